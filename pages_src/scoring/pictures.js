/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {{ url: string, size: number, models: string[] }} Sheet */
/** @typedef {{ sheet: Sheet, image: string, extent: string, place: string, size: number, good: boolean }} Picture */

const SHEETS_KEPT = 80;

/** Thumbnails, cut from the sprite sheets that Python sends as they are drawn. */
export class Pictures {
  #channel;
  #came;
  /** @type {Map<string, Picture>} */
  #known = new Map();
  /** @type {Map<string, number>} rank asked for, where it is under way */
  #asked = new Map();
  /** @type {Set<Sheet>} */
  #sheets = new Set();
  /** @type {Set<string>} */
  #shown = new Set();
  /** @type {string[]} */
  #kept = [];

  /** @param {Channel} channel @param {() => void} came */
  constructor(channel, came) {
    this.#channel = channel;
    this.#came = came;
    channel.on("pictures", (message, [buffer]) => void this.#take(message, buffer));
  }

  /** Those that are shown beside others, in any size, from the next request on. @param {string[]} models */
  keep(models) {
    this.#kept = models;
  }

  /**
   * Asks for those that are not here in that size or better. A request replaces the one before it.
   * @param {string[]} models which are looked at
   * @param {number} size pixels
   * @param {string[]} [ahead] models that may be looked at soon: until then, quick pictures are enough
   */
  want(models, size, ahead = []) {
    const [quick, well] = [rankOf(size), rankOf(size, true)];
    /** @type {Map<string, number>} */
    const needed = new Map();
    for (const [names, rank] of /** @type {const} */ ([
      [models, well],
      [ahead, quick],
      [this.#kept, 1],
    ])) {
      for (const model of names) if (!needed.has(model)) needed.set(model, rank);
    }
    this.#shown = new Set(needed.keys());
    const missing = [...needed].filter(([model, rank]) => this.#rankOf(model) < rank);
    if (!this.#channel.connected || missing.every(([model, rank]) => (this.#asked.get(model) ?? 0) >= rank)) return;
    this.#asked = new Map(missing);
    const absent = missing.filter(([model, rank]) => this.#rankOf(model) < Math.min(rank, quick));
    const good = missing.filter(([, rank]) => rank === well);
    const asked = { models: absent.map(([model]) => model), good: good.map(([model]) => model), size };
    this.#channel.request("pictures", asked).catch(() => this.askAgain());
  }

  /** @param {string} model */
  #rankOf(model) {
    const known = this.#known.get(model);
    return known ? rankOf(known.size, known.good) : 0;
  }

  /** After a reconnection nobody works on what was asked before. */
  askAgain() {
    this.#asked.clear();
  }

  /** @param {string} model */
  find(model) {
    return this.#known.get(model);
  }

  close() {
    for (const { url } of this.#sheets) URL.revokeObjectURL(url);
  }

  /**
   * @param {{ models: string[], good: boolean[], size: number, columns: number, rows: number }} message
   * @param {ArrayBuffer} buffer
   */
  async #take({ models, good, size, columns, rows }, buffer) {
    const url = URL.createObjectURL(new Blob([buffer], { type: "image/jpeg" }));
    const picture = new Image();
    picture.src = url;
    await picture.decode().catch(() => {}); // so that the tile never flickers
    const sheet = { url, size, models };
    this.#sheets.add(sheet);
    models.forEach((model, index) => {
      if (this.#rankOf(model) > rankOf(size, good[index])) return;
      const [column, row] = [index % columns, Math.floor(index / columns)];
      const place = `${percent(column, columns - 1)} ${percent(row, rows - 1)}`;
      this.#known.set(model, {
        sheet,
        image: `url("${url}")`,
        extent: `${columns * 100}% ${rows * 100}%`,
        place,
        size,
        good: good[index],
      });
    });
    this.#tidy();
    this.#came();
  }

  /** Lets go of old sheets of which nothing is shown. */
  #tidy() {
    for (const sheet of this.#sheets) {
      if (this.#sheets.size <= SHEETS_KEPT) return;
      const used = sheet.models.filter((model) => this.#known.get(model)?.sheet === sheet);
      if (used.some((model) => this.#shown.has(model))) continue;
      for (const model of used) this.#known.delete(model);
      URL.revokeObjectURL(sheet.url);
      this.#sheets.delete(sheet);
    }
  }
}

/** @param {HTMLElement} where @param {Picture | undefined} picture */
export function drawPicture(where, picture) {
  where.style.backgroundImage = picture?.image ?? "";
  where.style.backgroundSize = picture?.extent ?? "";
  where.style.backgroundPosition = picture?.place ?? "";
}

/** @param {number} part @param {number} whole */
function percent(part, whole) {
  return whole ? `${(100 * part) / whole}%` : "0";
}

/** Of two pictures the larger one is better, and of one size the good one. @param {number} size @param {boolean} [good] */
function rankOf(size, good = false) {
  return 2 * size - (good ? 0 : 1);
}
