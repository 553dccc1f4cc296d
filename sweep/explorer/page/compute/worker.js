/**
 * The computation in a worker of the page: cells and motions, by the program's kernels compiled to WebAssembly.
 *
 * The last of several scripts, because browsers do not let a page from a file create a worker from modules. It answers
 * one message after the other (computation.js).
 */

/** @import { Block, KernelModule } from "eulerdisk/compute/kernels" */
/** @import { Axis, BodyPlan, Plan, SystemPlan } from "eulerdisk/types" */

/** The largest code of a quantity; the next one means no value. */
const MOST_CODE = 254;

/** Rows that the reduction writes (kernels/bodies/arrays.py). */
const MEASURES = ["tilt_min", "tilt_max", "nutation_period", "separatrix", "tilt_error"];
const COUNTS = ["ending"];

/** The quantity that is derived from the wells (sweep/explorer/quantities.py). */
const REGIME = "regime";

/** Number of the torus; the thin disk is a torus without a tube (kernels/bodies/shapes.py). */
const TORUS = 0;

/** @typedef {Float64Array|Int32Array|Uint8Array} Values */
/** @typedef {Record<string, Values>} Columns */

const scope = /** @type {any} */ (self);
/** @type {(plan: Plan, judged: Columns, ending: Values, count: number) => Uint8Array} */
const verdicts = scope.verdicts;
/** @type {(plan: Plan, starts: Columns, measured: Columns, count: number, wanted?: string) => Columns} */
const diskColumns = scope.diskColumns;
/** @type {(plan: SystemPlan, starts: Columns, measured: Columns, count: number) => Columns} */
const systemColumns = scope.systemColumns;

/**
 * Return whether cells are those of a user's system.
 * @param {Plan} plan
 * @returns {plan is SystemPlan}
 */
function isOfSystem(plan) {
  return "system" in plan;
}

/**
 * Return whether cells are those of a body other than the thin disk.
 * @param {Plan} plan
 * @returns {plan is BodyPlan}
 */
function isOfBody(plan) {
  return "body" in plan;
}

/**
 * Return whether the wells of cells are needed, which take longer than everything else.
 * @param {Plan} plan
 * @param {string} [wanted]  the only column that is needed besides the verdict
 */
function needsWells(plan, wanted) {
  const needed = wanted ? [wanted, ...plan.criterion.named] : plan.shown;
  return plan.shown.includes(REGIME) && [REGIME, "wells"].some((name) => needed.includes(name));
}

/** Cells of a model: their starts, the kernels' measures, and the columns that follow. */
class Cells {
  #kernels;
  #reducing;
  #counting;
  #meeting;
  #paths;
  #base;

  /** @param {KernelModule} kernels */
  constructor(kernels) {
    this.#kernels = kernels;
    // the module of a system has only its own kernel
    const memoryOf = (/** @type {string} */ name) =>
      name in kernels.note.entries ? kernels.memoryOf(name) : [];
    this.#reducing = memoryOf("reduce");
    this.#counting = memoryOf("wells");
    this.#meeting = memoryOf("contact");
    this.#paths = new scope.Paths(kernels);
    this.#base = kernels.top;
  }

  /**
   * Return all columns of some cells, including their starts: valid until the next call.
   * @param {Plan} plan
   * @param {Columns} given  the parameters that are not held constant, by name
   * @param {number} count
   * @param {boolean} timed  whether periods and contact forces are needed
   * @param {string} [wanted]  the only column that is needed besides the verdict
   * @returns {Columns}
   */
  columns(plan, given, count, timed, wanted) {
    const kernels = this.#kernels;
    kernels.top = this.#base;
    const { parameters } = plan;
    const block = this.#starts(plan, given, count);
    if (isOfSystem(plan)) {
      const measured = this.#integrated(plan, block, count);
      const starts = this.#columns(block, parameters);
      const found = systemColumns(plan, starts, measured, count);
      for (const name of plan.singles) found[name] &&= found[name].map(Math.fround);
      return { ...starts, ...found, stability: verdicts(plan, { ...starts, ...found }, found.ending, count) };
    }
    const body = isOfBody(plan) ? [plan.body.number, plan.body.hollow, ...plan.body.follows] : [];
    kernels.call("complete", ...body, ...plan.rates, block);
    const bodies = plan.model === "disk" ? this.#tori(block) : block;
    const number = isOfBody(plan) ? plan.body.number : TORUS;
    const paths = this.#paths.columns(plan, bodies, number, wanted);
    const measured =
      plan.model === "disk" || isOfBody(plan)
        ? this.#reduced(plan, bodies, number, count, timed, wanted)
        : this.#integrated(plan, block, count);
    const starts = this.#columns(block, parameters);
    return diskColumns(plan, starts, { ...paths, ...measured }, count, wanted);
  }

  /**
   * Return the samples of a motion of a system: the columns of a cell that is followed until each of some times.
   * @param {SystemPlan} plan
   * @param {Columns} given  values of one cell
   * @param {Float64Array} times  from 0 to the duration
   * @returns {Columns}
   */
  samples(plan, given, times) {
    this.#kernels.top = this.#base;
    const block = this.#starts(plan, given, 1);
    const values = this.#kernels.rows(block).map(([value]) => value);
    const measured = this.#integrated(plan, block, times.length, times);
    const starts = plan.parameters.map((name, i) => [name, new Float64Array(times.length).fill(values[i])]);
    return systemColumns(plan, Object.fromEntries(starts), measured, times.length);
  }

  /**
   * Return the starts of some cells.
   * @param {Plan} plan
   * @param {Columns} given
   * @param {number} count
   */
  #starts({ parameters, held }, given, count) {
    const block = this.#kernels.array("float64", parameters.length, count);
    this.#kernels.rows(block).forEach((row, i) => {
      const values = given[parameters[i]];
      if (values) row.set(values);
      else row.fill(held[parameters[i]] ?? Infinity);
    });
    return block;
  }

  /**
   * Return thin disks as bodies: tori without a tube, whose moments are alpha and half of it.
   * @param {Block} disks
   */
  #tori(disks) {
    const kernels = this.#kernels;
    const tori = kernels.array("float64", 13, disks.shape[1]);
    const [tilt, tilt_rate, precession_rate, roll_rate, alpha, radius, gravity] = kernels.rows(disks);
    const none = new Float64Array(disks.shape[1]);
    // a body cannot have more mass outside than a hoop
    const half = alpha.map((/** @type {number} */ each) => (each <= 1 ? 0.5 * each : NaN));
    const lengths = [none, none, none, none, none];
    const rows = [tilt, tilt_rate, precession_rate, roll_rate, ...lengths, alpha, half, radius, gravity];
    kernels.rows(tori).forEach((row, i) => row.set(rows[i]));
    return tori;
  }

  /**
   * Return cells from the reduction; cells whose error exceeds the tolerance are unresolved.
   * @param {Plan} plan
   * @param {Block} bodies
   * @param {number} number  of the body
   * @param {number} count
   * @param {boolean} timed
   * @param {string} [wanted]
   * @returns {Columns}
   */
  #reduced(plan, bodies, number, count, timed, wanted) {
    const kernels = this.#kernels;
    const wells = needsWells(plan, wanted) ? this.#wells(bodies, number, count) : null;
    const measures = kernels.array("float64", MEASURES.length, count);
    const counts = kernels.array("int32", COUNTS.length, count);
    const { fall_tilt, tolerance } = plan.settings;
    const settings = [number, fall_tilt, timed ? 1 : 0];
    kernels.treat("reduce", count, bodies, ...settings, measures, counts, ...this.#reducing);
    /** @type {() => Columns} */
    const reduced = () => ({
      ...this.#columns(measures, MEASURES),
      ...this.#columns(counts, COUNTS),
      ...(wells && { wells }),
    });
    const {
      tilt_min: least,
      tilt_max: greatest,
      nutation_period: period,
      tilt_error: error,
      ending,
    } = reduced();
    for (let i = 0; i < count; i += 1) {
      if (!(error[i] > tolerance)) continue;
      least[i] = greatest[i] = period[i] = error[i] = NaN;
      ending[i] = plan.unresolved;
    }
    if (!(plan.contact && timed)) return reduced();
    const met = this.#met(plan, bodies, number, count);
    return { ...reduced(), ...met };
  }

  /**
   * Return the number of wells of each cell's potential.
   * @param {Block} bodies
   * @param {number} number  of the body
   * @param {number} count
   */
  #wells(bodies, number, count) {
    const kernels = this.#kernels;
    const wells = kernels.array("int64", count);
    kernels.treat("wells", count, bodies, number, wells, ...this.#counting);
    return Int32Array.from(kernels.numbers(wells), Number);
  }

  /**
   * Return rows of an array by their names: valid until the next array is created.
   * @param {Block} block
   * @param {string[]} names
   * @returns {Columns}
   */
  #columns(block, names) {
    return Object.fromEntries(this.#kernels.rows(block).map((row, i) => [names[i], row]));
  }

  /**
   * Return the extremes of the contact forces.
   * @param {Plan} plan
   * @param {Block} bodies
   * @param {number} number  of the body
   * @param {number} count
   * @returns {Columns}
   */
  #met(plan, bodies, number, count) {
    const kernels = this.#kernels;
    const extremes = kernels.array("float64", 2, count);
    const states = kernels.array("int64", count);
    const { fall_tilt } = plan.settings;
    kernels.treat("contact", count, bodies, number, fall_tilt, extremes, states, ...this.#meeting);
    const contact_state = Int32Array.from(kernels.numbers(states), Number);
    return { ...this.#columns(extremes, ["least_normal_force", "friction_needed"]), contact_state };
  }

  /**
   * Return cells with losses or of a system, integrated in time; or a cell of a system at some times.
   * @param {Plan} plan
   * @param {Block} starts
   * @param {number} count  of the cells, or of the times
   * @param {Float64Array|null} [times]
   * @returns {Columns}
   */
  #integrated(plan, starts, count, times = null) {
    const kernels = this.#kernels;
    const { measures: names, counts: counted } = plan;
    const [measures, counts] = [
      kernels.array("float64", names.length, count),
      kernels.array("int32", counted.length, count),
    ];
    const settings = kernels.array("float64", plan.kernel_settings.length);
    kernels.numbers(settings).set(plan.kernel_settings);
    if (times) {
      const at = kernels.array("float64", count);
      kernels.numbers(at).set(times);
      // a pass after a failed one writes nothing
      kernels.numbers(counts).fill(plan.unresolved);
      kernels.numbers(measures).fill(NaN);
      kernels.treat("follow", 1, starts, settings, at, measures, counts, ...kernels.memoryOf("follow"));
    } else {
      const name = isOfSystem(plan) ? "integrate" : "lossy_integrate";
      kernels.treat(name, count, starts, settings, measures, counts, ...kernels.memoryOf(name));
    }
    return { ...this.#columns(measures, names), ...this.#columns(counts, counted) };
  }
}

/**
 * Return the values of a side of a window at the centres of some of its pixels.
 * @param {{axis: Axis, count: number, from: number, to: number}} side
 */
function valuesOf({ axis, count, from, to }) {
  return Float64Array.from({ length: to - from }, (_, i) => {
    const at = axis.centre + axis.half * ((2 * (from + i) + 1) / count - 1);
    return axis.scale === "log" ? Math.exp(at) : at;
  });
}

/**
 * Return the values of columns in the order of rows.
 * @template {Float64Array|Float32Array|Uint8Array|Int32Array} T
 * @param {T} values
 * @param {number} width
 * @param {number} height
 */
function byRows(values, width, height) {
  const turned = /** @type {T} */ (values.slice());
  for (let x = 0; x < width; x += 1) {
    for (let y = 0; y < height; y += 1) turned[y * width + x] = values[x * height + y];
  }
  return turned;
}

/**
 * Return a piece of a window: values of a quantity, verdicts, and the range of the values.
 * @param {Cells} cells
 * @param {any} asked
 */
function piece(cells, { plan, x, y, quantity, timed, byColumns }) {
  const [across, up] = [valuesOf(x), valuesOf(y)];
  const [inner, outer] = byColumns ? [up, across] : [across, up];
  const count = inner.length * outer.length;
  const [quick, slow] = [new Float64Array(count), new Float64Array(count)];
  for (let i = 0; i < outer.length; i += 1) {
    quick.set(inner, i * inner.length);
    slow.fill(outer[i], i * inner.length, (i + 1) * inner.length);
  }
  const [columns, rows] = byColumns ? [slow, quick] : [quick, slow];
  const given = { [x.axis.name]: columns, [y.axis.name]: rows };
  const found = cells.columns(plan, given, count, timed, quantity);
  const turn = (/** @type {any} */ values) =>
    byColumns ? byRows(values, across.length, up.length) : values.slice();
  const [value, verdict] = [turn(found[quantity]), turn(found.stability)];
  const most = value instanceof Uint8Array ? MOST_CODE : Number.MAX_VALUE;
  let [low, high, least] = [Infinity, -Infinity, Infinity];
  for (let i = 0; i < count; i += 1) {
    const each = value[i];
    // false for NaN
    if (!(Math.abs(each) <= most)) continue;
    if (each < low) low = each;
    if (each > high) high = each;
    if (each > 0 && each < least) least = each;
  }
  return { value, verdict, low, high, least };
}

/**
 * Call an entry point with numbers and arrays; return its results, and the arrays after the call.
 * @param {KernelModule} kernels
 * @param {{name: string, values: (number|{shape: number[], numbers: Float64Array})[]}} asked
 */
function called(kernels, { name, values }) {
  const blocks = values.map((value) =>
    typeof value === "number" ? value : kernels.array("float64", ...value.shape),
  );
  values.forEach((value, i) => {
    const block = blocks[i];
    if (typeof value !== "number" && typeof block !== "number") kernels.numbers(block).set(value.numbers);
  });
  const results = kernels.call(name, ...blocks);
  const arrays = blocks.map((block) => (typeof block === "number" ? null : kernels.numbers(block).slice()));
  return { results, arrays };
}

let /** @type {Cells} */ cells, /** @type {KernelModule} */ kernels;

/** @type {Record<string, (asked: any) => object>} */
const ANSWERS = {
  begin: ({ module }) => {
    kernels = new scope.Kernels(module);
    cells = new Cells(kernels);
    return {};
  },
  piece: (asked) => piece(cells, asked),
  cells: ({ plan, given, count }) => {
    const found = cells.columns(plan, given, count, true);
    return Object.fromEntries(Object.entries(found).map(([name, values]) => [name, values.slice()]));
  },
  samples: ({ plan, given, times }) => {
    const found = cells.samples(plan, given, times);
    return Object.fromEntries(Object.entries(found).map(([name, values]) => [name, values.slice()]));
  },
  call: (asked) => {
    const { top } = kernels;
    const found = called(kernels, asked);
    kernels.top = top;
    return found;
  },
};

self.onmessage = ({ data: { id, what, asked } }) => {
  try {
    const found = ANSWERS[what](asked);
    const buffers = Object.values(found).flatMap((each) => (ArrayBuffer.isView(each) ? [each.buffer] : []));
    self.postMessage({ id, found }, { transfer: [...new Set(buffers)] });
  } catch (problem) {
    self.postMessage({ id, problem: String(problem) });
  }
};
