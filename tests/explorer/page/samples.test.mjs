/** Samples of a motion, and the figures of them. */

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  forcesFigure,
  ledgerFigure,
  potentialAt,
  potentialFigure,
  tiltFigure,
} from "eulerdisk/motion/figures";
import { rangeOf } from "eulerdisk/motion/plot";
import { Samples } from "eulerdisk/motion/samples";
import { systemFigures } from "eulerdisk/motion/system_figures";

const near = (found, expected) => assert.ok(Math.abs(found - expected) < 1e-12, `${found} ${expected}`);
const doubles = (...values) => Float64Array.from(values);

const TIMES = doubles(0, 0.1, 0.4, 0.5, 1.1, 1.3, 2);
const QUANTITIES = {
  time: { label: "time", unit: "s", factor: 1 },
  tilt: { label: "tilt", unit: "deg", factor: 180 / Math.PI },
  potential: { label: "potential", unit: "", factor: 1 },
  energy: { label: "energy", unit: "", factor: 1 },
};

/** Samples of a motion with losses, which has no potential. */
const samplesOf = (arrays, head = {}) =>
  new Samples({
    head: { lossy: true, quantities: QUANTITIES, turns: [], ...head },
    arrays: { time: TIMES, ...arrays },
  });

test("a parabola is exact between uneven samples, and beyond both ends the motion stays", () => {
  const parabola = (t) => 3 * t * t - 2 * t + 1;
  const samples = samplesOf({ tilt: TIMES.map(parabola) });
  for (const time of [0.15, 0.3, 0.45, 0.7, 1, 1.2]) near(samples.at("tilt", time), parabola(time));
  assert.deepEqual(
    [-1, 0, 2, 9].map((time) => samples.at("tilt", time)),
    [1, 1, parabola(2), parabola(2)],
  );
  TIMES.forEach((time, i) => near(samples.at("tilt", time), samples.arrays.tilt[i]));
});

test("at both ends a line is exact, and there are no jumps between intervals", () => {
  const samples = samplesOf({ tilt: TIMES.map((time) => 5 - 2 * time) });
  for (const time of [0.05, 0.3, 1.9]) near(samples.at("tilt", time), 5 - 2 * time);
  const wild = samplesOf({ tilt: doubles(1, -3, 8, 0, 2, -5, 7) });
  for (const time of TIMES.slice(1, -1)) {
    assert.ok(Math.abs(wild.at("tilt", time - 1e-9) - wild.at("tilt", time + 1e-9)) < 1e-6);
    const slopes = [-1e-6, 1e-6].map((step) => (wild.at("tilt", time + step) - wild.at("tilt", time)) / step);
    assert.ok(Math.abs(slopes[0] - slopes[1]) < 1e-2);
  }
});

test("the sample before a time is never the last one", () => {
  const samples = samplesOf({});
  assert.deepEqual(
    [-1, 0, 0.05, 0.1, 1.2, 2, 5].map((time) => samples.before(time)),
    [0, 0, 0, 1, 4, 5, 5],
  );
  assert.deepEqual(samples.between(0.8), { before: 3, share: (0.8 - 0.5) / (1.1 - 0.5) });
  assert.deepEqual(
    [samples.between(-1), samples.between(9)],
    [
      { before: 0, share: 0 },
      { before: 5, share: 1 },
    ],
  );
  assert.equal(samples.length, 2);
  // a motion that ends where it starts
  const still = new Samples({ head: { lossy: true }, arrays: { time: doubles(0, 0), tilt: doubles(3, 4) } });
  assert.deepEqual([still.at("tilt", 0), still.between(0)], [3, { before: 0, share: 0 }]);
});

test("a range has some margin around its values, even if they are equal", () => {
  near(rangeOf([1, 3, NaN, 2]).low, 1 - 0.14);
  near(rangeOf([1, 3]).high, 3 + 0.14);
  const same = rangeOf([5, 5 + 1e-15]);
  assert.ok(same.low < 4.6 && same.high > 5.4);
  assert.ok(rangeOf([0]).low < 0 && rangeOf([0]).high > 0);
  assert.deepEqual(rangeOf([NaN]), { low: 0, high: 1 });
});

test("the tilt is drawn in degrees over the longer time, with its turning points", () => {
  const samples = samplesOf({ tilt: TIMES.map(() => Math.PI / 180) }, { turns: [[Math.PI / 6, "30 deg"]] });
  const { x, curves, lines, xLabel, yLabel } = tiltFigure(samples, 7);
  assert.deepEqual([x, xLabel, yLabel], [{ low: 0, high: 7 }, "time (s)", "tilt (deg)"]);
  near(curves[0].y[3], 1);
  near(lines[0].y, 30);
});

test("forces are drawn at least from 0 to the weight; a short peak is cut off", () => {
  const flat = TIMES.map(() => 0.5);
  const forces = (normal_force, friction_needed = flat, length = 2) =>
    forcesFigure(
      samplesOf({
        normal_force,
        friction_needed,
        friction_across: TIMES.map(() => 0.3),
        friction_along: TIMES.map(() => -0.4),
      }),
      length,
    );
  const { y, curves } = forces(flat);
  assert.deepEqual(y, rangeOf([0, 1]));
  // the other motion is longer
  assert.deepEqual(forces(flat, flat, 7).x, { low: 0, high: 7 });
  curves.find(({ kind }) => kind === "horizontal").y.forEach((each) => near(each, 0.5));
  const peak = TIMES.map((_, i) => (i === 3 ? 100 : 1));
  assert.deepEqual(forces(peak).y, rangeOf([0, 100]));
  // less than a twentieth of the time, between denser samples
  const short = TIMES.map((_, i) => (i === 6 ? 100 : 1));
  assert.deepEqual(forces(short).y, rangeOf([0, 2.5]));
  assert.deepEqual(forces(TIMES.map(() => -9)).y, rangeOf([-2.5, 1]));
  assert.deepEqual(
    forces(
      flat,
      TIMES.map(() => Infinity),
    ).y,
    rangeOf([0, 1]),
  );
});

test("a ledger is stacked on the energy, and zero losses are not drawn", () => {
  const arrays = {
    energy: doubles(3, 2),
    rolling: doubles(0, 0.5),
    air: doubles(0, 0.5),
    contour: doubles(0, 0),
    time: doubles(0, 1),
  };
  const samples = samplesOf(arrays, { ledger: { rolling: "rolling", contour: "contour", air: "air!" } });
  assert.deepEqual(ledgerFigure(samples, 7).x, { low: 0, high: 7 });
  const { areas, y } = ledgerFigure(samples, 1);
  assert.deepEqual(
    areas.map(({ kind, label, y: top }) => [kind, label, ...top]),
    [
      ["energy", "energy", 3, 2],
      ["rolling", "rolling", 3, 2.5],
      ["air", "air!", 3, 3],
    ],
  );
  assert.deepEqual([y.low, y.high], [0, 1.05 * 3]);
});

test("the potential has its wells, barriers and turning points, and its height at every tilt", () => {
  const head = { quantities: QUANTITIES, turns: [[-1, "-57.3 deg"]] };
  const potential = {
    tilt: doubles(-1, 0, 2),
    excess: doubles(1, 0, 4),
    wells: [[0.0123456789, -0.1]],
    barriers: [[-0.7654321, 0.2]],
  };
  const samples = { head, potential };
  const { dots, x, lines } = potentialFigure(samples);
  assert.deepEqual(
    dots.map(({ kind, label }) => `${kind}: ${label}`),
    [
      "well: well at 0.70736 deg",
      "barrier: barrier at \u221243.856 deg",
      "turn: turning point at \u221257.3 deg",
    ],
  );
  assert.deepEqual([dots[0].y, dots[1].y, dots[2].y, lines[0].y], [-0.1, 0.2, 0, 0]);
  near(dots[1].x, (-0.7654321 * 180) / Math.PI);
  near(x.high, 360 / Math.PI);
  assert.deepEqual(
    [-1, -0.5, 0, 1, 2].map((tilt) => potentialAt(samples, tilt)),
    [1, 0.5, 0, 2, 4],
  );
  assert.equal(potentialAt(samples, -1 - 1e-7), 1);
  for (const beyond of [-1.1, 2.1]) assert.ok(Number.isNaN(potentialAt(samples, beyond)));
  assert.throws(() => potentialFigure(samplesOf({})));
});

test("each state of a system is drawn over time, dashed when uncertain, and two of them in a plane", () => {
  const quantities = {
    time: { label: "time", unit: "ms", factor: 1000 },
    x: { label: "x", unit: "", factor: 1 },
    speed: { label: "speed", unit: "mm/s", factor: 1000 },
  };
  const head = { lossy: false, quantities, states: ["x", "speed"], doubtful: 0.5, turns: [] };
  const [x, speed] = [TIMES.map((time) => 2 * time), TIMES.map(() => 3)];
  const samples = new Samples({ head, arrays: { time: TIMES, x, speed } });
  assert.equal(samples.potential, null);
  const [first, second, plane, ...more] = systemFigures(samples, 4);
  assert.deepEqual(more, []);
  assert.deepEqual([first.name, first.seeks, plane.name, plane.seeks], ["state-x", true, "plane", false]);
  assert.deepEqual(first.figure.x, { low: 0, high: 4000 });
  assert.equal(second.figure.yLabel, "speed (mm/s)");
  const [known, doubtful] = first.figure.curves;
  assert.deepEqual([known.kind, [...known.x]], ["known", [0, 100, 400]]);
  assert.deepEqual([doubtful.kind, doubtful.x[0], doubtful.x.at(-1)], ["doubtful", 400, 2000]);
  assert.deepEqual(first.cursorAt(0.4), [400]);
  assert.deepEqual(plane.cursorAt(0.4), [0.8, 3000]);
  const certain = new Samples({ head: { ...head, doubtful: null }, arrays: { time: TIMES, x, speed } });
  assert.equal(systemFigures(certain, 4)[0].figure.curves.length, 1);
});
