/** The numbers of the start under the pointer: immediately from the picture, then from the exact reduction. */

import { html } from "eulerdisk/elements";
import { Latest } from "eulerdisk/refresh";
import { baseOf, isFixed, parameterOf, verdictWords } from "eulerdisk/state";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @import { Aim } from "eulerdisk/map" */
/** @import { About, Quantity, Source, View } from "eulerdisk/types" */

/** Milliseconds for which the pointer must rest before its numbers are requested. */
const REST = 60;

/** Text for a place outside the grid of an atlas whose cells cannot be computed. */
const NO_CELL = "No cell here.";

export class Readout {
  #element;
  #spoken;
  #about;
  #requests;
  #timer = 0;
  /** @type {[string, string][]} what is known of the last point without a request */
  #rows = [];
  /** @type {string[]} names of the numbers of the last point, in their order */
  #names = [];
  #plane = "";
  /** @type {Aim|null} */
  #aim = null;

  /**
   * @param {HTMLElement} element
   * @param {HTMLElement} spoken  screen readers read it aloud when it changes
   * @param {About} about
   * @param {Source} source
   */
  constructor(element, spoken, about, source) {
    this.#element = element;
    this.#spoken = spoken;
    this.#about = about;
    this.#requests = new Latest((/** @type {{view: View, aim: Aim}} */ asked) => this.#ask(source, asked));
    this.#invite();
  }

  /**
   * Show the numbers of the start under the pointer.
   * @param {Aim} aim
   * @param {View} view
   * @param {Quantity} quantity
   */
  show(aim, view, quantity) {
    this.#aim = aim;
    this.#plane = planeOf(view);
    clearTimeout(this.#timer);
    this.#requests.forget();
    const known = this.#rough(aim, view, quantity);
    this.#rows = known;
    if (aim.shown?.origin === "none" && isFixed(this.#about, view)) {
      this.#tell(NO_CELL, aim);
      return;
    }
    // reserve the places of numbers that are still to come
    const others = this.#names.filter((name) => !known.some((row) => row[0] === name));
    this.#fill([...known, ...others.map((name) => /** @type {[string, string]} */ ([name, "\u2026"]))], "");
    this.#timer = window.setTimeout(() => this.#requests.ask({ view, aim }), REST);
  }

  /**
   * Show the numbers of the same start with other words of the view, if there is a start.
   * @param {View} view
   */
  follow(view) {
    if (!this.#aim) return;
    if (planeOf(view) !== this.#plane) {
      this.#invite();
      return;
    }
    this.#aim = { ...this.#aim, shown: null, keys: false };
    this.#requests.ask({ view, aim: this.#aim });
  }

  /** Say what the user can do, until the pointer has been on the map. */
  #invite() {
    this.#aim = null;
    const words =
      "Point at the map for numbers; click for a motion. Use the wheel or pinch to zoom. Drag to move the map: one finger sideways, two fingers in any direction.";
    this.#element.replaceChildren(html("p", { class: "quiet" }, words));
  }

  /**
   * @param {Aim} aim
   * @param {View} view
   * @param {Quantity} quantity
   * @returns {[string, string][]}
   */
  #rough({ point, shown }, view, quantity) {
    /** @type {[string, string][]} */
    const rows = /** @type {const} */ (["x", "y"]).map((which) => {
      const { label, factor, unit } = parameterOf(this.#about, view[which].name);
      return [label, `${readable(point[which] * factor, 6)} ${unit}`.trim()];
    });
    if (!shown || shown.origin === "none") return rows;
    const { value } = shown;
    const words =
      quantity.flags?.[String(value)] ?? `${readable(value * quantity.factor, 4)} ${quantity.unit}`.trim();
    rows.push([quantity.label, words]);
    if (quantity.name !== "stability") {
      rows.push(["verdict", verdictWords(this.#about, shown.verdict)]);
    }
    return rows;
  }

  /**
   * @param {Source} source
   * @param {{view: View, aim: Aim}} asked
   */
  async #ask(source, { view, aim }) {
    let answer;
    try {
      answer = await source.point({ view, ...aim.point });
    } catch (problem) {
      const { message, unreachable } = /** @type {Error & {unreachable?: boolean}} */ (problem);
      // the notice below the map reports that the server does not answer
      if (this.#aim === aim) this.#tell(unreachable ? "" : message, aim);
      return;
    }
    if (this.#aim !== aim) return;
    if (answer.note) {
      this.#tell(answer.note, aim);
      return;
    }
    // where nothing can be computed, the numbers are those of the cell
    const isStored = answer.stored !== null && (aim.shown?.origin === "stored" || isFixed(this.#about, view));
    const cell = isStored && answer.stored ? answer.stored : answer;
    const exact = /** @type {[string, string][]} */ ([
      ...[view.x.name, view.y.name].map((name) => [
        parameterOf(this.#about, name).label,
        cell.start[name].text,
      ]),
      ["verdict", cell.verdict],
      ...cell.numbers.filter(({ text }) => text).map(({ name, text }) => [name.replaceAll("_", " "), text]),
    ]);
    // the motion next to it may have losses; these numbers have none
    const computed = baseOf(this.#about, view).rolls ? "computed, without losses" : "computed";
    const origin = isStored ? "stored cell" : computed;
    this.#names = exact.map(([name]) => name);
    this.#fill(exact, origin);
    if (aim.keys) this.#spoken.textContent = exact.map((row) => row.join(" ")).join(", ");
  }

  /**
   * Show what is known of a point that has no numbers, and say why.
   * @param {string} words
   * @param {Aim} aim
   */
  #tell(words, aim) {
    this.#fill(this.#rows, "");
    if (!words) return;
    this.#element.append(html("p", { class: "quiet" }, words));
    if (aim.keys) this.#spoken.textContent = [...this.#rows.map((row) => row.join(" ")), words].join(", ");
  }

  /**
   * @param {[string, string][]} rows
   * @param {string} origin
   */
  #fill(rows, origin) {
    const place = (/** @type {string} */ name) => this.#names.indexOf(name);
    const ordered = this.#names.length
      ? rows.toSorted((one, other) => place(one[0]) - place(other[0]))
      : rows;
    const cells = ordered.map(([name, text]) =>
      html("div", {}, html("dt", {}, name), html("dd", { title: text }, printedUnits(text))),
    );
    if (origin) cells.push(html("div", { class: "origin" }, html("dt", {}, "from"), html("dd", {}, origin)));
    this.#element.replaceChildren(html("dl", {}, ...cells));
  }
}

/**
 * Return which two parameters the values of a start belong to.
 * @param {View} view
 */
function planeOf({ base, x, y }) {
  return [base, x.name, y.name].join();
}
