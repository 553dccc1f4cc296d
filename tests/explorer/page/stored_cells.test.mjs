/** Stored cells of an exported page: their windows, their points, and packed arrays. */

import assert from "node:assert/strict";
import { deflateSync } from "node:zlib";
import { test } from "node:test";
import { unpackedArray } from "eulerdisk/packed";
import { nearest, StoredCells } from "eulerdisk/stored_cells";
import { firstState } from "eulerdisk/state";
import { ABOUT, RATE } from "./about.mjs";

/** An array as the program packs it: deflated by zlib, in base64. */
function packed(type, array) {
  return { type, data: deflateSync(new Uint8Array(array.buffer)).toString("base64") };
}

test("an array of any type is unpacked to the bit", async () => {
  const doubles = Float64Array.of(1 / 3, -0, NaN, Infinity, 5e-324);
  const found = await unpackedArray(packed("f8", doubles));
  assert.ok(found instanceof Float64Array);
  assert.ok(doubles.every((each, i) => Object.is(each, found[i])));
  assert.deepEqual(await unpackedArray(packed("f4", Float32Array.of(0.1, -2))), Float32Array.of(0.1, -2));
  const long = Uint8Array.from({ length: 100_000 }, (_, i) => i % 251);
  assert.deepEqual(await unpackedArray(packed("u1", long)), long);
  assert.deepEqual(await unpackedArray(packed("f8", new Float64Array(0))), new Float64Array(0));
});

const X = Float64Array.of(2, 2.5, 3, 3.5, 4);
const Y = Float64Array.of(0.01, 0.1, 1);

const CELLS = {
  peak_tilt: Float64Array.from({ length: 15 }, (_, i) => (i === 7 ? NaN : i)),
  verdict: Uint8Array.from({ length: 15 }, (_, i) => i % 3),
  stability: Uint8Array.from({ length: 15 }, (_, i) => i % 3),
  gravity: Float64Array.from({ length: 15 }, (_, i) => 10 + i),
};

const ATLAS = {
  base: "rolling",
  live: false,
  note: "5 by 3 cells",
  x: { scale: "linear" },
  y: { scale: "log" },
};
const STARTS = { alpha: 0.5 };
const about = { ...ABOUT, atlas: ATLAS };
const { view: VIEW } = firstState(ABOUT);
const Y_AXIS = { name: "tilt", centre: Math.log(0.1), half: 1.5 * Math.LN10, scale: "log" };
const PLANE = { ...VIEW, x: { ...RATE, centre: 3, half: 1.25 }, y: Y_AXIS };

const arrays = { x: packed("f8", X), y: packed("f8", Y) };
const types = { verdict: "u1", stability: "u1" };
const stored = {
  ...arrays,
  cells: Object.fromEntries(
    Object.entries(CELLS).map(([name, each]) => [name, packed(types[name] ?? "f8", each)]),
  ),
  starts: STARTS,
};
const read = () => StoredCells.read({ about, stored });

test("a page without cells has none", async () => {
  assert.equal(await StoredCells.read({ about, stored: null }), null);
});

test("a window with as many pixels as cells has their values, in their rows", async () => {
  const cells = await read();
  const found = await cells.window({ view: PLANE, width: 5, height: 3, quantity: "peak_tilt" });
  assert.deepEqual([...found.value], [...CELLS.peak_tilt]);
  assert.deepEqual([...found.verdict], [...CELLS.verdict]);
  assert.ok(found.stored.every((each) => each === 1));
  assert.deepEqual(found.head, { low: 0, high: 14, least: 1, end: false, note: "" });
});

test("places without a cell are empty, and a window outside all cells has no ends", async () => {
  const cells = await read();
  const wide = { ...PLANE, x: { ...RATE, centre: 3, half: 2.5 } };
  const { value, stored: origin } = await cells.window({
    view: wide,
    width: 25,
    height: 1,
    quantity: "peak_tilt",
  });
  // pixels are at 0.6, 0.8 and so on, and cells extend from 1.75 to 4.25
  assert.deepEqual(
    [...origin],
    Array.from({ length: 25 }, (_, i) => (i >= 6 && i <= 18 ? 1 : 2)),
  );
  assert.deepEqual([...value.slice(6, 19)], [5, 5, 5, 6, 6, NaN, NaN, NaN, 8, 8, 9, 9, 9]);
  assert.ok([...value.slice(0, 6), ...value.slice(19)].every(Number.isNaN));
  const beside = { ...PLANE, x: { ...RATE, centre: 30, half: 1 } };
  const { head } = await cells.window({ view: beside, width: 4, height: 4, quantity: "peak_tilt" });
  assert.deepEqual([head.low, head.high, head.least], [null, null, null]);
});

test("if cells are visible as such, the note says what is stored", async () => {
  const cells = await read();
  const request = { view: PLANE, quantity: "peak_tilt" };
  assert.equal((await cells.window({ ...request, width: 51, height: 31 })).head.note, "5 by 3 cells");
  assert.equal((await cells.window({ ...request, width: 50, height: 20 })).head.note, "");
});

test("another plane, other words, and a quantity that is not stored have no stored window", async () => {
  const cells = await read();
  const request = { view: PLANE, width: 2, height: 2, quantity: "peak_tilt" };
  assert.notEqual(await cells.window(request), null);
  for (const other of [
    { ...request, quantity: "period" },
    { ...request, view: { ...PLANE, words: { alpha: 1 } } },
    { ...request, view: { ...PLANE, x: PLANE.y, y: PLANE.x } },
  ]) {
    assert.equal(await cells.window(other), null);
  }
});

test("a point has the nearest cell's start, fixed values and computed parameters", async () => {
  const cells = await read();
  assert.deepEqual(cells.at({ x: 2.6, y: 0.2 }), { x: 2.5, y: 0.1, index: 6 });
  const { start, numbers, verdict, stored: none } = await cells.point({ view: PLANE, x: 2.6, y: 0.2 });
  assert.deepEqual(start, {
    tilt: { value: 0.1, text: "5.72958 deg" },
    roll_rate: { value: 2.5, text: "2.5 rad s-1" },
    alpha: { value: 0.5, text: "0.5" },
    gravity: { value: 16, text: "16 m s-2" },
  });
  assert.deepEqual(numbers, [
    { name: "peak_tilt", label: "peak tilt", description: "", value: 6, text: "343.775 deg" },
  ]);
  assert.deepEqual([verdict, none], ["undecided", null]);
  const missing = await cells.point({ view: PLANE, x: 3, y: 0.1 });
  assert.deepEqual(
    [missing.numbers[0].value, missing.numbers[0].text, missing.verdict],
    [null, "none", "stable"],
  );
  assert.equal(await cells.point({ view: PLANE, x: 20, y: 0.1 }), null);
  assert.equal(await cells.point({ view: { ...PLANE, words: { alpha: 1 } }, x: 3, y: 0.1 }), null);
});

test("a place has the nearest cell within half a cell, for increasing and decreasing cells", () => {
  for (const [places, order] of [
    [
      [0, 1, 3],
      [0, 1, 2],
    ],
    [
      [3, 1, 0],
      [2, 1, 0],
    ],
  ]) {
    const wanted = [-0.51, -0.5, 0.49, 0.51, 1.99, 2.01, 4, 4.01];
    assert.deepEqual(
      wanted.map((each) => nearest(places, each)),
      [-1, 0, 0, 1, 1, 2, 2, -1].map((i) => order[i] ?? -1),
    );
  }
  assert.equal(nearest([5], 100), 0);
});
