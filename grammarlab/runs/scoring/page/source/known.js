/** @typedef {import("./types.js").Page} Page */
/**
 * @typedef {object} Known what a person can be told about a model
 * @property {string} label
 * @property {number | null} score given for the active factor
 * @property {boolean} saved whether that score is on disk
 * @property {number | null} predicted 0 to 100
 * @property {number | null} uncertain standard deviation in points
 */

/**
 * What is known of a model in the view that is shown; scores on their way count.
 * @param {Page} page
 * @param {string} model
 * @returns {Known}
 */
export function knownOf(page, model) {
  const { state, outbox } = page;
  const { score: stored, mean, std, product, label } = state.models[model];
  const { score, saved } = outbox.find(model, page.factor().id) ?? { score: stored, saved: true };
  if (state.view === "product") return { label, score, saved, predicted: product ?? null, uncertain: null };
  return { label, score, saved, predicted: mean, uncertain: std };
}

/** For the line below the grids, and for screen readers. @param {Known} known */
export function inWords({ label, score, saved, predicted, uncertain }) {
  const parts = [label, score === null ? "no score" : `scored ${shortly(score)}${saved ? "" : ", not saved yet"}`];
  if (predicted !== null) {
    parts.push(`predicted ${Math.round(predicted)}${uncertain === null ? "" : ` ± ${Math.round(uncertain)}`}`);
  }
  return parts.join(", ");
}

/** @param {number} score */
export function shortly(score) {
  return String(Math.round(score * 10) / 10);
}
