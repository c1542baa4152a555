// Runs one scene by one method, applies every check, and classifies the outcome.
#include <algorithm>
#include <cmath>

#include "dynamics/elements.hpp"
#include "facade/assess.hpp"
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/numbers.hpp"

namespace freeplay::verification::random_scenes {
namespace {

bool lubricates(const Scene& scene) { return !scene.mechanism.lubricants.empty(); }

template <class Kind, class List>
bool has(const List& list) {
  return std::ranges::any_of(list, [](const auto& one) { return std::holds_alternative<Kind>(one); });
}

const Way& way_named(std::string_view name) {
  return *std::ranges::find(ways(Suite::agreement), name, &Way::name);
}

/// The most accurate method for the scene: the contact onsets of the others are compared with it.
const Way& best(const Scene& scene, const Way& way, bool touching) {
  // Penalty regularises a resting contact, or friction of fixed bound: another motion within its
  // own bounds.
  const bool own = way.family == Family::penalty && (touching || has<JointFriction>(scene.mechanism.loads) ||
                                                     has<Freewheel>(scene.mechanism.loads));
  return own ? way : way_named("event-driven");
}

/// The outcome of a run that misses a check by `what`, with its notes.
Verdict amounts(const Result& run, const Check& missed, const std::string& what) {
  auto verdict = beyond_bound(run, what, missed.noted_by);
  verdict.check = missed.name;
  if (verdict.outcome == Outcome::refused) verdict.detail = run.ending.reason;
  return verdict;
}

}  // namespace

std::vector<Check> checks() {
  std::vector<Check> list;
  for (const auto& all : {conservation_checks(), agreement_checks()})
    list.insert(list.end(), all.begin(), all.end());
  return list;
}

bool Subject::lubricated() const { return lubricates(scene); }

bool Subject::conservative() const {
  const auto& m = scene.mechanism;
  if (!m.drives.empty() || lubricated() || has<ForceLoad>(m.loads) || has<TorqueLoad>(m.loads) ||
      has<JointFriction>(m.loads) || has<Freewheel>(m.loads))
    return false;
  const auto dissipates = [](const auto& load) {
    const Dynamics<std::decay_t<decltype(load)>> dynamics{load};
    if constexpr (requires { dynamics.does_work(); })
      return dynamics.does_work();
    else
      return false;
  };
  for (const auto& load : m.loads)
    if (std::visit(dissipates, load)) return false;
  return std::ranges::all_of(m.surfaces,
                             [](const Surface& s) { return s.restitution.value_or(1) == 1 && !s.friction; });
}

bool Subject::alone() const {
  const auto& m = scene.mechanism;
  const auto grounded = [&m](const auto& one) {
    return std::visit(
        [&m](const auto& e) {
          const auto on = [](const std::array<int, 2>& b) { return b[0] == ground || b[1] == ground; };
          if constexpr (requires { e.between; })
            return on(e.between);
          else
            return on(bodies_of(m.joints[e.joint]));
        },
        one);
  };
  return m.gravity.is_zero() && m.drives.empty() && std::ranges::none_of(m.joints, grounded) &&
         std::ranges::none_of(m.contacts, grounded) && std::ranges::all_of(m.loads, [](const Load& load) {
           const auto* spring = std::get_if<SpringDamper>(&load);
           const auto* torsion = std::get_if<TorsionalSpringDamper>(&load);
           const auto inner = [](const std::array<int, 2>& b) { return b[0] != ground && b[1] != ground; };
           const auto* beam = std::get_if<BeamElement>(&load);
           return spring ? inner(spring->between)
                  : beam ? inner(beam->between)
                         : torsion && inner(torsion->between);
         });
}

bool Subject::reduced() const { return std::ranges::any_of(scene.mechanism.beams, &Beam::is_reduced); }

bool Subject::touching() const {
  for (std::size_t k = 0; k < sight.start_gap.size(); ++k)
    if (sight.start_gap[k] < 1e-6 * sight.measure[k]) return true;
  return false;
}

int chosen(const Subject& s, int of) {
  std::uint64_t salt = 7919;
  for (const char* c = s.way.name; *c; ++c) salt = salt * 31 + static_cast<unsigned char>(*c);
  return Draw(s.drawn.seed ^ salt, static_cast<std::uint64_t>(s.drawn.index)).whole(0, of - 1);
}

namespace {

/// References of one scene, by the methods that make them.
using References = std::map<const Way*, Reference>;

/// Without a separate reference: against other runs, conservation, and the notes of the run.
Verdict assess_by_checks(const RandomScene& scene, const Way& way, const std::function<void(Sight&)>& falsify,
                         References& references) {
  Subject s{scene, scene_for(scene, way), way, {}, {}};
  try {
    // A run of zero length: whether contacts are closed at the start decides which checks apply.
    s.sight = look(s.scene, way, {.until = 0.0});
    const auto& by = best(s.scene, way, s.touching());
    if (!references.contains(&by)) references[&by] = make_reference(s.scene, by);
    s.reference = references.at(&by);
    LookRequest request{.forces = chosen(s, 4) == 0};
    if (s.reference.way) request.at = s.reference.at.t;
    s.sight = look(s.scene, way, request);
  } catch (const SceneError& e) {
    return {Outcome::refused, e.what()};
  }
  auto& run = s.sight.result;
  if (s.sight.overtime) {
    const double end = s.scene.run.duration;
    const bool goes_on = s.sight.went_on > 1e-3 * end;
    return {goes_on ? Outcome::refused : Outcome::hung,
            fmt::format("after {:.0f} s of CPU at t = {:.3g} s of {:.3g} s{}", run_limit(scene.suite),
                        run.t_end, end, goes_on ? ", and going on" : ""),
            "", 0, run.cpu_seconds};
  }
  if (way.stepped)
    if (const auto doubt = doubt_first_touches(s.scene, {}, {})) add(*doubt, run);
  if (falsify) falsify(s.sight);
  Verdict verdict;
  if (run.ending.status == Ending::Status::failed) verdict = {Outcome::refused, run.ending.reason};
  // A silent error outweighs one that a note reports.
  for (const auto& check : checks())
    if (const auto what = check.assess(s)) {
      const auto found = amounts(run, check, *what);
      if (verdict.check.empty() || found.outcome > verdict.outcome) verdict = found;
    }
  verdict.cpu = run.cpu_seconds;
  verdict.known = static_cast<double>(s.reference.touches.size());
  return verdict;
}

}  // namespace

Verdict assess(const RandomScene& scene, const Way& way, const std::function<void(Sight&)>& falsify) {
  if (scene.suite == Suite::rows) return KnownRows(scene).assess(way, falsify);
  References references;
  return assess_by_checks(scene, way, falsify, references);
}

void assess(const RandomScene& scene, std::span<const Way* const> by,
            const std::function<void(const Verdict&)>& seen) {
  KnownRows known(scene);
  References references;
  for (const auto* way : by) try {
      seen(scene.suite == Suite::rows ? known.assess(*way) : assess_by_checks(scene, *way, {}, references));
    } catch (const std::exception& e) {
      seen({Outcome::crashed, e.what()});
    }
}

}  // namespace freeplay::verification::random_scenes
