import { Ahead } from "../shared/ahead.js";
import { element } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { openPage } from "../shared/open.js";
import { makeStage } from "./stage.js";

/** @typedef {import("./types.js").Axis} Axis */
/** @typedef {import("./types.js").Line} Line */
/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */
/** @typedef {import("./types.js").Wall} Wall */

/**
 * Walls with units, lines and labels to correct, and a trial building.
 * @param {HTMLElement} root
 * @param {import("../shared/channel.js").Channel} channel
 * @param {State} first
 */
function build(root, channel, first) {
  let seed = 0;
  const ahead = new Ahead(); // places of lines, and whether walls are kept
  /** @type {Map<string, string>} */
  const pictures = new Map();
  /** @type {Page} */
  const page = {
    state: first,
    wall: first.main,
    cells: null,
    line: null,
    current: () => /** @type {Wall} */ (page.state.walls.find((each) => each.name === page.wall)),
    choose(cells, line = null) {
      [page.cells, page.line] = [cells, line];
      draw();
    },
    /** Shown at once, so that a held key continues from there; restored if the change is refused. */
    async moveLine({ axis, line }, at) {
      const { wall } = page;
      const lines = page.current()[axis];
      const before = lines[line];
      lines[line] = at;
      draw();
      const answer = ask("move", { wall, axis, line, at });
      void ahead.set(keyOf(wall, axis, line), at, answer);
      if (await answer) return;
      lines[line] = before;
      draw();
    },
    pictureOf(name) {
      if (!pictures.has(name)) void fetchPicture(name);
      return pictures.get(name);
    },
  };
  const stage = makeStage(page, colorOf);
  const title = element("h1", { class: "ex-title" });
  const saved = element("span", { class: "ex-saved", role: "status" });
  const undo = textButton("Undo", () => ask("undo"));
  const redo = textButton("Redo", () => ask("redo"));
  const lost = element("span", { class: "ex-bad", role: "alert" });
  const walls = element("div", { class: "gl-row gl-wrap", role: "tablist", "aria-label": "Walls" });
  const about = element("p", { class: "ex-note" });
  const status = element("p", { role: "status" });
  const labels = element("ul", { class: "ex-labels", "aria-label": "Labels" });
  const name = element("input", { class: "gl-input", "aria-label": "Label of the chosen units" });
  const names = element("datalist", { id: "ex-names" });
  name.setAttribute("list", names.id);
  const exclude = textButton("Exclude this wall", () => {
    const { wall } = page;
    const kept = !ahead.of(wall, page.current().kept);
    void ahead.set(wall, kept, ask(kept ? "include" : "exclude", { wall }));
  });
  let isJoining = false;
  const remove = textButton("Remove line", async () => {
    const { line, wall } = page;
    if (!line || isJoining) return; // lines have other numbers afterwards
    isJoining = true;
    page.choose(null);
    await ask("join", { wall, ...line });
    isJoining = false;
  });
  const addRow = textButton("Split row", () => split("rows", 0));
  const addColumn = textButton("Split column", () => split("columns", 1));
  const rows = number("Rows", 8);
  const columns = number("Columns", 10);
  const again = textButton("Another", () => synthesize(seed + 1), { "aria-label": "Another result" });
  const figures = element("p", { class: "ex-note", role: "status", "aria-label": "Result" });
  const result = element("img", { class: "ex-result", hidden: true });
  result.alt = "Example, labels, new labels and the new building";

  root.replaceChildren(
    element(
      "header",
      { class: "ex-bar" },
      title,
      undo,
      redo,
      textButton("Save", () => ask("save")),
      saved,
      lost,
    ),
    element(
      "div",
      { class: "ex-body" },
      element("section", { class: "ex-wall", "aria-label": "Example" }, walls, stage.element, about),
      element(
        "section",
        { class: "ex-side", "aria-label": "Corrections" },
        status,
        element("h2", {}, "Labels"),
        labels,
        form("gl-row", relabel, name, names, submit("Relabel")),
        element("h2", {}, "Lines and walls"),
        element("div", { class: "gl-row gl-wrap" }, remove, addRow, addColumn, exclude),
        element("h2", {}, "Try it"),
        form("gl-row gl-wrap", () => synthesize(0), rows, "×", columns, submit("Synthesize"), again),
        figures,
      ),
    ),
    element("div", { class: "ex-body" }, result),
  );
  addEventListener("keydown", press);

  /** @param {string} command @param {object} [parameters] */
  async function ask(command, parameters = {}) {
    try {
      const answer = await channel.request(command, parameters);
      status.textContent = answer.result.words ? `undone or redone: ${answer.result.words}` : "";
      status.className = "ex-note";
      return answer;
    } catch (error) {
      status.textContent = error instanceof Error ? error.message : String(error);
      status.className = "ex-bad";
      draw();
      return null;
    }
  }

  /** @param {string} wall */
  async function fetchPicture(wall) {
    pictures.set(wall, "");
    const answer = await ask("picture", { wall });
    if (!answer) return void pictures.delete(wall);
    pictures.set(wall, pngUrl(answer.buffers[0]));
    draw();
  }

  function relabel() {
    if (!page.cells) return;
    const [row, column, last_row, last_column] = page.cells;
    void ask("relabel", { wall: page.wall, row, column, last_row, last_column, label: name.value });
  }

  /** Splits the chosen units in two. @param {Axis} axis @param {number} place of its number among `cells` */
  function split(axis, place) {
    const { cells, wall } = page;
    if (!cells) return;
    const lines = page.current()[axis];
    const at = Math.min(cells[place], cells[place + 2]);
    page.choose(null); // units have other numbers afterwards
    void ask("split", { wall, axis, at: (lines[at] + lines[at + 1]) / 2 });
  }

  /** @param {number} number */
  async function synthesize(number) {
    seed = number;
    figures.textContent = "…";
    const answer = await ask("synthesize", { rows: +rows.value, columns: +columns.value, seed });
    if (!answer) return void (figures.textContent = "");
    const { rows: high, columns: wide, energy, bound, watertight, triangles } = answer.result;
    const proven = energy === bound ? "proven to be the least" : `at least ${bound}`;
    figures.textContent =
      `${high} × ${wide} units, energy ${energy} (${proven}), ` +
      `${triangles.toLocaleString()} triangles, ${watertight ? "closed" : "open"}`;
    URL.revokeObjectURL(result.src);
    result.src = pngUrl(answer.buffers[0]);
    result.hidden = false;
  }

  function draw() {
    const { state, cells, line } = page;
    const here = page.current();
    title.textContent = state.title;
    saved.textContent = state.saved ? `saved to ${state.file}` : "not saved";
    undo.disabled = !state.undo;
    redo.disabled = !state.redo;
    undo.title = state.undo;
    redo.title = state.redo;
    walls.replaceChildren(...state.walls.map(wallTab));
    const known = [...new Set(here.labels.flat())];
    labels.replaceChildren(...known.map((each) => labelItem(each, known, here)));
    names.replaceChildren(...state.names.map((value) => element("option", { value })));
    exclude.textContent = here.kept ? "Exclude this wall" : "Include this wall";
    exclude.disabled = page.wall === state.main;
    remove.disabled = !line;
    addRow.disabled = addColumn.disabled = !cells;
    const label = cells && here.labels[cells[0]]?.[cells[1]];
    if (label && document.activeElement !== name) name.value = label;
    about.textContent = line
      ? `A line between ${line.axis}, at ${here[line.axis][line.line]?.toFixed(2)} m: drag it, or use arrow keys.`
      : "Click a unit, Shift and click for several; drag lines and borders.";
    stage.draw();
  }

  /** Lines that were moved on since stay where they are. */
  function keepAhead() {
    for (const { name, ...lines } of page.state.walls)
      for (const axis of /** @type {Axis[]} */ (["rows", "columns"]))
        lines[axis].forEach((at, line) => (lines[axis][line] = ahead.of(keyOf(name, axis, line), at)));
  }

  /** @param {Wall} wall */
  function wallTab(wall) {
    const tab = element("button", { type: "button", class: `gl-tab ${wall.kept ? "" : "ex-out"}`, role: "tab" });
    tab.setAttribute("aria-selected", String(wall.name === page.wall));
    tab.textContent = `${wall.name} ${wall.rows.length - 1} × ${wall.columns.length - 1}${wall.kept ? "" : ", excluded"}`;
    tab.addEventListener("click", () => {
      page.wall = wall.name;
      page.choose(null);
    });
    return tab;
  }

  /** @param {string} label @param {string[]} all @param {Wall} here */
  function labelItem(label, all, here) {
    const others = all.filter((each) => each !== label);
    const swatch = element("span", { class: "ex-swatch" });
    swatch.style.background = colorOf(label);
    const into = element(
      "select",
      { class: "gl-input", "aria-label": `Merge ${label} into`, hidden: !others.length },
      element("option", { value: "" }, "merge into…"),
      ...others.map((value) => element("option", { value }, value)),
    );
    into.addEventListener("change", () => {
      if (into.value) void ask("merge", { wall: page.wall, label, into: into.value });
    });
    const often = here.labels.flat().filter((each) => each === label).length;
    return element("li", {}, swatch, element("span", {}, `${label} (${often})`), into);
  }

  /** @param {string} label */
  function colorOf(label) {
    const place = page.state.names.indexOf(label);
    return `hsl(${(209 + 222.5 * place) % 360} 60% ${place % 3 === 2 ? 42 : 55}%)`;
  }

  /** @param {KeyboardEvent} event */
  function press(event) {
    const typing = event.target instanceof HTMLInputElement || event.target instanceof HTMLSelectElement;
    const command = event.ctrlKey || event.metaKey;
    if (command && !typing && "zy".includes(event.key)) void ask(event.key === "z" ? "undo" : "redo");
    else if (command && event.key === "s") void ask("save");
    else if (event.key === "Escape") {
      stage.cancel();
      return page.choose(null);
    } else if (typing || !stage.nudge(event.key)) return;
    event.preventDefault();
  }

  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      ahead.told();
      keepAhead();
      if (!state.walls.some((each) => each.name === page.wall)) page.wall = state.main;
      draw();
    },
    /** @param {boolean} connected */
    connection(connected) {
      lost.textContent = connected ? "" : "The connection is lost; changes wait until it is back.";
    },
  };
}

/** @param {string} wall @param {Axis} axis @param {number} line */
function keyOf(wall, axis, line) {
  return `${wall} ${axis} ${line}`;
}

/** @param {string} text */
function submit(text) {
  return element("button", { class: "gl-button gl-primary" }, text);
}

/** @param {string} label @param {number} value */
function number(label, value) {
  const properties = { type: "number", class: "gl-input gl-number", min: "1", max: "60", value, "aria-label": label };
  return element("input", properties);
}

/** @param {string} style @param {() => unknown} act @param {(Node | string)[]} children */
function form(style, act, ...children) {
  const made = element("form", { class: style }, ...children);
  made.addEventListener("submit", (event) => {
    event.preventDefault();
    act();
  });
  return made;
}

/** @param {ArrayBuffer} bytes of a picture */
function pngUrl(bytes) {
  return URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
}

openPage("ex-page", "Opening the example…", build);
