/** The menus at the top: copy the address or a command, save pictures and data. */

import { html, svg } from "eulerdisk/elements";
import { wordsOfProblem } from "eulerdisk/notice";
import { FINE, pixels } from "eulerdisk/refresh";
import { isFixed } from "eulerdisk/state";

/** @import { AtlasMap } from "eulerdisk/map" */
/** @import { Motions } from "eulerdisk/motions" */
/** @import { State } from "eulerdisk/state" */
/** @import { About, Source } from "eulerdisk/types" */

/** Largest number of cells that are saved. */
const MOST_CELLS = 1e6;

const NO_DOWNLOADS =
  "the page around this one forbids downloads: open this page on its own, or add allow-downloads to the frame's sandbox.";

/**
 * @typedef {object} Place
 * @property {() => State} state
 * @property {(() => string)|null} address  an address that can be shared
 * @property {AtlasMap} map
 * @property {Motions} motions
 * @property {Source} source
 * @property {(words: string) => void} say
 */

/**
 * @param {HTMLElement} element
 * @param {About} about
 * @param {Place} place
 * @returns {(state: State) => void}  shows the items that a state offers
 */
export function addMenus(element, about, place) {
  const { map, motions, source, say } = place;
  /** @param {number} most  cells */
  const asked = (most) => {
    const { view, quantity } = place.state();
    const [width, height] = pixels(map.size, most);
    return { view, quantity, width, height };
  };
  const name = () => `${place.state().view.base || "atlas"}-${place.state().quantity}`;
  /**
   * @param {object|null} request
   * @param {"command"|"python"} which
   */
  const copyAs = async (request, which) => {
    if (request) await copy(String((await /** @type {any} */ (source).command(request))[which]), say);
  };
  /**
   * @param {Blob} blob
   * @param {string} file
   */
  const give = (blob, file) => {
    download(blob, file);
    // a page cannot find out whether its sandbox allows downloads
    if (!place.address) say(`${file} was passed to the browser. If it does not arrive, ${NO_DOWNLOADS}`);
  };
  /** @param {"csv"|"netcdf"} format */
  const save = async (format) => {
    const { blob, name: file } = await /** @type {any} */ (source).data({ ...asked(MOST_CELLS), format });
    give(blob, file);
  };
  const { address } = place;
  const copies = address ? [item("address of this view", () => copy(address(), say))] : [];
  const files = [
    item("picture, PNG", async () => give(await pngOf(map), `${name()}.png`)),
    item("picture, SVG", async () =>
      give(new Blob([svgOf(map)], { type: "image/svg+xml" }), `${name()}.svg`),
    ),
  ];
  if (source.command) {
    copies.push(
      item("window as command", () => copyAs(asked(FINE), "command")),
      item("window as Python", () => copyAs(asked(FINE), "python")),
    );
    for (const [slot, letter] of ["A", "B"].entries()) {
      const offered = (/** @type {State} */ { points, compare }) =>
        points[slot] !== null && (slot === 0 || compare);
      copies.push(
        item(`motion ${letter} as command`, () => copyAs(motions.request(slot), "command"), offered),
        item(`motion ${letter} as Python`, () => copyAs(motions.request(slot), "python"), offered),
      );
    }
  }
  if (source.data) {
    // saving computes cells; stored cells are already in a file
    const offered = (/** @type {State} */ { view }) => !isFixed(about, view);
    files.push(
      item("data, CSV", () => save("csv"), offered),
      item("data, netCDF", () => save("netcdf"), offered),
    );
  }
  if (copies.length) element.append(menu("Copy", copies, say));
  element.append(menu("Save", files, say));
  return (state) => {
    for (const { button, offered } of [...copies, ...files]) button.hidden = !offered(state);
  };
}

/** @typedef {{button: HTMLButtonElement, deed: () => Promise<void>, offered: (state: State) => boolean}} Item */

/**
 * @param {string} words
 * @param {() => Promise<void>} deed
 * @param {(state: State) => boolean} [offered]  whether a state offers the item
 * @returns {Item}
 */
function item(words, deed, offered = () => true) {
  return { button: html("button", { type: "button" }, words), deed, offered };
}

/**
 * @param {string} title
 * @param {Item[]} items
 * @param {(words: string) => void} say
 */
function menu(title, items, say) {
  const details = html("details", { class: "menu" }, html("summary", {}, title));
  const close = () => details.removeAttribute("open");
  const closeAndReturn = () => {
    close();
    // otherwise the focused element disappears with the menu, and Tab starts at the top of the page
    details.querySelector("summary")?.focus();
  };
  const closeUnlessIn = (/** @type {EventTarget|null} */ target) => {
    if (!details.contains(/** @type {Node} */ (target))) close();
  };
  for (const { button, deed } of items) {
    button.addEventListener("click", () => {
      closeAndReturn();
      deed().catch((problem) => say(wordsOfProblem(problem)));
    });
  }
  details.append(html("div", {}, ...items.map(({ button }) => button)));
  // some browsers do not focus a clicked button, so Escape is pressed elsewhere
  document.addEventListener("keydown", (event) => {
    if (event.key === "Escape" && details.open) closeAndReturn();
  });
  document.addEventListener("pointerdown", (event) => closeUnlessIn(event.target));
  details.addEventListener("focusout", ({ relatedTarget }) => {
    if (relatedTarget) closeUnlessIn(relatedTarget);
  });
  return details;
}

/**
 * @param {string} text
 * @param {(words: string) => void} say
 */
async function copy(text, say) {
  if (await copied(text)) say("Copied.");
}

/**
 * Put a text into the clipboard, or show it if that is impossible.
 * @param {string} text
 * @returns {Promise<boolean>}  whether the text is in the clipboard
 */
export async function copied(text) {
  try {
    // some browsers have no clipboard, and a frame of another page may not write to it
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copiedFrom(shownText(text));
  }
}

/**
 * Copy the selected text of a dialog, which stays open if that is impossible.
 * @param {HTMLDialogElement} dialog
 */
function copiedFrom(dialog) {
  const done = document.execCommand("copy");
  if (done) dialog.close();
  return done;
}

/**
 * Show a dialog with a selected text. Closing it removes it and returns the focus.
 * @param {string} text
 */
function shownText(text) {
  const area = html("textarea", {
    readonly: true,
    rows: "8",
    spellcheck: "false",
    "aria-label": "Text to copy",
  });
  area.value = text;
  const close = html("button", { type: "button", click: () => dialog.close() }, "Close");
  const words = html(
    "p",
    { id: "copy-words" },
    "This browser does not let the page copy. Copy this text yourself:",
  );
  const dialog = html("dialog", { class: "copy", "aria-labelledby": "copy-words" }, words, area, close);
  dialog.addEventListener("close", () => dialog.remove());
  document.body.append(dialog);
  dialog.showModal();
  area.select();
  return dialog;
}

/** Properties that the style sheet gives the overlay and that a file needs itself. */
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
 * Return the visible map as the text of an SVG.
 * @param {AtlasMap} map
 */
function svgOf(map) {
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
  // elements with their own colours have them as attributes, which stay
  for (const name of ["fill", "stroke"]) {
    if (from.hasAttribute(name)) to.setAttribute(name, from.getAttribute(name) ?? "");
  }
  [...from.children].forEach((child, index) => copyStyles(child, to.children[index]));
}

/**
 * Return the map as a PNG with at least two dots per CSS pixel.
 * @param {AtlasMap} map
 * @returns {Promise<Blob>}
 */
async function pngOf(map) {
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
 * Offer a file as a download of the browser.
 * @param {Blob} blob
 * @param {string} name
 */
export function download(blob, name) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  // after a minute, the browser has started to read it
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}
