/**
 * Window arithmetic along one axis: values, pixels, and zoom with its limit.
 *
 * A place along an axis is a number u from -1 (low end) to 1 (high end); the value there is centre + half * u, or the
 * exponential of that on an axis with the scale "log". Differences from the centre are formed before any division, so
 * that places remain exact in windows of 1e-10 of the value.
 */

/** @import { Axis } from "eulerdisk/types" */

/** Least width of a pixel, in units in the last place of the value. */
const LEAST_ULPS = 8;

/**
 * Return the distance from a double to the next one.
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
 * Return the value at a place.
 * @param {Axis} axis
 * @param {number} place
 */
export function valueAt(axis, place) {
  const at = axis.centre + axis.half * place;
  return axis.scale === "log" ? Math.exp(at) : at;
}

/**
 * Return the place of a value; NaN where a logarithmic axis has none.
 * @param {Axis} axis
 * @param {number} value
 */
export function placeOf(axis, value) {
  const at = axis.scale === "log" ? Math.log(value) : value;
  return (at - axis.centre) / axis.half;
}

/**
 * Return the value in the middle of a pixel, as the server computes it.
 * @param {Axis} axis
 * @param {number} pixel
 * @param {number} count
 */
export function pixelValue(axis, pixel, count) {
  return valueAt(axis, (2 * pixel + 1) / count - 1);
}

/**
 * Return the value with the fewest displayed digits within a pixel of a place.
 * @param {Axis} axis
 * @param {number} place
 * @param {number} count  of pixels
 * @param {number} factor  from values to displayed numbers
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
 * Return both ends of the range, as values.
 * @param {Axis} axis
 * @returns {[number, number]}
 */
export function ends(axis) {
  return [valueAt(axis, -1), valueAt(axis, 1)];
}

/**
 * Return the axis from one value to another; linear where a logarithm is impossible.
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
 * Return the smallest half-width for which pixels have 8 units in the last place.
 * @param {Axis} axis
 * @param {number} pixels
 */
export function leastHalf(axis, pixels) {
  const last = axis.scale === "log" ? Math.max(2 ** -52, ulp(axis.centre)) : ulp(axis.centre);
  return (LEAST_ULPS * last * pixels) / 2;
}

/**
 * Return the axis zoomed by a factor about a place, which keeps its value; a factor below 1 zooms in. The half-width
 * stays between `least` and `most`.
 * @param {Axis} axis
 * @param {number} factor
 * @param {number} place
 * @param {{least: number, most: number}} limits  of the half-width
 * @returns {Axis}
 */
export function zoomed(axis, factor, place, limits) {
  const least = Math.min(limits.least, axis.half);
  const most = Math.max(limits.most, axis.half);
  const half = Math.min(Math.max(axis.half * factor, least), most);
  return { ...axis, centre: axis.centre + place * (axis.half - half), half };
}

/**
 * Return the axis moved by a distance in places; the whole width is 2.
 * @param {Axis} axis
 * @param {number} by
 * @returns {Axis}
 */
export function moved(axis, by) {
  return { ...axis, centre: axis.centre + axis.half * by };
}

/** Largest value on a linear axis, and largest logarithm on a logarithmic one, before numbers overflow. */
const LARGEST = { linear: 1e300, log: 690 };

/**
 * Return the axis moved, and narrowed if necessary, so that it lies within the allowed values and within finite
 * numbers.
 * @param {Axis} axis
 * @param {number|null} least  null if there is no limit
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
 * Return where one axis lies on another one, as [scale, offset] with place there = offset + scale * place here; null if
 * the two have no common coordinate.
 * @param {Axis} from
 * @param {Axis} to
 * @returns {[number, number]|null}
 */
export function between(from, to) {
  if (from.name !== to.name || from.scale !== to.scale) return null;
  return [from.half / to.half, (from.centre - to.centre) / to.half];
}
