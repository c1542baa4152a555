// Published mechanisms without contact: their positions and velocities by each scheme, compared
// with independent references in minimal coordinates and with the published digits.
#include "verification/claims/claim.hpp"
#include "verification/references/pendulum.hpp"
#include "verification/references/published/iftomm.hpp"
#include "verification/references/published/smooth_motion.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// A function of the state at the end of a run.
struct Quantity {
  const char* name;
  const char* unit;
  std::function<double(const State&)> of;
  double exact;          ///< by the reference
  double bound;          ///< of schemes with a tolerance
  double rate;           ///< greatest rate of change during the motion, by the reference
  double published = 0;  ///< by the source, if published_bound > 0
  double published_bound = 0;
};

/// Why a bound holds, and where the values come from.
struct Grounds {
  const char *reference, *bound;
  const char *published = "", *published_bound = "";
};

constexpr const char* per_step = "tolerance 1e-12 per step, some thousand steps";

/// The coordinate k of a body, 0 to 2 for x, y and θ.
auto place(std::size_t body, std::size_t k) {
  return [i = 3 * body + k](const State& s) { return s.q[i]; };
}
auto rate(std::size_t body, std::size_t k) {
  return [i = 3 * body + k](const State& s) { return s.v[i]; };
}

void claim_at_end(Findings& f, const char* subject, const test::Way& way, const Result& run,
                  const std::vector<Quantity>& quantities, const Grounds& grounds) {
  for (const auto& q : quantities) {
    const double value = q.of(run.final_state);
    f.within(claim_name(subject, q.name, way.name), q.unit, value, q.exact,
             way.fixed() ? way.step * q.rate : q.bound, grounds.reference,
             way.fixed() ? "first order: the greatest change during one step" : grounds.bound);
    if (q.published_bound > 0)
      f.within(claim_name(subject, fmt::format("{}, published", q.name), way.name), q.unit, value,
               q.published, way.fixed() ? way.step * q.rate + q.published_bound : q.published_bound,
               grounds.published, grounds.published_bound);
  }
}

/// Penalty, event-driven, and Moreau–Jean with the step h.
std::vector<test::Way> schemes(double h, const char* time_stepping) {
  return {test::penalty, test::event_driven, test::fixed_steps(h, time_stepping)};
}

void car_axis(Findings& f) {
  const reference::CarAxis axis;
  const auto exact = axis.rod(3, axis.at(3));
  const auto& p = reference::car_axis_places;
  const auto& v = reference::car_axis_speeds;
  const double turn = (v[3] - v[1]) * (p[2] - p[0]) - (v[2] - v[0]) * (p[3] - p[1]);  // L = 1 m
  const double near = 1e-9;
  const int axle = 2;
  const std::vector<Quantity> quantities{
      {"x of the rod's centre at 3 s", "m", place(axle, 0), exact[0], near, 0.6, (p[0] + p[2]) / 2, near},
      {"y of the rod's centre at 3 s", "m", place(axle, 1), exact[1], near, 1.1, (p[1] + p[3]) / 2, near},
      {"angle of the rod at 3 s", "rad", place(axle, 2), exact[2], near, 2.1,
       std::atan2(p[3] - p[1], p[2] - p[0]), near},
      {"velocity of the rod's centre along x at 3 s", "m/s", rate(axle, 0), exact[3], near, 8.5,
       (v[0] + v[2]) / 2, near},
      {"velocity of the rod's centre along y at 3 s", "m/s", rate(axle, 1), exact[4], near, 30,
       (v[1] + v[3]) / 2, near},
      {"angular velocity of the rod at 3 s", "rad/s", rate(axle, 2), exact[5], near, 58, turn, near}};
  const auto scene = read_scene(test::published("car-axis"));
  for (const auto& way : schemes(1e-4, "Moreau–Jean, h = 1e-4 s"))
    claim_at_end(f, "car axis", way, test::finished(way, scene), quantities,
                 {"references/published/smooth_motion", per_step, "IVP test set, caraxis",
                  "tolerance 1e-12 per step; the published digits differ from the reference by 5e-12"});
}

void exudyn_slider_cranks(Findings& f) {
  const Grounds grounds{"references/published/smooth_motion", per_step};
  for (const auto& way : schemes(1e-4, "Moreau–Jean, h = 1e-4 s")) {
    double sum = 0;
    for (const bool floating : {false, true}) {
      const reference::ExudynSliderCrank m{.floating = floating};
      const auto y = m.at(0.3L);
      std::vector<Quantity> quantities{
          {"x of the slider at 0.3 s", "m", place(2, 0), double(m.slider(y).real()), 1e-9, 0.7},
          {"velocity of the slider at 0.3 s", "m/s", rate(2, 0), double(m.slider_velocity(y)), 1e-8, 4.2},
          {"angle of the crank at 0.3 s", "rad", place(0, 2), double(y[2] + y[3]), 1e-9, 6.5},
          {"angular velocity of the crank at 0.3 s", "rad/s", rate(0, 2), double(y[6] + y[7]), 1e-8, 84}};
      if (floating)
        quantities.push_back({"angle of the frame at 0.3 s", "rad", place(3, 2), double(y[2]), 1e-9, 1.6e-3});
      const char* const name = floating ? "exudyn-slider-crank-floating" : "exudyn-slider-crank";
      const auto run = test::finished(way, read_scene(test::published(name)));
      claim_at_end(f,
                   floating ? "slider-crank of the Exudyn tests on an elastic frame"
                            : "slider-crank of the Exudyn tests on the ground",
                   way, run, quantities, grounds);
      sum += run.final_state.q[6];
    }
    const bool fixed = way.fixed();
    f.within(claim_name("slider-cranks of the Exudyn tests", "sum of both sliders' x at 0.3 s, published",
                        way.name),
             "m", sum, reference::exudyn_slider_crank_sum, fixed ? 2 * way.step * 0.7 : 1e-8,
             "Exudyn test suite, sliderCrankFloatingTest.py",
             fixed ? "first order: the greatest change during one step"
                   : "tolerance of the test suite; steps of 6e-5 s of order 2 with errors of 6e-9 m");
  }
}

/// Greatest and root mean square error of the pendulum at 4000 instants of 10 s. Errors of the mean
/// are relative to the coordinate or to 1e-3 m.
void simple_pendulum(Findings& f) {
  const reference::Pendulum pendulum{1, 0, 1, 9.81, -std::numbers::pi / 2};
  const auto at = [&](double t) {
    const auto p = reference::pendulum_state(pendulum, t);
    return std::array{std::sin(p.angle), -std::cos(p.angle), p.rate * std::cos(p.angle),
                      p.rate * std::sin(p.angle)};
  };
  const char* const subject = "simple pendulum of IFToMM A01";
  const auto scene = read_scene(test::published("iftomm-simple-pendulum"));
  const auto end = at(10);
  const double near = 1e-8;
  const std::vector<Quantity> quantities{{"x at 10 s", "m", place(0, 0), end[0], near, 4.5},
                                         {"y at 10 s", "m", place(0, 1), end[1], near, 4.5},
                                         {"velocity along x at 10 s", "m/s", rate(0, 0), end[2], near, 30},
                                         {"velocity along y at 10 s", "m/s", rate(0, 1), end[3], near, 30}};
  for (const auto& way : schemes(1e-4, "Moreau–Jean, h = 1e-4 s")) {
    const auto run = test::finished(way, scene);
    claim_at_end(f, subject, way, run, quantities,
                 {"references/pendulum (elliptic functions)", "tolerance 1e-12 of 1 m per step, 3000 steps"});
    f.at_most(claim_name(subject, "energy error at 10 s", way.name), "J",
              std::abs(run.ledger.kinetic + run.ledger.potential - run.ledger.initial),
              way.fixed() ? 1e-5 : 1e-8, "0",
              way.fixed() ? "second order on smooth motion: (ω h)² of 9.81 J, margin of 10"
                          : "tolerance 1e-12 per step, times the force 9.81 N and 3000 steps");
  }
  // The cheapest settings with a margin.
  const auto required = [&](test::Way way, double tolerance) {
    auto cheap = scene;
    way.choose(cheap);
    cheap.penalty.tolerance = cheap.nonsmooth.tolerance = tolerance;
    Simulation simulation(cheap, test::name_of(way.family));
    std::vector<double> q(3), v(3);
    double sum = 0;
    int next = 1;
    test::watch_steps(simulation, [&](const Step& s) {
      for (; next <= 4000 && next * 0.0025 <= s.t1; ++next) {
        const double t = next * 0.0025;
        s.state(t, q, v);
        const auto exact = at(t);
        for (std::size_t k = 0; k < 2; ++k) {
          const double error = (q[k] - exact[k]) / std::max(std::abs(exact[k]), 1e-3);
          sum += error * error / 8000;
        }
      }
    });
    f.at_most(
        claim_name(subject, "root mean square of the relative errors at 4000 instants of 10 s", way.name), "",
        next > 3999 ? std::sqrt(sum) : INFINITY, 1e-3, "LIM repository, A01: high precision",
        "required accuracy");
  };
  required({"penalty, tolerance 1e-6", Family::penalty}, 1e-6);
  required({"event-driven, tolerance 1e-7", Family::nonsmooth, Scheme::event_driven}, 1e-7);
  required(test::fixed_steps(5e-4, "Moreau–Jean, h = 5e-4 s"), 1e-10);
}

void four_bars(Findings& f) {
  const char* const reference = "references/published/iftomm (elliptic functions)";
  const auto energy = [&](const char* subject, const char* scheme, const Result& run) {
    f.at_most(claim_name(subject, "energy error at 10 s", scheme), "J",
              std::abs(run.ledger.kinetic + run.ledger.potential - run.ledger.initial), 0.1,
              "0 (IFToMM benchmark A02)", "requirement of the benchmark");
  };
  const auto& p = reference::exudyn_four_bars_fine;
  const auto quantities = [&](const reference::FourBarRow& row, double sign, bool published) {
    const auto h = row.head(10);
    // Greatest speed √(v₀² + 4 g W/J), less than 7.1 m/s; the accelerations are below 60 m/s².
    std::vector<Quantity> list{
        {"x of the first head at 10 s", "m", [sign](const State& s) { return sign * 2 * s.q[0]; }, h[0], 1e-3,
         7.1},
        {"y of the first head at 10 s", "m", [](const State& s) { return 2 * s.q[1]; }, h[1], 1e-3, 7.1},
        {"velocity of the first head along x at 10 s", "m/s",
         [sign](const State& s) { return sign * 2 * s.v[0]; }, h[2], 1e-2, 60},
        {"velocity of the first head along y at 10 s", "m/s", [](const State& s) { return 2 * s.v[1]; }, h[3],
         1e-2, 60}};
    if (published)
      for (std::size_t k = 0; k < list.size(); ++k) {
        list[k].published = p[k];
        list[k].published_bound = list[k].bound;
      }
    return list;
  };
  const Grounds grounds{reference,
                        "dependent rows at the aligned positions: up to 1e-4 J of 36 J there, times the "
                        "sensitivity of the passage over the top",
                        "Exudyn, fourBarMechanismIftomm.py, h = 0.125e-3 s",
                        "dependent rows at the aligned positions; error of the published digits 4e-6"};
  const auto scene = read_scene(test::published("iftomm-four-bars"));
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-4, "Moreau–Jean, h = 1e-4 s")}) {
    const char* const subject = "four-bar row of IFToMM A02, N = 2";
    const auto run = test::finished(way, scene);
    claim_at_end(f, subject, way, run, quantities({.count = 2}, 1, true), grounds);
    energy(subject, way.name, run);
  }
  for (const int count : {1, 10, 40}) {
    // Its heads start along −x.
    auto row = test::row_of_four_bars(count, 0);
    row.run.duration = 10;
    const auto way = test::fixed_steps(1e-3, "Moreau–Jean, h = 1e-3 s");
    const auto subject = fmt::format("four-bar row of IFToMM A02, N = {}", count);
    const auto run = test::finished(way, row);
    claim_at_end(f, subject.c_str(), way, run, quantities({.count = count}, -1, false), grounds);
    energy(subject.c_str(), way.name, run);
  }
}

void andrews(Findings& f) {
  const reference::Andrews m;
  const auto y = m.at(0.05L);
  const auto angles = m.angles(y);
  const double near = 3e-9;
  const std::vector<Quantity> quantities{
      {"angle β at 0.05 s", "rad", place(0, 2), angles[0], near, 1300},
      {"angle δ at 0.05 s", "rad", place(4, 2), angles[4], near, 25},
      {"angle γ at 0.05 s", "rad", [](const State& s) { return s.q[8] + std::numbers::pi / 2; }, angles[2],
       near, 205},
      {"x of point F at 0.05 s", "m", [](const State& s) { return 0.007 * std::cos(s.q[2]); },
       double(m.rr * std::cos(y[0])), 2.1e-11, 9.1},
      {"y of point F at 0.05 s", "m", [](const State& s) { return 0.007 * std::sin(s.q[2]); },
       double(m.rr * std::sin(y[0])), 2.1e-11, 9.1},
      {"angular velocity of the crank at 0.05 s", "rad/s", rate(0, 2), double(y[7]), 1e-6, 4e5}};
  const auto scene = read_scene(test::published("iftomm-andrews"));
  const char* const subject = "Andrews' squeezer of IFToMM A03";
  for (const auto& way : schemes(1e-6, "Moreau–Jean, h = 1e-6 s")) {
    const auto run = test::finished(way, scene);
    claim_at_end(f, subject, way, run, quantities,
                 {"references/published/iftomm",
                  "1e-9 rad at 0.03 s as for the IVP test set, growing with the square of time"});
    const auto& l = run.ledger;
    f.at_most(claim_name(subject, "energy balance T + V − E₀ − τ(β − β₀) at 0.05 s", way.name), "J",
              std::abs(l.kinetic + l.potential + l.elastic - l.initial - l.drive),
              way.fixed() ? 4.3e-5 : 1e-8, "0 (IFToMM benchmark A03)",
              way.fixed() ? "first order: the motor's work in one step"
                          : "the motor's torque times the bound of its angle, margin of 100");
  }
}

void planar_mechanics(Findings& f) {
  const auto ways = schemes(1e-4, "Moreau–Jean, h = 1e-4 s");
  const Grounds grounds{
      "references/published/smooth_motion", per_step, "PlanarMechanics 1.6.0, stored results by Dymola",
      "DASSL with tolerance 1e-6 per step; growth by ten to a hundred, assumed after a first comparison"};
  const auto compare = [&](const char* subject, const char* name, const std::vector<Quantity>& quantities,
                           const Grounds& why) {
    const auto scene = read_scene(test::published(name));
    for (const auto& way : ways) claim_at_end(f, subject, way, test::finished(way, scene), quantities, why);
  };
  const auto engine = reference::PistonEngine().at(10);
  const auto& e = reference::modelica_piston_engine;
  compare("piston engine of PlanarMechanics", "modelica-piston-engine",
          {{"crank angle at 10 s", "rad", place(0, 2), double(engine[0]), 1e-8, 2.5, e[0], 1e-4},
           {"angular velocity of the crank at 10 s", "rad/s", rate(0, 2), double(engine[1]), 1e-8, 4.4, e[1],
            1e-4}},
          grounds);

  const auto crab = reference::CraneCrab::at(10);
  const auto& c = reference::modelica_crane_crab;
  compare(
      "crane crab of PlanarMechanics", "modelica-crane-crab",
      {{"place of the cart at 10 s", "m", place(0, 0), double(crab[0]), 1e-9, 1, c[0], 1e-5},
       {"angle of the load at 10 s", "rad", place(1, 2), double(crab[1]), 1e-9, 5.6, c[1], 1e-5},
       {"velocity of the cart at 10 s", "m/s", rate(0, 0), double(crab[2]), 1e-9, 6.8, c[2], 1e-5},
       {"angular velocity of the load at 10 s", "rad/s", rate(1, 2), double(crab[3]), 1e-8, 8.7, c[3], 1e-5}},
      grounds);

  const auto pendulum = reference::DoublePendulumOfModelica::at(10);
  // The published digits differ by up to 1.5e-2: nearby motions separate, and its tolerance is 1e-6.
  const auto lower = [](const std::vector<double>& x) { return x[5] - x[2]; };
  compare(
      "double pendulum of PlanarMechanics", "modelica-double-pendulum",
      {{"upper angle at 10 s", "rad", place(0, 2), double(pendulum[0]), 1e-6, 4.2},
       {"lower angle relative to the upper at 10 s", "rad", [&](const State& s) { return lower(s.q); },
        double(pendulum[1]), 1e-6, 15},
       {"upper angular velocity at 10 s", "rad/s", rate(0, 2), double(pendulum[2]), 1e-5, 16},
       {"lower relative angular velocity at 10 s", "rad/s", [&](const State& s) { return lower(s.v); },
        double(pendulum[3]), 1e-5, 57}},
      {grounds.reference, "tolerance 1e-12 per step, 3000 steps, times the growth of errors by a thousand",
       grounds.published, "DASSL with tolerance 1e-6, times the growth of errors by a thousand"});

  const auto loop = reference::KinematicLoop().at(6);
  const auto& k = reference::modelica_kinematic_loop;
  const auto knee = [](const State& s) { return std::asin(s.q[3]); };
  compare(
      "kinematic loop of PlanarMechanics", "modelica-kinematic-loop",
      {{"angle of the arm at 6 s", "rad", knee, double(loop[0]), 1e-8, 0.62, k[0], 1e-4},
       {"angle of the load relative to the arm at 6 s", "rad",
        [&](const State& s) { return s.q[2] - knee(s); }, double(loop[1]), 1e-8, 1.3, k[1], 1e-4},
       {"angular velocity of the arm at 6 s", "rad/s",
        [&](const State& s) { return s.v[3] / std::cos(knee(s)); }, double(loop[2]), 1e-8, 21, k[2], 1e-4},
       {"angular velocity of the load relative to the arm at 6 s", "rad/s",
        [&](const State& s) { return s.v[2] - s.v[3] / std::cos(knee(s)); }, double(loop[3]), 1e-8, 35, k[3],
        1e-4}},
      {grounds.reference, "tolerance 1e-12 per step, 5000 steps of small masses", grounds.published,
       grounds.published_bound});
}

}  // namespace

void published_smooth(Findings& f) {
  car_axis(f);
  exudyn_slider_cranks(f);
  simple_pendulum(f);
  four_bars(f);
  andrews(f);
  planar_mechanics(f);
}

}  // namespace freeplay::verification
