/** The samples of one motion, and interpolation between them. */

import { potentialOf } from "eulerdisk/motion/potential";

/** @import { MotionAnswer } from "eulerdisk/types" */

export class Samples {
  /** @param {MotionAnswer} answer */
  constructor({ head, arrays }) {
    this.head = head;
    this.arrays = arrays;
    this.times = arrays.time;
    /** The potential, for a rolling body without losses. */
    this.potential =
      head.lossy || head.states
        ? null
        : potentialOf(/** @type {any} */ ({ ...head, ...head.start }), head.fall_tilt, head.body);
  }

  /** Length of the motion in seconds. */
  get length() {
    return this.times[this.times.length - 1];
  }

  /**
   * Return the index of the last sample at or before a time, except the very last sample.
   * @param {number} time
   */
  before(time) {
    let [low, high] = [0, this.times.length - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle;
      else high = middle;
    }
    return low;
  }

  /**
   * Return the index of the sample before a time, and the share of the way from it to the next one.
   * @param {number} time
   */
  between(time) {
    const t = Math.min(Math.max(time, this.times[0]), this.length);
    const before = this.before(t);
    const step = this.times[before + 1] - this.times[before];
    return { before, share: step > 0 ? (t - this.times[before]) / step : 0 };
  }

  /**
   * Return the value of an array at a time, by the cubic whose slopes at both samples are those of the parabolas
   * through their neighbours. After its end, a motion stays where it is.
   * @param {string} name
   * @param {number} time
   */
  at(name, time) {
    const values = this.arrays[name];
    const t = Math.min(Math.max(time, this.times[0]), this.length);
    const i = this.before(t);
    const step = this.times[i + 1] - this.times[i];
    if (!(step > 0)) return values[i];
    const share = (t - this.times[i]) / step;
    const [a, b] = [this.#slope(values, i) * step, this.#slope(values, i + 1) * step];
    const rise = values[i + 1] - values[i];
    const bend = share * (1 - share) * ((1 - share) * (a - rise) - share * (b - rise));
    return values[i] + share * rise + bend;
  }

  /**
   * Return the slope of the parabola through a sample and its neighbours; at an end, the slope of the line to its only
   * neighbour.
   * @param {Float64Array} values
   * @param {number} i
   */
  #slope(values, i) {
    const last = values.length - 1;
    if (i === 0) return (values[1] - values[0]) / (this.times[1] - this.times[0]);
    if (i === last) return (values[last] - values[last - 1]) / (this.times[last] - this.times[last - 1]);
    const [before, after] = [this.times[i] - this.times[i - 1], this.times[i + 1] - this.times[i]];
    const [left, right] = [(values[i] - values[i - 1]) / before, (values[i + 1] - values[i]) / after];
    return (after * left + before * right) / (before + after);
  }
}
