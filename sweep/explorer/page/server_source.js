/** Where the page gets its numbers from while a server of this machine answers. */

/** @import { DataRequest, Place, Source, View, WindowAnswer, WindowRequest } from "eulerdisk/types" */

/** A request that the server refused, in its words. */
class Refused extends Error {
  /**
   * @param {number} status
   * @param {{error?: string, hint?: string, where?: string}} body
   */
  constructor(status, body) {
    super(body.error ?? `The server answered with status ${status}.`);
    this.status = status;
    this.hint = body.hint ?? "";
    this.where = body.where ?? "";
  }

  /** Whether a newer request has taken the place of this one. */
  get superseded() {
    return this.status === 410;
  }
}

/**
 * Head and arrays of a binary answer: a length, JSON, and the arrays that it lists.
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
    // an array that does not begin at a multiple of its size must be copied
    arrays[name] = new Type(
      from % Type.BYTES_PER_ELEMENT ? buffer.slice(from, from + bytes) : buffer,
      from % Type.BYTES_PER_ELEMENT ? 0 : from,
      count,
    );
    from += bytes;
  }
  return { head, arrays };
}

/** @implements {Source} */
export class ServerSource {
  live = true;
  cellAt = null;
  reach = new Reach();
  /** Numbers of requests of this page; the server drops a window when a newer one of its lane has come. */
  #number = 0;
  #client = crypto.randomUUID();

  async about() {
    const answer = await this.reach.of(fetch("./about"));
    if (!answer.ok) throw await refusal(answer);
    const about = await this.reach.of(answer.json());
    this.live = about.atlas === null || about.atlas.live;
    return about;
  }

  /**
   * @param {WindowRequest} request
   * @param {AbortSignal} [signal]
   * @returns {Promise<WindowAnswer>}
   */
  async window(request, signal) {
    this.#number += 1;
    const asked = { ...request, client: this.#client, number: this.#number };
    const { head, arrays } = unpacked(await this.#bytes("window", asked, signal));
    const { width, height } = request;
    return {
      head,
      width,
      height,
      value: arrays.value,
      verdict: arrays.verdict,
      stored: arrays.stored ?? null,
    };
  }

  /**
   * @param {View} view
   * @param {AbortSignal} [signal]
   */
  async lines(view, signal) {
    return (await this.#json("lines", { view }, signal)).lines;
  }

  /**
   * @param {Place} place
   * @param {AbortSignal} [signal]
   */
  async point(place, signal) {
    return this.#json("point", place, signal);
  }

  /**
   * @param {object} request
   * @param {AbortSignal} [signal]
   */
  async motion(request, signal) {
    const answer = await this.#ask("motion", request, signal);
    // a start without a motion is answered in words
    if (answer.headers.get("Content-Type") === "application/json") {
      throw new Refused(400, await this.reach.of(answer.json(), signal));
    }
    return unpacked(await this.reach.of(answer.arrayBuffer(), signal));
  }

  /** @param {Place} place */
  async explain(place) {
    return (await this.#json("explain", place)).text;
  }

  /** @param {object} request */
  async command(request) {
    return this.#json("command", request);
  }

  /** @param {DataRequest} request */
  async data(request) {
    const answer = await this.#ask("data", request);
    const named = /filename="([^"]+)"/.exec(answer.headers.get("Content-Disposition") ?? "");
    return {
      blob: await this.reach.of(answer.blob()),
      name: named ? named[1] : `window.${request.format === "csv" ? "csv" : "nc"}`,
    };
  }

  /**
   * @param {string} what
   * @param {object} body
   * @param {AbortSignal} [signal]
   */
  async #json(what, body, signal) {
    return this.reach.of((await this.#ask(what, body, signal)).json(), signal);
  }

  /**
   * @param {string} what
   * @param {object} body
   * @param {AbortSignal} [signal]
   */
  async #bytes(what, body, signal) {
    return this.reach.of((await this.#ask(what, body, signal)).arrayBuffer(), signal);
  }

  /**
   * @param {string} what
   * @param {object} body
   * @param {AbortSignal} [signal]
   */
  async #ask(what, body, signal) {
    const headers = { "Content-Type": "application/json" };
    const asked = { method: "POST", headers, body: JSON.stringify(body), signal };
    const answer = await this.reach.of(fetch(`./${what}`, asked), signal);
    if (!answer.ok) throw await refusal(answer);
    return answer;
  }
}

/** @param {Response} answer */
async function refusal(answer) {
  const body = await answer.json().catch(() => ({}));
  return new Refused(answer.status, body);
}

/** Milliseconds until a server that did not answer is asked again: at first, and at most. */
const [SOON, LATE] = [1000, 15_000];

/** Status of an address without the token of the server. */
const REFUSED = 403;

/** The server did not answer at all. */
class Unreachable extends Error {
  unreachable = true;
  hint =
    "Start eulerdisk explore again, and put what stands behind the # of this address behind the address that it prints. " +
    "If it still runs, this page goes on by itself as soon as it answers.";

  constructor() {
    super("The explorer does not answer: the process that served this page has probably ended.");
  }
}

/** Another process answers at the address of the server. */
class Replaced extends Error {
  hint =
    "Open the address that it printed; what stands behind the # of this address shows the same view there.";

  constructor() {
    super("The explorer was started anew, and has another address.");
  }
}

export class Reach {
  /** @type {(problem: Error) => void} is told that the server does not answer */
  onLost = () => {};
  /** Is told that it answers again. */
  onBack = () => {};
  #waiting = false;
  /** Milliseconds until the server is asked again. */
  #wait = SOON;
  /** When it answered again last. */
  #back = -Infinity;

  /**
   * What a promise of fetch, or of the body of its answer, comes to.
   * @template Found
   * @param {Promise<Found>} promise
   * @param {AbortSignal} [signal]
   * @returns {Promise<Found>}
   * @throws {Unreachable} if the server does not answer
   */
  async of(promise, signal) {
    try {
      return await promise;
    } catch (problem) {
      // fetch tells of a network that fails by this type, and of what the page itself has ended by another one
      if (signal?.aborted || !(problem instanceof TypeError)) throw problem;
      const lost = new Unreachable();
      if (!this.#waiting) {
        this.#waiting = true;
        this.onLost(lost);
        // one that answers here, and breaks off what is asked of it then, is asked ever more seldom, too
        const isBackForGood = performance.now() - this.#back > LATE;
        this.#wait = isBackForGood ? SOON : Math.min(2 * this.#wait, LATE);
        this.#askAgain();
      }
      throw lost;
    }
  }

  #askAgain() {
    setTimeout(async () => {
      const answer = await fetch("./about").catch(() => null);
      // too many at once, or a fault: it is the same server; another one refuses the token of this page
      if (answer === null || !(answer.ok || answer.status === REFUSED)) {
        this.#wait = Math.min(2 * this.#wait, LATE);
        this.#askAgain();
        return;
      }
      this.#waiting = false;
      this.#back = performance.now();
      if (answer.ok) this.onBack();
      else this.onLost(new Replaced());
    }, this.#wait);
  }
}
