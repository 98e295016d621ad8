/**
 * What the page is told; see `grammarlab/pages/editor/desk.py`.
 *
 * @typedef {import("../stage/types.js").Drawing} Drawing
 * @typedef {import("../stage/types.js").Grid} Grid
 * @typedef {import("../stage/types.js").What} What
 * @typedef {import("../stage/types.js").Lock & { range: number[] }} Lock with the range of an aspect
 * @typedef {import("../shared/frame.js").FileState & EditorState} State
 *
 * @typedef {object} EditorState
 * @property {number} protocol
 * @property {string[]} labels
 * @property {string[]} colors of each label, and last of what has none
 * @property {number[]} leaves node of each leaf
 * @property {number[]} parent of each node
 * @property {number[]} names label of each node, -1 for none
 * @property {number} pictures how many there are
 * @property {Grid[]} grids
 * @property {string} active name of a grid, or empty
 * @property {Lock[]} locks
 * @property {Drawing} drawing
 * @property {Float64Array} boxes of each node left, bottom, width, height in metres
 *
 * @typedef {object} Page what the parts of the page share
 * @property {State} state
 * @property {import("../shared/channel.js").Channel} channel
 * @property {import("./pictures.js").Pictures} pictures
 * @property {number} selected node, or -1
 * @property {boolean} gridding whether a click changes the active grid
 * @property {boolean} tied whether the facade keeps its aspect
 * @property {(command: string, parameters?: object) => Promise<any>} ask sends a command; a refusal is shown
 * @property {(node: number) => void} select
 * @property {(text: string) => void} say a passing note
 * @property {(text: string) => void} complain something that a person has to know
 * @property {() => void} changed draws everything again
 */
export {};
