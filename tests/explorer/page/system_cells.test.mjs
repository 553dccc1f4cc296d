/** Derived values of a system's cell from its passes; test_truth.py compares random cells with the program. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { plain, scriptsOf } from "./worker_scripts.mjs";

const { systemColumns } = scriptsOf("system_cells");

const [UNRESOLVED, DIFFERENT] = [9, 8];

/** A system with one state, whose square is conserved, with two passes and a duration of 10 s. */
const PLAN = {
  parameters: ["x"],
  unresolved: UNRESOLVED,
  failed: [UNRESOLVED],
  kernel_settings: [10, 0, 1e-6],
  system: {
    passes: ["first", "last"],
    states: ["x"],
    state_ends: [{ name: "end_x", stated: "end_x_error" }],
    end_time: "end_time",
    end_time_stated: "time_error",
    measures: [
      { name: "peak", stated: "peak_error", kind: "max", expressions: ["x", ["-", 0, "x"]] },
      { name: "lowest", stated: "lowest_error", kind: "min", expressions: ["x"] },
      { name: "final", stated: "final_error", kind: "last", expressions: [["*", 2, ["**", "x", 2]]] },
    ],
    labels: [
      [["-", "x", 1]],
      [
        ["neg", "x"],
        ["-", "t", 1],
      ],
    ],
    conserved: [["*", "x", "x"]],
    columns: [
      "peak",
      "lowest",
      "final",
      "end_x",
      "end_x_error",
      "end_time",
      "label",
      "conserved_change",
      "ending",
    ],
    coded: ["label", "ending"],
    different: DIFFERENT,
    same_time: 0.01,
    same_place: 0.1,
    shares: [1],
    of_states: 0,
    least: 0,
    few_steps: 0,
    of_times: 1,
    rounding: 0,
    grown: 0,
  },
};

/** Columns of one cell whose passes end at places and times with codes. */
function cell({ places = [2, 2], times = [5, 5], endings = [4, 4], start = 1 } = {}) {
  const measured = { steps: Float64Array.of(100), unproved: Float64Array.of(0) };
  PLAN.system.passes.forEach((pass, i) => {
    const values = { x: places[i], end_time: times[i], ending: endings[i], "largest x": 2 };
    Object.assign(values, { "peak 0": 3, "peak 1": 7, "lowest 0": 4 });
    for (const [name, value] of Object.entries(values)) measured[`${pass}: ${name}`] = Float64Array.of(value);
  });
  const found = plain(systemColumns(PLAN, { x: Float64Array.of(start) }, measured, 1));
  return Object.fromEntries(Object.entries(found).map(([name, [value]]) => [name, value]));
}

test("a cell ends like its last two passes if their place and time agree; otherwise it is sensitive", () => {
  assert.equal(cell().ending, 4);
  for (const unlike of [
    { endings: [4, 5] },
    { endings: [5, 4] },
    { times: [5, 5.11] },
    { places: [2, 2.21] },
  ]) {
    assert.equal(cell(unlike).ending, DIFFERENT);
  }
  assert.equal(cell({ times: [5, 5.09], places: [2, 2.19] }).ending, 4);
});

test("a cell with an unresolved pass is unresolved and has no numbers", () => {
  for (const endings of [
    [UNRESOLVED, 4],
    [4, UNRESOLVED],
  ]) {
    const { ending, peak, end_x, conserved_change, label } = cell({ endings });
    assert.deepEqual([ending, peak, end_x, conserved_change, label], [UNRESOLVED, NaN, NaN, NaN, 0]);
  }
});

test("measures are the largest, the smallest and the last value of their expressions", () => {
  const { peak, lowest, final, end_x, end_time } = cell({ places: [3, -3], times: [4, 5] });
  // for a smallest value, the kernel has the largest of minus the expression
  assert.deepEqual([peak, lowest, final, end_x, end_time], [7, -4, 18, -3, 5]);
});

/** A count and a time of a condition, whose passes have these numbers. */
function moments(given = {}, places = [2, 2]) {
  const { counts, levels, times } = { counts: [3, 3], levels: [1, 1], times: [2, 2], ...given };
  const named = (kind, name, when) => {
    const moment = { kind: when, of_condition: true, expressions: [["-", "x", 1]] };
    return { name, stated: `${name}_error`, kind, expressions: [], moment };
  };
  const columns = ["count", "count_error", "began", "began_error", "ending"];
  const measures = [named("count", "count", "last"), named("time", "began", "first")];
  const plan = {
    ...PLAN,
    system: { ...PLAN.system, measures, labels: [], conserved: [], columns, unknown: 1e30 },
  };
  const measured = { steps: Float64Array.of(100), unproved: Float64Array.of(0) };
  PLAN.system.passes.forEach((pass, i) => {
    const values = { x: places[i], end_time: 5, ending: 4, "largest x": 2 };
    for (const { name } of measures) {
      Object.assign(values, {
        [`${name} count`]: counts[i],
        [`${name} level`]: levels[i],
        [`${name} time`]: times[i],
      });
    }
    for (const [name, value] of Object.entries(values)) measured[`${pass}: ${name}`] = Float64Array.of(value);
  });
  const found = plain(systemColumns(plan, { x: Float64Array.of(1) }, measured, 1));
  return columns.slice(0, 4).map((name) => found[name][0]);
}

test("a count and a time are decided if passes agree and no error can change them", () => {
  const unknown = 1e30;
  assert.deepEqual(moments(), [3, 0, 2, 0]);
  assert.deepEqual(moments({ counts: [2, 3] }), [3, unknown, 2, 0]);
  assert.deepEqual(moments({ times: [2, 2.11] }), [3, 0, 2.11, unknown]);
  assert.deepEqual(moments({ counts: [0, 0], times: [NaN, NaN] }), [0, 0, NaN, NaN]);
  // the end of the motion, where the last pass has no time
  assert.deepEqual(moments({ times: [2, NaN] }), [3, 0, 5, unknown]);
  // the error of x is a sixteenth of its size, and the terms of the condition add up to 3
  assert.deepEqual(moments({ levels: [1, 0.1] }, [2, 2.125]), [3, unknown, 2, unknown]);
  assert.deepEqual(moments({ levels: [0.1, 0.2] }, [2, 2.125]), [3, 0, 2, 0]);
  // of a sensitive motion the first time may be known
  assert.deepEqual(moments({}, [2, 2.5]), [3, unknown, 2, 0]);
});

test("the error of a state is the difference of its passes, if nothing else is added", () => {
  const { end_x_error } = cell({ places: [2, 2.125] });
  assert.equal(end_x_error, 0.125);
});

test("a label is the first whose expressions are all positive in both passes", () => {
  assert.equal(cell({ places: [2, 2] }).label, 1);
  assert.equal(cell({ places: [-2, -2] }).label, 2);
  assert.equal(cell({ places: [-2, -2], times: [0.5, 0.5] }).label, 0);
  assert.equal(cell({ places: [0.95, 1.05] }).label, 0);
});

test("the change of a conserved quantity is relative to its largest term", () => {
  assert.equal(cell({ start: 1, places: [2, 2] }).conserved_change, 3 / 4);
  assert.equal(cell({ start: -2, places: [2, 2] }).conserved_change, 0);
  assert.ok(Number.isNaN(cell({ times: [NaN, NaN] }).conserved_change));
});
