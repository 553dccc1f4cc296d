/** One motion: the disk as it moves, its curves, its losses and what is known of its start in words. */

import { html, select, svg } from "eulerdisk/elements";
import { clock, SPEEDS } from "eulerdisk/motion/clock";
import { DiskScene } from "eulerdisk/motion/disk_scene";
import { rollingFigures } from "eulerdisk/motion/figures";
import { LossSliders } from "eulerdisk/motion/loss_sliders";
import { Plot } from "eulerdisk/motion/plot";
import { Samples } from "eulerdisk/motion/samples";
import { systemFigures } from "eulerdisk/motion/system_figures";
import { tell, tellProblem, wordsOfProblem } from "eulerdisk/notice";
import { wordsOf } from "eulerdisk/state";
import { printedUnits, readable } from "eulerdisk/ticks";

/** @import { Problem } from "eulerdisk/notice" */
/** @import { Clock } from "eulerdisk/motion/clock" */
/** @import { MotionFigure } from "eulerdisk/motion/figures" */
/** @import { Standpoint } from "eulerdisk/motion/disk_scene" */
/** @import { Described, MotionRequest, MotionSettings, Source } from "eulerdisk/types" */

/** Milliseconds that a slider has to rest before its motion is asked for. */
const REST = 60;

const NO_WEBGL = "This browser offers no WebGL: what moves is not drawn, and the curves below are complete.";

export class MotionPanel {
  /**
   * @param {HTMLElement} element
   * @param {Source} source
   * @param {() => void} [told]  is called when a person has changed what `settings` holds
   */
  constructor(element, source, told = () => {}) {
    this.element = element;
    this.source = source;
    this.told = told;
    /** @type {Standpoint|null} where the camera was put */
    this.standpoint = null;
    /** @type {Samples|null} the motion for its usual time */
    this.own = null;
    /** @type {Samples|null} the motion as drawn: `own`, or a longer one beside another motion */
    this.samples = null;
    /** Seconds to which the shown one is wanted. */
    this.wanted = 0;
    /** @type {AbortController|null} */
    this.extended = null;
    /** Whether the shown one is too short, and the problem that is told is why. */
    this.isCut = false;
    /** @type {MotionRequest|null} */
    this.request = null;
    /** @type {AbortController|null} */
    this.asked = null;
    /** @type {AbortController|null} */
    this.judged = null;
    this.timer = 0;
    this.fresh = false;
    /** The motion of which is told, as text; and whether its words are there. */
    this.subject = "";
    this.explained = false;
    this.parts = partsOf(element);
    /** @type {DiskScene|null|undefined} null where there is no WebGL */
    this.scene = undefined;
    this.parts.words.addEventListener("toggle", () => this.#explain());
    for (const part of [this.parts.laws, this.parts.words]) part.addEventListener("toggle", told);
    /** @type {MotionFigure[]} */
    this.figures = [];
    /** @type {Map<string, Plot>} by the names of figures */
    this.plots = new Map();
    this.transport = new Transport(this.parts.transport, clock);
    this.losses = new LossSliders(this.parts.losses, () => {
      this.#askSoon();
      told();
    });
    clock.listen(() => this.#follow());
    const themes = new MutationObserver(() => this.#showScene());
    themes.observe(document.documentElement, { attributeFilter: ["data-theme"] });
  }

  /**
   * Show the motion of a place of the map, with the losses that are set.
   * @param {MotionRequest} request
   */
  async show(request) {
    const former = this.request;
    const another = !former || former.x !== request.x || former.y !== request.y;
    this.request = request;
    await this.#ask(another);
  }

  /** The motion of which is told: a place, with the losses that are set here. */
  get #place() {
    const { view, x, y } = /** @type {MotionRequest} */ (this.request);
    return { view, x, y, losses: this.losses.losses };
  }

  /** Ask for what is said of the motion; what was said of another one goes. */
  #judge() {
    const { view, x, y, losses } = this.#place;
    const key = JSON.stringify([x, y, wordsOf(view), losses]);
    if (key !== this.subject) {
      this.explained = false;
      this.parts.explanation.textContent = "";
      this.parts.verdict.textContent = "";
    }
    this.subject = key;
    // the kernel of a set of losses takes seconds to compile: their verdict stands in the words, which a person opens
    const free = Object.keys(losses).length === 0;
    if (free && !this.parts.verdict.textContent) void this.#tellVerdict(key);
  }

  /**
   * What a person has set of this motion.
   * @returns {MotionSettings}
   */
  get settings() {
    const { laws, words } = this.parts;
    const open = Object.entries({ laws, words }).filter(([, part]) => part.open);
    return { losses: this.losses.losses, camera: this.standpoint, open: open.map(([name]) => name) };
  }

  /** Losses that are set here act on the motion that is shown next. */
  set settings({ losses, camera, open }) {
    this.losses.losses = losses;
    this.parts.laws.open = open.includes("laws");
    this.parts.words.open = open.includes("words");
    this.standpoint = camera;
    if (this.scene?.samples) this.scene.standpoint = camera ?? this.scene.behind();
  }

  clear() {
    clearTimeout(this.timer);
    this.asked?.abort();
    this.extended?.abort();
    this.judged?.abort();
    this.parts.verdict.textContent = "";
    tell(this.parts.problem, "");
    this.own = this.samples = null;
    this.isCut = false;
    this.request = null;
    this.fresh = false;
    this.scene?.clear();
    clock.leave(this);
    this.element.classList.remove("shown", "waiting", "refused");
  }

  #askSoon() {
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.#ask(false), REST);
  }

  /** @param {boolean} fromStart  whether the clock begins anew */
  async #ask(fromStart) {
    if (!this.request) return;
    this.#judge();
    this.asked?.abort();
    const asked = new AbortController();
    this.asked = asked;
    this.element.classList.add("waiting");
    // another start whose motion was dropped for one with other words begins anew all the same
    this.fresh ||= fromStart;
    try {
      const answer = await this.source.motion({ ...this.request, losses: this.losses.losses }, asked.signal);
      if (asked.signal.aborted) return;
      const samples = new Samples(answer);
      // the page goes on between what is computed, the scene, which takes some 30 ms once, and what is drawn
      await turn();
      if (asked.signal.aborted) return;
      if (this.scene === undefined && !samples.head.states) {
        this.#makeScene();
        await turn();
      }
      if (asked.signal.aborted) return;
      this.#show(samples, this.fresh);
      this.fresh = false;
      tell(this.parts.problem, "");
    } catch (problem) {
      if (asked.signal.aborted) return;
      if (
        /** @type {Problem} */ (problem).status === 400 &&
        !this.samples &&
        Object.keys(this.losses.losses).length
      ) {
        // losses of an address may leave no motion: without them there are sliders to set them with
        this.losses.losses = {};
        this.told();
        const without = this.#ask(fromStart);
        const last = this.asked;
        await without;
        // another start may have been chosen meanwhile: this is not said of it
        if (this.asked !== last || last.signal.aborted) return;
      }
      tellProblem(this.parts.problem, problem, () => this.request && void this.show(this.request));
      // the verdict and the words of the start are there without its motion
      this.element.classList.toggle("refused", !this.samples);
    }
    this.element.classList.remove("waiting");
    await this.#explain();
  }

  /**
   * @param {Samples} samples
   * @param {boolean} fromStart
   */
  #show(samples, fromStart) {
    const { head } = samples;
    this.extended?.abort();
    this.own = this.samples = samples;
    this.wanted = samples.length;
    this.isCut = false;
    this.element.classList.add("shown");
    this.element.classList.remove("refused");
    this.element.classList.toggle("lossy", head.lossy);
    this.element.classList.toggle("system", head.states !== undefined);
    this.parts.note.textContent = printedUnits(head.note);
    this.parts.laws.hidden = head.losses.length === 0;
    this.parts.summary.textContent = `Losses: the ${head.body ? "body" : "disk"} that stops`;
    this.losses.show(head.losses);
    this.#showScene();
    // the clock tells all panels: those beside this one draw their curves over the new time
    clock.enter(this, samples.length);
    // the film of a disk plays; the curves of a system are there at once
    if (fromStart) clock.begin(!head.states && !matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  #showScene() {
    if (!this.samples || !this.scene) return;
    this.scene.show(this.samples, this.#colours(), this.standpoint);
    this.scene.canvas.setAttribute(
      "aria-label",
      `The ${this.samples.head.body?.called ?? "disk"}, ${this.samples.head.title}: arrows turn the camera, plus and minus bring it nearer and farther, ` +
        "0 puts it back, Space plays and pauses",
    );
    this.parts.square.textContent = `squares of ${lengthText(this.scene.square)}`;
    this.parts.stage.append(this.parts.square);
    this.scene.setTime(clock.time);
  }

  /** Colours of the scene as the page has them by day or night. */
  #colours() {
    const probe = html("i");
    this.element.append(probe);
    const [ground, grid, trail, force, rim] = ["ground", "grid", "trail", "force", "rim"].map((name) => {
      probe.style.color = `var(--motion-${name})`;
      return getComputedStyle(probe).color;
    });
    probe.remove();
    return { ground, grid, trail, force, rim };
  }

  #makeScene() {
    try {
      this.scene = new DiskScene(this.parts.stage, (standpoint) => {
        this.standpoint = standpoint;
        this.told();
      });
    } catch (problem) {
      if (!/webgl/i.test(/** @type {Error} */ (problem).message)) throw problem;
      this.scene = null;
      this.parts.stage.textContent = NO_WEBGL;
      return;
    }
    this.scene.canvas.addEventListener("keydown", (event) => {
      if (event.key !== " " || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      if (clock.playing) clock.pause();
      else clock.play();
    });
  }

  /** Follow a motion that goes on for as long as the one beside it. */
  async #extend() {
    const { own } = this;
    const wanted = own && !own.head.ended ? Math.max(clock.length, own.length) : 0;
    if (!own || !this.request || !wanted || wanted === this.wanted) return;
    this.wanted = wanted;
    this.extended?.abort();
    const extended = new AbortController();
    this.extended = extended;
    const request = { ...this.request, losses: this.losses.losses, duration: wanted };
    try {
      const isOwn = wanted === own.length;
      const samples = isOwn ? own : new Samples(await this.source.motion(request, extended.signal));
      if (extended.signal.aborted) return;
      this.samples = samples;
    } catch (problem) {
      if (extended.signal.aborted) return;
      // it is not asked for again before a person does so, or another time is wanted: the clock calls this in each frame
      this.isCut = true;
      tellProblem(this.parts.problem, problem, () => this.request && void this.show(this.request));
      return;
    }
    if (this.isCut) tell(this.parts.problem, "");
    this.isCut = false;
    this.parts.note.textContent = printedUnits(this.samples.head.note);
    this.#showScene();
    this.#follow();
  }

  /** Show the time of the clock. */
  #follow() {
    void this.#extend();
    const { samples } = this;
    // nothing has a place in a time without length
    if (!samples || clock.length === 0) return;
    if (this.drawnLength !== clock.length || this.drawn !== samples) this.#drawCurves(samples, clock.length);
    const time = Math.min(clock.time, samples.length);
    // what ends before the motion beside it stays where it ended
    const { ending } = samples.head;
    this.parts.ending.textContent = clock.time >= samples.length ? `${ending}: this is its end` : ending;
    for (const { name, cursorAt } of this.figures) this.plots.get(name)?.setCursor(...cursorAt(time));
    this.transport.follow(samples.head.states && samples.head.quantities.time);
    this.scene?.setTime(time);
  }

  /**
   * @param {Samples} samples
   * @param {number} length
   */
  #drawCurves(samples, length) {
    this.drawnLength = length;
    this.drawn = samples;
    const former = this.figures.map(({ name }) => name);
    this.figures = samples.head.states ? systemFigures(samples, length) : rollingFigures(samples, length);
    const { factor } = samples.head.quantities.time;
    const plots = this.figures.map(({ name, seeks }) => this.#plotOf(name, seeks ? factor : null));
    if (this.figures.some(({ name }, i) => name !== former[i]) || former.length !== plots.length) {
      this.parts.curves.replaceChildren(...plots.map(({ element }) => element));
    }
    this.figures.forEach(({ figure }, i) => plots[i].show(figure));
  }

  /**
   * The plot of a name, made when it is wanted first.
   * @param {string} name
   * @param {number|null} factor  from seconds to the unit of its time; null where its cursor cannot be dragged
   */
  #plotOf(name, factor) {
    const known = this.plots.get(name);
    if (known) return known;
    const seek = factor === null ? undefined : (/** @type {number} */ x) => clock.seek(x / factor);
    const made = new Plot(html("div", { class: `plot ${name}` }), seek);
    this.plots.set(name, made);
    return made;
  }

  /** @param {string} key  the motion of which is told */
  async #tellVerdict(key) {
    this.judged?.abort();
    this.judged = new AbortController();
    const point = await this.source.point(this.#place, this.judged.signal).catch(() => null);
    if (!this.request || this.subject !== key || !point) return;
    // the motion of a start that is no cell of an atlas is shown, and has no verdict
    this.parts.verdict.textContent = point.verdict || (point.note ?? "");
    this.parts.verdict.dataset.verdict = point.verdict;
  }

  /** Ask for the explanation when it is open and not there yet. */
  async #explain() {
    if (!this.request || !this.parts.words.open || this.explained) return;
    const { subject } = this;
    /** @type {Promise<string>} */
    const asked = this.source.explain(this.#place);
    const found = await asked.then(
      (text) => ({ text, explained: true }),
      // what was refused is asked for once more when the words are opened again
      (problem) => ({ text: wordsOfProblem(problem), explained: false }),
    );
    if (!this.request || this.subject !== subject) return;
    this.parts.explanation.textContent = found.text;
    this.explained = found.explained;
  }
}

/**
 * The elements of a panel, put into one.
 * @param {HTMLElement} element
 */
function partsOf(element) {
  const part = (/** @type {string} */ name) => html("div", { class: name });
  const explanation = html("pre", { class: "explanation", tabindex: "0" });
  const losses = part("losses");
  const summary = html("summary", {}, "Losses");
  const parts = {
    verdict: html("span", { class: "verdict" }),
    ending: html("span", { class: "ending" }),
    problem: html("p", { class: "problem", role: "status" }),
    stage: part("stage"),
    square: html("span", { class: "square" }),
    transport: part("transport"),
    curves: part("curves"),
    note: html("p", { class: "note" }),
    losses,
    explanation,
    laws: html("details", { class: "laws" }, summary, losses),
    summary,
    words: html("details", { class: "words" }, html("summary", {}, "In words"), explanation),
  };
  const head = html("p", { class: "state" }, parts.verdict, parts.ending);
  const below = [parts.note, parts.laws, parts.words];
  element.classList.add("motion");
  element.replaceChildren(head, parts.problem, parts.stage, parts.transport, parts.curves, ...below);
  return parts;
}

/**
 * Length as people read it.
 * @param {number} length  in m
 */
function lengthText(length) {
  const [unit, factor] = length < 0.01 ? ["mm", 1e3] : length < 1 ? ["cm", 1e2] : ["m", 1];
  return `${Number((length * Number(factor)).toPrecision(3))} ${unit}`;
}

/** What the button does, drawn: not every font has signs for it. */
const SIGNS = { pause: "M3 2h4v12H3zM9 2h4v12H9z", play: "M4 2l10 6-10 6z" };

/** Steps of the slider of time. */
const STEPS = 1000;

class Transport {
  /**
   * @param {HTMLElement} element
   * @param {Clock} clock
   */
  constructor(element, clock) {
    this.clock = clock;
    this.button = html("button", { type: "button", class: "play" });
    this.button.addEventListener("click", () => (clock.playing ? clock.pause() : clock.play()));
    this.slide = html("input", {
      type: "range",
      min: "0",
      max: String(STEPS),
      class: "time",
      "aria-label": "time",
    });
    this.slide.addEventListener("input", () => clock.seek((Number(this.slide.value) / STEPS) * clock.length));
    this.said = html("output", { class: "now" });
    const speeds = SPEEDS.map((speed) => ({ value: String(speed), label: `${speed}\u00d7` }));
    const words = { "aria-label": "speed", title: "seconds of the motion in a second" };
    this.speed = select(words, speeds, (speed) => clock.setSpeed(Number(speed)));
    element.append(this.button, this.slide, this.said, this.speed);
    this.follow();
  }

  /**
   * Show where the clock is.
   * @param {Described} [quantity]  of the time of a system, whose durations are of any size; none of a rolling body
   */
  follow(quantity) {
    const { playing, time, length, speed } = this.clock;
    const word = playing ? "pause" : "play";
    if (this.button.dataset.does !== word) {
      this.button.dataset.does = word;
      this.button.setAttribute("aria-label", word);
      const sign = svg("path", { d: SIGNS[word], fill: "currentColor" });
      const size = { viewBox: "0 0 16 16", width: 14, height: 14, "aria-hidden": "true" };
      this.button.replaceChildren(svg("svg", size, sign));
    }
    this.slide.value = String(length > 0 ? Math.round((time / length) * STEPS) : 0);
    const digits = Math.max(0, 2 - Math.floor(Math.log10(Math.max(length, 1e-6))));
    const text = quantity
      ? `${readable(quantity.factor * time, 4)} ${printedUnits(quantity.unit)}`.trim()
      : `${time.toFixed(digits)} s`;
    this.said.textContent = text;
    this.slide.setAttribute("aria-valuetext", text);
    this.speed.value = String(speed);
  }
}

/** Let the page go on with what else there is to do. */
function turn() {
  return new Promise((resolve) => setTimeout(resolve));
}
