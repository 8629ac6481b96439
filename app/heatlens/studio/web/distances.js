// Distances in words, and those that are engraved on a focus wheel.

const FOOT_M = 0.3048;
const ROUNDS = [[1, 2, 5], [1.5, 3, 7], [4, 6, 8], [2.5, 9]];
const DECADES = 5;
const INFINITY = "∞";

/** Return a distance of the state as a number: JSON has no infinity, and writes "inf". */
export function metres(value) {
  return value === "inf" ? Infinity : value;
}

/** Return a number as the state writes it. */
export function toJson(distance) {
  return distance === Infinity ? "inf" : distance;
}

/** Return a distance in words; zeros at the end stay, so that it keeps its width while it turns. */
export function words(distance, unit) {
  if (distance === Infinity) return INFINITY;
  if (unit === "ft") return feet(distance);
  if (distance < 0.1) return `${trimmed(distance * 100, 3)} cm`;
  return `${distance < 9.995 ? distance.toFixed(2) : trimmed(distance, 4)} m`;
}

function trimmed(value, digits) {
  return String(Number(value.toPrecision(digits)));
}

function feet(distance) {
  const inches = Math.round((distance / FOOT_M) * 12 * 2) / 2;
  const whole = Math.floor(inches / 12);
  const rest = inches - 12 * whole;
  return whole ? (rest ? `${whole}'${rest}"` : `${whole}'`) : `${rest}"`;
}

/** Return a label without its unit, as lenses have it. */
export function engraved(distance, unit) {
  const isMetres = unit !== "ft" && distance >= 0.1 && distance !== Infinity;
  return isMetres ? trimmed(distance, 4) : words(distance, unit);
}

/** Yield round distances in metres from `near` on, the roundest group first. */
export function* rounds(near, unit) {
  const one = unit === "ft" ? FOOT_M : 1;
  const first = Math.floor(Math.log10(near / one));
  for (const group of ROUNDS) {
    for (let power = first; power <= first + DECADES; power += 1) {
      for (const step of group) {
        const distance = step * 10 ** power * one;
        if (distance >= near * 0.999) yield distance;
      }
    }
  }
}
