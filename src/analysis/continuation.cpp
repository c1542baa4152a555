#include "analysis/continuation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <optional>
#include <utility>
#include <vector>

#include "analysis/branch_curves.hpp"
#include "analysis/branch_events.hpp"
#include "analysis/branch_solver.hpp"
#include "analysis/orbit.hpp"
#include "analysis/periodicity.hpp"
#include "analysis/varied_key.hpp"
#include "facade/identify.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

/// Shortest step, relative to the greatest one; below it the branch ends.
constexpr double least_step = 1e-8;
/// Share of the greatest approach speed or force below which a vanishing one is extrapolated to 0.
constexpr double vanishing_share = 1e-3;
/// Derivatives end at slow impacts whose penetration without the impact would be negligible. A branch that
/// ends at a speed below this share is extrapolated as well, once its steps are this short.
constexpr double slow_share = 0.05, slow_step = 0.02;
constexpr std::size_t most_kept = 32;
/// Most changes of the order of onsets on a branch.
constexpr int most_changes = 20;
/// The section is moved if a contact onset comes nearer than this share of the period.
constexpr double least_margin = 0.02;
/// Greatest distance of the first motion of a crossing branch along the present branch, over the amplitude.
constexpr double crossing_slope = 10;
constexpr int most_branches = 12;
/// Where the tangent has a smaller part along the key, steps are bounded by the state.
constexpr double least_share_of_key = 0.2;

/// Requires a range and a step of a key, whose settings have names with this beginning.
void require_steps(const std::string& settings, double from, double to, const std::optional<double>& step) {
  if (!(std::isfinite(from) && std::isfinite(to)) || from == to)
    throw ModelError(settings + "to", fmt::format("must differ from {}from", settings));
  if (step && !(*step > 0)) throw ModelError(settings + "step", "must be greater than 0");
}

/// Throws ModelError if a request cannot be met.
void require_possible(const Scene& scene, const ContinuationRequest& request) {
  const auto family = family_of(request.formulation);
  static_cast<void>(property(scene, request.key, family));
  require_steps("continue.", request.from, request.to, request.step);
  if (request.start && !(*request.start >= std::min(request.from, request.to) &&
                         *request.start <= std::max(request.from, request.to)))
    throw ModelError("continue.start", "must be within continue.from and continue.to");
  if (family == Family::penalty && (request.second || !request.restarts.empty()))
    throw ModelError(request.second ? "continue.second" : "continue.formulation",
                     "curves over two keys and branches of an earlier result need the nonsmooth formulation");
  if (family == Family::nonsmooth && scene.nonsmooth.scheme_in_force() == Scheme::moreau_jean)
    throw ModelError(
        "nonsmooth.scheme",
        "branches of orbits of time stepping are not available, because its return map has jumps; set "
        "it to \"event-driven\" or \"automatic\"");
  if (const auto& second = request.second) {
    const double at = property(scene, second->key, Family::nonsmooth).value();
    if (second->key == request.key) throw ModelError("continue.second", "must differ from continue.key");
    if (!(at >= std::min(second->from, second->to) && at <= std::max(second->from, second->to)))
      throw ModelError("continue.second",
                       fmt::format("{} = {:.9g} in the scene; it must be from continue.second_from to "
                                   "continue.second_to",
                                   second->key, at));
    require_steps("continue.second_", second->from, second->to, second->step);
  }
}

}  // namespace

class Continuation::Implementation {
 public:
  Implementation(const Scene& scene, const ContinuationRequest& request) : scene_(scene), request_(request) {}

  bool advance() {
    if (!std::exchange(begun_, true)) {
      find_first();
    } else if (!branches_.empty()) {
      auto& b = branches_.front();
      if (const auto ends = step(b); !ends.empty()) {
        result_.ends.push_back({b.number, b.count, b.begins, ends});
        branches_.pop_front();
      }
    } else {
      return advance_curve();
    }
    return true;
  }
  const Branches& result() const { return result_; }

 private:
  using enum BifurcationKind;
  /// A branch in progress, or still to be followed.
  struct Branch {
    BranchSolver solver;
    BranchMotion base;  ///< the last motion
    std::string begins;
    int number = 1, doublings = 0;
    int count = 0;                        ///< of motions, also of an earlier result
    std::vector<BranchMotion> last = {};  ///< with the same sequence; none before it is followed
    double step = 0;                      ///< arclength
    int changes = 0;                      ///< of the order of onsets
  };

  /// Finds the first motion, or those from which branches of an earlier result go on.
  void find_first() {
    require_possible(scene_, request_);
    BranchSetup setup{.key = request_.key,
                      .from = request_.from,
                      .to = request_.to,
                      .period = request_.period,
                      .autonomous = false,
                      .family = family_of(request_.formulation),
                      .stop = request_.stop};
    const double begin = request_.start.value_or(request_.from);
    const auto first = property(scene_, setup.key, setup.family).at(begin);
    setup.autonomous = !excitation_of(first.mechanism, System(first.mechanism)).any;
    count_ = request_.branches;
    if (!request_.restarts.empty()) return restart(setup);
    SectionState section;
    const auto found = orbit(first,
                             {.formulation = request_.formulation,
                              .periods = request_.periods,
                              .settle = request_.settle,
                              .period = request_.period,
                              .stop = request_.stop},
                             section);
    BranchSolver solver(scene_, setup, request_.periods);
    std::string reason = found.failure;
    std::optional<BranchMotion> motion;
    if (reason.empty())
      motion = solver.begin(section, begin, found.period * found.periods, setup.to > setup.from, reason);
    if (motion)
      branches_.push_back({solver, *motion, "start", ++count_, 0});
    else
      result_.failure = fmt::format("{} = {:.9g}: {}", setup.key, begin, reason);
    if (motion && request_.start && *request_.start != request_.from && *request_.start != request_.to) {
      motion->tangent = -motion->tangent;
      branches_.push_back({std::move(solver), std::move(*motion), "start", ++count_, 0});
    }
  }

  void restart(const BranchSetup& setup) {
    const auto [low, high] = std::minmax(request_.from, request_.to);
    for (const auto& r : request_.restarts) {
      const auto& o = r.last.orbit;
      if (r.rising ? r.last.parameter >= high : r.last.parameter <= low) continue;
      BranchSolver solver(scene_, setup, o.periods);
      std::string reason;
      auto motion = solver.begin(o.state, r.last.parameter, o.period * o.periods, r.rising, reason);
      if (motion)
        branches_.push_back({std::move(solver), std::move(*motion), r.begins, r.last.branch,
                             static_cast<int>(std::log2(o.periods / request_.periods)), r.last.number + 1});
      else if (result_.failure.empty())
        result_.failure =
            fmt::format("branch {} at {} = {:.9g}: {}", r.last.branch, setup.key, r.last.parameter, reason);
    }
    if (!branches_.empty())
      result_.failure.clear();
    else if (result_.failure.empty())
      result_.failure = fmt::format("no branch goes on within {} = {:.9g} to {:.9g}; give a longer range",
                                    setup.key, low, high);
  }

  /// Arclength along which the key changes by the greatest step.
  double greatest_step(const BranchMotion& m) const {
    const double share =
        request_.step ? *request_.step / std::abs(request_.to - request_.from) : BranchStep::greatest;
    return share / std::max(std::abs(m.tangent_key()), least_share_of_key);
  }
  BranchPoint point_of(const Branch& b, const BranchMotion& m) const {
    return {b.number, b.count, m.parameter, branch_orbit(b.solver.periods(), m)};
  }
  void add(Branch& b) {
    result_.points.push_back(point_of(b, b.base));
    ++b.count;
  }

  /// Finds the next motion of a branch, or shortens the step. Returns why the branch ends, or nothing.
  std::string step(Branch& b) {
    if (b.last.empty()) {
      b.last = {b.base};
      b.step = 0.5 * greatest_step(b.base);
      if (b.count == 0) add(b);
      return {};
    }
    if (b.count >= request_.most_points) return fmt::format("{} motions", b.count);
    std::string reason;
    auto next = b.solver.along(b.base, b.step, reason);
    if (next) reason = unsuitable(b.base, *next);
    if (!reason.empty()) {
      b.step *= BranchStep::reduction;
      const auto least = least_positive(b.base);
      const bool slowing = least.kind == grazing && least.share < slow_share && falling(b.last, least);
      if (b.step > (slowing ? slow_step : least_step) * greatest_step(b.base)) return {};
      if (slowing) return vanish(b, least);
      if (const auto grazed = new_contact_ahead(b.solver, b.base, b.step)) return begin_contact(b, *grazed);
      if (next && b.base.sequence() != next->sequence() && b.changes++ < most_changes) {
        if (auto ends = pass_order(b, *next); !ends.empty()) return ends;
        b.base = std::move(*next);
        add(b);
        b.last = {b.base};
        b.step = slow_step * greatest_step(b.base);
        return {};
      }
      return fmt::format("no further motion is found at {} = {:.9g}: {}", request_.key, b.base.parameter,
                         reason);
    }
    const auto bound = bound_between(b.base, *next);
    std::vector<BranchTest> tests;
    for (const auto& one : request_.events)
      tests.push_back({event, one.name, [&](const BranchMotion& m) { return one.value(point_of(b, m)); }});
    auto events = events_between(b.solver, b.base, b.step, *next, tests);
    double reach = b.step;
    if (bound && next->parameter != *bound)
      if (auto edge = reach_key(b.solver, b.base, b.step, *next, *bound)) {
        reach = edge->distance;
        next = std::move(edge->motion);
      }
    for (auto& e : events)
      if (e.distance <= reach) report(b, e);
    b.base = std::move(*next);
    add(b);
    b.step = std::min(BranchStep::after(b.step, b.base.iterations), greatest_step(b.base));
    if (b.last.size() >= most_kept) b.last.erase(b.last.begin());
    b.last.push_back(b.base);
    if (bound) return branch_range_ends;
    if (const auto least = least_positive(b.base); least.share < vanishing_share && falling(b.last, least))
      return vanish(b, least);
    if (BranchSolver::margin(b.base) < least_margin && b.solver.recentre(b.base).empty()) b.last = {b.base};
    return {};
  }

  /// Why a motion cannot follow another one; empty if it can.
  std::string unsuitable(const BranchMotion& base, const BranchMotion& next) const {
    if (base.sequence() != next.sequence()) return "the order of contact onsets changes";
    const auto was = positive_quantities(base), now = positive_quantities(next);
    if (was.size() != now.size()) return "a lasting contact separates, or a contact begins to last";
    for (std::size_t i = 0; i < was.size(); ++i)
      if (now[i].value < BranchStep::remaining_share * was[i].value)
        return fmt::format("the {} of {} comes to 0",
                           was[i].kind == grazing ? "approach speed" : "least force",
                           contact_name(base, was[i]));
    const auto f = base.model->map.size();
    // Both tangents in the coordinates of the first: local coordinates belong to each state.
    const auto ahead = next.model->map.displacement(next.tangent.head(f));
    const double cosine =
        base.tangent.head(f).dot(base.model->map.local(ahead)) + base.tangent_key() * next.tangent_key();
    if (cosine < BranchStep::least_cosine) return "the tangent of the branch turns too fast";
    return {};
  }

  /// The end of the range that the next motion reaches or passes. A branch may begin at an end.
  std::optional<double> bound_between(const BranchMotion& base, const BranchMotion& next) const {
    for (const double bound : {request_.from, request_.to})
      if (base.parameter != bound && (base.parameter - bound) * (next.parameter - bound) <= 0) return bound;
    return {};
  }

  void report(const Branch& b, BranchEvent& e) {
    Bifurcation found{.kind = e.kind, .at = point_of(b, e.motion), .joint = {}, .follows = {}};
    found.residual = e.residual;
    if (e.kind == fold) found.follows = "the branch turns back";
    if (e.kind == torus) found.follows = "a quasi-periodic motion";
    if (e.kind == event) found.follows = e.name;
    if (e.kind == crossing) cross(b, e.motion, found);
    keep_curve({e.kind, b.solver, e.motion, {}, e.motion.parameter});
    if (e.kind == flip) {
      found.follows = "a motion of doubled period";
      if (b.doublings < request_.follow_doubled && count_ < most_branches) {
        BranchSolver solver(scene_, b.solver.setup(), 2 * b.solver.periods());
        solver.set_scale(b.solver.scale());
        solver.set_steps(b.solver.steps());
        if (auto doubled = doubled_motion(solver, e.motion)) {
          found.new_branch = ++count_;
          branches_.push_back({std::move(solver), std::move(*doubled),
                               fmt::format("flip at {:.9g}", e.motion.parameter), count_, b.doublings + 1});
        }
      }
    }
    result_.bifurcations.push_back(std::move(found));
  }

  /// Begins both sides of the branch that crosses the present one.
  void cross(const Branch& b, const BranchMotion& at, Bifurcation& found) {
    found.follows = "branches cross; no motion of the other one is found nearby";
    BranchMotion base = at;
    base.tangent = crossing_direction(b.solver, at);
    for (const double side : {1.0, -1.0})
      for (const double amplitude : first_amplitudes) {
        std::string reason;
        auto m = count_ < most_branches ? b.solver.along(base, side * amplitude, reason) : std::nullopt;
        if (!m || std::abs(b.solver.distance(at, *m)) > crossing_slope * amplitude) continue;
        m->tangent *= side;
        if (found.new_branch == 0) found.new_branch = count_ + 1;
        found.follows = "branches cross";
        branches_.push_back({b.solver, std::move(*m), fmt::format("crossing at {:.9g}", at.parameter),
                             ++count_, b.doublings});
        break;
      }
  }

  /// Reports a grazing impact or a lift-off. Returns the end of the branch in words.
  std::string vanish(Branch& b, const Positive& quantity) {
    const auto g = extrapolated(b.last, quantity);
    const auto& m = b.last.back();
    Bifurcation found{.kind = quantity.kind, .at = point_of(b, m), .joint = {}, .follows = {}};
    found.at.parameter = g.parameter;
    found.at.orbit.period = g.period / b.solver.periods();
    found.at.orbit.state = g.state;
    found.joint = contact_name(m, quantity);
    found.residual = g.error;
    const auto& before = b.last[b.last.size() - 2];
    keep_curve({quantity.kind, b.solver, m, quantity, g.parameter, slope_of(b.solver, m, before, quantity)});
    if (quantity.kind == grazing) return graze(b, m, g, quantity.index, std::move(found));
    found.at.orbit.lasting[quantity.index].least_force = 0;
    found.follows = "the contact separates for a part of the motion";
    result_.bifurcations.push_back(found);
    return fmt::format("{} lifts off", found.joint);
  }

  /// Reports a grazing impact and the motions without it. Returns the end of the branch in words.
  std::string graze(Branch& b, const BranchMotion& m, const Vanished& g, std::size_t onset,
                    Bifurcation found) {
    found.at.orbit.impacts[onset].speed = 0;
    auto without = m.sequence();
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(onset));
    // The side of the motions with the impact: the slope of the key at speed 0.
    const double with_impact = m.parameter > g.parameter ? 1 : -1;
    for (const double side : {-with_impact, with_impact}) {
      auto motion = motion_beside(b.solver, m, g, side, without);
      if (!motion) continue;
      if (motion->tangent_key() * side < 0) motion->tangent = -motion->tangent;
      found.follows =
          side == with_impact ? "turns back without this impact" : "continues without this impact";
      begin_beside(b, std::move(*motion), found);
      break;
    }
    if (found.follows.empty()) found.follows = "no motion without this impact is found nearby";
    result_.bifurcations.push_back(found);
    return fmt::format("the impact of {} grazes", found.joint);
  }

  /// Reports that contact onsets change their order between two motions next to each other. The branch
  /// continues with the other order; returns a reason if the motions are not near each other.
  std::string pass_order(const Branch& b, const BranchMotion& after) {
    Bifurcation found{.kind = sequence, .at = point_of(b, b.base), .joint = {}, .follows = {}};
    const auto old = b.base.sequence(), now = after.sequence();
    if (old.size() != now.size())
      return fmt::format("the number of contact onsets changes at {} = {:.9g}", request_.key,
                         b.base.parameter);
    const auto place = std::ranges::mismatch(old, now).in1 - old.begin();
    found.joint = found.at.orbit.impacts[static_cast<std::size_t>(place)].joint;
    found.residual = std::abs(after.parameter - b.base.parameter);
    found.follows = fmt::format("{} comes first",
                                after.model->system.contact_facts(now[static_cast<std::size_t>(place)]).name);
    result_.bifurcations.push_back(std::move(found));
    return {};
  }

  /// Reports the contact that a branch begins to touch, and the motions with this impact. Returns the end of
  /// the branch in words.
  std::string begin_contact(Branch& b, const NewContact& grazed) {
    const auto& m = b.base;
    Bifurcation found{.kind = grazing, .at = point_of(b, m), .joint = {}, .follows = {}};
    found.joint = m.model->system.contact_facts(grazed.contact).name;
    found.residual = b.step * b.solver.setup().range() * std::abs(m.tangent_key());
    found.follows = "no motion with this impact is found nearby";
    std::string reason;
    if (auto motion = first_with_impact(b.solver, m, grazed, reason)) {
      const auto quantity = positive_quantities(*motion)[grazed.onset];
      keep_curve({grazing, b.solver, *motion, quantity, m.parameter,
                  -quantity.share / b.solver.distance(*motion, m)});
      const bool onwards = (motion->parameter - m.parameter) * m.tangent_key() > 0;
      found.follows = onwards ? "continues with this impact" : "turns back with this impact";
      begin_beside(b, std::move(*motion), found);
    }
    result_.bifurcations.push_back(found);
    return fmt::format("it begins to touch {}", found.joint);
  }

  /// Begins a branch at a grazing impact.
  void begin_beside(const Branch& b, BranchMotion motion, Bifurcation& found) {
    if (count_ >= most_branches) return;
    found.new_branch = ++count_;
    branches_.push_back({b.solver, std::move(motion), fmt::format("grazing at {:.9g}", found.at.parameter),
                         found.new_branch, b.doublings});
  }

  void keep_curve(CurveStart start) {
    if (!request_.second || start.kind >= sequence) return;
    const auto& kinds = request_.second->kinds;
    if (kinds.empty() || std::ranges::find(kinds, start.kind) != kinds.end())
      curve_starts_.push_back(std::move(start));
  }

  /// Finds the next point of the curves of the bifurcations over both keys. A bifurcation begins a curve
  /// unless an earlier one passes through it. False: there are no more.
  bool advance_curve() {
    if (!curve_) {
      if (curve_starts_.empty()) return false;
      curve_.emplace(scene_, *request_.second, std::move(curve_starts_.front()),
                     static_cast<int>(result_.curves.size()) + 1);
      curve_starts_.pop_front();
      if (curve_->begins_on(result_.curve_points)) curve_.reset();
    } else if (curve_->advance()) {
      result_.curve_points.push_back(curve_->point());
    } else {
      // Along the curve: the first side backwards, then the other one.
      const auto& ends = result_.curves.emplace_back(curve_->ends());
      const auto first = result_.curve_points.end() - ends.points;
      std::reverse(first, first + curve_->points_of_first_side());
      curve_.reset();
    }
    return true;
  }

  const Scene& scene_;
  const ContinuationRequest request_;
  Branches result_;
  bool begun_ = false;
  std::deque<Branch> branches_;
  int count_ = 0;  // of branches
  std::deque<CurveStart> curve_starts_;
  std::optional<BifurcationCurve> curve_;  // in progress
};

Continuation::Continuation(const Scene& scene, const ContinuationRequest& request)
    : own_(std::make_unique<Implementation>(scene, request)) {}
Continuation::~Continuation() = default;
bool Continuation::advance() { return own_->advance(); }
const Branches& Continuation::found() const { return own_->result(); }

Branches continue_orbit(const Scene& scene, const ContinuationRequest& request) {
  Continuation branches(scene, request);
  while (branches.advance()) continue;
  return branches.found();
}

}  // namespace freeplay
