import { element } from "./element.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("./display.js").makeDisplay>} Display */

const SLACK = 4; // pixels that a hand may shake in a click

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
  /** @type {Map<number, PointerEvent>} */
  const fingers = new Map();
  let panning = false;

  stage.addEventListener("pointerdown", (event) => {
    if (event.pointerType === "touch") fingers.set(event.pointerId, event);
    if (event.button > 1 || onScrollbar(event)) return;
    const command = event.ctrlKey || event.metaKey;
    const pans = panning || command || event.button === 1 || event.pointerType === "touch";
    const kept = new Set(event.shiftKey ? page.selection.chosen : []);
    drag = { event, moved: false, pans, kept, left: stage.scrollLeft, top: stage.scrollTop };
    if (event.button === 1) event.preventDefault();
  });

  stage.addEventListener("pointermove", (event) => {
    if (fingers.size === 2) return pinch(event);
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
      fingers.delete(event.pointerId);
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
      display.zoomBy(Math.exp((-Math.sign(event.deltaY) * Math.min(Math.abs(event.deltaY), 60)) / 250), event);
    },
    { passive: false },
  );

  /** @param {PointerEvent} event */
  function click(event) {
    const position = display.positionOf(event.target);
    const { selection } = page;
    if (position < 0) return event.shiftKey || event.ctrlKey || event.metaKey ? undefined : selection.none();
    if (event.shiftKey) selection.rangeTo(position, event.ctrlKey || event.metaKey);
    else if (event.ctrlKey || event.metaKey || event.pointerType === "touch") selection.toggle(position);
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
  function pinch(event) {
    const distance = () => {
      const [a, b] = [...fingers.values()];
      return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);
    };
    const before = distance();
    fingers.set(event.pointerId, event);
    const [a, b] = [...fingers.values()];
    display.zoomBy(distance() / before, { clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 });
    drag = null;
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
