/**
 * What the page is told; see `grammarlab/pages/watch/desk.py`.
 *
 * @typedef {object} Control
 * @property {string} name of the attribute
 * @property {string} label
 * @property {string} group
 * @property {"number" | "text" | "switch" | "menu" | "color"} kind
 * @property {string} value in the rule file; empty if it is drawn or computed
 * @property {number | null} low
 * @property {number | null} high
 * @property {number | null} step
 * @property {string[]} choices
 *
 * @typedef {{ severity: string, message: string, hint: string, line: number, column: number, code: [string, string] }} Mistake
 *
 * @typedef {object} State
 * @property {number} protocol
 * @property {string} title
 * @property {string} file
 * @property {number} seed
 * @property {number} model
 * @property {Record<string, string>} values of attributes that differ from the file
 * @property {Control[]} controls
 * @property {Mistake[]} mistakes
 * @property {number} version of the model
 * @property {number} shapes
 * @property {boolean} busy
 * @property {string} undo what would be undone, in words
 * @property {string} redo
 */
export {};
