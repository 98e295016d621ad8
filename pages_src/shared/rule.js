import { element, iconButton } from "./element.js";

/**
 * @typedef {object} ModelPart a visible shape of a model
 * @property {number} number
 * @property {number} count parts of the model
 * @property {[number, number]} triangles its first one among those of the model, and the one after its last
 * @property {[string, string][]} path symbols from the initial shape down to it, with their places in the rule file
 */

const INVITATION = "Click a part of the model to see the rule that made it.";

/**
 * Which rule made a part of the model in the 3D view, and the symbols above it.
 * @param {import("./channel.js").Channel} channel
 * @param {(triangles: [number, number] | null) => void} mark shows which part is meant
 */
export function makeRule(channel, mark) {
  let model = "";
  let asked = 0;
  /** @type {ModelPart | null} */
  let part = null;
  /** Number of the part that is shown or was asked for; steps count from it. @type {number | null} */
  let number = null;
  /** Finds the part at a triangle, whose number is not known before. */
  let picking = Promise.resolve();
  const text = element("div", { class: "gl-rule-text", role: "status" });
  const panel = element(
    "section",
    { class: "gl-row gl-rule", "aria-label": "Rule of a part" },
    iconButton("previous", "Previous part", () => step(-1), "↑"),
    iconButton("next", "Next part", () => step(1), "↓"),
    text,
  );

  /** @param {string} id */
  function open(id) {
    model = id;
    clear();
  }

  /** Forgets the part. */
  function clear() {
    asked += 1;
    part = number = null;
    mark(null);
    text.replaceChildren(INVITATION);
  }

  /** The part that a triangle of the model belongs to; none for null. @param {number | null} triangle */
  function pick(triangle) {
    if (triangle === null) return clear();
    return (picking = ask({ triangle }));
  }

  /** @param {number} by */
  async function step(by) {
    await picking;
    number = number === null ? Math.min(by, 0) : number + by;
    return ask({ part: number });
  }

  /** @param {{ triangle: number } | { part: number }} which */
  async function ask(which) {
    const turn = ++asked;
    if (!part) text.replaceChildren("looking…");
    try {
      const { result } = await channel.request("part", { model, ...which });
      if (turn !== asked) return;
      part = /** @type {ModelPart} */ (result);
      number = part.number;
      mark(part.triangles);
      text.replaceChildren(...inWords(part));
    } catch (error) {
      if (turn !== asked) return;
      number = part ? part.number : null;
      text.replaceChildren(`No rule: ${error instanceof Error ? error.message : error}`);
    }
  }

  return { element: panel, open, pick, step, clear };
}

/** @param {ModelPart} part */
function inWords({ number, count, path }) {
  const [symbol, place] = path[path.length - 1];
  return [
    element("p", {}, element("b", {}, symbol), " ", element("code", {}, place), ` part ${number + 1} of ${count}`),
    element(
      "ol",
      { class: "gl-path", "aria-label": "Symbols above it" },
      ...path.slice(0, -1).map(([above, where]) => element("li", { title: where }, `${above} `, lineOf(where))),
    ),
  ];
}

/** The line and column of a place, without its file. @param {string} place */
function lineOf(place) {
  return element("small", {}, place.split(":").slice(-2).join(":"));
}
