/**
 * The potential of one motion of a body of revolution without losses; see potential.js.
 *
 * B w^2/2 + V = E with V = A o^2/2 + I s^2/2 + v^2/2 + h, where s and o depend only on the tilt, by a linear system
 * (docs/bodies.md, with its letters).
 */

/** @import { BodyOfMotion } from "eulerdisk/types" */
/** @import { Curve, Start } from "eulerdisk/motion/potential" */

/** Largest step of the integration. */
const STEP = 0.03;

/**
 * Return the properties of the meridian at a tilt with sine S and cosine C: n of an ellipse, a, b, l, r and a - r C.
 * @param {BodyOfMotion} body
 * @param {number} S
 * @param {number} C
 */
function placeAt({ core, shift, edge, square }, S, C) {
  const n = 1 / Math.sqrt(C * C + square * S * S);
  const [a, b] = [core + edge * n * C, -shift - edge * square * n * S];
  const r = edge * square * n ** 3;
  return { n, a, b, lever: a * S + b * C, r, inner: a - r * C };
}

/**
 * Return a function for the potential minus the energy and for its slope, as for the disk. The changes of s and of x =
 * C o since the start are integrated, so that the excess of a narrow swing is not a difference of large numbers.
 * @param {Start} start
 * @param {BodyOfMotion} body
 * @returns {Curve}
 */
export function curveOfBody({ tilt, tilt_rate, precession_rate, roll_rate, radius, gravity }, body) {
  const { core, shift, edge, square, axial: I, transverse: A } = body;
  const unit = Math.sqrt(radius / gravity);
  const [S0, C0] = [Math.sin(tilt), Math.cos(tilt)];
  const here = placeAt(body, S0, C0);
  const s0 = unit * (roll_rate + precession_rate * S0);
  const o0 = unit * precession_rate * C0;
  const x0 = C0 * o0;
  const v0 = here.a * s0 + here.b * o0;
  const y0 = Math.atanh(S0);
  const kinetic = 0.5 * (A + here.a ** 2 + here.b ** 2) * (unit * tilt_rate) ** 2;
  const slopes = (/** @type {number} */ y, /** @type {number} */ s, /** @type {number} */ x) => {
    const [S, C] = [Math.tanh(y), 1 / Math.cosh(y)];
    const { a, b, r, inner } = placeAt(body, S, C);
    const D = I * (A + b * b) + A * a * a;
    const spin = s0 + s;
    // C times P/D
    const twist = (inner * (x0 + x) - C * (r * S + (I / A) * b) * spin) / D;
    return /** @type {[number, number]} */ ([-A * a * twist, -C * ((I / A) * spin * C + I * b * twist)]);
  };
  const next = (/** @type {number} */ y, /** @type {[number, number]} */ [s, x], /** @type {number} */ h) => {
    const [s1, x1] = slopes(y, s, x);
    const [s2, x2] = slopes(y + h / 2, s + (h / 2) * s1, x + (h / 2) * x1);
    const [s3, x3] = slopes(y + h / 2, s + (h / 2) * s2, x + (h / 2) * x2);
    const [s4, x4] = slopes(y + h, s + h * s3, x + h * x3);
    return /** @type {[number, number]} */ ([
      s + (h / 6) * (s1 + 2 * s2 + 2 * s3 + s4),
      x + (h / 6) * (x1 + 2 * x2 + 2 * x3 + x4),
    ]);
  };
  /** Values integrated on either side of the start. @type {[number, number][][]} */
  const [up, down] = [[[0, 0]], [[0, 0]]];
  return (place) => {
    const way = place < y0 ? -1 : 1;
    const steps = Math.floor(Math.abs(place - y0) / STEP);
    const passed = way < 0 ? down : up;
    while (passed.length <= steps) {
      const count = passed.length - 1;
      passed.push(next(y0 + way * count * STEP, passed[count], way * STEP));
    }
    const last = y0 + way * steps * STEP;
    const [s, x] = next(last, passed[steps], place - last);
    const there = Math.asin(Math.tanh(place));
    const [S, C] = [Math.sin(there), Math.cos(there)];
    const now = placeAt(body, S, C);
    // differences from the start, without subtracting nearly equal numbers
    const half = Math.sin((there - tilt) / 2);
    const rise = 2 * Math.cos((there + tilt) / 2) * half;
    const fall = -2 * Math.sin((there + tilt) / 2) * half;
    const squares = (1 - square) * rise * (S + S0);
    const wider = (squares * now.n * here.n) / (1 / now.n + 1 / here.n);
    const longer = edge * (wider * C + here.n * fall);
    const farther = -edge * square * (wider * S + here.n * rise);
    const higher = core * fall + shift * rise - (edge * squares) / (1 / now.n + 1 / here.n);
    const [spin, o] = [s0 + s, (x0 + x) / C];
    const change = x / C - (x0 * fall) / (C * C0);
    const v = now.a * spin + now.b * o;
    const faster = now.a * s + s0 * longer + now.b * change + o0 * farther;
    const gained = 0.5 * (A * change * (o + o0) + I * s * (spin + s0) + faster * (v + v0)) + higher;
    const pull = C * now.lever + o * (C * I * spin - A * o * S + (now.a * C - now.b * S) * v);
    return { excess: gained - kinetic, slope: -pull };
  };
}
