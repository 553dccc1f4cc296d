/**
 * What a motion is for the page, as types only: this module holds no code.
 *
 * @module motion/types
 */

/**
 * The start of a motion, and what is to be changed of it. `losses` holds what the controls ask for, in SI units.
 * @typedef {object} MotionRequest
 * @property {import("eulerdisk/types").View} view
 * @property {number} x
 * @property {number} y
 * @property {number|null} [duration]  in seconds; null for as long as the motion is worth seeing
 * @property {Record<string, number|string>} [losses]
 */

/**
 * What a person sets of a motion: its losses, in SI units; where the camera stands, null where it stood at first; and
 * which parts of its panel are open, "laws" and "words".
 * @typedef {object} MotionSettings
 * @property {Record<string, number|string>} losses
 * @property {import("eulerdisk/motion/disk_scene").Standpoint|null} camera
 * @property {string[]} open
 */

/**
 * Label, unit and factor from SI units of an array.
 * @typedef {{label: string, unit: string, factor: number}} Described
 */

/**
 * A control of a loss: a logarithmic slider with a value that leaves the word out at one of its ends, or a choice.
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
 * @property {boolean} [idle]  whether it changes nothing while the others are as they are
 * @property {string} [none]  what it means to leave the word out
 * @property {"low"|"high"} [end]  end of the slider at which it is left out
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
 * @property {number} alpha
 * @property {number} radius
 * @property {number} gravity
 * @property {[number, string][]} turns
 * @property {number|null} period
 * @property {number} fall_tilt
 * @property {LossControl[]} losses
 * @property {Record<string, string>|null} ledger
 * @property {Record<string, Described>} quantities
 */

/**
 * Arrays have one value for each sample.
 * @typedef {{head: MotionHead, arrays: Record<string, Float64Array>}} MotionAnswer
 */

/**
 * What an exported page holds for the motions that it integrates itself (`stored_motions` of sweep/explorer/motion.py);
 * `fall_tilt` in radians.
 * @typedef {object} StoredMotions
 * @property {number} fall_tilt
 * @property {Record<string, Described>} quantities
 * @property {{lifts_off: string, needs: string}} words
 */

export {};
