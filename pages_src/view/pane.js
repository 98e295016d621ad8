import { element } from "../shared/element.js";
import { show } from "../viewer/viewer.js";
import { makeTree } from "../shared/tree.js";
import { makeExamples } from "./examples.js";

/** @typedef {import("./types.js").Run} Run */
/** @typedef {import("./types.js").Model} Model */

/**
 * One run: its model in 3D, with numbers and tree.
 * @param {Run} run
 * @param {{ damping: boolean, moved: (pose: any) => void, say: (text: string) => void, complain: (error: unknown) => void }} options
 */
export function makePane(run, { damping, moved, say, complain }) {
  const canvas = element("canvas", {
    class: "gl-canvas",
    tabIndex: 0,
    role: "application",
    "aria-label": `${run.name} in 3D: Shift with arrows turns, + and − zoom`,
  });
  const picked = element("span", { class: "vi-picked", role: "status" });
  const tree = makeTree(([, symbol]) => mark(symbol));
  const title = element("h2", { class: "vi-title" });
  const facts = element("dl", { class: "vi-facts" });
  const examples = makeExamples(run, say);
  /** @type {ReturnType<typeof show> | null} */
  let view = null;
  new ResizeObserver(() => view?.resize()).observe(canvas);

  /** @param {string} symbol of the clicked part */
  function find(symbol) {
    tree.go(tree.rowOf(symbol));
    mark(symbol);
  }

  /** @param {string} symbol */
  function mark(symbol) {
    view?.markNamed(symbol);
    picked.textContent = symbol ? `${symbol}: shown in green` : "";
  }

  return {
    room: element("div", { class: "gl-room vi-room" }, canvas, element("div", { class: "vi-caption" }, title, picked)),
    side: element(
      "section",
      { class: "gl-card", "aria-label": run.name },
      element("h2", {}, run.name),
      run.leftOut ? element("p", { class: "gl-hint" }, leftOut(run)) : null,
      facts,
      examples.element,
      tree.element,
    ),
    canvas,
    /** @param {number} index */
    has: (index) => run.models.some((model) => model.index === index),
    view: () => view,
    toggleExample: examples.toggle,
    /** @param {number} index of a model */
    async show(index) {
      const model = run.models.find((one) => one.index === index);
      title.textContent = model ? `${run.name}: model ${index}` : `${run.name}: model ${index} is not in this page`;
      facts.replaceChildren(...(model ? factsOf(model) : []));
      examples.show(model ? index : null);
      tree.show(model?.tree ?? []);
      picked.textContent = "";
      if (!model) return view?.clear();
      try {
        view ??= show(canvas, { damping, moved, named: find });
        await view.load(await unpacked(model.glb));
        canvas.dataset.shown = String(index);
      } catch (error) {
        complain(error);
      }
    },
  };
}

/** @param {Run} run */
function leftOut({ leftOut, models }) {
  const those = leftOut === 1 ? "one model is" : `${leftOut.toLocaleString()} models are`;
  return `${those} not in this page, which would be too large, or not finished; it has ${models.length.toLocaleString()}.`;
}

/** @param {Model} model */
function factsOf({ seed, shapes, triangles, reports }) {
  const facts = { seed, shapes: shapes.toLocaleString(), triangles: triangles.toLocaleString() };
  for (const [key, sum] of Object.entries(reports)) Object.assign(facts, { [key]: sum.toLocaleString() });
  return Object.entries(facts).flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]);
}

/** @param {string} text base64 of a gzip */
async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
}
