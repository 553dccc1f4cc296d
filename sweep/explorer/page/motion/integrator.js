/**
 * The motion of a disk that rolls without losses, integrated in the page: exported pages have no server.
 *
 * Equations of docs/theory.md ("As the code has them"), time in units of sqrt(R/g). The state is S = sin(tilt),
 * C = cos(tilt), T = tan(tilt), w = tilt rate, o = precession rate * C, s = roll rate + precession rate * S. Heading, roll
 * angle and path are integrated with it.
 */

/** @typedef {{tilt: number, tilt_rate: number, precession_rate: number, roll_rate: number}} Rates */
/** @typedef {Rates & {alpha: number, radius: number, gravity: number}} Start */

/** Step times the fastest frequency of the state. */
const RELATIVE_STEP = 0.006;

/** Steps after which a motion is given up, and those that are made to find its turning points. */
const MOST_STEPS = 2e6;
const STEPS_TO_TURNS = 4e5;

/** Between two samples: angle that the disk turns, time in units of sqrt(R/g), and the share of the whole time. */
const TURN = 0.1;
const PART = 0.1;
const LEAST_SHARE = 1 / 50_000;
const MOST_SHARE = 1 / 1000;

/** Numbers of the state: S, C, T, w, o, s, heading, roll angle, x and y of the contact point over the radius. */
const SIZE = 10;

/** @typedef {""|"fell"|"given up"} Ended  empty while a motion goes on */

/** @typedef {{ended: Ended, arrays: Record<string, Float64Array>}} Samples */

/** @typedef {{time: number, tilt: number}} Turn  in seconds and radians */

/** A motion under way: its state, and the time since its start in units of sqrt(R/g). */
class Motion {
  now = 0;
  steps = 0;
  /** @type {Ended} */
  ended = "";
  #alpha;
  #least;
  /** @type {Float64Array} */
  #next;

  /**
   * @param {Start} start
   * @param {number} fallTilt
   */
  constructor(start, fallTilt) {
    this.unit = Math.sqrt(start.radius / start.gravity);
    /** @type {Float64Array} */
    this.state = stateOf(start, this.unit);
    this.#next = this.state.slice();
    this.#alpha = start.alpha;
    this.#least = Math.cos(fallTilt);
  }

  /** Time since the start in seconds. */
  get time() {
    return this.unit * this.now;
  }

  get suitableStep() {
    return suitableStep(this.state, this.#alpha);
  }

  /**
   * One step. A disk that falls within it ends where it falls; one whose numbers end stays where it is.
   * @param {number} h
   */
  advance(h) {
    const next = step(this.state, this.#alpha, h, this.#next);
    this.steps += 1;
    if (next[1] <= this.#least) {
      const part = fallWithin(this.state, this.#alpha, h, this.#least);
      step(this.state, this.#alpha, part, next);
      this.ended = "fell";
      this.now += part;
    } else if (next[1] > this.#least && this.steps <= MOST_STEPS) {
      this.now += h;
    } else {
      this.ended = "given up";
      return;
    }
    [this.state, this.#next] = [next, this.state];
  }

  /**
   * To a time in seconds, or to the end.
   * @param {number} time
   */
  follow(time) {
    const end = time / this.unit;
    while (this.now < end && !this.ended) {
      const parts = Math.max(1, Math.ceil((end - this.now) / this.suitableStep - 1e-9));
      this.advance((end - this.now) / parts);
      if (parts === 1 && !this.ended) this.now = end;
    }
  }

  /**
   * One step, and the turning point of the tilt that lies within it.
   * @returns {Turn|null}
   */
  advanceToTurn() {
    const [h, begun] = [this.suitableStep, this.now];
    const before = this.state.slice();
    const side = Math.sign(before[3]);
    this.advance(h);
    if (this.ended || side === 0 || Math.sign(this.state[3]) === side) return null;
    const part = partWithin(h, (middle) => Math.sign(step(before, this.#alpha, middle, LANDED)[3]) === side);
    const [S, C] = step(before, this.#alpha, part, LANDED);
    return { time: this.unit * (begun + part), tilt: Math.atan2(S, C) };
  }
}

/**
 * Samples of a motion at given times [s], increasing from 0.
 *
 * A disk whose tilt reaches `fallTilt` has fallen: the samples end there, with the moment of the fall as the last time.
 * Those of one that needs too many steps end where it was given up.
 * @param {Start} start  in SI units
 * @param {ArrayLike<number>} times
 * @param {number} fallTilt  in radians
 * @returns {Samples}
 */
export function integrate(start, times, fallTilt) {
  let i = 0;
  return sampled(start, fallTilt, () => times[(i += 1)]);
}

/**
 * Samples of a motion to a time [s], as close as it turns at each moment.
 * @param {Start} start  in SI units
 * @param {number} duration
 * @param {number} fallTilt  in radians
 * @returns {Samples}
 */
export function integrateClosely(start, duration, fallTilt) {
  return sampled(start, fallTilt, ({ state, unit }, time) => {
    if (time >= duration) return undefined;
    const [, C, T, w, o, s] = state;
    const rate = Math.abs(w) + Math.abs(o / C) + Math.abs(s - o * T);
    const wanted = unit * Math.min(PART, TURN / rate);
    const interval = Math.max(Math.min(wanted, MOST_SHARE * duration), LEAST_SHARE * duration);
    // no interval that is much shorter than the others stands at the end
    return time + 1.5 * interval < duration ? time + interval : duration;
  });
}

/**
 * @param {Start} start
 * @param {number} fallTilt
 * @param {(motion: Motion, time: number) => number|undefined} following  time of the next sample, none after the last
 * @returns {Samples}
 */
function sampled(start, fallTilt, following) {
  const motion = new Motion(start, fallTilt);
  const kept = [motion.state.slice()];
  const moments = [0];
  for (let last = 0; !motion.ended; last = moments[moments.length - 1]) {
    const time = following(motion, last);
    if (time === undefined) break;
    motion.follow(time);
    const moment = motion.ended ? motion.time : time;
    if (motion.ended && !(moment > last)) break;
    kept.push(motion.state.slice());
    moments.push(moment);
  }
  return { ended: motion.ended, arrays: arraysOf(kept, moments, start, motion.unit) };
}

/**
 * The first two turning points of the tilt, between which it swings for ever; a start at rest is one. A tilt that never
 * changes has the same one twice. None are known of a disk that falls before, or is too slow to turn.
 * @param {Start} start  in SI units
 * @param {number} fallTilt  in radians
 * @returns {{ended: Ended, turns: Turn[]}}
 */
export function turnsOf(start, fallTilt) {
  const motion = new Motion(start, fallTilt);
  const turns = motion.state[3] === 0 ? [{ time: 0, tilt: start.tilt }] : [];
  while (turns.length < 2 && !motion.ended && motion.steps < STEPS_TO_TURNS) {
    const turn = motion.advanceToTurn();
    if (turn) turns.push(turn);
    // neither a rate nor what would change it
    if (motion.steps === 1 && motion.state[3] === 0) turns.push({ time: 0, tilt: start.tilt });
  }
  return { ended: motion.ended, turns: turns.length > 1 ? turns : [] };
}

/**
 * @param {Start} start
 * @param {number} unit  sqrt(R/g)
 */
function stateOf(start, unit) {
  const [S, C] = [Math.sin(start.tilt), Math.cos(start.tilt)];
  const o = unit * start.precession_rate * C;
  const s = unit * (start.roll_rate + start.precession_rate * S);
  return Float64Array.of(S, C, S / C, unit * start.tilt_rate, o, s, 0, 0, 0, 0);
}

/**
 * Derivatives of a state. Numbers are read one by one: taking an array apart costs ten times as much.
 * @param {Float64Array} state
 * @param {number} alpha
 * @param {Float64Array} into
 */
function slopes(state, alpha, into) {
  const S = state[0];
  const C = state[1];
  const T = state[2];
  const w = state[3];
  const o = state[4];
  const s = state[5];
  const rolling = s - o * T;
  into[0] = C * w;
  into[1] = -S * w;
  into[2] = (1 + T * T) * w;
  into[3] = (S + o * ((1 + alpha) * s - 0.5 * alpha * o * T)) / (1 + 0.5 * alpha);
  into[4] = w * (o * T - 2 * s);
  into[5] = (-w * o) / (1 + alpha);
  into[6] = o / C;
  into[7] = rolling;
  into[8] = -rolling * Math.sin(state[6]);
  into[9] = rolling * Math.cos(state[6]);
}

const [K1, K2, K3, K4, BETWEEN, LANDED] = Array.from({ length: 6 }, () => new Float64Array(SIZE));

/**
 * State one step of the classical Runge-Kutta method later.
 * @param {Float64Array} state
 * @param {number} alpha
 * @param {number} h
 * @param {Float64Array} next  where it is written
 */
function step(state, alpha, h, next) {
  slopes(state, alpha, K1);
  for (let i = 0; i < SIZE; i += 1) BETWEEN[i] = state[i] + 0.5 * h * K1[i];
  slopes(BETWEEN, alpha, K2);
  for (let i = 0; i < SIZE; i += 1) BETWEEN[i] = state[i] + 0.5 * h * K2[i];
  slopes(BETWEEN, alpha, K3);
  for (let i = 0; i < SIZE; i += 1) BETWEEN[i] = state[i] + h * K3[i];
  slopes(BETWEEN, alpha, K4);
  for (let i = 0; i < SIZE; i += 1) next[i] = state[i] + (h / 6) * (K1[i] + 2 * K2[i] + 2 * K3[i] + K4[i]);
  return next;
}

/**
 * Step for a state: its fastest frequency decides, and how near to flat it is.
 * @param {Float64Array} state
 * @param {number} alpha
 */
function suitableStep(state, alpha) {
  const C = state[1];
  const w = state[3];
  const o = state[4];
  const s = state[5];
  const square = (1 + 2 * (1 + alpha) * s * s) / (1 + 0.5 * alpha) + o * o + w * w;
  return (RELATIVE_STEP * C) / Math.sqrt(square);
}

/**
 * Part of a step after which cos(tilt) is down to `least`.
 * @param {Float64Array} state
 * @param {number} alpha
 * @param {number} h
 * @param {number} least
 */
function fallWithin(state, alpha, h, least) {
  return partWithin(h, (middle) => step(state, alpha, middle, LANDED)[1] > least);
}

/**
 * Largest part of a step for which something holds, by bisection.
 * @param {number} h
 * @param {(part: number) => boolean} holds
 */
function partWithin(h, holds) {
  let [low, high] = [0, h];
  for (let i = 0; i < 50; i += 1) {
    const middle = (low + high) / 2;
    if (holds(middle)) low = middle;
    else high = middle;
  }
  return low;
}

/**
 * Arrays of samples, named and measured as those of the server (sweep/explorer/motion.py).
 * @param {Float64Array[]} states
 * @param {number[]} times
 * @param {Start} start
 * @param {number} unit
 */
function arraysOf(states, times, start, unit) {
  const { alpha, radius } = start;
  /** @type {Record<string, (state: Float64Array) => number>} */
  const rules = {
    tilt: ([S, C]) => Math.atan2(S, C),
    tilt_rate: ([, , , w]) => w / unit,
    precession_rate: ([, C, , , o]) => o / (C * unit),
    roll_rate: ([, , T, , o, s]) => (s - o * T) / unit,
    heading: (state) => state[6],
    roll_angle: (state) => state[7],
    contact_x: (state) => radius * state[8],
    contact_y: (state) => radius * state[9],
    normal_force: (state) => forces(state, alpha)[0],
    friction_across: (state) => forces(state, alpha)[1],
    friction_along: (state) => forces(state, alpha)[2],
    friction_needed: (state) => {
      const [normal, across, along] = forces(state, alpha);
      return normal > 0 ? Math.hypot(across, along) / normal : NaN;
    },
    energy: ([, C, , w, o, s]) =>
      0.5 * (1 + 0.5 * alpha) * w * w + 0.5 * (1 + alpha) * s * s + 0.25 * alpha * o * o + C,
  };
  const found = Object.entries(rules).map(([name, rule]) => [name, Float64Array.from(states, rule)]);
  return { time: Float64Array.from(times), ...Object.fromEntries(found) };
}

/**
 * Force of the table on the disk over its weight: upward, across and along the track ("Forces at the contact").
 * @param {Float64Array} state
 * @param {number} alpha
 * @returns {[number, number, number]}
 */
export function forces(state, alpha) {
  const [S, C, T, w, o, s] = state;
  const [turning, rolling, climb] = [o / C, s - o * T, o * T];
  const acceleration = (S + o * ((1 + alpha) * s - 0.5 * alpha * o * T)) / (1 + 0.5 * alpha);
  const normal = 1 - (acceleration * S + w * w * C);
  const pull = 2 * S * C - (2 + alpha) * S * (w * w + climb * climb);
  const across = (pull + rolling * turning * (alpha - 2 * (1 + alpha) * S * S)) / (2 + alpha);
  return [normal, across, (alpha * o * w) / (1 + alpha)];
}
