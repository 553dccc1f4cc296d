/** The whole state in the fragment of the address, so that it can be shared, kept and revisited. */

import { SPEEDS } from "eulerdisk/motion/clock";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @import { About, Axis, MotionSettings } from "eulerdisk/types" */
/** @import { Point, State } from "eulerdisk/state" */

/** Largest length of an address [characters]; the page's own addresses have some hundred. */
const MOST = 16_384;

/** Digits of a time and of a camera position: finer than a picture of a motion can show. */
const DIGITS = 6;

/** Largest number of an axis: a server computes with no larger ones. */
const LARGEST = 1e12;

/** Prefix of the names of a view's words, and of losses, which distinguishes them from the page's own entries. */
const WORD = "with.";
const LOSS = "loss.";

/** Largest length of a word, and of a word of a loss [characters]. */
const MOST_TEXT = 200;
const MOST_LOSS = 40;

/** Letters of the two chosen points, the lines that can be hidden, and the parts of a motion that can be open. */
const LETTERS = ["a", "b"];
const LINES = ["analytic", "predicted", "measured"];
const PARTS = ["laws", "words"];

/**
 * Return the fragment of a state, without "#". Numbers are written so that they are read back exactly.
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
    entries.push(
      [LETTERS[slot], `${point.x},${point.y}`],
      ...motionEntries(LETTERS[slot], state.motions[slot]),
    );
  });
  if (state.time !== null) entries.push(["time", shortened(state.time)]);
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

/** @param {number} value */
function shortened(value) {
  return String(Number(value.toPrecision(DIGITS)));
}

/**
 * Return the settings of a motion as entries: "a.loss.friction=0.3", "a.camera=0.2,0.4,6", "a.open=laws".
 * @param {string} letter
 * @param {MotionSettings} settings
 */
function motionEntries(letter, { losses, camera, open }) {
  const entries = Object.entries(losses).map(([name, value]) => [LOSS + name, String(value)]);
  if (camera) entries.push(["camera", camera.map(shortened).join(",")]);
  if (open.length) entries.push(["open", open.join(",")]);
  return entries.map(([name, text]) => [`${letter}.${name}`, text]);
}

/**
 * Return the state in a fragment; missing or unreadable entries have their initial values.
 * @param {string} fragment  with or without "#"
 * @param {About} about
 * @returns {State}
 */
export function stateOf(fragment, about) {
  const entries = entriesOf(fragment);
  const first = firstState(about, entries.get("base") ?? undefined);
  const x = readAxis(entries.get("x"), about) ?? first.view.x;
  const y = readAxis(entries.get("y"), about) ?? first.view.y;
  // two axes of the same parameter do not span a plane
  const axes = x.name === y.name ? { x: first.view.x, y: first.view.y } : { x, y };
  return {
    view: { base: first.view.base, words: readWords(entries, about), ...axes },
    quantity: known(entries.get("quantity"), quantitiesOf(about, first.view.base)) ?? first.quantity,
    stored: entries.get("stored") !== "no",
    hidden: readNames(entries.get("hide"), LINES),
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
 * Return the theme in a fragment; empty to follow the system.
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
 * Return those of the names that a text contains, in their order.
 * @param {string|null} text
 * @param {string[]} names
 */
function readNames(text, names) {
  const found = (text ?? "").split(",");
  return names.filter((name) => found.includes(name));
}

/**
 * Return numbers separated by commas; null if one is invalid, or their count is wrong. Empty text is invalid, although
 * `Number` reads it as zero.
 * @param {string|null} text
 * @param {number} count
 */
function readNumbers(text, count) {
  const numbers = (text ?? "").split(",").map((each) => (each.trim() === "" ? NaN : Number(each)));
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

/**
 * Return a number or a word; undefined if there is none.
 * @param {string|null} text
 * @param {number} [most]  characters
 */
function readValue(text, most = MOST_TEXT) {
  if (text === null || text.trim() === "" || text.length > most) return undefined;
  return Number.isFinite(Number(text)) ? Number(text) : text;
}

/**
 * @param {string|null} text
 * @param {About} about
 * @returns {Axis|null}
 */
function readAxis(text, about) {
  const [name, ...numbers] = (text ?? "").split(",");
  const scale = numbers.pop() === "log" ? "log" : "linear";
  const [centre, half] = readNumbers(numbers.join(","), 2) ?? [NaN, NaN];
  const possible = Math.abs(centre) <= LARGEST && half > 0 && half <= LARGEST;
  return possible && known(name, about.parameters) ? { name, centre, half, scale } : null;
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
    const value = readValue(text);
    if (!key.startsWith(WORD) || value === undefined) continue;
    if (name === "criterion" || known(name, about.parameters)) words[name] = value;
  }
  return words;
}

/**
 * Return the settings of a motion; unreadable ones have their initial values.
 * @param {URLSearchParams} entries
 * @param {string} letter
 * @param {About} about
 * @returns {MotionSettings}
 */
function readMotion(entries, letter, about) {
  const losses = about.losses.map((name) => [
    name,
    readValue(entries.get(`${letter}.${LOSS}${name}`), MOST_LOSS),
  ]);
  const camera = readNumbers(entries.get(`${letter}.camera`), 3);
  return {
    losses: Object.fromEntries(losses.filter(([, value]) => value !== undefined)),
    camera: camera && camera[2] > 0 ? [camera[0], camera[1], camera[2]] : null,
    open: readNames(entries.get(`${letter}.open`), PARTS),
  };
}

/**
 * Return the ends of the colour scale, the lower one first.
 * @param {string|null} text
 * @returns {[number, number]|null}
 */
function readRange(text) {
  const pair = readNumbers(text, 2);
  return pair && pair[0] < pair[1] ? [pair[0], pair[1]] : null;
}

/** @param {string|null} text */
function readPositive(text) {
  const [value] = readNumbers(text, 1) ?? [0];
  return value > 0 ? value : null;
}

/**
 * @param {string|null} text
 * @returns {Point|null}
 */
function readPoint(text) {
  const pair = readNumbers(text, 2);
  return pair && { x: pair[0], y: pair[1] };
}
