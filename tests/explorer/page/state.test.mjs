/** The state of the page: bases, words and axes, and changes that leave the former state as it was. */

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

test("a base begins with its view and its usual quantity; of an unknown name the first base does", () => {
  const { view, quantity, stored, points } = firstState(ABOUT, "spinning");
  assert.deepEqual(view, { base: "spinning", words: {}, x: RATE, y: TILT });
  assert.equal(quantity, "period");
  assert.equal(stored, true);
  assert.deepEqual(points, [null, null]);
  assert.equal(firstState(ABOUT, "nothing").view.base, "rolling");
  assert.equal(baseOf(ABOUT, { ...VIEW, base: "nothing" }).name, "rolling");
});

test("other settings of one motion leave those of the other one", () => {
  const both = ["first", "second"];
  assert.deepEqual(withSlot(both, 0, "new"), ["new", "second"]);
  assert.deepEqual(withSlot(both, 1, "new"), ["first", "new"]);
  assert.deepEqual(both, ["first", "second"]);
});

test("quantities of a base are in its order; an unknown one is the first of all", () => {
  assert.deepEqual(
    quantitiesOf(ABOUT, "spinning").map(({ name }) => name),
    ["period", "stability"],
  );
  assert.equal(quantityOf(ABOUT, "nothing").name, "stability");
  assert.equal(parameterOf(ABOUT, "alpha").most, 1);
  assert.throws(() => parameterOf(ABOUT, "nothing"), /nothing/);
});

test("a word is that of the view, otherwise that of its base; one that is the base's own is not kept", () => {
  assert.equal(wordOf(ABOUT, VIEW, "alpha"), 0.5);
  const view = withWord(ABOUT, VIEW, "alpha", 0.7);
  assert.equal(wordOf(ABOUT, view, "alpha"), 0.7);
  assert.deepEqual(VIEW.words, {});
  assert.deepEqual(withWord(ABOUT, view, "alpha", 0.5).words, {});
});

test("a parameter that becomes an axis has the range of its slider, and the former one keeps its middle", () => {
  const view = withAxis(ABOUT, { ...VIEW, words: { gravity: 5 } }, "x", "gravity");
  assert.equal(view.x.scale, "log");
  const [low, high] = ends(view.x);
  assert.ok(Math.abs(low - 0.1) < 1e-12 && Math.abs(high - 30) < 1e-12);
  assert.deepEqual(view.words, { roll_rate: 3 });
  // and one that is an axis of the base has that range
  assert.deepEqual(withAxis(ABOUT, view, "x", "roll_rate").x, RATE);
});

test("the middle of a window beyond a slider is its nearer end", () => {
  const x = { ...RATE, centre: 300, half: 1 };
  assert.equal(withAxis(ABOUT, { ...VIEW, x }, "x", "alpha").words.roll_rate, 10);
  assert.equal(withAxis(ABOUT, { ...VIEW, x: { ...x, centre: -300 } }, "x", "alpha").words.roll_rate, -10);
});

test("the parameter of the other axis changes places with it; that of the same axis changes nothing", () => {
  const turned = withAxis(ABOUT, VIEW, "x", "tilt");
  assert.deepEqual([turned.x, turned.y], [TILT, RATE]);
  assert.equal(withAxis(ABOUT, VIEW, "y", "tilt"), VIEW);
});

test("another scale has the same range, and a logarithm that would begin at 0 begins at a thousandth of its end", () => {
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

test("all of a range is that of the base, or of the slider, in the scale of the side", () => {
  assert.equal(halfOfRange(ABOUT, { ...VIEW, x: { ...RATE, half: 0.01 } }, "x"), 1);
  const gravity = { name: "gravity", centre: 5, half: 1, scale: "linear" };
  assert.ok(Math.abs(halfOfRange(ABOUT, { ...VIEW, x: gravity }, "x") - 14.95) < 1e-12);
});

test("axes are kept within their domains, and words beyond them are left out", () => {
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

test("views of the same motions differ in their windows alone", () => {
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

test("a view is fixed where stored cells are all that it shows", () => {
  const atlas = { base: "rolling", live: false };
  assert.equal(isFixed(ABOUT, VIEW), false);
  assert.equal(isFixed({ ...ABOUT, atlas }, VIEW), true);
  assert.equal(isFixed({ ...ABOUT, atlas: { ...atlas, live: true } }, VIEW), false);
  assert.equal(isFixed({ ...ABOUT, atlas }, { ...VIEW, base: "spinning" }), false);
});

test("another radius or gravity leaves the map and the chosen starts where they are in scaled rates", () => {
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
  // what a system calls its radius is its own affair
  assert.deepEqual(withValue(of({ bases }), state, "radius", 0.125).view.x, state.view.x);
  assert.deepEqual(withValue(about, state, "alpha", 0.7).view.x, state.view.x);
});
