import { element, icon } from "./element.js";

/** @typedef {{ preferences: { scale?: any } }} Page */
/** @typedef {import("./types.js").Said} Said */
/** @typedef {import("./types.js").Scale} Scale */
/** @typedef {{ score: number, key: string, text: string, label?: string, picture?: "up" | "down" }} Step */

/** How something is said of one model: the name of each scale, and what can be said. @type {Record<Scale, { name: string, steps: Step[] }>} */
export const SCALES = {
  score: {
    name: "0–100",
    steps: Array.from({ length: 11 }, (_, step) => ({
      score: 10 * step,
      key: step === 10 ? "h" : String(step),
      text: String(10 * step),
    })),
  },
  stars: {
    name: "Stars",
    steps: Array.from({ length: 5 }, (_, step) => ({
      score: 25 * step,
      key: String(step + 1),
      text: "★",
      label: `${step + 1} of 5 stars`,
    })),
  },
  thumb: {
    name: "Thumbs",
    steps: [
      { score: 0, key: "0", text: "Down", label: "thumb down", picture: "down" },
      { score: 100, key: "1", text: "Up", label: "thumb up", picture: "up" },
    ],
  },
};

/** The scale that a person gives scores on in this browser. @param {Page} page @returns {Scale} */
export function scaleOf({ preferences: { scale } }) {
  return Object.hasOwn(SCALES, scale) ? /** @type {Scale} */ (scale) : "score";
}

/** The scale after the one in use. @param {Page} page @returns {Scale} */
export function nextScale(page) {
  const names = /** @type {Scale[]} */ (Object.keys(SCALES));
  return names[(names.indexOf(scaleOf(page)) + 1) % names.length];
}

/**
 * The score that a key stands for on a scale; undefined for other keys.
 * @param {Scale} scale
 * @param {string} key
 * @returns {number | null | undefined}
 */
export function scoreOfKey(scale, key) {
  if (key === "Delete" || key === "Backspace") return null;
  return SCALES[scale].steps.find((step) => step.key === key.toLowerCase())?.score;
}

/** Where there is little room. @param {Said} said @returns {string} */
export function shortly({ score, kind }) {
  if (score === null) return "";
  if (kind === "stars") return `${1 + score / 25}★`;
  if (kind === "thumb") return score > 50 ? "▲" : "▼";
  return String(Math.round(score * 10) / 10);
}

/** @param {Said} said @returns {string} */
export function inWords({ score, kind }) {
  const step = SCALES[kind ?? "score"].steps.find((each) => each.score === score);
  return score === null ? "no score" : (step?.label ?? `scored ${shortly({ score, kind: "score" })}`);
}

/**
 * A button for each step of the scale in use.
 *
 * @param {Page} page
 * @param {string} label for screen readers
 * @param {(score: number) => void} give
 */
export function makeSteps(page, label, give) {
  const box = element("div", { class: "gl-steps", role: "group", "aria-label": label });
  let drawn = "";

  /** @param {Said} said of all that is selected; no score where they differ */
  function draw({ score, kind }) {
    const scale = scaleOf(page);
    const { steps } = SCALES[scale];
    if (scale !== drawn) box.replaceChildren(...steps.map((step) => makeStep(step, give)));
    drawn = scale;
    const isOn = (/** @type {Step} */ step) => (scale === "stars" ? step.score <= Number(score) : step.score === score);
    steps.forEach((step, index) =>
      box.children[index].classList.toggle("gl-on", score !== null && kind === scale && isOn(step)),
    );
  }

  return { element: box, draw };
}

/** @param {Step} step @param {(score: number) => void} give */
function makeStep({ score, key, text, label, picture }, give) {
  return element(
    "button",
    {
      type: "button",
      class: "gl-button gl-step",
      title: `key ${key.toUpperCase()}`,
      "aria-label": label,
      onclick: () => give(score),
    },
    picture ? icon(picture) : null,
    text,
  );
}
