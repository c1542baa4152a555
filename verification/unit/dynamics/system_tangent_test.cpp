// Traced derivatives: of operations against closed forms, and of the equations of motion in contact modes of
// random scenes against differences of the right-hand side.
#include "dynamics/system_tangent.hpp"

#include "analysis/sensitivity.hpp"
#include "analysis/varied_key.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/movable_rows.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_tracer.hpp"
#include "formulations/event_driven/event_dynamics.hpp"
#include "formulations/variation/differences.hpp"
#include "numerics/tangent_tape.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace rs = freeplay::verification::random_scenes;

namespace {

using Vector = std::vector<double>;
using Block = TangentTape::Block;

}  // namespace

TEST_CASE("derivatives of traced operations have their closed forms", "[compiled]") {
  const double a = 0.7, b = -1.3, c = 2.5, d = 0.4;
  auto object = TracedObject::unshared();
  {
    Trace trace(object, "f");
    const auto x = trace.inputs(0, std::vector{a, b});
    const Traced k(c), l(d);
    trace.output(0, 0, sin(x[0]) * exp(k * x[1]) / sqrt(x[0] * x[0] + l));
    trace.output(0, 1, atan2(x[0], x[1]) - tanh(k * x[0]));
    trace.output(0, 2, max(x[0], x[1]) + abs(x[1] * l) + cos(-x[1]));
    trace.output(0, 3, x[0] < x[1] ? x[0] : x[1] * x[0]);
    trace.output(0, 4, Traced(0) * x[0] + k);
    const std::vector knots{0.0, 0.5, 1.0}, column{7.0, 8.0, 9.0, 10.0};
    trace.output(0, 5, pick(locate(x[0], knots), column) * x[1]);
    // A function outside with the value x₀² x₁ and its derivative by x₀.
    const auto square = [](const double* in, double* out) {
      out[0] = in[0];
      out[1] = in[0] * in[0] * in[1];
      out[2] = 2 * in[0] * in[1];
    };
    const auto y = call_outside({3, square}, x, "");
    trace.output(0, 6, y[1] + y[2] * (x[0] - y[0]));
  }
  TangentInputs in;
  in.values = {{a, b}};
  in.directions = {2};
  in.varied_values = 1;
  in.varied_directions = 3;
  int next = 0;  // each use of a constant is a slot; k is 2.5, l is 0.4
  for (const double value : object.constants()) in.varied.push_back(value == c ? 0 : value == d ? 1 : -1);
  for (const int index : in.varied) next += index >= 0;
  REQUIRE(next == 5);
  TracedObject derivative;
  append_tangent(derivative, "df", object, object.function(0), in);
  TangentTape tape(derivative, derivative.function(0), 2);

  // Directions: x₀, x₁, k, l and the sum of all.
  std::vector<Block> x(2, Block::Zero()), p(2, Block::Zero()), out(7, Block::Zero());
  x[0][0] = x[1][1] = p[0][2] = p[1][3] = 1;
  for (auto* list : {&x, &p})
    for (auto& block : *list) block[4] = 1;
  const double state[] = {a, b}, constants[] = {c, d};
  const double* values[] = {state, constants};
  const Block* directions[] = {x.data(), p.data()};
  Block* results[] = {out.data()};
  REQUIRE(tape.values(values));
  tape.directions(directions, results);

  const double root = std::sqrt(a * a + d), e = std::exp(c * b), s = std::sin(a), t = std::tanh(c * a);
  const double r2 = a * a + b * b;
  const Vector expected[] = {{std::cos(a) * e / root - s * e * a / std::pow(root, 3), s * c * e / root,
                              s * b * e / root, -0.5 * s * e / std::pow(root, 3)},
                             {b / r2 - c * (1 - t * t), -a / r2, -a * (1 - t * t), 0},
                             {1, -d - std::sin(b), 0, std::abs(b)},
                             {b, a, 0, 0},
                             {0, 0, 1, 0},
                             {0, 9, 0, 0},
                             {2 * a * b, 0, 0, 0}};
  for (std::size_t i = 0; i < 7; ++i) {
    double sum = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      INFO(i << " " << k);
      CHECK(out[i][static_cast<long>(k)] == Approx(expected[i][k]).epsilon(1e-14).margin(1e-15));
      sum += expected[i][k];
    }
    CHECK(out[i][4] == Approx(sum).epsilon(1e-13).margin(1e-14));
    CHECK(out[i][5] == 0);
  }
  // Where the comparison has another result, the function does not apply.
  const double other[] = {b, a};
  values[0] = other;
  CHECK_FALSE(tape.values(values));
}

TEST_CASE("random scenes: traced derivatives in contact modes equal differences", "[compiled][sensitivity]") {
  // Differences of the right-hand side have an error of 1e-12 of the forces in it, which may exceed their
  // sum; along directions of the state also that of their fourth order, so that the best of several
  // spacings is taken: a wrong derivative differs from all of them. Stiff stops leave 2e-5.
  constexpr double state_bound = 1e-4, parameter_bound = 1e-7;
  int scenes = 0, closed = 0, keys = 0, covered = 0, rubbing = 0;
  std::mt19937 engine(20261126);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int index = 0; index < 150 && scenes < 60; ++index) {
    const auto drawn = rs::draw(7, index);
    const auto scene = rs::scene_for(drawn, rs::ways(drawn.suite).front());
    const System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, scene.run.start);
    const RowFacts facts{!redundant_rows(system, start.q).empty(), true};
    if (facts.redundant || system.n() == 0) continue;
    // The masses of a body and a point of a joint.
    const auto& body = scene.mechanism.bodies.front().name;
    std::vector<std::string> names{"bodies." + body + ".mass", "bodies." + body + ".inertia"};
    if (system.contacts() > 0)
      for (const char* key : {".clearance", ".radius", ".at[1][0]"})
        for (const char* kind : {"joints.", "contacts."})
          names.push_back(kind + system.contact_facts(0).name + key);
    names.emplace_back("gravity[1]");
    std::vector<std::vector<std::unique_ptr<System>>> displaced;
    std::vector<SystemTangent::Parameter> parameters;
    std::vector<std::string> varied;
    for (const auto& name : names) {
      try {
        const auto key = property(scene, name, Family::nonsmooth);
        const double value = key.value();
        double h = 5e-4 * (value == 0 ? 0.1 : std::abs(value));
        // A point that moves turns the normal of a contact by its displacement over the
        // eccentricity, of which these states may have a small part of the clearance.
        if (name.ends_with(".at[1][0]")) h = std::min(h, 1e-4 * system.contact_facts(0).clearance);
        std::vector<std::unique_ptr<System>> systems;
        SystemTangent::Parameter p;
        p.spacing = h;
        for (std::size_t i = 0; i < 4; ++i) {
          const auto beside = key.at(value + difference_places[i] * h);
          systems.push_back(std::make_unique<System>(beside.mechanism));
          p.systems[i] = systems.back().get();
        }
        if (p.systems[0]->n() != system.n() || p.systems[0]->contacts() != system.contacts()) continue;
        displaced.push_back(std::move(systems));
        parameters.push_back(p);
        varied.push_back(name);
      } catch (const std::exception&) {  // the scene has no such key
      }
    }
    const Vector restitution(static_cast<std::size_t>(system.contacts()), 0.5);
    EventDynamics fast(system, scene.nonsmooth, restitution, facts, 1);
    fast.use_tangent(std::make_shared<SystemTangent>(system, SystemTangent::Use::modes, parameters));
    const bool has_parameters = system.frictions() == 0 && !fast.films.any();  // see includes_parameter()
    ++scenes;
    INFO(drawn.kind << " " << index);
    double displacement = 1e-6;
    for (int k = 0; k < system.contacts(); ++k)
      displacement = std::min(displacement, 1e-3 * system.contact_facts(k).clearance);

    EventDynamics nominal(system, scene.nonsmooth, restitution, facts, 1);
    std::vector<EventDynamics*> all{&fast, &nominal};
    std::vector<std::vector<std::unique_ptr<EventDynamics>>> twins;
    for (const auto& p : parameters) {
      auto& list = twins.emplace_back();
      for (const auto* s : p.systems) {
        list.push_back(nominal.twin_of(*s));
        all.push_back(list.back().get());
      }
    }
    for (int mode = 0; mode < 3; ++mode) {
      const int k = mode == 0 || system.contacts() == 0 ? -1 : static_cast<int>(engine() % system.contacts());
      const int slip = k >= 0 && system.has_friction(k) ? static_cast<int>(engine() % 3) - 1 : 0;
      const int joint_slip = static_cast<int>(engine() % 3) - 1;
      // More active rows than freedoms depend on each other, and their forces are not unique.
      const int active = (k >= 0 ? (system.has_friction(k) && slip == 0 ? 2 : 1) : 0) +
                         (joint_slip == 0 ? system.frictions() : 0);
      if (active > system.n() - system.rows()) continue;
      for (auto* f : all) {
        for (int c = 0; c < system.contacts(); ++c) {
          f->contacts[c].closed = c == k;
          f->contacts[c].slip = c == k ? slip : 0;
        }
        for (auto& joint : f->preloaded) joint.slip = joint_slip;
      }
      const auto at = moved(system, start, still_coordinates(system, start), 11 + mode);
      const auto size = static_cast<std::size_t>(fast.size()), n = at.q.size();
      Vector x(size);
      std::ranges::copy(at.q, x.begin());
      std::ranges::copy(at.v, x.begin() + static_cast<long>(n));
      std::ranges::copy(at.z, x.begin() + fast.state_offset());
      std::vector<Vector> directions(parameters.size() + 3, Vector(size));
      for (std::size_t c = parameters.size(); c < directions.size(); ++c)
        for (std::size_t i = 0; i < size; ++i)
          if (i < 2 * n || (i >= static_cast<std::size_t>(fast.state_offset()) &&
                            i < static_cast<std::size_t>(fast.integral_offset())))
            directions[c][i] = uniform(engine);
      auto found = directions;
      for (auto* f : all) f->phases.start(system, x.data(), x.data() + n);
      const auto f = fast.directional(x, at.t, directions, found);
      if (!is_finite(f)) continue;  // no regular forces in this mode
      closed += k >= 0;
      rubbing += system.frictions() > 0;
      const auto error = [&](const Vector& a, const Vector& b, double scale) {
        double most = 0;
        for (std::size_t i = 0; i < size; ++i) scale = std::max(scale, std::abs(b[i]));
        for (std::size_t i = 0; i < size; ++i) most = std::max(most, std::abs(a[i] - b[i]));
        return most / scale;
      };
      double size_of_f = 0;
      for (const double y : f) size_of_f = std::max(size_of_f, std::abs(y));
      // By four values at difference_places · h.
      const auto slope_of = [&](double h, auto value) {
        Vector values[4], slope(size);
        for (std::size_t i = 0; i < 4; ++i) {
          values[i].resize(size);
          value(i, values[i]);
        }
        for (std::size_t i = 0; i < size; ++i)
          slope[i] = (8 * (values[2][i] - values[1][i]) - (values[3][i] - values[0][i])) / (12 * h);
        return slope;
      };
      for (std::size_t c = parameters.size(); c < directions.size(); ++c) {
        double least = INFINITY;
        for (const double h : {displacement, 0.1 * displacement, 10 * displacement, 30 * displacement}) {
          const auto slope = slope_of(h, [&](std::size_t i, Vector& value) {
            auto y = x;
            for (std::size_t j = 0; j < size; ++j) y[j] += difference_places[i] * h * directions[c][j];
            nominal(y, value, at.t);
          });
          least = std::min(least, error(found[c], slope, 1e-3 * size_of_f));
        }
        CHECK(least < state_bound);
      }
      for (std::size_t c = 0; c < parameters.size(); ++c) {
        keys += has_parameters;
        if (!fast.includes_parameter(c)) continue;
        ++covered;
        const auto slope = slope_of(parameters[c].spacing,
                                    [&](std::size_t i, Vector& value) { (*twins[c][i])(x, value, at.t); });
        INFO(varied[c]);
        const double unit = parameters[c].spacing / 5e-4;
        CHECK(error(found[c], slope, 1e-3 * size_of_f / unit) < parameter_bound);
      }
    }
  }
  CAPTURE(scenes, closed, keys, covered);
  CHECK(scenes >= 30);
  CHECK(closed >= 40);
  CHECK(rubbing >= 2);
  CHECK(covered >= 9 * keys / 10);
}

TEST_CASE("runs: variational equations give equal derivatives with and without traced parameters",
          "[compiled][sensitivity]") {
  // Each difference of right-hand sides has an error of 1e-12; a few impacts multiply it by at most 1e3.
  auto scene = read_scene(test::flores());
  scene.run.discard = 0;
  scene.run.duration = 0.02;
  scene.nonsmooth.scheme = Scheme::event_driven;
  for (const char* formulation : {"nonsmooth", "penalty"}) {
    SensitivityRequest request{
        .of = {"event.1.t", "event.4.t", "event.4.impulse_n", "end.slider.vx", "energy.work_of_drives"},
        .to = {"joints.gudgeon.clearance", "bodies.slider.mass", "bodies.rod.inertia",
               "drives.motor.speed_rpm", "surfaces.steel.restitution", "surfaces.steel.friction",
               "joints.big_end.at[0][0]", "joints.gudgeon.at[0][0]", "initial.rod.omega"},
        .formulation = formulation};
    const auto traced = sensitivities(scene, request);
    request.compile = Compile::never;
    const auto differenced = sensitivities(scene, request);
    int compared = 0;
    for (std::size_t i = 0; i < traced.quantities.size(); ++i) {
      const auto &a = traced.quantities[i], &b = differenced.quantities[i];
      CHECK(a.value == b.value);
      for (std::size_t c = 0; c < request.to.size(); ++c) {
        INFO(formulation << " " << a.name << " " << request.to[c]);
        REQUIRE(a.reasons[c] == b.reasons[c]);
        if (!b.reasons[c].empty()) continue;
        ++compared;
        const double unit = std::abs(b.value) / std::max(std::abs(differenced.key_values[c]), 1e-3);
        CHECK(std::abs(a.derivatives[c] - b.derivatives[c]) <= 1e-9 * (std::abs(b.derivatives[c]) + unit));
      }
    }
    CHECK(compared >= 36);
  }
}

TEST_CASE("derivatives on another branch than at first are those of that branch", "[compiled][jacobian]") {
  // A speed governor whose integral stops at the limit of its torque.
  const auto scene =
      parse_scene(test::two_bodies() +
                      test::drive("governor", "pin",
                                  "target_speed = 1\nproportional = 2\nintegral = 3\ntorque_limit = 1.5\n") +
                      test::run_for(1),
                  "governor");
  const System system(scene.mechanism);
  EventDynamics f(system, scene.nonsmooth, {}, RowFacts{false}, 1);
  std::mt19937 engine(20261129);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (int trial = 0; trial < 12; ++trial) {
    EventDynamics::Vector x(static_cast<std::size_t>(f.size()));
    for (auto& y : x) y = 2 * uniform(engine);
    CAPTURE(trial);
    CHECK(test::jacobian_error(f, x, 0.4) < 1e-6);
  }
}
