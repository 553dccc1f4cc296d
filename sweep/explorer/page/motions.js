/** The motions next to the map: of the first chosen start, and for comparison of the second one. */

import { html } from "eulerdisk/elements";
import { MotionPanel } from "eulerdisk/motion/panel";
import { parameterOf, wordsOf } from "eulerdisk/state";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @import { About, MotionSettings, Place, Source, View } from "eulerdisk/types" */
/** @import { Point, State } from "eulerdisk/state" */

/**
 * What a slot reports: that it was closed, and the settings of its motion.
 * @typedef {object} Told
 * @property {(slot: number) => void} close
 * @property {(slot: number, settings: MotionSettings) => void} set
 */

/** Digits of the values of a start, as for the numbers of a point. */
const DIGITS = 6;

/** A place for a motion: its heading and its panel. */
class Slot {
  #about;
  #source;
  #letter;
  #caption = html("p", { class: "quiet" });
  #set;
  #body = html("div", {});
  /** @type {MotionPanel|null} created for the first motion */
  #made = null;
  /** @type {string|null} what is shown; null before anything is */
  #shown = null;
  /** @type {Place|null} what is wanted */
  #wanted = null;
  /** The settings as text; if the panel has others, it is updated to these. */
  #settings = "";
  element;

  /**
   * @param {string} letter
   * @param {About} about
   * @param {Source} source
   * @param {() => void} close
   * @param {(settings: MotionSettings) => void} set
   */
  constructor(letter, about, source, close, set) {
    this.#about = about;
    this.#source = source;
    this.#letter = letter;
    this.#set = set;
    const button = html(
      "button",
      { type: "button", class: "plain", "aria-label": `Close ${letter}`, click: close },
      "\u00d7",
    );
    const heading = html("h2", {}, html("span", { class: "letter" }, letter));
    const head = html("header", {}, heading, this.#caption, button);
    this.element = html("section", { class: "slot", "aria-label": `Motion ${letter}` }, head, this.#body);
  }

  /**
   * Show the motion of a start, or that none is chosen.
   * @param {View} view
   * @param {Point|null} point
   * @param {MotionSettings} settings
   */
  show(view, point, settings) {
    this.element.classList.toggle("empty", point === null);
    const key = point ? JSON.stringify(point) + wordsOf(view) : "";
    const wanted = JSON.stringify(settings);
    if (key === this.#shown && wanted === this.#settings) return;
    this.#shown = key;
    this.#settings = wanted;
    this.#caption.textContent = point ? this.#words(view, point) : this.#invitation;
    this.#wanted = point && { view, ...point };
    if (!this.#wanted) {
      delete this.element.dataset.shown;
      this.#made?.clear();
    }
    const panel = this.#wanted ? this.#panel : this.#made;
    if (panel && JSON.stringify(panel.settings) !== wanted) panel.settings = settings;
    this.again();
  }

  /** Request the motion again. */
  again() {
    if (this.#wanted) void this.#move(this.#wanted);
  }

  /**
   * Return the request that repeats the motion of this slot, with the losses set in its panel; null without a motion.
   */
  request() {
    return this.#wanted && { ...this.#wanted, losses: this.#panel.settings.losses };
  }

  get #panel() {
    this.#made ??= new MotionPanel(this.#body, this.#source, () => {
      const settings = JSON.stringify(this.#panel.settings);
      if (settings === this.#settings) return;
      this.#settings = settings;
      this.#set(this.#panel.settings);
    });
    return this.#made;
  }

  /** @param {Place} request */
  async #move(request) {
    // the panel drops the motion that it waits for if another one is wanted
    await this.#panel.show(request);
    if (this.#wanted === request) this.element.dataset.shown = JSON.stringify(request);
  }

  get #invitation() {
    if (this.#letter === "B") return "Click the map for a second start.";
    return "Click the map to show the motion of that start here.";
  }

  /**
   * @param {View} view
   * @param {Point} point
   */
  #words(view, point) {
    const values = /** @type {const} */ (["x", "y"])
      .map((which) => {
        const { label, factor, unit } = parameterOf(this.#about, view[which].name);
        return `${label} ${readable(point[which] * factor, DIGITS)} ${unit}`.trim();
      })
      .map(printedUnits)
      .join(", ");
    return this.#source.cellAt?.(point) ? `cell at ${values}` : values;
  }
}

export class Motions {
  /** @type {Slot[]} */
  #slots;

  /**
   * @param {HTMLElement} element
   * @param {About} about
   * @param {Source} source
   * @param {Told} told
   */
  constructor(element, about, source, told) {
    this.#slots = ["A", "B"].map((letter, slot) => {
      const set = (/** @type {MotionSettings} */ settings) => told.set(slot, settings);
      return new Slot(letter, about, source, () => told.close(slot), set);
    });
    element.append(...this.#slots.map((slot) => slot.element));
  }

  /**
   * Return the request that repeats a motion; null if none is shown.
   * @param {number} slot
   */
  request(slot) {
    return this.#slots[slot].request();
  }

  /**
   * Scroll to a motion that is below the map.
   * @param {number} slot
   * @param {HTMLElement} atlas
   */
  reveal(slot, atlas) {
    const { element } = this.#slots[slot];
    if (element.getBoundingClientRect().top >= atlas.getBoundingClientRect().bottom) element.scrollIntoView();
  }

  /** Request all shown motions again. */
  again() {
    for (const slot of this.#slots) slot.again();
  }

  /** @param {State} state */
  show({ view, points, compare, motions }) {
    this.#slots[0].show(view, points[0], motions[0]);
    this.#slots[1].show(view, compare ? points[1] : null, motions[1]);
    this.#slots[1].element.hidden = !compare;
  }
}
