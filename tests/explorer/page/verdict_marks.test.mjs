/** Marks painted over the colors of a number: undecided cells, and borders that hide no cells. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { markVerdicts } from "eulerdisk/verdict_marks";

const [WIDTH, HEIGHT] = [240, 120];
const GREY = 0xffd4d4d4;
const BLACK = 0xff000000;
const [UNDECIDED, STABLE, UNSTABLE] = [0, 1, 2];

/** Pixels with marks, by the column and the row from the bottom; every cell has another value. */
function marked(verdictAt, { hasBorders = true, valueAt = (c, r) => r * WIDTH + c } = {}) {
  const places = Array.from({ length: WIDTH * HEIGHT }, (_, i) => [i % WIDTH, Math.floor(i / WIDTH)]);
  const answer = {
    value: Float64Array.from(places, ([c, r]) => valueAt(c, r)),
    verdict: Uint8Array.from(places, ([c, r]) => verdictAt(c, r)),
    width: WIDTH,
    height: HEIGHT,
  };
  const pixels = new Uint32Array(WIDTH * HEIGHT);
  const hasUndecided = markVerdicts(pixels, answer, hasBorders);
  const at = (c, r) => pixels[(HEIGHT - 1 - r) * WIDTH + c];
  return { at, hasUndecided, count: (colour) => pixels.filter((each) => each === colour).length };
}

/** Reproducible random numbers from 0 to 1. */
function numbers() {
  let state = 1;
  return () => (state = (state * 48271) % 2147483647) / 2147483647;
}

test("undecided cells are gray, and those without a value are unchanged", () => {
  const verdictAt = (c, r) => (r === 0 && c < 2 ? UNDECIDED : STABLE);
  const { at, hasUndecided, count } = marked(verdictAt, { valueAt: (c) => (c === 1 ? NaN : c) });
  assert.deepEqual([at(0, 0), at(1, 0), count(GREY), hasUndecided], [GREY, 0, 1, true]);
  assert.equal(marked(() => STABLE).hasUndecided, false);
});

test("a border between large regions is a whole line, and only drawn on request", () => {
  const verdictAt = (c) => (c < 100 ? STABLE : UNSTABLE);
  const { at, count } = marked(verdictAt);
  assert.equal(count(BLACK), HEIGHT);
  for (const row of [0, 60, HEIGHT - 1]) assert.equal(at(99, row), BLACK);
  assert.equal(marked(verdictAt, { hasBorders: false }).count(BLACK), 0);
});

test("alternating cells have no lines, neither computed ones nor larger stored ones", () => {
  for (const side of [1, 4]) {
    const random = numbers();
    const drawn = Array.from({ length: WIDTH * HEIGHT }, random);
    const cell = (c, r) => Math.floor(r / side) * WIDTH + Math.floor(c / side);
    const { count } = marked((c, r) => (drawn[cell(c, r)] < 0.5 ? STABLE : UNSTABLE), { valueAt: cell });
    assert.ok(count(BLACK) < 0.01 * WIDTH * HEIGHT, `${side}: ${count(BLACK)}`);
  }
});

test("a single cell has no line around it", () => {
  for (const side of [1, 5]) {
    const cell = (c, r) => Math.floor(r / side) * WIDTH + Math.floor(c / side);
    const { count } = marked((c, r) => (cell(c, r) === 10 * WIDTH + 10 ? UNSTABLE : STABLE), {
      valueAt: cell,
    });
    assert.equal(count(BLACK), 0);
  }
});
