#include "formulations/time_stepping/lanes.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"
#include "formulations/marched.hpp"
#include "formulations/time_stepping/lane_group.hpp"
#include "formulations/time_stepping/moreau.hpp"
#include "simulation/march.hpp"

namespace freeplay {
namespace {

using Laned = Marched<MoreauStepper>;

/// Ordinary steps that are worth the way into one of several lanes and out of it, and into a single one.
constexpr double fewest_ordinary = 8, fewest_alone = 4;
/// After as many steps, stop requests are looked for.
constexpr double most_at_once = 1000;
/// The same where the steps are recorded; their records stay in the cache.
constexpr long most_recorded = 128;

/// A step that was made in a lane, as LaneRun::follow gets it.
class LaneStep final : public Step {
 public:
  explicit LaneStep(const System& system) : system_(system), e_(system.make_evaluation()) {
    for (auto* list : {&q0_, &q1_, &v0_, &v1_}) list->resize(static_cast<std::size_t>(system.n()));
  }
  /// The first state of a sequence of steps.
  void begin(const LaneGroup& group, int lane) { t1 = group.recorded(0, lane, q1_, v1_); }
  /// Goes to step `number` of the sequence, from 1.
  void advance(const LaneGroup& group, int lane, long number) {
    std::swap(q0_, q1_);
    std::swap(v0_, v1_);
    t0 = t1;
    t1 = group.recorded(number, lane, q1_, v1_);
    v0 = v0_;
    v1 = v1_;
  }
  void state(double t, std::span<double> q, std::span<double> v) const override {
    interpolate_step(t0, t1, t, {q0_.data(), q1_.data(), v0_.data(), v1_.data()}, system_.n(), q.data(),
                     v.data());
  }
  void contacts(double t, std::span<const double> q, std::span<ContactPlace> out) const override {
    contact_places(system_, e_, t, q, out);
  }
  std::span<const double> z() const override { return {}; }
  bool stopped() const override { return false; }
  bool cut() const override { return false; }
  std::span<const double> multipliers() const override { refuse(); }
  EnergyLedger ledger() const override { refuse(); }
  void forces(double, Forces&) const override { refuse(); }
  void add_impulse(double, double, Forces&) const override { refuse(); }
  const Forces& before() const override { refuse(); }
  const Forces& within() const override { refuse(); }

 private:
  [[noreturn]] static void refuse() {
    throw std::logic_error("a step in a lane has no energies, multipliers and forces");
  }

  const System& system_;
  mutable Evaluation e_;
  std::vector<double> q0_, q1_, v0_, v1_;
};

struct Lane {
  std::optional<LaneRun> run;
  Laned* formulation = nullptr;
  std::unique_ptr<Laned::Steps> steps;
  std::unique_ptr<LaneStep> followed;  // null: nobody follows
  bool inside = false;
  double left = 0;    // steps until it must leave
  long in_lanes = 0;  // steps made

  /// Number of steps that nobody sees: to the step that ends last before the time of the next shown one.
  /// The last steps of a run are its own, since they may be shorter.
  double unseen() const {
    const auto& s = formulation->stepper();
    const double end = std::min(run->next_shown(), run->until);
    return std::min(std::floor((end - s.t()) / s.fixed_length() - 1.01), most_at_once);
  }
  /// After the group has made steps of this lane.
  void take(const LaneGroup& group, int lane, long done) {
    left -= static_cast<double>(done);
    in_lanes += done;
    if (!followed) return;
    followed->begin(group, lane);
    for (long i = 1; i <= done; ++i) {
      followed->advance(group, lane, i);
      run->follow(*followed);
    }
  }
};

/// LaneScheduler: the lanes of one group. Each is empty, or has a run that steps alone, or one that steps
/// in the group. A run is loaded where its next steps may be ordinary and nobody sees them, and stored
/// where one is not ordinary or is to be seen; its place goes to the next run at its end.
class LaneScheduler {
 public:
  using Next = std::function<std::optional<LaneRun>()>;

  LaneScheduler(const LaneFunctions& functions, const Next& next)
      : functions_(&functions), next_(next), lanes_(static_cast<std::size_t>(functions.lanes)) {}
  /// A single lane, whose functions may come later.
  explicit LaneScheduler(const Next& next) : next_(next), lanes_(1) {}

  void run() {
    for (;;) {
      unsigned inside = 0;
      double most = most_at_once;
      bool followed = false;
      for (int i = 0; i < static_cast<int>(lanes_.size()); ++i) {
        auto& lane = lanes_[static_cast<std::size_t>(i)];
        while (!lane.inside && (lane.run || enter(i, lane))) walk(i, lane);
        if (!lane.inside) continue;
        inside |= 1u << i;
        most = std::min(most, lane.left);
        followed |= lane.followed != nullptr;
      }
      if (inside == 0) return;
      group_->record(followed ? most_recorded : 0);
      const long bound = followed ? most_recorded : static_cast<long>(most_at_once);
      const unsigned leaving = group_->advance(inside, std::min(static_cast<long>(most), bound));
      for (int i = 0; i < static_cast<int>(lanes_.size()); ++i) {
        auto& lane = lanes_[static_cast<std::size_t>(i)];
        if (!lane.inside) continue;
        const bool leaves = (leaving >> i & 1) != 0;
        lane.take(*group_, i, group_->done() + (leaving != 0 && !leaves ? 1 : 0));
        if (!leaves && lane.left >= 1) continue;
        group_->store(i);
        lane.inside = false;
      }
    }
  }

 private:
  bool enter(int i, Lane& lane) {
    if (none_) return false;
    lane.run = next_();
    none_ = !lane.run;
    if (none_) return false;
    lane.formulation = dynamic_cast<Laned*>(lane.run->formulation);
    lane.in_lanes = 0;
    lane.steps = std::make_unique<Laned::Steps>(lane.formulation->march(lane.run->until, *lane.run->watch));
    lane.followed = lane.run->follow ? std::make_unique<LaneStep>(lane.formulation->system()) : nullptr;
    if (functions_) join(i, lane, *functions_, *lane.run->constants);
    return true;
  }
  void join(int i, Lane& lane, const LaneFunctions& functions, const std::vector<double>& constants) {
    if (!group_) group_ = std::make_unique<LaneGroup>(functions, lane.formulation->stepper());
    group_->enter(i, {&lane.formulation->stepper(), &constants, &lane.formulation->passed()});
  }
  /// Steps of a run alone until it may be loaded, or its end.
  void walk(int i, Lane& lane) {
    while (lane.steps->step()) {
      if (!group_) {
        const auto& system = lane.formulation->system();
        const auto& compiled = system.compiled().functions();
        if (looked_ || !compiled.object) continue;
        looked_ = true;
        single_ = single_lane(system);
        if (single_.lanes != 1) continue;
        join(i, lane, single_, compiled.constants);
      }
      lane.left = lane.unseen();
      if (!(lane.left >= (functions_ ? fewest_ordinary : fewest_alone) && group_->ready(i))) continue;
      group_->load(i);
      lane.inside = true;
      return;
    }
    const auto run = std::move(*lane.run);
    lane.run.reset();
    none_ = false;
    run.ended(lane.formulation->finish(*lane.steps, *run.watch), lane.in_lanes);
  }

  const LaneFunctions* functions_ = nullptr;
  const Next& next_;
  LaneFunctions single_;  // without `functions_`, once the System has them
  bool looked_ = false;   // for `single_`
  std::vector<Lane> lanes_;
  std::unique_ptr<LaneGroup> group_;  // of the first run
  bool none_ = false;                 // whether `next` had none since the last end of a run
};

}  // namespace

bool fits_lanes(Formulation& formulation) {
  auto* f = dynamic_cast<Laned*>(&formulation);
  return f && LaneGroup::fits(f->stepper());
}

void run_in_lanes(const LaneFunctions& functions, const std::function<std::optional<LaneRun>()>& next) {
  LaneScheduler(functions, next).run();
}

Ending run_in_single_lane(Formulation& formulation, double until, Watch& watch,
                          const std::function<double()>& next_shown,
                          const std::function<void(const Step&)>& follow) {
  if (!fits_lanes(formulation)) return formulation.run(until, watch);
  Ending ending;
  std::optional<LaneRun> run = LaneRun{.formulation = &formulation,
                                       .until = until,
                                       .watch = &watch,
                                       .next_shown = next_shown,
                                       .follow = follow,
                                       .constants = nullptr,
                                       .ended = [&](const Ending& e, long) { ending = e; }};
  const LaneScheduler::Next next = [&] { return std::exchange(run, {}); };
  LaneScheduler(next).run();
  return ending;
}

}  // namespace freeplay
