/**
 * The WebAssembly module of a worker: its entry points, and the memory that contains their arrays.
 *
 * A part of the worker's script (worker.js), which finds the class by its name.
 */

/** Address at which the stack of a module starts, and after it the memory for arrays (kernels/native/wasm.py). */
const STACK = 1 << 18;

/** Alignment of arrays in bytes. */
const LINE = 64;

const PAGE = 65536;

/** Name of the section of a module that describes how its functions are called. */
const NOTE = "eulerdisk";

const VIEWS = { float64: Float64Array, int64: BigInt64Array, int32: Int32Array };

/** @typedef {keyof typeof VIEWS} Element */
/** @typedef {{at: number, element: Element, shape: number[], count: number}} Block an array in the module's memory */
/** @typedef {Kernels} KernelModule */

/**
 * The contents of the module's note; see kernels/page/sizes.py.
 * @typedef {object} Note
 * @property {Record<string, {arguments: [string, Element, number][], results: string[]}>} entries
 * @property {Record<string, number[][]>} memory
 * @property {number} chunk
 */

/** Entry points of a module, and the memory that contains their arrays. */
class Kernels {
  #functions;
  #memory = new WebAssembly.Memory({ initial: 16 });
  /** End of the used memory; resetting it frees everything created since. */
  top = STACK;
  #returned;

  /** @param {WebAssembly.Module} module */
  constructor(module) {
    const [section] = WebAssembly.Module.customSections(module, NOTE);
    /** @type {Note} */
    this.note = JSON.parse(new TextDecoder().decode(section));
    const { exports } = new WebAssembly.Instance(module, {
      env: {
        __linear_memory: this.#memory,
        __stack_pointer: new WebAssembly.Global({ value: "i32", mutable: true }, STACK),
        __indirect_function_table: new WebAssembly.Table({ initial: 64, element: "anyfunc" }),
      },
    });
    this.#functions = /** @type {Record<string, (...given: any[]) => any>} */ (exports);
    // the results of an entry point, and the place where it would record an exception
    this.#returned = this.array("float64", 16);
  }

  /**
   * Return a new array, not initialised.
   * @param {Element} element
   * @param {...number} shape
   * @returns {Block}
   */
  array(element, ...shape) {
    const count = shape.reduce((product, size) => product * size, 1);
    const at = this.top;
    this.top = Math.ceil((at + count * VIEWS[element].BYTES_PER_ELEMENT) / LINE) * LINE;
    const missing = this.top - this.#memory.buffer.byteLength;
    if (missing > 0) this.#memory.grow(Math.ceil(missing / PAGE));
    return { at, element, shape, count };
  }

  /**
   * Return the numbers of an array: valid until the next array is created, which may move the memory.
   * @param {Block} block
   * @returns {any}
   */
  numbers({ at, element, count }) {
    return new VIEWS[element](this.#memory.buffer, at, count);
  }

  /**
   * Return the rows of an array: valid until the next array is created.
   * @param {Block} block  of two dimensions
   * @returns {any[]}
   */
  rows(block) {
    const [rows, count] = block.shape;
    const numbers = this.numbers(block);
    return Array.from({ length: rows }, (_, i) => numbers.subarray(i * count, (i + 1) * count));
  }

  /**
   * Return the working memory that is an entry point's last arguments.
   * @param {string} name
   */
  memoryOf(name) {
    const shapes = this.note.memory[name];
    const types = this.note.entries[name].arguments.slice(-shapes.length);
    return shapes.map((shape, i) => this.array(types[i][1], ...shape));
  }

  /**
   * Call an entry point; return its numbers.
   * @param {string} name
   * @param {...(number|bigint|Block)} values
   * @returns {number[]}
   */
  call(name, ...values) {
    const { arguments: wanted, results } = this.note.entries[name];
    const passed = values.flatMap((value, i) => passedAs(value, wanted[i][1]));
    const { at } = this.#returned;
    if (this.#functions[name](at, at + 64, ...passed)) throw new Error(`The kernel ${name} failed.`);
    const told = new DataView(this.#memory.buffer, at);
    return results.map((type, i) =>
      type === "float64" ? told.getFloat64(8 * i, true) : Number(told.getBigInt64(8 * i, true)),
    );
  }

  /**
   * Call an entry point for `cells` cells, with a counter of the chunks that it has taken.
   * @param {string} name
   * @param {number} cells
   * @param {...(number|bigint|Block)} values
   */
  treat(name, cells, ...values) {
    const counter = this.array("int64", 1);
    this.numbers(counter)[0] = 0n;
    this.call(name, counter, cells, this.note.chunk, 1, ...values);
  }
}

/**
 * Return the numbers by which a value is passed; for an array, two references, its size, the size of a number, its
 * address, its shape, and its strides in bytes.
 * @param {number|bigint|Block} value
 * @param {Element} element
 */
function passedAs(value, element) {
  if (typeof value !== "object") return [element === "int64" ? BigInt(value) : value];
  const size = VIEWS[value.element].BYTES_PER_ELEMENT;
  const strides = value.shape.map((_, i) => value.shape.slice(i + 1).reduce((a, b) => a * b, size));
  return [0, 0, ...[value.count, size].map(BigInt), value.at, ...[...value.shape, ...strides].map(BigInt)];
}

Object.assign(self, { Kernels });
