import { element, iconButton } from "../shared/element.js";

/** @typedef {import("./types.js").Control} Control */
/** @typedef {import("./types.js").State} State */

/** A colour of CGA, perhaps with transparency. */
const HEXADECIMAL = /^#[0-9a-f]{6}([0-9a-f]{2})?$/i;

/**
 * Sliders, menus, switches and fields of attributes.
 * @param {(name: string, value: string | null) => void} set a value; null for that of the file
 */
export function makeControls(set) {
  const list = element("div", { class: "gl-plain" });
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Attributes" },
    element("h2", {}, "Attributes"),
    list,
  );
  let drawn = "";
  /** @type {ReturnType<typeof makeRow>[]} */
  let rows = [];

  /** @param {State} state */
  function update({ controls, values }) {
    const now = JSON.stringify(controls);
    if (now !== drawn) {
      drawn = now;
      rows = controls.map((control) => makeRow(control, set));
      list.replaceChildren(...withGroups(rows));
    }
    section.hidden = !controls.length;
    for (const { control, show } of rows) show(values[control.name] ?? control.value, control.name in values);
  }

  return { element: section, update };
}

/** @param {{ control: Control, element: HTMLElement }[]} rows */
function withGroups(rows) {
  let group = "";
  return rows.flatMap(({ control, element: row }) => {
    const heading = control.group && control.group !== group ? [element("h3", {}, control.group)] : [];
    group = control.group;
    return [...heading, row];
  });
}

/** @param {Control} control @param {(name: string, value: string | null) => void} set */
function makeRow(control, set) {
  const { name, label } = control;
  const give = (/** @type {string} */ value) => set(name, value);
  const field = makeField(control, give);
  const reset = iconButton("undo", `${label}: as in the file`, () => set(name, null));
  return {
    control,
    element: element(
      "div",
      { class: "wa-row" },
      element("span", { class: "wa-label", title: name }, label),
      ...field.elements,
      reset,
    ),
    /** @param {string} value @param {boolean} own whether it differs from the file */
    show(value, own) {
      reset.style.visibility = own ? "visible" : "hidden";
      field.show(value);
    },
  };
}

/** @param {Control} control @param {(value: string) => void} give */
function makeField({ kind, label, choices, low, high, step }, give) {
  if (kind === "switch") {
    const box = element("input", {
      type: "checkbox",
      "aria-label": label,
      onchange: () => give(String(box.checked)),
    });
    return { elements: [box], show: (/** @type {string} */ value) => void (box.checked = value === "true") };
  }
  if (kind === "menu") {
    const options = ["", ...choices].map((value) => element("option", { value, hidden: !value }, value || "as drawn"));
    const menu = element(
      "select",
      { class: "gl-input", "aria-label": label, onchange: () => give(menu.value) },
      ...options,
    );
    return { elements: [menu], show: (/** @type {string} */ value) => void (menu.value = value) };
  }
  const typed = element("input", {
    class: kind === "number" ? "gl-input wa-number" : "gl-input",
    type: kind === "number" ? "number" : "text",
    step: "any",
    placeholder: "drawn",
    "aria-label": label,
    onchange: () => typed.value && give(typed.value),
  });
  if (kind === "color") return makeColor(label, typed, give);
  const isSlider = kind === "number" && low !== null && high !== null && high > low;
  if (!isSlider) return { elements: [typed], show: (/** @type {string} */ value) => showUnlessTyping(typed, value) };
  const slider = element("input", {
    class: "wa-slider",
    type: "range",
    min: low,
    max: high,
    step: step && step > 0 ? step : "any",
    "aria-label": `${label}, slider`,
  });
  slider.addEventListener("input", () => {
    const value = String(Number(slider.valueAsNumber.toPrecision(4)));
    typed.value = value;
    give(value);
  });
  return {
    elements: [slider, typed],
    show(/** @type {string} */ value) {
      showUnlessTyping(typed, value);
      if (!slider.matches(":focus")) slider.value = value || String((low + high) / 2);
    },
  };
}

/**
 * A palette beside the text of a colour, which may have transparency.
 * @param {string} label
 * @param {HTMLInputElement} typed
 * @param {(value: string) => void} give
 */
function makeColor(label, typed, give) {
  const palette = element("input", { class: "wa-color", type: "color", "aria-label": `${label}, palette` });
  palette.addEventListener("input", () => {
    typed.value = palette.value + rest(typed.value);
    give(typed.value);
  });
  return {
    elements: [palette, typed],
    show(/** @type {string} */ value) {
      showUnlessTyping(typed, value);
      if (HEXADECIMAL.test(value)) palette.value = value.slice(0, 7).toLowerCase();
    },
  };
}

/** The transparency of a colour, which a palette has not. @param {string} color */
function rest(color) {
  return HEXADECIMAL.test(color) ? color.slice(7) : "";
}

/** @param {HTMLInputElement} input @param {string} value */
function showUnlessTyping(input, value) {
  if (!input.matches(":focus")) input.value = value;
}
