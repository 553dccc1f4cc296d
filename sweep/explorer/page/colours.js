/** How values become colours: cividis for numbers, blue and orange for verdicts, all told apart by the colour-blind. */

/** @typedef {import("eulerdisk/types").Quantity} Quantity */

/** Colours of cividis at equal distances (Nunez, Anderton, Renslow 2018). */
const CIVIDIS = (
  "00224e 002656 002a5f 002e6a 003170 0f3570 1a386f 243c6e 2b406d 33446d 39486c 3e4b6c " +
  "444f6c 49536c 4f576c 545a6d 595e6e 5e626e 636670 676a71 6c6d72 717274 757575 7a7a78 " +
  "7e7d78 848279 898578 8f8a78 938e78 989277 9e9676 a39a74 a99f73 aea371 b5a86f baac6d " +
  "c0b16a c5b568 cbb965 d1bf61 d6c35d ddc858 e2cd54 e9d34e efd748 f6dd3f fce236 fee838"
).split(" ");

/** Colours of verdicts by their codes: undecided, stable, unstable. */
const VERDICTS = ["#9a9a9a", "#3b76af", "#ee8a2e"];

/** Colours of other flags, in the order of their codes: light and dark ones of a hue belong together. */
const FLAGS = [
  "#a6cde6",
  "#3b76af",
  "#f8c07f",
  "#d9661f",
  "#7d4a86",
  "#9a9a9a",
  "#5f9e6e",
  "#c9b45a",
  "#5b5b8c",
];

/** How many shades a number may have. */
const SHADES = 1024;

/**
 * Which number has which shade: from `low` to `high`, in equal steps of the value or of its logarithm.
 * @typedef {{low: number, high: number, scale: "linear"|"log"}} Range
 */

/**
 * Red, green and blue of "rrggbb" or "#rrggbb".
 * @param {string} hex
 * @returns {[number, number, number]}
 */
export function channels(hex) {
  const number = parseInt(hex.replace("#", ""), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

/**
 * Colour at a share of the scale, from 0 to 1.
 * @param {number} share
 * @returns {[number, number, number]}
 */
export function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (CIVIDIS.length - 1);
  const index = Math.min(Math.floor(at), CIVIDIS.length - 2);
  const [below, above] = [channels(CIVIDIS[index]), channels(CIVIDIS[index + 1])];
  const part = at - index;
  /** @param {number} each */
  const mixed = (each) => Math.round(below[each] + part * (above[each] - below[each]));
  return [mixed(0), mixed(1), mixed(2)];
}

/**
 * Colour of a code of a quantity with flags, as "#rrggbb".
 * @param {Quantity} quantity
 * @param {number} code
 */
export function flagColour(quantity, code) {
  if (quantity.name === "stability") return VERDICTS[code] ?? VERDICTS[0];
  const order = Object.keys(quantity.flags ?? {})
    .map(Number)
    .sort((a, b) => a - b)
    .indexOf(code);
  return FLAGS[(order < 0 ? 0 : order) % FLAGS.length];
}

/**
 * One pixel as the canvas stores it (little-endian RGBA).
 * @param {[number, number, number]} colour
 */
function packed([red, green, blue]) {
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

const SCALE = Uint32Array.from({ length: SHADES }, (_, each) => packed(shade(each / (SHADES - 1))));

/**
 * Range for values from low to high that the scale of the quantity allows; of equal values a narrow one around them.
 * @param {Quantity} quantity
 * @param {number|null} low
 * @param {number|null} high
 * @returns {Range}
 */
export function rangeFor(quantity, low, high) {
  if (low === null || high === null) return { low: 0, high: 1, scale: "linear" };
  const scale = quantity.scale === "log" && low > 0 ? "log" : "linear";
  if (high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high))) return { low, high, scale };
  const margin = 1e-12 * Math.max(Math.abs(low), Math.abs(high)) || 1;
  return { low: low - margin, high: high + margin, scale: "linear" };
}

/**
 * Paint values into the pixels of a picture, whose rows go from the top downward.
 * @param {Uint32Array} pixels
 * @param {ArrayLike<number>} values  rows from the bottom upward; NaN is left transparent
 * @param {number} width
 * @param {number} height
 * @param {Quantity} quantity
 * @param {Range} range
 */
export function paint(pixels, values, width, height, quantity, range) {
  const colourOf = quantity.flags === null ? numberColours(range) : flagColours(quantity);
  for (let row = 0; row < height; row += 1) {
    const to = (height - 1 - row) * width;
    const from = row * width;
    for (let column = 0; column < width; column += 1) {
      const value = values[from + column];
      pixels[to + column] = value === value ? colourOf(value) : 0;
    }
  }
}

/**
 * @param {Range} range
 * @returns {(value: number) => number}
 */
function numberColours({ low, high, scale }) {
  const log = scale === "log";
  const [from, to] = log ? [Math.log(low), Math.log(high)] : [low, high];
  const stretch = (SHADES - 1) / (to - from);
  return (value) => {
    const at = ((log ? Math.log(value) : value) - from) * stretch + 0.5;
    // a value below the range, and the logarithm of 0, have the first shade
    return SCALE[at > 0 ? (at < SHADES ? at | 0 : SHADES - 1) : 0];
  };
}

/**
 * @param {Quantity} quantity
 * @returns {(value: number) => number}
 */
function flagColours(quantity) {
  const table = new Map();
  return (value) => {
    let found = table.get(value);
    if (found === undefined) {
      // a code without words is that of no cell
      found = String(value) in (quantity.flags ?? {}) ? packed(channels(flagColour(quantity, value))) : 0;
      table.set(value, found);
    }
    return found;
  };
}
