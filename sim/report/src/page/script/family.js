// Sliders that choose among the cases of a page; what is chosen stands out in each chart and among the rods.

class Family {
  constructor(root, of) {
    this.root = root;
    this.axes = of.axes.map(axis => ({ ...axis, places: column(axis.places).map(Math.round) }));
    for (const axis of this.axes) {
      // Left of the least value there is none: all of them.
      axis.slider = element('input', { type: 'range', min: -1, max: axis.values.length - 1, step: 1, value: -1 });
      axis.slider.oninput = () => this.moved(axis);
      axis.said = element('output', {});
      root.append(element('label', {}, element('span', { textContent: axis.name }), axis.slider, axis.said));
    }
    this.all = element('button', { type: 'button', textContent: 'All cases' });
    this.all.onclick = () => {
      this.axes.forEach(axis => { axis.slider.value = -1; });
      this.choose();
    };
    root.append(this.all);
    root.hidden = false;
    this.choose();
    globalThis.efam.family = this;
  }

  /** Cases at the sliders' values. */
  cases() {
    const places = this.axes.map(axis => Number(axis.slider.value));
    const isThere = k => this.axes.every((axis, a) => places[a] < 0 || axis.places[k] === places[a]);
    return this.axes[0].places.flatMap((_, k) => (isThere(k) ? [k] : []));
  }

  /** Where no case has all values, that of the moved slider counts alone. */
  moved(axis) {
    if (this.cases().length === 0) this.axes.filter(other => other !== axis).forEach(other => { other.slider.value = -1; });
    this.choose();
  }

  choose() {
    const isFree = this.axes.every(axis => Number(axis.slider.value) < 0);
    const cases = isFree ? null : this.cases();
    for (const axis of this.axes) {
      const place = Number(axis.slider.value);
      const own = place >= 0 ? axis.values[place] : cases?.length === 1 ? axis.values[axis.places[cases[0]]] : 'all';
      axis.said.textContent = own;
      axis.slider.setAttribute('aria-valuetext', own);
    }
    this.all.setAttribute('aria-pressed', String(isFree));
    const chosen = cases && new Set(cases);
    [...globalThis.efam.charts, ...globalThis.efam.rods].forEach(own => own.choose(chosen));
  }
}

globalThis.efam = { charts: [], rods: [], clocks };
document.querySelectorAll('figure > script.charts').forEach(data => figure(data.parentElement, data));
document.querySelectorAll('figure > script.rods').forEach(data => new Rods(data.parentElement, JSON.parse(data.textContent)));
document.querySelectorAll('.family > script.family').forEach(data => new Family(data.parentElement, JSON.parse(data.textContent)));
