/** The menus at the top: copy the address or a command, save pictures and data. */

import { html } from "eulerdisk/html";
import { download, pngOf, svgOf } from "eulerdisk/save";

/** @typedef {import("eulerdisk/types").Source} Source */
/** @typedef {import("eulerdisk/map").AtlasMap} AtlasMap */
/** @typedef {import("eulerdisk/state").State} State */

/**
 * @typedef {object} Place
 * @property {() => State} state
 * @property {() => string} address  that can be shared
 * @property {AtlasMap} map
 * @property {Source} source
 * @property {(words: string) => void} say
 */

/**
 * @param {HTMLElement} element
 * @param {Place} place
 */
export function addMenus(element, place) {
  const { map, source, say } = place;
  const asked = () => {
    const { view, quantity, points } = place.state();
    return { view, quantity, ...map.size, ...points[0] };
  };
  const name = () => `${place.state().view.base || "atlas"}-${place.state().quantity}`;
  /** @param {"command"|"python"} which */
  const copyAs = async (which) =>
    copy(String((await /** @type {any} */ (source).command(asked()))[which]), say);
  /** @param {"csv"|"netcdf"} format */
  const save = async (format) => {
    const { blob, name: file } = await /** @type {any} */ (source).data({ ...asked(), format });
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
      item("as command", () => copyAs("command")),
      item("as Python", () => copyAs("python")),
    );
  }
  if (source.data) {
    files.push(
      item("data, CSV", () => save("csv")),
      item("data, netCDF", () => save("netcdf")),
    );
  }
  element.append(menu("Copy", copies, say), menu("Save", files, say));
}

/** @typedef {{words: string, deed: () => Promise<void>}} Item */

/**
 * @param {string} words
 * @param {() => Promise<void>} deed
 * @returns {Item}
 */
function item(words, deed) {
  return { words, deed };
}

/**
 * @param {string} title
 * @param {Item[]} items
 * @param {(words: string) => void} say
 */
function menu(title, items, say) {
  const details = html("details", { class: "menu" }, html("summary", {}, title));
  const close = () => details.removeAttribute("open");
  /** @param {Item} each */
  const button = ({ words, deed }) =>
    html(
      "button",
      {
        type: "button",
        click: () => {
          close();
          deed().catch((problem) => say(problem.message));
        },
      },
      words,
    );
  details.append(html("div", {}, ...items.map(button)));
  details.addEventListener("keydown", (event) => {
    if (event.key !== "Escape") return;
    close();
    details.querySelector("summary")?.focus();
  });
  document.addEventListener("pointerdown", (event) => {
    if (!details.contains(/** @type {Node} */ (event.target))) close();
  });
  return details;
}

/**
 * @param {string} text
 * @param {(words: string) => void} say
 */
async function copy(text, say) {
  try {
    await navigator.clipboard.writeText(text);
    say("Copied.");
  } catch {
    // a page without leave to write to the clipboard shows what to copy
    say(text);
  }
}
