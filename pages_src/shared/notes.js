import { element, iconButton } from "./element.js";

const PASSING = 6000; // ms that a note stays
const MOST = 3;
export const LOST = "The connection to Python is lost. Trying again; is grammarlab still running?";

/** Temporary notes, persistent errors, and a banner for lasting states. */
export function makeNotes() {
  const notes = element("div", { class: "gl-notes", "aria-live": "polite" });
  const complaints = element("div", { class: "gl-notes", role: "alert" });
  const banner = element("div", { class: "gl-banner", role: "alert", hidden: true });
  const corner = element("div", { class: "gl-corner" }, notes, complaints);
  /** @type {HTMLElement | null} what had the focus before the notes got it */
  let before = null;
  corner.addEventListener("focusin", ({ relatedTarget }) => {
    if (relatedTarget instanceof HTMLElement && !corner.contains(relatedTarget)) before = relatedTarget;
  });

  /**
   * Who has the focus on a note goes on to another one, or back to where they came from; where that is gone, to the
   * first control of the page.
   * @param {Element} box
   */
  function remove(box) {
    const hadFocus = box.matches(":focus-within");
    box.remove();
    if (!hadFocus) return;
    /** @type {HTMLElement | null} */
    const another = corner.querySelector(".gl-note:not([hidden]) > button");
    (another ?? before)?.focus();
    if (document.activeElement !== document.body) return;
    /** @type {HTMLElement | null | undefined} */
    const first = corner.parentElement?.querySelector("button:enabled, [tabindex='0']");
    first?.focus();
  }

  /** @param {HTMLElement} where @param {string} text @param {string} style */
  function note(where, text, style) {
    for (const box of where.children) if (box.textContent === text) remove(box);
    const box = element(
      "div",
      { class: `gl-note ${style}` },
      element("span", {}, text),
      iconButton("close", "Dismiss", () => remove(box)),
    );
    where.append(box);
    while (where.childElementCount > MOST && where.firstElementChild) remove(where.firstElementChild);
    return box;
  }

  return {
    banner,
    element: corner,
    /** @param {string} text */
    say(text) {
      const box = note(notes, text, "");
      setTimeout(() => remove(box), PASSING);
    },
    /** @param {unknown} error or words */
    complain(error) {
      note(complaints, error instanceof Error ? error.message : String(error), "gl-bad");
    },
    /** What is complained about is over. */
    calm() {
      for (const box of [...complaints.children]) remove(box);
    },
    /** What lasts; empty for nothing. @param {string} text */
    announce(text) {
      banner.hidden = !text;
      if (banner.textContent !== text) banner.textContent = text;
    },
  };
}

/**
 * Sends commands; a refusal is shown.
 * @param {import("./channel.js").Channel} channel
 * @param {ReturnType<typeof makeNotes>} notes
 * @param {() => Promise<void>} ready
 * @returns {(command: string, parameters?: object) => Promise<any>}
 */
export function makeAsk(channel, notes, ready) {
  return async (command, parameters) => {
    await ready();
    try {
      const { result } = await channel.request(command, parameters);
      notes.calm();
      return result;
    } catch (error) {
      notes.complain(error);
    }
  };
}
