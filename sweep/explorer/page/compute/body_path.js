/**
 * One motion of a body of revolution, followed by the kernels of the program: as sweep/motion/body_path.py does it.
 *
 * It is integrated again with half the step until that changes it no more, or no less.
 */

import {
  evenly,
  largest,
  SAMPLES,
  MOST_SAMPLES,
  traced,
  unresolved,
  untilLater,
} from "eulerdisk/compute/paths";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { Path } from "eulerdisk/compute/paths" */

/** Endings of a motion that time ended, or that could not be resolved. */
const HORIZON = 3;
const UNRESOLVED = 5;

/** Rows of the samples (kernels/bodies/motion_arrays.py). */
export const ROWS = [
  ...["tilt", "tilt_rate", "precession_rate", "roll_rate", "heading", "roll_angle", "contact_x", "contact_y"],
  ...["centre_x", "centre_y", "centre_z", "energy", "energy_drift", "momentum", "momentum_rate", "gained"],
  ...["normal_force", "friction_across", "friction_along"],
];
const [TILT, TILT_RATE, PRECESSION_RATE, ROLL_RATE, HEADING, ROLL_ANGLE, CONTACT, , CENTRE] = ROWS.keys();
const FORCES = ROWS.indexOf("normal_force");

/** First step times the fastest frequency, halvings at most, the difference that is small enough, and one worth a halving. */
const STEP = 0.01;
const MOST_REFINEMENTS = 6;
const ALLOWED = 4e-10;
const BETTER = 0.5;

/** A difference of two integrations counts so many times; rounding that both have in common, and that of the start. */
const SAFETY = 4;
const ROUNDING = 1e-12;
const OF_RATES = 2 ** -50;

/** Angle between two samples, and how much later than it was found an end is looked for. */
const TURN = 0.2;
const LATER = 1.1;

/**
 * @param {Computation} computation
 * @param {number[]} start  in the order of the parameters of the model
 * @param {number} duration
 * @param {{fallTilt: number, number: number, poles: boolean, unit: number, radius: number}} body  its number, whether it
 *   rolls on through its poles, sqrt(R/g)
 * @param {AbortSignal} signal
 * @returns {Promise<Path>}
 */
export async function bodyPath(computation, start, duration, body, signal) {
  const integrated = async (/** @type {Float64Array} */ times) => {
    /** @type {Path|null} */
    let before = null;
    let [best, least] = [/** @type {Path|null} */ (null), Infinity];
    for (let refinement = 0; refinement <= MOST_REFINEMENTS; refinement += 1) {
      const settings = [0, STEP / 2 ** refinement, body.fallTilt, body.number];
      const path = await traced(computation, "body_trajectory", start, settings, times, ROWS.length, signal);
      if (path.ending === UNRESOLVED) {
        if (refinement > 0) break;
        continue;
      }
      if (before && before.ending === path.ending) {
        const error = apart(before, path, body);
        if (!(error < BETTER * least) && best) return best;
        [best, least] = [path, error];
        if (error <= ALLOWED) return path;
      }
      before = path;
    }
    if (best) return best;
    throw unresolved(before?.times.at(-1) ?? 0);
  };
  const times = evenly(duration, SAMPLES);
  const found = await integrated(times);
  const last = /** @type {number} */ (found.times.at(-1));
  const turns = largest(turning(found, body.poles)) * times[1];
  const count = Math.ceil(Math.min(Math.max(SAMPLES, ((last / times[1]) * turns) / TURN), MOST_SAMPLES));
  const ended = found.ending !== HORIZON;
  const closer = ended ? untilLater(last / (count - 0.5), Math.ceil(LATER * count)) : evenly(duration, count);
  if (!(closer[1] < times[1])) return found;
  const again = await integrated(closer);
  return again.ending === found.ending ? again : found;
}

/**
 * How fast a body turns, and the contact point goes round it.
 * @param {Path} path
 * @param {boolean} poles  beside one the rates of heading and roll say nothing
 */
function turning({ rows }, poles) {
  return rows[TILT].map((tilt, i) => {
    const [rate, precession, roll] = [rows[TILT_RATE][i], rows[PRECESSION_RATE][i], rows[ROLL_RATE][i]];
    const about = Math.abs(roll + precession * Math.sin(tilt));
    const across = Math.hypot(rate, precession * Math.cos(tilt));
    if (poles) return Math.hypot(about, across);
    return Math.max(about, across, Math.abs(precession), Math.abs(roll));
  });
}

/**
 * The largest error that two integrations tell of, scaled: they differ in time only at their ends.
 * @param {Path} one
 * @param {Path} other
 * @param {{unit: number, radius: number}} size
 */
function apart(one, other, { unit, radius }) {
  const size = other.times.length;
  const place = Math.min(size, one.times.length) - 1;
  const step = one.times[place] - one.times[place - 1];
  const first = one.rows.map((row) => (/** @type {number} */ i) => {
    const value = row[Math.min(i, row.length - 1)];
    return i < place
      ? value
      : value + ((other.times[i] - one.times[place]) / step) * (row[place] - row[place - 1]);
  });
  let [angle, path, rate, force] = [0, 0, 0, 0];
  for (let i = 0; i < size; i += 1) {
    const off = (/** @type {number} */ row) => other.rows[row][i] - first[row](i);
    const [sin, cos] = [Math.sin(other.rows[TILT][i]), Math.cos(other.rows[TILT][i])];
    const turned = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ c) =>
      Math.hypot(off(a), cos * off(b), off(c) + sin * off(b));
    angle = Math.max(angle, turned(TILT, HEADING, ROLL_ANGLE));
    rate = Math.max(rate, unit * turned(TILT_RATE, PRECESSION_RATE, ROLL_RATE));
    const centre = Math.hypot(off(CENTRE), off(CENTRE + 1), off(CENTRE + 2));
    path = Math.max(path, Math.max(Math.hypot(off(CONTACT), off(CONTACT + 1)), centre) / radius);
    force = Math.max(force, Math.hypot(off(FORCES), off(FORCES + 1), off(FORCES + 2)));
  }
  const fastest =
    unit * Math.max(Math.abs(other.rows[PRECESSION_RATE][0]), Math.abs(other.rows[ROLL_RATE][0]));
  const rounding = ROUNDING + OF_RATES * fastest * (1 + /** @type {number} */ (other.times.at(-1)) / unit);
  return SAFETY * Math.max(angle, path, rate, force) + rounding;
}
