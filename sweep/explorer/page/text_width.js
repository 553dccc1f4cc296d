/** How wide a text is, before it is drawn. */

/** @type {CanvasRenderingContext2D|null} */
let ruler = null;

/**
 * Width of a text of an overlay in CSS pixels.
 * @param {string} text
 */
export function textWidth(text) {
  ruler ??= document.createElement("canvas").getContext("2d");
  if (!ruler) return text.length * 7;
  ruler.font = "12px system-ui, sans-serif";
  return ruler.measureText(text).width;
}
