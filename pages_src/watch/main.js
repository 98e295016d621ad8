import { Ahead } from "../shared/ahead.js";
import { element, iconButton } from "../shared/element.js";
import { makeHelp } from "../shared/help.js";
import { textButton } from "../shared/menu.js";
import { LOST, makeAsk, makeNotes } from "../shared/notes.js";
import { isAlone, openPage } from "../shared/open.js";
import { makeRule } from "../shared/rule.js";
import { makeTree } from "../shared/tree.js";
import { viewerCode } from "../shared/viewer_code.js";
import { makeControls } from "./controls.js";
import { makeSheet } from "./sheet.js";

/** @typedef {import("./types.js").Mistake} Mistake */
/** @typedef {import("./types.js").State} State */
/** @typedef {ReturnType<typeof import("../viewer/viewer.js").show>} View */

const KEYS = [
  ["R", "roll the dice: another seed"],
  ["N, B", "next model, previous model of this seed"],
  ["S", "draw sixteen models"],
  ["↑ ↓", "on the model: the rules of its parts, one after the other"],
  ["Arrows with Shift, + −", "on the model: turn it, zoom"],
  ["Home", "see the whole model"],
  ["Ctrl Z, Ctrl Y", "undo, redo what was chosen here"],
  ["?", "show or hide these keys"],
];
const TURN = Math.PI / 16;
/** @type {Record<string, [number, number, number]>} */
const MOVES = {
  "Shift ArrowLeft": [-TURN, 0, 1],
  "Shift ArrowRight": [TURN, 0, 1],
  "Shift ArrowUp": [0, TURN, 1],
  "Shift ArrowDown": [0, -TURN, 1],
  "+": [0, 0, 1.25],
  "-": [0, 0, 0.8],
};

/**
 * The model of a rule file that is edited elsewhere, with its mistakes, attributes, seed and rules.
 * @param {HTMLElement} root
 * @param {import("../shared/channel.js").Channel} channel
 * @param {State} first
 */
function build(root, channel, first) {
  let state = first;
  let shown = 0; // version of the model
  let shownOf = ""; // seed and model
  /** @type {View | null} */
  let view = null;
  const ahead = new Ahead();
  const notes = makeNotes();
  const ask = makeAsk(channel, notes, async () => {});
  const help = makeHelp(KEYS, "Drag to turn, wheel or pinch to zoom; click a part for its rule and line.");
  const code = viewerCode(channel);
  const canvas = element("canvas", {
    class: "gl-canvas",
    tabIndex: 0,
    role: "application",
    "aria-label": "Model in 3D: Shift with arrows turns, + and − zoom, up and down name the rules of its parts",
  });
  const mistakes = element("div", { role: "alert" });
  // What rules print is no alarm.
  const printed = element("div");
  const rule = makeRule(channel, (triangles) => {
    view?.mark(triangles);
    if (triangles) tree.go(tree.rowAt(triangles[0]));
  });
  const tree = makeTree(([, , , , , triangles]) => {
    rule.clear();
    view?.mark(triangles ?? null);
  });
  const controls = makeControls((name, value) => void ask("set", { name, value }));
  const sheet = makeSheet(
    () => void ask("sheet"),
    (model) => want(state.seed, model),
  );
  const title = element("h1", { class: "gl-name" });
  const status = element("span", { class: "gl-saved", role: "status" });
  const seed = number("Seed", (value) => want(value, state.model));
  const model = number("Model", (value) => want(state.seed, value));
  const undo = iconButton("undo", "Undo", () => void ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void ask("redo"), "Ctrl Y");
  const resizes = new ResizeObserver(() => view?.resize());
  resizes.observe(canvas);

  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      element("span", { class: "gl-space" }),
      status,
      undo,
      redo,
      iconButton("fit", "Whole model", () => view?.reset(), "Home"),
      help.button,
    ),
    notes.banner,
    element(
      "div",
      { class: "gl-main" },
      element(
        "div",
        { class: "gl-left" },
        element("div", { class: "gl-room wa-room" }, canvas),
        element("div", { class: "wa-mistakes" }, mistakes, printed),
        element("div", { class: "wa-rule" }, rule.element),
      ),
      element(
        "aside",
        { class: "gl-side", "aria-label": "Seed and attributes" },
        element(
          "section",
          { class: "gl-card", "aria-label": "Seed" },
          element(
            "div",
            { class: "gl-row" },
            element("label", { class: "gl-row" }, "Seed", seed),
            textButton("⚄ Roll", () => void ask("roll"), { title: "Another seed (R)", "aria-label": "Roll the dice" }),
          ),
          element(
            "div",
            { class: "gl-row" },
            element("label", { class: "gl-row" }, "Model", model),
            iconButton("previous", "Previous model", () => step(-1), "B"),
            iconButton("next", "Next model", () => step(1), "N"),
          ),
        ),
        sheet.element,
        element("section", { class: "gl-card wa-tree", "aria-label": "Tree" }, element("h2", {}, "Tree"), tree.element),
        controls.element,
      ),
    ),
    notes.element,
    help.element,
  );
  channel.on("picture", ({ model: number }, [bytes]) => sheet.take(number, bytes));

  /** @param {number} newSeed @param {number} newModel */
  function want(newSeed, newModel) {
    const wanted = { seed: Math.max(newSeed, 0), model: Math.max(newModel, 0) };
    void ahead.set("wanted", wanted, ask("want", wanted));
  }

  /** @param {number} by */
  function step(by) {
    const { seed: now, model: here } = ahead.of("wanted", state);
    want(now, here + by);
  }

  const keyed = (/** @type {KeyboardEvent} */ event) => {
    const on = event.target;
    if (event.defaultPrevented) return;
    const isTyping =
      on instanceof HTMLElement && on.closest("input:not([type=range], [type=checkbox]), select, dialog[open]");
    if (isTyping || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const movement = MOVES[`${event.shiftKey && key.startsWith("Arrow") ? "Shift " : ""}${key}`];
    if (event.ctrlKey || event.metaKey) {
      if (key === "z") void ask(event.shiftKey ? "redo" : "undo");
      else if (key === "y") void ask("redo");
      else return;
    } else if (on === canvas && movement) view?.move(...movement);
    else if (on === canvas && key === "ArrowUp") void rule.step(-1);
    else if (on === canvas && key === "ArrowDown") void rule.step(1);
    else if (key === "r") void ask("roll");
    else if (key === "n") step(1);
    else if (key === "b") step(-1);
    else if (key === "s") sheet.draw();
    else if (key === "Home") view?.reset();
    else if (key === "?") help.open();
    else return;
    event.preventDefault();
  };
  root.addEventListener("keydown", keyed);
  // Before the first click, keys belong to nothing on the page; in a notebook they are the notebook's.
  const loose = (/** @type {KeyboardEvent} */ event) => {
    if (event.target === document.body) keyed(event);
  };
  if (isAlone()) document.addEventListener("keydown", loose);

  async function load() {
    const wanted = state.version;
    if (!wanted || wanted === shown) return;
    shown = wanted;
    const now = `${state.seed} ${state.model}`;
    try {
      const [{ result, buffers }, { show }] = await Promise.all([channel.request("model"), code()]);
      const damping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      view ??= show(canvas, { damping, picked: rule.pick });
      rule.open("");
      // After a save one goes on looking at the same place.
      await view.load(buffers[0], now === shownOf);
      tree.show(result.tree);
      shownOf = now;
      Object.assign(canvas.dataset, { version: wanted, shown: now });
    } catch (error) {
      notes.complain(error);
    }
  }

  return {
    /** @param {State} now */
    update(now) {
      state = now;
      ahead.told();
      title.textContent = state.title;
      title.title = state.file;
      if (isAlone()) document.title = `${state.title} – grammarlab`;
      const errors = state.mistakes.filter(({ severity }) => severity === "error").length;
      status.dataset.state = state.busy || errors ? "saving" : "saved";
      status.textContent = state.busy
        ? "making…"
        : errors
          ? `${errors} ${errors === 1 ? "error" : "errors"}`
          : `${state.shapes.toLocaleString()} shapes`;
      const isNote = (/** @type {Mistake} */ { severity }) => severity === "note";
      mistakes.replaceChildren(...state.mistakes.filter((each) => !isNote(each)).map(mistakeLine));
      printed.replaceChildren(...state.mistakes.filter(isNote).map(mistakeLine));
      for (const mark of mistakes.querySelectorAll("i")) showInLine(mark);
      root.classList.toggle("wa-stale", errors > 0);
      root.classList.toggle("wa-empty", !state.version && !state.busy);
      for (const [input, value] of /** @type {const} */ ([
        [seed, state.seed],
        [model, state.model],
      ]))
        if (!input.matches(":focus")) input.value = String(value);
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
      controls.update(state);
      sheet.mark(state.model);
      void load();
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
    },
    close() {
      document.removeEventListener("keydown", loose);
      resizes.disconnect();
      view?.dispose();
      help.close();
    },
  };
}

/** An error at its line, with a mark below its place. @param {Mistake} mistake */
function mistakeLine({ severity, message, hint, line, column, code }) {
  const place = line ? `line ${line}, column ${column}: ` : "";
  const [before, behind] = code;
  // Tabs keep their width, so the mark is below its place.
  const shown = [`${before}${behind}\n${before.replace(/[^\t]/g, " ")}`, element("i", {}, "^")];
  return element(
    "div",
    { class: `wa-mistake wa-${severity}` },
    element("b", {}, `${place}${message}`),
    before || behind
      ? element("pre", { tabindex: "0", role: "group", "aria-label": "Line with the mistake" }, ...shown)
      : null,
    hint ? element("small", {}, hint) : null,
  );
}

/** Scrolls a long line until the mark below the mistake is in its middle. @param {HTMLElement} mark */
function showInLine(mark) {
  const line = mark.parentElement;
  if (line) line.scrollLeft = mark.offsetLeft - line.clientWidth / 2;
}

/** @param {string} label @param {(value: number) => void} given */
function number(label, given) {
  const input = element("input", {
    class: "gl-input wa-whole",
    type: "number",
    min: "0",
    step: "1",
    "aria-label": label,
    onchange: () => input.checkValidity() && input.value !== "" && given(input.valueAsNumber),
  });
  return input;
}

export default openPage("wa-page", "Making the first model…", build);
