import { element, iconButton } from "../shared/element.js";

const SPOKEN = 1000; // ms after which what is read out leaves the page, where it can be read below

/**
 * Warnings about what the rules passed over, in one note that stays: many would cover what is scored. Each is read out
 * once; the newest one is in sight, and the others are below it, newest first.
 *
 * @param {() => void} handOn gives the focus to something else when the note goes
 */
export function makeWarnings(handOn) {
  const newest = element("span", { class: "gl-newest" });
  // Each paragraph is read out when it comes, also while an earlier one is still there.
  const spoken = element("div", { class: "gl-unseen", role: "alert", "aria-atomic": "false" });
  const summary = element("summary");
  const list = element("ol");
  const others = element("details", { hidden: true }, summary, list);
  const note = element(
    "div",
    { class: "gl-note gl-bad gl-warnings", hidden: true },
    element("div", {}, newest, spoken, others),
    iconButton("close", "Dismiss", dismiss),
  );
  /** @type {Set<string>} all so far, the dismissed ones among them, which do not come again */
  const known = new Set();

  function dismiss() {
    note.hidden = others.hidden = true;
    others.open = false;
    newest.textContent = "";
    spoken.replaceChildren();
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
      for (const warning of fresh) {
        const words = element("p", {}, warning);
        spoken.append(words);
        setTimeout(() => words.remove(), SPOKEN);
      }
      note.hidden = false;
      const more = list.childElementCount;
      others.hidden = !more;
      summary.textContent = `${more} more ${more === 1 ? "warning" : "warnings"}`;
    },
  };
}
