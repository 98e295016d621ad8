import { Box3, BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial, Vector3 } from "three";
import { partsOf } from "./features.js";
import { markMaterial } from "./scene.js";

const COLOUR = 0xff7a1a;
/** Opacity of the mark, and metres at which it would be opaque. */
const [FAINTEST, STRONGEST, FAR] = [0.22, 0.85, 500];

/**
 * The mark of the selected building, in all tiles that show it.
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {ReturnType<typeof import("./tiles.js").makeTiles>} tiles
 */
export function makeMarks(stage, tiles) {
  const material = markMaterial(COLOUR);
  const outline = new Line(
    new BufferGeometry(),
    new LineBasicMaterial({ color: COLOUR, fog: false, depthTest: false }),
  );
  outline.frustumCulled = false;
  outline.renderOrder = 1;
  outline.raycast = () => {};
  stage.scene.add(outline);
  /** @type {import("three").Mesh[]} */
  let parts = [];
  let marked = "";
  /** @type {Vector3 | null} of the marked parcel */
  let middle = null;

  function clear() {
    for (const part of parts) {
      part.removeFromParent();
      if ("isInstancedMesh" in part) /** @type {import("three").InstancedMesh} */ (part).dispose();
      else part.geometry.dispose();
    }
    parts = [];
  }

  function refresh() {
    clear();
    if (marked) tiles.each((scene) => parts.push(...partsOf(scene, marked)));
    for (const part of parts) part.material = material;
    stage.draw();
  }

  return {
    refresh,
    /** Marks what is far away more strongly; colours of what is near stay visible. @param {Vector3} eye */
    fade(eye) {
      if (!middle) return;
      material.opacity = Math.min(Math.max(eye.distanceTo(middle) / FAR, FAINTEST), STRONGEST);
    },
    /** The box around the marked building; null if no tile shows it. */
    bounds() {
      const box = new Box3();
      for (const part of parts) box.expandByObject(part);
      return box.isEmpty() ? null : box;
    },
    /** @param {string} id of a building; empty for none @param {number[]} points of its parcel: x, y, z */
    mark(id, points) {
      marked = id;
      middle = points.length ? new Box3().setFromArray(points).getCenter(new Vector3()) : null;
      outline.geometry.dispose();
      outline.geometry = new BufferGeometry();
      outline.geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      outline.visible = points.length > 0;
      refresh();
    },
  };
}
