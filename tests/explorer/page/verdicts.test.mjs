/** Verdicts of cells by conditions of all kinds, with values that are missing. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { scriptsOf } from "./worker_scripts.mjs";

const { verdicts } = scriptsOf("verdicts");

/** Verdicts where a condition is true (1), false (2), and where a named column is missing (0). */
function verdictsOf(
  condition,
  columns,
  { named = Object.keys(columns), ending, outcomes = [[1, 2, 0]], errors } = {},
) {
  const count = Object.values(columns)[0].length;
  const codes = ending ?? new Array(count).fill(0);
  return Array.from(verdicts({ criterion: { outcomes, condition, named, errors } }, columns, codes, count));
}

const terms = (...parts) => ({
  terms: parts
    .filter((_, i) => i % 2 === 0)
    .map((each) => (typeof each === "number" ? { value: each } : each)),
  signs: parts.filter((_, i) => i % 2 === 1),
});
const A = { name: "a" };

test("every sign compares, and is false of a missing value", () => {
  const a = [1, 2, 3, NaN];
  const expected = {
    "<": [1, 2, 2, 0],
    "<=": [1, 1, 2, 0],
    ">": [2, 2, 1, 0],
    ">=": [2, 1, 1, 0],
    "==": [2, 1, 2, 0],
    "!=": [1, 2, 1, 0],
  };
  for (const [sign, codes] of Object.entries(expected)) {
    assert.deepEqual(verdictsOf(terms(A, sign, 2), { a }), codes, sign);
  }
});

test("a chain of signs holds where each of them does", () => {
  assert.deepEqual(verdictsOf(terms(1, "<", A, "<=", 3), { a: [1, 2, 3, 4] }), [2, 1, 1, 2]);
});

test("a column has its magnitude and its factor", () => {
  const a = [-3, 1, 3];
  assert.deepEqual(verdictsOf(terms({ ...A, absolute: true }, ">", 2), { a }), [1, 2, 1]);
  assert.deepEqual(verdictsOf(terms({ ...A, factor: -2 }, ">", 2), { a }), [1, 2, 2]);
  assert.deepEqual(verdictsOf(terms({ ...A, factor: 2, absolute: true }, "<=", 2), { a }), [2, 1, 2]);
});

test("conditions are joined by words, and turned round", () => {
  const [low, high] = [terms(A, ">", 1), terms(A, "<", 3)];
  const a = [0, 2, 4];
  assert.deepEqual(verdictsOf({ word: "and", parts: [low, high] }, { a }), [2, 1, 2]);
  assert.deepEqual(verdictsOf({ word: "or", parts: [low, terms(A, "<", 1)] }, { a }), [1, 1, 1]);
  assert.deepEqual(verdictsOf({ not: { word: "or", parts: [low, high] } }, { a: [0, 2, NaN] }), [2, 2, 1]);
});

test("a missing value leaves a cell undecided only where it was not decided without it", () => {
  const columns = { a: [5, NaN, 5], b: [NaN, 0, 0] };
  const either = { word: "or", parts: [terms(A, ">", 1), terms({ name: "b" }, ">", 1)] };
  assert.deepEqual(verdictsOf(either, columns), [1, 0, 1]);
  // what a criterion does not name is not asked
  assert.deepEqual(verdictsOf(terms(A, ">", 9), columns, { named: ["a"] }), [2, 0, 2]);
});

test("each ending has outcomes of its own", () => {
  const outcomes = [
    [1, 2, 0],
    [2, 2, 2],
    [1, 1, 1],
    [0, 0, 0],
  ];
  const a = [0, 0, 0, 0, NaN];
  const found = verdictsOf(terms(A, ">", 1), { a }, { ending: [0, 1, 2, 3, 1], outcomes });
  assert.deepEqual(found, [2, 2, 1, 0, 2]);
});

test("a value within its error of what it is compared with leaves a cell undecided", () => {
  const columns = { a: [1, 1.95, 2, 2.05, 3, NaN], off: [0.03, 0.03, 0.03, 0.03, NaN, 0.03] };
  const errors = { a: { stated: "off", times: 2 } };
  const given = { named: ["a"], errors };
  const expected = {
    "<": [1, 0, 0, 0, 2, 0],
    "<=": [1, 0, 0, 0, 2, 0],
    ">": [2, 0, 0, 0, 1, 0],
    ">=": [2, 0, 0, 0, 1, 0],
    "==": [2, 0, 0, 0, 2, 0],
    "!=": [1, 0, 0, 0, 1, 0],
  };
  for (const [sign, codes] of Object.entries(expected)) {
    assert.deepEqual(verdictsOf(terms(A, sign, 2), columns, given), codes, sign);
  }
  // what holds in any case decides, and an error may be a share of the value
  const wide = terms({ ...A, absolute: true, factor: -1 }, ">", -1.5);
  assert.deepEqual(verdictsOf(wide, { a: [-1, -1.4, 1.6] }, { errors: { a: { relative: 0.1 } } }), [1, 0, 0]);
  const either = { word: "or", parts: [terms(A, ">", 2), terms({ name: "b" }, ">", 0)] };
  assert.deepEqual(verdictsOf(either, { a: [2, 2], b: [1, -1] }, { errors: { a: { absolute: 1 } } }), [1, 0]);
});

test("an ending that nobody knows is no flag, but decides where both outcomes are one", () => {
  const [isOne, code] = [terms(A, "==", 1), [0, 1, 1]];
  const errors = { a: { unknown: [1] } };
  const outcomes = [
    [1, 2, 0],
    [1, 2, 0],
  ];
  assert.deepEqual(verdictsOf(isOne, { a: [1, 1, 2] }, { ending: code, errors, outcomes }), [1, 0, 0]);
  assert.deepEqual(
    verdictsOf(
      { not: isOne },
      { a: [1, 1, 2] },
      { ending: code, errors, outcomes: [outcomes[0], [2, 2, 2]] },
    ),
    [2, 2, 2],
  );
});
