/** The motion of a start of a user's system, computed by the page: its states at each sample. */

import { spelled } from "eulerdisk/compute/spelling";
import { Problem } from "eulerdisk/notice";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { MotionAnswer, MotionRequest, SystemPlan, ToldNumber } from "eulerdisk/types" */

/**
 * Samples per step of the last pass, as in sweep/motion/system_path.py; the least and the largest number that are
 * drawn.
 */
const IN_A_STEP = 5;
const OF_LAST = 0.42;
const FEWEST = 200;
const MOST = 4000;

/** Digits of a start, and of a time. */
const DIGITS = 6;
const TIME_DIGITS = 4;

/**
 * Return the answer that the page draws for the motion of a start.
 * @param {Computation} computation
 * @param {SystemPlan} plan
 * @param {MotionRequest} request
 * @param {AbortSignal} signal
 * @returns {Promise<MotionAnswer>}
 */
export async function systemMotion(computation, plan, { view, x, y }, signal) {
  const given = { [view.x.name]: Float64Array.of(x), [view.y.name]: Float64Array.of(y) };
  const sample = (/** @type {Float64Array} */ times) =>
    computation.ask("samples", { plan, given, times }, { signal });
  const { end_time: endTime, runs_on: runsOn, different, states, state_ends: stateEnds } = plan.system;
  const [duration] = plan.kernel_settings;
  const whole = await sample(Float64Array.of(0, duration));
  const [end, ending] = [whole[endTime][1], whole.ending[1]];
  const told = new Map([...plan.starts, ...plan.numbers].map((each) => [each.name, each]));
  const rowOf = (/** @type {string} */ name) => /** @type {ToldNumber} */ (told.get(name));
  const time = (/** @type {number} */ value) => spelled(rowOf(endTime), value, TIME_DIGITS);
  if (plan.failed.includes(ending)) {
    throw new Problem(`This motion could not be followed beyond ${time(end)}.`, {
      hint: "Its explanation says why, and what helps.",
      status: 400,
    });
  }
  const endingWords = rowOf("ending").flags?.[String(ending)].replaceAll("_", " ") ?? "";
  if (!(end > 0)) {
    throw new Problem(`This motion has ended before it starts: its ending is ${endingWords}.`, {
      hint: "Choose another place on the map.",
      status: 400,
    });
  }
  const steps = whole.steps[1];
  const count = Math.min(Math.max(Math.ceil(IN_A_STEP * OF_LAST * steps), FEWEST), MOST);
  // the last column, at the duration, contains the end itself
  const times = Float64Array.from({ length: count + 1 }, (_, i) =>
    i < count ? (i * end) / count : duration,
  );
  const found = await sample(times);
  times[count] = end;
  // the passes may separate on the way and meet again
  const known = found.ending.findLastIndex((/** @type {number} */ code) => code !== different);
  const doubtful = known < count ? times[known + 1] : null;
  const isEnded = ending !== runsOn && ending !== different;
  const described = (/** @type {string} */ name) => {
    const { label, unit, factor } = rowOf(name);
    return { label, unit, factor };
  };
  const sides = [view.x.name, view.y.name];
  const values = { [view.x.name]: x, [view.y.name]: y };
  const head = /** @type {any} */ ({
    title: sides
      .map((name) => `${rowOf(name).label} ${spelled(rowOf(name), values[name], DIGITS)}`)
      .join(", "),
    ending: isEnded ? `${endingWords} at ${time(end)}` : `followed for ${time(end)}`,
    ended: isEnded,
    note:
      doubtful === null
        ? ""
        : `Beyond ${time(doubtful)} this motion is too sensitive to its start to be known: the curve there is one of many possible ones.`,
    states,
    doubtful,
    lossy: false,
    losses: [],
    ledger: null,
    turns: [],
    period: null,
    quantities: {
      time: { ...described(endTime), label: "time" },
      ...Object.fromEntries(states.map((name) => [name, described(name)])),
    },
  });
  const rows = states.map((name, i) => [name, found[stateEnds[i].name]]);
  return { head, arrays: { time: times, ...Object.fromEntries(rows) } };
}
