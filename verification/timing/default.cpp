// The cost of the default scheme compared with the event-driven one, and the accuracy of its first
// contacts (target freeplay-default), on 200 random linkages (verification/support/linkages.hpp).
// Prints a line for each linkage, then a summary.
#include <fmt/format.h>

#include <cstdlib>

#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/linkages.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;

namespace {

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
    const auto scene = parse_scene(verification::random_linkage(static_cast<std::uint64_t>(i)), "linkage");
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
