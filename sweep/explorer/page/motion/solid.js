/**
 * A body of revolution for the scene of a motion: its meridian, as in figures (sweep/figures/disk/solid.py), and
 * meshes.
 */

import { EDGE_COLOUR, FACES, painted, surfacePicture } from "eulerdisk/motion/paint";
import {
  DoubleSide,
  Group,
  LatheGeometry,
  Matrix4,
  Mesh,
  MeshStandardMaterial,
  RingGeometry,
  Vector2,
  Vector3,
} from "three";

/** @import { BodyOfMotion } from "eulerdisk/types" */

/** Number of facets around the axis, and along half a circle of a meridian. */
const AROUND = 144;
const ALONG = 36;

/** Parts of the surface: the side away from which the axis points, the opposite side, or the edge. */
const FRONT = 0;
const BACK = 1;
const EDGE = 2;

/**
 * A point of a meridian in units of the outer radius: its distance from the axis, and its height along the axis above
 * the centre of mass.
 * @typedef {[number, number]} Point
 */

/** @typedef {{points: Point[], shows: number}} Stretch */

/**
 * Return the stretches of a meridian, from the end to which the axis points to the other one.
 * @param {BodyOfMotion} body
 * @returns {Stretch[]}
 */
export function meridianOf({ name, core, shift, edge, square }) {
  if (name === "torus") {
    return [
      { points: arc(core, 0, edge, Math.PI, 0), shows: BACK },
      { points: arc(core, 0, edge, 0, -Math.PI), shows: FRONT },
    ];
  }
  if (name === "ball" || name === "spheroid") {
    const half = (/** @type {number} */ from, /** @type {number} */ to) =>
      arc(0, 0, 1, from, to).map(
        ([a, b]) => /** @type {Point} */ ([Math.max(a, 0), Math.sqrt(square) * b - shift]),
      );
    return [
      { points: half(Math.PI / 2, 0), shows: BACK },
      { points: half(0, -Math.PI / 2), shows: FRONT },
    ];
  }
  // the arc of a rim, on either edge; a single arc continues to the other side
  const middle = name === "arc" ? 0 : Math.abs(shift);
  const upper = edge > 0 ? arc(core, middle, edge, Math.PI / 2, 0) : [/** @type {Point} */ ([core, middle])];
  const lower = upper.map(([a, b]) => /** @type {Point} */ ([a, -b])).reverse();
  const down = name === "arc" ? shift : 0;
  const lowered = (/** @type {Point[]} */ points) =>
    points.map(([a, b]) => /** @type {Point} */ ([a, b - down]));
  const top = upper[0];
  return [
    { points: lowered([[0, top[1]], top]), shows: BACK },
    { points: lowered([...upper, ...lower]), shows: EDGE },
    { points: lowered([[top[0], -top[1]], [0, -top[1]]]), shows: FRONT },
  ]; // prettier-ignore
}

/**
 * @param {number} core
 * @param {number} height
 * @param {number} radius
 * @param {number} from  angle above the plane across the axis
 * @param {number} to
 * @returns {Point[]}
 */
function arc(core, height, radius, from, to) {
  const count = Math.ceil((ALONG * Math.abs(to - from)) / Math.PI);
  return Array.from({ length: count + 1 }, (_, i) => {
    const angle = from + (i / count) * (to - from);
    return [core + radius * Math.cos(angle), height + radius * Math.sin(angle)];
  });
}

/**
 * Return the distance of the farthest point from the centre of mass, in units of the outer radius.
 * @param {BodyOfMotion} body
 */
export function reachOf(body) {
  return Math.max(...meridianOf(body).flatMap(({ points }) => points.map(([a, b]) => Math.hypot(a, b))));
}

/**
 * Return the body, with its centre of mass at 0, its painted direction along x and its axis against z, like the faces
 * of the disk.
 * @param {number} radius
 * @param {BodyOfMotion} body
 * @returns {Group}
 */
export function solidOf(radius, body) {
  const group = new Group();
  for (const { points, shows } of meridianOf(body)) {
    const isFace = shows !== EDGE && points.length === 2;
    const mesh = isFace ? face(radius, points, shows) : surface(radius, points, shows);
    mesh.castShadow = true;
    group.add(mesh);
  }
  return group;
}

/**
 * @param {number} radius
 * @param {Point[]} points
 * @param {number} shows
 */
function face(radius, points, shows) {
  const outer = Math.max(...points.map(([distance]) => distance));
  const mesh = new Mesh(new RingGeometry(0, radius * outer, AROUND), painted(FACES[shows]));
  if (shows === BACK) mesh.rotation.x = Math.PI;
  mesh.position.z = -radius * points[0][1];
  return mesh;
}

/**
 * @param {number} radius
 * @param {Point[]} points
 * @param {number} shows
 */
function surface(radius, points, shows) {
  const profile = points.map(([distance, height]) => new Vector2(radius * distance, -radius * height));
  const geometry = new LatheGeometry(profile, AROUND);
  // a lathe turns about y, from z to x
  geometry.applyMatrix4(
    new Matrix4().makeBasis(new Vector3(0, 1, 0), new Vector3(0, 0, 1), new Vector3(1, 0, 0)),
  );
  const map = surfacePicture(shows === EDGE ? EDGE_COLOUR : FACES[shows]);
  return new Mesh(geometry, new MeshStandardMaterial({ map, roughness: 0.6, side: DoubleSide }));
}
