import { Box3, Raycaster, Vector2, Vector3 } from "three";
import { buildingOf } from "./features.js";
import { makeGround } from "./ground.js";
import { makeMarks } from "./marks.js";
import { makeOrbit } from "./orbit.js";
import { makeScene } from "./scene.js";
import { makeTiles } from "./tiles.js";
import { makeWalk } from "./walk.js";

/** @typedef {ReturnType<typeof makeView>} View */

/** Largest movement of a click, in pixels. */
const STEADY = 6;
/** Number of planes that are tried for a point on the ground. */
const TRIES = 8;

/**
 * The city in 3D: from above or from the street, with one parcel marked.
 * @param {HTMLCanvasElement} canvas
 * @param {object} tell
 * @param {(id: string | undefined) => void} tell.select called for a click on a parcel, or on nothing
 * @param {(text: string) => void} tell.progress
 * @param {(text: string) => void} tell.failed
 */
export function makeView(canvas, tell) {
  const stage = makeScene(canvas, { before });
  const { camera, scene } = stage;
  const orbit = makeOrbit(stage, canvas);
  const tiles = makeTiles(stage, { loaded, ready, failed: tell.failed });
  const marks = makeMarks(stage, tiles);
  const walk = makeWalk(stage, canvas, (x, z) => ground?.heightAt(x, z) ?? 0);
  /** @type {ReturnType<typeof makeGround> | null} */
  let ground = null;
  /** @type {(id: string) => number[]} */
  let outlineOf = () => [];
  let marked = "";
  /** Whether a person has looked elsewhere than at first. */
  let isMoved = false;
  /** @type {Vector2 | null} where a click may have begun */
  let pressed = null;
  tiles.open();

  function before() {
    if (walk.active) walk.update();
    else orbit.update();
    tiles.update();
    marks.fade(camera.position);
    tell.progress(tiles.isLoading ? "loading buildings…" : "");
  }

  function ready() {
    const box = bounds();
    if (box && !isMoved) orbit.frame(box, true);
  }

  function loaded() {
    marks.refresh();
  }

  for (const kind of ["pointerdown", "wheel", "keydown"])
    canvas.addEventListener(kind, () => void (isMoved = true), { passive: true });
  canvas.addEventListener("pointerdown", (event) => {
    canvas.focus({ preventScroll: true });
    canvas.dataset.by = "pointer";
    pressed = event.isPrimary && event.button === 0 ? new Vector2(event.clientX, event.clientY) : null;
  });
  canvas.addEventListener("keydown", () => void (canvas.dataset.by = "keys"));
  canvas.addEventListener("pointerup", (event) => {
    const isClick = pressed && pressed.distanceTo(new Vector2(event.clientX, event.clientY)) < STEADY;
    pressed = null;
    if (isClick) tell.select(parcelAt(event.offsetX, event.offsetY));
  });

  /** The parcel that is seen at a pixel. @param {number} x @param {number} y */
  function parcelAt(x, y) {
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight), camera);
    const hit = tiles.group ? ray.intersectObject(tiles.group, true)[0] : undefined;
    const found = hit && buildingOf(hit);
    if (found && (!ground || ground.has(found))) return found;
    const point = hit?.point ?? onGround(ray);
    return point && ground?.idAt(point.x, point.z);
  }

  /** @param {Raycaster} ray */
  function onGround({ ray: { origin, direction } }) {
    const point = orbit.target.clone();
    // On a slope, each plane at the height of the point before is nearer to the ground.
    for (let tries = 0; tries < TRIES; tries++) {
      const distance = ((ground?.heightAt(point.x, point.z) ?? 0) - origin.y) / direction.y;
      if (!(distance > 0)) return undefined;
      point.copy(direction).multiplyScalar(distance).add(origin);
    }
    return point;
  }

  /** Whether the marked building is seen from a point. @param {Box3} box @param {Vector3} from */
  function isSeen(box, from) {
    if (!tiles.group) return true;
    const top = box.getCenter(new Vector3()).setY(box.max.y);
    const ray = new Raycaster(top, from.clone().sub(top).normalize(), 0.1, top.distanceTo(from));
    return ray.intersectObject(tiles.group, true).every((hit) => buildingOf(hit) === marked);
  }

  /** The whole city; its parcels have closer bounds than tiles, which may be cells of a large square. */
  const bounds = () => ground?.bounds ?? tiles.bounds();

  /** @param {string} id */
  function mark(id) {
    marked = id;
    marks.mark(id, outlineOf(id));
  }

  return {
    orbit,
    walk,
    mark,
    /** The tiles have changed. */
    reload: tiles.open,
    /** @param {string[]} ids @param {ArrayBuffer[]} buffers of `Ground` */
    layOut(ids, [offsets, corners, zones, built, streets, kinds, surfaces, owners]) {
      const values = {
        ids,
        offsets: new Uint32Array(offsets),
        corners: new Float32Array(corners),
        zones: new Uint8Array(zones),
        built: new Uint8Array(built),
        streets: new Float32Array(streets),
        kinds: new Uint8Array(kinds),
        surfaces: new Float32Array(surfaces),
        owners: new Uint32Array(owners),
      };
      const rows = new Map(ids.map((id, row) => [id, row]));
      outlineOf = (id) => {
        const row = rows.get(id);
        if (row === undefined) return [];
        const [first, last] = [values.offsets[row], values.offsets[row + 1]];
        const outline = [...values.corners.subarray(3 * first, 3 * last)];
        return [...outline, ...outline.slice(0, 3)].map((value, axis) => (axis % 3 === 1 ? value + 0.15 : value));
      };
      ground = makeGround(stage, values);
      ready();
      if (marked) mark(marked);
      stage.draw();
    },
    /** @param {string} id */
    has: (id) => ground?.has(id) ?? false,
    /** The parcel in the middle of the picture. */
    middle: () => parcelAt(canvas.clientWidth / 2, canvas.clientHeight / 2),
    /** @param {string} id @param {number} step */
    neighbour: (id, step) => ground?.neighbour(id, step),
    /** Goes to the marked parcel. */
    visit() {
      isMoved = true;
      const place = ground?.placeOf(marked);
      if (!place || !ground) return;
      const { x, z, ground: height, radius } = place;
      const street = ground.streetBefore(place);
      if (walk.active) return walk.begin(street, new Vector3(x, height + 5, z));
      const flat = new Box3(
        new Vector3(x - radius, height, z - radius),
        new Vector3(x + radius, height + 5, z + radius),
      );
      const box = marks.bounds() ?? flat;
      orbit.visit(box, street, (from) => isSeen(box, from));
    },
    showAll() {
      const box = bounds();
      if (box) orbit.frame(box);
    },
    /** Between the view from above and the street, in front of the marked building if there is one. */
    toggleWalk() {
      if (walk.active) {
        const point = walk.ahead();
        walk.end();
        orbit.enable(true);
        orbit.riseFrom(point);
        return;
      }
      const place = ground?.placeOf(marked);
      orbit.enable(false);
      if (place && ground)
        return walk.begin(ground.streetBefore(place), new Vector3(place.x, place.ground + 5, place.z));
      // Without a building one looks along the street, as far as possible in the direction of the view from above.
      const forward = camera.getWorldDirection(new Vector3()).setY(0).normalize();
      const from = ground?.streetNear(orbit.target.x, orbit.target.z) ?? orbit.target;
      const angle = ground?.alongStreet(from, forward) ?? Math.atan2(forward.z, forward.x);
      walk.begin(from, new Vector3(from.x + 100 * Math.cos(angle), orbit.target.y, from.z + 100 * Math.sin(angle)));
    },
  };
}
