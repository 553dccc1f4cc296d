/** The whole state in the fragment of the address, so that it can be shared, kept and gone back to. */

import { motionEntries, numberOf, readMotion } from "eulerdisk/address_motion";
import { SPEEDS } from "eulerdisk/motion/clock";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @import { Point, State } from "eulerdisk/state" */
/** @import { About, Axis } from "eulerdisk/types" */

/** Characters of an address at most: one that a page writes has some hundred. */
const MOST = 16_384;

/** Digits of a time that is kept: finer than a picture of a motion. */
const TIME_DIGITS = 6;

/** Largest number of an axis: a server computes with no larger one. */
const LARGEST = 1e12;

/** Words of a view have this before their names, so that none is taken for an entry of the page. */
const WORD = "with.";

/** Characters of a word of a view at most. */
const MOST_TEXT = 200;

/** The two chosen points, and the lines that can be hidden. */
const LETTERS = ["a", "b"];
const LINES = ["analytic", "predicted", "measured"];

/**
 * Fragment of a state, without "#". Numbers are written so that they are read back to the bit.
 * @param {State} state
 */
export function fragmentOf(state) {
  const { view } = state;
  const entries = [
    ["base", view.base],
    ["x", axisText(view.x)],
    ["y", axisText(view.y)],
  ];
  for (const [name, value] of Object.entries(view.words)) entries.push([WORD + name, String(value)]);
  entries.push(["quantity", state.quantity]);
  state.points.forEach((point, slot) => {
    if (!point) return;
    const letter = LETTERS[slot];
    entries.push([letter, pointText(point)], ...motionEntries(letter, state.motions[slot]));
  });
  if (state.time !== null) entries.push(["time", String(Number(state.time.toPrecision(TIME_DIGITS)))]);
  if (state.speed !== null) entries.push(["speed", String(state.speed)]);
  if (state.compare) entries.push(["compare", "yes"]);
  if (!state.stored) entries.push(["stored", "no"]);
  if (state.hidden.length) entries.push(["hide", state.hidden.join(",")]);
  if (state.range) entries.push(["range", state.range.join(",")]);
  if (state.theme) entries.push(["theme", state.theme]);
  return entries.map(([key, value]) => `${encoded(key)}=${encoded(value)}`).join("&");
}

/** @param {string} text */
function encoded(text) {
  return encodeURIComponent(text).replaceAll("%2C", ",").replaceAll("%3A", ":");
}

/** @param {Axis} axis */
function axisText({ name, centre, half, scale }) {
  return [name, centre, half, scale].join(",");
}

/** @param {Point} point */
function pointText({ x, y }) {
  return `${x},${y}`;
}

/**
 * State of a fragment; what is missing or cannot be read is as at the start.
 * @param {string} fragment  with or without "#"
 * @param {About} about
 * @returns {State}
 */
export function stateOf(fragment, about) {
  const entries = entriesOf(fragment);
  const first = firstState(about, entries.get("base") ?? undefined);
  const x = readAxis(entries.get("x"), about) ?? first.view.x;
  const y = readAxis(entries.get("y"), about) ?? first.view.y;
  // two axes of one parameter are no plane
  const axes = x.name === y.name ? { x: first.view.x, y: first.view.y } : { x, y };
  return {
    view: { base: first.view.base, words: readWords(entries, about), ...axes },
    quantity: known(entries.get("quantity"), quantitiesOf(about, first.view.base)) ?? first.quantity,
    stored: entries.get("stored") !== "no",
    hidden: LINES.filter((name) => (entries.get("hide") ?? "").split(",").includes(name)),
    range: readRange(entries.get("range")),
    points: [readPoint(entries.get(LETTERS[0])), readPoint(entries.get(LETTERS[1]))],
    compare: entries.get("compare") === "yes",
    motions: [readMotion(entries, LETTERS[0], about), readMotion(entries, LETTERS[1], about)],
    time: readPositive(entries.get("time")),
    speed: SPEEDS.find((speed) => String(speed) === entries.get("speed")) ?? null,
    theme: readTheme(entries),
  };
}

/**
 * Light or dark as a fragment has it; empty for that of the system.
 * @param {string} fragment  with or without "#"
 */
export function themeOf(fragment) {
  return readTheme(entriesOf(fragment));
}

/** @param {string} fragment */
function entriesOf(fragment) {
  return new URLSearchParams(fragment.length > MOST ? "" : fragment.replace(/^#/, "").replaceAll("+", "%2B"));
}

/**
 * @param {URLSearchParams} entries
 * @returns {State["theme"]}
 */
function readTheme(entries) {
  const theme = entries.get("theme");
  return theme === "light" || theme === "dark" ? theme : "";
}

/**
 * @param {string|null} name
 * @param {{name: string}[]} table
 */
function known(name, table) {
  return table.find((each) => each.name === name)?.name;
}

/**
 * @param {string|null} text
 * @param {About} about
 * @returns {Axis|null}
 */
function readAxis(text, about) {
  const [name, centre, half, scale] = (text ?? "").split(",");
  const axis = { name, centre: numberOf(centre), half: numberOf(half), scale };
  const possible = Math.abs(axis.centre) <= LARGEST && axis.half > 0 && axis.half <= LARGEST;
  if (!possible || !known(name, about.parameters)) return null;
  return { ...axis, scale: scale === "log" ? "log" : "linear" };
}

/**
 * @param {URLSearchParams} entries
 * @param {About} about
 */
function readWords(entries, about) {
  /** @type {Record<string, number|string>} */
  const words = {};
  for (const [key, text] of entries) {
    const name = key.slice(WORD.length);
    if (!key.startsWith(WORD) || text.trim() === "" || text.length > MOST_TEXT) continue;
    if (name !== "criterion" && !known(name, about.parameters)) continue;
    words[name] = Number.isFinite(Number(text)) ? Number(text) : text;
  }
  return words;
}

/**
 * @param {string|null} text
 * @returns {[number, number]|null}
 */
function readPair(text) {
  const numbers = (text ?? "").split(",").map(numberOf);
  return numbers.length === 2 && numbers.every(Number.isFinite) ? [numbers[0], numbers[1]] : null;
}

/**
 * Ends of the colours, the lower one first.
 * @param {string|null} text
 */
function readRange(text) {
  const pair = readPair(text);
  return pair && pair[0] < pair[1] ? pair : null;
}

/**
 * @param {string|null} text
 * @returns {number|null}
 */
function readPositive(text) {
  const value = Number(text ?? "");
  return Number.isFinite(value) && value > 0 ? value : null;
}

/**
 * @param {string|null} text
 * @returns {Point|null}
 */
function readPoint(text) {
  const pair = readPair(text);
  return pair && { x: pair[0], y: pair[1] };
}
