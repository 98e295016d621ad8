import { element } from "../shared/element.js";
import { inWords } from "./known.js";
import { drawPicture } from "./pictures.js";
import { shortly } from "../shared/scale.js";

/** @typedef {import("./pictures.js").Picture} Picture */
/** @typedef {import("./known.js").Known} Known */
/**
 * @typedef {Known & { model: string, picture: Picture | undefined, chosen: boolean, cursor: boolean }} Look
 * content of a tile; only changed parts of a tile are updated
 */

/** Standard deviation in points that fills the blue bar: equally many scores of 0 and 100 have 50. */
const WIDEST = 50;

/** One tile of a grid. */
export class Cell {
  #picture = element("div", { class: "gl-picture gl-empty" });
  #score = element("span", { class: "gl-score" });
  #predicted = bar("gl-predicted");
  #uncertain = bar("gl-uncertain");
  /** @type {Partial<Look>} */
  #look = {};

  element = element(
    "div",
    { class: "gl-cell", role: "option", tabindex: -1 },
    this.#picture,
    this.#score,
    element("div", { class: "gl-bars", "aria-hidden": "true" }, this.#predicted.element, this.#uncertain.element),
  );

  /** @param {Look} look */
  draw(look) {
    const before = this.#look;
    this.#look = look;
    if (look.model !== before.model) this.element.dataset.model = look.model;
    if (look.picture !== before.picture) this.#drawPicture(look.picture);
    if (look.score !== before.score || look.kind !== before.kind || look.saved !== before.saved) this.#drawScore(look);
    if (look.predicted !== before.predicted) this.#predicted.set(look.predicted, 100);
    if (look.uncertain !== before.uncertain) this.#uncertain.set(look.uncertain, WIDEST);
    if (look.chosen !== before.chosen) this.element.setAttribute("aria-selected", String(look.chosen));
    if (look.cursor !== before.cursor) this.element.tabIndex = look.cursor ? 0 : -1;
    const words = inWords(look);
    if (before.label === undefined || words !== inWords(/** @type {Look} */ (before))) this.element.ariaLabel = words;
  }

  /** @param {Picture | undefined} picture */
  #drawPicture(picture) {
    drawPicture(this.#picture, picture);
    this.#picture.classList.toggle("gl-empty", !picture);
  }

  /** @param {Look} look */
  #drawScore({ score, kind, saved }) {
    this.#score.textContent = shortly({ score, kind });
    this.#score.classList.toggle("gl-unsaved", !saved);
  }
}

/** @param {string} name */
function bar(name) {
  const fill = element("i");
  const number = element("b");
  return {
    element: element("div", { class: `gl-bar ${name}` }, element("span", {}, fill), number),
    /** @param {number | null} value @param {number} full */
    set(value, full) {
      fill.style.transform = `scaleX(${Math.min(Math.max((value ?? 0) / full, 0), 1)})`;
      // Not as text, since the name of the tile has it in words.
      number.dataset.value = value === null ? "" : String(Math.round(value));
    },
  };
}
