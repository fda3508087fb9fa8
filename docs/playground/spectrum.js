// Amplitude over frequency of an evenly sampled curve: Hann's window, zeros behind, a transform of two to some power.

const LENGTH = 4096;

/** Frequencies, Hz, and amplitudes up to a highest frequency; the curve's mean over its last third is taken off. */
export function spectrum(values, rate, highest) {
  const count = Math.min(values.length, LENGTH);
  const tail = values.slice(-Math.max(1, Math.floor(count / 3)));
  const mean = tail.reduce((sum, value) => sum + value, 0) / tail.length;
  const re = new Float64Array(LENGTH), im = new Float64Array(LENGTH);
  let weight = 0;
  for (let k = 0; k < count; k++) {
    const window = 0.5 - 0.5 * Math.cos((2 * Math.PI * (k + 0.5)) / count);
    re[k] = window * (values[k] - mean);
    weight += window;
  }
  transform(re, im);
  const frequency = [], amplitude = [];
  for (let k = 0; (k * rate) / LENGTH <= highest; k++) {
    frequency.push((k * rate) / LENGTH);
    amplitude.push((2 * Math.hypot(re[k], im[k])) / weight);
  }
  return { frequency, amplitude };
}

/** Where it is highest, between the points by a parabola. */
export function peak({ frequency, amplitude }) {
  let at = 1;
  for (let k = 1; k + 1 < amplitude.length; k++) if (amplitude[k] > amplitude[at]) at = k;
  const [a, b, c] = [amplitude[at - 1], amplitude[at], amplitude[at + 1] ?? 0];
  const bend = a - 2 * b + c;
  const shift = bend < 0 ? (0.5 * (a - c)) / bend : 0;
  return { frequency: frequency[at] + shift * (frequency[1] - frequency[0]), amplitude: b };
}

// Cooley and Tukey (1965), in place.
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) [re[i], re[j], im[i], im[j]] = [re[j], re[i], im[j], im[i]];
  }
  for (let size = 2; size <= n; size *= 2) {
    const half = size / 2, turn = (-2 * Math.PI) / size;
    for (let k = 0; k < half; k++) {
      const c = Math.cos(turn * k), s = Math.sin(turn * k);
      for (let i = k; i < n; i += size) {
        const j = i + half;
        const x = re[j] * c - im[j] * s, y = re[j] * s + im[j] * c;
        [re[j], im[j]] = [re[i] - x, im[i] - y];
        re[i] += x;
        im[i] += y;
      }
    }
  }
}
