/** Answers of a server, and the messages if it does not answer. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { mayPass, Problem, wordsOfProblem } from "eulerdisk/notice";
import { Reach, unpacked } from "eulerdisk/server_source";

/** A binary answer in the server's format: a length, JSON, and the arrays in sequence. */
function answerOf(arrays, text = "") {
  const list = arrays.map(([name, type, array]) => ({ name, type, count: array.length }));
  const head = Buffer.from(JSON.stringify({ arrays: list, text }));
  const length = Buffer.alloc(4);
  length.writeUInt32LE(head.length);
  const bytes = Buffer.concat([length, head, ...arrays.map(([, , array]) => Buffer.from(array.buffer))]);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
}

test("arrays of every type are unpacked at any offset", () => {
  for (let more = 0; more < 8; more += 1) {
    const given = [
      ["verdict", "u1", Uint8Array.of(1, 2, 255)],
      ["value", "f8", Float64Array.of(1 / 3, -0, NaN)],
      ["single", "f4", Float32Array.of(0.1)],
      ["code", "i4", Int32Array.of(-7)],
      ["none", "f8", new Float64Array(0)],
    ];
    const { head, arrays } = unpacked(answerOf(given, "\u00e9".repeat(more)));
    assert.equal(head.text.length, more);
    for (const [name, , array] of given) assert.deepEqual(arrays[name], array);
  }
});

test("a missing server is reported once and asked until it answers", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const settle = () => new Promise((resolve) => setImmediate(resolve));
  const told = [];
  const reach = new Reach();
  reach.onLost = (problem) => told.push(problem.message);
  reach.onBack = () => told.push("back");
  const lost = () =>
    assert.rejects(reach.of(Promise.reject(new TypeError("network"))), { unreachable: true });
  await lost();
  await lost();
  assert.equal(told.length, 1);
  let answer = () => Promise.reject(new TypeError("network"));
  globalThis.fetch = () => answer();
  for (const next of [answer, async () => ({ ok: false, status: 500 }), async () => ({ ok: true })]) {
    assert.equal(told.length, 1);
    answer = next;
    context.mock.timers.tick(2000);
    await settle();
  }
  assert.deepEqual(told.slice(1), ["back"]);
  context.mock.timers.tick(10_000);
  await settle();
  assert.equal(told.length, 2);
});

test("another server at the same address is reported as such", async (context) => {
  context.mock.timers.enable({ apis: ["setTimeout"] });
  const told = [];
  const reach = new Reach();
  reach.onLost = ({ message }) => told.push(message);
  globalThis.fetch = async () => ({ ok: false, status: 403 });
  await assert.rejects(reach.of(Promise.reject(new TypeError("network"))));
  context.mock.timers.tick(2000);
  await new Promise((resolve) => setImmediate(resolve));
  assert.match(told[1], /restarted/);
});

test("a request that the page canceled, and errors outside the network, are not a lost server", async () => {
  const reach = new Reach();
  reach.onLost = () => assert.fail();
  assert.equal(await reach.of(Promise.resolve(3)), 3);
  await assert.rejects(reach.of(Promise.reject(new RangeError("x"))), RangeError);
  await assert.rejects(reach.of(Promise.reject(new TypeError("y")), AbortSignal.abort()), TypeError);
});

test("only server errors may be temporary, and a problem is followed by its hint", () => {
  const may = [0, 400, 403, 499, 500, 503].map((status) => mayPass({ status }));
  assert.deepEqual(may, [false, false, false, false, true, true]);
  assert.equal(mayPass({}), false);
  assert.equal(wordsOfProblem(new Problem("No.", { hint: "Do." })), "No. Do.");
  assert.equal(wordsOfProblem(new Problem("No.")), "No.");
});
