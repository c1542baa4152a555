// Bodies that touch without load: columns, rows and grids.
#include "verification/random_scenes/builder.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Half a diameter of a whole number of 0.1 mm, so that places along a line are short decimals.
double short_radius(Draw& draw) { return exact(draw.whole(5, 500) * 1e-4); }

void discs(Builder& b, std::size_t i, std::size_t j, double Ri, double Rj) {
  b.table(fmt::format("contacts.c{}_{}", i, j),
          fmt::format("type = \"discs\"\nbetween = [\"d{}\", \"d{}\"]\nradii = [{}, {}]\nsurface = \"s\"\n",
                      i, j, text_of(Ri), text_of(Rj)));
}

void finish_row(Builder& b, Row row, double speed, double duration, const std::vector<double>& K) {
  row.row.stiffness = K;
  b.scene.speed = speed;
  b.given = true;
  b.longest = 4000;
  b.finish(duration);
  row.compliant_step = std::min(b.contact / 150, b.scene.shortest / 100);
  const auto& r = row.row;
  const std::size_t n = r.mass.size();
  for (std::size_t i = 0; i < n; ++i) {
    b.still(3 * i + 1 - row.along, 0, r.reach[i]);
    b.still(3 * i + 2, 0, 1);
  }
  if (r.restitution == 1) {
    b.scene.energy = [r, n, along = row.along](Coordinates q, Coordinates v) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i)
        sum += r.mass[i] * (0.5 * v[3 * i + along] * v[3 * i + along] + r.gravity * q[3 * i + along]);
      return sum;
    };
    b.scene.energy_of_rigid_only = true;
  }
  b.scene.row = std::move(row);
}

}  // namespace

void touching_column(Builder& b) {
  auto& draw = b.draw;
  const auto n = static_cast<std::size_t>(draw.whole(2, 7));
  const double R = short_radius(draw), g = exact(draw.chance(0.7) ? 9.81 : draw.decades(-1, 2));
  const double drop = exact(R * draw.whole(1, 50) * 0.1), speed = std::sqrt(2 * g * drop);
  const double e = exact(draw.chance(0.5) ? 1 : draw.between(0.3, 0.95));
  b.flight = std::sqrt(2 * drop / g);
  Row row;
  row.row.floor = true;
  row.row.gravity = g;
  row.row.restitution = e;
  b.gravity(g);
  const bool alike = draw.chance(0.5);
  const double mass = exact(draw.decades(-2, 1));
  const double K = b.surface(e, mass, speed, R, std::min(0.05 * b.flight, 0.03 * R / speed));
  std::vector<double> stiffness;
  for (std::size_t i = 0; i < n; ++i) {
    const double m = alike ? mass : exact(mass * draw.decades(-0.7, 0.7));
    const double y = exact(drop + R + 2 * R * static_cast<double>(i));
    b.body(fmt::format("d{}", i), {.mass = m, .inertia = exact(0.5 * m * R * R), .y = y});
    row.row.mass.push_back(m);
    row.row.x.push_back(y);
    row.row.v.push_back(0);
    row.row.reach.push_back(R);
    if (i == 0)
      b.table("contacts.floor",
              fmt::format("type = \"plane\"\nbetween = [\"ground\", \"d0\"]\nradius = {}\nsurface = \"s\"\n",
                          text_of(R)));
    else
      discs(b, i - 1, i, R, R);
    stiffness.push_back(i == 0 ? K : K * std::sqrt(0.5));
  }
  row.row.closed = 1e-11 * static_cast<double>(n) * R;
  row.along = 1;
  finish_row(b, row, speed, b.flight * draw.between(2, 8), stiffness);
}

void touching_row(Builder& b) {
  auto& draw = b.draw;
  const auto n = static_cast<std::size_t>(draw.whole(3, 8));
  const bool blocks = draw.chance(0.4);
  const double R = short_radius(draw), speed = exact(R * draw.decades(0, 2)),
               e = exact(draw.chance(0.5) ? 1 : draw.between(0, 0.95));
  if (e <= 0.05) b.scene.penalty = false;
  const double gap = exact(R * draw.whole(1, 100) * 0.1), mass = exact(draw.decades(-2, 1));
  b.flight = gap / speed;
  Row row;
  row.row.restitution = e;
  row.along = 0;
  const double K = b.surface(std::max(e, 0.05), mass, speed, R, std::min(0.05 * b.flight, 0.03 * R / speed));
  (void)K;
  row.row.restitution = std::max(e, 0.05);
  const bool alike = draw.chance(0.5), last_free = draw.chance(0.3);
  std::vector<double> stiffness;
  double x = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double m = alike ? mass : exact(mass * draw.decades(-0.7, 0.7));
    if (i > 0) x = exact(x + 2 * R + (i == 1 || (last_free && i + 1 == n) ? gap : 0));
    const double v = i == 0 ? speed : 0;
    b.body(fmt::format("d{}", i), {.mass = m, .inertia = exact(0.5 * m * R * R), .x = x, .vx = v});
    row.row.mass.push_back(m);
    row.row.x.push_back(x);
    row.row.v.push_back(v);
    row.row.reach.push_back(R);
    if (i == 0) continue;
    if (blocks) {  // a face of each against a rounded nose of the next; the face is on the right of its body
      b.table(
          fmt::format("contacts.c{}_{}", i - 1, i),
          fmt::format(
              "type = \"plane\"\nbetween = [\"d{}\", \"d{}\"]\nat = [[{}, 0], [0, 0]]\naxis = [0, -1]\nradius = {}\nsurface = \"s\"\n",
              i - 1, i, text_of(R), text_of(R)));
      stiffness.push_back(K);
    } else {
      discs(b, i - 1, i, R, R);
      stiffness.push_back(K * std::sqrt(0.5));
    }
  }
  row.row.closed = 1e-11 * static_cast<double>(n) * R;
  finish_row(b, row, speed, b.flight * draw.between(2, 20), stiffness);
}

void touching_grid(Builder& b) {
  auto& draw = b.draw;
  const int columns = draw.whole(2, 4), lines = draw.whole(2, 3);
  const double R = short_radius(draw), speed = exact(R * draw.decades(0, 2)),
               e = exact(draw.chance(0.5) ? 1 : draw.between(0.2, 0.95));
  const double gap = exact(R * draw.whole(1, 100) * 0.1), m = exact(draw.decades(-2, 1));
  b.flight = gap / speed;
  b.scene.speed = speed;
  b.surface(e, m, speed, R, std::min(0.05 * b.flight, 0.03 * R / speed));
  std::size_t n = 0;
  for (int row = 0; row < lines; ++row)
    for (int column = 0; column < columns; ++column)
      b.body(fmt::format("d{}", n++), {.mass = m,
                                       .inertia = exact(0.5 * m * R * R),
                                       .x = exact(2 * R * column),
                                       .y = exact(2 * R * row)});
  // The one that comes meets the first disc along a row, off its middle by a share of the radius.
  const double off = draw.chance(0.5) ? 0 : exact(R * draw.between(-1, 1));
  b.body(fmt::format("d{}", n),
         {.mass = m, .inertia = exact(0.5 * m * R * R), .x = exact(-2 * R - gap), .y = off, .vx = speed});
  for (int i = 0; i < static_cast<int>(n); ++i)
    for (int j = i + 1; j < static_cast<int>(n); ++j)
      if (const int dx = std::abs(i % columns - j % columns), dy = std::abs(i / columns - j / columns);
          dx + dy == 1)
        discs(b, static_cast<std::size_t>(i), static_cast<std::size_t>(j), R, R);
  for (int row = 0; row < lines; ++row) discs(b, static_cast<std::size_t>(row * columns), n, R, R);
  for (std::size_t i = 0; i <= n; ++i) {
    b.scene.others.push_back(3 * i);
    b.scene.others.push_back(3 * i + 1);
    b.still(3 * i + 2, 0, 1);
  }
  b.scene.prescribed.clear();
  for (std::size_t i = 0; i <= n; ++i) b.still(3 * i + 2, 0, 1);
  if (e == 1) {
    b.scene.energy = [m, n](Coordinates, Coordinates v) {
      double sum = 0;
      for (std::size_t i = 0; i <= n; ++i)
        sum += 0.5 * m * (v[3 * i] * v[3 * i] + v[3 * i + 1] * v[3 * i + 1]);
      return sum;
    };
    b.scene.energy_of_rigid_only = true;
  }
  b.given = true;
  b.longest = 4000;
  b.finish(b.flight * draw.between(2, 10));
}

}  // namespace freeplay::verification::random_scenes
