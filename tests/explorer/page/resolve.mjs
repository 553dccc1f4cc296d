/** Lets Node find the page's modules by their names in its import map. */

import { registerHooks } from "node:module";

const PAGE = new URL("../../../sweep/explorer/page/", import.meta.url);

/**
 * Path of a module in the page's folder, as in `modules` of sweep/explorer/pages.py; null for any other name.
 * @param {string} name
 */
function pathOf(name) {
  if (name.startsWith("eulerdisk/")) return `${name.slice("eulerdisk/".length)}.js`;
  return /^three(\/|$)/.test(name) ? `vendor/${name.replaceAll("/", ".")}.js` : null;
}

registerHooks({
  resolve(name, context, next) {
    const path = pathOf(name);
    // no package.json declares them as modules
    return path
      ? { url: new URL(path, PAGE).href, format: "module", shortCircuit: true }
      : next(name, context);
  },
});
