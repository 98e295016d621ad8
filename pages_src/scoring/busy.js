import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";

/** @typedef {import("./types.js").Progress} Progress */

/**
 * A bar of the progress of something long, its stage and share in words, and a button that cancels it.
 * @param {string} name what is done
 * @param {() => void} cancel
 */
export function makeBusy(name, cancel) {
  const bar = element("progress", { class: "gl-progress", max: 1, "aria-label": name });
  const stage = element("span");
  const stop = textButton("Cancel", cancel);
  const section = element(
    "div",
    { class: "gl-busy", hidden: true },
    bar,
    element("div", { class: "gl-row" }, stage, element("span", { class: "gl-space" }), stop),
  );

  /** @param {Progress | null} now nothing once it is done */
  function progress(now) {
    section.hidden = now === null;
    if (!now) return;
    const share = now.done && now.total ? ` ${Math.round((100 * now.done) / now.total)} %` : "";
    stage.textContent = `${now.stage}…${share}`;
    if (now.total) bar.value = now.done / now.total;
    else bar.removeAttribute("value");
  }

  return { element: section, progress };
}
