// The stage: clamp, rod, end fitting, the trail of the tip, and where the rod would hang.

import { palette, sharp } from './chart.js';

/** Room around a rod, as shares of its length: behind the clamp, ahead, above what was reached, below. */
const ROOM = { behind: 0.16, ahead: 1.12, above: 0.24, below: 1.12 };
const TRAIL = 150;

export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.reach = this.above = 0;
    this.rods = [];
    this.measured = null;
  }

  /** Begins the trails anew. */
  clear(rod) {
    if (this.rods[rod]) this.rods[rod].trail = [];
  }

  /** Takes a frame of each rod; `rests` are nodes where they would hang. */
  show(frames, rests, diameters, names) {
    this.rods = frames.map((frame, k) => {
      const trail = this.rods[k]?.trail ?? [];
      if (trail.at(-1)?.[0] !== frame.tip[0] || trail.at(-1)?.[1] !== frame.tip[1]) trail.push(frame.tip);
      if (trail.length > TRAIL) trail.shift();
      return { frame, trail, rest: rests[k], diameter: diameters[k], name: names[k] };
    });
    this.draw();
  }

  draw() {
    const { pen, width, height } = sharp(this.canvas);
    if (!width || !this.rods.length) return;
    const colours = palette();
    const reaches = this.rods.map(({ frame }) => along(frame.nodes) + Math.hypot(
      frame.tip[0] - frame.nodes.at(-1)[0], frame.tip[1] - frame.nodes.at(-1)[1]));
    const due = Math.max(...reaches);
    // The scale follows a rod that lengthens without a jump.
    this.reach = this.reach ? this.reach + 0.1 * (due - this.reach) : due;
    const highest = Math.max(0, ...this.rods.flatMap(({ trail }) => trail.map(([, z]) => z))) / this.reach + ROOM.above;
    this.above = this.above ? this.above + 0.1 * (highest - this.above) : highest;
    const count = this.rods.length;
    const part = width / count;
    const scale = Math.min(part / (ROOM.behind + ROOM.ahead), height / (this.above + ROOM.below)) / this.reach;
    const top = Math.max(0, (height - scale * this.reach * (this.above + ROOM.below)) / 2);
    this.rods.forEach((rod, k) => {
      const left = k * part + Math.max(0, (part - scale * this.reach * (ROOM.behind + ROOM.ahead)) / 2);
      const at = ([x, z]) => [left + scale * (x + ROOM.behind * this.reach), top + scale * (this.above * this.reach - z)];
      this.rod(pen, rod, at, scale, colours, colours.series[k], count > 1);
    });
    this.ruler(pen, scale, height, colours);
  }

  rod(pen, { frame, trail, rest, diameter, name }, at, scale, colours, colour, isNamed) {
    const wide = Math.max(5, scale * (diameter || 0.02));
    const [ox, oy] = at([0, 0]);
    // The level.
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    pen.setLineDash([2, 5]);
    path(pen, [[ox, oy], at([this.reach * ROOM.ahead, 0])]);
    pen.stroke();
    if (rest) {
      pen.strokeStyle = colours.muted;
      pen.setLineDash([5, 5]);
      path(pen, rest.map(at));
      pen.stroke();
    }
    pen.setLineDash([]);
    pen.strokeStyle = colour;
    pen.lineWidth = 2;
    for (let k = 1; k < trail.length; k++) {
      pen.globalAlpha = 0.55 * (k / trail.length);
      path(pen, [at(trail[k - 1]), at(trail[k])]);
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.lineCap = pen.lineJoin = 'round';
    const body = frame.nodes.map(at);
    pen.lineWidth = wide;
    path(pen, body);
    pen.stroke();
    // The braid: fine strokes across, so that stretch and bending are seen.
    pen.strokeStyle = colours.paper;
    pen.globalAlpha = 0.35;
    pen.lineWidth = 1;
    for (let k = 1; k < body.length; k++) {
      const [[ax, ay], [bx, by]] = [body[k - 1], body[k]];
      const length = Math.hypot(bx - ax, by - ay) || 1;
      const [nx, ny] = [(-(by - ay) / length) * wide * 0.42, ((bx - ax) / length) * wide * 0.42];
      path(pen, [[bx + nx, by + ny], [bx - nx, by - ny]]);
      pen.stroke();
    }
    pen.globalAlpha = 1;
    pen.lineCap = 'butt';
    // The clamp covers the rod's round end.
    pen.fillStyle = colours.muted;
    pen.fillRect(ox - 0.9 * wide, oy - 1.1 * wide, 0.9 * wide, 2.2 * wide);
    const [end, tip] = [body.at(-1), at(frame.tip)];
    const beyond = [end[0] + 1.9 * (tip[0] - end[0]), end[1] + 1.9 * (tip[1] - end[1])];
    pen.strokeStyle = colours.ink;
    pen.lineWidth = wide * 1.08;
    path(pen, [end, beyond]);
    pen.stroke();
    pen.fillStyle = colours.paper;
    pen.beginPath();
    pen.arc(...tip, Math.max(2.5, wide * 0.16), 0, 7);
    pen.fill();
    if (this.measured) {
      pen.strokeStyle = colours.series[2];
      pen.lineWidth = 3;
      pen.beginPath();
      pen.arc(...at(this.measured), 8, 0, 7);
      pen.stroke();
    }
    if (isNamed) {
      pen.fillStyle = colour;
      pen.font = '600 15px system-ui, sans-serif';
      pen.textAlign = 'left';
      pen.fillText(name, ox - 0.9 * wide, oy - 1.1 * wide - 14);
    }
  }

  /** How long 50 or 100 mm are. */
  ruler(pen, scale, height, colours) {
    const long = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5].findLast(long => long * scale < 130) ?? 0.01;
    const [x, y] = [16, height - 16];
    pen.strokeStyle = colours.muted;
    pen.lineWidth = 1.5;
    path(pen, [[x, y - 5], [x, y], [x + long * scale, y], [x + long * scale, y - 5]]);
    pen.stroke();
    pen.fillStyle = colours.muted;
    pen.font = '12px system-ui, sans-serif';
    pen.textAlign = 'left';
    pen.fillText(`${Math.round(1e3 * long)} mm`, x + 6, y - 6);
  }
}

function path(pen, points) {
  pen.beginPath();
  for (const point of points) pen.lineTo(...point);
}

function along(nodes) {
  let length = 0;
  for (let k = 1; k < nodes.length; k++) length += Math.hypot(nodes[k][0] - nodes[k - 1][0], nodes[k][1] - nodes[k - 1][1]);
  return length;
}
