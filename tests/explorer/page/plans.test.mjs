/** Plans of a page without a server, changed by numbers. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { plansWith } from "eulerdisk/compute/plans";
import { firstState } from "eulerdisk/state";
import { ABOUT } from "./about.mjs";

const { view: VIEW } = firstState(ABOUT);

const PLAN = {
  parameters: ["tilt", "roll_rate", "alpha", "gravity"],
  held: { alpha: 0.5, gravity: 9.81, precession_rate: 0 },
  rates: [0, 0],
  from_start: false,
  settings: { fall_tilt: 1.4, tolerance: 1e-9 },
};

const PLANS = {
  cells: PLAN,
  lossy: null,
  disk: PLAN,
  refused: null,
  motion: { lossy: false, fall_tilt: 1.4, flat_tilt: 1.5 },
};

const withWords = (words, plans = PLANS) => plansWith(ABOUT, plans, { ...VIEW, words });
const withRates = (rates, words, x = VIEW.x) =>
  plansWith(ABOUT, { ...PLANS, cells: { ...PLAN, rates } }, { ...VIEW, x, words }).cells;

test("numbers replace fixed values in each of the plans; the old plans stay unchanged", () => {
  const { cells, disk, lossy, motion } = withWords({ alpha: 0.8 });
  assert.deepEqual([cells.held.alpha, disk.held.alpha, lossy], [0.8, 0.8, null]);
  assert.deepEqual(cells.settings, PLAN.settings);
  assert.equal(motion.fall_tilt, 1.4);
  assert.equal(PLAN.held.alpha, 0.5);
});

test("the tilt of a fall affects cells and motions", () => {
  const { cells, motion } = withWords({ fall_tilt: 1.1 });
  assert.deepEqual(
    [cells.settings, motion.fall_tilt, motion.flat_tilt],
    [{ fall_tilt: 1.1, tolerance: 1e-9 }, 1.1, 1.5],
  );
  assert.equal(withWords({ fall_tilt: 1.57 }).motion.fall_tilt, 1.57);
});

test("words of the page itself are known; others are refused with advice", () => {
  assert.equal(withWords({ criterion: "departure:5deg" }).cells.held.alpha, 0.5);
  assert.throws(() => withWords({ criterion: "departure:6deg" }), {
    message: /criterion=departure:6deg/,
    status: 400,
    hint: /explore/,
  });
});

test("a given rate, or one that is an axis, is not computed by a rule", () => {
  const x = { ...VIEW.x, name: "alpha" };
  assert.deepEqual(withRates([1, 3], {}).rates, [1, 0]);
  assert.deepEqual(withRates([1, 3], {}, x).rates, [1, 3]);
  assert.deepEqual(withRates([1, 3], { precession_rate: 2 }, x).rates, [0, 3]);
});

test("a circling motion is disturbed at its start", () => {
  const x = { ...VIEW.x, name: "alpha" };
  assert.equal(withRates([0, 0], {}).from_start, false);
  assert.equal(withRates([2, 0], {}).from_start, true);
  assert.equal(withRates([0, 3], { precession_rate: 1 }, x).from_start, true);
});

test("incompatible rates are refused", () => {
  const x = { ...VIEW.x, name: "alpha" };
  assert.throws(() => withRates([4, 4], { roll_rate: 1 }, x), /wobble/);
  assert.deepEqual(withRates([4, 4], {}, x).rates, [4, 4]);
  assert.throws(() => withRates([0, 3], { precession_rate: 0 }, x), /No roll rate/);
  assert.deepEqual(withRates([0, 3], { precession_rate: 0.1 }, x).rates, [0, 3]);
});

test("a given moment of a body is not computed from a shape", () => {
  const body = { ...PLAN, body: { number: 1, hollow: 0, follows: [1, 2] } };
  const given = (words) => withWords(words, { ...PLANS, cells: body }).cells.body.follows;
  assert.deepEqual(given({}), [1, 2]);
  assert.deepEqual(given({ transverse_moment: 0.3 }), [1, 0]);
  assert.deepEqual(given({ axial_moment: 0.3 }), [0, 2]);
});

test("a system accepts only numbers of its parameters", () => {
  const cells = { system: {}, parameters: ["length"], held: { length: 1 } };
  const plans = { ...PLANS, cells, disk: null, motion: null };
  assert.deepEqual(withWords({ length: 0.3 }, plans).cells.held, { length: 0.3 });
  assert.throws(() => withWords({ duration: 3 }, plans), /duration=3/);
  assert.equal(withWords({ length: 0.3 }, plans).motion, null);
});
