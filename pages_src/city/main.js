import { element, iconButton } from "../shared/element.js";
import { makeHelp } from "../shared/help.js";
import { textButton } from "../shared/menu.js";
import { LOST, makeAsk, makeNotes } from "../shared/notes.js";
import { openPage } from "../shared/open.js";
import { KEYS, listenToKeys, POINTING } from "./keyboard.js";
import { makePanel } from "./panel.js";
import { makeView } from "./view.js";

/** @typedef {import("./types.js").Parcel} Parcel */
/** @typedef {import("./types.js").State} State */

/**
 * A city: its tiles, the selected parcel, and what is changed.
 * @param {HTMLElement} root
 * @param {import("../shared/channel.js").Channel} channel
 * @param {State} first
 */
function build(root, channel, first) {
  let state = first;
  /** @type {Parcel | null} */
  let parcel = null;
  /** The parcel that was selected last, which Python may not have told yet. @type {Promise<Parcel | null>} */
  let asked = Promise.resolve(null);
  let selected = "";
  let turn = 0;
  /** The rules of the building that was asked about last. @type {{ building: string, rules: string[] }} */
  let told = { building: "", rules: [] };
  const notes = makeNotes();
  const ask = makeAsk(channel, notes, async () => {});
  const help = makeHelp(KEYS, POINTING);
  const canvas = element("canvas", {
    class: "ct-canvas",
    tabIndex: 0,
    role: "application",
    "aria-label":
      "City in 3D: arrows move, Q and E turn, + and − zoom, N and B go from building to building, ? shows all keys",
  });
  const progress = element("span", { class: "ct-progress", role: "status" });
  const view = makeView(canvas, {
    select: (id) => void select(id),
    progress: (text) => void (progress.textContent = text),
    // While tiles are being written, some are missing.
    failed: (text) => state.busy || notes.complain(text),
  });
  const panel = makePanel({ ask, score, change, find, visit: () => view.visit(), go });

  const title = element("h1", { class: "gl-name" });
  const status = element("span", { class: "gl-saved", role: "status" });
  const undo = iconButton("undo", "Undo", () => void ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void ask("redo"), "Ctrl Y");
  const mode = textButton("Walk", toggleWalk, { title: "Walk in the streets, or see the city from above (V)" });
  const pad = walkPad(view.walk);
  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      element("span", { class: "gl-space" }),
      status,
      undo,
      redo,
      mode,
      iconButton("fit", "Whole city", showAll, "Home"),
      help.button,
    ),
    notes.banner,
    element(
      "div",
      { class: "gl-main" },
      element("div", { class: "gl-left ct-stage" }, canvas, progress, pad),
      panel.element,
    ),
    notes.element,
    help.element,
  );
  listenToKeys(root, canvas, {
    orbit: view.orbit,
    walk: view.walk,
    actions: {
      v: toggleWalk,
      f: () => view.visit(),
      Home: showAll,
      n: () => void go(1),
      b: () => void go(-1),
      Enter: () => void select(view.middle()),
      r: () => void change("reroll"),
      p: () => void change("pin"),
      x: () => void change("exclude"),
      Escape: () => void select(""),
      "?": help.open,
    },
    score: (value) => score(value, "stars"),
    undo: () => void ask("undo"),
    redo: () => void ask("redo"),
  });
  /** Resolves to whether parcels are known; what concerns them waits for it. */
  let laidOut = loadGround();

  async function loadGround() {
    try {
      const { result, buffers } = await channel.request("ground");
      if (result.ids) view.layOut(result.ids, buffers);
      return true;
    } catch (error) {
      if (channel.connected) notes.complain(error);
      return false;
    }
  }

  /** @param {string | undefined} id */
  async function select(id = "") {
    selected = id;
    view.mark(id);
    await refresh();
  }

  /** What is known of the selected parcel now. */
  async function refresh() {
    const mine = (turn += 1);
    asked = selected ? ask("parcel", { parcel: selected }).then((found) => found ?? null) : Promise.resolve(null);
    const found = await asked;
    if (mine !== turn) return;
    parcel = found;
    panel.show(parcel);
    panel.update(state, parcel);
    void tellRules(mine);
  }

  /** Deriving the building again takes longer than all else, and is done once. @param {number} mine */
  async function tellRules(mine) {
    const { id = "", status = "", facts = [] } = parcel ?? {};
    const building = JSON.stringify([id, facts]);
    if (building === told.building) return panel.tell(told.rules);
    panel.tell([]);
    if (status !== "built") return;
    const answer = await ask("rules", { parcel: id });
    if (mine !== turn || !answer) return;
    told = { building, rules: answer.rules };
    panel.tell(told.rules);
  }

  /** @param {string} id */
  async function find(id) {
    await laidOut;
    if (!view.has(id)) return false;
    void select(id);
    view.visit();
    return true;
  }

  /** @param {number} step */
  async function go(step) {
    await laidOut;
    const id = view.neighbour(selected, step);
    if (!id) return;
    void select(id);
    view.visit();
  }

  /** @param {number | null} value @param {string} kind */
  async function score(value, kind) {
    const meant = await asked;
    if (meant?.status !== "built") return;
    await ask("score", { parcel: meant.id, score: value, kind });
    await refresh();
  }

  /** @param {"reroll" | "pin" | "exclude"} action */
  async function change(action) {
    const meant = await asked;
    if (!meant || !state.editable || (meant.status !== "built" && meant.pin !== "excluded")) return;
    void ask(action, { parcel: meant.id });
  }

  function toggleWalk() {
    view.toggleWalk();
    const { active } = view.walk;
    mode.textContent = active ? "From above" : "Walk";
    pad.hidden = !active;
    canvas.focus();
  }

  function showAll() {
    if (view.walk.active) toggleWalk();
    view.showAll();
  }

  return {
    /** @param {State} now */
    update(now) {
      const before = state;
      state = now;
      title.textContent = state.title;
      document.title = `${state.title} – grammarlab`;
      title.title = state.file;
      status.textContent = state.busy || (state.num_pins ? "saved" : "");
      status.dataset.state = state.busy ? "saving" : "saved";
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
      if (state.failed && state.failed !== before.failed) notes.complain(state.failed);
      if (state.tiles !== before.tiles) view.reload();
      panel.update(state, parcel);
      void refresh();
    },
    /** @param {boolean} connected */
    async connection(connected) {
      notes.announce(connected ? "" : LOST);
      if (connected && !(await laidOut)) laidOut = loadGround();
    },
  };
}

/** Buttons to walk by touch. @param {import("./view.js").View["walk"]} walk */
function walkPad(walk) {
  const ways = /** @type {const} */ ([
    ["turnLeft", "↶", "Turn left"],
    ["ahead", "↑", "Walk ahead"],
    ["turnRight", "↷", "Turn right"],
    ["left", "←", "Step to the left"],
    ["back", "↓", "Walk back"],
    ["right", "→", "Step to the right"],
  ]);
  const buttons = ways.map(([way, text, label]) => {
    const button = textButton(text, () => {}, { "aria-label": label, class: "gl-button ct-way" });
    button.addEventListener("pointerdown", (event) => {
      button.setPointerCapture(event.pointerId);
      walk.hold(way, true);
    });
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      button.addEventListener(end, () => walk.hold(way, false));
    return button;
  });
  return element("div", { class: "ct-pad", role: "group", "aria-label": "Walk", hidden: true }, ...buttons);
}

/**
 * The page, or why there is none.
 * @param {HTMLElement} root
 * @param {import("../shared/channel.js").Channel} channel
 * @param {State} state
 */
function buildIfPossible(root, channel, state) {
  if (document.createElement("canvas").getContext("webgl2")) return build(root, channel, state);
  root.replaceChildren(
    element(
      "p",
      { class: "gl-wait", role: "alert" },
      "This browser shows no 3D (WebGL 2): switch it on, or use another.",
    ),
  );
  return { update() {}, connection() {} };
}

openPage("ct-page", "Opening the city…", buildIfPossible);
