import { element, iconButton } from "../shared/element.js";
import { KEYS } from "./keyboard.js";

/** What all keys do: a dialog, opened by a button or by `?`, wherever that lies on the keyboard. */
export function makeHelp() {
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
    element(
      "dl",
      { class: "gl-keys" },
      ...KEYS.flatMap(([keys, says]) => [element("dt", {}, keys), element("dd", {}, says)]),
    ),
  );
  const button = iconButton("keys", "Keys", () => dialog.showModal(), "?");
  button.setAttribute("aria-haspopup", "dialog");

  dialog.addEventListener("keydown", (event) => {
    event.stopPropagation(); // what the keys do is only read here
    if (event.key === "?") dialog.close();
    else if (event.key !== "Tab") return; // the one button keeps the focus; without this Tab leads out of the page
    event.preventDefault();
  });

  return {
    button,
    element: dialog,
    open() {
      if (!dialog.open) dialog.showModal();
    },
    close: () => dialog.close(),
  };
}
