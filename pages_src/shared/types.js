/**
 * A request is `{id, command, …}`, its answer `{id, ok: true, result}` or `{id, ok: false, error}`; messages without a
 * request are `{event, …}`. Bytes are sent beside a message, as buffers.
 *
 * @typedef {object} Transport
 * @property {(message: object, buffers: ArrayBuffer[]) => void} send
 * @property {(heard: (message: any, buffers: ArrayBuffer[]) => void) => void} listen
 * @property {(changed: (connected: boolean) => void) => void} watch is told when the connection comes or goes
 * @property {() => void} close
 *
 * @typedef {"score" | "stars" | "thumb"} Scale of 0 to 100; five stars; up and down
 * @typedef {{ score: number | null, kind: Scale | null }} Said of one model
 */
export {};
