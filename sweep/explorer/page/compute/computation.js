/**
 * The workers of the page. Questions are answered in the order in which they were asked, single cells before windows;
 * abandoned questions are skipped.
 */

import { Problem } from "eulerdisk/notice";

/** The scripts of a worker, of which the last one starts it. */
const SCRIPTS = ["kernels", "verdicts", "disk_cells", "path_cells", "system_cells", "worker"].map(
  (name) => `eulerdisk/compute/${name}`,
);

/** Largest number of workers, each of which takes a few MB of memory. */
const MOST_WORKERS = 6;

/**
 * Number of cells in a piece of a window: some 10 ms, after which a worker checks what is wanted now. Cells with
 * periods take longer, those of other bodies some 20 us each, or 0.2 ms with their paths, and those of a system up to a
 * millisecond.
 */
const PIECES = { plain: 32768, timed: 24576, body: 2048, path: 256, system: 256 };

const OLD_BROWSER = "Open the page in a newer browser that has WebAssembly with vectors.";

/** A frame has the policy of the page around it, and a file that of its host. */
const FORBIDDEN =
  "The site or the page around this one must allow 'wasm-unsafe-eval' scripts and blob: workers. Or open the file on its own.";

/**
 * A question to a worker.
 * @typedef {object} Question
 * @property {string} what
 * @property {object} asked
 * @property {number} order  lower numbers come first
 * @property {AbortSignal} [signal]
 * @property {(found: any) => void} resolve
 * @property {(problem: unknown) => void} reject
 */

export class Computation {
  #workers;
  /** @type {Question[]} */
  #waiting = [];

  /** @param {Promise<BufferSource>} content of the WebAssembly module */
  constructor(content) {
    const count = Math.min(Math.max(navigator.hardwareConcurrency || 2, 1), MOST_WORKERS);
    const module = content.then(compiled);
    const address = addressOf(SCRIPTS);
    this.#workers = Array.from({ length: count }, () => new Processor(address, module, () => this.#go()));
    /** Settles when all workers have started, or failed to. */
    this.ready = Promise.allSettled(this.#workers.map((each) => each.begun));
  }

  /** Number of workers. */
  get size() {
    return this.#workers.length;
  }

  /**
   * Ask a worker.
   * @param {string} what  piece, cells or call
   * @param {object} asked
   * @param {{order?: number, signal?: AbortSignal}} [more]
   * @returns {Promise<any>}
   */
  ask(what, asked, { order = 0, signal } = {}) {
    return new Promise((resolve, reject) => {
      const before = this.#waiting.findIndex((each) => each.order > order);
      const at = before < 0 ? this.#waiting.length : before;
      this.#waiting.splice(at, 0, { what, asked, order, signal, resolve, reject });
      this.#go();
    });
  }

  /** Give waiting questions to idle workers. */
  #go() {
    for (const worker of this.#workers) {
      if (worker.busy) continue;
      const next = this.#next();
      if (!next) return;
      void worker.answer(next);
    }
  }

  #next() {
    for (;;) {
      const next = this.#waiting.shift();
      if (!next?.signal?.aborted) return next;
      next.reject(next.signal.reason);
    }
  }
}

/** A worker, and the question that it answers. */
class Processor {
  busy = true;
  /** @type {Worker|null} */
  #worker = null;
  /** @type {Problem|null} why there is no worker: the answer to every question */
  #refusal = null;
  #free;
  /** @type {{resolve: (found: any) => void, reject: (problem: unknown) => void}|null} */
  #answered = null;
  begun;

  /**
   * @param {string} address  of its script
   * @param {Promise<WebAssembly.Module>} module
   * @param {() => void} free  called when it waits for a question
   */
  constructor(address, module, free) {
    this.#free = free;
    try {
      this.#worker = this.#startWorker(address);
    } catch (problem) {
      // some browsers throw an exception where others fire an event
      this.#refusal = workerRefused(/** @type {Error} */ (problem).message);
    }
    this.begun = module.then((module) => this.#send("begin", { module }));
    const ready = () => {
      this.busy = false;
      free();
    };
    this.begun.then(ready, ready);
  }

  /** @param {string} address */
  #startWorker(address) {
    const worker = new Worker(address);
    worker.onmessage = ({ data }) => {
      if (data.problem) this.#answered?.reject(new Problem(data.problem));
      else this.#answered?.resolve(data.found);
    };
    worker.onerror = (event) => {
      event.preventDefault();
      // an event without a message: the browser did not load the script, so nothing will ever answer
      if (event.message === undefined) this.#refusal = workerRefused();
      this.#answered?.reject(this.#refusal ?? cannotCompute(event, OLD_BROWSER));
    };
    return worker;
  }

  /** @param {Question} question */
  async answer({ what, asked, resolve, reject }) {
    this.busy = true;
    try {
      await this.begun;
      resolve(await this.#send(what, asked));
    } catch (problem) {
      reject(
        problem instanceof Problem ? problem : cannotCompute(/** @type {Error} */ (problem), OLD_BROWSER),
      );
    }
    this.busy = false;
    this.#free();
  }

  /**
   * @param {string} what
   * @param {object} asked
   */
  #send(what, asked) {
    return new Promise((resolve, reject) => {
      this.#answered = { resolve, reject };
      if (this.#refusal) reject(this.#refusal);
      else this.#worker?.postMessage({ what, asked });
    });
  }
}

/**
 * @param {{message: string}} problem
 * @param {string} hint
 */
function cannotCompute({ message }, hint) {
  return new Problem(`The page cannot compute here: ${message.replace(/\.*$/, "")}.`, { hint });
}

/** @param {string} message */
function workerRefused(message = "the browser does not let it start workers") {
  return cannotCompute({ message }, FORBIDDEN);
}

/**
 * Return the compiled module.
 * @param {BufferSource} bytes
 */
async function compiled(bytes) {
  try {
    return await WebAssembly.compile(bytes);
  } catch (problem) {
    // a policy that forbids compilation still allows checking whether the browser could compile it
    throw WebAssembly.validate(bytes)
      ? cannotCompute({ message: "the browser does not let it compile WebAssembly" }, FORBIDDEN)
      : cannotCompute(/** @type {Error} */ (problem), OLD_BROWSER);
  }
}

/**
 * Return the address of a script that starts a worker with several scripts in order, whether the page has them as files
 * or as text.
 * @param {string[]} names
 */
function addressOf(names) {
  const addresses = names.map((name) => JSON.stringify(import.meta.resolve(name)));
  return URL.createObjectURL(new Blob([`importScripts(${addresses})`], { type: "text/javascript" }));
}

/**
 * Return the pieces of a window, whole rows or whole columns.
 * @param {{width: number, height: number, byColumns: boolean, kind: keyof typeof PIECES, workers: number}} window
 * @returns {{x: [number, number], y: [number, number]}[]}
 */
export function pieces({ width, height, byColumns, kind, workers }) {
  const [along, across] = byColumns ? [height, width] : [width, height];
  const cells = Math.min(PIECES[kind], Math.ceil((width * height) / (2 * workers)));
  const step = Math.max(1, Math.round(cells / along));
  /** @type {[number, number]} */
  const all = [0, along];
  return Array.from({ length: Math.ceil(across / step) }, (_, i) => {
    /** @type {[number, number]} */
    const part = [i * step, Math.min(across, (i + 1) * step)];
    return byColumns ? { x: part, y: all } : { x: all, y: part };
  });
}
