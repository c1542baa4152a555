// Scaling of the paper's slider-crank with crank speed. With an impact law the mechanism has no
// time scale: no gravity, no spring, no film. M a + Gᵀλ = 0 is homogeneous of degree 2 in the
// velocities, and Newton's restitution and Coulomb's friction relate velocities to velocities and
// impulses to impulses. If q(t) is the motion at ω, q(st) is that at sω from initial velocities s
// times as large. The Poincaré section of every turn is therefore equal in units of the clearance
// and of rω, also for a chaotic motion. With friction F in the guide this is true at equal F/(m r
// ω²).
#include "study/runs/section_run.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

struct MethodName {
  const char *family, *scheme, *name;
  double step;  ///< s, at 100 rpm; 0: adaptive
};
constexpr MethodName event_driven{"nonsmooth", "event-driven", "event-driven", 0},
    automatic{"nonsmooth", "automatic", "automatic", 0},
    moreau_jean{"nonsmooth", "moreau-jean", "Moreau–Jean, h = 2e-5 s at 100 rpm", 2e-5},
    penalty{"penalty", "automatic", "penalty", 0};

/// The journal's eccentricity over the clearance and the slider's velocity over rω at top dead
/// centre of every turn; `friction`: of the guide (N).
std::vector<double> section(const MethodName& way, double rpm, int turns, double friction = 0) {
  std::vector<std::string> set{fmt::format("drives.motor.speed_rpm={}", rpm),
                               fmt::format("run.revolutions={}", turns), "run.discard=0",
                               fmt::format("nonsmooth.scheme=\"{}\"", way.scheme)};
  if (way.step > 0) set.push_back(fmt::format("nonsmooth.step={}", way.step * 100 / rpm));
  if (friction > 0) set.push_back(fmt::format("loads.bearing.force={}", friction));
  const auto scene = read_scene(
      friction > 0 ? test::source_folder() / "cases/flores2011-attractors/scene.toml" : test::flores(), set);
  const SectionRequest requested{.formulation = way.family,
                                 .section = "every period",
                                 .columns = {"gudgeon.ex_c", "gudgeon.ey_c", "slider.vx"}};
  const auto run = SectionSimulation(scene, requested, {}).run();
  if (run.ending.status != Ending::Status::finished) throw std::runtime_error(run.ending.reason);
  const double rim = 0.05 * rpm * 2 * std::numbers::pi / 60;
  std::vector<double> points;
  for (std::size_t i = 0; i < run.size(); ++i)
    for (const double x : {run.at(i, 0), run.at(i, 1), run.at(i, 2) / rim}) points.push_back(x);
  return points;
}

/// Greatest difference of the first `count` values; NaN where a list is shorter.
double apart(const std::vector<double>& a, const std::vector<double>& b, std::size_t count) {
  if (a.size() < count || b.size() < count) return NAN;
  double worst = 0;
  for (std::size_t i = 0; i < count; ++i) worst = greatest(worst, std::abs(a[i] - b[i]));
  return worst;
}

void sections(Findings& f) {
  const char *homogeneous = "0: the equations are homogeneous in the velocities",
             *exponents =
                 "exact: a factor of 2 changes exponents alone, "
                 "so that every bit is equal if no scheme has a time or "
                 "speed scale",
             *fewer =
                 "roundings of 1e-16 differ, and the impacts of the first turn amplify them by some 1e5, "
                 "margin of 100";
  const char *subject = "paper's slider-crank with clearance",
             *rubbing = "paper's slider-crank with clearance and guide friction F",
             *doubled = "difference of sections at 200 and 100 rpm, eight turns";
  constexpr int turns = 8;
  constexpr std::size_t all = 3 * turns, first = 3;
  for (const auto& way : {event_driven, automatic, moreau_jean}) {
    const auto slow = section(way, 100, turns);
    f.within(claim_name(subject, doubled, way.name), "", apart(slow, section(way, 200, turns), all), 0, 0,
             homogeneous, exponents);
    f.at_most(claim_name(subject, "difference of sections at 300 and 100 rpm, first turn", way.name), "",
              apart(slow, section(way, 300, 1), first), 1e-9, homogeneous, fewer);
  }
  const auto rubbed = section(automatic, 100, turns, 2);
  f.within(claim_name(rubbing, fmt::format("{}, F/(m r ω²) = 0.36 at both speeds", doubled), automatic.name),
           "", apart(rubbed, section(automatic, 200, turns, 8), all), 0, 0, homogeneous, exponents);
  const char* another =
      "eccentricities differ by more than rounding, and by no more than twice the clearance";
  f.between(claim_name(rubbing, fmt::format("{}, F = 2 N at both speeds", doubled), automatic.name), "",
            apart(rubbed, section(automatic, 200, turns, 2), all), 1e-3, 2.1,
            "different: F/(m r ω²) is 0.36 and 0.09", another);
  f.between(claim_name(subject, doubled, penalty.name), "",
            apart(section(penalty, 100, turns), section(penalty, 200, turns), all), 1e-3, 2.1,
            "different: a compliant impact has a time scale", another);
}

}  // namespace

Parts rescaling() { return {sections}; }

}  // namespace freeplay::verification
