/** The origin of cells: a file, the page or the program; and the message if there are none. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { Computing } from "eulerdisk/compute/source";
import { Problem } from "eulerdisk/notice";
import { ABOUT, RATE, TILT } from "./about.mjs";

const VIEW = { base: "rolling", words: {}, x: RATE, y: TILT };
const CELLS = {
  shown: ["peak_tilt"],
  timed: ["peak_tilt"],
  path: [],
  criterion: { named: [], timed: false },
  numbers: [],
  starts: [],
};
const PLANS = { cells: CELLS, lossy: null, disk: null, motion: null, refused: null };
const REQUEST = { view: VIEW, width: 2, height: 2, quantity: "peak_tilt", stored: true };

const answerOf = (values, more = {}) => ({
  head: {
    low: Math.min(...values),
    high: Math.max(...values),
    least: Math.min(...values),
    end: false,
    note: "",
  },
  width: 2,
  height: 2,
  value: Float64Array.from(values),
  verdict: Uint8Array.of(1, 1, 1, 1),
  stored: null,
  ...more,
});

const unreachable = new Problem("gone", { unreachable: true });

/** A computation with parts that tests choose. */
function computing({ plans = PLANS, stored = null, program = null, cell = { stability: 1 } } = {}) {
  const piece = ({ x, y }) => {
    const value = Float64Array.of(5, 6, 7, 8).slice(2 * y.from, 2 * y.to);
    assert.deepEqual([x.from, x.to], [0, 2]);
    return {
      value,
      verdict: new Uint8Array(value.length).fill(2),
      low: value[0],
      high: value.at(-1),
      least: value[0],
    };
  };
  const ask = async (what, asked) =>
    what === "piece"
      ? piece(asked)
      : Object.fromEntries(Object.entries(cell).map(([name, each]) => [name, [each]]));
  const computation = { ask, size: 1, ready: Promise.resolve() };
  return new Computing(
    computation,
    async () => ABOUT,
    async () => plans,
    stored,
    program,
  );
}

const storing = (window, point = null) => ({ window: async () => window, point: async () => point });

test("stored cells fill a window, and are requested only if wanted", async () => {
  const stored = answerOf([1, 2, 3, 4], { stored: Uint8Array.of(1, 1, 1, 1) });
  assert.equal(await computing({ stored: storing(stored) }).window(REQUEST), stored);
  const other = await computing({ stored: storing(stored) }).window({ ...REQUEST, stored: false });
  assert.deepEqual([...other.value], [5, 6, 7, 8]);
});

test("cells that are not stored are computed; ends and note apply to all cells", async () => {
  const stored = answerOf([1, NaN, 3, NaN], {
    stored: Uint8Array.of(1, 2, 1, 2),
    verdict: Uint8Array.of(0, 0, 1, 0),
  });
  stored.head = { low: 1, high: 3, least: 1, end: false, note: "of the file" };
  const {
    head,
    value,
    verdict,
    stored: origin,
  } = await computing({ stored: storing(stored) }).window(REQUEST);
  assert.deepEqual(
    [[...value], [...verdict], [...origin]],
    [
      [1, 6, 3, 8],
      [0, 2, 1, 2],
      [1, 0, 1, 0],
    ],
  );
  assert.deepEqual([head.low, head.high, head.least, head.note], [1, 8, 1, "of the file"]);
});

test("a missing stored end is replaced by the computed one", async () => {
  const stored = answerOf([NaN, NaN, NaN, NaN], { stored: Uint8Array.of(1, 2, 2, 2) });
  stored.head = { low: null, high: null, least: null, end: false, note: "" };
  const { head } = await computing({ stored: storing(stored) }).window(REQUEST);
  assert.deepEqual([head.low, head.high, head.least], [5, 8, 5]);
});

test("cells that the page cannot compute are those stored, or missing", async () => {
  const plans = { ...PLANS, cells: null };
  const stored = answerOf([1, 2, 3, 4], { stored: Uint8Array.of(1, 2, 1, 2) });
  assert.equal(await computing({ plans, stored: storing(stored) }).window(REQUEST), stored);
  const none = await computing({ plans }).window(REQUEST);
  assert.ok([...none.value].every(Number.isNaN));
  assert.match(none.head.note, /^Peak tilt/);
  const codes = await computing({ plans }).window({ ...REQUEST, quantity: "stability" });
  assert.deepEqual([codes.value.constructor.name, ...codes.value], ["Uint8Array", 255, 255, 255, 255]);
  const refused = { error: "No.", hint: "Do." };
  await assert.rejects(computing({ plans: { ...plans, refused } }).window(REQUEST), {
    message: "No.",
    hint: "Do.",
    status: 400,
  });
});

test("the program computes what it computes faster; without it, the page does", async () => {
  const ofProgram = answerOf([9, 9, 9, 9]);
  const slow = { ...PLANS, cells: { ...CELLS, system: {} } };
  assert.equal(await computing({ plans: slow, program: async () => ofProgram }).window(REQUEST), ofProgram);
  assert.deepEqual(
    [...(await computing({ program: async () => ofProgram }).window(REQUEST)).value],
    [5, 6, 7, 8],
  );
  const gone = async () => {
    throw unreachable;
  };
  assert.deepEqual(
    [...(await computing({ plans: slow, program: gone }).window(REQUEST)).value],
    [5, 6, 7, 8],
  );
  const refused = async () => {
    throw new Problem("no");
  };
  await assert.rejects(computing({ plans: slow, program: refused }).window(REQUEST), { message: "no" });
});

const PLACE = { view: VIEW, x: 3, y: 0.02 };
const POINT = {
  start: { roll_rate: { value: 3 }, tilt: { value: 0.02 } },
  numbers: [],
  verdict: "stable",
  stored: null,
};

test("a point has the numbers of its cell, with the stored ones next to them", async () => {
  const found = await computing({ stored: storing(null, POINT) }).point(PLACE);
  assert.deepEqual([found.verdict, found.stored], ["stable", POINT]);
  assert.equal((await computing({ cell: { stability: 2 } }).point(PLACE)).verdict, "unstable");
});

test("for a motion with losses, a stored verdict applies only to its own start", async () => {
  const plans = { ...PLANS, cells: null, motion: { lossy: true } };
  const point = (place) => computing({ plans, stored: storing(null, POINT) }).point(place);
  assert.equal((await point(PLACE)).verdict, "stable");
  assert.equal((await point({ ...PLACE, losses: {} })).verdict, "stable");
  assert.equal((await point({ ...PLACE, x: 3.1, losses: {} })).verdict, "");
  assert.equal((await point({ ...PLACE, y: 0.021, losses: {} })).verdict, "");
  assert.equal((await point({ ...PLACE, x: 3.1 })).verdict, "stable");
});

test("a cell with losses is computed next to a motion that has some", async () => {
  const plans = { ...PLANS, cells: null, lossy: CELLS };
  assert.equal((await computing({ plans }).point({ ...PLACE, losses: {} })).verdict, "stable");
  assert.ok((await computing({ plans }).point(PLACE)).note);
});

test("an unknown point says so, with the reason if there is one", async () => {
  const plans = { ...PLANS, cells: null };
  assert.deepEqual(await computing({ plans }).point(PLACE), {
    start: {},
    numbers: [],
    verdict: "",
    stored: null,
    note: "No cell here.",
  });
  const refused = { error: "No.", hint: "" };
  await assert.rejects(computing({ plans: { ...plans, refused } }).point(PLACE), { message: "No." });
  assert.ok((await computing({ plans: { ...plans, refused }, stored: storing(null) }).point(PLACE)).note);
});
