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
