import { inWords as saidInWords } from "../shared/scale.js";

/** @typedef {import("./types.js").Page} Page */
/**
 * @typedef {object} Known the known facts about a model
 * @property {string} label
 * @property {number | null} score given for the active factor
 * @property {import("./types.js").Scale | null} kind how it was given
 * @property {boolean} saved whether that score is on disk
 * @property {number | null} predicted 0 to 100
 * @property {number | null} uncertain standard deviation in points
 */

/**
 * The known facts about a model in the visible view; includes scores that are not acknowledged yet.
 * @param {Page} page
 * @param {string} model
 * @returns {Known}
 */
export function knownOf(page, model) {
  const { state, outbox } = page;
  const { mean, std, product, label, ...stored } = state.models[model];
  const { score, kind, saved } = outbox.find(model, page.factor().id) ?? { ...stored, saved: true };
  if (state.view === "product") return { label, score, kind, saved, predicted: product ?? null, uncertain: null };
  return { label, score, kind, saved, predicted: mean, uncertain: std };
}

/** For the line below the grids, and for screen readers. @param {Known} known */
export function inWords({ label, score, kind, saved, predicted, uncertain }) {
  const parts = [label, `${saidInWords({ score, kind })}${score === null || saved ? "" : ", not saved yet"}`];
  if (predicted !== null) {
    parts.push(`predicted ${Math.round(predicted)}${uncertain === null ? "" : ` ± ${Math.round(uncertain)}`}`);
  }
  return parts.join(", ");
}

/** A number with its noun; empty for none. @param {number} number @param {string} noun */
export function counted(number, noun) {
  return number ? `${number} ${noun}${number === 1 ? "" : "s"}` : "";
}
