// Columns over time: all runs in one plot, events as ticks, a cursor at the current time. The wheel
// zooms, dragging zooms to the selected range, a double click resets the zoom, a click moves the
// motion to that time.
const plotMargin = { left: 64, right: 12, top: 8, bottom: 24 };
const mostPlots = 8;

/** The curve of a column in a run; undefined if the run has no such column. */
function curveOf(run, file, name) {
  const table = run.curves.find((t) => t.file === file && t.columns.some((column) => column.name === name));
  return table && { t: table.t, ...table.columns.find((column) => column.name === name) };
}
const columns = [];
for (const run of runs)
  for (const table of run.curves)
    for (const column of table.columns)
      if (!columns.some((k) => k.file === table.file && k.name === column.name))
        columns.push({ file: table.file, name: column.name, unit: column.unit });

// The greatest value of each column. A column that stays below 1e-9 of the greatest column of its
// unit is zero up to rounding.
const greatest = new Map(), ofUnit = {};
for (const run of runs)
  for (const table of run.curves)
    for (const column of table.columns) {
      const key = table.file + ' ' + column.name, size = column.y.reduce((most, y) => Math.max(most, Math.abs(y)), 0);
      greatest.set(key, Math.max(greatest.get(key) || 0, size));
      ofUnit[column.unit] = Math.max(ofUnit[column.unit] || 0, size);
    }
const isZero = (k) => !(greatest.get(k.file + ' ' + k.name) > 1e-9 * ofUnit[k.unit]);
columns.sort((a, b) => isZero(a) - isZero(b));

/** The columns shown first: a signal, gaps and forces of joints with clearance, a speed. Columns
 * that are zero all the time come last. */
function firstColumns() {
  const list = columns.filter((k) => k.file === 'signals.csv').slice(0, 1);
  for (const name of looseNames)
    for (const ends of [['.gap', '.rear_lower.gap', '.right.gap'], ['.fn', '.rear_lower.fn', '.right.fn']])
      list.push(...columns.filter((k) => ends.some((end) => k.name === name + end)).slice(0, 1));
  list.push(...columns.filter((k) => /\.(vx|omega)$/.test(k.name)).slice(-1));
  const some = list.filter((k) => !isZero(k));
  if (some.length < 3) some.push(...columns.filter((k) => /\.(vy|vx|omega)$/.test(k.name) && !isZero(k) && !some.includes(k)).slice(0, 3 - Math.max(some.length, 2)));
  return some.length ? some.slice(0, 3) : columns.slice(0, 1);
}

const toPixel = (width, t) => plotMargin.left + (t - state.from) / (state.to - state.from) * (width - plotMargin.left - plotMargin.right);
const toTime = (width, x) => state.from + (x - plotMargin.left) / (width - plotMargin.left - plotMargin.right) * (state.to - state.from);

// s, end of the start transient, which does not count for the scales of the whole time.
const transient = runs.reduce((t, run) => Math.max(t, run.transient || 0), 0);
const isWhole = () => state.from <= begin && state.to >= end;

/** Range of the values of curves within the displayed time range, with a margin. Over the whole
 * time it leaves out the start transient. */
function rangeOf(curves) {
  const after = isWhole() && transient > begin && transient < end ? transient : state.from;
  const range = rangeFrom(curves, after);
  return range || rangeFrom(curves, state.from) || [0, 1];
}

/** The range from a time on; none without values, or if they all are the same later on only. */
function rangeFrom(curves, from) {
  let low = Infinity, high = -Infinity;
  for (const { t, y } of curves)
    for (let i = before(t, from) + (from > state.from ? 1 : 0), n = Math.min(t.length - 1, before(t, state.to) + 1); i <= n; ++i)
      if (y[i] !== null) { low = Math.min(low, y[i]); high = Math.max(high, y[i]); }
  if (!(high >= low) || (high === low && from > state.from)) return null;
  const pad = high > low ? 0.05 * (high - low) : Math.abs(high) * 0.1 || 1;
  return [low - pad, high + pad];
}

function drawAxes(c, width, height, low, high) {
  const m = plotMargin, toY = (y) => m.top + (high - y) / (high - low) * (height - m.top - m.bottom);
  c.strokeStyle = colours.grid;
  c.fillStyle = colours.soft;
  c.lineWidth = 1;
  c.textAlign = 'right';
  c.textBaseline = 'middle';
  for (const y of ticks(low, high, 6)) {
    line(c, [[m.left, toY(y)], [width - m.right, toY(y)]]);
    c.stroke();
    c.fillText(Math.abs(y) >= 1e5 || (y !== 0 && Math.abs(y) < 1e-3) ? Number(y.toPrecision(4)).toExponential() : shown(y, 6), m.left - 6, toY(y));
  }
  c.textAlign = 'center';
  c.textBaseline = 'top';
  for (const t of ticks(state.from, state.to, width / 110)) {
    const x = toPixel(width, t);
    line(c, [[x, m.top], [x, height - m.bottom]]);
    c.stroke();
    c.fillText(shown(t, 8) + ' s', withinWidth(c, shown(t, 8) + ' s', x), height - m.bottom + 5);
  }
  c.textAlign = 'left';
  c.textBaseline = 'alphabetic';
  return toY;
}

function drawEventTicks(c, width, height, r) {
  const list = runs[r].events.t, first = before(list, state.from);
  c.strokeStyle = runColour(r);
  c.globalAlpha = 0.5;
  c.lineWidth = 1;
  c.beginPath();
  let drawn = -1;
  for (let i = first; i < list.length && list[i] <= state.to; ++i) {
    const x = Math.round(toPixel(width, list[i]));
    if (x < plotMargin.left || x === drawn) continue;
    drawn = x;
    c.moveTo(x, height - plotMargin.bottom - 4 - 4 * r);
    c.lineTo(x, height - plotMargin.bottom - 4 * r);
  }
  c.stroke();
  c.globalAlpha = 1;
}

function drawPlot(plot) {
  const { c, width, height } = paper(plot.canvas), m = plotMargin;
  const curves = runs.map((run) => curveOf(run, plot.column.file, plot.column.name));
  const [low, high] = rangeOf(curves.filter(Boolean));
  plot.scale = [low, high];
  const toY = drawAxes(c, width, height, low, high);
  c.save();
  c.beginPath();
  c.rect(m.left, m.top, width - m.left - m.right, height - m.top - m.bottom);
  c.clip();
  curves.forEach((curve, r) => {
    if (!curve) return;
    c.strokeStyle = runColour(r);
    c.lineWidth = 1.3;
    c.beginPath();
    let down = false;
    for (let i = before(curve.t, state.from), n = Math.min(curve.t.length - 1, before(curve.t, state.to) + 1); i <= n; ++i) {
      if (curve.y[i] === null) { down = false; continue; }
      const x = toPixel(width, curve.t[i]), y = toY(curve.y[i]);
      if (down) c.lineTo(x, y); else c.moveTo(x, y);
      down = true;
    }
    c.stroke();
  });
  const now = toPixel(width, state.t);
  c.strokeStyle = colours.ink;
  c.lineWidth = 1;
  line(c, [[now, 0], [now, height]]);
  c.stroke();
  if (plot.from !== undefined) {
    c.fillStyle = colours.accent;
    c.globalAlpha = 0.2;
    c.fillRect(Math.min(plot.from, plot.to), m.top, Math.abs(plot.to - plot.from), height);
    c.globalAlpha = 1;
  }
  c.restore();
  runs.forEach((_, r) => drawEventTicks(c, width, height, r));
  const t = plot.hover === undefined ? state.t : toTime(width, plot.hover);
  plot.value.textContent = `t = ${shown(t, 6)} s   ` + curves.map((curve, r) => {
    if (!curve) return '';
    const i = before(curve.t, t), k = i + 1 < curve.t.length && curve.t[i + 1] - t < t - curve.t[i] ? i + 1 : i;
    return `${runs[r].name}: ${shown(curve.y[k], 5)}${plot.column.unit ? ' ' + plot.column.unit : ''}`;
  }).filter(Boolean).join('   ');
}

function zoom(from, to) {
  const least = 1e-7 * (end - begin), width = Math.min(end - begin, Math.max(least, to - from));
  state.from = Math.max(begin, Math.min(from, end - width));
  state.to = state.from + width;
  redraw();
}

function bindPlot(plot) {
  const place = (e) => e.clientX - plot.canvas.getBoundingClientRect().left;
  plot.canvas.addEventListener('wheel', (e) => {
    e.preventDefault();
    const t = toTime(plot.canvas.clientWidth, place(e)), k = e.deltaY > 0 ? 1.25 : 0.8;
    zoom(t - k * (t - state.from), t + k * (state.to - t));
  }, { passive: false });
  plot.canvas.addEventListener('pointerdown', (e) => {
    plot.from = plot.to = place(e);
    plot.canvas.setPointerCapture(e.pointerId);
  });
  plot.canvas.addEventListener('pointermove', (e) => {
    plot.hover = place(e);
    if (plot.from !== undefined) plot.to = plot.hover;
    redraw();
  });
  plot.canvas.addEventListener('pointerleave', () => { plot.hover = undefined; redraw(); });
  plot.canvas.addEventListener('pointercancel', () => { plot.from = undefined; redraw(); });
  plot.canvas.addEventListener('pointerup', () => {
    if (plot.from === undefined) return;
    const width = plot.canvas.clientWidth, a = toTime(width, Math.min(plot.from, plot.to)), b = toTime(width, Math.max(plot.from, plot.to));
    const dragged = Math.abs(plot.to - plot.from) > 4;
    plot.from = undefined;
    if (dragged) zoom(a, b); else seek(a);
    redraw();
  });
  plot.canvas.addEventListener('dblclick', () => zoom(begin, end));
}

const plots = [];
function addPlot(parent, column) {
  const figure = element('figure', 'plot'), bar = element('div', 'row'), canvas = element('canvas');
  const choice = element('select', 'controls'), value = element('span', 'small'), remove = element('button', 'controls', '×');
  choice.setAttribute('aria-label', 'column');
  remove.title = 'remove this plot';
  columns.forEach((k, i) => {
    const option = element('option', '', k.name + (k.unit ? ` (${k.unit})` : '') + ' · ' + k.file);
    option.value = i;
    choice.append(option);
  });
  const plot = { canvas, column, value, figure };
  choice.value = columns.indexOf(column);
  const title = element('strong', 'print', '');
  choice.addEventListener('change', () => { plot.column = columns[Number(choice.value)]; redraw(); });
  remove.addEventListener('click', () => { plots.splice(plots.indexOf(plot), 1); figure.remove(); });
  bar.append(title, choice, remove, value);
  figure.append(bar, canvas);
  parent.append(figure);
  plots.push(plot);
  bindPlot(plot);
}

function makePlots(section) {
  if (!columns.length) return;
  section.hidden = false;
  const head = element('div', 'row'), key = element('span', 'small');
  head.append(element('h2', '', 'Plots'));
  runs.forEach((run, r) => {
    const name = element('strong', '', run.name);
    watch(() => { name.style.color = runColour(r); });
    head.append(name);
  });
  const more = element('button', 'controls', 'add plot'), whole = element('button', 'controls', 'whole time');
  key.textContent = 'wheel or drag: zoom; click: set the time; double click: show all';
  head.append(more, whole, key);
  const list = element('div');
  more.addEventListener('click', () => { if (plots.length < mostPlots) addPlot(list, columns.find((k) => plots.every((plot) => plot.column !== k)) || columns[0]); redraw(); });
  whole.addEventListener('click', () => zoom(begin, end));
  section.append(head, list);
  for (const column of firstColumns()) addPlot(list, column);
  const thinned = runs.flatMap((run) => run.curves.filter((t) => t.rows > t.t.length).map((t) => `${run.name} ${t.file}: ${t.t.length.toLocaleString('en')} of ${t.rows.toLocaleString('en')} rows`));
  if (thinned.length)
    section.append(element('p', 'small', `Rows shown of each column: ${thinned.join('; ')}. Each interval of rows is shown by its least and greatest value, so all peaks are kept; their times are exact to the interval. Ticks below mark events at their exact times.`));
  const start = element('p', 'small');
  section.append(start);
  watch(() => {
    plots.forEach(drawPlot);
    start.textContent = isWhole() && transient > begin && transient < end ? `The start up to t = ${shown(transient)} s is left out of the vertical scales; zoom in to see it in full.` : '';
  });
}
