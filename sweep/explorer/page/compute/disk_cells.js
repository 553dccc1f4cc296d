/**
 * Columns of cells of the disk, with and without losses, and of other bodies, from the measures of their kernels.
 *
 * A part of the worker's script (worker.js), which finds it by its name.
 */

/** @import { BodyPlan, ErrorRule, Plan } from "eulerdisk/types" */

/** @typedef {Float64Array|Int32Array|Uint8Array} Values */
/** @typedef {Record<string, Values>} Columns */

// all scripts of a worker share their global names
(() => {
  /** @type {{verdicts: (plan: Plan, judged: Columns, ending: Values, count: number) => Uint8Array}} */
  const { verdicts } = /** @type {any} */ (self);

  /** Quantities in a criterion, by their names there (sweep/request/criterion_kinds.py). */
  const [REACH, SCALE] = ["the reach", "the scale"];

  /** Largest share of a time that the errors of a small swing may reach (sweep/model/cells.py). */
  const MOST_OF_A_TIME = 0.5;

  /** Number of the ball; spheroids have higher numbers (kernels/bodies/shapes.py). */
  const BALL = 4;

  /**
   * Return the columns with those that follow from them: the start of a cell, how far it went, and the verdict.
   * @param {Plan} plan
   * @param {Columns} starts
   * @param {Columns} measured
   * @param {number} count
   * @param {string} [wanted]  the only column that is needed besides the verdict
   * @returns {Columns}
   */
  function diskColumns(plan, starts, measured, count, wanted) {
    const needed = wanted && [wanted, ...plan.criterion.named];
    const isNeeded = (/** @type {string[]} */ ...names) =>
      !needed || names.some((name) => needed.includes(name));
    for (const name of plan.singles) measured[name] &&= measured[name].map(Math.fround);
    const found = { ...starts, ...measured };
    if (isNeeded("peak_tilt")) found.peak_tilt = peaks(measured, count);
    if (isNeeded(REACH, "amplification")) found[REACH] = reaches(plan, found, count);
    if (isNeeded(SCALE, "amplification")) found[SCALE] = scales(plan, found, count);
    if (isNeeded("amplification")) {
      found.amplification = Float64Array.from(found[REACH], (each, i) => each / found[SCALE][i]);
    }
    for (const [name, rule] of Object.entries(plan.criterion.errors ?? {})) {
      if (rule.by) found[`${name}: error`] = errorsOf(name, rule, plan, found, count);
    }
    found.stability = verdicts(plan, found, measured.ending, count);
    if (measured.wells && isNeeded("regime")) found.regime = regimes(plan, measured, count);
    if (plan.losses.length && isNeeded("largest_loss")) {
      found.largest_loss = largest(
        plan.losses.map((name) => measured[name]),
        count,
      );
    }
    return found;
  }

  /**
   * Return the largest tilts to either side.
   * @param {Columns} measured
   * @param {number} count
   */
  function peaks({ tilt_min: least, tilt_max: greatest }, count) {
    const found = new Float64Array(count);
    for (let i = 0; i < count; i += 1) found[i] = Math.max(Math.abs(least[i]), Math.abs(greatest[i]));
    return found;
  }

  /**
   * Return the tilts of the motions that starts perturb, as in sweep/model/bodies/shape.py.
   * @param {Plan|BodyPlan} plan
   * @param {Columns} starts
   * @returns {(i: number) => number}
   */
  function undisturbed(plan, { tilt, offset }) {
    if (plan.from_start) return (i) => tilt[i];
    const number = "body" in plan ? plan.body.number : -1;
    if (number < BALL) return () => 0;
    return (i) => {
      const isOnEnd = number === BALL || Math.abs(tilt[i]) > Math.PI / 4 || offset[i] !== 0;
      return isOnEnd ? (tilt[i] < 0 ? -Math.PI : Math.PI) / 2 : 0;
    };
  }

  /**
   * Return how far the tilts went from the steady one.
   * @param {Plan} plan
   * @param {Columns} cells
   * @param {number} count
   */
  function reaches(plan, cells, count) {
    const { tilt_min: least, tilt_max: greatest } = cells;
    const found = new Float64Array(count);
    const steadyOf = undisturbed(plan, cells);
    for (let i = 0; i < count; i += 1) {
      const steady = steadyOf(i);
      found[i] = Math.max(Math.abs(greatest[i] - steady), Math.abs(least[i] - steady));
    }
    return found;
  }

  /**
   * Return the errors of a column that follow from the errors of the extremes.
   * @param {string} name
   * @param {ErrorRule} rule
   * @param {Plan} plan
   * @param {Columns} cells
   * @param {number} count
   */
  function errorsOf(name, rule, plan, cells, count) {
    const { by, stated = "", times = 0, rounding = 0, absolute = 0, relative = 0 } = rule;
    const found = new Float64Array(count);
    const [values, reach] = [cells[name], cells[REACH] ?? reaches(plan, cells, count)];
    const scale = by === "extreme" ? reach : (cells[SCALE] ?? scales(plan, cells, count));
    const { tilt, tilt_min: least, tilt_max: greatest } = cells;
    const steadyOf = undisturbed(plan, cells);
    for (let i = 0; i < count; i += 1) {
      const size = Number.isFinite(values[i]) ? Math.abs(values[i]) : 0;
      // a motion that goes no further than its start has an exact extreme
      const isStart = reach[i] <= Math.abs(tilt[i] - steadyOf(i));
      const error = isStart ? 0 : times * cells[stated][i] + rounding || 0;
      found[i] = absolute + relative * size;
      if (by === "extreme") found[i] += error;
      else if (by === "amplified") found[i] += scale[i] > 0 ? error / scale[i] : 0;
      else {
        const swing = Math.min(1, Math.min(scale[i] || 0, greatest[i] - least[i]));
        found[i] += swing > 0 ? size * Math.min(MOST_OF_A_TIME, error / swing) : 0;
      }
    }
    return found;
  }

  /**
   * Return the sizes of the perturbations; NaN where nothing is perturbed, and thus nothing amplified.
   * @param {Plan} plan
   * @param {Columns} cells
   * @param {number} count
   */
  function scales(plan, cells, count) {
    const { tilt, tilt_rate, alpha, transverse_moment, radius, gravity } = cells;
    const found = new Float64Array(count);
    const steadyOf = undisturbed(plan, cells);
    for (let i = 0; i < count; i += 1) {
      // twice (1 + transverse moment)
      const inertia = alpha ? 2 + alpha[i] : 2 + 2 * transverse_moment[i];
      const kick = tilt_rate[i] / Math.sqrt((2 * gravity[i]) / (inertia * radius[i]));
      const size = length(tilt[i] - steadyOf(i), kick);
      found[i] = size > 0 ? size : NaN;
    }
    return found;
  }

  /**
   * Return the length of a vector without underflow of small squares.
   * @param {number} x
   * @param {number} y
   */
  function length(x, y) {
    const [a, b] = [Math.abs(x), Math.abs(y)];
    const size = a > b ? a : b;
    return size > 0 && size < Infinity
      ? size * Math.sqrt((a / size) * (a / size) + (b / size) * (b / size))
      : a + b;
  }

  /**
   * Return the kinds of motions, as in sweep/explorer/quantities.py.
   * @param {Plan} plan
   * @param {Columns} measured
   * @param {number} count
   */
  function regimes(plan, { ending, wells, tilt_min: least, tilt_max: greatest }, count) {
    const found = new Uint8Array(count);
    for (let i = 0; i < count; i += 1) {
      const crosses = least[i] < 0 && greatest[i] > 0 ? 1 : 0;
      found[i] = wells[i] > 0 && !plan.failed.includes(ending[i]) ? 2 * (wells[i] - 1) + crosses : 5;
      if (plan.lost.includes(ending[i])) found[i] = 4;
    }
    return found;
  }

  /**
   * Return the number of the loss that took most, counted from 1; 0 where nothing was lost.
   * @param {Values[]} losses
   * @param {number} count
   */
  function largest(losses, count) {
    return Uint8Array.from({ length: count }, (_, i) => {
      const lost = [0, ...losses.map((each) => each[i] || 0)];
      return lost.indexOf(Math.max(...lost));
    });
  }

  Object.assign(self, { diskColumns });
})();
