// Reads the page's data and finds what held at a time. Arrays come as base64 of little-endian numbers.
const ARRAYS = { f4: Float32Array, i4: Int32Array };

function unpacked(value) {
  if (value === null || typeof value !== "object") return value;
  if (typeof value.bdata === "string") {
    const bytes = Uint8Array.from(atob(value.bdata), (letter) => letter.charCodeAt(0));
    return new ARRAYS[value.dtype](bytes.buffer);
  }
  const copy = Array.isArray(value) ? [] : {};
  for (const key in value) copy[key] = unpacked(value[key]);
  return copy;
}

/** Place of the newest of the rising `times` that is not after `t`; -1 before the first. */
function newest(times, t) {
  let low = 0, high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
}

/** The named columns of a way at `t`, straight between samples; null outside of it. */
function stateAt(way, t, columns) {
  const last = way === null ? -1 : way.t.length - 1;
  if (last < 0 || t < way.t[0] - 0.05 || t > way.t[last] + 0.05) return null;
  const index = Math.min(Math.max(newest(way.t, t), 0), last), next = Math.min(index + 1, last);
  const gap = way.t[next] - way.t[index];
  const part = gap > 0 ? Math.min(Math.max((t - way.t[index]) / gap, 0), 1) : 0;
  const state = {};
  for (const name of columns) state[name] = way[name][index] + part * (way[name][next] - way[name][index]);
  return state;
}

/** The newest sample of a series at `t`, unless it is older than `age` seconds. */
function sampleAt(series, t, age) {
  if (series === null) return null;
  const index = newest(series.t, t);
  if (index < 0 || t - series.t[index] > age) return null;
  const sample = {};
  for (const name in series) sample[name] = series[name][index];
  return sample;
}

/** Circles [north, east, radius] of the newest set at `t`. */
function circlesAt(scenes, t, age) {
  if (scenes === null) return [];
  const index = newest(scenes.t, t);
  if (index < 0 || t - scenes.t[index] > age) return [];
  const circles = [];
  for (let row = scenes.start[index]; row < scenes.start[index + 1]; row++) circles.push(scenes.rows.subarray(3 * row, 3 * row + 3));
  return circles;
}

function spellsAt(spells, t) {
  return spells.filter((spell) => spell.from <= t && t <= spell.to);
}

function colourOf(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
