/**
 * The messages between the page and the server, as types only: this module contains no code.
 *
 * Values are in SI units; a value times `factor` is the displayed number, in `unit`. The value at a pixel is centre +
 * half * ((2 i + 1) / n - 1) along each axis; on an axis with the scale "log", this is its natural logarithm.
 *
 * @module types
 */

/** @import { Standpoint } from "eulerdisk/motion/disk_scene" */
/** @import { Reach } from "eulerdisk/server_source" */

/**
 * One axis of a window: the range from centre - half to centre + half, with the scale "log" of the natural logarithm.
 * @typedef {{name: string, centre: number, half: number, scale: "linear"|"log"}} Axis
 */

/**
 * What the map shows. `words` contains the differences from the base: numbers in SI units, or words as on the command
 * line.
 * @typedef {{base: string, words: Record<string, number|string>, x: Axis, y: Axis}} View
 */

/**
 * A parameter that can be an axis or a slider. `low` and `high` are the ends of its slider, which do not limit the
 * parameter; null if it has no slider. `control` says whether the boundary is sought along it.
 * @typedef {object} Parameter
 * @property {string} name
 * @property {string} label  name in words, for an axis
 * @property {string} description
 * @property {string} unit  displayed unit; empty for a pure number
 * @property {number} factor
 * @property {number|null} low
 * @property {number|null} high
 * @property {number|null} least  end of the allowed range; null if there is none
 * @property {number|null} most
 * @property {"linear"|"log"} scale
 * @property {boolean} control
 * @property {string[]} words  words allowed instead of a number
 */

/**
 * A quantity that colours a map. `flags` maps each code of an enumerated quantity to its description; `is_peak` says
 * whether figures colour maps by it, always in equal steps of its logarithm.
 * @typedef {object} Quantity
 * @property {string} name
 * @property {string} label
 * @property {string} description
 * @property {string} unit
 * @property {number} factor
 * @property {Record<string, string>|null} flags
 * @property {boolean} is_peak
 */

/**
 * A criterion with one limit. It is written as `word:limit unit`, for instance "departure:5deg".
 * @typedef {object} Criterion
 * @property {string} word
 * @property {string} description
 * @property {string} unit
 * @property {number} low  end of its slider, in `unit`
 * @property {number} high  end of its slider, in `unit`
 */

/**
 * A starting point: a preset, or the subject from the command line (its name is ""). `words` contains the value of
 * every parameter that is no axis (a number in SI units, or a word) and of the criterion; `view` shows the whole range
 * of its grid; `quantities` names the quantities that can be shown, the default one first; `rolls` says whether its
 * cells are those of a rolling body instead of a user's system; `cost` is the time per cell in milliseconds, 0 where it
 * is negligible.
 * @typedef {object} Base
 * @property {string} name
 * @property {string} label
 * @property {string} description
 * @property {Record<string, number|string>} words
 * @property {View} view
 * @property {string[]} quantities
 * @property {boolean} rolls
 * @property {number} cost
 */

/**
 * The atlas given to the explorer. Its cells are shown in views that have its words and axes (`stored` of a window).
 * @typedef {object} StoredAtlas
 * @property {string} label  name of the file
 * @property {string} base  the base whose view shows the atlas
 * @property {boolean} live  whether windows can be computed; false for a model without an exact reduction
 * @property {string} note  a sentence that says what is stored and where its resolution ends
 * @property {Axis} x  range of the stored grid
 * @property {Axis} y
 */

/**
 * @typedef {object} About
 * @property {Base[]} bases
 * @property {string[]} others  presets that are integrated in time: they have maps only from atlases
 * @property {Parameter[]} parameters
 * @property {Quantity[]} quantities
 * @property {Criterion[]} criteria
 * @property {string[]} losses  words for the losses of a motion
 * @property {MotionTables} motions
 * @property {StoredAtlas|null} atlas
 */

/**
 * `stored` asks for the cells of the file in the part of the window that shows them, each as a rectangle of pixels.
 * @typedef {object} WindowRequest
 * @property {View} view
 * @property {number} width
 * @property {number} height
 * @property {string} quantity
 * @property {boolean} [stored]
 */

/**
 * Values in rows from the bottom upward, x fastest; NaN where there is no value. `verdict`: 0 undecided, 1 stable, 2
 * unstable. `stored`: 1 for the value of a stored cell, 0 for a computed one, 2 for neither; missing if all values were
 * computed. `end` says that a pixel is below 8 units in the last place, so that zoom ends here. `low`, `high` and
 * `least`, the smallest positive value, are null without such values. `milliseconds` is the time of the computation,
 * without the start of the workers.
 * @typedef {object} WindowAnswer
 * @property {{low: number|null, high: number|null, least: number|null, end: boolean, note?: string}} head
 * @property {number} width
 * @property {number} height
 * @property {Float32Array|Float64Array|Uint8Array} value
 * @property {Uint8Array} verdict
 * @property {Uint8Array|null} stored
 * @property {number} [milliseconds]
 */

/**
 * @typedef {{name: string, label: string, points: number[][][]}} Line  polylines of [x, y]
 */

/**
 * @typedef {{name: string, description: string, text: string, value: number|null}} ShownNumber
 */

/**
 * @typedef {object} PointAnswer
 * @property {Record<string, {value: number, text: string, label?: string}>} start
 * @property {ShownNumber[]} numbers
 * @property {string} verdict
 * @property {PointAnswer|null} stored  the same for the nearest stored cell
 * @property {string} [note]  why there are no numbers
 */

/**
 * @typedef {{view: View, x: number, y: number, losses?: Record<string, number|string>}} Place
 */

/**
 * An array in an exported page: its bytes (little-endian, rows from the bottom upward, x fastest), zlib-compressed,
 * in base64.
 * @typedef {{type: "f4"|"f8"|"u1", data: string}} PackedArray
 */

/**
 * The contents of an exported page, as JSON in <script type="application/json" id="stored">. `about` has one base. For
 * an atlas, `stored` contains x and y, the coordinates of the cells (f8); `cells`, with every stored quantity that
 * `about` lists, "verdict" (u1), and every parameter that cells compute themselves (f8), such as a steady rate; and
 * `starts`, the values of the other parameters that are no axis, and `fall_tilt`.
 * @typedef {object} StoredPage
 * @property {About} about
 * @property {Plans} plans
 * @property {Line[]} lines
 * @property {{x: PackedArray, y: PackedArray, cells: Record<string, PackedArray>, starts: Record<string, number>}|null} stored
 */

/**
 * How the page computes: `cells`, the cells of its map (null if it cannot, for the reason in `refused`); `lossy`, a
 * cell with losses; `disk`, the starts of motions; `motion`, how motions are followed. See sweep/explorer/plan.py.
 * @typedef {object} Plans
 * @property {Plan|null} cells
 * @property {{error: string, hint: string}|null} refused
 * @property {Plan|null} lossy
 * @property {Plan|null} disk
 * @property {MotionPlan|null} motion
 */

/**
 * How cells are computed. `parameters` are the rows of the kernels' array of starts, `held` the values of those that
 * are no axis (null: infinite), `rates` the numbers of the rules for precession and roll rate (kernels/page/starts.py).
 * `from_start` says whether the undisturbed tilt is the tilt of the start; `path` names the columns that describe the
 * path of the contact point, empty if it is not requested. `shown` are the quantities of the map, `timed` those that
 * take longer, `singles` the columns in single precision. `unresolved`, `lost` and `failed` are codes of endings.
 * @typedef {object} Plan
 * @property {string} model
 * @property {string[]} parameters
 * @property {Record<string, number|null>} held
 * @property {number[]} rates
 * @property {boolean} from_start
 * @property {{fall_tilt: number, tolerance: number}} settings
 * @property {number[]} kernel_settings
 * @property {string[]} measures
 * @property {string[]} counts
 * @property {string[]} losses
 * @property {boolean} contact
 * @property {string[]} path
 * @property {number} unresolved
 * @property {number[]} lost
 * @property {number[]} failed
 * @property {string[]} shown
 * @property {string[]} timed
 * @property {string[]} singles
 * @property {ToldNumber[]} starts
 * @property {ToldNumber[]} numbers
 * @property {{text: string, timed: boolean, outcomes: number[][], condition: Condition, named: string[], errors?:
 * Record<string, ErrorRule>}} criterion `outcomes` has three verdicts for each code of an ending: condition true,
 * false, and without a value
 */

/**
 * The largest error of a column's values: the value that each cell states in the column `stated`, multiplied by
 * `times`, plus an absolute and a relative part; unbounded for motions that ended with one of the codes `unknown`. With
 * `by`, the cells state the error of the extremes, and the error of an extreme, an amplification or a time follows from
 * it as in sweep/model/cells.py.
 * @typedef {{by?: "extreme"|"amplified"|"timed", stated?: string, times?: number, rounding?: number, absolute?: number,
 *   relative?: number, unknown?: number[]}} ErrorRule
 */

/**
 * An expression of a system: a number, a name, or an operation with its operands.
 * @typedef {number|string|[string, ...any[]]} Node
 */

/**
 * How cells of a user's system are computed: see sweep/explorer/system.py. The numbers are those of
 * sweep/model/system/passes.py.
 * @typedef {Plan & {system: SystemCells}} SystemPlan
 * @typedef {object} SystemCells
 * @property {string[]} passes
 * @property {string[]} states
 * @property {{name: string, stated: string}[]} state_ends
 * @property {string} end_time
 * @property {number} runs_on
 * @property {string} end_time_stated
 * @property {SystemMeasure[]} measures
 * @property {Node[][]} labels
 * @property {Node[]} conserved
 * @property {string[]} columns
 * @property {string[]} coded  the columns that are codes
 * @property {number} different
 * @property {number} same_time
 * @property {number} same_place
 * @property {number[]} shares
 * @property {number} of_states
 * @property {number} least
 * @property {number} few_steps
 * @property {number} of_times
 * @property {number} rounding
 * @property {number} grown
 * @property {number} unknown
 */

/**
 * A measure of a user's system: see sweep/model/system/definition.py.
 * @typedef {object} SystemMeasure
 * @property {string} name
 * @property {string} stated
 * @property {"max"|"min"|"last"|"mean"|"integral"|"count"|"time"|"value"} kind
 * @property {Node[]} expressions
 * @property {SystemMoment | null} moment
 * @typedef {{kind: "first"|"last"|"max"|"min", of_condition: boolean, expressions: Node[]}} SystemMoment
 */

/**
 * How cells of a body of revolution are computed: see sweep/explorer/body.py.
 * @typedef {Plan & {body: {number: number, shape: string[], hollow: number, follows: number[]}}} BodyPlan
 */

/**
 * A condition: the negation of another one, several joined by a word, or terms with signs between them.
 * @typedef {object} Condition
 * @property {Condition} [not]
 * @property {"and"|"or"} [word]
 * @property {Condition[]} [parts]
 * @property {Term[]} [terms]
 * @property {string[]} [signs]
 */

/**
 * A number, or a column or its magnitude, times a factor.
 * @typedef {{value?: number, name?: string, factor?: number, absolute?: boolean}} Term
 */

/**
 * How a number is displayed.
 * @typedef {object} ToldNumber
 * @property {string} name
 * @property {string} label
 * @property {string} description
 * @property {string} unit
 * @property {number} factor
 * @property {boolean} single
 * @property {Record<string, string>|null} flags
 */

/**
 * How motions are followed: whether the cells have losses, and which; the tilts at which a disk counts as fallen, or as
 * flat.
 * @typedef {object} MotionPlan
 * @property {boolean} lossy
 * @property {number} fall_tilt
 * @property {number} flat_tilt
 * @property {Record<string, number|string|null>} losses
 * @property {{name: string, number: number, called: string, poles: boolean, faced: boolean}|null} body  null for the
 * thin disk
 */

/**
 * A body of revolution: the arc of its meridian in units of the outer radius (kernels/bodies/shapes.py), and its
 * moments of inertia in units of m R^2.
 * @typedef {object} BodyOfMotion
 * @property {string} name
 * @property {string} called
 * @property {number} core
 * @property {number} shift
 * @property {number} edge
 * @property {number} square
 * @property {number} axial
 * @property {number} transverse
 */

/**
 * What all motions share: labels of their arrays, descriptions of endings by their codes, rules of parameters, and the
 * sliders of losses, whose ends are multiples of the quantity by which they are `scaled`.
 * @typedef {object} MotionTables
 * @property {Record<string, Described>} quantities
 * @property {Record<string, string>} disk
 * @property {Record<string, string>} lossy
 * @property {Record<string, string>} body
 * @property {Record<string, string>} ledger
 * @property {Record<string, string>} lossy_body
 * @property {string[]} lossy_parameters
 * @property {string[]} lossy_body_parameters
 * @property {Record<string, ToldNumber & {rule: string}>} rules
 * @property {(Omit<LossControl, "value"> & {scaled?: "one"|"radius"|"damping"})[]} sliders
 * @property {string[]} air_laws
 * @property {string} no_air
 * @property {{air_viscosity: number, air_density: number}} air
 * @property {number} mass
 */

/**
 * The cells at the pixels of a window, to save them.
 * @typedef {{view: View, width: number, height: number, format: "csv"|"netcdf"}} DataRequest
 */

/**
 * The start of a motion, with changes to it. `losses` contains the values of the controls, in SI units.
 * @typedef {object} MotionRequest
 * @property {View} view
 * @property {number} x
 * @property {number} y
 * @property {number|null} [duration]  in seconds; null for the default
 * @property {Record<string, number|string>} [losses]
 */

/**
 * What a person set for a motion: its losses, in SI units; the position of the camera, null for the initial one; and
 * the open parts of its panel, "laws" and "words".
 * @typedef {object} MotionSettings
 * @property {Record<string, number|string>} losses
 * @property {Standpoint|null} camera
 * @property {string[]} open
 */

/**
 * Label and unit of an array, and the factor from SI units to that unit.
 * @typedef {{label: string, unit: string, factor: number}} Described
 */

/**
 * A control of a loss: a logarithmic slider, one end of which omits the word, or a choice.
 * @typedef {object} LossControl
 * @property {string} name
 * @property {string} label
 * @property {string} description
 * @property {string[]} [choices]
 * @property {string} [unit]
 * @property {number} [factor]
 * @property {number} [low]
 * @property {number} [high]
 * @property {number|string|null} value
 * @property {boolean} [idle]  whether the control has no effect with the present values of the others
 * @property {string} [none]  what omitting the word means
 * @property {"low"|"high"} [end]  end of the slider at which the word is omitted
 */

/**
 * See sweep/explorer/motion.py.
 * @typedef {object} MotionHead
 * @property {string} title
 * @property {string} ending
 * @property {string} note
 * @property {boolean} ended
 * @property {boolean} lossy
 * @property {Record<string, number>} start
 * @property {number} alpha  only of the thin disk
 * @property {BodyOfMotion|null} body  null for the thin disk
 * @property {number} radius
 * @property {number} gravity
 * @property {string[]} [states]  of a motion of a system, which has no properties of a rolling body
 * @property {number|null} [doubtful]  time from which its states are too sensitive to be reliable
 * @property {[number, string][]} turns
 * @property {number|null} period
 * @property {number} fall_tilt
 * @property {LossControl[]} losses
 * @property {Record<string, string>|null} ledger
 * @property {Record<string, Described>} quantities
 */

/**
 * A motion: arrays with one value per sample.
 * @typedef {{head: MotionHead, arrays: Record<string, Float64Array>}} MotionAnswer
 */

/**
 * The origin of the page's numbers: a server, or the contents of an exported page.
 * @typedef {object} Source
 * @property {() => Promise<About>} about
 * @property {(request: WindowRequest, signal?: AbortSignal) => Promise<WindowAnswer>} window
 * @property {(view: View) => Promise<Line[]>} lines
 * @property {(place: Place, signal?: AbortSignal) => Promise<PointAnswer>} point
 * @property {(request: MotionRequest, signal?: AbortSignal) => Promise<MotionAnswer>} motion
 * @property {(place: Place) => Promise<string>} explain
 * @property {((point: {x: number, y: number}) => {x: number, y: number}|null)|null} cellAt  the cell that stands for a
 * point, where only stored cells are known; null where there is none
 * @property {((request: object) => Promise<{command: string, python: string}>)|null} command
 * @property {Reach|null} reach  whether a server answers; null without a server
 * @property {((request: DataRequest) => Promise<{blob: Blob, name: string}>)|null} data
 */

export {};
