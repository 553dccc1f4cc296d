/** The disk on the table in three dimensions, seen by a camera that follows it and can be turned. */

import { diskBody, niceLength, tableOfSquares, Trail } from "eulerdisk/motion/furniture";
import { reachOf, solidOf } from "eulerdisk/motion/solid";
import {
  AmbientLight,
  Color,
  DirectionalLight,
  Fog,
  Matrix4,
  Mesh,
  PCFShadowMap,
  PerspectiveCamera,
  PlaneGeometry,
  Scene,
  ShadowMaterial,
  Vector3,
  WebGLRenderer,
  ConeGeometry,
  CylinderGeometry,
  Group,
  MeshBasicMaterial,
  Quaternion,
} from "three";
import { OrbitControls } from "three/orbit_controls";

/** @import { Samples } from "eulerdisk/motion/samples" */
/** @import { MotionHead } from "eulerdisk/types" */

/**
 * Colours of the scene, as CSS writes them.
 * @typedef {{ground: string, grid: string, trail: string, force: string, rim: string}} SceneColours
 */

/**
 * Position of the camera relative to the disk: azimuth and elevation in radians, and distance in radii.
 * @typedef {[number, number, number]} Standpoint
 */

/** Initial position of the camera: behind the disk to its right and above the table, and its distance in radii. */
const AZIMUTH = (-58 * Math.PI) / 180;
const ELEVATION = (22 * Math.PI) / 180;
const DISTANCE = 5.8;

/**
 * Height of the point at which the camera looks, relative to the height of the centre: below the centre, so that the
 * path of an upright disk is visible.
 */
const LOOK_AT = 0.8;

/** Number of samples from which the median height of the centre is computed. */
const HEIGHTS = 200;

/** Angle by which a key press turns the camera. */
const TURN = (6 * Math.PI) / 180;

/** Least and greatest elevation of the camera: above the table, and not quite overhead. */
const [LOWEST, HIGHEST] = [0.02, 1.55];

/** Largest side of the squares of the table, in radii. */
const SQUARE = 1.0;

/**
 * Time between two frames in milliseconds above which pictures get coarser, how coarse, and the rest after which they
 * are sharp again.
 */
const SLOW = 50;
const COARSEST = 0.4;
const REST = 400;

/** Length of the arrow for the weight of the disk, in radii. */
const WEIGHT = 0.9;

export class DiskScene {
  /**
   * @param {HTMLElement} element  gets the picture
   * @param {(standpoint: Standpoint|null) => void} [turned]  called with the position where a person put the camera;
   * null for the initial position
   * @throws if the browser has no WebGL
   */
  constructor(element, turned = () => {}) {
    this.element = element;
    this.renderer = new WebGLRenderer({ antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = PCFShadowMap;
    this.canvas = this.renderer.domElement;
    this.scene = new Scene();
    this.camera = new PerspectiveCamera(32, 1, 0.01, 100);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.enablePan = false;
    // a finger that moves up or down scrolls the page
    this.canvas.style.touchAction = "pan-y";
    this.controls.maxPolarAngle = 0.495 * Math.PI;
    this.controls.addEventListener("change", () => this.draw());
    let before = "";
    this.controls.addEventListener("start", () => (before = String(this.standpoint)));
    this.controls.addEventListener("end", () => {
      if (this.samples && String(this.standpoint) !== before) turned(this.standpoint);
    });
    this.turned = turned;
    /** @type {Samples|null} */
    this.samples = null;
    this.time = 0;
    this.frame = 0;
    this.drawn = 0;
    this.sharpness = 1;
    /** @type {ReturnType<typeof setTimeout>|undefined} */
    this.timer = undefined;
    this.square = 0;
    /** Length in m that determines the layout of the scene: the radius, or the extent of a body. */
    this.size = 1;
    /** Median height of the centre in m. */
    this.height = 1;
    this.look = "";
    this.isCompiled = false;
    /** @type {Trail|undefined} */
    this.trail = undefined;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute("role", "application");
    this.canvas.setAttribute("aria-roledescription", "picture");
    this.canvas.addEventListener("keydown", (event) => this.#turnBy(event));
    new ResizeObserver(() => this.#fit()).observe(element);
  }

  /**
   * Show a motion. The camera keeps its position relative to the disk, unless the size of the disk changes.
   * @param {Samples} samples
   * @param {SceneColours} colours
   * @param {Standpoint|null} [standpoint]  camera position for a disk of another size; null for behind the disk
   */
  show(samples, colours, standpoint = null) {
    const { radius, alpha, body } = samples.head;
    const look = JSON.stringify([radius, alpha, body, colours]);
    const size = body ? radius * Math.max(reachOf(body), 1) : radius;
    const first = this.samples === null || this.size !== size;
    this.samples = samples;
    this.size = size;
    this.height = middleHeight(samples);
    if (!this.canvas.isConnected) this.element.append(this.canvas);
    if (look !== this.look) this.#furnish(samples.head, colours);
    this.look = look;
    this.#layTrail(samples, colours.trail);
    if (first) {
      this.#adjust(size);
      this.standpoint = standpoint ?? this.behind();
    }
    this.setTime(this.time);
  }

  /**
   * Add everything that does not depend on the motion to the scene.
   * @param {MotionHead} head
   * @param {SceneColours} colours
   */
  #furnish({ radius, alpha, body }, colours) {
    this.#empty();
    const { size } = this;
    this.square = niceLength(SQUARE * size);
    this.disk = body ? solidOf(radius, body) : diskBody(radius, alpha, colours.rim);
    this.force = new Arrow(size, colours.force);
    this.table = tableOfSquares(this.square, colours.ground, colours.grid);
    this.shadow = new Mesh(
      new PlaneGeometry(12 * size, 12 * size),
      new ShadowMaterial({ opacity: 0.3, depthWrite: false }),
    );
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = -1;
    this.scene.background = new Color(colours.ground);
    this.scene.fog = new Fog(colours.ground, 7 * size, 30 * size);
    this.light = sun(size);
    const parts = [this.table, this.shadow, this.disk, this.force];
    this.scene.add(...parts, this.light, this.light.target, new AmbientLight("#ffffff", 2.5));
  }

  /**
   * @param {Samples} samples
   * @param {string} colour
   */
  #layTrail({ arrays, head }, colour) {
    for (const old of this.trail ? [this.trail.whole, this.trail.passed] : []) {
      free(old);
      this.scene.remove(old);
    }
    this.trail = new Trail(arrays.time, arrays.contact_x, arrays.contact_y, head.radius, colour);
    this.scene.add(this.trail.whole, this.trail.passed);
  }

  /** @param {number} time  in seconds */
  setTime(time) {
    this.time = time;
    if (!this.samples || !this.disk) return;
    const pose = poseAt(this.samples, time);
    this.disk.quaternion.copy(pose.turned);
    this.disk.position.copy(pose.centre);
    this.force?.point(pose.contact, pose.push.multiplyScalar(WEIGHT * this.size));
    this.trail?.setTime(time);
    this.#follow(pose.centre, this.size);
    this.draw();
  }

  /** Draw in the next frame, only once for all changes before it. */
  draw() {
    if (!this.samples) return;
    this.frame ||= requestAnimationFrame((now) => {
      this.frame = 0;
      this.#keepPace(now);
      if (this.isCompiled) {
        this.renderer.render(this.scene, this.camera);
        return;
      }
      // the page continues while the driver compiles
      this.renderer.compile(this.scene, this.camera);
      this.isCompiled = true;
      this.draw();
    });
  }

  /**
   * Draw fewer pixels while frames are slow, as without a graphics card; draw sharply again at rest.
   * @param {number} now  in milliseconds
   */
  #keepPace(now) {
    const passed = now - this.drawn;
    this.drawn = now;
    if (passed > SLOW && passed < REST && this.sharpness > COARSEST) this.#sharpen(0.75 * this.sharpness);
    clearTimeout(this.timer);
    if (this.sharpness < 1) this.timer = setTimeout(() => this.#sharpen(1), REST);
  }

  /** @param {number} sharpness drawn pixels per screen pixel, along a side */
  #sharpen(sharpness) {
    this.sharpness = sharpness;
    this.#fit();
  }

  /**
   * Show nothing, and free all resources of the motion. The WebGL context stays for the next motion: three.js keeps
   * every context that ever shared a texture.
   */
  clear() {
    cancelAnimationFrame(this.frame);
    clearTimeout(this.timer);
    this.frame = 0;
    this.samples = null;
    this.#empty();
    this.canvas.remove();
  }

  #empty() {
    free(this.scene);
    this.scene.clear();
    this.trail = this.disk = this.force = this.table = this.shadow = this.light = undefined;
    this.look = "";
    this.isCompiled = false;
  }

  /**
   * Move camera, light and grid with the centre, which stays in place while a disk wobbles around it. Their height is
   * constant, so that the rise and fall of the disk are visible.
   * @param {Vector3} centre
   * @param {number} radius
   */
  #follow({ x, y }, radius) {
    const target = new Vector3(x, y, LOOK_AT * this.height);
    const way = target.clone().sub(this.controls.target);
    this.controls.target.copy(target);
    this.camera.position.add(way);
    this.camera.lookAt(target);
    this.light?.target.position.set(x, y, 0);
    this.light?.position.set(x - 1.5 * radius, y + 1.2 * radius, 5 * radius);
    this.shadow?.position.set(x, y, 0);
    const { square } = this;
    this.table?.position.set(square * Math.round(x / square), square * Math.round(y / square), 0);
  }

  /**
   * Return the position behind the disk.
   * @returns {Standpoint}
   */
  behind() {
    const samples = /** @type {Samples} */ (this.samples);
    const backwards = samples.head.start.roll_rate < 0 ? Math.PI : 0;
    // the track of heading 0 is the y axis
    return [samples.at("heading", 0) - Math.PI / 2 + AZIMUTH + backwards, ELEVATION, DISTANCE];
  }

  /**
   * The position of the camera relative to the disk.
   * @returns {Standpoint}
   */
  get standpoint() {
    const { x, y, z } = this.camera.position.clone().sub(this.controls.target);
    const distance = Math.hypot(x, y, z);
    return [Math.atan2(y, x), Math.asin(z / distance), distance / this.size];
  }

  set standpoint([azimuth, elevation, distance]) {
    const { minDistance, maxDistance } = this.controls;
    const far = Math.min(Math.max(distance * this.size, minDistance), maxDistance);
    const up = Math.min(Math.max(elevation, LOWEST), HIGHEST);
    this.camera.position.set(
      far * Math.cos(up) * Math.cos(azimuth),
      far * Math.cos(up) * Math.sin(azimuth),
      far * Math.sin(up),
    );
    this.camera.position.add(this.controls.target);
    this.controls.update();
    this.draw();
  }

  /**
   * Set the nearest and farthest visible distance for a disk of some size.
   * @param {number} radius
   */
  #adjust(radius) {
    this.camera.near = 0.05 * radius;
    this.camera.far = 80 * radius;
    this.controls.minDistance = 1.6 * radius;
    this.controls.maxDistance = 24 * radius;
    this.camera.updateProjectionMatrix();
  }

  /** @param {KeyboardEvent} event */
  #turnBy(event) {
    const turns = {
      ArrowLeft: [-1, 0, 1],
      ArrowRight: [1, 0, 1],
      ArrowUp: [0, 1, 1],
      ArrowDown: [0, -1, 1],
      "+": [0, 0, 0.9],
      "-": [0, 0, 1 / 0.9],
    };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "0") {
      this.standpoint = this.behind();
      this.turned(null);
    }
    const turn = turns[/** @type {"+"} */ (event.key)];
    if (!turn) return;
    event.preventDefault();
    const [azimuth, elevation, distance] = this.standpoint;
    this.standpoint = [azimuth + turn[0] * TURN, elevation + turn[1] * TURN, distance * turn[2]];
    this.turned(this.standpoint);
  }

  #fit() {
    const { clientWidth: width, clientHeight: height } = this.element;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(this.sharpness * Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }
}

/**
 * Free the graphics memory of a part of the scene.
 * @param {import("three").Object3D} whole
 */
function free(whole) {
  whole.traverse((part) => {
    const { geometry, material } = /** @type {Mesh} */ (part);
    geometry?.dispose();
    for (const each of [material ?? []].flat()) {
      /** @type {any} */ (each).map?.dispose();
      each.dispose();
    }
    if (part instanceof DirectionalLight) part.dispose();
  });
}

/** @param {number} radius */
function sun(radius) {
  const light = new DirectionalLight("#ffffff", 1.3);
  light.castShadow = true;
  light.shadow.mapSize.set(1024, 1024);
  light.shadow.radius = 5;
  light.shadow.bias = -0.0005;
  const frame = light.shadow.camera;
  frame.left = frame.bottom = -2.6 * radius;
  frame.right = frame.top = 2.6 * radius;
  frame.near = 0.5 * radius;
  frame.far = 12 * radius;
  return light;
}

/** Radius of the shaft, and radius and length of the head, in units of `unit`. */
const SHAFT = 0.024;
const HEAD = [0.07, 0.18];

const UP = new Vector3(0, 1, 0);

export class Arrow extends Group {
  /**
   * @param {number} unit  a length of the scene, to which the thickness is proportional
   * @param {string} colour
   */
  constructor(unit, colour) {
    super();
    this.unit = unit;
    // a force is visible through the disk, into which it often points
    const material = new MeshBasicMaterial({ color: colour, depthTest: false, transparent: true });
    this.shaft = new Mesh(new CylinderGeometry(SHAFT * unit, SHAFT * unit, 1, 16), material);
    this.head = new Mesh(new ConeGeometry(HEAD[0] * unit, HEAD[1] * unit, 24), material);
    this.shaft.renderOrder = this.head.renderOrder = 3;
    this.add(this.shaft, this.head);
  }

  /**
   * @param {Vector3} from
   * @param {Vector3} along  its length is the length of the arrow
   */
  point(from, along) {
    const length = along.length();
    this.visible = length > 1e-6 * this.unit;
    if (!this.visible) return;
    this.position.copy(from);
    this.quaternion.copy(new Quaternion().setFromUnitVectors(UP, along.clone().normalize()));
    // a short arrow consists only of its head
    const scale = Math.min(length / (HEAD[1] * this.unit), 1);
    const shaft = Math.max(length - HEAD[1] * this.unit, 0);
    this.shaft.visible = shaft > 0;
    this.shaft.scale.y = Math.max(shaft, 1e-9);
    this.shaft.position.y = shaft / 2;
    this.head.scale.setScalar(scale);
    this.head.position.y = shaft + 0.5 * scale * HEAD[1] * this.unit;
  }
}

/**
 * Return the median over time of the height of the centre in m.
 * @param {Samples} samples
 */
export function middleHeight(samples) {
  const { time } = samples.arrays;
  const last = time[time.length - 1];
  const heights = Array.from({ length: HEIGHTS }, (_, i) => {
    const at = (last * (i + 0.5)) / HEIGHTS;
    return samples.head.body
      ? samples.at("centre_z", at)
      : samples.head.radius * Math.abs(Math.cos(samples.at("tilt", at)));
  });
  return heights.sort((a, b) => a - b)[HEIGHTS / 2];
}

/**
 * Return the pose of a disk or a body at a time: its rotation, its centre and its contact point in m, and the force on
 * it divided by its weight.
 * @param {Samples} samples
 * @param {number} time
 */
export function poseAt(samples, time) {
  return samples.head.body ? poseOfBody(samples, time) : poseOfDisk(samples, time);
}

/**
 * @param {Samples} samples
 * @param {number} time
 */
function poseOfDisk(samples, time) {
  const at = (/** @type {string} */ name) => samples.at(name, time);
  const { radius } = samples.head;
  const { turned, down } = attitude(at("tilt"), at("heading"), at("roll_angle"));
  const contact = new Vector3(at("contact_x"), at("contact_y"), 0);
  const push = forceOf(at("heading"), at("normal_force"), at("friction_across"), at("friction_along"));
  return { turned, contact, centre: contact.clone().addScaledVector(down, -radius), push };
}

/**
 * Interpolate by an even rotation about one axis between two samples: near a pole, the heading is uneven.
 * @param {Samples} samples
 * @param {number} time
 */
function poseOfBody(samples, time) {
  const at = (/** @type {string} */ name) => samples.at(name, time);
  const { before, share } = samples.between(time);
  const [one, other] = [before, before + 1].map((i) => {
    const [tilt, heading, angle, normal, across, along] = [
      ...["tilt", "heading", "roll_angle", "normal_force", "friction_across", "friction_along"],
    ].map((name) => samples.arrays[name][i]);
    return { ...attitude(tilt, heading, angle), push: forceOf(heading, normal, across, along) };
  });
  return {
    turned: one.turned.slerp(other.turned, share),
    contact: new Vector3(at("contact_x"), at("contact_y"), 0),
    centre: new Vector3(at("centre_x"), at("centre_y"), at("centre_z")),
    push: one.push.lerp(other.push, share),
  };
}

/**
 * Return the rotation of a disk or a body, and the direction in its plane that points down. Its x axis is the painted
 * radius, which points down at a roll angle of 0; its z axis is opposite to the axis of a body
 * (kernels/bodies/equations.py).
 * @param {number} tilt
 * @param {number} heading
 * @param {number} rollAngle
 */
export function attitude(tilt, heading, rollAngle) {
  const across = new Vector3(Math.cos(heading), Math.sin(heading), 0);
  const along = new Vector3(-Math.sin(heading), Math.cos(heading), 0);
  const down = new Vector3(0, 0, -Math.cos(tilt)).addScaledVector(across, -Math.sin(tilt));
  const turned = (/** @type {number} */ a, /** @type {number} */ b) =>
    down.clone().multiplyScalar(a).addScaledVector(along, b);
  const painted = turned(Math.cos(rollAngle), -Math.sin(rollAngle));
  const aside = turned(Math.sin(rollAngle), Math.cos(rollAngle));
  const frame = new Matrix4().makeBasis(painted, aside, painted.clone().cross(aside));
  return { turned: new Quaternion().setFromRotationMatrix(frame), down };
}

/**
 * @param {number} heading
 * @param {number} normal
 * @param {number} across
 * @param {number} along
 */
function forceOf(heading, normal, across, along) {
  const [cos, sin] = [Math.cos(heading), Math.sin(heading)];
  return new Vector3(across * cos - along * sin, across * sin + along * cos, normal);
}
