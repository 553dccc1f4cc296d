/** What is set of a motion, as entries of the address: "a.loss.friction=0.3", "a.camera=0.2,0.4,6", "a.open=laws". */

/** @import { MotionSettings } from "eulerdisk/motion/types" */
/** @import { About } from "eulerdisk/types" */

/** Names of losses have this before them. */
const LOSS = "loss.";

/** Characters of a word of a loss at most. */
const MOST_TEXT = 40;

/** Parts of a panel that can be open. */
const PARTS = ["laws", "words"];

/** Digits of the place of the camera: a thousandth of a pixel. */
const DIGITS = 6;

/** @type {MotionSettings} nothing is set */
export const UNSET = { losses: {}, camera: null, open: [] };

/**
 * @param {string} letter
 * @param {MotionSettings} settings
 * @returns {[string, string][]}
 */
export function motionEntries(letter, { losses, camera, open }) {
  /** @type {[string, string][]} */
  const entries = Object.entries(losses).map(([name, value]) => [LOSS + name, String(value)]);
  if (camera) entries.push(["camera", camera.map((each) => Number(each.toPrecision(DIGITS))).join(",")]);
  if (open.length) entries.push(["open", open.join(",")]);
  return entries.map(([name, text]) => [`${letter}.${name}`, text]);
}

/**
 * What an address sets of a motion; what cannot be read is as at the start.
 * @param {URLSearchParams} entries
 * @param {string} letter
 * @param {About} about
 * @returns {MotionSettings}
 */
export function readMotion(entries, letter, about) {
  /** @type {MotionSettings["losses"]} */
  const losses = {};
  for (const name of about.losses) {
    const text = entries.get(`${letter}.${LOSS}${name}`) ?? "";
    if (text.trim() === "" || text.length > MOST_TEXT) continue;
    losses[name] = Number.isFinite(Number(text)) ? Number(text) : text;
  }
  const open = (entries.get(`${letter}.open`) ?? "").split(",");
  return {
    losses,
    camera: readCamera(entries.get(`${letter}.camera`)),
    open: PARTS.filter((part) => open.includes(part)),
  };
}

/**
 * @param {string|null} text
 * @returns {MotionSettings["camera"]}
 */
function readCamera(text) {
  const parts = (text ?? "").split(",").map(numberOf);
  if (parts.length !== 3 || !parts.every(Number.isFinite) || parts[2] <= 0) return null;
  return [parts[0], parts[1], parts[2]];
}

/**
 * Number of a text; NaN for an empty one and for spaces, which `Number` reads as zero.
 * @param {string} [text]
 */
export function numberOf(text = "") {
  return text.trim() === "" ? NaN : Number(text);
}
