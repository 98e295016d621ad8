/** @typedef {import("./types.js").Page} Page */

/** What the keys do, for the person who asks. */
export const KEYS = [
  ["Arrows", "wider, narrower, higher, lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "to the handles, the layouts and the panel"],
  ["L", "to the layouts; Enter chooses one"],
  ["T", "to the text; Escape leaves it"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "end a drag"],
  ["?", "show or hide these keys"],
];

/** @type {Record<string, [number, number]>} */
const WAYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * @param {Page} page
 * @param {ReturnType<typeof import("../stage/drag.js").makeDrag>} drag
 * @param {{ save: () => void, layouts: () => void, text: () => void, help: () => void }} acts
 */
export function listenToKeys(page, drag, acts) {
  let nudging = false;

  document.addEventListener("keydown", (event) => {
    const on = event.target;
    const typing = on instanceof HTMLTextAreaElement || (on instanceof HTMLInputElement && on.type !== "checkbox");
    if (typing && event.key === "Escape") on.blur();
    const means = event.ctrlKey || event.metaKey ? withCommand(event, typing) : !typing && plain(event);
    if (means) event.preventDefault();
  });
  document.addEventListener("keyup", (event) => {
    if (event.key in WAYS) end();
  });
  addEventListener("blur", end);

  function end() {
    if (nudging) drag.end();
    nudging = false;
  }

  /** @param {KeyboardEvent} event @param {boolean} typing */
  function withCommand(event, typing) {
    const key = event.key.toLowerCase();
    if (key === "s") acts.save();
    else if (typing) return false;
    else if ((key === "z" && event.shiftKey) || key === "y") void page.ask("redo");
    else if (key === "z") void page.ask("undo");
    else return false;
    return true;
  }

  /** @param {KeyboardEvent} event @returns {boolean} whether the key means something */
  function plain(event) {
    if (event.target instanceof Element && event.target.closest("dialog, [popover]")) return false;
    if (event.key in WAYS) return nudge(event);
    const key = event.key.toLowerCase();
    if (key === "?") acts.help();
    else if (key === "l") acts.layouts();
    else if (key === "t") acts.text();
    else return false;
    return true;
  }

  /** @param {KeyboardEvent} event */
  function nudge(event) {
    const [x, y] = WAYS[event.key];
    const step = event.shiftKey ? 1 : event.altKey ? 0.01 : 0.1;
    const { width, height } = drag.size;
    nudging = true;
    drag.to(width + x * step, height + y * step);
    return true;
  }
}
