import { element } from "../shared/element.js";

/** @typedef {import("./types.js").Row} Row */

/**
 * The derivation tree of a model: a list that opens and closes, with one row in the order of Tab.
 * @param {(symbol: string) => void} chosen gets the symbol of a row; empty for none
 */
export function makeTree(chosen) {
  const list = element("div", { class: "vi-tree", role: "tree", "aria-label": "Derivation tree" });
  /** @type {{ row: HTMLElement, depth: number, symbol: string, open: boolean, parent: boolean }[]} */
  let rows = [];
  let current = 0;

  /** @param {Row[]} tree */
  function show(tree) {
    current = 0;
    rows = tree.map(([depth, symbol, note, line, details], index) => ({
      depth,
      symbol,
      open: depth < 4,
      parent: tree[index + 1]?.[0] > depth,
      row: rowOf(index, { depth, symbol, note, line, details }),
    }));
    list.replaceChildren(...rows.map(({ row }) => row));
    update();
  }

  /** @param {number} index @param {{ depth: number, symbol: string, note: string, line: number, details: string }} row */
  function rowOf(index, { depth, symbol, note, line, details }) {
    const made = element(
      "div",
      { class: "vi-row", role: "treeitem", "aria-level": depth + 1, title: details },
      element("span", { class: "vi-twist", "aria-hidden": "true", onclick: () => toggle(index) }),
      element("b", {}, symbol),
      element("span", { class: "vi-note" }, note),
      element("span", { class: "vi-details" }, details),
      element("span", { class: "vi-line" }, line ? `line ${line}` : ""),
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
    chosen(rows[index].symbol);
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
    /** Goes to the first row of a symbol, and opens what it lies in. @param {string} symbol */
    find(symbol) {
      const index = rows.findIndex((row) => row.symbol === symbol);
      if (index < 0) return;
      let depth = rows[index].depth;
      for (let above = index; above >= 0 && depth > 0; above -= 1)
        if (rows[above].depth < depth) {
          rows[above].open = true;
          depth = rows[above].depth;
        }
      select(index);
    },
  };
}
