/**
 * Marks that the colours of a number do not show: undecided cells, and the borders between stable and unstable ones.
 */

import { channels, GREY, packed } from "eulerdisk/colours";

/** Codes of verdicts, and the colours that are painted. */
const [UNDECIDED, STABLE, UNSTABLE] = [0, 1, 2];
const [OPEN, BORDER] = [packed(channels(GREY)), packed([0, 0, 0])];

/**
 * As in sweep/figures/borders.py: half the side of the square in which borders are counted [cells], the number of
 * borders per cell from which on they are crowded, and the least number of a cell's eight neighbours that share its
 * verdict, for a line that does not just enclose a dot.
 */
const REACH = 3;
const CROWDED = 0.4;
const LEAST_ALIKE = 3;

/** Least size of a picture [pixels] in which borders are lines. */
const FINE = 200;

/**
 * Codes of verdicts in rows from the bottom upward; `side` is the length of a cell in pixels.
 * @typedef {{verdict: ArrayLike<number>, width: number, height: number, side: number}} Cells
 */

/**
 * Paint undecided cells grey and, if requested, the borders between stable and unstable cells, except where verdicts
 * alternate.
 * @param {Uint32Array} pixels  rows from the top downward
 * @param {{value: ArrayLike<number>, verdict: ArrayLike<number>, width: number, height: number}} answer  rows from the
 * bottom upward; NaN means that there is no cell
 * @param {boolean} hasBorders
 * @returns {boolean}  whether any cell is undecided
 */
export function markVerdicts(pixels, { value, verdict, width, height }, hasBorders) {
  const target = (/** @type {number} */ i) => i + (height - 1 - 2 * Math.floor(i / width)) * width;
  let hasUndecided = false;
  for (let i = 0; i < width * height; i += 1) {
    if (verdict[i] !== UNDECIDED || value[i] !== value[i]) continue;
    pixels[target(i)] = OPEN;
    hasUndecided = true;
  }
  if (hasBorders && width >= FINE) {
    const cells = { verdict, width, height, side: sideOf(value, width, height) };
    for (const i of borders(cells)) pixels[target(i)] = BORDER;
  }
  return hasUndecided;
}

/**
 * Return the indices of the pixels on drawn borders.
 * @param {Cells} cells
 */
function borders(cells) {
  const { verdict, width, height, side } = cells;
  const found = new Uint8Array(width * height);
  const meet = (/** @type {number} */ i, /** @type {number} */ j) =>
    (verdict[i] === STABLE && verdict[j] === UNSTABLE) || (verdict[i] === UNSTABLE && verdict[j] === STABLE);
  for (let i = 0; i < found.length; i += 1) {
    if (i % width < width - 1 && meet(i, i + 1)) found[i] += 1;
    if (i + width < found.length && meet(i, i + width)) found[i] += 2;
  }
  const reach = Math.ceil(REACH * side);
  // a border is as long as the cell next to it
  const most = (CROWDED * (2 * reach + 1) ** 2) / side;
  return Array.from(found.keys()).filter((i) => {
    if (!found[i]) return false;
    const beside = found[i] & 1 ? i + 1 : i + width;
    if (alike(cells, i) < LEAST_ALIKE || alike(cells, beside) < LEAST_ALIKE) return false;
    return countAround(found, i, width, height, reach) <= most;
  });
}

/**
 * Return how many of the eight neighbours of a cell share its verdict; those outside the picture count as sharing it.
 * @param {Cells} cells
 * @param {number} at
 */
function alike({ verdict, width, height, side }, at) {
  const [column, row, step] = [at % width, Math.floor(at / width), Math.round(side)];
  let count = -1;
  for (const down of [-step, 0, step]) {
    for (const across of [-step, 0, step]) {
      const [c, r] = [column + across, row + down];
      if (c < 0 || r < 0 || c >= width || r >= height || verdict[r * width + c] === verdict[at]) count += 1;
    }
  }
  return count;
}

/**
 * Return the number of borders in a square around a pixel.
 * @param {Uint8Array} found  1 for a border to the right, 2 for one above, 3 for both
 * @param {number} at
 * @param {number} width
 * @param {number} height
 * @param {number} reach
 */
function countAround(found, at, width, height, reach) {
  const [column, row] = [at % width, Math.floor(at / width)];
  let count = 0;
  for (let r = Math.max(0, row - reach); r <= Math.min(height - 1, row + reach); r += 1) {
    for (let c = Math.max(0, column - reach); c <= Math.min(width - 1, column + reach); c += 1) {
      const each = found[r * width + c];
      count += (each & 1) + (each >> 1);
    }
  }
  return count;
}

/**
 * Return the side of a cell in pixels: stored cells are larger than a pixel.
 * @param {ArrayLike<number>} value
 * @param {number} width
 * @param {number} height
 */
function sideOf(value, width, height) {
  let most = 0;
  for (let row = 0; row < height; row += Math.max(1, height >> 4)) {
    let changes = 1;
    for (let i = row * width + 1; i < (row + 1) * width; i += 1) changes += Number(value[i] !== value[i - 1]);
    most = Math.max(most, changes);
  }
  return width / Math.max(1, most);
}
