import { element, iconButton } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { card, sizeRow } from "../stage/size_row.js";
import { aspectRow } from "./aspect.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").What} What */

/**
 * Sizes and locks of the facade and of what is selected, and the grids.
 * @param {Page} page
 * @param {{ toggleLock: (what: What, node?: number) => void, toggleGridding: () => void }} acts
 */
export function makePanel(page, acts) {
  const width = lockableRow(
    "Width",
    "width",
    (value) => resize(value, null),
    () => acts.toggleLock("width", 0),
  );
  const height = lockableRow(
    "Height",
    "height",
    (value) => resize(null, value),
    () => acts.toggleLock("height", 0),
  );
  const tied = element("input", { type: "checkbox", onchange: () => (page.tied = tied.checked) });
  const grids = element("ul", { class: "fe-grids", "aria-label": "Grids" });
  const gridding = textButton("Change by clicking", acts.toggleGridding, {
    title: "A click adds a part to the active grid, or removes it (G)",
  });
  const hint = element("p", { class: "gl-hint" });
  const part = element("div", { class: "fe-part" });
  const locks = element("ul", { class: "fe-locks", "aria-label": "Locks" });

  /** @param {number | null} wide @param {number | null} high */
  function resize(wide, high) {
    const { width: w, height: h } = page.state.drawing;
    const factor = page.tied ? (wide !== null ? wide / w : (high ?? h) / h) : 1;
    return page.ask("resize", { width: wide ?? w * factor, height: high ?? h * factor });
  }

  function update() {
    const { state } = page;
    width.set(state.drawing.width, isLocked(page, 0, "width"));
    height.set(state.drawing.height, isLocked(page, 0, "height"));
    gridding.setAttribute("aria-pressed", String(page.gridding));
    gridding.disabled = !state.active;
    hint.textContent = page.gridding
      ? `Click parts to add them to “${state.active}”, or to remove them.`
      : "Draw a rectangle on the facade to make a grid of the parts inside it.";
    updateGrids();
    updatePart();
    locks.replaceChildren(
      ...state.locks.map(({ node, what, words }) =>
        element(
          "li",
          { class: "gl-row" },
          textButton(words, () => page.select(node), { class: "gl-choice fe-name" }),
          iconButton("close", `Unlock: ${words}`, () => void page.ask("unlock", { node, what })),
        ),
      ),
    );
    locked.hidden = !state.locks.length;
  }

  let drawnGrids = "";
  function updateGrids() {
    const { grids: found, active } = page.state;
    const now = JSON.stringify([
      found.map(({ name, rows, columns, nodes }) => [name, rows, columns, nodes.length]),
      active,
    ]);
    if (now === drawnGrids) return;
    drawnGrids = now;
    grids.replaceChildren(
      ...found.map(({ name, rows, columns, nodes }) => {
        const size = `${rows} × ${columns}`;
        const empty = rows * columns - nodes.length;
        const label = `${name}, ${rows} rows, ${columns} columns${empty ? `, ${empty} empty places` : ""}`;
        return element(
          "li",
          { class: "fe-grid" },
          element(
            "button",
            {
              type: "button",
              class: "gl-choice fe-choose",
              "aria-label": label,
              title: label,
              "aria-pressed": String(name === active),
              onclick: () => void page.ask("choose", { grid: name }),
            },
            element("b", { class: "fe-name" }, name),
            element("small", {}, size),
          ),
          name === active ? iconButton("more", `Rename ${name}`, () => rename(name)) : null,
          name === active
            ? iconButton("close", `Delete grid ${name}`, () => void page.ask("delete", { grid: name }))
            : null,
        );
      }),
    );
  }

  /** @param {string} name */
  function rename(name) {
    const input = element("input", {
      class: "gl-input",
      value: name,
      maxLength: 100,
      "aria-label": `New name of ${name}`,
    });
    let done = false;
    const end = async (/** @type {boolean} */ keep) => {
      if (done) return;
      done = true;
      drawnGrids = "";
      if (keep && input.value.trim() && input.value !== name) await page.ask("rename", { grid: name, to: input.value });
      updateGrids();
    };
    input.addEventListener("keydown", (event) => {
      if (event.key === "Enter") void end(true);
      if (event.key === "Escape") void end(false);
    });
    input.addEventListener("blur", () => void end(true));
    const row = [...grids.children][page.state.grids.findIndex((grid) => grid.name === name)];
    row.replaceChildren(input);
    input.focus();
    input.select();
  }

  let drawnPart = "";
  function updatePart() {
    const { state, selected } = page;
    const now = JSON.stringify([selected, state.revision]);
    if (now === drawnPart) return;
    drawnPart = now;
    if (selected < 0) {
      part.replaceChildren(
        element(
          "p",
          { class: "gl-hint" },
          "Click a part to see its size or to lock it. Drag the selected part to move it with all aligned parts.",
        ),
      );
      return;
    }
    const [w, h] = state.boxes.subarray(4 * selected + 2, 4 * selected + 4);
    const set = (/** @type {What} */ what) => (/** @type {number} */ value) =>
      page.ask("give", { node: selected, what, value });
    const row = (/** @type {string} */ name, /** @type {What} */ what, /** @type {number} */ value) => {
      const made = lockableRow(name, `part ${what}`, set(what), () => acts.toggleLock(what));
      made.set(value, isLocked(page, selected, what));
      return made.element;
    };
    const [left, bottom] = state.boxes.subarray(4 * selected, 4 * selected + 2);
    const rows = [row("Width", "width", w), row("Height", "height", h)];
    if (selected) rows.push(row("From the left", "left", left), row("Above ground", "bottom", bottom));
    const tie = lockButton("part aspect", () => acts.toggleLock("aspect"));
    tie.set(isLocked(page, selected, "aspect"));
    const aspect = aspectRow(
      (least, most) => page.ask("give", { node: selected, what: "aspect", least, most }),
      tie.element,
    );
    aspect.set(lockOf(page, selected, "aspect")?.range ?? [w / h, w / h]);
    const grid = state.grids.find(({ name }) => name === state.active);
    const inside = grid?.nodes.includes(selected);
    part.replaceChildren(
      element("p", { class: "fe-label" }, nameOf(page, selected)),
      ...rows,
      aspect.element,
      element(
        "div",
        { class: "gl-row gl-wrap" },
        grid
          ? textButton(
              inside ? `Remove from ${grid.name}` : `Add to ${grid.name}`,
              () => void page.ask("press", { node: selected }),
            )
          : null,
        selected > 0 ? textButton("Enclosing part", () => page.select(state.parent[selected])) : null,
      ),
    );
  }

  const locked = card("Locks", locks);
  return {
    element: element(
      "section",
      { class: "gl-side fe-side", "aria-label": "Sizes and grids" },
      card(
        "Facade",
        width.element,
        height.element,
        element("label", { class: "gl-check" }, tied, "Keep the aspect ratio"),
      ),
      card(
        "Grids",
        grids,
        element(
          "div",
          { class: "gl-row gl-wrap" },
          gridding,
          textButton("Propose", () => void page.ask("propose"), {
            title: "Replace the grids by new ones, found from labels, places and sizes",
          }),
        ),
        hint,
      ),
      card("Selected part", part),
      locked,
    ),
    update,
  };
}

/**
 * A length that can be typed and locked.
 * @param {string} name
 * @param {string} label for screen readers
 * @param {(metres: number) => Promise<any>} typed
 * @param {() => void} lock
 */
function lockableRow(name, label, typed, lock) {
  const button = lockButton(label, lock);
  const row = sizeRow(name, label, typed, button.element);
  return {
    element: row.element,
    /** @param {number} value @param {boolean} locked */
    set(value, locked) {
      row.set(value);
      button.set(locked);
    },
  };
}

const LOCKED = "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 5 0v2.5";
const OPEN = "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 4.8-1";

/** @param {string} label @param {() => void} onclick */
function lockButton(label, onclick) {
  const button = iconButton("close", `Lock ${label}`, (event) => {
    event.preventDefault(); // a label would hand the click on to its input
    onclick();
  });
  return {
    element: button,
    /** @param {boolean} locked */
    set(locked) {
      button.querySelector("path")?.setAttribute("d", locked ? LOCKED : OPEN);
      button.setAttribute("aria-pressed", String(locked));
      button.classList.toggle("fe-open", !locked);
    },
  };
}

/** @param {Page} page @param {number} node @param {What} what */
export function isLocked(page, node, what) {
  return lockOf(page, node, what) !== undefined;
}

/** @param {Page} page @param {number} node @param {What} what */
function lockOf(page, node, what) {
  return page.state.locks.find((lock) => lock.node === node && lock.what === what);
}

/** @param {Page} page @param {number} node */
function nameOf({ state }, node) {
  if (node === 0) return "the whole facade";
  return state.names[node] < 0 ? "part without a name" : state.labels[state.names[node]];
}
