/** Workers of the page in Node: their scripts run as in a browser, in a context without module names. */

import { resolveObjectURL } from "node:buffer";
import { readFileSync } from "node:fs";
import { fileURLToPath } from "node:url";
import { createContext, runInContext } from "node:vm";

/**
 * Global names of a worker after some scripts have run.
 * @param {string[]} addresses  of the scripts
 * @param {(message: any) => void} [tell]  receives the scripts' messages
 */
export function scopeOf(addresses, tell = () => {}) {
  const scope = createContext({ TextDecoder });
  scope.self = scope;
  // a browser also copies messages
  scope.postMessage = (message, { transfer = [] } = {}) => tell(structuredClone(message, { transfer }));
  for (const address of addresses) {
    runInContext(readFileSync(fileURLToPath(address), "utf8"), scope, { filename: address });
  }
  return scope;
}

export class PageWorker {
  onmessage = () => {};
  onerror = () => {};
  #scope;

  /** @param {string} address  of a script that imports others */
  constructor(address) {
    this.#scope = this.#begin(address);
    this.#scope.catch(({ message }) => this.onerror({ message, preventDefault() {} }));
  }

  async #begin(address) {
    const text = await resolveObjectURL(address).text();
    const scripts = JSON.parse(text.replace(/^importScripts\((.*)\)$/, "[$1]"));
    return scopeOf(scripts, (message) => setImmediate(() => this.onmessage({ data: message })));
  }

  postMessage(message) {
    this.#scope.then(
      ({ onmessage }) => onmessage({ data: message }),
      () => {},
    );
  }
}

globalThis.Worker = PageWorker;
