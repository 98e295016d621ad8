import { element, iconButton } from "../../../../scoring/page/source/element.js";
import { KEYS } from "./keyboard.js";

/** What the mouse, fingers and keys do, in a dialog. */
export function makeHelp() {
  const dialog = element("dialog", { class: "gl-help", "aria-label": "Keys" });
  const list = KEYS.flatMap(([key, does]) => [element("dt", {}, key), element("dd", {}, does)]);
  dialog.append(
    element(
      "div",
      { class: "gl-row" },
      element("h2", {}, "Keys"),
      element("span", { class: "gl-space" }),
      iconButton("close", "Close", () => dialog.close()),
    ),
    element(
      "p",
      { class: "gl-hint" },
      "Drag the handles at the right and at the top to change the size. Click a part to select it, draw a rectangle to make a grid. Click a picture below to accept a variation.",
    ),
    element("dl", { class: "gl-keys" }, ...list),
  );
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  dialog.addEventListener("keydown", (event) => event.key === "?" && dialog.close());
  const open = () => {
    if (!dialog.open) dialog.showModal();
  };
  return { element: dialog, open, button: iconButton("keys", "Keys", open, "?") };
}
