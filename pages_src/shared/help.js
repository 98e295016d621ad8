import { element, iconButton } from "./element.js";

/**
 * Help on mouse, touch and keys: a dialog, opened by a button or by `?`, on any keyboard layout.
 * @param {string[][]} keys and their effects
 * @param {string} [pointing] what mouse and fingers do
 */
export function makeHelp(keys, pointing) {
  const dialog = element(
    "dialog",
    { class: "gl-help", "aria-label": "Keys" },
    element(
      "header",
      { class: "gl-row" },
      element("h2", {}, "Keys"),
      element("span", { class: "gl-space" }),
      iconButton("close", "Close", () => dialog.close(), "Esc"),
    ),
    pointing ? element("p", { class: "gl-hint" }, pointing) : null,
    element(
      "dl",
      { class: "gl-keys" },
      ...keys.flatMap(([key, does]) => [element("dt", {}, key), element("dd", {}, does)]),
    ),
  );
  const open = () => {
    if (!dialog.open) dialog.showModal();
  };
  const button = iconButton("keys", "Keys", open, "?");
  button.setAttribute("aria-haspopup", "dialog");
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  dialog.addEventListener("keydown", (event) => {
    if (!dialog.open) return; // until the next frame the focus can still be in a dialog that has closed
    event.stopPropagation(); // the keys have no effect in the help
    if (event.key === "?") dialog.close();
    else if (event.key !== "Tab") return; // the one button keeps the focus; without this Tab leads out of the page
    event.preventDefault();
  });
  return { button, element: dialog, open, close: () => dialog.close() };
}
