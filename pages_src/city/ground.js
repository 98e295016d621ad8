import {
  Box3,
  BufferGeometry,
  Color,
  Float32BufferAttribute,
  LineBasicMaterial,
  LineSegments,
  Mesh,
  MeshLambertMaterial,
  ShapeUtils,
  Vector2,
  Vector3,
} from "three";
import { makeRelief } from "./relief.js";

/** @typedef {import("./types.js").Ground} Ground */
/** @typedef {import("./types.js").Place} Place */

/** Metres of a parcel's surface above the ground, and of its outline above its surface. */
const LIFT = 0.03;
/** Colours of zones, distinguishable for everyone. */
export const ZONE_COLOURS = ["#e69f00", "#56b4e9", "#009e73", "#f0e442", "#cc79a7", "#d55e00", "#0072b2", "#999999"];

/** Metres above the ground that a picture of the whole city shows. */
const HEIGHT = 40;
/** Metres around a parcel in which its street is looked for, and directions. */
const REACH = 80;
/** Metres that one sees along a street, at most. */
const FARTHEST = 150;
/** Metres from a point on a street to its edges, at most. */
const WIDEST = 20;
const TURNS = 48;

/** @param {number} zone */
export const zoneColour = (zone) => ZONE_COLOURS[zone % ZONE_COLOURS.length];

/**
 * Parcels on the ground, coloured by zone, and where they are.
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {Ground} ground
 */
export function makeGround(stage, ground) {
  const { ids, offsets, corners, zones } = ground;
  /** @type {Map<string, number>} */
  const rows = new Map(ids.map((id, row) => [id, row]));
  const places = ids.map((_, row) => placeOf(ground, row));
  const surfaces = surfacesOf(ground);
  const relief = ground.surfaces.length ? makeRelief(ground.streets, ground.surfaces) : null;
  const lots = surfaceMesh(surfaces.corners, 3, !relief);
  const streets = surfaceMesh(ground.streets, 1, !relief);
  const lines = new LineSegments(new BufferGeometry(), new LineBasicMaterial({ transparent: true, opacity: 0.35 }));
  lines.geometry.setAttribute("position", new Float32BufferAttribute(surfaces.edges, 3));
  lines.frustumCulled = false;
  lines.raycast = () => {};
  stage.scene.add(lots, streets, lines);
  stage.sink(places.reduce((least, { ground: height }) => Math.min(least, height), places[0]?.ground ?? 0) - 0.1);
  stage.colours((look) => {
    const tints = new Map([...zones].map((zone) => [zone, tinted(look.lot, zone, look.tint).toArray()]));
    paint(lots, surfaces.owners, (row) => /** @type {number[]} */ (tints.get(zones[row])));
    const grounds = [look.street, look.pavement, look.ground].map((colour) => new Color(colour).toArray());
    paint(
      streets,
      [...ground.kinds].flatMap((kind) => [kind, kind, kind]),
      (kind) => grounds[kind],
    );
    lines.material.color.set(look.ground).multiplyScalar(0.5);
  });

  /** @param {number} row @param {number} x @param {number} z */
  const isIn = (row, x, z) =>
    Math.hypot(places[row].x - x, places[row].z - z) <= places[row].radius &&
    contains(corners, offsets[row], offsets[row + 1], x, z);

  /** Parcels at most some metres from a place. @param {{ x: number, z: number }} place @param {number} reach */
  const near = ({ x, z }, reach) =>
    [...places.keys()].filter((row) => Math.hypot(places[row].x - x, places[row].z - z) - places[row].radius <= reach);

  /** The parcel at a point; undefined for streets. @param {number} x @param {number} z @returns {number | undefined} */
  function rowAt(x, z) {
    for (let row = 0; row < places.length; row++) if (isIn(row, x, z)) return row;
    return undefined;
  }

  return {
    ids,
    /** The box of all parcels, with room for buildings; null without parcels. */
    bounds: places.length ? boundsOf(corners) : null,
    /** @param {string} id */
    has: (id) => rows.has(id),
    /** @param {string} id @returns {Place | undefined} */
    placeOf: (id) => places[rows.get(id) ?? -1],
    /** @param {number} x @param {number} z */
    idAt: (x, z) => ids[rowAt(x, z) ?? -1],
    /** Height of the ground near a point. @param {number} x @param {number} z */
    heightAt(x, z) {
      const exact = relief?.heightAt(x, z);
      if (exact !== undefined) return exact;
      let [nearest, height] = [Infinity, 0];
      places.forEach((place) => {
        const distance = Math.hypot(place.x - x, place.z - z) - place.radius;
        if (distance < nearest) [nearest, height] = [distance, place.ground];
      });
      return height;
    },
    /**
     * Where a person sees a place: on the street that is nearest to it, across from it.
     * @param {Place} place
     */
    streetBefore(place) {
      const around = near(place, 2 * REACH);
      const isStreet = (/** @type {number} */ angle, /** @type {number} */ away) =>
        !around.some((row) => isIn(row, place.x + away * Math.cos(angle), place.z + away * Math.sin(angle)));
      let best = { angle: 0, away: Infinity };
      for (let turn = 0; turn < TURNS; turn++) {
        const angle = (2 * Math.PI * (turn + TURNS / 4)) / TURNS;
        for (let away = 2; away < Math.min(best.away, place.radius + REACH); away += 1)
          // A gap between parcels is not a street.
          if ([0, 2, 4].every((more) => isStreet(angle, away + more))) best = { angle, away };
      }
      if (best.away === Infinity) return this.streetNear(place.x, place.z);
      const across = [16, 14, 12, 10, 8, 6, 4, 2].find((more) => isStreet(best.angle, best.away + more)) ?? 1;
      const away = best.away + across;
      return { x: place.x + away * Math.cos(best.angle), z: place.z + away * Math.sin(best.angle) };
    },
    /**
     * The middle of the street that is nearest to a point.
     * @param {number} x
     * @param {number} z
     */
    streetNear(x, z) {
      for (let radius = 0; radius < 120; radius += 2)
        for (let turn = 0; turn < 16; turn++) {
          const angle = ((turn + 4) * Math.PI) / 8;
          const [east, south] = [Math.cos(angle), Math.sin(angle)];
          if (rowAt(x + radius * east, z + radius * south) !== undefined) continue;
          let [near, far] = [radius, radius];
          while (near > radius - WIDEST && rowAt(x + (near - 1) * east, z + (near - 1) * south) === undefined)
            near -= 1;
          while (far < radius + WIDEST && rowAt(x + (far + 1) * east, z + (far + 1) * south) === undefined) far += 1;
          const middle = (near + far) / 2;
          return { x: x + middle * east, z: z + middle * south };
        }
      return { x, z };
    },
    /**
     * The direction in which one sees farthest along streets, in radians from the east to the south.
     * @param {{ x: number, z: number }} from
     * @param {{ x: number, z: number }} forward which of two alike is taken
     */
    alongStreet({ x, z }, forward) {
      const around = near({ x, z }, FARTHEST);
      let best = { angle: 0, worth: -1 };
      for (let turn = 0; turn < TURNS; turn++) {
        const angle = (2 * Math.PI * turn) / TURNS;
        const [east, south] = [Math.cos(angle), Math.sin(angle)];
        let reach = 0;
        while (reach < FARTHEST && !around.some((row) => isIn(row, x + reach * east, z + reach * south))) reach += 3;
        const worth = reach * (east * forward.x + south * forward.z > 0 ? 1 : 0.7);
        if (worth > best.worth) best = { angle, worth };
      }
      return best.angle;
    },
    /** The id that many built parcels further in the order of the table, which follows places. @param {string} id @param {number} step */
    neighbour(id, step) {
      const count = ids.length;
      let row = rows.get(id) ?? (step > 0 ? -1 : 0);
      for (let tries = 0; tries < count; tries++) {
        row = (row + step + count) % count;
        if (ground.built[row]) return ids[row];
      }
      return undefined;
    },
  };
}

/** Triangles and outlines of all parcels. @param {Ground} ground */
function surfacesOf({ offsets, corners, surfaces, owners: given }) {
  /** @type {number[]} */
  const triangles = [...surfaces].map((value, axis) => (axis % 3 === 1 ? value + LIFT : value));
  /** @type {number[]} the parcel of each corner */
  const owners = [...given].flatMap((row) => [row, row, row]);
  /** @type {number[]} */
  const edges = [];
  for (let row = 0; row + 1 < offsets.length; row++) {
    /** @type {Vector3[]} */
    const outline = [];
    for (let corner = offsets[row]; corner < offsets[row + 1]; corner++)
      outline.push(new Vector3().fromArray(corners, 3 * corner));
    const flat = given.length ? [] : outline.map(({ x, z }) => new Vector2(x, z));
    for (const triangle of ShapeUtils.triangulateShape(flat, []))
      for (const corner of [...triangle].reverse()) {
        triangles.push(outline[corner].x, outline[corner].y + LIFT, outline[corner].z);
        owners.push(row);
      }
    outline.forEach((from, corner) => {
      const to = outline[(corner + 1) % outline.length];
      edges.push(from.x, from.y + 2 * LIFT, from.z, to.x, to.y + 2 * LIFT, to.z);
    });
  }
  return { corners: triangles, owners, edges };
}

/**
 * Triangles that lie on the ground, over layers of lower numbers.
 * @param {ArrayLike<number>} corners
 * @param {number} layer
 * @param {boolean} isLevel
 */
function surfaceMesh(corners, layer, isLevel) {
  const material = new MeshLambertMaterial({ vertexColors: true });
  Object.assign(material, { polygonOffset: true, polygonOffsetFactor: -layer, polygonOffsetUnits: -2 * layer });
  const mesh = new Mesh(new BufferGeometry(), material);
  const up = Float32Array.from({ length: corners.length }, (_, axis) => Number(axis % 3 === 1));
  mesh.geometry.setAttribute("position", new Float32BufferAttribute(corners, 3));
  if (isLevel) mesh.geometry.setAttribute("normal", new Float32BufferAttribute(up, 3));
  else mesh.geometry.computeVertexNormals();
  mesh.receiveShadow = true;
  mesh.frustumCulled = false;
  mesh.raycast = () => {};
  return mesh;
}

/** @param {Mesh} mesh @param {number[]} kinds of its corners @param {(kind: number) => number[]} colourOf */
function paint(mesh, kinds, colourOf) {
  mesh.geometry.setAttribute("color", new Float32BufferAttribute(kinds.flatMap(colourOf), 3));
}

/** @param {number} lot @param {number} zone @param {number} tint */
function tinted(lot, zone, tint) {
  const colour = new Color(lot);
  return zone === 255 ? colour : colour.lerp(new Color(zoneColour(zone)), tint);
}

/** @param {Ground} ground @param {number} row @returns {Place} */
function placeOf({ offsets, corners }, row) {
  const box = new Box3();
  for (let corner = offsets[row]; corner < offsets[row + 1]; corner++)
    box.expandByPoint(new Vector3().fromArray(corners, 3 * corner));
  const { x, z } = box.getCenter(new Vector3());
  const size = box.getSize(new Vector3());
  return { x, z, ground: (box.min.y + box.max.y) / 2, radius: Math.hypot(size.x, size.z) / 2 };
}

/** @param {Float32Array} corners */
function boundsOf(corners) {
  const box = new Box3().setFromArray(corners);
  box.max.y += HEIGHT;
  return box;
}

/** Whether an outline has a point inside. @param {Float32Array} corners @param {number} first @param {number} last @param {number} x @param {number} z */
function contains(corners, first, last, x, z) {
  let inside = false;
  for (let here = first, before = last - 1; here < last; before = here++) {
    const [x0, z0, x1, z1] = [corners[3 * here], corners[3 * here + 2], corners[3 * before], corners[3 * before + 2]];
    if (z0 > z !== z1 > z && x < ((x1 - x0) * (z - z0)) / (z1 - z0) + x0) inside = !inside;
  }
  return inside;
}
