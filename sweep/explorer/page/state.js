/** What the page shows, as one plain object, and the changes that can be made to it. Nothing here is changed in place. */

import { axisBetween, valueAt, within } from "eulerdisk/axis_window";

/** @import { About, Axis, Base, MotionSettings, Parameter, Quantity, View } from "eulerdisk/types" */

/** @type {MotionSettings} nothing is set of a motion */
export const UNSET = { losses: {}, camera: null, open: [] };

/**
 * A chosen point: the values along both axes.
 * @typedef {{x: number, y: number}} Point
 */

/**
 * `stored` shows the cells of a file where there are some; `hidden` names lines that are not drawn; `range` holds the ends
 * of the colours, null fits them to the window; `points` are the two chosen ones, the second one is shown if `compare`,
 * and `motions` what is set of the motion of each. `time` is where their clock was put to rest in seconds, null if it was
 * not, `speed` the one that was chosen for it.
 * @typedef {object} State
 * @property {View} view
 * @property {string} quantity
 * @property {boolean} stored
 * @property {string[]} hidden
 * @property {[number, number]|null} range
 * @property {[Point|null, Point|null]} points
 * @property {boolean} compare
 * @property {[MotionSettings, MotionSettings]} motions
 * @property {number|null} time
 * @property {number|null} speed
 * @property {""|"light"|"dark"} theme  empty for that of the system
 */

/**
 * What is shown first of a base.
 * @param {About} about
 * @param {string} [name]  of the base
 * @returns {State}
 */
export function firstState(about, name) {
  const base = about.bases.find((each) => each.name === name) ?? about.bases[0];
  return {
    view: { base: base.name, words: {}, x: base.view.x, y: base.view.y },
    quantity: quantitiesOf(about, base.name)[0].name,
    stored: true,
    hidden: [],
    range: null,
    points: [null, null],
    compare: false,
    motions: [UNSET, UNSET],
    time: null,
    speed: null,
    theme: "",
  };
}

/**
 * The base of a view.
 * @param {About} about
 * @param {View} view
 * @returns {Base}
 */
export function baseOf(about, view) {
  return about.bases.find((each) => each.name === view.base) ?? about.bases[0];
}

/**
 * What can be shown of a base, the usual one first.
 * @param {About} about
 * @param {string} name  of the base
 * @returns {Quantity[]}
 */
export function quantitiesOf(about, name) {
  const base = about.bases.find((each) => each.name === name) ?? about.bases[0];
  return base.quantities.map((each) => quantityOf(about, each));
}

/**
 * Parameter of a name.
 * @param {About} about
 * @param {string} name
 * @returns {Parameter}
 */
export function parameterOf(about, name) {
  const found = about.parameters.find((each) => each.name === name);
  if (!found) throw new Error(`There is no parameter ${name}.`);
  return found;
}

/**
 * @param {About} about
 * @param {string} name
 * @returns {Quantity}
 */
export function quantityOf(about, name) {
  return about.quantities.find((each) => each.name === name) ?? about.quantities[0];
}

/**
 * Value of a parameter that is no axis, or of the criterion: that of the view, else that of its base.
 * @param {About} about
 * @param {View} view
 * @param {string} name
 * @returns {number|string|undefined}
 */
export function wordOf(about, view, name) {
  return view.words[name] ?? baseOf(about, view).words[name];
}

/**
 * View with another value of a word; one that is the base's own is left out.
 * @param {About} about
 * @param {View} view
 * @param {string} name
 * @param {number|string} value
 * @returns {View}
 */
export function withWord(about, view, name, value) {
  const words = { ...view.words };
  if (baseOf(about, view).words[name] === value) delete words[name];
  else words[name] = value;
  return { ...view, words };
}

/** Rates, of which the map is the same for all radii in units of sqrt(g/R). */
const RATES = ["tilt_rate", "precession_rate", "roll_rate"];

/**
 * The unit sqrt(g/R) of the rates of a view over that of its base; 1 of a system, whose parameters mean what they like.
 * @param {About} about
 * @param {View} view
 */
function rateUnit(about, view) {
  const { words } = baseOf(about, view);
  /** @param {string} name */
  const share = (name) => Number(wordOf(about, view, name)) / Number(words[name]);
  const ratio = about.criteria.length ? Math.sqrt(share("gravity") / share("radius")) : 1;
  return ratio > 0 && Number.isFinite(ratio) ? ratio : 1;
}

/**
 * Axis whose rates are so many times as large; of another parameter the axis itself.
 * @param {Axis} axis
 * @param {number} times
 * @returns {Axis}
 */
function withRatesTimes(axis, times) {
  if (times === 1 || !RATES.includes(axis.name)) return axis;
  if (axis.scale === "log") return { ...axis, centre: axis.centre + Math.log(times) };
  return { ...axis, centre: axis.centre * times, half: axis.half * times };
}

/**
 * State with another value of a word. Another radius or gravity leaves the map and the chosen starts where they are in
 * scaled rates.
 * @param {About} about
 * @param {State} state
 * @param {string} name
 * @param {number|string} value
 * @returns {State}
 */
export function withValue(about, state, name, value) {
  const view = withWord(about, state.view, name, value);
  const times = rateUnit(about, view) / rateUnit(about, state.view);
  const [x, y] = [withRatesTimes(view.x, times), withRatesTimes(view.y, times)];
  const [alongX, alongY] = [view.x, view.y].map((axis) => (RATES.includes(axis.name) ? times : 1));
  const moved = (/** @type {Point|null} */ point) => point && { x: point.x * alongX, y: point.y * alongY };
  const [a, b] = state.points;
  return { ...state, view: { ...view, x, y }, points: [moved(a), moved(b)] };
}

/**
 * View with another parameter along an axis. The one that was there keeps the value in the middle, or the nearest that
 * its slider has: a window may be wider than the domain. If the other axis has the parameter, both change places.
 * @param {About} about
 * @param {View} view
 * @param {"x"|"y"} which
 * @param {string} name
 * @returns {View}
 */
export function withAxis(about, view, which, name) {
  const other = which === "x" ? "y" : "x";
  if (view[which].name === name) return view;
  if (view[other].name === name) return { ...view, x: view.y, y: view.x };
  const old = view[which];
  const { low, high } = parameterOf(about, old.name);
  const middle = Math.min(Math.max(valueAt(old, 0), low ?? -Infinity), high ?? Infinity);
  const words = { ...view.words, [old.name]: middle };
  delete words[name];
  return { ...view, words, [which]: firstAxis(about, view, name) };
}

/**
 * Range of a parameter that becomes an axis: that of the base if it is an axis there.
 * @param {About} about
 * @param {View} view
 * @param {string} name
 */
export function firstAxis(about, view, name) {
  const base = baseOf(about, view).view;
  const times = rateUnit(about, view);
  for (const axis of [base.x, base.y]) if (axis.name === name) return withRatesTimes(axis, times);
  const { low, high, scale } = parameterOf(about, name);
  return axisBetween(name, low ?? -1, high ?? 1, scale);
}

/**
 * View whose axis has the other scale, over the same range where a logarithm allows that; without positive values the
 * view itself.
 * @param {View} view
 * @param {"x"|"y"} which
 * @returns {View}
 */
export function withOtherScale(view, which) {
  const axis = view[which];
  const [low, high] = [valueAt(axis, -1), valueAt(axis, 1)];
  const scale = axis.scale === "log" ? "linear" : "log";
  if (scale === "log" && high <= 0) return view;
  // a logarithmic axis that would begin at 0 or below begins at a thousandth of its end
  const from = scale === "log" && low <= 0 ? high / 1000 : low;
  return { ...view, [which]: axisBetween(axis.name, from, high, scale) };
}

/**
 * Half of the width of a side that shows all of its range, in the scale that it has.
 * @param {About} about
 * @param {View} view
 * @param {"x"|"y"} which
 */
export function halfOfRange(about, view, which) {
  const { name, scale } = view[which];
  const whole = { ...view, [which]: firstAxis(about, view, name) };
  return (whole[which].scale === scale ? whole : withOtherScale(whole, which))[which].half;
}

/**
 * View of starts that exist: no axis goes beyond what its parameter may be, and a number that it may not be is left out.
 * @param {About} about
 * @param {View} view
 * @returns {View}
 */
export function withinDomain(about, view) {
  const [x, y] = [view.x, view.y].map((axis) => {
    const { least, most } = parameterOf(about, axis.name);
    return within(axis, least, most);
  });
  const allowed = Object.entries(view.words).filter(([name, value]) => {
    const { least, most } = about.parameters.find((each) => each.name === name) ?? {
      least: null,
      most: null,
    };
    return (
      typeof value !== "number" || ((least === null || value >= least) && (most === null || value <= most))
    );
  });
  return { ...view, words: Object.fromEntries(allowed), x, y };
}

/**
 * Parameters that a base has, as axes or otherwise, in the order of the model.
 * @param {About} about
 * @param {View} view
 * @returns {Parameter[]}
 */
export function parametersOf(about, view) {
  const { words, view: first } = baseOf(about, view);
  return about.parameters.filter(
    ({ name }) => name in words || name === first.x.name || name === first.y.name,
  );
}

/**
 * Words of a verdict.
 * @param {About} about
 * @param {number} code
 */
export function verdictWords(about, code) {
  return about.quantities.find(({ name }) => name === "stability")?.flags?.[String(code)] ?? "";
}

/**
 * All of a view but its window: the same where every start has the same motion, and lines are the same.
 * @param {View} view
 */
export function wordsOf({ base, words, x, y }) {
  return JSON.stringify([base, words, x.name, y.name]);
}

/**
 * Whether a view shows stored cells alone, so that its words and axes are as they are.
 * @param {About} about
 * @param {View} view
 */
export function isFixed({ atlas }, view) {
  return atlas !== null && !atlas.live && atlas.base === view.base;
}

/**
 * Settings of both motions with others for one of them.
 * @template Settings
 * @param {[Settings, Settings]} both
 * @param {number} slot
 * @param {Settings} settings
 * @returns {[Settings, Settings]}
 */
export function withSlot(both, slot, settings) {
  return slot === 0 ? [settings, both[1]] : [both[0], settings];
}
