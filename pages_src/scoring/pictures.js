/** @typedef {import("../shared/channel.js").Channel} Channel */
/** @typedef {{ url: string, size: number, models: string[] }} Sheet */
/** @typedef {{ sheet: Sheet, image: string, extent: string, place: string, size: number }} Picture */

const SHEETS_KEPT = 80;

/** Thumbnails, cut from the sprite sheets that Python sends as they are drawn. */
export class Pictures {
  #channel;
  #came;
  /** @type {Map<string, Picture>} */
  #known = new Map();
  /** @type {Map<string, number>} size asked for, where it is under way */
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
   * @param {string[]} models
   * @param {number} size pixels
   */
  want(models, size) {
    const large = new Set(models);
    this.#shown = new Set([...models, ...this.#kept]);
    const missing = [...this.#shown].filter(
      (model) => (this.#known.get(model)?.size ?? 0) < (large.has(model) ? size : 1),
    );
    if (!this.#channel.connected || missing.every((model) => (this.#asked.get(model) ?? 0) >= size)) return;
    this.#asked = new Map(missing.map((model) => [model, size]));
    this.#channel.request("pictures", { models: missing, size }).catch(() => this.askAgain());
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

  /** @param {{ models: string[], size: number, columns: number, rows: number }} message @param {ArrayBuffer} buffer */
  async #take({ models, size, columns, rows }, buffer) {
    const url = URL.createObjectURL(new Blob([buffer], { type: "image/jpeg" }));
    const picture = new Image();
    picture.src = url;
    await picture.decode().catch(() => {}); // so that the tile never flickers
    const sheet = { url, size, models };
    this.#sheets.add(sheet);
    models.forEach((model, index) => {
      if ((this.#known.get(model)?.size ?? 0) > size) return;
      const [column, row] = [index % columns, Math.floor(index / columns)];
      const place = `${percent(column, columns - 1)} ${percent(row, rows - 1)}`;
      this.#known.set(model, {
        sheet,
        image: `url("${url}")`,
        extent: `${columns * 100}% ${rows * 100}%`,
        place,
        size,
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
