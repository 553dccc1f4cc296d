/**
 * The source of the numbers of an exported page: it computes them, and has the cells of an atlas if the page contains
 * one.
 */

import { between } from "eulerdisk/axis_window";
import { wordsOfCell } from "eulerdisk/cell_words";
import { Computation } from "eulerdisk/compute/computation";
import { plansWith } from "eulerdisk/compute/plans";
import { Computing } from "eulerdisk/compute/source";
import { Problem } from "eulerdisk/notice";
import { baseOf, isFixed, parameterOf } from "eulerdisk/state";
import { unpackedArray } from "eulerdisk/packed";
import { StoredCells } from "eulerdisk/stored_cells";

/** @import { About, Line, MotionRequest, Place, Source, StoredPage, View, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/**
 * Narrowest window with lines, relative to the exported one: their points are a pixel apart there, so the straight
 * pieces between them would become visible.
 */
const NARROWEST = 1 / 16;

const LINES_HIDDEN =
  "The lines of theory belong to the exported window and its words; they are not shown here.";

const WORDS_HIDDEN = "This text is about the motion without the losses that are set next to it.";

/** The hint if the contents of the page cannot be read. */
const UNREADABLE =
  "The file is damaged, or this browser is too old: export the page again, or open it in a newer browser.";

/** @implements {Source} */
export class PageSource {
  command = null;
  data = null;
  reach = null;
  cellAt;
  #page;
  #computing;

  /**
   * @param {StoredPage} page
   * @param {StoredCells|null} stored
   * @param {Computation} computation
   */
  constructor(page, stored, computation) {
    this.#page = page;
    const plansOf = async (/** @type {View} */ view) => plansWith(page.about, page.plans, view);
    this.#computing = new Computing(computation, () => this.about(), plansOf, stored);
    // where nothing can be computed, everything shown for a point belongs to its cell
    const cellAt = (/** @type {{x: number, y: number}} */ point) => {
      const cell = stored?.at(point);
      return cell ? { x: cell.x, y: cell.y } : null;
    };
    this.cellAt = stored && !page.plans.cells ? cellAt : null;
  }

  /**
   * Return the source for the contents of a page.
   * @param {string} text  JSON
   * @param {string} kernels  the module of WebAssembly, packed
   * @throws {Problem}
   */
  static async read(text, kernels) {
    try {
      const page = JSON.parse(text);
      const module = unpackedArray({ type: "u1", data: kernels });
      const computation = new Computation(/** @type {Promise<any>} */ (module));
      return new PageSource(page, await StoredCells.read(page), computation);
    } catch (cause) {
      const words = `The cells in this page cannot be read: ${/** @type {Error} */ (cause)?.message ?? cause}.`;
      throw new Problem(words, { hint: UNREADABLE, cause });
    }
  }

  /** @returns {Promise<About>} */
  async about() {
    return this.#page.about;
  }

  /**
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<WindowAnswer>}
   */
  async window(request, signal) {
    const answer = await this.#computing.window(request, signal);
    const { head } = answer;
    return head.note || this.#holdsLines(request.view)
      ? answer
      : { ...answer, head: { ...head, note: LINES_HIDDEN } };
  }

  /** @param {View} view */
  async lines(view) {
    return this.#holdsLines(view) ? this.#page.lines : [];
  }

  /**
   * Return whether the lines of the page belong to a view: with the same words, and within the exported window.
   * @param {View} view
   */
  #holdsLines(view) {
    const { about, lines } = this.#page;
    if (lines.length === 0 || isFixed(about, view)) return true;
    const base = baseOf(about, view).view;
    return /** @type {const} */ (["x", "y"]).every((which) => {
      const place = between(view[which], base[which]);
      const isInside = place !== null && Math.abs(place[1]) + place[0] <= 1 + 1e-9 && place[0] >= NARROWEST;
      return isInside && Object.keys(view.words).length === 0;
    });
  }

  /**
   * @param {Place} place
   * @param {AbortSignal} [signal]
   */
  async point(place, signal) {
    return this.#computing.point(place, signal);
  }

  /**
   * @param {MotionRequest} request
   * @param {AbortSignal} [signal]
   */
  async motion(request, signal) {
    return this.#computing.motion(request, signal);
  }

  /**
   * @param {Place} place
   * @returns {Promise<string>}
   */
  async explain(place) {
    const { about, plans } = this.#page;
    if (Object.keys(place.losses ?? {}).length) return WORDS_HIDDEN;
    const numbers = await this.point(place);
    if (numbers.note) return numbers.note;
    const { view } = place;
    const criterion = plans.cells?.criterion.text ?? String(baseOf(about, view).words.criterion ?? "");
    const sides = { x: parameterOf(about, view.x.name), y: parameterOf(about, view.y.name) };
    /** @type {Line[]} */
    const lines = await this.lines(view);
    return wordsOfCell({ sides, numbers, lines, criterion });
  }
}
