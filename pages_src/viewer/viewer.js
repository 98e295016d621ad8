/**
 * One interactive 3D view of a model. Built with three.js into `../viewer.js`, which the page loads when first used.
 */
import {
  ACESFilmicToneMapping,
  Box3,
  BufferGeometry,
  CircleGeometry,
  DirectionalLight,
  DoubleSide,
  Float32BufferAttribute,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  Raycaster,
  Scene,
  ShadowMaterial,
  Sphere,
  Spherical,
  Vector2,
  Vector3,
  WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { GLTFLoader } from "three/addons/loaders/GLTFLoader.js";

/** @typedef {{ theta: number, phi: number, share: number }} Pose angles in radians, and the distance as a share of that from which the whole model is seen */

/** First position of the camera relative to the model: as in the thumbnails. */
const BEGIN = new Vector3(0.8, 0.55, 1);
const SUN = new Vector3(-0.45, 1, 0.6);
/** Largest movement of a click, in pixels. */
const STEADY = 6;

/**
 * A view that draws onto a canvas, only after a movement.
 *
 * @param {HTMLCanvasElement} canvas
 * @param {{ damping?: boolean, picked?: (triangle: number | null) => void, named?: (symbol: string) => void, moved?: (pose: Pose) => void }} [options]
 *   damping: let a movement run out softly (default: yes); picked: gets the clicked triangle of the model, counted through
 *   its file; named: gets the symbol of the clicked part, if the file names parts; moved: gets every view
 */
export function show(canvas, { damping = true, picked = () => {}, named = () => {}, moved = () => {} } = {}) {
  const renderer = new WebGLRenderer({ canvas, antialias: true, alpha: true });
  renderer.toneMapping = ACESFilmicToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;

  const scene = new Scene();
  const sun = new DirectionalLight(0xfff4e5, 2.6);
  sun.castShadow = true;
  sun.shadow.mapSize.set(2048, 2048);
  sun.shadow.bias = -0.0005;
  const ground = new Mesh(new CircleGeometry(1, 48), new ShadowMaterial({ opacity: 0.28 }));
  ground.rotation.x = -Math.PI / 2;
  ground.receiveShadow = true;
  scene.add(new HemisphereLight(0xdfeaff, 0x8a8378, 1.9), sun, sun.target, ground);

  const camera = new PerspectiveCamera(35, 1, 0.1, 1000);
  const controls = new OrbitControls(camera, canvas);
  controls.enableDamping = damping;
  controls.dampingFactor = 0.12;
  controls.addEventListener("change", () => {
    draw();
    moved(pose());
  });

  const marked = new Mesh(new BufferGeometry(), new MeshBasicMaterial({ color: 0x00a37f, transparent: true }));
  const green = new MeshLambertMaterial({ color: 0x00a37f, side: DoubleSide });
  Object.assign(marked.material, { opacity: 0.6, side: DoubleSide, polygonOffset: true, polygonOffsetFactor: -2 });

  /** @type {import("three").Object3D | null} */
  let model = null;
  /** @type {Vector2 | null} where a click may have begun */
  let pressed = null;
  let frame = 0;
  let loads = 0;
  let whole = 1; // distance from which the whole model is seen
  /** @type {Map<Mesh, Mesh["material"]>} materials of the parts that are marked by name */
  const own = new Map();

  function draw() {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      controls.update(); // announces a change, and so another frame, until the movement has run out
      renderer.render(scene, camera);
    });
  }

  function resize() {
    const { clientWidth: width, clientHeight: height } = canvas;
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(globalThis.devicePixelRatio || 1, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    draw();
  }

  /** The whole model in view, from where the thumbnails look. */
  function reset() {
    if (!model) return;
    const box = new Box3().setFromObject(model);
    const { center, radius } = box.getBoundingSphere(new Sphere());
    const narrow = Math.min(camera.aspect, 1);
    const distance = radius / Math.sin((camera.fov * Math.PI) / 360) / narrow;
    whole = distance;
    controls.target.copy(center);
    camera.position.copy(BEGIN).setLength(distance).add(center);
    camera.near = radius / 100;
    camera.far = distance + 20 * radius;
    camera.updateProjectionMatrix();
    controls.minDistance = radius / 10;
    controls.maxDistance = 6 * distance;
    light(center, radius, box.min.y);
    draw();
  }

  /**
   * What a mouse does by dragging and a wheel by turning.
   * @param {number} round the model, radians
   * @param {number} [up] and over it
   * @param {number} [nearer] by this factor
   */
  function move(round, up = 0, nearer = 1) {
    const place = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    place.theta += round;
    place.phi -= up;
    place.radius /= nearer;
    camera.position.setFromSpherical(place.makeSafe()).add(controls.target);
    draw();
  }

  /** Where the camera is, whatever the size of the model. @returns {Pose} */
  function pose() {
    const { theta, phi, radius } = new Spherical().setFromVector3(camera.position.clone().sub(controls.target));
    return { theta, phi, share: radius / whole };
  }

  /** Looks at the model as another view does. @param {Pose} pose */
  function take({ theta, phi, share }) {
    camera.position.setFromSphericalCoords(share * whole, phi, theta).add(controls.target);
    draw();
  }

  canvas.addEventListener("pointerdown", (event) => {
    pressed = event.isPrimary && event.button === 0 ? new Vector2(event.clientX, event.clientY) : null;
  });
  canvas.addEventListener("pointerup", (event) => {
    const isClick = pressed && pressed.distanceTo(new Vector2(event.clientX, event.clientY)) < STEADY;
    pressed = null;
    if (!isClick) return;
    picked(triangleAt(event.offsetX, event.offsetY));
    const symbol = symbolOf(hitAt(event.offsetX, event.offsetY)?.object);
    if (symbol) named(symbol);
  });

  /** What is seen at a pixel. @param {number} x @param {number} y */
  function hitAt(x, y) {
    const place = new Vector2((2 * x) / canvas.clientWidth - 1, 1 - (2 * y) / canvas.clientHeight);
    const ray = new Raycaster();
    ray.setFromCamera(place, camera);
    return model && ray.intersectObject(model)[0];
  }

  /** The triangle of the model that is seen at a pixel. @param {number} x @param {number} y */
  function triangleAt(x, y) {
    const hit = hitAt(x, y);
    if (!hit) return null;
    return (firsts().get(hit.object) ?? 0) + (hit.faceIndex ?? 0);
  }

  /** The first triangle of each mesh of the model, which come in the order of its file. */
  function firsts() {
    /** @type {Map<import("three").Object3D, number>} */
    const found = new Map();
    let count = 0;
    model?.traverse((part) => {
      if (!(part instanceof Mesh)) return;
      found.set(part, count);
      count += cornersOf(part.geometry) / 3;
    });
    return found;
  }

  /** Marks triangles of the model: first ones and ends in turn; null marks none. @param {number[] | null} triangles */
  function mark(triangles) {
    scene.remove(marked);
    marked.geometry.dispose();
    const points = triangles ? cornersIn(triangles) : [];
    if (points.length) {
      marked.geometry = new BufferGeometry();
      marked.geometry.setAttribute("position", new Float32BufferAttribute(points, 3));
      scene.add(marked);
    }
    draw();
  }

  /** Coordinates of the corners of triangles. @param {number[]} triangles first ones and ends in turn */
  function cornersIn(triangles) {
    const points = [];
    for (const [part, first] of firsts()) {
      const { geometry } = /** @type {Mesh} */ (part);
      const { position } = geometry.attributes;
      for (let run = 0; run < triangles.length; run += 2) {
        const start = Math.max(3 * (triangles[run] - first), 0);
        const end = Math.min(3 * (triangles[run + 1] - first), cornersOf(geometry));
        for (let corner = start; corner < end; corner++) {
          const row = geometry.index ? geometry.index.getX(corner) : corner;
          points.push(position.getX(row), position.getY(row), position.getZ(row));
        }
      }
    }
    return points;
  }

  /** Colours the parts of a symbol; none for an empty one. @param {string} symbol */
  function markNamed(symbol) {
    for (const [part, material] of own) part.material = material;
    own.clear();
    model?.traverse((part) => {
      if (!symbol || !(part instanceof Mesh) || symbolOf(part) !== symbol) return;
      own.set(part, part.material);
      part.material = green;
    });
    draw();
  }

  /** @param {Vector3} center @param {number} radius @param {number} floor */
  function light(center, radius, floor) {
    sun.target.position.copy(center);
    sun.position
      .copy(SUN)
      .setLength(3 * radius)
      .add(center);
    const { camera: shadow } = sun.shadow;
    shadow.left = shadow.bottom = -1.6 * radius;
    shadow.right = shadow.top = 1.6 * radius;
    shadow.far = 6 * radius;
    // Two texels along the normal: a wall at a grazing angle of the sun casts no stripes on itself.
    sun.shadow.normalBias = (2 * 3.2 * radius) / sun.shadow.mapSize.width;
    shadow.updateProjectionMatrix();
    ground.position.set(center.x, floor - 0.001 * radius, center.z);
    ground.scale.setScalar(6 * radius);
  }

  /**
   * Shows a model instead of the one before. When two loads cross, the later call wins.
   * @param {ArrayBuffer} glb
   * @param {boolean} [stays] whether the camera stays where it is, since it is the same model after a change
   */
  async function load(glb, stays = false) {
    const turn = ++loads;
    const loaded = (await new GLTFLoader().parseAsync(glb, "")).scene;
    if (turn !== loads) return discard(loaded);
    const place = stays && model ? { eye: camera.position.clone(), target: controls.target.clone() } : null;
    clear();
    loaded.traverse((part) => {
      part.castShadow = part.receiveShadow = part instanceof Mesh;
    });
    model = loaded;
    scene.add(model);
    resize();
    reset();
    if (!place) return;
    camera.position.copy(place.eye);
    controls.target.copy(place.target);
    draw();
  }

  function clear() {
    if (!model) return;
    mark(null);
    markNamed("");
    scene.remove(model);
    discard(model);
    model = null;
  }

  /** Shows nothing. */
  function empty() {
    loads += 1;
    clear();
    draw();
  }

  function dispose() {
    loads += 1;
    cancelAnimationFrame(frame);
    clear();
    marked.material.dispose();
    green.dispose();
    controls.dispose();
    renderer.dispose();
  }

  return { load, clear: empty, resize, reset, move, pose, take, mark, markNamed, dispose };
}

/** The symbol of a part, from its file: of the part, or of the node around its primitives. @param {import("three").Object3D | null | undefined} part */
function symbolOf(part) {
  return String(part?.userData.symbol ?? part?.parent?.userData.symbol ?? "");
}

/** @param {BufferGeometry} geometry */
function cornersOf(geometry) {
  return geometry.index?.count ?? geometry.attributes.position.count;
}

/** Frees what a model holds on the graphics card. @param {import("three").Object3D} object */
function discard(object) {
  object.traverse((part) => {
    if (!(part instanceof Mesh)) return;
    part.geometry.dispose();
    for (const material of [part.material].flat()) {
      for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
      material.dispose();
    }
  });
}
