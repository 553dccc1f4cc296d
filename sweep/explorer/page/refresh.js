/**
 * The scheduling of windows: a coarse one immediately and during movement, the fine one as soon as movement stops. If
 * cells take long, the coarse one has few of them, and ever finer ones come before the fine one.
 */

/** @import { Source, View, WindowAnswer } from "eulerdisk/types" */

/**
 * The wanted window: a view at the pixels of the screen.
 * @typedef {{view: View, quantity: string, stored: boolean, width: number, height: number}} Wanted
 */

/** Number of pixels of a coarse picture, and the largest number of a fine one. */
const COARSE = 256 * 192;
export const FINE = 2.5e6;

/**
 * Milliseconds that a coarse picture may take, and a fine one; factor by which the number of cells increases from
 * picture to picture between them.
 */
const SOON = 300;
const PATIENCE = 30_000;
const FINER = 6;
const FEW =
  "The cells of this map take long to compute, so it has fewer than the screen has pixels. Zoom in for more.";

/** Milliseconds without a change before the fine picture is requested. */
const REST = 90;

export class Refresh {
  #source;
  #deliver;
  #fail;
  /** @type {Wanted|null} */
  #wanted = null;
  /** @type {AbortController|null} */
  #fine = null;
  #timer = 0;
  /** @type {Map<string, number>} milliseconds per cell, by base and quantity */
  #costs = new Map();
  #costOf;
  /** @type {Wanted|null} a window that needs no computing, because all of it is stored */
  #free = null;
  /** @type {Latest<Wanted>} */
  #coarse;

  /**
   * @param {Source} source
   * @param {(wanted: Wanted, answer: WindowAnswer, lane: "coarse"|"fine") => void} deliver
   * @param {(problem: Error, lane: "coarse"|"fine") => void} fail
   * @param {(base: string) => number} costOf  milliseconds per cell of a base, 0 where they are negligible
   */
  constructor(source, deliver, fail, costOf) {
    this.#costOf = costOf;
    this.#source = source;
    this.#deliver = deliver;
    this.#fail = fail;
    this.#coarse = new Latest((wanted) => this.#ask(wanted, "coarse"));
  }

  /** @param {Wanted} wanted */
  ask(wanted) {
    this.#wanted = wanted;
    this.#fine?.abort();
    clearTimeout(this.#timer);
    this.#coarse.ask(wanted);
    this.#timer = window.setTimeout(() => void this.#askFine(wanted), REST);
  }

  /** @param {Wanted} wanted */
  async #askFine(wanted) {
    this.#fine = new AbortController();
    const { signal } = this.#fine;
    const cells = wanted.width * wanted.height;
    if (this.#cost(wanted)) {
      let count = FINER * this.#within(wanted, SOON, COARSE);
      while (
        this.#free !== wanted &&
        count < Math.min(cells, this.#within(wanted, PATIENCE, FINE)) &&
        !signal.aborted
      ) {
        await this.#ask(wanted, "coarse", signal, count);
        count *= FINER;
      }
    }
    if (!signal.aborted) await this.#ask(wanted, "fine", signal);
  }

  /** @param {Wanted} wanted */
  #cost({ view: { base }, quantity }) {
    return this.#costs.get(`${base} ${quantity}`) ?? this.#costOf(base);
  }

  /**
   * Return the number of cells that can be computed in some milliseconds, at most `most`.
   * @param {Wanted} wanted
   * @param {number} time
   * @param {number} most
   */
  #within(wanted, time, most) {
    const cost = this.#free === wanted ? 0 : this.#cost(wanted);
    return cost ? Math.min(most, time / cost) : most;
  }

  /**
   * @param {Wanted} wanted
   * @param {"coarse"|"fine"} lane
   * @param {AbortSignal} [signal]
   * @param {number} [count]  approximate number of cells
   */
  async #ask(wanted, lane, signal, count) {
    const { view, quantity, stored } = wanted;
    const most =
      lane === "coarse" ? this.#within(wanted, SOON, COARSE) : this.#within(wanted, PATIENCE, FINE);
    const [width, height] = pixels(wanted, count ?? most);
    try {
      const answer = await this.#source.window({ view, width, height, quantity, stored }, signal);
      // stored cells cost nothing
      const computed = answer.stored ? answer.stored.filter((each) => each === 0).length : width * height;
      if (!computed) this.#free = wanted;
      if (this.#costOf(view.base) && computed && answer.milliseconds !== undefined) {
        this.#costs.set(`${view.base} ${quantity}`, answer.milliseconds / computed);
      }
      // the fine picture of the same view may have arrived first
      if (signal?.aborted) return;
      const isWhole = width === wanted.width || lane === "coarse" || !this.#cost(wanted) || !computed;
      const { head } = answer;
      this.#deliver(
        wanted,
        isWhole || head.note ? answer : { ...answer, head: { ...head, note: FEW } },
        lane,
      );
    } catch (problem) {
      if (!signal?.aborted && wanted === this.#wanted) this.#fail(/** @type {Error} */ (problem), lane);
    }
  }
}

/**
 * Return a width and height with at most `most` pixels, in the proportions of the screen.
 * @param {{width: number, height: number}} screen
 * @param {number} most
 * @returns {[number, number]}
 */
export function pixels({ width, height }, most) {
  const shrink = Math.min(1, Math.sqrt(most / (width * height)));
  return [Math.max(1, Math.floor(width * shrink)), Math.max(1, Math.floor(height * shrink))];
}

/** @template Request */
export class Latest {
  #run;
  /** @type {Request|null} */
  #waiting = null;
  #busy = false;

  /** @param {(request: Request) => Promise<void>} run  must not reject */
  constructor(run) {
    this.#run = run;
  }

  /** Whether a request is under way. */
  get busy() {
    return this.#busy;
  }

  /** @param {Request} request */
  ask(request) {
    this.#waiting = request;
    if (!this.#busy) void this.#work();
  }

  /** Drop the waiting request. */
  forget() {
    this.#waiting = null;
  }

  async #work() {
    this.#busy = true;
    while (this.#waiting !== null) {
      const request = this.#waiting;
      this.#waiting = null;
      await this.#run(request);
    }
    this.#busy = false;
  }
}
