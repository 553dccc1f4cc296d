/** Windows and points from a plan: combining pieces, and the text about a cell. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { cellAt, computedWindow, isSlow, shown, toldCell } from "eulerdisk/compute/cells";
import { RATE, TILT } from "./about.mjs";

const PLAN = { timed: ["period"], path: [], criterion: { named: [], timed: false } };
const VIEW = { base: "", words: {}, x: RATE, y: TILT };

/** A computation of the whole window, in which cells have their column and row as values. */
function computing(size, answer) {
  const asked = [];
  const ask = async (what, question, more) => {
    asked.push({ what, ...question, more });
    const { x, y } = question;
    const count = (x.to - x.from) * (y.to - y.from);
    const at = Array.from({ length: count }, (_, i) => {
      const wide = x.to - x.from;
      return [x.from + (i % wide), y.from + Math.floor(i / wide)];
    });
    return answer(at);
  };
  return { ask, asked, size, ready: Promise.resolve() };
}

const numbered = (at) => {
  const value = Float64Array.from(at, ([column, row]) => 1000 * row + column);
  const verdict = Uint8Array.from(at, ([column]) => column % 3);
  const above = value.filter((each) => each > 0);
  return {
    value,
    verdict,
    low: Math.min(...value),
    high: Math.max(...value),
    least: Math.min(Infinity, ...above),
  };
};

for (const x of [RATE, { ...RATE, name: "alpha" }]) {
  test(`a window is combined from its pieces, with ${x.name} along it`, async () => {
    const computation = computing(3, numbered);
    const request = { view: { ...VIEW, x }, width: 300, height: 200, quantity: "peak_tilt" };
    const { head, value, verdict, stored, width } = await computedWindow(computation, PLAN, request);
    assert.ok(computation.asked.length > 3);
    assert.ok(value.every((each, i) => each === 1000 * Math.floor(i / 300) + (i % 300)));
    assert.ok(verdict.every((each, i) => each === (i % 300) % 3));
    assert.deepEqual([head.low, head.high, head.least, stored, width], [0, 199299, 1, null, 300]);
    const isWhole = computation.asked.every((part) =>
      x.name === "alpha" ? part.y.to === 200 : part.x.to === 300,
    );
    assert.ok(isWhole);
  });
}

test("windows without values have no ends", async () => {
  const none = computing(1, (at) => ({
    value: Float64Array.from(at, () => NaN),
    verdict: new Uint8Array(at.length),
    low: Infinity,
    high: -Infinity,
    least: Infinity,
  }));
  const request = { view: VIEW, width: 4, height: 3, quantity: "period" };
  const { head } = await computedWindow(none, PLAN, request);
  assert.deepEqual(head, { low: null, high: null, least: null, end: false, note: "" });
  assert.ok(none.asked.every(({ timed }) => timed));
});

test("zoom ends if a pixel is narrower than eight units in the last place along either side", async () => {
  for (const side of ["x", "y"]) {
    for (const [units, end] of [
      [7.9, true],
      [8.1, false],
    ]) {
      const axis = { ...VIEW[side], centre: 3, half: (units * 2 ** -51 * 40) / 2, scale: "linear" };
      const request = { view: { ...VIEW, [side]: axis }, width: 40, height: 40, quantity: "peak_tilt" };
      assert.equal((await computedWindow(computing(1, numbered), PLAN, request)).head.end, end);
    }
  }
});

test("the program computes windows of systems, and the page all others", () => {
  assert.equal(isSlow(PLAN), false);
  assert.equal(isSlow({ ...PLAN, body: {} }), false);
  assert.equal(isSlow({ ...PLAN, system: {} }), true);
});

test("a cell is requested at its place and has one number per column", async () => {
  const asked = [];
  const columns = { tilt: Float64Array.of(0.5), ending: Int32Array.of(4), period: Float64Array.of(NaN) };
  const computation = { ask: async (...given) => (asked.push(given), columns) };
  assert.deepEqual(await cellAt(computation, PLAN, { view: VIEW, x: 2, y: 0.5 }), {
    tilt: 0.5,
    ending: 4,
    period: NaN,
  });
  const [[what, { given, count }]] = asked;
  assert.deepEqual([what, count, [...given.roll_rate], [...given.tilt]], ["cells", 1, [2], [0.5]]);
});

test("numbers have their unit, and three digits in single precision; a missing number is stated", () => {
  const told = { name: "x", unit: "deg", factor: 180 / Math.PI, single: false, flags: null };
  assert.deepEqual(shown(told, 1), { value: 1, text: "57.2958 deg" });
  assert.deepEqual(shown({ ...told, single: true }, 1), { value: 1, text: "57.3 deg" });
  for (const none of [NaN, Infinity, -Infinity]) {
    assert.deepEqual(shown(told, none), { value: null, text: "none" });
  }
  const flags = { 1: "bounded" };
  assert.deepEqual(
    [1, 2].map((code) => shown({ ...told, flags }, code).text),
    ["bounded", "2"],
  );
});

test("a cell reports its numbers, its start and its verdict", () => {
  const number = (name) => ({
    name,
    label: `${name}!`,
    description: `${name}?`,
    unit: "s",
    factor: 2,
    single: false,
    flags: null,
  });
  const plan = { numbers: [number("a"), number("b")], starts: [number("c")] };
  assert.deepEqual(toldCell(plan, { a: 1, c: 3, stability: 2 }, { 2: "unstable" }), {
    start: { c: { value: 3, text: "6 s" } },
    numbers: [{ name: "a", label: "a!", description: "a?", value: 1, text: "2 s" }],
    verdict: "unstable",
    stored: null,
  });
  assert.equal(toldCell(plan, { stability: 7 }, {}).verdict, "");
});
