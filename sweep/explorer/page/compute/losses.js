/** Losses that are set for a motion: the words that they mean, and the sliders that show them. */

import { Problem } from "eulerdisk/notice";

/** @import { LossControl, MotionPlan, MotionTables } from "eulerdisk/types" */

/** @typedef {Record<string, number|string|null>} Words */

const ARMS = ["rolling_friction", "pivoting_friction", "contour_friction"];

/** The law of the air that also needs the density. */
const LAYER = "bildsten";

/**
 * Return the words of a motion with losses, adding air at room temperature and a mass where a law needs them. A mass
 * without any law is not a loss.
 * @param {MotionTables} tables
 * @param {Record<string, number|string>} given  what the controls ask for
 * @returns {Words}  empty without losses
 */
export function lossWords({ no_air, air, mass }, given) {
  if (Object.keys(given).every((name) => name === "mass")) return {};
  /** @type {Words} */
  let words = { air_law: no_air, ...given };
  if (words.air_law !== no_air) words = { air_viscosity: air.air_viscosity, ...words };
  if (words.air_law === LAYER) words = { air_density: air.air_density, ...words };
  return needsMass(no_air, words) ? { mass, ...words } : words;
}

/**
 * @param {string} noAir
 * @param {Words} words
 */
function needsMass(noAir, words) {
  return (words.air_law ?? noAir) !== noAir || Boolean(words.contour_damping);
}

/**
 * Return the words of the losses of a motion: those of the cells, changed by the controls.
 * @param {MotionTables} tables
 * @param {MotionPlan} plan
 * @param {Record<string, number|string>} given
 * @returns {Words}
 */
export function wordsOfMotion(tables, plan, given) {
  const lost = lossWords(tables, given);
  if (!plan.lossy || Object.keys(given).length === 0) return { ...plan.losses, ...lost };
  const none = [null, undefined, 0, tables.no_air];
  const asked = Object.entries(Object.keys(lost).length ? lost : given);
  // add what a law needs where the cells have none of it
  const changed = asked.filter(([name]) => name in given || none.includes(plan.losses[name]));
  const words = { ...plan.losses, ...Object.fromEntries(changed) };
  if (words.air_law === tables.no_air) words.air_viscosity = words.air_density = 0;
  return words;
}

/**
 * Return the numbers that the kernels use for words: a disk without a friction coefficient never slips.
 * @param {Words} words
 * @param {string} name
 */
export function numberOf(words, name) {
  const value = words[name];
  if (typeof value === "number") return value;
  return { mass: 1, friction: Infinity }[name] ?? 0;
}

/** Words whose numbers must be above 0; other losses may be 0. */
const POSITIVE = ["mass", "friction"];

/**
 * Raise an error about anything that is not a loss: an address may contain anything.
 * @param {MotionTables} tables
 * @param {Record<string, number|string>} given
 */
export function checkLosses({ lossy_parameters: known, air_laws: laws }, given) {
  for (const [name, value] of Object.entries(given)) {
    const isLaw = name === "air_law";
    if (!isLaw && !known.includes(name)) refuse(`${name} is not a loss.`);
    if (isLaw && !laws.includes(String(value))) {
      refuse(`air_law must be one of ${laws.join(", ")}; got ${value}.`);
    }
    const isAbove = typeof value === "number" && (POSITIVE.includes(name) ? value > 0 : value >= 0);
    const limit = POSITIVE.includes(name) ? "above 0" : "not below 0";
    if (!isLaw && !isAbove) refuse(`${name} must be a number ${limit}; got ${value}.`);
  }
}

/**
 * @param {string} words
 * @param {string} [hint]
 */
function refuse(words, hint = "Leave it out.") {
  throw new Problem(words, { hint, status: 400 });
}

/**
 * Raise an error about a lever arm as long as the radius: such a disk would not move at all.
 * @param {Words} words
 * @param {number} radius
 */
export function checkArms(words, radius) {
  for (const name of ARMS) {
    if (numberOf(words, name) < radius) continue;
    refuse(
      `A lever arm must be shorter than the radius; got ${name}=${words[name]} radius=${radius}.`,
      "Give a shorter arm; for a coin on glass it is some micrometres, as in 10um.",
    );
  }
}

/**
 * Return the controls of the losses of a motion; empty for a body that rolls on through its poles.
 * @param {MotionTables} tables
 * @param {MotionPlan} plan
 * @param {Record<string, number>} start
 * @param {Record<string, number|string>} given
 * @returns {LossControl[]}
 */
export function lossControls(tables, plan, { radius, gravity }, given) {
  if (plan.body?.poles) return [];
  /** @type {Words} */
  const held = { ...(plan.lossy ? plan.losses : {}), ...given };
  const mass = typeof held.mass === "number" ? held.mass : tables.mass;
  const scales = { one: 1, radius, damping: mass * radius ** 2 * Math.sqrt(gravity / radius) };
  // a body without a face traps no air
  const rows = tables.sliders.filter(({ name }) => name !== "air_law" || (plan.body?.faced ?? true));
  return rows.map(({ scaled, low, high, ...row }) => {
    const value = held[row.name];
    if (row.choices) return { ...row, value: value ?? row.choices[0] };
    const scale = scales[scaled ?? "one"];
    const found = { ...row, low: (low ?? 1) * scale, high: (high ?? 1) * scale };
    const shown = typeof value === "number" && value > 0 ? value : null;
    return row.name === "mass"
      ? { ...found, value: shown, idle: !needsMass(tables.no_air, held) }
      : { ...found, value: shown };
  });
}
