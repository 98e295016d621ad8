import { element, svg } from "../shared/element.js";
import { paint, sharp } from "./paint.js";
import { metres } from "./size_row.js";

/** @typedef {import("./types.js").Face} Face */
/** @typedef {{ left: number, bottom: number, right: number, top: number }} Area in metres */

const MARGIN = { left: 40, right: 84, top: 44, bottom: 56 }; // pixels around the facade, with room to drag into
const SHARE = 0.93; // part of the rest that it takes

/**
 * The facade with its overlays: grid, selection, lasso, measures, handles.
 * @param {Face} page
 * @param {{ size: { width: number, height: number }, active: boolean, conflict: string }} drag
 */
export function makeStage(page, drag) {
  const canvas = element("canvas", { class: "fe-canvas", "aria-hidden": "true" });
  const over = svg("svg", { class: "fe-over", "aria-hidden": "true" });
  const face = element("div", {
    class: "fe-face",
    tabIndex: 0,
    role: "application",
    "aria-label": "Facade: arrow keys go from part to part",
  });
  const handles = { width: handle("Width"), height: handle("Height"), both: corner() };
  const alert = element("p", { class: "fe-conflict", role: "alert", hidden: true });
  const stage = element(
    "div",
    { class: "fe-stage" },
    canvas,
    over,
    face,
    handles.width,
    handles.height,
    handles.both,
    alert,
  );
  const view = { left: 0, bottom: 0, scale: 1 };
  /** @type {Area | null} */
  let lasso = null;
  let hovered = -1;
  let frame = 0;
  const resizes = new ResizeObserver(() => {
    if (!drag.active) fit();
    draw();
  });
  resizes.observe(stage);

  /** As large as the room allows. */
  function fit() {
    const { clientWidth, clientHeight } = stage;
    const { width, height } = page.state.drawing;
    const room = [clientWidth - MARGIN.left - MARGIN.right, clientHeight - MARGIN.top - MARGIN.bottom];
    view.scale = Math.max(0.01, SHARE * Math.min(room[0] / width, room[1] / height));
    view.left = MARGIN.left + (room[0] - width * view.scale) / 2;
    view.bottom = clientHeight - MARGIN.bottom - Math.max(0, (room[1] - height * view.scale) / 2);
  }

  function drawSoon() {
    frame ||= requestAnimationFrame(draw);
  }

  function draw() {
    frame = 0;
    const { clientWidth, clientHeight } = stage;
    if (!clientWidth) return;
    const { context, ratio } = sharp(canvas, clientWidth, clientHeight);
    const { drawing, colors } = page.state;
    const looks = { images: page.pictures.images, colors };
    const at = { left: view.left * ratio, bottom: view.bottom * ratio, scale: view.scale * ratio };
    paint(context, drawing, looks, at);
    const [right, top] = [view.left + drawing.width * view.scale, view.bottom - drawing.height * view.scale];
    drawOver(right, top);
    place(handles.width, right, (top + view.bottom) / 2, drawing.width);
    place(handles.height, (view.left + right) / 2, top, drawing.height);
    place(handles.both, right, top, 0);
    stage.classList.toggle("fe-bad", Boolean(drag.conflict));
    stage.classList.toggle("fe-gridding", page.gridding);
    alert.hidden = !drag.conflict;
    if (alert.textContent !== drag.conflict) alert.textContent = drag.conflict;
  }

  /** @param {number} right @param {number} top */
  function drawOver(right, top) {
    const { state } = page;
    const grid = state.grids.find(({ name }) => name === state.active);
    const marks = [
      svg("line", {
        class: "fe-ground",
        x1: 12,
        x2: stage.clientWidth - 12,
        y1: view.bottom + 0.5,
        y2: view.bottom + 0.5,
      }),
      ...measure(view.left, view.bottom + 22, right, view.bottom + 22, `${metres(state.drawing.width)} m`),
      ...measure(right + 30, view.bottom, right + 30, top, `${metres(state.drawing.height)} m`),
    ];
    // What moves is easier to see alone.
    for (const node of (!drag.active && grid?.nodes) || []) marks.push(box(node, "fe-element"));
    for (const { node } of state.locks) if (node) marks.push(box(node, "fe-locked"));
    if (hovered >= 0 && hovered < state.parent.length) marks.push(box(hovered, "fe-hovered"));
    if (page.selected >= 0) marks.push(box(page.selected, "fe-selected"));
    if (lasso) {
      const [x, y] = [view.left + lasso.left * view.scale, view.bottom - lasso.top * view.scale];
      const [width, height] = [(lasso.right - lasso.left) * view.scale, (lasso.top - lasso.bottom) * view.scale];
      marks.push(svg("rect", { class: "fe-lasso", x, y, width, height }));
    }
    over.replaceChildren(...marks);
  }

  /** @param {number} node @param {string} style */
  function box(node, style) {
    const [x, y, width, height] = boxOf(node);
    const [left, top] = [view.left + x * view.scale, view.bottom - (y + height) * view.scale];
    return svg("rect", {
      class: style,
      "data-node": node,
      x: left,
      y: top,
      width: width * view.scale,
      height: height * view.scale,
      rx: 1.5,
    });
  }

  /** @param {HTMLElement} where @param {number} x @param {number} y @param {number} metresNow */
  function place(where, x, y, metresNow) {
    where.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
    if (!metresNow) return;
    where.setAttribute("aria-valuenow", metresNow.toFixed(2));
    where.setAttribute("aria-valuetext", `${metres(metresNow)} metres`);
  }

  /** The leaf at a place of the screen, as its node, or -1. @param {{ clientX: number, clientY: number }} event */
  function leafAt(event) {
    return page.state.leaves.find((node) => isOn(node, event)) ?? -1;
  }

  /** @param {number} node @param {{ clientX: number, clientY: number }} event */
  function isOn(node, event) {
    const { x, y } = metresAt(event);
    const [left, bottom, width, height] = boxOf(node);
    return x >= left && x < left + width && y >= bottom && y < bottom + height;
  }

  /** Left, bottom, width and height in metres. @param {number} node */
  function boxOf(node) {
    return page.state.boxes.subarray(4 * node, 4 * node + 4);
  }

  /** @param {{ clientX: number, clientY: number }} event */
  function metresAt({ clientX, clientY }) {
    const room = stage.getBoundingClientRect();
    return { x: (clientX - room.left - view.left) / view.scale, y: (view.bottom - (clientY - room.top)) / view.scale };
  }

  return {
    element: stage,
    face,
    handles,
    view,
    fit,
    draw,
    drawSoon,
    leafAt,
    boxOf,
    metresAt,
    /** Whether a place of the screen lies in the selected part, which is not the whole. @param {PointerEvent} event */
    isOnSelected: (event) => page.selected > 0 && isOn(page.selected, event),
    /** @param {Area | null} area */
    lasso(area) {
      lasso = area;
      drawSoon();
    },
    /** @param {number} node */
    hover(node) {
      if (node === hovered) return;
      hovered = node;
      drawSoon();
    },
    close: () => resizes.disconnect(),
  };
}

/** @param {string} name */
function handle(name) {
  return element("div", {
    class: `fe-handle fe-handle-${name.toLowerCase()}`,
    tabIndex: 0,
    role: "slider",
    "aria-label": name,
    "aria-orientation": name === "Width" ? "horizontal" : "vertical",
    "aria-valuemin": "0",
    title: `${name}: drag, or use the arrow keys. Shift keeps the aspect ratio while dragging`,
  });
}

function corner() {
  return element("div", { class: "fe-handle fe-handle-both", title: "Drag to scale", "aria-hidden": "true" });
}

/** A line with its length. @param {number} x1 @param {number} y1 @param {number} x2 @param {number} y2 @param {string} text */
function measure(x1, y1, x2, y2, text) {
  const flat = y1 === y2;
  const [dx, dy] = flat ? [0, 4] : [4, 0];
  const [x, y] = [(x1 + x2) / 2, (y1 + y2) / 2];
  /** @type {Record<string, string>} */
  const turned = flat ? {} : { transform: `rotate(-90 ${x + 18} ${y})` };
  return [
    svg("path", {
      class: "fe-measure",
      d: `M${x1} ${y1}L${x2} ${y2}M${x1 - dx} ${y1 - dy}L${x1 + dx} ${y1 + dy}M${x2 - dx} ${y2 - dy}L${x2 + dx} ${y2 + dy}`,
    }),
    svg("text", { class: "fe-length", x: flat ? x : x + 18, y: flat ? y + 20 : y + 4, ...turned }, new Text(text)),
  ];
}
