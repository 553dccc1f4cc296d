/** Verdicts of cells by conditions of all kinds, with missing values. */

import assert from "node:assert/strict";
import { test } from "node:test";
import { scriptsOf } from "./worker_scripts.mjs";

const { verdicts } = scriptsOf("verdicts");

/** Verdicts: 1 if a condition is true, 2 if it is false, 0 if a named column is missing. */
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

test("every sign compares, and is false for a missing value", () => {
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

test("a chain of signs holds if each of them does", () => {
  assert.deepEqual(verdictsOf(terms(1, "<", A, "<=", 3), { a: [1, 2, 3, 4] }), [2, 1, 1, 2]);
});

test("a column can have its magnitude and a factor", () => {
  const a = [-3, 1, 3];
  assert.deepEqual(verdictsOf(terms({ ...A, absolute: true }, ">", 2), { a }), [1, 2, 1]);
  assert.deepEqual(verdictsOf(terms({ ...A, factor: -2 }, ">", 2), { a }), [1, 2, 2]);
  assert.deepEqual(verdictsOf(terms({ ...A, factor: 2, absolute: true }, "<=", 2), { a }), [2, 1, 2]);
});

test("conditions are joined by words and negated", () => {
  const [low, high] = [terms(A, ">", 1), terms(A, "<", 3)];
  const a = [0, 2, 4];
  assert.deepEqual(verdictsOf({ word: "and", parts: [low, high] }, { a }), [2, 1, 2]);
  assert.deepEqual(verdictsOf({ word: "or", parts: [low, terms(A, "<", 1)] }, { a }), [1, 1, 1]);
  assert.deepEqual(verdictsOf({ not: { word: "or", parts: [low, high] } }, { a: [0, 2, NaN] }), [2, 2, 1]);
});

test("a missing value leaves a cell undecided only if it matters", () => {
  const columns = { a: [5, NaN, 5], b: [NaN, 0, 0] };
  const either = { word: "or", parts: [terms(A, ">", 1), terms({ name: "b" }, ">", 1)] };
  assert.deepEqual(verdictsOf(either, columns), [1, 0, 1]);
  // columns that the criterion does not name are ignored
  assert.deepEqual(verdictsOf(terms(A, ">", 9), columns, { named: ["a"] }), [2, 0, 2]);
});

test("each ending has its own outcomes", () => {
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

test("a value within its error of its limit leaves a cell undecided", () => {
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
  // a condition that is true in any case decides, and an error may be relative to the value
  const wide = terms({ ...A, absolute: true, factor: -1 }, ">", -1.5);
  assert.deepEqual(verdictsOf(wide, { a: [-1, -1.4, 1.6] }, { errors: { a: { relative: 0.1 } } }), [1, 0, 0]);
  const either = { word: "or", parts: [terms(A, ">", 2), terms({ name: "b" }, ">", 0)] };
  assert.deepEqual(verdictsOf(either, { a: [2, 2], b: [1, -1] }, { errors: { a: { absolute: 1 } } }), [1, 0]);
});

test("an unknown ending is no flag, but decides if both outcomes are the same", () => {
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
