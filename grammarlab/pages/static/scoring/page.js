/* Built from shared, scoring by pages_src/bundle.js; do not edit. Source 4d5a0c57902a657b */

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
function chooserButton(name) {
  const value = element("b");
  const button = element("button", { type: "button", class: "gl-button gl-chooser" }, element("span", {}, name), value);
  return { button, set: (text) => void (value.textContent = text) };
}

// scoring/pictures.js
var SHEETS_KEPT = 80;
var Pictures = class {
  #channel;
  #came;
  /** @type {Map<string, Picture>} */
  #known = /* @__PURE__ */ new Map();
  /** @type {Map<string, number>} rank asked for, where it is under way */
  #asked = /* @__PURE__ */ new Map();
  /** @type {Set<Sheet>} */
  #sheets = /* @__PURE__ */ new Set();
  /** @type {Set<string>} */
  #shown = /* @__PURE__ */ new Set();
  /** @type {string[]} */
  #kept = [];
  /** @param {Channel} channel @param {() => void} came */
  constructor(channel, came) {
    this.#channel = channel;
    this.#came = came;
    channel.on("pictures", (message, [buffer]) => void this.#take(message, buffer));
  }
  /** Those that are shown beside others, in any size, from the next request on. @param {string[]} models */
  keep(models) {
    this.#kept = models;
  }
  /**
   * Asks for those that are not here in that size or better. A request replaces the one before it.
   * @param {string[]} models which are looked at
   * @param {number} size pixels
   * @param {string[]} [ahead] models that may be looked at soon: until then, quick pictures are enough
   */
  want(models, size, ahead = []) {
    const [quick, well] = [rankOf(size), rankOf(size, true)];
    const needed = /* @__PURE__ */ new Map();
    for (
      const [names, rank] of
      /** @type {const} */
      [
        [models, well],
        [ahead, quick],
        [this.#kept, 1]
      ]
    ) {
      for (const model of names) if (!needed.has(model)) needed.set(model, rank);
    }
    this.#shown = new Set(needed.keys());
    const missing = [...needed].filter(([model, rank]) => this.#rankOf(model) < rank);
    if (!this.#channel.connected || missing.every(([model, rank]) => (this.#asked.get(model) ?? 0) >= rank)) return;
    this.#asked = new Map(missing);
    const absent = missing.filter(([model, rank]) => this.#rankOf(model) < Math.min(rank, quick));
    const good = missing.filter(([, rank]) => rank === well);
    const asked = { models: absent.map(([model]) => model), good: good.map(([model]) => model), size };
    this.#channel.request("pictures", asked).catch(() => this.askAgain());
  }
  /** @param {string} model */
  #rankOf(model) {
    const known = this.#known.get(model);
    return known ? rankOf(known.size, known.good) : 0;
  }
  /** After a reconnection nobody works on what was asked before. */
  askAgain() {
    this.#asked.clear();
  }
  /** @param {string} model */
  find(model) {
    return this.#known.get(model);
  }
  close() {
    for (const { url } of this.#sheets) URL.revokeObjectURL(url);
  }
  /**
   * @param {{ models: string[], good: boolean[], size: number, columns: number, rows: number }} message
   * @param {ArrayBuffer} buffer
   */
  async #take({ models, good, size, columns, rows }, buffer) {
    const url = URL.createObjectURL(new Blob([buffer], { type: "image/jpeg" }));
    const picture = new Image();
    picture.src = url;
    await picture.decode().catch(() => {
    });
    const sheet = { url, size, models };
    this.#sheets.add(sheet);
    models.forEach((model, index) => {
      if (this.#rankOf(model) > rankOf(size, good[index])) return;
      const [column, row] = [index % columns, Math.floor(index / columns)];
      const place = `${percent(column, columns - 1)} ${percent(row, rows - 1)}`;
      this.#known.set(model, {
        sheet,
        image: `url("${url}")`,
        extent: `${columns * 100}% ${rows * 100}%`,
        place,
        size,
        good: good[index]
      });
    });
    this.#tidy();
    this.#came();
  }
  /** Lets go of old sheets of which nothing is shown. */
  #tidy() {
    for (const sheet of this.#sheets) {
      if (this.#sheets.size <= SHEETS_KEPT) return;
      const used = sheet.models.filter((model) => this.#known.get(model)?.sheet === sheet);
      if (used.some((model) => this.#shown.has(model))) continue;
      for (const model of used) this.#known.delete(model);
      URL.revokeObjectURL(sheet.url);
      this.#sheets.delete(sheet);
    }
  }
};
function drawPicture(where, picture) {
  where.style.backgroundImage = picture?.image ?? "";
  where.style.backgroundSize = picture?.extent ?? "";
  where.style.backgroundPosition = picture?.place ?? "";
}
function percent(part, whole) {
  return whole ? `${100 * part / whole}%` : "0";
}
function rankOf(size, good = false) {
  return 2 * size - (good ? 0 : 1);
}

// scoring/compare.js
var PIXELS = 512;
var NAMES = { first: "This one", second: "That one", alike: "" };
var VERDICTS = { ArrowLeft: "first", ArrowRight: "second", ArrowDown: "alike", Delete: null, Backspace: null };
function makeCompare(page) {
  let index = 0;
  let shown = "";
  let ended = "";
  const heading = element("p", { class: "gl-asked", role: "status" });
  const sides = [makeSide("first"), makeSide("second")];
  const alike = textButton("Both alike", () => say("alike"), { title: "key ↓", class: "gl-button gl-alike" });
  const back = iconButton("previous", "Pair before", () => go(index - 1), "↑");
  const skip = iconButton("next", "Next pair", () => go(index + 1), "N");
  const clear = textButton("No answer", () => say(null), {
    title: "Remove the answer (Delete)",
    class: "gl-button gl-quiet"
  });
  const next = () => void page.ask("new_models", { way: "pairs" });
  const more = textButton("More pairs", next, {
    title: "Show other pairs of models"
  });
  const section = element(
    "section",
    { class: "gl-compare", "aria-label": "Compare two models", tabIndex: 0 },
    heading,
    element("div", { class: "gl-two" }, ...sides.map((side) => side.element)),
    element("div", { class: "gl-row gl-answers" }, back, alike, clear, skip, more)
  );
  function makeSide(verdict) {
    const picture = element("div", { class: "gl-picture" });
    const choose = element(
      "button",
      {
        type: "button",
        class: "gl-candidate",
        title: verdict === "first" ? "key ←" : "key →",
        ariaLabel: NAMES[verdict],
        // The second click of a double click would be about the next pair.
        onclick: (event) => event.detail < 2 && say(verdict)
      },
      picture
    );
    const name = element("span");
    const look = element(
      "button",
      {
        type: "button",
        class: "gl-button gl-quiet",
        title: "Enter",
        onclick: () => page.look(pair().models[verdict === "first" ? 0 : 1])
      },
      icon("cube"),
      "3D view"
    );
    const caption = element("figcaption", { class: "gl-row" }, name, element("span", { class: "gl-space" }), look);
    return {
      element: element("figure", { class: "gl-side-by-side" }, choose, caption),
      picture,
      choose,
      name,
      verdict
    };
  }
  function pair() {
    return pairs()[index];
  }
  function pairs() {
    return page.state.pairs ?? [];
  }
  function saidOf({ models, said: said2 }) {
    return page.outbox.findPair(models, page.factor().id) ?? { said: said2, saved: true };
  }
  function say(verdict) {
    if (!pair()) return;
    page.compare(pair().models, verdict);
    if (verdict === null || page.state.view === "product") return;
    if (pairs().some((each) => saidOf(each).said === null)) go(index + 1);
    else if (ended !== shown) {
      ended = shown;
      next();
    }
  }
  function go(to) {
    index = Math.max(0, Math.min(to, pairs().length - 1));
    draw();
  }
  function press(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.shiftKey || !pair()) return false;
    if (event.key in VERDICTS) say(VERDICTS[event.key]);
    else if (event.key === "ArrowUp") go(index - 1);
    else if (event.key === "n") go(index + 1);
    else if (event.key === "Enter" && event.target === section) page.look(pair().models[0]);
    else return false;
    return true;
  }
  function update() {
    const now = JSON.stringify(pairs().map(({ models }) => models));
    if (now !== shown) {
      const open = pairs().findIndex((each) => saidOf(each).said === null);
      index = Math.max(open, 0);
    }
    shown = now;
    draw();
  }
  function draw() {
    if (!pair()) return;
    const open = pairs().filter((each) => saidOf(each).said === null).length;
    const { said: said2, saved } = saidOf(pair());
    const words = open ? "Which one would you rather have?" : "All are answered; others come.";
    const asked = `Pair ${index + 1} of ${pairs().length}. ${words}`;
    if (heading.textContent !== asked) heading.textContent = asked;
    page.selection.follow(pair().models);
    sides.forEach(({ picture, choose, name, verdict }, side) => {
      const model = pair().models[side];
      const { label } = page.state.models[model];
      const found = page.pictures.find(model);
      drawPicture(picture, found);
      choose.ariaBusy = String(!found);
      name.textContent = label;
      choose.ariaLabel = `${NAMES[verdict]}: ${label}`;
      mark(choose, said2 === verdict, saved);
    });
    mark(alike, said2 === "alike", saved);
    back.disabled = index === 0;
    skip.disabled = index === pairs().length - 1;
    clear.disabled = said2 === null;
    more.classList.toggle("gl-primary", open === 0);
    const here = pair().models.every((model) => (page.pictures.find(model)?.size ?? 0) >= PIXELS);
    const wanted = pairs().slice(index, index + (here ? 2 : 1));
    page.pictures.want(
      wanted.flatMap(({ models }) => models),
      PIXELS
    );
  }
  return { element: section, press, update, draw, focus: () => section.focus({ preventScroll: true }) };
}
function mark(button, on, saved) {
  button.ariaPressed = String(on);
  button.classList.toggle("gl-unsaved", on && !saved);
}

// shared/scale.js
var SCALES = {
  score: {
    name: "0–100",
    steps: Array.from({ length: 11 }, (_, step) => ({
      score: 10 * step,
      key: step === 10 ? "h" : String(step),
      text: String(10 * step)
    }))
  },
  stars: {
    name: "Stars",
    steps: Array.from({ length: 5 }, (_, step) => ({
      score: 25 * step,
      key: String(step + 1),
      text: "★",
      label: `${step + 1} of 5 stars`
    }))
  },
  thumb: {
    name: "Thumbs",
    steps: [
      { score: 0, key: "0", text: "Down", label: "thumb down", picture: "down" },
      { score: 100, key: "1", text: "Up", label: "thumb up", picture: "up" }
    ]
  }
};
function scaleOf({ preferences: { scale } }) {
  return Object.hasOwn(SCALES, scale) ? (
    /** @type {Scale} */
    scale
  ) : "score";
}
function nextScale(page) {
  const names = (
    /** @type {Scale[]} */
    Object.keys(SCALES)
  );
  return names[(names.indexOf(scaleOf(page)) + 1) % names.length];
}
function scoreOfKey(scale, key) {
  if (key === "Delete" || key === "Backspace") return null;
  return SCALES[scale].steps.find((step) => step.key === key.toLowerCase())?.score;
}
function shortly({ score, kind }) {
  if (score === null) return "";
  if (kind === "stars") return `${1 + score / 25}★`;
  if (kind === "thumb") return score > 50 ? "▲" : "▼";
  return String(Math.round(score * 10) / 10);
}
function inWords({ score, kind }) {
  const step = SCALES[kind ?? "score"].steps.find((each) => each.score === score);
  return score === null ? "no score" : step?.label ?? `scored ${shortly({ score, kind: "score" })}`;
}
function makeSteps(page, label, give) {
  const box = element("div", { class: "gl-steps", role: "group", "aria-label": label });
  let drawn = "";
  function draw({ score, kind }) {
    const scale = scaleOf(page);
    const { steps } = SCALES[scale];
    if (scale !== drawn) box.replaceChildren(...steps.map((step) => makeStep(step, give)));
    drawn = scale;
    const isOn = (step) => scale === "stars" ? step.score <= Number(score) : step.score === score;
    steps.forEach(
      (step, index) => box.children[index].classList.toggle("gl-on", score !== null && kind === scale && isOn(step))
    );
  }
  return { element: box, draw };
}
function makeStep({ score, key, text, label, picture }, give) {
  return element(
    "button",
    {
      type: "button",
      class: "gl-button gl-step",
      title: `key ${key.toUpperCase()}`,
      "aria-label": label,
      onclick: () => give(score)
    },
    picture ? icon(picture) : null,
    text
  );
}

// scoring/known.js
function knownOf(page, model) {
  const { state, outbox } = page;
  const { mean, std, product, label, ...stored2 } = state.models[model];
  const { score, kind, saved } = outbox.find(model, page.factor().id) ?? { ...stored2, saved: true };
  if (state.view === "product") return { label, score, kind, saved, predicted: product ?? null, uncertain: null };
  return { label, score, kind, saved, predicted: mean, uncertain: std };
}
function inWords2({ label, score, kind, saved, predicted, uncertain }) {
  const parts = [label, `${inWords({ score, kind })}${score === null || saved ? "" : ", not saved yet"}`];
  if (predicted !== null) {
    parts.push(`predicted ${Math.round(predicted)}${uncertain === null ? "" : ` ± ${Math.round(uncertain)}`}`);
  }
  return parts.join(", ");
}
function counted(number2, noun) {
  return number2 ? `${number2} ${noun}${number2 === 1 ? "" : "s"}` : "";
}

// scoring/cell.js
var WIDEST = 50;
var Cell = class {
  #picture = element("div", { class: "gl-picture gl-empty" });
  #score = element("span", { class: "gl-score" });
  #predicted = bar("gl-predicted");
  #uncertain = bar("gl-uncertain");
  /** @type {Partial<Look>} */
  #look = {};
  element = element(
    "div",
    { class: "gl-cell", role: "option", tabindex: -1 },
    this.#picture,
    this.#score,
    element("div", { class: "gl-bars", "aria-hidden": "true" }, this.#predicted.element, this.#uncertain.element)
  );
  /** @param {Look} look */
  draw(look) {
    const before = this.#look;
    this.#look = look;
    if (look.model !== before.model) this.element.dataset.model = look.model;
    if (look.picture !== before.picture) this.#drawPicture(look.picture);
    if (look.score !== before.score || look.kind !== before.kind || look.saved !== before.saved) this.#drawScore(look);
    if (look.predicted !== before.predicted) this.#predicted.set(look.predicted, 100);
    if (look.uncertain !== before.uncertain) this.#uncertain.set(look.uncertain, WIDEST);
    if (look.chosen !== before.chosen) this.element.setAttribute("aria-selected", String(look.chosen));
    if (look.cursor !== before.cursor) this.element.tabIndex = look.cursor ? 0 : -1;
    const words = inWords2(look);
    if (before.label === void 0 || words !== inWords2(
      /** @type {Look} */
      before
    )) this.element.ariaLabel = words;
  }
  /** @param {Picture | undefined} picture */
  #drawPicture(picture) {
    drawPicture(this.#picture, picture);
    this.#picture.classList.toggle("gl-empty", !picture);
  }
  /** @param {Look} look */
  #drawScore({ score, kind, saved }) {
    this.#score.textContent = shortly({ score, kind });
    this.#score.classList.toggle("gl-unsaved", !saved);
  }
};
function bar(name) {
  const fill = element("i");
  const number2 = element("b");
  return {
    element: element("div", { class: `gl-bar ${name}` }, element("span", {}, fill), number2),
    /** @param {number | null} value @param {number} full */
    set(value, full) {
      fill.style.transform = `scaleX(${Math.min(Math.max((value ?? 0) / full, 0), 1)})`;
      number2.dataset.value = value === null ? "" : String(Math.round(value));
    }
  };
}

// scoring/display.js
var ZOOMS = { least: 0.5, most: 10 };
var JUDGED = 200;
var OVERVIEW = 5;
var SMALLEST = 26;
var LARGEST = 1200;
var ROOMY = 104;
var BARS = 12;
var ROOMY_BARS = 27;
var BY_HAND = 1500;
var NEAR = "25% 0px";
var NARROW = 620;
function makeDisplay(page) {
  const grids = [];
  const board = element("div", { class: "gl-board" });
  const more = textButton("More models", () => void ask(), { class: "gl-button gl-quiet gl-more" });
  const stage = element("div", { class: "gl-stage" }, board, more);
  const about = element("p", { class: "gl-about" });
  const { pictures } = page;
  let zoom = 1;
  let columns = 1;
  let size = 0;
  let frame = 0;
  let zoomed = () => {
  };
  let asked = "";
  let moved = -Infinity;
  const resizes = new ResizeObserver(() => fit());
  resizes.observe(stage);
  const byHand = () => moved = performance.now();
  stage.addEventListener("wheel", byHand, { passive: true });
  stage.addEventListener("touchmove", byHand, { passive: true });
  stage.addEventListener("pointerdown", ({ target }) => target === stage && byHand());
  const atEnd = new IntersectionObserver(([{ isIntersecting }]) => {
    if (isIntersecting && performance.now() - moved < BY_HAND) void ask();
  });
  atEnd.observe(more);
  const near = /* @__PURE__ */ new Set();
  const comings = new IntersectionObserver(
    (entries) => {
      for (const { target, isIntersecting } of entries) near[isIntersecting ? "add" : "delete"](target);
      wantPictures();
    },
    { root: stage, rootMargin: NEAR }
  );
  async function ask() {
    const now = page.selection.order.join();
    if (asked === now) return;
    asked = now;
    if (!await page.ask("more")) asked = "";
  }
  function update(state) {
    if (!state.updating) asked = "";
    const beginsAnew = page.selection.show(state.grids.flatMap((grid) => grid.models));
    while (grids.length < state.grids.length) grids.push(makeGrid(grids.length));
    if (board.childElementCount !== state.grids.length) {
      board.replaceChildren(...state.grids.map((_, index) => grids[index].element));
    }
    state.grids.forEach((grid, index) => fill(grids[index], grid.title, grid.models.length));
    fit();
    draw();
    if (beginsAnew) focus();
  }
  function fill({ title: heading, list, cells }, title, count) {
    heading.textContent = title || "more";
    while (cells.length < count) {
      const cell = new Cell();
      comings.observe(cell.element);
      cells.push(cell);
    }
    while (list.childElementCount > count) list.lastElementChild?.remove();
    for (let next = list.childElementCount; next < count; next += 1) list.append(cells[next].element);
  }
  function fit() {
    const layout = page.state.layout;
    const count = page.state.grids.length;
    const { clientWidth: width, offsetHeight: height } = stage;
    if (!width) return;
    const stacked = count > 1 && width < NARROW;
    const gap = layout.columns > 6 ? 4 : 8;
    const room = stacked ? width - 34 : (width - 34 - (count - 1) * 24) / count;
    const tall = (height - 56) / layout.rows - gap;
    const bars = page.preferences.bars ? tall - ROOMY_BARS >= ROOMY ? ROOMY_BARS : BARS : 0;
    const high = bars === BARS ? Math.min(tall - bars, ROOMY - 1) : tall - bars;
    const wide = room / layout.columns - gap;
    let fitting = stacked || height < 260 ? wide : Math.min(wide, high);
    columns = layout.columns;
    if (fitting < JUDGED && columns < OVERVIEW) {
      const most = Math.max(Math.floor((room + gap) / (JUDGED + gap)), 2);
      columns = Math.min(columns, most);
      fitting = Math.max(Math.min(room / columns - gap, Math.max(JUDGED, height - 56 - ROOMY_BARS)), fitting);
    }
    size = Math.min(Math.max(Math.floor(fitting * zoom), SMALLEST), LARGEST);
    stage.classList.toggle("gl-stacked", stacked);
    stage.classList.toggle("gl-roomy", size >= ROOMY);
    stage.classList.toggle("gl-no-bars", !page.preferences.bars);
    stage.style.setProperty("--gl-size", `${size}px`);
    stage.style.setProperty("--gl-gap", `${gap}px`);
    stage.style.setProperty("--gl-columns", String(columns));
    wantPictures();
  }
  function wantPictures() {
    if (page.state.pairs || !size) return;
    const here = tiles();
    const [inView, others] = [true, false].map(
      (is) => page.selection.order.filter((_, at) => near.has(here[at]) === is)
    );
    pictures.want(inView, pixelsFor(size), others);
  }
  function drawSoon() {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      draw();
    });
  }
  function draw() {
    if (page.state.pairs) return;
    let position = 0;
    page.state.grids.forEach((grid, index) => {
      const first = position;
      const here = page.selection.cursor - first;
      const keyboard = here >= 0 && here < grid.models.length ? here : 0;
      grid.models.forEach((model, place) => {
        const chosen = page.selection.chosen.has(model);
        const [picture, cursor] = [pictures.find(model), place === keyboard];
        grids[index].cells[place].draw({ ...knownOf(page, model), model, picture, chosen, cursor });
      });
      position += grid.models.length;
    });
    describe(page.selection.current);
  }
  function describe(model) {
    about.textContent = model && page.state.models[model] ? inWords2(knownOf(page, model)) : "";
  }
  function zoomBy(factor, to = middle(), held = hold(to)) {
    zoom = factor ? Math.min(Math.max(zoom * factor, ZOOMS.least), ZOOMS.most) : 1;
    fit();
    zoomed();
    const box = held.anchor.getBoundingClientRect();
    stage.scrollLeft += box.x + held.x * box.width - to.clientX;
    stage.scrollTop += box.y + held.y * box.height - to.clientY;
  }
  function hold({ clientX, clientY }) {
    const ground = (
      /** @type {Document | ShadowRoot} */
      stage.getRootNode()
    );
    const anchor = ground.elementFromPoint(clientX, clientY)?.closest(".gl-cell") ?? board;
    const box = anchor.getBoundingClientRect();
    return { anchor, x: (clientX - box.x) / box.width, y: (clientY - box.y) / box.height };
  }
  function middle() {
    const { x, y, width, height } = stage.getBoundingClientRect();
    return { clientX: x + width / 2, clientY: y + height / 2 };
  }
  function positionOf(target) {
    const tile = target instanceof Element ? target.closest(".gl-cell") : null;
    return tile ? tiles().indexOf(tile) : -1;
  }
  function tiles() {
    return page.state.grids.flatMap((_, index) => [...grids[index].list.children]);
  }
  function focus() {
    const tile = (
      /** @type {HTMLElement | undefined} */
      tiles()[page.selection.cursor]
    );
    tile?.focus({ preventScroll: true });
    tile?.scrollIntoView({ block: "nearest", inline: "nearest" });
  }
  function askAgain() {
    pictures.askAgain();
    fit();
  }
  function close() {
    resizes.disconnect();
    atEnd.disconnect();
    comings.disconnect();
  }
  return {
    element: stage,
    about,
    columns: () => columns,
    update,
    drawSoon,
    fit,
    describe,
    zoomBy,
    zoom: () => zoom,
    /** Calls a function after every change of the zoom. @param {() => void} listener */
    whenZoomed: (listener) => void (zoomed = listener),
    hold,
    positionOf,
    tiles,
    focus,
    askAgain,
    close
  };
}
function makeGrid(index) {
  const id = `gl-grid-${Math.random().toString(36).slice(2, 8)}-${index}`;
  const title = element("h2", { id, class: "gl-title" });
  const list = element("div", {
    class: "gl-grid",
    role: "listbox",
    "aria-multiselectable": "true",
    "aria-labelledby": id
  });
  const cells = [];
  return { element: element("section", { class: "gl-section" }, title, list), title, list, cells };
}
function pixelsFor(size) {
  return size * Math.min(globalThis.devicePixelRatio || 1, 2) > 200 ? 320 : 160;
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

// scoring/factors.js
function makeFactors(page) {
  const list = element("div", { class: "gl-factors", role: "group", "aria-label": "Factor of new scores" });
  const edit = menu(
    iconButton("more", "Rename or delete this factor", () => {
    }),
    "This factor",
    buildEdit
  );
  const create = menu(
    iconButton("plus", "New factor", () => {
    }),
    "New factor",
    buildCreate
  );
  const tabs = [];
  const product = makeTab(() => void page.ahead.set("view", "product", page.ask("view", { kind: "product" })));
  product.element.title = "The product of all factors; new scores belong to one factor";
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
  async function activate({ id }) {
    const active = page.ahead.of("factor", page.factor().id);
    const view = page.ahead.of("view", page.state.view);
    await Promise.all([
      id === active ? null : page.ahead.set("factor", id, page.ask("factor_activate", { name: id })),
      view === "active" ? null : page.ahead.set("view", "active", page.ask("view", { kind: "active" }))
    ]);
  }
  function buildCreate(close) {
    return [
      element(
        "p",
        {},
        "A factor is one aspect of what you like, such as shape or colour. Models are learned that all factors like: their scores are multiplied."
      ),
      nameForm("Create", "", (name) => {
        close();
        void page.ask("factor_create", { name });
      })
    ];
  }
  function buildEdit(close) {
    const { id, name, labels } = page.factor();
    const remove = textButton(
      `Delete “${name}” and its ${counted(labels, "score") || "scores"}`,
      () => {
        close();
        void page.ask("factor_delete", { name: id });
      },
      { class: "gl-button gl-danger", disabled: page.state.factors.length === 1 }
    );
    return [
      element("p", {}, `Factor “${name}”`),
      nameForm("Rename", name, (to) => {
        close();
        if (to !== name) void page.ask("factor_rename", { name: id, to });
      }),
      element("hr"),
      remove
    ];
  }
  return { element: element("div", { class: "gl-row" }, list, edit, create), update };
}
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
    }
  };
}
function nameForm(verb, value, done) {
  const input = element("input", {
    class: "gl-input",
    value,
    maxLength: 60,
    required: true,
    "aria-label": "Name of the factor",
    placeholder: "name"
  });
  return element(
    "form",
    {
      class: "gl-row",
      onsubmit: (event) => {
        event.preventDefault();
        if (input.value.trim()) done(input.value.trim());
      }
    },
    input,
    element("button", { class: "gl-button gl-primary" }, verb)
  );
}

// scoring/keyboard.js
var RATED = ["scored", "already ranked"];
var KEYS = [
  ["0 … 9", "score 0 … 90 for all selected models"],
  ["H", "score 100"],
  ["S", "type any score, then Enter"],
  ["1 … 5", "on the scale of stars: one to five stars"],
  ["0, 1", "on the scale of thumbs: thumb down, thumb up"],
  ["T", "next scale: 0–100, stars, thumbs"],
  ["Delete", "remove the score"],
  ["Arrows, Home, End", "move and select; with Shift, select a range; with Ctrl, move only"],
  ["Space", "select or deselect"],
  ["Ctrl A, Escape", "select all, select none"],
  [
    "Enter",
    "show the model in 3D; in this view, ← and → show its neighbours, ↑ and ↓ the rules of its parts, and Shift with arrows turns it; a finger that goes sideways above or below the picture shows the neighbours, too"
  ],
  ["C", "compare models two at a time, or go back to the grids"],
  [
    "← → ↓",
    "while comparing: prefer the left model, prefer the right model, both alike; ↑ shows the previous pair, N the next pair, Delete removes the answer, Enter shows both in 3D"
  ],
  ["U or Ctrl Z, Ctrl Shift Z", "undo, redo"],
  ["Ctrl Enter", "learn from all scores now, then show new models"],
  ["+ − =", "zoom in, zoom out, show all; also Ctrl with the wheel"],
  ["?", "show or hide these keys"]
];
function listenToKeys(page, display, panel) {
  const { selection } = page;
  const stage = display.element;
  stage.addEventListener("keydown", (event) => {
    if (display.positionOf(event.target) < 0 || event.altKey) return;
    const command = event.ctrlKey || event.metaKey;
    if (!(command ? withCommand(event) : plain(event))) return;
    event.preventDefault();
  });
  stage.addEventListener("focusin", (event) => {
    const position = display.positionOf(event.target);
    if (position >= 0 && position !== selection.cursor) selection.moveTo(position);
  });
  function withCommand(event) {
    if (event.key === "a") selection.all();
    else if (event.key === " ") selection.toggle(selection.cursor);
    else return move(event);
    return true;
  }
  function plain(event) {
    const { key } = event;
    const score = scoreOfKey(scaleOf(page), key);
    if (score !== void 0) scoreSelected(score);
    else if (key === "s") panel.typeScore();
    else if (key === " ") selection.toggle(selection.cursor);
    else if (key === "Enter" && selection.current) page.look(selection.current);
    else if (key === "Escape") selection.none();
    else if (key === "+") display.zoomBy(1.25);
    else if (key === "-") display.zoomBy(0.8);
    else if (key === "=") display.zoomBy(0);
    else return move(event);
    return true;
  }
  function move(event) {
    const to = destination(page, event.key, display.columns());
    if (to === void 0) return false;
    if (event.ctrlKey || event.metaKey) selection.moveTo(to);
    else if (event.shiftKey) selection.rangeTo(to, false);
    else selection.only(to);
    display.focus();
    return true;
  }
  function scoreSelected(score) {
    if (!selection.chosen.size && selection.current) selection.only(selection.cursor);
    page.score(selection.models, score);
    handOn();
  }
  function handOn() {
    if (page.preferences.advance && selection.models.length === 1) {
      const { order, cursor } = selection;
      const open = cursor + 1 < order.length ? cursor + 1 : order.findIndex((model) => knownOf(page, model).score === null);
      if (open >= 0) selection.only(open);
      else if (!RATED.includes(page.state.way) && selection.startAnew())
        void page.ask("new_models", { way: page.state.way });
    }
    display.focus();
  }
  return { handOn };
}
function destination({ state, selection }, key, columns) {
  let first = 0;
  let index = 0;
  while (index + 1 < state.grids.length && selection.cursor >= first + state.grids[index].models.length) {
    first += state.grids[index].models.length;
    index += 1;
  }
  const count = state.grids[index].models.length;
  const here = selection.cursor - first;
  const column = here % columns;
  const row = here - column;
  const within = (place) => place >= 0 && place < count ? first + place : selection.cursor;
  const end = Math.min(row + columns, count) - 1;
  switch (key) {
    case "ArrowUp":
      return within(here - columns);
    case "ArrowDown":
      return within(here + columns);
    case "ArrowLeft":
      if (column > 0) return within(here - 1);
      if (index === 0) return selection.cursor;
      return first - state.grids[index - 1].models.length + Math.min(row + columns, state.grids[index - 1].models.length) - 1;
    case "ArrowRight":
      if (here < end) return within(here + 1);
      if (index + 1 >= state.grids.length) return selection.cursor;
      return first + count + Math.min(row, state.grids[index + 1].models.length - 1);
    case "Home":
      return first;
    case "End":
      return first + count - 1;
    default:
      return void 0;
  }
}

// scoring/busy.js
function makeBusy(name, cancel) {
  const bar2 = element("progress", { class: "gl-progress", max: 1, "aria-label": name });
  const stage = element("span");
  const stop = textButton("Cancel", cancel);
  const section = element(
    "div",
    { class: "gl-busy", hidden: true },
    bar2,
    element("div", { class: "gl-row" }, stage, element("span", { class: "gl-space" }), stop)
  );
  function progress(now) {
    section.hidden = now === null;
    if (!now) return;
    const share = now.done && now.total ? ` ${Math.round(100 * now.done / now.total)} %` : "";
    stage.textContent = `${now.stage}…${share}`;
    if (now.total) bar2.value = now.done / now.total;
    else bar2.removeAttribute("value");
  }
  return { element: section, progress };
}

// scoring/contrasts.js
var SIZE = 160;
var TITLE = "One seed without and with the choice; the numbers are the mean predictions for all such models";
function makeContrasts(page) {
  const list = element("div", { class: "gl-contrasts" });
  let drawn = "";
  function update({ contrasts }) {
    const now = JSON.stringify(contrasts);
    if (now === drawn) return;
    drawn = now;
    for (const old of list.querySelectorAll("img")) URL.revokeObjectURL(old.src);
    list.replaceChildren();
    void show(contrasts, now);
  }
  async function show(contrasts, now) {
    for (const { text, without, having } of contrasts) {
      const [picture] = await page.channel.request("contrast", { choice: text, size: SIZE }).then(
        ({ buffers }) => buffers,
        () => []
        // no seed gives two such models
      );
      if (drawn !== now) return;
      if (!picture) continue;
      const image = element("img", {
        src: URL.createObjectURL(new Blob([picture], { type: "image/jpeg" })),
        width: 2 * SIZE,
        height: SIZE,
        alt: `One model without ${text}, and the same with it`
      });
      const labels = [`without: ${without}`, `with: ${having}`].map((label) => element("span", {}, label));
      list.append(
        element(
          "figure",
          { title: TITLE },
          element("figcaption", {}, text),
          image,
          element("div", { class: "gl-sides" }, ...labels)
        )
      );
    }
  }
  return { element: list, update };
}

// scoring/line.js
function makeLine(page) {
  const list = element("div", { class: "gl-next" });
  const figure = element(
    "figure",
    { role: "img", hidden: true },
    element("figcaption", { class: "gl-next-title", "aria-hidden": "true" }, "Next in line"),
    list
  );
  function draw() {
    const { line } = page.state;
    figure.hidden = line.length === 0;
    figure.ariaLabel = `${line.length} models that are next in line`;
    while (list.childElementCount < line.length) list.append(element("span", { class: "gl-picture" }));
    while (list.childElementCount > line.length) list.lastElementChild?.remove();
    line.forEach((model, at) => drawPicture(
      /** @type {HTMLElement} */
      list.children[at],
      page.pictures.find(model)
    ));
  }
  return { element: figure, draw };
}

// scoring/learning.js
var LITTLE = 0.01;
var LEAST_SHARE = 0.1;
function makeLearning(page) {
  const busy = makeBusy("Learning", () => void page.ask("cancel"));
  const hint = element("p", { class: "gl-hint" });
  const chart = element("figure", { class: "gl-chart" });
  const relevance = element("ul", { class: "gl-relevance" });
  const words = element("div", { class: "gl-words" });
  const contrasts = makeContrasts(page);
  const why = element("div", {}, element("h3", {}, "What the score depends on"), words, contrasts.element, relevance);
  const line = makeLine(page);
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Learning" },
    line.element,
    busy.element,
    hint,
    chart,
    why
  );
  let drawn = "";
  function update(state) {
    busy.progress(state.updating);
    line.draw();
    hint.textContent = hintOf(state);
    why.hidden = state.relevance.length + state.words.length === 0;
    words.replaceChildren(...state.words.map((line2) => element("p", {}, line2)));
    contrasts.update(state);
    relevance.replaceChildren(...state.relevance.map(relevanceLine));
    const points = JSON.stringify(state.chart);
    if (points !== drawn) chart.replaceChildren(...drawChart(state.chart));
    drawn = points;
  }
  return { element: section, update, progress: busy.progress, draw: line.draw };
}
function hintOf(state) {
  const [{ fresh, chart, explained, gain, turn, active }, all] = [state, said(state)];
  if (!all) return "Score some models: those in line follow your scores.";
  if (!fresh) return `${all}; the predictions do not know all of them yet.`;
  const last = chart.slice(-2);
  const steady = explained && last.length === 2 && last.every(({ js }) => js < LITTLE);
  const more = gain === null ? "" : ` 16 more may change what is learned by ${asShare(gain)}.`;
  const next = turn && turn !== active ? ` Those of “${turn}” tell the most.` : "";
  const known = steady ? "the last updates changed little, so you may stop." : "the predictions know them all.";
  return `${all}; ${known}${more}${next}`;
}
function asShare(nats) {
  const share = 100 * nats / Math.LN2;
  if (share < LEAST_SHARE) return `less than ${LEAST_SHARE} %`;
  return `${share >= 10 ? Math.round(share) : Number(share.toPrecision(1))} %`;
}
function said({ scored, compared }) {
  return [counted(scored, "score"), counted(compared, "comparison")].filter(Boolean).join(" and ");
}
function relevanceLine({ name, level, share }) {
  const fill = element("i");
  fill.style.transform = `scaleX(${Math.min(Math.max(share, 0), 1)})`;
  return element(
    "li",
    {},
    element("span", {}, name),
    element("b", {}, level),
    element("span", { class: "gl-share", "aria-hidden": "true" }, fill)
  );
}
function drawChart(movements) {
  if (movements.length === 0) return [];
  const [width, height] = [260, 64];
  const highest = Math.max(...movements.map(({ js: js2 }) => js2), 2 * LITTLE);
  const most = movements[movements.length - 1].labels;
  const least = movements[0].labels;
  const points = movements.map(({ labels, js: js2 }) => ({
    x: most > least ? 4 + (labels - least) / (most - least) * (width - 8) : width / 2,
    y: height - 4 - js2 / highest * (height - 12),
    words: `${counted(labels, "score") || "no scores"}: changed by ${asShare(js2)}`
  }));
  const line = svg("polyline", { class: "gl-line", points: points.map(({ x, y }) => `${x},${y}`).join(" ") });
  const dots = points.map(({ x, y, words }) => {
    const title = svg("title");
    title.textContent = words;
    return svg("circle", { class: "gl-dot", cx: x, cy: y, r: 3 }, title);
  });
  const level = height - 4 - LITTLE / highest * (height - 12);
  const little = svg("line", { class: "gl-little", x1: 0, x2: width, y1: level, y2: level });
  const { js } = movements[movements.length - 1];
  const caption = `The last update changed what is learned by ${asShare(js)}`;
  return [
    svg(
      "svg",
      { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": points.map(({ words }) => words).join("; ") },
      little,
      line,
      ...dots
    ),
    element(
      "figcaption",
      {
        title: "0 %: the same models as before; 100 %: none of them. Below the dashed line, updates change little"
      },
      caption
    )
  ];
}

// shared/rule.js
var INVITATION = "Click a part of the model to see the rule that made it.";
function makeRule(channel, mark2) {
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
    mark2(null);
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
      mark2(part.triangles);
      text.replaceChildren(...inWords3(part));
    } catch (error) {
      if (turn !== asked) return;
      number2 = part ? part.number : null;
      text.replaceChildren(`No rule: ${error instanceof Error ? error.message : error}`);
    }
  }
  return { element: panel, open, pick, step, clear };
}
function inWords3({ number: number2, count, path }) {
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

// scoring/look.js
var SWIPE = 50;
var TURN = Math.PI / 16;
var MOVEMENTS = {
  "Shift ArrowLeft": [-TURN, 0, 1],
  "Shift ArrowRight": [TURN, 0, 1],
  "Shift ArrowUp": [0, TURN, 1],
  "Shift ArrowDown": [0, -TURN, 1],
  "+": [0, 0, 1.25],
  "-": [0, 0, 0.8]
};
function makeLook(page, code, backToGrid) {
  let view = null;
  let model = "";
  let canvas = element("canvas", {
    class: "gl-canvas",
    tabIndex: 0,
    "aria-label": "Model in 3D: drag or Shift with arrows to turn, wheel or + − to zoom, = to see all, click or ↑ ↓ for the rules of parts"
  });
  const room = element("div", { class: "gl-room" }, canvas);
  const title = element("h2", { class: "gl-look-title" });
  const note = element("p", { class: "gl-look-note", role: "status" });
  const rule = makeRule(page.channel, (triangles) => view?.mark(triangles));
  const steps = makeSteps(page, "Score of this model", (score) => page.score([model], score));
  const dialog = element(
    "dialog",
    { class: "gl-look", "aria-label": "Model in 3D" },
    element(
      "header",
      { class: "gl-row" },
      iconButton("previous", "Previous model", () => go(-1), "←"),
      iconButton("next", "Next model", () => go(1), "→"),
      title,
      element("span", { class: "gl-space" }),
      iconButton("fit", "Whole model", () => view?.reset()),
      iconButton("close", "Close", () => dialog.close(), "Esc")
    ),
    room,
    note,
    rule.element,
    element("footer", {}, steps.element)
  );
  const resizes = new ResizeObserver(() => view?.resize());
  resizes.observe(room);
  dialog.addEventListener("close", () => {
    view?.dispose();
    view = null;
    canvas = /** @type {HTMLCanvasElement} */
    canvas.cloneNode();
    room.replaceChildren(canvas);
    page.selection.only(Math.max(page.selection.order.indexOf(model), 0));
    backToGrid();
  });
  let finger = null;
  dialog.addEventListener("pointerdown", (event) => {
    const isSwipe = event.pointerType === "touch" && event.isPrimary && !event.composedPath().includes(room);
    finger = isSwipe ? event : null;
  });
  dialog.addEventListener("pointercancel", () => finger = null);
  dialog.addEventListener("pointerup", (event) => {
    if (event.pointerId !== finger?.pointerId) return;
    const [right, down] = [event.clientX - finger.clientX, event.clientY - finger.clientY];
    finger = null;
    if (Math.abs(right) >= Math.max(SWIPE, 2 * Math.abs(down))) void go(right < 0 ? 1 : -1);
  });
  dialog.addEventListener("keydown", (event) => {
    if (!dialog.open || event.ctrlKey || event.metaKey || event.altKey) return;
    const score = scoreOfKey(scaleOf(page), event.key);
    const movement = MOVEMENTS[`${event.shiftKey && event.key.startsWith("Arrow") ? "Shift " : ""}${event.key}`];
    if (movement) view?.move(...movement);
    else if (event.key === "=") view?.reset();
    else if (event.key === "ArrowUp") void rule.step(-1);
    else if (event.key === "ArrowDown") void rule.step(1);
    else if (event.key === "ArrowLeft") void go(-1);
    else if (event.key === "ArrowRight") void go(1);
    else if (score !== void 0) page.score([model], score);
    else return;
    event.preventDefault();
  });
  async function open(id) {
    model = id;
    rule.open(id);
    if (!dialog.open) dialog.showModal();
    canvas.focus();
    update();
    note.textContent = "loading…";
    try {
      const [{ buffers }, { show }] = await Promise.all([page.channel.request("model", { model: id }), code()]);
      if (!dialog.open || model !== id) return;
      const damping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
      view ??= show(canvas, { damping, picked: rule.pick });
      await view.load(buffers[0]);
      note.textContent = "";
    } catch (error) {
      if (model === id) note.textContent = `No 3D view: ${error instanceof Error ? error.message : error}`;
    }
  }
  function go(step) {
    const order = [...new Set(page.selection.order)];
    const next = order[order.indexOf(model) + step];
    if (next) return open(next);
  }
  function update() {
    if (!dialog.open || !page.state.models[model]) return;
    const known = knownOf(page, model);
    title.textContent = inWords2(known);
    steps.draw(known);
  }
  return {
    element: dialog,
    open,
    update,
    close() {
      resizes.disconnect();
      dialog.close();
    }
  };
}

// scoring/outbox.js
var Outbox = class {
  #channel;
  /** @type {() => void} */
  #changed;
  /** @type {(error: Error) => void} */
  #refused;
  /** @type {Entry[]} */
  #entries = [];
  /** @param {Channel} channel @param {() => void} changed @param {(error: Error) => void} refused */
  constructor(channel, changed, refused) {
    this.#channel = channel;
    this.#changed = changed;
    this.#refused = refused;
  }
  /** @param {string[]} models @param {Said} said @param {number} factor */
  add(models, said2, factor) {
    this.#put({ models, said: said2, verdict: null, factor });
  }
  /** @param {string[]} models two of them @param {Verdict | null} verdict @param {number} factor */
  compare(models, verdict, factor) {
    this.#put({ models, said: null, verdict, factor });
  }
  /** @param {Omit<Entry, "key" | "since">} act */
  #put(act) {
    const key = Math.random().toString(36).slice(2) + Date.now().toString(36);
    const entry = { ...act, key, since: performance.now() };
    this.#entries.push(entry);
    this.#changed();
    void this.#send(entry);
  }
  /** After a reconnection: everything that was not acknowledged, in the order it was given. */
  resend() {
    for (const entry of this.#unsaved) void this.#send(entry);
  }
  /** Python's state includes all events up to a revision, so they are removed here. @param {number} revision */
  settle(revision) {
    this.#entries = this.#entries.filter((entry) => entry.revision === void 0 || entry.revision > revision);
  }
  /** Number of scores and comparisons that are not on disk. */
  get unsaved() {
    return this.#unsaved.reduce((sum, { said: said2, models }) => sum + (said2 ? models.length : 1), 0);
  }
  /** Milliseconds since the oldest score that is not on disk. */
  get waiting() {
    const [oldest] = this.#unsaved;
    return oldest ? performance.now() - oldest.since : 0;
  }
  /**
   * The unacknowledged score of a model, newer than the one of Python.
   * @param {string} model
   * @param {number} factor
   * @returns {Said & { saved: boolean } | undefined}
   */
  find(model, factor) {
    const entry = this.#entries.findLast((each) => each.said && each.factor === factor && each.models.includes(model));
    return entry?.said ? { ...entry.said, saved: entry.revision !== void 0 } : void 0;
  }
  /**
   * What was said of a pair here, newer than what Python told.
   * @param {string[]} models
   * @param {number} factor
   * @returns {{ said: Verdict | null, saved: boolean } | undefined}
   */
  findPair(models, factor) {
    const entry = this.#entries.findLast(
      (each) => !each.said && each.factor === factor && each.models.join() === models.join()
    );
    return entry && { said: entry.verdict, saved: entry.revision !== void 0 };
  }
  get #unsaved() {
    return this.#entries.filter((entry) => entry.revision === void 0);
  }
  /** @param {Entry} entry */
  async #send(entry) {
    const { key, factor } = entry;
    const [command, rest] = entry.said ? ["score", { models: entry.models, ...entry.said }] : ["compare", comparison(entry.models, entry.verdict)];
    try {
      const { result } = await this.#channel.request(command, { key, factor, ...rest });
      entry.revision = result.revision;
    } catch (error) {
      if (error instanceof ConnectionLost) return this.#changed();
      this.#entries = this.#entries.filter((other) => other !== entry);
      this.#refused(
        /** @type {Error} */
        error
      );
    }
    this.#changed();
  }
};
function comparison(models, verdict) {
  if (verdict === null) return { models, kind: null };
  return { models: verdict === "second" ? models.toReversed() : models, kind: verdict === "alike" ? "tie" : "rather" };
}

// scoring/pointer.js
var SLACK = 4;
var LINE = 34;
var NOTCH = 100;
var STEP = 24;
function listenToPointer(page, display) {
  const stage = display.element;
  const band = element("div", { class: "gl-band", hidden: true });
  stage.append(band);
  let drag = null;
  let pinch = null;
  let panning = false;
  stage.addEventListener("pointerdown", (event) => {
    if (event.button > 1 || onScrollbar(event)) return;
    const command = event.ctrlKey || event.metaKey;
    const pans = panning || command || event.button === 1 || event.pointerType === "touch";
    const kept = new Set(event.shiftKey ? page.selection.chosen : []);
    drag = { event, moved: false, pans, kept, left: stage.scrollLeft, top: stage.scrollTop };
    if (event.button === 1) event.preventDefault();
  });
  stage.addEventListener("pointermove", (event) => {
    if (!drag) return hover(event);
    const { event: start } = drag;
    if (!drag.moved && Math.hypot(event.clientX - start.clientX, event.clientY - start.clientY) < SLACK) return;
    if (!drag.moved) stage.setPointerCapture(event.pointerId);
    drag.moved = true;
    if (drag.pans) pan(event);
    else stretch(event);
  });
  for (
    const end of
    /** @type {const} */
    ["pointerup", "pointercancel"]
  ) {
    stage.addEventListener(end, (event) => {
      if (drag && !drag.moved && end === "pointerup" && drag.event.button === 0) click(event);
      drag = null;
      band.hidden = true;
      stage.classList.remove("gl-grabbing");
    });
  }
  stage.addEventListener("dblclick", (event) => {
    const position = display.positionOf(event.target);
    if (position >= 0) page.look(page.selection.order[position]);
  });
  stage.addEventListener("pointerleave", () => display.describe(page.selection.current));
  stage.addEventListener(
    "wheel",
    (event) => {
      if (!event.ctrlKey && !event.metaKey) return;
      event.preventDefault();
      const turned = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1);
      const far = Math.abs(turned) < NOTCH ? turned : Math.sign(turned) * STEP;
      display.zoomBy(Math.exp(-far / 100), event);
    },
    { passive: false }
  );
  stage.addEventListener(
    "touchstart",
    (event) => {
      grip(event);
      if (!pinch) return;
      if (event.cancelable) event.preventDefault();
      drag = null;
    },
    { passive: false }
  );
  stage.addEventListener(
    "touchmove",
    (event) => {
      const now = apart(event);
      if (!pinch || !now) return;
      if (event.cancelable) event.preventDefault();
      display.zoomBy(now.distance / pinch.distance, now, pinch.held);
      pinch.distance = now.distance;
    },
    { passive: false }
  );
  for (
    const end of
    /** @type {const} */
    ["touchend", "touchcancel"]
  ) {
    stage.addEventListener(end, grip);
  }
  function grip(event) {
    const fingers = apart(event);
    pinch = fingers && { distance: fingers.distance, held: display.hold(fingers) };
  }
  function click(event) {
    const position = display.positionOf(event.target);
    const { selection } = page;
    if (position < 0) return event.shiftKey || event.ctrlKey || event.metaKey ? void 0 : selection.none();
    if (event.shiftKey) selection.rangeTo(position, event.ctrlKey || event.metaKey);
    else if (event.ctrlKey || event.metaKey) selection.toggle(position);
    else if (event.pointerType === "touch") selection.touch(position);
    else selection.only(position);
    display.focus();
  }
  function hover(event) {
    const position = display.positionOf(event.target);
    display.describe(position < 0 ? page.selection.current : page.selection.order[position]);
  }
  function pan(event) {
    if (!drag || event.pointerType === "touch") return;
    stage.classList.add("gl-grabbing");
    stage.scrollLeft = drag.left - (event.clientX - drag.event.clientX);
    stage.scrollTop = drag.top - (event.clientY - drag.event.clientY);
  }
  function stretch(event) {
    if (!drag) return;
    const room = stage.getBoundingClientRect();
    if (event.clientY > room.bottom - 12) stage.scrollTop += 12;
    if (event.clientY < room.top + 12) stage.scrollTop -= 12;
    const [left, right] = [drag.event.clientX + drag.left - stage.scrollLeft, event.clientX].sort((a, b) => a - b);
    const [top, bottom] = [drag.event.clientY + drag.top - stage.scrollTop, event.clientY].sort((a, b) => a - b);
    band.hidden = false;
    band.style.transform = `translate(${left - room.left + stage.scrollLeft}px, ${top - room.top + stage.scrollTop}px)`;
    band.style.width = `${right - left}px`;
    band.style.height = `${bottom - top}px`;
    const inside = display.tiles().map((tile) => {
      const box = tile.getBoundingClientRect();
      return box.left < right && box.right > left && box.top < bottom && box.bottom > top;
    });
    page.selection.replace([...drag.kept, ...page.selection.order.filter((_, position) => inside[position])]);
  }
  function onScrollbar(event) {
    const room = stage.getBoundingClientRect();
    return event.clientX > room.left + stage.clientWidth || event.clientY > room.top + stage.clientHeight;
  }
  return {
    /** Dragging pans instead of selecting. @param {boolean} on */
    pan(on) {
      panning = on;
      stage.classList.toggle("gl-pans", on);
    }
  };
}
function apart({ touches }) {
  if (touches.length !== 2) return null;
  const [a, b] = touches;
  const distance = Math.max(Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY), 1);
  return { distance, clientX: (a.clientX + b.clientX) / 2, clientY: (a.clientY + b.clientY) / 2 };
}

// scoring/preferences.js
var DEFAULTS = { bars: true, advance: true, preview: true, scale: "score" };
function loadPreferences() {
  return new Proxy(
    { ...DEFAULTS, ...stored() },
    {
      set(all, name, value) {
        Reflect.set(all, name, value);
        try {
          localStorage.setItem("grammarlab", JSON.stringify(all));
        } catch {
        }
        return true;
      }
    }
  );
}
function stored() {
  try {
    return JSON.parse(localStorage.getItem("grammarlab") ?? "{}");
  } catch {
    return {};
  }
}

// scoring/preview.js
var REST = 500;
var ROUND = 9e3;
var LARGEST2 = 460;
var ROOM = 560;
function makePreview(page, display, code) {
  const stage = display.element;
  const canvas = element("canvas", { class: "gl-canvas" });
  const box = element("div", { class: "gl-preview", "aria-hidden": "true", hidden: true }, canvas);
  let view = null;
  let model = "";
  let timer = 0;
  let frame = 0;
  stage.addEventListener("pointermove", ({ pointerType, buttons, target }) => {
    if (pointerType === "mouse" && !buttons) rest(target);
  });
  stage.addEventListener("focusin", ({ target }) => {
    if (target instanceof Element && target.matches(":focus-visible")) rest(target);
  });
  for (const end of ["pointerleave", "pointerdown", "focusout", "wheel", "keydown"])
    stage.addEventListener(end, hide, { passive: true });
  stage.addEventListener("scroll", () => box.hidden ? wait() : hide(), { passive: true });
  function rest(target) {
    const position = display.positionOf(target);
    const meant = position < 0 ? "" : page.selection.order[position];
    if (meant === model) return;
    hide();
    if (!meant || !page.preferences.preview || stage.clientWidth < ROOM) return;
    model = meant;
    wait();
  }
  function wait() {
    clearTimeout(timer);
    if (model) timer = window.setTimeout(() => void show(), REST);
  }
  async function show() {
    const meant = model;
    try {
      const [{ buffers }, { show: open }] = await Promise.all([
        page.channel.request("model", { model: meant }),
        code()
      ]);
      const tile = display.tiles()[page.selection.order.indexOf(meant)];
      if (model !== meant || !tile) return;
      place(tile);
      view ??= open(canvas, { damping: false });
      await view.load(buffers[0]);
      if (model === meant) turn(view);
    } catch {
      hide();
    }
  }
  function place(tile) {
    const [room, at] = [stage.getBoundingClientRect(), tile.getBoundingClientRect()];
    const size = Math.min(LARGEST2, 0.48 * room.width, room.height - 24);
    const isLeft = at.left + at.width / 2 < room.left + room.width / 2;
    box.style.width = box.style.height = `${size}px`;
    box.style.left = `${stage.offsetLeft + (isLeft ? stage.clientWidth - size - 12 : 12)}px`;
    box.style.top = `${stage.offsetTop + 12}px`;
    box.hidden = false;
  }
  function turn(shown) {
    if (matchMedia("(prefers-reduced-motion: reduce)").matches) return;
    const begin = performance.now();
    let before = begin;
    const step = (now) => {
      shown.move(2 * Math.PI * Math.max(now - before, 0) / ROUND);
      before = Math.max(now, before);
      frame = now - begin < ROUND ? requestAnimationFrame(step) : 0;
    };
    frame = requestAnimationFrame(step);
  }
  function hide() {
    clearTimeout(timer);
    cancelAnimationFrame(frame);
    model = "";
    box.hidden = true;
  }
  return {
    element: box,
    hide,
    /** Other models may be shown now. */
    update() {
      if (model && !page.selection.order.includes(model)) hide();
    },
    close() {
      hide();
      view?.dispose();
    }
  };
}

// scoring/recent.js
function makeRecent(page) {
  const list = element("ul", { class: "gl-recent", "aria-label": "Scored models, the latest first" });
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Scored", hidden: true },
    element("h2", {}, "Scored"),
    list
  );
  const entries = /* @__PURE__ */ new Map();
  function update() {
    page.pictures.keep([...page.state.recent, ...page.state.line]);
    draw();
  }
  function draw() {
    const models = page.state.recent.filter((model) => knownOf(page, model).score !== null);
    section.hidden = !models.length;
    for (const model of models) if (!entries.has(model)) entries.set(model, makeEntry(page, model));
    for (const model of models) entries.get(model)?.draw();
    const shown = models.map((model) => (
      /** @type {Entry} */
      entries.get(model).element
    ));
    if (shown.length === list.childElementCount && shown.every((item, at) => item === list.children[at])) return;
    list.replaceChildren(...shown);
  }
  return { element: section, update, draw };
}
function makeEntry(page, model) {
  const picture = element("span", { class: "gl-picture" });
  const score = element("span", { class: "gl-score" });
  const look = element(
    "button",
    { type: "button", class: "gl-recent-look", onclick: () => page.look(model) },
    picture,
    score
  );
  const remove = element(
    "button",
    { type: "button", class: "gl-button gl-quiet", onclick: () => page.score([model], null) },
    icon("close")
  );
  const item = element("li", {}, look, remove);
  return {
    element: item,
    draw() {
      const known = knownOf(page, model);
      drawPicture(picture, page.pictures.find(model));
      score.textContent = shortly(known);
      score.classList.toggle("gl-unsaved", !known.saved);
      look.ariaLabel = look.title = inWords2(known);
      remove.ariaLabel = remove.title = `Remove the score of ${known.label}`;
    }
  };
}

// scoring/results.js
var FORMATS = {
  csv: "opens in any spreadsheet",
  jsonl: "one JSON object per line",
  parquet: "for Arrow, pandas and Polars"
};
var SHEET = 16;
function makeResults(page) {
  const { learns } = page.state;
  const learn = textButton(`Learn ${learns}`, () => busyWith(learn, learnGrammar), {
    title: `Write a ${learns} whose samples follow your scores`
  });
  const sheet = textButton("Check sheet", () => busyWith(sheet, drawSheet), {
    title: `Pictures of ${SHEET} samples of the learned ${learns}`
  });
  const picker = element("input", {
    type: "file",
    accept: ".csv,.tsv,.jsonl,.parquet",
    hidden: true,
    onchange: importScores
  });
  const give = menu(
    textButton("Export scores", () => {
    }, { class: "gl-button gl-chooser" }),
    "Scores as a file",
    buildFormats
  );
  const take = textButton("Import scores", () => picker.click(), {
    title: "A file that was exported here, or written by grammarlab label"
  });
  const busy = makeBusy("Result", () => void page.ask("cancel", { of: "result" }));
  const outcome = element("div", { class: "gl-outcome", role: "status" });
  const buttons = element("div", { class: "gl-pairs" }, learn, sheet, give, take);
  const section = element(
    "section",
    { class: "gl-card", "aria-label": "Result" },
    element("h2", {}, "Result"),
    buttons,
    busy.element,
    outcome,
    picker
  );
  async function learnGrammar() {
    const { result } = await page.channel.request("learn");
    const { file, rules_before: before, rules_after: after, text } = result;
    const told = `${file}: ${before} branches of rules became ${after}.`;
    const link = saveLink(file, [text], "text/plain");
    outcome.replaceChildren(element("p", {}, told), ...hints(result.notes), link);
    reveal(outcome);
    link.click();
  }
  async function drawSheet() {
    const { result, buffers } = await page.channel.request("sheet", { num: SHEET });
    const link = saveLink(result.file, buffers, "image/png");
    const picture = element("img", { src: link.href, alt: `${SHEET} samples of the learned ${learns}` });
    picture.addEventListener("load", () => reveal(outcome));
    outcome.replaceChildren(picture, link);
  }
  function buildFormats(close) {
    return Object.entries(FORMATS).map(
      ([format, says]) => choice(format.toUpperCase(), says, () => {
        close();
        void exportScores(format);
      })
    );
  }
  async function exportScores(format) {
    try {
      const { result, buffers } = await page.channel.request("export", { format });
      const link = saveLink(result.file, buffers, "application/octet-stream");
      section.append(link);
      link.click();
      link.remove();
    } catch (error) {
      page.complain(error);
    }
  }
  async function importScores() {
    const [file] = picker.files ?? [];
    picker.value = "";
    if (!file) return;
    try {
      const format = file.name.split(".").pop()?.toLowerCase();
      const { result } = await page.channel.request("import", { format }, [await file.arrayBuffer()]);
      page.say(`${counted(result.added, "score") || "no scores"} imported`);
      outcome.replaceChildren(...hints(result.notes));
    } catch (error) {
      page.complain(error);
    }
  }
  const hints = (notes = []) => notes.map((note) => element("p", { class: "gl-hint" }, `Note: ${note}`));
  async function busyWith(button, work) {
    if (!isBusy()) busy.progress({ stage: "starting", done: 0, total: 0 });
    reveal(busy.element);
    button.disabled = true;
    button.classList.add("gl-working");
    try {
      await work();
    } catch (error) {
      page.complain(error);
    } finally {
      button.disabled = false;
      button.classList.remove("gl-working");
      if (!isBusy()) busy.progress(null);
    }
  }
  const reveal = (part) => part.scrollIntoView({ block: "center" });
  const isBusy = () => learn.disabled || sheet.disabled;
  const urls = [];
  function saveLink(file, content, type) {
    const href = URL.createObjectURL(new Blob(content, { type }));
    urls.push(href);
    return element("a", { href, download: file }, `Save ${file}`);
  }
  return {
    element: section,
    /** Of what any window asked for; said where it was asked. @param {import("./types.js").Progress} now */
    progress(now) {
      if (isBusy()) busy.progress(now);
    },
    close: () => urls.forEach((url) => URL.revokeObjectURL(url))
  };
}

// scoring/scoring.js
function makeScoring(page, backToGrid, focusModels) {
  const heading = element("h2", {}, "Score");
  const count = element("p", { class: "gl-count", role: "status" });
  const number2 = element("input", {
    class: "gl-input gl-typed",
    type: "number",
    min: "0",
    max: "100",
    step: "any",
    "aria-label": "Score of the selected models, 0 to 100",
    title: "S"
  });
  const slider = element("input", {
    class: "gl-slider",
    type: "range",
    min: "0",
    max: "100",
    "aria-label": "Score of the selected models"
  });
  const steps = makeSteps(page, "Score of the selected models", give);
  const scales = Object.entries(SCALES).map(
    ([scale, { name }]) => textButton(name, (event) => chosenBy(
      event,
      /** @type {Scale} */
      scale
    ), {
      class: "gl-scale",
      title: "T: next scale"
    })
  );
  const clear = textButton("No score", () => give(null), {
    title: "Remove the score (Delete)",
    class: "gl-button gl-quiet"
  });
  const look = element(
    "button",
    {
      type: "button",
      class: "gl-button gl-quiet",
      title: "Enter, or double click",
      onclick: () => page.look(page.selection.models[0])
    },
    icon("cube"),
    "3D view"
  );
  const advance = element("input", {
    type: "checkbox",
    checked: page.preferences.advance,
    onchange: () => void (page.preferences.advance = advance.checked)
  });
  const set = element("button", { class: "gl-button" }, "Set");
  const form = element(
    "form",
    {
      class: "gl-row",
      onsubmit: (event) => {
        event.preventDefault();
        if (number2.value === "" || !number2.reportValidity()) return;
        give(number2.valueAsNumber);
        number2.value = "";
        backToGrid();
      }
    },
    number2,
    set,
    element("span", { class: "gl-space" }),
    clear
  );
  slider.addEventListener("input", () => void (number2.value = slider.value));
  slider.addEventListener("change", () => give(slider.valueAsNumber));
  const controls = element("fieldset", { class: "gl-plain" }, steps.element, slider, form);
  const section = element(
    "section",
    { class: "gl-card gl-scoring", "aria-label": "Score" },
    element("div", { class: "gl-row" }, heading, count, element("span", { class: "gl-space" }), look),
    element("div", { class: "gl-row gl-scales", role: "group", "aria-label": "Scale" }, ...scales),
    controls,
    element("label", { class: "gl-check" }, advance, "after a key, go on to the next model")
  );
  function give(score) {
    page.score(page.selection.models, score);
  }
  function update() {
    const chosen = page.selection.models;
    const said2 = new Map(chosen.map((model) => sayingOf(knownOf(page, model))));
    const shared = said2.size === 1 && [...said2.values()][0] || { score: null, kind: null };
    const scale = scaleOf(page);
    const plain = scale === "score" && shared.kind !== "stars" && shared.kind !== "thumb" ? shared.score : null;
    for (const part of [number2, set, slider]) part.hidden = scale !== "score";
    scales.forEach((button, index) => button.ariaPressed = String(Object.keys(SCALES)[index] === scale));
    const product = page.state.view === "product";
    const words = product ? "choose a factor first" : chosen.length ? `${chosen.length} selected` : "select models";
    if (count.textContent !== words) count.textContent = words;
    look.disabled = chosen.length === 0;
    controls.disabled = look.disabled || product;
    if (focused() !== number2) number2.value = shortly({ score: plain, kind: "score" });
    number2.placeholder = said2.size > 1 ? "mixed" : "0–100";
    if (focused() !== slider) slider.value = String(plain ?? 50);
    slider.classList.toggle("gl-unset", plain === null);
    steps.draw(shared);
  }
  function focused() {
    return (
      /** @type {Document | ShadowRoot} */
      section.getRootNode().activeElement
    );
  }
  function chosenBy(event, scale) {
    choose(scale);
    if (event.detail) focusModels();
  }
  function choose(scale) {
    page.preferences.scale = scale;
    update();
  }
  function typeScore() {
    if (controls.disabled || number2.hidden) return;
    number2.focus();
    number2.select();
  }
  return { element: section, update, typeScore, nextScale: () => choose(nextScale(page)) };
}
function sayingOf({ score, kind }) {
  return [`${kind} ${score}`, { score, kind }];
}

// scoring/selection.js
var Selection = class {
  /** @type {string[]} */
  order = [];
  /** @type {Set<string>} */
  chosen = /* @__PURE__ */ new Set();
  /** Position of the keyboard. */
  cursor = 0;
  /** Position where a range begins. */
  #anchor = 0;
  #changed;
  /** Whether the keyboard goes to the first model once others are shown. */
  #anew = false;
  /** Whether what is chosen has got its score. */
  #done = false;
  /** @param {() => void} changed */
  constructor(changed) {
    this.#changed = changed;
  }
  /** The models chosen, in the order shown. */
  get models() {
    return [...new Set(this.order)].filter((model) => this.chosen.has(model));
  }
  /** @returns {string | undefined} */
  get current() {
    return this.order[this.cursor];
  }
  /** Goes to the first model once others are shown. @returns {boolean} whether it did not wait for them before */
  startAnew() {
    const waited = this.#anew;
    this.#anew = true;
    return !waited;
  }
  /**
   * Shows other models, or the same in another order.
   * @param {string[]} order
   * @returns {boolean} whether it begins anew, at the first model
   */
  show(order) {
    if (this.#anew && order.length && !order.includes(this.order[this.cursor])) {
      this.order = order;
      this.#anew = false;
      this.only(0);
      return true;
    }
    const follow = (position) => {
      const found = order.indexOf(this.order[position]);
      return found >= 0 ? found : Math.min(position, Math.max(order.length - 1, 0));
    };
    [this.cursor, this.#anchor] = [follow(this.cursor), follow(this.#anchor)];
    this.order = order;
    const done = this.#done;
    this.#set(order.filter((model) => this.chosen.has(model)));
    this.#done = done;
    return false;
  }
  /** Shows a pair to compare, without a selection. @param {string[]} models */
  follow(models) {
    if (models.join() === this.order.join()) return;
    this.order = models;
    this.cursor = this.#anchor = 0;
    this.chosen = /* @__PURE__ */ new Set();
  }
  /** @param {number} position */
  only(position) {
    this.cursor = this.#anchor = position;
    this.#set([this.order[position]]);
  }
  /** Models have got their score; with it what is chosen, if it is among them. @param {string[]} models */
  done(models) {
    if ([...this.chosen].every((model) => models.includes(model))) this.#done = true;
  }
  /** Of fingers: one after the other is chosen, until they get a score; the next one is chosen alone. @param {number} position */
  touch(position) {
    if (this.#done) this.only(position);
    else this.toggle(position);
  }
  /** @param {number} position */
  toggle(position) {
    this.cursor = this.#anchor = position;
    const model = this.order[position];
    const without = [...this.chosen].filter((other) => other !== model);
    this.#set(this.chosen.has(model) ? without : [...without, model]);
  }
  /** Selects from the last choice to a position. @param {number} position @param {boolean} keep what is chosen */
  rangeTo(position, keep) {
    this.cursor = position;
    const [first, last] = [this.#anchor, position].sort((a, b) => a - b);
    const range = this.order.slice(first, last + 1);
    this.#set(keep ? [...this.chosen, ...range] : range);
  }
  /** Moves the keyboard, without a change of the selection. @param {number} position */
  moveTo(position) {
    this.cursor = position;
    this.#changed();
  }
  all() {
    this.#set(this.order);
  }
  none() {
    this.#set([]);
  }
  /** @param {Iterable<string>} models */
  replace(models) {
    this.#set(models);
  }
  /** @param {Iterable<string>} models */
  #set(models) {
    this.chosen = new Set(models);
    this.#done = false;
    this.#changed();
  }
};

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

// scoring/status.js
var PATIENCE = 8e3;
function makeStatus(page) {
  const saved = element("span", { class: "gl-saved", role: "status" });
  const notes = makeNotes();
  let given = false;
  let lost = false;
  let ended = "";
  const timer = setInterval(() => page.outbox.unsaved && update(), 1e3);
  function update() {
    const { unsaved, waiting } = page.outbox;
    const { connected } = page.channel;
    given ||= unsaved > 0;
    saved.dataset.state = unsaved ? "saving" : "saved";
    const text = unsaved ? connected && waiting < PATIENCE ? "saving…" : `${unsaved} not saved yet` : given ? "saved" : "";
    if (saved.textContent !== text) saved.textContent = text;
    notes.announce(bannerOf(connected, unsaved, waiting));
  }
  function bannerOf(connected, unsaved, waiting) {
    const kept = unsaved ? ` ${unsaved} ${unsaved === 1 ? "score is" : "scores are"} not saved yet; keep this page open, they will be sent again.` : "";
    if (ended) return ended;
    if (!connected && lost) return `${LOST}${kept}`;
    if (connected && unsaved && waiting > PATIENCE)
      return `Python does not answer.${kept} It may be busy, or the kernel has stopped.`;
    return "";
  }
  return {
    saved,
    banner: notes.banner,
    element: notes.element,
    say: notes.say,
    complain: notes.complain,
    update,
    /** @param {boolean} connected */
    connection(connected) {
      lost ||= !connected;
      update();
    },
    /** @param {string} text */
    closed(text) {
      ended = text;
      update();
    },
    close: () => clearInterval(timer)
  };
}

// scoring/toolbar.js
var SIZES = [
  { grids: 2, rows: 4, columns: 4, says: "to score" },
  { grids: 1, rows: 6, columns: 6, says: "to compare" },
  { grids: 2, rows: 6, columns: 6, says: "to score many" },
  { grids: 1, rows: 10, columns: 10, says: "to check the result" }
];
function makeToolbar(page, display, pointer) {
  const way = chooserButton("by");
  const size = chooserButton("Grid");
  const again = textButton("New models", () => void page.ask("new_models", { way: page.state.way }), {
    title: "Show other models, chosen by the method in the menu beside"
  });
  const compare = toggleButton("Compare", "Compare two models at a time (C)", page.pairwise);
  const sort = element("button", { type: "button", class: "gl-button gl-chooser" }, "Sort");
  const pan = toggle("hand", "Drag to pan", false, (on) => pointer.pan(on));
  const bars = toggle("bars", "Bars of predicted score and uncertainty", page.preferences.bars, (on) => {
    page.preferences.bars = on;
    display.fit();
  });
  const preview = toggle(
    "cube",
    "Show the model below the mouse large, and turning",
    page.preferences.preview,
    (on) => {
      page.preferences.preview = on;
    }
  );
  const bar2 = element(
    "div",
    { class: "gl-toolbar", role: "toolbar", "aria-label": "Display" },
    element("span", { class: "gl-joined" }, again, menu(way.button, "How models are chosen", buildWays)),
    compare,
    ...ofGrids(
      menu(sort, "Sort", (close) => buildSort(page, close)),
      menu(size.button, "Size of the grids", buildSizes),
      element("span", { class: "gl-space" }),
      legend(),
      element(
        "div",
        { class: "gl-row" },
        preview,
        bars,
        pan,
        iconButton("minus", "Zoom out", () => display.zoomBy(0.8)),
        zoomSlider(display),
        iconButton("fit", "Show all", () => display.zoomBy(0)),
        iconButton("plus", "Zoom in", () => display.zoomBy(1.25))
      )
    )
  );
  function buildWays(close) {
    return page.state.ways.map(({ name, label, says }) => {
      const show = () => {
        close();
        void page.ask("new_models", { way: name });
      };
      return choice(label, says, show, { checked: name === page.state.way });
    });
  }
  function buildSizes(close) {
    const { grids, rows, columns } = page.state.layout;
    const lay = (layout) => {
      close();
      void page.ask("layout", layout);
    };
    const [many, high, wide] = [number("grids", grids, 2), number("rows", rows, 10), number("columns", columns, 10)];
    const own = element(
      "form",
      {
        class: "gl-row",
        onsubmit: (event) => {
          event.preventDefault();
          lay({ grids: many.valueAsNumber, rows: high.valueAsNumber, columns: wide.valueAsNumber });
        }
      },
      many,
      "of",
      high,
      "×",
      wide,
      element("button", { class: "gl-button" }, "Set")
    );
    const presets = SIZES.map((each) => {
      const checked = each.grids === grids && each.rows === rows && each.columns === columns;
      return choice(nameOf(each), each.says, () => lay({ grids: each.grids, rows: each.rows, columns: each.columns }), {
        checked
      });
    });
    return [...presets, element("hr"), own];
  }
  function update(state) {
    way.set(state.ways.find(({ name }) => name === state.way)?.label ?? state.way);
    size.set(nameOf(state.layout));
    compare.ariaPressed = String(state.pairs !== null);
  }
  return { element: bar2, update };
}
function buildSort(page, close) {
  const chosen = page.selection.models;
  const sort = (order) => {
    close();
    void page.ask("sort", order);
  };
  const found = element("div", { class: "gl-found", role: "group", "aria-label": "Features found" });
  const query = element("input", {
    class: "gl-input",
    type: "search",
    placeholder: "Search features",
    "aria-label": "Search features"
  });
  let turn = 0;
  const search = async () => {
    const mine = turn += 1;
    const { features } = await page.ask("features", { query: query.value }) ?? { features: [] };
    if (mine !== turn) return;
    query.disabled = features === null;
    if (features === null) {
      similar.disabled = true;
      found.replaceChildren(element("p", {}, "Not yet: the features of the models are being counted."));
      return;
    }
    const lines = features.map(
      (feature) => choice(feature, "", () => sort({ by: "feature", feature }))
    );
    found.replaceChildren(...lines.length ? lines : [element("p", {}, "No feature has this name.")]);
  };
  query.addEventListener("input", search);
  const similar = choice(
    "Similarity",
    chosen.length ? `to the ${chosen.length} selected` : "select models first",
    () => sort({ by: "similarity", models: chosen }),
    { disabled: !chosen.length }
  );
  const isLearned = Object.keys(page.state.models).some((model) => knownOf(page, model).predicted !== null);
  void search();
  return [
    choice("Predicted score", "highest first", () => sort({ by: "score" })),
    choice(
      "Uncertainty",
      isLearned ? "least known first" : "nothing has been learned yet",
      () => sort({ by: "uncertainty" }),
      { disabled: !isLearned }
    ),
    similar,
    choice("Random", "", () => sort({ by: "random" })),
    choice("As chosen", "the order in which they were chosen", () => sort({ by: "shown" })),
    element("hr"),
    query,
    found
  ];
}
function ofGrids(...parts) {
  for (const part of parts) part.classList.add("gl-of-grids");
  return parts;
}
function toggleButton(text, title, onclick) {
  const button = textButton(text, onclick, { title });
  button.ariaPressed = "false";
  return button;
}
function zoomSlider(display) {
  const slider = element("input", {
    class: "gl-zoom",
    type: "range",
    min: Math.log2(ZOOMS.least),
    max: Math.log2(ZOOMS.most),
    step: "any",
    title: "Size of pictures; also the wheel here, or Ctrl and the wheel on the pictures",
    "aria-label": "Size of pictures"
  });
  const show = () => {
    slider.value = String(Math.log2(display.zoom()));
    slider.ariaValueText = `${Math.round(100 * display.zoom())} %`;
  };
  slider.addEventListener("input", () => display.zoomBy(2 ** slider.valueAsNumber / display.zoom()));
  slider.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      display.zoomBy(event.deltaY < 0 ? 1.12 : 1 / 1.12);
    },
    { passive: false }
  );
  display.whenZoomed(show);
  show();
  return slider;
}
function legend() {
  const key = (name, text) => element("span", { class: `gl-key ${name}` }, element("i"), text);
  return element("span", { class: "gl-legend" }, key("gl-predicted", "predicted"), key("gl-uncertain", "uncertain"));
}
function nameOf({ grids, rows, columns }) {
  return `${grids > 1 ? `${grids} of ` : ""}${rows} × ${columns}`;
}
function number(name, value, max) {
  return element("input", {
    class: "gl-input gl-number",
    type: "number",
    min: "1",
    max: String(max),
    required: true,
    value: String(value),
    "aria-label": name
  });
}
function toggle(picture, label, on, changed) {
  const button = iconButton(picture, label, () => {
    const now = button.ariaPressed !== "true";
    button.ariaPressed = String(now);
    changed(now);
  });
  button.ariaPressed = String(on);
  return button;
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

// scoring/warnings.js
var SPOKEN = 1e3;
function makeWarnings(handOn) {
  const newest = element("span", { class: "gl-newest" });
  const spoken = element("div", { class: "gl-unseen", role: "alert", "aria-atomic": "false" });
  const summary = element("summary");
  const list = element("ol");
  const others = element("details", { hidden: true }, summary, list);
  const note = element(
    "div",
    { class: "gl-note gl-bad gl-warnings", hidden: true },
    element("div", {}, newest, spoken, others),
    iconButton("close", "Dismiss", dismiss)
  );
  const known = /* @__PURE__ */ new Set();
  function dismiss() {
    note.hidden = others.hidden = true;
    others.open = false;
    newest.textContent = "";
    spoken.replaceChildren();
    list.replaceChildren();
    handOn();
  }
  return {
    element: note,
    /** @param {string[]} warnings all of the session, the oldest first */
    update(warnings) {
      const fresh = warnings.filter((warning) => !known.has(warning));
      if (!fresh.length) return;
      for (const warning of fresh) {
        known.add(warning);
        if (newest.textContent) list.prepend(element("li", {}, newest.textContent));
        newest.textContent = warning;
      }
      for (const warning of fresh) {
        const words = element("p", {}, warning);
        spoken.append(words);
        setTimeout(() => words.remove(), SPOKEN);
      }
      note.hidden = false;
      const more = list.childElementCount;
      others.hidden = !more;
      summary.textContent = `${more} more ${more === 1 ? "warning" : "warnings"}`;
    }
  };
}

// scoring/main.js
var main_default = {
  /** @param {{ model: any, el: HTMLElement }} widget */
  render({ model, el }) {
    return mount(el, widgetTransport(model));
  }
};
function mount(host, transport) {
  const root = waitingRoot("", "Making the first models…");
  root.dataset.lmSuppressShortcuts = "true";
  root.addEventListener("keydown", (event) => event.stopPropagation());
  host.append(root);
  const channel = new Channel(transport);
  let built = null;
  let lost = false;
  function follow(state) {
    if (!understands(root, state)) return;
    built ??= build(root, channel, state);
    built.update(state);
  }
  channel.on("state", ({ state }) => follow(state));
  channel.on("progress", (progress) => built?.progress(progress));
  channel.on("closed", ({ message }) => built?.closed(message));
  channel.open(async (connected) => {
    built?.connection(connected);
    lost ||= !connected;
    if (!connected) return;
    try {
      follow((await channel.request("state")).result);
      if (lost) built?.reconnected();
    } catch (error) {
      if (channel.connected) root.textContent = error instanceof Error ? error.message : String(error);
    }
  });
  return () => {
    root.remove();
    built?.close();
    channel.close();
  };
}
function build(root, channel, first) {
  const redraw = () => {
    if (page.state.pairs) compare.draw();
    else display.drawSoon();
    recent.draw();
    learning.draw();
    scoring.update();
  };
  let way = "default";
  const page = {
    root,
    state: first,
    channel,
    preferences: loadPreferences(),
    selection: new Selection(() => redraw()),
    outbox: new Outbox(
      channel,
      () => changed(),
      (error) => page.complain(new Error(`Not saved: ${error.message}`))
    ),
    ask: (command, parameters) => channel.request(command, parameters).then(
      ({ result }) => result,
      (error) => void page.complain(error)
    ),
    pictures: new Pictures(channel, () => redraw()),
    score(models, score) {
      const kind = scaleOf(page);
      if (!models.length || !scorable()) return;
      page.outbox.add(models, { score, kind }, page.factor().id);
      if (score !== null) page.selection.done(models);
    },
    compare(models, verdict) {
      if (scorable()) page.outbox.compare(models, verdict, page.factor().id);
    },
    ahead: new Ahead(),
    pairwise() {
      const pairs = !page.ahead.of("pairs", page.state.pairs !== null);
      void page.ahead.set("pairs", pairs, page.ask("new_models", { way: pairs ? "pairs" : way }));
    },
    factor() {
      const { factors: factors2, active } = page.state;
      return factors2.find(({ name }) => name === active) ?? factors2[0];
    },
    look(model) {
      preview.hide();
      void look.open(model);
    },
    say: (text) => status.say(text),
    complain: (error) => void status.complain(error)
  };
  const compare = makeCompare(page);
  const display = makeDisplay(page);
  const pointer = listenToPointer(page, display);
  const status = makeStatus(page);
  const scoring = makeScoring(
    page,
    () => keys.handOn(),
    () => focusModels()
  );
  const keys = listenToKeys(page, display, scoring);
  const code = viewerCode(channel);
  const preview = makePreview(page, display, code);
  const recent = makeRecent(page);
  const look = makeLook(page, code, focusModels);
  const learning = makeLearning(page);
  const results = makeResults(page);
  const factors = makeFactors(page);
  const toolbar = makeToolbar(page, display, pointer);
  const help = makeHelp(KEYS);
  const undo = iconButton("undo", "Undo", () => goThrough("undo"), "U, Ctrl Z");
  const redo = iconButton("redo", "Redo", () => goThrough("redo"), "Ctrl Shift Z");
  const title = element("h1", { class: "gl-name" });
  const warnings = makeWarnings(focusModels);
  status.element.prepend(warnings.element);
  root.replaceChildren(
    element(
      "header",
      { class: "gl-header" },
      title,
      factors.element,
      element("span", { class: "gl-space" }),
      status.saved,
      undo,
      redo,
      help.button
    ),
    status.banner,
    element(
      "div",
      { class: "gl-main" },
      element(
        "div",
        { class: "gl-left" },
        toolbar.element,
        display.element,
        preview.element,
        display.about,
        compare.element
      ),
      element(
        "section",
        { class: "gl-side", "aria-label": "Score and learn" },
        scoring.element,
        recent.element,
        learning.element,
        results.element
      )
    ),
    status.element,
    look.element,
    help.element
  );
  function scorable() {
    if (page.state.view !== "product") return true;
    status.say("The product of all factors cannot be scored. Choose the factor of the score first.");
    return false;
  }
  function changed() {
    redraw();
    look.update();
    status.update();
  }
  function goThrough(command) {
    const isLeft = () => command === "undo" ? page.state.can_undo : page.state.can_redo;
    channel.request(command).catch((error) => isLeft() ? page.complain(error) : page.say(error.message));
  }
  const everywhere = (event) => {
    const typing = event.target instanceof HTMLInputElement && event.target.type !== "range" && event.target.type !== "checkbox";
    const command = event.ctrlKey || event.metaKey;
    const key = event.key.toLowerCase();
    if (command && key === "enter") void page.ask("update");
    else if (typing || event.defaultPrevented) return;
    else if (!inDialog(event) && compare.press(event)) return event.preventDefault();
    else if (key === "?") help.open();
    else if (!command && key === "t") {
      scoring.nextScale();
      look.update();
    } else if (!command && key === "c" && !inDialog(event)) page.pairwise();
    else if (command && key === "z" && event.shiftKey || command && key === "y") goThrough("redo");
    else if (command && key === "z" || !command && key === "u") goThrough("undo");
    else return;
    event.preventDefault();
  };
  root.addEventListener("keydown", everywhere);
  const loose = (event) => {
    if (event.target === document.body) everywhere(event);
  };
  if (isAlone()) document.addEventListener("keydown", loose);
  function focusModels() {
    if (page.state.pairs) compare.focus();
    else display.focus();
  }
  function hasKeyboard() {
    const { activeElement } = (
      /** @type {Document | ShadowRoot} */
      root.getRootNode()
    );
    return root.contains(activeElement) && !(activeElement instanceof HTMLInputElement);
  }
  const hold = (event) => page.outbox.unsaved && event.preventDefault();
  addEventListener("beforeunload", hold);
  return {
    /** @param {State} state */
    update(state) {
      if (state.message && state.message !== page.state.message) page.say(state.message);
      warnings.update(state.warnings);
      const [before, after] = [page.state.pairs !== null, state.pairs !== null];
      page.state = state;
      page.ahead.told();
      if (!after) way = state.way;
      root.classList.toggle("gl-pairwise", after);
      page.outbox.settle(state.revision);
      title.textContent = state.title;
      title.title = state.session;
      if (isAlone()) document.title = `${state.title} – grammarlab`;
      undo.disabled = !state.can_undo;
      redo.disabled = !state.can_redo;
      const shown = after ? compare : display;
      for (const part of [factors, toolbar, recent, shown, preview, scoring, learning, look, status])
        part.update(state);
      if (before !== after && hasKeyboard()) shown.focus();
    },
    /** @param {import("./types.js").Progress} progress */
    progress(progress) {
      const part = (progress.of ?? "update") === "update" ? learning : results;
      part.progress(progress);
    },
    /** @param {boolean} connected */
    connection(connected) {
      status.connection(connected);
    },
    /** Python ended the session, and will not answer any more. @param {string} message */
    closed(message) {
      status.closed(message);
    },
    /** The state is there; whatever was under way when the connection was lost begins anew. */
    reconnected() {
      display.askAgain();
      page.outbox.resend();
    },
    close() {
      removeEventListener("beforeunload", hold);
      document.removeEventListener("keydown", loose);
      for (const part of [preview, display, page.pictures, results, look, help, status]) part.close();
    }
  };
}
function inDialog({ target }) {
  return target instanceof Element && target.closest("dialog[open]") !== null;
}
var alone = document.getElementById("grammarlab");
if (alone && isAlone()) mount(alone, socketTransport(socketUrl()));
export {
  main_default as default
};
