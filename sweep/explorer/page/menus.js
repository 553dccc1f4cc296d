/** The menus at the top: copy the address or a command, save pictures and data. */

import { html, svg } from "eulerdisk/elements";
import { wordsOfProblem } from "eulerdisk/notice";
import { FINE, pixels } from "eulerdisk/refresh";
import { isFixed } from "eulerdisk/state";

/** @import { AtlasMap } from "eulerdisk/map" */
/** @import { Motions } from "eulerdisk/motions" */
/** @import { State } from "eulerdisk/state" */
/** @import { About, Source } from "eulerdisk/types" */

/** Cells that are saved at most. */
const MOST_CELLS = 1e6;

const NO_DOWNLOADS =
  "the page around this one allows no downloads: open this page by itself, or add allow-downloads to the frame's sandbox.";

/**
 * @typedef {object} Place
 * @property {() => State} state
 * @property {(() => string)|null} address  that can be shared
 * @property {AtlasMap} map
 * @property {Motions} motions
 * @property {Source} source
 * @property {(words: string) => void} say
 */

/**
 * @param {HTMLElement} element
 * @param {About} about
 * @param {Place} place
 * @returns {(state: State) => void}  offers what there is in a state
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
    // nothing tells a page that its sandbox allows no downloads
    if (!place.address) say(`${file} was given to the browser. If it does not arrive, ${NO_DOWNLOADS}`);
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
    // what is saved is computed: of stored cells alone the file is there already
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
 * @param {(state: State) => boolean} [offered]  whether there is such a thing in a state
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
    // else the focus would be lost with what has it, and Tab would begin at the top of the page
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
  // some browsers give the focus to no button that is clicked, so that Escape is pressed elsewhere
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
 * Put a text into the clipboard, or show it.
 * @param {string} text
 * @returns {Promise<boolean>}  whether it is in the clipboard
 */
export async function copied(text) {
  try {
    // some browsers have none, and a frame of another page may not write to it
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    return copiedFrom(shownText(text));
  }
}

/**
 * Copy what is selected in a dialog, which stays open where that is not possible.
 * @param {HTMLDialogElement} dialog
 */
function copiedFrom(dialog) {
  const done = document.execCommand("copy");
  if (done) dialog.close();
  return done;
}

/**
 * A dialog with a text that is selected. It goes when it is closed; the focus returns to where it was.
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
