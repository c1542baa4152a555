#include "formulations/time_stepping/lanes.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "dynamics/system_functions.hpp"
#include "dynamics/system_tracer.hpp"
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

/// The lanes of one group.
class Lanes {
 public:
  using Next = std::function<std::optional<LaneRun>()>;
  using Single = std::function<const SingleLane*()>;

  Lanes(const LaneFunctions& functions, const Next& next)
      : functions_(&functions), next_(next), lanes_(static_cast<std::size_t>(functions.lanes)) {}
  /// A single lane, whose functions may come later.
  Lanes(const Next& next, const Single& single) : next_(next), single_(&single), lanes_(1) {}

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
        if (found_ || !(found_ = (*single_)()) || found_->functions.lanes != 1) continue;
        join(i, lane, found_->functions, found_->constants);
      }
      lane.left = lane.unseen();
      if (!(lane.left >= (single_ ? fewest_alone : fewest_ordinary) && group_->ready(i))) continue;
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
  const Single* single_ = nullptr;
  const SingleLane* found_ = nullptr;  // of single_
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
  Lanes(functions, next).run();
}

Ending run_in_single_lane(Formulation& formulation, double until, Watch& watch,
                          const std::function<double()>& next_shown,
                          const std::function<void(const Step&)>& follow,
                          const std::function<const SingleLane*()>& lane) {
  if (!dynamic_cast<Laned*>(&formulation)) return formulation.run(until, watch);
  Ending ending;
  std::optional<LaneRun> run = LaneRun{.formulation = &formulation,
                                       .until = until,
                                       .watch = &watch,
                                       .next_shown = next_shown,
                                       .follow = follow,
                                       .constants = nullptr,
                                       .ended = [&](const Ending& e, long) { ending = e; }};
  Lanes([&] { return std::exchange(run, {}); }, lane).run();
  return ending;
}

namespace {

constexpr int steps_compared = 20;

/// A stepper with its log.
struct OneStepper {
  OneStepper(const System& system, const State& from, double h, RowFacts facts)
      : log(system.contacts(), system.reported()),
        stepper(system, {}, h, std::vector<double>(static_cast<std::size_t>(system.reported()), 0.5), facts) {
    stepper.start(from, log);
  }
  /// Products with 0 vanish in compiled functions, so a motion that overflows is another one.
  bool overflows() const {
    return std::ranges::any_of(stepper.data().v, [](double v) { return !(std::abs(v) <= 1e50); });
  }
  /// Appends its quantities in one order; without multipliers, which steps in lanes do not keep.
  void put(std::vector<double>& all) const {
    const auto& d = stepper.data();
    for (const auto* list : {&d.q, &d.v}) all.insert(all.end(), list->begin(), list->end());
    for (const auto& c : stepper.contacts().all()) all.insert(all.end(), {c.gap, c.last_n, c.last_t});
    const auto& works = stepper.integrals();
    all.insert(all.end(), {works.drive, works.load, works.contact, works.friction, works.stabilisation,
                           stepper.extremes().constraint_length, stepper.extremes().constraint_angle});
  }
  ContactLog log;
  MoreauStepper stepper;
};

/// The quantities of some steps of h (s), in one order.
std::vector<double> stepped(const System& system, const State& from, double h, RowFacts facts) {
  OneStepper one(system, from, h, facts);
  std::vector<double> all;
  for (int i = 0; i < steps_compared && one.stepper.step(INFINITY) && !one.overflows(); ++i) {
    one.put(all);
    const auto& lambda = one.stepper.data().lambda;
    all.insert(all.end(), lambda.begin(), lambda.end());
  }
  return all;
}

}  // namespace

long differing_steps(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                     int states) {
  const auto still = still_coordinates(system, near);
  long differing = 0;
  for (unsigned seed = 0; seed < std::min(4u, static_cast<unsigned>(states)); ++seed) {
    const auto at = seed == 0 ? near : moved(system, near, still, seed);
    const double h = seed < 3 ? 1e-5 : 1e-3;
    system.compiled().attach({});
    const auto expected = stepped(system, at, h, facts);
    system.compiled().attach(functions);
    const auto found = stepped(system, at, h, facts);
    differing += differing_numbers(found, expected);
  }
  system.compiled().attach({});
  return differing;
}

long differing_lanes(const LaneFunctions& functions, const std::vector<LaneCheck>& lanes, RowFacts facts,
                     int states) {
  long differing = 0;
  for (unsigned seed = 0; seed < std::min(4u, static_cast<unsigned>(states)); ++seed) {
    const double h = seed < 3 ? 1e-5 : 1e-3;
    std::vector<std::unique_ptr<OneStepper>> alone, together;
    std::vector<double> passed(lanes.size());
    for (std::size_t i = 0; i < lanes.size(); ++i) {
      const auto& lane = lanes[i];
      const auto still = still_coordinates(*lane.system, *lane.near);
      const auto at = seed == 0 ? *lane.near : moved(*lane.system, *lane.near, still, seed);
      alone.push_back(std::make_unique<OneStepper>(*lane.system, at, h, facts));
      together.push_back(std::make_unique<OneStepper>(*lane.system, at, h, facts));
    }
    LaneGroup group(functions, together.front()->stepper);
    for (std::size_t i = 0; i < lanes.size(); ++i)
      group.enter(static_cast<int>(i), {&together[i]->stepper, lanes[i].constants, &passed[i]});
    unsigned inside = 0;
    for (int step = 0; step < steps_compared; ++step) {
      const unsigned leaving = inside == 0 ? 0 : group.advance(inside, 1);
      std::vector<double> found, expected;
      for (std::size_t i = 0; i < lanes.size(); ++i) {
        const int lane = static_cast<int>(i);
        const bool made = (inside >> i & 1) != 0 && (leaving >> i & 1) == 0;
        if ((inside >> i & 1) != 0) group.store(lane);
        inside &= ~(1u << i);
        if (!alone[i]->stepper.step(INFINITY)) return differing;
        if (!made && !together[i]->stepper.step(INFINITY)) return differing + 1;
        if (alone[i]->overflows()) continue;
        alone[i]->put(expected);
        together[i]->put(found);
        if (!group.ready(lane)) continue;
        group.load(lane);
        inside |= 1u << i;
      }
      differing += differing_numbers(found, expected);
    }
  }
  return differing;
}

}  // namespace freeplay
