/** The contents of the plots of a motion: tilt, potential, forces, and where its energy went. */

import { rangeOf } from "eulerdisk/motion/plot";
import { MINUS, readable } from "eulerdisk/ticks";

/** @import { Samples } from "eulerdisk/motion/samples" */
/** @import { Figure } from "eulerdisk/motion/plot" */

/**
 * A plot of a motion: its name, whether its x axis is time, so that its cursor can be dragged, and the cursor's
 * position at a time, in the units of the plot: a line at x, or a dot at x and y.
 * @typedef {object} MotionFigure
 * @property {string} name
 * @property {boolean} seeks
 * @property {Figure} figure
 * @property {(time: number) => [number, number?]} cursorAt
 */

/**
 * Largest force in view, in weights, or relative to the value that it stays below for all but a twentieth of the time.
 */
const IN_VIEW = 2.5;
const OFTEN = 1.3;
const MOMENTS = 400;

/** Digits of the wells and barriers, which are found on a curve of some hundred points. */
const DIGITS = 5;

/** Difference of tilts in radians that is only rounding: the potential ends where a disk has fallen. */
const SAME = 1e-6;

/**
 * Return the values of an array in displayed units.
 * @param {Samples} samples
 * @param {string} name
 */
export function shown(samples, name) {
  const { factor } = samples.head.quantities[name];
  return samples.arrays[name].map((value) => factor * value);
}

/**
 * Return the label of an axis: the name of an array and its unit.
 * @param {Samples} samples
 * @param {string} name
 */
export function labelled(samples, name) {
  const { label, unit } = samples.head.quantities[name];
  return unit ? `${label} (${unit})` : label;
}

/**
 * Return the plots of a rolling body.
 * @param {Samples} samples
 * @param {number} length  of the longest motion that is shown
 * @returns {MotionFigure[]}
 */
export function rollingFigures(samples, length) {
  const { lossy, quantities } = samples.head;
  const atTime = (/** @type {number} */ time) => /** @type {[number]} */ ([time]);
  const onPotential = (/** @type {number} */ time) => {
    const tilt = samples.at("tilt", time);
    return /** @type {[number, number]} */ ([quantities.tilt.factor * tilt, potentialAt(samples, tilt)]);
  };
  const energy = lossy
    ? { figure: ledgerFigure(samples, length), cursorAt: atTime }
    : { figure: potentialFigure(samples), cursorAt: onPotential };
  return [
    { name: "tilt", seeks: true, figure: tiltFigure(samples, length), cursorAt: atTime },
    { name: "potential", seeks: false, ...energy },
    { name: "forces", seeks: true, figure: forcesFigure(samples, length), cursorAt: atTime },
  ];
}

/**
 * @param {Samples} samples
 * @param {number} length  of the longest motion that is shown
 * @returns {Figure}
 */
export function tiltFigure(samples, length) {
  const tilt = shown(samples, "tilt");
  const { factor } = samples.head.quantities.tilt;
  return {
    title: "tilt against time",
    xLabel: labelled(samples, "time"),
    yLabel: labelled(samples, "tilt"),
    x: { low: 0, high: length },
    y: rangeOf(tilt),
    curves: [{ x: samples.times, y: tilt, kind: "tilt" }],
    lines: samples.head.turns.map(([turn]) => ({ y: factor * turn, kind: "turn" })),
  };
}

/**
 * @param {Samples} samples
 * @param {number} length
 * @returns {Figure}
 */
export function forcesFigure(samples, length) {
  const { arrays, times } = samples;
  const across = arrays.friction_across;
  const horizontal = across.map((value, i) => Math.hypot(value, arrays.friction_along[i]));
  const drawn = [arrays.normal_force, horizontal, arrays.friction_needed];
  const highest = Math.max(...drawn.map((values) => extremes(values)[1]));
  const often = OFTEN * Math.max(...drawn.map((values) => usual(samples, values)));
  const lowest = Math.max(Math.min(0, extremes(arrays.normal_force)[0]), -IN_VIEW);
  const y = rangeOf([lowest, Math.max(1, Math.min(highest, Math.max(often, IN_VIEW)))]);
  return {
    title: "forces at the contact against time",
    xLabel: labelled(samples, "time"),
    yLabel: "force / weight",
    hint: "Forces at the contact, divided by the weight of the disk: at rest, the normal force is 1.",
    x: { low: 0, high: length },
    y,
    curves: [
      { x: times, y: arrays.normal_force, kind: "normal", label: "normal force" },
      // the two are nearly equal while the normal force is the weight: the dashed one is drawn on top
      { x: times, y: arrays.friction_needed, kind: "needed", label: "friction needed" },
      { x: times, y: horizontal, kind: "horizontal", label: "horizontal force" },
    ],
  };
}

/**
 * @param {Samples} samples
 * @returns {Figure}
 */
export function potentialFigure(samples) {
  const { head, potential } = samples;
  const { factor, unit } = head.quantities.tilt;
  if (!potential) throw new Error("A motion with losses has no potential.");
  const tilt = potential.tilt.map((value) => factor * value);
  const dot =
    (/** @type {string} */ kind, /** @type {string} */ words) =>
    (/** @type {[number, number]} */ [x, y]) => ({
      x: factor * x,
      y,
      kind,
      label: `${words} at ${readable(factor * x, DIGITS)} ${unit}`,
    });
  const turns = head.turns.map(([turn, text]) => ({
    x: factor * turn,
    y: 0,
    kind: "turn",
    label: `turning point at ${text.replace("-", MINUS)}`,
  }));
  return {
    title: "potential minus energy against tilt",
    xLabel: labelled(samples, "tilt"),
    yLabel: labelled(samples, "potential"),
    hint:
      "Potential minus energy of the tilt, divided by weight × radius: the tilt moves where this is below 0, " +
      "and turns back where it is 0.",
    x: { low: tilt[0], high: tilt[tilt.length - 1] },
    y: rangeOf(potential.excess),
    curves: [{ x: tilt, y: potential.excess, kind: "potential" }],
    lines: [{ y: 0, kind: "energy" }],
    dots: [
      ...potential.wells.map(dot("well", "well")),
      ...potential.barriers.map(dot("barrier", "barrier")),
      ...turns,
    ],
  };
}

/**
 * Return the height of the potential at a tilt, for the dot that moves along the curve; NaN outside the curve.
 * @param {Samples} samples
 * @param {number} tilt  in SI units
 */
export function potentialAt(samples, tilt) {
  const { tilt: tilts, excess } = samples.potential ?? { tilt: [], excess: [] };
  const place = Math.min(Math.max(tilt, tilts[0]), tilts[tilts.length - 1]);
  if (!(Math.abs(place - tilt) < SAME)) return NaN;
  const after = Math.max(
    tilts.findIndex((value) => value >= place),
    1,
  );
  const share = (place - tilts[after - 1]) / (tilts[after] - tilts[after - 1]);
  return excess[after - 1] + share * (excess[after] - excess[after - 1]);
}

/**
 * Return the plot of the remaining energy and, stacked on it, the energy that each loss has taken: their sum is
 * constant.
 * @param {Samples} samples
 * @param {number} length
 * @returns {Figure}
 */
export function ledgerFigure(samples, length) {
  const { head, arrays, times } = samples;
  const taken = Object.keys(head.ledger ?? {}).filter((name) => arrays[name].some((value) => value > 0));
  let top = arrays.energy;
  const areas = [{ x: times, y: top, kind: "energy", label: "energy" }];
  for (const name of taken) {
    const below = top;
    top = arrays[name].map((value, i) => below[i] + value);
    areas.push({ x: times, y: top, kind: name, label: head.ledger?.[name] ?? name });
  }
  return {
    title: "energy and what the losses have taken of it, against time",
    xLabel: labelled(samples, "time"),
    yLabel: labelled(samples, "energy"),
    hint: "Energy divided by m g R (weight × radius): the remaining energy, and stacked on it what each loss has taken.",
    x: { low: 0, high: length },
    y: { low: 0, high: 1.05 * extremes(top)[1] },
    curves: [],
    areas,
  };
}

/**
 * Return the value that an array stays below for all but a twentieth of the time; samples are denser where more
 * happens.
 * @param {Samples} samples
 * @param {Float64Array} values
 */
function usual(samples, values) {
  const moments = Float64Array.from({ length: MOMENTS }, (_, i) => ((i + 0.5) / MOMENTS) * samples.length);
  const sorted = moments
    .map((time) => values[samples.before(time)])
    .filter(Number.isFinite)
    .sort();
  return sorted.length ? sorted[Math.floor(0.95 * (sorted.length - 1))] : 0;
}

/**
 * Return the least and the greatest finite value.
 * @param {Float64Array} values
 * @returns {[number, number]}
 */
function extremes(values) {
  let [low, high] = [Infinity, -Infinity];
  for (const value of values) {
    if (value < low) low = value;
    if (value > high && value < Infinity) high = value;
  }
  return low > high ? [0, 0] : [low, high];
}
