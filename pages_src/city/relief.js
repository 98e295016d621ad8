/** Metres of the squares in which triangles are looked up. */
const SQUARE = 16;

/**
 * Heights of a ground of triangles.
 * @param {Float32Array[]} parts x, y and z of the corners of triangles
 */
export function makeRelief(...parts) {
  /** Triangles by the square that they reach: the part, and the first of their numbers. @type {Map<string, [Float32Array, number][]>} */
  const squares = new Map();
  for (const corners of parts)
    for (let first = 0; first < corners.length; first += 9) {
      const [west, east] = range(corners[first], corners[first + 3], corners[first + 6]);
      const [north, south] = range(corners[first + 2], corners[first + 5], corners[first + 8]);
      for (let x = west; x <= east; x++)
        for (let z = north; z <= south; z++) {
          const key = `${x},${z}`;
          const here = squares.get(key);
          if (here) here.push([corners, first]);
          else squares.set(key, [[corners, first]]);
        }
    }

  return {
    /** Height at a point; undefined beside all triangles. @param {number} x @param {number} z @returns {number | undefined} */
    heightAt(x, z) {
      for (const [corners, first] of squares.get(`${square(x)},${square(z)}`) ?? []) {
        const height = heightIn(corners, first, x, z);
        if (height !== undefined) return height;
      }
      return undefined;
    },
  };
}

/** @param {number} value */
const square = (value) => Math.floor(value / SQUARE);

/** First and last square of some values. @param {number[]} values */
const range = (...values) => [square(Math.min(...values)), square(Math.max(...values))];

/**
 * Height of a triangle at a point, if it is there.
 * @param {Float32Array} corners
 * @param {number} first
 * @param {number} x
 * @param {number} z
 */
function heightIn(corners, first, x, z) {
  const [ax, ay, az, bx, by, bz, cx, cy, cz] = corners.subarray(first, first + 9);
  const whole = (bx - ax) * (cz - az) - (cx - ax) * (bz - az);
  const b = ((x - ax) * (cz - az) - (cx - ax) * (z - az)) / whole;
  const c = ((bx - ax) * (z - az) - (x - ax) * (bz - az)) / whole;
  return b >= 0 && c >= 0 && b + c <= 1 ? ay + b * (by - ay) + c * (cy - ay) : undefined;
}
