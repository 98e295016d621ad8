/**
 * Messages between the page of a city and Python; see `grammarlab/pages/city/`.
 *
 * @typedef {import("../shared/types.js").Said} Said
 *
 * @typedef {object} Zone
 * @property {string} name
 * @property {string} grammar name of its grammar; empty if it is unknown
 * @property {number} parcels with a building of this zone
 * @property {number} scored buildings with a score
 * @property {boolean} learnable whether its scores can be learned from
 * @property {string} learned sentence about what was learned; empty for nothing
 *
 * @typedef {object} State
 * @property {number} protocol
 * @property {number} revision
 * @property {string} title
 * @property {string} file of the pins
 * @property {string} undo what would be undone, in words
 * @property {string} redo
 * @property {number} tiles number that changes when the tiles have changed
 * @property {string} busy what is being done; empty for nothing
 * @property {string} failed why the last work failed; empty if it did not
 * @property {boolean} editable whether the city can be built again
 * @property {number} built parcels with a building
 * @property {Record<string, number>} empty parcels without one, by reason
 * @property {Zone[]} zones
 * @property {number} num_pins
 *
 * @typedef {object} Parcel
 * @property {string} id
 * @property {string} zone
 * @property {string} status `built` or `empty`
 * @property {[string, string][]} facts names and values, as text
 * @property {"free" | "pinned" | "rerolled" | "excluded"} pin what a person decided about it
 * @property {Said} said
 * @property {boolean} scorable whether it has a building, and not trees
 *
 * @typedef {object} Ground parcels as outlines, and streets, in metres: x to the east, y up, z to the south
 * @property {string[]} ids
 * @property {Uint32Array} offsets [N + 1] into the corners
 * @property {Float32Array} corners x, y and z of the corners of parcels
 * @property {Uint8Array} zones [N] numbers of zones; 255 for none
 * @property {Uint8Array} built [N] 1 for parcels with a building
 * @property {Float32Array} streets x, y and z of the corners of triangles
 * @property {Uint8Array} kinds of these triangles: 0 for streets, 1 for pavements, 2 for the land around them
 * @property {Float32Array} surfaces x, y and z of the corners of triangles of parcels on a terrain; empty without one
 * @property {Uint32Array} owners rows of the parcels of these triangles
 *
 * @typedef {{ x: number, z: number, ground: number, radius: number }} Place of a parcel
 */
export {};
