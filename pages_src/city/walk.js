import { Euler, Vector3 } from "three";

/** Metres above the ground. */
const EYES = 1.7;
/** Metres in a second; with Shift that many times as fast. */
const SPEED = 4;
const RUN = 5;
/** Radians in a second, and for each pixel of a drag. */
const TURN = 1.6;
const LOOK = 0.004;
const STEEPEST = 1.4;
/** What keys and buttons do while they are held: metres ahead and to the right, and turning to the left. */
const HELD = {
  ahead: [1, 0, 0],
  back: [-1, 0, 0],
  right: [0, 1, 0],
  left: [0, -1, 0],
  turnLeft: [0, 0, 1],
  turnRight: [0, 0, -1],
};

/** @typedef {keyof typeof HELD} Way */

/**
 * The view of a person in the streets.
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {HTMLCanvasElement} canvas
 * @param {(x: number, z: number) => number} heightAt height of the ground
 */
export function makeWalk(stage, canvas, heightAt) {
  const { camera } = stage;
  /** @type {Set<Way>} */
  const held = new Set();
  const focus = new Vector3();
  let [yaw, pitch] = [0, 0];
  let [active, running, last] = [false, false, 0];

  canvas.addEventListener("pointermove", (event) => {
    if (!active || !event.buttons || !event.isPrimary) return;
    look(event.movementX * LOOK, event.movementY * LOOK);
  });
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (!active) return;
      event.preventDefault();
      step(-Math.sign(event.deltaY), 0);
      stage.draw();
    },
    { passive: false },
  );

  /** @param {number} left radians @param {number} up radians */
  function look(left, up) {
    yaw += left;
    pitch = Math.min(Math.max(pitch + up, -STEEPEST), STEEPEST);
    stage.draw();
  }

  /** @param {number} ahead metres @param {number} right metres */
  function step(ahead, right) {
    camera.position.x += -Math.sin(yaw) * ahead + Math.cos(yaw) * right;
    camera.position.z += -Math.cos(yaw) * ahead - Math.sin(yaw) * right;
  }

  return {
    get active() {
      return active;
    },
    /** @param {{ x: number, z: number }} place @param {Vector3} at what to look at */
    begin(place, at) {
      active = true;
      held.clear();
      camera.position.set(place.x, heightAt(place.x, place.z) + EYES, place.z);
      const [east, south] = [at.x - place.x, at.z - place.z];
      yaw = Math.atan2(-east, -south);
      pitch = Math.min(Math.max(Math.atan2(at.y - camera.position.y, Math.hypot(east, south)), 0), 0.35);
      stage.draw();
    },
    end() {
      active = false;
      held.clear();
    },
    /** @param {Way} way @param {boolean} on */
    hold(way, on) {
      if (on) held.add(way);
      else held.delete(way);
      last = performance.now();
      stage.draw();
    },
    /** @param {boolean} on */
    run: (on) => void (running = on),
    stop: () => held.clear(),
    look,
    /** The point on the ground ahead. */
    ahead() {
      const forward = camera.getWorldDirection(new Vector3()).setY(0).normalize().multiplyScalar(20);
      return forward.add(camera.position).setY(camera.position.y - EYES);
    },
    /** Before each picture. */
    update() {
      const now = performance.now();
      const seconds = Math.min((now - last) / 1000, 0.1);
      last = now;
      for (const way of held) {
        const [ahead, right, turn] = HELD[way];
        const metres = seconds * SPEED * (running ? RUN : 1);
        step(ahead * metres, right * metres);
        yaw += turn * TURN * seconds;
      }
      const floor = heightAt(camera.position.x, camera.position.z) + EYES;
      camera.position.y += (floor - camera.position.y) * Math.min(1, 6 * seconds || 1);
      camera.quaternion.setFromEuler(new Euler(pitch, yaw, 0, "YXZ"));
      stage.lightUp(focus.copy(camera.position), 60);
      if (held.size) stage.draw();
    },
  };
}
