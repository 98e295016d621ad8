/** @typedef {import("./types.js").Page} Page */

/** What the keys do, for the person who asks. */
export const KEYS = [
  ["Arrows", "wider, narrower, higher, lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "to the facade, its handles, the variations and the panel"],
  ["Arrows on the facade", "from part to part"],
  ["Alt and arrows there", "move the part by 0.05 m, with Shift by 0.5 m"],
  ["Space on the facade", "put the part into the grid, or take it out"],
  ["W, H, A", "lock or unlock width, height, aspect of the selected part"],
  ["P", "select the part around the selected one"],
  ["G", "clicks change the grid, or select"],
  ["V", "to the variations; Enter accepts one"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "select nothing, end a drag"],
  ["?", "show or hide these keys"],
];

/** @type {Record<string, [number, number]>} */
const WAYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * @param {Page} page
 * @param {HTMLElement} root
 * @param {ReturnType<typeof import("../stage/stage.js").makeStage>} stage
 * @param {ReturnType<typeof import("../stage/drag.js").makeDrag>} drag
 * @param {{ save: () => void, toggleLock: (what: import("./types.js").What) => void, toggleGridding: () => void, variations: () => void, help: () => void }} acts
 */
export function listenToKeys(page, root, stage, drag, acts) {
  let nudging = false;

  const down = (/** @type {KeyboardEvent} */ event) => {
    const command = event.ctrlKey || event.metaKey;
    const typing = event.target instanceof HTMLInputElement && event.target.type !== "checkbox";
    if (!(command ? withCommand(event, typing) : !typing && plain(event))) return;
    event.preventDefault();
  };
  const up = (/** @type {KeyboardEvent} */ event) => {
    if (!nudging || !(event.key in WAYS)) return;
    nudging = false;
    drag.end();
  };
  document.addEventListener("keydown", down);
  document.addEventListener("keyup", up);
  addEventListener("blur", () => {
    if (nudging) drag.end();
    nudging = false;
  });

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
    const on = event.target instanceof Element ? event.target : root;
    if (on.closest("dialog, [popover]")) return false;
    if (event.key in WAYS) return on !== stage.face ? nudge(event, on) : event.altKey ? move(event) : go(event.key);
    const key = event.key.toLowerCase();
    if (key === "?") acts.help();
    else if (key === "w") acts.toggleLock("width");
    else if (key === "h") acts.toggleLock("height");
    else if (key === "a") acts.toggleLock("aspect");
    else if (key === "g") acts.toggleGridding();
    else if (key === "v") acts.variations();
    else if (key === "p" && page.selected > 0) page.select(page.state.parent[page.selected]);
    else if (key === " " && on === stage.face && page.selected >= 0) void page.ask("press", { node: page.selected });
    else if (key === "escape") page.select(-1);
    else return false;
    return true;
  }

  /** @param {KeyboardEvent} event @param {Element} on */
  function nudge(event, on) {
    if (on.closest(".fe-strip")) return false;
    const [x, y] = WAYS[event.key];
    const step = event.shiftKey ? 1 : event.altKey ? 0.01 : 0.1;
    const { width, height } = drag.size;
    nudging = true;
    const [w, h] = [width + x * step, height + y * step];
    if (!page.tied) drag.to(w, h);
    else if (x) drag.to(w, (height * w) / width);
    else drag.to((width * h) / height, h);
    return true;
  }

  /** The selected part a little. @param {KeyboardEvent} event */
  function move(event) {
    if (page.selected <= 0) return false;
    const [x, y] = WAYS[event.key];
    const step = event.shiftKey ? 0.5 : 0.05;
    const [left, bottom] = stage.boxOf(page.selected);
    nudging = true;
    drag.move(page.selected, left + x * step, bottom + y * step);
    return true;
  }

  /** To the nearest leaf on a side. @param {string} key */
  function go(key) {
    const { leaves } = page.state;
    const middle = (/** @type {number} */ node) => {
      const [x, y, width, height] = stage.boxOf(node);
      return [x + width / 2, y + height / 2];
    };
    if (page.selected < 0) {
      page.select(leaves[0]);
      return true;
    }
    const [dx, dy] = WAYS[key];
    const [x, y] = middle(page.selected);
    let [best, least] = [-1, Infinity];
    for (const leaf of leaves) {
      const [u, v] = middle(leaf);
      const ahead = (u - x) * dx + (v - y) * dy;
      const beside = Math.abs((u - x) * dy) + Math.abs((v - y) * dx);
      if (leaf !== page.selected && ahead > 1e-6 && ahead + 3 * beside < least)
        [best, least] = [leaf, ahead + 3 * beside];
    }
    if (best >= 0) page.select(best);
    return true;
  }

  return () => {
    document.removeEventListener("keydown", down);
    document.removeEventListener("keyup", up);
  };
}
