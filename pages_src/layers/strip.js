import { element } from "../shared/element.js";
import { paintSmall } from "../stage/paint.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").Layout} Layout */

const ROOM = { width: 196, height: 100 }; // pixels of a picture

/**
 * The best layouts as small pictures that follow the canvas.
 * @param {Page} page
 */
export function makeStrip(page) {
  const list = element("div", { class: "fe-strip", role: "group", "aria-label": "Layouts, the best first" });
  /** @type {{ tile: HTMLButtonElement, canvas: HTMLCanvasElement, words: HTMLElement, told: HTMLElement }[]} */
  const tiles = [];

  /** @param {number} number */
  function makeTile(number) {
    const canvas = element("canvas", { class: "fe-small", "aria-hidden": "true" });
    const [words, told] = [element("span", { class: "fe-words" }), element("small")];
    const onclick = () => void page.ask("choose", { number });
    const tile = element("button", { type: "button", class: "fe-tile", onclick }, canvas, words, told);
    list.append(tile);
    tiles.push({ tile, canvas, words, told });
  }

  function update() {
    while (tiles.length < page.layouts.length) makeTile(tiles.length);
    tiles.forEach(({ tile, canvas, words, told }, number) => {
      const layout = page.layouts[number];
      tile.hidden = !layout;
      if (!layout) return;
      tile.setAttribute("aria-pressed", String(number === page.chosen));
      words.textContent = countersOf(layout);
      told.textContent = `energy ${layout.energy.toPrecision(3)}`;
      tile.title = `${countersOf(layout)}: energy ${layout.energy.toPrecision(4)}${layout.proven ? ", proven" : ""}`;
    });
    paintSmall(
      page.layouts.map((drawing, number) => ({
        canvas: tiles[number].canvas,
        drawing,
        looks: { images: [], colors: drawing.colors },
      })),
      ROOM,
    );
  }

  return {
    element: element("section", { class: "fe-variations", "aria-label": "Layouts" }, list),
    update,
    first: () => /** @type {HTMLElement | null} */ (list.querySelector("button:not([hidden])"))?.focus(),
  };
}

/** @param {Layout} layout */
export function countersOf({ counters }) {
  return Object.entries(counters)
    .map(([name, value]) => `${name} = ${value}`)
    .join(", ");
}
