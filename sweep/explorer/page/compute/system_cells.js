/**
 * Columns of cells of a user's system, from the passes of its kernel: sweep/model/system/passes.py for the page.
 *
 * A part of the worker's script (worker.js), which finds it by its name.
 */

/** @import { Node, SystemCells, SystemMeasure, SystemMoment, SystemPlan } from "eulerdisk/types" */

/** @typedef {Record<string, any>} Columns  arrays of numbers, all of one length */

// all scripts of a worker share their global names
(() => {
  /** @type {Record<string, (...values: number[]) => number>} */
  const OPERATIONS = {
    "+": (one, other) => one + other,
    "-": (one, other) => one - other,
    "*": (one, other) => one * other,
    "/": (one, other) => one / other,
    "**": (one, other) => one ** other,
    neg: (one) => -one,
    sin: Math.sin,
    cos: Math.cos,
    tan: Math.tan,
    exp: Math.exp,
    log: Math.log,
    sqrt: Math.sqrt,
    tanh: Math.tanh,
    atan2: Math.atan2,
  };

  /** Operations whose terms are rounded separately. */
  const TERMS = ["+", "-", "*", "/", "neg"];

  /**
   * Return the value of an expression.
   * @param {Node} node
   * @param {Record<string, number>} values  of each name in the expression
   * @returns {number}
   */
  function valueOf(node, values) {
    if (typeof node === "number") return node;
    if (typeof node === "string") return values[node];
    const [name, ...parts] = node;
    return OPERATIONS[name](...parts.map((part) => valueOf(part, values)));
  }

  /**
   * Return the total magnitude of the terms of an expression.
   * @param {Node} node
   * @param {Record<string, number>} values
   * @returns {number}
   */
  function sizeOf(node, values) {
    if (!Array.isArray(node) || !TERMS.includes(node[0])) return Math.abs(valueOf(node, values));
    const [name, ...parts] = node;
    const [one, other] = parts.map((part) => sizeOf(part, values));
    return name === "neg" ? one : OPERATIONS[name === "-" ? "+" : name](one, other);
  }

  /** The passes of one cell. */
  class Passes {
    /** @type {SystemPlan} */
    #plan;
    /** @type {SystemCells} */
    #system;
    /** @type {Record<string, number>} */
    #start;
    /** @type {Columns} */
    #measured;
    /** @type {number} */
    #at;
    /** @type {Record<string, number>[]} states, time and start at the end of each pass */
    #ends;

    /**
     * @param {SystemPlan} plan
     * @param {Record<string, number>} start
     * @param {Columns} measured
     * @param {number} at  index of the cell
     */
    constructor(plan, start, measured, at) {
      this.#plan = plan;
      this.#system = plan.system;
      this.#start = start;
      this.#measured = measured;
      this.#at = at;
      const { passes, states, end_time } = this.#system;
      this.#ends = passes.map((pass) => ({
        ...start,
        ...Object.fromEntries(states.map((name) => [name, this.#of(pass, name)])),
        t: this.#of(pass, end_time),
      }));
    }

    /** @param {string} pass @param {string} what */
    #of(pass, what) {
      return this.#measured[`${pass}: ${what}`][this.#at];
    }

    /** @param {string} state */
    #size(state) {
      return this.#of(/** @type {string} */ (this.#system.passes.at(-1)), `largest ${state}`);
    }

    /** Return all columns of the cell. */
    columns() {
      const { labels, conserved, states, state_ends, end_time, end_time_stated } = this.#system;
      const ending = this.#ending();
      const known = !this.#plan.failed.includes(ending);
      /** @type {Record<string, number>} */
      const found = {};
      for (const { name, stated, passes, size, largest } of this.#values()) {
        const last = known ? passes[passes.length - 1] + 0 : NaN;
        found[name] = !known && name === end_time ? this.#followedUntil() : last;
        found[stated] = known ? this.#error(passes, size) + this.#system.rounding * largest : NaN;
      }
      for (const measure of known ? this.#system.measures : []) {
        if (measure.moment) this.#decide(measure, measure.moment, ending, found);
      }
      if (labels.length) {
        const errors = Object.fromEntries(states.map((name, i) => [name, found[state_ends[i].stated]]));
        found.label = this.#label(ending, { ...errors, t: found[end_time_stated] });
      }
      if (conserved.length) found.conserved_change = known ? this.#change() : NaN;
      return { ...found, ending };
    }

    /** Return the time up to which a pass that failed was followed, the later one of the last two. */
    #followedUntil() {
      const [before, last] = this.#system.passes.slice(-2);
      const pass = this.#plan.failed.includes(this.#of(last, "ending")) ? last : before;
      return Math.max(this.#of(pass, this.#system.end_time), 0);
    }

    #ending() {
      const { passes, states, same_time, same_place, different } = this.#system;
      const [one, other] = passes.slice(-2).map((pass) => this.#of(pass, "ending"));
      const { failed } = this.#plan;
      if (failed.includes(other)) return other;
      if (failed.includes(one)) return one;
      const [before, last] = this.#ends.slice(-2);
      const isSame =
        one === other &&
        Math.abs(before.t - last.t) <= same_time * this.#plan.kernel_settings[0] &&
        states.every((name) => Math.abs(before[name] - last[name]) <= same_place * this.#size(name));
      return isSame ? other : different;
    }

    /**
     * Return the error of the last pass.
     * @param {number[]} passes  the value from each pass
     * @param {number} size
     */
    #error(passes, size) {
      const { shares, of_states, least, few_steps, grown } = this.#system;
      const [, , tolerance] = this.#plan.kernel_settings;
      const steps = Math.max(this.#measured.steps[this.#at], 1);
      const rounding = (grown * Math.sqrt(steps)) / tolerance;
      let squares = ((least + few_steps / steps) * tolerance * size) ** 2;
      this.#differences().forEach((states, i) => {
        const weight = 1 / shares[i] + rounding * 100 ** (i + 1 - shares.length);
        const apart = Math.hypot(weight * (passes[i + 1] - passes[i]), weight * of_states * size * states);
        // an earlier pass may have no value
        squares += Number.isFinite(apart) ? apart ** 2 : 0;
      });
      return Math.sqrt(squares);
    }

    /** Return the largest relative difference of a state between each pass and the next; NaN where none is known. */
    #differences() {
      return this.#ends.slice(1).map((next, i) => {
        const known = this.#system.states
          .map((name) => Math.abs(next[name] - this.#ends[i][name]) / this.#size(name))
          .filter((each) => !Number.isNaN(each));
        return known.length ? Math.max(...known) : NaN;
      });
    }

    /** Return each value with its results from all passes, its size, and the largest sum of its steps. */
    #values() {
      const { measures, states, end_time, end_time_stated, of_times, state_ends } = this.#system;
      const last = this.#ends[this.#ends.length - 1];
      const duration = this.#plan.kernel_settings[0];
      const found = measures.map((measure) => {
        const { name, stated, kind, expressions } = measure;
        const passes = this.#passesOf(measure);
        const [told] = passes.slice(-1);
        const largest = ["mean", "integral", "value"].includes(kind)
          ? this.#terms(expressions) * (kind === "integral" ? last.t : 1)
          : Math.max(...expressions.map((each) => sizeOf(each, last)), told);
        const size = Number.isNaN(largest) ? Math.abs(told) : Math.max(Math.abs(told), largest);
        return { name, stated, passes, size, largest: kind === "time" ? duration : size };
      });
      const times = this.#ends.map((each) => each.t);
      found.push({
        name: end_time,
        stated: end_time_stated,
        passes: times,
        size: of_times * last.t,
        largest: duration,
      });
      states.forEach((state, i) => {
        const [size, passes] = [this.#size(state), this.#ends.map((each) => each[state])];
        found.push({ ...state_ends[i], passes, size, largest: size });
      });
      return found;
    }

    /**
     * Return the largest magnitude of the terms of expressions, for the largest values of all states.
     * @param {Node[]} expressions
     */
    #terms(expressions) {
      const sizes = this.#system.states.map((name) => [name, this.#size(name)]);
      const largest = { ...this.#ends[this.#ends.length - 1], ...Object.fromEntries(sizes) };
      return Math.max(...expressions.map((each) => sizeOf(each, largest)), 0);
    }

    /**
     * Write the stated error of a count, and of a measure that errors can change.
     * @param {SystemMeasure} measure
     * @param {SystemMoment} moment
     * @param {number} ending
     * @param {Record<string, number>} found
     */
    #decide({ name, stated, kind, expressions }, moment, ending, found) {
      const { passes, states, same_time, different, rounding, unknown } = this.#system;
      const [before, last] = passes
        .slice(-2)
        .map((pass) => (/** @type {string} */ what) => this.#of(pass, `${name} ${what}`));
      const shares = states.map((state) => {
        const size = this.#size(state);
        const values = this.#ends.map((each) => each[state]);
        return size > 0 ? this.#error(values, size) / size : 0;
      });
      const distance = last("level") - (moment.of_condition ? 0 : last("count"));
      const isNear = distance <= (Math.max(...shares) + rounding) * this.#terms(moment.expressions);
      const times = [before("time"), last("time")];
      const isApart =
        !(Math.abs(times[0] - times[1]) <= same_time * this.#plan.kernel_settings[0]) &&
        !times.every(Number.isNaN);
      const isDoubtful =
        (moment.kind === "last"
          ? before("count") !== last("count") || isNear || ending === different
          : isNear && ending !== different) ||
        (isApart && kind !== "count");
      if (kind === "count") found[stated] = 0;
      if (!isDoubtful) return;
      found[stated] = unknown;
      if (Number.isNaN(found[name])) {
        found[name] = valueOf(expressions[0] ?? "t", this.#ends[this.#ends.length - 1]);
      }
    }

    /**
     * Return the value of a measure from each pass.
     * @param {SystemMeasure} measure
     */
    #passesOf({ name, kind, expressions, moment }) {
      if (kind === "last") return this.#ends.map((each) => valueOf(expressions[0], each));
      if (moment) return this.#system.passes.map((pass) => this.#of(pass, `${name} ${kind}`));
      if (kind === "integral" || kind === "mean") {
        return this.#system.passes.map((pass, i) => {
          const [integral, end] = [this.#of(pass, `${name} integral`), this.#ends[i]];
          if (kind === "integral") return integral;
          return end.t > 0 ? integral / end.t : valueOf(expressions[0], end);
        });
      }
      const sign = kind === "max" ? 1 : -1;
      return this.#system.passes.map(
        (pass) => sign * Math.max(...expressions.map((_, row) => this.#of(pass, `${name} ${row}`))),
      );
    }

    /**
     * Return the first label that certainly applies; none if an earlier one may apply as well.
     * @param {number} ending
     * @param {Record<string, number>} errors of the states at the end, and of the time
     */
    #label(ending, errors) {
      if (ending === this.#system.different || this.#plan.failed.includes(ending)) return 0;
      for (const [i, all] of this.#system.labels.entries()) {
        const margins = all.map((each) => this.#margin(each, errors));
        if (margins.every(([value, off]) => value > off)) return i + 1;
        if (margins.every(([value, off]) => value > -off)) return 0;
      }
      return 0;
    }

    /**
     * Return the value of an expression at the end, and its error to first order.
     * @param {Node} node
     * @param {Record<string, number>} errors
     */
    #margin(node, errors) {
      const ends = this.#ends[this.#ends.length - 1];
      const value = valueOf(node, ends);
      let off = this.#system.rounding * sizeOf(node, ends);
      for (const [name, error] of Object.entries(errors)) {
        const changed = [error, -error].map(
          (each) => valueOf(node, { ...ends, [name]: ends[name] + each }) - value,
        );
        off += Math.max(...changed.map(Math.abs).filter((each) => !Number.isNaN(each)), 0);
      }
      return [value, off];
    }

    /** Return the largest change of a conserved quantity, relative to its largest term. */
    #change() {
      const begun = { ...this.#start, t: 0 };
      const ends = this.#ends[this.#ends.length - 1];
      const changes = this.#system.conserved.map((each) => {
        const [old, now] = [valueOf(each, begun), valueOf(each, ends)];
        return old === now ? 0 : Math.abs(now - old) / Math.max(sizeOf(each, begun), sizeOf(each, ends));
      });
      return Number.isNaN(ends.t) ? NaN : Math.max(...changes);
    }
  }

  /**
   * Return the columns of cells of a system, from the measures of its kernel.
   * @param {SystemPlan} plan
   * @param {Columns} starts
   * @param {Columns} measured
   * @param {number} count
   * @returns {Columns}
   */
  function systemColumns(plan, starts, measured, count) {
    const { coded, columns: names } = plan.system;
    /** @type {Columns} */
    const found = Object.fromEntries(
      names.map((name) => [name, coded.includes(name) ? new Uint8Array(count) : new Float64Array(count)]),
    );
    for (let i = 0; i < count; i += 1) {
      const start = Object.fromEntries(plan.parameters.map((name) => [name, starts[name][i]]));
      const cell = new Passes(plan, start, measured, i).columns();
      for (const name of names) found[name][i] = cell[/** @type {keyof typeof cell} */ (name)];
    }
    return { ...found, steps: measured.steps, unproved: measured.unproved };
  }

  Object.assign(self, { systemColumns });
})();
