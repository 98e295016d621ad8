import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Contrast} Contrast */

/** Pixels along each side of a picture. */
const SIZE = 160;

const TITLE = "One seed without and with the choice; the numbers are the mean predictions for all such models";

/**
 * Choices on which the scores depend, each as one model without it and one with it that differ in nothing else.
 * @param {import("./types.js").Page} page
 * @returns {import("./types.js").Part}
 */
export function makeContrasts(page) {
  const list = element("div", { class: "gl-contrasts" });
  let drawn = "";

  /** @param {import("./types.js").State} state */
  function update({ contrasts }) {
    const now = JSON.stringify(contrasts);
    if (now === drawn) return;
    drawn = now;
    for (const old of list.querySelectorAll("img")) URL.revokeObjectURL(old.src);
    list.replaceChildren();
    void show(contrasts, now);
  }

  /** One after the other, since pictures of models are more urgent. @param {Contrast[]} contrasts @param {string} now */
  async function show(contrasts, now) {
    for (const { text, without, having } of contrasts) {
      const [picture] = await page.channel.request("contrast", { choice: text, size: SIZE }).then(
        ({ buffers }) => buffers,
        () => [], // no seed gives two such models
      );
      if (drawn !== now) return;
      if (!picture) continue;
      const image = element("img", {
        src: URL.createObjectURL(new Blob([picture], { type: "image/jpeg" })),
        width: 2 * SIZE,
        height: SIZE,
        alt: `One model without ${text}, and the same with it`,
      });
      const labels = [`without: ${without}`, `with: ${having}`].map((label) => element("span", {}, label));
      list.append(
        element(
          "figure",
          { title: TITLE },
          element("figcaption", {}, text),
          image,
          element("div", { class: "gl-sides" }, ...labels),
        ),
      );
    }
  }

  return { element: list, update };
}
