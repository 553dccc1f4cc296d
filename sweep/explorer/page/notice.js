/** The line below the map: what is wrong, what has been done, and a button where trying again may help. */

import { html } from "eulerdisk/elements";

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
 * Words of a problem and what to do about it.
 * @param {{message: string, hint?: string}} problem
 */
export function wordsOfProblem({ message, hint }) {
  return [message, hint].filter(Boolean).join(" ");
}
