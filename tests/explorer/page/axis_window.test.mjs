/** Windows along one axis: places and values, zoom, and the limits of a window. */

import assert from "node:assert/strict";
import { test } from "node:test";
import {
  axisBetween,
  between,
  ends,
  leastHalf,
  moved,
  pixelValue,
  placeOf,
  roundestAt,
  ulp,
  valueAt,
  within,
  zoomed,
} from "eulerdisk/axis_window";

const LINEAR = { name: "x", centre: 3, half: 2, scale: "linear" };
const LOG = { name: "x", centre: Math.log(10), half: Math.log(10), scale: "log" };

const near = (found, expected, off = 1e-14) =>
  assert.ok(Math.abs(found - expected) <= off * Math.max(1, Math.abs(expected)), `${found} ${expected}`);

test("the middle and the ends of a window have their values", () => {
  assert.deepEqual(
    [-1, 0, 0.5, 1].map((place) => valueAt(LINEAR, place)),
    [1, 3, 4, 5],
  );
  [-1, 0, 1].forEach((place) => near(valueAt(LOG, place), 10 ** (place + 1)));
  assert.deepEqual(ends(LINEAR), [1, 5]);
});

test("a value has its place; on a logarithmic axis a negative value has none", () => {
  for (const axis of [LINEAR, LOG]) {
    for (const place of [-1, -0.3, 0, 0.7, 1]) near(placeOf(axis, valueAt(axis, place)), place);
  }
  assert.ok(Number.isNaN(placeOf(LOG, -1)));
  assert.equal(placeOf(LOG, 0), -Infinity);
});

test("pixels have the values at their centers, from the low end", () => {
  assert.deepEqual(
    [0, 1, 2, 3].map((pixel) => pixelValue(LINEAR, pixel, 4)),
    [1.5, 2.5, 3.5, 4.5],
  );
});

test("the unit in the last place is the distance to the next double, for small and large numbers", () => {
  assert.equal(ulp(0), 2 ** -1074);
  assert.equal(ulp(-1), 2 ** -52);
  assert.equal(ulp(Number.MAX_VALUE), 2 ** 971);
  assert.equal(ulp(1 - 2 ** -53), 2 ** -53);
  assert.equal(ulp(2 ** -1022), 2 ** -1074);
});

test("the roundest value within a pixel is displayed, in the displayed unit", () => {
  assert.equal(roundestAt({ ...LINEAR, centre: Math.PI, half: 1 }, 0, 100, 1), 3.14);
  assert.equal(roundestAt({ ...LINEAR, centre: Math.PI, half: 1 }, 0, 4, 1), 3);
  const degrees = 180 / Math.PI;
  assert.equal(roundestAt({ ...LINEAR, centre: 0.35, half: 0.1 }, 0, 20, degrees), 20 / degrees);
  // if all digits are needed, the value is that of the place
  const narrow = { ...LINEAR, centre: 1 / 3, half: 2 ** -54 };
  assert.equal(roundestAt(narrow, 0, 1000, 1), 1 / 3);
});

test("an axis from one value to another ends at these values", () => {
  const [low, high] = ends(axisBetween("x", 0.1, 1000, "log"));
  near(low, 0.1);
  near(high, 1000);
  assert.deepEqual(axisBetween("x", -2, 6, "linear"), { name: "x", centre: 2, half: 4, scale: "linear" });
  // a logarithmic axis cannot start at 0
  assert.deepEqual(axisBetween("x", 0, 6, "log"), { name: "x", centre: 3, half: 3, scale: "linear" });
});

test("a pixel is at least eight units in the last place wide, and for a logarithm eight times that of 1", () => {
  assert.equal(leastHalf({ ...LINEAR, centre: 3 }, 100), (8 * 2 ** -51 * 100) / 2);
  assert.equal(leastHalf({ ...LOG, centre: 0.001 }, 100), (8 * 2 ** -52 * 100) / 2);
  assert.equal(leastHalf({ ...LOG, centre: -5 }, 100), (8 * 2 ** -50 * 100) / 2);
});

test("zoom keeps the value at its place and stops at both limits", () => {
  const limits = { least: 1e-3, most: 10 };
  for (const place of [-1, -0.25, 0, 0.6]) {
    for (const factor of [0.5, 3]) {
      near(valueAt(zoomed(LINEAR, factor, place, limits), place), valueAt(LINEAR, place));
    }
  }
  assert.equal(zoomed(LINEAR, 0.5, 0, limits).half, 1);
  assert.equal(zoomed(LINEAR, 1e-9, 0, limits).half, 1e-3);
  assert.equal(zoomed(LINEAR, 1e9, 0, limits).half, 10);
});

test("an axis beyond a limit may stay but not move further", () => {
  const wide = { ...LINEAR, half: 50 };
  assert.equal(zoomed(wide, 2, 0, { least: 1, most: 10 }).half, 50);
  assert.equal(zoomed(wide, 0.5, 0, { least: 1, most: 10 }).half, 25);
  assert.equal(zoomed({ ...LINEAR, half: 0.1 }, 0.5, 0, { least: 1, most: 10 }).half, 0.1);
});

test("an axis moves by multiples of half its width", () => {
  assert.deepEqual(moved(LINEAR, 0.5), { ...LINEAR, centre: 4 });
  assert.deepEqual(moved(LINEAR, -2), { ...LINEAR, centre: -1 });
});

test("an axis within limits stays, one beyond is moved, and one too wide is narrowed", () => {
  assert.deepEqual(within(LINEAR, 0, 10), LINEAR);
  assert.deepEqual(within(LINEAR, null, null), LINEAR);
  assert.deepEqual(within(LINEAR, 2, 10), { ...LINEAR, centre: 4 });
  assert.deepEqual(within(LINEAR, null, 4), { ...LINEAR, centre: 2 });
  assert.deepEqual(within({ ...LINEAR, half: 20 }, -2, 8), { ...LINEAR, centre: 3, half: 5 });
  const [low, high] = ends(within({ ...LOG, half: 50 }, 1e-3, 1e3));
  near(low, 1e-3, 1e-12);
  near(high, 1e3, 1e-12);
});

test("a logarithmic axis of a parameter that may be 0 ends at the smallest numbers", () => {
  const [low, high] = ends(within({ ...LOG, centre: 0, half: 1e4 }, 0, null));
  assert.ok(low > 0 && high < Infinity);
});

test("the map between two axes is a scale and an offset; axes with other names or scales have none", () => {
  assert.deepEqual(between({ ...LINEAR, centre: 4, half: 1 }, LINEAR), [0.5, 0.5]);
  assert.deepEqual(between(LINEAR, LINEAR), [1, 0]);
  assert.equal(between(LINEAR, { ...LINEAR, name: "y" }), null);
  assert.equal(between(LINEAR, LOG), null);
});
