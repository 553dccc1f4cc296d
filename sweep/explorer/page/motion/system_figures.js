/** The contents of the plots of a system's motion: each state against time, and the first two against each other. */

import { labelled, shown } from "eulerdisk/motion/figures";
import { rangeOf } from "eulerdisk/motion/plot";

/** @import { MotionFigure } from "eulerdisk/motion/figures" */
/** @import { Samples } from "eulerdisk/motion/samples" */
/** @import { Curve, Figure } from "eulerdisk/motion/plot" */

/**
 * @param {Samples} samples
 * @param {number} length
 * @returns {MotionFigure[]}
 */
export function systemFigures(samples, length) {
  const states = samples.head.states ?? [];
  const ofTime = states.map((name) => ({
    name: `state-${name}`,
    seeks: true,
    figure: stateFigure(samples, name, length),
    cursorAt: (/** @type {number} */ time) => /** @type {[number]} */ ([factorOf(samples, "time") * time]),
  }));
  if (states.length < 2) return ofTime;
  const [one, other] = states;
  const at = (/** @type {string} */ name, /** @type {number} */ time) =>
    factorOf(samples, name) * samples.at(name, time);
  const plane = {
    name: "plane",
    seeks: false,
    figure: planeFigure(samples, one, other),
    cursorAt: (/** @type {number} */ time) =>
      /** @type {[number, number]} */ ([at(one, time), at(other, time)]),
  };
  return [...ofTime, plane];
}

/**
 * @param {Samples} samples
 * @param {string} name
 */
function factorOf(samples, name) {
  return samples.head.quantities[name].factor;
}

/**
 * Return a curve, in two pieces if it is reliable only up to some time.
 * @param {Samples} samples
 * @param {Float64Array} x
 * @param {Float64Array} y
 * @returns {Curve[]}
 */
function curves(samples, x, y) {
  const { doubtful } = samples.head;
  const known =
    doubtful === null
      ? x.length
      : samples.times.findIndex((time) => time >= /** @type {number} */ (doubtful));
  const piece = (/** @type {number} */ from, /** @type {number} */ to, /** @type {string} */ kind) => ({
    x: x.subarray(from, to),
    y: y.subarray(from, to),
    kind,
  });
  const pieces = [piece(0, known, "known")];
  if (known < x.length) pieces.push(piece(Math.max(known - 1, 0), x.length, "doubtful"));
  return pieces;
}

/**
 * @param {Samples} samples
 * @param {string} name
 * @param {number} length
 * @returns {Figure}
 */
function stateFigure(samples, name, length) {
  const [time, values] = [shown(samples, "time"), shown(samples, name)];
  return {
    title: `${samples.head.quantities[name].label} against time`,
    xLabel: labelled(samples, "time"),
    yLabel: labelled(samples, name),
    x: { low: 0, high: factorOf(samples, "time") * length },
    y: rangeOf(values),
    curves: curves(samples, time, values),
  };
}

/**
 * @param {Samples} samples
 * @param {string} one
 * @param {string} other
 * @returns {Figure}
 */
function planeFigure(samples, one, other) {
  const [x, y] = [shown(samples, one), shown(samples, other)];
  const labels = [one, other].map((name) => samples.head.quantities[name].label);
  return {
    title: `${labels[1]} against ${labels[0]}`,
    xLabel: labelled(samples, one),
    yLabel: labelled(samples, other),
    x: rangeOf(x),
    y: rangeOf(y),
    curves: curves(samples, x, y),
  };
}
