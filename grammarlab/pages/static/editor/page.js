/* Built from shared, stage, editor by pages_src/bundle.js; do not edit. Source 39110528100d5d35 */

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

// shared/menu.js
function menu(button, label, build2) {
  const panel = element("div", { class: "gl-menu", role: "group", "aria-label": label, popover: "auto" });
  button.setAttribute("aria-haspopup", "true");
  button.setAttribute("aria-expanded", "false");
  button.addEventListener("click", () => panel.matches(":popover-open") ? close() : open());
  panel.addEventListener("toggle", (event) => {
    const closed = (
      /** @type {ToggleEvent} */
      event.newState === "closed"
    );
    button.setAttribute("aria-expanded", String(!closed));
    if (closed) panel.replaceChildren();
  });
  panel.addEventListener("keydown", (event) => {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (!step || event.target instanceof HTMLInputElement && event.target.type === "number") return;
    event.preventDefault();
    const items = (
      /** @type {HTMLElement[]} */
      [...panel.querySelectorAll("button:not(:disabled), input")]
    );
    const here = items.indexOf(
      /** @type {HTMLElement} */
      event.target
    );
    items[(here + step + items.length) % items.length]?.focus();
  });
  function open() {
    panel.replaceChildren(...build2(close).filter((node) => node !== null));
    panel.showPopover({ source: button });
    place();
    panel.querySelector("input, [aria-checked=true], button:not(:disabled)")?.focus();
  }
  function close() {
    panel.hidePopover();
    button.focus();
  }
  function place() {
    const [from, { width, height }] = [button.getBoundingClientRect(), panel.getBoundingClientRect()];
    const below = from.bottom + 4 + height <= innerHeight || from.top < height;
    panel.style.left = `${Math.max(8, Math.min(from.left, innerWidth - width - 8))}px`;
    panel.style.top = `${below ? Math.max(8, Math.min(from.bottom + 4, innerHeight - height - 8)) : from.top - 4 - height}px`;
  }
  return element("span", { class: "gl-holder" }, button, panel);
}
function choice(title, says, onclick, { checked, disabled = false } = {}) {
  const ticked = checked === void 0 ? {} : { role: "radio", "aria-checked": String(checked) };
  return element(
    "button",
    { type: "button", class: "gl-choice", disabled, onclick, ...ticked },
    element("b", {}, title),
    says ? element("small", {}, says) : null
  );
}
function textButton(text, onclick, properties = {}) {
  return element("button", { type: "button", class: "gl-button", onclick, ...properties }, text);
}

// shared/frame.js
function makeFrame(root, page, { notes, help, kinds, settle, beside, left, panel }) {
  const title = element("h1", { class: "gl-name" });
  const saved = element("span", { class: "gl-saved", role: "status" });
  const undo = iconButton("undo", "Undo", () => void page.ask("undo"), "Ctrl Z");
  const redo = iconButton("redo", "Redo", () => void page.ask("redo"), "Ctrl Y");
  const exports = menu(
    element("button", { type: "button", class: "gl-button gl-chooser" }, "Export"),
    "Export",
    (close) => page.state.formats.map(
      (format) => choice(format.toUpperCase(), kinds[format] ?? "", async () => {
        close();
        const written = await page.ask("export", { format });
        if (written) notes.say(`Written to ${written.file}`);
      })
    )
  );
  async function save() {
    await settle();
    const written = await page.ask("save");
    if (written) notes.say(`Saved to ${written.file}`);
  }
  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      ...beside,
      element("span", { class: "gl-space" }),
      saved,
      undo,
      redo,
      exports,
      textButton("Save", save, { class: "gl-button gl-primary", title: "Save (Ctrl S)" }),
      help.button
    ),
    notes.banner,
    element("div", { class: "gl-main" }, element("div", { class: "gl-left" }, ...left), panel),
    notes.element,
    help.element
  );
  addEventListener("beforeunload", (event) => page.state.lost && event.preventDefault());
  return {
    save,
    update() {
      const { state } = page;
      title.textContent = state.title;
      title.title = state.file;
      document.title = `${state.title} – grammarlab`;
      saved.textContent = state.saved && state.revision ? "saved" : state.lost ? "not saved yet" : "";
      saved.dataset.state = state.lost ? "saving" : "saved";
      undo.disabled = !state.undo;
      undo.title = state.undo ? `Undo: ${state.undo} (Ctrl Z)` : "Nothing to undo";
      redo.disabled = !state.redo;
      redo.title = state.redo ? `Redo: ${state.redo} (Ctrl Y)` : "Nothing to redo";
    }
  };
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

// shared/notes.js
var PASSING = 6e3;
var MOST = 3;
var LOST = "The connection to Python is lost. Trying again; is grammarlab still running?";
function makeNotes() {
  const notes = element("div", { class: "gl-notes", "aria-live": "polite" });
  const complaints = element("div", { class: "gl-notes", role: "alert" });
  const banner = element("div", { class: "gl-banner", role: "alert", hidden: true });
  const corner2 = element("div", { class: "gl-corner" }, notes, complaints);
  let before = null;
  corner2.addEventListener("focusin", ({ relatedTarget }) => {
    if (relatedTarget instanceof HTMLElement && !corner2.contains(relatedTarget)) before = relatedTarget;
  });
  function remove(box) {
    const hadFocus = box.matches(":focus-within");
    box.remove();
    if (!hadFocus) return;
    const another = corner2.querySelector(".gl-note:not([hidden]) > button");
    (another ?? before)?.focus();
    if (document.activeElement !== document.body) return;
    const first = corner2.parentElement?.querySelector("button:enabled, [tabindex='0']");
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
    element: corner2,
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
function openPage(style, waiting, build2, read2 = () => {
}) {
  function mount(host, transport) {
    const root = waitingRoot(style, waiting);
    host.append(root);
    const channel = new Channel(transport);
    let built = null;
    function follow(state, buffers) {
      if (!understands(root, state)) return;
      read2(state, buffers);
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

// stage/drag.js
function makeDrag(page, { began, show, ended }) {
  let wanted = null;
  let reached = [];
  let running = null;
  let told = () => {
  };
  let conflict = "";
  function go() {
    running ??= run().finally(() => running = null);
  }
  async function run() {
    while (reached.length || wanted && !wanted.sent) {
      try {
        if (reached.length) await settle(reached[0]);
        else if (wanted) await solve(wanted);
      } catch (error) {
        stop(false);
        page.complain(error instanceof Error ? error.message : String(error));
      }
      page.changed();
    }
  }
  async function solve(wish) {
    wish.sent = true;
    const { result, buffers } = await page.channel.request("drag", wish.values);
    if (!wanted && !reached.length) return;
    conflict = result.conflict ?? "";
    if (buffers.length) show(result, buffers);
  }
  async function settle(wish) {
    const { result } = await page.channel.request(wish.command, wish.values);
    const changed = result.revision !== page.state.revision;
    if (changed) await new Promise((resolve) => told = () => resolve(void 0));
    reached = reached.filter((each) => each !== wish);
    if (reached.length || wanted) return;
    stop(changed);
  }
  function want(command, values) {
    began();
    wanted = { command, values, sent: false };
    go();
  }
  function stop(kept) {
    wanted = null;
    reached = [];
    conflict = "";
    told();
    ended(kept);
  }
  return {
    get active() {
      return wanted !== null || reached.length > 0;
    },
    /** What contradicts what, while it does. */
    get conflict() {
      return conflict;
    },
    /** The size on the way, or as it is. */
    get size() {
      const wish = wanted ?? reached.at(-1);
      const { width, height } = wish?.command === "resize" ? wish.values : page.state.drawing;
      return { width, height };
    },
    /** Left and bottom of a part on the way. @param {number} node @returns {number[] | undefined} */
    placeOf(node) {
      const wish = wanted ?? reached.at(-1);
      return wish?.command === "move" && wish.values.node === node ? [wish.values.left, wish.values.bottom] : void 0;
    },
    /** @param {number} width @param {number} height */
    to(width, height) {
      const { drawing } = page.state;
      want("resize", { width: round(width, drawing.width), height: round(height, drawing.height) });
    },
    /** @param {number} node @param {number} left @param {number} bottom metres from the lower left of the facade */
    move(node, left, bottom) {
      want("move", { node, left: Math.max(0, left), bottom: Math.max(0, bottom) });
    },
    /** What was reached stays. */
    end() {
      if (!wanted) return;
      reached.push(wanted);
      wanted = null;
      go();
    },
    /** Once nothing is under way. */
    idle: () => running ?? Promise.resolve(),
    /** More is known about the size on the way. */
    again() {
      if (!wanted) return;
      wanted.sent = false;
      go();
    },
    /** A state was told. */
    told: () => told(),
    /** As it was before. */
    cancel() {
      stop(false);
      page.changed();
    }
  };
}
function round(metres2, now) {
  if (metres2 === now) return now;
  const step = 10 ** (Math.floor(Math.log10(now)) - 3);
  return Number((Math.round(Math.min(Math.max(metres2, now / 50), now * 50) / step) * step).toPrecision(9));
}

// stage/paint.js
function paint(context, drawing, { images, colors }, { left, bottom, scale }) {
  const { columns, label, picture } = drawing;
  const outlines = new Map(drawing.outlines.map(({ leaf, corners }) => [leaf, corners]));
  const colorOf = (leaf) => colors[label[leaf] < 0 ? colors.length - 1 : label[leaf]];
  context.imageSmoothingQuality = "high";
  for (let leaf = 0; leaf < label.length; leaf += 1) {
    const [x, y, width, height, u, v, right, top] = columns.subarray(8 * leaf, 8 * leaf + 8);
    const [x0, x1] = [Math.round(left + x * scale), Math.round(left + (x + width) * scale)];
    const [y0, y1] = [Math.round(bottom - (y + height) * scale), Math.round(bottom - y * scale)];
    const image = images[picture[leaf]];
    const corners = outlines.get(leaf);
    if (image && right > u && top > v) {
      const { width: w, height: h } = image;
      context.drawImage(image, u * w, (1 - top) * h, (right - u) * w, (top - v) * h, x0, y0, x1 - x0, y1 - y0);
    } else if (corners && !image) {
      context.fillStyle = colors[colors.length - 1];
      context.fillRect(x0, y0, x1 - x0, y1 - y0);
      context.fillStyle = colorOf(leaf);
      context.beginPath();
      for (const [across, up] of corners) context.lineTo(x0 + across * (x1 - x0), y1 - up * (y1 - y0));
      context.fill();
    } else {
      context.fillStyle = colorOf(leaf);
      context.fillRect(x0, y0, x1 - x0, y1 - y0);
    }
  }
}
function paintSmall(pictures, room) {
  const scale = Math.min(
    room.width / Math.max(...pictures.map(({ drawing }) => drawing.width)),
    room.height / Math.max(...pictures.map(({ drawing }) => drawing.height))
  );
  for (const { canvas, drawing, looks } of pictures) {
    const [width, height] = [drawing.width * scale, drawing.height * scale];
    Object.assign(canvas.style, { width: `${width}px`, height: `${height}px` });
    const { context, ratio } = sharp(canvas, width, height);
    paint(context, drawing, looks, { left: 0, bottom: canvas.height, scale: scale * ratio });
  }
}
function sharp(canvas, width, height) {
  const ratio = Math.min(globalThis.devicePixelRatio || 1, 3);
  const [w, h] = [Math.max(1, Math.round(width * ratio)), Math.max(1, Math.round(height * ratio))];
  if (canvas.width !== w) canvas.width = w;
  if (canvas.height !== h) canvas.height = h;
  const context = (
    /** @type {CanvasRenderingContext2D} */
    canvas.getContext("2d")
  );
  context.clearRect(0, 0, w, h);
  return { context, ratio };
}

// stage/size_row.js
function card(title, ...children) {
  return element("div", { class: "gl-card" }, element("h2", {}, title), ...children);
}
function metres(value) {
  return value.toFixed(2);
}
function sizeRow(name, label, typed, ...more) {
  let now = 0;
  const input = element("input", {
    class: "gl-input fe-number",
    type: "number",
    min: "0",
    step: "any",
    "aria-label": `${label} in metres`
  });
  input.addEventListener("change", async () => {
    const value = Number(input.value);
    if (input.value === metres(now)) return;
    if (!(value >= 0) || !await typed(value)) input.value = metres(now);
  });
  return {
    element: element(
      "label",
      { class: "gl-row" },
      element("span", { class: "fe-unit" }, name),
      element("span", { class: "gl-space" }),
      input,
      "m",
      ...more
    ),
    /** @param {number} value */
    set(value) {
      now = value;
      if (document.activeElement !== input || input.value === "") input.value = metres(value);
    }
  };
}

// stage/stage.js
var MARGIN = { left: 40, right: 84, top: 44, bottom: 56 };
var SHARE = 0.93;
function makeStage(page, drag) {
  const canvas = element("canvas", { class: "fe-canvas", "aria-hidden": "true" });
  const over = svg("svg", { class: "fe-over", "aria-hidden": "true" });
  const face = element("div", {
    class: "fe-face",
    tabIndex: 0,
    role: "application",
    "aria-label": "Facade: arrow keys go from part to part"
  });
  const handles = { width: handle("Width"), height: handle("Height"), both: corner() };
  const alert = element("p", { class: "fe-conflict", role: "alert", hidden: true });
  const stage = element(
    "div",
    { class: "fe-stage" },
    canvas,
    over,
    face,
    handles.width,
    handles.height,
    handles.both,
    alert
  );
  const view = { left: 0, bottom: 0, scale: 1 };
  let lasso = null;
  let hovered = -1;
  let frame = 0;
  const resizes = new ResizeObserver(() => {
    if (!drag.active) fit();
    draw();
  });
  resizes.observe(stage);
  function fit() {
    const { clientWidth, clientHeight } = stage;
    const { width, height } = page.state.drawing;
    const room = [clientWidth - MARGIN.left - MARGIN.right, clientHeight - MARGIN.top - MARGIN.bottom];
    view.scale = Math.max(0.01, SHARE * Math.min(room[0] / width, room[1] / height));
    view.left = MARGIN.left + (room[0] - width * view.scale) / 2;
    view.bottom = clientHeight - MARGIN.bottom - Math.max(0, (room[1] - height * view.scale) / 2);
  }
  function drawSoon() {
    frame ||= requestAnimationFrame(draw);
  }
  function draw() {
    frame = 0;
    const { clientWidth, clientHeight } = stage;
    if (!clientWidth) return;
    const { context, ratio } = sharp(canvas, clientWidth, clientHeight);
    const { drawing, colors } = page.state;
    const looks = { images: page.pictures.images, colors };
    const at = { left: view.left * ratio, bottom: view.bottom * ratio, scale: view.scale * ratio };
    paint(context, drawing, looks, at);
    const [right, top] = [view.left + drawing.width * view.scale, view.bottom - drawing.height * view.scale];
    drawOver(right, top);
    place(handles.width, right, (top + view.bottom) / 2, drawing.width);
    place(handles.height, (view.left + right) / 2, top, drawing.height);
    place(handles.both, right, top, 0);
    stage.classList.toggle("fe-bad", Boolean(drag.conflict));
    stage.classList.toggle("fe-gridding", page.gridding);
    alert.hidden = !drag.conflict;
    if (alert.textContent !== drag.conflict) alert.textContent = drag.conflict;
  }
  function drawOver(right, top) {
    const { state } = page;
    const grid = state.grids.find(({ name }) => name === state.active);
    const marks = [
      svg("line", {
        class: "fe-ground",
        x1: 12,
        x2: stage.clientWidth - 12,
        y1: view.bottom + 0.5,
        y2: view.bottom + 0.5
      }),
      ...measure(view.left, view.bottom + 22, right, view.bottom + 22, `${metres(state.drawing.width)} m`),
      ...measure(right + 30, view.bottom, right + 30, top, `${metres(state.drawing.height)} m`)
    ];
    for (const node of !drag.active && grid?.nodes || []) marks.push(box(node, "fe-element"));
    for (const { node } of state.locks) if (node) marks.push(box(node, "fe-locked"));
    if (hovered >= 0 && hovered < state.parent.length) marks.push(box(hovered, "fe-hovered"));
    if (page.selected >= 0) marks.push(box(page.selected, "fe-selected"));
    if (lasso) {
      const [x, y] = [view.left + lasso.left * view.scale, view.bottom - lasso.top * view.scale];
      const [width, height] = [(lasso.right - lasso.left) * view.scale, (lasso.top - lasso.bottom) * view.scale];
      marks.push(svg("rect", { class: "fe-lasso", x, y, width, height }));
    }
    over.replaceChildren(...marks);
  }
  function box(node, style) {
    const [x, y, width, height] = boxOf(node);
    const [left, top] = [view.left + x * view.scale, view.bottom - (y + height) * view.scale];
    return svg("rect", {
      class: style,
      "data-node": node,
      x: left,
      y: top,
      width: width * view.scale,
      height: height * view.scale,
      rx: 1.5
    });
  }
  function place(where, x, y, metresNow) {
    where.style.transform = `translate(${x}px, ${y}px) translate(-50%, -50%)`;
    if (!metresNow) return;
    where.setAttribute("aria-valuenow", metresNow.toFixed(2));
    where.setAttribute("aria-valuetext", `${metres(metresNow)} metres`);
  }
  function leafAt(event) {
    return page.state.leaves.find((node) => isOn(node, event)) ?? -1;
  }
  function isOn(node, event) {
    const { x, y } = metresAt(event);
    const [left, bottom, width, height] = boxOf(node);
    return x >= left && x < left + width && y >= bottom && y < bottom + height;
  }
  function boxOf(node) {
    return page.state.boxes.subarray(4 * node, 4 * node + 4);
  }
  function metresAt({ clientX, clientY }) {
    const room = stage.getBoundingClientRect();
    return { x: (clientX - room.left - view.left) / view.scale, y: (view.bottom - (clientY - room.top)) / view.scale };
  }
  return {
    element: stage,
    face,
    handles,
    view,
    fit,
    draw,
    drawSoon,
    leafAt,
    boxOf,
    metresAt,
    /** Whether a place of the screen lies in the selected part, which is not the whole. @param {PointerEvent} event */
    isOnSelected: (event) => page.selected > 0 && isOn(page.selected, event),
    /** @param {Area | null} area */
    lasso(area) {
      lasso = area;
      drawSoon();
    },
    /** @param {number} node */
    hover(node) {
      if (node === hovered) return;
      hovered = node;
      drawSoon();
    },
    close: () => resizes.disconnect()
  };
}
function handle(name) {
  return element("div", {
    class: `fe-handle fe-handle-${name.toLowerCase()}`,
    tabIndex: 0,
    role: "slider",
    "aria-label": name,
    "aria-orientation": name === "Width" ? "horizontal" : "vertical",
    "aria-valuemin": "0",
    title: `${name}: drag, or use the arrow keys. Shift keeps the aspect ratio while dragging`
  });
}
function corner() {
  return element("div", { class: "fe-handle fe-handle-both", title: "Drag to scale", "aria-hidden": "true" });
}
function measure(x1, y1, x2, y2, text) {
  const flat = y1 === y2;
  const [dx, dy] = flat ? [0, 4] : [4, 0];
  const [x, y] = [(x1 + x2) / 2, (y1 + y2) / 2];
  const turned = flat ? {} : { transform: `rotate(-90 ${x + 18} ${y})` };
  return [
    svg("path", {
      class: "fe-measure",
      d: `M${x1} ${y1}L${x2} ${y2}M${x1 - dx} ${y1 - dy}L${x1 + dx} ${y1 + dy}M${x2 - dx} ${y2 - dy}L${x2 + dx} ${y2 + dy}`
    }),
    svg("text", { class: "fe-length", x: flat ? x : x + 18, y: flat ? y + 20 : y + 4, ...turned }, new Text(text))
  ];
}

// stage/handles.js
function listenToHandles(page, stage, drag) {
  listenToHandle(stage.handles.width, (start, dx, _dy, tied) => scaled(start, start.width + dx, null, tied));
  listenToHandle(stage.handles.height, (start, _dx, dy, tied) => scaled(start, null, start.height + dy, tied));
  listenToHandle(stage.handles.both, (start, dx, dy, tied) => {
    if (!tied) return drag.to(start.width + dx, start.height + dy);
    scaled(start, start.width + dx, null, true);
  });
  function scaled(start, width, height, tied) {
    const factor = tied ? width !== null ? width / start.width : (height ?? start.height) / start.height : 1;
    drag.to(width ?? start.width * factor, height ?? start.height * factor);
  }
  function listenToHandle(handle2, move) {
    let held = null;
    handle2.addEventListener("pointerdown", (event) => {
      if (event.button) return;
      event.preventDefault();
      handle2.focus();
      handle2.setPointerCapture(event.pointerId);
      const { width, height } = page.state.drawing;
      held = { x: event.clientX, y: event.clientY, size: { width, height } };
    });
    handle2.addEventListener("pointermove", (event) => {
      if (!held) return;
      const { scale } = stage.view;
      move(held.size, (event.clientX - held.x) / scale, (held.y - event.clientY) / scale, event.shiftKey || page.tied);
    });
    for (
      const end of
      /** @type {const} */
      ["pointerup", "lostpointercapture"]
    ) {
      handle2.addEventListener(end, () => {
        if (held) drag.end();
        held = null;
      });
    }
    handle2.addEventListener("pointercancel", () => {
      held = null;
      drag.cancel();
    });
    handle2.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !held) return;
      held = null;
      drag.cancel();
    });
  }
}

// editor/gestures.js
var SLACK = 4;
function listenToPointer(page, stage, drag) {
  const { face } = stage;
  let press = null;
  face.addEventListener("pointerdown", (event) => {
    if (event.button) return;
    const box = stage.isOnSelected(event) && !page.gridding ? stage.boxOf(page.selected).slice() : null;
    press = { ...stage.metresAt(event), event, moved: false, box };
    face.setPointerCapture(event.pointerId);
  });
  face.addEventListener("pointermove", (event) => {
    if (!press) {
      face.classList.toggle("fe-movable", stage.isOnSelected(event) && !page.gridding);
      return stage.hover(event.pointerType === "touch" ? -1 : stage.leafAt(event));
    }
    const { event: start } = press;
    press.moved ||= Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) >= SLACK;
    if (!press.moved) return;
    if (!press.box) return stage.lasso(areaTo(event));
    const { x, y } = stage.metresAt(event);
    drag.move(page.selected, press.box[0] + x - press.x, press.box[1] + y - press.y);
  });
  face.addEventListener("pointerleave", () => stage.hover(-1));
  face.addEventListener("pointerup", (event) => {
    if (!press) return;
    const { moved, box } = press;
    const area = areaTo(event);
    stop();
    if (moved && box) drag.end();
    else if (moved) void page.ask("lasso", area);
    else click(stage.leafAt(event));
  });
  face.addEventListener("pointercancel", cancel);
  face.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && press) cancel();
  });
  function cancel() {
    if (press?.box) drag.cancel();
    stop();
  }
  function stop() {
    press = null;
    stage.lasso(null);
  }
  function click(node) {
    if (node >= 0 && page.gridding) void page.ask("press", { node });
    else page.select(node === page.selected ? -1 : node);
  }
  function areaTo(event) {
    const { x, y } = stage.metresAt(event);
    const from = press ?? { x, y };
    return {
      left: Math.min(from.x, x),
      right: Math.max(from.x, x),
      bottom: Math.min(from.y, y),
      top: Math.max(from.y, y)
    };
  }
  listenToHandles(page, stage, drag);
}

// stage/keys.js
var WAYS = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
function listenToKeysOf(page, drag, save, plain) {
  let nudging = false;
  const nudge = {
    size(event) {
      const [x, y] = WAYS[event.key];
      const step = event.shiftKey ? 1 : event.altKey ? 0.01 : 0.1;
      const { width, height } = drag.size;
      const [w, h] = [width + x * step, height + y * step];
      nudging = true;
      if (!page.tied) drag.to(w, h);
      else if (x) drag.to(w, height * w / width);
      else drag.to(width * h / height, h);
      return true;
    },
    move(node, left, bottom) {
      nudging = true;
      drag.move(node, left, bottom);
      return true;
    }
  };
  document.addEventListener("keydown", (event) => {
    const on = event.target instanceof Element ? event.target : document.body;
    const typing = on instanceof HTMLTextAreaElement || on instanceof HTMLInputElement && on.type !== "checkbox";
    const means = event.ctrlKey || event.metaKey ? withCommand(event, typing) : !typing && !on.closest("dialog[open], :popover-open") && plain(event, on, nudge);
    if (means) event.preventDefault();
  });
  document.addEventListener("keyup", (event) => {
    if (event.key in WAYS) end();
  });
  addEventListener("blur", end);
  function end() {
    if (nudging) drag.end();
    nudging = false;
  }
  function withCommand(event, typing) {
    const key = event.key.toLowerCase();
    if (key === "s") save();
    else if (typing) return false;
    else if (key === "z" && event.shiftKey || key === "y") void page.ask("redo");
    else if (key === "z") void page.ask("undo");
    else return false;
    return true;
  }
}

// editor/keyboard.js
var KEYS = [
  ["Arrows", "make the facade wider, narrower, higher or lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "go to the facade, its handles, the variations and the panel"],
  ["Arrows on the facade", "go from part to part"],
  ["Alt and arrows on the facade", "move the selected part by 0.05 m, with Shift by 0.5 m"],
  ["Space on the facade", "add the selected part to the grid, or remove it"],
  ["W, H, A", "lock or unlock width, height, aspect of the selected part"],
  ["P", "select the part around the selected one"],
  ["G", "switch whether a click changes the grid or selects a part"],
  ["V", "go to the variations; Enter accepts one"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "select nothing, end a drag"],
  ["?", "show or hide these keys"]
];
function listenToKeys(page, stage, drag, acts) {
  listenToKeysOf(page, drag, acts.save, (event, on, nudge) => {
    if (event.key in WAYS) {
      if (on !== stage.face) return !on.closest(".fe-strip") && nudge.size(event);
      return event.altKey ? move(event, nudge) : go(event.key);
    }
    const key = event.key.toLowerCase();
    if (key === "?") acts.help();
    else if (key === "w") acts.toggleLock("width");
    else if (key === "h") acts.toggleLock("height");
    else if (key === "a") acts.toggleLock("aspect");
    else if (key === "g") acts.toggleGridding();
    else if (key === "v") acts.variations();
    else if (key === "p" && page.selected > 0) page.select(page.state.parent[page.selected]);
    else if (key === " " && on === stage.face && page.selected >= 0) void page.ask("press", { node: page.selected });
    else if (key === "escape") page.select(-1);
    else return false;
    return true;
  });
  function move(event, nudge) {
    if (page.selected <= 0) return false;
    const [x, y] = WAYS[event.key];
    const step = event.shiftKey ? 0.5 : 0.05;
    const [left, bottom] = drag.placeOf(page.selected) ?? stage.boxOf(page.selected);
    return nudge.move(page.selected, left + x * step, bottom + y * step);
  }
  function go(key) {
    const { leaves } = page.state;
    const middle = (node) => {
      const [x2, y2, width, height] = stage.boxOf(node);
      return [x2 + width / 2, y2 + height / 2];
    };
    if (page.selected < 0) {
      page.select(leaves[0]);
      return true;
    }
    const [dx, dy] = WAYS[key];
    const [x, y] = middle(page.selected);
    let [best, least] = [-1, Infinity];
    for (const leaf of leaves) {
      const [u, v] = middle(leaf);
      const ahead = (u - x) * dx + (v - y) * dy;
      const beside = Math.abs((u - x) * dy) + Math.abs((v - y) * dx);
      if (leaf !== page.selected && ahead > 1e-6 && ahead + 3 * beside < least)
        [best, least] = [leaf, ahead + 3 * beside];
    }
    if (best >= 0) page.select(best);
    return true;
  }
}

// editor/aspect.js
function aspectRow(typed, lock) {
  let [least, most] = [0, 0];
  const low = field("Least part width to height", () => give(low, (value) => [value, Math.max(value, most)]));
  const high = field("Largest part width to height", () => give(high, (value) => [Math.min(value, least), value]));
  async function give(input, range) {
    const [from, to] = range(Number(input.value));
    if (!(from > 0) || !await typed(from, to)) show();
  }
  function show() {
    low.value = least.toFixed(2);
    high.value = most.toFixed(2);
  }
  return {
    element: element(
      "div",
      { class: "gl-row" },
      element("span", { class: "fe-unit" }, "Width / height"),
      element("span", { class: "gl-space" }),
      low,
      "to",
      high,
      lock
    ),
    /** @param {number[]} range */
    set(range) {
      [least, most] = range;
      show();
    }
  };
}
function field(label, typed) {
  return element("input", {
    class: "gl-input fe-number fe-ratio",
    type: "number",
    min: "0",
    step: "any",
    "aria-label": label,
    onchange: typed
  });
}

// editor/panel.js
function makePanel(page, acts) {
  const width = lockableRow(
    "Width",
    "width",
    (value) => resize(value, null),
    () => acts.toggleLock("width", 0)
  );
  const height = lockableRow(
    "Height",
    "height",
    (value) => resize(null, value),
    () => acts.toggleLock("height", 0)
  );
  const tied = element("input", { type: "checkbox", onchange: () => page.tied = tied.checked });
  const grids = element("ul", { class: "fe-grids", "aria-label": "Grids" });
  const gridding = textButton("Change by clicking", acts.toggleGridding, {
    title: "A click adds a part to the active grid, or removes it (G)"
  });
  const hint = element("p", { class: "gl-hint" });
  const part = element("div", { class: "fe-part" });
  const locks = element("ul", { class: "fe-locks", "aria-label": "Locks" });
  function resize(wide, high) {
    const { width: w, height: h } = page.state.drawing;
    const factor = page.tied ? wide !== null ? wide / w : (high ?? h) / h : 1;
    return page.ask("resize", { width: wide ?? w * factor, height: high ?? h * factor });
  }
  function update() {
    const { state } = page;
    width.set(state.drawing.width, isLocked(page, 0, "width"));
    height.set(state.drawing.height, isLocked(page, 0, "height"));
    gridding.setAttribute("aria-pressed", String(page.gridding));
    gridding.disabled = !state.active;
    hint.textContent = page.gridding ? `Click parts to add them to “${state.active}”, or to remove them.` : "Draw a rectangle on the facade to make a grid of the parts inside it.";
    updateGrids();
    updatePart();
    locks.replaceChildren(
      ...state.locks.map(
        ({ node, what, words }) => element(
          "li",
          { class: "gl-row" },
          textButton(words, () => page.select(node), { class: "gl-choice fe-name" }),
          iconButton("close", `Unlock: ${words}`, () => void page.ask("unlock", { node, what }))
        )
      )
    );
    locked.hidden = !state.locks.length;
  }
  let drawnGrids = "";
  function updateGrids() {
    const { grids: found, active } = page.state;
    const now = JSON.stringify([
      found.map(({ name, rows, columns, nodes }) => [name, rows, columns, nodes.length]),
      active
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
              onclick: () => void page.ask("choose", { grid: name })
            },
            element("b", { class: "fe-name" }, name),
            element("small", {}, size)
          ),
          name === active ? iconButton("more", `Rename ${name}`, () => rename(name)) : null,
          name === active ? iconButton("close", `Delete grid ${name}`, () => void page.ask("delete", { grid: name })) : null
        );
      })
    );
  }
  function rename(name) {
    const input = element("input", {
      class: "gl-input",
      value: name,
      maxLength: 100,
      "aria-label": `New name of ${name}`
    });
    let done = false;
    const end = async (keep) => {
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
          "Click a part to see its size or to lock it. Drag the selected part to move it with all aligned parts."
        )
      );
      return;
    }
    const [w, h] = state.boxes.subarray(4 * selected + 2, 4 * selected + 4);
    const set = (what) => (value) => page.ask("give", { node: selected, what, value });
    const row = (name, what, value) => {
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
      tie.element
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
        grid ? textButton(
          inside ? `Remove from ${grid.name}` : `Add to ${grid.name}`,
          () => void page.ask("press", { node: selected })
        ) : null,
        selected > 0 ? textButton("Enclosing part", () => page.select(state.parent[selected])) : null
      )
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
        element("label", { class: "gl-check" }, tied, "Keep the aspect ratio")
      ),
      card(
        "Grids",
        grids,
        element(
          "div",
          { class: "gl-row gl-wrap" },
          gridding,
          textButton("Propose", () => void page.ask("propose"), {
            title: "Replace the grids by new ones, found from labels, places and sizes"
          })
        ),
        hint
      ),
      card("Selected part", part),
      locked
    ),
    update
  };
}
function lockableRow(name, label, typed, lock) {
  const button = lockButton(label, lock);
  const row = sizeRow(name, label, typed, button.element);
  return {
    element: row.element,
    /** @param {number} value @param {boolean} locked */
    set(value, locked) {
      row.set(value);
      button.set(locked);
    }
  };
}
var LOCKED = "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 5 0v2.5";
var OPEN = "M4 7.5h8v6H4zM5.5 7.5V5a2.5 2.5 0 0 1 4.8-1";
function lockButton(label, onclick) {
  const button = iconButton("close", `Lock ${label}`, (event) => {
    event.preventDefault();
    onclick();
  });
  return {
    element: button,
    /** @param {boolean} locked */
    set(locked) {
      button.querySelector("path")?.setAttribute("d", locked ? LOCKED : OPEN);
      button.setAttribute("aria-pressed", String(locked));
      button.classList.toggle("fe-open", !locked);
    }
  };
}
function isLocked(page, node, what) {
  return lockOf(page, node, what) !== void 0;
}
function lockOf(page, node, what) {
  return page.state.locks.find((lock) => lock.node === node && lock.what === what);
}
function nameOf({ state }, node) {
  if (node === 0) return "the whole facade";
  return state.names[node] < 0 ? "part without a name" : state.labels[state.names[node]];
}

// editor/pictures.js
var Pictures = class {
  /** @type {(ImageBitmap | undefined)[]} */
  images = [];
  #channel;
  #arrived;
  #asked = 0;
  /**
   * @param {import("../shared/channel.js").Channel} channel
   * @param {() => void} arrived
   */
  constructor(channel, arrived) {
    this.#channel = channel;
    this.#arrived = arrived;
  }
  /** @param {number} count */
  async want(count) {
    for (; this.#asked < count; this.#asked += 1) {
      const number = this.#asked;
      this.#channel.request("picture", { number }).then(({ buffers }) => createImageBitmap(new Blob([buffers[0]]))).then((image) => {
        this.images[number] = image;
        this.#arrived();
      }).catch(() => {
      });
    }
  }
  /** Requests pictures that were under way again. */
  again() {
    this.#asked = this.images.filter(Boolean).length === this.#asked ? this.#asked : 0;
  }
};

// editor/strip.js
var KINDS = [
  { name: "One column more", axis: "x", change: 1 },
  { name: "One column less", axis: "x", change: -1 },
  { name: "One row more", axis: "y", change: 1 },
  { name: "One row less", axis: "y", change: -1 }
];
var ROOM = { width: 196, height: 104 };
var AT_ONCE = 12;
function makeStrip(page) {
  let kind = KINDS[0];
  let most = AT_ONCE;
  let shown = "";
  let tiles = [];
  const list = element("div", { class: "fe-strip", role: "group", "aria-label": "Variations" });
  const about = element("p", { class: "fe-about", role: "status" });
  const tabs = KINDS.map(
    (each) => element("button", { type: "button", class: "gl-tab", onclick: () => choose(each) }, each.name)
  );
  function choose(each) {
    kind = each;
    most = AT_ONCE;
    update();
  }
  function update() {
    tabs.forEach((tab, index) => tab.setAttribute("aria-pressed", String(KINDS[index] === kind)));
    const { active, revision } = page.state;
    const wanted = JSON.stringify([active, revision, KINDS.indexOf(kind), most]);
    if (wanted === shown) return;
    shown = wanted;
    list.classList.add("fe-old");
    about.textContent = active ? "Computing variations…" : "";
    if (!active)
      return show([], 0, "Draw a rectangle around some windows to make a grid. Its variations will appear here.");
    page.channel.request("vary", { axis: kind.axis, change: kind.change, most }).then(
      ({ result, buffers }) => {
        if (wanted !== shown) return;
        const found = result.variations.map((each, number) => ({
          ...each,
          columns: new Float64Array(buffers[number])
        }));
        show(found, result.total, result.none);
      },
      (error) => wanted === shown && show([], 0, error.message)
    );
  }
  function show(found, total, none) {
    list.classList.remove("fe-old");
    tiles = found.map((variation) => ({
      variation,
      canvas: element("canvas", { class: "fe-small", "aria-hidden": "true" })
    }));
    const held = [...list.children].findIndex((each) => each === document.activeElement);
    list.replaceChildren(...tiles.map(tile));
    if (held >= 0) list.children[Math.min(held, tiles.length - 1)]?.focus();
    if (total > found.length && most < 60)
      list.append(
        element(
          "button",
          { type: "button", class: "gl-button fe-more", onclick: more },
          `${total - found.length} more`
        )
      );
    about.textContent = none;
    draw();
  }
  function more() {
    most = 60;
    update();
  }
  function tile({ variation, canvas }, number) {
    const { words, told, width, height } = variation;
    const size = `${width.toFixed(2)} × ${height.toFixed(2)} m`;
    return element(
      "button",
      {
        type: "button",
        class: `fe-tile${told.length ? " fe-flawed" : ""}`,
        title: [words, size, ...told].join("\n"),
        "aria-label": [words, size, ...told].join(", "),
        onclick: () => void page.ask("accept", { number })
      },
      canvas,
      element("span", { class: "fe-words" }, words),
      element("small", {}, told.length ? "incomplete" : size)
    );
  }
  function draw() {
    const looks = { images: page.pictures.images, colors: page.state.colors };
    paintSmall(
      tiles.map(({ variation, canvas }) => ({ canvas, drawing: variation, looks })),
      ROOM
    );
  }
  function first() {
    list.querySelector("button")?.focus();
  }
  return {
    element: element(
      "section",
      { class: "fe-variations", "aria-label": "Variations of the active grid" },
      element(
        "div",
        { class: "gl-row gl-wrap fe-kinds", role: "group", "aria-label": "Kind of variation" },
        ...tabs,
        about
      ),
      list
    ),
    update,
    draw,
    first,
    /** Asks anew. */
    again() {
      shown = "";
      update();
    }
  };
}

// editor/main.js
var KINDS2 = {
  json: "facade, can be opened again",
  svg: "drawing",
  png: "picture",
  glb: "model",
  obj: "model",
  cga: "rules of the facade"
};
function build(root, channel, first) {
  const notes = makeNotes();
  const ahead = new Ahead();
  const page = {
    state: first,
    channel,
    pictures: new Pictures(channel, () => {
      stage.drawSoon();
      strip.draw();
    }),
    selected: -1,
    gridding: false,
    tied: false,
    ask: makeAsk(channel, notes, () => drag.idle()),
    select(node) {
      page.selected = node;
      page.changed();
    },
    say: notes.say,
    complain: notes.complain,
    changed() {
      stage.drawSoon();
      panel.update();
      if (!drag.active) strip.update();
    }
  };
  let before = null;
  const drag = makeDrag(page, {
    began: () => before ??= sizesNow(),
    show: ({ width, height }, buffers) => show({ boxes: new Float64Array(buffers[0]), width, height }),
    ended(kept) {
      if (before && !kept) show(before);
      before = null;
      stage.fit();
    }
  });
  function sizesNow() {
    const { boxes, drawing } = page.state;
    return { boxes, width: drawing.width, height: drawing.height };
  }
  function show({ boxes, width, height }) {
    const { state } = page;
    if (boxes.length !== state.boxes.length) return;
    state.boxes = boxes;
    Object.assign(state.drawing, { width, height });
    state.leaves.forEach((node, leaf) => state.drawing.columns.set(boxes.subarray(4 * node, 4 * node + 4), 8 * leaf));
    page.changed();
  }
  const stage = makeStage(page, drag);
  const strip = makeStrip(page);
  const acts = {
    save: () => frame.save(),
    /** @param {What} what @param {number} [node] */
    toggleLock(what, node = page.selected) {
      if (node < 0) return page.say("Select a part first, to lock its size.");
      const key = `${node} ${what}`;
      const locked = !ahead.of(key, isLocked(page, node, what));
      void ahead.set(key, locked, page.ask(locked ? "lock" : "unlock", { node, what }));
    },
    toggleGridding() {
      page.gridding = !page.gridding && Boolean(page.state.active);
      page.changed();
    },
    variations: () => strip.first(),
    help: () => help.open()
  };
  const panel = makePanel(page, acts);
  const help = makeHelp(
    KEYS,
    "Drag the handles at the right and at the top to change the size. Click a part to select it. Draw a rectangle to make a grid. Click a picture below to accept a variation."
  );
  listenToPointer(page, stage, drag);
  listenToKeys(page, stage, drag, acts);
  const frame = makeFrame(root, page, {
    notes,
    help,
    kinds: KINDS2,
    // A length that is being typed counts.
    settle: () => document.activeElement instanceof HTMLInputElement && document.activeElement.blur(),
    beside: [],
    left: [stage.element, strip.element],
    panel: panel.element
  });
  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      ahead.told();
      if (before) before = sizesNow();
      drag.told();
      if (page.selected >= state.parent.length) page.selected = -1;
      page.gridding &&= Boolean(state.active);
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      void page.pictures.want(state.pictures);
      frame.update();
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
      if (!connected) return void drag.cancel();
      page.pictures.again();
      void page.pictures.want(page.state.pictures);
      strip.again();
    }
  };
}
function read(state, buffers) {
  state.drawing.columns = new Float64Array(buffers[0]);
  state.boxes = new Float64Array(buffers[1]);
}
openPage("fe-page", "Opening the facade…", build, read);
