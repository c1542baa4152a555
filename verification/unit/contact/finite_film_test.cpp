// Films of finite length against an independent solution of Reynolds' equation, the closed forms of short
// and long bearings, and Raimondi and Boyd's charts.
#include "formulations/contact/film.hpp"

#include <numbers>
#include <tuple>

#include "formulations/contact/steady_film.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/scene_text.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double pi = std::numbers::pi, radius = 0.05, clearance = 1e-4, viscosity = 0.1;

/// A film of L/D with a hand-over at c/1000.
Film film(double length, bool cavitated, Film::Kind kind = Film::Kind::finite_length) {
  return {
      kind,   cavitated, viscosity,        2 * radius * length,
      radius, clearance, 1e-3 * clearance, kind == Film::Kind::finite_length ? finite_film(length) : nullptr};
}
/// 12 μ R⁴/c³: force over G and speed.
constexpr double unit =
    12 * viscosity * radius * radius * radius * radius / (clearance * clearance * clearance);

/// G of a speed of 1 in the direction α.
std::array<double, 2> force(const Film& f, double epsilon, double angle) {
  const auto F = f.force<double>(epsilon, std::cos(angle), std::sin(angle));
  return {-F.radial / unit, -F.tangential / unit};
}

/// Reynolds' equation by finite volumes on equal cells of the whole film (720 × 48 and 360 × 24 cells of
/// half the length, extrapolated to order h²; python with scipy.sparse), five digits. G of the full film by
/// w_r and w_t; (G_r, G_t) of the positive pressure for α = 90°, 0 and 2.5 rad.
struct Reference {
  double length, epsilon;
  std::array<double, 2> full, tangential, closing, opening;
};
constexpr Reference references[] = {
    {1, 0.2, {1.7149, 1.5495}, {0.13973, 0.77475}, {1.2371, 0}, {-0.39127, 0.35538}},
    {1, 0.6, {5.1028, 2.1515}, {0.69767, 1.0758}, {4.8959, 0}, {-0.1882, 0.21754}},
    {1, 0.9, {53.614, 5.3289}, {4.4548, 2.6644}, {53.505, 0}, {-0.11484, 0.13874}},
    {0.5, 0.5, {0.65411, 0.3359}, {0.1037, 0.16795}, {0.61163, 0}, {-0.034299, 0.045802}},
    {0.5, 0.9, {17.501, 1.4519}, {1.4337, 0.72597}, {17.479, 0}, {-0.019241, 0.0308}},
    {0.25, 0.8, {0.80515, 0.12927}, {0.099451, 0.064635}, {0.80159, 0}, {-0.0024256, 0.0061751}},
    {2, 0.7, {25.143, 8.9048}, {3.1627, 4.4524}, {24.557, 0}, {-0.60901, 0.70958}}};

}  // namespace

TEST_CASE("films of finite length have the forces of Reynolds' equation", "[film]") {
  // The stated error: 3e-4 of the force, in openings 1e-3; the references have five digits.
  for (const auto& r : references) {
    CAPTURE(r.length, r.epsilon);
    const auto full = film(r.length, false), half = film(r.length, true);
    CHECK(force(full, r.epsilon, 0)[0] == Approx(r.full[0]).epsilon(3e-4));
    CHECK(force(full, r.epsilon, pi / 2)[1] == Approx(r.full[1]).epsilon(3e-4));
    for (const auto& [angle, G, relative] : {std::tuple{pi / 2, r.tangential, 3e-4},
                                             {-pi / 2, {r.tangential[0], -r.tangential[1]}, 3e-4},
                                             {0.0, r.closing, 3e-4},
                                             {2.5, r.opening, 1e-3}}) {
      CAPTURE(angle);
      const auto found = force(half, r.epsilon, angle);
      CHECK(std::hypot(found[0] - G[0], found[1] - G[1]) < relative * std::hypot(G[0], G[1]));
    }
  }
}

TEST_CASE("films of finite length approach the short and the long bearing", "[film]") {
  for (const double epsilon : {0.2, 0.5, 0.8})
    for (const bool cavitated : {false, true})
      for (const double angle : {0.0, 1.0, pi / 2, -pi / 2, 2.5}) {
        CAPTURE(epsilon, cavitated, angle);
        // Ocvirk neglects terms of the order (L/D)² over the square of the narrow gap's length 2(1 − ε):
        // 0.006 at ε = 0.8, times the second derivative of the profile, below 3.
        const auto found = force(film(0.05, cavitated), epsilon, angle),
                   exact = force(film(0.05, cavitated, Film::Kind::short_bearing), epsilon, angle);
        CHECK(std::hypot(found[0] - exact[0], found[1] - exact[1]) < 0.02 * std::hypot(exact[0], exact[1]));
      }
  // At L/D = 4 side flow takes the pressure from a length of about R at both ends: less than a third, and
  // less the narrower the gap.
  double last[2] = {0, 0};
  for (const double epsilon : {0.2, 0.5, 0.8, 0.95}) {
    CAPTURE(epsilon);
    const auto finite = film(4, false), infinite = film(4, false, Film::Kind::long_bearing);
    for (const int s : {0, 1}) {
      const double angle = s * pi / 2,
                   share = force(finite, epsilon, angle)[s] / force(infinite, epsilon, angle)[s];
      CHECK(share > std::max(2.0 / 3, last[s]));
      CHECK(share < 1);
      last[s] = share;
    }
  }
}

TEST_CASE("films of finite length dissipate, and have their exact derivatives", "[film]") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> part(0, 1);
  for (const bool cavitated : {false, true})
    for (int i = 0; i < 200; ++i) {
      const auto f = film(i % 2 ? 0.5 : 1.3, cavitated);
      const double epsilon = 0.999 * part(random), angle = 2 * pi * part(random), w = part(random) + 0.1;
      const std::array<double, 4> x{epsilon, w * std::cos(angle), w * std::sin(angle), 0};
      const auto at = [&](const std::array<double, 4>& y) { return f.force<double>(y[0], y[1], y[2]); };
      CAPTURE(cavitated, epsilon, angle, w);
      const auto F = at(x);
      CHECK(F.radial * x[1] + F.tangential * x[2] < 0);
      const auto y = directions_of<4>(x);
      const auto slopes = f.force<Dual<4>>(y[0], y[1], y[2]);
      CHECK(slopes.radial.value == Approx(F.radial));
      for (int k = 0; k < 3; ++k) {
        // Central differences: h² times third derivatives, which grow as (1 − ε)^(−3).
        const double h = 1e-5 * (k == 0 ? 1 - epsilon : w);
        auto up = x, down = x;
        up[k] += h;
        down[k] -= h;
        if (down[0] < 0) continue;
        const double size = std::hypot(F.radial, F.tangential) / (h * 1e5);
        CHECK(slopes.radial.slope[k] ==
              Approx((at(up).radial - at(down).radial) / (2 * h)).margin(1e-4 * size));
        CHECK(slopes.tangential.slope[k] ==
              Approx((at(up).tangential - at(down).tangential) / (2 * h)).margin(1e-4 * size));
      }
    }
}

TEST_CASE("finite films carry less than Raimondi and Boyd's, which rupture where the pressure rises",
          "[film]") {
  // A. A. Raimondi, J. Boyd, ASLE Trans. 1 (1958) 159: (ε, S, φ in degrees) of full journal bearings. Their
  // film ends where the pressure and its gradient vanish, beyond the widest range of positive pressure of the
  // half-Sommerfeld film. That film carries less, so that S and φ are greater at equal ε: hardly where side
  // flow dominates (small L/D and ε), by up to a quarter and 7° elsewhere.
  struct Row {
    double epsilon, sommerfeld, attitude;
  };
  const std::pair<double, std::vector<Row>> charts[] = {{1,
                                                         {{0.2, 0.631, 74.02},
                                                          {0.4, 0.264, 63.10},
                                                          {0.6, 0.121, 50.58},
                                                          {0.8, 0.0446, 36.24},
                                                          {0.9, 0.0188, 26.45}}},
                                                        {0.5,
                                                         {{0.2, 2.03, 74.94},
                                                          {0.4, 0.779, 61.45},
                                                          {0.6, 0.319, 48.14},
                                                          {0.8, 0.0923, 33.31},
                                                          {0.9, 0.0313, 23.66}}},
                                                        {0.25,
                                                         {{0.2, 7.57, 75.18},
                                                          {0.4, 2.83, 60.86},
                                                          {0.6, 1.07, 46.72},
                                                          {0.8, 0.261, 31.04},
                                                          {0.9, 0.0736, 21.85}}}};
  for (const auto& [length, rows] : charts)
    for (const auto& row : rows) {
      CAPTURE(length, row.epsilon);
      const auto s = steady_film(film(length, true), row.epsilon, 100);
      CHECK(s.sommerfeld / row.sommerfeld > 1);
      CHECK(s.sommerfeld / row.sommerfeld < 1.25);
      CHECK(s.attitude * 180 / pi - row.attitude > 0);
      CHECK(s.attitude * 180 / pi - row.attitude < 7);
      // The closed form of the short bearing, in its range of L/D ≤ 1/4 and outside.
      const auto plain = steady_film(film(length, true, Film::Kind::short_bearing), row.epsilon, 100);
      CHECK(plain.load > s.load);
    }
  // S = ℓ/(3π ε G) with G of the independent solution, at L/D = 1 and ε = 0.6.
  const auto s = steady_film(film(1, true), 0.6, 100);
  CHECK(s.sommerfeld == Approx(1 / (3 * pi * 0.6 * std::hypot(0.69767, 1.0758))).epsilon(3e-4));
  CHECK(s.attitude == Approx(std::atan2(1.0758, 0.69767)).epsilon(3e-4));
}

TEST_CASE("a rotor in a film of finite length stays at its equilibrium in every scheme", "[film][films]") {
  // L/D = 1, ε = 0.6: W = 6 μ R⁴ ω ε |G|/c² with G of the independent solution. Perturbations decay within
  // 1/ω = 0.01 s (m c ω²/W = 0.1 is far below the threshold); a force with an error of 1 % would move ε by
  // some 1e-3.
  const double omega = 100, e = 0.6 * clearance, phi = std::atan2(1.0758, 0.69767) - pi / 2,
               load = 0.5 * unit * omega * e * std::hypot(0.69767, 1.0758);
  const auto text =
      "gravity = [0, -9.81]\n" +
      test::body("rotor", load / 9.81, 1e3,
                 fmt::format("position = [{}, {}]\nangular_velocity = {}\n", e * std::cos(phi),
                             e * std::sin(phi), omega)) +
      test::pin("main", "ground", "rotor", {}, {},
                fmt::format("clearance = {}\nbearing_radius = {}\nbearing_length = {}\nsurface = \"s\"\n"
                            "lubricant = \"oil\"\n",
                            clearance, radius, 2 * radius)) +
      fmt::format("[lubricants.oil]\nviscosity = {}\nfilm = \"finite\"\n", viscosity) +
      "[surfaces.s]\nyoung = 207e9\npoisson = 0.3\nrestitution = 0.5\n" +
      test::run_for(0.05, "start = \"given\"\n");
  for (const auto& way :
       {test::fixed_steps(1e-5), test::chosen_steps, test::event_driven,
        test::Way{"rosenbrock4", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\""}}}) {
    CAPTURE(way.name);
    const auto end = test::finished(way, text).final_state;
    // The decrease of ω by the film's torque, some 10 N m of 1e3 kg m², is below 1e-5.
    CHECK(end.q[0] == Approx(e * std::cos(phi)).margin(1e-3 * clearance));
    CHECK(end.q[1] == Approx(e * std::sin(phi)).margin(1e-3 * clearance));
  }
}

TEST_CASE("finite films outside the range of their tables are refused", "[film]") {
  const auto refused = [](const std::string& keys) {
    const auto scene = read_scene(test::source_folder() / "cases/lubricated-pin/scene.toml",
                                  {"lubricants.oil.film=\"finite\"", keys});
    return test::refusal_of<ModelError>([&] { Simulation(scene, "nonsmooth"); });
  };
  CHECK_THAT(refused("joints.gudgeon.bearing_length=1e-3"),
             Contains("joints.gudgeon.bearing_length") && Contains("from 0.05 to 4, use \"short\""));
  CHECK_THAT(refused("joints.gudgeon.bearing_length=0.2"), Contains("use \"long\""));
  CHECK_THAT(refused("lubricants.oil.hand_over=1e-7"), Contains("lubricants.oil.hand_over"));
}
