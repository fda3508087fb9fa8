// Charts of a page: from the JSON in a figure to axes that can be read off, zoomed and thinned out. uPlot has the
// axes and the cursor; the marks are those that the SVG was drawn from. Without this script the SVG is what one sees.

/** Pixels within which a dot or a path is under the cursor; height of the axes; width of a narrow chart. */
const NEAR = 24, LOW = 230, NARROW = 460;
/** Opacity of what belongs to cases that are not chosen. */
const FAINT = 0.14;

/** Numbers that are kept as whole multiples of a unit, each less the one before. */
const column = of => {
  if (of.count !== undefined) return Array.from({ length: of.count }, (_, k) => (of.from + k * of.step) * of.unit);
  let sum = 0;
  return of.steps.map(step => (sum += step) * of.unit);
};
const told = value => (Number.isFinite(value) ? String(Number(value.toPrecision(4))).replace('-', '\u2212') : '\u2013');
const unit = label => (label.includes(', ') ? label.slice(label.lastIndexOf(', ') + 2).replace(/^dimensionless$/, '') : '');
const quantity = label => (label.includes(', ') ? label.slice(0, label.lastIndexOf(', ')) : label);
const element = (name, properties = {}, ...children) => {
  const own = Object.assign(document.createElement(name), properties);
  own.append(...children);
  return own;
};
/** A button that shows and hides what `name` stands for. */
const toggles = (button, hidden, name, redraw) => {
  button.setAttribute('aria-pressed', 'true');
  button.onclick = () => {
    const isHidden = !hidden.has(name);
    isHidden ? hidden.add(name) : hidden.delete(name);
    button.setAttribute('aria-pressed', String(!isHidden));
    redraw();
  };
};
/** An empty canvas as sharp as the screen, to be drawn on in pixels of the page. */
const cleared = (canvas, width, height) => {
  const ratio = devicePixelRatio, size = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== size[0] || canvas.height !== size[1]) [canvas.width, canvas.height] = size;
  const on = canvas.getContext('2d');
  on.setTransform(ratio, 0, 0, ratio, 0, 0);
  on.clearRect(0, 0, width, height);
  return on;
};
/** Last index whose value is not above x. */
const before = (values, x) => {
  let [low, high] = [0, values.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    values[middle] <= x ? (low = middle) : (high = middle - 1);
  }
  return low;
};

/** The time that all with one clock show; a clock is the label of an axis. */
const clocks = new Map();
const clock = name => {
  if (!clocks.has(name)) clocks.set(name, { time: null, all: new Set() });
  return clocks.get(name);
};
const show = (name, time) => {
  const own = clock(name);
  own.time = time;
  own.all.forEach(listener => listener(time));
};
const isTime = label => label.startsWith('time');

/** Marks of a chart with their numbers. */
const read = chart => {
  let x = [];
  return chart.marks.map(mark => {
    if (!mark.look) return mark;
    x = mark.x === 'same' ? x : column(mark.x);
    const isOrdered = x.every((value, k) => k === 0 || value >= x[k - 1]);
    const more = { times: mark.times && column(mark.times), upper: mark.upper && column(mark.upper), cases: mark.cases && column(mark.cases).map(Math.round) };
    return { ...mark, x, y: column(mark.y), isOrdered, ...more };
  });
};

/** The look of a key as a small drawing. */
const sample = key => {
  const { color, width, dash = [], alpha = 1 } = key.look;
  const line = `stroke="${color}" stroke-width="${Math.min(width, 8)}" stroke-opacity="${alpha}" fill="none"`;
  const shapes = {
    line: `<path d="M0 7H28" ${line} stroke-dasharray="${dash.join(' ')}"/>`,
    dot: `<circle cx="14" cy="7" r="4" fill="${color}"/>`,
    ring: `<circle cx="14" cy="7" r="4" ${line}/>`,
    band: `<path d="M0 1H28V13H0Z" fill="${color}" fill-opacity="${alpha}"/>`,
  };
  const svg = new DOMParser().parseFromString(
    `<svg xmlns="http://www.w3.org/2000/svg" width="28" height="14" aria-hidden="true">${shapes[key.shape]}</svg>`,
    'image/svg+xml',
  );
  return document.importNode(svg.documentElement, true);
};

class Chart {
  constructor(of, figure) {
    Object.assign(this, { of, figure, marks: read(of), hidden: new Set(), x: null, chosen: null });
    this.isPlane = of.equal || this.marks.some(mark => mark.kind === 'line' && !mark.isOrdered);
    this.isTimed = isTime(of.x.label) && !this.isPlane;
    this.whole = { x: of.x.range, y: of.y.range };
    this.title = element('strong', { textContent: of.title });
    this.said = element('output', { className: 'said' });
    this.back = element('button', { type: 'button', className: 'back', textContent: 'Whole chart', hidden: true });
    this.back.onclick = () => this.reset();
    this.keys = of.keys.map((key, k) => this.key(key, k));
    this.place = element('div', { className: 'axes', tabIndex: 0 });
    this.place.setAttribute('role', 'group');
    this.place.setAttribute('aria-label', `${of.title}. Left and right: values; plus and minus: zoom; 0: whole chart`);
    this.place.onkeydown = event => this.pressed(event);
    const keys = element('div', { className: 'keys' }, ...this.keys.map(key => key.button));
    const head = element('div', { className: 'head' }, this.title, this.said, this.back);
    this.root = element('div', { className: 'chart' }, head, keys, this.place);
  }

  key(key, k) {
    const value = element('span', { className: 'value' });
    const button = element('button', { type: 'button' }, sample(key), element('span', { textContent: key.name }), value);
    const marks = this.marks.filter(mark => mark.key === k);
    button.disabled = marks.length === 0;
    toggles(button, this.hidden, k, () => {
      this.plot.redraw(false);
      this.point();
    });
    return { button, value, marks, last: '' };
  }

  /** Axes in the room that there is; once the chart is in the page. */
  open() {
    const axis = label => ({ label, font: FONT, labelFont: FONT, labelSize: 20, stroke: '#000', grid: { stroke: '#e1e1e1', width: 1 },
      ticks: { stroke: '#000', width: 1, size: 4 }, values: (_, all) => all.map(value => (value === null ? '' : told(value))) });
    const scale = { time: false, auto: false };
    const own = (min, max) => ({ ...scale, min, max, range: (_, low, high) => [low, high] });
    this.plot = new uPlot({
      ...this.size(),
      padding: [8, 12, 0, 0],
      legend: { show: false },
      scales: { x: own(...this.whole.x), y: own(...this.whole.y) },
      series: [{}, { show: false }],
      axes: [{ ...axis(this.of.x.label), size: 34 }, { ...axis(this.of.y.label), size: 56 }],
      cursor: {
        x: false, y: false, points: { show: false },
        drag: { x: true, y: true, uni: 24, dist: 6, setScale: false },
        bind: { dblclick: () => () => this.reset() },
      },
      hooks: {
        draw: [() => this.draw()],
        setSelect: [plot => this.selected(plot.select)],
        setCursor: [plot => this.moved(plot.cursor)],
      },
    }, [this.whole.x, [null, null]], this.place);
    this.over = this.plot.over.appendChild(element('canvas', { className: 'marked' }));
    this.zoom(this.whole, false);
    if (this.isTimed || this.marks.some(mark => mark.times)) {
      const name = this.isTimed ? this.of.x.label : this.figure.timed ?? 'time, s';
      clock(name).all.add(time => this.timed(time));
      this.clock = name;
    }
    // In the next frame: a size that changes while sizes are told would be told again.
    this.watch = new ResizeObserver(() => requestAnimationFrame(() => {
      const size = this.size();
      if (size.width > 0 && (size.width !== this.plot.width || size.height !== this.plot.height)) {
        this.plot.setSize(size);
        this.zoom(this.now, false);
      }
    }));
    this.watch.observe(this.place);
    globalThis.efam.charts.push(this);
  }

  size() {
    const width = Math.max(240, Math.floor(this.place.clientWidth));
    const axes = width - 68;
    const height = this.of.equal ? axes / this.of.aspect : Math.max(LOW, Math.min(axes / this.of.aspect, 360));
    return { width, height: Math.round((width < NARROW && !this.of.equal ? LOW : height) + 64) };
  }

  reset() {
    this.zoom(this.whole);
  }

  /** Shows these ranges; charts of the figure over the same axis follow along it. */
  zoom({ x, y }, isLeading = true) {
    if (isLeading) for (const other of this.figure.charts) {
      if (other !== this && other.plot && other.of.x.label === this.of.x.label && !this.isPlane && !other.isPlane) other.zoom({ x, y: other.now.y }, false);
    }
    this.now = { x, y };
    const { clientWidth: width, clientHeight: height } = this.plot.over;
    if (this.of.equal && width > 0) {
      const per = Math.max((x[1] - x[0]) / width, (y[1] - y[0]) / height);
      const wide = ([low, high], length) => [(low + high - per * length) / 2, (low + high + per * length) / 2];
      [x, y] = [wide(x, width), wide(y, height)];
    }
    this.plot.batch(() => {
      this.plot.setScale('x', { min: x[0], max: x[1] });
      this.plot.setScale('y', { min: y[0], max: y[1] });
    });
    const same = (a, b) => a[0] === b[0] && a[1] === b[1];
    this.back.hidden = same(this.now.x, this.whole.x) && same(this.now.y, this.whole.y);
    this.point();
  }

  selected({ left, top, width, height }) {
    if (width < 6 && height < 6) return;
    const at = (pixel, axis) => this.plot.posToVal(pixel, axis);
    const { clientWidth, clientHeight } = this.plot.over;
    const x = width >= 6 && width < clientWidth ? [at(left, 'x'), at(left + width, 'x')] : this.now.x;
    const y = height >= 6 && height < clientHeight ? [at(top + height, 'y'), at(top, 'y')] : this.now.y;
    this.plot.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.zoom({ x, y });
  }

  moved({ left, top }) {
    if (left === undefined || left < 0 || !this.now) return;
    this.at = { left, top };
    const x = this.plot.posToVal(left, 'x');
    this.isTimed ? show(this.clock, x) : this.point(x);
  }

  timed(time) {
    if (this.isTimed) this.point(time);
    else {
      this.time = time;
      this.point();
    }
  }

  pressed(event) {
    if (event.target !== this.place) return;
    const [low, high] = this.now.x, step = (high - low) / (event.shiftKey ? 10 : 100);
    const from = this.x ?? (low + high) / 2;
    const to = { ArrowLeft: from - step, ArrowRight: from + step, Home: low, End: high }[event.key];
    const wide = { '+': 0.25, '=': 0.25, '-': 1 }[event.key];
    if (to !== undefined) {
      const x = Math.max(this.whole.x[0], Math.min(to, this.whole.x[1]));
      this.at = null;
      this.isTimed ? show(this.clock, x) : this.point(x);
    } else if (wide !== undefined) {
      const half = wide * (high - low), inside = x => Math.max(this.whole.x[0], Math.min(x, this.whole.x[1]));
      this.zoom({ x: [inside(from - half), inside(from + half)], y: this.now.y });
    } else if (event.key === '0' || event.key === 'Escape') this.reset();
    else return;
    event.preventDefault();
  }

  isShown(mark) {
    return (mark.key === undefined || !this.hidden.has(mark.key)) && (!mark.chosen || this.isChosen(mark));
  }

  /** Whether a mark belongs to a chosen case alone. */
  isChosen(mark) {
    return mark.case !== undefined && this.chosen !== null && this.chosen.has(mark.case);
  }

  /** Shows these cases of the page's family before all others, or all alike; and the values of a single one. */
  choose(chosen) {
    if (!this.marks.some(mark => mark.case !== undefined || mark.cases)) return;
    this.chosen = chosen;
    this.at = null;
    this.plot.redraw(false);
    const [one] = chosen?.size === 1 ? this.ofChosen() : [];
    this.point(one ? one.at.x : this.isTimed ? this.x : null);
  }

  /** Dots and cells of the chosen cases, with their places. */
  ofChosen() {
    if (this.chosen === null) return [];
    return this.marks.filter(mark => this.isShown(mark)).flatMap(mark => {
      const middle = ([low, high]) => (low + high) / 2;
      if (mark.kind === 'cell') return this.isChosen(mark) ? [{ mark, at: { x: middle(mark.x), y: middle(mark.y) } }] : [];
      const places = (mark.cases ?? []).flatMap((own, k) => (this.chosen.has(own) ? [k] : []));
      return places.map(k => ({ key: mark.key, mark, at: { x: mark.x[k], y: mark.y[k] } }));
    });
  }

  /** Height of a mark at x, or nothing. */
  value(mark, x) {
    const { x: all, y } = mark, last = all.length - 1;
    if (last < 0 || !mark.isOrdered || all[0] === all[last]) return null;
    const k = before(all, x);
    if (mark.kind === 'line' || mark.kind === 'band') {
      if (x < all[0] || x > all[last]) return null;
      const next = Math.min(k + 1, last), share = all[next] > all[k] ? (x - all[k]) / (all[next] - all[k]) : 0;
      const between = of => of[k] + share * (of[next] - of[k]);
      return mark.upper ? { x, y: between(y), upper: between(mark.upper) } : { x, y: between(y) };
    }
    const near = k < last && all[k + 1] - x < x - all[k] ? k + 1 : k;
    const isNear = Math.abs(this.plot.valToPos(all[near], 'x') - this.plot.valToPos(x, 'x')) < NEAR;
    return isNear ? { x: all[near], y: y[near] } : null;
  }

  /** Values at x, in the keys and as dots; of a plane, those of the point under the cursor. */
  point(x = this.x) {
    if (!this.plot || !this.now) return;
    this.x = x;
    const found = this.isPlane ? this.nearest() : this.atX(x);
    this.say(found, x);
    this.mark(found, x);
  }

  atX(x) {
    if (x === null) return [];
    // Where the cursor is not, the values are those of the chosen case.
    const all = this.at ? [] : this.ofChosen().filter(own => own.at.x === x);
    if (all.length) return all;
    this.keys.forEach((key, k) => {
      if (this.hidden.has(k)) return;
      // A dot says more than the line through it.
      const values = key.marks.filter(mark => this.isShown(mark)).map(mark => ({ mark, at: this.value(mark, x) })).filter(own => own.at);
      const best = values.find(own => own.mark.kind !== 'line') ?? values[0];
      if (best) all.push({ key: k, ...best });
    });
    const isNameless = mark => mark.look && mark.key === undefined && (this.keys.length === 0 || this.isChosen(mark));
    if (this.marks.some(isNameless)) {
      const values = this.marks.filter(isNameless).map(mark => ({ mark, at: this.value(mark, x) }));
      all.push(...values.filter(own => own.at).slice(0, 1));
    }
    const cell = this.at && this.cell();
    return cell ? [cell] : all;
  }

  cell() {
    const [x, y] = [this.plot.posToVal(this.at.left, 'x'), this.plot.posToVal(this.at.top, 'y')];
    const mark = this.marks.find(({ kind, x: [a, b], y: [c, d] }) => kind === 'cell' && a <= x && x <= b && c <= y && y <= d);
    return mark && { mark, at: { x, y } };
  }

  nearest() {
    if (!this.at) return [];
    let best = null, least = NEAR;
    for (const mark of this.marks.filter(own => own.look && this.isShown(own))) {
      mark.x.forEach((x, k) => {
        const distance = Math.hypot(this.plot.valToPos(x, 'x') - this.at.left, this.plot.valToPos(mark.y[k], 'y') - this.at.top);
        if (distance < least) [best, least] = [{ key: mark.key, mark, at: { x, y: mark.y[k], time: mark.times?.[k] } }, distance];
      });
    }
    return best ? [best] : [];
  }

  say(found, x) {
    const { x: ofX, y: ofY } = this.of;
    const [first] = found;
    let text = '';
    if (first?.mark.kind === 'cell') text = told(first.mark.value);
    else if (this.isPlane && first) {
      text = `${quantity(ofX.label)} ${told(first.at.x)} ${unit(ofX.label)}, ${quantity(ofY.label)} ${told(first.at.y)} ${unit(ofY.label)}`;
      if (first.at.time !== undefined) text += ` at ${told(first.at.time)} s`;
    } else if (!this.isPlane && x !== null) {
      text = `${quantity(ofX.label)} ${told(x)} ${unit(ofX.label)}`;
      const nameless = found.find(own => own.key === undefined);
      if (nameless) text += `: ${told(nameless.at.y)} ${unit(ofY.label)}`;
    }
    if (this.said.textContent !== text) this.said.textContent = text;
    this.keys.forEach((key, k) => {
      const own = this.isPlane ? null : found.find(one => one.key === k);
      const value = !own ? '' : own.at.upper === undefined ? told(own.at.y) : `${told(own.at.y)} to ${told(own.at.upper)}`;
      if (key.last !== value) key.value.textContent = key.last = value;
    });
  }

  /** The line of the cursor, dots on what is read off, and where a path is at the time of the page. */
  mark(found, x) {
    const { over, plot } = this;
    const { clientWidth: width, clientHeight: height } = plot.over;
    const on = cleared(over, width, height);
    const dot = (x, y, color, size = 4.5) => {
      const [left, top] = [plot.valToPos(x, 'x'), plot.valToPos(y, 'y')];
      if (!(left >= -1 && left <= width + 1 && top >= -1 && top <= height + 1)) return;
      on.beginPath();
      on.arc(left, top, size, 0, 7);
      Object.assign(on, { fillStyle: color, strokeStyle: '#fff', lineWidth: 2 });
      on.fill();
      on.stroke();
    };
    if (!this.isPlane && x !== null && found[0]?.mark.kind !== 'cell') {
      const left = Math.round(plot.valToPos(x, 'x')) + 0.5;
      Object.assign(on, { strokeStyle: '#555', lineWidth: 1 });
      on.setLineDash([4, 3]);
      on.beginPath();
      on.moveTo(left, 0);
      on.lineTo(left, height);
      if (left >= 0 && left <= width) on.stroke();
      on.setLineDash([]);
    }
    for (const { mark, at } of found) if (mark.look && at.upper === undefined) dot(at.x, at.y, mark.look.color);
    Object.assign(on, { strokeStyle: '#000', lineWidth: 2 });
    for (const { mark, at } of this.ofChosen()) {
      on.beginPath();
      if (mark.kind === 'cell') on.rect(...box(mark, x => plot.valToPos(x, 'x'), y => plot.valToPos(y, 'y')));
      else on.arc(plot.valToPos(at.x, 'x'), plot.valToPos(at.y, 'y'), 7, 0, 7);
      on.stroke();
    }
    if (this.time === undefined) return;
    for (const mark of this.marks.filter(own => own.times && this.isShown(own))) {
      const k = before(mark.times, this.time);
      dot(mark.x[k], mark.y[k], '#000', 5);
    }
  }

  draw() {
    const { ctx, bbox, scales } = this.plot, ratio = uPlot.pxRatio;
    const X = x => bbox.left + (x - scales.x.min) / (scales.x.max - scales.x.min) * bbox.width;
    const Y = y => bbox.top + (scales.y.max - y) / (scales.y.max - scales.y.min) * bbox.height;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    ctx.lineJoin = 'round';
    // What is chosen comes last, above all others.
    const isOther = mark => this.chosen !== null && mark.case !== undefined && mark.kind !== 'cell' && !this.isChosen(mark);
    const marks = this.marks.filter(mark => this.isShown(mark));
    const isAbove = mark => mark.kind !== 'cell' && this.isChosen(mark);
    let room = Infinity;
    for (const mark of [...marks.filter(mark => !isAbove(mark)), ...marks.filter(isAbove)]) {
      if (mark.kind === 'cell') room = X(mark.x[1]) - X(mark.x[0]);
      ctx.save();
      if (mark.look) {
        const { color, width, dash = [], alpha = 1 } = mark.look;
        Object.assign(ctx, { strokeStyle: color, fillStyle: color, lineWidth: width * (this.isChosen(mark) ? 1.5 : 1) * ratio, globalAlpha: isOther(mark) ? FAINT : alpha });
        ctx.setLineDash(dash.map(length => length * ratio));
      }
      DRAW[mark.kind](ctx, mark, X, Y, ratio, room, [bbox.left, bbox.left + bbox.width]);
      ctx.restore();
    }
    ctx.restore();
  }
}
