// The paper's rig with an impact law has no time of its own: no gravity, no spring, no film. M a + Gᵀλ = 0 is homogeneous of
// degree 2 in the rates, and Newton's restitution and Coulomb's friction relate velocities to velocities and impulses to
// impulses. So with q(t) at ω, q(st) is the motion at sω from a start whose rates are s times as great, and the section of
// every turn is the same in units of the clearance and of rω: for ever, chaotic as the motion is. With friction F in the guide
// the same holds at the same F/(m r ω²).
#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "mechanism/scene.hpp"
#include "study/runs/section_run.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification {
namespace {

struct Way {
  const char *family, *scheme;
  double step;  ///< s, at 100 rpm; 0: chosen
};
constexpr Way event_driven{"nonsmooth", "event-driven", 0}, automatic{"nonsmooth", "automatic", 0},
    moreau_jean{"nonsmooth", "moreau-jean", 2e-5}, penalty{"penalty", "automatic", 0};

/// Where the journal stands over the clearance at top dead centre, turn by turn, and the slider's speed over rω; `friction` of
/// the guide (N), where there is any.
std::vector<double> section(const Way& way, double rpm, int turns, double friction = 0) {
  std::vector<std::string> set{fmt::format("drives.motor.speed_rpm={}", rpm),
                               fmt::format("run.revolutions={}", turns), "run.discard=0",
                               fmt::format("nonsmooth.scheme=\"{}\"", way.scheme)};
  if (way.step > 0) set.push_back(fmt::format("nonsmooth.step={}", way.step * 100 / rpm));
  if (friction > 0) set.push_back(fmt::format("loads.bearing.force={}", friction));
  const auto scene = read_scene(
      friction > 0 ? test::source_folder() / "cases/flores2011-attractors/scene.toml" : test::flores(), set);
  const SectionRequest asked{.formulation = way.family,
                             .section = "every period",
                             .columns = {"gudgeon.ex_c", "gudgeon.ey_c", "slider.vx"}};
  const auto run = SectionSimulation(scene, asked, {}).run();
  if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
  const double rim = 0.05 * rpm * 2 * std::numbers::pi / 60;
  std::vector<double> points;
  for (std::size_t i = 0; i < run.size(); ++i)
    for (const double x : {run.at(i, 0), run.at(i, 1), run.at(i, 2) / rim}) points.push_back(x);
  return points;
}

/// Of the first `count` numbers of each; NaN where one has fewer.
double apart(const std::vector<double>& a, const std::vector<double>& b, std::size_t count) {
  if (a.size() < count || b.size() < count) return NAN;
  double worst = 0;
  for (std::size_t i = 0; i < count; ++i) worst = greatest(worst, std::abs(a[i] - b[i]));
  return worst;
}

}  // namespace

Findings rescaling() {
  Findings f;
  const char
      *homogeneous = "the equations are homogeneous in the rates",
      *exponents =
          "a factor of 2 changes exponents alone: every bit is the same if no scheme has a time or "
          "a speed of its own",
      *fewer =
          "roundings of 1e-16 differ, and the first turn's impacts amplify them by some 1e5; room of a "
          "hundred";
  constexpr int turns = 8;
  constexpr std::size_t all = 3 * turns, first = 3;
  for (const auto& way : {event_driven, automatic, moreau_jean}) {
    const auto slow = section(way, 100, turns);
    f.within(fmt::format("section at 200 rpm less that at 100 rpm, eight turns, {}", way.scheme), "",
             apart(slow, section(way, 200, turns), all), 0, 0, homogeneous, exponents);
    f.at_most(fmt::format("the same at 300 rpm, first turn, {}", way.scheme), "",
              apart(slow, section(way, 300, 1), first), 1e-9, homogeneous, fewer);
  }
  const auto rubbed = section(automatic, 100, turns, 2);
  f.within("the same with friction in the guide, F/(m r ω²) = 0.36 at both speeds, automatic", "",
           apart(rubbed, section(automatic, 200, turns, 8), all), 0, 0, homogeneous, exponents);
  const char* another =
      "places within the bearing differ by more than any rounding, and by no more than its width";
  f.between("with F = 2 N at both speeds, automatic", "",
            apart(rubbed, section(automatic, 200, turns, 2), all), 1e-3, 2.1,
            "the parameter is F/(m r ω²), 0.36 and 0.09", another);
  f.between("with a contact force, penalty", "",
            apart(section(penalty, 100, turns), section(penalty, 200, turns), all), 1e-3, 2.1,
            "an impact has a time of its own, whatever the speed of the crank", another);
  return f;
}

}  // namespace freeplay::verification
