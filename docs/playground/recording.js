// A dropped recording: which marker is the tip, how it stands, when it was let go; measured over simulated; the fit.

import { Chart, palette } from './chart.js';
import { read } from './readers.js';
import { digits, shown } from './units.js';

const EI = 'rod.bending_stiffness', ALPHA = 'effects.rayleigh_mass.alpha', BETA = 'effects.rayleigh_stiffness.beta';
const OFFSET = 'effects.clock.offset';
const FITTED = { [EI]: 'bending stiffness EI', [ALPHA]: 'mass damping α', [BETA]: 'stiffness damping β' };
/** Share of the whole way from which on the tip has left its hold. */
const LEFT = 0.01;
/** Bend of a curve at a sample, over that of the samples around it, from which on the sample is a ghost. */
const GHOST = 4;
/** Longest recording that is compared, s. */
const MOST = 60;
const at = id => document.getElementById(id);

export class Recording {
  /** `current` gives the setup, `ask` reaches the helper, `taken` is called with a fitted setup, `saved` with a text. */
  constructor(current, ask, taken, saved) {
    Object.assign(this, { current, ask, taken, saved, raw: null, path: null });
    this.over = new Chart(at('over'), { x: 'time since release / s', y: 'mm' });
    this.residuals = new Chart(at('residual'), { x: 'time since release / s', y: 'mm' });
    const drop = at('drop');
    addEventListener('dragover', event => { event.preventDefault(); drop.classList.add('over'); });
    addEventListener('dragleave', () => drop.classList.remove('over'));
    addEventListener('drop', event => {
      event.preventDefault();
      drop.classList.remove('over');
      if (event.dataTransfer.files[0]) this.open(event.dataTransfer.files[0]);
    });
    at('file').addEventListener('change', event => event.target.files[0] && this.open(event.target.files[0]));
    at('fit').addEventListener('click', () => this.fit());
    at('save-experiment').addEventListener('click', () => this.save());
  }

  async open(file) {
    try {
      this.raw = read(file.name, await file.arrayBuffer());
      Object.assign(this, { file: file.name, fitted: [], isInstantKnown: false });
    } catch (error) {
      this.raw = this.path = null;
      at('measured').hidden = true;
      return this.say(`This file cannot be read: ${error.message}.`, true);
    }
    const { time, markers, findings } = this.raw;
    this.say(`${file.name}: ${time.length} samples, ${digits(time.at(-1) - time[0])} s. ${findings.join('. ')}`);
    at('measured').hidden = false;
    at('fitted').replaceChildren();
    const tip = markers.findLast(({ name }) => /tip|end/i.test(name)) ?? markers[0];
    this.choice = { marker: tip.name, ...axes(tip), align: true };
    this.choice.release = release(time, this.seen().map(([, z]) => z));
    this.choices();
    this.take();
    at('measured').scrollIntoView({ block: 'nearest' });
  }

  say(text, isBad = false) {
    at('said').textContent = text;
    at('said').className = isBad ? 'bad' : '';
  }

  /** The chosen marker, forward and up, m. */
  seen() {
    const { axes } = this.raw.markers.find(({ name }) => name === this.choice.marker);
    const of = axis => axes[axis.at(-1)].map(value => (axis[0] === '−' ? -value : value));
    const [x, z] = [of(this.choice.forward), of(this.choice.up)];
    return x.map((x, k) => [x, z[k]]);
  }

  choices() {
    const { markers } = this.raw;
    const label = (text, input) => {
      const label = document.createElement('label');
      label.append(text, input);
      return label;
    };
    const select = (text, key, options) => {
      const select = document.createElement('select');
      select.append(...options.map(option => new Option(option, option, false, option === this.choice[key])));
      select.id = `choice-${key}`;
      select.addEventListener('change', () => {
        this.choice[key] = select.value;
        this.take();
      });
      return label(text, select);
    };
    const known = Object.keys(markers.find(({ name }) => name === this.choice.marker).axes);
    const ways = [...known, ...known.map(axis => `−${axis}`)];
    const instant = Object.assign(document.createElement('input'), {
      type: 'number', step: 'any', id: 'choice-release', value: this.choice.release.toFixed(3),
    });
    instant.addEventListener('change', () => {
      if (instant.value !== '' && instant.validity.valid) [this.choice.release, this.isInstantKnown] = [Number(instant.value), true];
      this.take();
    });
    const align = Object.assign(document.createElement('input'), { type: 'checkbox', checked: this.choice.align });
    align.addEventListener('change', () => {
      this.choice.align = align.checked;
      this.take();
    });
    at('choices').replaceChildren(
      select('Tip', 'marker', markers.map(({ name }) => name)), select('Forward', 'forward', ways), select('Up', 'up', ways),
      label('Let go at, s', instant), label(align, ' place its hold at the simulated start'),
    );
  }

  /** The path in the frame at the clamp, since the release. */
  async take() {
    const all = this.seen(), { time } = this.raw;
    const { release, align } = this.choice;
    const isGhost = ghosts(all);
    const isSeen = k => all[k].every(Number.isFinite) && !isGhost.has(k);
    const kept = time.map((_, k) => k).filter(k => isSeen(k) && time[k] >= release && time[k] - release < MOST);
    if (kept.length < 10) {
      this.path = null;
      return this.say(`The tip is seen ${kept.length} times after ${digits(release)} s: choose another marker or instant.`, true);
    }
    const held = all.filter((_, k) => isSeen(k) && time[k] <= release);
    this.hold = [0, 1].map(k => (held.length ? held.reduce((sum, seen) => sum + seen[k], 0) / held.length : all[kept[0]][k]));
    at('s-over').textContent = isGhost.size ? `${isGhost.size} samples that jump are left out` : '';
    this.raws = { time: kept.map(k => time[k] - release), seen: kept.map(k => all[k]), align };
    await this.compare();
  }

  /** Simulates as long as the recording is, and draws both. */
  async compare() {
    if (!this.raw || !this.raws) return;
    const { time, seen, align } = this.raws;
    const turn = this.turn = (this.turn ?? 0) + 1;
    let run;
    try {
      run = await this.ask({ ask: 'release', setup: { ...this.current(), duration: Math.max(0.1, time.at(-1)), rate: 200, tolerance: 1e-6 } });
    } catch (error) {
      return this.say(error.message, true);
    }
    if (turn !== this.turn) return;
    const shift = align ? [0, 1].map(k => run.tip[0][k] - this.hold[k]) : [0, 0];
    const tip = seen.map(point => point.map((value, k) => value + shift[k]));
    this.path = { time, tip };
    const { series } = palette();
    const mm = values => values.map(value => 1e3 * value);
    this.over.show([
      { x: time, y: mm(tip.map(([, z]) => z)), colour: series[2], dots: true, name: 'measured' },
      { x: run.time, y: mm(run.tip.map(([, z]) => z)), colour: series[0], name: 'simulated' },
    ]);
    const apart = [[], []];
    let square = 0;
    time.forEach((t, k) => {
      const place = Math.min(t * 200, run.time.length - 1), low = Math.min(Math.floor(place), run.time.length - 2), share = place - low;
      [0, 1].forEach(axis => {
        const simulated = run.tip[low][axis] + share * (run.tip[low + 1][axis] - run.tip[low][axis]);
        apart[axis].push(1e3 * (tip[k][axis] - simulated));
        square += apart[axis].at(-1) ** 2;
      });
    });
    this.residuals.show([
      { x: time, y: apart[1], colour: series[0], thin: true, name: 'up' },
      { x: time, y: apart[0], colour: series[1], thin: true, dash: [4, 3], name: 'forward' },
    ]);
    this.rms = Math.sqrt(square / time.length);
    at('s-residual').textContent = `${digits(this.rms)} mm rms`;
    at('over').ariaLabel = `Measured and simulated height; they differ by ${digits(this.rms)} mm rms`;
    at('residual').ariaLabel = `Residual of ${digits(this.rms)} mm rms`;
  }

  /** Where the tip was measured at a time since the release. */
  at(time) {
    if (!this.path) return null;
    const k = this.path.time.findIndex(t => t >= time);
    return k < 0 ? null : this.path.tip[k];
  }

  async fit() {
    if (!this.path) return;
    const setup = structuredClone(this.current());
    const unknowns = [EI, ALPHA, BETA, ...(at('fit-clock').checked ? [OFFSET] : [])];
    at('fit').disabled = true;
    this.say('Fitting; the muscle swings on meanwhile.');
    try {
      const fitted = await this.ask({ ask: 'fit', setup, unknowns, ...this.path });
      const value = path => fitted.found.find(found => found.path === path)?.value;
      setup.rod.bending_stiffness = value(EI);
      (setup.effects.rayleigh_mass ??= {}).alpha = value(ALPHA);
      (setup.effects.rayleigh_stiffness ??= {}).beta = value(BETA);
      this.choice.release -= value(OFFSET) ?? 0;
      this.fitted = unknowns.filter(path => path !== OFFSET);
      this.isInstantKnown ||= value(OFFSET) !== undefined;
      at('choice-release').value = this.choice.release.toFixed(4);
      this.report(fitted);
      this.taken(setup);
      await this.take();
    } catch (error) {
      this.say(`The fit ended without a result: ${error.message}.`, true);
    } finally {
      at('fit').disabled = false;
    }
  }

  /** The recording, what is known of it and the setup, as an experiment for the program. */
  async save() {
    const { marker, forward, up, release, align } = this.choice;
    const axis = of => of.replace('−', '-').replace(/^(?=[xyz])/, '+');
    const recording = {
      file: this.file, tip: this.raw.markers.find(({ name }) => name === marker).own, along: axis(forward), up: axis(up),
      unit: this.raw.unit ?? null, instant: this.isInstantKnown ? release : null, is_placed: align, fitted: this.fitted,
    };
    try {
      this.saved(await this.ask({ ask: 'experiment', setup: this.current(), recording }));
    } catch (error) {
      this.say(`The experiment cannot be saved: ${error.message}.`, true);
    }
  }

  report({ found, before_mm, after_mm, evaluations, converged }) {
    const table = document.createElement('table');
    table.createTHead().insertRow().append(...['Parameter', 'Value', 'Standard error'].map(text =>
      Object.assign(document.createElement('th'), { textContent: text, scope: 'col' })));
    const body = table.createTBody();
    for (const { path, unit, value, standard_error, at_bound } of found.filter(({ path }) => path in FITTED)) {
      const { factor, symbol } = shown(unit, value || 1);
      const row = body.insertRow();
      row.insertCell().textContent = FITTED[path];
      row.insertCell().textContent = `${digits(value / factor, 4)} ${symbol}`;
      row.insertCell().textContent = at_bound ? 'hit its bound' : standard_error ? `± ${digits(standard_error / factor, 2)} ${symbol}` : '–';
      row.dataset.path = path;
      row.dataset.value = value;
    }
    const note = Object.assign(document.createElement('p'), { className: 'note', textContent:
      'Standard errors take residuals as independent; efam calibrate gives honest intervals. One recording seldom tells α from β.' });
    at('fitted').replaceChildren(table, note);
    this.say(`Fitted${converged ? '' : ', not to the end'}: residual ${digits(before_mm)} mm before, ${digits(after_mm)} mm after, ${evaluations} runs.`);
  }
}

/** The axis that moves most is up; of the others the one that is longest is forward. */
function axes({ axes }) {
  const extent = values => {
    const seen = values.filter(Number.isFinite);
    return Math.max(...seen) - Math.min(...seen);
  };
  const names = Object.keys(axes);
  if (names.length === 2) return { forward: names[0], up: names[1] };
  const up = names.toSorted((a, b) => extent(axes[b]) - extent(axes[a]))[0];
  // It rests below where it was held.
  const seen = axes[up].filter(Number.isFinite);
  const sign = seen.at(-1) > seen[0] ? '−' : '';
  const size = axis => Math.abs(axes[axis].find(Number.isFinite) ?? 0);
  const forward = names.filter(axis => axis !== up).toSorted((a, b) => size(b) - size(a))[0];
  return { forward: (axes[forward].find(Number.isFinite) < 0 ? '−' : '') + forward, up: sign + up };
}

/** When the tip leaves its hold, on the recording's clock: the last time that it is near before it goes far. */
function release(time, z) {
  const smooth = medians(z);
  const seen = smooth.filter(Number.isFinite);
  const way = Math.max(...seen) - Math.min(...seen);
  const held = middle(smooth.slice(0, 15));
  let k = Math.max(0, smooth.findIndex(z => Math.abs(z - held) > 0.15 * way));
  while (k > 0 && !(Math.abs(smooth[k] - held) <= LEFT * way)) k--;
  return time[k];
}

/** Places where a coordinate jumps away from its neighbours and back: its bend is far beyond the noise and that of the
 *  curve nearby. A turning point of a fast swing bends as much as what is around it. */
function ghosts(all) {
  const found = new Set();
  const seen = all.map((_, k) => k).filter(k => all[k].every(Number.isFinite));
  for (const axis of [0, 1]) {
    const value = k => all[seen[k]][axis];
    const bends = seen.map((_, k) => (k && k + 1 < seen.length ? Math.abs(value(k) - (value(k - 1) + value(k + 1)) / 2) : 0));
    const noise = middle(bends);
    bends.forEach((bend, k) => {
      const nearby = Math.max(...[-4, -3, -2, 2, 3, 4].map(by => bends[k + by] ?? 0));
      if (bend > GHOST * Math.max(nearby, noise) && bend >= Math.max(bends[k - 1] ?? 0, bends[k + 1] ?? 0)) found.add(seen[k]);
    });
  }
  return found;
}

/** The median of five about each. */
function medians(values) {
  return values.map((_, k) => middle(values.slice(Math.max(0, k - 2), k + 3)));
}

function middle(values) {
  const seen = values.filter(Number.isFinite).toSorted((a, b) => a - b);
  return seen[Math.floor(seen.length / 2)] ?? NaN;
}
