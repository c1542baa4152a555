// Motions of beams against independent solutions: spin-up, rotation, the IVP test set's crank.
#include <Eigen/Dense>
#include <complex>

#include "mechanism/beam.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Places of the pieces of a beam in one row.
struct Pieces {
  const test::MotionRow& row;
  std::size_t first;
  Vec2 place(std::size_t k) const { return {row.q[3 * (first + k)], row.q[3 * (first + k) + 1]}; }
  double angle(std::size_t k) const { return row.q[3 * (first + k) + 2]; }
};
std::size_t first_of(const Scene& scene) { return static_cast<std::size_t>(scene.mechanism.beams[0].first); }

/// The free end of a beam of n pieces and length L, along and across a line from the origin at the angle psi.
Vec2 tip(const Pieces& p, std::size_t n, double L, double psi) {
  const double half = 0.5 * L / static_cast<double>(n), a = p.angle(n - 1);
  const Vec2 end = p.place(n - 1) + Vec2{half * std::cos(a), half * std::sin(a)};
  return {std::cos(psi) * end.x() + std::sin(psi) * end.y(),
          -std::sin(psi) * end.x() + std::cos(psi) * end.y()};
}

}  // namespace

TEST_CASE("a flexible arm spins up as in Simo and Vu-Quoc's example", "[beams]") {
  // J. Appl. Mech. 53 (1986) 855: L = 10 m, EA = 2.8e7 N, κGA = 1e7 N, EI = 1.4e4 N m², ρA = 1.2 kg/m, ρI = 6e-4 kg m;
  // the speed rises to 6 rad/s in 15 s as a cycloid. The tip along and across the rigid arm, by an independent
  // geometrically exact rod (spectral Galerkin, digits from degrees 8 and 10), and the steady extension
  // tan(aL)/a − L, a² = ρA ω²/EA.
  const auto scene_with = [](int n, double step) {
    const auto text = test::body("hub", 1, 1, "position = [0.0, 0.0]\nangle = 0.0\n") +
                      test::pin("axis", "ground", "hub") +
                      test::curve("spin", "ramp", "to = 6.0\nrise = 15.0\nprofile = \"cycloidal\"\n") +
                      test::drive("motor", "axis", "velocity = \"spin\"\n") +
                      fmt::format(
                          "[beams.arm]\nbetween = [\"hub\", \"free\"]\nlength = 10.0\nelements = {}\n"
                          "young = 2.8e7\ndensity = 1.2\narea = 1.0\nsecond_moment = 5e-4\n"
                          "shear_modulus = 1e7\nshear_factor = 1.0\n",
                          n) +
                      test::run_for(20);
    return test::scene_by(test::fixed_steps(step), text);
  };
  const auto tip_of = [](const Scene& scene, const test::MotionRow& row) {
    const double t = row.t, turned = 15 / (2 * std::numbers::pi),
                 psi =
                     t < 15 ? 0.4 * (0.5 * t * t + turned * turned * (std::cos(t / turned) - 1)) : 6 * t - 45;
    return tip({row, first_of(scene)}, static_cast<std::size_t>(scene.mechanism.beams[0].elements), 10, psi);
  };
  struct At {
    double t, u1, u2;
  };
  const std::vector<At> known{{1, -2.43634009e-5, -2.054353197e-2},
                              {5, -1.265463625e-2, -4.684761834e-1},
                              {6.5, -1.860342132e-2, -5.699483684e-1},
                              {10, -7.07233630e-3, -3.62814516e-1}};
  const auto error = [&](double h) {
    const auto scene = scene_with(static_cast<int>(std::round(1 / h)), 1e-3);
    const auto run = test::motion_rows(scene, Family::nonsmooth, 0.05);
    double most = 0;
    for (const auto& row : run.rows)
      for (const auto& at : known)
        if (std::abs(row.t - at.t) < 1e-9) {
          const auto u = tip_of(scene, row);
          most = std::max({most, std::abs(u.x() - 10 - at.u1), std::abs(u.y() - at.u2)});
        }
    return most;
  };
  test::check_order({1.0 / 6, 1.0 / 12, 1.0 / 24}, error, 1.6, 2.4);
  CHECK(error(1.0 / 24) < 1.5e-3);

  // Mean over many periods of the free axial vibration, 1e-3 of the extension. Masses in the middles: smaller by 1/(4n²).
  // The chord of a step is shorter than its arc, so that the length on the circle is greater by (ωh)²/8, 1.4e-3 of the
  // extension; the remaining bending vibration of 3.6 mm shortens the arm by 0.6 u²/L, 7e-4 of it on average.
  const auto scene = scene_with(12, 1.25e-4);
  const auto run = test::motion_rows(scene, Family::nonsmooth, 0.05);
  double extension = 0;
  int count = 0;
  for (const auto& row : run.rows)
    if (row.t > 15) extension += tip_of(scene, row).x() - 10, ++count;
  CHECK(extension / count == Approx(5.143174550e-4 * (1 - 0.25 / (12 * 12))).epsilon(2e-3));
}

TEST_CASE("a rotating beam has the frequencies of Southwell and Wright", "[beams]") {
  // μ = ω √(ρA L⁴/EI) of the first mode in the plane of rotation, for γ = Ω √(ρA L⁴/EI), by Ritz's method with 22 powers in
  // 60-digit arithmetic; out of the plane, μ² + γ², it has the digits of Wright, Smith, Thresher and Wang, J. Appl.
  // Mech. 49 (1982) 197. A slightly curved beam begins to swing about its stretched shape. Damping stops the axial vibration
  // of the start, whose tension would excite bending modes of half its frequency.
  struct Known {
    double gamma, mu;
  };
  for (const auto& known : {Known{2, 3.6217969641}, Known{6, 4.2632254202}, Known{12, 5.4270492778}}) {
    CAPTURE(known.gamma);
    const auto error = [&](double h) {
      const int n = static_cast<int>(std::round(1 / h));
      const auto text =
          test::body("hub", 1, 1, "position = [0.0, 0.0]\nangle = 0.0\n") +
          test::pin("axis", "ground", "hub") + test::motor("motor", "axis", known.gamma) +
          fmt::format(
              "[beams.rod]\nbetween = [\"hub\", \"free\"]\nlength = 1.0\nelements = {}\n"
              "young = 1e6\ndensity = 1.0\narea = 1.0\nsecond_moment = 1e-6\ncurvature = 0.01\ndamping = 1e-4\n",
              n) +
          test::run_for(16);
      const auto scene = test::scene_by(test::fixed_steps(5e-4), text);
      const auto run = test::motion_rows(scene, Family::nonsmooth, 0.01);
      // The phase of its first harmonic in two halves, by least squares with a constant, under Hann's window.
      std::array<Eigen::Matrix3d, 2> A{Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
      std::array<Eigen::Vector3d, 2> b{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
      for (const auto& row : run.rows) {
        const double y = tip({row, first_of(scene)}, static_cast<std::size_t>(n), 1, known.gamma * row.t).y();
        const std::size_t half = row.t < 8 ? 0 : 1;
        const double s = std::sin(std::numbers::pi * (row.t - 8.0 * static_cast<double>(half)) / 8);
        const Eigen::Vector3d x{1, std::cos(known.mu * row.t), std::sin(known.mu * row.t)};
        A[half] += s * s * x * x.transpose();
        b[half] += s * s * y * x;
      }
      std::array<std::complex<double>, 2> phase;
      for (const std::size_t half : {0, 1}) {
        const Eigen::Vector3d c = A[half].ldlt().solve(b[half]);
        phase[half] = {c[1], -c[2]};
      }
      return std::abs(std::arg(phase[1] / phase[0]) / 8 / known.mu);
    };
    // The finite EA couples by γ² EI/(EA L²) = 1.4e-4 for γ = 12, steps have errors of (Ωh)².
    CHECK(error(1.0 / 16) < 4e-4);
    if (known.gamma == 2) test::check_order({1.0 / 4, 1.0 / 8, 1.0 / 16}, error, 1.7, 2.3);
  }
}

TEST_CASE("the IVP test set's crank with an elastic rod", "[beams]") {
  // B. Simeon, Math. Modelling of Systems 2 (1996) 1: crank 0.15 m at 150 rad/s, rod 0.30 m × 8 mm × 8 mm of steel,
  // slider 0.075552 kg. Its second start, a straight rod that moves rigidly; its model lacks the stiffness by normal forces,
  // which changes the deflection by a quarter. An independent geometrically exact rod (degrees 8 and 10) has at 0.1 s
  // the slider at 0.1697534681 m, with axial vibrations of 1.7e-5 m whose phase pieces do not keep, and the first sine amplitude −5.0085e-5 m. A frequency of
  // 1277 rad/s makes 128 rad: pieces have errors of second order in its phase.
  const auto found = [](int n) {
    const auto text =
        test::body("crank", 1, 1) + test::body("big_eye", 1e-4, 1e-9) + test::body("eye", 1e-4, 1e-9) +
        test::body("slider", 0.075552, 1e-4) + test::pin("main", "ground", "crank") +
        test::pin("big_end", "crank", "big_eye", {0.15, 0}) + test::pin("gudgeon", "eye", "slider") +
        test::guide("guide", "ground", "slider") +
        test::motor("motor", "main", 150, "initial_angle = 0.0\n") +
        fmt::format(
            "[beams.rod]\nbetween = [\"big_eye\", \"eye\"]\nlength = 0.3\nelements = {}\nyoung = 2e11\n"
            "density = 7870\nsection = \"rectangle\"\nwidth = 8e-3\nheight = 8e-3\n",
            n) +
        "[assembly]\napproximate = true\n" + test::run_for(0.1);
    const auto scene = test::scene_by(test::fixed_steps(1e-5), text);
    const auto run = test::motion_rows(scene, Family::nonsmooth, 0.1);
    const auto& row = run.rows.back();
    const Vec2 a{row.q[3], row.q[4]}, chord = Vec2{row.q[6], row.q[7]} - a;
    double amplitude = 0;
    for (int k = 0; k < n; ++k) {
      const Vec2 d = Pieces{row, first_of(scene)}.place(static_cast<std::size_t>(k)) - a;
      amplitude += 2.0 / n * std::sin(std::numbers::pi * (k + 0.5) / n) * cross(chord, d) / chord.norm();
    }
    return std::pair{row.q[9], amplitude};
  };
  test::check_order(
      {1.0 / 12, 1.0 / 24, 1.0 / 48},
      [&](double h) {
        const auto [x, amplitude] = found(static_cast<int>(std::round(1 / h)));
        CHECK(std::abs(x - 0.16975346807) < 3.4e-5);
        return std::abs(amplitude + 5.0085e-5);
      },
      1.5, 2.5);
  CHECK(std::abs(found(48).second + 5.0085e-5) < 2e-5);
}

TEST_CASE("a beam between a pin and a roller bends to the elastica", "[beams]") {
  // Central force F = 8 EI/L²: mid deflection 0.1508603869 L, distance of the supports 0.9435667638 L (elliptic integrals).
  const auto error = [](double h) {
    const int n = static_cast<int>(std::round(1 / h));
    const auto text = test::body("a", 1e-3, 1e-6, "position = [0.0, 0.0]\nangle = 0.0\n") +
                      test::body("b", 1e-3, 1e-6, "position = [1.0, 0.0]\nangle = 0.0\n") +
                      test::body("roller", 1e-3, 1e-6, "position = [1.0, 0.0]\nangle = 0.0\n") +
                      test::pin("A", "ground", "a") + test::pin("B", "roller", "b") +
                      test::guide("way", "ground", "roller") +
                      fmt::format(
                          "[beams.rod]\nbetween = [\"a\", \"b\"]\nlength = 1.0\nelements = {}\nyoung = 1e7\n"
                          "density = 1.0\narea = 1.0\nsecond_moment = 1e-7\n",
                          n) +
                      test::force("f", fmt::format("rod-{}", (n + 1) / 2), {0, -8}) +
                      test::run_for(1e-3, "start = \"equilibrium\"\n");
    const auto scene = test::scene_by(test::fixed_steps(1e-3), text);
    const auto row = test::motion_rows(scene, Family::nonsmooth, 1e-3).rows.front();
    const auto middle = Pieces{row, first_of(scene)}.place(static_cast<std::size_t>(n / 2));
    return std::hypot(-middle.y() - 0.1508603868999, row.q[6] - 0.9435667637166);
  };
  test::check_order({1.0 / 5, 1.0 / 9, 1.0 / 17}, error, 3.3, 4.7);
  CHECK(error(1.0 / 17) < 2e-5);
}

TEST_CASE("a heavy cable swings as a chain of point masses on rods", "[beams]") {
  // EA = 1e9 N and EI = 1e-9 N m² leave strains of 1e-8. The chain has the masses of the pieces on massless rods, the
  // first half as long. A cable bends within its pieces, so that both approach each other: with the first order, because
  // the start, at rest and straight 0.1 rad from the vertical, is not smooth at the pin. Damping of axial vibration
  // keeps the cable under tension; fixed steps of 0.25 ms change the place of its last piece by 1e-4 m.
  const double turn = 0.1 - 0.5 * std::numbers::pi;
  const Vec2 along{std::cos(turn), std::sin(turn)};
  const auto error = [&](double h) {
    const int n = static_cast<int>(std::round(1 / h));
    std::string chain = "gravity = [0.0, -9.81]\n", cable = chain;
    for (int k = 0; k < n; ++k) {
      const auto at = along * ((k + 0.5) / n);
      const auto name = fmt::format("m{}", k);
      chain +=
          test::body(name, 1.0 / n, 1, fmt::format("position = [{}, {}]\n", at.x(), at.y())) +
          test::rod("r" + name, k > 0 ? fmt::format("m{}", k - 1) : "ground", name, (k > 0 ? 1.0 : 0.5) / n);
    }
    cable +=
        test::body("top", 1, 1e-9, fmt::format("position = [0.0, 0.0]\nangle = {}\n", turn)) +
        test::pin("pin", "ground", "top") +
        fmt::format(
            "[beams.rod]\nbetween = [\"top\", \"free\"]\nlength = 1.0\nelements = {}\nyoung = 1e9\ndensity = 1.0\n"
            "area = 1.0\nsecond_moment = 1e-18\ndamping = 1e-4\n",
            n);
    const auto end = test::run_for(1.5);
    const auto exact =
        test::motion_rows(test::scene_by(test::event_driven, chain + end), Family::nonsmooth, 0.05);
    const auto scene = test::scene_by(test::fixed_steps(2.5e-4), cable + end);
    const auto run = test::motion_rows(scene, Family::nonsmooth, 0.05);
    REQUIRE(run.rows.size() == exact.rows.size());
    const auto last = static_cast<std::size_t>(n) - 1;
    double most = 0;
    for (std::size_t i = 0; i < run.rows.size(); ++i) {
      const auto& q = exact.rows[i].q;
      most = std::max(
          most,
          (Pieces{run.rows[i], first_of(scene)}.place(last) - Vec2{q[3 * last], q[3 * last + 1]}).norm());
    }
    return most;
  };
  test::check_order({1.0 / 4, 1.0 / 8, 1.0 / 16}, error, 0.6, 1.2);
  CHECK(error(1.0 / 16) < 3e-3);
}
