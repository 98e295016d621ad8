import { BufferGeometry, Float32BufferAttribute, InstancedMesh, Matrix4, Mesh } from "three";

/** @typedef {import("three").Object3D} Object3D */

/** Arrays of the offsets of texts, by their type in the schema. @type {Record<string, any>} */
const OFFSETS = { UINT8: Uint8Array, UINT16: Uint16Array, UINT32: Uint32Array };

/**
 * Plugin of GLTFLoader: puts the ids of the buildings of a tile, by feature, into `userData.buildings` of its scene.
 * @param {any} parser
 */
export function buildingIds(parser) {
  return {
    name: "GRAMMARLAB_building_ids",
    /** @param {{ scene: Object3D }} result */
    async afterRoot(result) {
      const table = parser.json.extensions?.EXT_structural_metadata?.propertyTables?.[0];
      const ids = table?.properties?.id;
      if (!ids) return;
      const [values, offsets] = await Promise.all(
        [ids.values, ids.stringOffsets].map((view) => parser.getDependency("bufferView", view)),
      );
      const starts = new OFFSETS[ids.stringOffsetType ?? "UINT32"](offsets);
      const decoder = new TextDecoder();
      result.scene.userData.buildings = Array.from({ length: table.count }, (_, row) =>
        decoder.decode(new Uint8Array(values, starts[row], starts[row + 1] - starts[row])),
      );
    },
  };
}

/** The building that a ray hit. @param {import("three").Intersection} hit @returns {string | undefined} */
export function buildingOf({ object, face, instanceId }) {
  const ids = idsOf(object);
  const rows = rowsOf(/** @type {Mesh} */ (object));
  const row = rows?.getX(instanceId ?? face?.a ?? 0);
  return row === undefined ? undefined : ids?.[row];
}

/**
 * The parts of a building in a tile as geometries in the tile's metres, each with the mesh that it is a part of.
 * @param {Object3D} scene of the tile
 * @param {string} id
 * @returns {Mesh[]}
 */
export function partsOf(scene, id) {
  const row = scene.userData.buildings?.indexOf(id) ?? -1;
  /** @type {Mesh[]} */
  const parts = [];
  if (row < 0) return parts;
  scene.traverse((object) => {
    if (!(object instanceof Mesh) || object.userData.isMark) return;
    const part = object instanceof InstancedMesh ? instancesOf(object, row) : trianglesOf(object, row);
    if (!part) return;
    part.userData.isMark = true;
    part.raycast = () => {};
    part.matrixAutoUpdate = false;
    object.add(part);
    part.updateMatrixWorld(true);
    parts.push(part);
  });
  return parts;
}

/** @param {Mesh} mesh @param {number} row */
function trianglesOf(mesh, row) {
  const rows = rowsOf(mesh);
  const { index } = mesh.geometry;
  const { position } = mesh.geometry.attributes;
  if (!rows) return null;
  const points = [];
  const count = index?.count ?? position.count;
  for (let corner = 0; corner < count; corner++) {
    const vertex = index ? index.getX(corner) : corner;
    if (rows.getX(vertex) === row) points.push(position.getX(vertex), position.getY(vertex), position.getZ(vertex));
  }
  if (!points.length) return null;
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
  return new Mesh(geometry);
}

/** @param {InstancedMesh} mesh @param {number} row */
function instancesOf(mesh, row) {
  const rows = rowsOf(mesh);
  const found = [];
  for (let instance = 0; instance < mesh.count; instance++) if (rows?.getX(instance) === row) found.push(instance);
  if (!found.length) return null;
  const part = new InstancedMesh(mesh.geometry, undefined, found.length);
  const matrix = new Matrix4();
  found.forEach((instance, place) => {
    mesh.getMatrixAt(instance, matrix);
    part.setMatrixAt(place, matrix);
  });
  return part;
}

/** Rows of the tile's buildings: by vertex, or by instance. @param {Mesh} mesh */
function rowsOf(mesh) {
  const { _FEATURE_ID_0: ofInstances, _feature_id_0: ofVertices } = mesh.geometry.attributes;
  return mesh instanceof InstancedMesh ? ofInstances : ofVertices;
}

/** @param {Object3D} object @returns {string[] | undefined} */
function idsOf(object) {
  for (let part = /** @type {Object3D | null} */ (object); part; part = part.parent)
    if (part.userData.buildings) return part.userData.buildings;
  return undefined;
}
