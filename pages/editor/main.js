import { Channel } from "../shared/channel.js";
import { element, iconButton } from "../shared/element.js";
import { choice, menu, textButton } from "../shared/menu.js";
import { socketTransport } from "../shared/transports.js";
import { makeDrag } from "../stage/drag.js";
import { listenToPointer } from "../stage/gestures.js";
import { makeHelp } from "../shared/help.js";
import { KEYS, listenToKeys } from "./keyboard.js";
import { makeNotes } from "../shared/notes.js";
import { isLocked, makePanel } from "./panel.js";
import { Pictures } from "./pictures.js";
import { makeStage } from "../stage/stage.js";
import { makeStrip } from "./strip.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").What} What */

const PROTOCOL = 1;
/** @type {Record<string, string>} */
const KINDS = {
  json: "facade, to open again",
  svg: "drawing",
  png: "picture",
  glb: "model",
  obj: "model",
  cga: "rules that derive it",
};

/** @param {HTMLElement} host @param {string} url of the socket */
function mount(host, url) {
  const root = element(
    "div",
    { class: "gl-page fe-page" },
    element("p", { class: "gl-wait", role: "status" }, "Opening the facade…"),
  );
  host.append(root);
  const channel = new Channel(socketTransport(url));
  /** @type {ReturnType<typeof build> | null} */
  let built = null;
  channel.on("state", ({ state }, buffers) => {
    if (state.protocol !== PROTOCOL)
      return void (root.textContent = "This page and Python speak different versions. Reload the page.");
    state.drawing.columns = new Float64Array(buffers[0]);
    state.boxes = new Float64Array(buffers[1]);
    built ??= build(root, channel, state);
    built.update(state);
  });
  channel.open((connected) => built?.connection(connected));
}

/** @param {HTMLElement} root @param {Channel} channel @param {State} first */
function build(root, channel, first) {
  const notes = makeNotes();
  /** @type {Page} */
  const page = {
    state: first,
    channel,
    pictures: new Pictures(channel, () => {
      stage.drawSoon();
      strip.draw();
    }),
    selected: -1,
    gridding: false,
    tied: false,
    async ask(command, parameters) {
      await drag.idle();
      try {
        const { result } = await channel.request(command, parameters);
        notes.calm();
        return result;
      } catch (error) {
        notes.complain(error instanceof Error ? error.message : String(error));
      }
    },
    select(node) {
      page.selected = node;
      page.changed();
    },
    say: notes.say,
    complain: notes.complain,
    changed() {
      stage.drawSoon();
      panel.update();
      if (!drag.active) strip.update();
    },
  };
  /** @type {{ boxes: Float64Array, width: number, height: number } | null} as it was before a drag */
  let before = null;
  const drag = makeDrag(page, {
    began: () => (before ??= sizesNow()),
    show: ({ width, height }, buffers) => show({ boxes: new Float64Array(buffers[0]), width, height }),
    ended(kept) {
      if (before && !kept) show(before);
      before = null;
      stage.fit();
    },
  });
  function sizesNow() {
    const { boxes, drawing } = page.state;
    return { boxes, width: drawing.width, height: drawing.height };
  }
  /** @param {{ boxes: Float64Array, width: number, height: number }} sizes */
  function show({ boxes, width, height }) {
    const { state } = page;
    if (boxes.length !== state.boxes.length) return; // of the facade before
    state.boxes = boxes;
    Object.assign(state.drawing, { width, height });
    state.leaves.forEach((node, leaf) => state.drawing.columns.set(boxes.subarray(4 * node, 4 * node + 4), 8 * leaf));
    page.changed();
  }
  const stage = makeStage(page, drag);
  const strip = makeStrip(page);
  const acts = {
    async save() {
      // A length that is being typed counts.
      if (document.activeElement instanceof HTMLInputElement) document.activeElement.blur();
      const saved = await page.ask("save");
      if (saved) page.say(`Saved to ${saved.file}`);
    },
    /** @param {What} what @param {number} [node] */
    toggleLock(what, node = page.selected) {
      if (node < 0) return page.say("Select a part first, to lock its size.");
      void page.ask(isLocked(page, node, what) ? "unlock" : "lock", { node, what });
    },
    toggleGridding() {
      page.gridding = !page.gridding && Boolean(page.state.active);
      page.changed();
    },
    variations: () => strip.first(),
    help: () => help.open(),
  };
  const panel = makePanel(page, acts);
  const help = makeHelp(
    KEYS,
    "Drag the handles at the right and at the top to change the size. Click a part to select it, draw a rectangle to make a grid. Click a picture below to accept a variation.",
  );
  listenToPointer(page, stage, drag);
  listenToKeys(page, root, stage, drag, acts);

  const title = element("h1", { class: "gl-name" });
  const saved = element("span", { class: "gl-saved", role: "status" });
  const undo = iconButton("undo", "Undo", () => void page.ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void page.ask("redo"), "Ctrl Y");
  const save = textButton("Save", acts.save, { class: "gl-button gl-primary", title: "Save (Ctrl S)" });
  const exports = menu(
    element("button", { type: "button", class: "gl-button gl-chooser" }, "Export"),
    "Export",
    (close) =>
      page.state.formats.map((format) =>
        choice(format.toUpperCase(), KINDS[format] ?? "", async () => {
          close();
          const written = await page.ask("export", { format });
          if (written) page.say(`Written to ${written.file}`);
        }),
      ),
  );

  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      element("span", { class: "gl-space" }),
      saved,
      undo,
      redo,
      exports,
      save,
      help.button,
    ),
    notes.banner,
    element(
      "div",
      { class: "gl-main" },
      element("div", { class: "gl-left" }, stage.element, strip.element),
      panel.element,
    ),
    notes.element,
    help.element,
  );
  addEventListener("beforeunload", (event) => page.state.lost && event.preventDefault());

  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      if (before) before = sizesNow(); // what a cancelled drag goes back to
      drag.told();
      if (page.selected >= state.parent.length) page.selected = -1;
      page.gridding &&= Boolean(state.active);
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      void page.pictures.want(state.pictures);
      title.textContent = state.title;
      title.title = state.file;
      document.title = `${state.title} – grammarlab`;
      saved.textContent = state.saved && state.revision ? "saved" : state.lost ? "not saved yet" : "";
      saved.dataset.state = state.lost ? "saving" : "saved";
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.connection(connected);
      if (!connected) return void drag.cancel();
      page.pictures.again();
      void page.pictures.want(page.state.pictures);
      strip.again();
    },
  };
}

const { protocol, host, search } = location;
const place = document.getElementById("grammarlab");
if (place) mount(place, `${protocol === "https:" ? "wss" : "ws"}://${host}/socket${search}`);
