/** The page: one state, shown by all parts of the page and kept in the address. */

import { fragmentOf, stateOf, themeOf } from "eulerdisk/address";
import { baseMenu, showTheme, themeButton } from "eulerdisk/choices";
import { Controls } from "eulerdisk/controls";
import { AtlasMap } from "eulerdisk/map";
import { addMenus } from "eulerdisk/menus";
import { clock } from "eulerdisk/motion/clock";
import { Motions } from "eulerdisk/motions";
import { tell, tellProblem } from "eulerdisk/notice";
import { PageSource } from "eulerdisk/page_source";
import { Readout } from "eulerdisk/readout";
import { ServerSource } from "eulerdisk/server_source";
import { baseOf, firstAxis, quantityOf, UNSET, withinDomain, withSlot, wordsOf } from "eulerdisk/state";

/** @import { Aim } from "eulerdisk/map" */
/** @import { Point, State } from "eulerdisk/state" */
/** @import { About, Source } from "eulerdisk/types" */

/** Milliseconds without a change before the address is written. */
const REST = 250;

/** Milliseconds without a picture before the page explains the delay, and the explanation. */
const PATIENCE = 1500;
const COMPILING =
  "No picture yet: compiling the kernel of a map for the first time on this machine takes ten to thirty seconds.";

/** @param {string} id */
function part(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`The page has no element ${id}.`);
  return found;
}

/**
 * Return whether the page has an address of its own that others can open; a frame filled by text from its parent page
 * has none.
 */
function hasAddress() {
  return !["about:", "blob:", "data:"].includes(location.protocol);
}

/**
 * Write a state into the address if the browser allows it. It does not in a frame without an address, in some
 * sandboxes, or a hundred times within half a minute.
 * @param {State} state
 * @param {"replaceState"|"pushState"} how
 */
function writeAddress(state, how) {
  const fragment = `#${fragmentOf(state)}`;
  if (fragment === location.hash) return;
  try {
    history[how](null, "", fragment);
  } catch (problem) {
    if (/** @type {Error} */ (problem).name !== "SecurityError") throw problem;
  }
}

class Page {
  #about;
  #source;
  #state;
  #map;
  #controls;
  #readout;
  #motions;
  #choices;
  #timer = 0;
  /** The fragment that was last read or written. */
  #address = location.hash;
  /** @type {State|null} what was shown before the last click */
  #before = null;
  /**
   * Whether the page still has to choose its first motion: it was opened without a state, or the preset was changed.
   */
  #awaitsFirstStart = location.hash === "";
  /** @type {Error|null} why there is no picture, or no answer, until there is one */
  #problem = null;
  /** When the page was ready. */
  #begun = performance.now();
  /** @type {Error|null} set while the server does not answer; the page computes meanwhile */
  #lost = null;

  /**
   * @param {About} about
   * @param {Source} source
   */
  constructor(about, source) {
    this.#about = about;
    this.#source = source;
    this.#state = stateOf(location.hash, about);
    const change = (/** @type {(state: State) => State} */ by) => this.#show(by(this.#state));
    this.#map = new AtlasMap(part("map"), about, source, this.#state, {
      onView: (view) => change((state) => ({ ...state, view })),
      onChoose: (aim, second, tapped) => this.#choose(aim, second, tapped),
      onAim: (aim) => this.#aim(aim),
      onReset: (chosen) => this.#reset(chosen),
      onShown: () => {
        this.#problem = null;
        this.#shown();
        this.#chooseFirst();
      },
      onLines: () => this.#shown(),
      onProblem: (problem) => this.#note(problem),
    });
    this.#controls = new Controls(part("controls"), about, change, () => {
      const { low, high } = this.#map.picture.range;
      return [low, high];
    });
    this.#readout = new Readout(part("readout"), part("spoken"), about, source);
    this.#motions = new Motions(part("motions"), about, source, {
      close: (slot) => this.#close(slot),
      set: (slot, settings) =>
        change((state) => ({ ...state, motions: withSlot(state.motions, slot, settings) })),
    });
    clock.listen(() => this.#hearClock());
    const begin = (/** @type {(state: State) => State} */ by) => {
      this.#awaitsFirstStart = true;
      this.#begin(by(this.#state));
    };
    this.#choices = [baseMenu(part("bases"), about, begin), themeButton(part("theme"), change)];
    part("compare").addEventListener("click", () =>
      change((state) => ({ ...state, compare: !state.compare })),
    );
    part("whole").addEventListener("click", () => this.#reset(false));
    const followMenus = addMenus(part("menus"), about, {
      state: () => this.#state,
      address: hasAddress() ? () => location.href.replace(/#.*/, "") + "#" + fragmentOf(this.#state) : null,
      map: this.#map,
      motions: this.#motions,
      source,
      say: (words) => tell(part("notice"), words),
    });
    this.#choices.push(followMenus);
    if (source.reach) {
      const { reach } = source;
      reach.onLost = (problem) => {
        this.#lost = problem;
        this.#tell();
      };
      reach.onBack = () => {
        this.#lost = null;
        this.#tell();
        this.#map.again();
        this.#motions.again();
        this.#readout.follow(this.#state.view);
      };
    }
    window.addEventListener("hashchange", () => this.#restore());
    tell(part("notice"), "");
    this.#show(this.#state);
    setTimeout(() => this.#tell(), PATIENCE);
    const [first] = this.#state.points;
    if (first) this.#aim({ point: first, shown: null, keys: false });
  }

  /** @param {State} wanted */
  #show(wanted) {
    const points = this.#atCells(wanted.points);
    const state = { ...wanted, view: withinDomain(this.#about, wanted.view), points };
    const words = wordsOf(state.view);
    const before = wordsOf(this.#state.view);
    this.#state = state;
    showTheme(state.theme);
    part("compare").setAttribute("aria-pressed", String(state.compare));
    for (const follow of this.#choices) follow(state);
    this.#map.show(state);
    this.#controls.show(state, this.#map.lines);
    if (clock.chosen !== state.speed) clock.setSpeed(state.speed);
    if (clock.standing !== state.time) clock.hold(state.time);
    this.#motions.show(state);
    if (words !== before) this.#readout.follow(state.view);
    this.#keepSoon();
  }

  /**
   * Return the cells that represent chosen points where only stored cells are known: marks, numbers and motions belong
   * to these cells.
   * @param {State["points"]} points
   * @returns {State["points"]}
   */
  #atCells([a, b]) {
    const cell = (/** @type {Point|null} */ point) => point && (this.#source.cellAt?.(point) ?? point);
    return [cell(a), cell(b)];
  }

  /** Record where the motions' clock was put. */
  #hearClock() {
    const { standing: time, chosen: speed } = clock;
    if (time === this.#state.time && speed === this.#state.speed) return;
    this.#state = { ...this.#state, time, speed };
    this.#keepSoon();
  }

  #keepSoon() {
    clearTimeout(this.#timer);
    this.#timer = window.setTimeout(() => this.#keep(), REST);
  }

  /** @param {Aim|null} aim */
  #aim(aim) {
    const { view, quantity } = this.#state;
    if (aim) this.#readout.show(aim, view, quantityOf(this.#about, quantity));
  }

  /** Write the state into the address, unless the address has changed meanwhile: then show the new address. */
  #keep() {
    if (location.hash !== this.#address) {
      this.#restore();
      return;
    }
    writeAddress(this.#state, "replaceState");
    this.#address = location.hash;
  }

  /**
   * Show a state that abandons the present window; the browser's Back button returns to it.
   * @param {State} state
   */
  #begin(state) {
    this.#keep();
    writeAddress(state, "pushState");
    this.#address = location.hash;
    this.#show(state);
  }

  /** Show the state of an address that was typed or revisited. */
  #restore() {
    this.#address = location.hash;
    if (location.hash.slice(1) !== fragmentOf(this.#state)) this.#show(stateOf(location.hash, this.#about));
  }

  /**
   * @param {Aim} aim
   * @param {boolean} second
   * @param {boolean} tapped
   */
  #choose(aim, second, tapped) {
    const { point } = aim;
    this.#awaitsFirstStart = false;
    // a touch does not hover, so show the numbers of the chosen start too
    this.#aim(aim);
    this.#before = this.#state;
    const { points, compare } = this.#state;
    // while comparing, a click chooses the second start until there is one; with Shift it always does
    const slot = second || (compare && points[0] && !points[1]) ? 1 : 0;
    /** @type {[Point|null, Point|null]} */
    const chosen = slot ? [points[0], point] : [point, points[1]];
    this.#show({ ...this.#state, points: chosen, compare: compare || slot === 1, time: null });
    if (tapped) this.#motions.reveal(slot, part("atlas"));
  }

  /** Choose the page's first motion as soon as there are numbers to choose by. */
  #chooseFirst() {
    const point = this.#awaitsFirstStart ? this.#map.firstStart() : null;
    if (!point) return;
    this.#awaitsFirstStart = false;
    this.#show({ ...this.#state, points: [point, null] });
  }

  /** @param {number} slot */
  #close(slot) {
    const { points, motions, compare } = this.#state;
    // the second motion takes the place of the first
    const left = slot === 0 ? 1 : 0;
    const point = slot === 1 || compare ? points[left] : null;
    const settings = point ? motions[left] : UNSET;
    this.#show({ ...this.#state, points: [point, null], motions: [settings, UNSET], compare: false });
  }

  /** @param {boolean} chosen whether the first click of a double click chose a start, which was not intended */
  #reset(chosen) {
    // do not keep that start either: Back would return to it
    if (chosen && this.#before) this.#state = this.#before;
    const { view } = this.#state;
    const base = baseOf(this.#about, view).view;
    const isFirst = (/** @type {string} */ name) => [base.x.name, base.y.name].includes(name);
    const [x, y] = [view.x, view.y].map((axis) =>
      isFirst(axis.name) ? firstAxis(this.#about, view, axis.name) : axis,
    );
    this.#begin({ ...this.#state, view: { ...view, x, y } });
  }

  /** React to new numbers or other lines. */
  #shown() {
    this.#controls.show(this.#state, this.#map.lines);
    this.#tell();
  }

  /** Return whether the first picture takes long because the server may be compiling its kernel. */
  #waitsForKernel() {
    const isDear = baseOf(this.#about, this.#state.view).cost > 0;
    return performance.now() - this.#begun >= PATIENCE && isDear && Boolean(this.#source.reach);
  }

  /** Report what is wrong with the picture or its lines, otherwise the note of the picture. */
  #tell() {
    const problem = this.#lost ?? this.#problem ?? this.#map.linesProblem;
    const { answer } = this.#map.picture;
    const end = this.#map.atEnd || answer?.head.end;
    if (problem) tellProblem(part("notice"), problem, () => this.#map.again());
    else if (end) tell(part("notice"), "Zoom ends here: a pixel is 8 units in the last place wide.");
    else if (answer) tell(part("notice"), answer.head.note ?? "");
    else tell(part("notice"), this.#waitsForKernel() ? COMPILING : "");
  }

  /** @param {Error|null} problem */
  #note(problem) {
    this.#problem = problem;
    this.#tell();
  }
}

/** @param {Source} source */
async function begin(source) {
  const about = await source.about();
  document.title = `${about.atlas?.label ?? "eulerdisk explorer"}`;
  new Page(about, source);
}

/**
 * Begin, if necessary as soon as the server answers.
 * @param {ServerSource} source
 */
function beginOnceAnswered(source) {
  let isUnderWay = false;
  const attempt = async () => {
    // a second press, or a server that answers again meanwhile, must not begin a second page
    if (isUnderWay) return;
    isUnderWay = true;
    await begin(source).catch((problem) => sayWhyNot(problem, attempt));
    isUnderWay = false;
  };
  source.reach.onBack = attempt;
  source.reach.onLost = (problem) => tellProblem(part("notice"), problem);
  void attempt();
}

/**
 * Say why the page could not begin. Anything except a server's answer is a bug and is also logged to the console.
 * @param {Error & {status?: number, unreachable?: boolean}} problem
 * @param {(() => void)|null} [again]
 */
function sayWhyNot(problem, again = null) {
  tellProblem(part("notice"), problem, again);
  if (!problem.unreachable && !problem.status) reportError(problem);
}

// immediately, so that a page that waits for its server does not flash
showTheme(themeOf(location.hash));
const held = document.getElementById("stored");
if (held) {
  PageSource.read(held.textContent ?? "", document.getElementById("kernels")?.textContent ?? "")
    .then(begin)
    .catch(sayWhyNot);
} else beginOnceAnswered(new ServerSource());
