import { element, iconButton } from "../shared/element.js";
import { choice, chooserButton, menu, textButton } from "../shared/menu.js";
import { ZOOMS } from "./display.js";
import { knownOf } from "./known.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {ReturnType<typeof import("./display.js").makeDisplay>} Display */

const SIZES = [
  { grids: 2, rows: 4, columns: 4, says: "to score" },
  { grids: 1, rows: 6, columns: 6, says: "to compare" },
  { grids: 2, rows: 6, columns: 6, says: "to score many" },
  { grids: 1, rows: 10, columns: 10, says: "to check the result" },
];

/**
 * The choice and the order of the visible models.
 * @param {Page} page
 * @param {Display} display
 * @param {{ pan: (on: boolean) => void }} pointer
 * @returns {import("./types.js").Part}
 */
export function makeToolbar(page, display, pointer) {
  const way = chooserButton("by");
  const size = chooserButton("Grid");
  const again = textButton("New models", () => void page.ask("new_models", { way: page.state.way }), {
    title: "Show other models, chosen by the method in the menu beside",
  });
  const compare = toggleButton("Compare", "Compare two models at a time (C)", page.pairwise);
  const sort = element("button", { type: "button", class: "gl-button gl-chooser" }, "Sort");
  const pan = toggle("hand", "Drag to pan", false, (on) => pointer.pan(on));
  const bars = toggle("bars", "Bars of predicted score and uncertainty", page.preferences.bars, (on) => {
    page.preferences.bars = on;
    display.fit();
  });
  const preview = toggle(
    "cube",
    "Show the model below the mouse large, and turning",
    page.preferences.preview,
    (on) => {
      page.preferences.preview = on;
    },
  );
  const bar = element(
    "div",
    { class: "gl-toolbar", role: "toolbar", "aria-label": "Display" },
    element("span", { class: "gl-joined" }, again, menu(way.button, "How models are chosen", buildWays)),
    compare,
    ...ofGrids(
      menu(sort, "Sort", (close) => buildSort(page, close)),
      menu(size.button, "Size of the grids", buildSizes),
      element("span", { class: "gl-space" }),
      legend(),
      element(
        "div",
        { class: "gl-row" },
        preview,
        bars,
        pan,
        iconButton("minus", "Zoom out", () => display.zoomBy(0.8)),
        zoomSlider(display),
        iconButton("fit", "Show all", () => display.zoomBy(0)),
        iconButton("plus", "Zoom in", () => display.zoomBy(1.25)),
      ),
    ),
  );

  /** @param {() => void} close */
  function buildWays(close) {
    return page.state.ways.map(({ name, label, says }) => {
      const show = () => {
        close();
        void page.ask("new_models", { way: name });
      };
      return choice(label, says, show, { checked: name === page.state.way });
    });
  }

  /** @param {() => void} close */
  function buildSizes(close) {
    const { grids, rows, columns } = page.state.layout;
    const lay = (/** @type {import("./types.js").Layout} */ layout) => {
      close();
      void page.ask("layout", layout);
    };
    const [many, high, wide] = [number("grids", grids, 2), number("rows", rows, 10), number("columns", columns, 10)];
    const own = element(
      "form",
      {
        class: "gl-row",
        onsubmit: (/** @type {Event} */ event) => {
          event.preventDefault();
          lay({ grids: many.valueAsNumber, rows: high.valueAsNumber, columns: wide.valueAsNumber });
        },
      },
      many,
      "of",
      high,
      "×",
      wide,
      element("button", { class: "gl-button" }, "Set"),
    );
    const presets = SIZES.map((each) => {
      const checked = each.grids === grids && each.rows === rows && each.columns === columns;
      return choice(nameOf(each), each.says, () => lay({ grids: each.grids, rows: each.rows, columns: each.columns }), {
        checked,
      });
    });
    return [...presets, element("hr"), own];
  }

  /** @param {State} state */
  function update(state) {
    way.set(state.ways.find(({ name }) => name === state.way)?.label ?? state.way);
    size.set(nameOf(state.layout));
    compare.ariaPressed = String(state.pairs !== null);
  }

  return { element: bar, update };
}

/** @param {Page} page @param {() => void} close */
function buildSort(page, close) {
  const chosen = page.selection.models;
  const sort = (/** @type {object} */ order) => {
    close();
    void page.ask("sort", order);
  };
  const found = element("div", { class: "gl-found", role: "group", "aria-label": "Features found" });
  const query = element("input", {
    class: "gl-input",
    type: "search",
    placeholder: "Search features",
    "aria-label": "Search features",
  });
  let turn = 0;
  const search = async () => {
    const mine = (turn += 1);
    const { features } = (await page.ask("features", { query: query.value })) ?? { features: [] };
    if (mine !== turn) return;
    query.disabled = features === null;
    if (features === null) {
      similar.disabled = true;
      found.replaceChildren(element("p", {}, "Not yet: the features of the models are being counted."));
      return;
    }
    const lines = features.map((/** @type {string} */ feature) =>
      choice(feature, "", () => sort({ by: "feature", feature })),
    );
    found.replaceChildren(...(lines.length ? lines : [element("p", {}, "No feature has this name.")]));
  };
  query.addEventListener("input", search);
  const similar = choice(
    "Similarity",
    chosen.length ? `to the ${chosen.length} selected` : "select models first",
    () => sort({ by: "similarity", models: chosen }),
    { disabled: !chosen.length },
  );
  const isLearned = Object.keys(page.state.models).some((model) => knownOf(page, model).predicted !== null);
  void search();
  return [
    choice("Predicted score", "highest first", () => sort({ by: "score" })),
    choice(
      "Uncertainty",
      isLearned ? "least known first" : "nothing has been learned yet",
      () => sort({ by: "uncertainty" }),
      { disabled: !isLearned },
    ),
    similar,
    choice("Random", "", () => sort({ by: "random" })),
    choice("As chosen", "the order in which they were chosen", () => sort({ by: "shown" })),
    element("hr"),
    query,
    found,
  ];
}

/** Parts that have no effect on pairs. @param {HTMLElement[]} parts */
function ofGrids(...parts) {
  for (const part of parts) part.classList.add("gl-of-grids");
  return parts;
}

/** @param {string} text @param {string} title @param {() => void} onclick */
function toggleButton(text, title, onclick) {
  const button = textButton(text, onclick, { title });
  button.ariaPressed = "false";
  return button;
}

/** The size of pictures, as a slider that the wheel moves as well. @param {Display} display */
function zoomSlider(display) {
  const slider = element("input", {
    class: "gl-zoom",
    type: "range",
    min: Math.log2(ZOOMS.least),
    max: Math.log2(ZOOMS.most),
    step: "any",
    title: "Size of pictures; also the wheel here, or Ctrl and the wheel on the pictures",
    "aria-label": "Size of pictures",
  });
  const show = () => {
    slider.value = String(Math.log2(display.zoom()));
    slider.ariaValueText = `${Math.round(100 * display.zoom())} %`;
  };
  slider.addEventListener("input", () => display.zoomBy(2 ** slider.valueAsNumber / display.zoom()));
  slider.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      display.zoomBy(event.deltaY < 0 ? 1.12 : 1 / 1.12);
    },
    { passive: false },
  );
  display.whenZoomed(show);
  show();
  return slider;
}

/** What the bars mean. */
function legend() {
  const key = (/** @type {string} */ name, /** @type {string} */ text) =>
    element("span", { class: `gl-key ${name}` }, element("i"), text);
  return element("span", { class: "gl-legend" }, key("gl-predicted", "predicted"), key("gl-uncertain", "uncertain"));
}

/** @param {import("./types.js").Layout} layout */
function nameOf({ grids, rows, columns }) {
  return `${grids > 1 ? `${grids} of ` : ""}${rows} × ${columns}`;
}

/** @param {string} name @param {number} value @param {number} max */
function number(name, value, max) {
  return element("input", {
    class: "gl-input gl-number",
    type: "number",
    min: "1",
    max: String(max),
    required: true,
    value: String(value),
    "aria-label": name,
  });
}

/**
 * @param {Parameters<typeof iconButton>[0]} picture
 * @param {string} label
 * @param {boolean} on
 * @param {(on: boolean) => void} changed
 */
function toggle(picture, label, on, changed) {
  const button = iconButton(picture, label, () => {
    const now = button.ariaPressed !== "true";
    button.ariaPressed = String(now);
    changed(now);
  });
  button.ariaPressed = String(on);
  return button;
}
