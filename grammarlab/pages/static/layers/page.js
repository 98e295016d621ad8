/* Built from shared, stage, layers by pages_src/bundle.js; do not edit. Source c37da018acf5c7c7 */

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

// layers/keyboard.js
var KEYS = [
  ["Arrows", "make the canvas wider, narrower, higher or lower by 0.1 m; with Shift by 1 m, with Alt by 0.01 m"],
  ["Tab", "go to the handles, the layouts and the panel"],
  ["L", "go to the layouts; Enter chooses one"],
  ["T", "go to the text; Escape leaves it"],
  ["Ctrl Z, Ctrl Y", "undo, redo"],
  ["Ctrl S", "save"],
  ["Escape", "end a drag"],
  ["?", "show or hide these keys"]
];
function listenToKeys(page, drag, acts) {
  listenToKeysOf(page, drag, acts.save, (event, _on, nudge) => {
    if (event.key in WAYS) return nudge.size(event);
    const key = event.key.toLowerCase();
    if (key === "?") acts.help();
    else if (key === "l") acts.layouts();
    else if (key === "t") acts.text();
    else return false;
    return true;
  });
}

// layers/strip.js
var ROOM = { width: 196, height: 100 };
function makeStrip(page) {
  const list = element("div", { class: "fe-strip", role: "group", "aria-label": "Layouts, the best first" });
  const tiles = [];
  function makeTile(number) {
    const canvas = element("canvas", { class: "fe-small", "aria-hidden": "true" });
    const [words, told] = [element("span", { class: "fe-words" }), element("small")];
    const onclick = () => void page.ask("choose", { number });
    const tile = element("button", { type: "button", class: "fe-tile", onclick }, canvas, words, told);
    list.append(tile);
    tiles.push({ tile, canvas, words, told });
  }
  function update() {
    while (tiles.length < page.layouts.length) makeTile(tiles.length);
    tiles.forEach(({ tile, canvas, words, told }, number) => {
      const layout = page.layouts[number];
      tile.hidden = !layout;
      if (!layout) return;
      tile.setAttribute("aria-pressed", String(number === page.chosen));
      words.textContent = countersOf(layout);
      told.textContent = `energy ${layout.energy.toPrecision(3)}`;
      tile.title = `${countersOf(layout)}: energy ${layout.energy.toPrecision(4)}${layout.proven ? ", proven" : ""}`;
    });
    paintSmall(
      page.layouts.map((drawing, number) => ({
        canvas: tiles[number].canvas,
        drawing,
        looks: { images: [], colors: drawing.colors }
      })),
      ROOM
    );
  }
  return {
    element: element("section", { class: "fe-variations", "aria-label": "Layouts" }, list),
    update,
    first: () => (
      /** @type {HTMLElement | null} */
      list.querySelector("button:not([hidden])")?.focus()
    )
  };
}
function countersOf({ counters }) {
  return Object.entries(counters).map(([name, value]) => `${name} = ${value}`).join(", ");
}

// layers/panel.js
var FLAGS = [
  ["opaque", "opaque", "covers all of its place"],
  ["attached", "attached", "its neighbours stay next to it"],
  ["unoccludable", "unoccl.", "nothing may cover only a part of it"],
  ["transparent", "transp.", "a placeholder that is never visible"]
];
function makePanel(page, text) {
  const width = sizeRow("Width", "width", (width2) => page.ask("resize", { width: width2, height: page.state.height }));
  const height = sizeRow("Height", "height", (height2) => page.ask("resize", { width: page.state.width, height: height2 }));
  const counters = element("div", { class: "fl-counters", role: "status", "aria-label": "Counters" });
  const energy = element("p", { class: "gl-hint" });
  const layers = element("ul", { class: "fl-list", "aria-label": "Layers" });
  const symbols = element("div", { class: "fl-symbols", role: "group", "aria-label": "Symbols" });
  const design = element(
    "div",
    { class: "gl-plain" },
    card("Canvas", width.element, height.element),
    card("Counters", counters, energy),
    card("Layers, from the top down", layers),
    card("Symbols", symbols)
  );
  const tabs = [
    textButton("Design", () => choose(false), { class: "gl-button gl-tab" }),
    textButton("Text", () => choose(true), { class: "gl-button gl-tab" })
  ];
  let asText = false;
  function choose(text2) {
    asText = text2;
    update();
  }
  let drawn = "";
  function update() {
    tabs.forEach((tab, number) => tab.setAttribute("aria-pressed", String(number === 1 === asText)));
    design.hidden = asText;
    text.element.hidden = !asText;
    text.update();
    const layout = page.layouts[page.chosen];
    width.set(layout?.width ?? page.state.width);
    height.set(layout?.height ?? page.state.height);
    const now = layout ? countersOf(layout) : "";
    if (counters.textContent !== now.replaceAll(", ", ""))
      counters.replaceChildren(
        ...(now ? now.split(", ") : []).map((each) => element("span", { class: "fl-counter" }, each))
      );
    energy.textContent = layout ? `Energy ${layout.energy.toPrecision(4)}, ${layout.proven ? "proven to be the least" : "not proven to be the least"}` : "";
    const { layers: found, symbols: known } = page.state;
    const what = JSON.stringify([found, known]);
    if (what !== drawn) drawDesign();
    drawn = what;
    for (const symbol of known) {
      const size = layout?.sizes[symbol.name];
      const told = sizes.get(symbol.name);
      if (told) told.textContent = size === void 0 ? "–" : `${size.toFixed(2)} m`;
    }
  }
  const sizes = /* @__PURE__ */ new Map();
  function drawDesign() {
    const held = document.activeElement instanceof HTMLElement ? document.activeElement.dataset.what : void 0;
    sizes.clear();
    layers.replaceChildren(...page.state.layers.map(layerOf));
    symbols.replaceChildren(...page.state.symbols.flatMap(symbolOf));
    if (held) design.querySelector(`[data-what=${CSS.escape(held)}]`)?.focus();
  }
  function layerOf({ name, on, axes }, number) {
    const onchange = () => void page.ask("switch", { layer: number, on: box.checked });
    const box = element("input", { type: "checkbox", checked: on, onchange });
    box.dataset.what = `layer ${number}`;
    return element(
      "li",
      { class: on ? "" : "fl-off" },
      element("label", { class: "fl-head" }, box, element("span", { class: "fl-layer-name", title: name }, name)),
      ...axes.map(
        ({ pattern, symbols: symbols2, seen }, axis) => element(
          "div",
          { class: "fl-axis", role: "group", "aria-label": `Visible symbols of ${name} along ${"xy"[axis]}` },
          element("code", { class: "fl-pattern", title: "xy"[axis] }, pattern),
          ...symbols2.map((symbol) => {
            const shows = seen === null || seen.includes(symbol);
            const label = `${shows ? "Hide" : "Show"} ${symbol} of ${name}`;
            const [what, of] = [`mask ${number} ${axis} ${symbol}`, { layer: number, axis: "xy"[axis], symbol }];
            return chip(
              symbol,
              label,
              shows,
              what,
              () => toggle(what, shows, (seen2) => page.ask("mask", { ...of, seen: seen2 }))
            );
          })
        )
      )
    );
  }
  function toggle(what, confirmed, ask) {
    const value = !page.ahead.of(what, confirmed);
    void page.ahead.set(what, value, ask(value));
  }
  function symbolOf(symbol) {
    const { name, size } = symbol;
    const now = new Text("–");
    sizes.set(name, now);
    const target = size === null ? "the rest" : `of ${Number(size.toFixed(3))} m`;
    return [
      element("span", { class: "fl-symbol" }, name),
      element("span", { class: "fl-size" }, now, element("small", {}, target)),
      element(
        "span",
        { class: "fl-flags" },
        ...FLAGS.map(([flag, short, says]) => {
          const what = `flag ${name} ${flag}`;
          const made = chip(
            short,
            `${name}: ${flag}, ${says}`,
            symbol[flag],
            what,
            () => toggle(what, symbol[flag], (value) => page.ask("flag", { symbol: name, flag, value }))
          );
          made.classList.add("fl-flag");
          return made;
        })
      )
    ];
  }
  return {
    element: element(
      "section",
      { class: "gl-side fe-side fl-side", "aria-label": "Design" },
      element("div", { class: "fl-tabs", role: "group", "aria-label": "View of the design" }, ...tabs),
      design,
      text.element
    ),
    update,
    /** Shows the text, and is ready for typing. */
    write() {
      choose(true);
      text.input.focus();
    }
  };
}
function chip(text, label, pressed, what, onclick) {
  const made = textButton(text, onclick, { class: "gl-button fl-chip", "aria-label": label, title: label });
  made.setAttribute("aria-pressed", String(pressed));
  made.dataset.what = what;
  return made;
}

// layers/text.js
var PAUSE = 350;
function makeText(page) {
  const input = element("textarea", {
    class: "fl-text",
    spellcheck: false,
    autocomplete: "off",
    "aria-label": "Text of the design"
  });
  const mistakes = element("div", { role: "alert" });
  const editing = element("div", { class: "fl-editing" }, input, mistakes);
  let sent = "";
  let timer = 0;
  let sending = Promise.resolve();
  input.addEventListener("input", () => {
    clearTimeout(timer);
    timer = setTimeout(() => void send(), PAUSE);
  });
  input.addEventListener("blur", () => void send());
  input.addEventListener("keydown", ({ key }) => key === "Escape" && input.blur());
  function send() {
    clearTimeout(timer);
    if (input.value === sent) return sending;
    const before = sent;
    const text = sent = input.value;
    sending = page.ask("edit", { text }).then((answer) => {
      if (!answer && sent === text) sent = before;
    });
    return sending;
  }
  function go({ line, column, length }) {
    const lines = input.value.split("\n");
    const start = lines.slice(0, line - 1).reduce((sum, each) => sum + each.length + 1, 0) + column - 1;
    input.focus();
    input.setSelectionRange(start, start + length);
  }
  function update() {
    const { state } = page;
    if (input.value === sent && state.text !== sent) {
      const [start, end, top] = [input.selectionStart, input.selectionEnd, input.scrollTop];
      input.value = sent = state.text;
      input.setSelectionRange(start, end);
      input.scrollTop = top;
    }
    editing.classList.toggle("fl-wrong", state.mistakes.length > 0);
    input.setAttribute("aria-invalid", String(state.mistakes.length > 0));
    mistakes.replaceChildren(
      ...state.mistakes.map(
        (each) => element(
          "button",
          { type: "button", class: "fl-mistake", title: "Go there", onclick: () => go(each) },
          `line ${each.line}, column ${each.column}: ${each.message}`,
          element("pre", {}, each.shown)
        )
      )
    );
  }
  return { element: editing, input, update, send };
}

// layers/main.js
var EMPTY = { label: [], picture: [], outlines: [], columns: new Float64Array(), colors: [""] };
var KINDS = {
  json: "facade, can be opened and edited",
  svg: "drawing",
  png: "picture",
  glb: "model with the depth of layers",
  obj: "model with the depth of layers",
  cga: "rules of the facade"
};
function withColumns(layouts, buffers) {
  layouts.forEach((layout, number) => layout.columns = new Float64Array(buffers[number]));
  return layouts;
}
function build(root, channel, first) {
  const notes = makeNotes();
  let onTheWay = null;
  const page = {
    state: first,
    channel,
    tied: false,
    ahead: new Ahead(),
    get layouts() {
      return (onTheWay ?? page.state).layouts;
    },
    get chosen() {
      return (onTheWay ?? page.state).chosen;
    },
    ask: makeAsk(channel, notes, () => drag.idle()),
    complain: notes.complain,
    changed() {
      stage.drawSoon();
      strip.update();
      panel.update();
    }
  };
  const face = {
    ...{ channel, complain: notes.complain, changed: page.changed, pictures: { images: [] } },
    ...{ selected: -1, gridding: false, tied: false },
    get state() {
      const { revision, width, height } = page.state;
      const drawing = page.layouts[page.chosen] ?? { ...EMPTY, width, height };
      const none = { grids: [], locks: [], active: "", leaves: [], parent: [], boxes: new Float64Array() };
      return { revision, drawing, colors: drawing.colors, ...none };
    }
  };
  const drag = makeDrag(face, {
    began() {
    },
    show({ layouts, chosen }, buffers) {
      onTheWay = { layouts: withColumns(layouts, buffers), chosen };
    },
    ended(kept) {
      onTheWay = null;
      const { width, height } = page.state;
      if (!kept && channel.connected) channel.request("drag", { width, height }).catch(() => {
      });
      stage.fit();
    }
  });
  const told = {
    get size() {
      return drag.size;
    },
    get active() {
      return drag.active;
    },
    get conflict() {
      return drag.active ? drag.conflict : page.state.conflict;
    }
  };
  const stage = makeStage(face, told);
  stage.face.tabIndex = -1;
  stage.face.setAttribute("aria-label", "Facade");
  const strip = makeStrip(page);
  const text = makeText(page);
  const panel = makePanel(page, text);
  const help = makeHelp(
    KEYS,
    "Drag the handles at the right and at the top. The layers are laid out for each size. Click a picture below to choose a layout."
  );
  const acts = {
    save: () => frame.save(),
    layouts: () => strip.first(),
    text: () => panel.write(),
    help: () => help.open()
  };
  listenToHandles(face, stage, drag);
  listenToKeys(page, drag, acts);
  const solving = element("span", { class: "gl-count fl-solving", role: "status" });
  const frame = makeFrame(root, page, {
    notes,
    help,
    kinds: KINDS,
    settle: text.send,
    // what is being typed counts
    beside: [solving],
    left: [stage.element, strip.element],
    panel: panel.element
  });
  channel.on("better", drag.again);
  return {
    /** @param {State} state */
    update(state) {
      page.state = state;
      page.ahead.told();
      drag.told();
      if (!drag.active) stage.fit();
      page.changed();
      stage.draw();
      frame.update();
      solving.classList.toggle("fl-busy", state.solving);
      solving.textContent = state.solving ? "solving…" : "";
    },
    /** @param {boolean} connected */
    connection(connected) {
      notes.announce(connected ? "" : LOST);
      if (!connected) drag.cancel();
    }
  };
}
openPage("fe-page fl-page", "Opening the design…", build, ({ layouts }, buffers) => withColumns(layouts, buffers));
