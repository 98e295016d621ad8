/* The page of `grammarlab facade open BUILDING.obj`: walls with units, lines and labels to correct, and a try of it. */
const shared = (/** @type {string} */ name) => import(`/${name}${location.search}`);
const [{ Channel }, { element, svg }, { socketTransport }] = await Promise.all(
  ["channel.js", "element.js", "transports.js"].map(shared),
);
const PROTOCOL = 1;
const STEP = 0.05;

const host = /** @type {HTMLElement} */ (document.getElementById("grammarlab"));
const channel = new Channel(socketTransport(`ws://${location.host}/socket${location.search}`));
let state = null;
let wall = "";
/** Cells [first row, first column, last row, last column], or a line { axis, line }. */
let chosen = null;
let dragged = null;
let seed = 0;
const pictures = new Map();
const parts = build();

channel.on("state", (message) => {
  if (message.state.protocol !== PROTOCOL)
    return void (host.textContent = "This page and Python speak different versions. Reload the page.");
  state = message.state;
  if (!state.walls.some((each) => each.name === wall)) wall = state.main;
  draw();
});
channel.open((connected) => {
  parts.connection.textContent = connected ? "" : "The connection is lost; changes wait until it is back.";
});

const current = () => state.walls.find((each) => each.name === wall);
const color = (name) => {
  const number = state.names.indexOf(name);
  return `hsl(${(209 + 222.5 * number) % 360} 60% ${number % 3 === 2 ? 42 : 55}%)`;
};

async function ask(command, parameters = {}) {
  try {
    const answer = await channel.request(command, parameters);
    parts.status.textContent = answer.result.words ? `undone or done again: ${answer.result.words}` : "";
    parts.status.className = "ex-note";
    return answer;
  } catch (error) {
    parts.status.textContent = error.message;
    parts.status.className = "ex-bad";
    draw();
    return null;
  }
}

function build() {
  const button = (text, label, onclick) =>
    element("button", { type: "button", class: "gl-button", "aria-label": label, onclick }, text);
  const number = (label, value) =>
    element("input", { type: "number", class: "gl-input gl-number", min: "1", max: "60", value, "aria-label": label });
  const made = {
    title: element("span", { class: "ex-title" }),
    saved: element("span", { class: "ex-saved", role: "status" }),
    undo: button("Undo", "Undo", () => ask("undo")),
    redo: button("Redo", "Redo", () => ask("redo")),
    save: button("Save", "Save", () => ask("save")),
    connection: element("span", { class: "ex-bad", role: "alert" }),
    walls: element("div", { class: "gl-row gl-wrap", role: "tablist", "aria-label": "Walls" }),
    stage: svg("svg", { class: "ex-stage", role: "group", "aria-label": "Wall" }),
    labels: element("ul", { class: "ex-labels", "aria-label": "Labels" }),
    name: element("input", { class: "gl-input", "aria-label": "Label of the chosen units", list: "ex-names" }),
    names: element("datalist", { id: "ex-names" }),
    exclude: button("Exclude this wall", "Exclude this wall", () => {
      ask(current().kept ? "exclude" : "include", { wall });
    }),
    remove: button("Remove line", "Remove line", () => {
      if (chosen?.axis) ask("join", { wall, axis: chosen.axis, line: chosen.line }).then(() => choose(null));
    }),
    addRow: button("Split row", "Split row", () => splitChosen("rows")),
    addColumn: button("Split column", "Split column", () => splitChosen("columns")),
    about: element("p", { class: "ex-note" }),
    status: element("p", { role: "status" }),
    rows: number("Rows", 8),
    columns: number("Columns", 10),
    again: button("Another", "Another result", () => synthesize(seed + 1)),
    result: element("img", { class: "ex-result", alt: "Example, labels, new labels and the new building", hidden: true }),
    figures: element("p", { class: "ex-note", "aria-label": "Result" }),
  };
  const relabel = (event) => {
    event.preventDefault();
    if (!Array.isArray(chosen)) return;
    const [row, column, last_row, last_column] = chosen;
    ask("relabel", { wall, row, column, last_row, last_column, label: made.name.value });
  };
  host.append(
    element(
      "div",
      { class: "gl-page ex-page" },
      element("header", { class: "ex-bar" }, made.title, made.undo, made.redo, made.save, made.saved, made.connection),
      element(
        "div",
        { class: "ex-body" },
        element("section", { class: "ex-wall", "aria-label": "Example" }, made.walls, made.stage, made.about),
        element(
          "section",
          { class: "ex-side", "aria-label": "Corrections" },
          made.status,
          element("h2", {}, "Labels"),
          made.labels,
          element(
            "form",
            { class: "gl-row", onsubmit: relabel },
            made.name,
            made.names,
            element("button", { class: "gl-button gl-primary" }, "Relabel"),
          ),
          element("h2", {}, "Lines and walls"),
          element("div", { class: "gl-row gl-wrap" }, made.remove, made.addRow, made.addColumn, made.exclude),
          element("h2", {}, "Try it"),
          element(
            "form",
            { class: "gl-row gl-wrap", onsubmit: (event) => (event.preventDefault(), synthesize(0)) },
            made.rows,
            "×",
            made.columns,
            element("button", { class: "gl-button gl-primary" }, "Synthesize"),
            made.again,
          ),
          made.figures,
        ),
      ),
      element("div", { class: "ex-body" }, made.result),
    ),
  );
  made.stage.addEventListener("pointermove", move);
  made.stage.addEventListener("pointerup", drop);
  addEventListener("keydown", keys);
  return made;
}

function splitChosen(axis) {
  if (!Array.isArray(chosen)) return;
  const lines = current()[axis];
  const at = Math.min(...(axis === "rows" ? [chosen[0], chosen[2]] : [chosen[1], chosen[3]]));
  ask("split", { wall, axis, at: (lines[at] + lines[at + 1]) / 2 }).then(() => choose(null));
}

async function synthesize(number) {
  seed = number;
  parts.figures.textContent = "…";
  const answer = await ask("synthesize", { rows: +parts.rows.value, columns: +parts.columns.value, seed });
  if (!answer) return void (parts.figures.textContent = "");
  const { rows, columns, energy, bound, watertight, triangles } = answer.result;
  const proven = energy === bound ? "proven least" : `at least ${bound}`;
  parts.figures.textContent =
    `${rows} × ${columns} units, energy ${energy} (${proven}), ` +
    `${triangles.toLocaleString()} triangles, ${watertight ? "closed" : "open"}`;
  show(parts.result, answer.buffers[0]);
}

function show(image, bytes) {
  URL.revokeObjectURL(image.src);
  image.src = URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
  image.hidden = false;
}

function choose(what) {
  chosen = what;
  draw();
}

function draw() {
  if (!state) return;
  const { walls, undo, redo } = state;
  const here = current();
  parts.title.textContent = state.title;
  parts.saved.textContent = state.saved ? `saved to ${state.file}` : "not saved";
  parts.undo.disabled = !undo;
  parts.redo.disabled = !redo;
  parts.undo.title = undo;
  parts.redo.title = redo;
  parts.walls.replaceChildren(
    ...walls.map((each) =>
      element(
        "button",
        {
          type: "button",
          class: `gl-tab ${each.kept ? "" : "ex-out"}`,
          role: "tab",
          "aria-selected": String(each.name === wall),
          onclick: () => ((wall = each.name), choose(null)),
        },
        `${each.name} ${each.rows.length - 1} × ${each.columns.length - 1}${each.kept ? "" : ", excluded"}`,
      ),
    ),
  );
  const names = [...new Set(here.labels.flat())];
  parts.labels.replaceChildren(...names.map((name) => labelItem(name, names, here)));
  parts.names.replaceChildren(...state.names.map((value) => element("option", { value })));
  parts.exclude.textContent = here.kept ? "Exclude this wall" : "Include this wall";
  parts.exclude.disabled = wall === state.main;
  parts.remove.disabled = !chosen?.axis;
  parts.addRow.disabled = parts.addColumn.disabled = !Array.isArray(chosen);
  if (Array.isArray(chosen)) {
    const label = here.labels[chosen[0]]?.[chosen[1]];
    if (label && document.activeElement !== parts.name) parts.name.value = label;
  }
  parts.about.textContent = chosen?.axis
    ? `A line between ${chosen.axis}, at ${here[chosen.axis][chosen.line]?.toFixed(2)} m: drag it, or use arrow keys.`
    : "Click a unit, Shift and click for several; drag lines and borders.";
  drawStage(here);
}

function labelItem(name, names, here) {
  const others = names.filter((each) => each !== name);
  const swatch = element("span", { class: "ex-swatch" });
  swatch.style.background = color(name);
  const menu = element(
    "select",
    {
      class: "gl-input",
      "aria-label": `Merge ${name} into`,
      hidden: !others.length,
      onchange: () => menu.value && ask("merge", { wall, label: name, into: menu.value }),
    },
    element("option", { value: "" }, "merge into…"),
    ...others.map((value) => element("option", { value }, value)),
  );
  const often = here.labels.flat().filter((each) => each === name).length;
  return element("li", {}, swatch, element("span", {}, `${name} (${often})`), menu);
}

function drawStage(here) {
  const [[left, bottom], [right, top]] = here.box;
  const focused = document.activeElement?.dataset?.key;
  const lines = { columns: [...here.columns], rows: [...here.rows] };
  if (dragged) lines[dragged.axis][dragged.line] = dragged.at;
  const flip = (at) => top - at;
  const children = [];
  const image = svg("image", { x: left, y: 0, width: right - left, height: top - bottom, preserveAspectRatio: "none" });
  if (pictures.has(wall)) image.setAttribute("href", pictures.get(wall));
  else fetchPicture(wall);
  children.push(image);
  if (here.kept) {
    here.labels.forEach((row, r) =>
      row.forEach((name, c) => {
        const cell = svg("rect", {
          class: `ex-cell ${isChosen(r, c) ? "ex-chosen" : ""}`,
          x: lines.columns[c],
          y: flip(lines.rows[r + 1]),
          width: Math.max(lines.columns[c + 1] - lines.columns[c], 0),
          height: Math.max(lines.rows[r + 1] - lines.rows[r], 0),
          fill: color(name),
          tabindex: 0,
          role: "button",
          "data-key": `${r},${c}`,
          "aria-label": `${name}, row ${r + 1}, column ${c + 1}`,
          "aria-pressed": String(isChosen(r, c)),
        });
        const press = (event) =>
          choose(event.shiftKey && Array.isArray(chosen) ? [chosen[0], chosen[1], r, c] : [r, c, r, c]);
        cell.addEventListener("click", press);
        cell.addEventListener("keydown", (event) => {
          if (event.key === "Enter" || event.key === " ") event.preventDefault(), press(event);
        });
        children.push(cell);
      }),
    );
    for (const [x0, y0, x1, y1] of here.elements)
      children.push(svg("rect", { class: "ex-element", x: x0, y: flip(y1), width: x1 - x0, height: y1 - y0 }));
    for (const axis of ["columns", "rows"])
      lines[axis].forEach((at, line) => children.push(...lineMarks(axis, line, at, lines, flip)));
  }
  parts.stage.setAttribute("viewBox", `${left} 0 ${right - left} ${top - bottom}`);
  parts.stage.replaceChildren(...children);
  if (focused) parts.stage.querySelector(`[data-key="${focused}"]`)?.focus();
}

function lineMarks(axis, line, at, lines, flip) {
  const across = axis === "columns" ? lines.rows : lines.columns;
  const [low, high] = [across[0], across[across.length - 1]];
  const ends =
    axis === "columns"
      ? { x1: at, x2: at, y1: flip(low), y2: flip(high) }
      : { x1: low, x2: high, y1: flip(at), y2: flip(at) };
  const grip = svg("line", {
    ...ends,
    class: `ex-grip ${chosen?.axis === axis && chosen.line === line ? "ex-chosen" : ""}`,
    tabindex: 0,
    role: "slider",
    "data-key": `${axis} ${line}`,
    "aria-label": `Line ${line} of ${axis}`,
    "aria-valuenow": at.toFixed(2),
  });
  grip.addEventListener("pointerdown", (event) => {
    event.preventDefault();
    parts.stage.setPointerCapture(event.pointerId);
    dragged = { axis, line, at, start: at };
    choose({ axis, line });
  });
  grip.addEventListener("focus", () => {
    if (chosen?.axis !== axis || chosen.line !== line) choose({ axis, line });
  });
  return [svg("line", { ...ends, class: "ex-line" }), grip];
}

const isChosen = (r, c) =>
  Array.isArray(chosen) &&
  r >= Math.min(chosen[0], chosen[2]) &&
  r <= Math.max(chosen[0], chosen[2]) &&
  c >= Math.min(chosen[1], chosen[3]) &&
  c <= Math.max(chosen[1], chosen[3]);

async function fetchPicture(name) {
  pictures.set(name, "");
  const answer = await ask("picture", { wall: name });
  if (!answer) return void pictures.delete(name);
  pictures.set(name, URL.createObjectURL(new Blob([answer.buffers[0]], { type: "image/png" })));
  draw();
}

function move(event) {
  if (!dragged) return;
  const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(parts.stage.getScreenCTM().inverse());
  const lines = current()[dragged.axis];
  const at = dragged.axis === "columns" ? place.x : current().box[1][1] - place.y;
  const low = (lines[dragged.line - 1] ?? -Infinity) + STEP;
  const high = (lines[dragged.line + 1] ?? Infinity) - STEP;
  dragged.at = Math.min(Math.max(at, low), high);
  drawStage(current());
}

function drop() {
  if (!dragged) return;
  const { axis, line, at, start } = dragged;
  dragged = null;
  if (Math.abs(at - start) > 1e-3) moveLine(axis, line, at);
  else draw();
}

/** Shown at once, so that a key that is held goes on from there; taken back where it is refused. */
async function moveLine(axis, line, at) {
  const lines = current()[axis];
  const before = lines[line];
  lines[line] = at;
  draw();
  if (await ask("move", { wall, axis, line, at })) return;
  lines[line] = before;
  draw();
}

function keys(event) {
  const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
  if ((event.ctrlKey || event.metaKey) && !typing && "zy".includes(event.key)) {
    event.preventDefault();
    ask(event.key === "z" ? "undo" : "redo");
  } else if ((event.ctrlKey || event.metaKey) && event.key === "s") {
    event.preventDefault();
    ask("save");
  } else if (event.key === "Escape") {
    dragged = null;
    choose(null);
  } else if (!typing && chosen?.axis) {
    const step = { ArrowLeft: -STEP, ArrowDown: -STEP, ArrowRight: STEP, ArrowUp: STEP }[event.key];
    const upright = event.key === "ArrowUp" || event.key === "ArrowDown";
    if (!step || upright !== (chosen.axis === "rows")) return;
    event.preventDefault();
    moveLine(chosen.axis, chosen.line, current()[chosen.axis][chosen.line] + step);
  }
}
