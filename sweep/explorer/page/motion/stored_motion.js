/** Motions of an exported page: integrated in the page, in the form in which a server answers. */

import { integrateClosely, turnsOf } from "eulerdisk/motion/integrator";

/** @import { Ended, Start } from "eulerdisk/motion/integrator" */
/** @import { MotionAnswer, StoredMotions } from "eulerdisk/types" */

/** Periods that a motion is followed, the shortest and the longest time in seconds, and the angle that it turns in all. */
const PERIODS = 3;
const SHORTEST = 6;
const LONGEST = 60;
const TURNS = 400;

/** Swing in radians below which a tilt does not change but by rounding: it has no period that could be measured. */
const NO_SWING = 1e-9;

/** Digits of a turning point: those of the other numbers of an exported page. */
const DIGITS = 6;

/**
 * @param {Start} start  in SI units
 * @param {StoredMotions} stored
 * @param {string} title  which start it is
 * @param {number|null} [asked]  seconds to follow it
 * @returns {MotionAnswer}
 */
export function storedMotion(start, stored, title, asked = null) {
  const { ended: endedBefore, turns } = turnsOf(start, stored.fall_tilt);
  const tilts = turns.map(({ tilt }) => tilt).sort((a, b) => a - b);
  // a swing back takes as long as the swing there
  const period = tilts[1] - tilts[0] > NO_SWING ? 2 * (turns[1].time - turns[0].time) : null;
  const duration = durationOf(start, asked ?? (endedBefore === "fell" ? LONGEST : PERIODS * (period ?? 0)));
  const { ended, arrays } = integrateClosely(start, duration, stored.fall_tilt);
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
    fall_tilt: stored.fall_tilt,
    losses: [],
    ledger: null,
    quantities: stored.quantities,
  };
  return { head, arrays };
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
 * @param {Ended} ended
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
