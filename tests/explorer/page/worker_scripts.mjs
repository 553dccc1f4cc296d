/** The scripts of a worker without their kernels: their global names. */

import { scopeOf } from "./worker.mjs";

/** Global names of a worker after some of its scripts have run. */
export const scriptsOf = (...names) =>
  scopeOf(names.map((name) => import.meta.resolve(`eulerdisk/compute/${name}`)));

/** Plain arrays and objects of this realm, for comparison. */
export const plain = (columns) =>
  Object.fromEntries(Object.entries(columns).map(([name, values]) => [name, Array.from(values)]));
