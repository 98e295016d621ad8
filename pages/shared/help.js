import { element, iconButton } from "./element.js";

/**
 * What the mouse, fingers and keys do, in a dialog.
 * @param {string[][]} keys and what each does
 * @param {string} pointing what mouse and fingers do
 */
export function makeHelp(keys, pointing) {
  const dialog = element("dialog", { class: "gl-help", "aria-label": "Keys" });
  const list = keys.flatMap(([key, does]) => [element("dt", {}, key), element("dd", {}, does)]);
  dialog.append(
    element(
      "div",
      { class: "gl-row" },
      element("h2", {}, "Keys"),
      element("span", { class: "gl-space" }),
      iconButton("close", "Close", () => dialog.close()),
    ),
    element("p", { class: "gl-hint" }, pointing),
    element("dl", { class: "gl-keys" }, ...list),
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  dialog.addEventListener("keydown", (event) => event.key === "?" && dialog.close());
  const open = () => {
    if (!dialog.open) dialog.showModal();
  };
  return { element: dialog, open, button: iconButton("keys", "Keys", open, "?") };
}
