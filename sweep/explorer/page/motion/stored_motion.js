/** Motions of an exported page: integrated in the page, in the form in which a server answers. */

import { integrateClosely, turnsOf } from "eulerdisk/motion/integrator";

/** @typedef {import("eulerdisk/motion/integrator").Start} Start */
/** @typedef {import("eulerdisk/motion/types").MotionAnswer} MotionAnswer */
/** @typedef {import("eulerdisk/motion/types").StoredMotions} StoredMotions */

/** Periods that a motion is followed, the shortest and the longest time in seconds, and the angle that it turns in all. */
const PERIODS = 3;
const SHORTEST = 6;
const LONGEST = 60;
const TURNS = 400;

/** Swing in radians below which a tilt does not change but by rounding: it has no period that could be measured. */
const NO_SWING = 1e-9;

/** Digits of a turning point: those of the other numbers of an exported page. */
const DIGITS = 8;

/**
 * @param {Start} start  in SI units
 * @param {StoredMotions} stored
 * @param {string} title  which start it is
 * @returns {MotionAnswer}
 */
export function storedMotion(start, stored, title) {
  const { ended: endedBefore, turns } = turnsOf(start, stored.fall_tilt);
  const tilts = turns.map(({ tilt }) => tilt).sort((a, b) => a - b);
  // a swing back takes as long as the swing there
  const period = tilts[1] - tilts[0] > NO_SWING ? 2 * (turns[1].time - turns[0].time) : null;
  const duration = durationOf(start, endedBefore === "fell" ? LONGEST : PERIODS * (period ?? 0));
  const { ended, arrays } = integrateClosely(start, duration, stored.fall_tilt);
  const potential = potentialOf(start, stored.fall_tilt);
  const last = arrays.time[arrays.time.length - 1];
  const digits = (/** @type {number} */ value) => Number(value.toPrecision(3));
  const needed = arrays.friction_needed.reduce((most, value) => Math.max(most, value), 0);
  const head = {
    title,
    ending: endingOf(ended, digits(last)),
    note: Number.isNaN(needed) ? stored.words.lifts_off : `${stored.words.needs} ${digits(needed)}.`,
    ended: ended === "fell",
    lossy: false,
    start: { ...start },
    alpha: start.alpha,
    radius: start.radius,
    gravity: start.gravity,
    turns: tilts.map((tilt) => toldTilt(tilt, stored)),
    period,
    wells: potential.wells,
    barriers: potential.barriers,
    losses: [],
    ledger: null,
    quantities: stored.quantities,
  };
  return { head, arrays: { ...arrays, potential_tilt: potential.tilt, potential: potential.excess } };
}

/**
 * Time in seconds that a motion is followed.
 * @param {Start} start
 * @param {number} wanted
 */
function durationOf({ tilt_rate: tilting, precession_rate: turning, roll_rate: rolling }, wanted) {
  const most = TURNS / (Math.abs(tilting) + Math.abs(turning) + Math.abs(rolling));
  return Math.min(Math.max(wanted, SHORTEST), LONGEST, most);
}

/**
 * @param {import("eulerdisk/motion/integrator").Ended} ended
 * @param {number} last  in seconds
 */
function endingOf(ended, last) {
  if (ended === "fell") return `fell at ${last} s`;
  return ended === "given up" ? `followed to ${last} s: too fast from there on` : `followed for ${last} s`;
}

/**
 * A tilt with its words.
 * @param {number} tilt
 * @param {StoredMotions} stored
 * @returns {[number, string]}
 */
function toldTilt(tilt, { quantities }) {
  const { factor, unit } = quantities.tilt;
  return [tilt, `${Number((tilt * factor).toPrecision(DIGITS))} ${unit}`];
}

/** @typedef {{y: Float64Array, excess: Float64Array}} Curve */
/** @typedef {[number, number]} Point  tilt and excess */

/** Points of a curve on each side of the start, and steps between two of them. */
const POINTS = 400;
const STEPS = 4;

/** As in sweep/explorer/potential.py: how much is drawn above the energy, and how high a barrier may be. */
const MARGIN = 0.45;
const FAR = 12;

/**
 * Curve of the potential less the energy, as far as it is worth seeing, with its wells and barriers.
 * @param {Start} start
 * @param {number} fallTilt
 * @returns {{tilt: Float64Array, excess: Float64Array, wells: Point[], barriers: Point[]}}
 */
function potentialOf(start, fallTilt) {
  const y0 = Math.atanh(Math.sin(start.tilt));
  const far = Math.atanh(Math.sin(fallTilt));
  let curve = curveOf(start, -far, far);
  const whole = curve;
  const lowest = Math.min(...whole.excess);
  const depth = Math.max(-lowest, 0) || 1e-3;
  const near = turning(whole, 1).map(([, value]) => value);
  const height = Math.max(0, ...near.filter((value) => value >= 0 && value <= FAR * depth));
  const limit = height + MARGIN * (height + depth);
  // twice: the points of the first curve may lie farther apart than a narrow swing is wide
  for (let pass = 0; pass < 2; pass += 1) {
    const [low, high] = withinLimit(curve, y0, limit);
    curve = curveOf(start, low, high);
  }
  const seen = (/** @type {Point[]} */ points) =>
    points.filter(([y]) => y >= curve.y[0] && y <= curve.y[curve.y.length - 1]).map(toTilt);
  return {
    tilt: curve.y.map(tiltAt),
    excess: curve.excess,
    wells: seen(turning(curve, -1)),
    barriers: seen(turning(curve, 1)),
  };
}

/**
 * Excess on both sides of the start, between two stretched tilts.
 * @param {Start} start
 * @param {number} low
 * @param {number} high
 * @returns {Curve}
 */
function curveOf(start, low, high) {
  const y0 = Math.atanh(Math.sin(start.tilt));
  const left = sideOf(start, y0, low);
  const right = sideOf(start, y0, high);
  const here = -kinetic(start);
  const join = (
    /** @type {number[]} */ before,
    /** @type {number} */ middle,
    /** @type {number[]} */ after,
  ) => Float64Array.from([...before.reverse(), middle, ...after]);
  return { y: join(left.y, y0, right.y), excess: join(left.excess, here, right.excess) };
}

/** @param {Start} start */
function kinetic({ alpha, radius, gravity, tilt_rate: rate }) {
  return (0.5 * (1 + 0.5 * alpha) * rate * rate * radius) / gravity;
}

/**
 * Points from the start to one side. The changes of s and p since the start are integrated, so that the excess of a
 * narrow swing is no difference of large numbers.
 * @param {Start} start
 * @param {number} y0
 * @param {number} end
 */
function sideOf(start, y0, end) {
  const { alpha, radius, gravity, tilt } = start;
  const unit = Math.sqrt(radius / gravity);
  const [sin, cos0] = [Math.sin(tilt), Math.cos(tilt)];
  const s0 = unit * (start.roll_rate + start.precession_rate * sin);
  const p0 = unit * start.precession_rate * cos0 * cos0;
  const slopes = (/** @type {number} */ y, /** @type {number} */ s, /** @type {number} */ p) =>
    /** @type {[number, number]} */ ([-(p0 + p) / (1 + alpha), (-2 * (s0 + s)) / Math.cosh(y) ** 2]);
  const h = (end - y0) / (POINTS * STEPS);
  let [s, p] = [0, 0];
  /** @type {{y: number[], excess: number[]}} */
  const found = { y: [], excess: [] };
  for (let i = 1; i <= POINTS * STEPS; i += 1) {
    const y = y0 + (i - 1) * h;
    const [s1, p1] = slopes(y, s, p);
    const [s2, p2] = slopes(y + h / 2, s + (h / 2) * s1, p + (h / 2) * p1);
    const [s3, p3] = slopes(y + h / 2, s + (h / 2) * s2, p + (h / 2) * p2);
    const [s4, p4] = slopes(y + h, s + h * s3, p + h * p3);
    s += (h / 6) * (s1 + 2 * s2 + 2 * s3 + s4);
    p += (h / 6) * (p1 + 2 * p2 + 2 * p3 + p4);
    if (i % STEPS !== 0) continue;
    const there = tiltAt(y0 + i * h);
    const cos = Math.cos(there);
    const narrow = Math.sin((there + tilt) / 2) * Math.sin((there - tilt) / 2);
    const change = p / cos + (2 * p0 * narrow) / (cos * cos0);
    const sum = (p0 + p) / cos + p0 / cos0;
    found.y.push(y0 + i * h);
    found.excess.push(
      0.5 * (1 + alpha) * s * (2 * s0 + s) + 0.25 * alpha * change * sum - 2 * narrow - kinetic(start),
    );
  }
  return found;
}

/** @param {number} y */
function tiltAt(y) {
  return Math.asin(Math.tanh(y));
}

/**
 * @param {Point} point  stretched tilt and excess
 * @returns {Point}
 */
function toTilt([y, excess]) {
  return [tiltAt(y), excess];
}

/**
 * Maxima (sense 1) or minima (sense -1) within a curve, each by the parabola through three points.
 * @param {Curve} curve
 * @param {number} sense
 * @returns {Point[]}
 */
function turning({ y, excess }, sense) {
  /** @type {Point[]} */
  const found = [];
  for (let i = 1; i < y.length - 1; i += 1) {
    const [left, right] = [sense * (excess[i] - excess[i - 1]), sense * (excess[i + 1] - excess[i])];
    if (!(left > 0 && right <= 0)) continue;
    const shift = (left + right) / (2 * (left - right));
    const step = shift > 0 ? y[i + 1] - y[i] : y[i] - y[i - 1];
    found.push([y[i] + shift * step, excess[i] + (sense * shift * (left + right)) / 4]);
  }
  return found;
}

/**
 * Stretched tilts between which the excess stays below a limit about the start.
 * @param {Curve} curve
 * @param {number} y0
 * @param {number} limit
 */
function withinLimit({ y, excess }, y0, limit) {
  const middle = y.indexOf(y0);
  let [low, high] = [middle, middle];
  while (low > 0 && excess[low] <= limit) low -= 1;
  while (high < y.length - 1 && excess[high] <= limit) high += 1;
  return [y[low], y[high]];
}
