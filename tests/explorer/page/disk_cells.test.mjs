/** Derived values of disk cells; test_truth.py compares random cells with the program. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { plain, scriptsOf } from "./worker_scripts.mjs";

const { diskColumns } = scriptsOf("verdicts", "disk_cells");

const PLAN = {
  criterion: {
    outcomes: Array(8).fill([1, 2, 0]),
    condition: { terms: [{ value: 0 }, { value: 1 }], signs: ["<"] },
    named: [],
  },
  singles: [],
  losses: [],
  failed: [5],
  lost: [4],
  from_start: false,
};

const doubles = (...values) => Float64Array.from(values);

/** Starts of one cell for each tilt, at a rate. */
const starts = (tilts, rate = 0) => ({
  tilt: doubles(...tilts),
  tilt_rate: doubles(...tilts).fill(rate),
  alpha: doubles(...tilts).fill(0.5),
  radius: doubles(...tilts).fill(0.5),
  gravity: doubles(...tilts).fill(9.81),
});

const found = (plan, given, measured, wanted) =>
  plain(diskColumns(plan, given, measured, given.tilt.length, wanted));

test("the peak is the larger tilt on either side, and amplification is the reach over the disturbance", () => {
  const measured = { tilt_min: doubles(-0.3, -0.1), tilt_max: doubles(0.2, 0.4), ending: doubles(1, 1) };
  const { peak_tilt, amplification, stability } = found(PLAN, starts([0.1, 0.2]), measured);
  assert.deepEqual(peak_tilt, [0.3, 0.4]);
  assert.deepEqual(amplification, [0.3 / 0.1, 0.4 / 0.2]);
  assert.deepEqual(stability, [1, 1]);
});

test("a kick counts as the tilt that it causes without spin in half a swing", () => {
  const measured = { tilt_min: doubles(0), tilt_max: doubles(1), ending: doubles(1) };
  const rate = 3 * Math.sqrt((2 * 9.81) / (2.5 * 0.5));
  const { amplification } = found(PLAN, starts([4], rate), measured);
  assert.ok(Math.abs(amplification[0] - 1 / 5) < 1e-15);
  const body = { ...starts([4], 3 * Math.sqrt((2 * 9.81) / (2.6 * 0.5))), transverse_moment: doubles(0.3) };
  delete body.alpha;
  assert.ok(Math.abs(found(PLAN, body, measured).amplification[0] - 1 / 5) < 1e-15);
});

test("without a disturbance nothing is amplified; squares of small ones are not lost", () => {
  const measured = { tilt_min: doubles(0, 0), tilt_max: doubles(0.1, 3e-200), ending: doubles(1, 1) };
  const { amplification } = found(PLAN, starts([0, 1e-200]), measured);
  assert.ok(Number.isNaN(amplification[0]));
  assert.ok(Math.abs(amplification[1] - 3) < 1e-12);
});

test("a steady motion is disturbed at its own tilt, a spheroid on its end at a right angle", () => {
  const measured = { tilt_min: doubles(0.25), tilt_max: doubles(0.35), ending: doubles(1) };
  const steady = found({ ...PLAN, from_start: true }, starts([0.3], 0.1), measured);
  assert.ok(Math.abs(steady["the reach"][0] - 0.05) < 1e-15);
  const offset = doubles(0, 0, 0.1);
  const tilts = [1.5, -1.5, 0.1];
  const reach = (number, given) =>
    found(
      { ...PLAN, body: { number } },
      { ...starts(given), offset: offset.slice(0, given.length) },
      { tilt_min: doubles(...given), tilt_max: doubles(...given), ending: doubles(...given.map(() => 1)) },
    )["the reach"];
  const right = Math.PI / 2;
  assert.deepEqual(reach(5, tilts), [right - 1.5, right - 1.5, right - 0.1]);
  assert.deepEqual(reach(5, [0.1, 0.7]), [0.1, 0.7]);
  assert.deepEqual(reach(4, [0.1, -0.1]), [right - 0.1, right - 0.1]);
  assert.deepEqual(reach(3, [1.5]), [1.5]);
});

test("regimes count wells and crossings; falls and failures have their own", () => {
  const measured = {
    wells: Int32Array.of(1, 1, 2, 2, 1, 1, 0),
    tilt_min: doubles(0.1, -0.1, 0.1, -0.1, 0.1, 0.1, 0.1),
    tilt_max: doubles(0.2, 0.1, 0.2, 0.1, 0.2, 0.2, 0.2),
    ending: doubles(1, 1, 1, 1, 4, 5, 1),
  };
  assert.deepEqual(found(PLAN, starts([1, 1, 1, 1, 1, 1, 1]), measured).regime, [0, 1, 2, 3, 4, 5, 5]);
});

test("the largest loss is counted from 1, and is 0 if nothing was lost", () => {
  const plan = { ...PLAN, losses: ["rolling", "air"] };
  const measured = {
    rolling: doubles(0, 2, 1, NaN),
    air: doubles(0, 1, 2, 3),
    tilt_min: doubles(0, 0, 0, 0),
    tilt_max: doubles(0, 0, 0, 0),
    ending: doubles(1, 1, 1, 1),
  };
  assert.deepEqual(found(plan, starts([1, 1, 1, 1]), measured).largest_loss, [0, 1, 2, 2]);
});

test("only requested values and those of the criterion are computed, some in single precision", () => {
  const measured = () => ({ tilt_min: doubles(-0.1), tilt_max: doubles(0.3), ending: doubles(1) });
  assert.deepEqual(
    Object.keys(found(PLAN, starts([0.1]), measured(), "tilt_min")).includes("peak_tilt"),
    false,
  );
  const named = { ...PLAN, criterion: { ...PLAN.criterion, named: ["peak_tilt"] } };
  assert.deepEqual(found(named, starts([0.1]), measured(), "tilt_min").peak_tilt, [0.3]);
  const single = found({ ...PLAN, singles: ["tilt_max", "period"] }, starts([0.1]), measured());
  assert.deepEqual([single.tilt_max, single.tilt_min], [[Math.fround(0.3)], [-0.1]]);
});
