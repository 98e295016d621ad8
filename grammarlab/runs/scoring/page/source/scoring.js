import { element, icon } from "./element.js";
import { knownOf, shortly } from "./known.js";
import { textButton } from "./menu.js";

/** @typedef {import("./types.js").Page} Page */

const STEPS = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100];

/**
 * One score for all that is selected: typed, by slider or by a step.
 * @param {Page} page
 * @param {() => void} backToGrid
 */
export function makeScoring(page, backToGrid) {
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
  const steps = STEPS.map((score) =>
    textButton(String(score), () => give(score), {
      class: "gl-step",
      title: score === 100 ? "key H" : `key ${score / 10}`,
    }),
  );
  const clear = textButton("No score", () => give(null), {
    title: "Take the score away (Delete)",
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
    element("button", { class: "gl-button" }, "Set"),
    element("span", { class: "gl-space" }),
    clear,
  );

  slider.addEventListener("input", () => void (number.value = slider.value));
  slider.addEventListener("change", () => give(slider.valueAsNumber));

  const controls = element(
    "fieldset",
    { class: "gl-plain" },
    element("div", { class: "gl-steps", role: "group", "aria-label": "Score of the selected models" }, ...steps),
    slider,
    form,
  );
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Score" },
    element("div", { class: "gl-row" }, heading, count, element("span", { class: "gl-space" }), look),
    controls,
    element("label", { class: "gl-check" }, advance, "after a key, go on to the next model"),
  );

  /** @param {number | null} score */
  function give(score) {
    page.score(page.selection.models, score);
  }

  function update() {
    const chosen = page.selection.models;
    const scores = new Set(chosen.map((model) => knownOf(page, model).score));
    const [shared] = scores.size === 1 ? scores : [null];
    const product = page.state.view === "product";
    const words = product ? "choose a factor first" : chosen.length ? `${chosen.length} selected` : "select models";
    if (count.textContent !== words) count.textContent = words;
    look.disabled = chosen.length === 0;
    controls.disabled = look.disabled || product;
    if (focused() !== number) number.value = shared === null ? "" : shortly(shared);
    number.placeholder = scores.size > 1 ? "mixed" : "0–100";
    if (focused() !== slider) slider.value = String(shared ?? 50);
    slider.classList.toggle("gl-unset", shared === null);
    steps.forEach((button, index) => button.classList.toggle("gl-on", shared === STEPS[index]));
  }

  /** Where the keyboard is, also where a notebook keeps its outputs in a shadow tree. */
  function focused() {
    return /** @type {Document | ShadowRoot} */ (section.getRootNode()).activeElement;
  }

  function typeScore() {
    if (controls.disabled) return;
    number.focus();
    number.select();
  }

  return { element: section, update, typeScore };
}
