// One stranger by one way: seen, held to every check, and named.
#include <algorithm>
#include <cmath>

#include "dynamics/elements.hpp"
#include "facade/companion.hpp"
#include "verification/strangers/draft.hpp"
#include "verification/strangers/subject.hpp"

namespace freeplay::verification::strangers {
namespace {

constexpr Way all_ways[] = {
    {"penalty", Family::penalty, [](Scene&) {}},
    {"event-driven", Family::nonsmooth, [](Scene& s) { s.nonsmooth.scheme = Scheme::event_driven; }},
    {"moreau-jean", Family::nonsmooth, [](Scene& s) { s.nonsmooth.scheme = Scheme::moreau_jean; }, true,
     true},
    {"chosen steps", Family::nonsmooth,
     [](Scene& s) {
       s.nonsmooth.scheme = Scheme::moreau_jean;
       s.nonsmooth.step.reset();
     },
     false, true},
    {"automatic", Family::nonsmooth, [](Scene& s) { s.nonsmooth.scheme = Scheme::automatic; }},
};
const Way& penalty = all_ways[0];
const Way& events = all_ways[1];

bool lubricates(const Scene& scene) { return !scene.mechanism.lubricants.empty(); }

template <class Kind, class List>
bool has(const List& list) {
  return std::ranges::any_of(list, [](const auto& one) { return std::holds_alternative<Kind>(one); });
}

/// The way that knows the scene best: whose single touches the others must meet.
const Way& best(const Scene& scene, const Way& way, bool touching) {
  // A contact that rests, or friction of fixed bound, is regularised in penalty: another motion within its own bounds.
  if (way.family == Family::penalty && (touching || has<JointFriction>(scene.mechanism.loads)))
    return penalty;
  return events;
}

/// Adds what is told of a run by its own notes to an outcome.
Verdict amounts(const Sight& sight, const Check* missed, const std::string& what) {
  const auto& run = sight.result;
  const bool failed = run.ending.status == Ending::Status::failed;
  if (!missed) {
    if (failed) return {Outcome::refused, "", run.ending.reason};
    return {};
  }
  for (const auto& note : run.notes)
    if (note.starts_with("DOUBTFUL") || (!missed->told_by.empty() && note.find(missed->told_by) != note.npos))
      return {failed ? Outcome::refused : Outcome::degraded, missed->name,
              failed ? run.ending.reason : what + "; said: " + note};
  return {Outcome::wrong, missed->name, failed ? what + "; then stopped: " + run.ending.reason : what};
}

}  // namespace

std::span<const Way> ways() { return all_ways; }

bool has_model(const Scene& scene, const Way& way) {
  if (way.family == Family::nonsmooth) return true;
  return std::ranges::all_of(scene.mechanism.surfaces,
                             [](const Surface& s) { return s.restitution.value_or(1) > 0; });
}

std::vector<CheckFacts> checks() {
  std::vector<CheckFacts> list;
  for (const auto& all : {conservation_checks(), agreement_checks()})
    list.insert(list.end(), all.begin(), all.end());
  return list;
}

const char* word_for(Outcome outcome) {
  constexpr const char* words[] = {"right", "told", "refused", "SILENT", "HUNG", "CRASHED"};
  return words[static_cast<int>(outcome)];
}

bool Subject::lubricated() const { return lubricates(scene); }

bool Subject::conservative() const {
  const auto& m = scene.mechanism;
  if (!m.drives.empty() || lubricated() || has<ForceLoad>(m.loads) || has<TorqueLoad>(m.loads) ||
      has<JointFriction>(m.loads))
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
           return spring ? inner(spring->between) : torsion && inner(torsion->between);
         });
}

bool Subject::touching() const {
  for (std::size_t k = 0; k < sight.start_gap.size(); ++k)
    if (sight.start_gap[k] < 1e-6 * sight.measure[k]) return true;
  return false;
}

int chosen(const Subject& s, int of) {
  std::uint64_t salt = 7919;
  for (const char* c = s.way.name; *c; ++c) salt = salt * 31 + static_cast<unsigned char>(*c);
  return Draw(s.stranger.seed ^ salt, static_cast<std::uint64_t>(s.stranger.index)).whole(0, of - 1);
}

Verdict judge(const Stranger& stranger, const Way& way, const std::function<void(Sight&)>& falsify) {
  Subject s{stranger, parse_scene(stranger.text, fmt::format("stranger {}", stranger.index)), way, {}, {}};
  way.choose(s.scene);
  try {
    // Looked at for an instant only: whether contacts touch at the start decides what the run is held to.
    s.sight = look(s.scene, way, {.until = 0.0});
    s.reference = make_reference(s.scene, best(s.scene, way, s.touching()));
    LookRequest request{.forces = chosen(s, 4) == 0};
    if (s.reference.way) request.at = s.reference.at.t;
    s.sight = look(s.scene, way, request);
  } catch (const SceneError& e) {
    return {Outcome::refused, "", e.what()};
  }
  const double cpu = s.sight.result.cpu_seconds;
  if (s.sight.overtime) {
    const double end = s.scene.run.duration;
    const bool goes_on = s.sight.went_on > 1e-3 * end;
    return {goes_on ? Outcome::refused : Outcome::hung, "",
            fmt::format("after {:.0f} s of CPU at t = {:.3g} s of {:.3g} s{}", run_limit,
                        s.sight.result.t_end, end, goes_on ? ", and going on" : ""),
            cpu};
  }
  if (way.stepped)
    if (const auto doubt = doubt_first_touches(s.scene, {}, {})) add(*doubt, s.sight.result);
  if (falsify) falsify(s.sight);
  // What is silent outweighs what is told.
  Verdict verdict = amounts(s.sight, nullptr, "");
  for (const auto& all : {conservation_checks(), agreement_checks()})
    for (const auto& check : all)
      if (const auto what = check.judge(s)) {
        const auto found = amounts(s.sight, &check, *what);
        if (verdict.check.empty() || found.outcome > verdict.outcome) verdict = found;
      }
  verdict.cpu = cpu;
  verdict.touches = static_cast<int>(s.reference.touches.size());
  return verdict;
}

}  // namespace freeplay::verification::strangers
