/** The choices at the top: what to look at, and the light. */

import { html } from "eulerdisk/html";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/state").State} State */
/** @typedef {import("eulerdisk/controls").Change} Change */

/**
 * Choice of the base. Another one begins anew, but keeps the light and, where it can be shown, the quantity.
 * @param {HTMLElement} element
 * @param {About} about
 * @param {Change} change
 * @returns {(state: State) => void}
 */
export function baseMenu(element, about, change) {
  const others = html(
    "optgroup",
    { label: "Integrated in time (explore an atlas of one)", disabled: true },
    ...about.others.map((name) => html("option", {}, name)),
  );
  others.hidden = about.others.length === 0;
  const choice = html(
    "select",
    { id: "base", "aria-label": "What to look at" },
    ...about.bases.map(({ name, label, description }) =>
      html("option", { value: name, title: description }, label),
    ),
    // what people look for and cannot be chosen is named all the same
    others,
  );
  choice.addEventListener("change", () => {
    change(({ theme, quantity }) => {
      const first = firstState(about, choice.value);
      const has = quantitiesOf(about, choice.value).some(({ name }) => name === quantity);
      return { ...first, theme, quantity: has ? quantity : first.quantity };
    });
  });
  const title = html("p", { class: "quiet" });
  element.append(choice, title);
  choice.hidden = about.bases.length < 2;
  return ({ view }) => {
    choice.value = view.base;
    title.textContent = about.bases.find((each) => each.name === view.base)?.description ?? "";
  };
}

/**
 * Button that goes from the light of the system to the other one, and back.
 * @param {HTMLElement} button
 * @param {Change} change
 * @returns {(state: State) => void}
 */
export function themeButton(button, change) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = (/** @type {State} */ { theme }) => theme === "dark" || (theme === "" && system.matches);
  button.addEventListener("click", () => {
    change((state) => {
      const dark = !isDark(state);
      return { ...state, theme: dark === system.matches ? "" : dark ? "dark" : "light" };
    });
  });
  system.addEventListener("change", () => change((state) => state));
  return (state) => {
    button.textContent = isDark(state) ? "Light" : "Dark";
  };
}
