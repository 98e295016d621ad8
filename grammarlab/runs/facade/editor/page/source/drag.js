/** @typedef {import("./types.js").Page} Page */

/**
 * Sizes on the way, while a side or a part is dragged or an arrow key held.
 *
 * At most one request is under way, and the latest size goes next: what the server cannot follow is left out.
 * @param {Page} page
 * @param {(boxes: Float64Array, width: number, height: number) => void} show
 */
export function makeDrag(page, show) {
  /** @type {{ command: "resize" | "move", values: Record<string, number>, sent: boolean } | null} */
  let wanted = null;
  /** @type {{ boxes: Float64Array, width: number, height: number } | null} as it was before */
  let before = null;
  /** @type {Promise<void> | null} */
  let running = null;
  let ending = false;
  let conflict = "";

  function go() {
    running ??= run().finally(() => (running = null));
  }

  async function run() {
    while (wanted && (ending || !wanted.sent)) {
      const next = wanted;
      try {
        if (ending) await settle(next);
        else await solve(next);
      } catch (error) {
        restore();
        page.complain(error instanceof Error ? error.message : String(error));
      }
      page.changed();
    }
  }

  /** @param {NonNullable<typeof wanted>} next */
  async function solve(next) {
    const { result, buffers } = await page.channel.request("drag", next.values);
    conflict = result.conflict ?? "";
    if (buffers.length && wanted) show(new Float64Array(buffers[0]), result.width, result.height);
    next.sent = true;
  }

  /** @param {NonNullable<typeof wanted>} next */
  async function settle(next) {
    ending = false;
    next.sent = true;
    const { result } = await page.channel.request(next.command, next.values);
    if (wanted !== next) return; // the next drag has begun
    if (result.revision === page.state.revision) restore();
    else stop();
  }

  /** @param {"resize" | "move"} command @param {Record<string, number>} values */
  function want(command, values) {
    const { boxes, drawing } = page.state;
    before ??= { boxes, width: drawing.width, height: drawing.height };
    wanted = { command, values, sent: false };
    go();
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
      const { width, height } = page.state.drawing;
      return wanted?.command === "resize"
        ? { width: wanted.values.width, height: wanted.values.height }
        : { width, height };
    },
    /** @param {number} width @param {number} height */
    to(width, height) {
      const { drawing } = page.state;
      want("resize", { width: round(width, drawing.width), height: round(height, drawing.height) });
    },
    /** @param {number} node @param {number} left @param {number} bottom metres from the lower left of the facade */
    move(node, left, bottom) {
      want("move", { node, left: Math.max(0, left), bottom: Math.max(0, bottom) });
    },
    /** What was reached stays. */
    end() {
      if (!wanted) return;
      ending = true;
      go();
    },
    /** Once nothing is under way. */
    idle: () => running ?? Promise.resolve(),
    /** What is shown now is what a cancelled drag goes back to. */
    rebase() {
      const { boxes, drawing } = page.state;
      if (before) before = { boxes, width: drawing.width, height: drawing.height };
    },
    /** As it was before. */
    cancel() {
      restore();
      page.changed();
    },
  };
}

/**
 * A length that reads well, and that a facade can have.
 * @param {number} metres
 * @param {number} now what it is; a hand cannot mean one much smaller or larger, nor more than four digits
 */
function round(metres, now) {
  if (metres === now) return now;
  const step = 10 ** (Math.floor(Math.log10(now)) - 3);
  return Number((Math.round(Math.min(Math.max(metres, now / 50), now * 50) / step) * step).toPrecision(9));
}
