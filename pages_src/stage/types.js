/**
 * The drawing of a facade.
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
 * @typedef {object} Face what lies on a stage
 * @property {{ drawing: Drawing, colors: string[], grids: Grid[], active: string, locks: Lock[], leaves: number[], parent: number[], boxes: Float64Array }} state as of the page that edits facades
 * @property {{ images: (ImageBitmap | undefined)[] }} pictures
 * @property {number} selected node, or -1
 * @property {boolean} gridding whether a click changes the active grid
 */
export {};
