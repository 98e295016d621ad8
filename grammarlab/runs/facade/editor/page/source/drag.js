/** @typedef {import("./types.js").Page} Page */

/**
 * Sizes on the way, while a side is dragged or an arrow key held.
 *
 * At most one request is under way, and the latest size goes next: what the server cannot follow is left out.
 * @param {Page} page
 * @param {(boxes: Float64Array, width: number, height: number) => void} show
 */
export function makeDrag(page, show) {
  /** @type {{ width: number, height: number, sent: boolean } | null} */
  let wanted = null;
  /** @type {{ boxes: Float64Array, width: number, height: number } | null} as it was before */
  let before = null;
  let busy = false;
  let ending = false;
  let conflict = "";

  async function go() {
    if (busy || !wanted) return;
    busy = true;
    const size = wanted;
    try {
      if (ending) {
        ending = false;
        await page.channel.request("resize", size);
        stop();
      } else {
        const { result, buffers } = await page.channel.request("drag", size);
        conflict = result.conflict ?? "";
        if (buffers.length && wanted) show(new Float64Array(buffers[0]), result.width, result.height);
        if (wanted === size) wanted.sent = true;
      }
    } catch (error) {
      restore();
      page.complain(error instanceof Error ? error.message : String(error));
    }
    busy = false;
    page.changed();
    if (wanted && (ending || !wanted.sent)) void go();
  }

  function stop() {
    wanted = before = null;
    ending = false;
    conflict = "";
  }

  function restore() {
    const was = before;
    stop();
    if (was) show(was.boxes, was.width, was.height);
  }

  return {
    get active() {
      return wanted !== null;
    },
    /** What contradicts what, while it does. */
    get conflict() {
      return conflict;
    },
    /** The size on the way, or as it is. */
    get size() {
      return wanted ?? { width: page.state.drawing.width, height: page.state.drawing.height };
    },
    /** @param {number} width @param {number} height */
    to(width, height) {
      const { drawing } = page.state;
      const clamp = (/** @type {number} */ metres, /** @type {number} */ now) =>
        Math.min(Math.max(metres, now / 50), now * 50);
      before ??= { boxes: page.state.boxes, width: drawing.width, height: drawing.height };
      wanted = { width: clamp(width, drawing.width), height: clamp(height, drawing.height), sent: false };
      void go();
    },
    /** What was reached stays. */
    end() {
      if (!wanted) return;
      ending = true;
      void go();
    },
    /** As it was before. */
    cancel() {
      restore();
      page.changed();
    },
  };
}
