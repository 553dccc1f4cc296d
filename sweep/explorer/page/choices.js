/** The choices at the top: the base and the theme. */

import { html, select } from "eulerdisk/elements";
import { firstState, quantitiesOf } from "eulerdisk/state";

/** @import { Change } from "eulerdisk/controls" */
/** @import { State } from "eulerdisk/state" */
/** @import { About } from "eulerdisk/types" */

/**
 * Create the choice of the base. Another base starts afresh, but keeps the theme and, if possible, the quantity.
 * @param {HTMLElement} element
 * @param {About} about
 * @param {Change} change
 * @returns {(state: State) => void}
 */
export function baseMenu(element, about, change) {
  const others = html(
    "optgroup",
    { label: "Integrated in time (explore an atlas instead)", disabled: true },
    ...about.others.map((name) => html("option", {}, name)),
  );
  others.hidden = about.others.length === 0;
  const bases = about.bases.map(({ name, label, description }) => ({
    value: name,
    label,
    title: description,
  }));
  const choice = select({ id: "base", "aria-label": "Preset" }, bases, (name) =>
    change(({ theme, quantity }) => {
      const first = firstState(about, name);
      const has = quantitiesOf(about, name).some((each) => each.name === quantity);
      return { ...first, theme, quantity: has ? quantity : first.quantity };
    }),
  );
  // show these presets too, so that people who look for them learn why they cannot be chosen
  choice.append(others);
  const title = html("p", { class: "quiet" });
  element.append(choice, title);
  choice.hidden = about.bases.length < 2;
  return ({ view }) => {
    choice.value = view.base;
    title.textContent = about.bases.find((each) => each.name === view.base)?.description ?? "";
  };
}

/** Whether the system's theme is dark. */
const SYSTEM = matchMedia("(prefers-color-scheme: dark)");

/** @param {State["theme"]} theme */
function isDark(theme) {
  return theme === "dark" || (theme === "" && SYSTEM.matches);
}

/**
 * Apply a theme to the page.
 * @param {State["theme"]} theme
 */
export function showTheme(theme) {
  const { dataset } = document.documentElement;
  const shown = isDark(theme) ? "dark" : "light";
  // observers of the attribute redraw even if it is set to its present value
  if (dataset.theme !== shown) dataset.theme = shown;
}

/**
 * Set up the button that toggles between the system's theme and the other one.
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
