import { element, icon, iconButton } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { drawPicture } from "./pictures.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Verdict} Verdict */

const PIXELS = 512; // along each side of a picture
const NAMES = { first: "This one", second: "That one", alike: "" };
/** @type {Record<string, Verdict | null>} */
const VERDICTS = { ArrowLeft: "first", ArrowRight: "second", ArrowDown: "alike", Delete: null, Backspace: null };

/**
 * Two models side by side, to choose the preferred one.
 *
 * Pairs are chosen several at a time, and shown one after the other; what was said can be looked at and changed.
 * @param {Page} page
 */
export function makeCompare(page) {
  let index = 0;
  let shown = "";
  /** Pairs after which others were asked for. */
  let ended = "";
  const heading = element("p", { class: "gl-asked", role: "status" });
  const sides = [makeSide("first"), makeSide("second")];
  const alike = textButton("Both alike", () => say("alike"), { title: "key ↓", class: "gl-button gl-alike" });
  const back = iconButton("previous", "Pair before", () => go(index - 1), "↑");
  const skip = iconButton("next", "Next pair", () => go(index + 1), "N");
  const clear = textButton("No answer", () => say(null), {
    title: "Remove the answer (Delete)",
    class: "gl-button gl-quiet",
  });
  const next = () => void page.ask("new_models", { way: "pairs" });
  const more = textButton("More pairs", next, {
    title: "Show other pairs of models",
  });
  const section = element(
    "section",
    { class: "gl-compare", "aria-label": "Compare two models", tabIndex: 0 },
    heading,
    element("div", { class: "gl-two" }, ...sides.map((side) => side.element)),
    element("div", { class: "gl-row gl-answers" }, back, alike, clear, skip, more),
  );

  /** @param {Verdict} verdict */
  function makeSide(verdict) {
    const picture = element("div", { class: "gl-picture" });
    const choose = element(
      "button",
      {
        type: "button",
        class: "gl-candidate",
        title: verdict === "first" ? "key ←" : "key →",
        ariaLabel: NAMES[verdict],
        // The second click of a double click would be about the next pair.
        onclick: (/** @type {MouseEvent} */ event) => event.detail < 2 && say(verdict),
      },
      picture,
    );
    const name = element("span");
    const look = element(
      "button",
      {
        type: "button",
        class: "gl-button gl-quiet",
        title: "Enter",
        onclick: () => page.look(pair().models[verdict === "first" ? 0 : 1]),
      },
      icon("cube"),
      "3D view",
    );
    const caption = element("figcaption", { class: "gl-row" }, name, element("span", { class: "gl-space" }), look);
    return {
      element: element("figure", { class: "gl-side-by-side" }, choose, caption),
      picture,
      choose,
      name,
      verdict,
    };
  }

  function pair() {
    return pairs()[index];
  }

  /** @returns {import("./types.js").Pair[]} none where models are shown in grids */
  function pairs() {
    return page.state.pairs ?? [];
  }

  /** What was said of a pair; answers on their way count. @param {import("./types.js").Pair} pair */
  function saidOf({ models, said }) {
    return page.outbox.findPair(models, page.factor().id) ?? { said, saved: true };
  }

  /** @param {Verdict | null} verdict */
  function say(verdict) {
    if (!pair()) return;
    page.compare(pair().models, verdict);
    if (verdict === null || page.state.view === "product") return;
    if (pairs().some((each) => saidOf(each).said === null)) go(index + 1);
    else if (ended !== shown) {
      ended = shown;
      next();
    }
  }

  /** @param {number} to */
  function go(to) {
    index = Math.max(0, Math.min(to, pairs().length - 1));
    draw();
  }

  /** @param {KeyboardEvent} event @returns {boolean} whether the key means something here */
  function press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey || !pair()) return false;
    if (event.key in VERDICTS) say(VERDICTS[event.key]);
    else if (event.key === "ArrowUp") go(index - 1);
    else if (event.key === "n") go(index + 1);
    else if (event.key === "Enter" && event.target === section) page.look(pair().models[0]);
    else return false;
    return true;
  }

  function update() {
    const now = JSON.stringify(pairs().map(({ models }) => models));
    if (now !== shown) {
      const open = pairs().findIndex((each) => saidOf(each).said === null);
      index = Math.max(open, 0);
    }
    shown = now;
    draw();
  }

  function draw() {
    if (!pair()) return;
    const open = pairs().filter((each) => saidOf(each).said === null).length;
    const { said, saved } = saidOf(pair());
    const words = open ? "Which one would you rather have?" : "All are answered; others come.";
    const asked = `Pair ${index + 1} of ${pairs().length}. ${words}`;
    if (heading.textContent !== asked) heading.textContent = asked;
    page.selection.follow(pair().models);
    sides.forEach(({ picture, choose, name, verdict }, side) => {
      const model = pair().models[side];
      const { label } = page.state.models[model];
      const found = page.pictures.find(model);
      drawPicture(picture, found);
      choose.ariaBusy = String(!found);
      name.textContent = label;
      choose.ariaLabel = `${NAMES[verdict]}: ${label}`;
      mark(choose, said === verdict, saved);
    });
    mark(alike, said === "alike", saved);
    back.disabled = index === 0;
    skip.disabled = index === pairs().length - 1;
    clear.disabled = said === null;
    more.classList.toggle("gl-primary", open === 0);
    // The next pair is drawn once this one is there.
    const here = pair().models.every((model) => (page.pictures.find(model)?.size ?? 0) >= PIXELS);
    const wanted = pairs().slice(index, index + (here ? 2 : 1));
    page.pictures.want(
      wanted.flatMap(({ models }) => models),
      PIXELS,
    );
  }

  return { element: section, press, update, draw, focus: () => section.focus({ preventScroll: true }) };
}

/** @param {HTMLElement} button @param {boolean} on @param {boolean} saved */
function mark(button, on, saved) {
  button.ariaPressed = String(on);
  button.classList.toggle("gl-unsaved", on && !saved);
}
