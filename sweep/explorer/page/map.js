/** The map: picture, overlay and gestures of one element. It shows a state and reports what the user does on it. */

import { between, leastHalf, moved, roundestAt, valueAt, zoomed } from "eulerdisk/axis_window";
import { paint, rangeFor } from "eulerdisk/colours";
import { Gestures, listenToKeys } from "eulerdisk/gestures";
import { html, svg } from "eulerdisk/elements";
import { Latest, Refresh } from "eulerdisk/refresh";
import { legendHeight, drawOverlay } from "eulerdisk/overlay";
import { mayPass } from "eulerdisk/notice";
import { halfOfRange, parameterOf, quantityOf, wordsOf } from "eulerdisk/state";
import { markVerdicts } from "eulerdisk/verdict_marks";

/** @import { Range } from "eulerdisk/colours" */
/** @import { Deeds, Place } from "eulerdisk/gestures" */
/** @import { Wanted } from "eulerdisk/refresh" */
/** @import { Point, State } from "eulerdisk/state" */
/** @import { About, Axis, Line, Quantity, Source, View, WindowAnswer } from "eulerdisk/types" */

/**
 * A start under the pointer, and what the picture shows there.
 * @typedef {{point: Point, shown: Seen|null, keys: boolean}} Aim
 */

/**
 * What the map reports: another view; a chosen start (`second`: for the second motion; `tapped`: by touch); the start
 * under the pointer, null for none; a request for the whole range; new numbers; other lines; a window that the server
 * refused.
 * @typedef {object} Told
 * @property {(view: View) => void} onView
 * @property {(aim: Aim, second: boolean, tapped: boolean) => void} onChoose
 * @property {(aim: Aim|null) => void} onAim
 * @property {(chosen: boolean) => void} onReset
 * @property {() => void} onShown
 * @property {() => void} onLines
 * @property {(problem: Error) => void} onProblem
 */

/** Number of steps of the keyboard's cursor from border to border. */
const CELLS = [50, 40];

/** Place near which the first start is chosen: small rates, and tilts large enough to be visible. */
const BEGIN = /** @type {Place} */ ([0.5, -0.5]);

/** Code of the verdict "unstable". */
const UNSTABLE = 2;

/** Largest extent of a window, relative to the range of its base. */
const BEYOND = 8;

export class AtlasMap {
  picture = new Picture();
  /** @type {SVGSVGElement} */
  overlay = /** @type {SVGSVGElement} */ (svg("svg", { class: "overlay", "aria-hidden": "true" }));
  /** @type {Line[]} */
  lines = [];
  /** @type {Error|null} why there are no lines, although there could be */
  linesProblem = null;
  #element;
  #about;
  #told;
  #refresh;
  #lineRequests;
  /** @type {State} */
  #state;
  /** @type {Place|null} */
  #cursor = null;
  #linesOf = "";
  #asked = "";
  #frame = 0;

  /**
   * @param {HTMLElement} element
   * @param {About} about
   * @param {Source} source
   * @param {State} state
   * @param {Told} told
   */
  constructor(element, about, source, state, told) {
    this.#element = element;
    this.#about = about;
    this.#state = state;
    this.#told = told;
    this.picture.canvas.className = "picture";
    element.append(html("div", { class: "ground" }), this.picture.canvas, this.overlay);
    this.#refresh = new Refresh(
      source,
      (...answer) => this.#take(...answer),
      (...problem) => this.#refuse(...problem),
      (name) => about.bases.find((base) => base.name === name)?.cost ?? 0,
    );
    this.#lineRequests = new Latest((/** @type {View} */ view) => this.#askLines(source, view));
    this.#listen();
    new ResizeObserver(() => this.show(this.#state)).observe(element);
  }

  /** The position of the picture in the element, in CSS pixels. */
  get plot() {
    const { clientWidth, clientHeight } = this.#element;
    const narrow = clientWidth < 520;
    const [left, right] = narrow ? [54, 8] : [72, 18];
    const top = legendHeight(quantityOf(this.#about, this.#state.quantity), clientWidth - left - right);
    return {
      left,
      top,
      right,
      width: Math.max(40, Math.floor(clientWidth - left - right)),
      height: Math.max(40, Math.floor(clientHeight - top - 50)),
    };
  }

  /** The size of the picture in device pixels. */
  get size() {
    const { width, height } = this.plot;
    const density = window.devicePixelRatio || 1;
    return { width: Math.round(width * density), height: Math.round(height * density) };
  }

  /** Whether zoom has reached its limit, for each axis. */
  get atEnd() {
    const { view } = this.#state;
    const { width, height } = this.size;
    return (
      view.x.half <= leastHalf(view.x, width) * 1.001 || view.y.half <= leastHalf(view.y, height) * 1.001
    );
  }

  /**
   * Show a state: immediately what is known, then the answers to new requests.
   * @param {State} state
   */
  show(state) {
    const recoloured = String(state.range) !== String(this.#state.range);
    this.#state = state;
    if (recoloured) this.picture.colour(state.range);
    this.#ask();
    this.redraw();
  }

  /**
   * Return a start to begin with: the unstable one nearest to the middle of the lower right quarter, or else the
   * nearest with numbers; null until the picture belongs to the state.
   * @returns {Point|null}
   */
  firstStart() {
    if (!this.#isOfState()) return null;
    const { view } = this.#state;
    const steps = Array.from({ length: 19 }, (_, i) => (i - 9) / 10);
    /** @type {Place[]} */
    const places = steps.flatMap((up) => steps.map((across) => /** @type {Place} */ ([across, up])));
    const near = places.toSorted((a, b) => distance(a, BEGIN) - distance(b, BEGIN));
    const seen = near.filter((place) => this.picture.codeAt(view, ...place) !== null);
    const place = seen.find((each) => this.picture.at(view, ...each)?.verdict === UNSTABLE) ?? seen[0];
    return place ? this.#pointAt(place, true) : null;
  }

  /** Repeat all requests for what is shown. */
  again() {
    this.#asked = "";
    this.show(this.#state);
  }

  /** Draw in the next frame. */
  redraw() {
    cancelAnimationFrame(this.#frame);
    this.#frame = requestAnimationFrame(() => this.#draw());
  }

  #draw() {
    const { view, points, compare, hidden, quantity } = this.#state;
    const { plot, size } = this;
    const { canvas } = this.picture;
    this.picture.draw(view, size.width, size.height);
    const ground = /** @type {HTMLElement} */ (canvas.previousElementSibling);
    for (const { style } of [canvas, ground]) {
      [style.left, style.top] = [`${plot.left}px`, `${plot.top}px`];
      [style.width, style.height] = [`${plot.width}px`, `${plot.height}px`];
    }
    const { atlas } = this.#about;
    const coloured = this.picture.quantity ?? quantityOf(this.#about, quantity);
    drawOverlay(this.overlay, {
      view,
      plot,
      x: parameterOf(this.#about, view.x.name),
      y: parameterOf(this.#about, view.y.name),
      quantity: coloured,
      range: this.picture.range,
      undecided: this.picture.hasUndecided,
      lines: this.lines.filter((line) => !hidden.includes(line.name)),
      stale: this.#linesOf !== wordsOf(view),
      codeAt: (across, up) => this.picture.codeAt(view, across, up),
      regions: coloured.flags ?? quantityOf(this.#about, "stability").flags ?? {},
      points: [points[0], compare ? points[1] : null],
      grid: atlas && this.picture.hasStoredCells ? { x: atlas.x, y: atlas.y } : null,
      cursor: document.activeElement === this.#element ? this.#cursor : null,
    });
  }

  /** Request what is not shown yet. */
  #ask() {
    const { view, quantity, stored } = this.#state;
    const wanted = { view, quantity, stored, ...this.size };
    const key = JSON.stringify(wanted);
    if (key === this.#asked) return;
    this.#asked = key;
    this.#element.setAttribute("aria-busy", "true");
    this.#refresh.ask(wanted);
    this.#lineRequests.ask(view);
  }

  /**
   * @param {Wanted} wanted
   * @param {WindowAnswer} answer
   * @param {"coarse"|"fine"} lane
   */
  #take(wanted, answer, lane) {
    const key = JSON.stringify(wanted);
    const now = key === this.#asked;
    const { dataset } = this.#element;
    // a coarse picture is useless if the fine one is there, for its own view or for the one that is wanted now
    const isOfUse = dataset.lane !== "fine" || (dataset.shown !== key && dataset.shown !== this.#asked);
    if (lane === "coarse" && !isOfUse) return;
    this.picture.take(wanted.view, quantityOf(this.#about, wanted.quantity), answer, this.#state.range);
    dataset.shown = key;
    dataset.lane = lane;
    if (now && lane === "fine") this.#element.setAttribute("aria-busy", "false");
    this.#draw();
    this.#told.onShown();
  }

  /**
   * Handle the refusal of a window: remove a picture of another plane or quantity, so that it does not stay under the
   * new axes.
   * @param {Error} problem
   * @param {"coarse"|"fine"} lane
   */
  #refuse(problem, lane) {
    const { dataset } = this.#element;
    if (!this.#isOfState()) {
      this.picture.drop();
      delete dataset.shown;
      delete dataset.lane;
    }
    if (lane === "fine") this.#element.setAttribute("aria-busy", "false");
    this.redraw();
    this.#told.onProblem(problem);
  }

  /** Return whether the picture has the plane, the words and the quantity of the state. */
  #isOfState() {
    const { view, quantity } = this.#state;
    const { view: shown, quantity: colour } = this.picture;
    if (!shown || colour?.name !== quantity) return false;
    return (
      wordsOf(shown) === wordsOf(view) &&
      between(shown.x, view.x) !== null &&
      between(shown.y, view.y) !== null
    );
  }

  /**
   * @param {Source} source
   * @param {View} view
   */
  async #askLines(source, view) {
    try {
      this.lines = await source.lines(view);
      this.#linesOf = wordsOf(view);
      this.linesProblem = null;
    } catch (problem) {
      // errors in the view are reported by its window
      this.linesProblem = mayPass(/** @type {any} */ (problem)) ? /** @type {Error} */ (problem) : null;
      this.lines = [];
    }
    this.picture.showBorders(this.lines.length === 0, this.#state.range);
    this.redraw();
    this.#told.onLines();
  }

  #listen() {
    /** @type {Deeds} */
    const deeds = {
      zoom: (factor, across, up) => this.#zoom(factor, across, up),
      move: (across, up) => this.#move(across, up),
      choose: (place, second, tapped) => this.#told.onChoose(this.#aimAt(place, false, true), second, tapped),
      hover: (place) => this.#told.onAim(place && this.#aimAt(place, false)),
      reset: (chosen) => this.#told.onReset(chosen),
    };
    new Gestures(this.#element, () => this.plot, deeds);
    listenToKeys(this.#element, deeds, {
      get: () => this.#cursor ?? [0, 0],
      set: (place) => this.#setCursor(place),
      cell: () => [2 / CELLS[0], 2 / CELLS[1]],
    });
    this.#element.addEventListener("focus", () => this.redraw());
    this.#element.addEventListener("blur", () => this.redraw());
  }

  /** @param {Place} place */
  #setCursor(place) {
    this.#cursor = place;
    this.redraw();
    this.#told.onAim(this.#aimAt(place, true));
  }

  /**
   * @param {Place} place
   * @param {boolean} chosen  whether the start is chosen: it gets no more digits than its pixel needs
   * @returns {Point}
   */
  #pointAt([across, up], chosen) {
    const { x, y } = this.#state.view;
    const { width, height } = this.plot;
    const at = (/** @type {Axis} */ axis, /** @type {number} */ place, /** @type {number} */ count) =>
      chosen
        ? roundestAt(axis, place, count, parameterOf(this.#about, axis.name).factor)
        : valueAt(axis, place);
    return { x: at(x, across, width), y: at(y, up, height) };
  }

  /**
   * @param {Place} place
   * @param {boolean} keys
   * @param {boolean} [chosen]
   * @returns {Aim}
   */
  #aimAt(place, keys, chosen = false) {
    return { point: this.#pointAt(place, chosen), shown: this.picture.at(this.#state.view, ...place), keys };
  }

  /**
   * @param {number} factor
   * @param {number|null} across
   * @param {number|null} up
   */
  #zoom(factor, across, up) {
    const { view } = this.#state;
    const { width, height } = this.size;
    const x = across === null ? view.x : zoomed(view.x, factor, across, this.#limits("x", width));
    const y = up === null ? view.y : zoomed(view.y, factor, up, this.#limits("y", height));
    this.#told.onView({ ...view, x, y });
  }

  /**
   * @param {number} across
   * @param {number} up
   */
  #move(across, up) {
    const { view } = this.#state;
    this.#told.onView({ ...view, x: moved(view.x, across), y: moved(view.y, up) });
  }

  /**
   * @param {"x"|"y"} which
   * @param {number} pixels
   */
  #limits(which, pixels) {
    const axis = this.#state.view[which];
    const most = BEYOND * halfOfRange(this.#about, this.#state.view, which);
    return { least: leastHalf(axis, pixels), most };
  }
}

/**
 * @param {Place} one
 * @param {Place} other
 */
function distance(one, other) {
  return Math.hypot(one[0] - other[0], one[1] - other[1]);
}

/**
 * What the picture shows at a place; with the origin "none" there is neither value nor verdict.
 * @typedef {{value: number, verdict: number, origin: "computed"|"stored"|"none"}} Seen
 */

/** @type {Seen["origin"][]} indexed by the codes of a window */
const ORIGINS = ["computed", "stored", "none"];

export class Picture {
  /** The element that shows the picture; its size is in device pixels. */
  canvas = document.createElement("canvas");
  /** @type {View|null} */
  view = null;
  /** @type {WindowAnswer|null} */
  answer = null;
  /** @type {Quantity|null} */
  quantity = null;
  /** @type {Range} */
  range = { low: 0, high: 1, scale: "linear" };
  /** Whether undecided cells are grey among the colours of numbers. */
  hasUndecided = false;
  #hasBorders = false;
  #colours = document.createElement("canvas");

  /**
   * Show the newest window.
   * @param {View} view
   * @param {Quantity} quantity
   * @param {WindowAnswer} answer
   * @param {[number, number]|null} held  ends of the colour scale; null fits them to the window
   */
  take(view, quantity, answer, held) {
    [this.view, this.quantity, this.answer] = [view, quantity, answer];
    this.colour(held);
  }

  /**
   * Choose whether to paint the borders between stable and unstable cells, for maps without lines that show them.
   * @param {boolean} hasBorders
   * @param {[number, number]|null} held
   */
  showBorders(hasBorders, held) {
    if (hasBorders === this.#hasBorders) return;
    this.#hasBorders = hasBorders;
    this.colour(held);
  }

  /** Show nothing until the next window. */
  drop() {
    this.view = this.answer = this.quantity = null;
    this.range = { low: 0, high: 1, scale: "linear" };
  }

  /**
   * Colour the window again.
   * @param {[number, number]|null} held
   */
  colour(held) {
    if (!this.answer || !this.quantity) return;
    const { width, height, value, head } = this.answer;
    this.range = held
      ? rangeFor(this.quantity, held[0], held[1])
      : rangeFor(this.quantity, head.low, head.high, head.least);
    if (this.#colours.width !== width || this.#colours.height !== height) {
      this.#colours.width = width;
      this.#colours.height = height;
    }
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    paint(pixels, value, width, height, this.quantity, this.range);
    this.hasUndecided = this.quantity.flags === null && markVerdicts(pixels, this.answer, this.#hasBorders);
    context(this.#colours).putImageData(image, 0, 0);
  }

  /**
   * Draw the window where it lies in a view. A window with other axes fills the view until the new one arrives.
   * @param {View} view
   * @param {number} width  in device pixels
   * @param {number} height
   */
  draw(view, width, height) {
    if (this.canvas.width !== width || this.canvas.height !== height) {
      this.canvas.width = width;
      this.canvas.height = height;
    }
    const drawing = context(this.canvas);
    drawing.clearRect(0, 0, width, height);
    if (!this.answer || !this.view) return;
    const x = between(this.view.x, view.x) ?? [1, 0];
    const y = between(this.view.y, view.y) ?? [1, 0];
    // show cells as cells: enlarged pixels are smoothed only in a preview
    drawing.imageSmoothingEnabled = this.answer.stored === null;
    const [left, right] = [x[1] - x[0], x[1] + x[0]].map((place) => ((place + 1) / 2) * width);
    const [bottom, top] = [y[1] - y[0], y[1] + y[0]].map((place) => ((1 - place) / 2) * height);
    drawing.drawImage(this.#colours, left, top, right - left, bottom - top);
  }

  /**
   * Return value, verdict and origin at a place of the present view, from the window that is shown; null outside.
   * @param {View} view
   * @param {number} across  place along x
   * @param {number} up  place along y
   * @returns {Seen|null}
   */
  at(view, across, up) {
    if (!this.answer || !this.view) return null;
    const x = between(view.x, this.view.x);
    const y = between(view.y, this.view.y);
    if (!x || !y) return null;
    const { width, height, value, verdict, stored } = this.answer;
    const column = Math.floor(((x[1] + x[0] * across + 1) / 2) * width);
    const row = Math.floor(((y[1] + y[0] * up + 1) / 2) * height);
    if (column < 0 || row < 0 || column >= width || row >= height) return null;
    const index = row * width + column;
    return {
      value: value[index],
      verdict: verdict[index],
      origin: stored === null ? "computed" : ORIGINS[stored[index]],
    };
  }

  /**
   * Return the code of the region at a place of the present view: of a quantity with flags, otherwise the verdict; null
   * if there is none.
   * @param {View} view
   * @param {number} across
   * @param {number} up
   */
  codeAt(view, across, up) {
    const seen = this.at(view, across, up);
    if (!seen || seen.origin === "none" || Number.isNaN(seen.value)) return null;
    return this.quantity?.flags ? seen.value : seen.verdict;
  }

  /** Whether some of its cells are stored ones. */
  get hasStoredCells() {
    return this.answer?.stored?.includes(1) ?? false;
  }
}

/**
 * @param {HTMLCanvasElement} canvas
 * @returns {CanvasRenderingContext2D}
 */
function context(canvas) {
  const found = canvas.getContext("2d");
  if (!found) throw new Error("This browser cannot draw on a canvas.");
  return found;
}
