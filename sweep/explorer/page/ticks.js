/**
 * Ticks of an axis and their labels, readable from decades down to windows of 1e-10 of the value.
 *
 * Where labels would need many digits, the digits that all ticks share are written once, as an offset.
 */

/**
 * A tick at a place from -1 to 1; minor ticks have no label.
 * @typedef {{place: number, label: string}} Tick
 */

/**
 * `offset` is the text of a number to which all labels are added, empty if there is none; `power` is the labels' power
 * of ten.
 * @typedef {{ticks: Tick[], offset: string, power: number}} Scale
 */

/** Number of significant digits from which on labels are written relative to an offset. */
const MOST_DIGITS = 6;

export const MINUS = "\u2212";
const SUPERSCRIPT = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";

/**
 * Return a whole number as a superscript.
 * @param {number} power
 */
export function superscript(power) {
  const digits = [...String(Math.abs(power))].map((digit) => SUPERSCRIPT[Number(digit)]).join("");
  return (power < 0 ? "\u207b" : "") + digits;
}

/**
 * Return a text with units and powers of ten as in print: "rad s-1" becomes "rad s\u207b\u00b9", "2e-13" becomes
 * 2\u00d710\u207b\u00b9\u00b3.
 * @param {string} text
 */
export function printedUnits(text) {
  return text
    .replace(/(?<= |^|[a-z])([a-z]+)(-?\d)(?= |$)/gi, (_, unit, power) => unit + superscript(Number(power)))
    .replace(/(?<=\d)e([+-]\d+)/g, (_, power) => `\u00d710${superscript(Number(power))}`);
}

/**
 * Return the largest exponent of ten for which the power is not above a positive number.
 * @param {number} value
 */
function decade(value) {
  return Number(value.toExponential().split("e")[1]);
}

/**
 * Return a number as people write it, with a true minus sign and powers of ten written out.
 * @param {number} value
 * @param {number} digits
 */
export function readable(value, digits) {
  if (!Number.isFinite(value)) return "none";
  const [mantissa, exponent] = value.toPrecision(digits).split("e");
  const plain = (mantissa.includes(".") ? mantissa.replace(/\.?0+$/, "") : mantissa).replace("-", MINUS);
  return exponent === undefined ? plain : `${plain}\u00d710${superscript(Number(exponent))}`;
}

/**
 * Return a step between ticks, 1, 2 or 5 times a power of ten, so that about `count` of them fit.
 * @param {number} width
 * @param {number} count
 * @returns {{multiple: number, power: number}}
 */
function niceStep(width, count) {
  const rough = width / Math.max(count, 1);
  const power = decade(rough);
  const lead = rough / 10 ** power;
  if (lead > 7.07) return { multiple: 1, power: power + 1 };
  return { multiple: lead > 3.16 ? 5 : lead > 1.42 ? 2 : 1, power };
}

/**
 * Return equally spaced ticks of a range of values.
 * @param {number} low
 * @param {number} high
 * @param {number} count  approximate number of ticks
 * @param {(fromMiddle: number, middle: number) => number} placeOf  place of middle + fromMiddle
 * @returns {Scale}
 */
function equalSteps(low, high, count, placeOf) {
  const middle = (low + high) / 2;
  const { multiple, power } = niceStep(high - low, count);
  const step = multiple * 10 ** power;
  const largest = Math.max(Math.abs(low), Math.abs(high));
  const digits = decade(largest) - power + 1;
  const shared = digits > MOST_DIGITS;
  // the offset is a decimal number that ends one digit before the digits that change from tick to tick
  const offset = shared ? rounded(middle, power + 2) : 0;
  const offsetText = shared ? decimalText(offset, power + 2) : "";
  const first = Math.ceil((low - offset) / step - 1e-9);
  const last = Math.floor((high - offset) / step + 1e-9);
  const scale = shared || power > 4 || decade(largest) < -4 ? (shared ? power : decade(largest)) : 0;
  const ticks = [];
  for (let each = first; each <= last && ticks.length < 100; each += 1) {
    const place = placeOf(offset - middle + each * step, middle);
    ticks.push({ place, label: tickLabel(each * multiple, power - scale, shared) });
  }
  return { ticks, offset: offsetText, power: scale };
}

/**
 * Return a value rounded to a multiple of a power of ten.
 * @param {number} value
 * @param {number} power
 */
function rounded(value, power) {
  return power >= 0
    ? Math.round(value / 10 ** power) * 10 ** power
    : Number(value.toFixed(Math.min(-power, 100)));
}

/**
 * Return a decimal number with all digits down to a power of ten.
 * @param {number} value
 * @param {number} power
 */
function decimalText(value, power) {
  return value.toFixed(Math.min(Math.max(-power, 0), 100)).replace("-", MINUS);
}

/**
 * Return the label of whole * 10**power, with a sign if it is added to an offset.
 * @param {number} whole
 * @param {number} power
 * @param {boolean} signed
 */
function tickLabel(whole, power, signed) {
  const text = (Math.abs(whole) * 10 ** power).toFixed(Math.max(-power, 0));
  const sign = whole < 0 ? MINUS : signed && whole > 0 ? "+" : "";
  return sign + text;
}

/**
 * Return the ticks of a range of more than a decade and a half, at 1, 2 and 5 times powers of ten, with minor ticks
 * between them.
 * @param {number} low  natural logarithm
 * @param {number} high  natural logarithm
 * @param {number} count
 * @returns {Scale}
 */
function decades(low, high, count) {
  const [centre, half] = [(low + high) / 2, (high - low) / 2];
  const from = Math.floor(low / Math.LN10);
  const to = Math.ceil(high / Math.LN10);
  const each = Math.max(1, Math.ceil((to - from) / Math.max(count, 1)));
  const dense = ((high - low) / Math.LN10) * 3 <= count;
  const ticks = [];
  for (let power = from; power <= to; power += 1) {
    for (let lead = 1; lead < 10; lead += 1) {
      const place = (Math.log(lead) + power * Math.LN10 - centre) / half;
      if (Math.abs(place) > 1 + 1e-9) continue;
      const named = lead === 1 ? (power - from) % each === 0 : dense && (lead === 2 || lead === 5);
      if (lead > 1 && each > 1) continue;
      ticks.push({ place, label: named ? powerLabel(lead, power) : "" });
    }
  }
  return { ticks, offset: "", power: 0 };
}

/**
 * @param {number} lead
 * @param {number} power
 */
function powerLabel(lead, power) {
  if (power >= -3 && power <= 4) return (lead * 10 ** power).toFixed(Math.max(-power, 0));
  return (lead === 1 ? "" : `${lead}\u00d7`) + `10${superscript(power)}`;
}

/**
 * Return the ticks of an axis.
 * @param {{centre: number, half: number, scale: "linear"|"log"}} axis
 * @param {number} factor  from values to displayed numbers
 * @param {number} count  approximate number of ticks that fit
 * @returns {Scale}
 */
export function ticksOf(axis, factor, count) {
  if (axis.scale === "linear") {
    const half = axis.half * factor;
    const middle = axis.centre * factor;
    return equalSteps(middle - half, middle + half, count, (distance) => distance / half);
  }
  const shift = Math.log(factor);
  const [low, high] = [axis.centre - axis.half + shift, axis.centre + axis.half + shift];
  if (high - low > 1.5 * Math.LN10) return decades(low, high, count);
  const central = Math.exp(axis.centre + shift);
  return equalSteps(Math.exp(low), Math.exp(high), count, (distance, middle) => {
    // log1p keeps the digits of narrow windows, where both values are nearly equal
    return Math.log1p((middle - central + distance) / central) / axis.half;
  });
}
