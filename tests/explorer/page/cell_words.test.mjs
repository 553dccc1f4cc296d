/** The text about a cell without a server. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { wordsOfCell } from "eulerdisk/cell_words";
import { parameterOf } from "eulerdisk/state";
import { ABOUT } from "./about.mjs";

const SIDES = { x: parameterOf(ABOUT, "roll_rate"), y: parameterOf(ABOUT, "tilt") };

const NUMBERS = {
  start: {
    tilt: { value: 0.1, text: "5.72958 deg" },
    roll_rate: { value: 2.5, text: "2.5 rad s-1" },
    tilt_rate: { value: 0, text: "0 rad s-1" },
  },
  numbers: [{ name: "peak_tilt", text: "6e-13 deg", value: 1e-14, description: "largest tilt" }],
  verdict: "stable",
  stored: null,
};

const LINES = [
  {
    name: "analytic",
    label: "the analytic line",
    points: [
      [
        [2, 0],
        [4, 0.2],
      ],
      [
        [7, 0.05],
        [8, 0.07],
      ],
    ],
  },
];

const CELL = { sides: SIDES, numbers: NUMBERS, lines: LINES, criterion: "departure:5deg" };

test("a cell has its place, its start, its numbers, the lines of its row, and its verdict", () => {
  assert.deepEqual(wordsOfCell(CELL).split("\n"), [
    "cell        roll rate 2.5 rad s\u207b\u00b9, tilt 5.72958 deg",
    "start       tilt rate 0 rad s\u207b\u00b9",
    "",
    "  peak tilt         6\u00d710\u207b\u00b9\u00b3 deg           largest tilt",
    "",
    "lines       roll rate 3 rad s\u207b\u00b9          the analytic line",
    "            roll rate 2.5 rad s\u207b\u00b9        this cell",
    "",
    "verdict     stable by departure:5deg",
  ]);
});

test("a row that no line crosses, and a plane without a control, have no lines", () => {
  const beyond = { ...NUMBERS, start: { ...NUMBERS.start, tilt: { value: 1, text: "57.3 deg" } } };
  assert.ok(!wordsOfCell({ ...CELL, numbers: beyond }).includes("this cell"));
  const sides = { ...SIDES, x: { ...SIDES.x, control: false } };
  assert.ok(!wordsOfCell({ ...CELL, sides }).includes("this cell"));
});

test("along a vertical control the crossings are those of the column, and a verdict may have no criterion", () => {
  const turned = LINES.map((line) => ({
    ...line,
    points: line.points.map((all) => all.map(([x, y]) => [y, x])),
  }));
  const words = wordsOfCell({ ...CELL, sides: { x: SIDES.y, y: SIDES.x }, lines: turned, criterion: "" });
  assert.match(words, /^lines {7}roll rate 3 rad/m);
  assert.match(words, /^verdict {5}stable$/m);
});
