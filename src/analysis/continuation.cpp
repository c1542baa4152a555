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

/// A branch that is still to be followed.
struct Begun {
  BranchSolver solver;
  BranchMotion motion;
  std::string begins;
  int number = 1, doublings = 0;
  int points = 0;  ///< of an earlier result
};

class Continuation {
 public:
  Continuation(const Scene& scene, const ContinuationRequest& request) : scene_(scene), request_(request) {}

  Branches run() {
    BranchSetup setup{.key = request_.key,
                      .from = request_.from,
                      .to = request_.to,
                      .period = request_.period,
                      .autonomous = false,
                      .family = family_of(request_.formulation),
                      .stop = request_.stop};
    const double begin = request_.start.value_or(request_.from);
    const auto first = property(scene_, setup.key, setup.family).at(begin);
    const System system(first.mechanism);
    setup.autonomous = !excitation_of(first.mechanism, system).any;
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
    if (!motion) {
      result_.failure = fmt::format("{} = {:.9g}: {}", setup.key, begin, reason);
      return std::move(result_);
    }
    branches_.push_back({solver, *motion, "start", ++count_, 0});
    if (request_.start && *request_.start != request_.from && *request_.start != request_.to) {
      motion->tangent = -motion->tangent;
      branches_.push_back({std::move(solver), std::move(*motion), "start", ++count_, 0});
    }
    return follow_all();
  }

 private:
  Branches restart(const BranchSetup& setup) {
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
    return follow_all();
  }

  Branches follow_all() {
    while (!branches_.empty()) {
      auto next = std::move(branches_.front());
      branches_.pop_front();
      follow(next);
    }
    for (auto& start : curve_starts_) follow_curve(std::move(start));
    return std::move(result_);
  }

  /// Arclength along which the key changes by the greatest step.
  double greatest_step(const BranchMotion& m) const {
    const double share =
        request_.step ? *request_.step / std::abs(request_.to - request_.from) : BranchStep::greatest;
    return share / std::max(std::abs(m.tangent_key()), least_share_of_key);
  }
  BranchPoint point_of(const Begun& b, const BranchMotion& m, int number) const {
    return {b.number, number, m.parameter, branch_orbit(b.solver.periods(), m)};
  }
  void add(BranchPoint p) {
    if (request_.on_point) request_.on_point(p);
    result_.points.push_back(std::move(p));
  }
  void add(Bifurcation b) {
    if (request_.on_bifurcation) request_.on_bifurcation(b);
    result_.bifurcations.push_back(std::move(b));
  }

  void follow(Begun& b) {
    BranchMotion base = b.motion;
    std::vector<BranchMotion> last{base};  // with the same sequence
    int count = b.points;
    double step = 0.5 * greatest_step(base);
    int changes = 0;  // of the order of onsets
    std::string ends;
    if (count == 0) add(point_of(b, base, count++));
    std::vector<BranchTest> tests;
    for (const auto& event : request_.events)
      tests.push_back({BifurcationKind::event, event.name,
                       [&](const BranchMotion& m) { return event.value(point_of(b, m, count)); }});
    while (ends.empty()) {
      if (count >= request_.most_points) {
        ends = fmt::format("{} motions", count);
        break;
      }
      std::string reason;
      auto next = b.solver.along(base, step, reason);
      if (next) reason = unsuitable(base, *next);
      if (!reason.empty()) {
        step *= BranchStep::reduction;
        const auto least = least_positive(base);
        const bool slowing =
            least.kind == BifurcationKind::grazing && least.share < slow_share && falling(last, least);
        if (step > (slowing ? slow_step : least_step) * greatest_step(base)) continue;
        if (slowing)
          ends = vanish(b, last, least, count);
        else if (const auto grazed = new_contact_ahead(b.solver, base, step))
          ends = begin_contact(b, base, *grazed, step, count);
        else if (next && base.sequence() != next->sequence() && changes++ < most_changes) {
          ends = pass_order(b, base, *next, count);
          if (!ends.empty()) break;
          add(point_of(b, *next, count++));
          base = std::move(*next);
          last = {base};
          step = slow_step * greatest_step(base);
          continue;
        } else
          ends = fmt::format("no further motion is found at {} = {:.9g}: {}", request_.key, base.parameter,
                             reason);
        break;
      }
      const auto bound = bound_between(base, *next);
      auto events = events_between(b.solver, base, step, *next, tests);
      double reach = step;
      if (bound) {
        if (auto edge =
                next->parameter == *bound ? std::nullopt : reach_key(b.solver, base, step, *next, *bound)) {
          reach = edge->distance;
          next = std::move(edge->motion);
        }
        ends = branch_range_ends;
      }
      for (auto& e : events)
        if (e.distance <= reach) report(b, e, count);
      add(point_of(b, *next, count++));
      step = std::min(BranchStep::after(step, next->iterations), greatest_step(*next));
      base = std::move(*next);
      if (last.size() >= most_kept) last.erase(last.begin());
      last.push_back(base);
      if (!ends.empty()) break;
      if (const auto least = least_positive(base); least.share < vanishing_share && falling(last, least)) {
        ends = vanish(b, last, least, count);
        break;
      }
      if (BranchSolver::margin(base) < least_margin && b.solver.recentre(base).empty()) last = {base};
    }
    result_.ends.push_back({b.number, count, b.begins, ends});
  }

  /// Why a motion cannot follow another one; empty if it can.
  std::string unsuitable(const BranchMotion& base, const BranchMotion& next) const {
    if (base.sequence() != next.sequence()) return "the order of contact onsets changes";
    const auto was = positive_quantities(base), now = positive_quantities(next);
    if (was.size() != now.size()) return "a lasting contact separates, or a contact begins to last";
    for (std::size_t i = 0; i < was.size(); ++i)
      if (now[i].value < BranchStep::remaining_share * was[i].value)
        return fmt::format("the {} of {} comes to 0",
                           was[i].kind == BifurcationKind::grazing ? "approach speed" : "least force",
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

  void report(const Begun& b, BranchEvent& e, int count) {
    Bifurcation found{.kind = e.kind, .at = point_of(b, e.motion, count), .joint = {}, .follows = {}};
    found.residual = e.residual;
    if (e.kind == BifurcationKind::fold) found.follows = "the branch turns back";
    if (e.kind == BifurcationKind::torus) found.follows = "a quasi-periodic motion";
    if (e.kind == BifurcationKind::event) found.follows = e.name;
    if (e.kind == BifurcationKind::crossing) cross(b, e.motion, found);
    keep_curve({e.kind, b.solver, e.motion, {}, e.motion.parameter});
    if (e.kind == BifurcationKind::flip) {
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
    add(std::move(found));
  }

  /// Begins both sides of the branch that crosses the present one.
  void cross(const Begun& b, const BranchMotion& at, Bifurcation& found) {
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
  std::string vanish(Begun& b, const std::vector<BranchMotion>& motions, const Positive& quantity,
                     int count) {
    const auto g = extrapolated(motions, quantity);
    const auto& m = motions.back();
    Bifurcation found{.kind = quantity.kind, .at = point_of(b, m, count), .joint = {}, .follows = {}};
    found.at.parameter = g.parameter;
    found.at.orbit.period = g.period / b.solver.periods();
    found.at.orbit.state = g.state;
    found.joint = contact_name(m, quantity);
    found.residual = g.error;
    const auto& before = motions[motions.size() - 2];
    keep_curve({quantity.kind, b.solver, m, quantity, g.parameter, slope_of(b.solver, m, before, quantity)});
    if (quantity.kind == BifurcationKind::grazing) return graze(b, m, g, quantity.index, std::move(found));
    found.at.orbit.lasting[quantity.index].least_force = 0;
    found.follows = "the contact separates for a part of the motion";
    add(found);
    return fmt::format("{} lifts off", found.joint);
  }

  /// Reports a grazing impact and the motions without it. Returns the end of the branch in words.
  std::string graze(Begun& b, const BranchMotion& m, const Vanished& g, std::size_t onset,
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
    add(found);
    return fmt::format("the impact of {} grazes", found.joint);
  }

  /// Reports that contact onsets change their order between two motions next to each other. The branch
  /// continues with the other order; returns a reason if the motions are not near each other.
  std::string pass_order(const Begun& b, const BranchMotion& before, const BranchMotion& after, int count) {
    Bifurcation found{
        .kind = BifurcationKind::sequence, .at = point_of(b, before, count), .joint = {}, .follows = {}};
    const auto old = before.sequence(), now = after.sequence();
    if (old.size() != now.size())
      return fmt::format("the number of contact onsets changes at {} = {:.9g}", request_.key,
                         before.parameter);
    const auto place = std::ranges::mismatch(old, now).in1 - old.begin();
    found.joint = found.at.orbit.impacts[static_cast<std::size_t>(place)].joint;
    found.residual = std::abs(after.parameter - before.parameter);
    found.follows = fmt::format("{} comes first",
                                after.model->system.contact_facts(now[static_cast<std::size_t>(place)]).name);
    add(std::move(found));
    return {};
  }

  /// Reports the contact that a branch begins to touch, and the motions with this impact. Returns the end of
  /// the branch in words.
  std::string begin_contact(Begun& b, const BranchMotion& m, const NewContact& grazed, double step,
                            int count) {
    Bifurcation found{
        .kind = BifurcationKind::grazing, .at = point_of(b, m, count), .joint = {}, .follows = {}};
    found.joint = m.model->system.contact_facts(grazed.contact).name;
    found.residual = step * b.solver.setup().range() * std::abs(m.tangent_key());
    std::string reason;
    if (auto motion = first_with_impact(b.solver, m, grazed, reason)) {
      const auto quantity = positive_quantities(*motion)[grazed.onset];
      keep_curve({BifurcationKind::grazing, b.solver, *motion, quantity, m.parameter,
                  -quantity.share / b.solver.distance(*motion, m)});
      const bool onwards = (motion->parameter - m.parameter) * m.tangent_key() > 0;
      found.follows = onwards ? "continues with this impact" : "turns back with this impact";
      begin_beside(b, std::move(*motion), found);
    } else {
      found.follows = "no motion with this impact is found nearby";
    }
    add(found);
    return fmt::format("it begins to touch {}", found.joint);
  }

  /// Begins a branch at a grazing impact.
  void begin_beside(const Begun& b, BranchMotion motion, Bifurcation& found) {
    if (count_ >= most_branches) return;
    found.new_branch = ++count_;
    branches_.push_back({b.solver, std::move(motion), fmt::format("grazing at {:.9g}", found.at.parameter),
                         found.new_branch, b.doublings});
  }

  void keep_curve(CurveStart start) {
    if (!request_.second) return;
    if (start.kind >= BifurcationKind::sequence) return;
    const auto& kinds = request_.second->kinds;
    if (kinds.empty() || std::ranges::find(kinds, start.kind) != kinds.end())
      curve_starts_.push_back(std::move(start));
  }

  /// Follows the curve of a bifurcation over both keys, unless an earlier curve passes through it.
  void follow_curve(CurveStart start) {
    BifurcationCurve curve(scene_, *request_.second, std::move(start),
                           static_cast<int>(result_.curves.size()) + 1);
    if (curve.begins_on(result_.curve_points)) return;
    auto [points, ends] = curve.follow(request_.on_curve_point);
    for (auto& point : points) result_.curve_points.push_back(std::move(point));
    result_.curves.push_back(std::move(ends));
  }

  const Scene& scene_;
  const ContinuationRequest& request_;
  std::vector<CurveStart> curve_starts_;
  Branches result_;
  std::deque<Begun> branches_;
  int count_ = 0;
};

/// Requires a range and a step of a key, whose settings have names with this beginning.
void require_steps(const std::string& settings, double from, double to, const std::optional<double>& step) {
  if (!(std::isfinite(from) && std::isfinite(to)) || from == to)
    throw ModelError(settings + "to", fmt::format("must differ from {}from", settings));
  if (step && !(*step > 0)) throw ModelError(settings + "step", "must be greater than 0");
}

}  // namespace

Branches continue_orbit(const Scene& scene, const ContinuationRequest& request) {
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
  return Continuation(scene, request).run();
}

}  // namespace freeplay
