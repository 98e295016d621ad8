import { Cell } from "./cell.js";
import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { inWords, knownOf } from "./known.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {{ clientX: number, clientY: number }} Point on the screen */
/** @typedef {{ anchor: Element, x: number, y: number }} Held a place within an element, as parts of its size */

export const ZOOMS = { least: 0.5, most: 10 };
const JUDGED = 200; // pixels of a picture from which a model can be judged
const OVERVIEW = 5; // columns of a grid that is for looking at many at once, however small
const SMALLEST = 26;
const LARGEST = 1200;
const ROOMY = 104; // pixels of a tile from which on numbers fit beside its bars
const BARS = 12; // pixels that they take below a tile
const ROOMY_BARS = 27;
const BY_HAND = 1500; // ms after a wheel, a finger or a scroll bar in which what comes into view was scrolled to
const NEAR = "25% 0px"; // how far from the view tiles are drawn well
const NARROW = 620; // pixels of width below which grids stand one above the other

/**
 * The grids of thumbnails, which zoom and pan together.
 *
 * Tiles are made once and drawn again: other models, another order or 200 new scores only change what differs.
 * @param {Page} page
 */
export function makeDisplay(page) {
  /** @type {{ element: HTMLElement, title: HTMLElement, list: HTMLElement, cells: Cell[] }[]} */
  const grids = [];
  const board = element("div", { class: "gl-board" });
  const more = textButton("More models", () => void ask(), { class: "gl-button gl-quiet gl-more" });
  const stage = element("div", { class: "gl-stage" }, board, more);
  const about = element("p", { class: "gl-about" });
  const { pictures } = page;
  let zoom = 1;
  let columns = 1; // of a grid, as it is shown
  let size = 0;
  let frame = 0;
  let zoomed = () => {};
  let asked = ""; // what was shown when more was asked for
  let moved = -Infinity; // when a hand moved what is shown, ms

  const resizes = new ResizeObserver(() => fit());
  resizes.observe(stage);

  // Scrolling goes on without an end: what is in line comes when the end is near. Keys only move to what is there.
  const byHand = () => (moved = performance.now());
  stage.addEventListener("wheel", byHand, { passive: true });
  stage.addEventListener("touchmove", byHand, { passive: true });
  // On the scroll bar; a click on a tile may scroll, but not on and on.
  stage.addEventListener("pointerdown", ({ target }) => target === stage && byHand());
  const atEnd = new IntersectionObserver(([{ isIntersecting }]) => {
    if (isIntersecting && performance.now() - moved < BY_HAND) void ask();
  });
  atEnd.observe(more);

  // What is out of view is drawn quickly until it comes near.
  /** @type {Set<Element>} */
  const near = new Set();
  const comings = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) near[isIntersecting ? "add" : "delete"](target);
      wantPictures();
    },
    { root: stage, rootMargin: NEAR },
  );

  async function ask() {
    const now = page.selection.order.join();
    if (asked === now) return;
    asked = now;
    // Refused, or lost with the connection: they can be asked for again.
    if (!(await page.ask("more"))) asked = "";
  }

  /** @param {State} state */
  function update(state) {
    if (!state.updating) asked = ""; // whether there were more or not
    const beginsAnew = page.selection.show(state.grids.flatMap((grid) => grid.models));
    while (grids.length < state.grids.length) grids.push(makeGrid(grids.length));
    // Moving an element takes the keyboard away from what is in it, so only what has to move does.
    if (board.childElementCount !== state.grids.length) {
      board.replaceChildren(...state.grids.map((_, index) => grids[index].element));
    }
    state.grids.forEach((grid, index) => fill(grids[index], grid.title, grid.models.length));
    fit();
    draw();
    if (beginsAnew) focus();
  }

  /** @param {typeof grids[number]} grid @param {string} title @param {number} count */
  function fill({ title: heading, list, cells }, title, count) {
    heading.textContent = title || "more";
    while (cells.length < count) {
      const cell = new Cell();
      comings.observe(cell.element);
      cells.push(cell);
    }
    while (list.childElementCount > count) list.lastElementChild?.remove();
    for (let next = list.childElementCount; next < count; next += 1) list.append(cells[next].element);
  }

  /**
   * As large as the room allows, times the zoom. Where all would fit at a size that nobody can judge, a grid has fewer
   * columns and is longer than the room.
   */
  function fit() {
    const layout = page.state.layout;
    const count = page.state.grids.length;
    // Neither changes with what is in the stage: a scroll bar has its own room in the width, and is part of the height.
    const { clientWidth: width, offsetHeight: height } = stage;
    if (!width) return;
    const stacked = count > 1 && width < NARROW;
    const gap = layout.columns > 6 ? 4 : 8;
    const room = stacked ? width - 34 : (width - 34 - (count - 1) * 24) / count;
    const tall = (height - 56) / layout.rows - gap;
    const bars = page.preferences.bars ? (tall - ROOMY_BARS >= ROOMY ? ROOMY_BARS : BARS) : 0;
    // With larger tiles than that, numbers would need room beside the bars.
    const high = bars === BARS ? Math.min(tall - bars, ROOMY - 1) : tall - bars;
    const wide = room / layout.columns - gap;
    let fitting = stacked || height < 260 ? wide : Math.min(wide, high);
    columns = layout.columns;
    if (fitting < JUDGED && columns < OVERVIEW) {
      const most = Math.max(Math.floor((room + gap) / (JUDGED + gap)), 2);
      columns = Math.min(columns, most);
      fitting = Math.max(Math.min(room / columns - gap, Math.max(JUDGED, height - 56 - ROOMY_BARS)), fitting);
    }
    size = Math.min(Math.max(Math.floor(fitting * zoom), SMALLEST), LARGEST);
    stage.classList.toggle("gl-stacked", stacked);
    stage.classList.toggle("gl-roomy", size >= ROOMY);
    stage.classList.toggle("gl-no-bars", !page.preferences.bars);
    stage.style.setProperty("--gl-size", `${size}px`);
    stage.style.setProperty("--gl-gap", `${gap}px`);
    stage.style.setProperty("--gl-columns", String(columns));
    wantPictures();
  }

  function wantPictures() {
    if (page.state.pairs || !size) return;
    const here = tiles();
    const [inView, others] = [true, false].map((is) =>
      page.selection.order.filter((_, at) => near.has(here[at]) === is),
    );
    pictures.want(inView, pixelsFor(size), others);
  }

  function drawSoon() {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      draw();
    });
  }

  function draw() {
    if (page.state.pairs) return;
    let position = 0;
    page.state.grids.forEach((grid, index) => {
      const first = position;
      const here = page.selection.cursor - first;
      const keyboard = here >= 0 && here < grid.models.length ? here : 0;
      grid.models.forEach((model, place) => {
        const chosen = page.selection.chosen.has(model);
        const [picture, cursor] = [pictures.find(model), place === keyboard];
        grids[index].cells[place].draw({ ...knownOf(page, model), model, picture, chosen, cursor });
      });
      position += grid.models.length;
    });
    describe(page.selection.current);
  }

  /** Says below the grids what is known of a model. @param {string | undefined} model */
  function describe(model) {
    about.textContent = model && page.state.models[model] ? inWords(knownOf(page, model)) : "";
  }

  /**
   * @param {number} factor to zoom by; 0 fits all again
   * @param {Point} [to] where what is held comes to lie; the middle if not given
   * @param {Held} [held] what was there before, if not given
   */
  function zoomBy(factor, to = middle(), held = hold(to)) {
    zoom = factor ? Math.min(Math.max(zoom * factor, ZOOMS.least), ZOOMS.most) : 1;
    fit();
    zoomed();
    const box = held.anchor.getBoundingClientRect();
    stage.scrollLeft += box.x + held.x * box.width - to.clientX;
    stage.scrollTop += box.y + held.y * box.height - to.clientY;
  }

  /**
   * The place of the models that lies at a point. Gaps do not grow with the tiles, so it is a place of a tile where
   * there is one.
   * @param {Point} point
   * @returns {Held}
   */
  function hold({ clientX, clientY }) {
    const ground = /** @type {Document | ShadowRoot} */ (stage.getRootNode());
    const anchor = ground.elementFromPoint(clientX, clientY)?.closest(".gl-cell") ?? board;
    const box = anchor.getBoundingClientRect();
    return { anchor, x: (clientX - box.x) / box.width, y: (clientY - box.y) / box.height };
  }

  /** @returns {Point} */
  function middle() {
    const { x, y, width, height } = stage.getBoundingClientRect();
    return { clientX: x + width / 2, clientY: y + height / 2 };
  }

  /** The position of the tile that an element lies in, or -1. @param {EventTarget | null} target */
  function positionOf(target) {
    const tile = target instanceof Element ? target.closest(".gl-cell") : null;
    return tile ? tiles().indexOf(tile) : -1;
  }

  /** @returns {Element[]} all tiles, by position */
  function tiles() {
    return page.state.grids.flatMap((_, index) => [...grids[index].list.children]);
  }

  /** Brings the keyboard to where the selection's cursor is. */
  function focus() {
    const tile = /** @type {HTMLElement | undefined} */ (tiles()[page.selection.cursor]);
    tile?.focus({ preventScroll: true });
    tile?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }

  function askAgain() {
    pictures.askAgain();
    fit();
  }

  function close() {
    resizes.disconnect();
    atEnd.disconnect();
    comings.disconnect();
  }

  return {
    element: stage,
    about,
    columns: () => columns,
    update,
    drawSoon,
    fit,
    describe,
    zoomBy,
    zoom: () => zoom,
    /** Calls a function after every change of the zoom. @param {() => void} listener */
    whenZoomed: (listener) => void (zoomed = listener),
    hold,
    positionOf,
    tiles,
    focus,
    askAgain,
    close,
  };
}

/** @param {number} index */
function makeGrid(index) {
  const id = `gl-grid-${Math.random().toString(36).slice(2, 8)}-${index}`;
  const title = element("h2", { id, class: "gl-title" });
  const list = element("div", {
    class: "gl-grid",
    role: "listbox",
    "aria-multiselectable": "true",
    "aria-labelledby": id,
  });
  /** @type {Cell[]} */
  const cells = [];
  return { element: element("section", { class: "gl-section" }, title, list), title, list, cells };
}

/** The size of the pictures for tiles of a size on screen. @param {number} size */
function pixelsFor(size) {
  return size * Math.min(globalThis.devicePixelRatio || 1, 2) > 200 ? 320 : 160;
}
