import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";

const MODELS = 16;

/**
 * Sixteen models of the seed as pictures; a click shows one large.
 * @param {() => void} ask for pictures
 * @param {(model: number) => void} choose
 */
export function makeSheet(ask, choose) {
  /** @type {string[]} */
  const urls = [];
  const tiles = Array.from({ length: MODELS }, (_, model) =>
    element("button", {
      type: "button",
      class: "wa-tile",
      "aria-label": `Model ${model}`,
      title: `Model ${model}`,
      onclick: () => choose(model),
    }),
  );
  const grid = element(
    "div",
    { class: "wa-sheet", role: "group", "aria-label": "Sixteen models", hidden: true },
    ...tiles,
  );
  const button = textButton("Sheet of sixteen", draw, { title: "Draw the first sixteen models of this seed (S)" });

  function draw() {
    for (const tile of tiles) tile.replaceChildren();
    for (const url of urls.splice(0)) URL.revokeObjectURL(url);
    grid.hidden = false;
    ask();
  }

  return {
    element: element("section", { class: "gl-card", "aria-label": "Sheet" }, button, grid),
    draw,
    /** @param {number} model that is shown large */
    mark: (model) => tiles.forEach((tile, at) => tile.setAttribute("aria-pressed", String(at === model))),
    /** @param {number} model @param {ArrayBuffer} bytes of its picture */
    take(model, bytes) {
      const url = URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" }));
      urls.push(url);
      tiles[model].replaceChildren(element("img", { src: url, alt: "" }));
    },
  };
}
