import { element, svg } from "../shared/element.js";
import { textButton } from "../shared/menu.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Movement} Movement */
/** @typedef {import("./types.js").Progress} Progress */

/** Movement in nats below which more scores change little; twice in a row means that scoring may stop. */
const SETTLED = 0.01;

/**
 * Refitting, the movement of the density, and the features that the score depends on.
 * @param {Page} page
 * @returns {import("./types.js").Part & { progress: (progress: Progress | null) => void }}
 */
export function makeLearning(page) {
  const start = textButton("Update", () => void page.ask("update"), {
    class: "gl-button gl-primary gl-wide",
    title: "Learn from all scores and show new models (Ctrl Enter)",
  });
  const bar = element("progress", { class: "gl-progress", max: 1, "aria-label": "Update" });
  const stage = element("span");
  const stop = textButton("Cancel", () => void page.ask("cancel"));
  const busy = element(
    "div",
    { class: "gl-busy", hidden: true },
    bar,
    element("div", { class: "gl-row" }, stage, element("span", { class: "gl-space" }), stop),
  );
  const hint = element("p", { class: "gl-hint" });
  const chart = element("figure", { class: "gl-chart" });
  const relevance = element("ul", { class: "gl-relevance" });
  const words = element("div", { class: "gl-words" });
  const why = element("div", {}, element("h3", {}, "What the score depends on"), words, relevance);
  const section = element("section", { class: "gl-card", "aria-label": "Learning" }, start, busy, hint, chart, why);
  let drawn = "";

  /** @param {State} state */
  function update(state) {
    progress(state.updating);
    start.disabled = said(state) === "";
    start.classList.toggle("gl-calm", state.fresh);
    hint.textContent = hintOf(state);
    why.hidden = state.relevance.length === 0;
    words.replaceChildren(...state.words.map((line) => element("p", {}, line)));
    relevance.replaceChildren(...state.relevance.map(relevanceLine));
    const points = JSON.stringify(state.chart);
    if (points !== drawn) chart.replaceChildren(...drawChart(state.chart));
    drawn = points;
  }

  /** @param {Progress | null} now */
  function progress(now) {
    start.hidden = now !== null;
    busy.hidden = now === null;
    if (!now) return;
    stage.textContent = `${now.stage}…`;
    if (now.total) bar.value = now.done / now.total;
    else bar.removeAttribute("value");
  }

  return { element: section, update, progress };
}

/** @param {State} state */
function hintOf(state) {
  const [{ fresh, chart, gain, turn, active }, all] = [state, said(state)];
  if (!all) return "Score some models, then update: the density follows your scores.";
  if (!fresh) return `${all}; the predictions do not know all of them yet.`;
  const last = chart.slice(-2);
  const settled = last.length === 2 && last.every(({ js }) => js < SETTLED);
  const more = gain === null ? "" : ` 16 more scores may gain about ${gain.toPrecision(1)} nats.`;
  const next = turn && turn !== active ? ` Those of “${turn}” tell most.` : "";
  const known = settled ? "the density has settled." : "the predictions know them all.";
  return `${all}; ${known}${more}${next}`;
}

/** Numbers of scores and comparisons, in words. @param {State} state */
function said({ scored, compared }) {
  return [scored && `${scored} scores`, compared && `${compared} comparisons`].filter(Boolean).join(" and ");
}

/** @param {import("./types.js").Relevance} relevance */
function relevanceLine({ name, level, share }) {
  const fill = element("i");
  fill.style.transform = `scaleX(${Math.min(Math.max(share, 0), 1)})`;
  return element(
    "li",
    {},
    element("span", {}, name),
    element("b", {}, level),
    element("span", { class: "gl-share", "aria-hidden": "true" }, fill),
  );
}

/** A small chart: movement of the density at each update, by number of labels. @param {Movement[]} movements */
function drawChart(movements) {
  if (movements.length === 0) return [];
  const [width, height] = [260, 64];
  const highest = Math.max(...movements.map(({ js }) => js), 2 * SETTLED);
  const most = movements[movements.length - 1].labels;
  const least = movements[0].labels;
  const points = movements.map(({ labels, js }) => ({
    x: most > least ? 4 + ((labels - least) / (most - least)) * (width - 8) : width / 2,
    y: height - 4 - (js / highest) * (height - 12),
    words: `${labels} scores: moved by ${js.toPrecision(2)}`,
  }));
  const line = svg("polyline", { class: "gl-line", points: points.map(({ x, y }) => `${x},${y}`).join(" ") });
  const dots = points.map(({ x, y, words }) => {
    const title = svg("title");
    title.textContent = words;
    return svg("circle", { class: "gl-dot", cx: x, cy: y, r: 3 }, title);
  });
  const floor = height - 4 - (SETTLED / highest) * (height - 12);
  const settled = svg("line", { class: "gl-settled", x1: 0, x2: width, y1: floor, y2: floor });
  const { js } = movements[movements.length - 1];
  const caption = `Last update moved the density by ${js.toPrecision(2)} nats`;
  return [
    svg(
      "svg",
      { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": points.map(({ words }) => words).join("; ") },
      settled,
      line,
      ...dots,
    ),
    element(
      "figcaption",
      {
        title:
          "Jensen-Shannon divergence between the densities before and after; below the dashed line, updates change little",
      },
      caption,
    ),
  ];
}
