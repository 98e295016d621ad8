import { element, icon } from "../shared/element.js";
import { shortly } from "../shared/scale.js";
import { inWords, knownOf } from "./known.js";
import { drawPicture } from "./pictures.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof makeEntry>} Entry */

/**
 * The models that were scored, the latest first; each score can be taken away, whatever was scored since.
 * @param {Page} page
 */
export function makeRecent(page) {
  const list = element("ul", { class: "gl-recent", "aria-label": "Scored models, the latest first" });
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Scored", hidden: true },
    element("h2", {}, "Scored"),
    list,
  );
  /** @type {Map<string, Entry>} entries stay, so that none moves away under the keyboard */
  const entries = new Map();

  function update() {
    page.pictures.keep([...page.state.recent, ...page.state.line]);
    draw();
  }

  function draw() {
    const models = page.state.recent.filter((model) => knownOf(page, model).score !== null);
    section.hidden = !models.length;
    for (const model of models) if (!entries.has(model)) entries.set(model, makeEntry(page, model));
    for (const model of models) entries.get(model)?.draw();
    const shown = models.map((model) => /** @type {Entry} */ (entries.get(model)).element);
    if (shown.length === list.childElementCount && shown.every((item, at) => item === list.children[at])) return;
    list.replaceChildren(...shown);
  }

  return { element: section, update, draw };
}

/** @param {Page} page @param {string} model */
function makeEntry(page, model) {
  const picture = element("span", { class: "gl-picture" });
  const score = element("span", { class: "gl-score" });
  const look = element(
    "button",
    { type: "button", class: "gl-recent-look", onclick: () => page.look(model) },
    picture,
    score,
  );
  const remove = element(
    "button",
    { type: "button", class: "gl-button gl-quiet", onclick: () => page.score([model], null) },
    icon("close"),
  );
  const item = element("li", {}, look, remove);
  return {
    element: item,
    draw() {
      const known = knownOf(page, model);
      drawPicture(picture, page.pictures.find(model));
      score.textContent = shortly(known);
      score.classList.toggle("gl-unsaved", !known.saved);
      look.ariaLabel = look.title = inWords(known);
      remove.ariaLabel = remove.title = `Remove the score of ${known.label}`;
    },
  };
}
