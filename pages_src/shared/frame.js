import { element, iconButton } from "./element.js";
import { choice, menu, textButton } from "./menu.js";

/**
 * @typedef {object} FileState the state of the file that a page edits
 * @property {string} title
 * @property {string} file that it is saved to
 * @property {number} revision
 * @property {boolean} saved whether that file is up to date
 * @property {boolean} lost whether no file is up to date
 * @property {string} undo what would be undone, in words
 * @property {string} redo
 * @property {string[]} formats that it is exported to
 */

/**
 * The frame of a page that edits a file: name, undo and redo, export, save, keys and notes.
 *
 * @param {HTMLElement} root
 * @param {{ state: FileState, ask: (command: string, parameters?: object) => Promise<any> }} page
 * @param {object} parts
 * @param {ReturnType<typeof import("./notes.js").makeNotes>} parts.notes
 * @param {ReturnType<typeof import("./help.js").makeHelp>} parts.help
 * @param {Record<string, string>} parts.kinds what a format is for
 * @param {() => unknown} parts.settle before what is being typed is saved
 * @param {HTMLElement[]} parts.beside the name
 * @param {HTMLElement[]} parts.left
 * @param {HTMLElement} parts.panel
 */
export function makeFrame(root, page, { notes, help, kinds, settle, beside, left, panel }) {
  const title = element("h1", { class: "gl-name" });
  const saved = element("span", { class: "gl-saved", role: "status" });
  const undo = iconButton("undo", "Undo", () => void page.ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void page.ask("redo"), "Ctrl Y");
  const exports = menu(
    element("button", { type: "button", class: "gl-button gl-chooser" }, "Export"),
    "Export",
    (close) =>
      page.state.formats.map((format) =>
        choice(format.toUpperCase(), kinds[format] ?? "", async () => {
          close();
          const written = await page.ask("export", { format });
          if (written) notes.say(`Written to ${written.file}`);
        }),
      ),
  );

  async function save() {
    await settle();
    const written = await page.ask("save");
    if (written) notes.say(`Saved to ${written.file}`);
  }

  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      ...beside,
      element("span", { class: "gl-space" }),
      saved,
      undo,
      redo,
      exports,
      textButton("Save", save, { class: "gl-button gl-primary", title: "Save (Ctrl S)" }),
      help.button,
    ),
    notes.banner,
    element("div", { class: "gl-main" }, element("div", { class: "gl-left" }, ...left), panel),
    notes.element,
    help.element,
  );
  addEventListener("beforeunload", (event) => page.state.lost && event.preventDefault());

  return {
    save,
    update() {
      const { state } = page;
      title.textContent = state.title;
      title.title = state.file;
      document.title = `${state.title} – grammarlab`;
      saved.textContent = state.saved && state.revision ? "saved" : state.lost ? "not saved yet" : "";
      saved.dataset.state = state.lost ? "saving" : "saved";
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
    },
  };
}
