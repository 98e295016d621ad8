import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { card, sizeRow } from "../stage/size_row.js";
import { countersOf } from "./strip.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").Flag} Flag */

/** @type {[Flag, string, string][]} */
const FLAGS = [
  ["opaque", "opaque", "covers all of its place"],
  ["attached", "attached", "its neighbours stay next to it"],
  ["unoccludable", "unoccl.", "nothing may cover only a part of it"],
  ["transparent", "transp.", "a placeholder that is never visible"],
];

/**
 * The canvas, counters, layers and symbols of the design, or its text.
 * @param {Page} page
 * @param {ReturnType<typeof import("./text.js").makeText>} text
 */
export function makePanel(page, text) {
  const width = sizeRow("Width", "width", (width) => page.ask("resize", { width, height: page.state.height }));
  const height = sizeRow("Height", "height", (height) => page.ask("resize", { width: page.state.width, height }));
  const counters = element("div", { class: "fl-counters", role: "status", "aria-label": "Counters" });
  const energy = element("p", { class: "gl-hint" });
  const layers = element("ul", { class: "fl-list", "aria-label": "Layers" });
  const symbols = element("div", { class: "fl-symbols", role: "group", "aria-label": "Symbols" });
  const design = element(
    "div",
    { class: "gl-plain" },
    card("Canvas", width.element, height.element),
    card("Counters", counters, energy),
    card("Layers, from the top down", layers),
    card("Symbols", symbols),
  );
  const tabs = [
    textButton("Design", () => choose(false), { class: "gl-button gl-tab" }),
    textButton("Text", () => choose(true), { class: "gl-button gl-tab" }),
  ];
  let asText = false;

  /** @param {boolean} text */
  function choose(text) {
    asText = text;
    update();
  }

  let drawn = "";
  function update() {
    tabs.forEach((tab, number) => tab.setAttribute("aria-pressed", String((number === 1) === asText)));
    design.hidden = asText;
    text.element.hidden = !asText;
    text.update();
    const layout = page.layouts[page.chosen];
    width.set(layout?.width ?? page.state.width);
    height.set(layout?.height ?? page.state.height);
    const now = layout ? countersOf(layout) : "";
    if (counters.textContent !== now.replaceAll(", ", ""))
      counters.replaceChildren(
        ...(now ? now.split(", ") : []).map((each) => element("span", { class: "fl-counter" }, each)),
      );
    energy.textContent = layout
      ? `Energy ${layout.energy.toPrecision(4)}, ${layout.proven ? "proven to be the least" : "not proven to be the least"}`
      : "";
    const { layers: found, symbols: known } = page.state;
    const what = JSON.stringify([found, known]);
    if (what !== drawn) drawDesign();
    drawn = what;
    for (const symbol of known) {
      const size = layout?.sizes[symbol.name];
      const told = sizes.get(symbol.name);
      if (told) told.textContent = size === undefined ? "–" : `${size.toFixed(2)} m`;
    }
  }

  /** @type {Map<string, Text>} */
  const sizes = new Map();
  function drawDesign() {
    const held = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.what : undefined;
    sizes.clear();
    layers.replaceChildren(...page.state.layers.map(layerOf));
    symbols.replaceChildren(...page.state.symbols.flatMap(symbolOf));
    // The pressed button keeps the focus.
    if (held) /** @type {HTMLElement | null} */ (design.querySelector(`[data-what=${CSS.escape(held)}]`))?.focus();
  }

  /** @param {import("./types.js").Layer} layer @param {number} number */
  function layerOf({ name, on, axes }, number) {
    const onchange = () => void page.ask("switch", { layer: number, on: box.checked });
    const box = element("input", { type: "checkbox", checked: on, onchange });
    box.dataset.what = `layer ${number}`;
    return element(
      "li",
      { class: on ? "" : "fl-off" },
      element("label", { class: "fl-head" }, box, element("span", { class: "fl-layer-name", title: name }, name)),
      ...axes.map(({ pattern, symbols, seen }, axis) =>
        element(
          "div",
          { class: "fl-axis", role: "group", "aria-label": `Visible symbols of ${name} along ${"xy"[axis]}` },
          element("code", { class: "fl-pattern", title: "xy"[axis] }, pattern),
          ...symbols.map((symbol) => {
            const shows = seen === null || seen.includes(symbol);
            const label = `${shows ? "Hide" : "Show"} ${symbol} of ${name}`;
            const [what, of] = [`mask ${number} ${axis} ${symbol}`, { layer: number, axis: "xy"[axis], symbol }];
            return chip(symbol, label, shows, what, () =>
              toggle(what, shows, (seen) => page.ask("mask", { ...of, seen })),
            );
          }),
        ),
      ),
    );
  }

  /** @param {string} what @param {boolean} confirmed @param {(value: boolean) => Promise<unknown>} ask */
  function toggle(what, confirmed, ask) {
    const value = !page.ahead.of(what, confirmed);
    void page.ahead.set(what, value, ask(value));
  }

  /** @param {import("./types.js").Symbol} symbol */
  function symbolOf(symbol) {
    const { name, size } = symbol;
    const now = new Text("–");
    sizes.set(name, now);
    const target = size === null ? "the rest" : `of ${Number(size.toFixed(3))} m`;
    return [
      element("span", { class: "fl-symbol" }, name),
      element("span", { class: "fl-size" }, now, element("small", {}, target)),
      element(
        "span",
        { class: "fl-flags" },
        ...FLAGS.map(([flag, short, says]) => {
          const what = `flag ${name} ${flag}`;
          const made = chip(short, `${name}: ${flag}, ${says}`, symbol[flag], what, () =>
            toggle(what, symbol[flag], (value) => page.ask("flag", { symbol: name, flag, value })),
          );
          made.classList.add("fl-flag");
          return made;
        }),
      ),
    ];
  }

  return {
    element: element(
      "section",
      { class: "gl-side fe-side fl-side", "aria-label": "Design" },
      element("div", { class: "fl-tabs", role: "group", "aria-label": "View of the design" }, ...tabs),
      design,
      text.element,
    ),
    update,
    /** Shows the text, and is ready for typing. */
    write() {
      choose(true);
      text.input.focus();
    },
  };
}

/**
 * @param {string} text
 * @param {string} label
 * @param {boolean} pressed
 * @param {string} what it is about, so that its successor is found
 * @param {() => void} onclick
 */
function chip(text, label, pressed, what, onclick) {
  const made = textButton(text, onclick, { class: "gl-button fl-chip", "aria-label": label, title: label });
  made.setAttribute("aria-pressed", String(pressed));
  made.dataset.what = what;
  return made;
}
