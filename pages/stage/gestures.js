/** @typedef {import("../editor/types.js").Page} Page */
/** @typedef {ReturnType<typeof import("./stage.js").makeStage>} Stage */
/** @typedef {ReturnType<typeof import("./drag.js").makeDrag>} Drag */

const SLACK = 4; // pixels that a hand may shake in a click

/**
 * Mouse, pen and finger on the facade: a press selects a part or changes the grid, a rectangle
 * makes a grid, the selected part is moved, handles size.
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

/**
 * Handles size the whole.
 * @param {{ state: { drawing: { width: number, height: number } }, tied: boolean }} page
 * @param {Stage} stage
 * @param {Drag} drag
 */
export function listenToHandles(page, stage, drag) {
  listenToHandle(stage.handles.width, (start, dx, _dy, tied) => scaled(start, start.width + dx, null, tied));
  listenToHandle(stage.handles.height, (start, _dx, dy, tied) => scaled(start, null, start.height + dy, tied));
  listenToHandle(stage.handles.both, (start, dx, dy, tied) => {
    if (!tied) return drag.to(start.width + dx, start.height + dy);
    scaled(start, start.width + dx, null, true);
  });

  /**
   * @param {{ width: number, height: number }} start
   * @param {number | null} width
   * @param {number | null} height
   * @param {boolean} tied
   */
  function scaled(start, width, height, tied) {
    const factor = tied ? (width !== null ? width / start.width : (height ?? start.height) / start.height) : 1;
    drag.to(width ?? start.width * factor, height ?? start.height * factor);
  }

  /**
   * @param {HTMLElement} handle
   * @param {(start: { width: number, height: number }, dx: number, dy: number, tied: boolean) => void} move
   */
  function listenToHandle(handle, move) {
    /** @type {{ x: number, y: number, size: { width: number, height: number } } | null} */
    let held = null;
    handle.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      event.preventDefault();
      handle.focus();
      handle.setPointerCapture(event.pointerId);
      const { width, height } = page.state.drawing;
      held = { x: event.clientX, y: event.clientY, size: { width, height } };
    });
    handle.addEventListener("pointermove", (event) => {
      if (!held) return;
      const { scale } = stage.view;
      move(held.size, (event.clientX - held.x) / scale, (held.y - event.clientY) / scale, event.shiftKey || page.tied);
    });
    for (const end of /** @type {const} */ (["pointerup", "lostpointercapture"])) {
      handle.addEventListener(end, () => {
        if (held) drag.end();
        held = null;
      });
    }
    handle.addEventListener("pointercancel", () => {
      held = null;
      drag.cancel();
    });
    handle.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !held) return;
      held = null;
      drag.cancel();
    });
  }
}
