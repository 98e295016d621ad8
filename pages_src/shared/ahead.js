/**
 * Values that a person has set and Python has not confirmed yet: what is pressed next counts from them.
 *
 * An answer comes before the state that it leads to, so a value stays until the first state after its answer.
 */
export class Ahead {
  /** @type {Map<string, { value: any, answered: boolean }>} */
  #values = new Map();

  /**
   * What was set last, or else what is confirmed.
   * @template T
   * @param {string} key
   * @param {T} confirmed
   * @returns {T}
   */
  of(key, confirmed) {
    const set = this.#values.get(key);
    return set ? set.value : confirmed;
  }

  /** @param {string} key @param {unknown} value @param {Promise<unknown>} answer nothing if the value is refused */
  async set(key, value, answer) {
    const mine = { value, answered: false };
    this.#values.set(key, mine);
    const accepted = await answer;
    mine.answered = true;
    if (!accepted && this.#values.get(key) === mine) this.#values.delete(key);
  }

  /** A state was told. */
  told() {
    for (const [key, { answered }] of this.#values) if (answered) this.#values.delete(key);
  }
}
