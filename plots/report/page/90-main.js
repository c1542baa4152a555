// Assembles the page: theme, controls, keys, and the interface for tests.
const themes = ['light', 'dark'];
function setTheme(name) {
  document.documentElement.dataset.theme = name;
  takeColours();
  redraw();
}
const dark = window.matchMedia('(prefers-color-scheme: dark)');
setTheme(dark.matches ? 'dark' : 'light');
dark.addEventListener('change', () => setTheme(dark.matches ? 'dark' : 'light'));
const swapTheme = () => setTheme(themes[1 - themes.indexOf(document.documentElement.dataset.theme)]);
byId('theme').addEventListener('click', swapTheme);

// Printing uses the light theme.
let screenTheme = '';
const drawAll = () => { for (const f of listeners) f(); };
window.addEventListener('beforeprint', () => { screenTheme = document.documentElement.dataset.theme; setTheme('light'); drawAll(); });
window.addEventListener('afterprint', () => { setTheme(screenTheme); drawAll(); });

byId('title').textContent = data.title || data.folder;
byId('subtitle').textContent = (data.scene_title && data.scene_title !== data.title ? data.scene_title + ' · ' : '') + { run: 'one run', comparison: 'both formulations of one scene', sweep: 'a study', bifurcation: 'a bifurcation diagram', basin: 'basins of attraction', orbit: 'a periodic motion', continue: 'branches of periodic motions', lyapunov: 'Lyapunov exponents' }[data.kind] + ' · ' + data.folder;

const keyList = [['space', 'play or pause'], ['← →', 'a frame back or on; with shift ten'], ['P N', 'the event before, the next one'],
  ['Home End', 'beginning, end'], ['+ −', 'faster, slower'], ['O', 'runs side by side or overlaid'], ['F', 'forces'], ['Z', 'plots: whole time'], ['T', 'light or dark'], ['?', 'these keys']];
function showKeys() {
  const box = byId('help');
  if (box.open) return box.close();
  const close = element('button', '', 'close');
  close.addEventListener('click', () => box.close());
  box.replaceChildren(element('h2', '', 'Keys'), ...keyList.map(([key, what]) => { const row = element('p'); row.append(element('kbd', '', key), ' ' + what); return row; }), close);
  box.showModal();
}

const rates = [0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10];
/** Rate at which one turn, or a whole run without turns, takes about 4 s. */
function firstRate() {
  const turn = runs[0].turn || (end - begin);
  return rates.reduce((best, rate) => (Math.abs(Math.log(turn / rate / 4)) < Math.abs(Math.log(turn / best / 4)) ? rate : best));
}
function setRate(rate) {
  state.rate = rate;
  byId('speed').value = rate;
}

function bindView(canvas) {
  let from = null;
  canvas.addEventListener('wheel', (e) => {
    if (!e.ctrlKey && !e.shiftKey) return;  // the wheel scrolls the page
    e.preventDefault();
    state.view.zoom = Math.min(1e4, Math.max(0.2, state.view.zoom * (e.deltaY > 0 ? 0.8 : 1.25)));
    redraw();
  }, { passive: false });
  canvas.addEventListener('pointerdown', (e) => { from = [e.clientX, e.clientY, state.view.x, state.view.y]; canvas.setPointerCapture(e.pointerId); });
  canvas.addEventListener('pointermove', (e) => {
    if (!from) return;
    const { k } = scaleOf(canvas.clientWidth, canvas.clientHeight);
    state.view.x = from[2] - (e.clientX - from[0]) / k;
    state.view.y = from[3] + (e.clientY - from[1]) / k;
    redraw();
  });
  for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, () => { from = null; });
  canvas.addEventListener('dblclick', () => { state.view = { zoom: 1, x: 0, y: 0 }; redraw(); });
}

let views = [];
function layViews() {
  const beside = state.layout === 'beside', ideal = runs.findIndex((run) => run.name === 'ideal joint');
  const single = runs.length > 1 && !beside && state.layout !== 'over' ? [Number(state.layout)] : null;
  const loose = runs.map((_, r) => r).filter((r) => r !== ideal || runs.length === 1);
  const lists = single ? [single] : beside ? loose.map((r) => [r]) : [loose];
  byId('views').replaceChildren();
  views = lists.map((list) => {
    const figure = element('figure', 'view'), canvas = element('canvas');
    figure.append(element('figcaption', '', list.map((r) => runs[r].name).join(' and ')), canvas);
    byId('views').append(figure);
    bindView(canvas);
    return { canvas, list };
  });
  fitViews();
}

/** Sets the heights of the canvases to the aspect ratio of the mechanism, within limits. */
function fitViews() {
  const shape = (box.high - box.low) / (box.right - box.left);
  const least = window.innerWidth > 760 ? 240 : 150, most = Math.max(least, Math.min(520, 0.6 * window.innerHeight));
  for (const { canvas } of views) canvas.style.height = `${Math.round(Math.min(most, Math.max(least, shape * canvas.clientWidth)))}px`;
  redraw();
}

function makeMotion() {
  byId('motion').hidden = false;
  for (const rate of rates) { const option = element('option', '', rate >= 1 ? `${rate} ×` : `1/${Math.round(1 / rate)}`); option.value = rate; byId('speed').append(option); }
  setRate(firstRate());
  const layouts = [['beside', 'beside'], ['over', 'over one another'], ...runs.map((run, r) => [r, run.name])];
  for (const [value, text] of layouts) { const option = element('option', '', text); option.value = value; byId('layout').append(option); }
  byId('layout-label').hidden = runs.length < 2;
  byId('arrows-label').hidden = !runs.some((run) => run.motion.arrows.length || run.events.t.length);
  byId('deflection-label').hidden = !magnifiedParts;
  byId('deflection-label').firstChild.textContent = `${magnifiedParts} `;
  for (const factor of [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000]) { const option = element('option', '', `× ${factor}`); option.value = factor; byId('deflection').append(option); }
  byId('deflection').addEventListener('change', (e) => { state.magnify = Number(e.target.value); redraw(); });
  byId('play').addEventListener('click', () => play());
  byId('previous').addEventListener('click', () => stepEvent(false));
  byId('next').addEventListener('click', () => stepEvent(true));
  byId('keys').addEventListener('click', showKeys);
  byId('scrub').addEventListener('input', (e) => { play(false); seek(begin + Number(e.target.value) / 10000 * (end - begin)); });
  byId('speed').addEventListener('change', (e) => setRate(Number(e.target.value)));
  byId('layout').addEventListener('change', (e) => { state.layout = e.target.value; layViews(); });
  byId('follow').addEventListener('change', (e) => { state.names = e.target.checked; redraw(); });
  byId('arrows').addEventListener('change', (e) => { state.arrows = e.target.checked; redraw(); });
  const thinned = runs.filter((run) => run.motion.rows > run.motion.t.length).map((run) => `${run.name}: ${run.motion.t.length.toLocaleString('en')} of ${run.motion.rows.toLocaleString('en')} rows`);
  byId('shown').textContent = (thinned.length ? `Frames shown: ${thinned.join('; ')}, including rows next to events; linear interpolation between them. ` : '') +
    (runs.some((run) => run.motion.arrows.length) ? 'Arrows: forces on the second body of each joint, dashed if shortened; rings: impacts. ' : 'Rings: impacts; forces are shown for runs made with --forces. ') +
    'Drag to move the picture, Ctrl + wheel to zoom, double click to reset.';
  makeLoose(byId('magnified'));
  layViews();
  watch(() => {
    for (const { canvas, list } of views) drawMechanism(canvas, list);
    byId('time').textContent = `t = ${state.t.toFixed(6)} s`;
    byId('scrub').value = end > begin ? Math.round((state.t - begin) / (end - begin) * 10000) : 0;
    byId('play').textContent = state.playing ? '❚❚' : '▶';
  });
}

function stepFrames(count) {
  play(false);
  const list = runs[0].motion.t;
  seek(list[Math.min(list.length - 1, Math.max(0, before(list, state.t + 1e-12) + count))]);
}

const keys = {
  ' ': () => play(), n: () => stepEvent(true), p: () => stepEvent(false), Home: () => seek(begin), End: () => seek(end),
  ArrowRight: (e) => stepFrames(e.shiftKey ? 10 : 1), ArrowLeft: (e) => stepFrames(e.shiftKey ? -10 : -1),
  '+': () => setRate(rates[Math.min(rates.length - 1, rates.indexOf(state.rate) + 1)]),
  '-': () => setRate(rates[Math.max(0, rates.indexOf(state.rate) - 1)]),
  o: () => { if (runs.length > 1) { state.layout = state.layout === 'over' ? 'beside' : 'over'; byId('layout').value = state.layout; layViews(); } },
  f: () => { state.arrows = !state.arrows; byId('arrows').checked = state.arrows; redraw(); },
  z: () => zoom(begin, end),
};
document.addEventListener('keydown', (e) => {
  if (e.ctrlKey || e.metaKey || e.altKey || byId('help').open) return;
  const inField = ['SELECT', 'TEXTAREA'].includes(e.target.tagName) || (e.target.tagName === 'INPUT' && e.target.type !== 'checkbox');
  if (inField || (e.key === ' ' && ['BUTTON', 'SUMMARY', 'INPUT'].includes(e.target.tagName)) || e.target.id === 'diagram') return;
  const key = e.key.length === 1 ? e.key.toLowerCase() : e.key;
  if (key === 't') return swapTheme();
  if (key === '?') return showKeys();
  if (!runs.length || !keys[key]) return;
  keys[key](e);
  e.preventDefault();
});

makeNotes(byId('notes'));
if (runs.length && runs.every((run) => run.motion.t.length)) {
  makeMotion();
  makePlots(byId('plots'));
  makeEvents(byId('events'));
}
makeStudy(byId('study'));
makePictures(byId('tables'));
makeTables(byId('tables'));
makeAgain(byId('again'));
window.addEventListener('resize', () => (runs.length ? fitViews() : redraw()));
redraw();

/** Interface for tests: the displayed state (time, poses, positions within clearances), pixels. */
window.freeplay = {
  data, seek, play, zoom,
  state() {
    const { t, playing, rate, layout, from, to } = state;
    return { t, playing, rate, layout, from, to, scales: plots.map((plot) => ({ column: plot.column.name, range: plot.scale })), theme: document.documentElement.dataset.theme, runs: runs.map((run) => {
      const at = frame(run, t);
      return { name: run.name, poses: run.motion.poses.map((column) => between(column, at)), loose: run.motion.loose.map((joint) => ({ name: joint.name, ...playAt(joint, at) })) };
    }) };
  },
  /** Pixel of the centre of mass of a body in a view. */
  pixel(view, body) {
    const { canvas, list } = views[view], run = runs[list[0]], p = poseOf(run, body, frame(run, state.t));
    return scaleOf(canvas.clientWidth, canvas.clientHeight).at([p.x, p.y]);
  },
};
