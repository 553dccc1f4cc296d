/**
 * Verdicts of cells, by the criterion of a plan.
 *
 * A part of the worker's script (worker.js), which finds it under its name.
 */

/** @import { Condition, Plan, Term } from "eulerdisk/types" */

/** @typedef {Float64Array|Int32Array|Uint8Array} Values */
/** @typedef {Record<string, Values>} Columns */

// all scripts of a worker share their global names
(() => {
  /**
   * Verdicts of cells by their endings and the criterion.
   * @param {Plan} plan
   * @param {Columns} judged  what the criterion judges by
   * @param {Values} ending
   * @param {number} count
   */
  function verdicts({ criterion: { outcomes, condition, named } }, judged, ending, count) {
    const holds = holding(condition, judged);
    const columns = named.map((name) => judged[name]);
    const stability = new Uint8Array(count);
    for (let i = 0; i < count; i += 1) {
      const [isTrue, isFalse, isMissing] = outcomes[ending[i]];
      stability[i] = isFalse;
      if (holds(i)) stability[i] = isTrue;
      else if (isFalse !== isMissing && columns.some((column) => Number.isNaN(column[i]))) {
        stability[i] = isMissing;
      }
    }
    return stability;
  }

  /**
   * Where a condition holds, as a function of the number of a cell; false of a missing value.
   * @param {Condition} condition
   * @param {Columns} columns
   * @returns {(i: number) => boolean}
   */
  function holding(condition, columns) {
    if (condition.not) {
      const part = holding(condition.not, columns);
      return (i) => !part(i);
    }
    if (condition.parts) {
      const parts = condition.parts.map((part) => holding(part, columns));
      return condition.word === "and"
        ? (i) => parts.every((part) => part(i))
        : (i) => parts.some((part) => part(i));
    }
    const { terms = [], signs = [] } = condition;
    const values = terms.map((term) => valueOf(term, columns));
    const pairs = signs.map((sign, i) => {
      const [agrees, one, other] = [SIGNS[sign], values[i], values[i + 1]];
      return (/** @type {number} */ cell) => agrees(one(cell), other(cell));
    });
    return pairs.length === 1 ? pairs[0] : (i) => pairs.every((pair) => pair(i));
  }

  /**
   * @param {Term} term
   * @param {Columns} columns
   * @returns {(i: number) => number}
   */
  function valueOf({ value = 0, name, factor = 1, absolute }, columns) {
    if (!name) return () => value;
    const column = columns[name];
    if (factor === 1) return absolute ? (i) => Math.abs(column[i]) : (i) => column[i];
    return absolute ? (i) => factor * Math.abs(column[i]) : (i) => factor * column[i];
  }

  /** @type {Record<string, (one: number, other: number) => boolean>} all false of a missing value */
  const SIGNS = {
    "<": (one, other) => one < other,
    "<=": (one, other) => one <= other,
    ">": (one, other) => one > other,
    ">=": (one, other) => one >= other,
    "==": (one, other) => one === other,
    "!=": (one, other) => one < other || one > other,
  };

  Object.assign(self, { verdicts });
})();
