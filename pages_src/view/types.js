/**
 * What the page holds; see `grammarlab/pages/run_page.py`.
 *
 * @typedef {[depth: number, symbol: string, note: string, line: number, details: string]} Row
 *
 * @typedef {object} Model
 * @property {number} index
 * @property {string} seed
 * @property {number} shapes
 * @property {number} triangles
 * @property {Record<string, number>} reports
 * @property {Row[]} tree
 * @property {string} glb gzip in base64
 *
 * @typedef {{ name: string, folder: string, models: Model[], leftOut: number }} Run
 */
export {};
