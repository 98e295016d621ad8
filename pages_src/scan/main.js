import { element, svg } from "../shared/element.js";
import { textButton } from "../shared/menu.js";
import { openPage } from "../shared/open.js";

/** @typedef {{ elements: number[], template?: string, same?: boolean, ignore?: boolean, share?: string, value?: number }} Correction */
/** @typedef {{ box: number[], kind: string, sizes: Record<string, number>, uncertain: string, lines: number[][], points: number[][], color: string }} Fit of an element */

/**
 * @typedef {object} State the state that Python sends; see `grammarlab/pages/scan_desk.py`
 * @property {number} protocol
 * @property {string} title
 * @property {string} file that it is saved to
 * @property {boolean} busy
 * @property {boolean} undo whether something can be undone
 * @property {[number, number, number, number]} bounds left, bottom, right, top in metres
 * @property {Fit[]} elements
 * @property {string[]} templates
 * @property {string[]} words about kinds
 * @property {Correction[]} corrections
 */

/**
 * Fits over points, kinds by colour, and corrections by a person.
 * @param {HTMLElement} root
 * @param {import("../shared/channel.js").Channel} channel
 * @param {State} state
 */
function build(root, channel, state) {
  /** @type {Set<number>} */
  const chosen = new Set();
  const stage = svg("svg", { class: "sc-stage", role: "group", "aria-label": "Elements" });
  const title = element("h1", { class: "sc-title" });
  const status = element("span", { role: "status" });
  const lost = element("span", { class: "sc-bad", role: "alert" });
  const refused = element("span", { class: "sc-bad", role: "alert" });
  const selection = element("div", { role: "group", "aria-label": "Chosen" });
  const template = element("select", { class: "gl-input", "aria-label": "Template" });
  const words = element("ul", { "aria-label": "Kinds" });
  const doubts = element("ul", { "aria-label": "Uncertain" });
  const said = element("ul", { "aria-label": "Corrections" });
  const undo = textButton("Undo", () => ask("undo"));
  const none = textButton("None", () => {
    chosen.clear();
    draw();
  });
  root.replaceChildren(
    stage,
    element(
      "div",
      { class: "sc-panel" },
      ...[title, status, lost, refused],
      ...[element("h2", {}, "Chosen"), selection],
      row(
        template,
        textButton("Set template", () => correct({ template: template.value })),
      ),
      row(
        textButton("Same kind", () => correct({ same: true })),
        textButton("Ignore", () => correct({ ignore: true })),
        none,
      ),
      ...["width", "height"].map(shareRow),
      ...[element("h2", {}, "Corrections"), undo, said],
      ...[element("h2", {}, "Kinds"), words],
      ...[element("h2", {}, "Uncertain"), doubts],
    ),
  );

  /** @param {string} share width or height */
  function shareRow(share) {
    const value = element("input", {
      type: "number",
      class: "gl-input",
      min: "0.01",
      step: "0.01",
      placeholder: "any",
    });
    value.setAttribute("aria-label", `${share} in metres`);
    const act = () => correct(value.value ? { share, value: Number(value.value) } : { share });
    return row(value, textButton(`Share ${share}`, act));
  }

  /** @param {string} command @param {object} [parameters] */
  async function ask(command, parameters) {
    try {
      await channel.request(command, parameters);
      refused.textContent = "";
    } catch (error) {
      refused.textContent = error instanceof Error ? error.message : String(error);
      draw();
    }
  }

  /** @param {Omit<Correction, "elements">} correction of the chosen elements */
  function correct(correction) {
    if (!chosen.size) return void (refused.textContent = "Choose elements first: click on them.");
    return ask("correct", { correction: { elements: [...chosen].sort((a, b) => a - b), ...correction } });
  }

  /** @param {number} number */
  function toggle(number) {
    if (!chosen.delete(number)) chosen.add(number);
    draw();
  }

  function draw() {
    drawStage();
    title.textContent = state.title;
    status.textContent = state.busy ? "matching …" : `saved in ${state.file}`;
    selection.textContent =
      [...chosen].map((each) => `${each} (${state.elements[each].kind || "…"})`).join(", ") || "none";
    if (template.options.length !== state.templates.length)
      template.replaceChildren(...state.templates.map((name) => element("option", { value: name }, name)));
    undo.disabled = !state.undo;
    words.replaceChildren(...state.words.map((text) => element("li", {}, text)));
    doubts.replaceChildren(
      ...state.elements.flatMap(({ uncertain }, number) =>
        uncertain ? [element("li", {}, `element ${number}: ${uncertain}`)] : [],
      ),
    );
    said.replaceChildren(
      ...state.corrections.map((each, number) =>
        element(
          "li",
          {},
          `${told(each)} `,
          textButton("Take back", (event) => {
            /** @type {HTMLButtonElement} */ (event.currentTarget).disabled = true; // then the next one has its number
            void ask("remove", { number });
          }),
        ),
      ),
    );
  }

  function drawStage() {
    const [left, bottom, right, top] = state.bounds;
    const room = 0.02 * Math.max(right - left, top - bottom);
    // Numbers of a drawing have few digits, so it counts from the corner of the facade.
    const x = (/** @type {number} */ value) => (value - left).toFixed(4);
    const y = (/** @type {number} */ value) => (top - value).toFixed(4);
    stage.setAttribute("viewBox", `${-room} ${-room} ${right - left + 2 * room} ${top - bottom + 2 * room}`);
    const focused = stage.querySelector(":focus")?.getAttribute("data-element");
    stage.replaceChildren(
      ...state.elements.map((each, number) => {
        const lines = each.lines.map(([a, c, d, e]) => `M${x(a)} ${y(c)}L${x(d)} ${y(e)}`).join("");
        const dots = each.points.map(([a, c]) => `M${x(a)} ${y(c)}h0`).join("");
        const [l, b, r, t] = each.box;
        return svg(
          "g",
          {},
          boxOf(each, number, { x: x(l), y: y(t), width: r - l, height: t - b }),
          svg("path", { class: "sc-fit", d: lines, stroke: each.color }),
          svg("path", { class: "sc-points", d: dots }),
        );
      }),
    );
    if (focused) /** @type {SVGElement | null} */ (stage.querySelector(`[data-element="${focused}"]`))?.focus();
  }

  /** @param {Fit} fit @param {number} number @param {Record<string, string | number>} place */
  function boxOf({ kind, sizes, uncertain }, number, place) {
    const measures = Object.entries(sizes).map(([name, value]) => `${name} ${value}`);
    const says = [`element ${number}`, kind, measures.join(", "), uncertain].filter(Boolean).join(": ");
    const box = svg(
      "rect",
      {
        class: uncertain ? "sc-box sc-doubt" : "sc-box",
        ...place,
        role: "button",
        tabindex: 0,
        "aria-pressed": String(chosen.has(number)),
        "aria-label": says,
        "data-element": number,
      },
      svg("title", {}, new Text(says)),
    );
    box.addEventListener("click", () => toggle(number));
    box.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      toggle(number);
    });
    return box;
  }

  return {
    /** @param {State} now */
    update(now) {
      state = now;
      draw();
    },
    /** @param {boolean} connected */
    connection(connected) {
      lost.textContent = connected ? "" : "The connection is lost. Try again when it is restored.";
    },
  };
}

/** @param {HTMLElement[]} children */
function row(...children) {
  return element("div", { class: "sc-row" }, ...children);
}

/** @param {Correction} correction */
function told(correction) {
  const who = `elements ${correction.elements.join(", ")}`;
  if (correction.template) return `${who}: ${correction.template}`;
  if (correction.same) return `${who}: of one kind`;
  if (correction.ignore) return `${who}: left out`;
  return `${who}: one ${correction.share}${correction.value ? `, ${correction.value} m` : ""}`;
}

openPage("sc-page", "Opening the elements…", build);
