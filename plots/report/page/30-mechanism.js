// The mechanism at the current time, to scale: shapes in the frames of their bodies, moved by the
// frames of a run.

/** Pose of a body: x, y, cos, sin; that of the ground is constant. */
function poseOf(run, body, at) {
  if (body < 0) return { x: 0, y: 0, c: 1, s: 0 };
  const p = run.motion.poses, angle = between(p[3 * body + 2], at);
  return { x: between(p[3 * body], at), y: between(p[3 * body + 1], at), c: Math.cos(angle), s: Math.sin(angle) };
}
const placed = (pose, x, y) => [pose.x + pose.c * x - pose.s * y, pose.y + pose.s * x + pose.c * y];
const turned = (pose, x, y) => [pose.c * x - pose.s * y, pose.s * x + pose.c * y];

/** Kinds of shapes of several points; those of a bearing and a journal have places on the nominal circle, too. */
const surfaces = ['bearing', 'journal'], outlines = ['link', 'outline', ...surfaces];

/** Shapes of a run, in its order. The points of a shape of several points are collected in one shape. */
function gather(run) {
  const list = [];
  for (const [kind, name, body, x, y, other, a, b] of run.motion.shapes) {
    const before = last(list);
    if (outlines.includes(kind) && before && before.kind === kind && before.name === name && before.body === body) {
      before.points.push([x, y]);
      before.nominal.push([a, b]);
    } else list.push({ kind, name, body, x, y, other, a, b, points: [[x, y]], nominal: [[a, b]] });
  }
  if (!list.length) run.motion.bodies.forEach((name, body) => list.push({ kind: 'mass', name, body, x: 0, y: 0, other: -1, a: 0, b: 0, points: [[0, 0]] }));
  return list;
}
for (const run of runs) run.shapes = gather(run);
/** What the selected factor magnifies; empty: nothing. */
const magnifiedParts = [runs.some((run) => run.motion.beams.length) ? 'deflection' : '',
  runs.some((run) => run.shapes.some((s) => surfaces.includes(s.kind))) ? 'clearance and deviations' : ''].filter(Boolean).join(', ');

/** Points of the line of a beam in a pose with its deflection magnified (io/scene/beam_line.hpp). */
function beamLine(beam, pose, magnify) {
  const points = beam.points.map(([i, x, y, j, u, v, share]) => {
    const p = placed(pose(i), x, y), q = placed(pose(j), u, v);
    return [(1 - share) * p[0] + share * q[0], (1 - share) * p[1] + share * q[1]];
  });
  const [x0, y0] = points[0], dx = last(points)[0] - x0, dy = last(points)[1] - y0;
  return points.map(([x, y], k) => {
    const [u, v] = beam.points[k].slice(7), cx = x0 + u * dx - v * dy, cy = y0 + u * dy + v * dx;
    return [cx + magnify * (x - cx), cy + magnify * (y - cy)];
  });
}

/** Points of a bearing or journal with clearance and deviations magnified (io/scene/bearing_line.hpp). */
function surfaceLine(run, s, pose, magnify) {
  const at = ([x, y]) => placed(pose(s.body), x, y);
  const joint = run.shapes.find((shape) => shape.kind === 'loose' && shape.name === s.name);
  if (!joint) return s.points.map(at);
  const nominal = s.nominal.map(at), count = nominal.length - 1, [bx, by] = placed(pose(joint.body), joint.x, joint.y);
  const middle = (k) => nominal.slice(0, count).reduce((sum, p) => sum + p[k], 0) / count;
  const dx = (magnify - 1) * (middle(0) - bx), dy = (magnify - 1) * (middle(1) - by);
  return s.points.map(at).map(([x, y], k) => {
    const [u, v] = nominal[k];
    return [u + magnify * (x - u) + dx, v + magnify * (y - v) + dy];
  });
}

/** Bounding box of the shapes of all runs over all frames. */
function bounds() {
  const box = { left: Infinity, right: -Infinity, low: Infinity, high: -Infinity };
  const hold = ([x, y], r) => {
    if (!Number.isFinite(x + y)) return;
    box.left = Math.min(box.left, x - r); box.right = Math.max(box.right, x + r);
    box.low = Math.min(box.low, y - r); box.high = Math.max(box.high, y + r);
  };
  for (const run of runs) {
    const count = run.motion.t.length, each = Math.max(1, Math.floor(count / 150));
    for (let i = 0; i < count; i += each) {
      const poses = run.motion.bodies.map((_, b) => poseOf(run, b, { i, part: 0 }));
      poses[-1] = poseOf(run, -1, { i, part: 0 });
      for (const beam of run.motion.beams) for (const p of beamLine(beam, (body) => poses[body], 1)) hold(p, 0);
      for (const s of run.shapes) {
        const r = s.kind === 'disc' || s.kind === 'loose' ? s.a : 0;
        const points = s.points.length > 20 ? s.points.filter((_, k) => k % 15 === 0) : s.points;
        for (const [x, y] of points) hold(placed(poses[s.body], x, y), r);
        if (s.kind === 'spring' || s.kind === 'line') hold(placed(poses[s.other], s.a, s.b), 0);
      }
    }
  }
  if (!Number.isFinite(box.left)) Object.assign(box, { left: -1, right: 1, low: -1, high: 1 });
  const size = Math.max(box.right - box.left, box.high - box.low, 1e-9);
  const pad = 0.08 * size;
  box.left -= pad; box.right += pad; box.low -= pad; box.high += pad;
  return box;
}
const box = runs.length ? bounds() : null;

/** Map from metres to the pixels of a canvas. */
function scaleOf(width, height) {
  const k = Math.min(width / (box.right - box.left), height / (box.high - box.low)) * state.view.zoom;
  const x0 = 0.5 * (box.left + box.right) + state.view.x, y0 = 0.5 * (box.low + box.high) + state.view.y;
  return { k, at: ([x, y]) => [0.5 * width + k * (x - x0), 0.5 * height - k * (y - y0)] };
}

function hatch(c, x, y, dx, dy, length, u) {
  const strokes = Math.min(60, Math.max(4, Math.round(length / (0.8 * u))));
  c.beginPath();
  for (let i = 0; i <= strokes; ++i) {
    const s = length * (i / strokes - 0.5), px = x + s * dx, py = y + s * dy;
    c.moveTo(px, py);
    c.lineTo(px - 0.5 * u * (dx + dy), py - 0.5 * u * (dy - dx));
  }
  c.stroke();
}

const painters = {
  link(c, s, to, pose, colour) {
    const points = s.points.map(([x, y]) => to.at(placed(pose(s.body), x, y)));
    c.lineWidth = 5;
    c.strokeStyle = colour(s.body);
    line(c, points);
    if (points.length > 3) { c.globalAlpha *= 0.15; c.fillStyle = colour(s.body); c.fill(); c.globalAlpha /= 0.15; }
    c.stroke();
  },
  outline(c, s, to, pose, colour) {
    line(c, s.points.map(([x, y]) => to.at(placed(pose(s.body), x, y))), true);
    c.lineWidth = 2;
    c.strokeStyle = colour(s.body);
    c.stroke();
  },
  bearing(c, s, to, pose, colour, run) { surface(c, s, to, pose, run, colours.accent); },
  journal(c, s, to, pose, colour, run) { surface(c, s, to, pose, run, colours.ink); },
  disc(c, s, to, pose, colour) {
    const p = pose(s.body), [x, y] = to.at(placed(p, s.x, s.y)), r = Math.max(2, s.a * to.k);
    c.lineWidth = 1.5;
    c.strokeStyle = colour(s.body);
    c.beginPath();
    c.arc(x, y, r, 0, 2 * Math.PI);
    c.moveTo(x, y);
    c.lineTo(x + r * p.c, y - r * p.s);
    c.stroke();
  },
  line(c, s, to, pose, colour) {
    c.lineWidth = 2;
    c.strokeStyle = colour(s.body);
    line(c, [to.at(placed(pose(s.body), s.x, s.y)), to.at(placed(pose(s.other), s.a, s.b))]);
    c.stroke();
  },
  wall(c, s, to, pose) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y)), [a, b] = turned(pose(s.other), s.a, s.b), l = 2000;
    c.lineWidth = 1.5;
    c.strokeStyle = colours.soft;
    line(c, [[x - l * a, y + l * b], [x + l * a, y - l * b]]);
    c.stroke();
    hatch(c, x, y, a, -b, 600, 12);
  },
  slider(c, s, to, pose, colour) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y)), [a, b] = turned(pose(s.other), s.a, s.b);
    const at = (u, v) => [x + u * a - v * b, y - u * b - v * a];
    c.lineWidth = 1;
    c.strokeStyle = colours.soft;
    for (const side of [-10, 10]) { line(c, [at(-42, side), at(42, side)]); c.stroke(); }
    c.fillStyle = colours.card;
    c.strokeStyle = colour(s.body);
    c.lineWidth = 2.5;
    line(c, [at(-16, -9), at(16, -9), at(16, 9), at(-16, 9)], true);
    c.fill();
    c.stroke();
  },
  spring(c, s, to, pose) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y)), [u, v] = to.at(placed(pose(s.other), s.a, s.b));
    const length = Math.hypot(u - x, v - y) || 1, nx = -(v - y) / length, ny = (u - x) / length, points = [];
    for (let i = 0; i <= 16; ++i) {
      const across = i < 2 || i > 14 ? 0 : (i % 2 ? 6 : -6), part = i / 16;
      points.push([x + part * (u - x) + across * nx, y + part * (v - y) + across * ny]);
    }
    c.lineWidth = 1.5;
    c.strokeStyle = colours.soft;
    line(c, points);
    c.stroke();
  },
  support(c, s, to, pose) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y));
    c.lineWidth = 1.2;
    c.strokeStyle = colours.soft;
    line(c, [[x, y], [x - 8, y + 14], [x + 8, y + 14]], true);
    c.stroke();
    hatch(c, x, y + 14, 1, 0, 24, 7);
  },
  pin(c, s, to, pose, colour) { ring(c, to.at(placed(pose(s.body), s.x, s.y)), 5, colours.ink); },
  loose(c, s, to, pose) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y)), r = Math.max(7, s.a * to.k);
    c.setLineDash([3, 3]);
    ring(c, [x, y], r, colours.accent);
    c.setLineDash([]);
    ring(c, [x, y], 2.5, colours.ink);
  },
  weld(c, s, to, pose) { const [x, y] = to.at(placed(pose(s.body), s.x, s.y)); c.fillStyle = colours.ink; c.fillRect(x - 4, y - 4, 8, 8); },
  joint(c, s, to, pose) { ring(c, to.at(placed(pose(s.body), s.x, s.y)), 3, colours.ink); },
  mass(c, s, to, pose, colour) {
    const [x, y] = to.at(placed(pose(s.body), s.x, s.y));
    c.fillStyle = colour(s.body);
    c.beginPath();
    c.arc(x, y, 2.5, 0, 2 * Math.PI);
    c.fill();
    if (state.names) { c.fillStyle = colours.ink; label(c, s.name, x + 7, y - 7); }
  },
};
const order = ['wall', 'support', 'outline', 'line', 'disc', 'link', 'spring', 'slider', 'weld', 'joint', 'pin', 'loose', ...surfaces, 'mass'];

function surface(c, s, to, pose, run, colour) {
  line(c, surfaceLine(run, s, pose, state.magnify).map(to.at), true);
  c.lineWidth = 1.5;
  c.strokeStyle = colour;
  c.stroke();
}

function drawBeam(c, beam, to, pose, colour, named) {
  const points = beamLine(beam, pose, state.magnify).map(to.at), [x, y] = points[points.length >> 1];
  c.lineWidth = 5;
  c.strokeStyle = colour(beam.points[0][3]);
  line(c, points);
  c.stroke();
  if (named && state.names) { c.fillStyle = colours.ink; label(c, beam.name, x + 7, y - 7); }
}

function ring(c, [x, y], r, colour) {
  c.lineWidth = 1.8;
  c.strokeStyle = colour;
  c.fillStyle = colours.card;
  c.beginPath();
  c.arc(x, y, r, 0, 2 * Math.PI);
  if (r < 6) c.fill();
  c.stroke();
}

/** The shapes at which a force acts: the guide for its corners, both of two discs, none of many. */
function shapesOf(run, name) {
  const named = (n) => {
    const list = run.shapes.filter((s) => s.name === n && order.includes(s.kind) && !['mass', 'support', ...outlines].includes(s.kind));
    const other = list.find((s) => s.kind !== 'disc');
    return other ? [other] : list.length <= 2 ? list : [];
  };
  const found = named(name);
  return found.length ? found : named(name.slice(0, name.lastIndexOf('.')));
}
/** Point of action: nearest point of two discs, middle of a face, else the point of the shape. */
function actsAt(list, pose) {
  const [s, other] = list, p = placed(pose(s.body), s.x, s.y);
  if (s.kind === 'line') { const q = placed(pose(s.other), s.a, s.b); return [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]; }
  if (!other) return p;
  const q = placed(pose(other.body), other.x, other.y), d = Math.hypot(q[0] - p[0], q[1] - p[1]);
  if (!d) return p;
  const [from, r, sign] = s.a >= other.a ? [p, s.a, 1] : [q, other.a, -1];
  return [from[0] + sign * r * (q[0] - p[0]) / d, from[1] + sign * r * (q[1] - p[1]) / d];
}
for (const run of runs) {
  // Arrows are scaled by the force that 1 in 50 values exceed, so that single peaks do not shorten
  // all others.
  const sizes = [];
  for (const a of run.motion.arrows) {
    a.shapes = shapesOf(run, a.name);
    a.columns[0].forEach((fx, i) => { const f = Math.hypot(fx, a.columns[1][i]); if (f > 0) sizes.push(f); });
  }
  sizes.sort((a, b) => a - b);
  run.force = sizes[Math.floor(0.98 * (sizes.length - 1))] || 0;
}

function drawForces(c, run, to, pose, at) {
  c.strokeStyle = colours.force;
  c.lineWidth = 2;
  const unit = 90 / Math.max(...runs.map((r) => r.force), 1e-300);
  for (const a of run.motion.arrows) {
    if (!a.shapes.length) continue;
    const [x, y] = to.at(actsAt(a.shapes, pose));
    arrow(c, x, y, unit * between(a.columns[0], at), -unit * between(a.columns[1], at), 160);
  }
  // An impulse has no finite force; a ring marks it for 1/50 s of screen time.
  const reach = Math.max(0.02 * state.rate, 1e-6 * end);
  const e = run.events;
  for (let i = before(e.t, state.t + reach); i >= 0 && e.t[i] >= state.t - reach; --i) {
    if (e.kinds[e.kind[i]] === 'separation') continue;
    const shapes = shapesOf(run, e.joints[e.joint[i]]);
    if (shapes.length) ring(c, to.at(actsAt(shapes, pose)), 14, colours.force);
  }
}

/** Draws several runs into one canvas, each over the previous ones. */
function drawMechanism(canvas, list) {
  const { c, width, height } = paper(canvas);
  const to = scaleOf(width, height);
  list.forEach((r, k) => {
    const run = runs[r], at = frame(run, state.t), poses = new Map();
    const pose = (body) => {
      if (!poses.has(body)) poses.set(body, poseOf(run, body, at));
      return poses.get(body);
    };
    const colour = list.length > 1 ? () => runColour(r) : (body) => (body < 0 ? colours.soft : bodyColour(body));
    c.globalAlpha = k > 0 ? 0.65 : 1;
    for (const kind of order) {
      for (const s of run.shapes) if (s.kind === kind && (k === 0 || kind !== 'mass')) painters[kind](c, s, to, pose, colour, run);
      if (kind === 'link') for (const beam of run.motion.beams) drawBeam(c, beam, to, pose, colour, k === 0);
    }
    if (state.arrows) drawForces(c, run, to, pose, at);
    c.globalAlpha = 1;
  });
  if (state.magnify !== 1) { c.fillStyle = colours.soft; c.fillText(`${magnifiedParts} × ${state.magnify}`, 12, 18); }
  // Scale bar: a round length of about a fifth of the width.
  const length = ticks(0, 0.25 * width / to.k, 1)[1] || ticks(0, 0.25 * width / to.k, 2)[1];
  if (length) {
    c.strokeStyle = c.fillStyle = colours.soft;
    c.lineWidth = 1.5;
    line(c, [[12, height - 10], [12 + length * to.k, height - 10]]);
    c.stroke();
    c.fillText(length >= 1 ? shown(length) + ' m' : shown(1e3 * length) + ' mm', 12, height - 16);
  }
}
