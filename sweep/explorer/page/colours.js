/** The mapping from values to colours: those of figures for numbers and regimes, blue and orange for verdicts. */

/** @import { Quantity } from "eulerdisk/types" */

/**
 * Colours of numbers at equal distances, light for small ones, as in figures (COLOURS in sweep/figures/shade.py, most
 * of viridis from its light end).
 */
const NUMBERS = (
  "fde725 f4e61e eae51a dfe318 d2e21b c8e020 bddf26 b0dd2f a5db36 9bd93c 8ed645 84d44b 7ad151 " +
  "6ece58 65cb5e 5cc863 52c569 4ac16d 42be71 3aba76 34b679 2eb37c 29af7f 25ab82 22a785 20a386 " +
  "1f9f88 1e9b8a 1f978b 20928c 218f8d 228b8d 24868e 26828e 277f8e 297a8e 2a768e 2c728e 2e6e8e " +
  "306a8e 31668e 33628d 365d8d 38598c 3a548c 3c4f8a 3e4a89 404688 424086 443b84 453781 46307e"
).split(" ");

/** Colours of verdicts by their codes: undecided, stable, unstable. */
const VERDICTS = ["#9a9a9a", "#3b76af", "#ee8a2e"];

/**
 * Colours of regimes: the hue shows the wells, the strength shows the crossing (sweep/figures/disk/regimes.py); greys
 * for cells without a regime.
 */
const REGIMES = ["#dcecf6", "#7fb9dc", "#fbe3bd", "#e69f00", "#ebebeb", "#b3b3b3"];

/**
 * Colours of the loss that took most: none, rolling, pivoting, contour, damping, air
 * (sweep/figures/disk/losses_map.py). The curves of a motion have the same colours (motion.css).
 */
const LOSSES = ["#999999", "#e69f00", "#cc79a7", "#0072b2", "#56b4e9", "#009e73"];

/** Flags of cells without a definite answer, and their colour (_OPEN and _GREY in sweep/figures/shade.py). */
const OPEN = ["undecided", "sensitive"];
export const GREY = "#d4d4d4";

/** Ratio of numbers beyond which equal steps would squeeze the small ones (SQUEEZED in sweep/figures/scales.py). */
const SQUEEZED = 20;

/** Number of shades of a number. */
const SHADES = 1024;

/**
 * The colour scale: from `low` to `high`, in equal steps of the value or of its logarithm.
 * @typedef {{low: number, high: number, scale: "linear"|"log"}} Range
 */

/**
 * Return red, green and blue of "rrggbb" or "#rrggbb".
 * @param {string} hex
 * @returns {[number, number, number]}
 */
export function channels(hex) {
  const number = parseInt(hex.replace("#", ""), 16);
  return [number >> 16, (number >> 8) & 255, number & 255];
}

/**
 * Return the colour at a share of the scale, from 0 to 1.
 * @param {number} share
 * @returns {[number, number, number]}
 */
export function shade(share) {
  const at = Math.min(Math.max(share, 0), 1) * (NUMBERS.length - 1);
  const index = Math.min(Math.floor(at), NUMBERS.length - 2);
  const [below, above] = [channels(NUMBERS[index]), channels(NUMBERS[index + 1])];
  const part = at - index;
  /** @param {number} each */
  const mixed = (each) => Math.round(below[each] + part * (above[each] - below[each]));
  return [mixed(0), mixed(1), mixed(2)];
}

/**
 * Return the colour of a code of a quantity with flags, as "#rrggbb".
 * @param {Quantity} quantity
 * @param {number} code
 */
export function flagColour(quantity, code) {
  if (quantity.name === "stability") return VERDICTS[code] ?? VERDICTS[0];
  if (quantity.name === "regime") return REGIMES[code] ?? REGIMES[5];
  if (quantity.name === "largest_loss") return LOSSES[code] ?? LOSSES[0];
  const flags = quantity.flags ?? {};
  if (OPEN.includes(flags[String(code)])) return GREY;
  // from light to dark, as in figures
  const codes = Object.keys(flags)
    .filter((each) => !OPEN.includes(flags[each]))
    .map(Number);
  const darker = codes.filter((each) => each < code).length;
  const [red, green, blue] = shade(codes.length > 1 ? darker / (codes.length - 1) : 0);
  return "#" + (65536 * red + 256 * green + blue).toString(16).padStart(6, "0");
}

/**
 * Return one pixel as the canvas stores it (little-endian RGBA).
 * @param {[number, number, number]} colour
 */
export function packed([red, green, blue]) {
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

const SCALE = Uint32Array.from({ length: SHADES }, (_, each) => packed(shade(each / (SHADES - 1))));

/**
 * Return the colour scale for values from low to high, as in figures: logarithmic for the peak, and where numbers span
 * decades; then it starts at the least positive value. For equal values, it is a narrow range around them.
 * @param {Quantity} quantity
 * @param {number|null} low
 * @param {number|null} high
 * @param {number|null} [least]  the smallest positive value
 * @returns {Range}
 */
export function rangeFor(quantity, low, high, least = low) {
  if (low === null || high === null) return { low: 0, high: 1, scale: "linear" };
  if (low >= 0 && least !== null && least > 0 && (quantity.is_peak || high > SQUEEZED * least)) {
    return { low: least, high: Math.max(high, (1 + 1e-12) * least), scale: "log" };
  }
  if (high - low > 1e-12 * Math.max(Math.abs(low), Math.abs(high))) return { low, high, scale: "linear" };
  const margin = 1e-12 * Math.max(Math.abs(low), Math.abs(high)) || 1;
  return { low: low - margin, high: high + margin, scale: "linear" };
}

/**
 * Paint values into the pixels of a picture, whose rows go from top to bottom.
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
    // values below the range, and the logarithm of 0, get the first shade
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
      // a code without a description belongs to no cell
      found = String(value) in (quantity.flags ?? {}) ? packed(channels(flagColour(quantity, value))) : 0;
      table.set(value, found);
    }
    return found;
  };
}
