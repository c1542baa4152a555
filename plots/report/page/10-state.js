// State of the page: the data, the clock, and the listeners to changes. Texts come from files of
// unknown origin and reach the page only through textContent and fillText.
const data = JSON.parse(document.getElementById('data').textContent);
const runs = Array.isArray(data.runs) && data.kind !== 'sweep' ? data.runs : [];
const byId = (id) => document.getElementById(id);

/** Creates an element with a class and a text. */
function element(tag, className, text) {
  const e = document.createElement(tag);
  if (className) e.className = className;
  if (text !== undefined) e.textContent = String(text);
  return e;
}

const last = (list) => list[list.length - 1];
const end = runs.reduce((t, run) => Math.max(t, last(run.motion.t) || 0), 0);
const begin = runs.length ? runs.reduce((t, run) => Math.min(t, run.motion.t[0] || 0), Infinity) : 0;

const state = {
  t: begin, playing: false, rate: 1, layout: 'beside', names: true, arrows: true, magnify: 1,
  from: begin, to: end,  // s, time range of the plots
  view: { zoom: 1, x: 0, y: 0 },  // view of the mechanism
};

const listeners = [];
/** Registers f to be called when the time or the view changes. */
function watch(f) { listeners.push(f); }
let asked = false;
/** Schedules a redraw of everything, at most once per screen frame. */
function redraw() {
  if (asked) return;
  asked = true;
  requestAnimationFrame(() => { asked = false; for (const f of listeners) f(); });
}

function seek(t) {
  state.t = Math.min(end, Math.max(begin, t));
  redraw();
}

let shownAt = 0;
function step(now) {
  if (!state.playing) return;
  const passed = Math.min(0.1, (now - shownAt) / 1000);
  shownAt = now;
  let t = state.t + passed * state.rate;
  if (t > end) t = begin;
  seek(t);
  requestAnimationFrame(step);
}
function play(on = !state.playing) {
  if (on && !state.playing) {
    shownAt = performance.now();
    state.playing = true;
    requestAnimationFrame(step);
  }
  state.playing = on;
  redraw();
}

/** Greatest index with list[index] <= t, at least 0. */
function before(list, t) {
  let low = 0, high = list.length - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (list[middle] <= t) low = middle; else high = middle - 1;
  }
  return low;
}

/** The frame before the time t, and the fraction of the interval to the next frame. */
function frame(run, t) {
  const list = run.motion.t, i = before(list, t);
  if (i + 1 >= list.length || t <= list[i]) return { i, part: 0 };
  return { i, part: Math.min(1, (t - list[i]) / (list[i + 1] - list[i])) };
}
function between(column, { i, part }) {
  return part > 0 ? column[i] + part * (column[i + 1] - column[i]) : column[i];
}

// The events of all runs in the order of time.
const events = [];
runs.forEach((run, r) => run.events.t.forEach((t, i) => events.push({ run: r, i, t })));
events.sort((a, b) => a.t - b.t);

/** Moves to the next event after the current time, or to the previous one. */
function stepEvent(forward) {
  play(false);
  const tiny = 1e-9 * Math.max(end, 1e-9);
  if (forward) {
    const e = events.find((one) => one.t > state.t + tiny);
    if (e) seek(e.t);
  } else {
    for (let k = events.length - 1; k >= 0; --k) if (events[k].t < state.t - tiny) return seek(events[k].t);
    seek(begin);
  }
}

/** A number formatted for display. */
function shown(x, digits = 4) {
  if (x === null || x === undefined || Number.isNaN(x)) return '–';
  const size = Math.abs(x);
  if (size !== 0 && (size < 1e-4 || size >= 1e9)) return Number(x.toPrecision(digits)).toExponential();
  return String(Number(x.toPrecision(digits)));
}
