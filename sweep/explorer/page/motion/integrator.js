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

/** Steps after which a motion is given up. */
const MOST_STEPS = 2e6;

/** Numbers of the state: S, C, T, w, o, s, heading, roll angle, x and y of the contact point over the radius. */
const SIZE = 10;

/**
 * Samples of a motion at given times [s], increasing from 0.
 *
 * A disk whose tilt reaches `fallTilt` has fallen: the samples end there, with the moment of the fall as the last time.
 * @param {Start} start  in SI units
 * @param {ArrayLike<number>} times
 * @param {number} fallTilt  in radians
 * @returns {{fell: boolean, arrays: Record<string, Float64Array>}}
 */
export function integrate(start, times, fallTilt) {
  const unit = Math.sqrt(start.radius / start.gravity);
  const least = Math.cos(fallTilt);
  /** @type {Float64Array} */
  let state = stateOf(start, unit);
  /** @type {Float64Array} */
  let next = state.slice();
  const kept = [state.slice()];
  const moments = [0];
  let steps = 0;
  for (let i = 1; i < times.length; i += 1) {
    const end = times[i] / unit;
    let now = times[i - 1] / unit;
    while (now < end) {
      const parts = Math.max(1, Math.ceil((end - now) / suitableStep(state, start.alpha) - 1e-9));
      const h = (end - now) / parts;
      step(state, start.alpha, h, next);
      steps += 1;
      // a disk that cannot be followed ends as one that fell: where it was last
      if (!(next[1] > least) || steps > MOST_STEPS) {
        const part = fallWithin(state, start.alpha, h, least);
        kept.push(step(state, start.alpha, part, next).slice());
        moments.push(unit * (now + part));
        return { fell: true, arrays: arraysOf(kept, moments, start, unit) };
      }
      [state, next] = [next, state];
      now = parts === 1 ? end : now + h;
    }
    kept.push(state.slice());
    moments.push(times[i]);
  }
  return { fell: false, arrays: arraysOf(kept, moments, start, unit) };
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
 * Part of a step after which cos(tilt) is down to `least`, by bisection.
 * @param {Float64Array} state
 * @param {number} alpha
 * @param {number} h
 * @param {number} least
 */
function fallWithin(state, alpha, h, least) {
  let [low, high] = [0, h];
  for (let i = 0; i < 50; i += 1) {
    const middle = (low + high) / 2;
    if (step(state, alpha, middle, LANDED)[1] > least) low = middle;
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
