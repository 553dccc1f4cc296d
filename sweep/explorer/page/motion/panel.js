/** One motion: the moving disk, its curves, its losses, and a description of its start. */

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

/** Milliseconds for which a slider must rest before its motion is requested. */
const REST = 60;

const NO_WEBGL = "This browser has no WebGL, so the moving disk is not drawn. The curves below are complete.";

export class MotionPanel {
  /**
   * @param {HTMLElement} element
   * @param {Source} source
   * @param {() => void} [told]  called when a person has changed something in `settings`
   */
  constructor(element, source, told = () => {}) {
    this.element = element;
    this.source = source;
    this.told = told;
    /** @type {Standpoint|null} where the camera was put */
    this.standpoint = null;
    /** @type {Samples|null} the motion for its default duration */
    this.own = null;
    /** @type {Samples|null} the motion that is drawn: `own`, or a longer one next to another motion */
    this.samples = null;
    /** Duration in seconds that is wanted of the shown motion. */
    this.wanted = 0;
    /** @type {AbortController|null} */
    this.extended = null;
    /** Whether the shown motion is too short, for the reason that is reported. */
    this.isCut = false;
    /** @type {MotionRequest|null} */
    this.request = null;
    /** @type {AbortController|null} */
    this.asked = null;
    /** @type {AbortController|null} */
    this.judged = null;
    this.timer = 0;
    this.fresh = false;
    /** Key of the motion that is described, and whether its description has arrived. */
    this.subject = "";
    this.explained = false;
    this.parts = partsOf(element);
    /** @type {DiskScene|null|undefined} null without WebGL */
    this.scene = undefined;
    this.parts.words.addEventListener("toggle", () => this.#explain());
    for (const part of [this.parts.laws, this.parts.words]) part.addEventListener("toggle", told);
    /** @type {MotionFigure[]} */
    this.figures = [];
    /** @type {Map<string, Plot>} by names of figures */
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
   * Show the motion of a place on the map, with the present losses.
   * @param {MotionRequest} request
   */
  async show(request) {
    const former = this.request;
    const another = !former || former.x !== request.x || former.y !== request.y;
    this.request = request;
    await this.#ask(another);
  }

  /** The motion that is described: a place, with the losses set here. */
  get #place() {
    const { view, x, y } = /** @type {MotionRequest} */ (this.request);
    return { view, x, y, losses: this.losses.losses };
  }

  /** Request the description of the motion, and remove the description of another one. */
  #judge() {
    const { view, x, y, losses } = this.#place;
    const key = JSON.stringify([x, y, wordsOf(view), losses]);
    if (key !== this.subject) {
      this.explained = false;
      this.parts.explanation.textContent = "";
      this.parts.verdict.textContent = "";
    }
    this.subject = key;
    // the kernel for a set of losses takes seconds to compile: then the verdict is only in the text that a person opens
    const free = Object.keys(losses).length === 0;
    if (free && !this.parts.verdict.textContent) void this.#tellVerdict(key);
  }

  /**
   * The settings that a person made for this motion.
   * @returns {MotionSettings}
   */
  get settings() {
    const { laws, words } = this.parts;
    const open = Object.entries({ laws, words }).filter(([, part]) => part.open);
    return { losses: this.losses.losses, camera: this.standpoint, open: open.map(([name]) => name) };
  }

  /** The losses that are set here act on the next motion. */
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

  /** @param {boolean} fromStart whether the clock starts at the beginning */
  async #ask(fromStart) {
    if (!this.request) return;
    this.#judge();
    this.asked?.abort();
    const asked = new AbortController();
    this.asked = asked;
    this.element.classList.add("waiting");
    // another start begins afresh even if its motion was dropped in favour of one with other words
    this.fresh ||= fromStart;
    try {
      const answer = await this.source.motion({ ...this.request, losses: this.losses.losses }, asked.signal);
      if (asked.signal.aborted) return;
      const samples = new Samples(answer);
      // let the page react between the computation, the setup of the scene, which takes some 30 ms once, and the
      // drawing
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
        // the losses in an address may allow no motion: without them there are sliders to change them
        this.losses.losses = {};
        this.told();
        const without = this.#ask(fromStart);
        const last = this.asked;
        await without;
        // another start may have been chosen meanwhile, to which this does not apply
        if (this.asked !== last || last.signal.aborted) return;
      }
      tellProblem(this.parts.problem, problem, () => this.request && void this.show(this.request));
      // the verdict and the text about the start exist without its motion
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
    // the clock informs all panels, which draw their curves over the new time
    clock.enter(this, samples.length);
    // the film of a disk plays; the curves of a system appear at once
    if (fromStart) clock.begin(!head.states && !matchMedia("(prefers-reduced-motion: reduce)").matches);
  }

  #showScene() {
    if (!this.samples || !this.scene) return;
    this.scene.show(this.samples, this.#colours(), this.standpoint);
    this.scene.canvas.setAttribute(
      "aria-label",
      `The ${this.samples.head.body?.called ?? "disk"}, ${this.samples.head.title}: arrows turn the camera, plus and minus move it closer and farther away, ` +
        "0 resets it, Space plays and pauses",
    );
    this.parts.square.textContent = `squares of ${lengthText(this.scene.square)}`;
    this.parts.stage.append(this.parts.square);
    this.scene.setTime(clock.time);
  }

  /** Return the colours of the scene in the page's present theme. */
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

  /** Extend the motion to the duration of the one next to it. */
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
      // the clock calls this in every frame: do not ask again until a person does, or another duration is wanted
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
    // a duration of zero has no positions
    if (!samples || clock.length === 0) return;
    if (this.drawnLength !== clock.length || this.drawn !== samples) this.#drawCurves(samples, clock.length);
    const time = Math.min(clock.time, samples.length);
    // a motion that is shorter than the one next to it stays where it ended
    const { ending } = samples.head;
    this.parts.ending.textContent = clock.time >= samples.length ? `${ending}: it has ended` : ending;
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
   * Return the plot with a name, created on first use.
   * @param {string} name
   * @param {number|null} factor  from seconds to the unit of its time; null if its cursor cannot be dragged
   */
  #plotOf(name, factor) {
    const known = this.plots.get(name);
    if (known) return known;
    const seek = factor === null ? undefined : (/** @type {number} */ x) => clock.seek(x / factor);
    const made = new Plot(html("div", { class: `plot ${name}` }), seek);
    this.plots.set(name, made);
    return made;
  }

  /** @param {string} key of the motion that is described */
  async #tellVerdict(key) {
    this.judged?.abort();
    this.judged = new AbortController();
    const point = await this.source.point(this.#place, this.judged.signal).catch(() => null);
    if (!this.request || this.subject !== key || !point) return;
    // the motion of a start that is not a cell of an atlas is shown, but has no verdict
    this.parts.verdict.textContent = point.verdict || (point.note ?? "");
    this.parts.verdict.dataset.verdict = point.verdict;
  }

  /** Request the explanation if it is open and missing. */
  async #explain() {
    if (!this.request || !this.parts.words.open || this.explained) return;
    const { subject } = this;
    /** @type {Promise<string>} */
    const asked = this.source.explain(this.#place);
    const found = await asked.then(
      (text) => ({ text, explained: true }),
      // a refused explanation is requested again when its section is reopened
      (problem) => ({ text: wordsOfProblem(problem), explained: false }),
    );
    if (!this.request || this.subject !== subject) return;
    this.parts.explanation.textContent = found.text;
    this.explained = found.explained;
  }
}

/**
 * Create the elements of a panel inside an element.
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
    words: html("details", { class: "words" }, html("summary", {}, "Explanation"), explanation),
  };
  const head = html("p", { class: "state" }, parts.verdict, parts.ending);
  const below = [parts.note, parts.laws, parts.words];
  element.classList.add("motion");
  element.replaceChildren(head, parts.problem, parts.stage, parts.transport, parts.curves, ...below);
  return parts;
}

/**
 * Return a length as text.
 * @param {number} length  in m
 */
function lengthText(length) {
  const [unit, factor] = length < 0.01 ? ["mm", 1e3] : length < 1 ? ["cm", 1e2] : ["m", 1];
  return `${Number((length * Number(factor)).toPrecision(3))} ${unit}`;
}

/** Icons of the button as paths: not every font has such characters. */
const SIGNS = { pause: "M3 2h4v12H3zM9 2h4v12H9z", play: "M4 2l10 6-10 6z" };

/** Number of steps of the time slider. */
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
    const words = { "aria-label": "speed", title: "seconds of the motion per second" };
    this.speed = select(words, speeds, (speed) => clock.setSpeed(Number(speed)));
    element.append(this.button, this.slide, this.said, this.speed);
    this.follow();
  }

  /**
   * Show the position of the clock.
   * @param {Described} [quantity]  time of a system, whose durations are of any size; omitted for a rolling body
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

/** Let the page do its other work. */
function turn() {
  return new Promise((resolve) => setTimeout(resolve));
}
