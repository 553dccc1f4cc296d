/**
 * Evaluates JavaScript for Python (node_page.py): each input line is a JSON string with a function and its argument, and
 * each output line is its result. Addresses are relative to the page's address, the first argument.
 */

import { createInterface } from "node:readline";
import "./worker.mjs";

const fetching = globalThis.fetch;
const [, , address] = process.argv;
globalThis.window = globalThis;
globalThis.fetch = (where, ...more) => fetching(new URL(where, address), ...more);

/** JSON with NaN and infinity, as Python reads them. */
function written(value) {
  const marked = JSON.stringify(value, (_, each) => {
    const isPlain = typeof each !== "number" || (Number.isFinite(each) && !Object.is(each, -0));
    return isPlain ? each : `\u0001${Object.is(each, -0) ? "-0.0" : each}`;
  });
  return (marked ?? "null").replace(/"\\u0001([^"]+)"/g, "$1");
}

for await (const line of createInterface({ input: process.stdin })) {
  let answer;
  try {
    // a direct eval, so that imports work as in this module
    answer = { found: await eval(JSON.parse(line)) };
  } catch (problem) {
    answer = { problem: problem.stack ?? String(problem) };
  }
  process.stdout.write(`${written(answer)}\n`);
}
