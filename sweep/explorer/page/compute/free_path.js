/**
 * One motion without losses, followed by the program's kernels as in sweep/motion/free_path.py.
 *
 * The step is halved until that no longer changes the motion, or no longer improves it. The page allows ten times the
 * error of the program, because a picture needs no more accuracy and a click is answered at once.
 */

import {
  evenly,
  largest,
  SAMPLES,
  MOST_SAMPLES,
  traced,
  turning,
  unresolved,
  untilLater,
} from "eulerdisk/compute/paths";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { Path } from "eulerdisk/compute/paths" */

/** Endings of a motion that reached the time limit, or that could not be resolved. */
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

/**
 * First step times the fastest frequency; refinement where only turns are sought; largest number of halvings;
 * difference that is small enough; and the improvement that is worth a halving.
 */
const STEP = 0.01;
const ROUGH = -2;
const MOST_REFINEMENTS = 6;
const ALLOWED = 4e-9;
const BETTER = 0.5;

/** Factor for the difference of two integrations; rounding that both share; and rounding of the start. */
const SAFETY = 4;
const ROUNDING = 1e-12;
const OF_RATES = 2 ** -50;

/** Angle between two samples, and how much later than its first estimate an end is sought. */
const TURN = 0.2;
const LATER = 1.1;

/**
 * @param {Computation} computation
 * @param {number[]} start  in the order of the parameters of the model
 * @param {number} duration
 * @param {{fallTilt: number, number: number, poles: boolean, unit: number, radius: number}} body  its number, whether
 * it rolls on through its poles, sqrt(R/g)
 * @param {AbortSignal} signal
 * @returns {Promise<Path>}
 */
export async function freePath(computation, start, duration, body, signal) {
  const once = (/** @type {Float64Array} */ times, /** @type {number} */ refinement) => {
    const settings = [0, STEP / 2 ** refinement, body.fallTilt, body.number];
    return traced(computation, "trajectory", start, settings, times, ROWS.length, signal);
  };
  const times = evenly(duration, SAMPLES);
  // a longer step is enough to see how fast it turns and when it ends
  const rough = await once(times, ROUGH);
  const closer = rough.ending === UNRESOLVED ? times : closerTimes(rough, times, body.poles);
  const chosen = closer[1] < times[1] ? closer : times;
  return settled((refinement) => once(chosen, refinement), body);
}

/**
 * Return a motion whose step is so short that halving it makes hardly any difference.
 * @param {(refinement: number) => Promise<Path>} once
 * @param {{unit: number, radius: number}} size
 * @returns {Promise<Path>}
 */
async function settled(once, size) {
  let before = await once(0);
  let [best, least] = [/** @type {Path|null} */ (null), Infinity];
  for (let refinement = 1; refinement <= MOST_REFINEMENTS; refinement += 1) {
    const path = await once(refinement);
    if (path.ending === UNRESOLVED) break;
    if (before.ending === path.ending) {
      const error = apart(before, path, size);
      if (best && !(error < BETTER * least)) return best;
      [best, least] = [path, error];
      if (error <= ALLOWED) return path;
    }
    before = path;
  }
  if (best) return best;
  throw unresolved(before.times.at(-1) ?? 0);
}

/**
 * Return evenly spaced times, close enough for the fastest turn in the samples, and equally many up to an end.
 * @param {Path} path
 * @param {Float64Array} times
 * @param {boolean} poles
 */
function closerTimes(path, times, poles) {
  const last = /** @type {number} */ (path.times.at(-1));
  const turns = largest(turning(path, poles)) * times[1];
  const count = Math.ceil(Math.min(Math.max(SAMPLES, ((last / times[1]) * turns) / TURN), MOST_SAMPLES));
  if (path.ending === HORIZON) return evenly(/** @type {number} */ (times.at(-1)), count);
  // half an interval, so that no sample coincides with the end, which has its own
  return untilLater(last / (count - 0.5), Math.ceil(LATER * count));
}

/**
 * Return the largest scaled difference of two integrations, whose times differ only at their ends.
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
