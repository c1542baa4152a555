// The penalty formulation in its limits: infinite contact stiffness on three mechanisms, and
// vanishing regularisation of friction on a block.
#include "formulations/make.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// Convergence of the second impact of a penalty run to that of the nonsmooth formulation: the
/// exponent of the contact stiffness K in the differences of its time, approach speed and impulse,
/// over four decades of K.
void limit(Findings& f, const std::string& name, Scene scene) {
  scene.run.discard = 0;
  scene.instruments.clear();
  scene.nonsmooth.scheme = Scheme::event_driven;
  const auto exact = test::touch(test::simulate(scene, Family::nonsmooth), 1);
  scene.penalty.contact = ContactLaw::exact;
  scene.penalty.tolerance = 1e-11;
  std::vector<double> K, errors[3];
  for (const double factor : {1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    auto stiff = scene;
    stiff.mechanism.surfaces[0].young = *scene.mechanism.surfaces[0].young * factor;
    const auto touch = test::touch(test::simulate(stiff, Family::penalty), 1);
    K.push_back(factor);
    errors[0].push_back(std::abs(touch.t - exact.t));
    errors[1].push_back(std::abs(touch.v_n_minus - exact.v_n_minus));
    errors[2].push_back(std::abs(touch.impulse_n - exact.impulse_n));
  }
  const char* quantity[] = {"time", "approach speed", "impulse"};
  for (int i = 0; i < 3; ++i) {
    f.between(
        claim_name(name, fmt::format("exponent of K in the {} of the 2nd impact", quantity[i]), "penalty"),
        "", test::observed_order(K, errors[i]), -0.43, -0.37, "−2/5, as of the contact time (Hertz)",
        "the next order changes it by up to 0.02 at K × 1");
    f.curves.push_back({"stiff_limit", name.substr(0, name.find(',')) + ", " + quantity[i],
                        "stiffness over the scene's", "difference (s, m/s, N s)", K, errors[i]});
  }
}

/// A block that sticks on a slope under the set-valued law creeps under a regularised one, at the
/// speed where friction balances the downhill force. Ambrósio's friction rises linearly from v₀ to
/// v₁, so v = v₀ + (v₁ − v₀) tan α/μ, and the creep vanishes with v₁. Contacts at rest are
/// overdamped and need the implicit integrator.
void friction_limit(Findings& f) {
  const char* const subject = "block sticking on a slope";
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
    f.relative(claim_name(subject, fmt::format("creep speed at v₁ = {} m/s", v1), "penalty"), "m/s", v,
               0.1 * v1 + 0.9 * v1 * std::tan(20 * M_PI / 180) / 0.5, 1e-2, "v₀ + (v₁ − v₀) tan α/μ",
               "the feet still sink at some 1e-6 m/s after 1 s, "
               "and their penetration changes the lever arm of friction");
    speeds.push_back(v1);
    creeps.push_back(v);
  }
  f.between(claim_name(subject, "order of the creep speed in v₁", "penalty"), "",
            test::observed_order(speeds, creeps), 0.99, 1.01, "1, from v₀ + (v₁ − v₀) tan α/μ",
            "1e-2 over two decades");
}

void limits(Findings& f) {
  auto rig = read_scene(test::flores());
  rig.run.duration = 0.0095;
  limit(f, "paper's slider-crank with clearance", rig);
  auto four_bar = read_scene(test::scene_file("four_bar_two"));
  four_bar.run.duration = 0.035;
  four_bar.mechanism.surfaces[0].friction.reset();
  limit(f, "four-bar with clearance in two pins, no friction", four_bar);
  auto guide = read_scene(test::source_folder() / "cases/flores2010-translational/scene.toml");
  guide.mechanism.bodies[2].angular_velocity = 3;
  guide.mechanism.surfaces[0].friction.reset();
  guide.mechanism.surfaces[0].young = 207e11;
  guide.run.duration = 0.0027;
  limit(f, "slider-crank with clearance in the guide, no friction, ω₃ = 3 rad/s, E = 207e11 Pa", guide);
}

}  // namespace

Parts stiff_limit() { return {friction_limit, limits}; }

}  // namespace freeplay::verification
