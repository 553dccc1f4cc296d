/** The legend above a map: the bar of colours or the words of flags, and a sample of each line. */

import { flagColour, shade } from "eulerdisk/colours";
import { textWidth } from "eulerdisk/text_width";
import { svg } from "eulerdisk/svg";
import { ticksOf } from "eulerdisk/ticks";
import { titleOf } from "eulerdisk/overlay";

/** @typedef {import("eulerdisk/overlay").Scene} Scene */

/** Colours of the gradient that stands for the scale. */
const STOPS = 24;

/** Height of one row of the legend, and of that with the samples of lines. */
const [ROW, SAMPLES] = [18, 20];

/** Length of a sample of a line, the room between it and its words, and that between two samples. */
const USUAL = [20, 6, 18];

/** The same on the smallest screens. */
const TIGHT = [13, 3, 9];

/**
 * @param {Scene} scene
 * @returns {SVGElement}
 */
export function drawLegend(scene) {
  const group = svg("g", { class: "legend", transform: `translate(${scene.plot.left} 0)` });
  group.append(scene.quantity.flags ? flags(scene) : bar(scene));
  group.append(...samples(scene));
  const title = group.querySelector(".title")?.textContent ?? "";
  if (scene.grid) group.append(...storedSample(scene, textWidth(title)));
  return group;
}

/**
 * Height of the legend of a quantity above a plot of some width, in CSS pixels.
 * @param {import("eulerdisk/types").Quantity} quantity
 * @param {number} width
 */
export function legendHeight({ flags }, width) {
  if (!flags) return ROW * 3 + SAMPLES;
  const rows = flagRows(flags, width);
  return ROW * (rows.at(-1)?.row ?? 0) + ROW * 2 + 6 + SAMPLES;
}

/**
 * A sample of each line, from the right border leftward, in the last row; where labels have no room, with one word each.
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
    const d = `M${x} ${y}h${length}`;
    parts.push(
      svg("path", { class: `halo ${line.name}`, d }),
      svg("path", { class: `line ${line.name}`, d }),
    );
    parts.push(svg("text", { x: x + length + room, y: y + 4 }, line[word]));
    x -= between;
  }
  return parts;
}

/**
 * What tells stored cells from computed ones, in the first row, beside a title of some width.
 * @param {Scene} scene
 * @param {number} title
 */
function storedSample({ plot }, title) {
  const [length, room, between] = USUAL;
  const free = plot.width - title - between - length - room;
  const words = textWidth("border of stored cells") <= free ? "border of stored cells" : "stored";
  const x = plot.width - textWidth(words) - length - room;
  const sample = ["halo", "line"].map((kind) =>
    svg("path", { class: `${kind} stored`, d: `M${x} 7h${length}` }),
  );
  return [...sample, svg("text", { x: x + length + room, y: 11 }, words)];
}

/** @param {Scene} scene */
function bar({ quantity, range, plot }) {
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
  const { ticks, offset, power } = ticksOf(axis, quantity.factor, wide / 80);
  for (const { place, label } of ticks) {
    const x = ((place + 1) / 2) * wide;
    group.append(svg("line", { x1: x, x2: x, y1: ROW + 10, y2: ROW + (label ? 15 : 13) }));
    if (label) group.append(svg("text", { x, y: ROW + 26, "text-anchor": "middle" }, label));
  }
  group.append(svg("text", { class: "title", y: 12 }, titleOf(quantity, offset, power)));
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
 * Where the words of flags stand, in rows that are no wider than the plot.
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
