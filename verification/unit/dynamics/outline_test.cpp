// Contacts with convex outlines against geometry: gaps against samples of the boundary, contact rows against
// finite differences, bounds of the gap against samples of motions, kinks at the ends of edges, and refused
// outlines.
#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/contact_rows.hpp"

using namespace freeplay;

namespace {

constexpr double s = 1e-5;

struct Outline {
  std::vector<Vec2> points;
  double corner_radius = 0, radius = 0;
  Vec2 origin{0.1, -0.2}, centre{0.3, 0.15};  // on the first and the second body

  std::string keys() const {
    std::string list;
    for (const auto& p : points)
      list += fmt::format("{}[{:.17g}, {:.17g}]", list.empty() ? "" : ", ", p.x(), p.y());
    return fmt::format("points = [{}]\ncorner_radius = {:.17g}\nradius = {:.17g}\n", list, corner_radius,
                       radius);
  }
};

/// Two to seven points of an ellipse, with sharp or rounded corners.
Outline some_outline(test::Uniform& random, int which) {
  Outline o;
  const double first = random(0, 1), a = random(0.8, 1.6), b = random(0.8, 1.6);
  const int count = which % 3 == 0 ? 2 : 3 + which % 5;
  for (int k = 0; k < count; ++k) {
    const double angle = first + 2 * M_PI * (k + random(0, 0.3)) / count;
    o.points.emplace_back(a * std::cos(angle), b * std::sin(angle));
  }
  o.corner_radius = which % 2 == 0 ? 0 : 0.02;
  o.radius = 0.3;
  return o;
}

Scene pair_of(const Outline& o, const std::string& bodies = "\"plate\", \"disc\"") {
  return parse_scene(test::body("plate", 1, 1) + test::body("disc", 1, 1, "position = [0.0, 9.0]\n") +
                         test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\nfriction = 0.1\n") +
                         "[contacts.side]\ntype = \"outline\"\nbetween = [" + bodies +
                         "]\nat = [[0.1, -0.2], [0.3, 0.15]]\nsurface = \"steel\"\n" + "stiffness = 1e7\n" +
                         o.keys() + test::run_for(1),
                     "outline");
}

/// Positions of both bodies at which the disc's centre is at x of the outline.
std::vector<double> pose(test::Uniform& random, const Outline& o, const Vec2& x) {
  auto q = random.vector(6, 3);
  const Vec2 at = Placement{q.data()}.point(0, o.origin + x);
  q[3] = q[4] = 0;
  const Vec2 arm = Placement{q.data()}.point(1, o.centre);
  q[3] = at.x() - arm.x(), q[4] = at.y() - arm.y();
  return q;
}

/// Samples of the boundary at distances of 1e-3 or less. An arc follows from its corner: its centre is on
/// the bisector of the corner's angle β at r/sin(β/2), and it touches the edges r/tan(β/2) from the corner.
std::vector<Vec2> boundary(const Outline& o) {
  std::vector<Vec2> list;
  const double r = o.corner_radius;
  const auto arc = [&](const Vec2& centre, double from, double to) {
    for (int i = 0; i <= 400; ++i) {
      const double angle = from + (to - from) * i / 400;
      list.push_back(centre + r * Vec2{std::cos(angle), std::sin(angle)});
    }
  };
  const auto line = [&](const Vec2& a, const Vec2& b) {
    for (int i = 0; i <= 4000; ++i) list.push_back(a + (i / 4000.0) * (b - a));
  };
  const auto& p = o.points;
  if (p.size() == 2) {
    const Vec2 u = (p[1] - p[0]).direction(), n = perp(u);
    for (const double side : {1.0, -1.0}) line(p[0] + side * r * n, p[1] + side * r * n);
    arc(p[0], 0, 2 * M_PI), arc(p[1], 0, 2 * M_PI);
    return list;
  }
  const auto count = p.size();
  for (std::size_t k = 0; k < count; ++k) {
    const auto half_angle = [&](std::size_t i) {
      const Vec2 a = p[(i + count - 1) % count] - p[i % count], b = p[(i + 1) % count] - p[i % count];
      return 0.5 * std::acos(dot(a, b) / (a.norm() * b.norm()));
    };
    const Vec2 here = p[k], next = p[(k + 1) % count], before = p[(k + count - 1) % count];
    const Vec2 u = (next - here).direction();
    line(here + r / std::tan(half_angle(k)) * u, next - r / std::tan(half_angle(k + 1)) * u);
    const Vec2 bisector = (u + (before - here).direction()).direction();
    const double open = M_PI / 2 - half_angle(k), out = std::atan2(-bisector.y(), -bisector.x());
    arc(here + r / std::sin(half_angle(k)) * bisector, out - open, out + open);
  }
  return list;
}

/// Whether a point is inside the polygon, by the number of edges to its right.
bool inside(const std::vector<Vec2>& p, const Vec2& x) {
  bool odd = false;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec2 a = p[k], b = p[(k + 1) % p.size()];
    if ((a.y() > x.y()) != (b.y() > x.y()) &&
        x.x() < a.x() + (x.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x()))
      odd = !odd;
  }
  return odd;
}

}  // namespace

TEST_CASE("the gap of an outline is the distance to samples of its boundary", "[outline]") {
  test::Uniform random;
  int outside = 0, within = 0;
  for (int which = 0; which < 30; ++which) {
    const auto o = some_outline(random, which);
    const auto samples = boundary(o);
    const System system(pair_of(o).mechanism);
    auto e = system.make_evaluation();
    for (int trial = 0; trial < 30; ++trial) {
      const Vec2 x{random(-3, 3), random(-3, 3)};
      const auto q = pose(random, o, x);
      system.place(0, q.data(), e);
      double nearest = INFINITY;
      for (const auto& p : samples) nearest = std::min(nearest, (p - x).norm());
      if (nearest < 0.05) continue;  // samples 1e-3 apart: (5e-4)²/(2·0.05) = 2.5e-6
      CAPTURE(which, x.x(), x.y(), o.keys());
      const double gap = system.gap(0, q.data(), e);
      if (o.points.size() > 2 && inside(o.points, x)) {
        CHECK(gap == Approx(-nearest - o.radius).margin(3e-6));
        ++within;
      } else {
        CHECK(gap == Approx(nearest - o.radius).margin(3e-6));
        ++outside;
      }
    }
  }
  CHECK(outside > 300);
  CHECK(within > 30);
}

TEST_CASE("contact rows of outlines agree with finite differences", "[outline]") {
  test::Uniform random;
  int compared = 0, jumps = 0;
  for (int which = 0; which < 24; ++which)
    for (const char* bodies : {"\"plate\", \"disc\"", "\"ground\", \"disc\"", "\"plate\", \"ground\""}) {
      const auto o = some_outline(random, which);
      const System system(pair_of(o, bodies).mechanism);
      for (int trial = 0; trial < 20; ++trial) {
        const auto q = pose(random, o, {random(-2, 2), random(-2, 2)});
        const auto v = random.vector(6);
        CAPTURE(which, bodies, trial, o.keys());
        const test::RowDifferences found(system, 0, q, v, s);
        const auto& row = found.row;
        if (row.gap < -0.5 * o.radius) continue;  // radii of curvature above 0.15
        // Across the ends of edges ġ is continuous; its slope jumps by (t·w)²/D < 6²/0.15.
        if (found.gamma_jump() > 0.05) {
          CHECK(found.rate() == Approx(found.gap_slope()).margin(0.5 * s * 240 + 1e-6));
          ++jumps;
          continue;
        }
        // s²/6 times third derivatives, which are below |w|³/D² = 6³/0.15²
        CHECK(found.rate() == Approx(found.gap_slope()).margin(1e-6));
        CHECK(row.gamma_n == Approx(found.gamma_n()).margin(1e-4));
        CHECK(row.gamma_t == Approx(found.gamma_t()).margin(1e-4));
        ++compared;
        // Neither surface moves along the other.
        if (std::string_view(bodies).find("ground") == std::string_view::npos)
          found.check_common_rotation(q, 0);
      }
    }
  CHECK(compared > 500);
  CHECK(jumps < compared / 20);
}

TEST_CASE("bounds of an outline's gap hold against samples of spinning motions", "[outline]") {
  test::Uniform random;
  int risen = 0, fallen = 0, tight = 0;
  constexpr int cases = 1500;
  for (int which = 0; which < cases; ++which) {
    const auto o = some_outline(random, which);
    const System system(pair_of(o).mechanism);
    const auto q = pose(random, o, {random(-3, 3), random(-3, 3)});
    const auto v = random.vector(6);
    const double h = std::pow(10, random(-2.5, 0));
    CAPTURE(which, h, o.keys());
    const auto found = test::gap_bounds(system, 0, q, v, h, 200);
    CHECK(found.bound <= found.least + 1e-12);  // rounding
    risen += found.rises;
    fallen += found.falls;
    tight += found.least - found.bound < 0.05;
  }
  // The bounds decide short intervals.
  CHECK(risen > cases / 20);
  CHECK(fallen > cases / 20);
  CHECK(tight > cases / 4);
}

TEST_CASE("each edge of an outline has kinks at its ends, a thin face two", "[outline]") {
  Outline o{{{0, 0}, {3, 0}, {3, 1}, {0, 1}}, 0.25, 0.1};
  const System box(pair_of(o).mechanism);
  REQUIRE(box.phases() == 4);
  for (const int k : {0, 1, 2, 3}) {
    // shorter than the sides by the rounded corners
    CHECK(box.phase(k).kinks == std::vector<double>{0, k % 2 == 0 ? 2.5 : 0.5});
    CHECK(box.phase(k).contact);
  }
  o.points = {{0, 0}, {3, 0}};
  CHECK(System(pair_of(o).mechanism).phases() == 1);
}

TEST_CASE("impossible outlines are refused with the reason", "[outline][refused]") {
  const auto said = [](std::vector<Vec2> points, double corner_radius, double radius) {
    return test::refusal_of([&] { pair_of({std::move(points), corner_radius, radius}); });
  };
  using Catch::Matchers::Contains;
  CHECK(said({{0, 0}, {1, 0}}, 0, 0.1) == "accepted");
  CHECK_THAT(said({{0, 0}}, 0, 0.1), Contains("points: must be at least two points"));
  CHECK_THAT(said({{0, 0}, {1, 0}, {0, 1}}, 0, 0), Contains("corner_radius: must be greater than 0"));
  CHECK_THAT(said({{0, 0}, {0, 1}, {1, 0}}, 0, 0.1), Contains("does not turn left at point 1"));
  CHECK_THAT(said({{0, 0}, {2, 0}, {2, 2}, {1, 0.5}}, 0, 0.1), Contains("does not turn left at point 4"));
  CHECK_THAT(said({{0, 0}, {1, 0}, {0, 1}, {0, 0}}, 0, 0.1), Contains("end where they begin"));
  CHECK_THAT(said({{0, 0}, {1, 0}, {1, 1}, {0, 1}}, 0.5, 0.1), Contains("corner_radius: is too great"));
  // a pentagram
  std::vector<Vec2> star;
  for (int k = 0; k < 5; ++k) star.emplace_back(std::cos(0.8 * M_PI * k), std::sin(0.8 * M_PI * k));
  CHECK_THAT(said(star, 0, 0.1), Contains("must go once around"));
}
