/** Lets Node find the page's modules by the names that they import each other with: those of its import map. */

import { registerHooks } from "node:module";

const PAGE = new URL("../../../sweep/explorer/page/", import.meta.url);

/**
 * Path of a module in the page's folder, as `modules` of sweep/explorer/pages.py has it; null of any other name.
 * @param {string} name
 */
function pathOf(name) {
  if (name.startsWith("eulerdisk/")) return `${name.slice("eulerdisk/".length)}.js`;
  return /^three(\/|$)/.test(name) ? `vendor/${name.replaceAll("/", ".")}.js` : null;
}

registerHooks({
  resolve(name, context, next) {
    const path = pathOf(name);
    // no package.json says that they are modules
    return path
      ? { url: new URL(path, PAGE).href, format: "module", shortCircuit: true }
      : next(name, context);
  },
});
