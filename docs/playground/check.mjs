// Drives the playground in Chromium: numbers, sliders, recording, fit, link, sizes, keyboard, broken files, silence.

import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

import { start } from './browser.mjs';

const [file, ...options] = process.argv.slice(2);
const url = pathToFileURL(resolve(file)).href;
const scratch = mkdtempSync(join(tmpdir(), 'playground-'));
const { BROWSER, EFAM } = process.env;
const PSI = 6894.757293168361;
const BEAM = 'sim/tests/program/cases/lab_esc.c3d';
const RECORDING = 'scenarios/diagnosis/nothing/15psi-1.csv';
/** Largest size of the page, bytes; longest time of a frame's integration and to the first paint, ms. */
const MOST = { bytes: 3e6, frame: 4, paint: 1000 };
const browser = await start(BROWSER);
const told = (what, ...figures) => console.log(`${what.padEnd(34)}${figures.join('  ')}`);

async function opened(shape = { width: 1280, height: 800 }, fragment = '') {
  const page = await browser.page(shape);
  await page.go(url + fragment);
  await page.until('globalThis.playground?.frames().length > 0');
  return page;
}

/** What a page may not do: complain, or ask for anything but itself and what it made. */
function silent({ complaints, requests }) {
  assert.deepEqual(complaints, []);
  assert.deepEqual(requests.filter(request => !/^(file|data|blob):/.test(request)), []);
}

async function size() {
  const { size } = statSync(file);
  assert.ok(size < MOST.bytes, `${size} bytes`);
  told('one file', `${(size / 1e6).toFixed(2)} MB`);
}

/** With a limit of the software renderer of a machine without a graphics card: the integration alone is measured. */
async function speed() {
  const page = await opened();
  const paint = await page.run(`performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? 0`);
  await new Promise(done => setTimeout(done, 3000));
  const { mean, most, count } = await page.run('({ ...playground.cost, count: playground.cost.last.length })');
  // A screen of 60 Hz: what a second of swing costs, in frames that are not drawn.
  const exact = await page.run(`(() => {
    playground.ask({ ask: 'let_go', rod: 9, setup: playground.state().setups[0] });
    const cost = [];
    for (let k = 0; k < 600; k++) { const t = performance.now(); playground.ask({ ask: 'step', rod: 9, duration: 1 / 60 }); cost.push(performance.now() - t); }
    cost.sort((a, b) => a - b);
    return { median: cost[300], high: cost[594] };
  })()`);
  assert.ok(exact.median < MOST.frame, `a frame costs ${exact.median} ms`);
  assert.ok(paint > 0 && paint < MOST.paint, `first paint after ${paint} ms`);
  told('frame of 1/60 s, 32 nodes', `median ${exact.median.toFixed(2)} ms, 99 % below ${exact.high.toFixed(2)} ms; while drawing ${mean.toFixed(2)} ms, at most ${most.toFixed(2)} ms of ${count}`);
  told('first paint from disk', `${paint.toFixed(0)} ms`);
  silent(page);
}

/** The same setup by the program: text and numbers. */
async function numbers() {
  const page = await opened();
  const muscle = { muscle: 'garbulinski-2022', nodes: 32, duration: 10, rate: 100 };
  const damping = { rayleigh_mass: { alpha: 1 }, rayleigh_stiffness: { beta: 2e-3 } };
  const setups = [
    { ...muscle, pressure: 15 * PSI, rod: {}, angle: 0, effects: damping },
    { ...muscle, pressure: 300e3, rod: { bending_stiffness: 0.011 }, angle: 0.5,
      effects: { ...damping, payload: { mass: 0.05 }, air_drag: { drag_coefficient: 1.4 }, viscoelastic: {} } },
    { muscle: null, rod: { length: 0.3, mass: 0.05, bending_stiffness: 0.02, diameter: 0.01 }, nodes: 24, duration: 3, rate: 120, angle: 0, effects: damping },
    // Friction turns round with a kink: there the last digits decide which step is refused, and the path differs within
    // its tolerance.
    { ...muscle, pressure: 300e3, rod: {}, angle: 0, effects: { ...damping, dahl: {} }, most: 1e-6 },
  ];
  for (const [k, { most: admitted = 1e-9, ...setup }] of setups.entries()) {
    const text = await page.run(`playground.ask({ ask: 'scenario', setup: ${JSON.stringify(setup)} })`);
    const [scenario, out] = [join(scratch, `${k}.toml`), join(scratch, `run-${k}`)];
    writeFileSync(scenario, text);
    execFileSync(EFAM, ['simulate', scenario, '--csv', '--json', '--no-error-estimate', '--out', out], { stdio: ['ignore', 'ignore', 'inherit'] });
    const [head, ...rows] = readFileSync(join(out, 'trajectory.csv'), 'utf8').trim().split('\n').map(line => line.split(','));
    const columns = ['tip_x_m', 'tip_z_m'].map(name => head.indexOf(name));
    assert.ok(columns.every(column => column >= 0), head.slice(0, 12).join());
    const run = await page.run(`playground.ask({ ask: 'release', setup: ${JSON.stringify(setup)} })`);
    assert.equal(run.tip.length, rows.length);
    const apart = rows.map((row, k) => Math.max(...columns.map((column, axis) => Math.abs(Number(row[column]) - run.tip[k][axis]))));
    const most = Math.max(...apart);
    assert.ok(most < admitted, `setup ${k}: ${most} m apart`);
    told(`numbers of efam simulate, ${k + 1}`, `${rows.length} samples, ${most.toExponential(1)} m apart at most`);
  }
  silent(page);
}

async function sliders() {
  const page = await opened();
  const before = await page.run('playground.state().setups[0].pressure');
  await page.run(`document.querySelector('#main-sliders input[type=range]').focus()`);
  for (let k = 0; k < 5; k++) await page.key('ArrowRight', 'ArrowRight', 39);
  const after = await page.run('playground.state().setups[0].pressure');
  assert.ok(Math.abs(after - before - 2.5 * PSI) < 1, `${before} to ${after} Pa`);
  await page.until(`Math.abs(playground.frames()[0].pressure - ${after}) < 1`);
  // An effect by its name: found, switched on, moved; its page is beside it.
  await page.run(`(() => { const find = document.getElementById('find'); find.value = 'drag'; find.dispatchEvent(new Event('input')); })()`);
  await page.run(`document.querySelector('#effects input[data-name=air_drag]').click()`);
  assert.match(await page.run(`document.querySelector('#effect pre').textContent`), /Law:\s+f = /);
  await page.run(`document.querySelector('#effect input[type=range]').focus()`);
  await page.key('End', 'End', 35);
  const coefficient = await page.run('playground.state().setups[0].effects.air_drag.drag_coefficient');
  assert.equal(coefficient, 6);
  await page.key('Tab', 'Tab', 9);
  // Each effect can be switched on and off while the rod swings.
  const names = await page.run(`playground.ask({ ask: 'catalogue' }).effects.filter(effect => !effect.is_baseline).map(effect => effect.name)`);
  await page.run(`(() => { const find = document.getElementById('find'); find.value = ''; find.dispatchEvent(new Event('input')); })()`);
  for (const name of names) {
    await page.run(`document.querySelector('#effects input[data-name=${name}]').click()`);
    await page.run(`document.querySelector('#effects input[data-name=${name}]').click()`);
    assert.equal(await page.run(`document.getElementById('trouble').textContent`), '', name);
  }
  // Two muscles, slow motion, a pause, another release.
  await page.run(`document.getElementById('second').click()`);
  await page.until('playground.frames().length === 2');
  await page.run(`document.activeElement.blur()`);
  await page.key('l', 'KeyL', 76);
  assert.ok((await page.run('playground.frames()[0].time')) < 0.3);
  await page.run(`(() => { const speed = document.getElementById('speed'); speed.value = '0.1'; speed.dispatchEvent(new Event('change')); })()`);
  await page.key('p', 'KeyP', 80);
  const stopped = await page.run('playground.frames()[0].time');
  await new Promise(done => setTimeout(done, 200));
  assert.equal(await page.run('playground.frames()[0].time'), stopped);
  // The bump of the paper.
  await page.run(`document.getElementById('second').click()`);
  await page.run(`document.getElementById('bump').click()`);
  await page.until(`/bump of/.test(document.getElementById('s-height').textContent) && /peak at 1.43 Hz$/.test(document.getElementById('s-spectrum').textContent)`);
  told('sliders, effects, keys', `${names.length} effects on and off; ${await page.run(`document.getElementById('s-height').textContent`)}; ${await page.run(`document.getElementById('s-spectrum').textContent`)}`);
  silent(page);
}

async function fit() {
  const page = await opened();
  await page.files('#file', [resolve(RECORDING)]);
  await page.until(`/\\d mm rms/.test(document.getElementById('s-residual').textContent)`);
  const before = await page.run('playground.recording.rms');
  const begun = Date.now();
  await page.run(`document.getElementById('fit').click()`);
  await page.until(`document.querySelector('#fitted td') !== null && !document.getElementById('fit').disabled`, 90);
  const seconds = (Date.now() - begun) / 1000;
  await page.until(`playground.recording.rms < ${0.5 * before}`);
  const found = await page.run(`Object.fromEntries([...document.querySelectorAll('#fitted tbody tr')].map(row => [row.dataset.path, Number(row.dataset.value)]))`);
  const stiffness = found['rod.bending_stiffness'];
  // The same recording by the program.
  const experiment = join(scratch, 'experiment.toml');
  // By the experiment that the page saves, beside the recording.
  writeFileSync(join(scratch, '15psi-1.csv'), readFileSync(resolve(RECORDING)));
  await page.run(`globalThis.kept = null; playground.recording.saved = text => { globalThis.kept = text; }; document.getElementById('save-experiment').click()`);
  await page.until('globalThis.kept !== null');
  writeFileSync(experiment, await page.run('globalThis.kept'));
  execFileSync(EFAM, ['calibrate', experiment, '--json', '--out', join(scratch, 'calibration')], { stdio: ['ignore', 'ignore', 'ignore'] });
  const text = readFileSync(join(scratch, 'calibration', 'muscle.toml'), 'utf8');
  const columns = JSON.parse(text.match(/^columns = (\[.*\])/m)[1]);
  const rows = [...text.slice(text.indexOf('rows = [')).matchAll(/\[([-+.\de,\s]+)\]/g)].map(([, row]) => row.split(',').map(Number));
  const row = rows.find(row => Math.abs(row[columns.indexOf('pressure')] / PSI - 15) < 1e-6);
  const due = row[columns.indexOf('bending_stiffness_calibrated')];
  assert.ok(Math.abs(stiffness / due - 1) < 0.01, `EI ${stiffness}, efam calibrate ${due}`);
  told('a recording fitted', `EI ${(1e3 * stiffness).toFixed(3)} mN m2, ${(100 * (stiffness / due - 1)).toFixed(2)} % off efam calibrate; ${before.toFixed(2)} to ${(await page.run('playground.recording.rms')).toFixed(2)} mm; ${seconds.toFixed(1)} s`);
  return page;
}

/** A beam of silicone that others recorded, as C3D, on a rod without a muscle. Its residual falls as that of the program. */
async function beam() {
  const rod = { length: 0.1, mass: 0.0963, bending_stiffness: 0.016, diameter: 0.03 };
  const setup = { muscle: null, pressure: 0, rod, nodes: 32, angle: 0, duration: 4, rate: 100,
    effects: { rayleigh_mass: { alpha: 1 }, rayleigh_stiffness: { beta: 2e-3 } } };
  const page = await opened({ width: 1280, height: 800 }, `#${Buffer.from(JSON.stringify({ setups: [setup], speed: 1 })).toString('base64url')}`);
  // The file's one spoilt label, as its makers wrote it.
  const bytes = readFileSync(BEAM), file = join(scratch, 'beam.c3d');
  bytes.set(Buffer.from(' - '), bytes.indexOf('\u001b[3'));
  writeFileSync(file, bytes);
  await page.files('#file', [file]);
  await page.until(`/\\d mm rms/.test(document.getElementById('s-residual').textContent)`);
  await page.run(`document.getElementById('fit').click()`);
  await page.until(`document.querySelector('#fitted td') !== null && !document.getElementById('fit').disabled`, 90);
  const stiffness = Number(await page.run(`document.querySelector('#fitted tbody tr').dataset.value`));
  const names = await page.run('playground.recording.raw.markers.map(({ name }) => name)');
  const of = word => JSON.stringify(names.filter(name => name.includes(word) && !name.includes('mean')));
  writeFileSync(join(scratch, 'beam.toml'), `[rod]\nlength = "100 mm"\nmass = "96.3 g"\nbending_stiffness = "0.016 N m^2"\n`
    + `[effects.rayleigh_mass]\nalpha = "1 1/s"\n[effects.rayleigh_stiffness]\nbeta = "2 ms"\n`
    + `[[recording]]\nfile = ${JSON.stringify(file)}\ntip = ${of('Tip')}\nbase = ${of('Base')}\nangle = "0 deg"\n`);
  execFileSync(EFAM, ['calibrate', join(scratch, 'beam.toml'), '--json', '--out', join(scratch, 'beam')], { stdio: ['ignore', 'ignore', 'inherit'] });
  const due = Number(readFileSync(join(scratch, 'beam', 'rod.toml'), 'utf8').match(/bending_stiffness = "?([\d.e-]+)/)[1]);
  assert.ok(Math.abs(stiffness / due - 1) < 0.01, `EI ${stiffness}, efam calibrate ${due}`);
  told('the silicone beam as C3D', `EI ${(1e3 * stiffness).toFixed(2)} mN m2, ${(100 * (stiffness / due - 1)).toFixed(2)} % off efam calibrate; ${(await page.run('playground.recording.rms')).toFixed(2)} mm`);
  silent(page);
}

/** Files that are none, dropped; the page says so and goes on. */
async function broken() {
  const page = await opened();
  const c3d = new Uint8Array(1024);
  [c3d[0], c3d[1], c3d[512 + 3]] = [2, 80, 84];
  const files = [['empty.csv', '""'], ['words.csv', '"once upon a time"'], ['text.csv', '"time_s,tip_x_mm\\n0,a\\n"'],
    ['cut.c3d', `new Uint8Array([${c3d}])`], ['back.csv', '"t_s,x_m,z_m\\n" + Array.from({ length: 20 }, (_, k) => `${20 - k},0,0`).join("\\n")']];
  for (const [name, content] of files) {
    await page.run(`(() => {
      const data = new DataTransfer();
      data.items.add(new File([${content}], '${name}'));
      dispatchEvent(new DragEvent('drop', { dataTransfer: data }));
    })()`);
    await page.until(`document.getElementById('said').className === 'bad' && document.getElementById('said').textContent.includes('cannot be read')`);
    await page.run(`document.getElementById('said').className = ''`);
  }
  const time = await page.run('playground.frames()[0].time');
  await page.until(`playground.frames()[0].time > ${time}`);
  told('broken files', `${files.length} refused in words`);
  silent(page);
}

async function link() {
  const page = await opened();
  await page.run(`document.getElementById('second').click()`);
  await page.run(`document.querySelector('#effects input[data-name=viscoelastic]').click()`);
  await page.run(`document.getElementById('share').click()`);
  const [hash, state] = [await page.run('location.hash'), await page.run('playground.state()')];
  const other = await opened({ width: 1280, height: 800 }, hash);
  assert.deepEqual(await other.run('playground.state()'), state);
  // Links may be anybody's.
  const wrong = value => Buffer.from(JSON.stringify(value)).toString('base64url');
  const hostile = ['#?', '#e30', `#${wrong({ setups: [{ rod: {}, effects: {}, nodes: 1e9 }], speed: 1 })}`,
    `#${wrong({ setups: [{ muscle: 'none', rod: {}, effects: { '<img src=x>': {} }, nodes: 32 }], speed: 1 })}`];
  for (const fragment of hostile) {
    const page = await opened({ width: 800, height: 600 }, fragment);
    await page.until('playground.frames()[0].time > 0');
    assert.equal(await page.run(`document.querySelectorAll('img').length`), 0);
    silent(page);
  }
  told('link', `${hash.length} characters hold the state; ${hostile.length} bad ones start anew`);
  silent(page);
}

/** No sideways scrolling, enough contrast (WCAG 2.2, 1.4.3), a name for each control. */
async function shapes() {
  for (const shape of [{ width: 1280, height: 800 }, { width: 390, height: 844 }, { width: 1280, height: 800, dark: true }, { width: 390, height: 844, dark: true }]) {
    const page = await opened(shape);
    await page.until(`/peak/.test(document.getElementById('s-spectrum').textContent)`);
    assert.equal(await page.run('document.documentElement.scrollWidth - innerWidth'), 0, `${shape.width} px`);
    const [contrast, text] = await page.run(`(() => {
      const colour = text => (text.match(/[\\d.]+/g) ?? []).map(Number);
      const light = ([r, g, b]) => { const [x, y, z] = [r, g, b].map(v => (v /= 255) <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4); return 0.2126 * x + 0.7152 * y + 0.0722 * z; };
      let least = [21, ''];
      for (const element of document.querySelectorAll('main *, header *')) {
        if (![...element.childNodes].some(node => node.nodeType === 3 && node.data.trim()) || !element.getClientRects().length) continue;
        let behind = element;
        while (behind && colour(getComputedStyle(behind).backgroundColor)[3] === 0) behind = behind.parentElement;
        const [low, high] = [light(colour(getComputedStyle(element).color)), light(colour(getComputedStyle(behind ?? document.body).backgroundColor))].sort((a, b) => a - b);
        const own = (high + 0.05) / (low + 0.05);
        if (own < least[0]) least = [own, element.textContent.slice(0, 30)];
      }
      return least;
    })()`);
    assert.ok(contrast >= 4.5, `contrast ${contrast} of ${text}`);
    const unnamed = await page.run(`[...document.querySelectorAll('input, select, button')].filter(control => !(control.ariaLabel || control.labels?.length || control.textContent.trim())).length`);
    assert.equal(unnamed, 0);
    await page.size(shape.width === 390 ? 844 : 700, 500);
    assert.equal(await page.run('document.documentElement.scrollWidth - innerWidth'), 0, 'turned');
    told(`${shape.width} px, ${shape.dark ? 'dark' : 'light'}`, `contrast ${contrast.toFixed(1)} at least`);
    silent(page);
  }
}

/** For the book; with `--whole` the dark ones and whole pages, to be looked at. */
async function pictures(folder) {
  mkdirSync(folder, { recursive: true });
  const save = async (page, name, clip) => writeFileSync(join(folder, `${name}.webp`), await page.picture(clip));
  const [wide, phone] = [{ width: 1280, height: 800 }, { width: 390, height: 844 }];
  const dark = { 'wide-dark': { ...wide, dark: true }, 'phone-dark': { ...phone, dark: true } };
  for (const [name, shape] of Object.entries({ wide, phone, ...(options.includes('--whole') && dark) })) {
    const page = await opened(shape);
    await page.until(`/peak/.test(document.getElementById('s-spectrum').textContent)`);
    await page.run(`document.getElementById('go').click()`);
    await page.until('playground.frames()[0].time > 0.25');
    await page.run(`document.getElementById('pause').click()`);
    await new Promise(done => setTimeout(done, 300));
    await save(page, `playground-${name}`);
    const height = await page.run('document.documentElement.scrollHeight');
    if (options.includes('--whole')) await save(page, `whole-${name}`, { x: 0, y: 0, width: shape.width, height });
  }
  const page = await fit();
  await page.run(`document.getElementById('h-recording').scrollIntoView()`);
  await new Promise(done => setTimeout(done, 500));
  await save(page, 'playground-fit');
  silent(page);
}

let failed = 0;
const steps = { size, speed, numbers, sliders, fit: async () => silent(await fit()), beam, broken, link, shapes };
const chosen = options[0] === '--only' ? [options[1]] : Object.keys(steps);
for (const name of options[0] === '--pictures' ? [] : chosen) {
  try {
    await steps[name]();
  } catch (error) {
    failed++;
    console.error(`${name} FAILED: ${error.stack}`);
  }
}
if (options[0] === '--pictures') await pictures(options[1] ?? 'docs/src/pictures');
await browser.close();
rmSync(scratch, { recursive: true, force: true });
process.exit(failed ? 1 : 0);
