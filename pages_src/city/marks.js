import { Box3, BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial } from "three";
import { partsOf } from "./features.js";
import { markMaterial } from "./scene.js";

const COLOUR = 0xff7a1a;

/**
 * The mark of the selected building, in all tiles that show it.
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {ReturnType<typeof import("./tiles.js").makeTiles>} tiles
 */
export function makeMarks(stage, tiles) {
  const material = markMaterial(COLOUR);
  const outline = new Line(new BufferGeometry(), new LineBasicMaterial({ color: COLOUR, fog: false }));
  outline.frustumCulled = false;
  outline.raycast = () => {};
  stage.scene.add(outline);
  /** @type {import("three").Mesh[]} */
  let parts = [];
  let marked = "";

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
    /** The box around the marked building; null if no tile shows it. */
    bounds() {
      const box = new Box3();
      for (const part of parts) box.expandByObject(part);
      return box.isEmpty() ? null : box;
    },
    /** @param {string} id of a building; empty for none @param {number[]} points of its parcel: x, y, z */
    mark(id, points) {
      marked = id;
      outline.geometry.dispose();
      outline.geometry = new BufferGeometry();
      outline.geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      outline.visible = points.length > 0;
      refresh();
    },
  };
}
