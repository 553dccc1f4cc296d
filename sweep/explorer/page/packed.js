/** Binary data in a page that is a single file: bytes in base64. */

/** @import { PackedArray } from "eulerdisk/types" */

/**
 * Return the bytes of a text in base64.
 * @param {string} text
 */
function bytesOf(text) {
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  // ten times as fast as a callback for each letter
  for (let i = 0; i < bytes.length; i += 1) bytes[i] = letters.charCodeAt(i);
  return bytes;
}

/**
 * Return the array in compressed bytes.
 * @param {PackedArray} packed
 * @returns {Promise<Float32Array|Float64Array|Uint8Array>}
 */
export async function unpackedArray({ type, data }) {
  const inflated = new Blob([bytesOf(data)]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(inflated).arrayBuffer();
  return new { f4: Float32Array, f8: Float64Array, u1: Uint8Array }[type](buffer);
}
