/* Built from shared, scan by pages_src/bundle.js; do not edit. Source 1092a1ca8a8ae6e3 */

// shared/element.js
function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === void 0 || value === null) continue;
    if (name === "class") made.className = value;
    else if (name in made) Reflect.set(made, name, value);
    else made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== void 0));
  return made;
}
function svg(tag, attributes = {}, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, String(value));
  made.append(...children);
  return made;
}

// shared/menu.js
function textButton(text, onclick, properties = {}) {
  return element("button", { type: "button", class: "gl-button", onclick, ...properties }, text);
}

// shared/channel.js
var ConnectionLost = class extends Error {
};
var Refusal = class extends Error {
};
var Channel = class {
  connected = false;
  #transport;
  /** Several views of one widget receive each other's answers, so every page marks its own requests. */
  #mark = Math.random().toString(36).slice(2, 8);
  #count = 0;
  /** @type {Map<string, { resolve: (answer: any) => void, reject: (error: Error) => void }>} */
  #waiting = /* @__PURE__ */ new Map();
  /** @type {Map<string, (message: any, buffers: ArrayBuffer[]) => void>} */
  #listeners = /* @__PURE__ */ new Map();
  /** @param {Transport} transport */
  constructor(transport) {
    this.#transport = transport;
    transport.listen((message, buffers) => this.#hear(message, buffers));
  }
  /** @param {string} event @param {(message: any, buffers: ArrayBuffer[]) => void} listener */
  on(event, listener) {
    this.#listeners.set(event, listener);
  }
  /** Begins; `changed` is called for every connection made or lost. @param {(connected: boolean) => void} changed */
  open(changed) {
    this.#transport.watch((connected) => {
      if (!connected) this.#abandon();
      if (connected === this.connected) return;
      this.connected = connected;
      changed(connected);
    });
  }
  /**
   * @param {string} command
   * @param {object} [parameters]
   * @param {ArrayBuffer[]} [buffers]
   * @returns {Promise<{ result: any, buffers: ArrayBuffer[] }>}
   * @throws {Refusal | ConnectionLost}
   */
  request(command, parameters = {}, buffers = []) {
    if (!this.connected) return Promise.reject(new ConnectionLost("There is no connection to Python."));
    const id = `${this.#mark}-${this.#count += 1}`;
    return new Promise((resolve, reject) => {
      this.#waiting.set(id, { resolve, reject });
      this.#transport.send({ ...parameters, id, command }, buffers);
    });
  }
  close() {
    this.#abandon();
    this.#transport.close();
  }
  /** @param {any} message @param {ArrayBuffer[]} buffers */
  #hear(message, buffers) {
    if (message.event) return this.#listeners.get(message.event)?.(message, buffers);
    const asked = this.#waiting.get(message.id);
    if (!asked) return;
    this.#waiting.delete(message.id);
    if (message.ok) asked.resolve({ result: message.result, buffers });
    else asked.reject(new Refusal(message.error));
  }
  #abandon() {
    const lost = [...this.#waiting.values()];
    this.#waiting.clear();
    for (const { reject } of lost) reject(new ConnectionLost("The connection to Python was lost before it answered."));
  }
};

// shared/transports.js
var SHORTEST_PAUSE = 300;
var LONGEST_PAUSE = 4e3;
function socketTransport(url) {
  let heard = () => {
  };
  let changed = () => {
  };
  let socket;
  let pause = SHORTEST_PAUSE;
  let timer = 0;
  function open() {
    socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    const take = assembler((message, buffers) => heard(message, buffers));
    socket.onmessage = ({ data }) => take(data);
    socket.onopen = () => {
      pause = SHORTEST_PAUSE;
      changed(true);
    };
    socket.onclose = () => {
      changed(false);
      timer = window.setTimeout(open, pause);
      pause = Math.min(2 * pause, LONGEST_PAUSE);
    };
  }
  return {
    send(message, buffers) {
      socket.send(JSON.stringify({ ...message, buffers: buffers.length }));
      for (const buffer of buffers) socket.send(buffer);
    },
    listen: (callback) => void (heard = callback),
    watch(callback) {
      changed = callback;
      open();
    },
    close() {
      clearTimeout(timer);
      socket.onclose = null;
      socket.close();
    }
  };
}
function socketUrl() {
  const { protocol, host, search } = location;
  return `${protocol === "https:" ? "wss" : "ws"}://${host}/socket${search}`;
}
function assembler(done) {
  let message = null;
  let buffers = [];
  return (frame) => {
    if (typeof frame === "string") [message, buffers] = [JSON.parse(frame), []];
    else buffers.push(frame);
    if (buffers.length === (message.buffers ?? 0)) done(message, buffers);
  };
}
function widgetTransport(model) {
  let forward = () => {
  };
  const callback = (message, buffers) => forward(message, buffers);
  model.on("msg:custom", callback);
  return {
    send: (message, buffers) => model.send(message, void 0, buffers),
    listen(heard) {
      forward = (message, buffers) => heard(message, (buffers ?? []).map(bytesOf));
    },
    watch: (changed) => changed(true),
    close: () => model.off("msg:custom", callback)
  };
}
function bytesOf(view) {
  if (view instanceof ArrayBuffer) return view;
  return (
    /** @type {ArrayBuffer} */
    view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength)
  );
}

// shared/open.js
var PROTOCOL = 1;
function openPage(style, waiting, build2, read = () => {
}) {
  function mount(host, transport) {
    const root = waitingRoot(style, waiting);
    host.append(root);
    const channel = new Channel(transport);
    let built = null;
    function follow(state, buffers) {
      if (!understands(root, state)) return;
      read(state, buffers);
      built ??= build2(root, channel, state);
      built.update(state);
    }
    channel.on("state", ({ state }, buffers) => follow(state, buffers));
    channel.open((connected) => built?.connection(connected));
    return {
      root,
      /** A notebook may show a widget long after its first state was told. */
      ask: () => channel.request("state").then(({ result, buffers }) => follow(result, buffers)),
      close() {
        built?.close?.();
        channel.close();
        root.remove();
      }
    };
  }
  const alone = isAlone() && document.getElementById("grammarlab");
  if (alone) mount(alone, socketTransport(socketUrl()));
  return {
    /** @param {{ model: any, el: HTMLElement }} widget */
    render({ model, el }) {
      const { root, ask, close } = mount(el, widgetTransport(model));
      root.dataset.lmSuppressShortcuts = "true";
      root.addEventListener("keydown", (event) => event.stopPropagation());
      ask().catch((error) => root.textContent = error.message);
      return close;
    }
  };
}
function isAlone() {
  return document.body.classList.contains("gl-alone");
}
function waitingRoot(style, waiting) {
  return element("div", { class: `gl-page ${style}` }, element("p", { class: "gl-wait", role: "status" }, waiting));
}
function understands(root, { protocol }) {
  if (protocol !== PROTOCOL) root.textContent = "This page and Python speak different versions. Reload the page.";
  return protocol === PROTOCOL;
}

// scan/main.js
function build(root, channel, state) {
  const chosen = /* @__PURE__ */ new Set();
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
        textButton("Set template", () => correct({ template: template.value }))
      ),
      row(
        textButton("Same kind", () => correct({ same: true })),
        textButton("Ignore", () => correct({ ignore: true })),
        none
      ),
      ...["width", "height"].map(shareRow),
      ...[element("h2", {}, "Corrections"), undo, said],
      ...[element("h2", {}, "Kinds"), words],
      ...[element("h2", {}, "Uncertain"), doubts]
    )
  );
  function shareRow(share) {
    const value = element("input", {
      type: "number",
      class: "gl-input",
      min: "0.01",
      step: "0.01",
      placeholder: "any"
    });
    value.setAttribute("aria-label", `${share} in metres`);
    const act = () => correct(value.value ? { share, value: Number(value.value) } : { share });
    return row(value, textButton(`Share ${share}`, act));
  }
  async function ask(command, parameters) {
    try {
      await channel.request(command, parameters);
      refused.textContent = "";
    } catch (error) {
      refused.textContent = error instanceof Error ? error.message : String(error);
      draw();
    }
  }
  function correct(correction) {
    if (!chosen.size) return void (refused.textContent = "Choose elements first: click on them.");
    return ask("correct", { correction: { elements: [...chosen].sort((a, b) => a - b), ...correction } });
  }
  function toggle(number) {
    if (!chosen.delete(number)) chosen.add(number);
    draw();
  }
  function draw() {
    drawStage();
    title.textContent = state.title;
    status.textContent = state.busy ? "matching …" : `saved in ${state.file}`;
    selection.textContent = [...chosen].map((each) => `${each} (${state.elements[each].kind || "…"})`).join(", ") || "none";
    if (template.options.length !== state.templates.length)
      template.replaceChildren(...state.templates.map((name) => element("option", { value: name }, name)));
    undo.disabled = !state.undo;
    words.replaceChildren(...state.words.map((text) => element("li", {}, text)));
    doubts.replaceChildren(
      ...state.elements.flatMap(
        ({ uncertain }, number) => uncertain ? [element("li", {}, `element ${number}: ${uncertain}`)] : []
      )
    );
    said.replaceChildren(
      ...state.corrections.map(
        (each, number) => element(
          "li",
          {},
          `${told(each)} `,
          textButton("Take back", (event) => {
            event.currentTarget.disabled = true;
            void ask("remove", { number });
          })
        )
      )
    );
  }
  function drawStage() {
    const [left, bottom, right, top] = state.bounds;
    const room = 0.02 * Math.max(right - left, top - bottom);
    const x = (value) => (value - left).toFixed(4);
    const y = (value) => (top - value).toFixed(4);
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
          svg("path", { class: "sc-points", d: dots })
        );
      })
    );
    if (focused) stage.querySelector(`[data-element="${focused}"]`)?.focus();
  }
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
        "data-element": number
      },
      svg("title", {}, new Text(says))
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
    }
  };
}
function row(...children) {
  return element("div", { class: "sc-row" }, ...children);
}
function told(correction) {
  const who = `elements ${correction.elements.join(", ")}`;
  if (correction.template) return `${who}: ${correction.template}`;
  if (correction.same) return `${who}: of one kind`;
  if (correction.ignore) return `${who}: left out`;
  return `${who}: one ${correction.share}${correction.value ? `, ${correction.value} m` : ""}`;
}
openPage("sc-page", "Opening the elements…", build);
