import { scoreOfKey } from "../shared/scale.js";

/** @typedef {import("./walk.js").Way} Way */

/** The keys and their effects, for the help. */
export const KEYS = [
  ["Arrows", "move over the city; while walking, walk and turn"],
  ["W A S D", "the same; while walking A and D step aside, Shift runs"],
  ["Q, E", "turn left, turn right"],
  ["+ −, Page Up, Page Down", "nearer, farther, steeper, flatter"],
  ["V", "walk in the streets, or see the city from above"],
  ["Home, F", "see the whole city; go to the selected building"],
  ["N, B", "next building, previous building"],
  ["Enter", "select the building in the middle"],
  ["R, P, X", "reroll, pin, exclude the selected building"],
  ["1 … 5", "score the selected building with stars; Delete removes the score"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Escape", "select nothing"],
  ["?", "show or hide these keys"],
];
export const POINTING =
  "Drag to turn, drag with the right button or with two fingers to move, turn the wheel or pinch to zoom, click a building to select it. While walking, drag to look around.";

/** Shares of the distance and radians of one press. */
const STEP = 0.06;
const TURN = Math.PI / 32;
/** @type {Record<string, Parameters<ReturnType<typeof import("./orbit.js").makeOrbit>["move"]>[0]>} */
const MOVES = {
  ArrowLeft: { east: -STEP },
  ArrowRight: { east: STEP },
  ArrowUp: { south: -STEP },
  ArrowDown: { south: STEP },
  a: { east: -STEP },
  d: { east: STEP },
  w: { south: -STEP },
  s: { south: STEP },
  q: { round: -TURN },
  e: { round: TURN },
  PageUp: { up: TURN },
  PageDown: { up: -TURN },
  "+": { nearer: 1.2 },
  "=": { nearer: 1.2 },
  "-": { nearer: 1 / 1.2 },
};
/** @type {Record<string, Way>} */
const WAYS = {
  ArrowUp: "ahead",
  ArrowDown: "back",
  ArrowLeft: "turnLeft",
  ArrowRight: "turnRight",
  w: "ahead",
  s: "back",
  a: "left",
  d: "right",
  q: "turnLeft",
  e: "turnRight",
};

/**
 * @param {HTMLElement} root
 * @param {HTMLElement} canvas
 * @param {object} page
 * @param {ReturnType<typeof import("./orbit.js").makeOrbit>} page.orbit
 * @param {ReturnType<typeof import("./walk.js").makeWalk>} page.walk
 * @param {Record<string, () => void>} page.actions by key
 * @param {(score: number | null) => void} page.score
 * @param {() => void} page.undo
 * @param {() => void} page.redo
 */
export function listenToKeys(root, canvas, { orbit, walk, actions, score, undo, redo }) {
  addEventListener("keydown", (event) => {
    if (event.defaultPrevented || event.altKey || isTyping(event.target)) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    if (event.ctrlKey || event.metaKey) {
      if (key === "z") (event.shiftKey ? redo : undo)();
      else if (key === "y") redo();
      else return;
    } else if (!press(key, event)) return;
    event.preventDefault();
  });
  addEventListener("keyup", (event) => {
    const way = WAYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    if (way) walk.hold(way, false);
    if (event.key === "Shift") walk.run(false);
  });
  addEventListener("blur", walk.stop);

  /** @param {string} key @param {KeyboardEvent} event @returns {boolean} whether the key means something here */
  function press(key, event) {
    const isBusy = event.target instanceof HTMLElement && event.target !== canvas && event.target !== document.body;
    // A button has its own keys, and the panel is scrolled by arrows.
    if (isBusy && (key === "Enter" || key === " " || key.startsWith("Arrow") || key.startsWith("Page"))) return false;
    if (key === "Shift") walk.run(true);
    const given = scoreOfKey("stars", key);
    if (given !== undefined) score(given);
    else if (walk.active && WAYS[key]) walk.hold(WAYS[key], true);
    else if (walk.active && (key === "PageUp" || key === "PageDown")) walk.look(0, key === "PageUp" ? TURN : -TURN);
    else if (!walk.active && MOVES[key]) orbit.move(MOVES[key]);
    else if (Object.hasOwn(actions, key)) actions[key]();
    else return false;
    return true;
  }
}

/** @param {EventTarget | null} target */
function isTyping(target) {
  return target instanceof HTMLElement && Boolean(target.closest("input, select, textarea, dialog, [popover]"));
}
