/** The plans of a page without a server: those of the exported view, changed by numbers. */

import { Problem } from "eulerdisk/notice";
import { baseOf } from "eulerdisk/state";

/** @import { About, BodyPlan, Plan, Plans, View } from "eulerdisk/types" */

/** Kinds of rates (kernels/page/starts.py). */
const GIVEN = 0;
const STEADY = 3;
const WOBBLE = 4;

const MOMENTS = ["axial_moment", "transverse_moment"];

const RATES = ["precession_rate", "roll_rate"];

const HINT =
  "Use eulerdisk explore, which accepts all words; this page has a fixed criterion and accepts only numbers.";

/**
 * Return the plans of a view of the exported base.
 * @param {About} about
 * @param {Plans} plans
 * @param {View} view
 * @returns {Plans}
 * @throws {Problem} if the view has words that need other plans
 */
export function plansWith(about, plans, view) {
  const { words } = baseOf(about, view);
  /** @type {Record<string, number>} */
  const numbers = {};
  for (const [name, value] of Object.entries(view.words)) {
    if (typeof value === "number") numbers[name] = value;
    else if (value !== words[name]) throw refused(`This page does not know ${name}=${value}.`);
  }
  const given = [...Object.keys(numbers), view.x.name, view.y.name];
  const changed = (/** @type {Plan|null} */ plan) => plan && planWith(plan, numbers, given);
  const { motion } = plans;
  const fallTilt = numbers.fall_tilt ?? motion?.fall_tilt;
  return {
    ...plans,
    cells: changed(plans.cells),
    lossy: changed(plans.lossy),
    disk: changed(plans.disk),
    motion: motion && { ...motion, fall_tilt: fallTilt ?? motion.fall_tilt },
  };
}

/**
 * @param {Plan} plan
 * @param {Record<string, number>} numbers
 * @param {string[]} given  parameters that are numbers, or axes
 * @returns {Plan}
 */
function planWith(plan, numbers, given) {
  if ("system" in plan) {
    const other = Object.keys(numbers).find((name) => !plan.parameters.includes(name));
    if (other) throw refused(`This page does not know ${other}=${numbers[other]}.`);
    return { ...plan, held: { ...plan.held, ...numbers } };
  }
  const rates = RATES.map((name, i) => (given.includes(name) ? GIVEN : plan.rates[i]));
  const held = { ...plan.held, ...numbers };
  const [precession, roll] = rates;
  if (precession === WOBBLE && roll !== WOBBLE) {
    throw refused(
      "precession_rate=wobble is the rate of a disk whose centre rests; it needs roll_rate=wobble.",
    );
  }
  if (roll === STEADY && held.precession_rate === 0 && "precession_rate" in numbers) {
    throw refused(
      "No roll rate keeps the tilt constant without precession.",
      "Give another precession rate.",
    );
  }
  const isCircling = precession !== GIVEN || roll === STEADY;
  const fall_tilt = numbers.fall_tilt ?? plan.settings.fall_tilt;
  const found = { ...plan, held, rates, from_start: isCircling, settings: { ...plan.settings, fall_tilt } };
  return "body" in plan ? withMoments(/** @type {BodyPlan} */ (found), given) : found;
}

/**
 * Return a body whose moments are numbers where these are given.
 * @param {BodyPlan} plan
 * @param {string[]} given
 * @returns {BodyPlan}
 */
function withMoments(plan, given) {
  const follows = plan.body.follows.map((each, i) => (given.includes(MOMENTS[i]) ? GIVEN : each));
  return { ...plan, body: { ...plan.body, follows } };
}

/**
 * @param {string} words
 * @param {string} [hint]
 */
function refused(words, hint = HINT) {
  return new Problem(words, { hint, status: 400 });
}
