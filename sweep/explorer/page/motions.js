/** The motions beside the map: that of the first chosen start, and for comparison that of the second one. */

import { html } from "eulerdisk/elements";
import { tell, wordsOfProblem } from "eulerdisk/notice";
import { parameterOf, wordsOf } from "eulerdisk/state";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Place} Place */
/** @typedef {import("eulerdisk/types").Source} Source */
/** @typedef {import("eulerdisk/types").View} View */
/** @typedef {import("eulerdisk/state").State} State */
/** @typedef {import("eulerdisk/state").Point} Point */
/** @typedef {import("eulerdisk/motion/types").MotionSettings} MotionSettings */

/**
 * What a slot tells: that it is closed; what a person has set of its motion.
 * @typedef {object} Told
 * @property {(slot: number) => void} close
 * @property {(slot: number, settings: MotionSettings) => void} set
 */

/**
 * What shows one motion (`MotionPanel` of eulerdisk/motion/panel).
 * @typedef {object} Panel
 * @property {(request: Place) => Promise<void>} show
 * @property {() => void} clear
 * @property {MotionSettings} settings  what a person has set
 */

/** The module that shows motions did not come. */
class NotLoaded extends Error {
  /** @param {unknown} cause */
  constructor(cause) {
    super("The part of this page that shows motions could not be loaded.", { cause });
  }
}

/** One place for a motion: its heading and its panel. */
class Slot {
  #about;
  #source;
  #letter;
  #set;
  #caption = html("p", { class: "quiet" });
  #problem = html("p", { class: "fault", role: "status" });
  #body = html("div", { class: "motion" });
  /** @type {Promise<Panel>|null} */
  #panel = null;
  /** @type {string|null} what is shown; null before anything is */
  #shown = null;
  /** @type {Place|null} what is wanted; what comes for another one is too late */
  #wanted = null;
  /** What is set, as text: what the panel has else is changed to this. */
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
    this.element = html(
      "section",
      { class: "slot", "aria-label": `Motion ${letter}` },
      head,
      this.#problem,
      this.#body,
    );
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
    this.#caption.textContent = point ? this.#words(view, point) : invitation(this.#letter);
    this.#wanted = point && { view, ...point };
    if (this.#wanted) void this.#move(this.#wanted);
    else this.#clear();
  }

  /** Ask for the motion once more. */
  again() {
    if (this.#wanted) void this.#move(this.#wanted);
  }

  /** What makes the motion of this slot again, with the losses that are set in its panel; null without one. */
  async request() {
    if (!this.#wanted) return null;
    const panel = await this.#panel;
    return { ...this.#wanted, losses: panel?.settings.losses ?? {} };
  }

  /** @param {Place} request */
  async #move(request) {
    tell(this.#problem, "");
    try {
      this.#panel ??= this.#make().catch((problem) => {
        // what could not be loaded is loaded anew next time
        this.#panel = null;
        throw problem;
      });
      const panel = await this.#panel;
      if (this.#wanted !== request) return;
      this.#setPanel(panel);
      // the panel drops the motion that it waits for where another one is wanted
      await panel.show(request);
      if (this.#wanted === request) this.element.dataset.shown = JSON.stringify(request);
    } catch (problem) {
      if (this.#wanted === request) this.#tell(/** @type {Error} */ (problem));
    }
  }

  /** @param {Error} problem */
  #tell(problem) {
    const again = problem instanceof NotLoaded ? () => void this.#reload() : null;
    tell(this.#problem, wordsOfProblem(problem), again);
  }

  /** Load the page anew if its server answers: some browsers ask only once for a module. The address keeps all. */
  async #reload() {
    await this.#source.about().then(
      () => location.reload(),
      (problem) => this.#tell(new NotLoaded(problem)),
    );
  }

  #clear() {
    delete this.element.dataset.shown;
    tell(this.#problem, "");
    void this.#panel?.then(
      (panel) => {
        if (this.#wanted) return;
        panel.clear();
        this.#setPanel(panel);
      },
      () => {},
    );
  }

  /** @param {Panel} panel */
  #setPanel(panel) {
    if (JSON.stringify(panel.settings) !== this.#settings) panel.settings = JSON.parse(this.#settings);
  }

  /** @returns {Promise<Panel>} */
  async #make() {
    const { MotionPanel } = await import("eulerdisk/motion/panel").catch((problem) => {
      // it may have come and have a fault, which the console tells
      reportError(problem);
      throw new NotLoaded(problem);
    });
    /** @type {Panel} */
    const panel = new MotionPanel(this.#body, this.#source, () => {
      const settings = JSON.stringify(panel.settings);
      if (settings === this.#settings) return;
      this.#settings = settings;
      this.#set(panel.settings);
    });
    return panel;
  }

  /**
   * @param {View} view
   * @param {Point} point
   */
  #words(view, point) {
    const values = /** @type {const} */ (["x", "y"])
      .map((which) => {
        const { label, factor, unit } = parameterOf(this.#about, view[which].name);
        return `${label} ${readable(point[which] * factor, 7)} ${unit}`.trim();
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
   * What makes a motion again; null where none is shown.
   * @param {number} slot
   */
  request(slot) {
    return this.#slots[slot].request();
  }

  /** Ask for all motions that are shown once more. */
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

/** Load what shows motions, before the first start is chosen. */
export async function loadMotions() {
  await import("eulerdisk/motion/panel");
}

/** @param {string} letter */
function invitation(letter) {
  return letter === "A"
    ? "Click the map: the disk of that start rolls here."
    : "Click the map for a second start.";
}
