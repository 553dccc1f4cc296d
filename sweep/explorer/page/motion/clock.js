/** The time of the motions that are shown: all panels share it, so that two motions can be compared. */

/** Speeds to choose from: seconds of the motion per second. */
export const SPEEDS = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];

/** Time in seconds that a motion should take on the screen. */
const SHOWN = 9;

/** Longest time between two frames that counts, so that a page continues where it was after being in the background. */
const LONGEST_FRAME = 0.1;

export class Clock {
  time = 0;
  playing = false;
  speed = 1;
  /** @type {number|null} the chosen speed; null lets it follow from the length of the motions */
  chosen = null;
  /** @type {number|null} time at which the clock stays although motions begin, until it is moved */
  #held = null;
  /** @type {Map<object, number>} length of the motion of each panel */
  #lengths = new Map();
  /** @type {(() => void)[]} */
  #listeners = [];
  #frame = 0;
  #last = 0;

  /** Length of the longest shown motion, in seconds. */
  get length() {
    return Math.max(0, ...this.#lengths.values());
  }

  /**
   * Call a function after every change.
   * @param {() => void} listener
   */
  listen(listener) {
    this.#listeners.push(listener);
  }

  /**
   * Record the length of a panel's motion.
   * @param {object} panel
   * @param {number} length
   */
  enter(panel, length) {
    this.#lengths.set(panel, length);
    this.#settle();
  }

  /** @param {object} panel */
  leave(panel) {
    this.#lengths.delete(panel);
    this.#settle();
  }

  /** The time at which the clock was stopped; null while it runs, and at the beginning or end. */
  get standing() {
    const within = !this.playing && this.time > 0 && this.time < this.length;
    return this.#held ?? (within ? this.time : null);
  }

  /**
   * Stop at a time, even before the motions are shown; null lets them start at the beginning.
   * @param {number|null} time
   */
  hold(time) {
    this.#held = time;
    if (time === null) return;
    this.pause();
    this.#stand(time);
  }

  /**
   * Start a motion: at its beginning, or where the clock was stopped.
   * @param {boolean} plays
   */
  begin(plays) {
    this.#stand(this.#held ?? 0);
    if (plays && this.#held === null) this.play();
  }

  play() {
    this.#held = null;
    if (this.playing || this.length === 0) return;
    if (this.time >= this.length) this.time = 0;
    this.playing = true;
    this.#last = 0;
    this.#frame = requestAnimationFrame((now) => this.#advance(now));
    this.#tell();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    cancelAnimationFrame(this.#frame);
    this.#tell();
  }

  /** @param {number} time */
  seek(time) {
    this.#held = null;
    this.#stand(time);
  }

  /** @param {number} time */
  #stand(time) {
    this.time = Math.min(Math.max(time, 0), this.length);
    this.#tell();
  }

  /** @param {number|null} speed null for one that suits the length of the motions */
  setSpeed(speed) {
    this.chosen = speed;
    this.#settle();
  }

  #settle() {
    if (this.length === 0) {
      this.playing = false;
      cancelAnimationFrame(this.#frame);
      this.time = 0;
    } else {
      const wanted = Math.log(this.length / SHOWN);
      const nearer = (/** @type {number} */ a, /** @type {number} */ b) =>
        Math.abs(Math.log(a) - wanted) <= Math.abs(Math.log(b) - wanted) ? a : b;
      this.speed = this.chosen ?? SPEEDS.reduce(nearer);
    }
    this.time = Math.min(this.time, this.length);
    this.#tell();
  }

  /** @param {number} now  in milliseconds */
  #advance(now) {
    const passed = this.#last === 0 ? 0 : Math.min((now - this.#last) / 1000, LONGEST_FRAME);
    this.#last = now;
    this.time = Math.min(this.time + this.speed * passed, this.length);
    if (this.time >= this.length) this.playing = false;
    else this.#frame = requestAnimationFrame((later) => this.#advance(later));
    this.#tell();
  }

  #tell() {
    for (const listener of this.#listeners) listener();
  }
}

/** The clock of this page. */
export const clock = new Clock();
