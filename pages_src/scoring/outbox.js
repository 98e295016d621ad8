import { ConnectionLost } from "../shared/channel.js";

/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {import("./types.js").Said} Said */
/** @typedef {import("./types.js").Verdict} Verdict */
/**
 * @typedef {object} Entry one act of scoring or comparing
 * @property {string} key the same however often it is sent, so that Python stores it once
 * @property {string[]} models
 * @property {Said | null} said null for a comparison
 * @property {Verdict | null} verdict of a comparison
 * @property {number} factor id of the factor that the person saw
 * @property {number} since when it was given, ms
 * @property {number} [revision] of the session, once it is saved
 */

/**
 * Unacknowledged scores. A score stays here until Python reports that it is on disk, even if connections are lost. Only a
 * refusal removes it earlier, and the page reports that.
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

  /** @param {string[]} models @param {Said} said @param {number} factor */
  add(models, said, factor) {
    this.#put({ models, said, verdict: null, factor });
  }

  /** @param {string[]} models two of them @param {Verdict | null} verdict @param {number} factor */
  compare(models, verdict, factor) {
    this.#put({ models, said: null, verdict, factor });
  }

  /** @param {Omit<Entry, "key" | "since">} act */
  #put(act) {
    const key = Math.random().toString(36).slice(2) + Date.now().toString(36);
    const entry = { ...act, key, since: performance.now() };
    this.#entries.push(entry);
    this.#changed();
    void this.#send(entry);
  }

  /** After a reconnection: everything that was not acknowledged, in the order it was given. */
  resend() {
    for (const entry of this.#unsaved) void this.#send(entry);
  }

  /** Python's state includes all events up to a revision, so they are removed here. @param {number} revision */
  settle(revision) {
    this.#entries = this.#entries.filter((entry) => entry.revision === undefined || entry.revision > revision);
  }

  /** Number of scores and comparisons that are not on disk. */
  get unsaved() {
    return this.#unsaved.reduce((sum, { said, models }) => sum + (said ? models.length : 1), 0);
  }

  /** Milliseconds since the oldest score that is not on disk. */
  get waiting() {
    const [oldest] = this.#unsaved;
    return oldest ? performance.now() - oldest.since : 0;
  }

  /**
   * The unacknowledged score of a model, newer than the one of Python.
   * @param {string} model
   * @param {number} factor
   * @returns {Said & { saved: boolean } | undefined}
   */
  find(model, factor) {
    const entry = this.#entries.findLast((each) => each.said && each.factor === factor && each.models.includes(model));
    return entry?.said ? { ...entry.said, saved: entry.revision !== undefined } : undefined;
  }

  /**
   * What was said of a pair here, newer than what Python told.
   * @param {string[]} models
   * @param {number} factor
   * @returns {{ said: Verdict | null, saved: boolean } | undefined}
   */
  findPair(models, factor) {
    const entry = this.#entries.findLast(
      (each) => !each.said && each.factor === factor && each.models.join() === models.join(),
    );
    return entry && { said: entry.verdict, saved: entry.revision !== undefined };
  }

  get #unsaved() {
    return this.#entries.filter((entry) => entry.revision === undefined);
  }

  /** @param {Entry} entry */
  async #send(entry) {
    const { key, factor } = entry;
    const [command, rest] = entry.said
      ? ["score", { models: entry.models, ...entry.said }]
      : ["compare", comparison(entry.models, entry.verdict)];
    try {
      const { result } = await this.#channel.request(command, { key, factor, ...rest });
      entry.revision = result.revision;
    } catch (error) {
      if (error instanceof ConnectionLost) return this.#changed();
      this.#entries = this.#entries.filter((other) => other !== entry);
      this.#refused(/** @type {Error} */ (error));
    }
    this.#changed();
  }
}

/** As Python wants it: the model that is preferred comes first. @param {string[]} models @param {Verdict | null} verdict */
function comparison(models, verdict) {
  if (verdict === null) return { models, kind: null };
  return { models: verdict === "second" ? models.toReversed() : models, kind: verdict === "alike" ? "tie" : "rather" };
}
