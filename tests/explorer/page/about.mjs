/** A small `about` for tests: two bases of a disk, three parameters, three quantities. */

/** @param {string} name */
const parameter = (name, more = {}) => ({
  name,
  label: name.replaceAll("_", " "),
  description: "",
  unit: "",
  factor: 1,
  low: null,
  high: null,
  least: null,
  most: null,
  scale: "linear",
  control: false,
  words: [],
  ...more,
});

/** @param {string} name */
const quantity = (name, more = {}) => ({
  name,
  label: name.replaceAll("_", " "),
  description: "",
  unit: "",
  factor: 1,
  flags: null,
  is_peak: false,
  ...more,
});

export const RATE = { name: "roll_rate", centre: 3, half: 1, scale: "linear" };
export const TILT = { name: "tilt", centre: -4, half: 2, scale: "log" };

/** @param {string} name */
const base = (name, more = {}) => ({
  name,
  label: name,
  description: "",
  words: { alpha: 0.5, gravity: 9.81, criterion: "departure:5deg" },
  view: { base: name, words: {}, x: RATE, y: TILT },
  quantities: ["peak_tilt", "stability"],
  rolls: true,
  cost: 0,
  ...more,
});

export const ABOUT = {
  bases: [base("rolling"), base("spinning", { words: { alpha: 0.25 }, quantities: ["period", "stability"] })],
  others: [],
  parameters: [
    parameter("tilt", { unit: "deg", factor: 180 / Math.PI, least: -1.5, most: 1.5, low: -1, high: 1 }),
    parameter("roll_rate", { unit: "rad s-1", low: -10, high: 10, control: true }),
    parameter("alpha", { low: 0.1, high: 1, least: 1e-9, most: 1 }),
    parameter("gravity", { unit: "m s-2", low: 0.1, high: 30, least: 1e-9, scale: "log" }),
  ],
  quantities: [
    quantity("stability", { flags: { 0: "undecided", 1: "stable", 2: "unstable" } }),
    quantity("peak_tilt", { unit: "deg", factor: 180 / Math.PI, is_peak: true }),
    quantity("period", { unit: "s" }),
  ],
  criteria: [],
  losses: ["friction", "mass", "air_law"],
  motions: {},
  atlas: null,
};
