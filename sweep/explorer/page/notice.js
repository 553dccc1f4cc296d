/** What is wrong and what has been done, told in an element, and a button where trying again may help. */

import { html } from "eulerdisk/elements";

/** Something that was asked for and does not come: in words, with what to do, and whether a server answered at all. */
export class Problem extends Error {
  /**
   * @param {string} message
   * @param {{hint?: string, status?: number, unreachable?: boolean, cause?: unknown}} [more]
   */
  constructor(message, { hint = "", status = 0, unreachable = false, cause } = {}) {
    super(message, { cause });
    this.hint = hint;
    this.status = status;
    this.unreachable = unreachable;
  }
}

/** Status from which on a request was in order, and the server could not answer it. */
const FAULT = 500;

/**
 * Whether a request that failed may be answered when it is made once more.
 * @param {{status?: number}} problem
 */
export function mayPass({ status = 0 }) {
  return status >= FAULT;
}

/**
 * Show words in an element, and a button behind them. What is there already stays as it is: a button that is being
 * pressed or has the focus, and words that were read out. Where a button with the focus goes, the map has it next.
 * @param {HTMLElement} element
 * @param {string} words
 * @param {(() => void)|null} [again]  tries once more
 */
export function tell(element, words, again = null) {
  const former = element.querySelector("button");
  const button = again && (former ?? html("button", { type: "button", class: "again" }, "Try again"));
  if (button) button.onclick = again;
  if (former === button && element.firstChild?.textContent === words) return;
  const hadFocus = former !== null && document.activeElement === former;
  element.replaceChildren(...(button ? [words, " ", button] : [words]));
  if (hadFocus) (button ?? document.getElementById("map"))?.focus({ preventScroll: true });
}

/**
 * Tell a problem in an element, with what to do about it.
 * @param {HTMLElement} element
 * @param {unknown} problem
 * @param {(() => void)|null} [again]  tries once more, where that may help
 */
export function tellProblem(element, problem, again = null) {
  tell(element, wordsOfProblem(problem), mayPass(/** @type {Problem} */ (problem)) ? again : null);
}

/**
 * Words of a problem and what to do about it.
 * @param {unknown} problem
 */
export function wordsOfProblem(problem) {
  const { message, hint } = /** @type {Problem} */ (problem);
  return [message, hint].filter(Boolean).join(" ");
}
