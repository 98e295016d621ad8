import { Channel } from "../shared/channel.js";
import { element, iconButton } from "../shared/element.js";
import { choice, menu, textButton } from "../shared/menu.js";
import { socketTransport } from "../shared/transports.js";
import { makeDrag } from "../stage/drag.js";
import { listenToHandles } from "../stage/gestures.js";
import { makeHelp } from "../shared/help.js";
import { makeNotes } from "../shared/notes.js";
import { makeStage } from "../stage/stage.js";
import { KEYS, listenToKeys } from "./keyboard.js";
import { makePanel } from "./panel.js";
import { makeStrip } from "./strip.js";
import { makeText } from "./text.js";

/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Layout} Layout */

const PROTOCOL = 1;
const EMPTY = { label: [], picture: [], outlines: [], columns: new Float64Array(), colors: [""] };
/** @type {Record<string, string>} */
const KINDS = {
  json: "facade, to open and to edit",
  svg: "drawing",
  png: "picture",
  glb: "model with the depth of layers",
  obj: "model with the depth of layers",
  cga: "rules that derive it",
};

/** @param {HTMLElement} host @param {string} url of the socket */
function mount(host, url) {
  const root = element(
    "div",
    { class: "gl-page fe-page fl-page" },
    element("p", { class: "gl-wait", role: "status" }, "Opening the design…"),
  );
  host.append(root);
  const channel = new Channel(socketTransport(url));
  /** @type {ReturnType<typeof build> | null} */
  let built = null;
  channel.on("state", ({ state }, buffers) => {
    if (state.protocol !== PROTOCOL)
      return void (root.textContent = "This page and Python speak different versions. Reload the page.");
    withColumns(state.layouts, buffers);
    built ??= build(root, channel, state);
    built.update(state);
  });
  channel.on("better", () => built?.better());
  channel.open((connected) => built?.connection(connected));
}

/** @param {Layout[]} layouts @param {ArrayBuffer[]} buffers */
function withColumns(layouts, buffers) {
  layouts.forEach((layout, number) => (layout.columns = new Float64Array(buffers[number])));
  return layouts;
}

/** @param {HTMLElement} root @param {Channel} channel @param {State} first */
function build(root, channel, first) {
  const notes = makeNotes();
  /** @type {{ layouts: Layout[], chosen: number } | null} */
  let onTheWay = null;
  const page = {
    state: first,
    channel,
    tied: false,
    get layouts() {
      return (onTheWay ?? page.state).layouts;
    },
    get chosen() {
      return (onTheWay ?? page.state).chosen;
    },
    /** @param {string} command @param {object} [parameters] */
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
    complain: notes.complain,
    changed() {
      stage.drawSoon();
      strip.update();
      panel.update();
    },
  };
  /** What is dragged and drawn: one facade. */
  const face = {
    ...{ channel, complain: notes.complain, changed: page.changed, pictures: { images: [] } },
    ...{ selected: -1, gridding: false, tied: false },
    get state() {
      const { revision, width, height } = page.state;
      const drawing = page.layouts[page.chosen] ?? { ...EMPTY, width, height };
      const none = { grids: [], locks: [], active: "", leaves: [], parent: [], boxes: new Float64Array() };
      return { revision, drawing, colors: drawing.colors, ...none };
    },
  };
  const drag = makeDrag(face, {
    began() {},
    show({ layouts, chosen }, buffers) {
      onTheWay = { layouts: withColumns(layouts, buffers), chosen };
    },
    ended(kept) {
      onTheWay = null;
      const { width, height } = page.state;
      if (!kept && channel.connected) channel.request("drag", { width, height }).catch(() => {}); // what to solve for
      stage.fit();
    },
  });
  const told = {
    get size() {
      return drag.size;
    },
    get active() {
      return drag.active;
    },
    get conflict() {
      return drag.active ? drag.conflict : page.state.conflict;
    },
  };
  const stage = makeStage(/** @type {any} */ (face), told);
  stage.face.tabIndex = -1;
  stage.face.setAttribute("aria-label", "Facade");
  const strip = makeStrip(page);
  const text = makeText(page);
  const panel = makePanel(page, text);
  const help = makeHelp(
    KEYS,
    "Drag the handles at the right and at the top: the layers are laid out for each size. Click a picture below to choose a layout.",
  );
  const acts = {
    async save() {
      await text.send(); // what is being typed counts
      const saved = await page.ask("save");
      if (saved) notes.say(`Saved to ${saved.file}`);
    },
    layouts: () => strip.first(),
    text: () => panel.write(),
    help: () => help.open(),
  };
  listenToHandles(face, stage, drag);
  listenToKeys(page, drag, acts);

  const title = element("h1", { class: "gl-name" });
  const solving = element("span", { class: "gl-count fl-solving", role: "status" });
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
          if (written) notes.say(`Written to ${written.file}`);
        }),
      ),
  );
  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      solving,
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
      drag.told();
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      title.textContent = state.title;
      title.title = state.file;
      document.title = `${state.title} – grammarlab`;
      solving.classList.toggle("fl-busy", state.solving);
      solving.textContent = state.solving ? "solving…" : "";
      saved.textContent = state.saved && state.revision ? "saved" : state.lost ? "not saved yet" : "";
      saved.dataset.state = state.lost ? "saving" : "saved";
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
    },
    /** More is known about the size on the way. */
    better: () => drag.again(),
    /** @param {boolean} connected */
    connection(connected) {
      notes.connection(connected);
      if (!connected) drag.cancel();
    },
  };
}

const { protocol, host, search } = location;
const place = document.getElementById("grammarlab");
if (place) mount(place, `${protocol === "https:" ? "wss" : "ws"}://${host}/socket${search}`);
