/** Reports of problems and of completed actions in an element, with a button where trying again may help. */

import { html } from "eulerdisk/elements";

/** A request that failed: a message, a hint, and whether a server answered at all. */
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

/** Status from which on the request was valid, but the server could not answer it. */
const FAULT = 500;

/**
 * Return whether a failed request may succeed if it is repeated.
 * @param {{status?: number}} problem
 */
export function mayPass({ status = 0 }) {
  return status >= FAULT;
}

/**
 * Show text in an element, followed by a button. Unchanged parts are kept: a button that is being pressed or has the
 * focus, and text that was read out. If a focused button disappears, the map gets the focus.
 * @param {HTMLElement} element
 * @param {string} words
 * @param {(() => void)|null} [again]  repeats the attempt
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
 * Report a problem in an element, with a hint what to do about it.
 * @param {HTMLElement} element
 * @param {unknown} problem
 * @param {(() => void)|null} [again]  repeats the attempt, where that may help
 */
export function tellProblem(element, problem, again = null) {
  tell(element, wordsOfProblem(problem), mayPass(/** @type {Problem} */ (problem)) ? again : null);
}

/**
 * Return the text of a problem and its hint.
 * @param {unknown} problem
 */
export function wordsOfProblem(problem) {
  const { message, hint } = /** @type {Problem} */ (problem);
  return [message, hint].filter(Boolean).join(" ");
}
