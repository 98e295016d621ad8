/**
 * The state that Python sends; see `grammarlab/pages/example_desk.py`.
 *
 * @typedef {"rows" | "columns"} Axis
 * @typedef {Record<Axis, number[]>} Lines metres above ground, or from the left
 * @typedef {Lines & { name: string, kept: boolean, labels: string[][], box: [[number, number], [number, number]], elements: number[][] }} Wall
 * @typedef {{ axis: Axis, line: number }} Line one of a wall
 *
 * @typedef {object} State
 * @property {number} protocol
 * @property {string} title
 * @property {string} file that it is saved to
 * @property {boolean} saved whether that file holds what is shown
 * @property {string} undo what would be undone, in words
 * @property {string} redo
 * @property {string} main name of the wall that is never excluded
 * @property {string[]} names of labels
 * @property {Wall[]} walls
 *
 * @typedef {object} Page what the parts of the page share
 * @property {State} state
 * @property {string} wall name of the one that is shown
 * @property {number[] | null} cells that are chosen: first row, first column, last row, last column
 * @property {Line | null} line that is chosen
 * @property {() => Wall} current
 * @property {(cells: number[] | null, line?: Line | null) => void} choose
 * @property {(line: Line, at: number) => void} moveLine to a place in metres
 * @property {(name: string) => string | undefined} pictureOf a wall, once it is there
 */
export {};
