/** Whether the server of this page still answers: what is said when it does not, and the wait until it does again. */

/** Milliseconds until a server that did not answer is asked again: at first, and at most. */
const [SOON, LATE] = [1000, 15_000];

/** Status of an address without the token of the server. */
const REFUSED = 403;

/** The server did not answer at all. */
export class Unreachable extends Error {
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
