import { element, iconButton } from "../shared/element.js";

/** @typedef {import("./types.js").Page} Page */

const PATIENCE = 8000; // ms after which a score that is not acknowledged is worth a word
const PASSING = 6000; // ms that a note stays

/**
 * Whether all scores are on disk, whether there is a connection, passing notes, and complaints that stay.
 * @param {Page} page
 */
export function makeStatus(page) {
  const saved = element("span", { class: "gl-saved", role: "status" });
  const banner = element("div", { class: "gl-banner", role: "alert", hidden: true });
  const notes = element("div", { class: "gl-notes", "aria-live": "polite" });
  const complaints = element("div", { class: "gl-notes", role: "alert" });
  let given = false;
  let lost = false;
  let ended = "";
  const timer = setInterval(() => page.outbox.unsaved && update(), 1000);

  function update() {
    const { unsaved, waiting } = page.outbox;
    const { connected } = page.channel;
    given ||= unsaved > 0;
    saved.dataset.state = unsaved ? "saving" : "saved";
    const text = unsaved
      ? connected && waiting < PATIENCE
        ? "saving…"
        : `${unsaved} not saved yet`
      : given
        ? "saved"
        : "";
    if (saved.textContent !== text) saved.textContent = text;
    tell(bannerOf(connected, unsaved, waiting));
  }

  /** @param {boolean} connected @param {number} unsaved @param {number} waiting */
  function bannerOf(connected, unsaved, waiting) {
    const kept = unsaved
      ? ` ${unsaved} ${unsaved === 1 ? "score is" : "scores are"} not saved yet; keep this page open, they will be sent again.`
      : "";
    if (ended) return ended;
    if (!connected && lost)
      return `The connection to Python is lost. Trying again; is grammarlab still running?${kept}`;
    if (connected && unsaved && waiting > PATIENCE)
      return `Python does not answer.${kept} It may be busy, or the kernel has stopped.`;
    return "";
  }

  /** @param {string} text */
  function tell(text) {
    banner.hidden = !text;
    if (banner.textContent !== text) banner.textContent = text;
  }

  /** @param {HTMLElement} where @param {string} text @param {string} style */
  function note(where, text, style) {
    const box = element(
      "div",
      { class: `gl-note ${style}` },
      element("span", {}, text),
      iconButton("close", "Dismiss", () => box.remove()),
    );
    where.append(box);
    while (where.childElementCount > 3) where.firstElementChild?.remove();
    return box;
  }

  return {
    saved,
    banner,
    element: element("div", { class: "gl-corner" }, notes, complaints),
    update,
    /** @param {boolean} connected */
    connection(connected) {
      lost ||= !connected;
      update();
    },
    /** @param {string} text */
    closed(text) {
      ended = text;
      update();
    },
    /** @param {string} text */
    say(text) {
      const box = note(notes, text, "");
      setTimeout(() => box.remove(), PASSING);
    },
    /** @param {unknown} error */
    complain(error) {
      note(complaints, error instanceof Error ? error.message : String(error), "gl-bad");
    },
    close: () => clearInterval(timer),
  };
}
