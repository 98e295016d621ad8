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
 * @typedef {{ name: string, folder: string, models: Model[], leftOut: number }} Run
 */
export {};
