// Numbers as people read them.

/**
 * @param {number | null | undefined} value
 * @param {number} [digits]
 */
export function short(value, digits = 3) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(digits - 1).replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

/**
 * An error [SI] in the small unit of its quantity.
 * @param {number | null | undefined} value
 * @param {{per_small: number, small: string}} quantity
 */
export function small(value, quantity) {
  if (value === null || value === undefined) return "–";
  return `${short(value * quantity.per_small)} ${quantity.small.replace("um", "µm")}`;
}

/** @param {number} seconds */
export function span(seconds) {
  return seconds < 120 ? `${short(seconds)} s` : `${short(seconds / 60)} min`;
}

/** @param {string} name */
export function unit(name) {
  return name === "1" ? "" : name.replace("um", "µm").replace("^2", "²").replace("^3", "³");
}
