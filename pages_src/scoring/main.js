import { Ahead } from "../shared/ahead.js";
import { Channel } from "../shared/channel.js";
import { makeCompare } from "./compare.js";
import { makeDisplay } from "./display.js";
import { element, iconButton } from "../shared/element.js";
import { makeHelp } from "../shared/help.js";
import { isAlone, understands, waitingRoot } from "../shared/open.js";
import { makeFactors } from "./factors.js";
import { KEYS, listenToKeys } from "./keyboard.js";
import { makeLearning } from "./learning.js";
import { makeLook } from "./look.js";
import { Outbox } from "./outbox.js";
import { Pictures } from "./pictures.js";
import { listenToPointer } from "./pointer.js";
import { loadPreferences } from "./preferences.js";
import { makePreview } from "./preview.js";
import { makeRecent } from "./recent.js";
import { makeResults } from "./results.js";
import { scaleOf } from "../shared/scale.js";
import { makeScoring } from "./scoring.js";
import { Selection } from "./selection.js";
import { makeStatus } from "./status.js";
import { makeToolbar } from "./toolbar.js";
import { viewerCode } from "../shared/viewer_code.js";
import { makeWarnings } from "./warnings.js";
import { socketTransport, socketUrl, widgetTransport } from "../shared/transports.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Transport} Transport */

/** The page as a widget of a notebook. */
export default {
  /** @param {{ model: any, el: HTMLElement }} widget */
  render({ model, el }) {
    return mount(el, widgetTransport(model));
  },
};

/**
 * The page itself: waits for the first state, builds, then follows every state.
 *
 * @param {HTMLElement} host
 * @param {Transport} transport
 * @returns {() => void} takes the page away
 */
function mount(host, transport) {
  // Notebooks use single keys themselves, so they must not get the keys typed here.
  const root = waitingRoot("", "Making the first models…");
  root.dataset.lmSuppressShortcuts = "true";
  root.addEventListener("keydown", (event) => event.stopPropagation());
  host.append(root);

  const channel = new Channel(transport);
  /** @type {ReturnType<typeof build> | null} */
  let built = null;
  let lost = false;

  /** @param {State} state */
  function follow(state) {
    if (!understands(root, state)) return;
    built ??= build(root, channel, state);
    built.update(state);
  }

  channel.on("state", ({ state }) => follow(state));
  channel.on("progress", (progress) => built?.progress(progress));
  channel.on("closed", ({ message }) => built?.closed(message));
  channel.open(async (connected) => {
    built?.connection(connected);
    lost ||= !connected;
    if (!connected) return;
    try {
      follow((await channel.request("state")).result);
      if (lost) built?.reconnected();
    } catch (error) {
      if (channel.connected) root.textContent = error instanceof Error ? error.message : String(error);
    }
  });

  return () => {
    // Taken away first: what is not shown any more does not ask for pictures that are let go.
    root.remove();
    built?.close();
    channel.close();
  };
}

/** @param {HTMLElement} root @param {Channel} channel @param {State} first */
function build(root, channel, first) {
  const redraw = () => {
    if (page.state.pairs) compare.draw();
    else display.drawSoon();
    recent.draw();
    learning.draw();
    scoring.update();
  };
  let way = "default"; // how models were chosen before pairs were
  /** @type {Page} */
  const page = {
    root,
    state: first,
    channel,
    preferences: loadPreferences(),
    selection: new Selection(() => redraw()),
    outbox: new Outbox(
      channel,
      () => changed(),
      (error) => page.complain(new Error(`Not saved: ${error.message}`)),
    ),
    ask: (command, parameters) =>
      channel.request(command, parameters).then(
        ({ result }) => result,
        (error) => void page.complain(error),
      ),
    pictures: new Pictures(channel, () => redraw()),
    score(models, score) {
      const kind = scaleOf(page);
      if (!models.length || !scorable()) return;
      page.outbox.add(models, { score, kind }, page.factor().id);
      if (score !== null) page.selection.done(models);
    },
    compare(models, verdict) {
      if (scorable()) page.outbox.compare(models, verdict, page.factor().id);
    },
    ahead: new Ahead(),
    pairwise() {
      const pairs = !page.ahead.of("pairs", page.state.pairs !== null);
      void page.ahead.set("pairs", pairs, page.ask("new_models", { way: pairs ? "pairs" : way }));
    },
    factor() {
      const { factors, active } = page.state;
      return factors.find(({ name }) => name === active) ?? factors[0];
    },
    look(model) {
      preview.hide();
      void look.open(model);
    },
    say: (text) => status.say(text),
    complain: (error) => void status.complain(error),
  };
  const compare = makeCompare(page);
  const display = makeDisplay(page);
  const pointer = listenToPointer(page, display);
  const status = makeStatus(page);
  const scoring = makeScoring(
    page,
    () => keys.handOn(),
    () => focusModels(),
  );
  const keys = listenToKeys(page, display, scoring);
  const code = viewerCode(channel);
  const preview = makePreview(page, display, code);
  const recent = makeRecent(page);
  const look = makeLook(page, code, focusModels);
  const learning = makeLearning(page);
  const results = makeResults(page);
  const factors = makeFactors(page);
  const toolbar = makeToolbar(page, display, pointer);
  const help = makeHelp(KEYS);
  const undo = iconButton("undo", "Undo", () => goThrough("undo"), "U, Ctrl Z");
  const redo = iconButton("redo", "Redo", () => goThrough("redo"), "Ctrl Shift Z");
  const title = element("h1", { class: "gl-name" });
  const warnings = makeWarnings(focusModels);
  status.element.prepend(warnings.element);

  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      factors.element,
      element("span", { class: "gl-space" }),
      status.saved,
      undo,
      redo,
      help.button,
    ),
    status.banner,
    element(
      "div",
      { class: "gl-main" },
      element(
        "div",
        { class: "gl-left" },
        toolbar.element,
        display.element,
        preview.element,
        display.about,
        compare.element,
      ),
      element(
        "section",
        { class: "gl-side", "aria-label": "Score and learn" },
        scoring.element,
        recent.element,
        learning.element,
        results.element,
      ),
    ),
    status.element,
    look.element,
    help.element,
  );

  function scorable() {
    if (page.state.view !== "product") return true;
    status.say("The product of all factors cannot be scored. Choose the factor of the score first.");
    return false;
  }

  function changed() {
    redraw();
    look.update();
    status.update();
  }

  /** Where nothing is left to go through, that is no mistake: it is said in passing. @param {"undo" | "redo"} command */
  function goThrough(command) {
    const isLeft = () => (command === "undo" ? page.state.can_undo : page.state.can_redo);
    channel.request(command).catch((error) => (isLeft() ? page.complain(error) : page.say(error.message)));
  }

  const everywhere = (/** @type {KeyboardEvent} */ event) => {
    const typing =
      event.target instanceof HTMLInputElement && event.target.type !== "range" && event.target.type !== "checkbox";
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    if (command && key === "enter") void page.ask("update");
    else if (typing || event.defaultPrevented) return;
    else if (!inDialog(event) && compare.press(event)) return event.preventDefault();
    else if (key === "?") help.open();
    else if (!command && key === "t") {
      scoring.nextScale();
      look.update();
    } else if (!command && key === "c" && !inDialog(event)) page.pairwise();
    else if ((command && key === "z" && event.shiftKey) || (command && key === "y")) goThrough("redo");
    else if ((command && key === "z") || (!command && key === "u")) goThrough("undo");
    else return;
    event.preventDefault();
  };
  root.addEventListener("keydown", everywhere);
  // Before the first click, keys belong to nothing on the page; in a notebook they are the notebook's.
  const loose = (/** @type {KeyboardEvent} */ event) => {
    if (event.target === document.body) everywhere(event);
  };
  if (isAlone()) document.addEventListener("keydown", loose);

  function focusModels() {
    if (page.state.pairs) compare.focus();
    else display.focus();
  }

  /** Whether the keyboard is on the page, and nothing is being typed; a notebook may keep the page in a shadow tree. */
  function hasKeyboard() {
    const { activeElement } = /** @type {Document | ShadowRoot} */ (root.getRootNode());
    return root.contains(activeElement) && !(activeElement instanceof HTMLInputElement);
  }

  const hold = (/** @type {BeforeUnloadEvent} */ event) => page.outbox.unsaved && event.preventDefault();
  addEventListener("beforeunload", hold);

  return {
    /** @param {State} state */
    update(state) {
      if (state.message && state.message !== page.state.message) page.say(state.message);
      warnings.update(state.warnings);
      const [before, after] = [page.state.pairs !== null, state.pairs !== null];
      page.state = state;
      page.ahead.told();
      if (!after) way = state.way;
      root.classList.toggle("gl-pairwise", after);
      page.outbox.settle(state.revision);
      title.textContent = state.title;
      title.title = state.session;
      if (isAlone()) document.title = `${state.title} – grammarlab`;
      undo.disabled = !state.can_undo;
      redo.disabled = !state.can_redo;
      const shown = after ? compare : display;
      for (const part of [factors, toolbar, recent, shown, preview, scoring, learning, look, status])
        part.update(state);
      if (before !== after && hasKeyboard()) shown.focus();
    },
    /** @param {import("./types.js").Progress} progress */
    progress(progress) {
      const part = (progress.of ?? "update") === "update" ? learning : results;
      part.progress(progress);
    },
    /** @param {boolean} connected */
    connection(connected) {
      status.connection(connected);
    },
    /** Python ended the session, and will not answer any more. @param {string} message */
    closed(message) {
      status.closed(message);
    },
    /** The state is there; whatever was under way when the connection was lost begins anew. */
    reconnected() {
      display.askAgain();
      page.outbox.resend();
    },
    close() {
      removeEventListener("beforeunload", hold);
      document.removeEventListener("keydown", loose);
      for (const part of [preview, display, page.pictures, results, look, help, status]) part.close();
    },
  };
}

/** @param {KeyboardEvent} event */
function inDialog({ target }) {
  return target instanceof Element && target.closest("dialog[open]") !== null;
}

const alone = document.getElementById("grammarlab");
if (alone && isAlone()) mount(alone, socketTransport(socketUrl()));
