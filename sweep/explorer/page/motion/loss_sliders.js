/** The losses of a motion: a slider for each law, one end of which switches the law off. */

import { html, select, shareOnRuler, valueOnRuler } from "eulerdisk/elements";

/** @import { LossControl } from "eulerdisk/types" */

/** Number of steps of a slider, including the end that means no loss. */
const STEPS = 240;

/** Digits of a value that a slider sets. */
const DIGITS = 3;

export class LossSliders {
  /**
   * @param {HTMLElement} element
   * @param {(losses: Record<string, number|string>) => void} changed
   */
  constructor(element, changed) {
    this.element = element;
    this.changed = changed;
    /** @type {Record<string, number|string>} what the controls ask for */
    this.losses = {};
    /** @type {Map<string, (control: LossControl) => void>} */
    this.rows = new Map();
    this.reset = html("button", { type: "button", class: "quiet" }, "no losses");
    this.reset.addEventListener("click", () => this.#set({}));
  }

  /**
   * Show the controls of an answer. They are created once, so that a slider that is being dragged stays.
   * @param {LossControl[]} controls
   */
  show(controls) {
    if (this.rows.size === 0) {
      const made = controls.map((control) =>
        control.choices ? this.#choice(control) : this.#slider(control),
      );
      this.element.replaceChildren(...made, html("p", { class: "buttons" }, this.reset));
    }
    for (const control of controls) this.rows.get(control.name)?.(control);
    controls.forEach(({ idle }, i) => this.element.children[i].toggleAttribute("hidden", Boolean(idle)));
    this.reset.disabled = Object.keys(this.losses).length === 0;
  }

  /** @param {Record<string, number|string>} losses */
  #set(losses) {
    this.losses = losses;
    this.changed(losses);
  }

  /**
   * @param {string} name
   * @param {number|string|null} value
   */
  #setOne(name, value) {
    const others = { ...this.losses };
    delete others[name];
    this.#set(value === null ? others : { ...others, [name]: value });
  }

  /** @param {LossControl} first */
  #slider(first) {
    let control = first;
    const slide = html("input", { type: "range", min: "0", max: String(STEPS), "aria-label": first.label });
    const said = html("output", {});
    const tell = (/** @type {number|null} */ value) => {
      const text =
        value === null ? (control.none ?? "") : spelled(value * (control.factor ?? 1), control.unit ?? "");
      said.textContent = text;
      slide.setAttribute("aria-valuetext", text);
    };
    slide.addEventListener("input", () => {
      const value = valueAt(control, Number(slide.value));
      tell(value);
      this.#setOne(first.name, value);
    });
    this.rows.set(first.name, (next) => {
      control = next;
      // the slider knows its position better than an answer to an earlier position
      const value = this.losses[next.name] ?? next.value;
      slide.value = String(placeOf(control, typeof value === "number" ? value : null));
      tell(typeof value === "number" ? value : null);
    });
    const caption = html(
      "span",
      { class: "caption", title: first.description },
      html("span", {}, first.label),
      said,
    );
    return html("label", { class: "loss" }, caption, slide);
  }

  /** @param {LossControl} control */
  #choice(control) {
    const choices = (control.choices ?? []).map((choice) => ({ value: choice, label: choice }));
    // the first choice means no loss
    const choice = select({ "aria-label": control.label }, choices, (value) =>
      this.#setOne(control.name, value === choices[0].value ? null : value),
    );
    this.rows.set(control.name, (next) => {
      choice.value = String(this.losses[next.name] ?? next.value);
    });
    const words = html("span", {}, control.label);
    return html("label", { class: "loss choice", title: control.description }, words, choice);
  }
}

/**
 * Return the value at a position of a slider; null at the end that means no loss.
 * @param {LossControl} control
 * @param {number} place  from 0 to STEPS
 */
export function valueAt({ low = 1, high = 1, end }, place) {
  const step = end === "high" ? place : place - 1;
  if (step < 0 || step > STEPS - 1) return null;
  const value = valueOnRuler({ low, high, scale: "log" }, step / (STEPS - 1));
  return Number(value.toPrecision(DIGITS));
}

/**
 * @param {LossControl} control
 * @param {number|null} value
 */
export function placeOf({ low = 1, high = 1, end }, value) {
  if (value === null) return end === "high" ? STEPS : 0;
  const share = shareOnRuler({ low, high, scale: "log" }, value);
  return Math.round(share * (STEPS - 1)) + (end === "high" ? 0 : 1);
}

/**
 * @param {number} value
 * @param {string} unit
 */
function spelled(value, unit) {
  return `${Number(value.toPrecision(DIGITS))} ${unit}`.trimEnd();
}
