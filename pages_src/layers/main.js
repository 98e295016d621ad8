import { Ahead } from "../shared/ahead.js";
import { element } from "../shared/element.js";
import { makeFrame } from "../shared/frame.js";
import { makeHelp } from "../shared/help.js";
import { LOST, makeAsk, makeNotes } from "../shared/notes.js";
import { openPage } from "../shared/open.js";
import { makeDrag } from "../stage/drag.js";
import { listenToHandles } from "../stage/handles.js";
import { makeStage } from "../stage/stage.js";
import { KEYS, listenToKeys } from "./keyboard.js";
import { makePanel } from "./panel.js";
import { makeStrip } from "./strip.js";
import { makeText } from "./text.js";

/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Layout} Layout */

const EMPTY = { label: [], picture: [], outlines: [], columns: new Float64Array(), colors: [""] };
/** @type {Record<string, string>} */
const KINDS = {
  json: "facade, can be opened and edited",
  svg: "drawing",
  png: "picture",
  glb: "model with the depth of layers",
  obj: "model with the depth of layers",
  cga: "rules of the facade",
};

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
    ahead: new Ahead(),
    get layouts() {
      return (onTheWay ?? page.state).layouts;
    },
    get chosen() {
      return (onTheWay ?? page.state).chosen;
    },
    ask: makeAsk(channel, notes, () => drag.idle()),
    complain: notes.complain,
    changed() {
      stage.drawSoon();
      strip.update();
      panel.update();
    },
  };
  /** The facade that is dragged and drawn. */
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
  const stage = makeStage(face, told);
  stage.face.tabIndex = -1;
  stage.face.setAttribute("aria-label", "Facade");
  const strip = makeStrip(page);
  const text = makeText(page);
  const panel = makePanel(page, text);
  const help = makeHelp(
    KEYS,
    "Drag the handles at the right and at the top. The layers are laid out for each size. Click a picture below to choose a layout.",
  );
  const acts = {
    save: () => frame.save(),
    layouts: () => strip.first(),
    text: () => panel.write(),
    help: () => help.open(),
  };
  listenToHandles(face, stage, drag);
  listenToKeys(page, drag, acts);

  const solving = element("span", { class: "gl-count fl-solving", role: "status" });
  const frame = makeFrame(root, page, {
    notes,
    help,
    kinds: KINDS,
    settle: text.send, // what is being typed counts
    beside: [solving],
    left: [stage.element, strip.element],
    panel: panel.element,
  });
  channel.on("better", drag.again); // more is known about the size on the way

  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      page.ahead.told();
      drag.told();
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      frame.update();
      solving.classList.toggle("fl-busy", state.solving);
      solving.textContent = state.solving ? "solving…" : "";
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
      if (!connected) drag.cancel();
    },
  };
}

openPage("fe-page fl-page", "Opening the design…", build, ({ layouts }, buffers) => withColumns(layouts, buffers));
