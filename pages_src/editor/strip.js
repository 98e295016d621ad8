import { element } from "../shared/element.js";
import { paintSmall } from "../stage/paint.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").Drawing} Drawing */
/** @typedef {Drawing & { words: string, told: string[] }} Variation */

const KINDS = [
  { name: "One column more", axis: "x", change: 1 },
  { name: "One column less", axis: "x", change: -1 },
  { name: "One row more", axis: "y", change: 1 },
  { name: "One row less", axis: "y", change: -1 },
];
const ROOM = { width: 196, height: 104 }; // pixels of a picture
const AT_ONCE = 12;

/**
 * Variations of the active grid, as pictures of the facade after each.
 * @param {Page} page
 */
export function makeStrip(page) {
  let kind = KINDS[0];
  let most = AT_ONCE;
  let shown = ""; // for what
  /** @type {{ variation: Variation, canvas: HTMLCanvasElement }[]} */
  let tiles = [];
  const list = element("div", { class: "fe-strip", role: "group", "aria-label": "Variations" });
  const about = element("p", { class: "fe-about", role: "status" });
  const tabs = KINDS.map((each) =>
    element("button", { type: "button", class: "gl-tab", onclick: () => choose(each) }, each.name),
  );

  /** @param {typeof kind} each */
  function choose(each) {
    kind = each;
    most = AT_ONCE;
    update();
  }

  function update() {
    tabs.forEach((tab, index) => tab.setAttribute("aria-pressed", String(KINDS[index] === kind)));
    const { active, revision } = page.state;
    const wanted = JSON.stringify([active, revision, KINDS.indexOf(kind), most]);
    if (wanted === shown) return;
    shown = wanted;
    list.classList.add("fe-old");
    about.textContent = active ? "Computing variations…" : "";
    if (!active)
      return show([], 0, "Draw a rectangle around some windows to make a grid. Its variations will appear here.");
    page.channel.request("vary", { axis: kind.axis, change: kind.change, most }).then(
      ({ result, buffers }) => {
        if (wanted !== shown) return;
        const found = result.variations.map((/** @type {Variation} */ each, /** @type {number} */ number) => ({
          ...each,
          columns: new Float64Array(buffers[number]),
        }));
        show(found, result.total, result.none);
      },
      (error) => wanted === shown && show([], 0, error.message),
    );
  }

  /** @param {Variation[]} found @param {number} total @param {string} none */
  function show(found, total, none) {
    list.classList.remove("fe-old");
    tiles = found.map((variation) => ({
      variation,
      canvas: element("canvas", { class: "fe-small", "aria-hidden": "true" }),
    }));
    const held = [...list.children].findIndex((each) => each === document.activeElement);
    list.replaceChildren(...tiles.map(tile));
    // New pictures do not take the keyboard away.
    if (held >= 0) /** @type {HTMLElement | undefined} */ (list.children[Math.min(held, tiles.length - 1)])?.focus();
    if (total > found.length && most < 60)
      list.append(
        element(
          "button",
          { type: "button", class: "gl-button fe-more", onclick: more },
          `${total - found.length} more`,
        ),
      );
    about.textContent = none;
    draw();
  }

  function more() {
    most = 60;
    update();
  }

  /** @param {typeof tiles[number]} tile @param {number} number */
  function tile({ variation, canvas }, number) {
    const { words, told, width, height } = variation;
    const size = `${width.toFixed(2)} × ${height.toFixed(2)} m`;
    return element(
      "button",
      {
        type: "button",
        class: `fe-tile${told.length ? " fe-flawed" : ""}`,
        title: [words, size, ...told].join("\n"),
        "aria-label": [words, size, ...told].join(", "),
        onclick: () => void page.ask("accept", { number }),
      },
      canvas,
      element("span", { class: "fe-words" }, words),
      element("small", {}, told.length ? "incomplete" : size),
    );
  }

  function draw() {
    const looks = { images: page.pictures.images, colors: page.state.colors };
    paintSmall(
      tiles.map(({ variation, canvas }) => ({ canvas, drawing: variation, looks })),
      ROOM,
    );
  }

  function first() {
    /** @type {HTMLElement | null} */ (list.querySelector("button"))?.focus();
  }

  return {
    element: element(
      "section",
      { class: "fe-variations", "aria-label": "Variations of the active grid" },
      element(
        "div",
        { class: "gl-row gl-wrap fe-kinds", role: "group", "aria-label": "Kind of variation" },
        ...tabs,
        about,
      ),
      list,
    ),
    update,
    draw,
    first,
    /** Asks anew. */
    again() {
      shown = "";
      update();
    },
  };
}
