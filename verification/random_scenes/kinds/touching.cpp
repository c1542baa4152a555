// Bodies that touch without load: columns, rows and grids.
#include <algorithm>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Half a diameter of a whole number of 0.1 mm, so that positions along a line are short decimals.
double short_radius(Draw& draw) { return exact(draw.whole(5, 500) * 1e-4); }

void disc(Draft& out, std::size_t i, double mass, double R, Vec2 at, Vec2 velocity = {0, 0}) {
  out.body({.name = toml("d{}", i),
            .mass = mass,
            .inertia = exact(0.5 * mass * R * R),
            .at = at,
            .velocity = velocity});
}
void discs(Draft& out, std::size_t i, std::size_t j, double R) {
  out.table(toml("contacts.c{}_{}", i, j),
            toml("type = 'discs'\nbetween = ['d{}', 'd{}']\nradii = [{}, {}]\nsurface = 's'\n", i, j, R, R));
}

/// Adds a disc or block to the line, with this position and velocity along it.
void add(Draft& out, BodiesInLine& line, double mass, double R, double place, double rate) {
  auto& r = line.row;
  const auto along = [&](double x) { return line.along ? Vec2{0, x} : Vec2{x, 0}; };
  disc(out, r.mass.size(), mass, R, along(place), along(rate));
  r.mass.push_back(mass), r.reach.push_back(R);
  r.x.push_back(place), r.v.push_back(rate);
}

void finish_row(Draft& out, BodiesInLine row, double speed, double duration, const std::vector<double>& K) {
  row.row.stiffness = K;
  row.row.closed = 1e-11 * static_cast<double>(row.row.mass.size()) * row.row.reach[0];
  out.scene.speed = speed;
  out.given = true;
  out.longest = 4000;
  out.finish(duration);
  row.compliant_step = std::min(out.contact / 150, out.scene.shortest / 100);
  const auto& r = row.row;
  const std::size_t n = r.mass.size();
  for (std::size_t i = 0; i < n; ++i) {
    out.still(3 * i + 1 - row.along, 0, r.reach[i]);
    out.still(3 * i + 2, 0, 1);
  }
  if (r.restitution == 1) {
    out.scene.energy = [r, n, along = row.along](Coordinates q, Coordinates v) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i)
        sum += r.mass[i] * (0.5 * v[3 * i + along] * v[3 * i + along] + r.gravity * q[3 * i + along]);
      return sum;
    };
    out.scene.energy_of_rigid_only = true;
  }
  out.scene.line = std::move(row);
}

}  // namespace

void touching_column(Draw& draw, Draft& out) {
  const auto n = static_cast<std::size_t>(draw.whole(2, 7));
  const double R = short_radius(draw), g = exact(draw.chance(0.7) ? 9.81 : draw.decades(-1, 2));
  const double drop = exact(R * draw.whole(1, 50) * 0.1), speed = std::sqrt(2 * g * drop);
  const double e = exact(draw.chance(0.5) ? 1 : draw.between(0.3, 0.95));
  out.flight = std::sqrt(2 * drop / g);
  BodiesInLine row;
  row.row.floor = true;
  row.row.gravity = g;
  row.row.restitution = e;
  out.gravity({0, -g});
  const bool alike = draw.chance(0.5);
  const double mass = exact(draw.decades(-2, 1));
  const double K = out.surface(e, mass, speed, R, std::min(0.05 * out.flight, 0.03 * R / speed));
  std::vector<double> stiffness;
  for (std::size_t i = 0; i < n; ++i) {
    const double m = alike ? mass : exact(mass * draw.decades(-0.7, 0.7));
    add(out, row, m, R, exact(drop + R + 2 * R * static_cast<double>(i)), 0);
    if (i == 0)
      out.table("contacts.floor",
                toml("type = 'plane'\nbetween = ['ground', 'd0']\nradius = {}\nsurface = 's'\n", R));
    else
      discs(out, i - 1, i, R);
    stiffness.push_back(i == 0 ? K : K * std::sqrt(0.5));
  }
  finish_row(out, row, speed, out.flight * draw.between(2, 8), stiffness);
}

void touching_row(Draw& draw, Draft& out) {
  const auto n = static_cast<std::size_t>(draw.whole(3, 8));
  const bool blocks = draw.chance(0.4);
  const double R = short_radius(draw), speed = exact(R * draw.decades(0, 2)),
               e = exact(draw.chance(0.5) ? 1 : draw.between(0, 0.95));
  if (e <= 0.05) out.scene.penalty = false;
  const double gap = exact(R * draw.whole(1, 100) * 0.1), mass = exact(draw.decades(-2, 1));
  out.flight = gap / speed;
  BodiesInLine row;
  row.along = 0;
  row.row.restitution = std::max(e, 0.05);
  const double K =
      out.surface(row.row.restitution, mass, speed, R, std::min(0.05 * out.flight, 0.03 * R / speed));
  const bool alike = draw.chance(0.5), last_free = draw.chance(0.3);
  std::vector<double> stiffness;
  double x = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double m = alike ? mass : exact(mass * draw.decades(-0.7, 0.7));
    if (i > 0) x = exact(x + 2 * R + (i == 1 || (last_free && i + 1 == n) ? gap : 0));
    add(out, row, m, R, x, i == 0 ? speed : 0);
    if (i == 0) continue;
    // a face of each against a rounded nose of the next; the face is on the right of its body
    if (blocks) {
      out.table(toml("contacts.c{}_{}", i - 1, i),
                toml("type = 'plane'\nbetween = ['d{}', 'd{}']\nat = [[{}, 0], [0, 0]]\naxis = [0, -1]\n"
                     "radius = {}\nsurface = 's'\n",
                     i - 1, i, R, R));
      stiffness.push_back(K);
    } else {
      discs(out, i - 1, i, R);
      stiffness.push_back(K * std::sqrt(0.5));
    }
  }
  finish_row(out, row, speed, out.flight * draw.between(2, 20), stiffness);
}

void touching_grid(Draw& draw, Draft& out) {
  const int columns = draw.whole(2, 4), lines = draw.whole(2, 3);
  const double R = short_radius(draw), speed = exact(R * draw.decades(0, 2)),
               e = exact(draw.chance(0.5) ? 1 : draw.between(0.2, 0.95));
  const double gap = exact(R * draw.whole(1, 100) * 0.1), m = exact(draw.decades(-2, 1));
  out.flight = gap / speed;
  out.scene.speed = speed;
  out.surface(e, m, speed, R, std::min(0.05 * out.flight, 0.03 * R / speed));
  std::size_t n = 0;
  for (int row = 0; row < lines; ++row)
    for (int column = 0; column < columns; ++column)
      disc(out, n++, m, R, {exact(2 * R * column), exact(2 * R * row)});
  // The arriving disc hits the first one along a row, off its centre line by a fraction of the
  // radius.
  const double off = draw.chance(0.5) ? 0 : exact(R * draw.between(-1, 1));
  disc(out, n, m, R, {exact(-2 * R - gap), off}, {speed, 0});
  for (int i = 0; i < static_cast<int>(n); ++i)
    for (int j = i + 1; j < static_cast<int>(n); ++j)
      if (const int dx = std::abs(i % columns - j % columns), dy = std::abs(i / columns - j / columns);
          dx + dy == 1)
        discs(out, static_cast<std::size_t>(i), static_cast<std::size_t>(j), R);
  for (int row = 0; row < lines; ++row) discs(out, static_cast<std::size_t>(row * columns), n, R);
  for (std::size_t i = 0; i <= n; ++i) {
    out.scene.others.push_back(3 * i);
    out.scene.others.push_back(3 * i + 1);
    out.still(3 * i + 2, 0, 1);
  }
  if (e == 1) {
    out.scene.energy = [m, n](Coordinates, Coordinates v) {
      double sum = 0;
      for (std::size_t i = 0; i <= n; ++i)
        sum += 0.5 * m * (v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1]);
      return sum;
    };
    out.scene.energy_of_rigid_only = true;
  }
  out.given = true;
  out.longest = 4000;
  out.finish(out.flight * draw.between(2, 10));
}

}  // namespace freeplay::verification::random_scenes
