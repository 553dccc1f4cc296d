/**
 * Window arithmetic along one axis: values, pixels, zoom and its end.
 *
 * A place along an axis is a number u from -1 (low end) to 1 (high end); the value there is centre + half * u, of an axis
 * with the scale "log" the exponential of that. Differences to the centre are formed before anything is divided, so
 * that places stay exact in windows of 1e-10 of the value.
 */

/** @import { Axis } from "eulerdisk/types" */

/** A pixel may not be narrower than this many units in the last place of the value. */
const LEAST_ULPS = 8;

/**
 * Distance from a double to the next one.
 * @param {number} value
 */
export function ulp(value) {
  const size = Math.abs(value);
  if (size < 2 ** -1022) return 2 ** -1074;
  const exponent = Math.floor(Math.log2(size));
  // log2 may round up to the next power just below it
  return 2 ** ((2 ** exponent > size ? exponent - 1 : exponent) - 52);
}

/**
 * Value at a place.
 * @param {Axis} axis
 * @param {number} place
 */
export function valueAt(axis, place) {
  const at = axis.centre + axis.half * place;
  return axis.scale === "log" ? Math.exp(at) : at;
}

/**
 * Place of a value; NaN where a logarithmic axis has none.
 * @param {Axis} axis
 * @param {number} value
 */
export function placeOf(axis, value) {
  const at = axis.scale === "log" ? Math.log(value) : value;
  return (at - axis.centre) / axis.half;
}

/**
 * Value in the middle of a pixel, as the server computes it.
 * @param {Axis} axis
 * @param {number} pixel
 * @param {number} count
 */
export function pixelValue(axis, pixel, count) {
  return valueAt(axis, (2 * pixel + 1) / count - 1);
}

/**
 * The value with the fewest digits, as people read them, within a pixel of a place.
 * @param {Axis} axis
 * @param {number} place
 * @param {number} count  of pixels
 * @param {number} factor  from values to what people read
 */
export function roundestAt(axis, place, count, factor) {
  const [low, middle, high] = [-1, 0, 1].map((side) => valueAt(axis, place + side / count));
  for (let digits = 1; digits < 17; digits += 1) {
    const value = Number((middle * factor).toPrecision(digits)) / factor;
    if (value >= low && value <= high) return value;
  }
  return middle;
}

/**
 * Both ends of the range, in values.
 * @param {Axis} axis
 * @returns {[number, number]}
 */
export function ends(axis) {
  return [valueAt(axis, -1), valueAt(axis, 1)];
}

/**
 * Axis from one value to another; linear where a logarithm is not possible.
 * @param {string} name
 * @param {number} low
 * @param {number} high
 * @param {"linear"|"log"} scale
 * @returns {Axis}
 */
export function axisBetween(name, low, high, scale) {
  if (scale === "log" && low > 0) {
    const [from, to] = [Math.log(low), Math.log(high)];
    return { name, centre: (from + to) / 2, half: (to - from) / 2, scale };
  }
  return { name, centre: (low + high) / 2, half: (high - low) / 2, scale: "linear" };
}

/**
 * Smallest half that pixels of 8 units in the last place allow.
 * @param {Axis} axis
 * @param {number} pixels
 */
export function leastHalf(axis, pixels) {
  const last = axis.scale === "log" ? Math.max(2 ** -52, ulp(axis.centre)) : ulp(axis.centre);
  return (LEAST_ULPS * last * pixels) / 2;
}

/**
 * Axis zoomed by a factor about a place, which keeps its value: below 1 zooms in. Zoom ends at `least` and at `most`.
 * @param {Axis} axis
 * @param {number} factor
 * @param {number} place
 * @param {{least: number, most: number}} limits  of half
 * @returns {Axis}
 */
export function zoomed(axis, factor, place, limits) {
  const least = Math.min(limits.least, axis.half);
  const most = Math.max(limits.most, axis.half);
  const half = Math.min(Math.max(axis.half * factor, least), most);
  return { ...axis, centre: axis.centre + place * (axis.half - half), half };
}

/**
 * Axis moved by a distance in places: its whole width is 2.
 * @param {Axis} axis
 * @param {number} by
 * @returns {Axis}
 */
export function moved(axis, by) {
  return { ...axis, centre: axis.centre + axis.half * by };
}

/** Largest number of a linear axis, and largest logarithm of a logarithmic one: beyond them lies no number. */
const LARGEST = { linear: 1e300, log: 690 };

/**
 * Axis within the values that are allowed, and those that are numbers: moved, and if it is too wide for them narrowed.
 * @param {Axis} axis
 * @param {number|null} least  null if there is no end
 * @param {number|null} most
 * @returns {Axis}
 */
export function within(axis, least, most) {
  const at = (/** @type {number} */ value) => (axis.scale === "log" ? Math.log(Math.max(value, 0)) : value);
  const largest = LARGEST[axis.scale];
  const low = Math.max(least === null ? -Infinity : at(least), -largest);
  const high = Math.min(most === null ? Infinity : at(most), largest);
  const half = Math.min(axis.half, (high - low) / 2);
  return { ...axis, centre: Math.min(Math.max(axis.centre, low + half), high - half), half };
}

/**
 * Where the ends of one axis lie on another one, as [scale, offset]: place there = offset + scale * place here; null if
 * the two have no common coordinate.
 * @param {Axis} from
 * @param {Axis} to
 * @returns {[number, number]|null}
 */
export function between(from, to) {
  if (from.name !== to.name || from.scale !== to.scale) return null;
  return [from.half / to.half, (from.centre - to.centre) / to.half];
}
