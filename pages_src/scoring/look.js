import { element, iconButton } from "../shared/element.js";
import { inWords, knownOf } from "./known.js";
import { makeRule } from "../shared/rule.js";
import { makeSteps, scaleOf, scoreOfKey } from "../shared/scale.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {ReturnType<typeof import("../viewer/viewer.js").show>} View */

/** Pixels that a finger moves to the side, at least, for another model. */
const SWIPE = 50;
/** Radians by which a key turns the model. */
const TURN = Math.PI / 16;
/** @type {Record<string, [number, number, number]>} what keys do to the view */
const MOVEMENTS = {
  "Shift ArrowLeft": [-TURN, 0, 1],
  "Shift ArrowRight": [TURN, 0, 1],
  "Shift ArrowUp": [0, TURN, 1],
  "Shift ArrowDown": [0, -TURN, 1],
  "+": [0, 0, 1.25],
  "-": [0, 0, 0.8],
};

/**
 * The large 3D view of one model.
 * @param {Page} page
 * @param {ReturnType<typeof import("../shared/viewer_code.js").viewerCode>} code
 * @param {() => void} backToGrid
 */
export function makeLook(page, code, backToGrid) {
  /** @type {View | null} */
  let view = null;
  let model = "";
  let canvas = element("canvas", {
    class: "gl-canvas",
    tabIndex: 0,
    "aria-label":
      "Model in 3D: drag or Shift with arrows to turn, wheel or + − to zoom, = to see all, click or ↑ ↓ for the rules of parts",
  });
  const room = element("div", { class: "gl-room" }, canvas);
  const title = element("h2", { class: "gl-look-title" });
  const note = element("p", { class: "gl-look-note", role: "status" });
  const rule = makeRule(page.channel, (triangles) => view?.mark(triangles));
  const steps = makeSteps(page, "Score of this model", (score) => page.score([model], score));
  const dialog = element(
    "dialog",
    { class: "gl-look", "aria-label": "Model in 3D" },
    element(
      "header",
      { class: "gl-row" },
      iconButton("previous", "Previous model", () => go(-1), "←"),
      iconButton("next", "Next model", () => go(1), "→"),
      title,
      element("span", { class: "gl-space" }),
      iconButton("fit", "Whole model", () => view?.reset()),
      iconButton("close", "Close", () => dialog.close(), "Esc"),
    ),
    room,
    note,
    rule.element,
    element("footer", {}, steps.element),
  );
  const resizes = new ResizeObserver(() => view?.resize());
  resizes.observe(room);

  dialog.addEventListener("close", () => {
    view?.dispose();
    view = null;
    canvas = /** @type {HTMLCanvasElement} */ (canvas.cloneNode()); // a canvas serves one view only
    room.replaceChildren(canvas);
    page.selection.only(Math.max(page.selection.order.indexOf(model), 0));
    backToGrid();
  });

  /** @type {PointerEvent | null} where a finger was put above or below the picture, in which fingers turn the model */
  let finger = null;
  dialog.addEventListener("pointerdown", (event) => {
    const isSwipe = event.pointerType === "touch" && event.isPrimary && !event.composedPath().includes(room);
    finger = isSwipe ? event : null;
  });
  dialog.addEventListener("pointercancel", () => (finger = null));
  dialog.addEventListener("pointerup", (event) => {
    if (event.pointerId !== finger?.pointerId) return;
    const [right, down] = [event.clientX - finger.clientX, event.clientY - finger.clientY];
    finger = null;
    if (Math.abs(right) >= Math.max(SWIPE, 2 * Math.abs(down))) void go(right < 0 ? 1 : -1);
  });

  dialog.addEventListener("keydown", (event) => {
    if (!dialog.open || event.ctrlKey || event.metaKey || event.altKey) return;
    const score = scoreOfKey(scaleOf(page), event.key);
    const movement = MOVEMENTS[`${event.shiftKey && event.key.startsWith("Arrow") ? "Shift " : ""}${event.key}`];
    if (movement) view?.move(...movement);
    else if (event.key === "=") view?.reset();
    else if (event.key === "ArrowUp") void rule.step(-1);
    else if (event.key === "ArrowDown") void rule.step(1);
    else if (event.key === "ArrowLeft") void go(-1);
    else if (event.key === "ArrowRight") void go(1);
    else if (score !== undefined) page.score([model], score);
    else return;
    event.preventDefault();
  });

  /** @param {string} id */
  async function open(id) {
    model = id;
    rule.open(id);
    if (!dialog.open) dialog.showModal();
    canvas.focus();
    update();
    note.textContent = "loading…";
    try {
      const [{ buffers }, { show }] = await Promise.all([page.channel.request("model", { model: id }), code()]);
      if (!dialog.open || model !== id) return;
      const damping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      view ??= show(canvas, { damping, picked: rule.pick });
      await view.load(buffers[0]);
      note.textContent = "";
    } catch (error) {
      if (model === id) note.textContent = `No 3D view: ${error instanceof Error ? error.message : error}`;
    }
  }

  /** @param {number} step */
  function go(step) {
    const order = [...new Set(page.selection.order)];
    const next = order[order.indexOf(model) + step];
    if (next) return open(next);
  }

  function update() {
    if (!dialog.open || !page.state.models[model]) return;
    const known = knownOf(page, model);
    title.textContent = inWords(known);
    steps.draw(known);
  }

  return {
    element: dialog,
    open,
    update,
    close() {
      resizes.disconnect();
      dialog.close();
    },
  };
}
