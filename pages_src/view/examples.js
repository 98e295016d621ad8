import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Run} Run */

/**
 * Models of a run that are marked as good examples, and the options with which `learn` learns from them.
 * @param {Run} run
 * @param {(text: string) => void} say says what a key has changed, which screen readers do not see
 */
export function makeExamples(run, say) {
  /** @type {Set<number>} */
  const marked = new Set();
  let shown = -1;
  const box = element("input", {
    type: "checkbox",
    "aria-label": `a good example of ${run.name}`,
    onchange: () => set(box.checked),
  });
  const options = element("input", {
    class: "gl-input",
    readOnly: true,
    "aria-label": `Options of grammarlab learn for the examples of ${run.name}`,
    title: `Options of grammarlab learn, ${run.start}`,
    onfocus: () => options.select(),
  });
  const section = element(
    "div",
    { class: "vi-examples" },
    element("label", { class: "gl-check" }, box, "a good example"),
    options,
  );

  /** @param {boolean} isExample */
  function set(isExample) {
    if (isExample) marked.add(shown);
    else marked.delete(shown);
    draw();
  }

  function draw() {
    box.checked = marked.has(shown);
    options.hidden = marked.size === 0;
    options.value = `--examples ${run.folder} --models ${asRanges([...marked].sort((a, b) => a - b))}`;
  }

  return {
    element: section,
    /** Mark the shown model, or take its mark away. */
    toggle() {
      if (section.hidden) return;
      set(!box.checked);
      say(`${run.name}, model ${shown}: ${box.checked ? "a good example" : "no longer a good example"}`);
    },
    /** @param {number | null} index of the model that is shown now; none if the run does not have it */
    show(index) {
      section.hidden = index === null;
      shown = index ?? -1;
      draw();
    },
  };
}

/** Ascending numbers as text: `3,7,9-12`. @param {number[]} numbers */
function asRanges(numbers) {
  /** @type {[number, number][]} */
  const ranges = [];
  for (const number of numbers) {
    const last = ranges.at(-1);
    if (last && last[1] === number - 1) last[1] = number;
    else ranges.push([number, number]);
  }
  return ranges.map(([first, last]) => (first === last ? `${first}` : `${first}-${last}`)).join(",");
}
