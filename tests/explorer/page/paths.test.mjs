/** The times and steps of sampled motions; test_motions.py compares them with SciPy and the energy balance. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { freePath } from "eulerdisk/compute/free_path";
import { evenly, largest, lossyPath, turning, unresolved, untilLater } from "eulerdisk/compute/paths";
import { torusOf } from "eulerdisk/compute/shapes";

const { signal } = new AbortController();

test("times are evenly spaced and end at the duration to the bit", () => {
  const times = evenly(0.3, 7);
  assert.deepEqual([times.length, times[0], times.at(-1)], [8, 0, 0.3]);
  assert.ok(times.every((each, i) => Math.abs(each - (0.3 * i) / 7) < 1e-16));
  assert.deepEqual([...untilLater(0.5, 3)], [0, 0.5, 1, 1.5]);
});

test("the largest magnitude counts either sign; of nothing it is 0", () => {
  assert.deepEqual([largest(Float64Array.of(1, -3, 2)), largest(new Float64Array(0))], [3, 0]);
});

test("a body turns as fast as its rates; near a pole heading and roll cancel", () => {
  const rows = [
    [0, Math.PI / 2],
    [3, 0],
    [4, 7],
    [1, -7],
  ].map((row) => Float64Array.from(row));
  assert.deepEqual(
    [...turning({ rows }, false)].map((each) => Number(each.toFixed(12))),
    [5, 7],
  );
  assert.deepEqual(
    [...turning({ rows }, true)].map((each) => Number(each.toFixed(12))),
    [Number(Math.hypot(1, 5).toFixed(12)), 0],
  );
});

test("a motion that cannot be resolved says when", () => {
  assert.match(unresolved(1.23456789).message, /until 1\.23457 s/);
  for (const time of [0, -0.07, NaN]) assert.doesNotMatch(unresolved(time).message, /until|0/);
});

/**
 * A computation whose motions turn at rates and end at `ends` with a code; `drift` gives the energy drift for a step, and
 * `off` the error of the heading.
 */
function computing({ rate = 1, ends = Infinity, code = 4, drift = () => 0, horizon = 3, off = () => 0 }) {
  const asked = [];
  const ask = async (what, { name, values }) => {
    const [, { numbers: settings }, { numbers: times, shape }] = values;
    asked.push({ name, step: settings[1], times, count: times.length, shape });
    const filled =
      times[times.length - 1] <= ends ? times.length : times.findIndex((each) => each > ends) + 1;
    const last = Math.min(ends, times[times.length - 1]);
    const [rows] = values[3].shape;
    const samples = new Float64Array(rows * times.length);
    for (let i = 0; i < filled; i += 1) {
      const time = i === filled - 1 ? last : times[i];
      samples[2 * times.length + i] = rate;
      samples[4 * times.length + i] = rate * time + off(settings[1]);
      // the energy of a motion with losses
      if (rows === 21) samples[20 * times.length + i] = i ? drift(settings[1]) : 0;
    }
    return { results: [last < ends ? horizon : code, filled, last], arrays: [null, null, null, samples] };
  };
  return { ask, asked };
}

test("a slow disk has a thousand samples, and a fast one has one per fifth of a radian", async () => {
  const size = { fallTilt: 1.5, number: 0, poles: false, unit: 0.2, radius: 0.5 };
  const start = torusOf({
    tilt: 0.1,
    tilt_rate: 1,
    precession_rate: 2,
    roll_rate: 3,
    alpha: 0.4,
    radius: 0.5,
    gravity: 9,
  });
  assert.deepEqual(start, [0.1, 1, 2, 3, 0, 0, 0, 0, 0, 0.4, 0.2, 0.5, 9]);
  const slow = await freePath(computing({ rate: 1 }), start, 6, size, signal);
  assert.deepEqual([slow.times.length, slow.times.at(-1)], [1001, 6]);
  const wild = await freePath(computing({ rate: 1e6 }), start, 6, size, signal);
  assert.equal(wild.times.length, 200_001);
});

const LOSSY = { flatTilt: 1.5, law: 0, body: null };

test("with losses samples are denser towards rest and reach its end", async () => {
  const resting = (code) => lossyPath(computing({ ends: 2, code }), new Array(11).fill(0), 10, LOSSY, signal);
  const { times, ending } = await resting(2);
  assert.deepEqual([ending, times.at(-1)], [2, 2]);
  const gaps = times.slice(1).map((each, i) => each - times[i]);
  assert.ok(times.length > 1000);
  assert.ok(gaps.at(-2) < gaps[0] / 50);
  // a slip is sudden: samples are evenly spaced up to it
  const even = await resting(5);
  const [first, last] = [even.times[1], even.times.at(-2) - even.times.at(-3)];
  assert.ok(Math.abs(last / first - 1) < 0.05);
});

test("with losses the step is halved until the energy is balanced to 1e-9", async () => {
  const steps = async (drift) => {
    const computation = computing({ drift });
    await lossyPath(computation, new Array(11).fill(0), 6, LOSSY, signal);
    return [...new Set(computation.asked.map(({ step }) => step))];
  };
  assert.deepEqual(await steps(() => 1e-10), [0.1]);
  assert.deepEqual(await steps((step) => (step < 0.04 ? 0 : 1e-6)), [0.1, 0.05, 0.025]);
});

test("a motion held by friction from its start stands, and one that slips or lifts off there has none", async () => {
  const at = (code, body = null) =>
    lossyPath(computing({ ends: 0, code }), new Array(11).fill(0), 4, { ...LOSSY, body }, signal);
  const { times, rows } = await at(2);
  assert.deepEqual([times.length, times.at(-1), rows[0].length], [1001, 4, 1001]);
  await assert.rejects(at(5), { message: /the disk slips/, hint: /friction/ });
  await assert.rejects(at(6, 1), { message: /the body lifts off/, hint: /slower/ });
});

test("a body is sampled as often as it turns, and integrated until half the step changes nothing", async () => {
  const size = { fallTilt: 1.5, number: 1, poles: false, unit: 0.2, radius: 0.5 };
  const computation = computing({ rate: 50 });
  const path = await freePath(computation, new Array(13).fill(0), 10, size, signal);
  assert.ok(Math.abs(path.times.length - (10 * 50) / 0.2) < 3);
  assert.deepEqual(
    computation.asked.map(({ step }) => step),
    [0.04, 0.01, 0.005],
  );
  const ended = await freePath(computing({ rate: 1, ends: 2 }), new Array(13).fill(0), 10, size, signal);
  assert.equal(ended.times.at(-1), 2);
  assert.ok(ended.times.length >= 1000 && ended.times.length < 1010);
  const off = (step) => ({ 0.01: 1e-6, 0.005: 1e-8 })[step] ?? 0;
  const rough = computing({ off });
  await freePath(rough, new Array(13).fill(0), 10, size, signal);
  assert.deepEqual(
    rough.asked.map(({ step }) => step),
    [0.04, 0.01, 0.005, 0.0025, 0.00125],
  );
  const never = freePath(computing({ ends: 2, code: 5 }), new Array(13).fill(0), 10, size, signal);
  await assert.rejects(never, /until 2 s/);
});
