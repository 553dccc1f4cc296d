/** The cells of an atlas in an exported page. */

import { pixelValue } from "eulerdisk/axis_window";
import { unpackedArray } from "eulerdisk/packed";
import { baseOf, verdictWords } from "eulerdisk/state";
import { readable } from "eulerdisk/ticks";

/** @import { Place, PointAnswer, Quantity, StoredPage, View, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/** @typedef {Float32Array|Float64Array|Uint8Array} Values */

/** Digits of displayed numbers: as many as single precision has. */
const DIGITS = 6;

/** Codes of pixels: with a cell of the file, and without one. */
const STORED = 1;
const NO_CELL = 2;

export class StoredCells {
  #page;
  #x;
  #y;
  #cells;
  /** The positions of the cells along both sides; on a logarithmic side, the logarithms of their values. */
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
   * Return the cells of a page; null if it has none.
   * @param {StoredPage} page
   */
  static async read(page) {
    const { stored } = page;
    if (!stored) return null;
    const names = Object.keys(stored.cells);
    const packed = [stored.x, stored.y, ...names.map((name) => stored.cells[name])];
    const [x, y, ...arrays] = await Promise.all(packed.map(unpackedArray));
    return new StoredCells(page, x, y, Object.fromEntries(names.map((name, index) => [name, arrays[index]])));
  }

  /**
   * Return whether a view shows the plane of the cells.
   * @param {View} view
   */
  shows(view) {
    const { about } = this.#page;
    const base = baseOf(about, view).view;
    return view.x.name === base.x.name && view.y.name === base.y.name && Object.keys(view.words).length === 0;
  }

  /**
   * @param {WindowRequest} request
   * @returns {Promise<WindowAnswer|null>}
   */
  async window({ view, width, height, quantity }) {
    const cells = this.#cells[quantity];
    if (!this.shows(view) || !cells) return null;
    const cellsOf = (/** @type {"x"|"y"} */ which, /** @type {number} */ count) =>
      Int32Array.from({ length: count }, (_, i) => this.#places[which](pixelValue(view[which], i, count)));
    const [columns, rows] = [cellsOf("x", width), cellsOf("y", height)];
    const count = width * height;
    const [value, verdict] = [new Float32Array(count).fill(NaN), new Uint8Array(count)];
    const stored = new Uint8Array(count).fill(NO_CELL);
    let [low, high, least] = [Infinity, -Infinity, Infinity];
    for (let row = 0; row < height; row += 1) {
      if (rows[row] < 0) continue;
      for (let column = 0; column < width; column += 1) {
        if (columns[column] < 0) continue;
        const from = rows[row] * this.#x.length + columns[column];
        const found = cells[from];
        value[row * width + column] = found;
        verdict[row * width + column] = this.#cells.verdict[from];
        stored[row * width + column] = STORED;
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

  /**
   * Return the values of the cell nearest to a point; null if there is none.
   * @param {{x: number, y: number}} point
   */
  at({ x, y }) {
    const [column, row] = [this.#places.x(x), this.#places.y(y)];
    return column < 0 || row < 0
      ? null
      : { x: this.#x[column], y: this.#y[row], index: row * this.#x.length + column };
  }

  /**
   * @param {Place} place
   * @returns {Promise<PointAnswer|null>}
   */
  async point(place) {
    const { view } = place;
    const cell = this.shows(view) ? this.at(place) : null;
    if (!cell) return null;
    const { about, stored } = this.#page;
    /** @type {Record<string, number>} */
    const start = { ...stored?.starts, [view.x.name]: cell.x, [view.y.name]: cell.y };
    // rates that the cells computed themselves
    for (const { name } of about.parameters) {
      if (name in this.#cells) start[name] = this.#cells[name][cell.index];
    }
    const known = about.parameters.filter(({ name }) => name in start);
    const told = known.map(({ name, factor, unit }) => [name, toldNumber(start[name], factor, unit, DIGITS)]);
    const numbers = about.quantities
      .filter(({ name }) => name in this.#cells && name !== "stability")
      .map((quantity) => ({
        ...described(quantity),
        ...toldValue(quantity, this.#cells[quantity.name], cell.index),
      }));
    const verdict = verdictWords(about, this.#cells.verdict[cell.index]);
    return { start: Object.fromEntries(told), numbers, verdict, stored: null };
  }

  /**
   * Return a note where the resolution of the file ends, as soon as single cells are visible.
   * @param {Int32Array} columns
   * @param {Int32Array} rows
   */
  #resolution(columns, rows) {
    const seen = Math.max(new Set(columns).size / columns.length, new Set(rows).size / rows.length);
    return seen < 0.1 ? (this.#page.about.atlas?.note ?? "") : "";
  }
}

/**
 * Return a function from a value to the index of its cell, -1 if there is none.
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
 * Return the number or flag of a cell.
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
 * Return the index of the nearest place; -1 if none is within half a cell.
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
