import {
  ACESFilmicToneMapping,
  BackSide,
  Color,
  DirectionalLight,
  Fog,
  HemisphereLight,
  Mesh,
  MeshBasicMaterial,
  MeshLambertMaterial,
  PCFShadowMap,
  PerspectiveCamera,
  RingGeometry,
  Scene,
  ShaderMaterial,
  SphereGeometry,
  Vector3,
  WebGLRenderer,
} from "three";

const SUN = new Vector3(-0.55, 0.9, 0.5);
/** Pixels along each side of the map of shadows. */
const SHADOW_PIXELS = 2048;
/** Metres around the point that is looked at with shadows: least and most. */
const SHADOW_RADII = [60, 500];
/** Metres to the horizon. */
const FAR = 30_000;

const LOOKS = {
  light: {
    zenith: 0x6fa8e0,
    horizon: 0xdfe9f2,
    ground: 0xb4b9a6,
    street: 0x7c7e81,
    pavement: 0xbdbab3,
    lot: 0xc6cfb8,
    tint: 0.25,
    sky: 1.9,
    sun: 2.6,
  },
  dark: {
    zenith: 0x131a24,
    horizon: 0x465364,
    ground: 0x50564e,
    street: 0x474b50,
    pavement: 0x6a6c6c,
    lot: 0x687062,
    tint: 0.15,
    sky: 1.2,
    sun: 1.7,
  },
};

/**
 * Sky, light and ground of a city; it is drawn only when something has changed.
 * @param {HTMLCanvasElement} canvas
 * @param {{ before: () => void }} each what is done before each picture
 */
export function makeScene(canvas, each) {
  const renderer = new WebGLRenderer({ canvas, antialias: true });
  renderer.toneMapping = ACESFilmicToneMapping;
  renderer.shadowMap.enabled = true;
  renderer.shadowMap.type = PCFShadowMap;
  renderer.shadowMap.autoUpdate = false;

  const scene = new Scene();
  const camera = new PerspectiveCamera(50, 1, 0.5, FAR);
  const light = new HemisphereLight(0xdfeaff, 0x8a8378, 1);
  const sun = new DirectionalLight(0xfff4e5, 1);
  sun.castShadow = true;
  sun.shadow.mapSize.set(SHADOW_PIXELS, SHADOW_PIXELS);
  sun.shadow.bias = -0.0004;
  const ground = new Mesh(plain(), new MeshLambertMaterial());
  ground.receiveShadow = true;
  const sky = makeSky();
  const fog = new Fog(0, 1, FAR);
  scene.fog = fog;
  scene.add(light, sun, sun.target, ground, sky.mesh);

  /** Centre of the shadows, and metres around it. */
  const lit = { focus: new Vector3(), radius: 0 };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  /** @type {(look: typeof LOOKS.light) => void} */
  let relook = () => {};
  let frame = 0;

  function recolour() {
    const look = LOOKS[dark.matches ? "dark" : "light"];
    sky.paint(look.zenith, look.horizon);
    fog.color.set(look.horizon);
    ground.material.color.set(look.ground);
    light.intensity = look.sky;
    sun.intensity = look.sun;
    relook(look);
    draw();
  }

  function draw() {
    frame ||= requestAnimationFrame(() => {
      frame = 0;
      each.before();
      sky.mesh.position.copy(camera.position);
      ground.position.x = camera.position.x;
      ground.position.z = camera.position.z;
      renderer.render(scene, camera);
    });
  }

  /**
   * Shadows around the point that is looked at, drawn anew if they would be far off or unsharp.
   * @param {Vector3} focus
   * @param {number} distance from the camera
   */
  function lightUp(focus, distance) {
    const radius = Math.min(Math.max(1.3 * distance, SHADOW_RADII[0]), SHADOW_RADII[1]);
    const isNear = focus.distanceTo(lit.focus) < radius / 6;
    const isSharp = radius < 1.3 * lit.radius && radius > 0.7 * lit.radius;
    camera.near = Math.min(Math.max(distance / 100, 0.2), 20);
    camera.updateProjectionMatrix();
    fog.near = Math.max(2 * distance, 600);
    fog.far = Math.max(12 * distance, 5000);
    if (isNear && isSharp) return;
    lit.focus.copy(focus);
    lit.radius = radius;
    sun.target.position.copy(focus);
    sun.position
      .copy(SUN)
      .setLength(radius + 400)
      .add(focus);
    const { camera: shadow } = sun.shadow;
    shadow.left = shadow.bottom = -radius;
    shadow.right = shadow.top = radius;
    shadow.near = 1;
    shadow.far = 2 * radius + 800;
    shadow.updateProjectionMatrix();
    sun.shadow.normalBias = radius / 400;
    reshade();
  }

  function reshade() {
    renderer.shadowMap.needsUpdate = true;
    draw();
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

  dark.addEventListener("change", recolour);
  recolour();
  new ResizeObserver(resize).observe(canvas);
  resize();
  return {
    renderer,
    scene,
    camera,
    draw,
    lightUp,
    reshade,
    /** Puts the ground below everything. @param {number} height metres */
    sink: (height) => void (ground.position.y = height),
    /** @param {(look: typeof LOOKS.light) => void} callback for the colours, now and whenever they change */
    colours(callback) {
      relook = callback;
      recolour();
    },
  };
}

/** A disc whose triangles are small near its middle: depths within a triangle of kilometres are not exact enough for fog. */
function plain() {
  const disc = new RingGeometry(0, 1, 64, 12);
  const { position } = disc.attributes;
  for (let corner = 0; corner < position.count; corner++) {
    const [x, y] = [position.getX(corner), position.getY(corner)];
    const farther = FAR * Math.hypot(x, y) ** 4;
    position.setXY(corner, x * farther, y * farther);
  }
  return disc.rotateX(-Math.PI / 2);
}

/** A dome around the camera, brighter at the horizon. */
function makeSky() {
  const colours = { zenith: { value: new Color() }, horizon: { value: new Color() } };
  const material = new ShaderMaterial({
    uniforms: colours,
    side: BackSide,
    depthWrite: false,
    vertexShader:
      "varying vec3 v; void main() { v = position; gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0); }",
    fragmentShader: `
      varying vec3 v;
      uniform vec3 zenith;
      uniform vec3 horizon;
      void main() {
        gl_FragColor = vec4(mix(horizon, zenith, pow(max(normalize(v).y, 0.0), 0.55)), 1.0);
        #include <colorspace_fragment>
      }`,
  });
  const mesh = new Mesh(new SphereGeometry(FAR / 2, 32, 16), material);
  mesh.renderOrder = -1;
  mesh.frustumCulled = false;
  return {
    mesh,
    /** @param {number} zenith @param {number} horizon */
    paint(zenith, horizon) {
      colours.zenith.value.set(zenith);
      colours.horizon.value.set(horizon);
    },
  };
}

/** A translucent material that marks what is selected. @param {number} colour */
export function markMaterial(colour) {
  return new MeshBasicMaterial({
    color: colour,
    transparent: true,
    depthWrite: false,
    polygonOffset: true,
    polygonOffsetFactor: -2,
    polygonOffsetUnits: -2,
    side: 2,
    fog: false,
  });
}
