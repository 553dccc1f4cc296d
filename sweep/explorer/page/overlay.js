/** Everything drawn over the picture of a map: frame, axes, lines, legend, chosen points and the cursor, as one SVG. */

import { placeOf, valueAt } from "eulerdisk/axis_window";
import { flagColour, GREY, shade } from "eulerdisk/colours";
import { svg, textWidth } from "eulerdisk/elements";
import { codesOf, rasterOf, roomiest } from "eulerdisk/regions";
import { printedUnits, superscript, ticksOf } from "eulerdisk/ticks";

/** @import { Range } from "eulerdisk/colours" */
/** @import { Point } from "eulerdisk/state" */
/** @import { Tick } from "eulerdisk/ticks" */
/** @import { Axis, Line, Parameter, Quantity, View } from "eulerdisk/types" */

/**
 * The position of the picture, in CSS pixels; `right` is the space to its right.
 * @typedef {{left: number, top: number, right: number, width: number, height: number}} Plot
 */

/**
 * The contents of an overlay. `stale` says that the lines belong to other words.
 * @typedef {object} Scene
 * @property {View} view
 * @property {Plot} plot
 * @property {Parameter} x
 * @property {Parameter} y
 * @property {Quantity} quantity
 * @property {Range} range
 * @property {boolean} undecided  whether undecided cells are grey among the colours of numbers
 * @property {Line[]} lines
 * @property {boolean} stale
 * @property {[Point|null, Point|null]} points
 * @property {(across: number, up: number) => number|null} codeAt  region at a place from -1 to 1
 * @property {Record<string, string>} regions  names of regions by code
 * @property {{x: Axis, y: Axis}|null} grid  the range of stored cells, if some are shown
 * @property {[number, number]|null} cursor  place of the keyboard's cursor
 */

/** CSS pixels between labelled ticks, along x and y, and the least gap between two labels. */
const [APART_X, APART_Y] = [95, 52];
const ROOM = 8;

/**
 * Draw a scene into an element, replacing its contents.
 * @param {SVGSVGElement} element
 * @param {Scene} scene
 */
export function drawOverlay(element, scene) {
  const { left, top, width, height } = scene.plot;
  const inside = svg("g", { transform: `translate(${left} ${top})` });
  if (scene.grid) inside.append(...gridFrame(scene, scene.grid));
  const lines = svg("g", { class: scene.stale ? "lines stale" : "lines" });
  const drawn = order(scene.lines).map((line) => ({ name: line.name, pieces: piecesOf(scene, line) }));
  for (const { name, pieces } of drawn) lines.append(...drawLine(name, pieces));
  inside.append(lines, svg("rect", { class: "frame", width, height }));
  inside.append(xAxis(scene), yAxis(scene));
  inside.append(
    ...regionNames(
      scene,
      drawn.flatMap(({ pieces }) => pieces),
    ),
  );
  scene.points.forEach((point, slot) => {
    if (point) inside.append(...mark(scene, point, "AB"[slot]));
  });
  if (scene.cursor) inside.append(cross(scene.plot, scene.cursor));
  element.replaceChildren(inside, drawLegend(scene));
}

/**
 * Return the pixel of a start in the plot.
 * @param {Scene} scene
 * @param {number} x
 * @param {number} y
 * @returns {Pixel}
 */
function pixelOf({ view, plot }, x, y) {
  return [((placeOf(view.x, x) + 1) / 2) * plot.width, ((1 - placeOf(view.y, y)) / 2) * plot.height];
}

/**
 * Return the lines from the lowest to the highest, as in figures.
 * @param {Line[]} lines
 */
function order(lines) {
  const names = ["analytic", "predicted", "measured"];
  return lines.toSorted((one, other) => names.indexOf(one.name) - names.indexOf(other.name));
}

/**
 * Return the visible pieces of a line, in pixels of the plot.
 * @param {Scene} scene
 * @param {Line} line
 */
function piecesOf(scene, line) {
  const { width, height } = scene.plot;
  const box = { left: 0, top: 0, right: width, bottom: height };
  return line.points.flatMap((points) =>
    clipped(
      points.map(([x, y]) => pixelOf(scene, x, y)),
      box,
    ),
  );
}

/**
 * @param {string} name
 * @param {Pixel[][]} pieces
 */
function drawLine(name, pieces) {
  if (!pieces.length) return [];
  const path = pieces
    .map((piece) => `M${piece.map(([x, y]) => `${x.toFixed(2)} ${y.toFixed(2)}`).join("L")}`)
    .join("");
  return haloed(name, path);
}

/**
 * Return the name of each region, so that a map can be read without its colours.
 * @param {Scene} scene
 * @param {Pixel[][]} lines
 */
function regionNames(scene, lines) {
  const { plot, regions, points, codeAt } = scene;
  const marks = points.flatMap((point) => (point ? [pixelOf(scene, point.x, point.y)] : []));
  const raster = rasterOf(plot.width, plot.height, lines, marks);
  const codes = codesOf(raster, codeAt);
  return Object.entries(regions).flatMap(([code, name]) => {
    // the drawn letters are larger and bolder than the measured ones
    const place = roomiest(raster, codes, Number(code), [textWidth(name) * 1.3, 16]);
    if (!place) return [];
    const [x, y] = place;
    return [svg("text", { class: "region", x, y, dy: "0.35em", "text-anchor": "middle" }, name)];
  });
}

/**
 * Return a sample of a kind of line, to put next to its name.
 * @param {string} kind
 */
export function lineSample(kind) {
  return svg("svg", { class: "sample", "aria-hidden": "true" }, ...haloed(kind, "M3 4h20"));
}

/**
 * Return a line of some kind, with another one beneath that keeps it visible on every colour.
 * @param {string} kind
 * @param {string} d
 */
function haloed(kind, d) {
  return [svg("path", { class: `halo ${kind}`, d }), svg("path", { class: `line ${kind}`, d })];
}

/**
 * @param {Scene} scene
 * @param {{x: Axis, y: Axis}} grid
 */
function gridFrame(scene, { x, y }) {
  const [left, bottom] = pixelOf(scene, valueAt(x, -1), valueAt(y, -1));
  const [right, top] = pixelOf(scene, valueAt(x, 1), valueAt(y, 1));
  /** @type {Pixel[]} */
  const corners = [
    [left, bottom],
    [right, bottom],
    [right, top],
    [left, top],
    [left, bottom],
  ];
  const { width, height } = scene.plot;
  const pieces = clipped(corners, { left: -1, top: -1, right: width + 1, bottom: height + 1 });
  const path = pieces.map((piece) => `M${piece.map((each) => each.join(" ")).join("L")}`).join("");
  return haloed("stored", path);
}

/**
 * Return the ticks of an axis, without labels that would touch the previous one: on a logarithmic axis, labels crowd.
 * @param {Tick[]} ticks
 * @param {number} length  in pixels
 */
function spaced(ticks, length) {
  let free = -Infinity;
  return ticks.map(({ place, label }) => {
    const [middle, half] = [((place + 1) / 2) * length, textWidth(label) / 2];
    if (middle - half < free) return { place, label: "" };
    if (label) free = middle + half + ROOM;
    return { place, label };
  });
}

/** @param {Scene} scene */
function xAxis({ view, plot, x }) {
  const group = svg("g", { class: "axis", transform: `translate(0 ${plot.height})` });
  const { ticks, offset, power } = ticksOf(view.x, x.factor, plot.width / APART_X);
  for (const { place, label } of spaced(ticks, plot.width)) {
    const at = ((place + 1) / 2) * plot.width;
    group.append(svg("line", { x1: at, x2: at, y1: 0, y2: label ? 6 : 3 }));
    if (label) {
      // at the right border, move a label only as far left as necessary
      const x = Math.min(at, plot.width + plot.right - textWidth(label) / 2);
      group.append(svg("text", { x, y: 20, "text-anchor": "middle" }, label));
    }
  }
  const title = svg(
    "text",
    { class: "title", x: plot.width / 2, y: 42, "text-anchor": "middle" },
    titleOf(x, offset, power),
  );
  group.append(title);
  return group;
}

/** @param {Scene} scene */
function yAxis({ view, plot, y }) {
  const group = svg("g", { class: "axis" });
  const { ticks, offset, power } = ticksOf(view.y, y.factor, plot.height / APART_Y);
  for (const { place, label } of ticks) {
    const at = ((1 - place) / 2) * plot.height;
    group.append(svg("line", { x1: label ? -6 : -3, x2: 0, y1: at, y2: at }));
    if (label) group.append(svg("text", { x: -10, y: at, dy: "0.33em", "text-anchor": "end" }, label));
  }
  const turned = `translate(${16 - plot.left} ${plot.height / 2}) rotate(-90)`;
  group.append(
    svg("text", { class: "title", transform: turned, "text-anchor": "middle" }, titleOf(y, offset, power)),
  );
  return group;
}

/**
 * Return name and unit of an axis, and what its labels omit: "roll rate (2.557 + n × 10⁻⁶ rad/s)".
 * @param {{label: string, unit: string}} shown
 * @param {string} offset
 * @param {number} power
 */
function titleOf({ label, unit }, offset, power) {
  const scale = power === 0 ? "" : `\u00d7\u2009${power === 1 ? "10" : `10${superscript(power)}`}`;
  const printed = printedUnits(unit);
  if (offset) return `${label}: ${offset} + labels ${scale} ${printed}`.trim();
  const units = [scale, printed].filter(Boolean).join(" ");
  return units ? `${label} (${units})` : label;
}

/**
 * @param {Scene} scene
 * @param {Point} point
 * @param {string} letter
 */
function mark(scene, point, letter) {
  const [x, y] = pixelOf(scene, point.x, point.y);
  if (!(x >= -12 && y >= -12 && x <= scene.plot.width + 12 && y <= scene.plot.height + 12)) return [];
  return [
    svg("circle", { class: "mark", cx: x, cy: y, r: 9 }),
    svg("text", { class: "mark", x, y, dy: "0.35em", "text-anchor": "middle" }, letter),
  ];
}

/**
 * @param {Plot} plot
 * @param {[number, number]} place
 */
function cross({ width, height }, [across, up]) {
  const [x, y] = [((across + 1) / 2) * width, ((1 - up) / 2) * height];
  const d = `M${x - 12} ${y}H${x - 4}M${x + 4} ${y}H${x + 12}M${x} ${y - 12}V${y - 4}M${x} ${y + 4}V${y + 12}`;
  return svg("g", { class: "cursor" }, svg("path", { class: "halo", d }), svg("path", { d }));
}

/** @typedef {[number, number]} Pixel */

/**
 * Return the pieces of a polyline inside a rectangle. A point that is not finite ends a piece.
 * @param {Pixel[]} points
 * @param {{left: number, top: number, right: number, bottom: number}} box
 * @returns {Pixel[][]}
 */
export function clipped(points, box) {
  /** @type {Pixel[][]} */
  const pieces = [];
  /** @type {Pixel[]} */
  let piece = [];
  for (let each = 1; each < points.length; each += 1) {
    const part = segment(points[each - 1], points[each], box);
    if (part === null) continue;
    const last = piece.at(-1);
    if (!last || last[0] !== part[0][0] || last[1] !== part[0][1]) {
      piece = [part[0]];
      pieces.push(piece);
    }
    piece.push(part[1]);
  }
  return pieces;
}

/**
 * Return the part of a segment inside a rectangle (Liang and Barsky 1984); null if there is none.
 * @param {Pixel} from
 * @param {Pixel} to
 * @param {{left: number, top: number, right: number, bottom: number}} box
 * @returns {[Pixel, Pixel]|null}
 */
function segment(from, to, box) {
  if (![...from, ...to].every(Number.isFinite)) return null;
  const [dx, dy] = [to[0] - from[0], to[1] - from[1]];
  let [enter, leave] = [0, 1];
  const sides = [
    [-dx, from[0] - box.left],
    [dx, box.right - from[0]],
    [-dy, from[1] - box.top],
    [dy, box.bottom - from[1]],
  ];
  for (const [slope, distance] of sides) {
    if (slope === 0 && distance < 0) return null;
    if (slope < 0) enter = Math.max(enter, distance / slope);
    if (slope > 0) leave = Math.min(leave, distance / slope);
  }
  if (enter > leave) return null;
  /** @param {number} share @returns {Pixel} */
  const at = (share) =>
    share === 0 ? from : share === 1 ? to : [from[0] + share * dx, from[1] + share * dy];
  return [at(enter), at(leave)];
}

/** Number of colours in the gradient that shows the scale. */
const STOPS = 24;

/** Height of a row of the legend, and of the row with the samples of lines. */
const [ROW, SAMPLES] = [18, 20];

/** Length of a sample of a line, the gap between the sample and its text, and the gap between two samples. */
const USUAL = [20, 6, 18];

/** The same on very small screens. */
const TIGHT = [13, 3, 9];

/**
 * @param {Scene} scene
 * @returns {SVGElement}
 */
function drawLegend(scene) {
  const group = svg("g", { class: "legend", transform: `translate(${scene.plot.left} 0)` });
  group.append(scene.quantity.flags ? flags(scene) : bar(scene));
  group.append(...samples(scene));
  const title = group.querySelector(".title")?.textContent ?? "";
  if (scene.grid) group.append(...storedSample(scene, textWidth(title)));
  return group;
}

/**
 * Return the height of the legend of a quantity above a plot of some width, in CSS pixels.
 * @param {Quantity} quantity
 * @param {number} width
 */
export function legendHeight({ flags }, width) {
  if (!flags) return ROW * 3 + SAMPLES;
  const rows = flagRows(flags, width);
  return ROW * (rows.at(-1)?.row ?? 0) + ROW * 2 + 6 + SAMPLES;
}

/**
 * Return a sample of each line, in the last row and from the right border leftward, with one-word names if labels do
 * not fit.
 * @param {Scene} scene
 */
function samples({ lines, plot }) {
  const parts = [];
  const y = plot.top - 12;
  let x = plot.width;
  const known = lines.filter((line) => line.points.length);
  /** @param {number[]} sizes  @param {"name"|"label"} word */
  const fits = ([length, room, between], word) =>
    known.reduce((sum, line) => sum + textWidth(line[word]) + length + room + between, -between) <=
    plot.width;
  const word = fits(USUAL, "label") ? "label" : "name";
  const [length, room, between] = fits(USUAL, word) ? USUAL : TIGHT;
  for (const line of known.toReversed()) {
    x -= textWidth(line[word]) + length + room;
    parts.push(...haloed(line.name, `M${x} ${y}h${length}`));
    parts.push(svg("text", { x: x + length + room, y: y + 4 }, line[word]));
    x -= between;
  }
  return parts;
}

/**
 * Return the sample that explains the border of stored cells, in the first row next to a title of some width.
 * @param {Scene} scene
 * @param {number} title
 */
function storedSample({ plot }, title) {
  const [length, room, between] = USUAL;
  const free = plot.width - title - between - length - room;
  const words = textWidth("border of stored cells") <= free ? "border of stored cells" : "stored";
  const x = plot.width - textWidth(words) - length - room;
  return [...haloed("stored", `M${x} 7h${length}`), svg("text", { x: x + length + room, y: 11 }, words)];
}

/** @param {Scene} scene */
function bar({ quantity, range, plot, undecided }) {
  const group = svg("g");
  const wide = Math.min(plot.width, 420);
  const gradient = svg("linearGradient", { id: "scale-of-colours" });
  for (let each = 0; each <= STOPS; each += 1) {
    const colour = `rgb(${shade(each / STOPS).join(" ")})`;
    gradient.append(svg("stop", { offset: each / STOPS, "stop-color": colour }));
  }
  group.append(
    gradient,
    svg("rect", { class: "bar", y: ROW, width: wide, height: 10, fill: "url(#scale-of-colours)" }),
  );
  const log = range.scale === "log";
  const [low, high] = log ? [Math.log(range.low), Math.log(range.high)] : [range.low, range.high];
  const axis = { centre: (low + high) / 2, half: (high - low) / 2, scale: range.scale };
  const { ticks, offset, power } = ticksOf(axis, quantity.factor, wide / 50);
  for (const { place, label } of spaced(ticks, wide)) {
    const x = ((place + 1) / 2) * wide;
    group.append(svg("line", { x1: x, x2: x, y1: ROW + 10, y2: ROW + (label ? 15 : 13) }));
    if (label) group.append(svg("text", { x, y: ROW + 26, "text-anchor": "middle" }, label));
  }
  group.append(svg("text", { class: "title", y: 12 }, titleOf(quantity, offset, power)));
  if (undecided && wide + 36 + textWidth("undecided") <= plot.width) {
    const x = wide + 18;
    group.append(
      svg("rect", { class: "bar", x, y: ROW - 1, width: 12, height: 12, fill: GREY }),
      svg("text", { x: x + 18, y: ROW + 9.5 }, "undecided"),
    );
  }
  return group;
}

/** @param {Scene} scene */
function flags({ quantity, plot }) {
  const group = svg("g");
  group.append(svg("text", { class: "title", y: 12 }, quantity.label));
  for (const { code, words, x, row } of flagRows(quantity.flags ?? {}, plot.width)) {
    const y = ROW * (row + 1) + 2;
    group.append(
      svg("rect", { class: "bar", x, y, width: 12, height: 12, fill: flagColour(quantity, Number(code)) }),
    );
    group.append(svg("text", { x: x + 18, y: y + 10.5 }, words));
  }
  return group;
}

/**
 * Return the positions of the names of flags, in rows that are not wider than the plot.
 * @param {Record<string, string>} flags
 * @param {number} width
 */
function flagRows(flags, width) {
  let [x, row] = [0, 0];
  return Object.entries(flags).map(([code, words]) => {
    const wide = textWidth(words) + 18;
    if (x > 0 && x + wide > width) [x, row] = [0, row + 1];
    const place = { code, words, x, row };
    x += wide + 18;
    return place;
  });
}
