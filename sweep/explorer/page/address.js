/** The whole state in the fragment of the address, so that it can be shared, kept and gone back to. */

import { firstState, quantitiesOf } from "eulerdisk/state";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Axis} Axis */
/** @typedef {import("eulerdisk/state").State} State */
/** @typedef {import("eulerdisk/state").Point} Point */

/** Words of a view have this before their names, so that none is taken for an entry of the page. */
const WORD = "with.";

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
  const [first, second] = state.points;
  if (first) entries.push(["a", pointText(first)]);
  if (second) entries.push(["b", pointText(second)]);
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
  const entries = new URLSearchParams(fragment.replace(/^#/, "").replaceAll("+", "%2B"));
  const first = firstState(about, entries.get("base") ?? undefined);
  const theme = entries.get("theme");
  const x = readAxis(entries.get("x"), about) ?? first.view.x;
  const y = readAxis(entries.get("y"), about) ?? first.view.y;
  // two axes of one parameter are no plane
  const axes = x.name === y.name ? { x: first.view.x, y: first.view.y } : { x, y };
  return {
    view: { base: first.view.base, words: readWords(entries, about), ...axes },
    quantity: known(entries.get("quantity"), quantitiesOf(about, first.view.base)) ?? first.quantity,
    stored: entries.get("stored") !== "no",
    hidden: (entries.get("hide") ?? "").split(",").filter(Boolean),
    range: readPair(entries.get("range")),
    points: [readPoint(entries.get("a")), readPoint(entries.get("b"))],
    compare: entries.get("compare") === "yes",
    theme: theme === "light" || theme === "dark" ? theme : "",
  };
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
  const axis = { name, centre: Number(centre), half: Number(half), scale };
  const possible =
    Number.isFinite(axis.centre) && Number.isFinite(axis.half) && axis.half > 0 && centre !== "";
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
    if (!key.startsWith(WORD) || text === "") continue;
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
  const [low, high] = (text ?? "").split(",").map(Number);
  return Number.isFinite(low) && Number.isFinite(high) && text ? [low, high] : null;
}

/**
 * @param {string|null} text
 * @returns {Point|null}
 */
function readPoint(text) {
  const pair = readPair(text);
  return pair && { x: pair[0], y: pair[1] };
}
