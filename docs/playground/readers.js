// Recordings in a browser: tables with a head, and C3D of Intel processors. What a file leaves open is said, not hidden.
// The program reads more formats and checks more; this is to look at a recording beside a rod.

const LENGTHS = { m: 1, mm: 1e-3, cm: 1e-2, in: 0.0254 };
const TIMES = { s: 1, ms: 1e-3 };
/** Metres beyond which a number without a unit is taken for millimetres. */
const FAR = 5;

/** Times, s, markers with positions, m, each a list by axis, and what was found. */
export function read(name, buffer) {
  const bytes = new Uint8Array(buffer);
  if (!bytes.length) throw new Error(`${name} is empty`);
  const recording = bytes[1] === 80 && bytes[0] < 20 || /\.c3d$/i.test(name) ? c3d(bytes) : table(new TextDecoder().decode(bytes));
  if (recording.time.length < 10) throw new Error(`${name} has ${recording.time.length} samples; ten are needed`);
  if (!recording.markers.length) throw new Error(`${name} has no positions`);
  if (recording.time.some((time, k) => !Number.isFinite(time) || (k && time <= recording.time[k - 1]))) {
    throw new Error(`${name} has times that do not ascend`);
  }
  recording.markers.push(...means(recording.markers));
  return recording;
}

/** The marker of a column as the program names it: `Tip 1_x_mm` is of `Tip 1`, `x` of `point`. */
function named(text) {
  const stem = text.trim().replace(/^["']|["']$/g, '').replace(/[ _]*[([][^([]*[)\]]$/, '').replace(/_(m|mm|cm|in)$/i, '');
  return stem.match(/^(.*)[_.: ][xyz]$/i)?.[1] ?? 'point';
}

/** `tip_x_mm`, `tip x (mm)`, `x[m]`: marker, axis and unit. */
function column(text) {
  const words = text.trim().toLowerCase().replace(/["'()[\]]/g, ' ').trim().split(/[\s_/.:]+/);
  const last = words.at(-1);
  const unit = words.length > 1 && (last in LENGTHS || last in TIMES) ? words.pop() : null;
  if (/^(t|time|times|zeit|seconds)$/.test(words.join(' '))) return { kind: 'time', factor: TIMES[unit] ?? 1 };
  const axis = words.pop();
  if (!/^[xyz]$/.test(axis)) return { kind: 'other' };
  return { kind: 'position', marker: words.join(' ') || 'tip', own: named(text), axis, factor: LENGTHS[unit] ?? null };
}

function table(text) {
  const lines = text.replace(/^\uFEFF/, '').split(/\r?\n/).filter(line => line.trim() && !line.startsWith('#'));
  const separator = [';', '\t', ','].find(separator => lines[0]?.includes(separator)) ?? ',';
  const heads = (lines[0] ?? '').split(separator).map(column);
  const clock = heads.findIndex(({ kind }) => kind === 'time');
  if (clock < 0) throw new Error('the table has no column of time: its first line must be a head such as time_s, tip_x_mm, tip_z_mm');
  const number = text => (text === undefined || text.trim() === '' ? NaN
    : Number(separator === ',' ? text : text.replace(',', '.')));
  const rows = lines.slice(1).map((line, k) => {
    const row = line.split(separator).map(number);
    if (!Number.isFinite(row[clock])) throw new Error(`line ${k + 2} of the table has no time`);
    return row;
  });
  const findings = [], markers = new Map();
  let assumed = null;
  heads.forEach((head, k) => {
    if (head.kind !== 'position') return;
    const values = rows.map(row => row[k] ?? NaN);
    let factor = head.factor;
    if (factor === null) {
      factor = values.some(value => Math.abs(value) > FAR) ? 1e-3 : 1;
      assumed = factor === 1 ? 'm' : 'mm';
      findings.push(`${head.marker} ${head.axis} states no unit; ${factor === 1 ? 'm' : 'mm'} is assumed`);
    }
    const marker = markers.get(head.marker) ?? { name: head.marker, own: [head.own], axes: {} };
    marker.axes[head.axis] = values.map(value => value * factor);
    markers.set(head.marker, marker);
  });
  return { time: rows.map(row => row[clock] * heads[clock].factor), markers: [...markers.values()], findings, unit: assumed };
}

// Source: The C3D File Format, User Guide, Motion Lab Systems (2008).
function c3d(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const start = (bytes[0] - 1) * 512;
  if (bytes.length < 1024 || bytes[1] !== 80 || start + 4 > bytes.length) throw new Error('this is no whole C3D file');
  if (bytes[start + 3] !== 84) throw new Error('this C3D file is of a DEC or MIPS processor; the program efam reads it');
  const parameters = groups(bytes, view, start + 4);
  const word = index => view.getUint16(2 * index - 2, true);
  const [points, analog, first, last] = [word(2), word(3), word(4), word(5)];
  const data = (word(9) - 1) * 512;
  const scale = parameters.get('POINT:SCALE')?.numbers[0] ?? view.getFloat32(12, true);
  const rate = parameters.get('POINT:RATE')?.numbers[0] || view.getFloat32(20, true);
  const size = scale < 0 ? 4 : 2, width = size * (4 * points + analog);
  const frames = last - first + 1;
  if (!points || frames < 1 || !(rate > 0)) throw new Error('this C3D file states no points, frames or rate');
  if (data < 512 || data + frames * width > bytes.length) throw new Error(`this C3D file states ${frames} frames and is cut short`);
  const unit = parameters.get('POINT:UNITS')?.texts[0]?.toLowerCase() || 'mm';
  if (!(unit in LENGTHS)) throw new Error(`this C3D file has positions in ${unit}, which is not known here`);
  const labels = parameters.get('POINT:LABELS')?.texts ?? [];
  const markers = Array.from({ length: points }, (_, k) => ({ name: labels[k]?.replace(/\p{C}/gu, '') || `point ${k + 1}`, axes: { x: [], y: [], z: [] } }));
  markers.forEach(marker => { marker.own = [marker.name]; });
  const value = at => (size === 4 ? view.getFloat32(at, true) : scale * view.getInt16(at, true));
  for (let frame = 0; frame < frames; frame++) {
    markers.forEach(({ axes }, point) => {
      const at = data + frame * width + 4 * size * point;
      // A point is there if its fourth word is not negative; its coordinates say nothing about that.
      const is = value(at + 3 * size) >= 0;
      ['x', 'y', 'z'].forEach((axis, k) => axes[axis].push(is ? value(at + k * size) * LENGTHS[unit] : NaN));
    });
  }
  return { time: Array.from({ length: frames }, (_, k) => k / rate), markers, findings: [`C3D, ${rate} Hz, positions in ${unit}`] };
}

/** Parameters by `GROUP:NAME`, as numbers or texts. */
function groups(bytes, view, from) {
  const names = new Map(), found = new Map();
  const letters = (at, length) => String.fromCharCode(...bytes.subarray(at, at + length));
  for (let at = from; at + 4 < bytes.length;) {
    const length = Math.abs(view.getInt8(at)), id = view.getInt8(at + 1);
    if (!length || !id) break;
    const name = letters(at + 2, length).toUpperCase();
    const next = at + 2 + length, offset = view.getInt16(next, true);
    if (id < 0) names.set(-id, name);
    else found.set(`${id} ${name}`, values(bytes, view, next + 2, letters));
    if (offset <= 0) break;
    at = next + offset;
  }
  return new Map([...found].map(([key, value]) => {
    const [id, ...name] = key.split(' ');
    return [`${names.get(Number(id))}:${name.join(' ')}`, value];
  }));
}

function values(bytes, view, at, letters) {
  const type = view.getInt8(at), sizes = [...bytes.subarray(at + 2, at + 2 + bytes[at + 1])];
  const data = at + 2 + sizes.length, all = sizes.reduce((product, size) => product * size, 1);
  const found = { numbers: [], texts: [] };
  if (data + all * Math.abs(type) > bytes.length) return found;
  if (type === -1) {
    const long = sizes[0] || 1;
    for (let k = 0; k < all; k += long) found.texts.push(letters(data + k, long).trim());
  } else {
    const value = { 1: k => view.getInt8(data + k), 2: k => view.getInt16(data + 2 * k, true), 4: k => view.getFloat32(data + 4 * k, true) }[type];
    if (value) for (let k = 0; k < all; k++) found.numbers.push(value(k));
  }
  return found;
}

/** Means of markers whose names differ by a number alone, such as three on one end body. */
function means(markers) {
  const groups = Map.groupBy(markers, ({ name }) => name.replace(/[\s_-]*\d+$/, ''));
  return [...groups].filter(([, group]) => group.length > 1).map(([name, group]) => {
    const axes = {};
    for (const axis of Object.keys(group[0].axes)) {
      axes[axis] = group[0].axes[axis].map((_, k) => group.reduce((sum, marker) => sum + (marker.axes[axis]?.[k] ?? NaN), 0) / group.length);
    }
    return { name: `${name || 'all'}, mean of ${group.length}`, own: group.flatMap(({ own }) => own), axes };
  });
}
