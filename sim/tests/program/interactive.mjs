// Uses the pages of a folder as a person would, with a mouse and a keyboard and under their own policy: reads values
// off, zooms, hides, plays. Says what is broken.

import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

import { start } from '../../../docs/playground/browser.mjs';

const [program, folder] = process.argv.slice(2);
const browser = await start(program);
const wait = () => new Promise(done => setTimeout(done, 80));

async function opened(name, shape = { width: 1280, height: 900 }) {
  const page = await browser.page(shape);
  await page.go(pathToFileURL(resolve(folder, name, 'report.html')).href);
  await page.until('globalThis.efam?.charts.length > 0 && document.readyState === "complete"');
  return page;
}

/** A place in the axes of a chart, as shares of their width and height. */
const at = (page, chart, x, y = 0.5) => page.run(`(() => {
  const over = efam.charts[${chart}].plot.over;
  over.scrollIntoView({ block: 'center' });
  const { left, top, width, height } = over.getBoundingClientRect();
  return [left + ${x} * width, top + ${y} * height];
})()`);
const of = (page, title) => page.run(`efam.charts.findIndex(chart => chart.of.title.startsWith(${JSON.stringify(title)}))`);
const range = (page, chart) => page.run(`['x', 'y'].map(axis => [efam.charts[${chart}].plot.scales[axis].min, efam.charts[${chart}].plot.scales[axis].max])`);

/** Nothing but both scripts ran, nothing was asked for, and no other script can run. */
async function kept({ run, complaints, requests }) {
  assert.deepEqual(complaints, []);
  assert.deepEqual(requests.filter(request => !request.startsWith('file:')), []);
  assert.equal(await run(`document.querySelectorAll('img, iframe, object, embed, form').length`), 0);
  assert.equal(await run(`[...document.scripts].filter(script => !script.type).length`), 2);
  const refused = await run(`new Promise(done => {
    addEventListener('securitypolicyviolation', event => done(event.effectiveDirective), { once: true });
    document.body.append(Object.assign(document.createElement('script'), { textContent: 'globalThis.stranger = 1' }));
    setTimeout(() => done('nothing'), 500);
  })`);
  assert.match(refused, /^script-src/);
  assert.equal(await run('globalThis.stranger'), undefined);
}

async function readOff() {
  const page = await opened('run');
  const chart = await of(page, 'The tip');
  await page.mouse(await at(page, chart, 0.3));
  await wait();
  const { said, value, ends } = await page.run(`(() => {
    const chart = efam.charts[${chart}], line = chart.marks.find(mark => mark.kind === 'line' && mark.key === 0);
    const next = line.x.findIndex(x => x > chart.x), ends = [line.y[next - 1], line.y[next]];
    return { said: chart.said.textContent, value: Number(chart.keys[0].value.textContent.replace('\\u2212', '-')), ends };
  })()`);
  assert.match(said, /^time [\d.]+ s$/);
  // Printed to 0.1 mm.
  assert.ok(value > Math.min(...ends) - 0.1 && value < Math.max(...ends) + 0.1, `${value} is read off between samples of ${ends}`);
  // The same instant in the energies and of the rod.
  const times = await page.run(`[efam.charts[${chart}].x, efam.charts.find(chart => chart.of.y.label === 'energy, mJ').x, efam.rods[0].time]`);
  assert.ok(times.every(time => Math.abs(time - times[0]) < 1e-9), times.join());
}

async function zoomed() {
  const page = await opened('run');
  const chart = await of(page, 'The tip');
  const whole = await range(page, chart);
  await page.mouse(await at(page, chart, 0.2), await at(page, chart, 0.3), await at(page, chart, 0.4));
  await wait();
  const [[low, high]] = await range(page, chart);
  const share = x => whole[0][0] + x * (whole[0][1] - whole[0][0]);
  assert.ok(Math.abs(low - share(0.2)) < share(0.01) && Math.abs(high - share(0.4)) < share(0.01), `${low} to ${high}`);
  await page.twice(await at(page, chart, 0.6));
  await wait();
  assert.deepEqual(await range(page, chart), whole);
  // By keyboard, too.
  await page.run(`efam.charts[${chart}].place.focus()`);
  await page.key('ArrowRight', 'ArrowRight', 39);
  await page.key('+', 'Equal', 187);
  assert.notDeepEqual(await range(page, chart), whole);
  await page.key('0', 'Digit0', 48);
  assert.deepEqual(await range(page, chart), whole);
}

async function hidden() {
  const page = await opened('run');
  const chart = await of(page, 'The tip');
  const ink = () => page.run(`(() => {
    const { ctx } = efam.charts[${chart}].plot, { width, height } = ctx.canvas;
    const all = ctx.getImageData(0, 0, width, height).data;
    let count = 0;
    for (let k = 0; k < all.length; k += 4) if (all[k] < 60 && all[k + 2] > 120) count++;
    return count;
  })()`);
  const before = await ink();
  await page.run(`efam.charts[${chart}].keys[0].button.click()`);
  await wait();
  assert.ok(before > 500 && await ink() < 0.2 * before, `${before} blue pixels, then ${await ink()}`);
  assert.equal(await page.run(`efam.charts[${chart}].keys[0].button.getAttribute('aria-pressed')`), 'false');
  await kept(page);
}

async function played(name, count) {
  const page = await opened(name);
  assert.equal(await page.run('efam.rods.reduce((sum, own) => sum + own.rods.length, 0)'), count);
  const tip = () => page.run('efam.rods[0].posture(efam.rods[0].rods[0]).at(-1)');
  const before = await tip();
  await page.run(`efam.rods[0].button.click()`);
  await page.until('efam.rods[0].time > efam.rods[0].first + 0.15');
  await page.run(`efam.rods[0].button.click()`);
  const [then, time] = [await tip(), await page.run('efam.rods[0].time')];
  assert.ok(Math.hypot(then[0] - before[0], then[1] - before[1]) > 5, `the tip moved from ${before} to ${then}`);
  await wait();
  assert.equal(await page.run('efam.rods[0].time'), time, 'it stands still');
  const slow = await page.run(`(() => { const own = efam.rods[0]; own.speeds.value = '0.1'; own.speeds.onchange(); return own.speed; })()`);
  assert.equal(slow, 0.1);
  await kept(page);
}

/** The residual before and after are shown at one place, one or the other. */
async function chosen() {
  const page = await opened('diagnosis');
  const shown = () => page.run(`(() => {
    const figure = document.querySelector('figure[data-choice]');
    return [...figure.querySelectorAll('.chart')].map(chart => chart.offsetHeight > 0);
  })()`);
  assert.deepEqual(await shown(), [true, true]);
  await page.run(`document.querySelector('figure[data-choice] .choice button').click()`);
  assert.deepEqual(await shown(), [true, false]);
  await kept(page);
}

/** Pixels of a canvas of which a colour is true. */
const inked = (page, canvas, isInk) => page.run(`(() => {
  const canvas = ${canvas}, isInk = ${isInk};
  const all = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height).data;
  let count = 0;
  for (let k = 0; k < all.length; k += 4) if (isInk(all.slice(k, k + 4))) count++;
  return count;
})()`);

/** By keyboard, the sliders of a sweep choose a point: its numbers are those of its row, and its rod stands out. */
async function slid() {
  const page = await opened('sweep');
  const solid = () => inked(page, 'efam.rods[0].canvas', '([r, g, b, a]) => a > 250 && b > 150 && r < 60');
  await page.run(`(() => { const own = efam.rods[0].slider; own.value = 0.3; own.oninput(); })()`);
  const before = await solid();
  for (const [axis, count] of [[0, 1], [1, 3]]) {
    await page.run(`efam.family.axes[${axis}].slider.focus()`);
    for (let k = 0; k < count; k++) await page.key('ArrowRight', 'ArrowRight', 39);
  }
  await wait();
  assert.deepEqual(await page.run('efam.family.axes.map(axis => axis.said.textContent)'), ['103.4 kPa', '80 g']);
  assert.equal(await page.run(`efam.family.axes[1].slider.getAttribute('aria-valuetext')`), '80 g');
  const [heads, ...rows] = readFileSync(resolve(folder, 'sweep', 'sweep.csv'), 'utf8').trim().split('\n').map(line => line.split(','));
  const of = name => heads.findIndex(head => head.startsWith(name));
  const row = rows.find(row => Math.abs(row[of('muscle_pressure')] - 103421) < 1 && Math.abs(row[of('effects_payload_mass')] - 0.08) < 1e-9);
  const said = await page.run(`efam.charts.filter(chart => chart.of.title === 'Frequency as released').map(chart => chart.said.textContent)`);
  assert.equal(said.length, 2, said.join(' | '));
  for (const text of said) {
    const value = Number(text.match(/([\d.]+) Hz$/)[1]);
    assert.ok(Math.abs(value / row[of('frequency_hz')] - 1) < 1e-3, `${text} where the row has ${row[of('frequency_hz')]} Hz`);
  }
  const after = await solid();
  assert.ok(before > 500 && after > 50 && after < 0.6 * before, `${before} pixels of all rods, ${after} of the chosen one`);
  await page.run(`efam.family.all.click()`);
  await wait();
  assert.equal(await solid(), before, 'all are as they were');
  await page.media('print');
  assert.equal(await page.run('efam.family.root.offsetHeight'), 0);
  await kept(page);
}

/** A run of a set that no picture shows is drawn once it is chosen. */
async function called() {
  const page = await opened('rows');
  const chart = await of(page, 'Height of the tip');
  const ink = () => inked(page, `efam.charts[${chart}].plot.ctx.canvas`, '([r, g, b, a]) => a > 200 && r > 110 && r < 160 && g < 60 && b < 110');
  const before = await ink();
  await page.run(`(() => { const own = efam.family.axes[0].slider; own.value = 3; own.oninput(); })()`);
  await wait();
  assert.equal(await page.run('efam.family.axes[0].said.textContent'), '20 psi');
  const after = await ink();
  assert.ok(after > 300 && before < 0.1 * after, `${before} pixels of its colour, then ${after}`);
  assert.deepEqual(await page.run(`efam.charts[${chart}].marks.filter(mark => efam.charts[${chart}].isChosen(mark)).map(mark => mark.case)`), [3]);
  await kept(page);
}

/** In print, and without scripts, one sees pictures. */
async function printed() {
  const page = await opened('run');
  await page.media('print');
  assert.ok(await page.run(`[...document.querySelectorAll('figure .scroll')].every(own => own.offsetHeight > 100)`));
  assert.equal(await page.run(`[...document.querySelectorAll('.live, .motion')].filter(own => own.offsetHeight > 0).length`), 0);
}

const all = { readOff, zoomed, hidden, played: () => played('run', 1), 'with markers': () => played('calibration', 1),
  'before and after': () => played('diagnosis', 2), chosen, slid, called, printed };
let broken = 0;
for (const [name, check] of Object.entries(all)) {
  try {
    await check();
    console.log(`${name}: well`);
  } catch (error) {
    broken++;
    console.error(`${name}: ${error.stack}`);
  }
}
await browser.close();
process.exit(broken ? 1 : 0);
