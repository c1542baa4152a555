// A load cell and a torque sensor: the time integral of the samples is the impulse of an impact,
// and the steady value is the torque.
#include <cmath>
#include <numbers>

#include "mechanism/options.hpp"
#include "verification/claims/force_claims.hpp"
#include "verification/references/impulses.hpp"

namespace freeplay::verification::force_claims {
namespace {

/// A journal that falls 1 cm onto its bearing; a load cell measures the bearing force along y.
Scene journal() {
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  m.surfaces.push_back(test::steel(0.5));
  m.bodies.push_back({"journal", 0.3, 1e-4, {0, 0}, 0, {0, 0}, 0});
  RevoluteJoint joint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}};
  joint.clearance = Clearance{1e-2, 5e-2, 0, std::nullopt, -1};
  m.joints.push_back(joint);
  Instrument cell;
  cell.kind = Instrument::Kind::load_cell;
  cell.name = "cell";
  cell.joint = 0;
  cell.axis = {0, 1};
  cell.bandwidth = 1000;
  cell.sampling = 1e5;
  scene.instruments.push_back(cell);
  scene.run.duration = 0.053;
  scene.run.start = RunOptions::Start::given;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.step = 1e-5;
  return scene;
}

}  // namespace

void load_cell(Findings& f) {
  const double h = 1e-2, g = 9.81, mass = 0.3, bandwidth = 1000, sampling = 1e5;
  const double P = reference::drop_impulse(mass, h, 0.5, g);
  const double w = 2 * std::numbers::pi * bandwidth;
  const char* const source = "references/impulses, m (1 + e) √(2 g h)";
  const struct {
    const char* name;
    Family family;
    Scheme scheme;
    double impulse;
    const char* why;
  } ways[] = {{"event-driven", Family::nonsmooth, Scheme::event_driven, 1e-9, "tolerance 1e-10"},
              {"Moreau–Jean, h = 1e-5 s", Family::nonsmooth, Scheme::moreau_jean, 4e-4,
               "contact onset within a step: g h over 0.44 m/s, twice by the restitution"},
              {"penalty", Family::penalty, Scheme::moreau_jean, 1e-6, hertz}};
  for (const auto& way : ways) {
    auto scene = journal();
    scene.nonsmooth.scheme = way.scheme;
    BalanceWatch watch(scene.mechanism, false, 1e-3, 1 << 30);
    std::vector<double> samples;
    test::Listener listener;
    listener.want.samples = true;
    listener.on_sample = [&](std::size_t, double, double value) { samples.push_back(value); };
    const auto result = run(scene, way.family, {&watch, &listener});
    const auto hit = test::touch(result, 0);
    double expected = P;
    if (way.family == Family::penalty)
      expected = reference::drop_impulse(mass, h, hit.v_n_plus / -hit.v_n_minus, g) + mass * g * hit.duration;
    const auto name = [&](const char* quantity) {
      return claim_name("journal falling 1 cm onto its bearing", quantity, way.name);
    };
    f.relative(name("time integral of the bearing force"), "N s", watch.total.elements[0].fy, expected,
               way.impulse,
               way.family == Family::penalty ? "m (1 + e) √(2 g h) + m g T with e and duration T of the run"
                                             : source,
               way.why);
    f.relative(name("impulse of the contact event"), "N s", hit.impulse_n, watch.total.elements[0].fy,
               way.family == Family::penalty ? 1e-6 : 1e-12, "time integral of the bearing force",
               way.family == Family::penalty ? hertz : "rounding: the same sum");
    double sum = 0;
    for (const double y : samples) sum += y / sampling;
    f.relative(name("sum of load-cell samples times the sampling period"), "N s", sum, expected,
               4e-4 + way.impulse, "∫ y dt = P for unit gain at rest",
               "(ω Δt)²/12 of the kink at contact onset, and the bound of the impulse");
    if (way.family != Family::nonsmooth) continue;
    double off = 0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double t = static_cast<double>(i + 1) / sampling;
      const double y = reference::low_pass2_response(bandwidth, hit.impulse_n, t - hit.t);
      off = greatest(off, std::abs(samples[i] - y));
    }
    f.at_most(name("load-cell samples less the filter's impulse response, greatest, over ω P"), "",
              off / (w * P), 1e-9, "references/impulses, low_pass2_response",
              "rounding of 5000 exact filter steps");
  }
}

void torque_sensor(Findings& f) {
  Scene scene;
  auto& m = scene.mechanism;
  m.bodies.push_back({"rotor", 1.0, 0.01, {0, 0}, 0, {0, 0}, 10});
  m.joints.push_back(RevoluteJoint{"bearing", {ground, 0}, {Vec2{0, 0}, Vec2{0, 0}}, {}});
  m.drives.push_back(SpeedDrive{"motor", 0, 10, 0});
  m.loads.push_back(TorqueLoad{"brake", 0, -0.7});
  Instrument sensor;
  sensor.kind = Instrument::Kind::torque;
  sensor.name = "sensor";
  sensor.drive = "motor";
  sensor.bandwidth = 500;
  sensor.sampling = 5e3;
  scene.instruments.push_back(sensor);
  scene.run.duration = 0.02;
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    double last = NAN;
    test::Listener listener;
    listener.on_sample = [&](std::size_t, double, double value) { last = value; };
    run(scene, family, {&listener});
    f.relative(claim_name("rotor under a brake", "steady value of the torque sensor",
                          family == Family::penalty ? "penalty" : "automatic"),
               "N m", last, 0.7, 1e-9, "torque of the brake", "rounding of a hundred steps");
  }
}

}  // namespace freeplay::verification::force_claims
