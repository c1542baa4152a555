// First contacts of rollers and flat faces with waved cams, in every scheme, against brute force.
#include "dynamics/system.hpp"
#include "verification/references/cam_follower.hpp"
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A cam with 3 to 120 waves and a follower in free motion.
struct Flight {
  reference::CamFlight motion;
  double radius = 0, size = 1, end = 0;
  bool fixed = false, driven = false;  ///< the cam does not turn; is driven

  Flight() = default;
  explicit Flight(std::mt19937_64& engine) {
    const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(engine); };
    const auto chance = [&](double p) { return uniform(0, 1) < p; };
    const int waves = std::uniform_int_distribution(3, 120)(engine);
    motion.flat = chance(0.3);
    // Waves of a flat face's cam must leave its outline convex.
    const double high = motion.flat ? uniform(0.05, 0.8) / (waves * waves - 1) : uniform(0.02, 1.0) / waves,
                 phase = uniform(0, 6), uneven = chance(0.5) ? uniform(0, 0.5) : 0;
    std::vector<double> lift;
    const int n = 24 * waves;
    for (int i = 0; i < n; ++i) {
      const double phi = 2 * M_PI * i / n;
      lift.push_back(0.5 * high * (1 + std::sin(waves * phi + phase)) *
                     (motion.flat ? 1 : 1 + uneven * std::sin(2 * phi)));
    }
    motion.lift = reference::LiftTable(lift);
    if (!motion.flat)  // small enough for the crests
      for (radius = uniform(0.01, 1);; radius *= 0.5) {
        motion.base = 1 + radius;
        if (motion.shape().round > 1.05 * radius) break;
      }
    fixed = chance(0.2);
    driven = !fixed && chance(0.5);
    motion.turn = fixed ? 0 : (chance(0.5) ? 1 : -1) * std::pow(10, uniform(-1, 1.3));
    motion.angle = fixed ? 0 : uniform(-3, 3);
    const auto shape = motion.shape();
    const double to = uniform(-M_PI, M_PI), along = motion.flat ? uniform(-0.3, 0.3) : 0;
    // A third begins close to the cam, where a roller may be in a hollow.
    double away = shape.high + uniform(0.05, 1);
    if (chance(0.35))
      away = motion.base + motion.lift.at((motion.flat ? 0 : to) - motion.angle).h +
             std::pow(10, uniform(-3, -1));
    motion.x = away * std::cos(to) - along * std::sin(to);
    motion.y = away * std::sin(to) + along * std::cos(to);
    motion.face = to + M_PI / 2;
    if (motion.flat) {
      motion.spin = chance(0.3) ? uniform(-2, 2) : 0;
      away = motion.base + motion.lift.at(to - motion.angle).h + std::pow(10, uniform(-3, 0));
      motion.x = away * std::cos(to) - along * std::sin(to);
      motion.y = away * std::sin(to) + along * std::cos(to);
    }
    const double in = std::pow(10, uniform(-1.5, 0.7)), across = chance(0.5) ? uniform(-3, 3) : 0;
    motion.vx = -in * std::cos(to) - across * std::sin(to);
    motion.vy = -in * std::sin(to) + across * std::cos(to);
    const double gravity = chance(0.5) ? uniform(0, 10) : 0;
    motion.ax = -gravity * std::cos(to);
    motion.ay = -gravity * std::sin(to);
    end = std::min(uniform(1, 3) * away / in, 20 / (0.1 + std::abs(motion.turn)));
    size = std::ldexp(1, std::uniform_int_distribution(-10, 10)(engine));
  }

  /// kg; so that a compliant contact of any size takes about 0.1 ms: (m²/(R E*² v))^0.2 with R and v ~ size.
  double mass() const { return size; }
  std::string scene() const {
    std::string table;
    const auto n = motion.lift.y.size();
    for (std::size_t i = 0; i < n; ++i)
      table +=
          fmt::format("[{:.17g}, {:.17g}],\n", 2 * M_PI * static_cast<double>(i) / static_cast<double>(n),
                      size * motion.lift.y[i]);
    std::string text =
        fmt::format("gravity = [{:.17g}, {:.17g}]\n", size * motion.ax, size * motion.ay) +
        test::body(
            "follower", mass(), mass() * size * size,
            fmt::format("position = [{:.17g}, {:.17g}]\nvelocity = [{:.17g}, {:.17g}]\n"
                        "angular_velocity = {:.17g}\n",
                        size * motion.x, size * motion.y, size * motion.vx, size * motion.vy, motion.spin)) +
        test::surface("steel", 0.5, "young = 2e11\npoisson = 0.3\n") +
        fmt::format(
            R"([contacts.lobe]
type = "cam"
between = ["{}", "follower"]
surface = "steel"
base_radius = {:.17g}
lift_table = [{}]
{}
)",
            fixed ? "ground" : "cam", size * (motion.base - radius), table,
            motion.flat
                ? fmt::format("axis = [{:.17g}, {:.17g}]", std::cos(motion.face), std::sin(motion.face))
                : fmt::format("follower = \"roller\"\nroller_radius = {:.17g}", size * radius)) +
        test::run_for(end, "start = \"given\"\n");
    if (!fixed)
      text += test::body(
                  "cam", mass(), mass() * size * size,
                  fmt::format("angle = {:.17g}\nangular_velocity = {:.17g}\n", motion.angle, motion.turn)) +
              test::pin("pin", "ground", "cam");
    if (driven) text += fmt::format("[drives.motor]\njoint = \"pin\"\nspeed = {:.17g}\n", motion.turn);
    return text;
  }
};

/// Runs `count` scenes by every method; returns the number of runs with a contact.
int fly(unsigned seed, int count) {
  int onsets = 0;
  std::mt19937_64 engine(seed);
  for (int i = 0; i < count; ++i) {
    Flight f(engine);
    if (f.motion.gap(0) < 1e-6) continue;  // begins in contact
    const auto exact = f.motion.onset(f.end);
    // Within rounding and the error of steps, a grazing contact has no definite time.
    if (exact && exact->approach < 1e-3 * exact->fastest) continue;
    // A contact of the penalty formulation is reported at its end.
    const double whole = f.end;
    if (exact) f.end = exact->t + 0.05 * whole;
    const double step = f.end / 4000;
    for (const auto& way : test::with_integrators(
             {test::event_driven, test::automatic, test::chosen_steps, test::fixed_steps(step)})) {
      CAPTURE(seed, i, way.name, f.end, f.size, f.motion.flat);
      const auto found = test::touches(test::finished(way, f.scene()));
      REQUIRE(found.empty() == !exact);
      if (!exact) continue;
      ++onsets;
      // Motions are parabolas: located times are exact up to the error tolerance of steps, 1e-6 of
      // adaptive time steps; a fixed step finds the contact at its end.
      const double allowed = way.fixed() ? 2 * step : way.stepping() ? 2e-6 * whole : 1e-9 * whole;
      CHECK(found[0].t == Approx(exact->t).margin(allowed).epsilon(0));
    }
  }
  return onsets;
}

}  // namespace

TEST_CASE("gaps of waved cams are those of brute force, and stay above their bounds in flight", "[cam]") {
  std::mt19937_64 engine(62031);
  std::uniform_real_distribution<double> uniform(0, 1);
  int proved = 0;
  for (int i = 0; i < 60; ++i) {
    Flight f(engine);
    f.size = 1;
    const System system(parse_scene(f.scene(), "s.toml").mechanism);
    auto e = system.make_evaluation();
    ContactRow row;
    const auto at = [&](double t, std::vector<double>& q, std::vector<double>& v) {
      const auto& m = f.motion;
      q = {m.x + t * (m.vx + 0.5 * t * m.ax), m.y + t * (m.vy + 0.5 * t * m.ay), m.spin * t};
      v = {m.vx + t * m.ax, m.vy + t * m.ay, m.spin};
      if (!f.fixed) q.insert(q.end(), {0, 0, m.angle + m.turn * t}), v.insert(v.end(), {0, 0, m.turn});
      system.place(t, q.data(), e);
      system.contact(0, q.data(), v.data(), e, row);
      return Watched{row.gap, row.normal.dot(v.data())};
    };
    for (int j = 0; j < 20; ++j) {
      CAPTURE(i, j);
      // windows up to ten times the time of passing a crest
      const double h = std::pow(10, -4 + 3 * uniform(engine)) * f.end, t = uniform(engine) * f.end;
      std::vector<double> q, v, v0;
      const auto a = at(t, q, v);
      REQUIRE(a.value == Approx(f.motion.gap(t)).margin(1e-12));
      REQUIRE(system.gap(0, q.data(), e) == a.value);
      v0 = v;
      const auto b = at(t + h, q, v);
      MotionBounds bounds;
      bounds.duration = h;
      for (std::size_t c = 0; c < v.size(); ++c) {
        bounds.speed.push_back(std::max(std::abs(v0[c]), std::abs(v[c])));
        bounds.acceleration.push_back(std::abs(v[c] - v0[c]) / h);
      }
      const auto motion = system.gap_motion(0, bounds, q.data(), e);
      const double least = motion.least(a, b, h);
      const bool rises = motion.rises(a, b, h), falls = motion.falls(a, b, h);
      proved += least > 0 || rises || falls;
      std::vector<double> between;
      for (int k = 1; k <= 50; ++k) between.push_back(at(t + h * k / 50, q, v).value);
      // Bounds are those outside of the cam.
      if (std::min(a.value, *std::ranges::min_element(between)) < 0) continue;
      double before = a.value;
      for (const double y : between) {
        REQUIRE(y >= least - 1e-12);
        REQUIRE((!rises || y >= before - 1e-12));
        REQUIRE((!falls || y <= before + 1e-12));
        before = y;
      }
    }
  }
  CHECK(proved > 100);
}

TEST_CASE("first contacts with waved cams are those of brute force", "[cam]") { CHECK(fly(6203, 40) > 100); }

TEST_CASE("first contacts with 1,000 waved cams of two seeds are those of brute force", "[cam][.long]") {
  for (const unsigned seed : {620301u, 620302u}) CHECK(fly(seed, 1000) > 1000);
}

TEST_CASE("a roller that falls on a cam with 60 waves meets it where brute force does", "[cam]") {
  // centre from y = 60 mm; base radius 40 mm, lift 0.5 mm (1 + sin 60φ) every 0.25°, roller 0.5 mm
  Flight f;
  std::vector<double> y;
  for (int i = 0; i < 1440; ++i) y.push_back(0.5e-3 * (1 + std::sin(i * M_PI / 12)));
  f.motion.lift = reference::LiftTable(y);
  f.radius = 0.5e-3;
  f.motion.base = 0.0405;
  f.motion.turn = 15;
  f.motion.y = 0.06;
  f.motion.ay = -9.81;
  f.end = 0.0625;
  const auto exact = f.motion.onset(f.end);
  REQUIRE(exact);
  // Of the sine itself. The spline is up to 5/384 (π/12)⁴ 0.5 mm = 3e-8 m away, at 0.85 m/s.
  CHECK(exact->t == Approx(0.0614603722).margin(4e-8));
  for (const auto& way : {test::event_driven, test::automatic, test::chosen_steps, test::penalty}) {
    CAPTURE(way.name);
    CHECK(test::touch(test::finished(way, f.scene()), 0).t ==
          Approx(exact->t).margin(way.stepping() ? 2e-6 * f.end : 1e-10));
  }
}
