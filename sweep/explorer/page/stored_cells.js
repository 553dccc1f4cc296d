/** The cells of an atlas that a page holds, and which of them a pixel shows. */

import { pixelValue } from "eulerdisk/axis_window";

/** @typedef {import("eulerdisk/types").Axis} Axis */
/** @typedef {import("eulerdisk/types").PackedArray} PackedArray */

/**
 * Array of its compressed bytes.
 * @param {PackedArray} packed
 * @returns {Promise<Float32Array|Float64Array|Uint8Array>}
 */
export async function unpackedArray({ type, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const inflated = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(inflated).arrayBuffer();
  return new { f4: Float32Array, f8: Float64Array, u1: Uint8Array }[type](buffer);
}

/**
 * Which cell each pixel of a side of the window shows: the nearest one, -1 farther out than half a cell.
 * @param {Axis} axis
 * @param {number} count  of pixels
 * @param {ArrayLike<number>} values  of the cells, in order
 * @param {boolean} log  whether cells are wide in proportion to their values
 * @returns {Int32Array}
 */
export function cellsOf(axis, count, values, log) {
  const at = (/** @type {number} */ value) => (log ? Math.log(value) : value);
  const places = Array.from(values, at);
  return Int32Array.from({ length: count }, (_, pixel) =>
    nearest(places, at(pixelValue(axis, pixel, count))),
  );
}

/**
 * Index of the nearest place; -1 if none is within half a cell.
 * @param {number[]} places  in order, rising or falling
 * @param {number} wanted
 */
export function nearest(places, wanted) {
  const last = places.length - 1;
  if (last < 1) return 0;
  const rising = places[last] > places[0];
  let [low, high] = [0, last];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (places[middle] <= wanted === rising) low = middle;
    else high = middle;
  }
  const found = Math.abs(places[low] - wanted) <= Math.abs(places[high] - wanted) ? low : high;
  const cell = Math.abs(places[high] - places[low]);
  return Math.abs(places[found] - wanted) <= (cell / 2) * (1 + 1e-9) ? found : -1;
}
