import { element } from "../shared/element.js";
import { LOST, makeNotes } from "../shared/notes.js";

/** @typedef {import("./types.js").Page} Page */

const PATIENCE = 8000; // ms after which an unacknowledged score is reported

/**
 * Whether all scores are on disk, whether there is a connection, passing notes, and complaints that stay.
 * @param {Page} page
 */
export function makeStatus(page) {
  const saved = element("span", { class: "gl-saved", role: "status" });
  const notes = makeNotes();
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
    notes.announce(bannerOf(connected, unsaved, waiting));
  }

  /** @param {boolean} connected @param {number} unsaved @param {number} waiting */
  function bannerOf(connected, unsaved, waiting) {
    const kept = unsaved
      ? ` ${unsaved} ${unsaved === 1 ? "score is" : "scores are"} not saved yet; keep this page open, they will be sent again.`
      : "";
    if (ended) return ended;
    if (!connected && lost) return `${LOST}${kept}`;
    if (connected && unsaved && waiting > PATIENCE)
      return `Python does not answer.${kept} It may be busy, or the kernel has stopped.`;
    return "";
  }

  return {
    saved,
    banner: notes.banner,
    element: notes.element,
    say: notes.say,
    complain: notes.complain,
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
    close: () => clearInterval(timer),
  };
}
