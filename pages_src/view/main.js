import { element, iconButton } from "../shared/element.js";
import { makeHelp } from "../shared/help.js";
import { makeNotes } from "../shared/notes.js";
import { makePane } from "./pane.js";

/** @typedef {import("./types.js").Run} Run */

const KEYS = [
  ["N, B", "next model, previous model"],
  ["T", "turn the models, or stop"],
  ["M", "mark the model as a good example, or not; with two runs, that of the model in use or the first"],
  ["Arrows with Shift, + −", "on a model: turn it, zoom"],
  ["Home", "see the whole models"],
  ["Arrows", "in the tree: up and down, open and close; the shapes of a row's symbol turn green"],
  ["?", "show or hide these keys"],
];
const STEP = Math.PI / 16;
const SPEED = 0.35; // radians in a second
/** @type {Record<string, [number, number, number]>} */
const MOVES = {
  "Shift ArrowLeft": [-STEP, 0, 1],
  "Shift ArrowRight": [STEP, 0, 1],
  "Shift ArrowUp": [0, STEP, 1],
  "Shift ArrowDown": [0, -STEP, 1],
  "+": [0, 0, 1.25],
  "-": [0, 0, 0.8],
};

/** Builds the page from the runs that it holds. @param {Run[]} runs */
function build(runs) {
  const notes = makeNotes();
  const help = makeHelp(KEYS, "Drag to turn, wheel or pinch to zoom; click a part for its symbol in the tree.");
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let follows = false; // whether a view is being moved by another
  const panes = runs.map((run) =>
    makePane(run, {
      damping: !still,
      say: notes.say,
      complain: notes.complain,
      moved(pose) {
        if (follows) return;
        follows = true;
        for (const pane of panes) if (pane.view()?.pose() !== pose) pane.view()?.take(pose);
        follows = false;
      },
    }),
  );
  const indices = [...new Set(runs.flatMap(({ models }) => models.map(({ index }) => index)))].sort((a, b) => a - b);
  let place = 0;
  let turning = false;
  let before = 0;

  const chooser = element(
    "select",
    { class: "gl-input vi-chooser", "aria-label": "Model", onchange: () => go(chooser.selectedIndex) },
    ...indices.map((index) => element("option", { value: String(index) }, `model ${index}`)),
  );
  const count = element("span", { class: "gl-count" });
  const turn = element(
    "button",
    { type: "button", class: "gl-button", title: "Turn the models, or stop (T)", onclick: () => setTurning(!turning) },
    "Turn",
  );
  const names = runs.map(({ name }) => name).join(" and ");
  const page = element(
    "div",
    { class: "gl-page vi-page" },
    element(
      "header",
      { class: "gl-header" },
      element("h1", { class: "gl-name", title: names }, names),
      element("span", { class: "gl-space" }),
      element(
        "div",
        { class: "gl-row" },
        iconButton("previous", "Previous model", () => go(place - 1), "B"),
        chooser,
        iconButton("next", "Next model", () => go(place + 1), "N"),
        count,
      ),
      turn,
      iconButton("fit", "Whole models", reset, "Home"),
      help.button,
    ),
    notes.banner,
    element(
      "div",
      { class: "gl-main" },
      element("div", { class: "gl-left vi-rooms" }, ...panes.map(({ room }) => room)),
      element("aside", { class: "gl-side", "aria-label": "Derivation" }, ...panes.map(({ side }) => side)),
    ),
    notes.element,
    help.element,
  );
  document.getElementById("grammarlab")?.append(page);

  /** @param {number} wanted place in the list */
  async function go(wanted) {
    place = Math.min(Math.max(wanted, 0), indices.length - 1);
    chooser.selectedIndex = place;
    count.textContent = `of ${indices.length.toLocaleString()}`;
    await Promise.all(panes.map((pane) => pane.show(indices[place])));
  }

  function reset() {
    for (const pane of panes) pane.view()?.reset();
  }

  /** @param {boolean} turns */
  function setTurning(turns) {
    turning = turns;
    turn.setAttribute("aria-pressed", String(turns));
    before = performance.now();
    if (turns) requestAnimationFrame(step);
  }

  /** @param {number} now */
  function step(now) {
    if (!turning) return;
    panes[0].view()?.move((SPEED * (before - now)) / 1000);
    before = now;
    requestAnimationFrame(step);
  }

  // Who takes hold of a model looks at one side of it.
  for (const { canvas } of panes) canvas.addEventListener("pointerdown", () => setTurning(false));
  addEventListener("keydown", (event) => {
    const on = event.target;
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    if (on instanceof HTMLElement && on.closest("select, input.gl-input, dialog[open]")) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const movement = MOVES[`${event.shiftKey && key.startsWith("Arrow") ? "Shift " : ""}${key}`];
    const held = panes.find(({ canvas }) => canvas === on);
    if (held && movement) {
      setTurning(false);
      held.view()?.move(...movement);
    } else if (key === "n") void go(place + 1);
    else if (key === "b") void go(place - 1);
    else if (key === "t") setTurning(!turning);
    else if (key === "m") (held ?? panes[0]).toggleExample();
    else if (key === "Home") reset();
    else if (key === "?") help.open();
    else return;
    event.preventDefault();
  });

  void go(0).then(() => setTurning(!still));
}

build(JSON.parse(document.getElementById("runs")?.textContent ?? "[]"));
