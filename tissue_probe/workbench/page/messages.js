// A message's bytes: its head in JSON, and arrays behind it (messages.py has the layout).

/** @typedef {Float32Array | Float64Array | Uint16Array} Numbers */

const TYPES = { f4: Float32Array, f8: Float64Array, u2: Uint16Array };

/**
 * @param {ArrayBuffer} buffer
 * The head is what ``JSON.parse`` makes of it: who asked knows its type.
 * @returns {{head: ReturnType<typeof JSON.parse>, arrays: Record<string, Numbers>}}
 */
export function unpacked(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  /** @type {Record<string, Numbers>} */
  const arrays = {};
  let at = 4 + size;
  for (const [name, kind, count] of head.arrays) {
    const array = new TYPES[/** @type {keyof typeof TYPES} */ (kind)](buffer, at, count);
    arrays[name] = array;
    at += Math.ceil(array.byteLength / 8) * 8;
  }
  return { head, arrays };
}
