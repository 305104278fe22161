// Colours of numbers: the map "cividis" (Nuñez, Anderton, Renslow 2018), which colour-blind eyes read as others do.

const STOPS = [
  [0, 34, 78], [18, 53, 112], [59, 73, 108], [87, 93, 109], [112, 113, 115], [138, 134, 120], [165, 156, 116],
  [195, 179, 105], [225, 204, 85], [254, 232, 56],
];

function mixed(part) {
  const at = Math.min(Math.max(part, 0), 1) * (STOPS.length - 1);
  const low = Math.min(Math.floor(at), STOPS.length - 2);
  return STOPS[low].map((from, i) => from + (STOPS[low + 1][i] - from) * (at - low));
}

const linear = (byte) => {
  const x = byte / 255;
  return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
};

const TABLE = Array.from({ length: 256 }, (_, i) => mixed(i / 255).map(linear));

/** Linear red, green and blue of every number, from 0 to `high`. */
export function colours(values, high, into) {
  const scale = 255 / high;
  for (let i = 0; i < values.length; i++) {
    const entry = TABLE[Math.min(Math.max(Math.round(values[i] * scale), 0), 255)];
    into[3 * i] = entry[0];
    into[3 * i + 1] = entry[1];
    into[3 * i + 2] = entry[2];
  }
}

/** The map as a gradient of CSS. */
export function gradient() {
  return `linear-gradient(90deg, ${STOPS.map((stop) => `rgb(${stop.join(" ")})`).join(", ")})`;
}

/** A round number no smaller than nearly all of them: a tip's peak does not darken the rest. */
export function roundHigh(values, part = 0.97) {
  const sorted = Float32Array.from(values).sort();
  const high = sorted[Math.floor(part * (sorted.length - 1))] ?? 0;
  if (!(high > 0)) return 1e-3;
  const power = 10 ** Math.floor(Math.log10(high));
  return [1, 2, 5, 10].map((step) => step * power).find((step) => step >= high);
}
