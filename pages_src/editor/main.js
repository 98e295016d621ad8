import { Ahead } from "../shared/ahead.js";
import { makeFrame } from "../shared/frame.js";
import { makeHelp } from "../shared/help.js";
import { LOST, makeAsk, makeNotes } from "../shared/notes.js";
import { openPage } from "../shared/open.js";
import { makeDrag } from "../stage/drag.js";
import { makeStage } from "../stage/stage.js";
import { listenToPointer } from "./gestures.js";
import { KEYS, listenToKeys } from "./keyboard.js";
import { isLocked, makePanel } from "./panel.js";
import { Pictures } from "./pictures.js";
import { makeStrip } from "./strip.js";

/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").What} What */

/** @type {Record<string, string>} */
const KINDS = {
  json: "facade, can be opened again",
  svg: "drawing",
  png: "picture",
  glb: "model",
  obj: "model",
  cga: "rules of the facade",
};

/** @param {HTMLElement} root @param {Channel} channel @param {State} first */
function build(root, channel, first) {
  const notes = makeNotes();
  const ahead = new Ahead(); // whether sizes are locked
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
    ask: makeAsk(channel, notes, () => drag.idle()),
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
    save: () => frame.save(),
    /** @param {What} what @param {number} [node] */
    toggleLock(what, node = page.selected) {
      if (node < 0) return page.say("Select a part first, to lock its size.");
      const key = `${node} ${what}`;
      const locked = !ahead.of(key, isLocked(page, node, what));
      void ahead.set(key, locked, page.ask(locked ? "lock" : "unlock", { node, what }));
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
    "Drag the handles at the right and at the top to change the size. Click a part to select it. Draw a rectangle to make a grid. Click a picture below to accept a variation.",
  );
  listenToPointer(page, stage, drag);
  listenToKeys(page, stage, drag, acts);
  const frame = makeFrame(root, page, {
    notes,
    help,
    kinds: KINDS,
    // A length that is being typed counts.
    settle: () => document.activeElement instanceof HTMLInputElement && document.activeElement.blur(),
    beside: [],
    left: [stage.element, strip.element],
    panel: panel.element,
  });

  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      ahead.told();
      if (before) before = sizesNow(); // what a cancelled drag goes back to
      drag.told();
      if (page.selected >= state.parent.length) page.selected = -1;
      page.gridding &&= Boolean(state.active);
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      void page.pictures.want(state.pictures);
      frame.update();
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
      if (!connected) return void drag.cancel();
      page.pictures.again();
      void page.pictures.want(page.state.pictures);
      strip.again();
    },
  };
}

/** @param {State} state @param {ArrayBuffer[]} buffers */
function read(state, buffers) {
  state.drawing.columns = new Float64Array(buffers[0]);
  state.boxes = new Float64Array(buffers[1]);
}

openPage("fe-page", "Opening the facade…", build, read);
