import { element, svg } from "../shared/element.js";
import { makeBusy } from "./busy.js";
import { makeContrasts } from "./contrasts.js";
import { counted } from "./known.js";
import { makeLine } from "./line.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Movement} Movement */
/** @typedef {import("./types.js").Progress} Progress */

/** Change in nats below which more scores change little; twice in a row means that scoring may stop. */
const LITTLE = 0.01;
/** Percent below which a change is none that a person could see. */
const LEAST_SHARE = 0.1;

/**
 * Learning, how much each update changed what is learned, and what the score depends on.
 * @param {Page} page
 * @returns {import("./types.js").Part & { progress: (progress: Progress | null) => void, draw: () => void }}
 */
export function makeLearning(page) {
  const busy = makeBusy("Learning", () => void page.ask("cancel"));
  const hint = element("p", { class: "gl-hint" });
  const chart = element("figure", { class: "gl-chart" });
  const relevance = element("ul", { class: "gl-relevance" });
  const words = element("div", { class: "gl-words" });
  const contrasts = makeContrasts(page);
  const why = element("div", {}, element("h3", {}, "What the score depends on"), words, contrasts.element, relevance);
  const line = makeLine(page);
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Learning" },
    line.element,
    busy.element,
    hint,
    chart,
    why,
  );
  let drawn = "";

  /** @param {State} state */
  function update(state) {
    busy.progress(state.updating);
    line.draw();
    hint.textContent = hintOf(state);
    why.hidden = state.relevance.length + state.words.length === 0;
    words.replaceChildren(...state.words.map((line) => element("p", {}, line)));
    contrasts.update(state);
    relevance.replaceChildren(...state.relevance.map(relevanceLine));
    const points = JSON.stringify(state.chart);
    if (points !== drawn) chart.replaceChildren(...drawChart(state.chart));
    drawn = points;
  }

  return { element: section, update, progress: busy.progress, draw: line.draw };
}

/** @param {State} state */
function hintOf(state) {
  const [{ fresh, chart, explained, gain, turn, active }, all] = [state, said(state)];
  if (!all) return "Score some models: those in line follow your scores.";
  if (!fresh) return `${all}; the predictions do not know all of them yet.`;
  const last = chart.slice(-2);
  // Without a pattern updates change little, too, since the original is kept: that is no reason to stop.
  const steady = explained && last.length === 2 && last.every(({ js }) => js < LITTLE);
  const more = gain === null ? "" : ` 16 more may change what is learned by ${asShare(gain)}.`;
  const next = turn && turn !== active ? ` Those of “${turn}” tell the most.` : "";
  const known = steady ? "the last updates changed little, so you may stop." : "the predictions know them all.";
  return `${all}; ${known}${more}${next}`;
}

/** A divergence as a share of the largest one, that of two kinds of models without a common one. @param {number} nats */
function asShare(nats) {
  const share = (100 * nats) / Math.LN2;
  if (share < LEAST_SHARE) return `less than ${LEAST_SHARE} %`;
  return `${share >= 10 ? Math.round(share) : Number(share.toPrecision(1))} %`;
}

/** Numbers of scores and comparisons, in words. @param {State} state */
function said({ scored, compared }) {
  return [counted(scored, "score"), counted(compared, "comparison")].filter(Boolean).join(" and ");
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

/** A small chart: how much each update changed what is learned, by number of scores. @param {Movement[]} movements */
function drawChart(movements) {
  if (movements.length === 0) return [];
  const [width, height] = [260, 64];
  const highest = Math.max(...movements.map(({ js }) => js), 2 * LITTLE);
  const most = movements[movements.length - 1].labels;
  const least = movements[0].labels;
  const points = movements.map(({ labels, js }) => ({
    x: most > least ? 4 + ((labels - least) / (most - least)) * (width - 8) : width / 2,
    y: height - 4 - (js / highest) * (height - 12),
    words: `${counted(labels, "score") || "no scores"}: changed by ${asShare(js)}`,
  }));
  const line = svg("polyline", { class: "gl-line", points: points.map(({ x, y }) => `${x},${y}`).join(" ") });
  const dots = points.map(({ x, y, words }) => {
    const title = svg("title");
    title.textContent = words;
    return svg("circle", { class: "gl-dot", cx: x, cy: y, r: 3 }, title);
  });
  const level = height - 4 - (LITTLE / highest) * (height - 12);
  const little = svg("line", { class: "gl-little", x1: 0, x2: width, y1: level, y2: level });
  const { js } = movements[movements.length - 1];
  const caption = `The last update changed what is learned by ${asShare(js)}`;
  return [
    svg(
      "svg",
      { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": points.map(({ words }) => words).join("; ") },
      little,
      line,
      ...dots,
    ),
    element(
      "figcaption",
      {
        title: "0 %: the same models as before; 100 %: none of them. Below the dashed line, updates change little",
      },
      caption,
    ),
  ];
}
