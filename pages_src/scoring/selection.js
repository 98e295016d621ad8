/**
 * The selected models among the visible ones, and the position of the keyboard.
 *
 * Models are counted through all grids: a position is an index into `order`. A model in two grids is one
 * model with two positions.
 */
export class Selection {
  /** @type {string[]} */
  order = [];
  /** @type {Set<string>} */
  chosen = new Set();
  /** Position of the keyboard. */
  cursor = 0;
  /** Position where a range begins. */
  #anchor = 0;
  #changed;
  /** Whether the keyboard goes to the first model once others are shown. */
  #anew = false;
  /** Whether what is chosen has got its score. */
  #done = false;

  /** @param {() => void} changed */
  constructor(changed) {
    this.#changed = changed;
  }

  /** The models chosen, in the order shown. */
  get models() {
    return [...new Set(this.order)].filter((model) => this.chosen.has(model));
  }

  /** @returns {string | undefined} */
  get current() {
    return this.order[this.cursor];
  }

  /** Goes to the first model once others are shown. @returns {boolean} whether it did not wait for them before */
  startAnew() {
    const waited = this.#anew;
    this.#anew = true;
    return !waited;
  }

  /**
   * Shows other models, or the same in another order.
   * @param {string[]} order
   * @returns {boolean} whether it begins anew, at the first model
   */
  show(order) {
    if (this.#anew && order.length && !order.includes(this.order[this.cursor])) {
      this.order = order;
      this.#anew = false;
      this.only(0);
      return true;
    }
    const follow = (/** @type {number} */ position) => {
      const found = order.indexOf(this.order[position]);
      return found >= 0 ? found : Math.min(position, Math.max(order.length - 1, 0));
    };
    [this.cursor, this.#anchor] = [follow(this.cursor), follow(this.#anchor)];
    this.order = order;
    const done = this.#done;
    this.#set(order.filter((model) => this.chosen.has(model)));
    this.#done = done;
    return false;
  }

  /** Shows a pair to compare, without a selection. @param {string[]} models */
  follow(models) {
    if (models.join() === this.order.join()) return;
    this.order = models;
    this.cursor = this.#anchor = 0;
    this.chosen = new Set();
  }

  /** @param {number} position */
  only(position) {
    this.cursor = this.#anchor = position;
    this.#set([this.order[position]]);
  }

  /** Models have got their score; with it what is chosen, if it is among them. @param {string[]} models */
  done(models) {
    if ([...this.chosen].every((model) => models.includes(model))) this.#done = true;
  }

  /** Of fingers: one after the other is chosen, until they get a score; the next one is chosen alone. @param {number} position */
  touch(position) {
    if (this.#done) this.only(position);
    else this.toggle(position);
  }

  /** @param {number} position */
  toggle(position) {
    this.cursor = this.#anchor = position;
    const model = this.order[position];
    const without = [...this.chosen].filter((other) => other !== model);
    this.#set(this.chosen.has(model) ? without : [...without, model]);
  }

  /** Selects from the last choice to a position. @param {number} position @param {boolean} keep what is chosen */
  rangeTo(position, keep) {
    this.cursor = position;
    const [first, last] = [this.#anchor, position].sort((a, b) => a - b);
    const range = this.order.slice(first, last + 1);
    this.#set(keep ? [...this.chosen, ...range] : range);
  }

  /** Moves the keyboard, without a change of the selection. @param {number} position */
  moveTo(position) {
    this.cursor = position;
    this.#changed();
  }

  all() {
    this.#set(this.order);
  }

  none() {
    this.#set([]);
  }

  /** @param {Iterable<string>} models */
  replace(models) {
    this.#set(models);
  }

  /** @param {Iterable<string>} models */
  #set(models) {
    this.chosen = new Set(models);
    this.#done = false;
    this.#changed();
  }
}
