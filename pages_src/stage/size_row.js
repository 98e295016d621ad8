import { element } from "../shared/element.js";

/** @param {string} title @param {HTMLElement[]} children */
export function card(title, ...children) {
  return element("div", { class: "gl-card" }, element("h2", {}, title), ...children);
}

/** @param {number} value */
export function metres(value) {
  return value.toFixed(2);
}

/**
 * A length that can be typed.
 * @param {string} name
 * @param {string} label for screen readers
 * @param {(metres: number) => Promise<any>} typed returns nothing if the length is refused
 * @param {HTMLElement[]} more elements after it
 */
export function sizeRow(name, label, typed, ...more) {
  let now = 0;
  const input = element("input", {
    class: "gl-input fe-number",
    type: "number",
    min: "0",
    step: "any",
    "aria-label": `${label} in metres`,
  });
  input.addEventListener("change", async () => {
    const value = Number(input.value);
    if (input.value === metres(now)) return;
    if (!(value >= 0) || !(await typed(value))) input.value = metres(now);
  });
  return {
    element: element(
      "label",
      { class: "gl-row" },
      element("span", { class: "fe-unit" }, name),
      element("span", { class: "gl-space" }),
      input,
      "m",
      ...more,
    ),
    /** @param {number} value */
    set(value) {
      now = value;
      if (document.activeElement !== input || input.value === "") input.value = metres(value);
    },
  };
}
