// What must not change, over long runs and over random mechanisms.
#include <random>

#include "facade/simulation.hpp"
#include "formulations/make.hpp"
#include "mechanism/scene.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/support/support.hpp"

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
  Simulation simulation(scene, "penalty", {.start = State{0, {1e-3, 0, 0}, {0, 0, 0}, {}}});
  simulation.run();
  const double w = std::sqrt(64.0 - 25.0), t = 0.4;
  f.within("a pin open by 1 mm, α = 5, β = 8: opening after 0.4 s", "m", simulation.state().q[0],
           1e-3 * std::exp(-5 * t) * (std::cos(w * t) + 5 / w * std::sin(w * t)), 1e-8, "Φ̈ + 2αΦ̇ + β²Φ = 0",
           "tolerance 1e-9 of 1 m a step");
}

/// A journal that lies in its wall by a nanometre is pulled off: a contact does not hold it back.
void no_pull(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  m.surfaces.push_back(test::steel(0.5));
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

/// A chain of 3 to 5 bars that hangs on the ground and falls from random angles, one of its pins loose.
Scene random_chain(std::mt19937& engine, int bars) {
  const auto u = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  const int loose = static_cast<int>(u(0, bars));
  const double radial = u(0.2e-3, 0.5e-3);
  m.surfaces.push_back(test::steel(u(0.1, 0.9)));
  m.surfaces.back().friction = u(0, 0.3);
  Vec2 end{0, 0}, end_velocity{0, 0}, hook{0, 0};
  for (int b = 0; b < bars; ++b) {
    const double mass = u(0.2, 2), length = u(0.1, 0.3), angle = u(-M_PI, 0), rate = u(-2, 2);
    const Vec2 half = 0.5 * length * Vec2{std::cos(angle), std::sin(angle)};
    const Vec2 swing = rate * Vec2{-half.y(), half.x()};
    m.bodies.push_back({"bar" + std::to_string(b), mass, mass * length * length / 12, end + half, angle,
                        end_velocity + swing, rate});
    RevoluteJoint pin{"pin" + std::to_string(b), {b - 1, b}, {hook, Vec2{-0.5 * length, 0}}, {}};
    if (b == loose) pin.clearance = Clearance{radial, 10e-3, 0, std::nullopt, -1};
    m.joints.push_back(pin);
    end += 2 * half;
    end_velocity += 2 * swing;
    hook = {0.5 * length, 0};
  }
  scene.run.duration = 0.3;
  scene.run.start = RunOptions::Start::ideal;
  return scene;
}

/// Balance, constraints and walls on mechanisms that nobody chose.
void random_mechanisms(Findings& f) {
  const struct {
    const char* name;
    Family family;
    Scheme scheme;
    double balance, open, depth;
    const char *why_balance, *why_open, *why_depth;
  } ways[] = {
      {"penalty", Family::penalty, Scheme::moreau_jean, 1e-6, 1e-8, 0.1,
       "tolerance 1e-9 a step, a thousand steps", "drift of a thousand steps, 1e-9 of 0.5 mm each",
       "Hertz: a chain's 10 kg at the 0.1 m/s of a fall through 0.5 mm sink 17 µm, of 0.2 mm or more"},
      {"Moreau–Jean", Family::nonsmooth, Scheme::moreau_jean, 1e-9, 1e-9, 1e-3,
       "weight and impulses are constant in a step: rounding of 30,000 steps",
       "one Newton correction a step: (ω h)⁴ l/8 of 0.3 m at 50 rad/s, and room",
       "one Newton correction leaves half the square of what a step closes: 0.5 m/s × 1e-5 s/0.2 mm"},
      {"event-driven", Family::nonsmooth, Scheme::event_driven, 1e-7, 1e-9, 1e-6,
       "tolerance 1e-10 a step, a thousand steps", "drift of a thousand steps, 1e-10 of 0.5 mm each",
       "impacts are located to rounding; contact drifts by a thousand times 1e-10"}};
  constexpr int trials = 30;
  for (const auto& way : ways) {
    std::mt19937 engine(20261121);
    int finished = 0;
    double impacts = 0, balance = 0, open = 0, depth = 0;
    for (int trial = 0; trial < trials; ++trial) {
      auto scene = random_chain(engine, 3 + trial % 3);
      scene.nonsmooth.scheme = way.scheme;
      scene.nonsmooth.step = 1e-5;
      const auto run = test::simulate(scene, way.family);
      finished += run.ending.status == Ending::Status::finished;
      impacts += static_cast<double>(run.contacts[0].impacts);
      balance = greatest(balance, std::abs(run.ledger.closure()) / run.ledger.scale());
      open = greatest(open, run.extremes.constraint_length);
      depth = greatest(depth, run.contacts[0].penetration_ratio);
    }
    const std::string name = std::string(", ") + way.name;
    f.within("random chains with a loose pin, of 30: come to 0.3 s" + name, "", finished, trials, 0, "all",
             "none may fail");
    f.between("their impacts" + name, "", impacts, trials, 1e5, "free fall closes 0.5 mm in 10 ms",
              "one a mechanism, or nothing is tried");
    f.at_most("their worst energy balance over its greatest term" + name, "", balance, way.balance,
              "the ledger's own sum", way.why_balance);
    f.at_most("their greatest constraint violation" + name, "m", open, way.open, "0", way.why_open);
    f.at_most("their greatest penetration over clearance" + name, "", depth, way.depth, "0", way.why_depth);
  }
}

}  // namespace

Findings invariants() {
  Findings f;
  no_pull(f);
  baumgarte(f);
  random_mechanisms(f);
  auto ring = read_scene(test::scene_file("ring"));
  ring.mechanism.surfaces[0].restitution = 1;
  ring.mechanism.surfaces[0].friction.reset();
  ring.run.duration = 12;
  const auto change = [](const Result& run) {
    return std::abs(run.ledger.kinetic - run.ledger.initial) / run.ledger.initial;
  };
  ring.nonsmooth.scheme = Scheme::event_driven;
  const auto elastic = test::simulate(ring, Family::nonsmooth);
  f.between("elastic impacts of ring and journal, event-driven", "", double(elastic.contacts[0].impacts),
            1000, 1e6, "the run's length", "a thousand are asked for");
  f.at_most("their relative change of energy", "", change(elastic), 1e-8, "conservation", "asked for");
  ring.nonsmooth.scheme = Scheme::moreau_jean;
  f.at_most("the same by Moreau–Jean with chosen steps", "", change(test::simulate(ring, Family::nonsmooth)),
            1e-8, "conservation", "as event-driven: flights are exact, impacts are the same problem");
  ring.nonsmooth.step = 1e-5;
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
    double linear = 0;
    for (int i : {0, 1}) linear = greatest(linear, std::abs(momentum(end.q, end.v, i) - momentum(q, v, i)));
    f.at_most("ring and journal: change of momentum, " + name, "kg m/s", linear, 1e-12, "conservation",
              "forces and impulses come in pairs: rounding");
    // The pair meets with e × ė = c · 0.08 m/s, ė·ė = 0.13 m²/s². Friction can only stop the sliding of that
    // meeting, since afterwards nothing drives any, and approaches only become slower.
    const double along = 0.08, approach = std::sqrt(0.13 - along * along);                              // m/s
    const double sliding = std::abs(along - 0.019 * 20 - 0.02 * 3);                                     // m/s
    const double stops = sliding / (1 / 2.0 + 1 / 0.5 + 0.02 * 0.02 / 0.004 + 0.019 * 0.019 / 0.0002);  // N s
    const double K = 4.0 / 3 * 207e9 / (2 * (1 - 0.09)) * std::sqrt(20e-3 * 19e-3 / 1e-3);
    const double apart =
        penalty ? reference::elastic_impact(K, 2.0 * 0.5 / 2.5, approach).depth : approach * 1e-5;  // m
    f.at_most("its change of spin, " + name, "kg m²/s",
              std::abs(momentum(end.q, end.v, 2) - momentum(q, v, 2)), stops * apart, "conservation",
              penalty ? "friction acts on surfaces that overlap: what stops the first sliding (0.082 N s) "
                        "times the elastic depth of the first approach (13 µm)"
                      : "friction acts on surfaces as far apart as a step closes: what stops the first "
                        "sliding (0.082 N s) times the first approach (0.35 m/s) times h");
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
