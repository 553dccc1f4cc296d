/** Requests for windows: coarse at once, fine when at rest, and with fewer cells if they are slow. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { FINE, Latest, pixels, Refresh } from "eulerdisk/refresh";

globalThis.window = globalThis;

const WANTED = { view: { base: "b" }, quantity: "q", stored: true, width: 1600, height: 1200 };
const settle = () => new Promise((resolve) => setImmediate(resolve));

test("pixels keep the proportions of the screen, and each side has at least one", () => {
  assert.deepEqual(pixels({ width: 1600, height: 1200 }, 1e9), [1600, 1200]);
  assert.deepEqual(pixels({ width: 1600, height: 1200 }, 256 * 192), [256, 192]);
  assert.deepEqual(pixels({ width: 10_000, height: 10 }, 10), [100, 1]);
});

test("of many requests the first and the last run, one at a time", async () => {
  const run = [];
  const ends = [];
  const latest = new Latest((each) => new Promise((resolve) => (run.push(each), ends.push(resolve))));
  for (const each of "abcd") latest.ask(each);
  assert.deepEqual([run, latest.busy], [["a"], true]);
  ends.shift()();
  await settle();
  assert.deepEqual(run, ["a", "d"]);
  latest.ask("e");
  latest.forget();
  ends.shift()();
  await settle();
  assert.deepEqual([run, latest.busy], [["a", "d"], false]);
});

/** A refresh with a source that answers at once, and its requests and deliveries. */
function refreshing({ cost = 0, milliseconds, window = null } = {}) {
  const [asked, delivered, failed] = [[], [], []];
  const answer = (request) => ({ ...request, head: { note: "" }, stored: null, milliseconds });
  const source = { window: window ?? (async (request) => (asked.push(request), answer(request))) };
  const refresh = new Refresh(
    source,
    (_, given, lane) => delivered.push([lane, given.width * given.height, given.head.note]),
    (problem, lane) => failed.push([problem.message, lane]),
    () => cost,
  );
  return { refresh, asked, delivered, failed };
}

test("a coarse picture comes at once, and the fine one after 90 ms without a change", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { refresh, delivered } = refreshing();
  refresh.ask(WANTED);
  await settle();
  assert.deepEqual(delivered, [["coarse", 256 * 192, ""]]);
  context.mock.timers.tick(89);
  refresh.ask(WANTED);
  await settle();
  context.mock.timers.tick(89);
  await settle();
  assert.equal(delivered.length, 2);
  context.mock.timers.tick(1);
  await settle();
  assert.deepEqual(delivered[2], ["fine", 1600 * 1200, ""]);
});

test("a screen of more than 2.5 million pixels is limited to that number", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { refresh, delivered } = refreshing();
  refresh.ask({ ...WANTED, width: 4000, height: 3000 });
  context.mock.timers.tick(90);
  await settle();
  const [, [lane, count]] = delivered;
  assert.equal(lane, "fine");
  assert.ok(count <= FINE && count > 0.99 * FINE);
});

test("for slow cells a coarse picture takes 0.3 s, and finer ones precede the fine one", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { refresh, delivered } = refreshing({ cost: 0.1 });
  refresh.ask(WANTED);
  context.mock.timers.tick(90);
  await settle();
  assert.deepEqual(
    delivered.map(([lane]) => lane),
    ["coarse", "coarse", "coarse", "fine"],
  );
  const counts = delivered.map(([, count]) => count);
  [3000, 18_000, 108_000, 300_000].forEach((each, i) => assert.ok(Math.abs(counts[i] / each - 1) < 0.03));
  assert.deepEqual(
    delivered.map(([, , note]) => Boolean(note)),
    [false, false, false, true],
  );
});

test("stored cells cost nothing: their fine picture comes at once in full resolution", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const asked = [];
  const window = async (request) => {
    asked.push(request.width * request.height);
    const stored = new Uint8Array(request.width * request.height).fill(1);
    return { ...request, head: { note: "" }, stored, milliseconds: 1 };
  };
  const { refresh, delivered } = refreshing({ cost: 5, window });
  refresh.ask(WANTED);
  await settle();
  context.mock.timers.tick(90);
  await settle();
  assert.deepEqual([asked.length, asked.at(-1)], [2, 1600 * 1200]);
  assert.deepEqual(delivered.at(-1), ["fine", 1600 * 1200, ""]);
});

test("the time of a window sets the number of cells of the next one", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const { refresh, asked } = refreshing({ cost: 0.1, milliseconds: 3 });
  refresh.ask(WANTED);
  await settle();
  const first = asked[0].width * asked[0].height;
  refresh.ask(WANTED);
  await settle();
  const second = asked[1].width * asked[1].height;
  assert.ok(Math.abs(second / Math.min(256 * 192, (300 / 3) * first) - 1) < 0.03);
});

test("neither a canceled picture nor its problem is delivered", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const waiting = [];
  const window = (request, signal) =>
    new Promise((resolve, reject) => waiting.push({ request, signal, resolve, reject }));
  const { refresh, delivered, failed } = refreshing({ window });
  refresh.ask(WANTED);
  context.mock.timers.tick(90);
  assert.equal(waiting.length, 2);
  const other = { ...WANTED, quantity: "r" };
  refresh.ask(other);
  assert.ok(waiting[1].signal.aborted);
  waiting[1].resolve({ ...waiting[1].request, head: {}, stored: null });
  waiting[0].reject(new Error("old"));
  await settle();
  assert.deepEqual([delivered, failed], [[], []]);
  assert.equal(waiting[2].request.quantity, "r");
  waiting[2].reject(new Error("new"));
  await settle();
  assert.deepEqual(failed, [["new", "coarse"]]);
});
