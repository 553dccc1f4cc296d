/** The numbers of the start that is pointed at: at once those of the picture, then those of the exact reduction. */

import { html } from "eulerdisk/html";
import { Latest } from "eulerdisk/latest";
import { parameterOf, verdictWords } from "eulerdisk/state";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").PointAnswer} PointAnswer */
/** @typedef {import("eulerdisk/types").Quantity} Quantity */
/** @typedef {import("eulerdisk/types").Source} Source */
/** @typedef {import("eulerdisk/types").View} View */
/** @typedef {import("eulerdisk/map").Aim} Aim */

/** Milliseconds that the pointer rests before its numbers are asked for. */
const REST = 60;

export class Readout {
  #element;
  #spoken;
  #about;
  #requests;
  #timer = 0;
  /** @type {Aim|null} */
  #aim = null;

  /**
   * @param {HTMLElement} element
   * @param {HTMLElement} spoken  is read aloud when it changes
   * @param {About} about
   * @param {Source} source
   */
  constructor(element, spoken, about, source) {
    this.#element = element;
    this.#spoken = spoken;
    this.#about = about;
    this.#requests = new Latest((/** @type {{view: View, aim: Aim}} */ asked) => this.#ask(source, asked));
    this.show(null);
  }

  /**
   * Show what is pointed at; null for nothing.
   * @param {Aim|null} aim
   * @param {View} [view]
   * @param {Quantity} [quantity]
   */
  show(aim, view, quantity) {
    this.#aim = aim;
    clearTimeout(this.#timer);
    this.#requests.forget();
    if (!aim || !view || !quantity) {
      this.#element.replaceChildren(
        html("p", { class: "quiet" }, "Point at the map for its numbers, click to see the disk roll."),
      );
      return;
    }
    this.#element.replaceChildren(this.#table(this.#rough(aim, view, quantity), ""));
    this.#timer = window.setTimeout(() => this.#requests.ask({ view, aim }), REST);
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
    if (!shown) return rows;
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
    } catch {
      // the window has told what is wrong with the view; the numbers of the picture stay
      return;
    }
    if (this.#aim !== aim) return;
    const exact = /** @type {[string, string][]} */ ([
      ...[view.x.name, view.y.name].map((name) => [
        parameterOf(this.#about, name).label,
        answer.start[name].text,
      ]),
      ["verdict", answer.verdict],
      ...answer.numbers.filter(({ text }) => text).map(({ name, text }) => [name.replaceAll("_", " "), text]),
    ]);
    this.#element.replaceChildren(this.#table(exact, originOf(answer, aim)));
    if (aim.keys) this.#spoken.textContent = exact.map((row) => row.join(" ")).join(", ");
  }

  /**
   * @param {[string, string][]} rows
   * @param {string} origin
   */
  #table(rows, origin) {
    const cells = rows.map(([name, text]) =>
      html("div", {}, html("dt", {}, name), html("dd", { title: text }, printedUnits(text))),
    );
    if (origin) cells.push(html("div", { class: "origin" }, html("dt", {}, "from"), html("dd", {}, origin)));
    return html("dl", {}, ...cells);
  }
}

/**
 * Where the numbers of a point come from, in words; empty where there is only one kind.
 * @param {PointAnswer} answer
 * @param {Aim} aim
 */
function originOf(answer, aim) {
  if (!answer.stored) return "";
  return aim.shown?.stored ? "stored cell" : "computed now";
}
