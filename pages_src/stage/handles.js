/** @typedef {ReturnType<typeof import("./stage.js").makeStage>} Stage */
/** @typedef {ReturnType<typeof import("./drag.js").makeDrag>} Drag */

/**
 * Handles change the size of the whole facade.
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
