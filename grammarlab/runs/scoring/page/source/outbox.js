import { ConnectionLost } from "./channel.js";

/** @typedef {import("./channel.js").Channel} Channel */
/**
 * @typedef {object} Entry one act of scoring
 * @property {string} key the same however often it is sent, so that Python stores it once
 * @property {string[]} models
 * @property {number | null} score
 * @property {number} factor id of the factor that the person saw
 * @property {number} since when it was given, ms
 * @property {number} [revision] of the session, once it is saved
 */

/**
 * Scores on their way. A score stays here until Python says that it is on disk, through lost connections; only a
 * refusal takes it out otherwise, and that is told.
 */
export class Outbox {
  #channel;
  /** @type {() => void} */
  #changed;
  /** @type {(error: Error) => void} */
  #refused;
  /** @type {Entry[]} */
  #entries = [];

  /** @param {Channel} channel @param {() => void} changed @param {(error: Error) => void} refused */
  constructor(channel, changed, refused) {
    this.#channel = channel;
    this.#changed = changed;
    this.#refused = refused;
  }

  /** @param {string[]} models @param {number | null} score @param {number} factor */
  add(models, score, factor) {
    const key = Math.random().toString(36).slice(2) + Date.now().toString(36);
    const entry = { key, models, score, factor, since: performance.now() };
    this.#entries.push(entry);
    this.#changed();
    void this.#send(entry);
  }

  /** After a reconnection: everything that was not acknowledged, in the order it was given. */
  resend() {
    for (const entry of this.#unsaved) void this.#send(entry);
  }

  /** Python's state knows all events up to a revision, so those need no place here. @param {number} revision */
  settle(revision) {
    this.#entries = this.#entries.filter((entry) => entry.revision === undefined || entry.revision > revision);
  }

  /** How many scores are not on disk. */
  get unsaved() {
    return this.#unsaved.reduce((sum, entry) => sum + entry.models.length, 0);
  }

  /** Milliseconds since the oldest score that is not on disk. */
  get waiting() {
    const [oldest] = this.#unsaved;
    return oldest ? performance.now() - oldest.since : 0;
  }

  /**
   * The score that a model has here, newer than the one Python told.
   * @param {string} model
   * @param {number} factor
   * @returns {{ score: number | null, saved: boolean } | undefined}
   */
  find(model, factor) {
    const entry = this.#entries.findLast((each) => each.factor === factor && each.models.includes(model));
    return entry && { score: entry.score, saved: entry.revision !== undefined };
  }

  get #unsaved() {
    return this.#entries.filter((entry) => entry.revision === undefined);
  }

  /** @param {Entry} entry */
  async #send(entry) {
    const { key, models, score, factor } = entry;
    try {
      const { result } = await this.#channel.request("score", { key, models, score, factor });
      entry.revision = result.revision;
    } catch (error) {
      if (error instanceof ConnectionLost) return this.#changed();
      this.#entries = this.#entries.filter((other) => other !== entry);
      this.#refused(/** @type {Error} */ (error));
    }
    this.#changed();
  }
}
