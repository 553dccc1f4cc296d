/**
 * The source of the page's numbers while a server on this machine answers. The server turns words into plans, has the
 * cells of a file and the lines of theory, and computes windows that would take the page much longer; the page computes
 * the rest.
 */

import { Computation } from "eulerdisk/compute/computation";
import { Computing } from "eulerdisk/compute/source";
import { Problem } from "eulerdisk/notice";
import { wordsOf } from "eulerdisk/state";

/** @import { About, DataRequest, Line, MotionRequest, Place, Plans, PointAnswer, Source, View, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/**
 * Return head and arrays of a binary answer, which contains a length, JSON, and the arrays that the JSON lists.
 * @param {ArrayBuffer} buffer
 * @returns {{head: any, arrays: Record<string, any>}}
 */
export function unpacked(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  /** @type {Record<string, any>} */
  const arrays = {};
  let from = 4 + length;
  for (const { name, type, count } of head.arrays) {
    const Type = { f4: Float32Array, f8: Float64Array, u1: Uint8Array, i4: Int32Array }[
      /** @type {"f4"} */ (type)
    ];
    const bytes = count * Type.BYTES_PER_ELEMENT;
    // an array that does not begin at a multiple of its element size must be copied
    arrays[name] = new Type(
      from % Type.BYTES_PER_ELEMENT ? buffer.slice(from, from + bytes) : buffer,
      from % Type.BYTES_PER_ELEMENT ? 0 : from,
      count,
    );
    from += bytes;
  }
  return { head, arrays };
}

/** Number of views whose plans are cached. */
const MOST_PLANS = 32;

/** @implements {Source} */
export class ServerSource {
  cellAt = null;
  reach = new Reach();
  #computing;
  /** @type {Promise<About>|null} */
  #about = null;
  /** @type {Map<string, Promise<Plans>>} */
  #plans = new Map();

  constructor() {
    const content = fetch("./page/kernels.wasm").then((answer) => answer.arrayBuffer());
    const stored = {
      window: (/** @type {WindowRequest} */ request, /** @type {AbortSignal=} */ signal) =>
        this.#storedWindow(request, signal),
      point: (/** @type {Place} */ place, /** @type {AbortSignal=} */ signal) =>
        this.#storedPoint(place, signal),
    };
    const plansOf = (/** @type {View} */ view) => this.#plansOf(view);
    const program = (/** @type {WindowRequest} */ request, /** @type {AbortSignal=} */ signal) =>
      this.#computedWindow(request, signal);
    this.#computing = new Computing(new Computation(content), () => this.about(), plansOf, stored, program);
  }

  /** @returns {Promise<About>} */
  async about() {
    this.#about ??= this.#ask("about");
    this.#about.catch(() => (this.#about = null));
    return this.#about;
  }

  /**
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   */
  async window(request, signal) {
    return this.#computing.window(request, signal);
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
   * Return the server's plans for the words of a view, which are the same for every window.
   * @param {View} view
   */
  #plansOf(view) {
    const key = wordsOf(view);
    const known = this.#plans.get(key);
    if (known) return known;
    /** @type {Promise<Plans>} */
    const asked = this.#ask("plan", { view });
    // a refused plan may be requested again
    asked.catch(() => this.#plans.delete(key));
    this.#plans.set(key, asked);
    if (this.#plans.size > MOST_PLANS) {
      this.#plans.delete(/** @type {string} */ (this.#plans.keys().next().value));
    }
    return asked;
  }

  /**
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<WindowAnswer|null>}
   */
  async #storedWindow(request, signal) {
    if (!(await this.#hasCells(request.view))) return null;
    const { head, arrays } = await this.#ask("window", request, signal);
    const { width, height } = request;
    return arrays ? { head, width, height, ...arrays } : null;
  }

  /**
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<WindowAnswer>}
   */
  async #computedWindow(request, signal) {
    const began = performance.now();
    const { head, arrays } = await this.#ask("cells", request, signal);
    const { width, height } = request;
    const { value, verdict } = arrays;
    return { head, width, height, value, verdict, stored: null, milliseconds: performance.now() - began };
  }

  /**
   * @param {Place} place
   * @param {AbortSignal} [signal]
   * @returns {Promise<PointAnswer|null>}
   */
  async #storedPoint({ view, x, y }, signal) {
    if (!(await this.#hasCells(view))) return null;
    return (await this.#ask("point", { view, x, y }, signal)).stored;
  }

  /** @param {View} view */
  async #hasCells({ base }) {
    return (await this.about()).atlas?.base === base;
  }

  /**
   * @param {View} view
   * @returns {Promise<Line[]>}
   */
  async lines(view) {
    return (await this.#ask("lines", { view })).lines;
  }

  /** @param {Place} place */
  async explain(place) {
    return (await this.#ask("explain", place)).text;
  }

  /** @param {object} request */
  async command(request) {
    return this.#ask("command", request);
  }

  /** @param {DataRequest} request */
  async data(request) {
    const answer = await this.#answer("data", request);
    const named = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "");
    return { blob: await this.reach.of(answer.blob()), name: named?.[1] ?? "window" };
  }

  /**
   * Return the server's answer: an object, or head and arrays.
   * @param {string} what
   * @param {object} [question]
   * @param {AbortSignal} [signal]
   * @returns {Promise<any>}
   */
  async #ask(what, question, signal) {
    const answer = await this.#answer(what, question, signal);
    const isJson = answer.headers.get("Content-Type") === "application/json";
    return this.reach.of(isJson ? answer.json() : answer.arrayBuffer().then(unpacked), signal);
  }

  /**
   * @param {string} what
   * @param {object} [question]
   * @param {AbortSignal} [signal]
   */
  async #answer(what, question, signal) {
    const posted = {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(question),
    };
    const answer = await this.reach.of(fetch(`./${what}`, { ...(question && posted), signal }), signal);
    if (answer.ok) return answer;
    const body = await answer.json().catch(() => ({}));
    const { status } = answer;
    throw new Problem(body.error ?? `The server answered with status ${status}.`, { ...body, status });
  }
}

/** Milliseconds before a server that did not answer is asked again. */
const AGAIN = 2000;

/** Status of a request without the server's token. */
const REFUSED = 403;

const LOST = "The explorer does not answer: the process that served this page has probably ended.";
const LOST_HINT =
  "Start eulerdisk explore again, open the address that it prints, and append the part of this address from # on. " +
  "If it is still running, this page continues as soon as it answers.";

/** Another process answers at the server's address. */
const REPLACED = "The explorer was restarted and has a new address.";
const REPLACED_HINT =
  "Open the address that it printed; append the part of this address from # on to see the same view there.";

export class Reach {
  /** @type {(problem: Problem) => void} called when the server stops answering */
  onLost = () => {};
  /** Called when the server answers again. */
  onBack = () => {};
  #waiting = false;

  /**
   * Return the result of a fetch, or of reading its body.
   * @template Found
   * @param {Promise<Found>} promise
   * @param {AbortSignal} [signal]
   * @returns {Promise<Found>}
   * @throws {Problem} if the server does not answer
   */
  async of(promise, signal) {
    try {
      return await promise;
    } catch (problem) {
      // fetch reports a network error as a TypeError, and an abort by the page as another error
      if (signal?.aborted || !(problem instanceof TypeError)) throw problem;
      const lost = new Problem(LOST, { hint: LOST_HINT, unreachable: true });
      if (!this.#waiting) this.onLost(lost);
      this.#askAgain();
      throw lost;
    }
  }

  #askAgain() {
    if (this.#waiting) return;
    this.#waiting = true;
    setTimeout(async () => {
      const answer = await fetch("./about").catch(() => null);
      this.#waiting = false;
      // 'too many requests' and a bug come from the same server, but a different server refuses this page's token
      if (answer?.ok) this.onBack();
      else if (answer?.status === REFUSED) this.onLost(new Problem(REPLACED, { hint: REPLACED_HINT }));
      else this.#askAgain();
    }, AGAIN);
  }
}
