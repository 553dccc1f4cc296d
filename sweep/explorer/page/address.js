/** The whole state in the fragment of the address, so that it can be shared, kept and gone back to. */

import { SPEEDS } from "eulerdisk/motion/clock";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @import { About, Axis, MotionSettings } from "eulerdisk/types" */
/** @import { Point, State } from "eulerdisk/state" */

/** Characters of an address at most: one that a page writes has some hundred. */
const MOST = 16_384;

/** Digits of a time and of the place of a camera: finer than a picture of a motion. */
const DIGITS = 6;

/** Largest number of an axis: a server computes with no larger one. */
const LARGEST = 1e12;

/** Words of a view have this before their names, so that none is taken for an entry of the page; so have losses. */
const WORD = "with.";
const LOSS = "loss.";

/** Characters of a word at most, and of one of a loss. */
const MOST_TEXT = 200;
const MOST_LOSS = 40;

/** The two chosen points, the lines that can be hidden, and the parts of a motion that can be open. */
const LETTERS = ["a", "b"];
const LINES = ["analytic", "predicted", "measured"];
const PARTS = ["laws", "words"];

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
 * What is set of a motion: "a.loss.friction=0.3", "a.camera=0.2,0.4,6", "a.open=laws".
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
 * Those of some names that a text has, in their order.
 * @param {string|null} text
 * @param {string[]} names
 */
function readNames(text, names) {
  const found = (text ?? "").split(",");
  return names.filter((name) => found.includes(name));
}

/**
 * Numbers with commas between them; null where one is none, or there are fewer or more. An empty text is none, which
 * `Number` reads as zero.
 * @param {string|null} text
 * @param {number} count
 */
function readNumbers(text, count) {
  const numbers = (text ?? "").split(",").map((each) => (each.trim() === "" ? NaN : Number(each)));
  return numbers.length === count && numbers.every(Number.isFinite) ? numbers : null;
}

/**
 * A number or a word; undefined for none.
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
 * What is set of a motion; what cannot be read is as at the start.
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
 * Ends of the colours, the lower one first.
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
