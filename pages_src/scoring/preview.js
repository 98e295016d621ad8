import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("../viewer/viewer.js").show>} View */

const REST = 500; // ms that a mouse or the keyboard rests on a model before it is shown
const ROUND = 9000; // ms of one turn, after which it stands still
const LARGEST = 460; // pixels along each side
const ROOM = 560; // pixels of width from which on there is room beside the model that is meant

/**
 * The model below the mouse or the keyboard, large beside it, and turning once.
 * @param {Page} page
 * @param {ReturnType<typeof import("./display.js").makeDisplay>} display
 * @param {ReturnType<typeof import("../shared/viewer_code.js").viewerCode>} code
 */
export function makePreview(page, display, code) {
  const stage = display.element;
  const canvas = element("canvas", { class: "gl-canvas" });
  const box = element("div", { class: "gl-preview", "aria-hidden": "true", hidden: true }, canvas);
  /** @type {View | null} */
  let view = null;
  let model = "";
  let timer = 0;
  let frame = 0;

  stage.addEventListener("pointermove", ({ pointerType, buttons, target }) => {
    if (pointerType === "mouse" && !buttons) rest(target);
  });
  stage.addEventListener("focusin", ({ target }) => {
    if (target instanceof Element && target.matches(":focus-visible")) rest(target);
  });
  for (const end of ["pointerleave", "pointerdown", "focusout", "wheel", "keydown"])
    stage.addEventListener(end, hide, { passive: true });
  // A tile that gets the keyboard is brought into view; one that is scrolled away from the mouse is not meant any more.
  stage.addEventListener("scroll", () => (box.hidden ? wait() : hide()), { passive: true });

  /** @param {EventTarget | null} target */
  function rest(target) {
    const position = display.positionOf(target);
    const meant = position < 0 ? "" : page.selection.order[position];
    if (meant === model) return;
    hide();
    if (!meant || !page.preferences.preview || stage.clientWidth < ROOM) return;
    model = meant;
    wait();
  }

  function wait() {
    clearTimeout(timer);
    if (model) timer = window.setTimeout(() => void show(), REST);
  }

  async function show() {
    const meant = model;
    try {
      const [{ buffers }, { show: open }] = await Promise.all([
        page.channel.request("model", { model: meant }),
        code(),
      ]);
      const tile = display.tiles()[page.selection.order.indexOf(meant)];
      if (model !== meant || !tile) return;
      place(tile);
      view ??= open(canvas, { damping: false });
      await view.load(buffers[0]);
      if (model === meant) turn(view);
    } catch {
      hide(); // its picture is there, and the 3D view says what is wrong
    }
  }

  /** On the other side of the stage. @param {Element} tile */
  function place(tile) {
    const [room, at] = [stage.getBoundingClientRect(), tile.getBoundingClientRect()];
    const size = Math.min(LARGEST, 0.48 * room.width, room.height - 24);
    const isLeft = at.left + at.width / 2 < room.left + room.width / 2;
    box.style.width = box.style.height = `${size}px`;
    box.style.left = `${stage.offsetLeft + (isLeft ? stage.clientWidth - size - 12 : 12)}px`;
    box.style.top = `${stage.offsetTop + 12}px`;
    box.hidden = false;
  }

  /** @param {View} shown */
  function turn(shown) {
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    const begin = performance.now();
    let before = begin;
    const step = (/** @type {number} */ now) => {
      shown.move((2 * Math.PI * Math.max(now - before, 0)) / ROUND);
      before = Math.max(now, before);
      frame = now - begin < ROUND ? requestAnimationFrame(step) : 0;
    };
    frame = requestAnimationFrame(step);
  }

  function hide() {
    clearTimeout(timer);
    cancelAnimationFrame(frame);
    model = "";
    box.hidden = true;
  }

  return {
    element: box,
    hide,
    /** Other models may be shown now. */
    update() {
      if (model && !page.selection.order.includes(model)) hide();
    },
    close() {
      hide();
      view?.dispose();
    },
  };
}
