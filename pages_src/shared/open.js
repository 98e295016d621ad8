import { Channel } from "./channel.js";
import { element } from "./element.js";
import { socketTransport, socketUrl, widgetTransport } from "./transports.js";

/**
 * @template State
 * @typedef {{ update: (state: State) => void, connection: (connected: boolean) => void, close?: () => void }} Built
 */

const PROTOCOL = 1;

/**
 * Opens a page in its window: waits for the first state, builds, then follows every state.
 *
 * @template {{ protocol: number }} State
 * @param {string} style class names of the page
 * @param {string} waiting text until the first state
 * @param {(root: HTMLElement, channel: Channel, state: State) => Built<State>} build
 * @param {(state: State, buffers: ArrayBuffer[]) => void} [read] puts bytes into a state
 * @returns the page as a widget of a notebook
 */
export function openPage(style, waiting, build, read = () => {}) {
  /** @param {HTMLElement} host @param {import("./types.js").Transport} transport */
  function mount(host, transport) {
    const root = waitingRoot(style, waiting);
    host.append(root);
    const channel = new Channel(transport);
    /** @type {Built<State> | null} */
    let built = null;
    /** @param {State} state @param {ArrayBuffer[]} buffers */
    function follow(state, buffers) {
      if (!understands(root, state)) return;
      read(state, buffers);
      built ??= build(root, channel, state);
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
      },
    };
  }

  const alone = isAlone() && document.getElementById("grammarlab");
  if (alone) mount(alone, socketTransport(socketUrl()));
  return {
    /** @param {{ model: any, el: HTMLElement }} widget */
    render({ model, el }) {
      const { root, ask, close } = mount(el, widgetTransport(model));
      // Notebooks use single keys themselves, so they must not get the keys typed here.
      root.dataset.lmSuppressShortcuts = "true";
      root.addEventListener("keydown", (event) => event.stopPropagation());
      ask().catch((error) => (root.textContent = error.message));
      return close;
    },
  };
}

/** Whether the page has a window of its own. */
export function isAlone() {
  return document.body.classList.contains("gl-alone");
}

/** A page that is not built yet. @param {string} style @param {string} waiting */
export function waitingRoot(style, waiting) {
  return element("div", { class: `gl-page ${style}` }, element("p", { class: "gl-wait", role: "status" }, waiting));
}

/** Whether page and Python have one protocol version; otherwise the page reports it. @param {HTMLElement} root @param {{ protocol: number }} state */
export function understands(root, { protocol }) {
  if (protocol !== PROTOCOL) root.textContent = "This page and Python speak different versions. Reload the page.";
  return protocol === PROTOCOL;
}
