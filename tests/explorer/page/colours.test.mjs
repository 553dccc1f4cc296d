/** Pixels of a picture; test_arithmetic.py compares colors and ranges with matplotlib. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { flagColour, paint, rangeFor, shade } from "eulerdisk/colours";

const NUMBER = { name: "peak_tilt", flags: null, is_peak: true };
const VERDICT = { name: "stability", flags: { 0: "undecided", 1: "stable", 2: "unstable" } };

/** Red, green, blue and opacity of pixels. */
function painted(values, width, height, quantity, range) {
  const pixels = new Uint32Array(width * height);
  paint(pixels, values, width, height, quantity, range);
  const bytes = new Uint8Array(pixels.buffer);
  return Array.from({ length: pixels.length }, (_, i) => [...bytes.slice(4 * i, 4 * i + 4)]);
}

const NONE = [0, 0, 0, 0];
const LIGHT = [0xfd, 0xe7, 0x25, 255];
const DARK = [0x46, 0x30, 0x7e, 255];

test("the first row of values is the lowest row of the picture", () => {
  const found = painted([0, 1, 0.5, NaN, 2, -1], 2, 3, NUMBER, { low: 0, high: 1, scale: "linear" });
  assert.deepEqual(found, [DARK, LIGHT, [...shade(512 / 1023), 255], NONE, LIGHT, DARK]);
});

test("the middle of a logarithmic range is the geometric mean; 0 has the first shade", () => {
  const found = painted([0, 1, 10, 100, 1e9, Infinity], 6, 1, NUMBER, { low: 1, high: 100, scale: "log" });
  assert.deepEqual(found, [LIGHT, LIGHT, [...shade(512 / 1023), 255], DARK, DARK, DARK]);
});

test("flags have their colors, and unknown codes have none", () => {
  const found = painted([0, 1, 2, 255], 4, 1, VERDICT, { low: 0, high: 1, scale: "linear" });
  assert.deepEqual(found, [[0x9a, 0x9a, 0x9a, 255], [0x3b, 0x76, 0xaf, 255], [0xee, 0x8a, 0x2e, 255], NONE]);
});

test("shades go from light to dark and stop at both ends", () => {
  assert.deepEqual(
    [-1, 0, 1, 2].map(shade),
    [LIGHT, LIGHT, DARK, DARK].map((each) => each.slice(0, 3)),
  );
  const sums = Array.from({ length: 101 }, (_, i) => shade(i / 100).reduce((sum, each) => sum + each));
  assert.ok(sums.every((each, i) => i === 0 || each <= sums[i - 1] + 3));
});

test("flags without their own colors have shades in the order of their codes; undecided is gray", () => {
  const quantity = { name: "ending", flags: { 0: "undecided", 3: "a", 7: "b", 9: "sensitive", 12: "c" } };
  const hex = (share) =>
    "#" +
    shade(share)
      .map((each) => each.toString(16).padStart(2, "0"))
      .join("");
  assert.deepEqual(
    [0, 3, 7, 9, 12].map((code) => flagColour(quantity, code)),
    ["#d4d4d4", hex(0), hex(0.5), "#d4d4d4", hex(1)],
  );
  assert.equal(flagColour({ name: "x", flags: { 4: "only" } }, 4), hex(0));
});

test("a range without values, or with equal ones, is a valid range", () => {
  assert.deepEqual(rangeFor(NUMBER, null, null), { low: 0, high: 1, scale: "linear" });
  for (const value of [-5, 0, 5]) {
    const { low, high } = rangeFor({ ...NUMBER, is_peak: false }, value, value);
    assert.ok(low < value && value < high);
  }
  const { low, high, scale } = rangeFor(NUMBER, 5, 5);
  assert.deepEqual([low, scale], [5, "log"]);
  assert.ok(high > 5 && high < 5.1);
});

test("numbers that span decades are logarithmic from the least positive one; the peak always is", () => {
  const other = { ...NUMBER, is_peak: false };
  const log = (low, high) => ({ low, high, scale: "log" });
  const linear = (low, high) => ({ low, high, scale: "linear" });
  assert.deepEqual(rangeFor(other, 0, 10, 0.1), log(0.1, 10));
  assert.deepEqual(rangeFor(other, 1, 21), log(1, 21));
  assert.deepEqual(rangeFor(other, 1, 20), linear(1, 20));
  assert.deepEqual(rangeFor(other, 0, 10, 1), linear(0, 10));
  assert.deepEqual(rangeFor(NUMBER, 0, 10, 1), log(1, 10));
  assert.deepEqual(rangeFor(NUMBER, -1, 10, 0.1), linear(-1, 10));
  assert.deepEqual(rangeFor(NUMBER, -2, 0, null), linear(-2, 0));
});
