import { Channel } from "./channel.js";
import { element } from "./element.js";
import { socketTransport, socketUrl } from "./transports.js";

const PROTOCOL = 1;

/**
 * Opens a page in its window: waits for the first state, builds, then follows every state.
 *
 * @template {{ protocol: number }} State
 * @param {string} style class names of the page
 * @param {string} waiting text until the first state
 * @param {(root: HTMLElement, channel: Channel, state: State) => { update: (state: State) => void, connection: (connected: boolean) => void }} build
 * @param {(state: State, buffers: ArrayBuffer[]) => void} [read] puts bytes into a state
 */
export function openPage(style, waiting, build, read = () => {}) {
  const root = waitingRoot(style, waiting);
  document.getElementById("grammarlab")?.append(root);
  const channel = new Channel(socketTransport(socketUrl()));
  /** @type {ReturnType<typeof build> | null} */
  let built = null;
  channel.on("state", ({ state }, buffers) => {
    if (!understands(root, state)) return;
    read(state, buffers);
    built ??= build(root, channel, state);
    built.update(state);
  });
  channel.open((connected) => built?.connection(connected));
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
