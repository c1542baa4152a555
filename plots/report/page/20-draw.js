// Canvases with the resolution of the screen, and colours of the theme.
const colours = {};
function takeColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['page', 'card', 'ink', 'soft', 'line', 'accent', 'grid', 'force', 'warn',
    'c0', 'c1', 'c2', 'b0', 'b1', 'b2', 'b3', 'b4', 'b5', 'b6'])
    colours[name] = style.getPropertyValue('--' + name).trim();
}
const runColour = (r) => colours['c' + Math.min(r, 2)];
const bodyColour = (b) => colours['b' + b % 7];

/** Clears a canvas; returns its context and its size in CSS pixels. */
function paper(canvas) {
  const scale = window.devicePixelRatio || 1;
  const width = Math.max(1, canvas.clientWidth), height = Math.max(1, canvas.clientHeight);
  if (canvas.width !== Math.round(width * scale) || canvas.height !== Math.round(height * scale)) {
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
  }
  const c = canvas.getContext('2d');
  c.setTransform(scale, 0, 0, scale, 0, 0);
  c.clearRect(0, 0, width, height);
  c.font = '12px system-ui, "DejaVu Sans", sans-serif';
  c.lineJoin = c.lineCap = 'round';
  return { c, width, height };
}

/** Round numbers within a range, about `count` of them. */
function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count);
  if (!(raw > 0) || !Number.isFinite(raw)) return [];
  const power = 10 ** Math.floor(Math.log10(raw));
  const size = [1, 2, 5, 10].map((k) => k * power).find((k) => k >= raw * 0.999);
  const list = [];
  for (let i = Math.ceil(low / size - 1e-9); i * size <= high + 1e-9 * size; ++i) list.push(Number((i * size).toPrecision(12)));
  return list;
}

function line(c, points, close) {
  c.beginPath();
  points.forEach(([x, y], i) => (i ? c.lineTo(x, y) : c.moveTo(x, y)));
  if (close) c.closePath();
}

/** Draws an arrow of at most `most` pixels that ends within the picture; a shortened one is dashed. */
function arrow(c, x, y, dx, dy, most = Infinity) {
  const room = 6, within = (at, by, size) => (by > 0 ? (size - room - at) / by : by < 0 ? (room - at) / by : Infinity);
  const whole = Math.hypot(dx, dy);
  const part = Math.min(1, most / whole, within(x, dx, c.canvas.clientWidth), within(y, dy, c.canvas.clientHeight));
  const length = part * whole;
  if (!(length >= 2)) return;
  dx *= part; dy *= part;
  const head = Math.min(8, 0.5 * length), ux = dx / length, uy = dy / length;
  c.setLineDash(part < 1 ? [5, 4] : []);
  line(c, [[x, y], [x + dx, y + dy]]);
  c.stroke();
  c.setLineDash([]);
  c.beginPath();
  c.moveTo(x + dx - head * (ux + 0.6 * uy), y + dy - head * (uy - 0.6 * ux));
  c.lineTo(x + dx, y + dy);
  c.lineTo(x + dx - head * (ux - 0.6 * uy), y + dy - head * (uy + 0.6 * ux));
  c.stroke();
}

/** Centre of a text near x such that the text is not cut off at the right. */
const withinWidth = (c, words, x) => Math.min(x, c.canvas.clientWidth - 0.5 * c.measureText(words).width - 1);

/** Draws a text near an object. Long texts are shortened and kept inside the picture. */
function label(c, text, x, y, most = 28) {
  const words = text.length > most ? text.slice(0, most) + '…' : text, width = c.canvas.clientWidth;
  c.fillText(words, x < width ? Math.min(x, width - c.measureText(words).width - 2) : x, y);
}
