// Invariants over long runs and over random mechanisms: energy, momentum, constraints, penetration.
#include <random>

#include "formulations/make.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/hertz_impact.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {

namespace {

/// A pin with an initial constraint violation Φ, which Baumgarte's stabilisation reduces by Φ̈ +
/// 2αΦ̇ + β²Φ = 0.
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
  f.within("pin with a violation of 1 mm, α = 5, β = 8: constraint violation after 0.4 s [penalty]", "m",
           simulation.state().q[0], 1e-3 * std::exp(-5 * t) * (std::cos(w * t) + 5 / w * std::sin(w * t)),
           1e-8, "Φ̈ + 2αΦ̇ + β²Φ = 0", "tolerance 1e-9 of 1 m per step");
}

/// A journal with a penetration of 1 nm is pulled off the wall: the contact force must not become
/// tensile.
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
  f.within("journal pulled off its wall by 100 N: position after 1 ms [penalty]", "m",
           test::simulate(scene, Family::penalty).final_state.q[0], 1e-3 + 1e-9 - 0.5 * 100 * 1e-6, 1e-8,
           "x₀ − ½ F t²/m", "the elastic energy of 1 nm gives some 1e-5 m/s");
}

/// A chain of 3 to 5 bars that is fixed to the ground and falls from random angles, one of its pins
/// with clearance.
Scene random_chain(std::mt19937& engine, int bars) {
  const auto u = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  };
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  const int with_clearance = static_cast<int>(u(0, bars));
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
    if (b == with_clearance) pin.clearance = Clearance{radial, 10e-3, 0, std::nullopt, -1};
    m.joints.push_back(pin);
    end += 2 * half;
    end_velocity += 2 * swing;
    hook = {0.5 * length, 0};
  }
  scene.run.duration = 0.3;
  scene.run.start = RunOptions::Start::ideal;
  return scene;
}

/// Energy balance, constraint violation and penetration of random mechanisms.
void random_mechanisms(Findings& f) {
  const struct {
    const char* name;
    Family family;
    Scheme scheme;
    double balance, violation, depth;
    const char *why_balance, *why_violation, *why_depth;
  } ways[] = {
      {"penalty", Family::penalty, Scheme::moreau_jean, 1e-6, 1e-8, 0.1,
       "tolerance 1e-9 per step, a thousand steps", "drift of a thousand steps, 1e-9 of 0.5 mm each",
       "Hertz: 10 kg at 0.1 m/s, after a fall of 0.5 mm, penetrate by 17 µm, "
       "of a clearance of 0.2 mm or more"},
      {"Moreau–Jean, h = 1e-5 s", Family::nonsmooth, Scheme::moreau_jean, 1e-9, 1e-9, 1e-3,
       "rounding of 30000 steps: weight and impulses are constant in a step",
       "one Newton correction per step: (ω h)⁴ l/8, l = 0.3 m, ω = 50 rad/s, with a margin",
       "one Newton correction per step: half the square of the relative approach 0.5 m/s × 1e-5 s/0.2 mm"},
      {"event-driven", Family::nonsmooth, Scheme::event_driven, 1e-7, 1e-9, 1e-6,
       "tolerance 1e-10 per step, a thousand steps", "drift of a thousand steps, 1e-10 of 0.5 mm each",
       "impacts are located to rounding; closed contacts drift by a thousand times 1e-10"}};
  constexpr int trials = 30;
  for (const auto& way : ways) {
    std::mt19937 engine(20261121);
    int finished = 0;
    double impacts = 0, balance = 0, violation = 0, depth = 0;
    for (int trial = 0; trial < trials; ++trial) {
      auto scene = random_chain(engine, 3 + trial % 3);
      scene.nonsmooth.scheme = way.scheme;
      scene.nonsmooth.step = 1e-5;
      const auto run = test::simulate(scene, way.family);
      finished += run.ending.status == Ending::Status::finished;
      impacts += static_cast<double>(run.contacts[0].impacts);
      balance = greatest(balance, std::abs(run.ledger.closure()) / run.ledger.scale());
      violation = greatest(violation, run.extremes.constraint_length);
      depth = greatest(depth, run.contacts[0].penetration_ratio);
    }
    const auto name = [&](const char* quantity) {
      return claim_name("random chains with clearance in one pin", quantity, way.name);
    };
    f.within(name("runs of 30 that finish"), "", finished, trials, 0, "all", "exact");
    f.between(name("number of impacts"), "", impacts, trials, 1e5,
              "free fall closes a clearance of 0.5 mm in 10 ms", "at least one impact per mechanism");
    f.at_most(name("greatest error of the energy balance over its greatest term"), "", balance, way.balance,
              "0", way.why_balance);
    f.at_most(name("greatest constraint violation"), "m", violation, way.violation, "0", way.why_violation);
    f.at_most(name("greatest penetration over clearance"), "", depth, way.depth, "0", way.why_depth);
  }
}

void elastic_pair(Findings& f) {
  const char* const subject = "free ring and journal, e = 1, no friction";
  auto ring = read_scene(test::scene_file("ring"));
  ring.mechanism.surfaces[0].restitution = 1;
  ring.mechanism.surfaces[0].friction.reset();
  ring.run.duration = 12;
  const struct {
    test::Way way;
    const char* quantity;
    double bound;
    const char* reason;
  } rows[] = {
      {test::event_driven, "relative change of energy in 12 s", 1e-8, "required accuracy"},
      {test::chosen_steps, "relative change of energy in 12 s, required accuracy", 1e-8,
       "required accuracy: free flight is exact, impacts are solved as in the event-driven scheme"},
      {test::fixed_steps(1e-5, "Moreau–Jean, h = 1e-5 s"), "relative change of energy in 12 s, rounding",
       1e-10, "P (u⁺ + u⁻)/2 = 0 at e = 1: rounding of some thousand impacts"}};
  for (const auto& row : rows) {
    const auto run = test::finished(row.way, ring);
    if (!row.way.stepping())
      f.between(claim_name(subject, "number of impacts in 12 s", row.way.name), "",
                double(run.contacts[0].impacts), 1000, 1e6, "duration of the run",
                "at least a thousand impacts are required");
    f.at_most(claim_name(subject, row.quantity, row.way.name), "",
              std::abs(run.ledger.kinetic - run.ledger.initial) / run.ledger.initial, row.bound,
              "conservation", row.reason);
  }
}

/// Momentum of the free pair, with friction and restitution.
void momentum_of_pair(Findings& f) {
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
    const char* const scheme = penalty ? "penalty" : "Moreau–Jean, h = 1e-5 s";
    const char* const free_pair = "free ring and journal with friction";
    double linear = 0;
    for (int i : {0, 1}) linear = greatest(linear, std::abs(momentum(end.q, end.v, i) - momentum(q, v, i)));
    f.at_most(claim_name(free_pair, "change of momentum in 0.5 s", scheme), "kg m/s", linear, 1e-12,
              "conservation", "rounding: forces and impulses act in opposite pairs");
    // At the first impact e × ė = c · 0.08 m/s and ė·ė = 0.13 m²/s². Friction can at most stop the
    // sliding of this impact, since nothing drives any later sliding, and approach speeds only
    // decrease.
    const double along = 0.08, approach = std::sqrt(0.13 - along * along);  // m/s
    // m/s
    const double sliding = std::abs(along - 0.019 * 20 - 0.02 * 3);
    // N s
    const double stops = sliding / (1 / 2.0 + 1 / 0.5 + 0.02 * 0.02 / 0.004 + 0.019 * 0.019 / 0.0002);
    const double K = 4.0 / 3 * 207e9 / (2 * (1 - 0.09)) * std::sqrt(20e-3 * 19e-3 / 1e-3);
    const double apart =
        // m
        penalty ? reference::elastic_impact(K, 2.0 * 0.5 / 2.5, approach).depth : approach * 1e-5;
    f.at_most(
        claim_name(free_pair, "change of angular momentum in 0.5 s", scheme), "kg m²/s",
        std::abs(momentum(end.q, end.v, 2) - momentum(q, v, 2)), stops * apart, "conservation",
        penalty ? "friction acts on surfaces that overlap: impulse that stops the first sliding (0.082 N s) "
                  "times the elastic penetration of the first impact (13 µm)"
                : "friction acts on surfaces up to a step's travel apart: impulse that stops the first "
                  "sliding (0.082 N s) times the first approach speed (0.35 m/s) times h");
  }
}

void two_turns(Findings& f) {
  const auto rig = test::read_short(test::flores(), 0.6);
  const auto penalty = test::simulate(rig, Family::penalty), rigid = test::simulate(rig, Family::nonsmooth);
  const char *compliant = "penalty", *stepping = "Moreau–Jean, h = 1e-5 s";
  const struct {
    const char *quantity, *scheme, *unit;
    double measured, bound;
    const char* reason;
  } rows[] = {{"error of the energy balance in two turns", compliant, "J", std::abs(penalty.ledger.closure()),
               1e-8, "tolerance 1e-9 of some 10 J of exchanged energy"},
              {"error of the energy balance in two turns", stepping, "J", std::abs(rigid.ledger.closure()),
               1e-9, "rounding: the work of impulses is exact"},
              {"greatest penetration over clearance", stepping, "", rigid.contacts[0].penetration_ratio, 1e-5,
               "one Newton correction per step: half the square of the relative approach, "
               "(0.1 m/s × 1e-5 s/0.25 mm)²/2"},
              {"greatest residual of contact problems", stepping, "m/s", rigid.extremes.lcp_residual_rate,
               1e-11, "rounding of 0.1 m/s: contact problems are solved in closed form"},
              {"greatest constraint violation", compliant, "m", penalty.extremes.constraint_length, 1e-7,
               "drift at α = β = 5, tolerance 1e-9 of 0.25 mm, margin of 1000"},
              {"greatest constraint violation", stepping, "m", rigid.extremes.constraint_length, 1e-9,
               "one Newton correction per step: (ω h)⁴ r/8"}};
  for (const auto& row : rows)
    f.at_most(claim_name("paper's slider-crank with clearance", row.quantity, row.scheme), row.unit,
              row.measured, row.bound, "0", row.reason);
}

}  // namespace

Parts invariants() {
  return {no_pull, baumgarte, random_mechanisms, elastic_pair, momentum_of_pair, two_turns};
}

}  // namespace freeplay::verification
