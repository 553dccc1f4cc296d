/** What the colours of a number do not say: which cells are undecided, and where stable and unstable ones meet. */

import { channels, GREY, packed } from "eulerdisk/colours";

/** Codes of verdicts, and what is painted. */
const [UNDECIDED, STABLE, UNSTABLE] = [0, 1, 2];
const [OPEN, BORDER] = [packed(channels(GREY)), packed([0, 0, 0])];

/**
 * As in sweep/figures/borders.py: cells to each side among which borders are counted, how many of them for a cell are
 * crowded, and how many of the eight neighbours of a cell share its verdict where a line beside it is not one around a dot.
 */
const REACH = 3;
const CROWDED = 0.4;
const LEAST_ALIKE = 3;

/** Pixels of a picture from which on its borders are lines. */
const FINE = 200;

/**
 * Codes of verdicts in rows from the bottom upward; `side` is the length of a cell in pixels.
 * @typedef {{verdict: ArrayLike<number>, width: number, height: number, side: number}} Cells
 */

/**
 * Paint undecided cells grey and, if asked for, the borders between stable and unstable ones, but not where these alternate.
 * @param {Uint32Array} pixels  rows from the top downward
 * @param {{value: ArrayLike<number>, verdict: ArrayLike<number>, width: number, height: number}} answer  rows from the
 *   bottom upward; where the value is NaN there is no cell
 * @param {boolean} hasBorders
 * @returns {boolean}  whether some cell is undecided
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
 * Places of the pixels on borders that are drawn.
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
  // a border is as long as the cell beside it
  const most = (CROWDED * (2 * reach + 1) ** 2) / side;
  return Array.from(found.keys()).filter((i) => {
    if (!found[i]) return false;
    const beside = found[i] & 1 ? i + 1 : i + width;
    if (alike(cells, i) < LEAST_ALIKE || alike(cells, beside) < LEAST_ALIKE) return false;
    return countAround(found, i, width, height, reach) <= most;
  });
}

/**
 * How many of the eight neighbours of a cell share its verdict; what lies outside does.
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
 * Borders in a square around a pixel.
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
 * Side of a cell in pixels: stored cells are larger than these.
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
