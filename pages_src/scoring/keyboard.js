import { scaleOf, scoreOfKey } from "../shared/scale.js";
import { knownOf } from "./known.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("./display.js").makeDisplay>} Display */

/** Ways that show models because they have scores. */
const RATED = ["scored", "already ranked"];

/** The keys and their effects, for the help. */
export const KEYS = [
  ["0 … 9", "score 0 … 90 for all selected models"],
  ["H", "score 100"],
  ["S", "type any score, then Enter"],
  ["1 … 5", "on the scale of stars: one to five stars"],
  ["0, 1", "on the scale of thumbs: thumb down, thumb up"],
  ["T", "next scale: 0–100, stars, thumbs"],
  ["Delete", "remove the score"],
  ["Arrows, Home, End", "move and select; with Shift, select a range; with Ctrl, move only"],
  ["Space", "select or deselect"],
  ["Ctrl A, Escape", "select all, select none"],
  [
    "Enter",
    "show the model in 3D; in this view, ← and → show its neighbours, ↑ and ↓ the rules of its parts, and Shift with arrows turns it; a finger that goes sideways above or below the picture shows the neighbours, too",
  ],
  ["C", "compare models two at a time, or go back to the grids"],
  [
    "← → ↓",
    "while comparing: prefer the left model, prefer the right model, both alike; ↑ shows the previous pair, N the next pair, Delete removes the answer, Enter shows both in 3D",
  ],
  ["U or Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["Ctrl Enter", "learn from all scores now, then show new models"],
  ["+ − =", "zoom in, zoom out, show all; also Ctrl with the wheel"],
  ["?", "show or hide these keys"],
];

/**
 * The keys in the grids.
 * @param {Page} page
 * @param {Display} display
 * @param {{ typeScore: () => void }} panel
 */
export function listenToKeys(page, display, panel) {
  const { selection } = page;
  const stage = display.element;

  stage.addEventListener("keydown", (event) => {
    if (display.positionOf(event.target) < 0 || event.altKey) return;
    const command = event.ctrlKey || event.metaKey;
    if (!(command ? withCommand(event) : plain(event))) return;
    event.preventDefault();
  });

  // A click focuses through `display.focus`; Tab focuses by itself.
  stage.addEventListener("focusin", (event) => {
    const position = display.positionOf(event.target);
    if (position >= 0 && position !== selection.cursor) selection.moveTo(position);
  });

  /** @param {KeyboardEvent} event @returns {boolean} whether the key means something here */
  function withCommand(event) {
    if (event.key === "a") selection.all();
    else if (event.key === " ") selection.toggle(selection.cursor);
    else return move(event);
    return true;
  }

  /** @param {KeyboardEvent} event */
  function plain(event) {
    const { key } = event;
    const score = scoreOfKey(scaleOf(page), key);
    if (score !== undefined) scoreSelected(score);
    else if (key === "s") panel.typeScore();
    else if (key === " ") selection.toggle(selection.cursor);
    else if (key === "Enter" && selection.current) page.look(selection.current);
    else if (key === "Escape") selection.none();
    else if (key === "+") display.zoomBy(1.25);
    else if (key === "-") display.zoomBy(0.8);
    else if (key === "=") display.zoomBy(0);
    else return move(event);
    return true;
  }

  /** @param {KeyboardEvent} event */
  function move(event) {
    const to = destination(page, event.key, display.columns());
    if (to === undefined) return false;
    if (event.ctrlKey || event.metaKey) selection.moveTo(to);
    else if (event.shiftKey) selection.rangeTo(to, false);
    else selection.only(to);
    display.focus();
    return true;
  }

  /** What is selected, or else where the keyboard is, gets a score; one model hands on to the next. @param {number | null} score */
  function scoreSelected(score) {
    if (!selection.chosen.size && selection.current) selection.only(selection.cursor);
    page.score(selection.models, score);
    handOn();
  }

  /** After a single model the next one is selected, if the person likes that; after the last one, new models come. */
  function handOn() {
    if (page.preferences.advance && selection.models.length === 1) {
      const { order, cursor } = selection;
      const open =
        cursor + 1 < order.length ? cursor + 1 : order.findIndex((model) => knownOf(page, model).score === null);
      if (open >= 0) selection.only(open);
      else if (!RATED.includes(page.state.way) && selection.startAnew())
        void page.ask("new_models", { way: page.state.way });
    }
    display.focus();
  }

  return { handOn };
}

/**
 * The position that a key leads to. Grids stand side by side, so right of the first one comes the second.
 * @param {Page} page
 * @param {string} key
 * @param {number} columns of a grid, as it is shown
 * @returns {number | undefined}
 */
function destination({ state, selection }, key, columns) {
  let first = 0;
  let index = 0;
  while (index + 1 < state.grids.length && selection.cursor >= first + state.grids[index].models.length) {
    first += state.grids[index].models.length;
    index += 1;
  }
  const count = state.grids[index].models.length;
  const here = selection.cursor - first;
  const column = here % columns;
  const row = here - column;
  const within = (/** @type {number} */ place) => (place >= 0 && place < count ? first + place : selection.cursor);
  const end = Math.min(row + columns, count) - 1;
  switch (key) {
    case "ArrowUp":
      return within(here - columns);
    case "ArrowDown":
      return within(here + columns);
    case "ArrowLeft":
      if (column > 0) return within(here - 1);
      if (index === 0) return selection.cursor;
      return (
        first - state.grids[index - 1].models.length + Math.min(row + columns, state.grids[index - 1].models.length) - 1
      );
    case "ArrowRight":
      if (here < end) return within(here + 1);
      if (index + 1 >= state.grids.length) return selection.cursor;
      return first + count + Math.min(row, state.grids[index + 1].models.length - 1);
    case "Home":
      return first;
    case "End":
      return first + count - 1;
    default:
      return undefined;
  }
}
