import { element } from "./element.js";

/**
 * A button that opens a small panel, which closes on Escape, on a click elsewhere, and after a choice.
 *
 * @param {HTMLButtonElement} button
 * @param {string} label of the panel, for screen readers
 * @param {(close: () => void) => (Node | null)[]} build makes the content each time it opens
 */
export function menu(button, label, build) {
  const panel = element("div", { class: "gl-menu", role: "group", "aria-label": label, popover: "auto" });
  button.setAttribute("aria-haspopup", "true");
  button.setAttribute("aria-expanded", "false");
  button.addEventListener("click", () => (panel.matches(":popover-open") ? close() : open()));
  panel.addEventListener("toggle", (event) => {
    const closed = /** @type {ToggleEvent} */ (event).newState === "closed";
    button.setAttribute("aria-expanded", String(!closed));
    if (closed) panel.replaceChildren();
  });
  panel.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step || (event.target instanceof HTMLInputElement && event.target.type === "number")) return;
    event.preventDefault();
    const items = /** @type {HTMLElement[]} */ ([...panel.querySelectorAll("button:not(:disabled), input")]);
    const here = items.indexOf(/** @type {HTMLElement} */ (event.target));
    items[(here + step + items.length) % items.length]?.focus();
  });

  function open() {
    panel.replaceChildren(...build(close).filter((node) => node !== null));
    panel.showPopover({ source: button });
    place();
    /** @type {HTMLElement | null} */ (
      panel.querySelector("input, [aria-checked=true], button:not(:disabled)")
    )?.focus();
  }

  function close() {
    panel.hidePopover();
    button.focus();
  }

  /** Below the button if there is room, and always inside the window. */
  function place() {
    const [from, { width, height }] = [button.getBoundingClientRect(), panel.getBoundingClientRect()];
    const below = from.bottom + 4 + height <= innerHeight || from.top < height;
    panel.style.left = `${Math.max(8, Math.min(from.left, innerWidth - width - 8))}px`;
    panel.style.top = `${below ? Math.max(8, Math.min(from.bottom + 4, innerHeight - height - 8)) : from.top - 4 - height}px`;
  }

  return element("span", { class: "gl-holder" }, button, panel);
}

/**
 * A line of a menu: a title and an explanation.
 *
 * @param {string} title
 * @param {string} says
 * @param {() => void} onclick
 * @param {{ checked?: boolean, disabled?: boolean }} [state]
 */
export function choice(title, says, onclick, { checked, disabled = false } = {}) {
  const ticked = checked === undefined ? {} : { role: "radio", "aria-checked": String(checked) };
  return element(
    "button",
    { type: "button", class: "gl-choice", disabled, onclick, ...ticked },
    element("b", {}, title),
    says ? element("small", {}, says) : null,
  );
}

/** @param {string} text @param {(event: MouseEvent) => void} onclick @param {Record<string, any>} [properties] */
export function textButton(text, onclick, properties = {}) {
  return element("button", { type: "button", class: "gl-button", onclick, ...properties }, text);
}

/**
 * A button that shows the current choice and opens a menu.
 * @param {string} name of what is chosen
 */
export function chooserButton(name) {
  const value = element("b");
  const button = element("button", { type: "button", class: "gl-button gl-chooser" }, element("span", {}, name), value);
  return { button, set: (/** @type {string} */ text) => void (value.textContent = text) };
}
