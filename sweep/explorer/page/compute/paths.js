/**
 * One motion with losses, followed by the program's kernels: when it is sampled, and with which step, as in
 * sweep/motion/lossy_path.py; and what all motions share.
 */

import { Problem } from "eulerdisk/notice";

/** @import { Computation } from "eulerdisk/compute/computation" */

/**
 * A path: times of samples, their rows, and the code of the ending.
 * @typedef {{times: Float64Array, rows: Float64Array[], ending: number}} Path
 */

/** Codes of the endings of motions. */
const LOSSY = { flat: 1, rest: 2, horizon: 3, slip: 5, unresolved: 7 };

/** Rows of the samples: the state, heading and roll angle, what each loss has taken, and the energy. */
const [TILT, TILT_RATE, PRECESSION_RATE, ROLL_RATE] = [0, 1, 2, 3];
const STATE = 4;
const TURNING = [0, 4, 5];
const LOSSY_ROWS = 21;
const LOSSES = [8, 13];
const LOSSY_ENERGY = 20;

/** Initial and largest number of samples. */
export const SAMPLES = 1000;
export const MOST_SAMPLES = 200_000;

/** Largest number of times that a motion is integrated again with half the step. */
const MOST_REFINEMENTS = 6;

/**
 * Step over that of atlases; largest imbalance of the energy; largest angle per sample; least number of samples; samples
 * per factor e of the time remaining to the end, down to a share of the duration; most integrations with closer samples,
 * the wanted number of samples in a gap that is close enough, and how much later than its first estimate an end is
 * sought.
 */
const LOSSY_STEP = 0.1;
const MOST_IMBALANCE = 1e-9;
const LOSSY_TURN = 0.18;
const LEAST_SAMPLES = 1150;
const TOWARDS_END = 60;
const NEAREST = 1e-5;
const PASSES = 5;
const ENOUGH = 1.1;
const LOSSY_LATER = 1.001;

const BRINK = "rolling friction must clearly hold it or let it go, ";
const HINT = "Give a shorter duration, slower rates, or a smaller largest tilt.";

/**
 * Return a motion with losses, of the disk or of another body.
 * @param {Computation} computation
 * @param {number[]} start
 * @param {number} duration
 * @param {{flatTilt: number, law: number, body: number|null}} given  law of the air, number of the body
 * @param {AbortSignal} signal
 * @returns {Promise<Path>}
 */
export async function lossyPath(computation, start, duration, { flatTilt, law, body }, signal) {
  const name = body === null ? "lossy_trajectory" : "body_lossy_trajectory";
  const integrated = async (/** @type {Float64Array} */ times) => {
    for (let refinement = 0; ; refinement += 1) {
      const settings = [0, LOSSY_STEP / 2 ** refinement, flatTilt, law, ...(body === null ? [] : [body])];
      const path = await traced(computation, name, start, settings, times, LOSSY_ROWS, signal);
      const isLast = refinement === MOST_REFINEMENTS;
      if (path.ending === LOSSY.unresolved) {
        if (isLast) throw unresolved(path.times.at(-1) ?? 0, BRINK);
        continue;
      }
      const kept = path.rows[LOSSY_ENERGY].map((each, i) => each + taken(path.rows, i));
      if (largest(kept.map((each) => each - kept[0])) <= MOST_IMBALANCE || isLast) return path;
    }
  };
  const first = evenly(duration, SAMPLES);
  let path = await integrated(first);
  if (path.times.at(-1) === 0) return held(path, first, body === null ? "disk" : "body");
  for (let pass = 0; pass < PASSES; pass += 1) {
    const wanted = wantedBetween(path);
    if (largest(wanted) <= ENOUGH) break;
    path = await integrated(closerTo(path, wanted));
  }
  // where dry friction lets go, the kernels start the motion slightly after its start
  path.rows.slice(0, STATE).forEach((row, i) => (row[0] = start[i]));
  return path;
}

/**
 * Return a motion that friction holds from its start as one at rest; raise an error for other motions that end where
 * they begin.
 * @param {Path} path
 * @param {Float64Array} times
 * @param {string} called
 */
function held(path, times, called) {
  if (path.ending !== LOSSY.rest) {
    const slips = path.ending === LOSSY.slip;
    throw new Problem(
      `This motion ends where it begins: the ${called} ${slips ? "slips" : "lifts off"}, and the model with losses ends there.`,
      {
        hint: slips ? "Give a larger friction coefficient, or leave it out." : "Give slower rates.",
        status: 400,
      },
    );
  }
  return { ...path, times, rows: path.rows.map((row) => new Float64Array(times.length).fill(row[0])) };
}

/**
 * Integrate one start and sample it.
 * @param {Computation} computation
 * @param {string} name
 * @param {number[]} start
 * @param {number[]} settings
 * @param {Float64Array} times
 * @param {number} rows
 * @param {AbortSignal} signal
 * @returns {Promise<Path>}
 */
export async function traced(computation, name, start, settings, times, rows, signal) {
  const array = (/** @type {ArrayLike<number>} */ numbers, /** @type {number[][]} */ ...shape) => ({
    shape: shape[0] ?? [numbers.length],
    numbers: Float64Array.from(numbers),
  });
  const values = [
    array(start, [start.length, 1]),
    array(settings),
    array(times),
    array([], [rows, times.length]),
  ];
  const { results, arrays } = await computation.ask("call", { name, values }, { signal });
  const [ending, filled, last] = results;
  const moments = times.slice(0, filled);
  moments[filled - 1] = last;
  const samples = arrays[3];
  const row = (/** @type {number} */ i) => samples.slice(i * times.length, i * times.length + filled);
  return { times: moments, rows: Array.from({ length: rows }, (_, i) => row(i)), ending };
}

/**
 * @param {number} time
 * @param {string} also  another rule that the motion must satisfy, with a comma and a space
 */
export function unresolved(time, also = "") {
  const followed = `it was followed until ${Number(time.toPrecision(6))} s`;
  return new Problem(
    `This motion could not be resolved: its state must stay finite, ${also}and it may take no more steps; ` +
      `${time > 0 ? followed : "it fails from its start on"}.`,
    { hint: HINT, status: 400 },
  );
}

/**
 * @param {number} duration
 * @param {number} count  of gaps
 */
export function evenly(duration, count) {
  const step = duration / count;
  return Float64Array.from({ length: count + 1 }, (_, i) => (i === count ? duration : i * step));
}

/**
 * @param {number} step
 * @param {number} count
 */
export function untilLater(step, count) {
  return Float64Array.from({ length: count + 1 }, (_, i) => i * step);
}

/** @param {Float64Array} values */
function differences(values) {
  return values.subarray(1).map((value, i) => value - values[i]);
}

/** @param {Float64Array} values */
export function largest(values) {
  return values.reduce((most, value) => Math.max(most, Math.abs(value)), 0);
}

/**
 * @param {Float64Array[]} rows
 * @param {number} i
 */
function taken(rows, i) {
  return rows.slice(...LOSSES).reduce((sum, row) => sum + row[i], 0);
}

/**
 * Return how fast a body turns, and how fast the contact point goes around it.
 * @param {{rows: Float64Array[]}} path
 * @param {boolean} poles  whether it passes poles, near which the rates of heading and roll say nothing
 */
export function turning({ rows }, poles) {
  return rows[TILT].map((tilt, i) => {
    const [rate, precession, roll] = [rows[TILT_RATE][i], rows[PRECESSION_RATE][i], rows[ROLL_RATE][i]];
    const about = Math.abs(roll + precession * Math.sin(tilt));
    const across = Math.hypot(rate, precession * Math.cos(tilt));
    if (poles) return Math.hypot(about, across);
    return Math.max(about, across, Math.abs(precession), Math.abs(roll));
  });
}

/**
 * Return how many samples should replace each gap between two, judging by the turns in the gap.
 * @param {Path} path
 */
function wantedBetween({ times, rows, ending }) {
  const length = /** @type {number} */ (times.at(-1));
  const angles = TURNING.map((row) => differences(rows[row]));
  const rates = rows[TILT_RATE];
  const isTowardsEnd = ending === LOSSY.flat || ending === LOSSY.rest;
  const left = (/** @type {number} */ i) => length - times[i] + NEAREST * length;
  return differences(times).map((gap, i) => {
    // the difference of two samples does not show a swing of the tilt between them
    const swing = Math.max(Math.abs(rates[i]), Math.abs(rates[i + 1])) * gap;
    const turns = Math.max(swing, ...angles.map((row) => Math.abs(row[i])));
    const wanted = Math.max(turns / LOSSY_TURN, (gap / length) * LEAST_SAMPLES);
    return isTowardsEnd ? Math.max(wanted, TOWARDS_END * Math.log(left(i) / left(i + 1))) : wanted;
  });
}

/**
 * Return times with a wanted number of samples in each gap, evenly spread.
 * @param {Path} path
 * @param {Float64Array} wanted
 */
function closerTo({ times, ending }, wanted) {
  let sum = 0;
  const counted = [0, ...wanted.map((each) => (sum += each))];
  const count = Math.ceil(Math.min(sum, MOST_SAMPLES));
  let gap = 0;
  const found = Float64Array.from({ length: count + 1 }, (_, i) => {
    const at = i === count ? sum : (i * sum) / count;
    while (gap < wanted.length - 1 && counted[gap + 1] < at) gap += 1;
    const share = (at - counted[gap]) / (counted[gap + 1] - counted[gap]);
    return times[gap] + share * (times[gap + 1] - times[gap]);
  });
  found[count] = /** @type {number} */ (times.at(-1)) * (ending === LOSSY.horizon ? 1 : LOSSY_LATER);
  return found;
}
