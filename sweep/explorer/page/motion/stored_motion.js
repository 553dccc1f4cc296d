/** Motions of an exported page: integrated in the page, in the form in which a server answers. */

import { integrate } from "eulerdisk/motion/integrator";
import { potentialOf } from "eulerdisk/motion/stored_potential";

/** @typedef {import("eulerdisk/motion/integrator").Start} Start */
/** @typedef {import("eulerdisk/motion/types").MotionAnswer} MotionAnswer */
/** @typedef {import("eulerdisk/motion/types").StoredMotions} StoredMotions */

/** Swings that a motion is followed, the shortest and the longest time in seconds, and the angle that it turns in all. */
const SWINGS = 3;
const SHORTEST = 6;
const LONGEST = 60;
const TURNS = 400;

/** Angle that the disk turns between two samples at the rates of its start, and the fewest samples. */
const TURN = 0.1;
const FEWEST = 1000;

/**
 * @param {Start} start  in SI units
 * @param {StoredMotions} stored
 * @returns {MotionAnswer}
 */
export function storedMotion(start, stored) {
  const rates = ["tilt_rate", "precession_rate", "roll_rate"];
  const rate = rates.reduce((sum, name) => sum + Math.abs(start[/** @type {"tilt_rate"} */ (name)]), 0);
  const longest = Math.min(LONGEST, rate > 0 ? TURNS / rate : LONGEST);
  const count = Math.max(FEWEST, Math.ceil((longest * rate) / TURN));
  const times = Float64Array.from({ length: count + 1 }, (_, i) => (longest * i) / count);
  const { fell, arrays } = integrate(start, times, stored.fall_tilt);
  const turns = turningTimes(arrays.time, arrays.tilt_rate);
  // every second turn is on the same side
  const period = turns.length > 2 ? turns[turns.length - 1 - (turns.length % 2 ? 0 : 1)] - turns[0] : NaN;
  const swings = Math.floor((turns.length - 1) / 2);
  const wanted = fell ? Infinity : Math.min(Math.max((SWINGS * period) / swings || 0, SHORTEST), longest);
  const kept = arrays.time.filter((time) => time <= wanted).length;
  const cut = Object.fromEntries(
    Object.entries(arrays).map(([name, values]) => [name, values.slice(0, kept)]),
  );
  const potential = potentialOf(start, stored.fall_tilt);
  const last = cut.time[kept - 1];
  const digits = (/** @type {number} */ value) => Number(value.toPrecision(3));
  const needed = cut.friction_needed.reduce((most, value) => Math.max(most, value), 0);
  const head = {
    title: "",
    ending: fell ? `fell at ${digits(last)} s` : `followed for ${digits(last)} s`,
    note: Number.isNaN(needed) ? stored.words.lifts_off : `${stored.words.needs} ${digits(needed)}.`,
    ended: fell,
    lossy: false,
    start: { ...start },
    alpha: start.alpha,
    radius: start.radius,
    gravity: start.gravity,
    turns: turns.length > 1 ? extremesOf(cut.tilt, stored) : [],
    period: Number.isFinite(period) ? period / swings : null,
    wells: potential.wells,
    barriers: potential.barriers,
    losses: [],
    ledger: null,
    quantities: stored.quantities,
  };
  return { head, arrays: { ...cut, potential_tilt: potential.tilt, potential: potential.excess } };
}

/**
 * Times at which a rate changes its sign, by the line between two samples.
 * @param {Float64Array} times
 * @param {Float64Array} rates
 */
function turningTimes(times, rates) {
  const found = [];
  for (let i = 1; i < rates.length; i += 1) {
    const [before, after] = [rates[i - 1], rates[i]];
    if (before * after < 0) {
      found.push(times[i - 1] + ((times[i] - times[i - 1]) * before) / (before - after));
    }
  }
  return found;
}

/**
 * Least and greatest tilt with their words.
 * @param {Float64Array} tilts
 * @param {StoredMotions} stored
 * @returns {[number, string][]}
 */
function extremesOf(tilts, { quantities }) {
  const { factor, unit } = quantities.tilt;
  const ends = [tilts.reduce((a, b) => Math.min(a, b)), tilts.reduce((a, b) => Math.max(a, b))];
  return ends.map((tilt) => [tilt, `${Number((tilt * factor).toPrecision(5))} ${unit}`]);
}
