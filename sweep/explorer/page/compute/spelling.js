/** Numbers as the program spells them. */

/** @import { ToldNumber } from "eulerdisk/types" */

/** Number of turns from which on an angle is given in turns. */
const MANY_TURNS = 10;
const TURN = 2 * Math.PI;

/**
 * Return a value as text for a message, with angles in degrees, or in turns if they are many.
 * @param {Pick<ToldNumber, "unit"|"factor">} told
 * @param {number} value
 * @param {number} digits
 */
export function spelled({ unit, factor }, value, digits) {
  if (unit === "deg" && Math.abs(value) >= MANY_TURNS * TURN) return `${general(value / TURN, digits)} turns`;
  return `${general(value * factor, digits)} ${unit}`.trimEnd();
}

/**
 * Return a number with some digits, without trailing zeros, like Python's format "g".
 * @param {number} value
 * @param {number} digits
 */
export function general(value, digits) {
  if (value === 0) return Object.is(value, -0) ? "-0" : "0";
  const [mantissa, power] = value.toExponential(digits - 1).split("e");
  const exponent = Number(power);
  const short = (/** @type {string} */ text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);
  if (exponent >= -4 && exponent < digits) return short(value.toFixed(Math.max(0, digits - 1 - exponent)));
  const size = String(Math.abs(exponent)).padStart(2, "0");
  return `${short(mantissa)}e${exponent < 0 ? "-" : "+"}${size}`;
}
