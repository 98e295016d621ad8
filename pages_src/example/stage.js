import { svg } from "../shared/element.js";

/** @typedef {import("./types.js").Axis} Axis */
/** @typedef {import("./types.js").Line} Line */
/** @typedef {import("./types.js").Lines} Lines */
/** @typedef {import("./types.js").Page} Page */

const STEP = 0.05; // metres
/** @type {Record<string, number>} */
const STEPS = { ArrowLeft: -STEP, ArrowDown: -STEP, ArrowRight: STEP, ArrowUp: STEP };

/**
 * A wall with its units, and lines that can be dragged.
 * @param {Page} page
 * @param {(name: string) => string} colorOf a label
 */
export function makeStage(page, colorOf) {
  /** @type {Line & { at: number, start: number } | null} */
  let dragged = null;
  const stage = /** @type {SVGSVGElement} */ (svg("svg", { class: "ex-stage", role: "group", "aria-label": "Wall" }));
  stage.addEventListener("pointermove", move);
  stage.addEventListener("pointerup", drop);

  function draw() {
    const here = page.current();
    const [[left, bottom], [right, top]] = here.box;
    const focused = /** @type {SVGElement | null} */ (stage.querySelector(":focus"))?.dataset.key;
    /** @type {Lines} */
    const lines = { columns: [...here.columns], rows: [...here.rows] };
    if (dragged) lines[dragged.axis][dragged.line] = dragged.at;
    const flip = (/** @type {number} */ at) => top - at;
    const image = svg("image", {
      ...{ x: left, y: 0, width: right - left, height: top - bottom, preserveAspectRatio: "none" },
    });
    const picture = page.pictureOf(here.name);
    if (picture) image.setAttribute("href", picture);
    const children = [image];
    if (here.kept) {
      children.push(
        ...here.labels.flatMap((row, r) => row.map((name, c) => cellOf(name, r, c, lines, flip))),
        ...here.elements.map(([x0, y0, x1, y1]) =>
          svg("rect", { class: "ex-element", x: x0, y: flip(y1), width: x1 - x0, height: y1 - y0 }),
        ),
      );
      for (const axis of /** @type {Axis[]} */ (["columns", "rows"]))
        lines[axis].forEach((at, line) => children.push(...lineMarks({ axis, line }, at, lines, flip)));
    }
    stage.setAttribute("viewBox", `${left} 0 ${right - left} ${top - bottom}`);
    stage.replaceChildren(...children);
    if (focused) /** @type {SVGElement | null} */ (stage.querySelector(`[data-key="${focused}"]`))?.focus();
  }

  /** @param {string} name @param {number} r @param {number} c @param {Lines} lines @param {(at: number) => number} flip */
  function cellOf(name, r, c, { rows, columns }, flip) {
    const cell = svg("rect", {
      class: `ex-cell ${isChosen(r, c) ? "ex-chosen" : ""}`,
      x: columns[c],
      y: flip(rows[r + 1]),
      width: Math.max(columns[c + 1] - columns[c], 0),
      height: Math.max(rows[r + 1] - rows[r], 0),
      fill: colorOf(name),
      tabindex: 0,
      role: "button",
      "data-key": `${r},${c}`,
      "aria-label": `${name}, row ${r + 1}, column ${c + 1}`,
      "aria-pressed": String(isChosen(r, c)),
    });
    const press = (/** @type {MouseEvent | KeyboardEvent} */ { shiftKey }) =>
      page.choose(shiftKey && page.cells ? [page.cells[0], page.cells[1], r, c] : [r, c, r, c]);
    cell.addEventListener("click", press);
    cell.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      press(event);
    });
    return cell;
  }

  /** @param {Line} line @param {number} at @param {Lines} lines @param {(at: number) => number} flip */
  function lineMarks({ axis, line }, at, lines, flip) {
    const across = axis === "columns" ? lines.rows : lines.columns;
    const [low, high] = [across[0], across[across.length - 1]];
    const ends =
      axis === "columns"
        ? { x1: at, x2: at, y1: flip(low), y2: flip(high) }
        : { x1: low, x2: high, y1: flip(at), y2: flip(at) };
    const isIt = () => page.line?.axis === axis && page.line.line === line;
    const grip = svg("line", {
      ...ends,
      class: `ex-grip ${isIt() ? "ex-chosen" : ""}`,
      tabindex: 0,
      role: "slider",
      "data-key": `${axis} ${line}`,
      "aria-label": `Line ${line} of ${axis}`,
      "aria-valuenow": at.toFixed(2),
    });
    grip.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      stage.setPointerCapture(event.pointerId);
      dragged = { axis, line, at, start: at };
      page.choose(null, { axis, line });
    });
    grip.addEventListener("focus", () => {
      if (!isIt()) page.choose(null, { axis, line });
    });
    return [svg("line", { ...ends, class: "ex-line" }), grip];
  }

  /** @param {number} r @param {number} c */
  function isChosen(r, c) {
    if (!page.cells) return false;
    const [r0, c0, r1, c1] = page.cells;
    return r >= Math.min(r0, r1) && r <= Math.max(r0, r1) && c >= Math.min(c0, c1) && c <= Math.max(c0, c1);
  }

  /** @param {PointerEvent} event */
  function move(event) {
    if (!dragged) return;
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(stage.getScreenCTM()?.inverse());
    const here = page.current();
    const lines = here[dragged.axis];
    const at = dragged.axis === "columns" ? place.x : here.box[1][1] - place.y;
    const low = (lines[dragged.line - 1] ?? -Infinity) + STEP;
    const high = (lines[dragged.line + 1] ?? Infinity) - STEP;
    dragged.at = Math.min(Math.max(at, low), high);
    draw();
  }

  function drop() {
    if (!dragged) return;
    const { axis, line, at, start } = dragged;
    dragged = null;
    if (Math.abs(at - start) > 1e-3) page.moveLine({ axis, line }, at);
    else draw();
  }

  return {
    element: stage,
    draw,
    /** Cancels a drag. */
    cancel: () => void (dragged = null),
    /** Moves the chosen line a little. @param {string} key @returns {boolean} whether the key has a meaning */
    nudge(key) {
      const upright = key === "ArrowUp" || key === "ArrowDown";
      if (!page.line || !STEPS[key] || upright !== (page.line.axis === "rows")) return false;
      page.moveLine(page.line, page.current()[page.line.axis][page.line.line] + STEPS[key]);
      return true;
    },
  };
}
