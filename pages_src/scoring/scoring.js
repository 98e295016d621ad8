import { element, icon } from "../shared/element.js";
import { knownOf } from "./known.js";
import { textButton } from "../shared/menu.js";
import { makeSteps, nextScale, SCALES, scaleOf, shortly } from "../shared/scale.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").Scale} Scale */
/** @typedef {import("./types.js").Said} Said */

/**
 * One score for all that is selected, on the scale of choice: typed, by slider or by a step.
 * @param {Page} page
 * @param {() => void} backToGrid
 * @param {() => void} focusModels
 */
export function makeScoring(page, backToGrid, focusModels) {
  const heading = element("h2", {}, "Score");
  const count = element("p", { class: "gl-count", role: "status" });
  const number = element("input", {
    class: "gl-input gl-typed",
    type: "number",
    min: "0",
    max: "100",
    step: "any",
    "aria-label": "Score of the selected models, 0 to 100",
    title: "S",
  });
  const slider = element("input", {
    class: "gl-slider",
    type: "range",
    min: "0",
    max: "100",
    "aria-label": "Score of the selected models",
  });
  const steps = makeSteps(page, "Score of the selected models", give);
  const scales = Object.entries(SCALES).map(([scale, { name }]) =>
    textButton(name, (event) => chosenBy(event, /** @type {Scale} */ (scale)), {
      class: "gl-scale",
      title: "T: next scale",
    }),
  );
  const clear = textButton("No score", () => give(null), {
    title: "Remove the score (Delete)",
    class: "gl-button gl-quiet",
  });
  const look = element(
    "button",
    {
      type: "button",
      class: "gl-button gl-quiet",
      title: "Enter, or double click",
      onclick: () => page.look(page.selection.models[0]),
    },
    icon("cube"),
    "3D view",
  );
  const advance = element("input", {
    type: "checkbox",
    checked: page.preferences.advance,
    onchange: () => void (page.preferences.advance = advance.checked),
  });
  const set = element("button", { class: "gl-button" }, "Set");
  const form = element(
    "form",
    {
      class: "gl-row",
      onsubmit: (/** @type {Event} */ event) => {
        event.preventDefault();
        if (number.value === "" || !number.reportValidity()) return;
        give(number.valueAsNumber);
        number.value = "";
        backToGrid();
      },
    },
    number,
    set,
    element("span", { class: "gl-space" }),
    clear,
  );

  slider.addEventListener("input", () => void (number.value = slider.value));
  slider.addEventListener("change", () => give(slider.valueAsNumber));

  const controls = element("fieldset", { class: "gl-plain" }, steps.element, slider, form);
  const section = element(
    "section",
    { class: "gl-card gl-scoring", "aria-label": "Score" },
    element("div", { class: "gl-row" }, heading, count, element("span", { class: "gl-space" }), look),
    element("div", { class: "gl-row gl-scales", role: "group", "aria-label": "Scale" }, ...scales),
    controls,
    element("label", { class: "gl-check" }, advance, "after a key, go on to the next model"),
  );

  /** @param {number | null} score */
  function give(score) {
    page.score(page.selection.models, score);
  }

  function update() {
    const chosen = page.selection.models;
    const said = new Map(chosen.map((model) => sayingOf(knownOf(page, model))));
    /** @type {Said} */
    const shared = (said.size === 1 && [...said.values()][0]) || { score: null, kind: null };
    const scale = scaleOf(page);
    const plain = scale === "score" && shared.kind !== "stars" && shared.kind !== "thumb" ? shared.score : null;
    for (const part of [number, set, slider]) part.hidden = scale !== "score";
    scales.forEach((button, index) => (button.ariaPressed = String(Object.keys(SCALES)[index] === scale)));
    const product = page.state.view === "product";
    const words = product ? "choose a factor first" : chosen.length ? `${chosen.length} selected` : "select models";
    if (count.textContent !== words) count.textContent = words;
    look.disabled = chosen.length === 0;
    controls.disabled = look.disabled || product;
    if (focused() !== number) number.value = shortly({ score: plain, kind: "score" });
    number.placeholder = said.size > 1 ? "mixed" : "0–100";
    if (focused() !== slider) slider.value = String(plain ?? 50);
    slider.classList.toggle("gl-unset", plain === null);
    steps.draw(shared);
  }

  /** The focused element, even if a notebook keeps its outputs in a shadow tree. */
  function focused() {
    return /** @type {Document | ShadowRoot} */ (section.getRootNode()).activeElement;
  }

  /** After a click the keys of the scale are for the models. @param {MouseEvent} event @param {Scale} scale */
  function chosenBy(event, scale) {
    choose(scale);
    if (event.detail) focusModels();
  }

  /** @param {Scale} scale */
  function choose(scale) {
    page.preferences.scale = scale;
    update();
  }

  function typeScore() {
    if (controls.disabled || number.hidden) return;
    number.focus();
    number.select();
  }

  return { element: section, update, typeScore, nextScale: () => choose(nextScale(page)) };
}

/** A text that is equal for equal statements. @param {Said} said @returns {[string, Said]} */
function sayingOf({ score, kind }) {
  return [`${kind} ${score}`, { score, kind }];
}
