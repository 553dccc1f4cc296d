/** The objects in the scene of a motion: the disk as a three.js body, the table, and the path on it. */

import { FACES, filled, painted, textureOf } from "eulerdisk/motion/paint";
import {
  BufferAttribute,
  BufferGeometry,
  DoubleSide,
  Group,
  LatheGeometry,
  Mesh,
  MeshBasicMaterial,
  MeshStandardMaterial,
  PlaneGeometry,
  RepeatWrapping,
  RingGeometry,
  Vector2,
} from "three";

/** Half the thickness of a disk, and of a ring, which has no face, in radii; those of the equations have none. */
const THICKNESS = { disk: 0.012, ring: 0.03 };

/** Inner radius of the widest ring that is drawn, in radii: a hoop has no width. */
const WIDEST = 0.9;

/**
 * Return the inner radius, in radii, of the ring with a moment of inertia; 0 for a full disk.
 * @param {number} alpha
 */
function innerRadius(alpha) {
  // a ring from a R to R has (1 + a^2) / 2
  return Math.min(Math.sqrt(Math.max(2 * alpha - 1, 0)), WIDEST);
}

/**
 * @param {number} radius
 * @param {number} alpha  moment of inertia over m R^2
 * @param {string} rimColour
 * @returns {Group}
 */
export function diskBody(radius, alpha, rimColour) {
  const body = new Group();
  const inner = innerRadius(alpha) * radius;
  const half = (inner > 0 ? THICKNESS.ring : THICKNESS.disk) * radius;
  for (const [side, colour] of FACES.entries()) {
    const face = new Mesh(new RingGeometry(inner, radius, 128), painted(colour));
    // the second face looks in the opposite direction; its painted radius stays where that of the first is
    if (side === 1) face.rotation.x = Math.PI;
    face.position.z = side === 0 ? half : -half;
    face.castShadow = true;
    body.add(face);
  }
  const profile = [new Vector2(radius, -half), new Vector2(radius, half)];
  if (inner > 0) {
    profile.push(new Vector2(inner, half), new Vector2(inner, -half), new Vector2(radius, -half));
  }
  const rim = new Mesh(
    new LatheGeometry(profile, 128),
    new MeshStandardMaterial({ color: rimColour, roughness: 0.5, side: 2 }),
  );
  rim.rotation.x = Math.PI / 2;
  rim.castShadow = true;
  body.add(rim);
  return body;
}

/** Number of squares along a side of the table, which follows the disk by whole squares. */
const SQUARES = 120;

/** Side of the picture of a square in pixels, and width of its lines. */
const SQUARE_PIXELS = 256;
const LINE = 4;

/** Width of the path, and its height above the table, in radii. */
const WIDTH = 0.035;
const OVER = 0.002;

/** Largest number of points of the path. */
const MOST_POINTS = 20000;

/**
 * Return the largest length of the form 1, 2 or 5 times a power of ten that is not above a given one.
 * @param {number} length
 */
export function niceLength(length) {
  const power = 10 ** Math.floor(Math.log10(length));
  const lead = length / power;
  return (lead >= 5 ? 5 : lead >= 2 ? 2 : 1) * power;
}

/**
 * Return a table of squares. It is drawn before everything on it, and hides nothing.
 * @param {number} side  of a square
 * @param {string} ground
 * @param {string} lines
 */
export function tableOfSquares(side, ground, lines) {
  const context = filled(SQUARE_PIXELS, ground);
  context.strokeStyle = lines;
  context.lineWidth = LINE;
  context.strokeRect(0, 0, SQUARE_PIXELS, SQUARE_PIXELS);
  const map = textureOf(context);
  map.wrapS = map.wrapT = RepeatWrapping;
  map.repeat.set(SQUARES, SQUARES);
  const table = new Mesh(
    new PlaneGeometry(SQUARES * side, SQUARES * side),
    new MeshBasicMaterial({ map, depthWrite: false }),
  );
  table.renderOrder = -2;
  return table;
}

/** The path as a ribbon on the table: strong where the disk has been, faint elsewhere. */
export class Trail {
  /**
   * @param {Float64Array} times
   * @param {Float64Array} x  of the contact point
   * @param {Float64Array} y
   * @param {number} radius
   * @param {string} colour
   */
  constructor(times, x, y, radius, colour) {
    const every = Math.ceil(times.length / MOST_POINTS);
    const chosen = Array.from({ length: Math.ceil(times.length / every) }, (_, i) => i * every);
    if (chosen[chosen.length - 1] !== times.length - 1) chosen.push(times.length - 1);
    this.times = Float64Array.from(chosen, (i) => times[i]);
    const geometry = ribbon(chosen, x, y, 0.5 * WIDTH * radius, OVER * radius);
    this.passed = new Mesh(geometry, flat(colour, 1));
    this.whole = new Mesh(geometry.clone(), flat(colour, 0.22));
    this.whole.renderOrder = 1;
    this.passed.renderOrder = 2;
  }

  /** @param {number} time */
  setTime(time) {
    // find the samples up to the time by bisection; the triangles of a segment start at the sample before it
    let [low, high] = [0, this.times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    this.passed.geometry.setDrawRange(0, 6 * Math.max(low - 1, 0));
  }
}

/**
 * @param {string} colour
 * @param {number} opacity
 */
function flat(colour, opacity) {
  return new MeshBasicMaterial({
    color: colour,
    opacity,
    transparent: true,
    side: DoubleSide,
    depthWrite: false,
  });
}

/**
 * @param {number[]} chosen  indices of the samples
 * @param {Float64Array} x
 * @param {Float64Array} y
 * @param {number} half  width
 * @param {number} height
 */
function ribbon(chosen, x, y, half, height) {
  const corners = new Float32Array(6 * chosen.length);
  const triangles = new Uint32Array(6 * Math.max(chosen.length - 1, 0));
  let [ux, uy] = [1, 0];
  chosen.forEach((sample, i) => {
    const before = chosen[Math.max(i - 1, 0)];
    const after = chosen[Math.min(i + 1, chosen.length - 1)];
    const [dx, dy] = [x[after] - x[before], y[after] - y[before]];
    const length = Math.hypot(dx, dy);
    if (length > 0) [ux, uy] = [dx / length, dy / length];
    corners.set([x[sample] - half * uy, y[sample] + half * ux, height], 6 * i);
    corners.set([x[sample] + half * uy, y[sample] - half * ux, height], 6 * i + 3);
    if (i > 0) triangles.set([2 * i - 2, 2 * i - 1, 2 * i, 2 * i, 2 * i - 1, 2 * i + 1], 6 * i - 6);
  });
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(corners, 3));
  geometry.setIndex(new BufferAttribute(triangles, 1));
  return geometry;
}
