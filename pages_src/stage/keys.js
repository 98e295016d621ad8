/** @type {Record<string, [number, number]>} */
export const WAYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/**
 * @typedef {object} Nudge drags until the key is let go
 * @property {(event: KeyboardEvent) => boolean} size the whole, by an arrow
 * @property {(node: number, left: number, bottom: number) => boolean} move a part
 */

/**
 * Undo, redo and save by keys; other keys go to `plain` unless text is typed or a dialog is open.
 *
 * @param {{ ask: (command: string) => Promise<any>, tied: boolean }} page
 * @param {ReturnType<typeof import("./drag.js").makeDrag>} drag
 * @param {() => void} save
 * @param {(event: KeyboardEvent, on: Element, nudge: Nudge) => boolean} plain
 *   whether a key means something
 */
export function listenToKeysOf(page, drag, save, plain) {
  let nudging = false;
  /** @type {Nudge} */
  const nudge = {
    size(event) {
      const [x, y] = WAYS[event.key];
      const step = event.shiftKey ? 1 : event.altKey ? 0.01 : 0.1;
      const { width, height } = drag.size;
      const [w, h] = [width + x * step, height + y * step];
      nudging = true;
      if (!page.tied) drag.to(w, h);
      else if (x) drag.to(w, (height * w) / width);
      else drag.to((width * h) / height, h);
      return true;
    },
    move(node, left, bottom) {
      nudging = true;
      drag.move(node, left, bottom);
      return true;
    },
  };

  document.addEventListener("keydown", (event) => {
    const on = event.target instanceof Element ? event.target : document.body;
    const typing = on instanceof HTMLTextAreaElement || (on instanceof HTMLInputElement && on.type !== "checkbox");
    const means =
      event.ctrlKey || event.metaKey
        ? withCommand(event, typing)
        : !typing && !on.closest("dialog[open], :popover-open") && plain(event, on, nudge);
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
    if (key === "s") save();
    else if (typing) return false;
    else if ((key === "z" && event.shiftKey) || key === "y") void page.ask("redo");
    else if (key === "z") void page.ask("undo");
    else return false;
    return true;
  }
}
