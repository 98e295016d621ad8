import { element, iconButton } from "../shared/element.js";

/**
 * Warnings about what the rules passed over, in one note that stays: many would cover what is scored. The newest one is
 * read out, and the others are below it, newest first.
 *
 * @param {() => void} handOn gives the focus to something else when the note goes
 */
export function makeWarnings(handOn) {
  const newest = element("span", { role: "alert" });
  const summary = element("summary");
  const list = element("ol");
  const others = element("details", { hidden: true }, summary, list);
  const note = element(
    "div",
    { class: "gl-note gl-bad gl-warnings", hidden: true },
    element("div", {}, newest, others),
    iconButton("close", "Dismiss", dismiss),
  );
  /** @type {Set<string>} all so far, the dismissed ones among them, which do not come again */
  const known = new Set();

  function dismiss() {
    note.hidden = others.hidden = true;
    others.open = false;
    newest.textContent = "";
    list.replaceChildren();
    handOn();
  }

  return {
    element: note,
    /** @param {string[]} warnings all of the session, the oldest first */
    update(warnings) {
      const fresh = warnings.filter((warning) => !known.has(warning));
      if (!fresh.length) return;
      for (const warning of fresh) {
        known.add(warning);
        // What was the newest moves to the list, where nothing is read out again; the rest of the note stays as it is.
        if (newest.textContent) list.prepend(element("li", {}, newest.textContent));
        newest.textContent = warning;
      }
      note.hidden = false;
      const more = list.childElementCount;
      others.hidden = !more;
      summary.textContent = `${more} more ${more === 1 ? "warning" : "warnings"}`;
    },
  };
}
