import { element, iconButton } from "./element.js";

const PASSING = 6000; // ms that a note stays
const MOST = 3;

/** Passing notes, complaints that stay, and a banner while there is no connection. */
export function makeNotes() {
  const notes = element("div", { class: "gl-notes", "aria-live": "polite" });
  const complaints = element("div", { class: "gl-notes", role: "alert" });
  const banner = element("div", { class: "gl-banner", role: "alert", hidden: true });

  /** @param {HTMLElement} where @param {string} text @param {string} style */
  function note(where, text, style) {
    for (const box of where.children) if (box.textContent === text) box.remove();
    const box = element(
      "div",
      { class: `gl-note ${style}` },
      element("span", {}, text),
      iconButton("close", "Dismiss", () => box.remove()),
    );
    where.append(box);
    while (where.childElementCount > MOST) where.firstElementChild?.remove();
    return box;
  }

  return {
    banner,
    element: element("div", { class: "gl-corner fe-corner" }, notes, complaints),
    /** @param {string} text */
    say(text) {
      const box = note(notes, text, "");
      setTimeout(() => box.remove(), PASSING);
    },
    /** @param {string} text */
    complain: (text) => void note(complaints, text, "gl-bad"),
    /** What is complained about is over. */
    calm: () => complaints.replaceChildren(),
    /** @param {boolean} connected */
    connection(connected) {
      banner.hidden = connected;
      banner.textContent = connected
        ? ""
        : "The connection to Python is lost. Trying again; is grammarlab still running?";
    },
  };
}
