/** Sliders with a number beside them: of parameters, linear or logarithmic, and of the criterion. */

import { html } from "eulerdisk/html";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Parameter} Parameter */

/**
 * A row of the controls; `follow` shows a value, undefined where there is none.
 * @typedef {{name: string, element: HTMLElement, follow: (value: number|string|undefined) => void}} Row
 */

/** @typedef {(value: any) => void} SetValue  takes a number in SI units, or words */

/**
 * `low` and `high` are the ends of a slider; a number that is written lies above and below others, if they are given.
 * @typedef {{low: number, high: number, scale: "linear"|"log", factor: number, unit: string, above?: number|null, below?: number|null}} Ruler
 */

/** No tilt departs farther, in degrees. */
const HALF_TURN = 180;

/** Steps of a slider from end to end. */
const STEPS = 1000;

/**
 * Slider of a parameter. A double click on its name goes back to the value of the base.
 * @param {Parameter} parameter
 * @param {number|string} first  the value of the base
 * @param {SetValue} set
 * @returns {Row}
 */
export function parameterSlider(parameter, first, set) {
  const { name, label, description, words } = parameter;
  const ruler = { ...parameter, low: parameter.low ?? 0, high: parameter.high ?? 1 };
  const row = numberRow(name, label, description, ruler, set);
  row.caption.addEventListener("dblclick", () => set(first));
  if (typeof first === "number") return { name, element: row.element, follow: row.follow };
  const choice = html("select", { "aria-label": `${label}: a number or a word`, id: `word-${name}` });
  choice.append(
    html("option", { value: "" }, "number"),
    ...words.map((word) => html("option", { value: word }, word)),
  );
  choice.addEventListener("change", () => set(choice.value || (ruler.low + ruler.high) / 2));
  row.caption.after(choice);
  return {
    name,
    element: row.element,
    follow: (value) => {
      choice.value = typeof value === "string" ? value : "";
      row.element.classList.toggle("word", typeof value === "string");
      row.follow(value);
    },
  };
}

/**
 * Row of a value that cannot be changed.
 * @param {string} name
 * @param {string} label
 * @param {{factor: number, unit: string}} [shown]
 * @returns {Row}
 */
export function textRow(name, label, shown) {
  const text = html("span", { class: "number" });
  return {
    name,
    element: html(
      "div",
      { class: "slider" },
      html("div", { class: "caption" }, html("span", {}, label), text),
    ),
    follow: (value) => {
      const words =
        typeof value === "number" && shown ? `${readable(value * shown.factor, 6)} ${shown.unit}` : value;
      text.textContent = printedUnits(String(words ?? "")).trim();
    },
  };
}

/**
 * Slider of the limit of the criterion, and its kind.
 * @param {About} about
 * @param {SetValue} set
 * @returns {Row}
 */
export function criterionSlider(about, set) {
  const kinds = about.criteria.map(({ word, description }) =>
    html("option", { value: word, title: description }, word),
  );
  const own = html("option", { value: "" }, "another one");
  const kind = html("select", { id: "criterion-kind", "aria-label": "criterion" }, ...kinds, own);
  const text = html("span", { class: "own-criterion" });
  /** @type {Map<string, ReturnType<typeof numberRow>>} */
  const rows = new Map();
  for (const { word, description, unit, low, high } of about.criteria) {
    /** @type {Ruler} */
    const ruler = {
      low,
      high,
      scale: "log",
      factor: 1,
      unit,
      above: 0,
      below: unit === "deg" ? HALF_TURN : null,
    };
    const write = (/** @type {number} */ limit) => set(`${word}:${limit}${unit}`);
    rows.set(word, numberRow(`criterion-${word}`, `limit of ${word}`, description, ruler, write));
  }
  kind.addEventListener("change", () => {
    const found = about.criteria.find(({ word }) => word === kind.value);
    if (found) set(`${found.word}:${Number(Math.sqrt(found.low * found.high).toPrecision(2))}${found.unit}`);
  });
  const parts = [...rows.values()].map((row) => row.element);
  return {
    name: "criterion",
    element: html("div", { class: "criterion" }, kind, text, ...parts),
    follow: (value) => {
      const [word, limit] = String(value ?? "").split(":");
      const found = rows.get(word);
      kind.value = found ? word : "";
      own.hidden = found !== undefined;
      own.textContent = /^\w+$/.test(word) ? word : "another one";
      text.textContent = found ? "" : String(value ?? "");
      for (const row of rows.values()) row.element.hidden = row !== found;
      found?.follow(parseFloat(limit));
    },
  };
}

/**
 * A caption, a slider and a field for the exact number.
 * @param {string} name
 * @param {string} label
 * @param {string} description
 * @param {Ruler} ruler
 * @param {SetValue} set
 */
function numberRow(name, label, description, ruler, set) {
  const id = `value-${name}`;
  const caption = html("label", { for: id, title: description }, label);
  const field = html("input", {
    id,
    type: "text",
    inputmode: "decimal",
    autocomplete: "off",
    spellcheck: "false",
  });
  const slide = html("input", {
    type: "range",
    id: `slide-${name}`,
    min: "0",
    max: String(STEPS),
    "aria-label": label,
  });
  slide.addEventListener("input", () => set(tidy(valueOf(ruler, Number(slide.value) / STEPS), ruler.factor)));
  field.addEventListener("change", () => {
    const value = Number(field.value.trim().replace(",", ".").replace("\u2212", "-"));
    const { above = null, below = null } = ruler;
    const possible =
      Number.isFinite(value) && (above === null || value > above) && (below === null || value < below);
    if (field.value.trim() !== "" && possible) set(value / ruler.factor);
    field.classList.toggle("wrong", !possible);
    const limits = `above ${above}${below === null ? "" : ` and below ${below} ${ruler.unit}`}`;
    field.title = Number.isFinite(value) && !possible ? `This must be ${limits}.` : "";
  });
  const number = html(
    "span",
    { class: "number" },
    field,
    html("span", { class: "unit" }, printedUnits(ruler.unit)),
  );
  const element = html("div", { class: "slider" }, html("div", { class: "caption" }, caption, number), slide);
  /** @param {number|string|undefined} value */
  const follow = (value) => {
    if (typeof value !== "number" || !Number.isFinite(value)) return;
    // a field that is being written in is left alone
    const shown = String(Number((value * ruler.factor).toPrecision(12)));
    if (document.activeElement !== field || Number(field.value) !== Number(shown)) field.value = shown;
    slide.value = String(Math.round(shareOf(ruler, value) * STEPS));
    slide.setAttribute("aria-valuetext", `${shown} ${ruler.unit}`);
  };
  return { element, caption, follow };
}

/**
 * @param {Ruler} ruler
 * @param {number} share
 */
function valueOf({ low, high, scale }, share) {
  return scale === "log" ? low * (high / low) ** share : low + share * (high - low);
}

/**
 * @param {Ruler} ruler
 * @param {number} value
 */
function shareOf({ low, high, scale }, value) {
  const share = scale === "log" ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.min(Math.max(share, 0), 1);
}

/**
 * Value of which people read four digits, so that a slider stops at short numbers.
 * @param {number} value
 * @param {number} factor
 */
function tidy(value, factor) {
  return Number((value * factor).toPrecision(4)) / factor;
}
