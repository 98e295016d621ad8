/** @typedef {import("./types.js").Transport} Transport */

const SHORTEST_PAUSE = 300;
const LONGEST_PAUSE = 4000;

/**
 * The server of a page. A message is a text frame with the number of the binary frames that follow it.
 *
 * @param {string} url of the socket
 * @returns {Transport}
 */
export function socketTransport(url) {
  /** @type {(message: any, buffers: ArrayBuffer[]) => void} */
  let heard = () => {};
  /** @type {(connected: boolean) => void} */
  let changed = () => {};
  /** @type {WebSocket} */
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
    },
  };
}

/** Address of the server of this window. */
export function socketUrl() {
  const { protocol, host, search } = location;
  return `${protocol === "https:" ? "wss" : "ws"}://${host}/socket${search}`;
}

/**
 * Joins the frames of a message.
 * @param {(message: any, buffers: ArrayBuffer[]) => void} done
 */
function assembler(done) {
  /** @type {any} */
  let message = null;
  /** @type {ArrayBuffer[]} */
  let buffers = [];
  return (/** @type {string | ArrayBuffer} */ frame) => {
    if (typeof frame === "string") [message, buffers] = [JSON.parse(frame), []];
    else buffers.push(frame);
    if (buffers.length === (message.buffers ?? 0)) done(message, buffers);
  };
}

/**
 * The widget of a notebook.
 *
 * @param {any} model of anywidget
 * @returns {Transport}
 */
export function widgetTransport(model) {
  /** @type {(message: any, buffers: DataView[]) => void} */
  let forward = () => {};
  const callback = (/** @type {any} */ message, /** @type {DataView[]} */ buffers) => forward(message, buffers);
  model.on("msg:custom", callback);
  return {
    send: (message, buffers) => model.send(message, undefined, buffers),
    listen(heard) {
      forward = (message, buffers) => heard(message, (buffers ?? []).map(bytesOf)); // not every notebook gives an empty list
    },
    watch: (changed) => changed(true),
    close: () => model.off("msg:custom", callback),
  };
}

/** Bytes from a notebook: usually a view of a part of a larger buffer. @param {ArrayBufferView | ArrayBuffer} view @returns {ArrayBuffer} */
function bytesOf(view) {
  if (view instanceof ArrayBuffer) return view;
  return /** @type {ArrayBuffer} */ (view.buffer.slice(view.byteOffset, view.byteOffset + view.byteLength));
}
