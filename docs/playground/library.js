// The catalogue of effects: switches, and for the chosen one its sliders with its page beside them.

import { slider } from './controls.js';
import { fromTable } from './state.js';

const KINDS = {
  elastic: 'Stiffness', dissipative: 'Losses', inertial: 'Mass', load: 'Loads', measurement: 'Camera and markers',
  description: 'Description without a cause',
};
/** What only a recording shows moves no rod. */
const UNSEEN = 'measurement';
const text = (tag, textContent, className = '') => Object.assign(document.createElement(tag), { textContent, className });

export class Library {
  /** `current` gives the setup that is edited, `change` is called after it was changed. */
  constructor(catalogue, current, change) {
    Object.assign(this, { catalogue, current, change, chosen: 'air_drag' });
    this.list = document.getElementById('effects');
    this.article = document.getElementById('effect');
    document.getElementById('find').addEventListener('input', event => this.index(event.target.value));
    this.index('');
  }

  /** The list of names, as far as they hold a word. */
  index(word) {
    const has = effect => [effect.title, effect.name, effect.meaning, effect.signature].join(' ').toLowerCase()
      .includes(word.trim().toLowerCase());
    const rows = [this.entry({ name: '', title: 'The rod itself' }, false)];
    for (const [kind, head] of Object.entries(KINDS)) {
      const effects = this.catalogue.effects.filter(effect => effect.kind === kind && has(effect));
      if (!effects.length) continue;
      rows.push(Object.assign(document.createElement('li'), { className: 'head', textContent: head }));
      rows.push(...effects.map(effect => this.entry(effect, !effect.is_baseline)));
    }
    this.list.replaceChildren(...rows);
    this.show();
  }

  entry({ name, title }, isOptional) {
    const row = document.createElement('li');
    const button = Object.assign(document.createElement('button'), { type: 'button', textContent: title });
    button.dataset.name = name;
    button.addEventListener('click', () => {
      this.chosen = name;
      this.show();
    });
    if (isOptional) {
      const box = Object.assign(document.createElement('input'), { type: 'checkbox', ariaLabel: `${title}: on` });
      box.dataset.name = name;
      box.addEventListener('change', () => this.switch(name, box.checked));
      row.append(box);
    }
    row.append(button);
    return row;
  }

  switch(name, isOn) {
    const { effects } = this.current();
    if (isOn) effects[name] ??= {};
    else delete effects[name];
    this.chosen = name;
    this.show();
    this.change();
  }

  /** Switches and sliders as the setup is. */
  show() {
    const setup = this.current();
    for (const box of this.list.querySelectorAll('input')) box.checked = box.dataset.name in setup.effects;
    for (const button of this.list.querySelectorAll('button')) {
      button.setAttribute('aria-current', button.dataset.name === this.chosen);
    }
    const effect = this.catalogue.effects.find(({ name }) => name === this.chosen);
    this.article.replaceChildren(...(effect ? this.page(effect, setup) : this.rod(setup)));
  }

  page(effect, setup) {
    const parts = [text('h3', effect.title), text('p', `In a recording: ${effect.signature}.`, 'note')];
    if (effect.kind === UNSEEN) parts.push(text('p', 'It changes what is recorded, not how the rod swings.', 'note'));
    const sliders = text('div', '', 'sliders');
    for (const p of effect.parameters) {
      const value = setup.effects[effect.name]?.[p.name] ?? p.default;
      const set = value => {
        const own = this.current().effects;
        (own[effect.name] ??= {})[p.name] = value;
        const box = this.list.querySelector(`input[data-name="${effect.name}"]`);
        if (box) box.checked = true;
        this.change();
      };
      const label = p.meaning[0].toUpperCase() + p.meaning.slice(1);
      sliders.append(slider({ label, unit: p.unit, range: p.range, reach: p.slider, value, set }).box);
    }
    const page = Object.assign(text('pre', effect.page.trimEnd()), { tabIndex: 0, ariaLabel: `Page of ${effect.title}` });
    parts.push(sliders, page);
    return parts;
  }

  rod(setup) {
    const sliders = text('div', '', 'sliders');
    for (const p of this.catalogue.rod) {
      const value = setup.rod[p.name] ?? fromTable(this.catalogue, setup, p.name);
      if (p.name === 'axial_stiffness' && !setup.muscle) continue;
      const set = value => {
        this.current().rod[p.name] = value;
        this.change();
      };
      const label = p.meaning[0].toUpperCase() + p.meaning.slice(1);
      sliders.append(slider({ label, unit: p.unit, range: p.range, reach: p.slider, value, set }).box);
    }
    sliders.append(slider({
      label: 'Angle of the clamp above the horizontal', unit: 'rad', range: [-1.4, 1.4], reach: [-Math.PI / 3, Math.PI / 3],
      step: 1, value: setup.base_angle ?? 0,
      set: value => {
        // It is let go straight, as a clamp that is tilted holds it.
        Object.assign(this.current(), { base_angle: value, angle: value });
        this.change();
      },
    }).box);
    const again = text('button', 'Take the table’s values again');
    again.addEventListener('click', () => {
      this.current().rod = {};
      this.show();
      this.change();
    });
    const note = setup.muscle ? 'The muscle’s table gives these for its pressure. A slider that is moved fixes its value.'
      : 'A plain rod has no table: these are its numbers.';
    return [text('h3', 'The rod itself'), text('p', note, 'note'), sliders, ...(setup.muscle ? [again] : [])];
  }
}
