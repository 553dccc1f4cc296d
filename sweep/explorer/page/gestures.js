/** Gestures on a map: wheel, drag, pinch, click, double click and keys, with places from -1 to 1. */

/** @import { Plot } from "eulerdisk/overlay" */
/** @typedef {[number, number]} Place */

/**
 * The actions of a map. `zoom` below 1 zooms in; a place that is null leaves its axis unchanged. `move` is in places.
 * @typedef {object} Deeds
 * @property {(factor: number, across: number|null, up: number|null) => void} zoom
 * @property {(across: number, up: number) => void} move
 * @property {(place: Place, second: boolean, tapped: boolean) => void} choose  `tapped`: by touch, not by a key
 * @property {(place: Place|null) => void} hover
 * @property {(chosen: boolean) => void} reset  `chosen`: by a double click whose first click chose a start
 */

/** Largest movement of a pointer during a click, in CSS pixels. */
const STILL = 5;

/** Zoom per line of a wheel, and per key press. */
const [LINE, KEY] = [0.05, 0.7];

export class Gestures {
  #element;
  #plot;
  #deeds;
  /** @type {Map<number, {x: number, y: number}>} pointers that are down */
  #down = new Map();
  #moved = false;
  /** Whether the last first click chose a start. */
  #chose = false;

  /**
   * @param {HTMLElement} element
   * @param {() => Plot} plot
   * @param {Deeds} deeds
   */
  constructor(element, plot, deeds) {
    this.#element = element;
    this.#plot = plot;
    this.#deeds = deeds;
    element.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    element.addEventListener("pointerdown", (event) => this.#press(event));
    element.addEventListener("pointermove", (event) => this.#drag(event));
    element.addEventListener("pointerup", (event) => this.#down.delete(event.pointerId));
    element.addEventListener("pointercancel", (event) => this.#down.delete(event.pointerId));
    element.addEventListener("click", (event) => this.#click(event));
    element.addEventListener("pointerleave", () => deeds.hover(null));
    element.addEventListener("dblclick", () => deeds.reset(this.#chose));
  }

  /**
   * Return the place of a point on the screen.
   * @param {{x: number, y: number}} point
   * @returns {Place}
   */
  #place({ x, y }) {
    const box = this.#element.getBoundingClientRect();
    const { left, top, width, height } = this.#plot();
    return [(2 * (x - box.left - left)) / width - 1, 1 - (2 * (y - box.top - top)) / height];
  }

  /** @param {WheelEvent} event */
  #wheel(event) {
    event.preventDefault();
    const lines =
      event.deltaMode === 0 ? event.deltaY / 40 : event.deltaMode === 1 ? event.deltaY : event.deltaY * 20;
    // browsers report a pinch on a touchpad as a wheel with the control key, in small steps
    const strength = event.ctrlKey ? 8 : 1;
    const [across, up] = this.#place(event);
    // over the labels of one axis, zoom only that axis
    const besides = { x: up < -1, y: across < -1 };
    const factor = Math.exp(Math.min(Math.max(lines * LINE * strength, -1), 1));
    this.#deeds.zoom(factor, besides.y ? null : across, besides.x ? null : up);
  }

  /** @param {PointerEvent} event */
  #press(event) {
    if (event.button !== 0) return;
    if (this.#down.size === 0) this.#moved = false;
    this.#down.set(event.pointerId, { x: event.clientX, y: event.clientY });
    this.#element.setPointerCapture(event.pointerId);
  }

  /** @param {PointerEvent} event */
  #drag(event) {
    const now = { x: event.clientX, y: event.clientY };
    const before = this.#down.get(event.pointerId);
    if (!before) {
      this.#hover(now);
      return;
    }
    const [across, up] = [now.x - before.x, now.y - before.y].map(Math.abs);
    // the browser is about to scroll
    const scrolls = event.pointerType === "touch" && this.#down.size === 1 && up >= across;
    if (!this.#moved && (scrolls || Math.hypot(across, up) < STILL)) return;
    this.#moved = true;
    const other = [...this.#down].find(([id]) => id !== event.pointerId)?.[1];
    if (other) this.#pinch(other, before, now);
    else {
      const [from, to] = [this.#place(before), this.#place(now)];
      this.#deeds.move(from[0] - to[0], from[1] - to[1]);
    }
    this.#down.set(event.pointerId, now);
  }

  /**
   * @param {{x: number, y: number}} other
   * @param {{x: number, y: number}} before
   * @param {{x: number, y: number}} now
   */
  #pinch(other, before, now) {
    /** @param {{x: number, y: number}} one */
    const middle = (one) => this.#place({ x: (one.x + other.x) / 2, y: (one.y + other.y) / 2 });
    /** @param {{x: number, y: number}} one */
    const distance = (one) => Math.max(Math.hypot(one.x - other.x, one.y - other.y), 1);
    const [from, to] = [middle(before), middle(now)];
    this.#deeds.move(from[0] - to[0], from[1] - to[1]);
    this.#deeds.zoom(distance(before) / distance(now), to[0], to[1]);
  }

  /** @param {MouseEvent} event */
  #click(event) {
    // the second click of a double click chooses nothing
    if (event.detail > 1) return;
    const place = this.#place(event);
    this.#chose = !this.#moved && inside(place);
    if (this.#chose) this.#deeds.choose(place, event.shiftKey, true);
  }

  /** @param {{x: number, y: number}} point */
  #hover(point) {
    const place = this.#place(point);
    this.#deeds.hover(inside(place) ? place : null);
  }
}

/** @param {Place} place */
function inside([across, up]) {
  return Math.abs(across) <= 1 && Math.abs(up) <= 1;
}

/**
 * A cell cursor moved by keys: arrows move it by a cell, and at the border move the window; + and - zoom about it.
 * @typedef {{get: () => Place, set: (place: Place) => void, cell: () => Place}} Cursor
 */

/**
 * Listen to the keys of a map.
 * @param {HTMLElement} element
 * @param {Deeds} deeds
 * @param {Cursor} cursor
 */
export function listenToKeys(element, deeds, cursor) {
  element.addEventListener("keydown", (event) => {
    if (event.altKey || event.metaKey || event.ctrlKey) return;
    const [across, up] = cursor.get();
    const [wide, high] = cursor.cell();
    const much = event.shiftKey ? 8 : 1;
    /** @type {Record<string, () => void>} */
    const keys = {
      ArrowLeft: () => step(deeds, cursor, -wide * much, 0),
      ArrowRight: () => step(deeds, cursor, wide * much, 0),
      ArrowUp: () => step(deeds, cursor, 0, high * much),
      ArrowDown: () => step(deeds, cursor, 0, -high * much),
      "+": () => deeds.zoom(KEY, across, up),
      "=": () => deeds.zoom(KEY, across, up),
      "-": () => deeds.zoom(1 / KEY, across, up),
      0: () => deeds.reset(false),
      Enter: () => deeds.choose([across, up], event.shiftKey, false),
    };
    const deed = keys[event.key];
    if (!deed) return;
    event.preventDefault();
    deed();
  });
}

/**
 * @param {Deeds} deeds
 * @param {Cursor} cursor
 * @param {number} across
 * @param {number} up
 */
function step(deeds, cursor, across, up) {
  const [from, height] = cursor.get();
  const to = [from + across, height + up];
  const kept = to.map((place) => Math.min(Math.max(place, -1), 1));
  if (kept[0] !== to[0] || kept[1] !== to[1]) deeds.move(to[0] - kept[0], to[1] - kept[1]);
  cursor.set([kept[0], kept[1]]);
}
