/** Windows and points that the page computes according to a plan. */

import { leastHalf } from "eulerdisk/axis_window";
import { pieces } from "eulerdisk/compute/computation";
import { spelled } from "eulerdisk/compute/spelling";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { BodyPlan, Plan, Place, PointAnswer, ToldNumber, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/** Digits of a displayed number, in double and in single precision. */
const DIGITS = 6;
const SINGLE_DIGITS = 3;

/**
 * Return whether a window takes the page more than 1.5 times as long as the program, whose vectors are wider, as
 * measured by scripts/page_speed.py. The reduction does not.
 * @param {Plan} plan
 */
export function isSlow(plan) {
  return "system" in plan;
}

/**
 * Return the kind of cells that determines the time per cell of a window.
 * @param {Plan} plan
 * @param {string} quantity
 */
function kindOf(plan, quantity) {
  if ("system" in plan) return "system";
  if ([quantity, ...plan.criterion.named].some((name) => plan.path.includes(name))) return "path";
  if ("body" in plan) return "body";
  return isTimed(plan, quantity) ? "timed" : "plain";
}

/**
 * @param {Plan} plan
 * @param {string} quantity
 */
function isTimed(plan, quantity) {
  return plan.timed.includes(quantity) || plan.criterion.timed;
}

/**
 * Return a window, computed piece by piece.
 * @param {Computation} computation
 * @param {Plan} plan
 * @param {WindowRequest} request
 * @param {AbortSignal} [signal]
 * @returns {Promise<WindowAnswer>}
 */
export async function computedWindow(computation, plan, { view, width, height, quantity }, signal) {
  await computation.ready;
  const began = performance.now();
  const timed = isTimed(plan, quantity);
  // cells of one body share the tables of its motions
  const shape = "body" in plan ? /** @type {BodyPlan} */ (plan).body.shape : ["alpha"];
  const byColumns = shape.includes(view.x.name);
  const kind = kindOf(plan, quantity);
  const parts = pieces({ width, height, byColumns, kind, workers: computation.size });
  const side = (
    /** @type {"x"|"y"} */ which,
    /** @type {number} */ count,
    /** @type {[number, number]} */ [from, to],
  ) => ({
    axis: view[which],
    count,
    from,
    to,
  });
  /** @type {any} */
  let value = null;
  const verdict = new Uint8Array(width * height);
  let [low, high, least] = [Infinity, -Infinity, Infinity];
  const put = (
    /** @type {any} */ found,
    /** @type {{x: [number, number], y: [number, number]}} */ { x, y },
  ) => {
    value ??= new found.value.constructor(width * height);
    copy(value, found.value, x, y, width);
    copy(verdict, found.verdict, x, y, width);
    low = Math.min(low, found.low);
    high = Math.max(high, found.high);
    least = Math.min(least, found.least);
  };
  await Promise.all(
    parts.map(async (part) => {
      const sides = { x: side("x", width, part.x), y: side("y", height, part.y) };
      const asked = { plan, quantity, timed, byColumns, ...sides };
      put(await computation.ask("piece", asked, { order: parts.length, signal }), part);
    }),
  );
  const known = (/** @type {number} */ each) => (Number.isFinite(each) ? each : null);
  const end = view.x.half < leastHalf(view.x, width) || view.y.half < leastHalf(view.y, height);
  const head = { low: known(low), high: known(high), least: known(least), end, note: "" };
  const milliseconds = performance.now() - began;
  return { head, width, height, value, verdict, stored: null, milliseconds };
}

/**
 * Copy the values of a piece to their position in the window.
 * @param {any} all
 * @param {any} some
 * @param {[number, number]} x
 * @param {[number, number]} y
 * @param {number} width
 */
function copy(all, some, x, y, width) {
  const count = x[1] - x[0];
  if (count === width) all.set(some, y[0] * width);
  else {
    for (let row = y[0]; row < y[1]; row += 1) {
      const from = (row - y[0]) * count;
      all.set(some.subarray(from, from + count), row * width + x[0]);
    }
  }
}

/**
 * Return all columns of the cell at a place, each with a single number.
 * @param {Computation} computation
 * @param {Plan} plan
 * @param {Place} place
 * @param {AbortSignal} [signal]
 * @returns {Promise<Record<string, number>>}
 */
export async function cellAt(computation, plan, { view, x, y }, signal) {
  const given = { [view.x.name]: Float64Array.of(x), [view.y.name]: Float64Array.of(y) };
  const columns = await computation.ask("cells", { plan, given, count: 1 }, { signal });
  return Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, Number(values[0])]));
}

/**
 * Return the numbers of the cell at a place.
 * @param {Plan} plan
 * @param {Record<string, number>} cell
 * @param {Record<string, string>} verdicts  descriptions of the verdicts
 * @returns {PointAnswer}
 */
export function toldCell(plan, cell, verdicts) {
  const told = new Map(plan.numbers.map((each) => [each.name, each]));
  const start = plan.starts.map((each) => [each.name, shown(each, cell[each.name])]);
  const numbers = plan.numbers
    .filter(({ name }) => name in cell)
    .map(({ name, label, description }) => ({
      name,
      label,
      description,
      ...shown(/** @type {ToldNumber} */ (told.get(name)), cell[name]),
    }));
  const verdict = verdicts[String(cell.stability)] ?? "";
  return { start: Object.fromEntries(start), numbers, verdict, stored: null };
}

/**
 * Return a number and its text.
 * @param {ToldNumber} told
 * @param {number} value
 * @returns {{value: number|null, text: string}}
 */
export function shown(told, value) {
  if (told.flags) return { value, text: told.flags[String(value)] ?? String(value) };
  if (!Number.isFinite(value)) return { value: null, text: "none" };
  return { value, text: spelled(told, value, told.single ? SINGLE_DIGITS : DIGITS) };
}
