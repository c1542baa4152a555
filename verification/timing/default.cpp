// The cost of the default scheme compared with the event-driven one, and the accuracy of its first
// contacts (target freeplay-default), on 200 random linkages. Prints a line for each linkage, then a
// summary.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/scene_text.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

/// A scene: a four-bar by Grashof's rule (the crank is the shortest link; shortest + longest < the
/// other two), of bars of 1 to 5 kg/m, with clearance in one to three joints, over one revolution of
/// its crank at 30 to 600 rpm from the ideal joints' start. Clearances are 3e-4 to 1e-2 of the crank,
/// e is 0.1 to 0.9, most have friction and weight.
std::string random_linkage(std::uint64_t index) {
  std::mt19937_64 engine(20260000 + index);
  const auto between = [&](double a, double b) {
    return a + (b - a) * static_cast<double>(engine() >> 11) * 0x1p-53;
  };
  const auto decades = [&](double a, double b) { return std::pow(10, between(a, b)); };
  const double crank = between(0.03, 0.1);
  double coupler = 0, rocker = 0, base = 0;
  do {
    coupler = crank * between(2, 5);
    rocker = crank * between(1.5, 4);
    base = crank * between(1.5, 4.5);
  } while (2 * std::max({coupler, rocker, base}) > coupler + rocker + base - 1.2 * crank);
  std::string text = between(0, 1) < 0.7 ? "gravity = [0.0, -9.81]\n" : "";
  text += fmt::format("[surfaces.s]\nrestitution = {:.4f}\n", between(0.1, 0.9));
  if (between(0, 1) < 0.7) text += fmt::format("friction = {:.4f}\n", decades(-2, -0.7));
  // Circles about the crank pin and the rocker's pivot intersect.
  const double angle = between(0, 2 * std::numbers::pi);
  const Vec2 pin = crank * Vec2{std::cos(angle), std::sin(angle)}, pivot{base, 0}, d = pivot - pin;
  const double s = d.norm(), along = (s * s + coupler * coupler - rocker * rocker) / (2 * s),
               up = std::sqrt(coupler * coupler - along * along);
  const Vec2 end = pin + (along / s) * d + (up / s) * Vec2{-d.y(), d.x()};
  const auto bar = [&](const char* name, Vec2 from, Vec2 to) {
    const double length = (to - from).norm(), mass = length * between(1, 5);
    const Vec2 middle = 0.5 * (from + to);
    text += fmt::format(
        "[bodies.{}]\nmass = {:.17g}\ninertia = {:.17g}\nposition = [{:.17g}, {:.17g}]\nangle = {:.17g}\n",
        name, mass, mass * length * length / 12, middle.x(), middle.y(),
        std::atan2(to.y() - from.y(), to.x() - from.x()));
  };
  bar("crank", {0, 0}, pin);
  bar("coupler", pin, end);
  bar("rocker", pivot, end);
  std::vector<bool> clearance_joint(3);
  for (int missing = 1 + static_cast<int>(between(0, 3)); missing > 0;) {
    const auto which = static_cast<std::size_t>(between(0, 3));
    missing -= !clearance_joint[which];
    clearance_joint[which] = true;
  }
  const auto joint = [&](const char* name, const char* of, double at, double on) {
    text += fmt::format(
        "[joints.{}]\ntype = \"revolute\"\nbetween = [{}]\nat = [[{:.17g}, 0.0], [{:.17g}, 0.0]]\n", name, of,
        at, on);
  };
  const auto play = [&](std::size_t which) {
    const double c = crank * decades(-3.5, -2);
    if (clearance_joint[which])
      text +=
          fmt::format("clearance = {:.17g}\nbearing_radius = {:.17g}\nsurface = \"s\"\n", c, 0.15 * crank);
  };
  joint("main", R"("ground", "crank")", 0, -0.5 * crank);
  joint("crank_pin", R"("crank", "coupler")", 0.5 * crank, -0.5 * coupler);
  play(0);
  joint("rocker_pin", R"("coupler", "rocker")", 0.5 * coupler, 0.5 * rocker);
  play(1);
  joint("pivot", R"("ground", "rocker")", base, -0.5 * rocker);
  play(2);
  const double rpm = 30 * std::pow(20, between(0, 1));
  return text + test::drive("motor", "main", fmt::format("speed_rpm = {:.17g}\n", rpm)) +
         "[run]\nrevolutions = 1\nstart = \"ideal\"\n";
}

Result run(Scene scene, Scheme scheme, double tolerance = 1e-10) {
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.tolerance = tolerance;
  return test::simulate(scene, Family::nonsmooth);
}

/// Error of the first three contacts: times relative to the time since the start, speeds to the
/// greatest of the three.
double off(const Result& found, const Result& exact) {
  const auto a = test::touches(found), b = test::touches(exact);
  const auto count = std::min<std::size_t>(3, b.size());
  if (a.size() < count) return INFINITY;
  double fastest = 0, worst = 0;
  for (std::size_t i = 0; i < count; ++i) fastest = std::max(fastest, -b[i].v_n_minus);
  for (std::size_t i = 0; i < count; ++i)
    worst = std::max({worst, std::abs(a[i].t / b[i].t - 1), a[i].contact != b[i].contact ? INFINITY : 0.0,
                      std::abs(a[i].v_n_minus - b[i].v_n_minus) / fastest});
  return worst;
}

bool finished(const Result& run) { return run.ending.status == Ending::Status::finished; }

/// Without a hand-over the default is the event-driven scheme bit for bit, which a test checks.
Result beside(const Scene& scene, const Result& automatic) {
  return automatic.work.handovers == 0 && finished(automatic) ? automatic : run(scene, Scheme::event_driven);
}

Result exact_touches(Scene scene, const Result& automatic) {
  const auto touches = test::touches(automatic);
  if (touches.size() >= 3) scene.run.duration = std::min(scene.run.duration, 1.01 * touches[2].t);
  return run(scene, Scheme::event_driven, 1e-12);
}

}  // namespace

/// `freeplay-default [FIRST [BEYOND]]`: the linkages FIRST to BEYOND − 1.
int main(int count, char** arguments) {
  const int first = count > 1 ? std::atoi(arguments[1]) : 0,
            beyond = count > 2 ? std::atoi(arguments[2]) : 200;
  int dear = 0, both = 0, near = 0;
  for (int i = first; i < beyond; ++i) {
    const auto scene = parse_scene(random_linkage(static_cast<std::uint64_t>(i)), "linkage");
    const auto automatic = run(scene, Scheme::automatic), events = beside(scene, automatic);
    const double away = off(automatic, exact_touches(scene, automatic));
    const auto over = [](long one, long other) {
      return static_cast<double>(one) / static_cast<double>(other);
    };
    const double rhs = over(automatic.work.rhs, events.work.rhs);
    both += finished(automatic) && finished(events);
    dear += finished(automatic) && finished(events) && rhs > 1.2;
    near += away <= 1e-3;
    fmt::print(
        "{}: {} and {}, right-hand sides {:.3f}, factorisations {:.3f}, touches off by {:.1g}, "
        "{} hand-overs for {:.2g} "
        "of {:.2g} s\n",
        i, automatic.ending.reason.empty() ? "finished" : automatic.ending.reason,
        events.ending.reason.empty() ? "finished" : events.ending.reason, rhs,
        over(automatic.work.factorisations, events.work.factorisations), away, automatic.work.handovers,
        automatic.work.stepped, scene.run.duration);
  }
  fmt::print(
      "both finish: {}; of these above 1.2 in right-hand sides: {}; "
      "first three contact onsets within 1e-3: {} of {}\n",
      both, dear, near, beyond - first);
}
