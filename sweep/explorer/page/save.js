/** Pictures of the map as files: the overlay with the colours beneath it, as SVG, and drawn from that as PNG. */

import { svg } from "eulerdisk/svg";

/** @typedef {import("eulerdisk/map").AtlasMap} AtlasMap */

/** What a style sheet says of the overlay and a file has to say itself. */
const STYLES = [
  "fill",
  "fill-opacity",
  "stroke",
  "stroke-width",
  "stroke-dasharray",
  "stroke-opacity",
  "stroke-linecap",
  "stroke-linejoin",
  "opacity",
  "font-family",
  "font-size",
  "font-weight",
  "paint-order",
  "display",
];

/**
 * The map as it is seen, as the text of an SVG.
 * @param {AtlasMap} map
 */
export function svgOf(map) {
  const { overlay, picture, plot } = map;
  const copy = /** @type {SVGSVGElement} */ (overlay.cloneNode(true));
  copyStyles(overlay, copy);
  const { clientWidth: width, clientHeight: height } = overlay;
  const attributes = {
    xmlns: "http://www.w3.org/2000/svg",
    viewBox: `0 0 ${width} ${height}`,
    width,
    height,
  };
  for (const [key, value] of Object.entries(attributes)) copy.setAttribute(key, String(value));
  const page = getComputedStyle(document.body).backgroundColor;
  const colours = svg("image", {
    href: picture.canvas.toDataURL("image/png"),
    x: plot.left,
    y: plot.top,
    width: plot.width,
    height: plot.height,
    preserveAspectRatio: "none",
  });
  copy.prepend(svg("rect", { width, height, fill: page }), colours);
  return new XMLSerializer().serializeToString(copy);
}

/**
 * @param {Element} from
 * @param {Element} to
 */
function copyStyles(from, to) {
  const style = getComputedStyle(from);
  for (const name of STYLES) to.setAttribute(name, style.getPropertyValue(name));
  to.removeAttribute("class");
  // colours of their own are attributes already, and stay
  for (const name of ["fill", "stroke"]) {
    if (from.hasAttribute(name)) to.setAttribute(name, from.getAttribute(name) ?? "");
  }
  [...from.children].forEach((child, index) => copyStyles(child, to.children[index]));
}

/**
 * The map as PNG, at twice the size of the screen's CSS pixels or finer.
 * @param {AtlasMap} map
 * @returns {Promise<Blob>}
 */
export async function pngOf(map) {
  const { clientWidth, clientHeight } = map.overlay;
  const density = Math.max(window.devicePixelRatio || 1, 2);
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svgOf(map))}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  canvas.width = Math.round(clientWidth * density);
  canvas.height = Math.round(clientHeight * density);
  canvas.getContext("2d")?.drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve, reject) => {
    canvas.toBlob(
      (blob) => (blob ? resolve(blob) : reject(new Error("The picture is too large."))),
      "image/png",
    );
  });
}

/**
 * Give a file to the browser's downloads.
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // the browser has begun to read it before the next minute
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
