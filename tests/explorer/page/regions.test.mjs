/** Names of regions: each where it has most room, checked against every place of the raster. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { codesOf, rasterOf, roomiest } from "eulerdisk/regions";

const STEP = 6;

test("a raster has a point per six pixels and covers those under lines and marks", () => {
  const { columns, rows, covered } = rasterOf(62, 33, [], []);
  assert.deepEqual([columns, rows], [10, 5]);
  assert.ok(covered.every((each) => each === 0));
  const line = rasterOf(
    60,
    30,
    [
      [
        [0, 15],
        [60, 15],
      ],
    ],
    [],
  ).covered;
  assert.deepEqual(
    Array.from(line, (each, i) => each === Number(Math.floor(i / 10) === 2)),
    Array(50).fill(true),
  );
  const steep = rasterOf(
    60,
    30,
    [
      [
        [3, -100],
        [3, 9],
      ],
    ],
    [],
  ).covered;
  assert.deepEqual(
    [...steep.keys()].filter((i) => steep[i]),
    [0, 10],
  );
});

test("a mark covers twelve pixels on each side, within the plot", () => {
  const { covered } = rasterOf(
    60,
    60,
    [],
    [
      [30, 30],
      [-60, -60],
    ],
  );
  const places = [...covered.keys()].filter((i) => covered[i]).map((i) => [i % 10, Math.floor(i / 10)]);
  assert.deepEqual(
    places,
    [3, 4, 5, 6, 7].flatMap((row) => [3, 4, 5, 6, 7].map((column) => [column, row])),
  );
});

test("codes are requested at the centers of the points, from the upper left corner", () => {
  const asked = [];
  const raster = { columns: 2, rows: 2, covered: new Uint8Array(4) };
  const codes = codesOf(raster, (across, up) => asked.push([across, up]));
  assert.deepEqual(asked, [
    [-0.5, 0.5],
    [0.5, 0.5],
    [-0.5, -0.5],
    [0.5, -0.5],
  ]);
  assert.deepEqual(codes, [1, 2, 3, 4]);
});

/** The most room in a region by trying every box: half its width, or -1 if the word does not fit. */
function room({ columns, rows, covered }, codes, code, size, column, row) {
  const [wide, high] = size.map((each) => Math.ceil((each / 2 + STEP) / STEP));
  const isFree = (x) => {
    const y = Math.round((high * x) / wide);
    if (column < x || row < y || column + x >= columns || row + y >= rows) return false;
    for (let i = column - x; i <= column + x; i += 1) {
      for (let j = row - y; j <= row + y; j += 1) {
        if (codes[j * columns + i] !== code || covered[j * columns + i]) return false;
      }
    }
    return true;
  };
  let most = -1;
  for (let x = wide; x < columns && isFree(x); x += 1) most = x;
  return most;
}

test("a name is where there is most room, in a map of any shape", () => {
  let seed = 1;
  const random = () => (seed = (seed * 48271) % 2147483647) / 2147483647;
  let placed = 0;
  for (let map = 0; map < 30; map += 1) {
    const raster = rasterOf(
      240,
      180,
      [
        [
          [0, 180 * random()],
          [240, 180 * random()],
        ],
      ],
      [[240 * random(), 90]],
    );
    const [middle, slope, bend] = [random() - 0.5, 2 * random() - 1, 2 * random() - 1];
    const codes = codesOf(raster, (across, up) =>
      up > middle + slope * across + bend * across ** 2 ? 1 : 2,
    );
    for (const code of [1, 2]) {
      const size = [40, 16];
      const places = codes.map((each, i) =>
        each === code
          ? room(raster, codes, code, size, i % raster.columns, Math.floor(i / raster.columns))
          : -1,
      );
      const most = Math.max(...places);
      const found = roomiest(raster, codes, code, size);
      if (most < 0) assert.equal(found, null);
      else {
        const [column, row] = found.map((each) => each / STEP - 0.5);
        assert.equal(places[row * raster.columns + column], most);
        placed += 1;
      }
    }
  }
  assert.ok(placed > 20);
});

test("among places with equal room, the middle one has the name; a small region has none", () => {
  const raster = { columns: 21, rows: 5, covered: new Uint8Array(105) };
  assert.deepEqual(roomiest(raster, Array(105).fill(1), 1, [6, 6]), [10.5 * STEP, 2.5 * STEP]);
  assert.equal(roomiest(raster, Array(105).fill(1), 2, [6, 6]), null);
  assert.equal(roomiest(raster, Array(105).fill(1), 1, [300, 6]), null);
});
