import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("./display.js").makeDisplay>} Display */

const SLACK = 4; // pixels that a hand may shake in a click
const LINE = 34; // pixels that a browser means which counts in lines, three to a notch
const NOTCH = 100; // pixels from which on it was a notch of a mouse wheel, not fingers on a touchpad
const STEP = 24; // what a notch counts for

/**
 * Mouse, pen and fingers on the grids: click, range, toggle, rubber band, zoom and pan.
 *
 * All listeners sit on the stage, however many tiles there are.
 * @param {Page} page
 * @param {Display} display
 */
export function listenToPointer(page, display) {
  const stage = display.element;
  const band = element("div", { class: "gl-band", hidden: true });
  stage.append(band);
  /** @type {{ event: PointerEvent, moved: boolean, pans: boolean, kept: Set<string>, left: number, top: number } | null} */
  let drag = null;
  /** @type {{ distance: number, held: import("./display.js").Held } | null} two fingers, and what they hold */
  let pinch = null;
  let panning = false;

  stage.addEventListener("pointerdown", (event) => {
    if (event.button > 1 || onScrollbar(event)) return;
    const command = event.ctrlKey || event.metaKey;
    const pans = panning || command || event.button === 1 || event.pointerType === "touch";
    const kept = new Set(event.shiftKey ? page.selection.chosen : []);
    drag = { event, moved: false, pans, kept, left: stage.scrollLeft, top: stage.scrollTop };
    if (event.button === 1) event.preventDefault();
  });

  stage.addEventListener("pointermove", (event) => {
    if (!drag) return hover(event);
    const { event: start } = drag;
    if (!drag.moved && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < SLACK) return;
    if (!drag.moved) stage.setPointerCapture(event.pointerId);
    drag.moved = true;
    if (drag.pans) pan(event);
    else stretch(event);
  });

  for (const end of /** @type {const} */ (["pointerup", "pointercancel"])) {
    stage.addEventListener(end, (event) => {
      if (drag && !drag.moved && end === "pointerup" && drag.event.button === 0) click(event);
      drag = null;
      band.hidden = true;
      stage.classList.remove("gl-grabbing");
    });
  }

  stage.addEventListener("dblclick", (event) => {
    const position = display.positionOf(event.target);
    if (position >= 0) page.look(page.selection.order[position]);
  });

  stage.addEventListener("pointerleave", () => display.describe(page.selection.current));

  stage.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey && !event.metaKey) return; // plain turning scrolls, so that a notebook can be scrolled past
      event.preventDefault();
      // Two fingers on a touchpad arrive as this, 100 times the logarithm of how far they moved apart.
      const turned = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1);
      const far = Math.abs(turned) < NOTCH ? turned : Math.sign(turned) * STEP;
      display.zoomBy(Math.exp(-far / 100), event);
    },
    { passive: false },
  );

  // One finger scrolls without us. Two would, too, if the browser were not told in time that they mean something else.
  stage.addEventListener(
    "touchstart",
    (event) => {
      grip(event);
      if (!pinch) return;
      if (event.cancelable) event.preventDefault();
      drag = null;
    },
    { passive: false },
  );

  stage.addEventListener(
    "touchmove",
    (event) => {
      const now = apart(event);
      if (!pinch || !now) return;
      if (event.cancelable) event.preventDefault();
      display.zoomBy(now.distance / pinch.distance, now, pinch.held);
      pinch.distance = now.distance;
    },
    { passive: false },
  );

  for (const end of /** @type {const} */ (["touchend", "touchcancel"])) {
    stage.addEventListener(end, grip);
  }

  /** @param {TouchEvent} event */
  function grip(event) {
    const fingers = apart(event);
    pinch = fingers && { distance: fingers.distance, held: display.hold(fingers) };
  }

  /** @param {PointerEvent} event */
  function click(event) {
    const position = display.positionOf(event.target);
    const { selection } = page;
    if (position < 0) return event.shiftKey || event.ctrlKey || event.metaKey ? undefined : selection.none();
    if (event.shiftKey) selection.rangeTo(position, event.ctrlKey || event.metaKey);
    else if (event.ctrlKey || event.metaKey) selection.toggle(position);
    else if (event.pointerType === "touch") selection.touch(position);
    else selection.only(position);
    display.focus();
  }

  /** @param {PointerEvent} event */
  function hover(event) {
    const position = display.positionOf(event.target);
    display.describe(position < 0 ? page.selection.current : page.selection.order[position]);
  }

  /** @param {PointerEvent} event */
  function pan(event) {
    if (!drag || event.pointerType === "touch") return; // fingers scroll by themselves
    stage.classList.add("gl-grabbing");
    stage.scrollLeft = drag.left - (event.clientX - drag.event.clientX);
    stage.scrollTop = drag.top - (event.clientY - drag.event.clientY);
  }

  /** The rubber band, which scrolls with what lies below it. @param {PointerEvent} event */
  function stretch(event) {
    if (!drag) return;
    const room = stage.getBoundingClientRect();
    if (event.clientY > room.bottom - 12) stage.scrollTop += 12;
    if (event.clientY < room.top + 12) stage.scrollTop -= 12;
    const [left, right] = [drag.event.clientX + drag.left - stage.scrollLeft, event.clientX].sort((a, b) => a - b);
    const [top, bottom] = [drag.event.clientY + drag.top - stage.scrollTop, event.clientY].sort((a, b) => a - b);
    band.hidden = false;
    band.style.transform = `translate(${left - room.left + stage.scrollLeft}px, ${top - room.top + stage.scrollTop}px)`;
    band.style.width = `${right - left}px`;
    band.style.height = `${bottom - top}px`;
    const inside = display.tiles().map((tile) => {
      const box = tile.getBoundingClientRect();
      return box.left < right && box.right > left && box.top < bottom && box.bottom > top;
    });
    page.selection.replace([...drag.kept, ...page.selection.order.filter((_, position) => inside[position])]);
  }

  /** @param {PointerEvent} event */
  function onScrollbar(event) {
    const room = stage.getBoundingClientRect();
    return event.clientX > room.left + stage.clientWidth || event.clientY > room.top + stage.clientHeight;
  }

  return {
    /** Dragging pans instead of selecting. @param {boolean} on */
    pan(on) {
      panning = on;
      stage.classList.toggle("gl-pans", on);
    },
  };
}

/** How far two fingers are from each other, and what is between them; nothing for fewer or more. @param {TouchEvent} event */
function apart({ touches }) {
  if (touches.length !== 2) return null;
  const [a, b] = touches;
  const distance = Math.max(Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), 1);
  return { distance, clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 };
}
