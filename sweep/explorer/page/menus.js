/** The menus at the top: copy the address or a command, save pictures and data. */

import { copied } from "eulerdisk/copy";
import { html } from "eulerdisk/html";
import { wordsOfProblem } from "eulerdisk/notice";
import { FINE, pixels } from "eulerdisk/refresh";
import { download, pngOf, svgOf } from "eulerdisk/save";
import { isFixed } from "eulerdisk/state";

/** @typedef {import("eulerdisk/types").About} About */
/** @typedef {import("eulerdisk/types").Source} Source */
/** @typedef {import("eulerdisk/map").AtlasMap} AtlasMap */
/** @typedef {import("eulerdisk/motions").Motions} Motions */
/** @typedef {import("eulerdisk/state").State} State */

/** Cells that are saved at most. */
const MOST_CELLS = 1e6;

/**
 * @typedef {object} Place
 * @property {() => State} state
 * @property {() => string} address  that can be shared
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
  /** @param {"csv"|"netcdf"} format */
  const save = async (format) => {
    const { blob, name: file } = await /** @type {any} */ (source).data({ ...asked(MOST_CELLS), format });
    download(blob, file);
  };
  const copies = [item("address of this view", () => copy(place.address(), say))];
  const files = [
    item("picture, PNG", async () => download(await pngOf(map), `${name()}.png`)),
    item("picture, SVG", async () =>
      download(new Blob([svgOf(map)], { type: "image/svg+xml" }), `${name()}.svg`),
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
        item(
          `motion ${letter} as command`,
          async () => copyAs(await motions.request(slot), "command"),
          offered,
        ),
        item(
          `motion ${letter} as Python`,
          async () => copyAs(await motions.request(slot), "python"),
          offered,
        ),
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
  element.append(menu("Copy", copies, say), menu("Save", files, say));
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
