import { listenToHandles } from "../stage/handles.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("../stage/stage.js").makeStage>} Stage */
/** @typedef {ReturnType<typeof import("../stage/drag.js").makeDrag>} Drag */

const SLACK = 4; // largest movement of a click, in pixels

/**
 * Mouse, pen and finger on the facade: a press selects a part or changes the grid, a rectangle
 * makes a grid, a drag moves the selected part, handles change the size.
 * @param {Page} page
 * @param {Stage} stage
 * @param {Drag} drag
 */
export function listenToPointer(page, stage, drag) {
  const { face } = stage;
  /** @type {{ x: number, y: number, event: PointerEvent, moved: boolean, box: Float64Array | null } | null} */
  let press = null; // `box` of the selected part, which follows

  face.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    const box = stage.isOnSelected(event) && !page.gridding ? stage.boxOf(page.selected).slice() : null;
    press = { ...stage.metresAt(event), event, moved: false, box };
    face.setPointerCapture(event.pointerId);
  });
  face.addEventListener("pointermove", (event) => {
    if (!press) {
      face.classList.toggle("fe-movable", stage.isOnSelected(event) && !page.gridding);
      return stage.hover(event.pointerType === "touch" ? -1 : stage.leafAt(event));
    }
    const { event: start } = press;
    press.moved ||= Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) >= SLACK;
    if (!press.moved) return;
    if (!press.box) return stage.lasso(areaTo(event));
    const { x, y } = stage.metresAt(event);
    drag.move(page.selected, press.box[0] + x - press.x, press.box[1] + y - press.y);
  });
  face.addEventListener("pointerleave", () => stage.hover(-1));
  face.addEventListener("pointerup", (event) => {
    if (!press) return;
    const { moved, box } = press;
    const area = areaTo(event);
    stop();
    if (moved && box) drag.end();
    else if (moved) void page.ask("lasso", area);
    else click(stage.leafAt(event));
  });
  face.addEventListener("pointercancel", cancel);
  face.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && press) cancel();
  });

  function cancel() {
    if (press?.box) drag.cancel();
    stop();
  }

  function stop() {
    press = null;
    stage.lasso(null);
  }

  /** @param {number} node */
  function click(node) {
    if (node >= 0 && page.gridding) void page.ask("press", { node });
    else page.select(node === page.selected ? -1 : node);
  }

  /** @param {PointerEvent} event */
  function areaTo(event) {
    const { x, y } = stage.metresAt(event);
    const from = press ?? { x, y };
    return {
      left: Math.min(from.x, x),
      right: Math.max(from.x, x),
      bottom: Math.min(from.y, y),
      top: Math.max(from.y, y),
    };
  }

  listenToHandles(page, stage, drag);
}
