// Charts on a canvas: axes, lines, moving marks, and values under the pointer.

const MARGIN = { left: 46, right: 12, top: 10, bottom: 34 };

/** Colours as the style gives them, light or dark. */
export function palette() {
  const style = getComputedStyle(document.documentElement);
  const of = name => style.getPropertyValue(`--${name}`).trim();
  return { ink: of('ink'), muted: of('muted'), line: of('line'), paper: of('card'), series: [of('one'), of('two'), of('three'), of('four')] };
}

/** A canvas as sharp as the screen. */
export function sharp(canvas) {
  const ratio = devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const pen = canvas.getContext('2d');
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

function ticks(low, high, most) {
  const raw = (high - low) / most, unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map(k => k * unit).find(step => step >= raw * 0.999);
  const all = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) all.push(k * step);
  const after = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  return all.map(at => ({ at, text: at.toFixed(after).replace('-', '−') }));
}

export class Chart {
  /** `x` and `y` are labels with units. */
  constructor(canvas, { x, y }) {
    Object.assign(this, { canvas, labels: { x, y }, lines: [], marks: [], pointer: null });
    canvas.addEventListener('pointermove', event => { this.pointer = event.offsetX; this.draw(); });
    canvas.addEventListener('pointerleave', () => { this.pointer = null; this.draw(); });
    new ResizeObserver(() => this.draw()).observe(canvas);
  }

  /** Lines are `{ x, y, colour, dash, thin, dots, name }`; limits hold them all unless given. */
  show(lines, limits = {}) {
    this.lines = lines.filter(line => line.x.length);
    const extent = (key, given) => {
      let [low, high] = [Infinity, -Infinity];
      for (const line of this.lines) for (const value of line[key]) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
      if (!(high > low)) [low, high] = Number.isFinite(low) ? [low - 1, low + 1] : [0, 1];
      const air = key === 'y' ? 0.06 * (high - low) : 0;
      return given ?? [low - air, high + air];
    };
    this.limits = { x: extent('x', limits.x), y: extent('y', limits.y) };
    this.draw();
  }

  /** Marks are points that move: `{ x, y, colour }`, in one colour joined to a trail if they have lists. */
  mark(marks) {
    this.marks = marks;
    this.draw();
  }

  draw() {
    if (!this.limits || !this.canvas.clientWidth) return;
    const { pen, width, height } = sharp(this.canvas);
    const colours = palette();
    const { x: [x0, x1], y: [y0, y1] } = this.limits;
    const [w, h] = [width - MARGIN.left - MARGIN.right, height - MARGIN.top - MARGIN.bottom];
    const X = x => MARGIN.left + ((x - x0) / (x1 - x0)) * w;
    const Y = y => MARGIN.top + (1 - (y - y0) / (y1 - y0)) * h;
    pen.font = '12px system-ui, sans-serif';
    pen.lineWidth = 1;
    pen.strokeStyle = colours.line;
    pen.fillStyle = colours.muted;
    pen.textAlign = 'center';
    pen.textBaseline = 'top';
    for (const { at, text } of ticks(x0, x1, Math.max(2, w / 75))) {
      pen.beginPath();
      pen.moveTo(X(at), MARGIN.top);
      pen.lineTo(X(at), MARGIN.top + h);
      pen.stroke();
      pen.fillText(text, X(at), MARGIN.top + h + 4);
    }
    pen.textAlign = 'right';
    pen.fillText(this.labels.x, width - MARGIN.right, height - 14);
    pen.textBaseline = 'middle';
    for (const { at, text } of ticks(y0, y1, Math.max(2, h / 38))) {
      pen.beginPath();
      pen.moveTo(MARGIN.left, Y(at));
      pen.lineTo(width - MARGIN.right, Y(at));
      pen.stroke();
      pen.fillText(text, MARGIN.left - 6, Y(at));
    }
    pen.save();
    pen.beginPath();
    pen.rect(MARGIN.left, MARGIN.top, w, h);
    pen.clip();
    for (const line of this.lines) this.stroke(pen, line, X, Y);
    for (const { x, y, colour } of this.marks) {
      if (Array.isArray(x)) {
        if (x.length) this.stroke(pen, { x, y, colour }, X, Y);
        continue;
      }
      pen.beginPath();
      pen.arc(X(x), Y(y), 5, 0, 7);
      pen.fillStyle = colour;
      pen.fill();
      pen.strokeStyle = colours.paper;
      pen.lineWidth = 1.5;
      pen.stroke();
    }
    pen.restore();
    if (this.pointer !== null && this.pointer > MARGIN.left) this.read(pen, colours, X, Y, { width, h, x0, x1, w });
  }

  stroke(pen, { x, y, colour, dash, thin, dots }, X, Y) {
    pen.strokeStyle = pen.fillStyle = colour;
    if (dots) {
      for (let k = 0; k < x.length; k++) pen.fillRect(X(x[k]) - 1.25, Y(y[k]) - 1.25, 2.5, 2.5);
      return;
    }
    pen.lineWidth = thin ? 1.2 : 2;
    pen.setLineDash(dash ?? []);
    pen.beginPath();
    for (let k = 0; k < x.length; k++) pen.lineTo(X(x[k]), Y(y[k]));
    pen.stroke();
    pen.setLineDash([]);
  }

  /** The value of each named line at the pointer. */
  read(pen, colours, X, Y, { width, h, x0, x1, w }) {
    const at = x0 + ((this.pointer - MARGIN.left) / w) * (x1 - x0);
    pen.strokeStyle = colours.muted;
    pen.lineWidth = 1;
    pen.beginPath();
    pen.moveTo(this.pointer, MARGIN.top);
    pen.lineTo(this.pointer, MARGIN.top + h);
    pen.stroke();
    const texts = [`${at.toFixed(2)} ${this.labels.x.match(/\/ (.*)/)?.[1] ?? ''}`];
    for (const { x, y, name } of this.lines.filter(line => line.name)) {
      const next = x.findIndex(value => value >= at);
      if (next > 0) {
        const share = (at - x[next - 1]) / (x[next] - x[next - 1]);
        texts.push(`${name} ${(y[next - 1] + share * (y[next] - y[next - 1])).toFixed(1).replace('-', '−')}`);
      }
    }
    const wide = Math.max(...texts.map(text => pen.measureText(text).width)) + 12;
    const left = this.pointer + wide + 12 > width ? this.pointer - wide - 6 : this.pointer + 6;
    pen.fillStyle = colours.paper;
    pen.fillRect(left, MARGIN.top + 2, wide, 17 * texts.length + 4);
    pen.strokeRect(left, MARGIN.top + 2, wide, 17 * texts.length + 4);
    pen.fillStyle = colours.ink;
    pen.textAlign = 'left';
    pen.textBaseline = 'top';
    texts.forEach((text, k) => pen.fillText(text, left + 6, MARGIN.top + 6 + 17 * k));
  }
}
