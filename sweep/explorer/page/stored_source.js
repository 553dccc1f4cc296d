/** Where an exported page gets its numbers from: the cells that it holds, and motions that it integrates itself. */

import { pixelValue } from "eulerdisk/axis_window";
import { storedMotion } from "eulerdisk/motion/stored_motion";
import { Problem } from "eulerdisk/notice";
import { baseOf, parameterOf, verdictWords } from "eulerdisk/state";
import { readable, printedUnits } from "eulerdisk/ticks";

/** @import { About, Line, MotionAnswer, MotionRequest, PackedArray, Parameter, Place, PointAnswer, Quantity, Source, StoredPage, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/** @typedef {Float32Array|Float64Array|Uint8Array} Values */

/** Digits of numbers that are told: an array in single precision has as many. */
const DIGITS = 6;

const NO_MOTION = "An exported page has motions of the disk without losses alone.";

/** Said of a place that the page has no cell for. */
const NO_CELL = "No cell here.";

/** What to do where the page's own cells cannot be read. */
const UNREADABLE =
  "The file is damaged, or this browser is too old: export the page once more, or open it in a newer browser.";

/** @implements {Source} */
export class StoredSource {
  command = null;
  data = null;
  reach = null;
  #page;
  #x;
  #y;
  #cells;
  /** Where the cells stand along both sides: of a logarithmic one the logarithms of their values. */
  #places;

  /**
   * @param {StoredPage} page
   * @param {Values} x
   * @param {Values} y
   * @param {Record<string, Values>} cells
   */
  constructor(page, x, y, cells) {
    this.#page = page;
    this.#x = x;
    this.#y = y;
    this.#cells = cells;
    const { atlas } = page.about;
    this.#places = { x: placesOf(x, atlas?.x.scale), y: placesOf(y, atlas?.y.scale) };
  }

  /**
   * Source of what a page holds.
   * @param {string} text  JSON
   * @throws {Problem}
   */
  static async read(text) {
    return StoredSource.#unpacked(text).catch((cause) => {
      const words = `The cells that this page holds cannot be read: ${cause?.message ?? cause}.`;
      throw new Problem(words, { hint: UNREADABLE, cause });
    });
  }

  /** @param {string} text */
  static async #unpacked(text) {
    /** @type {StoredPage} */
    const page = JSON.parse(text);
    const names = Object.keys(page.cells);
    const arrays = await Promise.all(
      [page.x, page.y, ...names.map((name) => page.cells[name])].map(unpackedArray),
    );
    const cells = Object.fromEntries(names.map((name, index) => [name, arrays[index + 2]]));
    return new StoredSource(page, arrays[0], arrays[1], cells);
  }

  /** @returns {Promise<About>} */
  async about() {
    return this.#page.about;
  }

  /**
   * @param {WindowRequest} request
   * @returns {Promise<WindowAnswer>}
   */
  async window({ view, width, height, quantity }) {
    const cellsOf = (/** @type {"x"|"y"} */ which, /** @type {number} */ count) =>
      Int32Array.from({ length: count }, (_, i) => this.#places[which](pixelValue(view[which], i, count)));
    const [columns, rows] = [cellsOf("x", width), cellsOf("y", height)];
    const count = width * height;
    const [value, verdict] = [new Float32Array(count).fill(NaN), new Uint8Array(count)];
    const stored = new Uint8Array(count).fill(2);
    const [cells, verdicts] = [this.#cells[quantity], this.#cells.verdict];
    let [low, high, least] = [Infinity, -Infinity, Infinity];
    for (let row = 0; row < height; row += 1) {
      if (rows[row] < 0) continue;
      for (let column = 0; column < width; column += 1) {
        if (columns[column] < 0) continue;
        const from = rows[row] * this.#x.length + columns[column];
        const found = cells[from];
        value[row * width + column] = found;
        verdict[row * width + column] = verdicts[from];
        stored[row * width + column] = 1;
        if (found < low) low = found;
        if (found > high) high = found;
        if (found > 0 && found < least) least = found;
      }
    }
    const known = (/** @type {number} */ each) => (Number.isFinite(each) ? each : null);
    const range = { low: known(low), high: known(high), least: known(least) };
    const head = { ...range, end: false, note: this.#resolution(columns, rows) };
    return { head, width, height, value, verdict, stored };
  }

  /** @returns {Promise<Line[]>} */
  async lines() {
    return this.#page.lines;
  }

  /**
   * Values of the cell nearest to a point, of which all that is shown of the point is told; null where there is none.
   * @param {{x: number, y: number}} point
   */
  cellAt(point) {
    const [column, row] = this.#nearestTo(point);
    return column < 0 || row < 0 ? null : { x: this.#x[column], y: this.#y[row] };
  }

  /**
   * Numbers of the cell along both sides; -1 where there is none.
   * @param {{x: number, y: number}} point
   */
  #nearestTo({ x, y }) {
    return [this.#places.x(x), this.#places.y(y)];
  }

  /**
   * @param {Place} place
   * @returns {Promise<PointAnswer>}
   */
  async point({ view, x, y }) {
    const { quantities, parameters } = this.#page.about;
    const [column, row] = this.#nearestTo({ x, y });
    if (column < 0 || row < 0) return { start: {}, numbers: [], verdict: "", stored: null, note: NO_CELL };
    const index = row * this.#x.length + column;
    /** @type {Record<string, number>} */
    const start = { ...this.#page.starts, [view.x.name]: this.#x[column], [view.y.name]: this.#y[row] };
    // rates that every cell computed for itself
    for (const { name } of parameters) if (name in this.#cells) start[name] = this.#cells[name][index];
    const known = parameters.filter(({ name }) => name in start);
    const told = known.map(({ name, factor, unit }) => [name, toldNumber(start[name], factor, unit, DIGITS)]);
    const numbers = quantities
      .filter(({ name }) => name in this.#cells && name !== "stability")
      .map((quantity) => ({
        ...described(quantity),
        ...toldValue(quantity, this.#cells[quantity.name], index),
      }));
    const verdict = verdictWords(this.#page.about, this.#cells.verdict[index]);
    const cell = { start: Object.fromEntries(told), numbers, verdict, stored: null };
    return { ...cell, stored: cell };
  }

  /**
   * The motion of the cell nearest to a place.
   * @param {MotionRequest} place
   * @returns {Promise<MotionAnswer>}
   */
  async motion(place) {
    const { motions } = this.#page;
    if (!motions) throw new Error(NO_MOTION);
    const { start, note } = await this.point(place);
    if (note) throw new Error(note);
    const values = Object.fromEntries(Object.entries(start).map(([name, { value }]) => [name, value]));
    const { view } = place;
    const title = [view.x, view.y].map(({ name }) => `${name.replaceAll("_", " ")} ${start[name].text}`);
    return storedMotion(/** @type {any} */ (values), motions, title.join(", "), place.duration);
  }

  /**
   * @param {Place} place
   * @returns {Promise<string>}
   */
  async explain(place) {
    const { about, lines } = this.#page;
    const numbers = await this.point(place);
    if (numbers.note) return numbers.note;
    const [column, row] = this.#nearestTo(place);
    const { view } = place;
    return wordsOfCell({
      sides: { x: parameterOf(about, view.x.name), y: parameterOf(about, view.y.name) },
      counts: { x: [column + 1, this.#x.length], y: [row + 1, this.#y.length] },
      numbers,
      lines,
      criterion: String(baseOf(about, view).words.criterion ?? ""),
    });
  }

  /**
   * Where the resolution of the file ends, in words, once cells are seen as such.
   * @param {Int32Array} columns
   * @param {Int32Array} rows
   */
  #resolution(columns, rows) {
    const seen = Math.max(new Set(columns).size / columns.length, new Set(rows).size / rows.length);
    return seen < 0.1 ? (this.#page.about.atlas?.note ?? "") : "";
  }
}

/**
 * Function from a value to the number of the cell that it lies in; -1 where there is none.
 * @param {Values} values  of the cells
 * @param {"linear"|"log"} [scale]  whether cells are wide in proportion to their values
 */
function placesOf(values, scale) {
  const at = (/** @type {number} */ value) => (scale === "log" ? Math.log(value) : value);
  const places = Array.from(values, at);
  return (/** @type {number} */ value) => nearest(places, at(value));
}

/** @param {Quantity} quantity */
function described({ name, label, description }) {
  return { name, label, description };
}

/**
 * @param {number} value
 * @param {number} factor
 * @param {string} unit
 * @param {number} digits
 */
function toldNumber(value, factor, unit, digits) {
  return { value, text: `${readable(value * factor, digits)} ${unit}`.trim() };
}

/**
 * What a cell holds.
 * @param {Quantity} quantity
 * @param {Values} values  of all cells
 * @param {number} index
 */
function toldValue({ flags, factor, unit }, values, index) {
  const value = values[index];
  if (flags) return { value, text: flags[String(value)] ?? String(value) };
  return Number.isFinite(value) ? toldNumber(value, factor, unit, DIGITS) : { value: null, text: "none" };
}

/**
 * Array of its compressed bytes.
 * @param {PackedArray} packed
 * @returns {Promise<Float32Array|Float64Array|Uint8Array>}
 */
async function unpackedArray({ type, data }) {
  const bytes = Uint8Array.from(atob(data), (letter) => letter.charCodeAt(0));
  const inflated = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(inflated).arrayBuffer();
  return new { f4: Float32Array, f8: Float64Array, u1: Uint8Array }[type](buffer);
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

/**
 * A cell: where it is in the plane, what it holds, and the parameters and lines of the plane. `counts` has the number of
 * the cell along each side and how many there are.
 * @typedef {object} Cell
 * @property {{x: Parameter, y: Parameter}} sides
 * @property {{x: [number, number], y: [number, number]}} counts
 * @property {PointAnswer} numbers
 * @property {Line[]} lines
 * @property {string} criterion
 */

/** Width of the column of names, and of that of values. */
const NAME = 12;
const VALUE = 22;

/** Digits of a value on a line. */
const LINE_DIGITS = 6;

/**
 * @param {Cell} cell
 * @returns {string}
 */
function wordsOfCell(cell) {
  const { sides, counts, numbers, criterion } = cell;
  const { start } = numbers;
  const told = (/** @type {string} */ name) => printedUnits(start[name].text);
  const place = /** @type {const} */ (["x", "y"]).map((side) => {
    const { name, label } = sides[side];
    return `${label} ${told(name)} (${counts[side].join(" of ")})`;
  });
  const others = Object.keys(start).filter((name) => name !== sides.x.name && name !== sides.y.name);
  const held = numbers.numbers.map(
    ({ name, text, description }) =>
      `  ${name.replaceAll("_", " ").padEnd(NAME + 6)}${printedUnits(text).padEnd(VALUE)}${description}`,
  );
  return [
    row("cell", place.join(", ")),
    row("start", others.map((name) => `${name.replaceAll("_", " ")} ${told(name)}`).join(", ")),
    "",
    ...held,
    "",
    ...boundaryRows(cell),
    row("verdict", criterion ? `${numbers.verdict} by ${criterion}` : numbers.verdict),
  ].join("\n");
}

/**
 * @param {string} name
 * @param {string} text
 */
function row(name, text) {
  return name.padEnd(NAME) + text;
}

/**
 * @param {string} place
 * @param {string} label
 */
function onLine(place, label) {
  return `${printedUnits(place).padEnd(VALUE + 6)} ${label}`;
}

/**
 * Where the lines of the map cross the row of a cell, along the parameter that the boundary is sought along.
 * @param {Cell} cell
 */
function boundaryRows({ sides, numbers, lines }) {
  const along = sides.x.control ? "x" : "y";
  const across = along === "x" ? "y" : "x";
  const { name, label, factor, unit } = sides[along];
  if (!sides[along].control) return [];
  const wanted = numbers.start[sides[across].name].value;
  const order = along === "x" ? [0, 1] : [1, 0];
  const found = lines.flatMap((line) =>
    crossings(line.points, wanted, order).map((value) =>
      onLine(`${label} ${readable(value * factor, LINE_DIGITS)} ${unit}`, line.label),
    ),
  );
  const here = row("", onLine(`${label} ${numbers.start[name].text}`, "this cell"));
  return found.length === 0 ? [] : [...found.map((text, i) => row(i ? "" : "lines", text)), here, ""];
}

/**
 * Values along one side at which polylines have a value along the other.
 * @param {number[][][]} lines
 * @param {number} wanted  value along the other side
 * @param {number[]} order  numbers of both sides in a point
 */
export function crossings(lines, wanted, [along, across]) {
  return lines.flatMap((points) => {
    if (points.length === 1) return points[0][across] === wanted ? [points[0][along]] : [];
    const isClosed = points[0].every((value, side) => value === points[points.length - 1][side]);
    return points.slice(1).flatMap((end, i) => {
      const begin = points[i];
      const [before, after] = [begin[across] - wanted, end[across] - wanted];
      const isLast = i === points.length - 2 && !isClosed;
      // a segment has its first end, so that a point of the line is met once; the last one has both
      if (before === after || before * after > 0 || (after === 0 && !isLast)) return [];
      return [begin[along] + (before / (before - after)) * (end[along] - begin[along])];
    });
  });
}
