/** The legend above a map: the bar of colours or the words of flags, and a sample of each line. */

import { flagColour, shade } from "eulerdisk/colours";
import { svg } from "eulerdisk/svg";
import { ticksOf } from "eulerdisk/ticks";
import { titleOf } from "eulerdisk/overlay";

/** @typedef {import("eulerdisk/overlay").Scene} Scene */

/** Colours of the gradient that stands for the scale. */
const STOPS = 24;

/** Height of one line of the legend. */
const ROW = 18;

/**
 * @param {Scene} scene
 * @returns {SVGElement}
 */
export function drawLegend(scene) {
  const group = svg("g", { class: "legend", transform: `translate(${scene.plot.left} 0)` });
  group.append(scene.quantity.flags ? flags(scene) : bar(scene));
  const samples = scene.lines.filter((line) => line.points.length);
  let x = scene.plot.width;
  for (const line of samples.toReversed()) {
    const wide = textWidth(line.label) + 34;
    x -= wide;
    if (x < 0) break;
    group.append(
      svg("path", { class: `line ${line.name}`, d: `M${x} ${ROW * 3 - 9}h20` }),
      svg("text", { x: x + 26, y: ROW * 3 - 5 }, line.label),
    );
  }
  return group;
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
  group.append(svg("text", { class: "title", y: 11 }, titleOf(quantity, offset, power)));
  return group;
}

/** @param {Scene} scene */
function flags({ quantity, plot }) {
  const group = svg("g");
  group.append(svg("text", { class: "title", y: 11 }, quantity.label));
  let [x, y] = [0, ROW];
  for (const [code, words] of Object.entries(quantity.flags ?? {})) {
    const wide = textWidth(words) + 36;
    if (x + wide > plot.width && x > 0) [x, y] = [0, y + ROW];
    group.append(
      svg("rect", { class: "bar", x, y, width: 12, height: 12, fill: flagColour(quantity, Number(code)) }),
    );
    group.append(svg("text", { x: x + 18, y: y + 10.5 }, words));
    x += wide;
  }
  return group;
}

/** @type {CanvasRenderingContext2D|null} */
let ruler = null;

/**
 * Width of a text of the legend in CSS pixels.
 * @param {string} text
 */
function textWidth(text) {
  ruler ??= document.createElement("canvas").getContext("2d");
  if (!ruler) return text.length * 7;
  ruler.font = "12px system-ui, sans-serif";
  return ruler.measureText(text).width;
}
