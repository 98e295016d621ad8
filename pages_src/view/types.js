/**
 * What the page holds; see `grammarlab/pages/run_page.py`.
 *
 * @typedef {object} Model
 * @property {number} index
 * @property {string} seed
 * @property {number} shapes
 * @property {number} triangles
 * @property {Record<string, number>} reports
 * @property {import("../shared/tree.js").Row[]} tree
 * @property {string} glb gzip in base64
 *
 * @typedef {object} Run
 * @property {string} name
 * @property {string} folder as an argument in a shell
 * @property {string} start from where the folder leads to the run
 * @property {Model[]} models
 * @property {number} leftOut
 */
export {};
