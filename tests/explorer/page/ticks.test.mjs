/** Ticks and displayed numbers; test_numbers.py compares ticks of random windows with exact decimals. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { printedUnits, readable, superscript, ticksOf } from "eulerdisk/ticks";

const axis = (low, high) => ({ centre: (low + high) / 2, half: (high - low) / 2, scale: "linear" });
const log = (low, high) => ({ ...axis(Math.log(low), Math.log(high)), scale: "log" });
const labels = ({ ticks }) => ticks.map(({ label }) => label).filter(Boolean);

test("a plain range has plain numbers with a real minus sign", () => {
  const scale = ticksOf(axis(-1, 1), 1, 4);
  assert.deepEqual(scale, {
    ticks: [-1, -0.5, 0, 0.5, 1].map((place) => ({ place, label: place.toFixed(1).replace("-", "\u2212") })),
    offset: "",
    power: 0,
  });
});

test("steps are 1, 2 and 5 times powers of ten", () => {
  assert.deepEqual(labels(ticksOf(axis(0, 10), 1, 10)), [
    "0",
    "1",
    "2",
    "3",
    "4",
    "5",
    "6",
    "7",
    "8",
    "9",
    "10",
  ]);
  assert.deepEqual(labels(ticksOf(axis(0, 10), 1, 5)), ["0", "2", "4", "6", "8", "10"]);
  assert.deepEqual(labels(ticksOf(axis(0, 10), 1, 2)), ["0", "5", "10"]);
  assert.deepEqual(labels(ticksOf(axis(0, 10), 1, 1)), ["0", "10"]);
});

test("labels are in the displayed unit", () => {
  assert.deepEqual(labels(ticksOf(axis(0, Math.PI / 2), 180 / Math.PI, 3)), ["0", "20", "40", "60", "80"]);
});

test("large and small numbers have a power of ten, and a narrow window has common digits as an offset", () => {
  const large = ticksOf(axis(0, 4e6), 1, 4);
  assert.deepEqual([labels(large), large.power], [["0", "1", "2", "3", "4"], 6]);
  const small = ticksOf(axis(0, 4e-6), 1, 4);
  assert.deepEqual([labels(small), small.power], [["0", "1", "2", "3", "4"], -6]);
  const narrow = ticksOf(axis(2.5 - 2e-9, 2.5 + 2e-9), 1, 4);
  assert.deepEqual(narrow.offset, "2.5000000");
  assert.deepEqual([labels(narrow), narrow.power], [["\u22122", "\u22121", "0", "+1", "+2"], -9]);
});

test("a range of decades has its powers, with 2 and 5 between them if there is room", () => {
  assert.deepEqual(labels(ticksOf(log(0.01, 1000), 1, 5)), ["0.01", "0.1", "1", "10", "100", "1000"]);
  assert.deepEqual(labels(ticksOf(log(1, 100), 1, 8)), ["1", "2", "5", "10", "20", "50", "100"]);
  assert.deepEqual(labels(ticksOf(log(1e-6, 1e6), 1, 4)), [
    "10\u207b\u2076",
    "0.001",
    "1",
    "1000",
    "10\u2076",
  ]);
});

test("a logarithmic axis has small ticks at all integer multiples, at their logarithms", () => {
  const { ticks } = ticksOf(log(1, 100), 1, 2);
  const expected = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 20, 30, 40, 50, 60, 70, 80, 90, 100].map(
    (each) => Math.log10(each) - 1,
  );
  assert.equal(ticks.length, expected.length);
  ticks.forEach(({ place }, i) => assert.ok(Math.abs(place - expected[i]) < 1e-12));
});

test("a logarithmic axis of less than a decade and a half has equal steps, at their logarithms", () => {
  const { ticks } = ticksOf(log(1, 10), 1, 5);
  assert.deepEqual(
    ticks.map(({ label }) => label),
    ["2", "4", "6", "8", "10"],
  );
  ticks.forEach(({ place, label }) =>
    assert.ok(Math.abs(place - (2 * Math.log10(Number(label)) - 1)) < 1e-12),
  );
});

test("numbers have no trailing zeros, and powers of ten are written out", () => {
  assert.equal(readable(0.25, 6), "0.25");
  assert.equal(readable(-100, 6), "\u2212100");
  assert.equal(readable(1200, 2), "1.2\u00d710\u00b3");
  assert.equal(readable(-2.5e-13, 4), "\u22122.5\u00d710\u207b\u00b9\u00b3");
  assert.equal(readable(0, 3), "0");
  for (const none of [NaN, Infinity, -Infinity]) assert.equal(readable(none, 3), "none");
});

test("units and powers of ten are printed as superscripts", () => {
  assert.equal(superscript(-1203), "\u207b\u00b9\u00b2\u2070\u00b3");
  assert.equal(printedUnits("3 rad s-1"), "3 rad s\u207b\u00b9");
  assert.equal(printedUnits("m s-2"), "m s\u207b\u00b2");
  assert.equal(printedUnits("kg m2"), "kg m\u00b2");
  assert.equal(printedUnits("2e-13 m"), "2\u00d710\u207b\u00b9\u00b3 m");
  assert.equal(printedUnits("tilt 5 deg"), "tilt 5 deg");
});
