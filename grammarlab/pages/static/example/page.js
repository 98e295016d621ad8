/* Built from shared, example by pages_src/bundle.js; do not edit. Source 54b0fef1b71db9b8 */

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

// example/stage.js
var STEP = 0.05;
var STEPS = { ArrowLeft: -STEP, ArrowDown: -STEP, ArrowRight: STEP, ArrowUp: STEP };
function makeStage(page, colorOf) {
  let dragged = null;
  const stage = (
    /** @type {SVGSVGElement} */
    svg("svg", { class: "ex-stage", role: "group", "aria-label": "Wall" })
  );
  stage.addEventListener("pointermove", move);
  stage.addEventListener("pointerup", drop);
  function draw() {
    const here = page.current();
    const [[left, bottom], [right, top]] = here.box;
    const focused = (
      /** @type {SVGElement | null} */
      stage.querySelector(":focus")?.dataset.key
    );
    const lines = { columns: [...here.columns], rows: [...here.rows] };
    if (dragged) lines[dragged.axis][dragged.line] = dragged.at;
    const flip = (at) => top - at;
    const image = svg("image", {
      ...{ x: left, y: 0, width: right - left, height: top - bottom, preserveAspectRatio: "none" }
    });
    const picture = page.pictureOf(here.name);
    if (picture) image.setAttribute("href", picture);
    const children = [image];
    if (here.kept) {
      children.push(
        ...here.labels.flatMap((row, r) => row.map((name, c) => cellOf(name, r, c, lines, flip))),
        ...here.elements.map(
          ([x0, y0, x1, y1]) => svg("rect", { class: "ex-element", x: x0, y: flip(y1), width: x1 - x0, height: y1 - y0 })
        )
      );
      for (
        const axis of
        /** @type {Axis[]} */
        ["columns", "rows"]
      )
        lines[axis].forEach((at, line) => children.push(...lineMarks({ axis, line }, at, lines, flip)));
    }
    stage.setAttribute("viewBox", `${left} 0 ${right - left} ${top - bottom}`);
    stage.replaceChildren(...children);
    if (focused) stage.querySelector(`[data-key="${focused}"]`)?.focus();
  }
  function cellOf(name, r, c, { rows, columns }, flip) {
    const cell = svg("rect", {
      class: `ex-cell ${isChosen(r, c) ? "ex-chosen" : ""}`,
      x: columns[c],
      y: flip(rows[r + 1]),
      width: Math.max(columns[c + 1] - columns[c], 0),
      height: Math.max(rows[r + 1] - rows[r], 0),
      fill: colorOf(name),
      tabindex: 0,
      role: "button",
      "data-key": `${r},${c}`,
      "aria-label": `${name}, row ${r + 1}, column ${c + 1}`,
      "aria-pressed": String(isChosen(r, c))
    });
    const press = ({ shiftKey }) => page.choose(shiftKey && page.cells ? [page.cells[0], page.cells[1], r, c] : [r, c, r, c]);
    cell.addEventListener("click", press);
    cell.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      press(event);
    });
    return cell;
  }
  function lineMarks({ axis, line }, at, lines, flip) {
    const across = axis === "columns" ? lines.rows : lines.columns;
    const [low, high] = [across[0], across[across.length - 1]];
    const ends = axis === "columns" ? { x1: at, x2: at, y1: flip(low), y2: flip(high) } : { x1: low, x2: high, y1: flip(at), y2: flip(at) };
    const isIt = () => page.line?.axis === axis && page.line.line === line;
    const grip = svg("line", {
      ...ends,
      class: `ex-grip ${isIt() ? "ex-chosen" : ""}`,
      tabindex: 0,
      role: "slider",
      "data-key": `${axis} ${line}`,
      "aria-label": `Line ${line} of ${axis}`,
      "aria-valuenow": at.toFixed(2)
    });
    grip.addEventListener("pointerdown", (event) => {
      event.preventDefault();
      stage.setPointerCapture(event.pointerId);
      dragged = { axis, line, at, start: at };
      page.choose(null, { axis, line });
    });
    grip.addEventListener("focus", () => {
      if (!isIt()) page.choose(null, { axis, line });
    });
    return [svg("line", { ...ends, class: "ex-line" }), grip];
  }
  function isChosen(r, c) {
    if (!page.cells) return false;
    const [r0, c0, r1, c1] = page.cells;
    return r >= Math.min(r0, r1) && r <= Math.max(r0, r1) && c >= Math.min(c0, c1) && c <= Math.max(c0, c1);
  }
  function move(event) {
    if (!dragged) return;
    const place = new DOMPoint(event.clientX, event.clientY).matrixTransform(stage.getScreenCTM()?.inverse());
    const here = page.current();
    const lines = here[dragged.axis];
    const at = dragged.axis === "columns" ? place.x : here.box[1][1] - place.y;
    const low = (lines[dragged.line - 1] ?? -Infinity) + STEP;
    const high = (lines[dragged.line + 1] ?? Infinity) - STEP;
    dragged.at = Math.min(Math.max(at, low), high);
    draw();
  }
  function drop() {
    if (!dragged) return;
    const { axis, line, at, start } = dragged;
    dragged = null;
    if (Math.abs(at - start) > 1e-3) page.moveLine({ axis, line }, at);
    else draw();
  }
  return {
    element: stage,
    draw,
    /** Cancels a drag. */
    cancel: () => void (dragged = null),
    /** Moves the chosen line a little. @param {string} key @returns {boolean} whether the key has a meaning */
    nudge(key) {
      const upright = key === "ArrowUp" || key === "ArrowDown";
      if (!page.line || !STEPS[key] || upright !== (page.line.axis === "rows")) return false;
      page.moveLine(page.line, page.current()[page.line.axis][page.line.line] + STEPS[key]);
      return true;
    }
  };
}

// example/main.js
function build(root, channel, first) {
  let seed = 0;
  const ahead = new Ahead();
  const pictures = /* @__PURE__ */ new Map();
  const page = {
    state: first,
    wall: first.main,
    cells: null,
    line: null,
    current: () => (
      /** @type {Wall} */
      page.state.walls.find((each) => each.name === page.wall)
    ),
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
    pictureOf(name2) {
      if (!pictures.has(name2)) void fetchPicture(name2);
      return pictures.get(name2);
    }
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
    if (!line || isJoining) return;
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
      lost
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
        figures
      )
    ),
    element("div", { class: "ex-body" }, result)
  );
  addEventListener("keydown", press);
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
  function split(axis, place) {
    const { cells, wall } = page;
    if (!cells) return;
    const lines = page.current()[axis];
    const at = Math.min(cells[place], cells[place + 2]);
    page.choose(null);
    void ask("split", { wall, axis, at: (lines[at] + lines[at + 1]) / 2 });
  }
  async function synthesize(number2) {
    seed = number2;
    figures.textContent = "…";
    const answer = await ask("synthesize", { rows: +rows.value, columns: +columns.value, seed });
    if (!answer) return void (figures.textContent = "");
    const { rows: high, columns: wide, energy, bound, watertight, triangles } = answer.result;
    const proven = energy === bound ? "proven to be the least" : `at least ${bound}`;
    figures.textContent = `${high} × ${wide} units, energy ${energy} (${proven}), ${triangles.toLocaleString()} triangles, ${watertight ? "closed" : "open"}`;
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
    about.textContent = line ? `A line between ${line.axis}, at ${here[line.axis][line.line]?.toFixed(2)} m: drag it, or use arrow keys.` : "Click a unit, Shift and click for several; drag lines and borders.";
    stage.draw();
  }
  function keepAhead() {
    for (const { name: name2, ...lines } of page.state.walls)
      for (
        const axis of
        /** @type {Axis[]} */
        ["rows", "columns"]
      )
        lines[axis].forEach((at, line) => lines[axis][line] = ahead.of(keyOf(name2, axis, line), at));
  }
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
  function labelItem(label, all, here) {
    const others = all.filter((each) => each !== label);
    const swatch = element("span", { class: "ex-swatch" });
    swatch.style.background = colorOf(label);
    const into = element(
      "select",
      { class: "gl-input", "aria-label": `Merge ${label} into`, hidden: !others.length },
      element("option", { value: "" }, "merge into…"),
      ...others.map((value) => element("option", { value }, value))
    );
    into.addEventListener("change", () => {
      if (into.value) void ask("merge", { wall: page.wall, label, into: into.value });
    });
    const often = here.labels.flat().filter((each) => each === label).length;
    return element("li", {}, swatch, element("span", {}, `${label} (${often})`), into);
  }
  function colorOf(label) {
    const place = page.state.names.indexOf(label);
    return `hsl(${(209 + 222.5 * place) % 360} 60% ${place % 3 === 2 ? 42 : 55}%)`;
  }
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
    }
  };
}
function keyOf(wall, axis, line) {
  return `${wall} ${axis} ${line}`;
}
function submit(text) {
  return element("button", { class: "gl-button gl-primary" }, text);
}
function number(label, value) {
  const properties = { type: "number", class: "gl-input gl-number", min: "1", max: "60", value, "aria-label": label };
  return element("input", properties);
}
function form(style, act, ...children) {
  const made = element("form", { class: style }, ...children);
  made.addEventListener("submit", (event) => {
    event.preventDefault();
    act();
  });
  return made;
}
function pngUrl(bytes) {
  return URL.createObjectURL(new Blob([bytes], { type: "image/png" }));
}
openPage("ex-page", "Opening the example…", build);
