/** The picture of a map: the newest window as colours, drawn where it lies in the present view. */

import { between } from "eulerdisk/axis_window";
import { paint, rangeFor } from "eulerdisk/colours";

/** @typedef {import("eulerdisk/types").Quantity} Quantity */
/** @typedef {import("eulerdisk/types").View} View */
/** @typedef {import("eulerdisk/types").WindowAnswer} WindowAnswer */
/** @typedef {import("eulerdisk/colours").Range} Range */

/**
 * What the picture shows at a place; of the origin "none" there is neither value nor verdict.
 * @typedef {{value: number, verdict: number, origin: "computed"|"stored"|"none"}} Seen
 */

/** @type {Seen["origin"][]} by the codes of a window */
const ORIGINS = ["computed", "stored", "none"];

export class Picture {
  /** The element that shows it; its size is in pixels of the device. */
  canvas = document.createElement("canvas");
  /** @type {View|null} */
  view = null;
  /** @type {WindowAnswer|null} */
  answer = null;
  /** @type {Quantity|null} */
  quantity = null;
  /** @type {Range} */
  range = { low: 0, high: 1, scale: "linear" };
  #colours = document.createElement("canvas");

  /**
   * Take the newest window.
   * @param {View} view
   * @param {Quantity} quantity
   * @param {WindowAnswer} answer
   * @param {[number, number]|null} held  ends of the colours; null fits them to the window
   */
  take(view, quantity, answer, held) {
    [this.view, this.quantity, this.answer] = [view, quantity, answer];
    this.colour(held);
  }

  /** Show nothing until the next window. */
  drop() {
    this.view = this.answer = this.quantity = null;
    this.range = { low: 0, high: 1, scale: "linear" };
  }

  /**
   * Colour the window anew.
   * @param {[number, number]|null} held
   */
  colour(held) {
    if (!this.answer || !this.quantity) return;
    const { width, height, value, head } = this.answer;
    this.range = held
      ? rangeFor(this.quantity, held[0], held[1])
      : rangeFor(this.quantity, head.low, head.high);
    if (this.#colours.width !== width || this.#colours.height !== height) {
      this.#colours.width = width;
      this.#colours.height = height;
    }
    const image = new ImageData(width, height);
    paint(new Uint32Array(image.data.buffer), value, width, height, this.quantity, this.range);
    context(this.#colours).putImageData(image, 0, 0);
  }

  /**
   * Draw it where it lies in a view. A window of other axes fills the view until its own comes.
   * @param {View} view
   * @param {number} width  in pixels of the device
   * @param {number} height
   */
  draw(view, width, height) {
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const drawing = context(this.canvas);
    drawing.clearRect(0, 0, width, height);
    if (!this.answer || !this.view) return;
    const x = between(this.view.x, view.x) ?? [1, 0];
    const y = between(this.view.y, view.y) ?? [1, 0];
    // cells stay cells: pixels that are larger than those of the screen are not smoothed, unless they are a preview
    drawing.imageSmoothingEnabled = this.answer.stored === null;
    const [left, right] = [x[1] - x[0], x[1] + x[0]].map((place) => ((place + 1) / 2) * width);
    const [bottom, top] = [y[1] - y[0], y[1] + y[0]].map((place) => ((1 - place) / 2) * height);
    drawing.drawImage(this.#colours, left, top, right - left, bottom - top);
  }

  /**
   * Value, verdict and origin at places of the present view, from the window that is shown; null outside of it.
   * @param {View} view
   * @param {number} across  place along x
   * @param {number} up  place along y
   * @returns {Seen|null}
   */
  at(view, across, up) {
    if (!this.answer || !this.view) return null;
    const x = between(view.x, this.view.x);
    const y = between(view.y, this.view.y);
    if (!x || !y) return null;
    const { width, height, value, verdict, stored } = this.answer;
    const column = Math.floor(((x[1] + x[0] * across + 1) / 2) * width);
    const row = Math.floor(((y[1] + y[0] * up + 1) / 2) * height);
    if (column < 0 || row < 0 || column >= width || row >= height) return null;
    const index = row * width + column;
    return {
      value: value[index],
      verdict: verdict[index],
      origin: stored === null ? "computed" : ORIGINS[stored[index]],
    };
  }

  /** Whether the window holds stored cells, and computed ones. */
  origins() {
    const stored = this.answer?.stored ?? null;
    if (!stored) return { stored: false, computed: true };
    return { stored: stored.includes(1), computed: stored.includes(0) };
  }
}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
function context(canvas) {
  const found = canvas.getContext("2d");
  if (!found) throw new Error("This browser cannot draw on a canvas.");
  return found;
}
