// Joins the parts: what was set goes to the core, what it answers goes to the stage and the charts.

import { Chart, palette } from './chart.js';
import { slider } from './controls.js';
import { compiled, core, helper } from './door.js';
import { Library } from './library.js';
import { Recording } from './recording.js';
import { peak, spectrum } from './spectrum.js';
import { Stage } from './stage.js';
import { first, fromTable, packed, plain, unpacked } from './state.js';
import { digits } from './units.js';

const byId = id => document.getElementById(id);
const NAMES = ['Muscle A', 'Muscle B'];
/** Longest time that a frame makes up for, s: a page in the background stands still. */
const MOST_FRAME = 1 / 20;
/** Quiet time after a change before a whole release is computed, ms. */
const QUIET = 120;
/** Highest frequency of the spectrum, Hz. */
const HIGHEST = 6;
/** Tolerance of runs that are only drawn; what is saved has the finer one of the core's door. */
const SEEN = 1e-6;

const module = await compiled();
const ask = await core(module);
const later = helper(module);
const catalogue = ask({ ask: 'catalogue' });
const stage = new Stage(byId('stage'));
const charts = {
  height: new Chart(byId('height'), { x: 'time / s', y: 'mm' }),
  spectrum: new Chart(byId('spectrum'), { x: 'frequency / Hz', y: 'mm' }),
  energy: new Chart(byId('energy'), { x: 'time / s', y: 'mJ' }),
  phase: new Chart(byId('phase'), { x: 'height / mm', y: 'm/s' }),
};

let state = unpacked(location.hash) ?? { setups: [first(catalogue)], speed: 1 };
// Who asked for less motion begins with a rod that is held.
let isPaused = matchMedia('(prefers-reduced-motion: reduce)').matches;
let edited = 0, trails = [], frames = [], rests = [], runs = [];
/** What frames cost, ms: shown to whoever looks, read by the check. */
const cost = { last: [], mean: 0, most: 0 };
const setup = () => state.setups[edited];

// --- what is set

const trouble = text => {
  byId('trouble').hidden = !text;
  byId('trouble').textContent = text ?? '';
};

const effect = (name, key) => catalogue.effects.find(effect => effect.name === name).parameters.find(p => p.name === key);
const own = (name, key, label, reach, display) => {
  const p = effect(name, key);
  return {
    label, unit: p.unit, range: p.range, reach, display, hint: p.meaning,
    get: () => setup().effects[name]?.[key] ?? p.null_value ?? p.default,
    set: value => { (setup().effects[name] ??= {})[key] = value; },
  };
};

function mainControls() {
  const { pressures } = catalogue.muscles[0];
  const range = [pressures[0], pressures.at(-1)];
  const pressure = {
    label: 'Pressure', unit: 'Pa', range, reach: range, step: 0.5, display: { factor: catalogue.psi, symbol: 'psi' },
    get: () => setup().pressure, set: value => { setup().pressure = Math.min(Math.max(value, range[0]), range[1]); },
  };
  const angle = {
    label: 'Angle of release', unit: 'rad', range: [-1.4, 1.4], reach: [-Math.PI / 3, Math.PI / 3], step: 1,
    get: () => setup().angle ?? 0, set: value => { setup().angle = value; }, hint: 'at another angle than the clamp a string holds the tip',
  };
  return [
    ...(setup().muscle ? [pressure] : []),
    own('payload', 'mass', 'Payload', [0, 0.2]),
    angle,
    own('rayleigh_mass', 'alpha', 'Mass damping α', [0, 5]),
    own('rayleigh_stiffness', 'beta', 'Stiffness damping β', [0, 0.02], { factor: 1e-3, symbol: 'ms' }),
  ];
}

function showControls() {
  const controls = mainControls().map(control => ({ control, made: slider({ ...control, value: control.get(), set: value => {
    control.set(value);
    changed();
  } }) }));
  byId('main-sliders').replaceChildren(...controls.map(({ made }) => made.box));
  byId('muscle').value = setup().muscle ?? '';
  byId('which').hidden = state.setups.length < 2;
  byId('which').replaceChildren(...state.setups.map((_, k) => {
    const button = Object.assign(document.createElement('button'), { textContent: NAMES[k], ariaPressed: k === edited });
    button.addEventListener('click', () => {
      edited = k;
      showControls();
      library.show();
    });
    return button;
  }));
  byId('second').setAttribute('aria-pressed', state.setups.length > 1);
  byId('speed').value = String(state.speed);
}

let quiet;
function changed() {
  try {
    frames[edited] = ask({ ask: 'change', rod: edited, setup: setup() });
    trouble();
  } catch (error) {
    return trouble(error.message);
  }
  clearTimeout(quiet);
  const which = edited;
  quiet = setTimeout(() => computed(which), QUIET);
  history.replaceState(null, '', `#${packed(state)}`);
}

/** A whole release of a setup, its rest and modes, on the other thread. */
const turns = [0, 0];
async function computed(which) {
  const turn = ++turns[which], wanted = structuredClone(state.setups[which]);
  try {
    const [run, rest] = [await later({ ask: 'release', setup: { ...wanted, tolerance: SEEN } }), await later({ ask: 'rest', setup: wanted })];
    if (turn !== turns[which] || which >= state.setups.length) return;
    [runs[which], rests[which]] = [run, rest];
    showCharts();
    recording.compare();
  } catch (error) {
    if (turn === turns[which]) trouble(error.message);
  }
}

function letGo() {
  state.setups.forEach((setup, k) => {
    try {
      frames[k] = ask({ ask: 'let_go', rod: k, setup });
    } catch (error) {
      trouble(`${error.message}; the page starts anew`);
      // Such as a link with values that the core refuses.
      state.setups[k] = first(catalogue);
      frames[k] = ask({ ask: 'let_go', rod: k, setup: state.setups[k] });
      showControls();
    }
    trails[k] = { time: [], z: [], speed: [] };
    stage.clear(k);
  });
  frames.length = trails.length = state.setups.length;
}

function everything() {
  runs.length = rests.length = Math.min(runs.length, state.setups.length);
  edited = Math.min(edited, state.setups.length - 1);
  showControls();
  library.show();
  letGo();
  state.setups.forEach((_, k) => computed(k));
  history.replaceState(null, '', `#${packed(state)}`);
}

// --- what is seen

function showCharts() {
  const { series } = palette();
  const of = (k, colour = series[k]) => ({ colour, thin: true, dash: k ? [6, 4] : undefined, name: runs.length > 1 ? NAMES[k] : '' });
  const each = make => runs.flatMap((run, k) => (run ? make(run, k) : []));
  const heights = run => run.tip.map(([, z]) => 1e3 * z);
  charts.height.show(each((run, k) => [{ x: run.time, y: heights(run), ...of(k), name: of(k).name || 'height' }]));
  const spectra = runs.map(run => run && spectrum(heights(run), 1 / (run.time[1] - run.time[0]), HIGHEST));
  charts.spectrum.show(each((_, k) => [{ x: spectra[k].frequency, y: spectra[k].amplitude, ...of(k), name: of(k).name || 'amplitude' }]));
  charts.phase.show(each((run, k) => [{ x: heights(run), y: run.tip_velocity.map(([, v]) => v), ...of(k) }]));
  const run = runs[edited] ?? runs[0];
  const parts = ['motion', 'bending', 'height', 'lost'];
  charts.energy.show(parts.map((name, k) => ({
    x: run.time, y: run.energy.map(energy => 1e3 * energy[k]), colour: series[k], thin: true, name, dash: [undefined, [6, 4], [2, 3], [9, 3, 2, 3]][k],
  })));
  const found = runs.map((run, k) => run && `${digits(peak(spectra[k]).frequency)} Hz`).filter(Boolean);
  byId('s-spectrum').textContent = `peak at ${found.join(' and ')}`;
  byId('s-energy').replaceChildren(...parts.map((name, k) => {
    const part = Object.assign(document.createElement('b'), { textContent: `${name} ` });
    part.style.color = series[k];
    return part;
  }), runs.length > 1 ? `of ${NAMES[edited]}` : '');
  const bumped = bump(run);
  byId('s-height').textContent = bumped ? `bump of ${digits(bumped.size, 2)} mm at ${digits(bumped.time)} s` : `lowest ${digits(Math.min(...heights(run)))} mm`;
  byId('height').ariaLabel = `Height of the tip over time; ${byId('s-height').textContent}`;
  byId('spectrum').ariaLabel = `Spectrum of the height; ${byId('s-spectrum').textContent}`;
  byId('energy').ariaLabel = 'Energy of motion, bending and height, and what is lost, over time';
  byId('phase').ariaLabel = 'Speed of the tip over its height: a spiral towards rest';
}

/** The paper's bump: before the tip first rises to its upper peak it passes two lows with a top between them. */
function bump(run) {
  const z = run.tip.map(([, z]) => z);
  const turn = (k, sign) => sign * z[k] < sign * z[k - 1] && sign * z[k] <= sign * z[k + 1];
  const lows = [];
  for (let k = 1; k + 1 < z.length && lows.length < 2; k++) if (turn(k, 1)) lows.push(k);
  if (lows.length < 2) return null;
  let top = lows[0];
  for (let k = lows[0]; k < lows[1]; k++) if (z[k] > z[top]) top = k;
  const size = z[top] - Math.max(z[lows[0]], z[lows[1]]);
  return size > 1e-4 && size < 0.4 * (z[0] - z[lows[0]]) ? { time: run.time[top], size: 1e3 * size } : null;
}

function say() {
  const lines = frames.map((frame, k) => {
    const swing = rests[k]?.modes[0];
    const pressure = state.setups[k].muscle ? `${(frame.pressure / catalogue.psi).toFixed(1)} psi, ` : '';
    const mode = swing ? `${digits(swing[0])} Hz, damping ratio ${digits(swing[1])}` : '';
    const tip = `tip ${(1e3 * frame.tip[1]).toFixed(0).replace('-', '−')} mm`;
    return frames.length > 1 ? `${NAMES[k]}: ${pressure}${tip}, ${swing ? `${digits(swing[0])} Hz` : ''}`
      : `${pressure}${frame.time.toFixed(2)} s\n${tip}\n${mode}`;
  });
  byId('live').textContent = lines.join('\n');
}

let before, told = 0;
function frame(now) {
  requestAnimationFrame(frame);
  const passed = Math.min((now - (before ?? now)) / 1000, MOST_FRAME);
  before = now;
  const begun = performance.now();
  if (!isPaused && passed > 0) {
    state.setups.forEach((setup, k) => {
      try {
        frames[k] = ask({ ask: 'step', rod: k, duration: passed * state.speed });
      } catch (error) {
        trouble(`${error.message}; it is let go again`);
        letGo();
      }
      const { time, tip, tip_velocity } = frames[k], trail = trails[k];
      trail.time.push(time);
      trail.z.push(1e3 * tip[1]);
      trail.speed.push(tip_velocity[1]);
      if (trail.time.length > 1500) for (const list of Object.values(trail)) list.shift();
    });
    cost.last.push(performance.now() - begun);
    if (cost.last.length > 240) cost.last.shift();
    cost.mean = cost.last.reduce((sum, ms) => sum + ms, 0) / cost.last.length;
    cost.most = Math.max(...cost.last);
  }
  stage.measured = frames.length === 1 ? recording.at(frames[0].time) : null;
  stage.show(frames, rests.map(rest => rest?.nodes), state.setups.map(setup => setup.rod.diameter ?? fromTable(catalogue, setup, 'diameter')), NAMES);
  if (now - told > 100) {
    told = now;
    say();
    if (runs.length) marks();
  }
}

function marks() {
  const { series } = palette();
  const live = make => trails.flatMap((trail, k) => (frames[k] && trail ? make(trail, frames[k], series[k]) : []));
  charts.height.mark(live(({ time, z }, frame, colour) => [{ x: time, y: z, colour }, { x: frame.time, y: 1e3 * frame.tip[1], colour }]));
  charts.phase.mark(live(({ z, speed }, frame, colour) => [
    { x: z.slice(-90), y: speed.slice(-90), colour }, { x: 1e3 * frame.tip[1], y: frame.tip_velocity[1], colour }]));
  const energy = frames[edited]?.energy;
  if (energy) charts.energy.mark(energy.map((joule, k) => ({ x: frames[edited].time, y: 1e3 * joule, colour: series[k] })));
}

// --- what is pressed

const library = new Library(catalogue, setup, () => { showControls(); changed(); });
const recording = new Recording(() => state.setups[0], later, fitted => {
  state.setups[0] = fitted;
  everything();
}, text => {
  save(text, 'experiment.toml');
  recording.say('Saved as experiment.toml: put it beside the recording.');
});
function save(text, name) {
  const link = Object.assign(document.createElement('a'), {
    href: URL.createObjectURL(new Blob([text], { type: 'application/toml' })), download: name,
  });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}


byId('muscle').append(...catalogue.muscles.map(({ name }) => new Option(name, name)), new Option('plain rod without a muscle', ''));
byId('muscle').addEventListener('change', ({ target }) => {
  state.setups[edited] = target.value ? { ...first(catalogue), effects: setup().effects } : plain(catalogue, setup());
  if (!target.value) library.chosen = '';
  everything();
});
byId('lesson').textContent = 'At 15 psi the tip swings past straight down. Its height then has a second bump in each of the '
  + 'first swings, as the paper measured (Garbulinski and Wereley 2022, Figure 8).';
byId('bump').addEventListener('click', () => {
  state.setups[edited] = first(catalogue);
  everything();
});
byId('go').addEventListener('click', letGo);
byId('pause').addEventListener('click', () => {
  isPaused = !isPaused;
  byId('pause').setAttribute('aria-pressed', isPaused);
});
byId('speed').addEventListener('change', ({ target }) => {
  state.speed = Number(target.value);
  history.replaceState(null, '', `#${packed(state)}`);
});
byId('second').addEventListener('click', () => {
  if (state.setups.length > 1) state.setups.pop();
  else state.setups.push(structuredClone(state.setups[0]));
  edited = state.setups.length - 1;
  everything();
});
byId('reset').addEventListener('click', () => {
  state = { setups: [first(catalogue)], speed: 1 };
  everything();
});
byId('save').addEventListener('click', () => {
  save(ask({ ask: 'scenario', setup: setup() }), 'playground.toml');
  byId('kept').textContent = 'Saved as playground.toml.';
});
byId('share').addEventListener('click', async () => {
  history.replaceState(null, '', `#${packed(state)}`);
  try {
    await navigator.clipboard.writeText(location.href);
    byId('kept').textContent = 'The link is in the clipboard.';
  } catch {
    byId('kept').textContent = 'The link is in the address bar.';
  }
});
addEventListener('keydown', event => {
  if (event.ctrlKey || event.metaKey || event.altKey || event.target.matches('input[type=search], input[type=number], select')) return;
  const button = { l: 'go', p: 'pause' }[event.key.toLowerCase()];
  if (button) byId(button).click();
});
addEventListener('hashchange', () => {
  const linked = unpacked(location.hash);
  if (!linked) return;
  state = linked;
  everything();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', showCharts);

byId('pause').setAttribute('aria-pressed', isPaused);
everything();
requestAnimationFrame(frame);
/** For the check, which drives this page. */
globalThis.playground = { ask, later, cost, state: () => state, frames: () => frames, recording };
