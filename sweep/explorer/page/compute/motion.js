/** Motions that the page computes: their duration, their arrays, and the texts next to them. */

import { cellAt } from "eulerdisk/compute/cells";
import { freePath, ROWS } from "eulerdisk/compute/free_path";
import {
  checkArms,
  checkLosses,
  lossControls,
  lossWords,
  numberOf,
  wordsOfMotion,
} from "eulerdisk/compute/losses";
import { lossyPath } from "eulerdisk/compute/paths";
import { bodyOf, TORUS, torusOf } from "eulerdisk/compute/shapes";
import { general, spelled } from "eulerdisk/compute/spelling";
import { systemMotion } from "eulerdisk/compute/system_motion";
import { Problem } from "eulerdisk/notice";

/** @import { Computation } from "eulerdisk/compute/computation" */
/** @import { MotionAnswer, MotionPlan, MotionRequest, MotionTables, Parameter, Plans, SystemPlan } from "eulerdisk/types" */

/**
 * Number of periods for which a motion without losses is followed, and its shortest and longest duration in seconds.
 */
const PERIODS = 3;
const SHORTEST = 6;
const LONGEST = 60;

/** Longest duration of a motion with losses, which is otherwise followed to its end. */
const TO_THE_END = 120;

/**
 * Largest total angle in radians by which the disk may turn at its initial rates, and longest duration in units of
 * sqrt(R/g).
 */
const MOST = { disk: { turns: 400, units: 4e3 }, lossy: { turns: 4000, units: 4e4 } };

const LEAST = 1e-3;

/** Largest tilt of a body that rolls on through the vertical: nothing ends its motion there. */
const RIGHT_ANGLE = Math.PI / 2;

/** Largest rate, in units of sqrt(g/R): the energy contains its square. */
const LARGEST = 1e100;

/**
 * Endings of a cell without losses: it swings; it falls, or touches down on its other edge (kernels/disk/endings.py).
 */
const BOUNDED = 1;
const ENDS = [4, 7];

const STATE = ["tilt", "tilt_rate", "precession_rate", "roll_rate"];
const PATH = ["heading", "roll_angle", "contact_x", "contact_y"];
const CENTRE = ["centre_x", "centre_y", "centre_z"];
const LOSSES = ["rolling_loss", "pivoting_loss", "contour_loss", "damping_loss", "air_loss"];
const FORCES = ["normal_force", "friction_across", "friction_along"];

/** Rows of the forces and of the centre among the samples of a motion with losses. */
const LOSSY_FORCES = 13;
const LOSSY_CENTRE = 17;

const LIFTS_OFF = "A real disk would leave the table during this motion: the normal force vanishes.";
const NEEDS = "Rolling without slipping needs a friction coefficient of";
const ELSEWHERE = "Choose another place on the map.";

/** Digits of a start and of a turning point, of a time, and of a coefficient. */
const DIGITS = 6;
const TIME_DIGITS = 4;
const FEW_DIGITS = 3;

/** @typedef {Record<string, number>} Start  every parameter, in SI */

/**
 * Return the answer that the page draws for the motion of a start.
 * @param {Computation} computation
 * @param {MotionTables} tables
 * @param {Parameter[]} parameters
 * @param {Plans} plans
 * @param {MotionRequest} request
 * @param {AbortSignal} signal
 * @returns {Promise<MotionAnswer>}
 */
export async function computedMotion(computation, tables, parameters, plans, request, signal) {
  const { cells, disk } = plans;
  const { view } = request;
  if (cells && "system" in cells) {
    return systemMotion(computation, /** @type {SystemPlan} */ (cells), request, signal);
  }
  const motion = plans.motion && { ...plans.motion, losses: lossesAt(plans.motion.losses, request) };
  const losses = request.losses ?? {};
  if (!motion || !disk) {
    throw new Problem("This page shows no motions of these cells in time.", {
      hint: "eulerdisk simulate follows one.",
      status: 400,
    });
  }
  checkLosses(tables, losses);
  const cell = await cellAt(computation, disk, request, signal);
  const lossy = motion.lossy || Object.keys(lossWords(tables, losses)).length > 0;
  const { body } = motion;
  const largest = body?.poles ? RIGHT_ANGLE : lossy ? motion.flat_tilt : motion.fall_tilt;
  checkStart(tables, parameters, cell, largest, lossy ? "flat_tilt" : "fall_tilt", body ? "body" : "disk");
  const words = wordsOfMotion(tables, motion, losses);
  if (body) checkBody(body, bodyOf(body, cell), cell, lossy ? words : {}, tables.no_air);
  if (lossy) checkArms(words, cell.radius);
  const duration = durationOf(cell, lossy, Boolean(body), request.duration ?? null);
  const start = body ? disk.parameters.map((name) => cell[name]) : torusOf(cell);
  const rolling = { ...(body ?? { number: TORUS, poles: false }), fallTilt: largest };
  const { arrays, ending } = lossy
    ? await lossyArrays(computation, tables, cell, words, duration, motion, signal)
    : await freeArrays(computation, start, cell, duration, rolling, signal);
  const last = /** @type {number} */ (arrays.time.at(-1));
  const ended = endingsOf(tables, Boolean(body), lossy)[String(ending)];
  const told = (/** @type {string} */ name) => spelled(tables.rules[name], cell[name], DIGITS);
  const sides = [view.x.name, view.y.name].filter((name) => name in tables.rules);
  const head = {
    title: sides.map((name) => `${name.replaceAll("_", " ")} ${told(name)}`).join(", "),
    ending: ended
      ? `${ended} at ${general(last, TIME_DIGITS)} s`
      : `followed for ${general(last, FEW_DIGITS)} s`,
    ended: Boolean(ended),
    note: noteOf(arrays),
    lossy,
    start: Object.fromEntries(STATE.map((name) => [name, cell[name]])),
    alpha: cell.alpha,
    body: body && bodyOf(body, cell),
    radius: cell.radius,
    gravity: cell.gravity,
    quantities: tables.quantities,
    losses: lossControls(tables, motion, /** @type {any} */ (cell), losses),
    ledger: lossy ? tables.ledger : null,
    ...swing(tables, cell, lossy, largest),
  };
  return { head, arrays };
}

/**
 * Return the losses of the cell at a place, some of which may be axes of the map.
 * @param {MotionPlan["losses"]} losses
 * @param {MotionRequest} request
 * @returns {MotionPlan["losses"]}
 */
function lossesAt(losses, { view, x, y }) {
  /** @type {Record<string, number>} */
  const at = { [view.x.name]: x, [view.y.name]: y };
  return Object.fromEntries(Object.entries(losses).map(([name, value]) => [name, at[name] ?? value]));
}

/**
 * Return the descriptions of the endings of motions.
 * @param {MotionTables} tables
 * @param {boolean} isBody
 * @param {boolean} lossy
 */
function endingsOf(tables, isBody, lossy) {
  if (isBody) return lossy ? tables.lossy_body : tables.body;
  return lossy ? tables.lossy : tables.disk;
}

/**
 * Raise an error if a start has no motion.
 * @param {MotionTables} tables
 * @param {Parameter[]} parameters
 * @param {Start} start
 * @param {number} largest
 * @param {string} largestName
 * @param {string} called
 */
function checkStart(tables, parameters, start, largest, largestName, called) {
  const refuse = (/** @type {string} */ words, hint = ELSEWHERE) => {
    throw new Problem(words, { hint, status: 400 });
  };
  const missing = STATE.find((name) => !Number.isFinite(start[name]));
  if (missing) refuse(`No motion here: no ${missing} keeps this tilt constant.`);
  const got = (/** @type {string} */ name) => spelled(tables.rules[name], start[name], 10);
  for (const { name, least, most } of parameters) {
    if (!(name in tables.rules)) continue;
    if ((least === null || start[name] >= least) && (most === null || start[name] <= most)) continue;
    refuse(`No motion here: it needs ${tables.rules[name].rule}; got ${got(name)}.`);
  }
  const unit = Math.sqrt(start.radius / start.gravity);
  const large = STATE.slice(1).find((name) => !(Math.abs(start[name]) * unit < LARGEST));
  if (large) {
    refuse(
      `No motion here: ${large} is so large that the energy overflows.`,
      `${ELSEWHERE.slice(0, -1)}, or a smaller number.`,
    );
  }
  if (Math.abs(start.tilt) < largest) return;
  const limit = spelled(tables.rules.tilt, largest, DIGITS);
  refuse(
    `This ${called} has fallen before it starts: |tilt| must be below ${largestName}; got tilt=${got("tilt")} ${largestName}=${limit}.`,
    `Start with a smaller tilt, or give a larger ${largestName}.`,
  );
}

/**
 * Raise an error, as the program does, if a body starts on both edges, or has losses that are not derived for it.
 * @param {{name: string, called: string, poles: boolean, faced: boolean}} body
 * @param {{core: number}} shape
 * @param {Record<string, number>} cell
 * @param {Record<string, number|string|null>} words  of the losses, empty without losses
 * @param {string} none  the law of no air
 */
function checkBody({ name, called, poles, faced }, { core }, cell, words, none) {
  if (name === "rim" && cell.tilt === 0) {
    const ended =
      "This motion has ended before it starts: upright, a disk with a rim stands on both of its edges.";
    throw new Problem(ended, { hint: "Start with a tilt.", status: 400 });
  }
  if (!Object.keys(words).length) return;
  if (poles) {
    const endless = `A ${called} rolls without losses: the thin disk and bodies that fall have them.`;
    throw new Problem(endless, { hint: "Leave the losses out.", status: 400 });
  }
  if (core <= 0) {
    const round = `A ${called} of this shape has no face left to lie on, so it cannot have losses.`;
    throw new Problem(round, { hint: "Give a smaller fillet or thickness.", status: 400 });
  }
  if (!faced && words.air_law && words.air_law !== none) {
    const open = `The laws of the air describe a film and a layer under a flat face, and a ${called} has none.`;
    throw new Problem(open, { hint: `Give air_law=${none}.`, status: 400 });
  }
}

/**
 * Return the duration in seconds for which a motion is followed.
 * @param {Start} cell
 * @param {boolean} lossy
 * @param {boolean} isBody
 * @param {number|null} asked
 */
function durationOf(cell, lossy, isBody, asked) {
  const { turns, units } = lossy ? MOST.lossy : MOST.disk;
  const { tilt, tilt_rate: tilting, precession_rate: turning, roll_rate: rolling } = cell;
  // near a pole of a ball, heading and roll turn against each other
  const rate = isBody
    ? Math.hypot(tilting, turning * Math.cos(tilt)) + Math.abs(rolling + turning * Math.sin(tilt))
    : Math.abs(tilting) + Math.abs(turning) + Math.abs(rolling);
  const most = Math.min(rate > 0 ? turns / rate : Infinity, units * Math.sqrt(cell.radius / cell.gravity));
  if (asked !== null) return Math.min(Math.max(asked, LEAST), most);
  if (lossy) return Math.min(TO_THE_END, most);
  const { nutation_period: period, ending } = cell;
  // a disk that falls is followed to its fall, whenever that is
  const wanted = Number.isFinite(period) ? PERIODS * period : ENDS.includes(ending) ? LONGEST : SHORTEST;
  return Math.min(Math.max(wanted, SHORTEST), LONGEST, most);
}

/**
 * @param {Computation} computation
 * @param {number[]} start  as that of a body
 * @param {Start} cell
 * @param {number} duration
 * @param {{number: number, poles: boolean, fallTilt: number}} body
 * @param {AbortSignal} signal
 */
async function freeArrays(computation, start, cell, duration, body, signal) {
  const { radius, gravity } = cell;
  const size = { radius, unit: Math.sqrt(radius / gravity) };
  const { times, rows, ending } = await freePath(computation, start, duration, { ...body, ...size }, signal);
  // the kernel converted the rates to scaled ones and back
  STATE.forEach((name, i) => (rows[i][0] = cell[name]));
  const all = named(ROWS, rows);
  const kept = [...STATE, ...PATH, ...CENTRE, ...FORCES, "energy"].map((name) => [name, all[name]]);
  const arrays = { time: times, ...Object.fromEntries(kept), friction_needed: frictionNeeded(all) };
  return { arrays: /** @type {Record<string, Float64Array>} */ (arrays), ending };
}

/** @param {Record<string, Float64Array>} forces */
function frictionNeeded({ normal_force: normal, friction_across: across, friction_along: along }) {
  return normal.map((each, i) => (each > 0 ? Math.hypot(across[i], along[i]) / each : NaN));
}

/**
 * @param {Computation} computation
 * @param {MotionTables} tables
 * @param {Start} cell
 * @param {Record<string, number|string|null>} words
 * @param {number} duration
 * @param {MotionPlan} plan
 * @param {AbortSignal} signal
 */
async function lossyArrays(
  computation,
  tables,
  cell,
  words,
  duration,
  { body, flat_tilt: flatTilt },
  signal,
) {
  const names = body ? tables.lossy_body_parameters : tables.lossy_parameters;
  const start = names.map((name) => (name in tables.rules ? cell[name] : numberOf(words, name)));
  const law = tables.air_laws.indexOf(String(words.air_law ?? tables.no_air));
  const { times, rows, ending } = await lossyPath(
    computation,
    start,
    duration,
    { flatTilt, law, body: body?.number ?? null },
    signal,
  );
  const needed = frictionNeeded(named(FORCES, rows.slice(LOSSY_FORCES)));
  const samples = named([...STATE, ...PATH, ...LOSSES, ...FORCES], rows);
  const centre = named([...CENTRE, "energy"], rows.slice(LOSSY_CENTRE));
  const arrays = { time: times, ...samples, ...centre, friction_needed: needed };
  return { arrays: /** @type {Record<string, Float64Array>} */ (arrays), ending };
}

/**
 * @param {string[]} names
 * @param {Float64Array[]} rows
 */
function named(names, rows) {
  return Object.fromEntries(names.map((name, i) => [name, rows[i]]));
}

/**
 * Return a note on the friction that the disk needs to roll all the time.
 * @param {Record<string, Float64Array>} arrays
 */
function noteOf({ normal_force: normal, friction_needed: needed }) {
  if (!normal.every((each) => each > 0)) return LIFTS_OFF;
  return `${NEEDS} ${general(
    needed.reduce((most, each) => Math.max(most, each), 0),
    FEW_DIGITS,
  )}.`;
}

/**
 * Return the swing of a motion without losses, from the reduction.
 * @param {MotionTables} tables
 * @param {Start} cell
 * @param {boolean} lossy
 * @param {number} fallTilt
 */
function swing(
  { rules },
  { ending, tilt_min: least, tilt_max: greatest, nutation_period: period },
  lossy,
  fallTilt,
) {
  if (lossy) return { turns: [], period: null, fall_tilt: /** @type {any} */ (null) };
  const turns = ending === BOUNDED ? [least, greatest] : [];
  return {
    // with the same digits as the numbers of the point next to it
    turns: turns.map((turn) => /** @type {[number, string]} */ ([turn, spelled(rules.tilt, turn, DIGITS)])),
    period: Number.isFinite(period) ? period : null,
    fall_tilt: fallTilt,
  };
}
