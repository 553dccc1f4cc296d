/**
 * Where the disk is in space, from its angles: x and y on the table, z upward.
 *
 * At heading 0 the disk rolls along y, and a positive tilt leans it towards x. The painted radius points to the contact
 * point at roll angle 0.
 */

/** @typedef {[number, number, number]} Vector */

/**
 * `painted` is the unit vector along the painted radius, `aside` the one a quarter of a turn from it, `axis` that of the
 * disk: right-handed, in this order. `across` and `along` are the horizontal directions across and along the track.
 * @typedef {{centre: Vector, contact: Vector, painted: Vector, aside: Vector, axis: Vector, across: Vector, along: Vector}} Pose
 */

/**
 * @param {number} tilt
 * @param {number} heading
 * @param {number} rollAngle
 * @param {number} x  of the contact point
 * @param {number} y
 * @param {number} radius
 * @returns {Pose}
 */
export function poseOf(tilt, heading, rollAngle, x, y, radius) {
  /** @type {Vector} */
  const across = [Math.cos(heading), Math.sin(heading), 0];
  /** @type {Vector} */
  const along = [-Math.sin(heading), Math.cos(heading), 0];
  const down = combined(-Math.sin(tilt), across, -Math.cos(tilt), [0, 0, 1]);
  const painted = combined(Math.cos(rollAngle), down, -Math.sin(rollAngle), along);
  const aside = combined(Math.sin(rollAngle), down, Math.cos(rollAngle), along);
  return {
    centre: combined(1, [x, y, 0], -radius, down),
    contact: [x, y, 0],
    painted,
    aside,
    axis: crossed(painted, aside),
    across,
    along,
  };
}

/**
 * @param {number} a
 * @param {Vector} u
 * @param {number} b
 * @param {Vector} v
 * @returns {Vector}
 */
function combined(a, u, b, v) {
  return [a * u[0] + b * v[0], a * u[1] + b * v[1], a * u[2] + b * v[2]];
}

/**
 * @param {Vector} u
 * @param {Vector} v
 * @returns {Vector}
 */
function crossed(u, v) {
  return [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
}
