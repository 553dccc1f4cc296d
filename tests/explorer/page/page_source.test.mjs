/** The answers of an exported page without a server. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { PageSource } from "eulerdisk/page_source";
import { firstState } from "eulerdisk/state";
import { ABOUT } from "./about.mjs";

const { view: VIEW } = firstState(ABOUT);
const LINES = [
  {
    name: "analytic",
    label: "analytic",
    points: [
      [
        [2, 0],
        [4, 0.2],
      ],
    ],
  },
];
const CELLS = {
  shown: ["peak_tilt"],
  timed: [],
  path: [],
  criterion: { named: [], timed: false, text: "departure:5deg" },
  numbers: [],
  starts: ["tilt", "roll_rate"].map((name) => ({ name, unit: "", factor: 1, single: false, flags: null })),
  settings: { fall_tilt: 1.4 },
  rates: [0, 0],
  held: {},
};
const PLANS = { cells: CELLS, lossy: null, disk: null, motion: null, refused: null };
const PAGE = { about: ABOUT, plans: PLANS, lines: LINES, stored: null };

/** A source of a page whose cells are all equal. */
function sourceOf(page = PAGE, stored = null) {
  const ask = async (what, { x, y }) => {
    if (what === "cells") return { tilt: [0.02], roll_rate: [3], stability: [1] };
    const count = (x.to - x.from) * (y.to - y.from);
    return {
      value: new Float64Array(count),
      verdict: new Uint8Array(count),
      low: 0,
      high: 0,
      least: Infinity,
    };
  };
  return new PageSource(page, stored, { ask, size: 1, ready: Promise.resolve() });
}

const withX = (more) => ({ ...VIEW, x: { ...VIEW.x, ...more } });

test("lines are those of the exported window and its words, down to a sixteenth of it", async () => {
  const source = sourceOf();
  const isShown = async (view) => (await source.lines(view)).length > 0;
  assert.deepEqual(await source.lines(VIEW), LINES);
  for (const view of [
    withX({ half: 1 / 16 }),
    withX({ centre: 3.5, half: 0.5 }),
    withX({ centre: 2.5, half: 0.5 }),
  ]) {
    assert.ok(await isShown(view));
  }
  for (const view of [
    { ...VIEW, words: { alpha: 1 } },
    withX({ half: 0.0624 }),
    withX({ half: 1.1 }),
    withX({ centre: 3.6, half: 0.5 }),
    withX({ centre: 2.4, half: 0.5 }),
    withX({ name: "alpha" }),
    { ...VIEW, y: { ...VIEW.y, half: 0.1 } },
  ]) {
    assert.equal(await isShown(view), false);
  }
});

test("a window without its lines says so, but not on a page that has none", async () => {
  const request = { view: { ...VIEW, words: { alpha: 1 } }, width: 2, height: 2, quantity: "peak_tilt" };
  assert.match((await sourceOf().window(request)).head.note, /lines of theory/);
  assert.equal((await sourceOf().window({ ...request, view: VIEW })).head.note, "");
  assert.equal((await sourceOf({ ...PAGE, lines: [] }).window(request)).head.note, "");
});

test("a place is explained by its cell, its line and the criterion, but not for a motion with losses", async () => {
  const words = await sourceOf().explain({ view: VIEW, x: 3, y: 0.02 });
  assert.match(words, /^cell +roll rate 3, tilt 0.02$/m);
  assert.match(words, /^lines +roll rate 2.2 rad/m);
  assert.match(words, /^verdict +stable by departure:5deg$/m);
  const lossy = await sourceOf().explain({ view: VIEW, x: 3, y: 0.02, losses: { friction: 1 } });
  assert.doesNotMatch(lossy, /verdict/);
  const none = sourceOf({ ...PAGE, plans: { ...PLANS, cells: null } });
  assert.equal(await none.explain({ view: VIEW, x: 3, y: 0.02 }), "No cell here.");
});

test("a point has its cell's numbers only if nothing can be computed", () => {
  const stored = { at: ({ x }) => (x > 0 ? { x: 1, y: 2, index: 3 } : null) };
  assert.equal(sourceOf(PAGE, stored).cellAt, null);
  assert.equal(sourceOf().cellAt, null);
  const { cellAt } = sourceOf({ ...PAGE, plans: { ...PLANS, cells: null } }, stored);
  assert.deepEqual([cellAt({ x: 5, y: 5 }), cellAt({ x: -5, y: 5 })], [{ x: 1, y: 2 }, null]);
});

test("a damaged page says what to do", async () => {
  await assert.rejects(PageSource.read("{", ""), {
    message: /cannot be read/,
    hint: /export the page again/,
  });
  globalThis.Worker = class {};
  const stored = { x: { type: "f8", data: "AAAA" }, y: { type: "f8", data: "AAAA" }, cells: {}, starts: {} };
  await assert.rejects(PageSource.read(JSON.stringify({ ...PAGE, stored }), ""), {
    message: /cannot be read/,
  });
});
