/** The controls next to the map: what is shown, the axes, and sliders for every other parameter. */

import { valueAt } from "eulerdisk/axis_window";
import { checkbox, html, select, shareOnRuler, valueOnRuler } from "eulerdisk/elements";
import { lineSample } from "eulerdisk/overlay";
import {
  baseOf,
  isFixed,
  parametersOf,
  quantitiesOf,
  quantityOf,
  withAxis,
  withOtherScale,
  withValue,
  wordOf,
} from "eulerdisk/state";
import { readNumber } from "eulerdisk/number_text";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @import { Ruler } from "eulerdisk/elements" */
/** @import { State } from "eulerdisk/state" */
/** @import { About, Line, Parameter, View } from "eulerdisk/types" */

/** @typedef {(change: (state: State) => State) => void} Change */

/** @type {Record<string, string>} explanations of the lines for new users */
const MEANINGS = {
  analytic: "the analytic line is theory for a vanishing perturbation",
  predicted: "the predicted line is theory for this criterion and this tilt",
  measured: "the measured line separates stable from unstable computed cells",
};

/** Controls that are rebuilt if a base or an axis changes, and otherwise only follow the state. */
export class Controls {
  #element;
  #about;
  #change;
  #range;
  #built = "";
  /** @type {((state: State) => void)[]} */
  #follow = [];

  /**
   * @param {HTMLElement} element
   * @param {About} about
   * @param {Change} change
   * @param {() => [number, number]} range  ends of the present colour scale
   */
  constructor(element, about, change, range) {
    this.#element = element;
    this.#about = about;
    this.#change = change;
    this.#range = range;
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
    const choice = select(
      { id: "quantity" },
      quantitiesOf(this.#about, base).map(({ name, label, description }) => ({
        value: name,
        label,
        title: description,
      })),
      (quantity) => this.#change((state) => ({ ...state, quantity, range: null })),
    );
    this.#follow.push((state) => {
      choice.value = state.quantity;
    });
    return html("label", {}, html("span", {}, "colour"), choice);
  }

  #colours() {
    const { box, label } = checkbox("hold-colours", ["keep the colour range"], (held) =>
      this.#change((state) => ({ ...state, range: held ? this.#range() : null })),
    );
    label.title =
      "Each colour keeps its value while the window moves; otherwise the colours span the visible values.";
    this.#follow.push((state) => {
      box.checked = state.range !== null;
      label.hidden = quantityOf(this.#about, state.quantity).flags !== null;
    });
    return label;
  }

  /** @param {Line[]} lines */
  #lines(lines) {
    const labels = lines.map(({ name, label: words }) => {
      const { box, label } = checkbox(`line-${name}`, [lineSample(name), words], (shown) =>
        this.#change((state) => {
          const others = state.hidden.filter((each) => each !== name);
          return { ...state, hidden: shown ? others : [...others, name] };
        }),
      );
      this.#follow.push((state) => {
        box.checked = !state.hidden.includes(name);
      });
      return label;
    });
    const meanings = lines.flatMap(({ name }) => MEANINGS[name] ?? []).join("; ");
    return html(
      "div",
      {},
      html("div", { class: "checks", role: "group", "aria-label": "Boundaries" }, ...labels),
      html("p", { class: "quiet" }, meanings && `Boundaries of stability: ${meanings}.`),
    );
  }

  #stored() {
    const { atlas } = this.#about;
    const { box, label } = checkbox("show-stored", ["stored cells where the file has some"], (stored) =>
      this.#change((state) => ({ ...state, stored })),
    );
    this.#follow.push((state) => {
      box.checked = state.stored;
      label.hidden = atlas === null || state.view.base !== atlas.base || !atlas.live;
    });
    return html("div", {}, label, html("p", { class: "quiet" }, atlas?.note ?? ""));
  }

  /**
   * @param {"x"|"y"} which
   * @param {string} words
   * @param {Parameter[]} parameters
   */
  #axis(which, words, parameters) {
    const about = this.#about;
    const names = parameters.map(({ name, label }) => ({ value: name, label }));
    const choice = select({ id: `axis-${which}` }, names, (name) =>
      this.#change((state) => ({
        ...state,
        view: withAxis(about, state.view, which, name),
        // the chosen points are in another plane
        points: [null, null],
        compare: false,
      })),
    );
    const { box, label } = checkbox(`log-${which}`, ["log"], () =>
      this.#change((state) => ({ ...state, view: withOtherScale(state.view, which) })),
    );
    this.#follow.push(({ view }) => {
      choice.value = view[which].name;
      box.checked = view[which].scale === "log";
      choice.disabled = box.disabled = isFixed(about, view);
    });
    return html("div", { class: "axis-row" }, html("label", {}, html("span", {}, words), choice), label);
  }

  /** @param {State} state */
  #sliders(state) {
    const { view } = state;
    const about = this.#about;
    /** @param {string} name @returns {(value: number|string) => void} */
    const set = (name) => (value) => this.#change((now) => withValue(about, now, name, value));
    const base = baseOf(about, view);
    const fixed = isFixed(about, view);
    const isText = fixed || about.criteria.length === 0;
    const rows = [isText ? textRow("criterion", "criterion") : criterionSlider(about, set("criterion"))];
    for (const parameter of parametersOf(about, view)) {
      const { name, label, low } = parameter;
      if (name === view.x.name || name === view.y.name) continue;
      // an axis of the base that is no axis now has no word there: start in its middle
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
 * @param {View} view
 * @param {string} name
 */
function middleOf(view, name) {
  return valueAt(view.x.name === name ? view.x : view.y, 0);
}

/**
 * A row of the controls; `follow` shows a value, or undefined if there is none.
 * @typedef {{name: string, element: HTMLElement, follow: (value: number|string|undefined) => void}} Row
 */

/** @typedef {(value: any) => void} SetValue accepts a number in SI units, or a word */

/**
 * The scale of a field; a written number must be above and below the given limits.
 * @typedef {Ruler & {factor: number, unit: string, above?: number|null, below?: number|null}} Scale
 */

/** Largest departure of a tilt, in degrees. */
const HALF_TURN = 180;

/** Number of steps of a slider. */
const STEPS = 1000;

/**
 * Return the slider of a parameter. A double click on its name restores the base's value.
 * @param {Parameter} parameter
 * @param {number|string} first  the base's value
 * @param {SetValue} set
 * @returns {Row}
 */
function parameterSlider(parameter, first, set) {
  const { name, label, description, words } = parameter;
  const ruler = { ...parameter, low: parameter.low ?? 0, high: parameter.high ?? 1 };
  const row = numberRow(name, label, description, ruler, set);
  row.caption.addEventListener("dblclick", () => set(first));
  if (typeof first === "number") return { name, element: row.element, follow: row.follow };
  const choice = select(
    { "aria-label": `${label}: a number or a word`, id: `word-${name}` },
    [{ value: "", label: "number" }, ...words.map((word) => ({ value: word, label: word }))],
    (word) => set(word || (ruler.low + ruler.high) / 2),
  );
  row.caption.after(choice);
  return {
    name,
    element: row.element,
    follow: (value) => {
      choice.value = typeof value === "string" ? value : "";
      row.element.classList.toggle("word", typeof value === "string");
      row.follow(value);
    },
  };
}

/**
 * Return a row for a value that cannot be changed.
 * @param {string} name
 * @param {string} label
 * @param {{factor: number, unit: string}} [shown]
 * @returns {Row}
 */
function textRow(name, label, shown) {
  const text = html("span", { class: "number" });
  return {
    name,
    element: html(
      "div",
      { class: "slider" },
      html("div", { class: "caption" }, html("span", {}, label), text),
    ),
    follow: (value) => {
      const words =
        typeof value === "number" && shown ? `${readable(value * shown.factor, 6)} ${shown.unit}` : value;
      text.textContent = printedUnits(String(words ?? "")).trim();
    },
  };
}

/**
 * Return the slider of the criterion's limit, and the choice of its kind.
 * @param {About} about
 * @param {SetValue} set
 * @returns {Row}
 */
function criterionSlider(about, set) {
  const kinds = about.criteria.map(({ word, description }) => ({
    value: word,
    label: word,
    title: description,
  }));
  const other = { value: "", label: "other" };
  const kind = select({ id: "criterion-kind", "aria-label": "criterion" }, [...kinds, other], (word) => {
    const found = about.criteria.find((each) => each.word === word);
    if (found) set(`${word}:${Number(Math.sqrt(found.low * found.high).toPrecision(2))}${found.unit}`);
  });
  const own = kind.options[kinds.length];
  const text = html("span", { class: "own-criterion" });
  /** @type {Map<string, ReturnType<typeof numberRow>>} */
  const rows = new Map();
  for (const { word, description, unit, low, high } of about.criteria) {
    /** @type {Scale} */
    const ruler = {
      low,
      high,
      scale: "log",
      factor: 1,
      unit,
      above: 0,
      below: unit === "deg" ? HALF_TURN : null,
    };
    const write = (/** @type {number} */ limit) => set(`${word}:${limit}${unit}`);
    rows.set(word, numberRow(`criterion-${word}`, `limit of ${word}`, description, ruler, write));
  }
  const parts = [...rows.values()].map((row) => row.element);
  return {
    name: "criterion",
    element: html("div", { class: "criterion" }, kind, text, ...parts),
    follow: (value) => {
      const [word, limit] = String(value ?? "").split(":");
      const found = rows.get(word);
      kind.value = found ? word : "";
      own.hidden = found !== undefined;
      own.textContent = /^\w+$/.test(word) ? word : "other";
      text.textContent = found ? "" : String(value ?? "");
      for (const row of rows.values()) row.element.hidden = row !== found;
      found?.follow(parseFloat(limit));
    },
  };
}

/**
 * Return a caption, a slider and a field for the exact number.
 * @param {string} name
 * @param {string} label
 * @param {string} description
 * @param {Scale} ruler
 * @param {SetValue} set
 */
function numberRow(name, label, description, ruler, set) {
  const id = `value-${name}`;
  const caption = html("label", { for: id, title: description }, label);
  const field = html("input", {
    id,
    type: "text",
    autocomplete: "off",
    spellcheck: "false",
  });
  const slide = html("input", {
    type: "range",
    id: `slide-${name}`,
    min: "0",
    max: String(STEPS),
    "aria-label": label,
  });
  slide.addEventListener("input", () =>
    set(tidy(valueOnRuler(ruler, Number(slide.value) / STEPS), ruler.factor)),
  );
  field.addEventListener("change", () => {
    const { value, problem } = readNumber(field.value, ruler);
    field.classList.toggle("wrong", problem !== "");
    field.title = refusal.textContent = problem;
    if (value === null) return;
    field.value = String(Number(value.toPrecision(12)));
    set(value / ruler.factor);
  });
  const refusal = html("p", { class: "refusal", role: "status" });
  const number = html(
    "span",
    { class: "number" },
    field,
    html("span", { class: "unit" }, printedUnits(ruler.unit)),
  );
  const element = html(
    "div",
    { class: "slider" },
    html("div", { class: "caption" }, caption, number),
    slide,
    refusal,
  );
  /** @param {number|string|undefined} value */
  const follow = (value) => {
    if (typeof value !== "number" || !Number.isFinite(value)) return;
    // do not change a field while the user writes in it
    const shown = String(Number((value * ruler.factor).toPrecision(12)));
    if (document.activeElement !== field || Number(field.value) !== Number(shown)) field.value = shown;
    slide.value = String(Math.round(shareOnRuler(ruler, value) * STEPS));
    slide.setAttribute("aria-valuetext", `${shown} ${ruler.unit}`);
  };
  return { element, caption, follow };
}

/**
 * Return a value with four displayed digits, so that a slider stops at short numbers.
 * @param {number} value
 * @param {number} factor
 */
function tidy(value, factor) {
  return Number((value * factor).toPrecision(4)) / factor;
}
