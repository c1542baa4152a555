// Runs with compiled functions against general runs of the same random scenes. Compiled functions
// repeat the operations of the general evaluation (docs/theory/compiled.md), so all digits must agree.
#include <atomic>
#include <set>

#include "verification/claims/claim.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

namespace rs = random_scenes;

constexpr std::uint64_t compared_seed = 2026;
constexpr int compared_scenes = 40;
constexpr int curved_scenes = 60;
constexpr int compared_onsets = 10;
constexpr long longest_comparison = 1500;  // steps

/// Ends a run after a number of contact onsets or steps.
class Brief final : public Observer {
 public:
  StopToken token() const { return StopToken(done_); }
  void event(const Event& e) override {
    if (e.kind != EventKind::separation && ++onsets_ >= compared_onsets) done_ = true;
  }
  void step(const Step&) override {
    if (++steps_ >= longest_comparison) done_ = true;
  }

 private:
  int onsets_ = 0;
  long steps_ = 0;
  std::atomic<bool> done_ = false;
};

struct BriefRun {
  std::string failure;  ///< message of a scene that cannot be run
  Result result;
};

BriefRun brief_run(const Scene& scene, const rs::Way& way, Compile compile) {
  BriefRun run;
  try {
    Brief brief;
    Simulation simulation(scene, name_of(way.family), {.compile = compile});
    run.result = simulation.run({.observers = {&brief}, .stop = brief.token()});
  } catch (const ModelError& e) {
    run.failure = e.what();
  }
  return run;
}

bool same_digits(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool same_event(const Event& a, const Event& b) {
  return a.kind == b.kind && a.contact == b.contact && same_digits(a.t, b.t) &&
         same_digits(a.v_n_minus, b.v_n_minus) && same_digits(a.v_n_plus, b.v_n_plus) &&
         same_digits(a.v_t_minus, b.v_t_minus) && same_digits(a.v_t_plus, b.v_t_plus) &&
         same_digits(a.impulse_n, b.impulse_n) && same_digits(a.impulse_t, b.impulse_t) &&
         same_digits(a.duration, b.duration);
}

bool same_run(const BriefRun& a, const BriefRun& b) {
  const auto &x = a.result.final_state, &y = b.result.final_state;
  return a.failure == b.failure && a.result.ending.reason == b.result.ending.reason &&
         std::ranges::equal(a.result.events, b.result.events, same_event) && same_digits(x.t, y.t) &&
         std::ranges::equal(x.q, y.q, same_digits) && std::ranges::equal(x.v, y.v, same_digits) &&
         std::ranges::equal(x.z, y.z, same_digits) &&
         same_digits(a.result.ledger.closure(), b.result.ledger.closure());
}

/// Random scenes of a suite, by some of its ways.
struct Compared {
  const char* subject;
  const char* selection;               ///< of random_scenes::draw()
  int scenes, fewest;                  ///< drawn, and compared by each way
  const char* fewer;                   ///< reason for the difference
  std::vector<std::string_view> ways;  ///< empty: all
  int general;                         ///< most scenes with parts that have no compiled function
  const char* why_general;
};

long compare(Findings& f, const Compared& c) {
  long events = 0;
  std::set<int> with_general_parts;
  for (const auto& way : rs::ways(rs::draw(compared_seed, 0, c.selection).suite)) {
    if (!c.ways.empty() && std::ranges::find(c.ways, way.name) == c.ways.end()) continue;
    int compared = 0, differing = 0;
    for (int index = 0; index < c.scenes; ++index) {
      const auto drawn = rs::draw(compared_seed, index, c.selection);
      if (!rs::has_model(drawn, way)) continue;
      const auto scene = rs::scene_for(drawn, way);
      const auto compiled = brief_run(scene, way, Compile::always);
      const auto& made = compiled.result.compiled;
      if (!made.general_parts.empty()) with_general_parts.insert(index);
      if (compiled.failure.empty() && !made.used) {
        if (!made.general_parts.empty()) continue;
        throw std::runtime_error("compiled functions cannot be checked: " + made.reason);
      }
      ++compared;
      differing += !same_run(compiled, brief_run(scene, way, Compile::never));
      events += static_cast<long>(compiled.result.events.size());
    }
    f.between(claim_name(c.subject, "scenes compared with general runs", way.name), "", compared, c.fewest,
              c.scenes, "number of scenes", c.fewer);
    f.at_most(claim_name(c.subject, "scenes whose contacts or final state have other digits", way.name), "",
              differing, 0, "general runs of the same scenes",
              "the functions repeat the operations of the general evaluation in their order");
  }
  f.at_most(claim_name(c.subject, "scenes with parts that are not compiled"), "",
            static_cast<double>(with_general_parts.size()), c.general, "number of scenes", c.why_general);
  return events;
}

void compiled_scenes(Findings& f) {
  const char* const subject = "random scenes by compiled functions";
  const long events = compare(
      f, {subject,
          "",
          compared_scenes,
          compared_scenes / 2,
          "some scenes have no penalty model or no part that can be compiled; these are fewer than half",
          {},
          compared_scenes / 4,
          "rollers on cams, groups of contacts and dependent rows: fewer than one kind in four"});
  f.between(claim_name(subject, "contact events compared"), "", static_cast<double>(events), 200, 1e4,
            "number of events", "five schemes, 20 scenes or more, two events each; runs end at ten onsets");
  compare(f, {"random scenes with tables and curves by compiled functions",
              "new",
              curved_scenes,
              curved_scenes / 2,
              "scenes of some kinds have no penalty model; these are fewer than half",
              {"event-driven", "moreau-jean fixed", "adams_bashforth_moulton"},
              0,
              "all elements of these kinds have compiled functions"});
}

}  // namespace

Parts compiled_mechanisms() { return {compiled_scenes}; }

}  // namespace freeplay::verification
