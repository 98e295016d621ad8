/**
 * @license
 * 3d-tiles-renderer 0.5.3
 * Copyright 2020 California Institute of Technology
 * SPDX-License-Identifier: Apache-2.0
 */
import { TilesRenderer } from "3d-tiles-renderer/three";
import { GLTFExtensionsPlugin, ImplicitTilingPlugin } from "3d-tiles-renderer/plugins";
import { Box3, Matrix4, Mesh } from "three";
import { buildingIds } from "./features.js";

/** Bytes of tiles in memory; beyond it distant tiles stay coarse. */
const MAX_BYTES = 1.5e9;
const MIN_BYTES = 0.8e9;
/** Pictures without loading after which tiles are complete. */
const QUIET = 5;

/**
 * The tiles of a city in metres to the east, up and to the south of their origin.
 * New tiles replace old ones when they have loaded, so that the city never vanishes.
 *
 * @param {ReturnType<typeof import("./scene.js").makeScene>} stage
 * @param {{ loaded: () => void, ready: () => void, failed: (text: string) => void }} tell
 */
export function makeTiles(stage, tell) {
  /** @type {TilesRenderer | null} that are shown */
  let shown = null;
  /** @type {TilesRenderer | null} that are loading */
  let next = null;
  /** Pictures since nothing more of them was to be loaded. */
  let quiet = 0;

  function open() {
    next?.dispose();
    const tiles = new TilesRenderer(new URL("folder/tileset.json", location.href).href);
    tiles.registerPlugin(new ImplicitTilingPlugin());
    tiles.registerPlugin(
      new GLTFExtensionsPlugin({ metadata: false, rtc: false, plugins: [buildingIds], autoDispose: false }),
    );
    tiles.registerPlugin({ preprocessURL: withToken });
    tiles.lruCache.maxBytesSize = MAX_BYTES;
    tiles.lruCache.minBytesSize = MIN_BYTES;
    tiles.setCamera(stage.camera);
    tiles.addEventListener("load-root-tileset", () => {
      upright(tiles);
      tell.ready();
    });
    tiles.addEventListener("load-model", ({ scene }) => {
      scene.traverse((part) => {
        part.castShadow = part.receiveShadow = part instanceof Mesh;
      });
      if (tiles === shown) tell.loaded();
      performance.mark("city-tile");
      stage.reshade();
    });
    tiles.addEventListener("tile-visibility-change", stage.reshade);
    tiles.addEventListener("needs-update", stage.draw);
    tiles.addEventListener("load-error", ({ url, error }) => tell.failed(`${new URL(url).pathname}: ${error.message}`));
    if (shown) next = tiles;
    else shown = tiles;
    stage.scene.add(tiles.group);
    tiles.group.visible = tiles === shown;
    stage.draw();
  }

  function replace() {
    if (!shown || !next) return;
    stage.scene.remove(shown.group);
    shown.dispose();
    shown = next;
    next = null;
    shown.group.visible = true;
    tell.loaded();
    stage.reshade();
  }

  return {
    open,
    get group() {
      return shown?.group;
    },
    /** Whether tiles are being loaded. */
    get isLoading() {
      return Boolean(next) || !shown || shown.loadProgress < 1;
    },
    /** Loads what the camera needs; before each picture. */
    update() {
      for (const tiles of [shown, next]) {
        tiles?.setResolutionFromRenderer(stage.camera, stage.renderer);
        tiles?.update();
      }
      if (!next) return;
      // What a tile needs is asked for when it has come, so that loading ends only after some quiet pictures.
      quiet = next.root && next.loadProgress === 1 ? quiet + 1 : 0;
      if (quiet > QUIET) replace();
      else stage.draw();
    },
    /** Bounds of all buildings; null until they are known. */
    bounds() {
      const box = new Box3();
      if (!shown?.root || !shown.getBoundingBox(box)) return null;
      return localBounds(shown, box);
    },
    /** @param {(scene: import("three").Object3D) => void} visit */
    each: (visit) => void shown?.forEachLoadedModel((scene) => visit(scene)),
  };
}

/** Axes of the root: x to the east, y up, z to the south. @param {TilesRenderer} tiles */
function upright(tiles) {
  const toRoot = rootMatrix(tiles).invert();
  new Matrix4()
    .makeRotationX(-Math.PI / 2)
    .multiply(toRoot)
    .decompose(tiles.group.position, tiles.group.quaternion, tiles.group.scale);
  tiles.group.updateMatrixWorld(true);
}

/** @param {TilesRenderer} tiles */
function rootMatrix(tiles) {
  const numbers = /** @type {number[] | undefined} */ (/** @type {any} */ (tiles.root).transform);
  return numbers ? new Matrix4().fromArray(numbers) : new Matrix4();
}

/**
 * The box of the root about its own axes: a box of earth-centred axes would be far too large.
 * @param {TilesRenderer} tiles
 * @param {Box3} about
 */
function localBounds(tiles, about) {
  const numbers = /** @type {number[] | undefined} */ (/** @type {any} */ (tiles.root).boundingVolume?.box);
  if (!numbers) return about.applyMatrix4(tiles.group.matrixWorld);
  const [x, y, z, ...axes] = numbers;
  const half = [0, 1, 2].map((axis) => Math.abs(axes[axis]) + Math.abs(axes[axis + 3]) + Math.abs(axes[axis + 6]));
  const box = new Box3();
  box.min.set(x - half[0], z - half[2], -y - half[1]);
  box.max.set(x + half[0], z + half[2], -y + half[1]);
  return box;
}

/** Address of a file of the city with the token of this window. @param {string} address */
function withToken(address) {
  const url = new URL(address, location.href);
  url.search = location.search;
  return url.href;
}
