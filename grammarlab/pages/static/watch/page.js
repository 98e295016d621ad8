/* Built from shared, watch by pages_src/bundle.js; do not edit. Source de36c1df06a378bc */

// shared/ahead.js
var Ahead = class {
  /** @type {Map<string, { value: any, answered: boolean }>} */
  #values = /* @__PURE__ */ new Map();
  /**
   * What was set last, or else what is confirmed.
   * @template T
   * @param {string} key
   * @param {T} confirmed
   * @returns {T}
   */
  of(key, confirmed) {
    const set = this.#values.get(key);
    return set ? set.value : confirmed;
  }
  /** @param {string} key @param {unknown} value @param {Promise<unknown>} answer nothing if the value is refused */
  async set(key, value, answer) {
    const mine = { value, answered: false };
    this.#values.set(key, mine);
    const accepted = await answer;
    mine.answered = true;
    if (!accepted && this.#values.get(key) === mine) this.#values.delete(key);
  }
  /** A state was told. */
  told() {
    for (const [key, { answered }] of this.#values) if (answered) this.#values.delete(key);
  }
};

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
var ICONS = {
  undo: "M6 3 2.5 6.5 6 10M3 6.5h6.5a3.5 3.5 0 0 1 0 7H6",
  redo: "M10 3l3.5 3.5L10 10M13 6.5H6.5a3.5 3.5 0 0 0 0 7H10",
  plus: "M8 3v10M3 8h10",
  minus: "M3 8h10",
  close: "M4 4l8 8M12 4l-8 8",
  fit: "M2.5 6V2.5H6M10 2.5h3.5V6M13.5 10v3.5H10M6 13.5H2.5V10",
  hand: "M5 8V4.2a1 1 0 0 1 2 0V7m0-3.8a1 1 0 0 1 2 0V7m0-2.8a1 1 0 0 1 2 0V8m0-1.8a1 1 0 0 1 2 0V10a4 4 0 0 1-4 4H8.4a3 3 0 0 1-2.3-1.1L3 9.2a1 1 0 0 1 1.5-1.3L5 8.4",
  bars: "M2.5 5.5h11M2.5 10.5h7",
  more: "M4 8h.01M8 8h.01M12 8h.01",
  previous: "M10 3 5 8l5 5",
  next: "M6 3l5 5-5 5",
  cube: "M8 2l5.2 3v6L8 14l-5.2-3V5zM8 8l5.2-3M8 8v6M8 8 2.8 5",
  up: "M5 7v6.5M5 7l2.6-4.8a1.3 1.3 0 0 1 2.3 1.2L9.3 6.5h3.2a1.2 1.2 0 0 1 1.2 1.5l-1.1 4.4a1.5 1.5 0 0 1-1.4 1.1H5M2.3 7H5v6.5H2.3z",
  down: "M5 9V2.5M5 9l2.6 4.8a1.3 1.3 0 0 0 2.3-1.2L9.3 9.5h3.2a1.2 1.2 0 0 0 1.2-1.5l-1.1-4.4a1.5 1.5 0 0 0-1.4-1.1H5M2.3 9H5V2.5H2.3z",
  keys: "M2 4.5h12v7H2zM4.5 7h.01M7 7h.01M9.5 7h.01M11.8 7h.01M5 9.3h6"
};
function icon(name) {
  return svg("svg", { class: "gl-icon", viewBox: "0 0 16 16", "aria-hidden": "true" }, svg("path", { d: ICONS[name] }));
}
function iconButton(name, label, onclick, keys) {
  const title = keys ? `${label} (${keys})` : label;
  return element(
    "button",
    { type: "button", class: "gl-button gl-quiet", title, "aria-label": label, onclick },
    icon(name)
  );
}

// shared/help.js
function makeHelp(keys, pointing) {
  const dialog = element(
    "dialog",
    { class: "gl-help", "aria-label": "Keys" },
    element(
      "header",
      { class: "gl-row" },
      element("h2", {}, "Keys"),
      element("span", { class: "gl-space" }),
      iconButton("close", "Close", () => dialog.close(), "Esc")
    ),
    pointing ? element("p", { class: "gl-hint" }, pointing) : null,
    element(
      "dl",
      { class: "gl-keys" },
      ...keys.flatMap(([key, does]) => [element("dt", {}, key), element("dd", {}, does)])
    )
  );
  const open = () => {
    if (!dialog.open) dialog.showModal();
  };
  const button = iconButton("keys", "Keys", open, "?");
  button.setAttribute("aria-haspopup", "dialog");
  dialog.addEventListener("click", (event) => event.target === dialog && dialog.close());
  dialog.addEventListener("keydown", (event) => {
    if (!dialog.open) return;
    event.stopPropagation();
    if (event.key === "?") dialog.close();
    else if (event.key !== "Tab") return;
    event.preventDefault();
  });
  return { button, element: dialog, open, close: () => dialog.close() };
}

// shared/menu.js
function textButton(text, onclick, properties = {}) {
  return element("button", { type: "button", class: "gl-button", onclick, ...properties }, text);
}

// shared/notes.js
var PASSING = 6e3;
var MOST = 3;
var LOST = "The connection to Python is lost. Trying again; is grammarlab still running?";
function makeNotes() {
  const notes = element("div", { class: "gl-notes", "aria-live": "polite" });
  const complaints = element("div", { class: "gl-notes", role: "alert" });
  const banner = element("div", { class: "gl-banner", role: "alert", hidden: true });
  const corner = element("div", { class: "gl-corner" }, notes, complaints);
  let before = null;
  corner.addEventListener("focusin", ({ relatedTarget }) => {
    if (relatedTarget instanceof HTMLElement && !corner.contains(relatedTarget)) before = relatedTarget;
  });
  function remove(box) {
    const hadFocus = box.matches(":focus-within");
    box.remove();
    if (!hadFocus) return;
    const another = corner.querySelector(".gl-note:not([hidden]) > button");
    (another ?? before)?.focus();
    if (document.activeElement !== document.body) return;
    const first = corner.parentElement?.querySelector("button:enabled, [tabindex='0']");
    first?.focus();
  }
  function note(where, text, style) {
    for (const box2 of where.children) if (box2.textContent === text) remove(box2);
    const box = element(
      "div",
      { class: `gl-note ${style}` },
      element("span", {}, text),
      iconButton("close", "Dismiss", () => remove(box))
    );
    where.append(box);
    while (where.childElementCount > MOST && where.firstElementChild) remove(where.firstElementChild);
    return box;
  }
  return {
    banner,
    element: corner,
    /** @param {string} text */
    say(text) {
      const box = note(notes, text, "");
      setTimeout(() => remove(box), PASSING);
    },
    /** @param {unknown} error or words */
    complain(error) {
      note(complaints, error instanceof Error ? error.message : String(error), "gl-bad");
    },
    /** What is complained about is over. */
    calm() {
      for (const box of [...complaints.children]) remove(box);
    },
    /** What lasts; empty for nothing. @param {string} text */
    announce(text) {
      banner.hidden = !text;
      if (banner.textContent !== text) banner.textContent = text;
    }
  };
}
function makeAsk(channel, notes, ready) {
  return async (command, parameters) => {
    await ready();
    try {
      const { result } = await channel.request(command, parameters);
      notes.calm();
      return result;
    } catch (error) {
      notes.complain(error);
    }
  };
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

// shared/rule.js
var INVITATION = "Click a part of the model to see the rule that made it.";
function makeRule(channel, mark) {
  let model = "";
  let asked = 0;
  let part = null;
  let number2 = null;
  let picking = Promise.resolve();
  const text = element("div", { class: "gl-rule-text", role: "status" });
  const panel = element(
    "section",
    { class: "gl-row gl-rule", "aria-label": "Rule of a part" },
    iconButton("previous", "Previous part", () => step(-1), "↑"),
    iconButton("next", "Next part", () => step(1), "↓"),
    text
  );
  function open(id) {
    model = id;
    clear();
  }
  function clear() {
    asked += 1;
    part = number2 = null;
    mark(null);
    text.replaceChildren(INVITATION);
  }
  function pick(triangle) {
    if (triangle === null) return clear();
    return picking = ask({ triangle });
  }
  async function step(by) {
    await picking;
    number2 = number2 === null ? Math.min(by, 0) : number2 + by;
    return ask({ part: number2 });
  }
  async function ask(which) {
    const turn = ++asked;
    if (!part) text.replaceChildren("looking…");
    try {
      const { result } = await channel.request("part", { model, ...which });
      if (turn !== asked) return;
      part = /** @type {ModelPart} */
      result;
      number2 = part.number;
      mark(part.triangles);
      text.replaceChildren(...inWords(part));
    } catch (error) {
      if (turn !== asked) return;
      number2 = part ? part.number : null;
      text.replaceChildren(`No rule: ${error instanceof Error ? error.message : error}`);
    }
  }
  return { element: panel, open, pick, step, clear };
}
function inWords({ number: number2, count, path }) {
  const [symbol, place] = path[path.length - 1];
  return [
    element("p", {}, element("b", {}, symbol), " ", element("code", {}, place), ` part ${number2 + 1} of ${count}`),
    element(
      "ol",
      { class: "gl-path", "aria-label": "Symbols above it" },
      ...path.slice(0, -1).map(([above, where]) => element("li", { title: where }, `${above} `, lineOf(where)))
    )
  ];
}
function lineOf(place) {
  return element("small", {}, place.split(":").slice(-2).join(":"));
}

// shared/tree.js
function makeTree(chosen) {
  const list = element("div", { class: "gl-tree", role: "tree", "aria-label": "Derivation tree" });
  let rows = [];
  let current = 0;
  function show(tree) {
    current = 0;
    rows = tree.map((entry, index) => ({
      entry,
      depth: entry[0],
      open: entry[0] < 4,
      parent: tree[index + 1]?.[0] > entry[0],
      row: rowOf(index, entry)
    }));
    list.replaceChildren(...rows.map(({ row }) => row));
    update();
  }
  function rowOf(index, [depth, symbol, note, line, details]) {
    const made = element(
      "div",
      { class: "gl-tree-row", role: "treeitem", "aria-level": depth + 1, title: details },
      element("span", { class: "gl-twist", "aria-hidden": "true", onclick: () => toggle(index) }),
      element("b", {}, symbol),
      element("span", { class: "gl-tree-note" }, note),
      element("span", { class: "gl-tree-details" }, details),
      element("span", { class: "gl-tree-line" }, line ? `line ${line}` : "")
    );
    made.style.setProperty("--depth", String(depth));
    made.addEventListener("click", () => select(index));
    return made;
  }
  function toggle(index) {
    rows[index].open = !rows[index].open;
    update();
  }
  function select(index) {
    current = index;
    update();
    rows[index].row.focus({ preventScroll: false });
    chosen(rows[index].entry);
  }
  function update() {
    let closed = Infinity;
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
      const by = moves[
        /** @type {keyof typeof moves} */
        event.key
      ];
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
      const { row } = rows[index];
      const end = row.offsetTop + row.offsetHeight - list.clientHeight;
      list.scrollTop = Math.max(Math.min(list.scrollTop, row.offsetTop), end);
    },
    /** @returns {number} index of the first row of a symbol, or -1 @param {string} symbol */
    rowOf: (symbol) => rows.findIndex(({ entry }) => entry[1] === symbol),
    /** @returns {number} index of the lowest row with a triangle, or -1 @param {number} triangle */
    rowAt: (triangle) => rows.findLastIndex(({ entry }) => hasTriangle(entry[5] ?? [], triangle))
  };
}
function hasTriangle(runs, triangle) {
  return runs.some((first, at) => at % 2 === 0 && first <= triangle && triangle < runs[at + 1]);
}

// shared/viewer_code.js
function viewerCode(channel) {
  let code = null;
  return async () => {
    code ??= load(channel);
    try {
      return await code;
    } catch (error) {
      code = null;
      throw error;
    }
  };
}
async function load(channel) {
  const { buffers } = await channel.request("viewer");
  const url = URL.createObjectURL(new Blob(buffers, { type: "text/javascript" }));
  try {
    return await import(
      /* @vite-ignore */
      url
    );
  } finally {
    URL.revokeObjectURL(url);
  }
}

// watch/controls.js
var HEXADECIMAL = /^#[0-9a-f]{6}([0-9a-f]{2})?$/i;
function makeControls(set) {
  const list = element("div", { class: "gl-plain" });
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Attributes" },
    element("h2", {}, "Attributes"),
    list
  );
  let drawn = "";
  let rows = [];
  function update({ controls, values }) {
    const now = JSON.stringify(controls);
    if (now !== drawn) {
      drawn = now;
      rows = controls.map((control) => makeRow(control, set));
      list.replaceChildren(...withGroups(rows));
    }
    section.hidden = !controls.length;
    for (const { control, show } of rows) show(values[control.name] ?? control.value, control.name in values);
  }
  return { element: section, update };
}
function withGroups(rows) {
  let group = "";
  return rows.flatMap(({ control, element: row }) => {
    const heading = control.group && control.group !== group ? [element("h3", {}, control.group)] : [];
    group = control.group;
    return [...heading, row];
  });
}
function makeRow(control, set) {
  const { name, label } = control;
  const give = (value) => set(name, value);
  const field = makeField(control, give);
  const reset = iconButton("undo", `${label}: as in the file`, () => set(name, null));
  return {
    control,
    element: element(
      "div",
      { class: "wa-row" },
      element("span", { class: "wa-label", title: name }, label),
      ...field.elements,
      reset
    ),
    /** @param {string} value @param {boolean} own whether it differs from the file */
    show(value, own) {
      reset.style.visibility = own ? "visible" : "hidden";
      field.show(value);
    }
  };
}
function makeField({ kind, label, choices, low, high, step }, give) {
  if (kind === "switch") {
    const box = element("input", {
      type: "checkbox",
      "aria-label": label,
      onchange: () => give(String(box.checked))
    });
    return { elements: [box], show: (value) => void (box.checked = value === "true") };
  }
  if (kind === "menu") {
    const options = ["", ...choices].map((value) => element("option", { value, hidden: !value }, value || "as drawn"));
    const menu = element(
      "select",
      { class: "gl-input", "aria-label": label, onchange: () => give(menu.value) },
      ...options
    );
    return { elements: [menu], show: (value) => void (menu.value = value) };
  }
  const typed = element("input", {
    class: kind === "number" ? "gl-input wa-number" : "gl-input",
    type: kind === "number" ? "number" : "text",
    step: "any",
    placeholder: "drawn",
    "aria-label": label,
    onchange: () => typed.value && give(typed.value)
  });
  if (kind === "color") return makeColor(label, typed, give);
  const isSlider = kind === "number" && low !== null && high !== null && high > low;
  if (!isSlider) return { elements: [typed], show: (value) => showUnlessTyping(typed, value) };
  const slider = element("input", {
    class: "wa-slider",
    type: "range",
    min: low,
    max: high,
    step: step && step > 0 ? step : "any",
    "aria-label": `${label}, slider`
  });
  slider.addEventListener("input", () => {
    const value = String(Number(slider.valueAsNumber.toPrecision(4)));
    typed.value = value;
    give(value);
  });
  return {
    elements: [slider, typed],
    show(value) {
      showUnlessTyping(typed, value);
      if (!slider.matches(":focus")) slider.value = value || String((low + high) / 2);
    }
  };
}
function makeColor(label, typed, give) {
  const palette = element("input", { class: "wa-color", type: "color", "aria-label": `${label}, palette` });
  palette.addEventListener("input", () => {
    typed.value = palette.value + rest(typed.value);
    give(typed.value);
  });
  return {
    elements: [palette, typed],
    show(value) {
      showUnlessTyping(typed, value);
      if (HEXADECIMAL.test(value)) palette.value = value.slice(0, 7).toLowerCase();
    }
  };
}
function rest(color) {
  return HEXADECIMAL.test(color) ? color.slice(7) : "";
}
function showUnlessTyping(input, value) {
  if (!input.matches(":focus")) input.value = value;
}

// watch/sheet.js
var MODELS = 16;
function makeSheet(ask, choose) {
  const urls = [];
  const tiles = Array.from(
    { length: MODELS },
    (_, model) => element("button", {
      type: "button",
      class: "wa-tile",
      "aria-label": `Model ${model}`,
      title: `Model ${model}`,
      onclick: () => choose(model)
    })
  );
  const grid = element(
    "div",
    { class: "wa-sheet", role: "group", "aria-label": "Sixteen models", hidden: true },
    ...tiles
  );
  const button = textButton("Sheet of sixteen", draw, { title: "Draw the first sixteen models of this seed (S)" });
  function draw() {
    for (const tile of tiles) tile.replaceChildren();
    for (const url of urls.splice(0)) URL.revokeObjectURL(url);
    grid.hidden = false;
    ask();
  }
  return {
    element: element("section", { class: "gl-card", "aria-label": "Sheet" }, button, grid),
    draw,
    /** @param {number} model that is shown large */
    mark: (model) => tiles.forEach((tile, at) => tile.setAttribute("aria-pressed", String(at === model))),
    /** @param {number} model @param {ArrayBuffer} bytes of its picture */
    take(model, bytes) {
      const url = URL.createObjectURL(new Blob([bytes], { type: "image/jpeg" }));
      urls.push(url);
      tiles[model].replaceChildren(element("img", { src: url, alt: "" }));
    }
  };
}

// watch/main.js
var KEYS = [
  ["R", "roll the dice: another seed"],
  ["N, B", "next model, previous model of this seed"],
  ["S", "draw sixteen models"],
  ["↑ ↓", "on the model: the rules of its parts, one after the other"],
  ["Arrows with Shift, + −", "on the model: turn it, zoom"],
  ["Home", "see the whole model"],
  ["Ctrl Z, Ctrl Y", "undo, redo what was chosen here"],
  ["?", "show or hide these keys"]
];
var TURN = Math.PI / 16;
var MOVES = {
  "Shift ArrowLeft": [-TURN, 0, 1],
  "Shift ArrowRight": [TURN, 0, 1],
  "Shift ArrowUp": [0, TURN, 1],
  "Shift ArrowDown": [0, -TURN, 1],
  "+": [0, 0, 1.25],
  "-": [0, 0, 0.8]
};
function build(root, channel, first) {
  let state = first;
  let shown = 0;
  let shownOf = "";
  let view = null;
  const ahead = new Ahead();
  const notes = makeNotes();
  const ask = makeAsk(channel, notes, async () => {
  });
  const help = makeHelp(KEYS, "Drag to turn, wheel or pinch to zoom; click a part for its rule and line.");
  const code = viewerCode(channel);
  const canvas = element("canvas", {
    class: "gl-canvas",
    tabIndex: 0,
    role: "application",
    "aria-label": "Model in 3D: Shift with arrows turns, + and − zoom, up and down name the rules of its parts"
  });
  const mistakes = element("div", { role: "alert" });
  const printed = element("div");
  const rule = makeRule(channel, (triangles) => {
    view?.mark(triangles);
    if (triangles) tree.go(tree.rowAt(triangles[0]));
  });
  const tree = makeTree(([, , , , , triangles]) => {
    rule.clear();
    view?.mark(triangles ?? null);
  });
  const controls = makeControls((name, value) => void ask("set", { name, value }));
  const sheet = makeSheet(
    () => void ask("sheet"),
    (model2) => want(state.seed, model2)
  );
  const title = element("h1", { class: "gl-name" });
  const status = element("span", { class: "gl-saved", role: "status" });
  const seed = number("Seed", (value) => want(value, state.model));
  const model = number("Model", (value) => want(state.seed, value));
  const undo = iconButton("undo", "Undo", () => void ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void ask("redo"), "Ctrl Y");
  const resizes = new ResizeObserver(() => view?.resize());
  resizes.observe(canvas);
  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      element("span", { class: "gl-space" }),
      status,
      undo,
      redo,
      iconButton("fit", "Whole model", () => view?.reset(), "Home"),
      help.button
    ),
    notes.banner,
    element(
      "div",
      { class: "gl-main" },
      element(
        "div",
        { class: "gl-left" },
        element("div", { class: "gl-room wa-room" }, canvas),
        element("div", { class: "wa-mistakes" }, mistakes, printed),
        element("div", { class: "wa-rule" }, rule.element)
      ),
      element(
        "aside",
        { class: "gl-side", "aria-label": "Seed and attributes" },
        element(
          "section",
          { class: "gl-card", "aria-label": "Seed" },
          element(
            "div",
            { class: "gl-row" },
            element("label", { class: "gl-row" }, "Seed", seed),
            textButton("⚄ Roll", () => void ask("roll"), { title: "Another seed (R)", "aria-label": "Roll the dice" })
          ),
          element(
            "div",
            { class: "gl-row" },
            element("label", { class: "gl-row" }, "Model", model),
            iconButton("previous", "Previous model", () => step(-1), "B"),
            iconButton("next", "Next model", () => step(1), "N")
          )
        ),
        sheet.element,
        element("section", { class: "gl-card wa-tree", "aria-label": "Tree" }, element("h2", {}, "Tree"), tree.element),
        controls.element
      )
    ),
    notes.element,
    help.element
  );
  channel.on("picture", ({ model: number2 }, [bytes]) => sheet.take(number2, bytes));
  function want(newSeed, newModel) {
    const wanted = { seed: Math.max(newSeed, 0), model: Math.max(newModel, 0) };
    void ahead.set("wanted", wanted, ask("want", wanted));
  }
  function step(by) {
    const { seed: now, model: here } = ahead.of("wanted", state);
    want(now, here + by);
  }
  const keyed = (event) => {
    const on = event.target;
    if (event.defaultPrevented) return;
    const isTyping = on instanceof HTMLElement && on.closest("input:not([type=range], [type=checkbox]), select, dialog[open]");
    if (isTyping || event.altKey) return;
    const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
    const movement = MOVES[`${event.shiftKey && key.startsWith("Arrow") ? "Shift " : ""}${key}`];
    if (event.ctrlKey || event.metaKey) {
      if (key === "z") void ask(event.shiftKey ? "redo" : "undo");
      else if (key === "y") void ask("redo");
      else return;
    } else if (on === canvas && movement) view?.move(...movement);
    else if (on === canvas && key === "ArrowUp") void rule.step(-1);
    else if (on === canvas && key === "ArrowDown") void rule.step(1);
    else if (key === "r") void ask("roll");
    else if (key === "n") step(1);
    else if (key === "b") step(-1);
    else if (key === "s") sheet.draw();
    else if (key === "Home") view?.reset();
    else if (key === "?") help.open();
    else return;
    event.preventDefault();
  };
  root.addEventListener("keydown", keyed);
  const loose = (event) => {
    if (event.target === document.body) keyed(event);
  };
  if (isAlone()) document.addEventListener("keydown", loose);
  async function load2() {
    const wanted = state.version;
    if (!wanted || wanted === shown) return;
    shown = wanted;
    const now = `${state.seed} ${state.model}`;
    try {
      const [{ result, buffers }, { show }] = await Promise.all([channel.request("model"), code()]);
      const damping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      view ??= show(canvas, { damping, picked: rule.pick });
      rule.open("");
      await view.load(buffers[0], now === shownOf);
      tree.show(result.tree);
      shownOf = now;
      Object.assign(canvas.dataset, { version: wanted, shown: now });
    } catch (error) {
      notes.complain(error);
    }
  }
  return {
    /** @param {State} now */
    update(now) {
      state = now;
      ahead.told();
      title.textContent = state.title;
      title.title = state.file;
      if (isAlone()) document.title = `${state.title} – grammarlab`;
      const errors = state.mistakes.filter(({ severity }) => severity === "error").length;
      status.dataset.state = state.busy || errors ? "saving" : "saved";
      status.textContent = state.busy ? "making…" : errors ? `${errors} ${errors === 1 ? "error" : "errors"}` : `${state.shapes.toLocaleString()} shapes`;
      const isNote = ({ severity }) => severity === "note";
      mistakes.replaceChildren(...state.mistakes.filter((each) => !isNote(each)).map(mistakeLine));
      printed.replaceChildren(...state.mistakes.filter(isNote).map(mistakeLine));
      for (const mark of mistakes.querySelectorAll("i")) showInLine(mark);
      root.classList.toggle("wa-stale", errors > 0);
      root.classList.toggle("wa-empty", !state.version && !state.busy);
      for (
        const [input, value] of
        /** @type {const} */
        [
          [seed, state.seed],
          [model, state.model]
        ]
      )
        if (!input.matches(":focus")) input.value = String(value);
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
      controls.update(state);
      sheet.mark(state.model);
      void load2();
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
    },
    close() {
      document.removeEventListener("keydown", loose);
      resizes.disconnect();
      view?.dispose();
      help.close();
    }
  };
}
function mistakeLine({ severity, message, hint, line, column, code }) {
  const place = line ? `line ${line}, column ${column}: ` : "";
  const [before, behind] = code;
  const shown = [`${before}${behind}
${before.replace(/[^\t]/g, " ")}`, element("i", {}, "^")];
  return element(
    "div",
    { class: `wa-mistake wa-${severity}` },
    element("b", {}, `${place}${message}`),
    before || behind ? element("pre", { tabindex: "0", role: "group", "aria-label": "Line with the mistake" }, ...shown) : null,
    hint ? element("small", {}, hint) : null
  );
}
function showInLine(mark) {
  const line = mark.parentElement;
  if (line) line.scrollLeft = mark.offsetLeft - line.clientWidth / 2;
}
function number(label, given) {
  const input = element("input", {
    class: "gl-input wa-whole",
    type: "number",
    min: "0",
    step: "1",
    "aria-label": label,
    onchange: () => input.checkValidity() && input.value !== "" && given(input.valueAsNumber)
  });
  return input;
}
var main_default = openPage("wa-page", "Making the first model…", build);
export {
  main_default as default
};
