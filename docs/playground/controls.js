// A slider with a number beside it: the slider offers usual values, the number takes all admissible ones.

import { shown } from './units.js';

let count = 0;

/** Makes a control; `set` gets SI values. The control's `show` sets it without a call. */
export function slider({ label, unit, range, reach, value, set, step, display, hint }) {
  const { factor, symbol } = display ?? shown(unit, Math.max(Math.abs(reach[0]), Math.abs(reach[1])));
  const id = `c${++count}`;
  const box = document.createElement('div');
  box.className = 'slider';
  const name = Object.assign(document.createElement('label'), { textContent: label, htmlFor: id, title: hint ?? '' });
  const [low, high] = reach.map(value => value / factor);
  const fine = step ?? 10 ** Math.floor(Math.log10((high - low) / 100));
  const track = Object.assign(document.createElement('input'), { type: 'range', id, min: low, max: high, step: fine });
  const number = Object.assign(document.createElement('input'), {
    type: 'number', min: range[0] / factor, max: range[1] / factor, step: 'any', ariaLabel: `${label}, ${symbol || 'number'}`,
  });
  const beside = document.createElement('span');
  beside.className = 'value';
  beside.append(number, Object.assign(document.createElement('span'), { className: 'unit', textContent: symbol }));
  box.append(name, beside, track);
  const show = value => {
    track.value = value / factor;
    number.value = Number((value / factor).toPrecision(6));
    track.ariaValueText = `${number.value} ${symbol}`;
  };
  track.addEventListener('input', () => {
    // The step's own decimals: 0.1 + 0.2 is 0.3 here.
    const chosen = Number(Number(track.value).toPrecision(12));
    number.value = chosen;
    track.ariaValueText = `${chosen} ${symbol}`;
    set(chosen * factor);
  });
  number.addEventListener('change', () => {
    const chosen = Number(number.value);
    if (number.value === '' || !number.validity.valid) return show(box.last);
    track.value = chosen;
    set(chosen * factor);
  });
  show(value);
  return { box, show: value => { box.last = value; show(value); } };
}
