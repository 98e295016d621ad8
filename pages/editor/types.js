/**
 * What the page is told; see `state.py` and `columns.py`.
 *
 * @typedef {object} Drawing how to draw a facade
 * @property {number} width metres
 * @property {number} height
 * @property {number[]} label of each leaf, -1 for none
 * @property {number[]} picture of each leaf, -1 for none
 * @property {{ leaf: number, corners: [number, number][] }[]} outlines
 * @property {Float64Array} columns of each leaf left, bottom, width, height in metres; left, bottom, right, top of its part of a picture
 *
 * @typedef {{ name: string, rows: number, columns: number, nodes: number[] }} Grid
 * @typedef {"width" | "height" | "left" | "bottom" | "aspect"} What
 * @typedef {{ node: number, what: What, words: string }} Lock
 *
 * @typedef {object} State
 * @property {number} protocol
 * @property {number} revision
 * @property {string} title
 * @property {string} file that it is saved to
 * @property {boolean} saved whether that file holds what is shown
 * @property {boolean} lost whether no file does
 * @property {string} undo what would be undone, in words
 * @property {string} redo
 * @property {string[]} labels
 * @property {string[]} colors of each label, and last of what has none
 * @property {number[]} leaves node of each leaf
 * @property {number[]} parent of each node
 * @property {number[]} names label of each node, -1 for none
 * @property {number} pictures how many there are
 * @property {Grid[]} grids
 * @property {string} active name of a grid, or empty
 * @property {Lock[]} locks
 * @property {string[]} formats
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
