/** The controls beside the map: what is shown, the axes, and sliders for everything that is no axis. */

import { criterionSlider, parameterSlider, textRow } from "eulerdisk/sliders";
import { html } from "eulerdisk/html";
import { valueAt } from "eulerdisk/axis_window";
import {
  baseOf,
  isFixed,
  parametersOf,
  quantitiesOf,
  withAxis,
  withOtherScale,
  withWord,
  wordOf,
} from "eulerdisk/state";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Line} Line */
/** @typedef {import("eulerdisk/state").State} State */

/** @typedef {(change: (state: State) => State) => void} Change */

/**
 * Controls that are built anew where a base or an axis changes, and otherwise only follow the state.
 */
export class Controls {
  #element;
  #about;
  #change;
  #built = "";
  /** @type {((state: State) => void)[]} */
  #follow = [];

  /**
   * @param {HTMLElement} element
   * @param {About} about
   * @param {Change} change
   */
  constructor(element, about, change) {
    this.#element = element;
    this.#about = about;
    this.#change = change;
  }

  /**
   * @param {State} state
   * @param {Line[]} lines
   */
  show(state, lines) {
    const { base, x, y } = state.view;
    const built = JSON.stringify([base, x.name, y.name, lines.map((line) => line.name + line.label)]);
    if (built !== this.#built) this.#build(state, lines);
    this.#built = built;
    for (const follow of this.#follow) follow(state);
  }

  /**
   * @param {State} state
   * @param {Line[]} lines
   */
  #build(state, lines) {
    const { base } = state.view;
    this.#follow = [];
    const shown = html("fieldset", {}, html("legend", {}, "Shown"), this.#quantity(base), this.#colours());
    if (lines.length) shown.append(this.#lines(lines));
    if (this.#about.atlas) shown.append(this.#stored());
    const names = parametersOf(this.#about, state.view);
    const axes = html("fieldset", {}, html("legend", {}, "Axes"));
    axes.append(this.#axis("x", "across", names), this.#axis("y", "up", names));
    const held = html(
      "fieldset",
      { class: "held" },
      html("legend", {}, "Held fixed"),
      ...this.#sliders(state),
    );
    const focused = document.activeElement?.id;
    this.#element.replaceChildren(held, shown, axes);
    if (focused) document.getElementById(focused)?.focus();
  }

  /** @param {string} base */
  #quantity(base) {
    const choice = html(
      "select",
      {
        id: "quantity",
        change: () => this.#change((state) => ({ ...state, quantity: choice.value, range: null })),
      },
      ...quantitiesOf(this.#about, base).map(({ name, label, description }) =>
        html("option", { value: name, title: description }, label),
      ),
    );
    this.#follow.push((state) => {
      choice.value = state.quantity;
    });
    return html("label", {}, html("span", {}, "colour"), choice);
  }

  #colours() {
    const box = html("input", { type: "checkbox", id: "hold-colours" });
    box.addEventListener("change", () =>
      this.#element.dispatchEvent(new CustomEvent("hold", { detail: box.checked })),
    );
    const label = html("label", { class: "check" }, box, "hold the scale of colours");
    this.#follow.push((state) => {
      box.checked = state.range !== null;
      const { flags } = this.#about.quantities.find(({ name }) => name === state.quantity) ?? { flags: null };
      label.hidden = flags !== null;
    });
    return label;
  }

  /** @param {Line[]} lines */
  #lines(lines) {
    const boxes = lines.map(({ name, label }) => {
      const box = html("input", { type: "checkbox", id: `line-${name}` });
      box.addEventListener("change", () => {
        this.#change((state) => {
          const others = state.hidden.filter((each) => each !== name);
          return { ...state, hidden: box.checked ? others : [...others, name] };
        });
      });
      this.#follow.push((state) => {
        box.checked = !state.hidden.includes(name);
      });
      return html("label", { class: "check" }, box, html("i", { class: `sample ${name}` }), label);
    });
    return html("div", { class: "checks", role: "group", "aria-label": "Boundaries" }, ...boxes);
  }

  #stored() {
    const { atlas } = this.#about;
    const box = html("input", { type: "checkbox", id: "show-stored" });
    box.addEventListener("change", () => this.#change((state) => ({ ...state, stored: box.checked })));
    const label = html("label", { class: "check" }, box, "cells of the file where it has some");
    this.#follow.push((state) => {
      box.checked = state.stored;
      label.hidden = atlas === null || state.view.base !== atlas.base || !atlas.live;
    });
    return html("div", {}, label, html("p", { class: "quiet" }, atlas?.note ?? ""));
  }

  /**
   * @param {"x"|"y"} which
   * @param {string} words
   * @param {import("eulerdisk/types").Parameter[]} parameters
   */
  #axis(which, words, parameters) {
    const about = this.#about;
    const choice = html(
      "select",
      {
        id: `axis-${which}`,
        // the points that were chosen lie in another plane
        change: () =>
          this.#change((state) => ({
            ...state,
            view: withAxis(about, state.view, which, choice.value),
            points: [null, null],
            compare: false,
          })),
      },
      ...parameters.map(({ name, label }) => html("option", { value: name }, label)),
    );
    const log = html("input", { type: "checkbox", id: `log-${which}` });
    log.addEventListener("change", () =>
      this.#change((state) => ({ ...state, view: withOtherScale(state.view, which) })),
    );
    this.#follow.push(({ view }) => {
      choice.value = view[which].name;
      log.checked = view[which].scale === "log";
      choice.disabled = log.disabled = isFixed(about, view);
    });
    const row = html("label", {}, html("span", {}, words), choice);
    return html("div", { class: "axis-row" }, row, html("label", { class: "check" }, log, "log"));
  }

  /** @param {State} state */
  #sliders(state) {
    const { view } = state;
    const about = this.#about;
    /** @param {string} name @returns {(value: number|string) => void} */
    const set = (name) => (value) =>
      this.#change((now) => ({ ...now, view: withWord(about, now.view, name, value) }));
    const base = baseOf(about, view);
    const fixed = isFixed(about, view);
    const rows = [fixed ? textRow("criterion", "criterion") : criterionSlider(about, set("criterion"))];
    for (const parameter of parametersOf(about, view)) {
      const { name, label, low } = parameter;
      if (name === view.x.name || name === view.y.name) continue;
      // an axis of the base that is none now has no word there: it begins in its middle
      const first = base.words[name] ?? middleOf(base.view, name);
      const slides = !fixed && low !== null;
      rows.push(slides ? parameterSlider(parameter, first, set(name)) : textRow(name, label, parameter));
    }
    for (const { name, follow } of rows) {
      this.#follow.push((now) => follow(wordOf(about, now.view, name)));
    }
    return rows.map((row) => row.element);
  }
}

/**
 * @param {import("eulerdisk/types").View} view
 * @param {string} name
 */
function middleOf(view, name) {
  return valueAt(view.x.name === name ? view.x : view.y, 0);
}
