/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {{ command: "resize" | "move", values: Record<string, number>, sent: boolean }} Wish */

/**
 * Intermediate sizes while a side or a part is dragged or an arrow key is held.
 *
 * At most one request is under way, and the latest size is sent next; sizes that the server is too slow for are skipped.
 * The size at the end of a drag is never skipped, and becomes its own step.
 * @param {{ state: { revision: number, drawing: { width: number, height: number } }, channel: Channel, complain: (text: string) => void, changed: () => void }} page
 * @param {object} hooks
 * @param {() => void} hooks.began or went on
 * @param {(result: any, buffers: ArrayBuffer[]) => void} hooks.show a size on the way
 * @param {(kept: boolean) => void} hooks.ended and what was reached is kept, or all is as before
 */
export function makeDrag(page, { began, show, ended }) {
  /** @type {Wish | null} */
  let wanted = null;
  /** @type {Wish[]} of drags that have ended */
  let reached = [];
  /** @type {Promise<void> | null} */
  let running = null;
  let told = () => {};
  let conflict = "";

  function go() {
    running ??= run().finally(() => (running = null));
  }

  async function run() {
    while (reached.length || (wanted && !wanted.sent)) {
      try {
        if (reached.length) await settle(reached[0]);
        else if (wanted) await solve(wanted);
      } catch (error) {
        stop(false);
        page.complain(error instanceof Error ? error.message : String(error));
      }
      page.changed();
    }
  }

  /** @param {Wish} wish */
  async function solve(wish) {
    wish.sent = true;
    const { result, buffers } = await page.channel.request("drag", wish.values);
    if (!wanted && !reached.length) return; // cancelled
    conflict = result.conflict ?? "";
    if (buffers.length) show(result, buffers);
  }

  /** @param {Wish} wish */
  async function settle(wish) {
    const { result } = await page.channel.request(wish.command, wish.values);
    const changed = result.revision !== page.state.revision;
    if (changed) await new Promise((resolve) => (told = () => resolve(undefined)));
    reached = reached.filter((each) => each !== wish);
    if (reached.length || wanted) return;
    stop(changed);
  }

  /** @param {"resize" | "move"} command @param {Record<string, number>} values */
  function want(command, values) {
    began();
    wanted = { command, values, sent: false };
    go();
  }

  /** @param {boolean} kept */
  function stop(kept) {
    wanted = null;
    reached = [];
    conflict = "";
    told();
    ended(kept);
  }

  return {
    get active() {
      return wanted !== null || reached.length > 0;
    },
    /** What contradicts what, while it does. */
    get conflict() {
      return conflict;
    },
    /** The size on the way, or as it is. */
    get size() {
      const wish = wanted ?? reached.at(-1);
      const { width, height } = wish?.command === "resize" ? wish.values : page.state.drawing;
      return { width, height };
    },
    /** Left and bottom of a part on the way. @param {number} node @returns {number[] | undefined} */
    placeOf(node) {
      const wish = wanted ?? reached.at(-1);
      return wish?.command === "move" && wish.values.node === node ? [wish.values.left, wish.values.bottom] : undefined;
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
      reached.push(wanted);
      wanted = null;
      go();
    },
    /** Once nothing is under way. */
    idle: () => running ?? Promise.resolve(),
    /** More is known about the size on the way. */
    again() {
      if (!wanted) return;
      wanted.sent = false;
      go();
    },
    /** A state was told. */
    told: () => told(),
    /** As it was before. */
    cancel() {
      stop(false);
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
