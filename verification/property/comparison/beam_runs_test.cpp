// Beams in runs: fixed steps beyond the periods of axial waves, section forces, balances of forces, strain gauges.
#include "dynamics/assembly/assembly.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/beam.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A steel strip of 500 mm × 20 mm × 5 mm from the ground along x, with a tip of 0.2 kg.
std::string strip(const std::string& tip, const std::string& more = "") {
  return test::body("tip", 0.2, 1e-5, "position = [0.5, 0.0]\nangle = 0.0\n" + tip) +
         "[beams.strip]\nbetween = [\"ground\", \"tip\"]\nlength = 0.5\nyoung = 2.1e11\ndensity = 7850\n"
         "section = \"rectangle\"\nwidth = 20e-3\nheight = 5e-3\n" +
         more;
}
constexpr double EI = 2.1e11 * 20e-3 * 5e-3 * 5e-3 * 5e-3 / 12, EA = 2.1e11 * 20e-3 * 5e-3;

}  // namespace

TEST_CASE("fixed steps far beyond the periods of axial waves keep order and energy", "[beams]") {
  // Axial waves between pieces have up to 1.65e5 rad/s: explicit steps end at 12 µs. The first bending period is 0.1 s;
  // damping leaves hardly anything of modes from the third on, 1e3 rad/s, so that steps of 0.4 ms resolve the motion.
  const auto text = strip("velocity = [0.0, 0.1]\n", "damping = 1e-4\n") + test::run_for(0.2);
  const auto at_end = [&](const test::Way& way) {
    const auto motion = test::motion_rows(test::scene_by(way, text), Family::nonsmooth, 0.2);
    const auto& ledger = motion.run.ledger;
    return std::pair{motion.rows.back().q[1], std::abs(ledger.closure()) / ledger.scale()};
  };
  const double exact = at_end(test::event_driven).first;
  const auto error = [&](double h) {
    const auto [y, lost] = at_end(test::fixed_steps(h));
    CHECK(lost < 1e-4);
    return std::abs(y - exact);
  };
  test::check_order({4e-4, 2e-4, 1e-4, 5e-5}, error, 1.7, 2.3);
}

TEST_CASE("damped beams need no short fixed steps", "[beams]") {
  // The first mode decays by ω τ/2 of a period: amplitude exp(−ω² τ t/2), ω² = 3 EI/(L³ (m + 33/140 ρAL)) to 1 %.
  const double mass = 0.2 + 33.0 / 140 * 7850 * 20e-3 * 5e-3 * 0.5, square = 3 * EI / (0.125 * mass),
               tau = 2e-3;
  const auto text = strip("velocity = [0.0, 0.1]\n", fmt::format("damping = {}\n", tau)) + test::run_for(0.5);
  const auto motion =
      test::motion_rows(test::scene_by(test::fixed_steps(1e-3), text), Family::nonsmooth, 1e-3);
  const auto peak = [&](double from, double to) {
    double most = 0;
    for (const auto& row : motion.rows)
      if (row.t >= from && row.t < to) most = std::max(most, std::abs(row.q[1]));
    return most;
  };
  const double w = std::sqrt(square), half = std::numbers::pi / w;
  CHECK(std::log(peak(0, half) / peak(4 * half, 5 * half)) == Approx(2 * half * square * tau).epsilon(0.05));
}

TEST_CASE("sections of a beam have the forces and moments of statics", "[beams]") {
  // N = H and Q = P along the strip, M = P (L − x) about the small deflection; strain at the clamp on the left side.
  const double H = 20, P = 0.01;
  const auto text =
      strip("") + test::force("f", "tip", {H, P}) +
      "[instruments.gauge]\ntype = \"strain-gauge\"\nbeam = \"strip\"\nplace = 0.0\noffset = 2.5e-3\n"
      "bandwidth = 1000\nsampling = 5000\n" +
      test::run_for(0.02) + "start = \"equilibrium\"\n";
  // The tolerance of the penalty formulation, 1e-8 of 0.5 m, is 1.7 N for EA/l of 3e8 N/m; a tenth of it is seen.
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-3), test::penalty}) {
    CAPTURE(way.name);
    const double rounding = way.penalty() ? 0.17 : 1e-9;  // N
    const auto scene = test::scene_by(way, text);
    Simulation simulation(scene, test::name_of(way.family));
    test::LastForces forces;
    test::Listener gauge;
    double strain = 0;
    gauge.on_sample = [&](std::size_t, double, double value) { strain = value; };
    test::finished(simulation, {&forces, &gauge});
    const double shortened = P * 0.125 / (3 * EI);  // deflection of the tip, on which H acts
    for (int n = 0; n <= 8; ++n) {
      CAPTURE(n);
      const auto at = std::ranges::find(forces.elements, fmt::format("strip-{}", n + 1), &ForceElement::name);
      REQUIRE(at != forces.elements.end());
      const auto& f = forces.now.elements[static_cast<std::size_t>(at - forces.elements.begin())];
      const double arm = 0.5 - n * 0.0625;
      CHECK(f.fn == Approx(H).margin(rounding).epsilon(1e-6));
      CHECK(std::abs(f.bending - P * arm) < 2 * H * shortened + 1e-9 + 1e-3 * rounding);
      CHECK(std::abs(f.ft - P) < H * 2 * shortened / 0.5 + 1e-9 + rounding);
    }
    const auto& clamp = *std::ranges::find(forces.elements, "strip-1", &ForceElement::name);
    const auto& f = forces.now.elements[static_cast<std::size_t>(&clamp - forces.elements.data())];
    if (!way.penalty()) CHECK(strain == Approx(f.fn / EA - 2.5e-3 * f.bending / EI).epsilon(1e-3));
  }
}

TEST_CASE("forces of beams balance the motion of their pieces", "[beams]") {
  // Newton's and Euler's equations of each piece by the recorded forces, and momentum by their impulses.
  const auto text =
      test::body("a", 0.3, 1e-4,
                 "position = [0.0, 0.0]\nangle = 0.0\nvelocity = [0.0, 1.0]\nangular_velocity = 3.0\n") +
      test::body("b", 0.2, 1e-4, "position = [0.5, 0.0]\nangle = 0.0\nvelocity = [0.2, -1.0]\n") +
      "[beams.rod]\nbetween = [\"a\", \"b\"]\nat = [[0.01, 0.02], [-0.02, 0.0]]\nlength = 0.47\nelements = 4\n"
      "young = 1e8\ndensity = 1000\nsection = \"rectangle\"\nwidth = 0.01\nheight = 0.01\ndamping = 1e-4\n" +
      test::run_for(0.05);
  for (const auto& way :
       {test::event_driven, test::penalty, test::fixed_steps(1e-5), test::fixed_steps(2e-3)}) {
    CAPTURE(way.name, way.step);
    const auto scene = test::scene_by(way, text);
    Simulation simulation(scene, test::name_of(way.family));
    verification::BalanceWatch watch(scene.mechanism, way.fixed(), 0.01, 1);
    test::finished(simulation, {&watch});
    // Impulses of adaptive methods are integrals of their dense output.
    const double most = way.fixed() ? 1e-9 : 2e-6;
    CHECK(watch.linear() < most);
    CHECK(watch.angular() < most);
  }
}

namespace {

/// The slider-crank of cases/flores2011 with a rod of 14.33 mm × 20 mm between two eyes, its modulus multiplied by
/// `stiffer`; infinite: the rigid rod of the same masses. `gudgeon`: keys of the pin.
std::string rig(double stiffer, const std::string& gudgeon, int elements = 6) {
  const double L = 0.3, h = 14.33e-3, w = 20e-3, rho = 7850, A = h * w, I = w * h * h * h / 12, eye = 0.2275,
               eye_inertia = 5e-5, rod = rho * A * L;
  const auto frame = test::body("crank", 17.9, 0.460327) + test::body("slider", 1.013, 0.000772) +
                     test::pin("main", "ground", "crank") + test::guide("guide", "ground", "slider") +
                     test::motor("motor", "main", 20.94);
  if (std::isinf(stiffer))
    return frame +
           test::body("rod", rod + 2 * eye,
                      rod * L * L / 12 + rho * I * L + 2 * (eye * L * L / 4 + eye_inertia)) +
           test::pin("big_end", "crank", "rod", {0.05, 0}, {-L / 2, 0}) +
           test::pin("gudgeon", "rod", "slider", {L / 2, 0}, {}, gudgeon);
  return frame + test::body("big_eye", eye, eye_inertia) + test::body("eye", eye, eye_inertia) +
         test::pin("big_end", "crank", "big_eye", {0.05, 0}) +
         test::pin("gudgeon", "eye", "slider", {}, {}, gudgeon) +
         fmt::format(
             "[beams.rod]\nbetween = [\"big_eye\", \"eye\"]\nlength = {}\nelements = {}\nyoung = {}\n"
             "density = {}\nsection = \"rectangle\"\nwidth = {}\nheight = {}\n",
             L, elements, 207e9 * stiffer, rho, w, h);
}

}  // namespace

TEST_CASE("a stiff rod tends to the rigid rod with the first order in 1/EI", "[beams]") {
  // The angle of the rod's middle, in the mechanism without clearance.
  for (const auto& way :
       {test::fixed_steps(1e-4),
        test::Way{"penalty", Family::penalty, {}, 0, {"penalty.integrator=\"rosenbrock4\""}}}) {
    CAPTURE(way.name);
    const auto angles = [&](double stiffer) {
      const auto scene = test::scene_by(way, rig(stiffer, "", 4) + test::run_for(0.02));
      const auto& bodies = scene.mechanism.bodies;
      const auto at = static_cast<std::size_t>(
          std::ranges::find(bodies, std::isinf(stiffer) ? "rod" : "rod-2", &Body::name) - bodies.begin());
      std::vector<double> list;
      for (const auto& row : test::motion_rows(scene, way.family, 1e-3).rows)
        list.push_back(row.q[3 * at + 2]);
      return list;
    };
    const auto rigid = angles(INFINITY);
    const auto error = [&](double compliance) {
      const auto bent = angles(1 / compliance);
      double most = 0;
      for (std::size_t i = 0; i < rigid.size(); ++i)
        most = std::max(most, std::abs(std::remainder(bent[i] - rigid[i], 2 * std::numbers::pi)));
      return most;
    };
    test::check_order({1, 0.25, 0.0625}, error, 0.8, 1.2);
  }
}

TEST_CASE("the first impact of a stiff rod tends to that of the rigid rod", "[beams]") {
  const auto pin = test::loose(0.25e-3, 11.125e-3);
  const auto more = test::surface("s", 0.46, "young = 207e9\npoisson = 0.3\n") + test::run_for(0.03) +
                    "start = \"ideal\"\n";
  for (const auto& way : {test::event_driven, test::penalty}) {
    CAPTURE(way.name);
    const auto onset = [&](double stiffer) {
      return test::touch(test::finished(way, rig(stiffer, pin, 4) + more), 0).t;
    };
    const double rigid = onset(INFINITY);
    test::check_order(
        {1, 0.25, 0.0625}, [&](double c) { return std::abs(onset(1 / c) - rigid); }, 0.7, 1.3);
  }
}

TEST_CASE("a reduced beam keeps its motion in fixed steps beyond its axial vibration", "[beams]") {
  // Half of the pieces' modes; the deflection of the damped strip against the event-driven run of the same scene.
  const auto text = strip("velocity = [0.0, 0.1]\n", "modes = 4\ndamping = 1e-4\n") + test::run_for(0.2);
  const auto run = [&](const test::Way& way) {
    return test::motion_rows(test::scene_by(way, text), Family::nonsmooth, 0.2);
  };
  const double exact = run(test::event_driven).rows.back().q[1];
  const auto error = [&](double h) {
    const auto motion = run(test::fixed_steps(h));
    CHECK(std::abs(motion.run.ledger.closure()) < 1e-4 * motion.run.ledger.scale());
    CHECK(motion.run.work.rhs <= 4 * motion.run.work.steps);  // the damping is implicit
    return std::abs(motion.rows.back().q[1] - exact);
  };
  test::check_order({4e-4, 2e-4, 1e-4}, error, 1.7, 2.3);
}
