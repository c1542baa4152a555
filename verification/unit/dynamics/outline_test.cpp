// Contacts with convex outlines against geometry: gaps against samples of the boundary, contact rows against
// finite differences, bounds of the gap against samples of motions, kinks at the ends of edges, and refused
// outlines.
#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double s = 1e-5;

struct Random {
  std::mt19937 engine{20261130};
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>{low, high}(engine);
  }
  std::vector<double> vector(int n, double size = 1) {
    std::vector<double> x(static_cast<std::size_t>(n));
    for (auto& y : x) y = (*this)(-size, size);
    return x;
  }
};

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
Outline some_outline(Random& random, int which) {
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
std::vector<double> pose(Random& random, const Outline& o, const Vec2& x) {
  auto q = random.vector(6, 3);
  const Vec2 at = Placement{q.data()}.point(0, o.origin + x);
  q[3] = q[4] = 0;
  const Vec2 arm = Placement{q.data()}.point(1, o.centre);
  q[3] = at.x() - arm.x(), q[4] = at.y() - arm.y();
  return q;
}

std::vector<double> along(std::vector<double> q, const std::vector<double>& v, double t) {
  for (std::size_t i = 0; i < q.size(); ++i) q[i] += t * v[i];
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
  Random random;
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
  Random random;
  int compared = 0, jumps = 0;
  for (int which = 0; which < 24; ++which)
    for (const char* bodies : {"\"plate\", \"disc\"", "\"ground\", \"disc\"", "\"plate\", \"ground\""}) {
      const auto o = some_outline(random, which);
      const System system(pair_of(o, bodies).mechanism);
      auto e = system.make_evaluation(), lo = e, hi = e;
      ContactRow row, row_lo, row_hi;
      for (int trial = 0; trial < 20; ++trial) {
        const auto q = pose(random, o, {random(-2, 2), random(-2, 2)});
        const auto v = random.vector(6);
        const auto qa = along(q, v, -s), qb = along(q, v, s);
        system.place(0, q.data(), e);
        system.place(0, qa.data(), lo);
        system.place(0, qb.data(), hi);
        system.contact(0, q.data(), v.data(), e, row);
        if (row.gap < -0.5 * o.radius) continue;  // radii of curvature above 0.15
        system.contact(0, qa.data(), v.data(), lo, row_lo);
        system.contact(0, qb.data(), v.data(), hi, row_hi);
        CAPTURE(which, bodies, trial, o.keys(), row.gap);
        CHECK(row.gap == system.gap(0, q.data(), e));
        // Across the ends of edges ġ is continuous; its slope jumps by (t·w)²/D < 6²/0.15.
        const double rate = row.normal.dot(v.data());
        const double slope = (row_hi.gap - row_lo.gap) / (2 * s);
        if (std::abs(row_hi.gamma_n - row_lo.gamma_n) > 0.05) {
          CHECK(rate == Approx(slope).margin(0.5 * s * 240 + 1e-6));
          ++jumps;
          continue;
        }
        // s²/6 times third derivatives, which are below |w|³/D² = 6³/0.15²
        CHECK(rate == Approx(slope).margin(1e-6));
        const auto change = [&](const SparseRow& a, const SparseRow& b) {
          return (b.dot(v.data()) - a.dot(v.data())) / (2 * s);
        };
        CHECK(row.gamma_n == Approx(-change(row_lo.normal, row_hi.normal)).margin(1e-4));
        CHECK(row.gamma_t == Approx(-change(row_lo.tangent, row_hi.tangent)).margin(1e-4));
        ++compared;
        if (std::string_view(bodies).find("ground") != std::string_view::npos) continue;
        // Rotating both bodies about one point moves neither surface along the other, nor away.
        std::vector<double> common(6);
        for (int b : {0, 1}) {
          common[3 * b] = 0.3 - 0.7 * q[3 * b + 1];
          common[3 * b + 1] = -0.2 + 0.7 * q[3 * b];
          common[3 * b + 2] = 0.7;
        }
        CHECK(row.normal.dot(common.data()) == Approx(0).margin(1e-12));
        CHECK(row.tangent.dot(common.data()) == Approx(0).margin(1e-12));
      }
    }
  CHECK(compared > 500);
  CHECK(jumps < compared / 20);
}

TEST_CASE("bounds of an outline's gap hold against samples of spinning motions", "[outline]") {
  Random random;
  int risen = 0, fallen = 0, tight = 0;
  constexpr int cases = 1500;
  for (int which = 0; which < cases; ++which) {
    const auto o = some_outline(random, which);
    const System system(pair_of(o).mechanism);
    auto e = system.make_evaluation();
    const auto q0 = pose(random, o, {random(-3, 3), random(-3, 3)});
    const auto v = random.vector(6);
    const double h = std::pow(10, random(-2.5, 0));
    ContactRow row;
    const auto at = [&](double t) {
      const auto q = along(q0, v, t);
      system.place(0, q.data(), e);
      system.contact(0, q.data(), v.data(), e, row);
      return Watched{row.gap, row.normal.dot(v.data())};
    };
    MotionBounds bounds;
    bounds.duration = h;
    bounds.acceleration.assign(6, 0);
    for (const double x : v) bounds.speed.push_back(std::abs(x));
    const auto start = at(0), end = at(h);
    const auto q1 = along(q0, v, h);
    system.place(0, q1.data(), e);
    const auto motion = system.gap_motion(0, bounds, q1.data(), e);
    double least = INFINITY, slowest = INFINITY, fastest = -INFINITY;
    for (int k = 0; k <= 200; ++k) {
      const auto sample = at(h * k / 200);
      least = std::min(least, sample.value);
      slowest = std::min(slowest, sample.rate);
      fastest = std::max(fastest, sample.rate);
    }
    CAPTURE(which, h, o.keys());
    const double bound = motion.least(start, end, h);
    CHECK(bound <= least + 1e-12);  // rounding
    const bool rises = motion.rises(start, end, h), falls = motion.falls(start, end, h);
    if (rises) CHECK(slowest > 0);
    if (falls) CHECK(fastest < 0);
    risen += rises;
    fallen += falls;
    tight += least - bound < 0.05;
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
