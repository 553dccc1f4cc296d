/**
 * The meridian of a body of revolution, as in kernels/bodies/shapes.py; all lengths are in units of the outer radius.
 */

/** @import { BodyOfMotion } from "eulerdisk/types" */

/** Number of the torus. */
export const TORUS = 0;

/**
 * Return core, shift, edge and square of the arc of a body; see kernels/bodies/shapes.py.
 * @param {string} name
 * @param {Record<string, number>} cell  every parameter
 * @returns {{core: number, shift: number, edge: number, square: number}}
 */
function arcOf(name, { tube, thickness, fillet, offset, flattening, tilt }) {
  if (name === "torus") return { core: 1 - tube, shift: 0, edge: tube, square: 1 };
  if (name === "rounded") return { core: 1 - 0.5 * thickness, shift: 0, edge: 0.5 * thickness, square: 1 };
  if (name === "rim") {
    const shift = 0.5 * thickness - fillet;
    return { core: 1 - fillet, shift: tilt < 0 ? -shift : shift, edge: fillet, square: 1 };
  }
  if (name === "arc") return { core: 1 - fillet, shift: offset, edge: fillet, square: 1 };
  return { core: 0, shift: offset, edge: 1, square: name === "ball" ? 1 : (1 - flattening) ** 2 };
}

/**
 * Return the body of a motion.
 * @param {{name: string, called: string}} plan
 * @param {Record<string, number>} cell
 * @returns {BodyOfMotion}
 */
export function bodyOf({ name, called }, cell) {
  return {
    name,
    called,
    ...arcOf(name, cell),
    axial: cell.axial_moment,
    transverse: cell.transverse_moment,
  };
}

/**
 * Return the start of a thin disk as that of a torus without a tube, whose moments are alpha and half of it, in the order
 * of kernels/bodies/arrays.py.
 * @param {Record<string, number>} cell  every parameter
 */
export function torusOf({ tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity }) {
  const lengths = [0, 0, 0, 0, 0];
  return [tilt, tilt_rate, precession_rate, roll_rate, ...lengths, alpha, 0.5 * alpha, radius, gravity];
}
