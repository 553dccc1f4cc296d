/** The state of the page: bases, words and axes; changes do not modify the old state. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { ends } from "eulerdisk/axis_window";
import {
  baseOf,
  firstAxis,
  firstState,
  halfOfRange,
  isFixed,
  parameterOf,
  parametersOf,
  quantitiesOf,
  quantityOf,
  verdictWords,
  withAxis,
  withinDomain,
  withOtherScale,
  withSlot,
  withValue,
  withWord,
  wordOf,
  wordsOf,
} from "eulerdisk/state";
import { ABOUT, RATE, TILT } from "./about.mjs";

const { view: VIEW } = firstState(ABOUT);

test("a base starts with its view and its usual quantity; an unknown name gives the first base", () => {
  const { view, quantity, stored, points } = firstState(ABOUT, "spinning");
  assert.deepEqual(view, { base: "spinning", words: {}, x: RATE, y: TILT });
  assert.equal(quantity, "period");
  assert.equal(stored, true);
  assert.deepEqual(points, [null, null]);
  assert.equal(firstState(ABOUT, "nothing").view.base, "rolling");
  assert.equal(baseOf(ABOUT, { ...VIEW, base: "nothing" }).name, "rolling");
});

test("changing the settings of one motion leaves those of the other", () => {
  const both = ["first", "second"];
  assert.deepEqual(withSlot(both, 0, "new"), ["new", "second"]);
  assert.deepEqual(withSlot(both, 1, "new"), ["first", "new"]);
  assert.deepEqual(both, ["first", "second"]);
});

test("quantities of a base are in its order; an unknown one gives the first", () => {
  assert.deepEqual(
    quantitiesOf(ABOUT, "spinning").map(({ name }) => name),
    ["period", "stability"],
  );
  assert.equal(quantityOf(ABOUT, "nothing").name, "stability");
  assert.equal(parameterOf(ABOUT, "alpha").most, 1);
  assert.throws(() => parameterOf(ABOUT, "nothing"), /nothing/);
});

test("a word comes from the view, or else from its base; equal to the base it is not stored", () => {
  assert.equal(wordOf(ABOUT, VIEW, "alpha"), 0.5);
  const view = withWord(ABOUT, VIEW, "alpha", 0.7);
  assert.equal(wordOf(ABOUT, view, "alpha"), 0.7);
  assert.deepEqual(VIEW.words, {});
  assert.deepEqual(withWord(ABOUT, view, "alpha", 0.5).words, {});
});

test("a parameter that becomes an axis has the range of its slider, and the old one keeps its middle", () => {
  const view = withAxis(ABOUT, { ...VIEW, words: { gravity: 5 } }, "x", "gravity");
  assert.equal(view.x.scale, "log");
  const [low, high] = ends(view.x);
  assert.ok(Math.abs(low - 0.1) < 1e-12 && Math.abs(high - 30) < 1e-12);
  assert.deepEqual(view.words, { roll_rate: 3 });
  // an axis of the base has that range
  assert.deepEqual(withAxis(ABOUT, view, "x", "roll_rate").x, RATE);
});

test("if the middle of a window is outside a slider, the nearer end is used", () => {
  const x = { ...RATE, centre: 300, half: 1 };
  assert.equal(withAxis(ABOUT, { ...VIEW, x }, "x", "alpha").words.roll_rate, 10);
  assert.equal(withAxis(ABOUT, { ...VIEW, x: { ...x, centre: -300 } }, "x", "alpha").words.roll_rate, -10);
});

test("choosing the parameter of the other axis swaps them; that of the same axis changes nothing", () => {
  const turned = withAxis(ABOUT, VIEW, "x", "tilt");
  assert.deepEqual([turned.x, turned.y], [TILT, RATE]);
  assert.equal(withAxis(ABOUT, VIEW, "y", "tilt"), VIEW);
});

test("another scale keeps the range, and a logarithm that would start at 0 starts at a thousandth of its end", () => {
  const same = (axis, [low, high]) => {
    const found = ends(axis);
    assert.ok(Math.abs(found[0] / low - 1) < 1e-12 && Math.abs(found[1] / high - 1) < 1e-12, String(found));
  };
  const log = withOtherScale(VIEW, "x");
  assert.equal(log.x.scale, "log");
  same(log.x, [2, 4]);
  same(withOtherScale(log, "x").x, [2, 4]);
  const wide = withOtherScale({ ...VIEW, x: { ...RATE, centre: 1, half: 4 } }, "x");
  same(wide.x, [0.005, 5]);
  same(withOtherScale({ ...VIEW, x: { ...RATE, centre: 2, half: 2 } }, "x").x, [0.004, 4]);
  const negative = { ...VIEW, x: { ...RATE, centre: -3 } };
  assert.equal(withOtherScale(negative, "x"), negative);
});

test("the whole range is that of the base, or of the slider, in the scale of the axis", () => {
  assert.equal(halfOfRange(ABOUT, { ...VIEW, x: { ...RATE, half: 0.01 } }, "x"), 1);
  const gravity = { name: "gravity", centre: 5, half: 1, scale: "linear" };
  assert.ok(Math.abs(halfOfRange(ABOUT, { ...VIEW, x: gravity }, "x") - 14.95) < 1e-12);
});

test("axes stay within their domains, and words outside them are omitted", () => {
  const y = { name: "tilt", centre: 1, half: 2, scale: "linear" };
  const words = { alpha: 1.5, gravity: 0, criterion: "x", other: 7 };
  const view = withinDomain(ABOUT, { ...VIEW, y, words });
  assert.deepEqual(ends(view.y), [-1.5, 1.5]);
  assert.deepEqual(view.words, { criterion: "x", other: 7 });
  assert.deepEqual(withinDomain(ABOUT, { ...VIEW, words: { alpha: 1 } }).words, { alpha: 1 });
});

test("parameters of a base are its words and its axes, in the order of the model", () => {
  const names = (view) => parametersOf(ABOUT, view).map(({ name }) => name);
  assert.deepEqual(names(VIEW), ["tilt", "roll_rate", "alpha", "gravity"]);
  assert.deepEqual(names({ ...VIEW, base: "spinning" }), ["tilt", "roll_rate", "alpha"]);
});

test("verdicts have their words, and an unknown code has none", () => {
  assert.deepEqual(
    [0, 1, 2, 9].map((code) => verdictWords(ABOUT, code)),
    ["undecided", "stable", "unstable", ""],
  );
});

test("views of the same motions differ only in their windows", () => {
  const other = { ...VIEW, x: { ...RATE, centre: 9 } };
  assert.equal(wordsOf(VIEW), wordsOf(other));
  for (const unlike of [
    { ...VIEW, base: "spinning" },
    { ...VIEW, words: { alpha: 1 } },
    { ...VIEW, x: TILT, y: RATE },
  ]) {
    assert.notEqual(wordsOf(VIEW), wordsOf(unlike));
  }
});

test("a view is fixed if it shows only stored cells", () => {
  const atlas = { base: "rolling", live: false };
  assert.equal(isFixed(ABOUT, VIEW), false);
  assert.equal(isFixed({ ...ABOUT, atlas }, VIEW), true);
  assert.equal(isFixed({ ...ABOUT, atlas: { ...atlas, live: true } }, VIEW), false);
  assert.equal(isFixed({ ...ABOUT, atlas }, { ...VIEW, base: "spinning" }), false);
});

test("another radius or gravity keeps the map and the chosen starts in scaled rates", () => {
  const of = (more) => ({ ...ABOUT, ...more });
  const [first] = ABOUT.bases;
  const bases = [{ ...first, words: { ...first.words, radius: 0.5 } }];
  const about = of({ bases, criteria: [{ word: "departure" }] });
  const state = { ...firstState(about), points: [{ x: 2.5, y: 0.1 }, null] };
  const smaller = withValue(about, state, "radius", 0.125);
  assert.deepEqual(smaller.view.x, { ...state.view.x, centre: 6, half: 2 });
  assert.deepEqual(smaller.view.y, state.view.y);
  assert.deepEqual(smaller.points, [{ x: 5, y: 0.1 }, null]);
  assert.deepEqual(withValue(about, smaller, "radius", 0.5).view.x, state.view.x);
  // the whole range is that of the new radius
  assert.deepEqual(firstAxis(about, smaller.view, "roll_rate"), { ...state.view.x, centre: 6, half: 2 });
  const weak = withValue(about, state, "gravity", 9.81 / 4);
  assert.deepEqual([weak.view.x.centre, weak.view.x.half], [1.5, 0.5]);
  const log = { ...state, view: { ...state.view, x: { ...state.view.x, centre: 1, scale: "log" } } };
  assert.ok(Math.abs(withValue(about, log, "radius", 0.125).view.x.centre - 1 - Math.log(2)) < 1e-12);
  // the radius of a system has no special meaning
  assert.deepEqual(withValue(of({ bases }), state, "radius", 0.125).view.x, state.view.x);
  assert.deepEqual(withValue(about, state, "alpha", 0.7).view.x, state.view.x);
});
