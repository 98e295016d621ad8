import { element } from "../shared/element.js";
import { drawPicture } from "./pictures.js";

/** @typedef {import("./types.js").Page} Page */

/**
 * The models that come next: chosen behind the person, and other ones once more is known of what is liked.
 * @param {Page} page
 */
export function makeLine(page) {
  const list = element("div", { class: "gl-next" });
  const figure = element(
    "figure",
    { role: "img", hidden: true },
    element("figcaption", { class: "gl-next-title", "aria-hidden": "true" }, "Next in line"),
    list,
  );

  function draw() {
    const { line } = page.state;
    figure.hidden = line.length === 0;
    figure.ariaLabel = `${line.length} models that are next in line`;
    while (list.childElementCount < line.length) list.append(element("span", { class: "gl-picture" }));
    while (list.childElementCount > line.length) list.lastElementChild?.remove();
    line.forEach((model, at) => drawPicture(/** @type {HTMLElement} */ (list.children[at]), page.pictures.find(model)));
  }

  return { element: figure, draw };
}
