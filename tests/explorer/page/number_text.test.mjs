/** Text in a field: numbers with units, and refusals. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { readNumber } from "eulerdisk/number_text";

const RADIUS = { factor: 1, unit: "m", least: 5e-324, most: null };
const TILT = { factor: 180 / Math.PI, unit: "deg", least: -1.57, most: 1.57 };
const ALPHA = { factor: 1, unit: "", least: 0, most: 1 };

test("a number has the unit of its field, or its own", () => {
  for (const [text, field, expected] of [
    ["0.024", RADIUS, 0.024],
    ["24 mm", RADIUS, 0.024],
    ["24mm", RADIUS, 0.024],
    ["2,4 cm", RADIUS, 0.024],
    ["0.024 m", RADIUS, 0.024],
    ["24000 \u00b5m", RADIUS, 0.024],
    ["1e-2", RADIUS, 0.01],
    ["\u22125", TILT, -5],
    ["-5\u00b0", TILT, -5],
    ["0.1 rad", TILT, 18 / Math.PI],
    [".5", ALPHA, 0.5],
    ["60 rpm", { factor: 1, unit: "rad s-1" }, 2 * Math.PI],
    ["3 rad/s", { factor: 1, unit: "rad s-1" }, 3],
  ]) {
    const { value, problem } = readNumber(text, field);
    assert.equal(problem, "", text);
    assert.ok(Math.abs(value - expected) <= 1e-12 * Math.abs(expected), `${text}: ${value}`);
  }
});

test("bad text is refused with what is allowed", () => {
  for (const [text, field, ...facts] of [
    ["24 kg", RADIUS, /mm/, /kg/],
    ["", RADIUS, /number/, /m,/],
    ["wide", RADIUS, /number/],
    ["0", RADIUS, /above 0 m/],
    ["-3 mm", RADIUS, /above 0 m/],
    ["1e999", RADIUS, /above 0/],
    ["100", TILT, /at least/, /at most 89.9/, /deg/],
    ["0.5 m", ALPHA, /without a unit/],
    ["2", ALPHA, /at most 1/],
    ["180", { factor: 1, unit: "deg", above: 0, below: 180 }, /above 0 and below 180 deg/],
  ]) {
    const { value, problem } = readNumber(text, field);
    assert.equal(value, null, text);
    for (const fact of facts) assert.match(problem, fact);
  }
});
