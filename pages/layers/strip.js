import { element } from "../shared/element.js";
import { paint, sharp } from "../stage/paint.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").Layout} Layout */

const ROOM = { width: 196, height: 100 }; // pixels of a picture

/**
 * The best layouts beside each other, as small pictures that follow the canvas.
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
    const widest = Math.max(...page.layouts.map(({ width }) => width));
    const highest = Math.max(...page.layouts.map(({ height }) => height));
    const scale = Math.min(ROOM.width / widest, ROOM.height / highest);
    tiles.forEach(({ tile, canvas, words, told }, number) => {
      const layout = page.layouts[number];
      tile.hidden = !layout;
      if (!layout) return;
      tile.setAttribute("aria-pressed", String(number === page.chosen));
      words.textContent = countersOf(layout);
      told.textContent = `energy ${layout.energy.toPrecision(3)}`;
      tile.title = `${countersOf(layout)}: energy ${layout.energy.toPrecision(4)}${layout.proven ? ", proven" : ""}`;
      const [w, h] = [layout.width * scale, layout.height * scale];
      Object.assign(canvas.style, { width: `${w}px`, height: `${h}px` });
      const { context, ratio } = sharp(canvas, w, h);
      const view = { left: 0, bottom: canvas.height, scale: scale * ratio };
      paint(context, layout, { images: [], colors: layout.colors }, view);
    });
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
