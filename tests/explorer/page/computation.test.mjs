/** Questions to workers: their order, canceled ones, and the pieces of windows. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { Computation, pieces } from "eulerdisk/compute/computation";
import { Problem } from "eulerdisk/notice";

/** Workers that answer on demand, and the questions they got. */
class HeldWorker {
  static all = [];
  static asked = [];

  constructor() {
    HeldWorker.all.push(this);
  }

  postMessage(message) {
    if (message.what === "begin") queueMicrotask(() => this.onmessage({ data: { found: {} } }));
    else HeldWorker.asked.push({ ...message, worker: this });
  }
}

/** An empty WebAssembly module. */
const EMPTY = Uint8Array.of(0, 97, 115, 109, 1, 0, 0, 0);

/** A computation with this many workers, all ready. */
async function computing(count, content = Promise.resolve(EMPTY), worker = HeldWorker) {
  [HeldWorker.all, HeldWorker.asked] = [[], []];
  globalThis.Worker = worker;
  Object.defineProperty(navigator, "hardwareConcurrency", { value: count, configurable: true });
  const computation = new Computation(content);
  await computation.ready;
  return computation;
}

const settle = () => new Promise((resolve) => setImmediate(resolve));

/** Let the first worker with a question answer, and wait until it is free. */
async function answer(data = { found: "yes" }) {
  const { worker, ...message } = HeldWorker.asked.shift();
  worker.onmessage({ data });
  await settle();
  return message.asked;
}

test("there are as many workers as processors, at most six", async () => {
  assert.equal((await computing(3)).size, 3);
  assert.equal((await computing(64)).size, 6);
  assert.equal((await computing(0)).size, 2);
});

test("questions are answered in sequence, a lower order before a higher one", async () => {
  const computation = await computing(1);
  const found = ["a", "b", "c", "d"].map((each, i) =>
    computation.ask("piece", each, { order: [9, 9, 0, 9][i] }),
  );
  await settle();
  const order = [];
  for (let i = 0; i < 4; i += 1) order.push(await answer({ found: i }));
  assert.deepEqual(order, ["a", "c", "b", "d"]);
  assert.deepEqual(await Promise.all(found), [0, 2, 1, 3]);
});

test("all workers answer at the same time", async () => {
  const computation = await computing(2);
  for (const each of "abc") void computation.ask("piece", each);
  await settle();
  assert.equal(HeldWorker.asked.length, 2);
  assert.notEqual(HeldWorker.asked[0].worker, HeldWorker.asked[1].worker);
  await answer();
  assert.deepEqual(
    HeldWorker.asked.map(({ asked }) => asked),
    ["b", "c"],
  );
});

test("canceled questions are not computed", async () => {
  const computation = await computing(1);
  const controller = new AbortController();
  void computation.ask("piece", "a");
  const given = assert.rejects(computation.ask("piece", "b", { signal: controller.signal }), {
    name: "AbortError",
  });
  const after = computation.ask("piece", "c");
  controller.abort();
  await settle();
  assert.deepEqual([await answer(), await answer({ found: 3 })], ["a", "c"]);
  await given;
  assert.equal(await after, 3);
});

test("a worker's problem is reported, and it answers the next question", async () => {
  const computation = await computing(1);
  const isTold = (problem) => problem instanceof Problem && problem.message === "Error: no";
  const refused = assert.rejects(computation.ask("call", "a"), isTold);
  const next = computation.ask("call", "b");
  await settle();
  await answer({ problem: "Error: no" });
  await refused;
  await answer({ found: 1 });
  assert.equal(await next, 1);
});

test("if no module can be made, every question is refused with advice", async () => {
  const computation = await computing(1, Promise.resolve(Uint8Array.of(1)));
  for (let i = 0; i < 2; i += 1) {
    await assert.rejects(computation.ask("call", {}), {
      message: /cannot compute here/,
      hint: /newer browser/,
    });
  }
});

test("if the browser refuses workers, every question is refused with what to allow", async () => {
  class Thrown {
    constructor() {
      throw new DOMException("no workers here", "SecurityError");
    }
  }
  class NeverLoaded extends HeldWorker {
    postMessage() {
      // the error event of a script that failed to load has no message
      queueMicrotask(() => this.onerror({ preventDefault() {} }));
    }
  }
  for (const refused of [Thrown, NeverLoaded]) {
    const computation = await computing(1, Promise.resolve(EMPTY), refused);
    for (let i = 0; i < 2; i += 1) {
      await assert.rejects(computation.ask("call", {}), { message: /workers/, hint: /blob:/ });
    }
  }
});

test("pieces cover a window once, in whole rows or whole columns", () => {
  for (const byColumns of [false, true]) {
    for (const [width, height, most] of [
      [7, 5, Infinity],
      [1000, 700, 128],
      [1, 1, 1],
      [3, 100_000, Infinity],
    ]) {
      const parts = pieces({ width, height, byColumns, kind: "plain", most, workers: 2 });
      const [across, along] = byColumns ? ["x", "y"] : ["y", "x"];
      const end = { x: width, y: height };
      let next = 0;
      for (const part of parts) {
        assert.deepEqual(part[along], [0, end[along]]);
        assert.equal(part[across][0], next);
        assert.ok(part[across][1] > next && part[across][1] - next <= most);
        next = part[across][1];
      }
      assert.equal(next, end[across]);
    }
  }
});

test("pieces have at most as many cells as their kind allows, and each worker has two", () => {
  const window = { width: 1000, height: 1000, byColumns: false, most: Infinity, workers: 2 };
  const rows = (kind, more) => pieces({ ...window, kind, ...more })[0].y[1];
  assert.deepEqual(
    ["plain", "timed", "body", "path", "system"].map((kind) => rows(kind)),
    [33, 25, 2, 1, 1],
  );
  assert.equal(rows("plain", { width: 100, height: 100 }), 25);
});
