/** Everything that the page computes itself, for any origin of the plans: windows, points and motions. */

import { cellAt, computedWindow, isSlow, toldCell } from "eulerdisk/compute/cells";
import { computedMotion } from "eulerdisk/compute/motion";
import { Problem } from "eulerdisk/notice";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { About, MotionAnswer, MotionRequest, Place, Plan, Plans, PointAnswer, View, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/** Text for a place where nothing is stored and nothing can be computed. */
const NO_CELL = "No cell here.";

/** Code of a pixel with neither a stored nor a computed cell, and of a quantity without a value. */
const NOTHING = 2;
const NO_CODE = 255;

/**
 * The source of the cells of a file.
 * @typedef {object} Stored
 * @property {(request: WindowRequest, signal?: AbortSignal) => Promise<WindowAnswer|null>} window  null if a view shows
 * cells other than the stored ones
 * @property {(place: Place, signal?: AbortSignal) => Promise<PointAnswer|null>} point
 */

export class Computing {
  #computation;
  #about;
  #plansOf;
  #stored;
  #program;

  /**
   * @param {Computation} computation
   * @param {() => Promise<About>} about
   * @param {(view: View, signal?: AbortSignal) => Promise<Plans>} plansOf
   * @param {Stored|null} stored
   * @param {((request: WindowRequest, signal?: AbortSignal) => Promise<WindowAnswer>)|null} program  computes windows
   * faster than the page, if available
   */
  constructor(computation, about, plansOf, stored, program = null) {
    this.#computation = computation;
    this.#about = about;
    this.#plansOf = plansOf;
    this.#stored = stored;
    this.#program = program;
  }

  /**
   * Return a window: stored cells where they are wanted and available, and computed cells elsewhere.
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<WindowAnswer>}
   */
  async window(request, signal) {
    const [stored, plans] = await Promise.all([
      request.stored ? (this.#stored?.window(request, signal) ?? null) : null,
      this.#plansOf(request.view, signal),
    ]);
    const { cells } = plans;
    const isKnown = cells !== null && cells.shown.includes(request.quantity);
    if (stored && (!isKnown || !stored.stored?.includes(NOTHING))) return stored;
    if (isKnown) {
      const computed = await this.#computed(cells, request, signal);
      return stored ? joined(stored, computed) : computed;
    }
    if (plans.refused) throw new Problem(plans.refused.error, { hint: plans.refused.hint, status: 400 });
    return nothing(await this.#about(), request);
  }

  /**
   * Return a computed window: from the program where it is faster and answers, otherwise from the page.
   * @param {Plan} cells
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   */
  async #computed(cells, request, signal) {
    if (this.#program && isSlow(cells)) {
      try {
        return await this.#program(request, signal);
      } catch (problem) {
        if (!(problem instanceof Problem && problem.unreachable)) throw problem;
      }
    }
    return computedWindow(this.#computation, cells, request, signal);
  }

  /**
   * Return the numbers of a point: of its cell, and of the nearest stored cell.
   * @param {Place} place
   * @param {AbortSignal} [signal]
   * @returns {Promise<PointAnswer>}
   */
  async point(place, signal) {
    const [stored, plans] = await Promise.all([
      this.#stored?.point(place, signal) ?? null,
      this.#plansOf(place.view, signal),
    ]);
    const plan = plans.cells ?? (place.losses ? plans.lossy : null);
    if (plan) {
      const verdicts = (await this.#about()).quantities.find(({ name }) => name === "stability")?.flags ?? {};
      const cell = await cellAt(this.#computation, plan, place, signal);
      return { ...toldCell(plan, cell, verdicts), stored };
    }
    if (stored) {
      // a motion with losses from a start other than the cell's may have another verdict
      const isOther = place.losses && plans.motion?.lossy && !isAt(stored.start, place);
      return { ...stored, verdict: isOther ? "" : stored.verdict, stored };
    }
    if (plans.refused && !this.#stored) {
      throw new Problem(plans.refused.error, { hint: plans.refused.hint, status: 400 });
    }
    return { start: {}, numbers: [], verdict: "", stored: null, note: NO_CELL };
  }

  /**
   * @param {MotionRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<MotionAnswer>}
   */
  async motion(request, signal = new AbortController().signal) {
    const [{ motions, parameters }, plans] = await Promise.all([
      this.#about(),
      this.#plansOf(request.view, signal),
    ]);
    return computedMotion(this.#computation, motions, parameters, plans, request, signal);
  }
}

/**
 * Return whether a cell is exactly at a place, not only the nearest one.
 * @param {PointAnswer["start"]} start
 * @param {Place} place
 */
function isAt(start, { view, x, y }) {
  return start[view.x.name]?.value === x && start[view.y.name]?.value === y;
}

/**
 * Return stored cells, and computed ones where there are none.
 * @param {WindowAnswer} stored
 * @param {WindowAnswer} computed
 * @returns {WindowAnswer}
 */
function joined(stored, computed) {
  const mask = /** @type {Uint8Array} */ (stored.stored);
  const { value, verdict } = computed;
  const origin = new Uint8Array(mask.length);
  for (let i = 0; i < mask.length; i += 1) {
    if (mask[i] === NOTHING) continue;
    value[i] = stored.value[i];
    verdict[i] = stored.verdict[i];
    origin[i] = 1;
  }
  const ends = (
    /** @type {"low"|"high"|"least"} */ end,
    /** @type {(...all: number[]) => number} */ choose,
  ) => {
    const known = [stored.head[end], computed.head[end]].filter((each) => each !== null);
    return known.length ? choose(...known) : null;
  };
  const range = { low: ends("low", Math.min), high: ends("high", Math.max), least: ends("least", Math.min) };
  return { ...computed, head: { ...computed.head, ...range, note: stored.head.note }, stored: origin };
}

/**
 * Return a window of a quantity that only stored cells have, where none of them is shown.
 * @param {About} about
 * @param {WindowRequest} request
 * @returns {WindowAnswer}
 */
function nothing({ quantities }, { width, height, quantity }) {
  const shown = quantities.find(({ name }) => name === quantity);
  const label = shown?.label ?? quantity;
  const note = `${label[0].toUpperCase()}${label.slice(1)} is known only for stored cells, and none of them is shown here.`;
  const count = width * height;
  const value = shown?.flags ? new Uint8Array(count).fill(NO_CODE) : new Float64Array(count).fill(NaN);
  const head = { low: null, high: null, least: null, end: false, note };
  return { head, width, height, value, verdict: new Uint8Array(count), stored: null };
}
