/* The page of `grammarlab facade open ELEMENTS`: fits over points, kinds by colour, and what a person says about them. */
const shared = (/** @type {string} */ name) => import(`/${name}${location.search}`);
const [{ Channel }, { element, svg }, { socketTransport }] = await Promise.all(
  ["channel.js", "element.js", "transports.js"].map(shared),
);
const PROTOCOL = 1;
const SIZES = ["width", "height"];

const host = /** @type {HTMLElement} */ (document.getElementById("grammarlab"));
const channel = new Channel(socketTransport(`ws://${location.host}/socket${location.search}`));
let state = null;
/** @type {Set<number>} */
const chosen = new Set();
const parts = build();

channel.on("state", (message) => {
  if (message.state.protocol !== PROTOCOL)
    return void (host.textContent = "This page and Python speak different versions. Reload the page.");
  state = message.state;
  draw();
});
channel.open((connected) => {
  parts.connection.textContent = connected ? "" : "The connection is lost; try again when it is back.";
});

async function ask(command, parameters = {}) {
  try {
    await channel.request(command, parameters);
    parts.error.textContent = "";
  } catch (error) {
    parts.error.textContent = error.message;
  }
}

function correct(correction) {
  if (!chosen.size) return void (parts.error.textContent = "Choose elements first: click on them.");
  return ask("correct", { correction: { elements: [...chosen].sort((a, b) => a - b), ...correction } });
}

function button(text, onclick) {
  return element("button", { type: "button", class: "gl-button", onclick }, text);
}

function build() {
  const template = element("select", { class: "gl-input", "aria-label": "Template" });
  const sizes = SIZES.map((name) => {
    const value = element("input", { type: "number", class: "gl-input", min: "0.01", step: "0.01", placeholder: "any", "aria-label": `${name} in metres` });
    const share = () => correct(value.value ? { share: name, value: Number(value.value) } : { share: name });
    return element("div", { class: "sc-row" }, value, button(`Share ${name}`, share));
  });
  const made = {
    stage: svg("svg", { class: "sc-stage", role: "group", "aria-label": "Elements" }),
    title: element("strong"),
    status: element("span", { role: "status" }),
    connection: element("span", { class: "sc-bad", role: "alert" }),
    error: element("span", { class: "sc-bad", role: "alert" }),
    selection: element("div", { "aria-label": "Chosen" }),
    template,
    words: element("ul", { "aria-label": "Kinds" }),
    doubts: element("ul", { "aria-label": "Uncertain" }),
    said: element("ul", { "aria-label": "Corrections" }),
    undo: button("Undo", () => ask("undo")),
  };
  const heading = (text) => element("h2", {}, text);
  const panel = element(
    "div", { class: "sc-panel" }, made.title, made.status, made.connection, made.error,
    heading("Chosen"), made.selection,
    element("div", { class: "sc-row" }, template, button("Set template", () => correct({ template: template.value }))),
    element("div", { class: "sc-row" }, button("Same kind", () => correct({ same: true })), button("Ignore", () => correct({ ignore: true })), button("None", () => { chosen.clear(); draw(); })),
    ...sizes, heading("Corrections"), made.undo, made.said, heading("Kinds"), made.words, heading("Uncertain"), made.doubts,
  );
  host.replaceChildren(made.stage, panel);
  return made;
}

function toggle(number) {
  if (!chosen.delete(number)) chosen.add(number);
  draw();
}

function draw() {
  const [left, bottom, right, top] = state.bounds;
  const room = 0.02 * Math.max(right - left, top - bottom);
  // Numbers of a drawing have few digits: it counts from the corner of the facade.
  const x = (value) => (value - left).toFixed(4);
  const y = (value) => (top - value).toFixed(4);
  parts.stage.setAttribute("viewBox", `${-room} ${-room} ${right - left + 2 * room} ${top - bottom + 2 * room}`);
  const focused = document.activeElement?.getAttribute("data-element");
  parts.stage.replaceChildren(
    ...state.elements.map((each, number) => {
      const [l, b, r, t] = each.box;
      const press = () => toggle(number);
      const sizes = Object.entries(each.sizes).map(([name, value]) => `${name} ${value}`).join(", ");
      const says = [`element ${number}`, each.kind, sizes, each.uncertain].filter(Boolean).join(": ");
      const box = svg("rect", {
        class: each.uncertain ? "sc-box sc-doubt" : "sc-box", x: x(l), y: y(t), width: r - l, height: t - b,
        role: "button", tabindex: 0, "aria-pressed": String(chosen.has(number)), "aria-label": says, "data-element": number,
      }, svg("title"));
      box.firstChild.textContent = says;
      box.addEventListener("click", press);
      box.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        event.preventDefault();
        press();
      });
      const lines = each.lines.map(([a, c, d, e]) => `M${x(a)} ${y(c)}L${x(d)} ${y(e)}`).join("");
      const dots = each.points.map(([a, c]) => `M${x(a)} ${y(c)}h0`).join("");
      return svg("g", {}, box, svg("path", { class: "sc-fit", d: lines, stroke: each.color }), svg("path", { class: "sc-points", d: dots }));
    }),
  );
  if (focused) parts.stage.querySelector(`[data-element="${focused}"]`)?.focus();
  parts.title.textContent = state.title;
  parts.status.textContent = state.busy ? "matching …" : `saved in ${state.file}`;
  parts.selection.textContent = chosen.size ? [...chosen].map((each) => `${each} (${state.elements[each].kind || "…"})`).join(", ") : "none";
  if (parts.template.options.length !== state.templates.length)
    parts.template.replaceChildren(...state.templates.map((name) => element("option", { value: name }, name)));
  parts.undo.disabled = !state.undo;
  parts.words.replaceChildren(...state.words.map((text) => element("li", {}, text)));
  parts.doubts.replaceChildren(
    ...state.elements.flatMap((each, number) => (each.uncertain ? [element("li", {}, `element ${number}: ${each.uncertain}`)] : [])),
  );
  parts.said.replaceChildren(
    ...state.corrections.map((each, number) =>
      element("li", {}, `${told(each)} `, button("Take back", () => ask("remove", { number }))),
    ),
  );
}

function told(correction) {
  const who = `elements ${correction.elements.join(", ")}`;
  if (correction.template) return `${who}: ${correction.template}`;
  if (correction.same) return `${who}: of one kind`;
  if (correction.ignore) return `${who}: left out`;
  return `${who}: one ${correction.share}${correction.value ? `, ${correction.value} m` : ""}`;
}
