// One formulation against the other: the stiff limit on three mechanisms, and statistics of long runs.
#include <algorithm>
#include <boost/math/distributions/students_t.hpp>

#include <fmt/format.h>

#include "formulations/make.hpp"
#include "sim/recorder.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {
namespace {

/// The exponent of K by which the second impact of a scene approaches the impact law's, over four decades of
/// K.
void limit(Findings& f, const std::string& name, Scene scene) {
  scene.run.discard = 0;
  scene.accelerometers.clear();
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = test::touches(test::simulate(scene, Family::nonsmooth)).at(1);
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-11;
  std::vector<double> K, errors[3];
  for (const double factor : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    auto stiff = scene;
    stiff.mechanism.surfaces[0].young = *scene.mechanism.surfaces[0].young * factor;
    const auto touch = test::touches(test::simulate(stiff, Family::penalty)).at(1);
    K.push_back(factor);
    errors[0].push_back(std::abs(touch.t - exact.t));
    errors[1].push_back(std::abs(touch.v_n_minus - exact.v_n_minus));
    errors[2].push_back(std::abs(touch.impulse_n - exact.impulse_n));
  }
  const char* quantity[] = {"time", "approach speed", "impulse"};
  for (int i = 0; i < 3; ++i) {
    f.between(fmt::format("{}: exponent of K, {} of the second impact", name, quantity[i]), "",
              test::observed_order(K, errors[i]), -0.43, -0.37, "−2/5: the contact time (Hertz)",
              "the next order bends it by up to 0.02 at K × 1");
    f.curves.push_back({"stiff_limit", name + ", " + quantity[i], "stiffness over the scene's",
                        "difference (s, m/s, N s)", K, errors[i]});
  }
}

/// A block that the set-valued law holds on a slope creeps under a regularised one, at the speed where its
/// friction balances the pull: Ambrósio's rises from v₀ to v₁, so v = v₀ + (v₁ − v₀) tan α/μ, and the creep
/// vanishes with v₁. Contacts that begin at rest are overdamped: the implicit integrator's case.
void friction_limit(Findings& f) {
  std::vector<double> speeds, creeps;
  for (const double v1 : {1e-2, 1e-3, 1e-4}) {
    auto scene = read_scene(test::scene_file("block_on_slope"));
    scene.mechanism.surfaces[0].young = 1e9;
    scene.mechanism.surfaces[0].poisson = 0.3;
    for (auto& contact : scene.mechanism.contacts) {
      auto& foot = std::get<PlaneContact>(contact);
      foot.radius = 0.01;
      foot.at[1].y() += 0.01;
    }
    for (auto& body : scene.mechanism.bodies) body.velocity = {0, 0};
    scene.penalty.integrator = Integrator::rosenbrock4;
    scene.penalty.friction_v0 = 0.1 * v1;
    scene.penalty.friction_v1 = v1;
    scene.run.duration = 1;
    const double v = -test::simulate(scene, Family::penalty).final_state.v[0];
    f.relative(fmt::format("creep of a held block at v₁ = {} m/s", v1), "m/s", v,
               0.1 * v1 + 0.9 * v1 * std::tan(20 * M_PI / 180) / 0.5, 1e-2, "v₀ + (v₁ − v₀) tan α/μ",
               "the feet still sink by some 1e-6 m/s after 1 s, and their depth turns the friction's arm");
    speeds.push_back(v1);
    creeps.push_back(v);
  }
  f.between("order in v₁ by which the creep vanishes", "", test::observed_order(speeds, creeps), 0.99, 1.01,
            "1, from the same balance", "1e-2 over two decades");
}

}  // namespace

Findings stiff_limit() {
  Findings f;
  friction_limit(f);
  auto rig = read_scene(test::flores());
  rig.run.duration = 0.0095;
  limit(f, "the paper's rig", rig);
  auto four_bar = read_scene(test::scene_file("four_bar_two"));
  four_bar.run.duration = 0.035;
  four_bar.mechanism.surfaces[0].friction.reset();
  limit(f, "four-bar with two loose pins", four_bar);
  auto guide = read_scene(test::source_folder() / "cases/flores2010-translational/scene.toml");
  guide.mechanism.bodies[2].angular_velocity = 3;
  guide.mechanism.surfaces[0].friction.reset();
  guide.mechanism.surfaces[0].young = 207e11;
  guide.run.duration = 0.0027;
  limit(f, "slider loose in its guide", guide);
  return f;
}

namespace {

/// Of the journal's orbit over revolutions 3 to 8: the mean of e_x/c, and the share of time with e_y > 0.
std::pair<double, double> watch(const Scene& scene, Family family) {
  const System system(scene.mechanism);
  const auto formulation = make(family, scene, system, assemble(scene.mechanism, scene.run.start));
  Recorder recorder(scene, system, std::nullopt);
  auto e = system.make_evaluation();
  double along = 0, upper = 0;
  int samples = 0;
  for (double t = 0.6; t <= 2.4; t += 1e-3, ++samples) {
    formulation->run(t, recorder);
    const auto state = formulation->state();
    system.place(t, state.q.data(), e);
    const auto d = system.eccentricity(0, state.q.data(), e);
    along += d.x() / 0.25e-3;
    upper += d.y() > 0;
  }
  return {along / samples, upper / samples};
}

}  // namespace

/// Means over revolutions 3 to 8 of runs from perturbed starts, in both formulations, by Welch's test.
Findings statistics() {
  Findings f;
  constexpr int starts = 12;
  struct Sample {
    std::vector<double> value[2];  // penalty, nonsmooth
  };
  Sample lasting, dissipated, spread, impulse, along, upper;
  for (int i = 0; i < starts; ++i) {
    auto scene = read_scene(test::flores());
    scene.accelerometers.clear();
    scene.mechanism.surfaces[0].young = 207e9 * 1e3;
    scene.run.duration = 8 * 0.3;
    scene.run.discard = 2 * 0.3;
    auto state = assemble(scene.mechanism, RunOptions::Start::ideal);
    // The journal starts off centre, at angles around the circle.
    const double angle = 2 * M_PI * i / starts;
    const int slider = 2;
    for (std::size_t b = 0; b < scene.mechanism.bodies.size(); ++b) {
      auto& body = scene.mechanism.bodies[b];
      body.position = {state.q[3 * b], state.q[3 * b + 1]};
      body.angle = state.q[3 * b + 2];
      body.velocity = {state.v[3 * b], state.v[3 * b + 1]};
      body.angular_velocity = state.v[3 * b + 2];
    }
    scene.mechanism.bodies[slider].position.x() += 0.5 * 0.25e-3 * std::cos(angle);
    scene.mechanism.bodies[slider].velocity.x() += 0.02 * std::sin(angle);
    scene.run.start = RunOptions::Start::given;
    for (const auto family : {Family::penalty, Family::nonsmooth}) {
      const auto orbit = watch(scene, family);
      along.value[family == Family::nonsmooth].push_back(orbit.first);
      upper.value[family == Family::nonsmooth].push_back(orbit.second);
      const auto run = test::simulate(scene, family);
      const int k = family == Family::nonsmooth;
      lasting.value[k].push_back(1 - run.contacts[0].flight_fraction);
      impulse.value[k].push_back(run.contacts[0].greatest_impulse);
      dissipated.value[k].push_back((run.ledger.contact + run.ledger.friction) / 8);
      spread.value[k].push_back(run.contacts[0].fastest_approach);
    }
  }
  const auto claim = [&](const std::string& what, const std::string& unit, const Sample& s) {
    double mean[2], variance[2];
    for (int k : {0, 1}) {
      mean[k] = variance[k] = 0;
      for (double x : s.value[k]) mean[k] += x / starts;
      for (double x : s.value[k]) variance[k] += (x - mean[k]) * (x - mean[k]) / (starts - 1);
    }
    const double error = std::sqrt((variance[0] + variance[1]) / starts);
    const double a = variance[0] / starts, b = variance[1] / starts;
    const double freedom = a + b > 0 ? (a + b) * (a + b) / ((a * a + b * b) / (starts - 1)) : 2 * starts - 2;
    const double t = boost::math::quantile(boost::math::complement(boost::math::students_t(freedom), 5e-4));
    f.within(fmt::format("{}, mean of {} starts, penalty (K × 1000) less nonsmooth ({:.4g})", what, starts,
                         mean[1]),
             unit, mean[0] - mean[1], 0, t * error, "equality",
             fmt::format("Welch's test at 0.1 %: {:.2f} standard errors of {:.2g}", t, error));
  };
  claim("share of time in contact", "", lasting);
  claim("energy lost per turn", "J", dissipated);
  claim("fastest approach", "m/s", spread);
  claim("greatest impulse of an impact", "N s", impulse);
  claim("journal's orbit: mean of e_x over the clearance", "", along);
  claim("share of time in the upper half", "", upper);
  return f;
}

}  // namespace freeplay::verification
