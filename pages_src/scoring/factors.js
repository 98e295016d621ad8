import { element, iconButton } from "../shared/element.js";
import { menu, textButton } from "../shared/menu.js";
import { counted } from "./known.js";

/** @typedef {import("./types.js").Page} Page */
/** @typedef {import("./types.js").State} State */

/**
 * The factors. Scores belong to the active one; the product of all is one more view.
 * @param {Page} page
 * @returns {import("./types.js").Part}
 */
export function makeFactors(page) {
  const list = element("div", { class: "gl-factors", role: "group", "aria-label": "Factor of new scores" });
  const edit = menu(
    iconButton("more", "Rename or delete this factor", () => {}),
    "This factor",
    buildEdit,
  );
  const create = menu(
    iconButton("plus", "New factor", () => {}),
    "New factor",
    buildCreate,
  );

  /** @type {ReturnType<typeof makeTab>[]} */
  const tabs = [];
  const product = makeTab(() => void page.ahead.set("view", "product", page.ask("view", { kind: "product" })));
  product.element.title = "The product of all factors; new scores belong to one factor";

  /** Tabs are reused, so that none disappears under a finger. @param {State} state */
  function update({ factors, active, view }) {
    while (tabs.length < factors.length) {
      const index = tabs.length;
      tabs.push(makeTab(() => activate(page.state.factors[index])));
    }
    factors.forEach(({ name, labels }, index) => tabs[index].set(name, labels, view === "active" && name === active));
    product.set("product", null, view === "product");
    const shown = tabs.slice(0, factors.length).map((tab) => tab.element);
    if (factors.length > 1 || view === "product") shown.push(product.element);
    if (shown.length !== list.childElementCount) list.replaceChildren(...shown);
  }

  /** @param {import("./types.js").Factor} factor */
  async function activate({ id }) {
    const active = page.ahead.of("factor", page.factor().id);
    const view = page.ahead.of("view", page.state.view);
    await Promise.all([
      id === active ? null : page.ahead.set("factor", id, page.ask("factor_activate", { name: id })),
      view === "active" ? null : page.ahead.set("view", "active", page.ask("view", { kind: "active" })),
    ]);
  }

  /** @param {() => void} close */
  function buildCreate(close) {
    return [
      element(
        "p",
        {},
        "A factor is one aspect of what you like, such as shape or colour. Models are learned that all factors like: their scores are multiplied.",
      ),
      nameForm("Create", "", (name) => {
        close();
        void page.ask("factor_create", { name });
      }),
    ];
  }

  /** The menu concerns the factor that is active when it opens, even if another becomes active while it is open. @param {() => void} close */
  function buildEdit(close) {
    const { id, name, labels } = page.factor();
    const remove = textButton(
      `Delete “${name}” and its ${counted(labels, "score") || "scores"}`,
      () => {
        close();
        void page.ask("factor_delete", { name: id });
      },
      { class: "gl-button gl-danger", disabled: page.state.factors.length === 1 },
    );
    return [
      element("p", {}, `Factor “${name}”`),
      nameForm("Rename", name, (to) => {
        close();
        if (to !== name) void page.ask("factor_rename", { name: id, to });
      }),
      element("hr"),
      remove,
    ];
  }

  return { element: element("div", { class: "gl-row" }, list, edit, create), update };
}

/** @param {() => void} onclick */
function makeTab(onclick) {
  const [text, count] = [element("span"), element("small")];
  const tab = element("button", { type: "button", class: "gl-tab", onclick }, text, count);
  return {
    element: tab,
    /** @param {string} name @param {number | null} labels @param {boolean} pressed */
    set(name, labels, pressed) {
      text.textContent = name;
      count.hidden = labels === null;
      count.textContent = String(labels ?? "");
      count.ariaLabel = counted(labels ?? 0, "score") || "0 scores";
      tab.ariaPressed = String(pressed);
    },
  };
}

/** @param {string} verb @param {string} value @param {(name: string) => void} done */
function nameForm(verb, value, done) {
  const input = element("input", {
    class: "gl-input",
    value,
    maxLength: 60,
    required: true,
    "aria-label": "Name of the factor",
    placeholder: "name",
  });
  return element(
    "form",
    {
      class: "gl-row",
      onsubmit: (/** @type {Event} */ event) => {
        event.preventDefault();
        if (input.value.trim()) done(input.value.trim());
      },
    },
    input,
    element("button", { class: "gl-button gl-primary" }, verb),
  );
}
