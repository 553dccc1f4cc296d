/** The search for the place of each region's name: where it has most room, clear of lines and marks, as in figures. */

/** CSS pixels between two points of the raster on which places are sought. */
const STEP = 6;

/**
 * A raster of points on a plot, and which of them text must not cover.
 * @typedef {{columns: number, rows: number, covered: Uint8Array}} Raster
 */

/**
 * @param {number} width  of the plot in CSS pixels
 * @param {number} height
 * @param {[number, number][][]} lines  polylines in pixels of the plot
 * @param {[number, number][]} marks  centres of the marks of starts, each 24 pixels wide
 * @returns {Raster}
 */
export function rasterOf(width, height, lines, marks) {
  const [columns, rows] = [Math.floor(width / STEP), Math.floor(height / STEP)];
  const covered = new Uint8Array(columns * rows);
  const cover = (/** @type {number} */ x, /** @type {number} */ y) => {
    const [column, row] = [Math.floor(x / STEP), Math.floor(y / STEP)];
    if (column >= 0 && row >= 0 && column < columns && row < rows) covered[row * columns + column] = 1;
  };
  for (const line of lines) {
    line.slice(1).forEach((end, i) => {
      const [x, y] = line[i];
      const [across, down] = [end[0] - x, end[1] - y];
      const count = Math.ceil((2 * Math.hypot(across, down)) / STEP) + 1;
      for (let each = 0; each <= count; each += 1) {
        cover(x + (each / count) * across, y + (each / count) * down);
      }
    });
  }
  for (const [x, y] of marks) {
    for (let across = -12; across <= 12; across += STEP) {
      for (let down = -12; down <= 12; down += STEP) cover(x + across, y + down);
    }
  }
  return { columns, rows, covered };
}

/**
 * Return the codes of the regions at the points of a raster.
 * @param {Raster} raster
 * @param {(across: number, up: number) => number|null} codeAt  places from -1 to 1
 * @returns {(number|null)[]}
 */
export function codesOf({ columns, rows }, codeAt) {
  return Array.from({ length: columns * rows }, (_, i) => {
    const [column, row] = [i % columns, Math.floor(i / columns)];
    return codeAt((2 * column + 1) / columns - 1, 1 - (2 * row + 1) / rows);
  });
}

/**
 * Return the centre [pixels] of the place where a word has most room in a region; null if it does not fit.
 * @param {Raster} raster
 * @param {(number|null)[]} codes
 * @param {number} code  of the region
 * @param {[number, number]} size  of the word in pixels
 * @returns {[number, number]|null}
 */
export function roomiest({ columns, rows, covered }, codes, code, size) {
  // with sums over rectangles from the upper left corner, one step decides whether a box is free
  const sums = new Int32Array((columns + 1) * (rows + 1));
  for (let row = 0; row < rows; row += 1) {
    for (let column = 0; column < columns; column += 1) {
      const at = row * (columns + 1) + column;
      const taken = codes[row * columns + column] !== code || covered[row * columns + column] ? 1 : 0;
      sums[at + columns + 2] = taken + sums[at + 1] + sums[at + columns + 1] - sums[at];
    }
  }
  const sum = (/** @type {number} */ column, /** @type {number} */ row) => sums[row * (columns + 1) + column];
  const [wide, high] = size.map((each) => Math.ceil((each / 2 + STEP) / STEP));
  /** Return whether a box of half-width x around a place is free; then all smaller ones are free too. */
  const fits = (/** @type {number} */ x, /** @type {number} */ column, /** @type {number} */ row) => {
    const y = Math.round((high * x) / wide);
    return (
      column >= x &&
      row >= y &&
      column + x < columns &&
      row + y < rows &&
      sum(column + x + 1, row + y + 1) -
        sum(column - x, row + y + 1) -
        sum(column + x + 1, row - y) +
        sum(column - x, row - y) ===
        0
    );
  };
  /** @type {[number, number][]} */
  let found = [];
  codes.forEach((each, i) => {
    const [column, row] = [i % columns, Math.floor(i / columns)];
    if (each === code && fits(wide, column, row)) found.push([column, row]);
  });
  for (let [most, none] = [wide, columns]; none - most > 1;) {
    const x = Math.floor((most + none) / 2);
    const roomier = found.filter(([column, row]) => fits(x, column, row));
    if (roomier.length) [found, most] = [roomier, x];
    else none = x;
  }
  if (!found.length) return null;
  // of places with equal room, take the one in their middle
  const [middle, height] = [0, 1].map((which) => found.reduce((all, each) => all + each[which], 0));
  const apart = (/** @type {number[]} */ [column, row]) =>
    Math.hypot(column - middle / found.length, row - height / found.length);
  const [column, row] = found.reduce((best, each) => (apart(each) < apart(best) ? each : best));
  return [(column + 0.5) * STEP, (row + 0.5) * STEP];
}
