/**
 * The state that Python sends; see `grammarlab/pages/layers/shown.py`.
 *
 * @typedef {import("../stage/types.js").Drawing} Drawing
 * @typedef {Drawing & { counters: Record<string, number>, sizes: Record<string, number>, energy: number, proven: boolean, colors: string[], labels: string[] }} Layout
 * @typedef {{ pattern: string, symbols: string[], seen: string[] | null }} Axis
 * @typedef {{ name: string, on: boolean, axes: [Axis, Axis] }} Layer
 * @typedef {"opaque" | "attached" | "unoccludable" | "transparent"} Flag
 * @typedef {{ name: string, size: number | null } & Record<Flag, boolean>} Symbol
 * @typedef {{ message: string, hint: string, line: number, column: number, length: number, shown: string }} Mistake `shown` is the line with a caret, and a hint
 *
 * @typedef {import("../shared/frame.js").FileState & DesignState} State
 *
 * @typedef {object} DesignState
 * @property {number} protocol
 * @property {string} text
 * @property {Mistake[]} mistakes in the text
 * @property {number} width metres, of the canvas
 * @property {number} height
 * @property {boolean} solving whether better layouts may come
 * @property {string} conflict why the design has no layouts
 * @property {Layer[]} layers from the top down
 * @property {Symbol[]} symbols
 * @property {number} chosen
 * @property {Layout[]} layouts best first
 *
 * @typedef {object} Page what the parts of the page share
 * @property {State} state
 * @property {Layout[]} layouts on the way while a side is dragged, else those of the state
 * @property {number} chosen
 * @property {boolean} tied
 * @property {import("../shared/ahead.js").Ahead} ahead flags, and what is seen of layers
 * @property {(command: string, parameters?: object) => Promise<any>} ask sends a command; a refusal is shown
 */
export {};
