import { element } from "./element.js";

/**
 * @typedef {[depth: number, symbol: string, note: string, line: number, details: string, triangles?: number[]]} Row
 *   the triangles below it: first ones and ends in turn
 */

/**
 * The derivation tree of a model: a list that opens and closes, with one row in the order of Tab.
 * @param {(row: Row) => void} chosen gets the row that a person goes to
 */
export function makeTree(chosen) {
  const list = element("div", { class: "gl-tree", role: "tree", "aria-label": "Derivation tree" });
  /** @type {{ row: HTMLElement, entry: Row, depth: number, open: boolean, parent: boolean }[]} */
  let rows = [];
  let current = 0;

  /** @param {Row[]} tree */
  function show(tree) {
    current = 0;
    rows = tree.map((entry, index) => ({
      entry,
      depth: entry[0],
      open: entry[0] < 4,
      parent: tree[index + 1]?.[0] > entry[0],
      row: rowOf(index, entry),
    }));
    list.replaceChildren(...rows.map(({ row }) => row));
    update();
  }

  /** @param {number} index @param {Row} entry */
  function rowOf(index, [depth, symbol, note, line, details]) {
    const made = element(
      "div",
      { class: "gl-tree-row", role: "treeitem", "aria-level": depth + 1, title: details },
      element("span", { class: "gl-twist", "aria-hidden": "true", onclick: () => toggle(index) }),
      element("b", {}, symbol),
      element("span", { class: "gl-tree-note" }, note),
      element("span", { class: "gl-tree-details" }, details),
      element("span", { class: "gl-tree-line" }, line ? `line ${line}` : ""),
    );
    made.style.setProperty("--depth", String(depth));
    made.addEventListener("click", () => select(index));
    return made;
  }

  /** @param {number} index */
  function toggle(index) {
    rows[index].open = !rows[index].open;
    update();
  }

  /** @param {number} index */
  function select(index) {
    current = index;
    update();
    rows[index].row.focus({ preventScroll: false });
    chosen(rows[index].entry);
  }

  function update() {
    let closed = Infinity; // depth below which nothing is shown
    rows.forEach(({ row, depth, open, parent }, index) => {
      if (depth <= closed) closed = Infinity;
      row.hidden = depth > closed;
      if (!row.hidden && parent && !open) closed = depth;
      if (parent) row.setAttribute("aria-expanded", String(open));
      row.tabIndex = index === current ? 0 : -1;
      row.setAttribute("aria-selected", String(index === current));
    });
  }

  list.addEventListener("keydown", (event) => {
    const { open, parent, depth } = rows[current] ?? {};
    const moves = { ArrowDown: 1, ArrowUp: -1 };
    if (event.key in moves && !event.shiftKey) {
      const by = moves[/** @type {keyof typeof moves} */ (event.key)];
      let next = current + by;
      while (rows[next]?.row.hidden) next += by;
      if (rows[next]) select(next);
    } else if (event.key === "ArrowRight" && parent && !open) toggle(current);
    else if (event.key === "ArrowLeft" && parent && open) toggle(current);
    else if (event.key === "ArrowLeft") {
      let above = current;
      while (above > 0 && rows[above].depth >= depth) above -= 1;
      select(above);
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });

  return {
    element: list,
    show,
    /**
     * Goes to a row, and opens what it lies in; the keyboard stays where it is.
     * @param {number} index of the row, -1 for none
     */
    go(index) {
      if (index < 0) return;
      let depth = rows[index].depth;
      for (let above = index; above >= 0 && depth > 0; above -= 1)
        if (rows[above].depth < depth) {
          rows[above].open = true;
          depth = rows[above].depth;
        }
      current = index;
      update();
      // Only the list scrolls: what is around it stays in view.
      const { row } = rows[index];
      const end = row.offsetTop + row.offsetHeight - list.clientHeight;
      list.scrollTop = Math.max(Math.min(list.scrollTop, row.offsetTop), end);
    },
    /** @returns {number} index of the first row of a symbol, or -1 @param {string} symbol */
    rowOf: (symbol) => rows.findIndex(({ entry }) => entry[1] === symbol),
    /** @returns {number} index of the lowest row with a triangle, or -1 @param {number} triangle */
    rowAt: (triangle) => rows.findLastIndex(({ entry }) => hasTriangle(entry[5] ?? [], triangle)),
  };
}

/** @param {number[]} runs first ones and ends in turn @param {number} triangle */
function hasTriangle(runs, triangle) {
  return runs.some((first, at) => at % 2 === 0 && first <= triangle && triangle < runs[at + 1]);
}
