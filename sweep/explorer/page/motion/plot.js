/** A small plot: curves over one axis, marks, and a cursor that can be dragged. */

import { svg } from "eulerdisk/elements";
import { superscript, ticksOf } from "eulerdisk/ticks";

/** @typedef {{low: number, high: number}} Range */

/**
 * A curve in the colour of its class, interrupted by values that are not finite.
 * @typedef {{x: ArrayLike<number>, y: ArrayLike<number>, kind: string, label?: string}} Curve
 */

/**
 * The contents of a plot, in displayed units.
 * @typedef {object} Figure
 * @property {string} title  description for screen readers
 * @property {string} xLabel
 * @property {string} yLabel
 * @property {string} [hint]  explanation of the unit, shown when the pointer rests on the label
 * @property {Range} x
 * @property {Range} y
 * @property {Curve[]} curves
 * @property {{y: number, kind: string}[]} [lines]  horizontal lines
 * @property {{x: number, y: number, kind: string, label: string}[]} [dots]
 * @property {Curve[]} [areas]  filled from the previous curve, the first one from zero
 */

/** Margins around the curves, in pixels. */
const ROOM = { left: 54, right: 10, top: 20, bottom: 34 };

/** Margin beyond the largest and the smallest value, as a share of their difference. */
const MARGIN = 0.07;

/** Height of a line of text above the curves, approximate width of a letter, and gap between two keys, in pixels. */
const LINE = 14;
const LETTER = 5.7;
const GAP = 14;

/** Radius of a dot, and length of a tick, in pixels. */
const DOT = 3.5;
const TICK = 4;

/**
 * Return the range of values with a margin; for equal values, a range around them.
 * @param {Iterable<number>} values
 * @returns {Range}
 */
export function rangeOf(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  if (low > high) return { low: 0, high: 1 };
  const least = Math.max(Math.abs(low), Math.abs(high)) * 1e-13;
  const space = high - low > least ? MARGIN * (high - low) : Math.max(Math.abs(low), 1e-12) * 0.1;
  return { low: low - space, high: high + space };
}

export class Plot {
  /**
   * @param {HTMLElement} element
   * @param {(x: number) => void} [seek]  called with the position to which the cursor was dragged
   */
  constructor(element, seek) {
    this.element = element;
    /** @type {Figure|null} */
    this.figure = null;
    this.cursor = NaN;
    this.root = svg("svg", { role: "img" });
    this.mark = svg("g", { class: "cursor" });
    element.append(this.root);
    new ResizeObserver(() => this.#draw()).observe(element);
    if (seek) this.#followPointer(seek);
  }

  /** @param {Figure} figure */
  show(figure) {
    this.figure = figure;
    this.#draw();
  }

  /**
   * Move the cursor: a line across the plot, or with `y` a dot.
   * @param {number} x
   * @param {number} [y]
   */
  setCursor(x, y) {
    this.cursor = x;
    if (!this.figure || !this.width) return;
    const place = this.#right(x);
    if (!Number.isFinite(place) || Number.isNaN(y)) {
      this.mark.replaceChildren();
      return;
    }
    const line = { x1: place, x2: place, y1: this.top, y2: this.height - ROOM.bottom };
    const mark = y === undefined ? svg("line", line) : svg("circle", { cx: place, cy: this.#up(y), r: 5 });
    this.mark.replaceChildren(mark);
  }

  #draw() {
    const { clientWidth: width, clientHeight: height } = this.element;
    const { figure } = this;
    if (!figure || width === 0 || height === 0) return;
    [this.width, this.height] = [width, height];
    this.root.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.root.setAttribute("aria-label", figure.title);
    this.keys = this.#linesOfKeys(figure);
    this.top = ROOM.top + (this.keys.length - 1) * LINE;
    const lines = (figure.lines ?? []).map(({ y, kind }) => {
      const line = { x1: ROOM.left, x2: width - ROOM.right, y1: this.#up(y), y2: this.#up(y) };
      return svg("line", { ...line, class: `line ${kind}` });
    });
    const areas = this.#areas(figure.areas ?? []);
    const curves = figure.curves.map((curve) =>
      svg("path", { d: this.#path(curve), class: `curve ${curve.kind}` }),
    );
    const dots = (figure.dots ?? []).map((dot) => this.#dot(dot));
    const inner = { x: ROOM.left, y: this.top, width: this.#innerWidth(), height: this.#innerHeight() };
    const frame = {
      ...inner,
      viewBox: Object.values(inner).join(" "),
      class: "inside",
      "aria-hidden": "true",
    };
    const inside = svg("svg", frame, ...areas, ...lines, ...curves);
    this.root.replaceChildren(...this.#axes(figure), inside, ...dots, ...this.#legend(), this.mark);
    if (Number.isFinite(this.cursor) && this.mark.firstChild?.nodeName === "line") {
      this.setCursor(this.cursor);
    }
  }

  #innerWidth() {
    return Math.max(this.width - ROOM.left - ROOM.right, 1);
  }

  #innerHeight() {
    return Math.max(this.height - this.top - ROOM.bottom, 1);
  }

  /**
   * Return the distance of a value from the left edge, in pixels.
   * @param {number} value
   */
  #right(value) {
    const { low, high } = /** @type {Figure} */ (this.figure).x;
    return ROOM.left + ((value - low) / (high - low)) * this.#innerWidth();
  }

  /**
   * Return the distance of a value from the top, in pixels; values far outside are drawn just outside the plot.
   * @param {number} value
   */
  #up(value) {
    const { low, high } = /** @type {Figure} */ (this.figure).y;
    const share = Math.min(Math.max((value - low) / (high - low), -0.5), 1.5);
    return this.height - ROOM.bottom - share * this.#innerHeight();
  }

  /**
   * Return the path of a curve. Of the samples that share a pixel, the first, the extremes and the last are kept.
   * @param {Curve} curve
   */
  #path({ x, y }) {
    /** @type {string[]} */
    const parts = [];
    let pen = "M";
    let i = 0;
    while (i < x.length) {
      const column = Math.round(this.#right(x[i]));
      let [least, most, last] = [i, i, i];
      for (i += 1; i < x.length && Math.round(this.#right(x[i])) === column; i += 1) {
        if (y[i] < y[least]) least = i;
        if (y[i] > y[most]) most = i;
        last = i;
      }
      for (const each of [Math.min(least, most), Math.max(least, most), last]) {
        if (!Number.isFinite(y[each])) pen = "M";
        else {
          parts.push(`${pen}${this.#right(x[each]).toFixed(2)},${this.#up(y[each]).toFixed(2)}`);
          pen = "L";
        }
      }
    }
    return parts.join("");
  }

  /** @param {Curve[]} areas each one above the previous one */
  #areas(areas) {
    const floor = (/** @type {Curve} */ { x }) => ({ x, y: new Float64Array(x.length), kind: "" });
    return areas.map((area, i) => {
      const below = i === 0 ? floor(area) : areas[i - 1];
      const back = { x: Array.from(below.x).reverse(), y: Array.from(below.y).reverse(), kind: "" };
      const d = `${this.#path(area)}${this.#path(back).replace("M", "L")}Z`;
      return svg("path", { d, class: `area ${area.kind}` });
    });
  }

  /** @param {{x: number, y: number, kind: string, label: string}} dot */
  #dot({ x, y, kind, label }) {
    const mark = svg("circle", { cx: this.#right(x), cy: this.#up(y), r: DOT, class: `dot ${kind}` });
    mark.append(svg("title", {}, label));
    return mark;
  }

  /** @param {Figure} figure */
  #axes(figure) {
    const [bottom, right] = [this.height - ROOM.bottom, this.width - ROOM.right];
    const parts = [svg("path", { d: `M${ROOM.left},${this.top}V${bottom}H${right}`, class: "axis" })];
    const across = scaleOf(figure.x, this.#innerWidth() / 80);
    for (const { place, label } of across.ticks) {
      const x = ROOM.left + (0.5 + place / 2) * (right - ROOM.left);
      parts.push(svg("path", { d: `M${x},${bottom}v${TICK}`, class: "axis" }));
      parts.push(svg("text", { x, y: bottom + 15, class: "tick across" }, label));
    }
    const upward = scaleOf(figure.y, (bottom - this.top) / 32);
    for (const { place, label } of upward.ticks) {
      const y = bottom - (0.5 + place / 2) * (bottom - this.top);
      parts.push(svg("path", { d: `M${ROOM.left},${y}h${-TICK}`, class: "axis" }));
      parts.push(svg("path", { d: `M${ROOM.left},${y}H${right}`, class: "gridline" }));
      parts.push(svg("text", { x: ROOM.left - TICK - 3, y: y + 3.5, class: "tick upward" }, label));
    }
    parts.push(
      svg("text", { x: right, y: this.height - 3, class: "name across" }, named(figure.xLabel, across)),
    );
    const hint = figure.hint ? [svg("title", {}, figure.hint)] : [];
    parts.push(svg("text", { x: 2, y: 11, class: "name" }, named(figure.yLabel, upward), ...hint));
    return parts;
  }

  /** Return the keys of curves and areas, in right-aligned lines above the plot. */
  #legend() {
    return this.keys.flatMap((line, i) => {
      let end = this.width - ROOM.right;
      return line.toReversed().map(({ kind, label }) => {
        const mark = svg("tspan", { class: `key ${kind}` }, "\u25a0\u202f");
        const text = svg(
          "text",
          { x: end, y: 11 + i * LINE, class: "legend" },
          mark,
          svg("tspan", {}, label),
        );
        end -= widthOf(label) + GAP;
        return text;
      });
    });
  }

  /**
   * Return the lines of keys; the first is next to the name of the axis, if there is room.
   * @param {Figure} figure
   */
  #linesOfKeys({ curves, areas = [], yLabel }) {
    const room = this.width - ROOM.right;
    /** @type {{kind: string, label: string}[][]} */
    const lines = [[]];
    let used = yLabel.length * LETTER + GAP;
    for (const { kind, label } of [...curves, ...areas]) {
      if (!label) continue;
      const width = widthOf(label) + GAP;
      if (used + width > room) {
        lines.push([]);
        used = 0;
      }
      lines[lines.length - 1].push({ kind, label });
      used += width;
    }
    return lines;
  }

  /** @param {(x: number) => void} seek */
  #followPointer(seek) {
    const { root } = this;
    root.classList.add("seeks");
    const told = (/** @type {PointerEvent} */ event) => {
      if (!this.figure) return;
      const share = (event.clientX - root.getBoundingClientRect().left - ROOM.left) / this.#innerWidth();
      const { low, high } = this.figure.x;
      seek(low + Math.min(Math.max(share, 0), 1) * (high - low));
    };
    root.addEventListener("pointerdown", (event) => {
      root.setPointerCapture(event.pointerId);
      event.preventDefault();
      told(event);
    });
    root.addEventListener("pointermove", (event) => {
      if (root.hasPointerCapture(event.pointerId)) told(event);
    });
  }

  width = 0;
  height = 0;
  top = ROOM.top;
  /** @type {{kind: string, label: string}[][]} */
  keys = [];
}

/**
 * Return the approximate width of a key and its label.
 * @param {string} label
 */
function widthOf(label) {
  return (label.length + 1.5) * LETTER;
}

/**
 * @param {Range} range
 * @param {number} count
 */
function scaleOf({ low, high }, count) {
  return ticksOf(
    { centre: (low + high) / 2, half: (high - low) / 2, scale: "linear" },
    1,
    Math.max(count, 2),
  );
}

/**
 * Return the name of an axis, with the offset and the power of ten of its labels.
 * @param {string} label
 * @param {{offset: string, power: number}} scale
 */
function named(label, { offset, power }) {
  const tens = power === 0 ? "" : ` \u00d710${superscript(power)}`;
  return label + (offset ? `, from ${offset}` : "") + tens;
}
