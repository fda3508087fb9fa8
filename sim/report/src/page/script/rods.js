// The rod over time: played, scrubbed, slowed down; rods and measured markers over one another.

/** Speeds that are offered, of real time. */
const SPEEDS = [1, 0.5, 0.25, 0.1];
/** Time of the tip's trail, s. */
const TRAIL = 0.6;

class Rods {
  constructor(root, of) {
    Object.assign(this, { root, of, hidden: new Set(), speed: 1, isPlaying: false, chosen: null });
    this.rods = of.rods.map(rod => {
      const times = column(rod.times);
      return { ...rod, times, frames: rod.nodes.map(node => [column(node[0]), column(node[1])]) };
    });
    this.markers = of.markers.map(marker => ({ ...marker, times: column(marker.times), x: column(marker.x), z: column(marker.z) }));
    const all = [...this.rods, ...this.markers].map(own => own.times);
    [this.first, this.last] = [Math.min(...all.map(times => times[0])), Math.max(...all.map(times => times.at(-1)))];
    this.time = this.first;
    this.build();
    clock(of.clock).all.add(time => this.at(time));
    new ResizeObserver(() => requestAnimationFrame(() => this.draw())).observe(this.canvas);
    globalThis.efam.rods.push(this);
  }

  build() {
    this.canvas = element('canvas', { className: 'rods' });
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', `The rod in motion: ${this.of.title}`);
    this.button = element('button', { type: 'button', textContent: 'Play' });
    this.button.onclick = () => (this.isPlaying ? this.stop() : this.play());
    const step = Math.max(1e-3, (this.last - this.first) / 2000);
    this.slider = element('input', { type: 'range', min: this.first, max: this.last, step, value: this.first });
    this.slider.setAttribute('aria-label', `${this.of.clock}, of the rod and of the charts`);
    this.slider.oninput = () => show(this.of.clock, Number(this.slider.value));
    this.said = element('output', { className: 'said' });
    this.speeds = element('select', {}, ...SPEEDS.map(speed => element('option', { value: speed, textContent: speed === 1 ? 'real time' : `${speed} of it` })));
    this.speeds.onchange = () => { this.speed = Number(this.speeds.value); };
    const speeds = element('label', {}, 'Speed ', this.speeds);
    // Cases of a family are chosen by its sliders.
    const keys = [...this.rods.filter(rod => rod.case === null), ...this.markers, ...(this.of.rest ? [{ name: 'rest', look: { color: '#6e6e6e', width: 1.4, dash: [5, 4] }, shape: 'line', isRest: true }] : [])];
    const buttons = keys.map(own => {
      const button = element('button', { type: 'button' }, sample({ shape: own.shape ?? 'line', look: own.look }), element('span', { textContent: own.name }));
      const name = own.isRest ? 'rest' : own;
      toggles(button, this.hidden, name, () => this.draw());
      return button;
    });
    const controls = element('div', { className: 'controls' }, this.button, this.slider, this.said, speeds);
    this.root.append(element('div', { className: 'keys' }, ...buttons), this.canvas, controls);
    this.root.hidden = false;
  }

  play() {
    if (this.time >= this.last - 1e-9) this.time = this.first;
    this.isPlaying = true;
    this.button.textContent = 'Pause';
    let then = performance.now();
    const frame = now => {
      if (!this.isPlaying) return;
      const time = this.time + Math.max(0, now - then) / 1000 * this.speed;
      then = now;
      show(this.of.clock, Math.min(time, this.last));
      time >= this.last ? this.stop() : requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  stop() {
    this.isPlaying = false;
    this.button.textContent = 'Play';
  }

  at(time) {
    this.time = Math.max(this.first, Math.min(time, this.last));
    this.slider.value = this.time;
    this.draw();
  }

  /** Places of a rod's nodes at the time, mm. */
  posture(rod, time = this.time) {
    const { times, frames } = rod, k = before(times, time), next = Math.min(k + 1, times.length - 1);
    const share = times[next] > times[k] ? Math.max(0, Math.min(1, (time - times[k]) / (times[next] - times[k]))) : 0;
    return frames.map(([x, z]) => [x[k] + share * (x[next] - x[k]), z[k] + share * (z[next] - z[k])]);
  }

  draw() {
    const { canvas, of } = this, width = canvas.clientWidth;
    if (width === 0) return;
    const [x, z] = [of.x, of.z];
    const height = Math.min(width * (z[1] - z[0]) / (x[1] - x[0]), 460);
    canvas.style.height = `${height}px`;
    const scale = Math.min(width / (x[1] - x[0]), height / (z[1] - z[0]));
    const spare = (width - scale * (x[1] - x[0])) / 2;
    const at = this.place = ([a, b]) => [spare + (a - x[0]) * scale, (z[1] - b) * scale];
    const on = cleared(canvas, width, height);
    Object.assign(on, { lineCap: 'round', lineJoin: 'round' });
    const line = (points, { color, width: thick, dash = [], alpha = 1 }) => {
      Object.assign(on, { strokeStyle: color, lineWidth: thick, globalAlpha: alpha });
      on.setLineDash(dash);
      on.beginPath();
      points.forEach((point, k) => on[k ? 'lineTo' : 'moveTo'](...at(point)));
      on.stroke();
      Object.assign(on, { globalAlpha: 1 });
      on.setLineDash([]);
    };
    this.scenery(line);
    if (of.rest && !this.hidden.has('rest')) line(of.rest, { color: '#6e6e6e', width: 1.4, dash: [5, 4] });
    const isOther = rod => this.chosen !== null && rod.case !== null && !this.chosen.has(rod.case);
    for (const rod of this.rods.filter(isOther)) line(this.posture(rod), { ...rod.look, alpha: FAINT });
    for (const rod of this.rods.filter(own => !this.hidden.has(own) && !isOther(own))) {
      const from = this.time - TRAIL, tip = rod.frames.at(-1), trail = [];
      rod.times.forEach((time, k) => { if (time >= from && time <= this.time) trail.push([tip[0][k], tip[1][k]]); });
      const nodes = this.posture(rod);
      trail.push(nodes.at(-1));
      line(trail, { ...rod.look, width: 1, dash: [1.5, 3], alpha: 0.8 });
      line(nodes.slice(0, -1), { ...rod.look, width: 1.6 * rod.look.width });
      line(nodes.slice(-2), { ...rod.look, width: 2.6 * rod.look.width, dash: [] });
    }
    for (const marker of this.markers.filter(own => !this.hidden.has(own))) {
      const { times } = marker, k = before(times, this.time), next = Math.min(k + 1, times.length - 1);
      const near = Math.abs(times[next] - this.time) < Math.abs(times[k] - this.time) ? next : k;
      if (Math.abs(times[near] - this.time) > marker.within) continue;
      Object.assign(on, { strokeStyle: marker.look.color, lineWidth: marker.look.width });
      on.beginPath();
      on.arc(...at([marker.x[near], marker.z[near]]), 5.5, 0, 7);
      on.stroke();
    }
    this.said.textContent = `${this.time.toFixed(3).replace('-', '\u2212')} s`;
  }

  /** Shows these cases of the page's family before all others, or all alike. */
  choose(chosen) {
    this.chosen = chosen;
    this.draw();
  }

  /** The wall that the rod is clamped in, and a bar of 50 mm. */
  scenery(line) {
    const { angle, x, z } = this.of, [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const at = (along, across) => [along * cos - across * sin, along * sin + across * cos];
    const size = 0.06 * (z[1] - z[0]);
    line([at(0, -size), at(0, size)], { color: '#000', width: 3 });
    for (let k = -3; k <= 3; k++) line([at(-0.4 * size, size * (k / 3.6 - 0.2)), at(0, size * (k / 3.6 + 0.05))], { color: '#000', width: 1 });
    const [left, low] = [x[0] + 0.03 * (x[1] - x[0]), z[0] + 0.05 * (z[1] - z[0])];
    line([[left, low], [left + 50, low]], { color: '#000', width: 2 });
    const on = this.canvas.getContext('2d');
    Object.assign(on, { fillStyle: '#000', font: FONT, textAlign: 'left' });
    on.fillText('50 mm', ...this.place([left, low + 0.02 * (z[1] - z[0])]));
  }
}
