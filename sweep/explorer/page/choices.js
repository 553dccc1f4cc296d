/** The choices at the top: what to look at, and the light. */

import { html, select } from "eulerdisk/elements";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @import { Change } from "eulerdisk/controls" */
/** @import { State } from "eulerdisk/state" */
/** @import { About } from "eulerdisk/types" */

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
  const bases = about.bases.map(({ name, label, description }) => ({
    value: name,
    label,
    title: description,
  }));
  const choice = select({ id: "base", "aria-label": "What to look at" }, bases, (name) =>
    change(({ theme, quantity }) => {
      const first = firstState(about, name);
      const has = quantitiesOf(about, name).some((each) => each.name === quantity);
      return { ...first, theme, quantity: has ? quantity : first.quantity };
    }),
  );
  // what people look for and cannot be chosen is named all the same
  choice.append(others);
  const title = html("p", { class: "quiet" });
  element.append(choice, title);
  choice.hidden = about.bases.length < 2;
  return ({ view }) => {
    choice.value = view.base;
    title.textContent = about.bases.find((each) => each.name === view.base)?.description ?? "";
  };
}

/** Whether the system is dark. */
const SYSTEM = matchMedia("(prefers-color-scheme: dark)");

/** @param {State["theme"]} theme */
function isDark(theme) {
  return theme === "dark" || (theme === "" && SYSTEM.matches);
}

/**
 * Give the page its light.
 * @param {State["theme"]} theme
 */
export function showTheme(theme) {
  const { dataset } = document.documentElement;
  const shown = isDark(theme) ? "dark" : "light";
  // observers of the attribute draw anew even where it is set to its former value
  if (dataset.theme !== shown) dataset.theme = shown;
}

/**
 * Button that goes from the light of the system to the other one, and back.
 * @param {HTMLElement} button
 * @param {Change} change
 * @returns {(state: State) => void}
 */
export function themeButton(button, change) {
  button.addEventListener("click", () => {
    change((state) => {
      const dark = !isDark(state.theme);
      return { ...state, theme: dark === SYSTEM.matches ? "" : dark ? "dark" : "light" };
    });
  });
  SYSTEM.addEventListener("change", () => change((state) => state));
  return (state) => {
    button.textContent = isDark(state.theme) ? "Light" : "Dark";
  };
}
