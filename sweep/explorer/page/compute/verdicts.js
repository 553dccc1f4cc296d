/**
 * Verdicts of cells, by the criterion of a plan.
 *
 * A part of the worker's script (worker.js), which finds it by its name.
 */

/** @import { Condition, ErrorRule, Plan, Term } from "eulerdisk/types" */

/** @typedef {Float64Array|Int32Array|Uint8Array} Values */
/** @typedef {Record<string, Values>} Columns */

// all scripts of a worker share their global names
(() => {
  /** Truth values of a condition, as bits: it may hold, and it certainly holds. */
  const [NEVER, PERHAPS, SURELY] = [0, 1, 3];

  /** Truth of a condition -> truth of its negation. */
  const OPPOSITE = Uint8Array.of(SURELY, PERHAPS, PERHAPS, NEVER);

  /**
   * @typedef {{low: Values, high: Values}} Ends least and largest possible values of cells; the same array if there is
   * no error
   */

  /**
   * Return the verdicts of cells by their endings and the criterion; 0 where errors leave them open.
   * @param {Plan} plan
   * @param {Columns} judged  the quantities in the criterion, and the errors that cells state
   * @param {Values} ending
   * @param {number} count
   */
  function verdicts({ criterion: { outcomes, condition, named, errors = {} } }, judged, ending, count) {
    /** @type {Record<string, Ends>} */
    const ends = {};
    for (const name of named) ends[name] = endsOf(name, errors[name], judged, ending, count);
    const holds = truths(condition, ends, count);
    const columns = named.map((name) => judged[name]);
    const [stability, table] = [new Uint8Array(count), Uint8Array.from(outcomes.flat())];
    for (let i = 0; i < count; i += 1) {
      const row = 3 * ending[i];
      let column = 1;
      if (holds[i] === SURELY) column = 0;
      else if (holds[i] === NEVER && columns.some((values) => values[i] !== values[i])) column = 2;
      const isOpen = holds[i] === PERHAPS && table[row] !== table[row + 1];
      stability[i] = isOpen ? 0 : table[row + column];
    }
    return stability;
  }

  /**
   * Return the least and largest possible values of a column.
   * @param {string} name
   * @param {ErrorRule|undefined} rule
   * @param {Columns} judged
   * @param {Values} ending
   * @param {number} count
   * @returns {Ends}
   */
  function endsOf(name, rule, judged, ending, count) {
    const values = judged[name];
    if (!rule) return { low: values, high: values };
    const { stated, times = 0, absolute = 0, relative = 0, unknown } = rule;
    const [low, high] = [new Float64Array(count), new Float64Array(count)];
    const own = judged[`${name}: error`];
    const errors = own ?? (stated ? judged[stated] : new Float64Array(count));
    const [share, least] = own ? [1, 0] : [times, absolute];
    for (let i = 0; i < count; i += 1) {
      const said = share * errors[i];
      // a missing error adds nothing
      const error = least + relative * Math.abs(values[i]) + (said > 0 ? said : 0);
      low[i] = values[i] - error;
      high[i] = values[i] + error;
    }
    if (unknown) {
      for (let i = 0; i < count; i += 1) {
        if (unknown.includes(ending[i])) [low[i], high[i]] = [-Infinity, Infinity];
      }
    }
    return { low, high };
  }

  /**
   * Return the truth of a condition in each cell; false for a missing value.
   * @param {Condition} condition
   * @param {Record<string, Ends>} columns
   * @param {number} count
   * @returns {Uint8Array}
   */
  function truths(condition, columns, count) {
    if (condition.not) return truths(condition.not, columns, count).map((truth) => OPPOSITE[truth]);
    if (condition.parts) {
      const parts = condition.parts.map((part) => truths(part, columns, count));
      return joined(parts, condition.word === "and", count);
    }
    const { terms = [], signs = [] } = condition;
    const ends = terms.map((term) => endsOfTerm(term, columns, count));
    return joined(
      signs.map((sign, i) => compared(sign, ends[i], ends[i + 1], count)),
      true,
      count,
    );
  }

  /**
   * @param {Uint8Array[]} parts
   * @param {boolean} all  whether all conditions must hold, or only one
   * @param {number} count
   */
  function joined([found, ...others], all, count) {
    for (const part of others) {
      for (let i = 0; i < count; i += 1) found[i] = all ? found[i] & part[i] : found[i] | part[i];
    }
    return found;
  }

  /**
   * @param {Term} term
   * @param {Record<string, Ends>} columns
   * @param {number} count
   * @returns {Ends}
   */
  function endsOfTerm({ value = 0, name, factor = 1, absolute }, columns, count) {
    if (!name) {
      const same = new Float64Array(count).fill(value);
      return { low: same, high: same };
    }
    if (factor === 1 && !absolute) return columns[name];
    const { low, high } = columns[name];
    const [least, largest] = [new Float64Array(count), new Float64Array(count)];
    for (let i = 0; i < count; i += 1) {
      let [a, b] = [low[i], high[i]];
      if (absolute) [a, b] = [Math.max(0, a, -b), Math.max(Math.abs(a), Math.abs(b))];
      least[i] = factor * (factor > 0 ? a : b);
      largest[i] = factor * (factor > 0 ? b : a);
    }
    return { low: least, high: largest };
  }

  /**
   * Return the truth of a comparison of two terms with errors; false for a missing value.
   * @param {string} sign
   * @param {Ends} one
   * @param {Ends} other
   * @param {number} count
   */
  function compared(sign, one, other, count) {
    if (sign.startsWith(">")) return compared(sign.replace(">", "<"), other, one, count);
    const found = new Uint8Array(count);
    const [{ low: a, high: b }, { low: c, high: d }] = [one, other];
    const [isLess, isEqual] = [sign.startsWith("<"), sign === "<="];
    for (let i = 0; i < count; i += 1) {
      if (isLess) {
        if (b[i] < c[i] || (isEqual && b[i] === c[i])) found[i] = SURELY;
        else if (a[i] < d[i] || (isEqual && a[i] === d[i])) found[i] = PERHAPS;
        continue;
      }
      const apart = b[i] < c[i] || d[i] < a[i];
      const same = a[i] === d[i] && b[i] === c[i];
      if (sign === "==" ? same : apart) found[i] = SURELY;
      // neither is true for a missing value
      else if (!apart && !same && a[i] <= b[i] && c[i] <= d[i]) found[i] = PERHAPS;
    }
    return found;
  }

  Object.assign(self, { verdicts });
})();
