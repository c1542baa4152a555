// Bearings and journals with profiles: gaps against dense searches and against the geometry of both outlines,
// contact rows against finite differences, bounds of the gap against samples of motions, closed forms,
// reductions to round surfaces, refusals, and derivatives by amplitudes.
#include "mechanism/profile.hpp"

#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/contact_rows.hpp"
#include "verification/unit/variation/varied_scenes.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double R = 0.02, c = 1e-4;  // m, bearing radius and clearance

/// Rows n, cosine, sine.
using Series = std::vector<std::array<double, 3>>;

/// p and p″, term by term.
std::array<double, 2> deviation(const Series& series, double phi) {
  std::array<double, 2> p{};
  for (const auto& [n, cosine, sine] : series) {
    const double y = cosine * std::cos(n * phi) + sine * std::sin(n * phi);
    p[0] += y;
    p[1] -= n * n * y;
  }
  return p;
}
double slope(const Series& series, double phi) {
  double sum = 0;
  for (const auto& [n, cosine, sine] : series)
    sum += n * (sine * std::cos(n * phi) - cosine * std::sin(n * phi));
  return sum;
}

/// Three harmonics of orders 0 to 8, whose curvature is up to about `strong` times the clearance.
Series some_series(test::Uniform& random, double strong) {
  Series list;
  for (int k = 0; k < 3; ++k) {
    const double n = std::floor(random(0, 9)), angle = random(0, 2 * M_PI);
    const double size = 0.3 * random(0, 1) * c * (n < 2 ? std::min(strong, 1.0) : 3 * strong / (n * n - 1));
    list.push_back({n, size * std::cos(angle), size * std::sin(angle)});
  }
  return list;
}

std::string harmonics(const Series& series) {
  std::string rows;
  for (const auto& [n, cosine, sine] : series)
    rows += fmt::format("{}[{:.17g}, {:.17g}, {:.17g}]", rows.empty() ? "" : ", ", n, cosine, sine);
  return fmt::format("harmonics = [{}]\n", rows);
}

/// A bearing on the first of both bodies; profiles as keys of their tables, or empty.
Scene pair_of(const std::string& bearing, const std::string& journal,
              const std::string& bodies = "\"ring\", \"shaft\"", double clearance = c,
              Vec2 at = {0.01, -0.02}, double radius = R) {
  std::string profiles, keys = fmt::format("clearance = {:.17g}\nbearing_radius = {:.17g}\nsurface = \"s\"\n",
                                           clearance, radius);
  if (!bearing.empty()) keys += "bearing_profile = \"b\"\n", profiles += "[profiles.b]\n" + bearing;
  if (!journal.empty()) keys += "journal_profile = \"j\"\n", profiles += "[profiles.j]\n" + journal;
  return parse_scene(test::body("ring", 1, 1) + test::body("shaft", 1, 1) + test::surface("s", 0.5, 0.1) +
                         fmt::format("[joints.pin]\ntype = \"revolute\"\nbetween = [{}]\n"
                                     "at = [[{:.17g}, {:.17g}], [0.03, 0.015]]\n",
                                     bodies, at.x(), at.y()) +
                         keys + profiles + test::run_for(1),
                     "profiles");
}

/// Positions of both bodies with the journal's centre at d from the bearing's, in axes of the ring.
std::vector<double> pose(test::Uniform& random, const Vec2& d, Vec2 at = {0.01, -0.02}) {
  auto q = random.vector(6, 3);
  const Vec2 centre = Placement{q.data()}.point(0, at + d);
  q[3] = q[4] = 0;
  const Vec2 arm = Placement{q.data()}.point(1, {0.03, 0.015});
  q[3] = centre.x() - arm.x(), q[4] = centre.y() - arm.y();
  return q;
}

Vec2 polar(double r, double angle) { return {r * std::cos(angle), r * std::sin(angle)}; }

/// Profiles of both surfaces, or strong ones of a single surface. Empty if they are refused.
struct Surfaces {
  Series bearing, journal;
  std::optional<System> system;
  std::optional<OutOfRound> surfaces;

  Surfaces(test::Uniform& random, int which, const std::string& bodies = "\"ring\", \"shaft\"") {
    if (which % 3 != 2) bearing = some_series(random, which % 3 == 0 ? 0.4 : 2.5);
    if (which % 3 != 1) journal = some_series(random, which % 3 == 0 ? 0.4 : 2.5);
    try {
      const auto of = [](const Series& s) { return s.empty() ? "" : harmonics(s); };
      const auto m = pair_of(of(bearing), of(journal), bodies).mechanism;
      system.emplace(m);
      surfaces = out_of_round(m, std::get<RevoluteJoint>(m.joints[0]));
    } catch (const SceneError&) {
      // Refused: no clearance is left, both surfaces have strong waves, or a curvature is that of the other
      // surface.
    }
  }
};

}  // namespace

TEST_CASE("gaps of profiles are those of a dense search over all directions", "[profiles]") {
  test::Uniform random;
  constexpr int directions = 1000;
  int single = 0, several = 0, open = 0, closed = 0;
  for (int which = 0; which < 750; ++which) {
    const Surfaces s(random, which);
    if (!s.system) continue;
    auto e = s.system->make_evaluation();
    for (int trial = 0; trial < 20; ++trial) {
      const auto d = polar(c * random(0, 1.3), random(0, 2 * M_PI));
      const auto q = pose(random, d);
      s.system->place(0, q.data(), e);
      double dense = INFINITY, sharp = 0;  // least G, greatest |G″|
      for (int k = 0; k < directions; ++k) {
        const double phi = 2 * M_PI * k / directions;
        const auto b = deviation(s.bearing, phi), j = deviation(s.journal, phi - (q[5] - q[2]));
        const double out = dot(d, polar(1, phi));
        dense = std::min(dense, c + b[0] - j[0] - out);
        sharp = std::max(sharp, std::abs(b[1] - j[1] + out));
      }
      // Half of the distance between directions squared times half of G″; 1 % for its change; rounding of d
      // by positions of 3 m.
      const double below = 0.505 * sharp * std::pow(M_PI / directions, 2) + 1e-14;
      double gap = INFINITY;
      for (int k = 0; k < s.system->contacts(); ++k) gap = std::min(gap, s.system->gap(k, q.data(), e));
      CAPTURE(which, trial, s.system->contacts(), d.x(), d.y());
      // Beyond the reach an error of 1e-6 of the gap is allowed.
      if (s.system->contacts() == 1) {
        CHECK(gap <= dense + 1e-6 * c + 1e-14);
        CHECK(gap >= dense - below);
        ++single;
      } else {
        // The arcs cover all directions in which the journal can touch, so the signs agree.
        CHECK(gap >= dense - below);
        if (dense > 1e-9) CHECK(gap > 0);
        if (dense < -1e-9) CHECK(gap < 0);
        ++several;
      }
      ++(dense > 0 ? open : closed);
    }
  }
  CHECK(single + several > 10'000);
  CHECK(single > 3000);
  CHECK(several > 3000);
  CHECK(open > 3000);
  CHECK(closed > 1000);
}

TEST_CASE("the gap is the distance of both outlines", "[profiles]") {
  // Points H n + H′ t of the journal, and for each its least distance to the tangents of the bearing near it.
  test::Uniform random;
  int compared = 0;
  for (int which = 0; which < 60; which += 3) {
    const Surfaces s(random, which);
    if (!s.system || s.system->contacts() > 1) continue;
    auto e = s.system->make_evaluation();
    const auto d = polar(0.8 * c, random(0, 2 * M_PI));
    const auto q = pose(random, d);
    s.system->place(0, q.data(), e);
    const double turn = q[5] - q[2];
    double least = INFINITY;
    for (int k = 0; k < 4000; ++k) {
      const double phi = 2 * M_PI * k / 4000, H = R - c + deviation(s.journal, phi - turn)[0];
      const Vec2 x = d + H * polar(1, phi) + slope(s.journal, phi - turn) * perp(polar(1, phi));
      for (int m = -20; m <= 20; ++m) {
        const double psi = phi + 1e-3 * m;
        least = std::min(least, R + deviation(s.bearing, psi)[0] - dot(x, polar(1, psi)));
      }
    }
    // The directions are 1.6 and 1 mrad apart: ½ R (1 mrad)², for both surfaces.
    CHECK(s.system->gap(0, q.data(), e) == Approx(least).margin(0.5 * R * 2e-6));
    ++compared;
  }
  CHECK(compared > 8);
}

TEST_CASE("contact rows of profiles agree with finite differences", "[profiles]") {
  test::Uniform random;
  int compared = 0;
  for (int which = 0; which < 90; ++which)
    for (const char* bodies : {"\"ring\", \"shaft\"", "\"ground\", \"shaft\"", "\"ring\", \"ground\""}) {
      const Surfaces s(random, which, bodies);
      if (!s.system) continue;
      const auto& system = *s.system;
      for (int trial = 0; trial < 6; ++trial) {
        // Angles of the ground are 0, and its point is the joint's.
        auto q = pose(random, polar(c * random(0.7, 1.05), random(0, 2 * M_PI)));
        if (std::string_view(bodies).starts_with("\"ground")) {
          const auto d = polar(c * random(0.7, 1.05), random(0, 2 * M_PI));
          const Vec2 arm = Placement{q.data()}.point(1, {0.03, 0.015}) - Vec2{q[3], q[4]};
          q[3] = 0.01 + d.x() - arm.x(), q[4] = -0.02 + d.y() - arm.y();
        } else if (std::string_view(bodies).ends_with("\"ground\"")) {
          const auto d = polar(c * random(0.7, 1.05), random(0, 2 * M_PI));
          const Vec2 arm = Placement{q.data()}.point(0, {0.01, -0.02}) - Vec2{q[0], q[1]};
          q[0] = 0.03 - d.x() - arm.x(), q[1] = 0.015 - d.y() - arm.y();
        }
        // Points move by some clearances per second, bodies turn by one rad per second.
        std::vector<double> v = random.vector(6);
        for (const int body : {0, 1}) {
          const Vec2 arm =
              Placement{q.data()}.point(body, body == 0 ? Vec2{0.01, -0.02} : Vec2{0.03, 0.015}) -
              Vec2{q[3 * body], q[3 * body + 1]};
          const Vec2 slow = polar(c * random(0, 1), random(0, 7)) - v[3 * body + 2] * perp(arm);
          v[3 * body] = slow.x(), v[3 * body + 1] = slow.y();
        }
        for (int k = 0; k < system.contacts(); ++k) {
          CAPTURE(which, bodies, trial, k);
          const test::RowDifferences found(system, k, q, v, 1e-4);
          const auto& row = found.row;
          // Within the reach the place moves continuously; at the ends of an arc γ jumps. Fast motions are
          // left out.
          if (row.gap > 0.4 * s.surfaces->arcs[static_cast<std::size_t>(k)].least) continue;
          if (std::abs(row.gamma_n) > 30 * c || found.gamma_jump() > 0.2 * c) continue;
          // h²/6 of the third derivatives, some hundred clearances; rounding 1e-15/h.
          CHECK(found.rate() == Approx(found.gap_slope()).margin(1e-5 * c));
          CHECK(row.gamma_n == Approx(found.gamma_n()).margin(1e-3 * c).epsilon(1e-3));
          // v_T is of the size of R.
          CHECK(row.gamma_t == Approx(found.gamma_t()).margin(1e-3 * c).epsilon(1e-3));
          ++compared;
          // Across a gap the surfaces slide by ω g.
          if (std::string_view(bodies).find("ground") == std::string_view::npos)
            found.check_common_rotation(q, -0.7 * row.gap);
        }
      }
    }
  CHECK(compared > 200);
}

TEST_CASE("bounds of a profile's gap hold against samples of motions", "[profiles]") {
  test::Uniform random;
  int risen = 0, fallen = 0, checked = 0;
  for (int which = 0; which < 600; ++which) {
    const Surfaces s(random, which);
    if (!s.system) continue;
    const auto q = pose(random, polar(c * random(0.3, 1.1), random(0, 2 * M_PI)));
    auto v = random.vector(6, 0.1 * c);
    // Some bodies turn so fast that the bounds rarely decide.
    const double spin = which % 4 == 0 ? 1 : 0.01;
    v[2] = random(-spin, spin), v[5] = random(-spin, spin);
    const double h = std::pow(10, random(-3, 0));
    for (int k = 0; k < s.system->contacts(); ++k) {
      CAPTURE(which, k, h);
      const auto found = test::gap_bounds(*s.system, k, q, v, h, 100);
      // Beyond the reach gaps are exact to 1e-6.
      CHECK(found.bound <= found.least + 3e-6 * c);
      risen += found.rises;
      fallen += found.falls;
      ++checked;
    }
  }
  CHECK(risen > checked / 100);
  CHECK(fallen > checked / 100);
}

TEST_CASE("an elliptic bearing has the contacts of its closed form", "[profiles]") {
  // p = a cos 2φ: with the journal at (x, 0), G = c + a − x at φ = 0, and for x < 4a the least G is
  // c − a − x²/(8a) where cos φ = x/(4a). With c > 3a the journal touches at a single place everywhere.
  for (const double a : {0.2 * c, 0.3 * c, 0.5 * c, 0.7 * c}) {
    CAPTURE(a);
    const auto surfaces = harmonics({{2, a, 0}});
    const System system(pair_of(surfaces, "", "\"ground\", \"shaft\"", c, {0, 0}).mechanism);
    const bool one = c > 3 * a;
    REQUIRE(system.contacts() == (one ? 1 : 2));
    CHECK(system.contact_facts(0).name == (one ? "pin" : "pin.1"));
    auto e = system.make_evaluation();
    const auto gaps = [&](double x, double y) {
      // without rotation the journal's centre is at its point
      const std::vector<double> q{0, 0, 0, x - 0.03, y - 0.015, 0};
      system.place(0, q.data(), e);
      std::vector<double> list;
      for (int k = 0; k < system.contacts(); ++k) list.push_back(system.gap(k, q.data(), e));
      return list;
    };
    const double rounding = 1e-16;
    for (const double y : {0.5 * (c - a), c - a}) CHECK(gaps(0, y).back() >= c - a - y - rounding);
    const auto up = gaps(0, c - a);
    CHECK(*std::ranges::min_element(up) == Approx(0).margin(rounding));
    if (one) {
      CHECK(gaps(c + a, 0)[0] == Approx(0).margin(rounding));
      const double inside = 0.9 * c < 4 * a ? c - a - 0.81 * c * c / (8 * a) : 0.1 * c + a;
      CHECK(gaps(0.9 * c, 0)[0] == Approx(inside).margin(1e-9 * c));
      continue;
    }
    const double rest = std::sqrt(8 * a * (c - a));
    for (const double x : {0.98 * rest, rest})
      for (const double side : {1, -1})
        for (const double gap : gaps(side * x, 0))
          CHECK(gap == Approx(c - a - x * x / (8 * a)).margin(rounding));
    // Both normals have the angle arccos(x/4a) to the x axis.
    ContactRow row;
    const std::vector<double> q{0, 0, 0, rest - 0.03, -0.015, 0}, v(6);
    system.place(0, q.data(), e);
    for (const int k : {0, 1}) {
      system.contact(k, q.data(), v.data(), e, row);
      CHECK(row.normal.value[0] == Approx(-rest / (4 * a)).epsilon(1e-9));
    }
  }
}

TEST_CASE("harmonics of orders 0 and 1 are another clearance and another centre", "[profiles]") {
  test::Uniform random;
  const System round(pair_of("", "", "\"ring\", \"shaft\"", 1.25 * c, {0.01, -0.02}, R + 0.25 * c).mechanism);
  const System wide(pair_of(harmonics({{0, 0.25 * c, 0}}), "").mechanism);
  const Vec2 off{0.3 * c, -0.2 * c};
  const System moved(pair_of("", "", "\"ring\", \"shaft\"", c, Vec2{0.01, -0.02} + off).mechanism);
  const System shifted(pair_of(harmonics({{1, off.x(), off.y()}}), "").mechanism);
  auto e = round.make_evaluation();
  for (int trial = 0; trial < 200; ++trial) {
    const auto q = pose(random, polar(c * random(0.6, 1.3), random(0, 2 * M_PI)));
    const auto v = random.vector(6, c);
    round.place(0, q.data(), e);
    for (const auto& [a, b] : {std::pair{&round, &wide}, std::pair{&moved, &shifted}}) {
      CHECK(b->contacts() == 1);
      ContactRow x, y;
      a->contact(0, q.data(), v.data(), e, x);
      b->contact(0, q.data(), v.data(), e, y);
      CAPTURE(trial, x.gap / c, a == &round);
      // A gap of positions of 3 m rounds by 1e-15 m. The direction of |d| > 0.2 c then by 5e-11.
      CHECK(y.gap == Approx(x.gap).margin(2e-15));
      for (int i = 0; i < 6; ++i) CHECK(y.normal.value[i] == Approx(x.normal.value[i]).margin(1e-9));
      // Farther from the bearing the rotation of the normal is limited.
      if (x.gap < 0.5 * c) CHECK(y.gamma_n == Approx(x.gamma_n).margin(1e-9).epsilon(1e-8));
      // The friction of the moved centre acts at the nominal radius.
      if (a == &round)
        for (int i = 0; i < 6; ++i) CHECK(y.tangent.value[i] == Approx(x.tangent.value[i]).margin(1e-9));
    }
  }
}

TEST_CASE("a table through points of a profile replaces its harmonics", "[profiles]") {
  const double a = 0.5 * c;
  std::string points;
  for (int k = 0; k < 72; ++k)
    points += fmt::format("{}[{:.17g}, {:.17g}]", k == 0 ? "" : ", ", 2 * M_PI * k / 72,
                          a * std::cos(4 * M_PI * k / 72));
  const System table(pair_of("points = [" + points + "]\n", "").mechanism),
      series(pair_of(harmonics({{2, a, 0}}), "").mechanism);
  REQUIRE(table.contacts() == series.contacts());
  test::Uniform random;
  auto e = table.make_evaluation();
  for (int trial = 0; trial < 200; ++trial) {
    const auto q = pose(random, polar(c * random(0.5, 1.2), random(0, 2 * M_PI)));
    table.place(0, q.data(), e);
    for (int k = 0; k < table.contacts(); ++k)
      // 5/384 p″″ h⁴ of a cubic spline = 5/384 · 16 a (2π/72)⁴; arcs that begin elsewhere by a sample, 1.5
      // mrad
      CHECK(table.gap(k, q.data(), e) == Approx(series.gap(k, q.data(), e)).margin(3e-5 * a + 5e-3 * c));
  }
}

TEST_CASE("profiles whose contacts are not described are refused with the reason", "[profiles][refused]") {
  const auto said = [](const std::string& bearing, const std::string& journal = "") {
    return test::refusal_of([&] { pair_of(bearing, journal); });
  };
  CHECK(said(harmonics({{2, 0.2 * c, 0}})) == "accepted");
  CHECK(said(harmonics({{8, 0.3 * c, 0}})) == "accepted");
  CHECK(said(harmonics({{2, 0.1 * c, 0}}), harmonics({{3, 0.05 * c, 0}})) == "accepted");
  CHECK_THAT(said(""), Contains("accepted"));
  CHECK_THAT(said("\n"), Contains("profiles.b: needs exactly one of harmonics and points"));
  CHECK_THAT(said("harmonics = [[1.5, 0, 0]]\n"), Contains("profiles.b.harmonics: must have rows"));
  CHECK_THAT(said("points = [[0, 0], [1, 1e-6]]\n"), Contains("profiles.b.points: must be three points"));
  CHECK_THAT(said("points = [[0, 0], [1, 1e-6], [7, 0]]\n"), Contains("must stay within one turn"));
  CHECK_THAT(said("points = [[0, 0], [2, 1e-6], [1, 0]]\n"), Contains("must increase"));
  CHECK_THAT(said(harmonics({{2, 1.1 * c, 0}})), Contains("joints.pin.bearing_profile: leaves no clearance"));
  CHECK_THAT(said("", harmonics({{0, 1.1 * c, 0}})),
             Contains("joints.pin.journal_profile: leaves no clearance"));
  CHECK_THAT(said(harmonics({{40, 0.9 * c, 0}})), Contains("is too steep"));
  CHECK_THAT(said(harmonics({{8, 0.3 * c, 0}}), harmonics({{3, 0.1 * c, 0}})),
             Contains("several places that depend on the angle between both bodies"));
  CHECK_THAT(said("", harmonics({{20, 0.9 * c, 0}})), Contains("joints.pin.journal_profile: is too sharp"));
  // w = c − 3a at the ends of the long axis
  CHECK_THAT(said(harmonics({{2, c / 3, 0}})), Contains("is at its limit"));
  CHECK_THAT(
      test::refusal_of([] {
        parse_scene(
            test::body("a", 1, 1) + test::surface("s", 1) +
                "[lubricants.oil]\nviscosity = 0.1\n[profiles.p]\nharmonics = [[2, 1e-5, 0]]\n" +
                test::pin("pin", "ground", "a", {}, {},
                          test::loose(1e-4, 0.01) +
                              "bearing_length = 0.01\nlubricant = \"oil\"\njournal_profile = \"p\"\n") +
                test::run_for(1),
            "oil");
      }),
      Contains("joints.pin.lubricant: cannot be combined with a profile"));
  CHECK_THAT(test::refusal_of([] {
               parse_scene(test::body("a", 1, 1) + test::surface("s", 1) +
                               test::pin("pin", "ground", "a", {}, {},
                                         test::loose(1e-4, 0.01) + "journal_profile = \"p\"\n") +
                               test::run_for(1),
                           "missing");
             }),
             Contains("joints.pin.journal_profile: there is no profile \"p\""));
}

TEST_CASE("an impact in an elliptic bearing has closed derivatives by the amplitude",
          "[profiles][sensitivity]") {
  // Without gravity the journal flies along the x axis and meets the end at x = c + a: dt/da = 1/v.
  const double a = 2e-4, clearance = 1e-3, v = 0.5, e = 0.8;
  const auto text =
      "gravity = [0, 0]\n" +
      test::body("shaft", 1, 1e-4, fmt::format("velocity = [{}, 0]\nangular_velocity = 0\n", v)) +
      test::pin("pin", "ground", "shaft", {}, {},
                test::loose(clearance, 0.02) + "bearing_profile = \"oval\"\n") +
      fmt::format("[profiles.oval]\nharmonics = [[2, {}, 0]]\n", a) + test::surface("s", e) +
      test::run_for(4e-3, "start = \"given\"\n") +
      "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";
  const auto found = test::varied::of(text, {"event.1.t", "end.shaft.x"},
                                      {"profiles.oval.harmonics[0][1]", "joints.pin.clearance"});
  const double hit = (clearance + a) / v;
  CHECK(found.quantities[0].value == Approx(hit).epsilon(1e-10));
  test::varied::check_derivatives(found.quantities[0], {1 / v, 1 / v}, 1e-8);
  // x = c + a − e v (t − hit): d/da = 1 + e
  CHECK(found.quantities[1].value == Approx(clearance + a - e * v * (4e-3 - hit)).epsilon(1e-9));
  test::varied::check_derivatives(found.quantities[1], {1 + e, 1 + e}, 1e-8);
}
