/** One request at a time, and after it only the newest of those that came meanwhile. */

/** @template Request */
export class Latest {
  #run;
  /** @type {Request|null} */
  #waiting = null;
  #busy = false;

  /** @param {(request: Request) => Promise<void>} run  must not reject */
  constructor(run) {
    this.#run = run;
  }

  /** Whether a request is under way. */
  get busy() {
    return this.#busy;
  }

  /** @param {Request} request */
  ask(request) {
    this.#waiting = request;
    if (!this.#busy) void this.#work();
  }

  /** Forget what waits. */
  forget() {
    this.#waiting = null;
  }

  async #work() {
    this.#busy = true;
    while (this.#waiting !== null) {
      const request = this.#waiting;
      this.#waiting = null;
      await this.#run(request);
    }
    this.#busy = false;
  }
}
