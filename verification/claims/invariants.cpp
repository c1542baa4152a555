// What must not change, over long runs.
#include "formulations/make.hpp"
#include "sim/recorder.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support.hpp"

namespace freeplay::verification {

namespace {

/// A pin that starts open closes as α and β prescribe: Φ̈ + 2αΦ̇ + β²Φ = 0.
void baumgarte(Findings& f) {
  Scene scene;
  scene.mechanism.bodies.push_back({"bar", 2.0, 0.1, {0, 0}, 0, {0, 0}, 0});
  scene.mechanism.joints.push_back(RevoluteJoint{"pin", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}});
  scene.penalty.alpha = 5;
  scene.penalty.beta = 8;
  scene.run.duration = 0.4;
  const System system(scene.mechanism);
  const auto formulation = make(Family::penalty, scene, system, assemble(scene.mechanism, scene.run.start));
  formulation->start({0, {1e-3, 0, 0}, {0, 0, 0}});
  Recorder recorder(scene, system, std::nullopt);
  formulation->run(0.4, recorder);
  const double w = std::sqrt(64.0 - 25.0), t = 0.4;
  f.within("a pin open by 1 mm, α = 5, β = 8: opening after 0.4 s", "m", formulation->state().q[0],
           1e-3 * std::exp(-5 * t) * (std::cos(w * t) + 5 / w * std::sin(w * t)), 1e-8, "Φ̈ + 2αΦ̇ + β²Φ = 0",
           "tolerance 1e-9 of 1 m a step");
}

/// A journal that lies in its wall by a nanometre is pulled off: a contact does not hold it back.
void no_pull(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  Surface surface;
  surface.young = 207e9;
  surface.poisson = 0.3;
  surface.restitution = 0.5;
  m.surfaces.push_back(surface);
  m.bodies.push_back({"journal", 1.0, 0.1, {1e-3 + 1e-9, 0}, 0, {0, 0}, 0});
  RevoluteJoint joint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}};
  joint.clearance = Clearance{1e-3, 2e-2, 0, std::nullopt, -1};
  m.joints.push_back(joint);
  m.loads.push_back(ForceLoad{"pull", 0, {0, 0}, {-100, 0}});
  scene.run.duration = 1e-3;
  scene.run.start = RunOptions::Start::given;
  f.within("a journal pulled off its wall by 100 N: where after 1 ms", "m",
           test::simulate(scene, Family::penalty).final_state.q[0], 1e-3 + 1e-9 - 0.5 * 100 * 1e-6, 1e-8,
           "½ F t²/m", "the nanometre's own push gives some 1e-5 m/s");
}

}  // namespace

Findings invariants() {
  Findings f;
  no_pull(f);
  baumgarte(f);
  auto ring = read_scene(test::scene_file("ring"));
  ring.mechanism.surfaces[0].restitution = 1;
  ring.mechanism.surfaces[0].friction.reset();
  ring.run.duration = 12;
  const auto change = [](const RunSummary& run) {
    return std::abs(run.ledger.kinetic - run.ledger.initial) / run.ledger.initial;
  };
  ring.nonsmooth.scheme = Scheme::event_driven;
  const auto elastic = test::simulate(ring, Family::nonsmooth);
  f.between("elastic impacts of ring and journal, event-driven", "", double(elastic.contacts[0].impacts),
            1000, 1e6, "the run's length", "a thousand are asked for");
  f.at_most("their relative change of energy", "", change(elastic), 1e-8, "conservation", "asked for");
  ring.nonsmooth.scheme = Scheme::moreau_jean;
  f.at_most("the same by Moreau–Jean at 1e-5 s", "", change(test::simulate(ring, Family::nonsmooth)), 1e-10,
            "P (u⁺ + u⁻)/2 = 0 at e = 1", "rounding of some thousand impacts");

  // Momentum of the free pair, with friction and restitution.
  auto pair = read_scene(test::scene_file("ring"));
  pair.run.duration = 0.5;
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    const auto run = test::simulate(pair, family);
    const auto& end = run.final_state;
    const auto momentum = [&](const std::vector<double>& q, const std::vector<double>& v, int i) {
      if (i < 2) return 2.0 * v[i] + 0.5 * v[3 + i];
      return 2.0 * (q[0] * v[1] - q[1] * v[0]) + 0.004 * v[2] + 0.5 * (q[3] * v[4] - q[4] * v[3]) +
             0.0002 * v[5];
    };
    const std::vector<double> q{0, 0, 0, 1e-4, -2e-4, 0}, v{0, 0, 3, 0.3, 0.2, -20};
    const bool penalty = family == Family::penalty;
    const std::string name = penalty ? "penalty" : "Moreau–Jean";
    double linear = 0, overlap = 0;
    for (int i : {0, 1}) linear = greatest(linear, std::abs(momentum(end.q, end.v, i) - momentum(q, v, i)));
    for (const auto& e : run.events) overlap += std::abs(e.impulse_t) * run.contacts[0].penetration;
    f.at_most("ring and journal: change of momentum, " + name, "kg m/s", linear, 1e-12, "conservation",
              "forces and impulses come in pairs: rounding");
    // Moreau–Jean places impulses at the middle of a step, where the surfaces are up to |u_N| h/2 apart.
    for (const auto& e : run.events)
      if (!penalty) overlap += std::abs(e.impulse_t) * std::abs(e.v_n_minus) * 1e-5;
    f.at_most("its change of spin, " + name, "kg m²/s",
              std::abs(momentum(end.q, end.v, 2) - momentum(q, v, 2)), overlap + 1e-12, "conservation",
              penalty ? "friction acts on surfaces that overlap by δ: a couple of up to Σ |P_T| δ"
                      : "friction acts where the surfaces are up to |u_N| h apart: Σ |P_T| |u_N| h");
  }

  auto rig = read_scene(test::flores());
  rig.run.duration = 0.6;
  rig.run.discard = 0;
  const auto penalty = test::simulate(rig, Family::penalty),
             nonsmooth = test::simulate(rig, Family::nonsmooth);
  f.at_most("the paper's rig, two turns: energy balance, penalty", "J", std::abs(penalty.ledger.closure()),
            1e-8, "the ledger's own sum", "tolerance 1e-9 of some 10 J that go to and fro");
  f.at_most("the same, Moreau–Jean", "J", std::abs(nonsmooth.ledger.closure()), 1e-9, "the ledger's own sum",
            "impulses' work is exact: rounding");
  f.at_most("the rig's greatest penetration over clearance, Moreau–Jean", "",
            nonsmooth.contacts[0].penetration_ratio, 1e-5, "0",
            "one Newton correction leaves the square of what a step closes: (0.1 m/s × 1e-5 s/0.25 mm)²/2");
  f.at_most("greatest residual of its contact problems", "m/s", nonsmooth.extremes.lcp_residual_rate, 1e-11,
            "0", "closed forms: rounding of 0.1 m/s");
  f.at_most("greatest constraint violation, penalty", "m", penalty.extremes.constraint_length, 1e-7, "0",
            "drift at α = β = 5, tolerance 1e-9 of 0.25 mm, room of a thousand");
  f.at_most("greatest constraint violation, Moreau–Jean", "m", nonsmooth.extremes.constraint_length, 1e-9,
            "0", "one Newton correction a step: (ω h)⁴ r/8");
  return f;
}

}  // namespace freeplay::verification
