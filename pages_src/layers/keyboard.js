import { WAYS, listenToKeysOf } from "../stage/keys.js";

/** @typedef {import("./types.js").Page} Page */

/** The keys and their effects, for the help. */
export const KEYS = [
  ["Arrows", "make the canvas wider, narrower, higher or lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "go to the handles, the layouts and the panel"],
  ["L", "go to the layouts; Enter chooses one"],
  ["T", "go to the text; Escape leaves it"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "end a drag"],
  ["?", "show or hide these keys"],
];

/**
 * @param {Page} page
 * @param {ReturnType<typeof import("../stage/drag.js").makeDrag>} drag
 * @param {{ save: () => void, layouts: () => void, text: () => void, help: () => void }} acts
 */
export function listenToKeys(page, drag, acts) {
  listenToKeysOf(page, drag, acts.save, (event, _on, nudge) => {
    if (event.key in WAYS) return nudge.size(event);
    const key = event.key.toLowerCase();
    if (key === "?") acts.help();
    else if (key === "l") acts.layouts();
    else if (key === "t") acts.text();
    else return false;
    return true;
  });
}
