// Marks of a chart on a canvas, each by its kind.

const FONT = '12px system-ui, "Helvetica Neue", Arial, sans-serif';

const path = (on, { x, y }, X, Y) => x.forEach((at, k) => on[k ? 'lineTo' : 'moveTo'](X(at), Y(y[k])));
const box = ({ x, y }, X, Y) => [X(x[0]), Y(y[1]), X(x[1]) - X(x[0]), Y(y[0]) - Y(y[1])];
const DRAW = {
  line: (on, mark, X, Y) => {
    on.beginPath();
    path(on, mark, X, Y);
    on.stroke();
  },
  band: (on, mark, X, Y) => {
    on.beginPath();
    path(on, mark, X, Y);
    for (let k = mark.x.length - 1; k >= 0; k--) on.lineTo(X(mark.x[k]), Y(mark.upper[k]));
    on.fill();
  },
  dots: (on, mark, X, Y, ratio) => mark.x.forEach((x, k) => {
    on.beginPath();
    on.arc(X(x), Y(mark.y[k]), mark.radius * ratio, 0, 7);
    on.fill();
  }),
  rings: (on, mark, X, Y, ratio) => mark.x.forEach((x, k) => {
    on.beginPath();
    on.arc(X(x), Y(mark.y[k]), mark.radius * ratio, 0, 7);
    on.stroke();
  }),
  strip: (on, mark, X, Y) => {
    on.fillStyle = 'rgba(110, 110, 110, 0.18)';
    on.fillRect(...box(mark, X, Y));
  },
  cell: (on, mark, X, Y) => {
    Object.assign(on, { fillStyle: mark.color, strokeStyle: '#fff' });
    on.fillRect(...box(mark, X, Y));
    on.strokeRect(...box(mark, X, Y));
  },
  // In its cell, where there is room.
  number: (on, { at, text, color }, X, Y, ratio, room) => {
    Object.assign(on, { fillStyle: color, textAlign: 'center', textBaseline: 'middle', font: FONT.replace('12', 12 * ratio) });
    if (on.measureText(text).width < room) on.fillText(text, X(at[0]), Y(at[1]));
  },
  // As far to the left as it needs to be whole.
  text: (on, { at, text }, X, Y, ratio, room, [left, right]) => {
    Object.assign(on, { fillStyle: '#000', textAlign: 'left', textBaseline: 'middle', font: FONT.replace('12', 12 * ratio) });
    const last = right - 2 * ratio - on.measureText(text).width;
    on.fillText(text, Math.max(left + 2 * ratio, Math.min(X(at[0]), last)), Y(at[1]));
  },
};
