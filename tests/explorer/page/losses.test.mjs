/** Losses of a motion: their words, refusals, and sliders. */

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  checkArms,
  checkLosses,
  lossControls,
  lossWords,
  numberOf,
  wordsOfMotion,
} from "eulerdisk/compute/losses";
import { placeOf, valueAt } from "eulerdisk/motion/loss_sliders";

const TABLES = {
  no_air: "none",
  air: { air_viscosity: 1.8e-5, air_density: 1.2 },
  mass: 0.4,
  air_laws: ["none", "moffatt", "bildsten"],
  lossy_parameters: [
    "mass",
    "rolling_friction",
    "pivoting_friction",
    "contour_friction",
    "contour_damping",
    "friction",
  ],
  sliders: [
    { name: "rolling_friction", low: 1e-5, high: 0.1, scaled: "radius", end: "low" },
    { name: "contour_damping", low: 1e-3, high: 1, scaled: "damping", end: "low" },
    { name: "friction", low: 0.01, high: 2, end: "high" },
    { name: "mass", low: 0.001, high: 10, scaled: "one" },
    { name: "air_law", choices: ["none", "moffatt", "bildsten"] },
  ],
};

const CELLS = {
  lossy: true,
  body: null,
  losses: {
    air_law: "bildsten",
    air_viscosity: 2e-5,
    air_density: 1,
    mass: 0.1,
    rolling_friction: 1e-3,
    friction: null,
  },
};
const NONE = { lossy: false, body: null, losses: {} };

test("a mass alone is no loss, and a loss brings what its law needs", () => {
  assert.deepEqual(lossWords(TABLES, {}), {});
  assert.deepEqual(lossWords(TABLES, { mass: 3 }), {});
  assert.deepEqual(lossWords(TABLES, { friction: 0.2 }), { air_law: "none", friction: 0.2 });
  assert.deepEqual(lossWords(TABLES, { contour_damping: 0.1 }), {
    air_law: "none",
    contour_damping: 0.1,
    mass: 0.4,
  });
  const air = { air_law: "moffatt", air_viscosity: 1.8e-5, mass: 0.4 };
  assert.deepEqual(lossWords(TABLES, { air_law: "moffatt" }), air);
  const layer = { air_law: "bildsten", air_viscosity: 1.8e-5, air_density: 1.2, mass: 0.05 };
  assert.deepEqual(lossWords(TABLES, { air_law: "bildsten", mass: 0.05 }), layer);
});

test("a motion's losses keep those of the cells and add only what a law still needs", () => {
  assert.deepEqual(wordsOfMotion(TABLES, CELLS, {}), CELLS.losses);
  assert.deepEqual(wordsOfMotion(TABLES, CELLS, { rolling_friction: 0.01 }), {
    ...CELLS.losses,
    rolling_friction: 0.01,
  });
  assert.deepEqual(wordsOfMotion(TABLES, CELLS, { mass: 2 }), { ...CELLS.losses, mass: 2 });
  const still = { ...CELLS.losses, air_law: "none", air_viscosity: 0, air_density: 0 };
  assert.deepEqual(wordsOfMotion(TABLES, CELLS, { air_law: "none" }), still);
  const dry = { ...CELLS, losses: { ...still, mass: null } };
  const found = wordsOfMotion(TABLES, dry, { air_law: "moffatt" });
  assert.deepEqual([found.air_viscosity, found.mass, found.air_density], [1.8e-5, 0.4, 0]);
  assert.deepEqual(wordsOfMotion(TABLES, NONE, { friction: 0.2 }), { air_law: "none", friction: 0.2 });
});

test("the kernels have a number for every word: no mass is 1, and no coefficient never slips", () => {
  const words = { rolling_friction: 0, mass: null };
  const numbers = ["rolling_friction", "mass", "friction", "contour_friction"].map((name) =>
    numberOf(words, name),
  );
  assert.deepEqual(numbers, [0, 1, Infinity, 0]);
});

test("invalid losses are refused", () => {
  checkLosses(TABLES, { rolling_friction: 0, friction: 0.1, mass: 1, air_law: "moffatt" });
  for (const given of [
    { magic: 1 },
    { rolling_friction: -1e-9 },
    { rolling_friction: "x" },
    { rolling_friction: NaN },
    { friction: 0 },
    { mass: 0 },
    { air_law: "helium" },
    { air_law: 3 },
  ]) {
    const [name] = Object.keys(given);
    assert.throws(() => checkLosses(TABLES, given), { message: new RegExp(`${name}`), status: 400 });
  }
});

test("a lever arm is shorter than the radius", () => {
  const names = ["rolling_friction", "pivoting_friction", "contour_friction"];
  for (const name of names) {
    checkArms({ [name]: 0.4999, friction: 9, contour_damping: 9 }, 0.5);
    assert.throws(() => checkArms({ [name]: 0.5 }, 0.5), new RegExp(name));
  }
});

test("sliders have ends in proportion to the disk, and values of the cells or of the user", () => {
  const at = { radius: 0.5, gravity: 9.81 };
  const controls = (plan, given = {}) =>
    Object.fromEntries(lossControls(TABLES, plan, at, given).map((each) => [each.name, each]));
  const { rolling_friction, contour_damping, friction, mass, air_law } = controls(CELLS, { friction: 0.3 });
  assert.deepEqual([rolling_friction.low, rolling_friction.high, rolling_friction.value], [5e-6, 0.05, 1e-3]);
  const unit = 0.1 * 0.5 ** 2 * Math.sqrt(9.81 / 0.5);
  assert.deepEqual([contour_damping.low, contour_damping.value], [1e-3 * unit, null]);
  assert.deepEqual([friction.low, friction.high, friction.value], [0.01, 2, 0.3]);
  assert.deepEqual([mass.value, mass.idle, air_law.value], [0.1, false, "bildsten"]);
  const bare = controls(NONE, { rolling_friction: 0 });
  assert.deepEqual([bare.rolling_friction.value, bare.mass.idle, bare.air_law.value], [null, true, "none"]);
  assert.equal(bare.contour_damping.high, 0.4 * 0.5 ** 2 * Math.sqrt(9.81 / 0.5));
  const body = { lossy: false, losses: {}, body: { faced: false } };
  assert.ok(!("air_law" in controls(body)));
  assert.deepEqual(controls({ ...body, body: { faced: false, poles: true } }), {});
});

test("a slider has no loss at one end, and every value near its place", () => {
  for (const end of ["low", "high"]) {
    const control = { low: 1e-3, high: 0.1, end };
    const places = Array.from({ length: 241 }, (_, place) => place);
    const values = places.map((place) => valueAt(control, place));
    assert.equal(values.filter((each) => each === null).length, 1);
    assert.equal(values[end === "low" ? 0 : 240], null);
    places.forEach((place) => assert.ok(Math.abs(placeOf(control, values[place]) - place) <= 1));
  }
});
