// The parts of time stepping, each alone: the equations of a step on a mechanism given as arrays,
// control of the step size on given times, and contacts, position correction and records with one
// ball above a plane.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/simulation.hpp"
#include "formulations/time_stepping/contact_set.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "formulations/time_stepping/step_pace.hpp"
#include "formulations/time_stepping/step_problem.hpp"
#include "formulations/time_stepping/step_results.hpp"
#include "numerics/saddle_point.hpp"
#include "values/diagnostic.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("a time step of a mechanism given as three arrays satisfies its equations", "[moreau][step]") {
  const std::vector<double> mass{2, 2, 0.5}, force{3, -7, 1};
  const double phi_t = -0.4, gamma = 6, h = 0.01;
  CsrPattern G{.columns = 3, .column = {0, 1}};
  G.end_row();
  const std::vector<double> v{1, -2, 5}, row{0.6, 0.8};
  SaddlePoint saddle(mass, G);
  REQUIRE(saddle.factor(row.data()));
  const MidpointTerms terms{3, 1, mass.data(), force.data(), &phi_t, &gamma};
  std::vector<double> f(3), r(1), end(3), lambda(1);
  terms.sides(h, v.data(), f.data(), r.data());
  saddle.solve(f.data(), r.data(), end.data(), lambda.data());
  for (int i = 0; i < 3; ++i) {
    const double reaction = i < 2 ? row[static_cast<std::size_t>(i)] * lambda[0] : 0;
    const auto k = static_cast<std::size_t>(i);
    CHECK(mass[k] * (end[k] - v[k]) + reaction == Approx(h * force[k]).margin(1e-15));
  }
  CHECK(0.6 * end[0] + 0.8 * end[1] + phi_t == Approx(0.5 * h * gamma));
}

namespace {

/// Iterates v⁺ = of(v_mean) from v; returns the verdict that ended the iteration.
template <class Of>
MeanVelocity::Verdict iterate(MeanVelocity::Kind kind, std::vector<double>& v, Of of) {
  const std::vector<double> mass{1, 1, 1}, none{0, 0, 0}, old = v;
  const MidpointTerms terms{3, 0, mass.data(), none.data(), nullptr, nullptr};
  MeanVelocity mean;
  mean.last.resize(3);
  std::vector<double> v_mean(3);
  v = of(old);
  for (int i = 0;; ++i) {
    const MeanVelocity::Motion motion{1, none.data(), old.data(), v.data(), 0, 0};
    const auto verdict = mean.assess(i, terms, motion, kind, v_mean);
    if (verdict != MeanVelocity::Verdict::again) return verdict;
    v = of(v_mean);
  }
}

}  // namespace

TEST_CASE("the mean velocity of a damped step is found, or the failure is reported", "[moreau][step]") {
  using Verdict = MeanVelocity::Verdict;
  // v⁺ = v − z v_mean with z = hc/m: (2 − z)/(2 + z) v, found for z < 2.
  for (const double z : {0.1, 1.0}) {
    std::vector<double> v{3, -4, 1};
    const auto start = v;
    REQUIRE(iterate({}, v, [&](const std::vector<double>& mean) {
              return std::vector{start[0] - z * mean[0], start[1] - z * mean[1], start[2] - z * mean[2]};
            }) == Verdict::met);
    for (std::size_t i = 0; i < 3; ++i) CHECK(v[i] == Approx((2 - z) / (2 + z) * start[i]).epsilon(2e-9));
  }
  std::vector<double> v{3, 0, 0};
  CHECK(iterate({}, v, [](const std::vector<double>& mean) {
          return std::vector{3 - 5 * mean[0], 0.0, 0.0};
        }) == Verdict::diverged);
  // Endless oscillation: a failure, a film's fixed step that continues, a pulse that reverses the
  // motion.
  const auto flip = [](MeanVelocity::Kind kind) {
    std::vector<double> start{1, 0, 0};
    return iterate(kind, start, [n = 0](const std::vector<double>&) mutable {
      return std::vector{++n % 2 ? 1.0 : 2.0, 0.0, 0.0};
    });
  };
  CHECK(flip({}) == Verdict::diverged);
  CHECK(flip({.films = true, .fixed = true}) == Verdict::unsettled);
  CHECK(flip({.films = true}) == Verdict::diverged);
  CHECK(flip({.sweeps = true}) == Verdict::unswept);
}

TEST_CASE("the floor of adaptive steps rises among crowded impacts and falls again", "[moreau][step]") {
  Scales scales;
  scales.length = 1e-3;
  scales.speed = 1;
  StepPace pace(1e-6, scales);
  pace.start(0, 2, 0, 0);
  const double least = 1e-6 * 1e-3 / 2;
  CHECK(pace.floor == Approx(least));
  double t = 0;
  const auto steps = [&](double length, bool impacts) {
    for (int i = 0; i < 200; ++i) {
      pace.impacts_now += impacts;
      pace.note_step(t += length, 0);
    }
  };
  steps(1e-9, false);  // short steps of a smooth motion
  CHECK(pace.floor == Approx(least));
  steps(1e-9, true);
  CHECK(pace.floor == Approx(4 * least));
  pace.note_speed(4);  // the floor for a faster motion is too long by that factor
  CHECK(pace.floor == Approx(2 * least));
  CHECK(pace.raised() == Approx(4));
  steps(1e-2, false);
  CHECK(pace.raised() == Approx(1));
  for (int i = 0; i < 40; ++i) steps(1e-9, true);
  CHECK(pace.floor == Approx(0.2 * pace.pace));  // but not without limit
  CHECK_FALSE(pace.runs_away(0));
  pace.note_speed(1e4 * pace.calm_speed);
  CHECK_FALSE(pace.runs_away(0));  // not caused by an impact
  CHECK(pace.runs_away(1));
}

namespace {

/// A ball of 1 kg above a plane, and the data of a step.
struct Ball {
  explicit Ball(double gap, double speed, double step)
      : scene(read_scene(test::scene_file("ball_on_plane"))),
        system(scene.mechanism),
        data(system, {}),
        films(system),
        contacts(system, {0.8}, step),
        responses(system, 1, false),
        problem(data, scene.nonsmooth, 1, false, false),
        record(system, step),
        log(1) {
    auto state = assemble(scene.mechanism, scene.run.start);
    data.q = data.q_old = state.q;
    data.q[1] += gap;
    data.q_old = data.q;
    data.v = data.v_old = {0, speed, 0};
    data.log = &log;
    system.place(0, data.q.data(), data.end);
    record.start();
    contacts.start(data, responses);
  }
  /// To the middle of a step of h, without forces.
  void begin(double h, StepReach reach = StepReach::all) {
    data.t = data.t_old + h;
    data.reach = reach;
    for (std::size_t i = 0; i < 3; ++i) data.q_mid[i] = data.q_old[i] + 0.5 * h * data.v_old[i];
    system.place(0.5 * h, data.q_mid.data(), data.middle);
    system.rate(data.q_mid.data(), data.v_old.data(), data.middle);
    contacts.look_at_rows(data, responses);
    problem.begin(data);
    REQUIRE(data.saddle.factor(data.middle.G.data()));
    data.v = data.v_old;
  }
  void solve() { REQUIRE(problem.solve(data, contacts, responses, films)); }
  StepContact& contact() { return contacts[0]; }

  Scene scene;
  System system;
  StepData data;
  FilmStep films;
  ContactSet contacts;
  ImpulseResponses responses;
  StepProblem problem;
  ContactRecord record;
  ContactLog log;
};

}  // namespace

TEST_CASE("a contact becomes active when its gap closes, and is in impact once", "[moreau][step]") {
  {
    Ball far(1e-2, -1, 1e-3);
    far.begin(1e-3);
    far.solve();
    CHECK_FALSE(far.contact().active);
    CHECK(far.data.v[1] == -1);
    CHECK(far.problem.problem.unknowns.empty());
  }
  Ball ball(4e-4, -1, 1e-3);
  ball.begin(1e-3);
  ball.solve();
  CHECK(ball.contact().active);
  CHECK(ball.contact().in_impact);
  CHECK(ball.data.v[1] == Approx(0.8));  // restitution
  CHECK(ball.problem.unknown_of(ball.contact())->impulse_n == Approx(1.8));
  ball.record.record(ball.data, ball.contacts, ball.problem, ball.responses);
  CHECK(ball.record.in_impact());
  CHECK(ball.contact().t_onset == Approx(4e-4));  // instant at which the gap closes
  CHECK(ball.record.impacts(0).v.size() == 3);
  CHECK(ball.log.is_open(0));
  // It has a contact episode now: a loaded contact is not in impact again, and without an impulse
  // it separates.
  ball.begin(1e-3);
  ball.contact().active = true;
  CHECK_FALSE(ball.contacts.find_impacts(ball.data));
  ball.contact().unknown = -1;
  ball.record.record(ball.data, ball.contacts, ball.problem, ball.responses);
  CHECK_FALSE(ball.log.is_open(0));
  CHECK(ball.contact().steps == 0);
}

TEST_CASE("a smooth step includes only closed contacts, within their slack", "[moreau][step]") {
  Ball open(-1e-6, -1, 0);
  open.begin(1e-3, StepReach::closed);
  open.solve();
  CHECK_FALSE(open.contact().active);
  Ball closed(1e-6, 0, 0);
  closed.contact().closed = true;
  closed.begin(1e-3, StepReach::closed);
  closed.solve();
  CHECK_FALSE(closed.contact().active);  // it has a gap
  closed.contacts.slack = 2e-6;
  closed.data.v_old[1] = -1;
  closed.begin(1e-3, StepReach::closed);
  closed.solve();
  CHECK(closed.contact().active);
  CHECK_FALSE(closed.contact().in_impact);
  CHECK(closed.data.v[1] == Approx(0).margin(1e-15));  // no restitution
}

TEST_CASE("a position correction that does not meet its tolerance is reported", "[moreau][step]") {
  // A disc between two walls: they are apart by its diameter, or by 10 µm less.
  const auto notes = [](double missing) {
    const auto scene = fmt::format(
        "gravity = [0, -9.81]\n[groups.g]\nmass = 1\nradius = 0.1\npositions = [[{}, 0.1]]\n"
        "walls = [[0, 1], [0, 0], [{}, 0], [{}, 1]]\nsurface = \"s\"\n[surfaces.s]\nrestitution = 0\n"
        "[run]\nduration = 0.01\nstart = \"given\"\n[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-3\n",
        0.1 - 0.5 * missing, 0.2 - missing, 0.2 - missing);
    return Simulation(parse_scene(scene, "channel"), "nonsmooth").run().notes;
  };
  CHECK(std::ranges::count(notes(1e-5), diagnostic<Diagnostic::position_residual>(10, 5e-6)) == 1);
  for (const auto& note : notes(0)) CHECK_THAT(note, !Catch::Contains("correction"));
}
