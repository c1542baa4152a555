// Pages of studies: the runs of a sweep as a matrix with sparklines and as a table, the points of a
// bifurcation, the cells of a basin.

/** A value as text; "–" if there is none. */
const cellText = (x) => (x === null ? '–' : shown(x, 5));

// The axes of a sweep are shown in the study's units; `raw` has the values of the scene's keys, with all digits.
const axisOf = (k) => (data.axis_facts && data.axis_facts[k]) || {};
const withUnit = (name, unit) => (unit ? `${name}, ${unit}` : name);
if (data.kind === 'sweep')
  for (const run of data.runs) {
    run.raw = run.values;
    run.values = run.values.map((x, k) => (k < data.axes && x !== null ? Number((x * (axisOf(k).scale || 1)).toPrecision(9)) : x));
  }
const columnTitle = (k) => withUnit(data.columns[k], k < data.axes ? axisOf(k).unit : (data.units || {})[data.columns[k]]);

/** Above this ratio of positive values the colours are logarithmic, as in the figures of `freeplay plot`. */
const mostLinearRatio = 100;

/** Colour of a value on the scale of the matrix; `part` from 0 to 1. */
function shade(part) {
  const [r, g, b] = [1, 3, 5].map((i) => parseInt(colours.c1.slice(i, i + 2), 16));
  return `rgba(${r}, ${g}, ${b}, ${(0.04 + 0.66 * part).toFixed(3)})`;
}

function drawScale(canvas) {
  const { c, width, height } = paper(canvas);
  for (let x = 0; x < width; ++x) { c.fillStyle = shade(x / Math.max(1, width - 1)); c.fillRect(x, 0, 1, height); }
}

/** The command that makes the run of a sweep's cell from the scene's own start. */
function cellCommand(run) {
  const variant = (data.variants || {})[run.variant];
  if (!variant || !data.axis_facts || !/^\w+$/.test(run.formulation)) return [];
  return [`freeplay run ${variant.scene} --formulation ${run.formulation}${variant.set}` +
    data.axis_facts.map((axis, k) => (axis.key ? ` --set ${axis.key}=${run.raw[k]}` : '')).join(''),
  'The command starts as the scene does; the study perturbs the start and sets the duration.'];
}

function drawSpark(canvas, values) {
  const { c, width, height } = paper(canvas);
  const list = values.filter((y) => y !== null);
  const low = Math.min(...list), high = Math.max(...list), range = high - low || 1;
  c.strokeStyle = colours.ink;
  c.lineWidth = 1.2;
  line(c, values.map((y, i) => [2 + i / Math.max(1, values.length - 1) * (width - 4), height - 3 - ((y === null ? low : y) - low) / range * (height - 6)]));
  c.stroke();
}

/** Box with the parameters of the selected run or point and the command that repeats its run. */
function chosenBox() {
  const box = element('pre', '', data.kind === 'bifurcation' ? 'Click a point to show its parameters and command.' : 'Click a cell or point to show its parameters and command.');
  box.id = 'chosen';
  return box;
}

function makeSweep(section) {
  const names = data.columns, axes = names.slice(0, data.axes), list = data.runs;
  const head = element('div', 'row'), choice = element('select', 'controls'), chosen = chosenBox();
  choice.setAttribute('aria-label', 'statistic');
  const hasValues = names.map((_, k) => list.some((run) => run.values[k] !== null));
  names.forEach((name, k) => {
    if (k < axes.length || !hasValues[k]) return;
    const option = element('option', '', columnTitle(k));
    option.value = k;
    choice.append(option);
  });
  // The study's own measures precede the statistics, here and in the table.
  const own = (k) => k < axes.length || (data.own || []).includes(names[k]);
  const order = [...names.keys()].filter((k) => hasValues[k]).sort((a, b) => own(b) - own(a));
  const first = names.indexOf(data.first);
  if (first >= axes.length && hasValues[first]) choice.value = first;
  head.append(element('h2', '', `Runs of the study: ${list.length} of ${data.all}`), choice);
  section.append(head);
  const choose = (run) => {
    chosen.textContent = [`run ${run.key}`, `variant ${run.variant}, ${run.formulation}, start ${run.start}: ${run.status}${run.reason ? ': ' + run.reason : ''}`,
      ...axes.map((axis, k) => `${axis} = ${cellText(run.values[k])} ${axisOf(k).unit || ''}`), ...cellCommand(run)].join('\n');
  };
  const matrix = element('div', 'matrix'), key = element('p', 'row small'), scale = element('canvas', 'scale');
  section.append(key, matrix);
  const sparks = [];
  let shaded = [];
  const values = (k) => [...new Set(list.map((run) => run.values[k]))].sort((a, b) => a - b);
  const draw = () => {
    matrix.replaceChildren();
    key.replaceChildren();
    sparks.length = 0;
    shaded = [];
    const statistic = Number(choice.value), across = axes.length ? values(0) : [], down = axes.length > 1 ? values(1) : [null];
    const groups = [...new Set(list.map((run) => run.variant + ' · ' + run.formulation))];
    // Only a grid is shown as a matrix. For values spread over their ranges most cells would be
    // empty.
    const cells = across.length * down.length * groups.length;
    const grid = cells <= 1500 && new Set(list.map((run) => [run.variant, run.formulation, run.values[0], run.values[1]].join())).size >= 0.4 * cells;
    if (across.length && grid)
      for (const group of groups) {
        const table = element('table', 'cells'), top = element('tr');
        top.append(element('th', '', axes[1] ? `${columnTitle(1)} ↓` : ''), ...across.map((x) => element('th', '', cellText(x))));
        table.append(element('caption', '', `${group}; ${columnTitle(0)} →`), top);
        for (const y of down) {
          const row = element('tr');
          row.append(element('th', '', axes.length > 1 ? cellText(y) : ''));
          for (const x of across) {
            const cell = element('td'), found = list.filter((run) => run.variant + ' · ' + run.formulation === group && run.values[0] === x && (axes.length < 2 || run.values[1] === y));
            if (found.length) {
              const numbers = found.map((run) => run.values[statistic]).filter((v) => v !== null && v !== undefined);
              const traced = found.find((run) => run.line.length);
              if (traced) {
                const canvas = element('canvas');
                cell.append(canvas);
                sparks.push([canvas, traced.line]);
              }
              const mean = numbers.length ? numbers.reduce((a, b) => a + b) / numbers.length : null;
              cell.append(element('div', '', shown(mean, 3)));
              if (mean !== null) shaded.push([cell, mean]);
              cell.className = 'click';
              cell.addEventListener('click', () => choose(found[0]));
            }
            row.append(cell);
          }
          table.append(row);
        }
        const box = element('div', 'scroll');
        box.append(table);
        matrix.append(box);
      }
    const low = Math.min(...shaded.map(([, v]) => v)), high = Math.max(...shaded.map(([, v]) => v));
    const logarithmic = low > 0 && high > mostLinearRatio * low, place = logarithmic ? Math.log : (v) => v;
    shaded = shaded.map(([cell, v]) => [cell, high > low ? (place(v) - place(low)) / (place(high) - place(low)) : 0]);
    if (shaded.length) key.append(`${columnTitle(statistic)} (mean over starts${logarithmic ? '; logarithmic colours' : ''}): `, cellText(low), scale, cellText(high));
    redraw();
  };
  choice.addEventListener('change', draw);
  draw();
  watch(() => {
    sparks.forEach(([canvas, values_]) => drawSpark(canvas, values_));
    for (const [cell, part] of shaded) cell.style.background = shade(part);
    if (scale.isConnected) drawScale(scale);
  });
  if (!matrix.childElementCount && axes.length) {
    choice.remove();
    const statistics = names.filter((_, k) => k >= axes.length && hasValues[k]);
    makeScatter(section, axes[0], statistics, (i) => { choose(list[i]); return chosen.textContent; }, {
      title: `over ${axes[0]}`, size: 5, chosen, colour: () => colours.c0,
      columnOf: (name) => ({ y: list.map((run) => run.values[names.indexOf(name)]) }),
    });
  } else section.append(chosen);
  sweepTable(section, order.map(columnTitle), order, choose);
}

/** All runs as a table. A click on the head of a column sorts it. */
function sweepTable(section, names, places, choose) {
  const table = tableOf(['variant', 'formulation', 'start', ...names, 'status'], []), body = table.querySelector('tbody');
  let sorted = -1, sign = 1;
  const value = (run, k) => (k < 0 ? 0 : run.values[places[k]]);
  const fill = () => {
    const list = [...data.runs].sort((a, b) => sign * ((value(a, sorted) ?? -Infinity) - (value(b, sorted) ?? -Infinity)) || 0);
    body.replaceChildren();
    for (const run of list.slice(0, 1000)) {
      const row = element('tr', 'click');
      for (const cell of [run.variant, run.formulation, run.start, ...places.map((k) => cellText(run.values[k])), run.status]) row.append(element('td', '', cell));
      row.addEventListener('click', () => choose(run));
      body.append(row);
    }
  };
  table.querySelectorAll('th').forEach((th, i) => {
    if (i < 3 || i - 3 >= names.length) return;
    th.addEventListener('click', () => { sign = sorted === i - 3 ? -sign : 1; sorted = i - 3; fill(); });
  });
  fill();
  section.append(scrolled(table));
  if (data.runs.length > 1000) section.append(element('p', 'small', 'The first 1,000 rows in this order are listed.'));
}

function columnNamed(name) { return data.columns.find((column) => column.name === name); }

/** Scatter plot of two columns, coloured by branch. A click shows `tell` of the point. */
function makeScatter(section, x, ys, tell, options) {
  const columnOf = options.columnOf || columnNamed;
  const head = element('div', 'row'), choice = element('select', 'controls'), chosen = options.chosen || chosenBox(), canvas = element('canvas');
  choice.setAttribute('aria-label', 'column');
  choice.hidden = ys.length < 2;
  for (const name of ys) { const option = element('option', '', name); option.value = name; choice.append(option); }
  canvas.id = 'diagram';
  canvas.tabIndex = 0;
  const figure = element('figure', 'view');
  figure.append(canvas);
  head.append(element('h2', '', options.title), choice);
  section.append(head, figure, chosen);
  let at = -1, points = [];
  const m = plotMargin;
  const draw = () => {
    const { c, width, height } = paper(canvas), a = columnOf(x).y, b = columnOf(choice.value).y;
    const range = (list) => { let low = Infinity, high = -Infinity; for (const v of list) if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); } const pad = 0.04 * (high - low) || 0.5; return [low - pad, high + pad]; };
    const [left, right] = range(a), [low, high] = range(b);
    const toX = (v) => m.left + (v - left) / (right - left) * (width - m.left - m.right), toY = (v) => m.top + (high - v) / (high - low) * (height - m.top - m.bottom);
    c.strokeStyle = colours.grid;
    c.fillStyle = colours.soft;
    c.lineWidth = 1;
    c.textAlign = 'center';
    for (const v of ticks(left, right, width / 90)) { line(c, [[toX(v), m.top], [toX(v), height - m.bottom]]); c.stroke(); c.fillText(shown(v, 6), withinWidth(c, shown(v, 6), toX(v)), height - 8); }
    c.textAlign = 'right';
    for (const v of ticks(low, high, 6)) { line(c, [[m.left, toY(v)], [width - m.right, toY(v)]]); c.stroke(); c.fillText(shown(v, 4), m.left - 6, toY(v) + 4); }
    c.textAlign = 'left';
    points = a.map((v, i) => (v === null || b[i] === null ? null : [toX(v), toY(b[i])]));
    const size = options.size || (points.length > 2000 ? 2 : points.length > 200 ? 3 : 5);
    // Cells of a grid touch each other.
    const cell = (list, of) => {
      const at = [...new Set(list)].filter((v) => v !== null).sort((u, v) => u - v).map(of);
      return Math.max(size, ...at.slice(1).map((v, i) => Math.abs(v - at[i]))) + 0.5;
    };
    const across = options.cells ? cell(a, toX) : size, up = options.cells ? cell(b, toY) : size;
    points.forEach((p, i) => { if (p) { c.fillStyle = options.colour(i); c.fillRect(p[0] - 0.5 * across, p[1] - 0.5 * up, across, up); } });
    if (at >= 0 && points[at]) ring(c, points[at], 7, colours.ink);
  };
  const choose = (i) => { at = i; chosen.textContent = tell(i, choice.value); redraw(); };
  canvas.addEventListener('click', (e) => {
    const r = canvas.getBoundingClientRect(), px = e.clientX - r.left, py = e.clientY - r.top;
    let best = -1, distance = 900;
    points.forEach((p, i) => { if (p) { const d = (p[0] - px) ** 2 + (p[1] - py) ** 2; if (d < distance) { distance = d; best = i; } } });
    if (best >= 0) choose(best);
  });
  canvas.addEventListener('keydown', (e) => {
    if (e.key !== 'ArrowRight' && e.key !== 'ArrowLeft') return;
    choose((at + (e.key === 'ArrowRight' ? 1 : points.length - 1)) % points.length);
    e.preventDefault();
  });
  choice.addEventListener('change', redraw);
  watch(draw);
}

/** The command that repeats the run with these values of the axes. */
function commandOf(sets) {
  const formulation = data.formulation || 'nonsmooth';
  return `freeplay run ${data.scene_file} --formulation ${formulation}${data.overrides || ''}` +
    sets.map(([axis, value]) => ` --set ${axis.key}=${Number((value / (axis.scale || 1)).toPrecision(15))}`).join('');
}

function makeDiagram(section) {
  const columnOf = columnNamed;
  const axis = data.axis || {}, value = columnOf('value'), branch = columnOf('branch');
  const taken = ['branch', 'value', 'attractor', 'period', 't'];
  const ys = data.columns.filter((column) => column.y && !taken.includes(column.name)).map((column) => column.name);
  if (!value || !ys.length) return;
  const branches = branch ? [...new Set(branch.words)] : [];
  makeScatter(section, 'value', ys, (i, y) => {
    const of = (name) => { const column = columnOf(name); return column ? cellText(column.y[i]) : '–'; };
    return [`${axis.name || 'value'} = ${cellText(value.y[i])} ${axis.unit || ''}${branch ? ', branch ' + branch.words[i] : ''}`,
      `${y} = ${of(y)}; attractor ${of('attractor')}, period ${of('period')}, t = ${of('t')} s`,
      axis.key ? commandOf([[axis, value.y[i]]]) : '',
      branch && branches.length > 1 ? 'A branch continues from the final state of the previous value; from the start of the scene the motion may reach another attractor.' : ''].filter(Boolean).join('\n');
  }, {
    title: `Bifurcation over ${axis.name || 'value'}${axis.unit ? ', ' + axis.unit : ''}; section: ${data.section || ''}`,
    colour: (i) => (branch ? runColour(branches.indexOf(branch.words[i])) : colours.c0),
  });
  if (branch) {
    const key = element('p', 'row small');
    branches.forEach((name, b) => { const word = element('strong', '', name); watch(() => { word.style.color = runColour(b); }); key.append(word); });
    section.append(key);
  }
}

/** Key of the attractors' colours, with the period and the section of the first cell of each, and its share of the cells. */
function basinKey(attractor, colourOf) {
  const key = element('p', 'row small key'), all = attractor.y.length;
  const others = data.columns.filter((column) => column.y && !['x', 'y', 'attractor', 'period', 't'].includes(column.name));
  for (const a of [...new Set(attractor.y.map((v) => (v !== null && v >= 0 ? v : null)))].sort((u, v) => (u === null) - (v === null) || u - v)) {
    const same = (v) => (v !== null && v >= 0 ? v : null) === a, first = attractor.y.findIndex(same);
    const period = columnNamed('period'), count = attractor.y.filter(same).length;
    const facts = [...(period && a !== null ? [`period ${cellText(period.y[first])}`] : []), ...(a !== null ? others.map((column) => `${column.name} = ${cellText(column.y[first])}`) : [])];
    const word = element('strong', '', a === null ? 'no attractor found' : `attractor ${a}`);
    watch(() => { word.style.color = colourOf(a); });
    key.append(word, ` ${facts.join(', ')}${facts.length ? '; ' : ''}${shown(100 * count / all, 3)} % of the cells `);
  }
  return key;
}

function makeBasin(section) {
  const attractor = columnNamed('attractor'), axes = [data.x, data.y];
  if (!columnNamed('x') || !columnNamed('y') || !axes[0] || !axes[1]) return;
  const named = (axis) => axis.name + (axis.unit ? ', ' + axis.unit : '');
  const colourOf = (a) => (a !== null && a >= 0 ? bodyColour(a) : colours.soft);
  makeScatter(section, 'x', ['y'], (i) => [
    ...data.columns.map((column) => `${{ x: named(axes[0]), y: named(axes[1]) }[column.name] || column.name} = ${column.words ? column.words[i] : cellText(column.y[i])}`),
    commandOf([[axes[0], columnNamed('x').y[i]], [axes[1], columnNamed('y').y[i]]])].join('\n'), {
    title: `Basin over ${named(axes[0])} → and ${named(axes[1])} ↑`, size: 8,
    cells: true,
    colour: (i) => colourOf(attractor ? attractor.y[i] : null),
  });
  if (attractor) section.append(basinKey(attractor, colourOf));
}

function makeStudy(section) {
  if (!['sweep', 'bifurcation', 'basin'].includes(data.kind)) return;
  section.hidden = false;
  if (data.kind === 'sweep') makeSweep(section);
  if (data.kind === 'bifurcation') makeDiagram(section);
  if (data.kind === 'basin') makeBasin(section);
}
