/** The page's state as one plain object, and the changes to it. All functions return new objects. */

import { axisBetween, valueAt, within } from "eulerdisk/axis_window";

/** @import { About, Axis, Base, MotionSettings, Parameter, Quantity, View } from "eulerdisk/types" */

/** @type {MotionSettings} settings of a motion that nobody changed */
export const UNSET = { losses: {}, camera: null, open: [] };

/**
 * A chosen point: the values along both axes.
 * @typedef {{x: number, y: number}} Point
 */

/**
 * `stored` shows the cells of a file where it has some; `hidden` names lines that are not drawn; `range` contains the
 * ends of the colour scale, null fits them to the window; `points` are the two chosen points, of which the second is
 * shown if `compare`, and `motions` are the settings of their motions. `time` is where their clock was stopped, in
 * seconds, null if it was not; `speed` is the chosen speed of the clock.
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
 * @property {""|"light"|"dark"} theme  empty to follow the system
 */

/**
 * Return the initial state of a base.
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
 * Return the base of a view.
 * @param {About} about
 * @param {View} view
 * @returns {Base}
 */
export function baseOf(about, view) {
  return about.bases.find((each) => each.name === view.base) ?? about.bases[0];
}

/**
 * Return the quantities that can be shown of a base, the default one first.
 * @param {About} about
 * @param {string} name  of the base
 * @returns {Quantity[]}
 */
export function quantitiesOf(about, name) {
  const base = about.bases.find((each) => each.name === name) ?? about.bases[0];
  return base.quantities.map((each) => quantityOf(about, each));
}

/**
 * Return the parameter with a name.
 * @param {About} about
 * @param {string} name
 * @returns {Parameter}
 */
export function parameterOf(about, name) {
  const found = about.parameters.find((each) => each.name === name);
  if (!found) throw new Error(`No parameter is named ${name}.`);
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
 * Return the value of a parameter that is no axis, or of the criterion: from the view, otherwise from its base.
 * @param {About} about
 * @param {View} view
 * @param {string} name
 * @returns {number|string|undefined}
 */
export function wordOf(about, view, name) {
  return view.words[name] ?? baseOf(about, view).words[name];
}

/**
 * Return the view with another value of a word, omitting a value equal to the base's own.
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

/** Rates; in units of sqrt(g/R), the map is the same for all radii. */
const RATES = ["tilt_rate", "precession_rate", "roll_rate"];

/**
 * Return the unit sqrt(g/R) of the rates of a view, divided by that of its base; 1 for a system, whose parameters have
 * no fixed meaning.
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
 * Return the axis with its values multiplied by a factor if it is a rate, otherwise the axis itself.
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
 * Return the state with another value of a word. Another radius or gravity keeps the map and the chosen starts where
 * they are in scaled rates.
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
 * Return the view with another parameter along an axis. The replaced parameter keeps the value in the middle, or the
 * nearest one on its slider: a window may be wider than the allowed range. If the other axis has the new parameter, the
 * axes swap.
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
 * Return the initial range of a parameter that becomes an axis: the base's range if it is an axis there.
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
 * Return the view whose axis has the other scale, over the same range if a logarithm allows it; the view itself if no
 * values are positive.
 * @param {View} view
 * @param {"x"|"y"} which
 * @returns {View}
 */
export function withOtherScale(view, which) {
  const axis = view[which];
  const [low, high] = [valueAt(axis, -1), valueAt(axis, 1)];
  const scale = axis.scale === "log" ? "linear" : "log";
  if (scale === "log" && high <= 0) return view;
  // a logarithmic axis cannot start at 0 or below: start at a thousandth of its end
  const from = scale === "log" && low <= 0 ? high / 1000 : low;
  return { ...view, [which]: axisBetween(axis.name, from, high, scale) };
}

/**
 * Return half the width of a side that shows its whole range, in its present scale.
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
 * Return the view restricted to starts that exist: axes within the allowed ranges of their parameters, without
 * forbidden numbers.
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
 * Return the parameters of a base, axes or not, in the order of the model.
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
 * Return the description of a verdict.
 * @param {About} about
 * @param {number} code
 */
export function verdictWords(about, code) {
  return about.quantities.find(({ name }) => name === "stability")?.flags?.[String(code)] ?? "";
}

/**
 * Return everything in a view except its window, as a key: with equal keys, every start has the same motion, and the
 * lines are the same.
 * @param {View} view
 */
export function wordsOf({ base, words, x, y }) {
  return JSON.stringify([base, words, x.name, y.name]);
}

/**
 * Return whether a view shows only stored cells, so that its words and axes cannot be changed.
 * @param {About} about
 * @param {View} view
 */
export function isFixed({ atlas }, view) {
  return atlas !== null && !atlas.live && atlas.base === view.base;
}

/**
 * Return the settings of both motions, with new settings for one of them.
 * @template Settings
 * @param {[Settings, Settings]} both
 * @param {number} slot
 * @param {Settings} settings
 * @returns {[Settings, Settings]}
 */
export function withSlot(both, slot, settings) {
  return slot === 0 ? [settings, both[1]] : [both[0], settings];
}
