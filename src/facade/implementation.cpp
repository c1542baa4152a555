#include "facade/implementation.hpp"

#include <deque>
#include <utility>

#include "formulations/time_stepping/lanes.hpp"

namespace freeplay {

Layout layout_of(const Scene& scene, const System& system, const State& start) {
  Layout l;
  for (const auto& b : scene.mechanism.bodies) l.bodies.push_back(b.name);
  for (int k = 0; k < system.contacts(); ++k) l.contacts.push_back(system.contact_facts(k).name);
  for (const auto& f : system.families()) l.families.push_back(f.name);
  for (const auto& i : scene.instruments) l.channels.push_back(i.name);
  l.forces = system.report().elements;
  auto e = system.make_evaluation();
  system.place(start.t, start.q.data(), e);
  for (int k = 0; k < system.contacts(); ++k) {
    const auto eccentricity = system.eccentricity(k, start.q.data(), e);
    l.start.push_back({eccentricity.x(), eccentricity.y(), system.gap(k, start.q.data(), e)});
  }
  l.duration = l.end = scene.run.duration;
  l.output_step = scene.run.output_step.value_or(scene.run.duration / 20000);
  if (const auto* drive = main_drive(scene.mechanism)) {
    l.crank_speed = drive->speed;
    l.crank_start = drive->initial_angle;
  }
  return l;
}

// Runs of several simulations in lanes (formulations/time_stepping/lanes.hpp): sorts them by the structure of
// their mechanisms, compiles the functions of lanes, and divides the time of the thread among the runs.

/// Divides the CPU time of a thread equally among the runs that are in progress.
class SharedClock {
 public:
  /// `account`: its time, s
  void begin(double& account) {
    charge();
    open_.push_back(&account);
  }
  void end(double& account) {
    charge();
    std::erase(open_, &account);
  }
  void charge() {
    const double now = thread_seconds();
    for (auto* account : open_) *account += (now - last_) / static_cast<double>(open_.size());
    last_ = now;
  }
  /// The time since the last call belongs to none of them.
  void skip() { last_ = thread_seconds(); }

 private:
  std::vector<double*> open_;
  double last_ = thread_seconds();
};

/// One call of run_together().
class Simulation::LaneJobs {
 public:
  explicit LaneJobs(const std::function<std::optional<LaneJob>()>& next) : next_(next) {}

  void run() {
    for (;;) {
      auto first = members_to_begin();
      if (first.empty()) return;
      std::vector<LaneCandidate> candidates;
      for (const auto& m : first) {
        auto& s = m->simulation();
        candidates.push_back({&s.system, &s.start, s.facts(), &m->traced()});
      }
      if (const auto functions = compile_lanes(candidates, first.front()->one.request.stop)) {
        together(*functions, std::move(first));
        continue;
      }
      if (first.size() > 1) declined_ = std::make_shared<const TracedLanes>(first.front()->traced());
      for (const auto& m : first) alone(m->one);
    }
  }

 private:
  struct Member {
    LaneJob one;
    std::unique_ptr<Implementation::RunInProgress> run = {};  // null: not begun, or ended
    double cpu = 0;                                           // s
    Implementation& simulation() const { return *one.simulation->it_; }
    const TracedLanes& traced() const { return *simulation().lanes; }
    bool like(const TracedObject& structure) const { return traced().object.same_structure(structure); }
  };
  using Members = std::deque<std::unique_ptr<Member>>;

  static void alone(const LaneJob& one) {
    auto& s = *one.simulation->it_;
    auto run = std::make_unique<Implementation::RunInProgress>(s, one.request);
    auto result = run->finish(s.form->run(run->until, run->watch));
    run.reset();
    if (one.ended) one.ended(std::move(result), 0);
  }

  /// The next run that may have a lane; others are run at once. Null: there is none.
  std::unique_ptr<Member> next() {
    for (;;) {
      clock_.charge();
      auto one = next_();
      if (!one) return nullptr;
      auto member = std::make_unique<Member>(Member{std::move(*one)});
      auto& s = member->simulation();
      // Other runs are too short to be compiled, or shall be general.
      const bool fits = s.compiled && s.compiled->used && fits_lanes(*s.form);
      if (fits && !s.lanes) {
        s.lanes = trace_lanes(s.system, s.start, s.facts(), lanes_of_machine(), like_.get());
        if (!like_ || !s.lanes->object.same_structure(like_->object))
          like_ = std::make_shared<const TracedLanes>(*s.lanes);
      }
      if (fits && s.lanes->traced && !(declined_ && member->like(declined_->object))) {
        clock_.skip();
        return member;
      }
      alone(member->one);
      clock_.skip();
    }
  }

  bool has_room() const { return kept_.size() < static_cast<std::size_t>(most_together()); }

  /// Runs of one structure, at most one for each lane. Those of other structures are kept for later.
  Members members_to_begin() {
    Members found, earlier = std::exchange(kept_, {});
    const auto lanes = [&] { return found.empty() ? 1 : found.front()->traced().object.lanes(); };
    while (found.size() < static_cast<std::size_t>(lanes()) && has_room()) {
      std::unique_ptr<Member> m;
      if (!earlier.empty()) {
        m = std::move(earlier.front());
        earlier.pop_front();
      } else if (m = next(); !m) {
        break;
      }
      const bool fits = found.empty() || m->like(found.front()->traced().object);
      (fits ? found : kept_).push_back(std::move(m));
    }
    std::ranges::move(earlier, std::back_inserter(kept_));
    return found;
  }

  /// Runs these and all further ones of their structure, until too many others are kept.
  void together(const LaneFunctions& functions, Members first) {
    const auto structure = first.front()->traced().object;
    Members begun;
    run_in_lanes(functions, [&]() -> std::optional<LaneRun> {
      std::erase_if(begun, [](const auto& m) { return !m->run; });
      std::unique_ptr<Member> m;
      if (!first.empty()) {
        m = std::move(first.front());
        first.pop_front();
      }
      while (!m && has_room() && (m = next()))
        if (!m->like(structure)) kept_.push_back(std::exchange(m, nullptr));
      if (!m) return {};
      return begin(*begun.emplace_back(std::move(m)));
    });
  }

  LaneRun begin(Member& m) {
    auto& s = m.simulation();
    clock_.begin(m.cpu);
    m.run = std::make_unique<Implementation::RunInProgress>(s, m.one.request);
    return {.formulation = s.form.get(),
            .until = m.run->until,
            .watch = &m.run->watch,
            .next_shown = m.one.next_shown,
            .follow = m.run->follow(m.one.followers),
            .constants = &m.traced().object.constants(),
            .ended = [this, &m](const Ending& ending, long in_lanes) { end(m, ending, in_lanes); }};
  }

  void end(Member& m, const Ending& ending, long in_lanes) {
    clock_.end(m.cpu);
    auto result = m.run->finish(ending);
    result.cpu_seconds = m.cpu;
    m.run.reset();
    if (m.one.ended) m.one.ended(std::move(result), in_lanes);
  }

  const std::function<std::optional<LaneJob>()>& next_;
  Members kept_;
  std::shared_ptr<const TracedLanes> like_;  // of an earlier run, whose structure the next one probably has
  std::shared_ptr<const TracedLanes> declined_;  // a structure without functions of lanes
  SharedClock clock_;
};

void Simulation::run_together(const std::function<std::optional<LaneJob>()>& next) { LaneJobs(next).run(); }

int Simulation::most_together() { return lanes_of_machine(); }

}  // namespace freeplay
