/**
 * Numbers as people write them into a field: with comma or point, and with the field's unit or another one of its kind.
 */

import { printedUnits, readable } from "eulerdisk/ticks";

/** @type {Record<string, number>[]} units that can replace each other, and their size in the first unit */
const KINDS = [
  { m: 1, cm: 1e-2, mm: 1e-3, um: 1e-6, "\u00b5m": 1e-6, "\u03bcm": 1e-6, km: 1e3 },
  { rad: 1, deg: Math.PI / 180, "\u00b0": Math.PI / 180, mrad: 1e-3 },
  { "rad s-1": 1, "rad/s": 1, "deg s-1": Math.PI / 180, "deg/s": Math.PI / 180, rpm: Math.PI / 30 },
  { "m s-2": 1, "m/s2": 1, "m/s^2": 1 },
  { kg: 1, g: 1e-3 },
  { s: 1, ms: 1e-3 },
];

/** Size below which a number counts as 0: bisection finds an open end at 0 only approximately. */
const NEARLY_ZERO = 1e-100;

/**
 * The rules of a field: its numbers are SI values times `factor`, in `unit`; `above` and `below` are exclusive limits
 * in that unit, `least` and `most` are the last allowed values, in SI.
 * @typedef {{factor: number, unit: string, above?: number|null, below?: number|null, least?: number|null, most?: number|null}} Field
 */

/**
 * Return the number in a text, in the unit of a field, or the reason why it is invalid.
 * @param {string} text
 * @param {Field} field
 * @returns {{value: number, problem: ""}|{value: null, problem: string}}
 */
export function readNumber(text, field) {
  const refuse = (/** @type {string} */ problem) => ({ value: null, problem });
  const plain = text.trim().replace("\u2212", "-").replace(",", ".");
  const [, digits, unit] = /^([+-]?(?:\d+\.?\d*|\.\d+)(?:e[+-]?\d+)?)\s*(.*)$/i.exec(plain) ?? [];
  if (digits === undefined) return refuse(`This must be a number${inUnit(field)}.`);
  const share = unit ? ratio(unit, field.unit) : 1;
  if (share === null) return refuse(`This must be ${units(field)}; got ${unit}.`);
  const value = Number(digits) * share;
  const problem = limitBroken(value, field);
  return problem ? refuse(problem) : { value, problem: "" };
}

/**
 * Return the size of a unit in units of a field; null if they are of different kinds.
 * @param {string} given
 * @param {string} own
 * @returns {number|null}
 */
function ratio(given, own) {
  if (given === own || given === printedUnits(own)) return 1;
  const kind = kindOf(own);
  return kind && given in kind ? kind[given] / kind[own] : null;
}

/**
 * @param {string} unit
 * @returns {Record<string, number>|undefined}
 */
function kindOf(unit) {
  return KINDS.find((kind) => unit in kind);
}

/** @param {Field} field */
function inUnit({ unit }) {
  return unit ? ` in ${printedUnits(unit)}, or with a unit` : "";
}

/** @param {Field} field */
function units({ unit }) {
  if (!unit) return "a number without a unit";
  return `in ${Object.keys(kindOf(unit) ?? { [unit]: 1 })
    .filter((each) => /^[\w /^-]+$/.test(each))
    .map(printedUnits)
    .join(", ")}`;
}

/**
 * Return the limits as a message if a value breaks one; empty otherwise.
 * @param {number} value
 * @param {Field} field
 */
function limitBroken(value, { factor, unit, above = null, below = null, least = null, most = null }) {
  const low = least === null ? null : least * factor;
  const high = most === null ? null : most * factor;
  const isOpen = low !== null && Math.abs(low) < NEARLY_ZERO && low !== 0;
  if (
    Number.isFinite(value) &&
    (above === null || value > above) &&
    (below === null || value < below) &&
    (low === null || value >= low) &&
    (high === null || value <= high)
  ) {
    return "";
  }
  const limits = [];
  if (above !== null) limits.push(`above ${above}`);
  if (below !== null) limits.push(`below ${below}`);
  if (low !== null) limits.push(isOpen ? "above 0" : `at least ${readable(low, 4)}`);
  if (high !== null) limits.push(`at most ${readable(high, 4)}`);
  return `This must be ${limits.join(" and ") || "finite"} ${printedUnits(unit)}`.trim() + ".";
}
