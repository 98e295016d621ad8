import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Page} Page */

const PAUSE = 350; // ms after the last key

/**
 * The text of the design, and its mistakes.
 * @param {Page} page
 */
export function makeText(page) {
  const input = element("textarea", {
    class: "fl-text",
    spellcheck: false,
    autocomplete: "off",
    "aria-label": "Text of the design",
  });
  const mistakes = element("div", { role: "alert" });
  const editing = element("div", { class: "fl-editing" }, input, mistakes);
  let sent = ""; // what Python knows
  let timer = 0;
  /** @type {Promise<any>} */
  let sending = Promise.resolve();

  input.addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(() => void send(), PAUSE);
  });
  input.addEventListener("blur", () => void send());
  input.addEventListener("keydown", ({ key }) => key === "Escape" && input.blur());

  /** Whatever has been typed is known to Python once this ends. */
  function send() {
    clearTimeout(timer);
    if (input.value === sent) return sending;
    const before = sent;
    const text = (sent = input.value);
    sending = page.ask("edit", { text }).then((answer) => {
      if (!answer && sent === text) sent = before; // it will be sent anew
    });
    return sending;
  }

  /** @param {import("./types.js").Mistake} mistake */
  function go({ line, column, length }) {
    const lines = input.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0) + column - 1;
    input.focus();
    input.setSelectionRange(start, start + length);
  }

  function update() {
    const { state } = page;
    // What is being typed stays: Python hears of it with the next pause.
    if (input.value === sent && state.text !== sent) {
      const [start, end, top] = [input.selectionStart, input.selectionEnd, input.scrollTop];
      input.value = sent = state.text;
      input.setSelectionRange(start, end);
      input.scrollTop = top;
    }
    editing.classList.toggle("fl-wrong", state.mistakes.length > 0);
    input.setAttribute("aria-invalid", String(state.mistakes.length > 0));
    mistakes.replaceChildren(
      ...state.mistakes.map((each) =>
        element(
          "button",
          { type: "button", class: "fl-mistake", title: "Go there", onclick: () => go(each) },
          `line ${each.line}, column ${each.column}: ${each.message}`,
          element("pre", {}, each.shown),
        ),
      ),
    );
  }

  return { element: editing, input, update, send };
}
