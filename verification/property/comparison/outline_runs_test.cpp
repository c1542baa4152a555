// Runs with convex outlines against closed forms: a disc that slides off the end of a face, a disc that
// falls on a corner, thin faces that no step passes through, and random outlines in flight.
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double g = 9.81;

/// A disc of 1 kg over an outline of the ground, without friction.
std::string disc_over(const std::string& outline, Vec2 position, Vec2 velocity, double restitution,
                      double duration) {
  return fmt::format("gravity = [0, {:.17g}]\n", -g) +
         test::body("disc", 1, 0.5,
                    fmt::format("position = [{:.17g}, {:.17g}]\nvelocity = [{:.17g}, {:.17g}]\nangle = 0\n"
                                "angular_velocity = 0\n",
                                position.x(), position.y(), velocity.x(), velocity.y())) +
         test::surface("s", restitution, "young = 2e11\npoisson = 0.3\n") +
         "[contacts.side]\ntype = \"outline\"\nbetween = [\"ground\", \"disc\"]\nsurface = \"s\"\n" +
         outline + test::run_for(duration, "start = \"given\"\n");
}

/// The time (s) and the angle φ to the vertical at which a disc leaves a corner of radius r over which it
/// slides: with ρ = R + r, φ̇² = v0²/ρ² + 2 g (1 − cos φ)/ρ and a vanishing force at cos φ = ρ φ̇²/g.
struct Corner {
  double rho, v0;
  double cosine() const { return 2.0 / 3 + v0 * v0 / (3 * g * rho); }
  double rate(double phi) const {
    return std::sqrt(v0 * v0 / (rho * rho) + 2 * g * (1 - std::cos(phi)) / rho);
  }
  double angle() const { return std::acos(cosine()); }
  /// ∫ dφ/φ̇ by Simpson's rule.
  double duration() const {
    const int n = 2000;
    double sum = 0;
    for (int i = 0; i <= n; ++i) sum += (i == 0 || i == n ? 1 : i % 2 == 1 ? 4 : 2) / rate(angle() * i / n);
    return sum * angle() / (3 * n);
  }
};

}  // namespace

TEST_CASE("a disc slides off the end of a face, around its corner, and leaves it", "[outline]") {
  const double R = 0.1, v0 = 0.5, length = 0.2, after = 0.05;
  struct Face {
    const char* points;
    double top, end, r;
  };
  for (const auto& face :
       {Face{"points = [[-1, 0], [0, 0]]\nradius = 0.1\n", 0, 0, 0},
        Face{"points = [[-1, 0], [0, 0]]\nradius = 0.1\ncorner_radius = 0.02\n", 0.02, 0, 0.02},
        Face{"points = [[0.03, 0], [-1, 0], [-1, -1], [0.03, -1]]\nradius = 0.1\n"
             "corner_radius = 0.03\n",
             0, 0, 0.03}}) {
    CAPTURE(face.points);
    const Corner corner{R + face.r, v0};
    const double at_corner = length / v0, leaves = at_corner + corner.duration(), phi = corner.angle();
    // The centre of the corner is r below the face.
    const Vec2 middle{face.end, face.top - face.r};
    const double speed = corner.rho * corner.rate(phi);
    const Vec2 place = middle + corner.rho * Vec2{std::sin(phi), std::cos(phi)},
               velocity = speed * Vec2{std::cos(phi), -std::sin(phi)};
    const Vec2 expected = place + after * velocity - Vec2{0, 0.5 * g * after * after};
    const auto text = disc_over(face.points, {-length, face.top + R}, {v0, 0}, 0, leaves + after);
    const auto run = test::finished(test::event_driven, text);
    const auto& last = run.final_state;
    // tolerance 1e-8 of 0.1 m and 1 m/s in some ten steps
    CHECK(last.q[0] == Approx(expected.x()).margin(1e-6));
    CHECK(last.q[1] == Approx(expected.y()).margin(1e-6));
    CHECK(last.v[0] == Approx(velocity.x()).margin(1e-5));
    REQUIRE_FALSE(run.events.empty());
    CHECK(run.events.back().kind == EventKind::separation);
    // The force vanishes with a finite slope.
    CHECK(run.events.back().t == Approx(leaves).margin(1e-5));
    const auto adaptive = test::finished(test::chosen_steps, text).final_state;
    // a hundred steps with errors of 1e-5 of the disc's radius
    CHECK(adaptive.q[0] == Approx(expected.x()).margin(1e-3 * R));
    CHECK(adaptive.q[1] == Approx(expected.y()).margin(1e-3 * R));
    const auto fixed = test::finished(test::fixed_steps(1e-4), text).final_state;
    // first order: h times the speed of 1 m/s, factor of three
    CHECK(fixed.q[0] == Approx(expected.x()).margin(3e-4));
    CHECK(fixed.q[1] == Approx(expected.y()).margin(3e-4));
  }
}

TEST_CASE("a disc rolls around the end of a face, slips and leaves it", "[outline]") {
  // Expected: by SciPy's DOP853 at 1e-13. With the angle φ around the corner, ρ = R + r and
  // N = m (g cos φ − ρ φ̇²), rolling obeys (m + J/R²) ρ φ̈ = m g sin φ until the friction J ρ φ̈/R² exceeds
  // μ N; then sliding obeys m ρ φ̈ = m g sin φ − μ N and J ω̇ = μ N R until N = 0.
  const double leaves = 0.5557613777560849, x = 0.11417901629406285, y = 0.044812982115271245,
               theta = -3.270500672594203, vx = 0.6265083699303869, omega = -7.45760227488031;
  const auto text = "gravity = [0, -9.81]\n" +
                    test::body("disc", 1, 0.005,
                               "position = [-0.2, 0.12]\nvelocity = [0.5, 0]\nangle = 0\n"
                               "angular_velocity = -5\n") +
                    test::surface("s", 0, 0.3, "young = 2e11\npoisson = 0.3\n") +
                    "[contacts.side]\ntype = \"outline\"\nbetween = [\"ground\", \"disc\"]\n"
                    "points = [[-1, 0], [0, 0]]\ncorner_radius = 0.02\nradius = 0.1\nsurface = \"s\"\n" +
                    test::run_for(0.6, "start = \"given\"\n");
  const auto run = test::finished(test::event_driven, text);
  const auto& end = run.final_state;
  // tolerance 1e-8 in some tens of steps, and a slope of the force of order one at the events
  CHECK(end.q[0] == Approx(x).margin(1e-6));
  CHECK(end.q[1] == Approx(y).margin(1e-6));
  CHECK(end.q[2] == Approx(theta).margin(1e-5));
  CHECK(end.v[0] == Approx(vx).margin(1e-5));
  CHECK(end.v[2] == Approx(omega).margin(1e-4));
  REQUIRE_FALSE(run.events.empty());
  CHECK(run.events.back().t == Approx(leaves).margin(1e-5));
  const auto adaptive = test::finished(test::chosen_steps, text).final_state;
  CHECK(adaptive.q[0] == Approx(x).margin(1e-4));
  CHECK(adaptive.q[1] == Approx(y).margin(1e-4));
}

TEST_CASE("a disc that falls on a rounded corner bounces along the line of centres", "[outline]") {
  // The normal is tilted by α: the centre is ρ sin α beside that of the corner.
  const double R = 0.1, r = 0.05, rho = R + r, alpha = 0.4, height = 0.5, e = 0.7, after = 0.1;
  const Vec2 n{std::sin(alpha), std::cos(alpha)};
  const double t = std::sqrt(2 * height / g);
  const Vec2 before{0, -g * t}, behind = before - (1 + e) * dot(n, before) * n;
  const Vec2 impact = Vec2{-r, -r} + rho * n;
  const Vec2 expected = impact + after * behind - Vec2{0, 0.5 * g * after * after};
  const auto text =
      disc_over("points = [[0, 0], [-1, 0], [-1, -1], [0, -1]]\nradius = 0.1\ncorner_radius = 0.05\n",
                impact + Vec2{0, height}, {0, 0}, e, t + after);
  const auto exact = test::finished(test::event_driven, text);
  // Free fall is integrated to rounding; that of the impact's time grows by the speeds.
  CHECK(exact.final_state.q[0] == Approx(expected.x()).margin(1e-9));
  CHECK(exact.final_state.q[1] == Approx(expected.y()).margin(1e-9));
  CHECK(test::touch(exact, 0).t == Approx(t).margin(1e-10));
  CHECK(test::touch(exact, 0).v_n_minus == Approx(dot(n, before)).margin(1e-8));
  const auto soft = test::finished(test::penalty, text).final_state;
  // The default law delivers another restitution than asked for, but the force has the same direction.
  CHECK(soft.v[0] / (soft.v[1] - before.y() + g * after) == Approx(std::tan(alpha)).epsilon(1e-2));
}

TEST_CASE("no step passes through a thin face at any speed", "[outline]") {
  // A disc of 1 mm meets a face of no thickness at its middle, near its end, and beside it.
  for (const double speed : {1.0, 100.0, 1e4})
    for (const double beside : {-0.5, -1e-3, 0.9e-3, 1.1e-3}) {
      CAPTURE(speed, beside);
      const auto text =
          "gravity = [0, 0]\n" +
          test::body("disc", 1, 1e-6,
                     fmt::format("position = [{:.17g}, 3.0]\nvelocity = [0, {:.17g}]\nangle = 0\n"
                                 "angular_velocity = 0\n",
                                 beside, -speed)) +
          test::surface("s", 1, "young = 2e11\npoisson = 0.3\n") +
          "[contacts.side]\ntype = \"outline\"\nbetween = [\"ground\", \"disc\"]\n"
          "points = [[-1, 0], [0, 0]]\nradius = 1e-3\nsurface = \"s\"\n" +
          test::run_for(6 / speed, "start = \"given\"\n");
      for (const auto& way : {test::event_driven, test::chosen_steps}) {
        const auto run = test::finished(way, text);
        CHECK(test::touches(run).size() == (beside < 1e-3 ? 1U : 0U));
        if (beside < 0) CHECK(run.final_state.v[1] == Approx(speed));
      }
    }
}

TEST_CASE("a blade that spins in flight hits a peg at the time that its motion says", "[outline]") {
  // A heavy blade from 0.2 to 1 m turns by ω about the origin; a peg of 2 mm flies past.
  for (int i = 0; i < 12; ++i) {
    const double omega = 5.0 * (i + 1), y = 0.3 + 0.05 * i, v = 2;
    // The first time at which the peg's distance to the blade is 2 mm, from samples of 1e-6 s.
    double first = INFINITY;
    for (int k = 0; k < 3'000'000 && !std::isfinite(first); ++k) {
      const double t = 1e-6 * k, x = -3 + v * t, c = std::cos(omega * t), s = std::sin(omega * t);
      const double along = std::clamp(c * x + s * y, 0.2, 1.0);
      if (std::hypot(x - along * c, y - along * s) <= 2e-3) first = t;
    }
    CAPTURE(omega, y, first);
    REQUIRE(std::isfinite(first));
    const auto text = "gravity = [0, 0]\n" +
                      test::body("blade", 1e9, 1e9,
                                 fmt::format("position = [0, 0]\nvelocity = [0, 0]\nangle = 0\n"
                                             "angular_velocity = {:.17g}\n",
                                             omega)) +
                      test::body("peg", 1, 1e-6,
                                 fmt::format("position = [-3, {:.17g}]\nvelocity = [{:.17g}, 0]\nangle = 0\n"
                                             "angular_velocity = 0\n",
                                             y, v)) +
                      test::surface("s", 0, "young = 2e11\npoisson = 0.3\n") +
                      "[contacts.side]\ntype = \"outline\"\nbetween = [\"blade\", \"peg\"]\n"
                      "points = [[0.2, 0], [1, 0]]\nradius = 2e-3\nsurface = \"s\"\n" +
                      test::run_for(first + 1e-3, "start = \"given\"\n");
    CHECK(test::touch(test::finished(test::event_driven, text), 0).t == Approx(first).margin(2e-6));
  }
}

namespace {

/// A heavy plate that turns by ω about the origin, and a disc in straight flight without forces.
struct Flight {
  std::vector<Vec2> points, centres;
  double corner_radius = 0, radius = 0, omega = 0, restitution = 0, lasts = 0;
  Vec2 from, velocity;

  explicit Flight(std::mt19937& engine) {
    const auto draw = [&](double low, double high) {
      return std::uniform_real_distribution<double>{low, high}(engine);
    };
    const int count = 2 + static_cast<int>(draw(0, 5));
    const double a = draw(0.2, 0.6), b = draw(0.2, 0.6), first = draw(0, 1);
    for (int k = 0; k < count; ++k) {
      const double angle = first + 2 * M_PI * (k + draw(0, 0.3)) / count;
      points.emplace_back(a * std::cos(angle) + 0.2, b * std::sin(angle));
    }
    radius = std::pow(10, draw(-3, -0.5));
    corner_radius = draw(0, 1) < 0.5 ? 0 : std::min(0.01, radius);
    omega = draw(-30, 30);
    restitution = draw(0, 1);
    const double turn = draw(-M_PI, M_PI), speed = std::pow(10, draw(-1, 2));
    const Vec2 along{std::cos(turn), std::sin(turn)};
    from = -2.0 * along + draw(-1, 1) * perp(along);
    velocity = speed * along;
    lasts = 4 / speed;
    omega *= speed;
    const auto n = points.size();
    for (std::size_t k = 0; k < n; ++k) {  // on the bisector of the corner's angle β, at r/sin(β/2)
      const Vec2 p = points[k], u = (points[(k + 1) % n] - p).direction(),
                 w = (points[(k + n - 1) % n] - p).direction();
      const Vec2 bisector = n == 2 ? Vec2{} : (u + w).direction();
      centres.push_back(n == 2 ? p : p + corner_radius / std::abs(cross(bisector, u)) * bisector);
    }
  }
  Vec2 turned(const Vec2& p, double angle) const {
    return {std::cos(angle) * p.x() - std::sin(angle) * p.y(),
            std::sin(angle) * p.x() + std::cos(angle) * p.y()};
  }
  /// The disc's centre in the axes of the plate, and the nearest place of the lines between the centres.
  std::pair<Vec2, Vec2> nearest(double t) const {
    const Vec2 x = turned(from + t * velocity, -omega * t);
    Vec2 best = centres[0];
    for (std::size_t k = 0; k < centres.size(); ++k) {
      const Vec2 p = centres[k], e = centres[(k + 1) % centres.size()] - p;
      const Vec2 at = p + std::clamp(dot(x - p, e) / e.squared_norm(), 0.0, 1.0) * e;
      if ((at - x).norm() < (best - x).norm()) best = at;
    }
    return {x, best};
  }
  double gap(double t) const {
    const auto [x, at] = nearest(t);
    return (x - at).norm() - radius - corner_radius;
  }
  /// Rate of the gap: velocity of the disc's centre in the axes of the plate along the normal.
  double rate(double t) const {
    const auto [x, at] = nearest(t);
    return dot((x - at).direction(), turned(velocity, -omega * t) - omega * perp(x));
  }
  /// First time at which the gap is below 1e-12 m, by steps that its greatest rate cannot pass; infinite if
  /// there is none. `least`: the least gap before.
  double contact(double& least) const {
    least = INFINITY;
    for (double t = 0; t < lasts;) {
      const double g = gap(t);
      least = std::min(least, g);
      if (g < 1e-12) return t;
      t += std::max(0.9 * g, 1e-13) /
           (velocity.norm() + std::abs(omega) * (from + t * velocity).norm() + std::abs(omega) * g);
    }
    return INFINITY;
  }
  std::string text(double duration) const {
    std::string list;
    for (const auto& p : points)
      list += fmt::format("{}[{:.17g}, {:.17g}]", list.empty() ? "" : ", ", p.x(), p.y());
    return "gravity = [0, 0]\n" +
           test::body("plate", 1e12, 1e12,
                      fmt::format("position = [0, 0]\nvelocity = [0, 0]\nangle = 0\n"
                                  "angular_velocity = {:.17g}\n",
                                  omega)) +
           test::body("disc", 1, 1,
                      fmt::format("position = [{:.17g}, {:.17g}]\nvelocity = [{:.17g}, {:.17g}]\nangle = 0\n"
                                  "angular_velocity = 0\n",
                                  from.x(), from.y(), velocity.x(), velocity.y())) +
           test::surface("s", restitution, "young = 2e11\npoisson = 0.3\n") +
           fmt::format(
               "[contacts.side]\ntype = \"outline\"\nbetween = [\"plate\", \"disc\"]\nsurface = \"s\"\n"
               "points = [{}]\ncorner_radius = {:.17g}\nradius = {:.17g}\n",
               list, corner_radius, radius) +
           test::run_for(duration, "start = \"given\"\n");
  }
};

}  // namespace

TEST_CASE("discs meet random outlines at the time and speed of their geometry", "[outline]") {
  std::mt19937 engine(20261130);
  int hits = 0, passes = 0, grazes = 0;
  for (int i = 0; i < 200; ++i) {
    const Flight flight(engine);
    double least = 0;
    const double t = flight.contact(least);
    const double speed = flight.velocity.norm(), size = speed + std::abs(flight.omega);
    if (std::isfinite(t) ? flight.rate(t) > -1e-4 * size : least < 1e-6) {
      ++grazes;
      continue;
    }
    const auto text = flight.text(std::isfinite(t) ? t + 1e-3 * flight.lasts : flight.lasts);
    const auto found = test::touches(test::finished(test::event_driven, text));
    CAPTURE(i, t, least, text);
    REQUIRE(found.empty() == !std::isfinite(t));
    (found.empty() ? passes : hits) += 1;
    if (found.empty()) continue;
    const auto& first = found.front();
    // Positions by the integrator to 1e-8 m, over the approach speed.
    CHECK(std::abs(first.t - t) < 1e-8 / -flight.rate(t) + 1e-12);
    CHECK(first.v_n_minus == Approx(flight.rate(t)).epsilon(1e-5));
    CHECK(first.v_n_plus == Approx(-flight.restitution * flight.rate(t)).margin(1e-5 * size));
  }
  CHECK(hits > 60);
  CHECK(passes > 20);
  CHECK(grazes < 10);
}
