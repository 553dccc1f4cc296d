/**
 * The paths of the contact points of cells: sweep/model/disk/path.py for the page.
 *
 * A part of the worker's script (worker.js), which finds the class by its name.
 */

/** @import { Block, KernelModule } from "eulerdisk/compute/kernels" */
/** @import { BodyPlan, Plan } from "eulerdisk/types" */

/** @typedef {Float64Array|Int32Array|Uint8Array} Values */
/** @typedef {Record<string, Values>} Columns */

// all scripts of a worker share their global names
(() => {
  /** Rows that the kernel writes, and classes (kernels/bodies/arrays.py). */
  const ROWS = ["heading_per_nutation", "path_drift", "ring_inner", "ring_outer", "ring_x", "ring_y"];
  const [ANNULAR_PATH, CLOSED_PATH] = [1, 3];

  /**
   * Largest number of nutations after which a path counts as closed, and how near to whole turns the heading then is.
   */
  const MOST_NUTATIONS = 12;
  const CLOSED = 1e-8;

  class Paths {
    #kernels;
    #memory;

    /** @param {KernelModule} kernels */
    constructor(kernels) {
      this.#kernels = kernels;
      this.#memory = "paths" in kernels.note.entries ? kernels.memoryOf("paths") : [];
    }

    /**
     * Return the columns of the paths of cells; empty if they are not requested.
     * @param {Plan|BodyPlan} plan
     * @param {Block} bodies  starts of the cells as bodies
     * @param {number} number  of the body
     * @param {string} [wanted]  the only column that is needed besides the verdict
     * @returns {Columns}
     */
    columns(plan, bodies, number, wanted) {
      const needed = wanted ? [wanted, ...plan.criterion.named] : plan.path;
      if (!needed.some((name) => plan.path.includes(name))) return {};
      const kernels = this.#kernels;
      const count = bodies.shape[1];
      const measures = kernels.array("float64", ROWS.length, count);
      const classes = kernels.array("int64", count);
      const { fall_tilt } = plan.settings;
      kernels.treat("paths", count, bodies, number, fall_tilt, measures, classes, ...this.#memory);
      const measured = kernels.rows(measures).map((row, i) => [ROWS[i], row.slice()]);
      const headings = kernels.rows(measures)[0];
      return { ...Object.fromEntries(measured), ...closing(headings, kernels.numbers(classes)) };
    }
  }

  /**
   * Find the number of nutations, each of which gains an angle, after which the heading is nearest to whole turns;
   * return it with the classes of the paths, some of which close.
   * @param {Float64Array} headings
   * @param {BigInt64Array} classes  from the kernel
   * @returns {Columns}
   */
  function closing(headings, classes) {
    const [closing_nutations, closing_turns] = [headings, headings].map(
      (each) => new Float64Array(each.length),
    );
    const closing_angle = new Float64Array(headings.length).fill(NaN);
    const path_class = Uint8Array.from(classes, Number);
    headings.forEach((gained, i) => {
      for (let nutations = 1; nutations <= MOST_NUTATIONS; nutations += 1) {
        const heading = nutations * gained;
        const turns = Math.round(heading / (2 * Math.PI));
        const angle = Math.abs(heading - 2 * Math.PI * turns);
        // false without a heading
        if (!(nutations === 1 ? angle >= 0 : angle < closing_angle[i])) continue;
        [closing_nutations[i], closing_turns[i], closing_angle[i]] = [nutations, turns, angle];
        if (angle > CLOSED * (1 + Math.abs(heading))) continue;
        if (path_class[i] === ANNULAR_PATH) path_class[i] = CLOSED_PATH;
        // after twice as many nutations it closes, too
        break;
      }
    });
    return { closing_nutations, closing_turns, closing_angle, path_class };
  }

  Object.assign(self, { Paths });
})();
