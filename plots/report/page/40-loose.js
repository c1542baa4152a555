// Magnified joints with clearance: the centre of a journal in its clearance circle with its recent
// path, the ends of a slider or the pin of a slot between their walls.

/** Position within the clearance: (ex, ey)/c of a journal, else positions across, −1 to 1. */
function playAt(joint, at) {
  const v = joint.columns.map((column) => between(column, at));
  if (joint.kind === 'journal') {
    const c = joint.clearance;
    return { x: v[0] / c, y: v[1] / c, gap: v[2] };
  }
  const ends = [];
  for (let k = 0; k + 1 < v.length; k += 2) ends.push((v[k] - v[k + 1]) / (v[k] + v[k + 1]));
  return { ends, gap: Math.min(...v) };
}
for (const run of runs)
  for (const joint of run.motion.loose) {
    const first = joint.columns.map((column) => column[0]);
    joint.clearance = joint.kind === 'journal' ? first[2] + Math.hypot(first[0], first[1]) : 0.5 * (first[0] + first[1]);
  }

const mostLoose = 12;
const looseNames = [...new Set(runs.flatMap((run) => run.motion.loose.map((j) => j.name)))];

function drawJournal(c, joint, run, at, r, size, middle) {
  const to = (p) => [middle[0] + size * p.x, middle[1] - size * p.y];
  const back = Math.max(0, at.i - 200), path = [];
  for (let i = back; i <= at.i; ++i) path.push(to(playAt(joint, { i, part: 0 })));
  const now = playAt(joint, at);
  path.push(to(now));
  c.strokeStyle = c.fillStyle = runColour(r);
  c.lineWidth = 1;
  c.globalAlpha = 0.55;
  line(c, path);
  c.stroke();
  c.globalAlpha = 1;
  const [x, y] = to(now);
  c.beginPath();
  c.arc(x, y, 5, 0, 2 * Math.PI);
  c.fill();
  const force = run.motion.arrows.find((a) => a.name === joint.name);
  if (state.arrows && force && run.force > 0) {
    const unit = 0.6 * size / run.force;
    c.strokeStyle = colours.force;
    c.lineWidth = 2;
    arrow(c, x, y, unit * between(force.columns[0], at), -unit * between(force.columns[1], at), 1.2 * size);
  }
}

function drawBetweenWalls(c, joint, at, r, size, middle, width) {
  const { ends } = playAt(joint, at), half = 0.3 * width, reach = 0.62 * size;
  c.strokeStyle = c.fillStyle = runColour(r);
  c.lineWidth = 6;
  c.globalAlpha = 0.75;
  if (ends.length > 1) {
    line(c, [[middle[0] - half, middle[1] - reach * ends[0]], [middle[0] + half, middle[1] - reach * ends[1]]]);
    c.stroke();
  } else {
    c.beginPath();
    c.arc(middle[0], middle[1] - reach * ends[0], 7, 0, 2 * Math.PI);
    c.fill();
  }
  c.globalAlpha = 1;
}

function drawLoose(canvas, name, list) {
  const { c, width, height } = paper(canvas);
  const size = 0.4 * Math.min(width, height), middle = [0.5 * width, 0.5 * height];
  const jointOf = (run) => run.motion.loose.find((j) => j.name === name);
  const walls = runs.some((run) => jointOf(run) && jointOf(run).kind !== 'journal');
  c.strokeStyle = colours.ink;
  c.lineWidth = 1.5;
  c.beginPath();
  if (walls) {
    for (const side of [-1, 1]) {
      c.moveTo(0.08 * width, middle[1] + side * 0.72 * size);
      c.lineTo(0.92 * width, middle[1] + side * 0.72 * size);
    }
  } else {
    c.arc(middle[0], middle[1], size, 0, 2 * Math.PI);
    c.moveTo(middle[0] - 4, middle[1]); c.lineTo(middle[0] + 4, middle[1]);
    c.moveTo(middle[0], middle[1] - 4); c.lineTo(middle[0], middle[1] + 4);
  }
  c.stroke();
  for (const r of list) {
    const run = runs[r], joint = jointOf(run), at = frame(run, state.t);
    if (!joint) continue;
    if (joint.kind === 'journal') drawJournal(c, joint, run, at, r, size, middle);
    else drawBetweenWalls(c, joint, at, r, size, middle, width);
  }
}

/** Adds the figures of the joints with clearance to the page and registers their drawing. */
function makeLoose(parent) {
  const canvases = looseNames.slice(0, mostLoose).map((name) => {
    const figure = element('figure', 'play'), canvas = element('canvas');
    const joint = runs.flatMap((run) => run.motion.loose).find((j) => j.name === name);
    figure.append(canvas, element('figcaption', '', `${name}: ${joint.kind === 'journal' ? 'clearance circle' : joint.kind}, c = ${shown(1e3 * joint.clearance)} mm`));
    parent.append(figure);
    return { canvas, name };
  });
  if (looseNames.length > mostLoose)
    parent.append(element('p', 'small', `${mostLoose} of ${looseNames.length} joints with clearance are shown`));
  watch(() => {
    const list = runs.map((_, r) => r);
    for (const { canvas, name } of canvases) drawLoose(canvas, name, list);
  });
}
