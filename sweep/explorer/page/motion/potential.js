/**
 * The potential of one motion without losses, as a curve to draw: its height above the energy, its wells and its
 * barriers. The disk swings where its potential is below its energy. Everything is in units of m g R.
 */

import { curveOfBody } from "eulerdisk/motion/body_potential";

/** @import { BodyOfMotion } from "eulerdisk/types" */

/** @typedef {{tilt: number, tilt_rate: number, precession_rate: number, roll_rate: number, alpha: number, radius: number, gravity: number}} Start */
/** @typedef {[number, number]} Point a tilt, possibly stretched, and the excess of the potential there */
/** @typedef {(y: number) => {excess: number, slope: number}} Curve a function of stretched tilts */

/**
 * Longest step of the integration, and the least number of steps: up to 89 deg, the curve is accurate to 1e-7 of its
 * height.
 */
const STEP = 0.06;
const FEWEST = 6;

/**
 * Number of places among which extremes are sought, number of points of the curve, and number of bisections to an
 * extreme.
 */
const PLACES = 513;
const POINTS = 241;
const HALVINGS = 50;

/** Margin above the energy and above the barrier, as a share of the visible height. */
const MARGIN = 0.45;

/** Largest ratio of a barrier's height above the energy to the well's depth below it, for a barrier in the picture. */
const FAR = 12;

/** Largest stretched tilt, about 89.9 deg; at 90 deg it is infinite. */
const STEEPEST = 7;

/**
 * @param {Start} start
 * @param {number} fallTilt  end of the curve
 * @param {BodyOfMotion|null} [body]  omitted for the disk
 * @returns {{tilt: Float64Array, excess: Float64Array, wells: Point[], barriers: Point[]}}
 */
export function potentialOf(start, fallTilt, body) {
  const curve = body ? curveOfBody(start, body) : curveOf(start);
  const far = Math.min(stretched(fallTilt), STEEPEST);
  const here = stretched(Math.min(Math.max(start.tilt, -fallTilt), fallTilt));
  // a rim has another meridian on its other edge
  const [first, last] = body?.name !== "rim" ? [-far, far] : start.tilt < 0 ? [-far, 0] : [0, far];
  const places = [...evenly(first, last, PLACES), here].sort((a, b) => a - b);
  const slopes = places.map((y) => curve(y).slope);
  const [wells, barriers] = [-1, 1].map((sense) => extremes(curve, places, slopes, sense));
  // a disk at rest at the bottom of its well has no depth: draw its neighbourhood
  const depth =
    Math.max(0, ...[...wells.map(([, excess]) => excess), curve(here).excess].map((v) => -v)) || 1e-3;
  const height = Math.max(0, ...barriers.map(([, excess]) => excess).filter((value) => value <= FAR * depth));
  const limit = height + MARGIN * (height + depth);
  const [low, high] = [first, last].map((end) => crossing(curve, here, end, limit));
  const seen = (/** @type {Point[]} */ found) =>
    found
      .filter(([y]) => y >= low && y <= high)
      .map(([y, excess]) => /** @type {Point} */ ([tiltAt(y), excess]));
  const tilt = Float64Array.from(evenly(tiltAt(low), tiltAt(high), POINTS));
  const excess = tilt.map((each) => curve(stretched(each)).excess);
  return { tilt, excess, wells: seen(wells), barriers: seen(barriers) };
}

/** @param {number} tilt */
function stretched(tilt) {
  return Math.atanh(Math.sin(tilt));
}

/** @param {number} y  a stretched tilt */
function tiltAt(y) {
  return Math.asin(Math.tanh(y));
}

/**
 * @param {number} low
 * @param {number} high
 * @param {number} count
 */
function evenly(low, high, count) {
  return Array.from({ length: count }, (_, i) => low + (i / (count - 1)) * (high - low));
}

/**
 * Return a function for the potential minus the energy and for its slope. With p = o cos(tilt), ds/dy = -p/(1+alpha)
 * and dp/dy = -2 s cos(tilt)^2. The changes of s and p since the start are integrated, so that the excess of a narrow
 * swing is not a difference of large numbers.
 * @param {Start} start
 * @returns {Curve}
 */
function curveOf({ tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity }) {
  const unit = Math.sqrt(radius / gravity);
  const cos0 = Math.cos(tilt);
  const s0 = unit * (roll_rate + precession_rate * Math.sin(tilt));
  const p0 = unit * precession_rate * cos0 * cos0;
  const y0 = stretched(tilt);
  const kinetic = 0.5 * (1 + 0.5 * alpha) * (unit * tilt_rate) ** 2;
  const slopes = (/** @type {number} */ y, /** @type {number} */ s, /** @type {number} */ p) =>
    /** @type {[number, number]} */ ([-(p0 + p) / (1 + alpha), (-2 * (s0 + s)) / Math.cosh(y) ** 2]);
  return (place) => {
    const steps = Math.max(FEWEST, Math.ceil(Math.abs(place - y0) / STEP));
    const h = (place - y0) / steps;
    let [s, p] = [0, 0];
    for (let i = 0; i < steps; i += 1) {
      const y = y0 + i * h;
      const [s1, p1] = slopes(y, s, p);
      const [s2, p2] = slopes(y + h / 2, s + (h / 2) * s1, p + (h / 2) * p1);
      const [s3, p3] = slopes(y + h / 2, s + (h / 2) * s2, p + (h / 2) * p2);
      const [s4, p4] = slopes(y + h, s + h * s3, p + h * p3);
      s += (h / 6) * (s1 + 2 * s2 + 2 * s3 + s4);
      p += (h / 6) * (p1 + 2 * p2 + 2 * p3 + p4);
    }
    const there = tiltAt(place);
    const [sin, cos] = [Math.sin(there), Math.cos(there)];
    const [o, o0] = [(p0 + p) / cos, p0 / cos0];
    // o - o0, without subtracting nearly equal numbers
    const narrow = Math.sin((there + tilt) / 2) * Math.sin((there - tilt) / 2);
    const change = p / cos + (2 * p0 * narrow) / (cos * cos0);
    const rise = 0.5 * (1 + alpha) * s * (2 * s0 + s) + 0.25 * alpha * change * (o + o0) - 2 * narrow;
    const pull = sin * cos + (1 + alpha) * (s0 + s) * (p0 + p) - 0.5 * alpha * o * o * sin;
    return { excess: rise - kinetic, slope: -pull };
  };
}

/**
 * Return the maxima (sense 1) or minima (sense -1) among increasing places, by bisection.
 * @param {Curve} curve
 * @param {number[]} places
 * @param {number[]} slopes
 * @param {number} sense
 * @returns {Point[]}
 */
function extremes(curve, places, slopes, sense) {
  /** @type {Point[]} */
  const found = [];
  for (let i = 1; i < places.length; i += 1) {
    const rises = (/** @type {number} */ slope) => sense * slope >= 0;
    if (!rises(slopes[i - 1]) || rises(slopes[i])) continue;
    let [low, high] = [places[i - 1], places[i]];
    for (let halving = 0; halving < HALVINGS; halving += 1) {
      const middle = (low + high) / 2;
      if (rises(curve(middle).slope)) low = middle;
      else high = middle;
    }
    found.push([low, curve(low).excess]);
  }
  return found;
}

/**
 * Return the first stretched tilt on the way from the start to an end at which the excess is above a limit; the end if
 * there is none.
 * @param {Curve} curve
 * @param {number} here
 * @param {number} end
 * @param {number} limit
 */
function crossing(curve, here, end, limit) {
  let before = here;
  // distances from the start over twelve decades, because a swing may be that narrow
  const shares = [...evenly(-12, -2, 80).map((power) => 10 ** power), ...evenly(0.01, 1, 240)];
  for (const share of shares) {
    const place = here + share * (end - here);
    if (curve(place).excess > limit) {
      const near = evenly(before, place, 33);
      return near.find((y) => curve(y).excess > limit) ?? place;
    }
    before = place;
  }
  return end;
}
