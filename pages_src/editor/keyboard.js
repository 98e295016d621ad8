import { WAYS, listenToKeysOf } from "../stage/keys.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("../stage/keys.js").Nudge} Nudge */

/** The keys and their effects, for the help. */
export const KEYS = [
  ["Arrows", "make the facade wider, narrower, higher or lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "go to the facade, its handles, the variations and the panel"],
  ["Arrows on the facade", "go from part to part"],
  ["Alt and arrows on the facade", "move the selected part by 0.05 m, with Shift by 0.5 m"],
  ["Space on the facade", "add the selected part to the grid, or remove it"],
  ["W, H, A", "lock or unlock width, height, aspect of the selected part"],
  ["P", "select the part around the selected one"],
  ["G", "switch whether a click changes the grid or selects a part"],
  ["V", "go to the variations; Enter accepts one"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "select nothing, end a drag"],
  ["?", "show or hide these keys"],
];

/**
 * @param {Page} page
 * @param {ReturnType<typeof import("../stage/stage.js").makeStage>} stage
 * @param {ReturnType<typeof import("../stage/drag.js").makeDrag>} drag
 * @param {{ save: () => void, toggleLock: (what: import("./types.js").What) => void, toggleGridding: () => void, variations: () => void, help: () => void }} acts
 */
export function listenToKeys(page, stage, drag, acts) {
  listenToKeysOf(page, drag, acts.save, (event, on, nudge) => {
    if (event.key in WAYS) {
      if (on !== stage.face) return !on.closest(".fe-strip") && nudge.size(event);
      return event.altKey ? move(event, nudge) : go(event.key);
    }
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
  });

  /** Moves the selected part a little. @param {KeyboardEvent} event @param {Nudge} nudge */
  function move(event, nudge) {
    if (page.selected <= 0) return false;
    const [x, y] = WAYS[event.key];
    const step = event.shiftKey ? 0.5 : 0.05;
    const [left, bottom] = drag.placeOf(page.selected) ?? stage.boxOf(page.selected);
    return nudge.move(page.selected, left + x * step, bottom + y * step);
  }

  /** Selects the nearest leaf on a side. @param {string} key */
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
}
