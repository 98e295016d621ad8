import { Vector3 } from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";

/** From where the city is first seen: from the south and above; from higher in a window that is higher than wide. */
const BEGIN = new Vector3(0.12, 0.48, 1);
const BEGIN_HIGH = new Vector3(0.12, 1.1, 1);
/** Seconds of a flight. */
const FLIGHT = 0.6;
/** How near one flies to a building, and how steeply one may look at it. */
const CLOSE = 1.15;
const SLOPES = [0.55, 0.9, 1.4, 2.2, 4];
/** Share of the picture that the whole city takes. */
const MARGIN = 0.96;
/** Metres of the camera above the point that is looked at. */
const LOWEST = 1.5;

/**
 * The view from above: turning around a point on the ground.
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {HTMLCanvasElement} canvas
 */
export function makeOrbit(stage, canvas) {
  const { camera } = stage;
  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  controls.dampingFactor = 0.15;
  controls.maxPolarAngle = 0.49 * Math.PI;
  controls.minDistance = 5;
  controls.maxDistance = 12_000;
  controls.screenSpacePanning = false;
  controls.zoomToCursor = true;
  controls.addEventListener("change", stage.draw);
  /** @type {{ begin: number, from: Vector3, to: Vector3, fromTarget: Vector3, toTarget: Vector3 } | null} */
  let flight = null;
  controls.addEventListener("start", () => void (flight = null));

  /** @param {Vector3} to @param {Vector3} toTarget @param {boolean} [atOnce] */
  function fly(to, toTarget, atOnce = !controls.enableDamping) {
    flight = {
      begin: performance.now(),
      from: camera.position.clone(),
      to,
      fromTarget: controls.target.clone(),
      toTarget,
    };
    if (atOnce) flight.begin -= 1000 * FLIGHT;
    stage.draw();
  }

  /** The share of the way that is behind, of a flight that starts and ends slowly. */
  function advance() {
    if (!flight) return;
    const time = Math.min((performance.now() - flight.begin) / (1000 * FLIGHT), 1);
    const share = time * time * (3 - 2 * time);
    camera.position.lerpVectors(flight.from, flight.to, share);
    controls.target.lerpVectors(flight.fromTarget, flight.toTarget, share);
    if (time === 1) flight = null;
    else stage.draw();
  }

  return {
    /** Where one looks. */
    get target() {
      return controls.target;
    },
    get enabled() {
      return controls.enabled;
    },
    /** @param {boolean} on */
    enable(on) {
      controls.enabled = on;
      flight = null;
    },
    /** Before each picture. */
    update() {
      advance();
      controls.update();
      camera.position.y = Math.max(camera.position.y, controls.target.y + LOWEST);
      stage.lightUp(controls.target, camera.position.distanceTo(controls.target));
    },
    /** The whole city: as near as all corners of its box allow. @param {import("three").Box3} box @param {boolean} [atOnce] */
    frame(box, atOnce) {
      const target = box.getCenter(new Vector3());
      target.y = Math.max(box.min.y, 0);
      const toward = (camera.aspect < 1 ? BEGIN_HIGH : BEGIN).clone().normalize();
      const right = new Vector3(0, 1, 0).cross(toward).normalize();
      const up = toward.clone().cross(right);
      const slope = Math.tan((camera.fov * Math.PI) / 360) * MARGIN;
      let distance = controls.minDistance;
      for (let corner = 0; corner < 8; corner++) {
        const point = new Vector3(
          ...["x", "y", "z"].map((axis, bit) => (corner & (1 << bit) ? box.max : box.min)[/** @type {"x"} */ (axis)]),
        );
        point.sub(target);
        const across = Math.max(Math.abs(point.dot(right)) / camera.aspect, Math.abs(point.dot(up))) / slope;
        distance = Math.max(distance, across + point.dot(toward));
      }
      fly(toward.multiplyScalar(distance).add(target), target, atOnce);
    },
    /**
     * One building, seen from the side of its street, from so high that nothing hides it.
     * @param {import("three").Box3} box
     * @param {{ x: number, z: number }} street where a person sees it
     * @param {(from: Vector3) => boolean} isFree whether the building is seen from a point
     */
    visit(box, street, isFree) {
      const target = box.getCenter(new Vector3());
      const distance = (CLOSE * box.getSize(new Vector3()).length()) / 2 / Math.sin((camera.fov * Math.PI) / 360);
      const away = new Vector3(street.x - target.x, 0, street.z - target.z);
      if (!away.lengthSq()) away.set(0, 0, 1);
      away.normalize();
      const points = SLOPES.map((slope) => away.clone().setY(slope).setLength(distance).add(target));
      fly(points.find(isFree) ?? points[points.length - 1], target);
    },
    /** Stands back from a point that one looked at while walking. @param {Vector3} point */
    riseFrom(point) {
      const back = camera.getWorldDirection(new Vector3()).setY(0).normalize().multiplyScalar(-70);
      controls.target.copy(point);
      fly(
        point
          .clone()
          .add(back)
          .setY(point.y + 55),
        point.clone(),
      );
    },
    /**
     * What a mouse does by dragging and a wheel by turning.
     * @param {{ east?: number, south?: number, round?: number, up?: number, nearer?: number }} by shares of the
     *   distance, radians, and a factor
     */
    move({ east = 0, south = 0, round = 0, up = 0, nearer = 1 }) {
      const arm = camera.position.clone().sub(controls.target);
      const distance = arm.length();
      const heading = Math.atan2(arm.x, arm.z);
      const shift = new Vector3(east, 0, south).applyAxisAngle(new Vector3(0, 1, 0), heading).multiplyScalar(distance);
      const steepness = Math.min(Math.max(Math.acos(arm.y / distance) - up, 0.05), controls.maxPolarAngle);
      const length = Math.min(Math.max(distance / nearer, controls.minDistance), controls.maxDistance);
      arm.setFromSphericalCoords(length, steepness, heading + round);
      flight = null;
      controls.target.add(shift);
      camera.position.copy(controls.target).add(arm);
      stage.draw();
    },
  };
}
