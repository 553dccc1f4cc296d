/** Creation of HTML and SVG elements, scales of sliders, and the width of texts. Text is never interpreted as HTML. */

/**
 * @template {keyof HTMLElementTagNameMap} Name
 * @param {Name} name
 * @param {Record<string, string|boolean|EventListener>} [attributes]  a function listens to the event of that name
 * @param {(Node|string)[]} children
 * @returns {HTMLElementTagNameMap[Name]}
 */
export function html(name, attributes = {}, ...children) {
  const element = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") element.addEventListener(key, value);
    else if (typeof value === "boolean") element.toggleAttribute(key, value);
    else element.setAttribute(key, value);
  }
  element.append(...children);
  return element;
}

/**
 * Return a choice among options.
 * @param {Record<string, string>} attributes
 * @param {{value: string, label: string, title?: string}[]} options
 * @param {(value: string) => void} choose
 */
export function select(attributes, options, choose) {
  const made = options.map(({ value, label, title = "" }) =>
    html("option", title ? { value, title } : { value }, label),
  );
  const element = html("select", { ...attributes, change: () => choose(element.value) }, ...made);
  return element;
}

/**
 * Return a checkbox and its label.
 * @param {string} id
 * @param {(Node|string)[]} words
 * @param {(checked: boolean) => void} tick
 */
export function checkbox(id, words, tick) {
  const box = html("input", { type: "checkbox", id, change: () => tick(box.checked) });
  return { box, label: html("label", { class: "check" }, box, ...words) };
}

/**
 * The scale of a slider, in equal steps of its value or of the logarithm.
 * @typedef {{low: number, high: number, scale: "linear"|"log"}} Ruler
 */

/**
 * Return the value at a share of the way from one end of a slider to the other.
 * @param {Ruler} ruler
 * @param {number} share
 */
export function valueOnRuler({ low, high, scale }, share) {
  return scale === "log" ? low * (high / low) ** share : low + share * (high - low);
}

/**
 * Return the share of the way at which a value lies; for values beyond the ends, the nearer end.
 * @param {Ruler} ruler
 * @param {number} value
 */
export function shareOnRuler({ low, high, scale }, value) {
  const share = scale === "log" ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  return Math.min(Math.max(share, 0), 1);
}

const NAMESPACE = "http://www.w3.org/2000/svg";

/**
 * @param {string} name
 * @param {Record<string, string|number>} [attributes]
 * @param {(Node|string)[]} children
 * @returns {SVGElement}
 */
export function svg(name, attributes = {}, ...children) {
  const element = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, String(value));
  element.append(...children);
  return element;
}

/** @type {CanvasRenderingContext2D|null} */
let ruler = null;

/**
 * Return the width of a text in an overlay, in CSS pixels.
 * @param {string} text
 */
export function textWidth(text) {
  ruler ??= document.createElement("canvas").getContext("2d");
  if (!ruler) return text.length * 7;
  ruler.font = "12px system-ui, sans-serif";
  return ruler.measureText(text).width;
}
