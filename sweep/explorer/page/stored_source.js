/** Where an exported page gets its numbers from: the cells that it holds, and motions that it integrates itself. */

import { storedMotion } from "eulerdisk/motion/stored_motion";
import { baseOf, parameterOf, verdictWords } from "eulerdisk/state";
import { cellsOf, nearest, unpackedArray } from "eulerdisk/stored_cells";
import { wordsOfCell } from "eulerdisk/stored_words";
import { readable } from "eulerdisk/ticks";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Place} Place */
/** @typedef {import("eulerdisk/types").PointAnswer} PointAnswer */
/** @typedef {import("eulerdisk/types").Quantity} Quantity */
/** @typedef {import("eulerdisk/types").Source} Source */
/** @typedef {import("eulerdisk/types").StoredPage} StoredPage */
/** @typedef {import("eulerdisk/types").WindowAnswer} WindowAnswer */

/** @typedef {Float32Array|Float64Array|Uint8Array} Values */

/** Digits of numbers that are told, and as many as an array in single precision has. */
const DIGITS = 8;
const SINGLE_DIGITS = 7;

/** Said of a place that the page has no cell for. */
const NO_MOTION =
  "An exported page has no motions of a disk with losses: eulerdisk explore shows them, of the same atlas.";
const NO_CELL = "No cell here.";

/** What the page holds cannot be read. */
class Unreadable extends Error {
  hint =
    "The file is damaged, or this browser is too old: export the page once more, or open it in a newer browser.";

  /** @param {any} cause */
  constructor(cause) {
    super(`The cells that this page holds cannot be read: ${cause?.message ?? cause}.`, { cause });
  }
}

/** @implements {Source} */
export class StoredSource {
  live = false;
  command = null;
  data = null;
  reach = null;
  #page;
  #x;
  #y;
  #cells;

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
  }

  /**
   * Source of what a page holds.
   * @param {string} text  JSON
   * @throws {Unreadable}
   */
  static async read(text) {
    return StoredSource.#unpacked(text).catch((cause) => {
      throw new Unreadable(cause);
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
   * @param {import("eulerdisk/types").WindowRequest} request
   * @returns {Promise<WindowAnswer>}
   */
  async window({ view, width, height, quantity }) {
    const begun = performance.now();
    const { columns, rows } = this.#indices(view, width, height);
    const count = width * height;
    const [value, verdict] = [new Float32Array(count).fill(NaN), new Uint8Array(count)];
    const stored = new Uint8Array(count).fill(2);
    const [cells, verdicts] = [this.#cells[quantity], this.#cells.verdict];
    let [low, high] = [Infinity, -Infinity];
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
      }
    }
    const seconds = (performance.now() - begun) / 1000;
    const range = low <= high ? { low, high } : { low: null, high: null };
    const head = { ...range, seconds, end: false, note: this.#resolution(columns, rows) };
    return { head, width, height, value, verdict, stored };
  }

  /** @returns {Promise<import("eulerdisk/types").Line[]>} */
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
    const { atlas } = this.#page.about;
    return [nearestTo(this.#x, x, atlas?.x.scale), nearestTo(this.#y, y, atlas?.y.scale)];
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
   * @param {Place} place
   * @returns {Promise<import("eulerdisk/motion/types").MotionAnswer>}
   */
  async motion(place) {
    const { motions } = this.#page;
    if (!motions) throw new Error(NO_MOTION);
    const { start, note } = await this.point(place);
    if (note) throw new Error(note);
    const values = Object.fromEntries(Object.entries(start).map(([name, { value }]) => [name, value]));
    const { view } = place;
    const title = [view.x, view.y].map(({ name }) => `${name.replaceAll("_", " ")} ${start[name].text}`);
    return storedMotion(/** @type {any} */ (values), motions, title.join(", "));
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
   * @param {import("eulerdisk/types").View} view
   * @param {number} width
   * @param {number} height
   */
  #indices(view, width, height) {
    const { atlas } = this.#page.about;
    const columns = cellsOf(view.x, width, this.#x, atlas?.x.scale === "log");
    const rows = cellsOf(view.y, height, this.#y, atlas?.y.scale === "log");
    return { columns, rows };
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
 * @param {Values} values
 * @param {number} wanted
 * @param {"linear"|"log"} [scale]
 */
function nearestTo(values, wanted, scale) {
  const at = (/** @type {number} */ value) => (scale === "log" ? Math.log(value) : value);
  return nearest(Array.from(values, at), at(wanted));
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
 * What a cell holds, with no more digits than its array has.
 * @param {Quantity} quantity
 * @param {Values} values  of all cells
 * @param {number} index
 */
function toldValue({ flags, factor, unit }, values, index) {
  const value = values[index];
  if (flags) return { value, text: flags[String(value)] ?? String(value) };
  const digits = values instanceof Float32Array ? SINGLE_DIGITS : DIGITS;
  return Number.isFinite(value) ? toldNumber(value, factor, unit, digits) : { value: null, text: "none" };
}
