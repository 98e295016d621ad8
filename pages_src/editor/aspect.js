import { element } from "../shared/element.js";

/**
 * Fields for the least and largest width / height.
 * @param {(least: number, most: number) => Promise<any>} typed returns nothing if the range is refused
 * @param {HTMLElement} lock
 */
export function aspectRow(typed, lock) {
  let [least, most] = [0, 0];
  const low = field("Least part width to height", () => give(low, (value) => [value, Math.max(value, most)]));
  const high = field("Largest part width to height", () => give(high, (value) => [Math.min(value, least), value]));

  /** The other bound moves if necessary. @param {HTMLInputElement} input @param {(value: number) => number[]} range */
  async function give(input, range) {
    const [from, to] = range(Number(input.value));
    if (!(from > 0) || !(await typed(from, to))) show();
  }

  function show() {
    low.value = least.toFixed(2);
    high.value = most.toFixed(2);
  }

  return {
    element: element(
      "div",
      { class: "gl-row" },
      element("span", { class: "fe-unit" }, "Width / height"),
      element("span", { class: "gl-space" }),
      low,
      "to",
      high,
      lock,
    ),
    /** @param {number[]} range */
    set(range) {
      [least, most] = range;
      show();
    },
  };
}

/** @param {string} label for screen readers @param {() => void} typed */
function field(label, typed) {
  return element("input", {
    class: "gl-input fe-number fe-ratio",
    type: "number",
    min: "0",
    step: "any",
    "aria-label": label,
    onchange: typed,
  });
}
