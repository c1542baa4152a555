#include "analysis/branch_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>

#include "analysis/varied_key.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

using Eigen::VectorXd;

/// Steps in the plane of both keys, each over its range: first and least one over the greatest.
constexpr double first_share = 0.1, least_share = 1e-3;
/// Points from which the next one is predicted.
constexpr std::size_t most_nodes = 3;
constexpr int most_points = 1000;  // to each side
/// A zero is located if the arclength changes by less than this; most motions for it.
constexpr double located = 1e-8;
constexpr int most_motions = 12;
/// First arclength at an unknown slope.
constexpr double first_arclength = 1e-4;
/// A positive quantity is extrapolated to zero from motions with decreasing shares of it, by a polynomial:
/// its error is of the order of their product. They begin at these shares of an approach speed and of a
/// force.
constexpr double top_speed = 5e-2, top_force = 3e-3, level_ratio = 1.4, extrapolation_error = 1e-8;
constexpr std::size_t most_levels = 6;
/// A motion is at a level if its share deviates by less than this, relative.
constexpr double near_level = 0.2;
constexpr int most_tries = 6;
/// Distance from the chords of a curve, over the ranges of both keys, within which a bifurcation is on it.
constexpr double same_curve = 2e-3;

}  // namespace

BifurcationCurve::BifurcationCurve(const Scene& scene, const SecondKey& second, CurveStart start, int number)
    : scene_(scene), second_(second), start_(std::move(start)) {
  ends_.curve = number;
  ends_.kind = start_.kind;
  ends_.parameter = start_.parameter;
  const auto& setup = start_.solver.setup();
  keys_ = {setup.key, second.key};
  low_ = {std::min(setup.from, setup.to), std::min(second.from, second.to)};
  high_ = {std::max(setup.from, setup.to), std::max(second.from, second.to)};
  range_ = {high_[0] - low_[0], high_[1] - low_[1]};
  low_[0] -= range_[0];
  high_[0] += range_[0];
}

BranchSolver BifurcationCurve::solver(int free, double fixed) const {
  const auto scene = property(scene_, keys_[1 - free], Family::nonsmooth).at(fixed);
  auto setup = start_.solver.setup();
  setup.key = keys_[free];
  setup.from = 0;
  setup.to = range_[free];
  BranchSolver s(scene, setup, start_.solver.periods());
  s.set_scale(start_.solver.scale());
  s.set_steps(start_.solver.steps());
  return s;
}

/// The value of the test function, or the share of the positive quantity.
double BifurcationCurve::test(const BranchSolver& solver, const BranchMotion& m) const {
  if (!is_positive()) return bifurcation_test(start_.kind, solver, m);
  for (const auto& p : positive_quantities(m))
    if (p.same(start_.quantity)) return p.share;
  return NAN;
}

std::optional<BranchMotion> BifurcationCurve::along(const BranchSolver& solver, const BranchMotion& m,
                                                    double distance, std::string& reason) const {
  auto next = solver.along(m, distance, reason);
  if (!next) return next;
  if (next->sequence() != start_.motion.sequence() ||
      next->point.end.lasting.size() != start_.motion.point.end.lasting.size()) {
    reason = "the sequence of contacts changes";
    return {};
  }
  return next;
}

/// Moves along the branch to the zero of the test function by the secant method.
bool BifurcationCurve::zero(const BranchSolver& solver, Located& p, std::string& reason) const {
  auto m = along(solver, p.motion, 0, reason);
  if (!m) return false;
  p.iterations = m->iterations;
  double f = test(solver, *m), step = p.slope != 0 ? -f / p.slope : first_arclength;
  for (int i = 0; i < most_motions; ++i) {
    auto next = along(solver, *m, step, reason);
    if (!next) return false;
    const double value = test(solver, *next), slope = (value - f) / step;
    m = std::move(next);
    f = value;
    if (slope == 0 || !std::isfinite(slope)) break;
    p.slope = slope;
    step = -f / slope;
    if (std::abs(step) < located) {
      p.residual = f;
      p.at[static_cast<std::size_t>(p.free)] = m->parameter / range_[static_cast<std::size_t>(p.free)];
      p.motion = std::move(*m);
      set_base(p, p.motion, solver.guess(p.motion, 0));
      if (start_.kind == BifurcationKind::torus && !has_complex_pair(solver, p.motion)) {
        reason = "the pair of multipliers becomes real";
        return false;
      }
      return true;
    }
  }
  reason = "no zero of the condition is found";
  return false;
}

/// The motion along the branch whose share of the positive quantity is near `level`.
std::optional<BranchMotion> BifurcationCurve::at_level(const BranchSolver& solver, BranchMotion m,
                                                       double level, double& slope,
                                                       std::string& reason) const {
  for (int tries = 0; tries < most_tries; ++tries) {
    const double f = test(solver, m), step = (std::max(level, BranchStep::remaining_share * f) - f) / slope;
    auto next = along(solver, m, step, reason);
    if (!next) return next;
    const double value = test(solver, *next), found = (value - f) / step;
    if (found * slope > 0) slope = found;
    if (std::abs(value - level) < near_level * level) return next;
    m = std::move(*next);
  }
  reason = "no motion with a small value of the quantity is found";
  return {};
}

/// Moves along the branch to small values of the positive quantity, and extrapolates to zero.
bool BifurcationCurve::vanishing(const BranchSolver& solver, Located& p, std::string& reason) const {
  const double top = start_.kind == BifurcationKind::grazing ? top_speed : top_force;
  // To a motion of this kind: from the prediction to greater values.
  auto m = along(solver, p.motion, 0, reason);
  for (const double share : {1.0, 3.0})
    if (!m) m = along(solver, p.motion, share * top / p.slope, reason);
  if (!m) return false;
  p.iterations = m->iterations;
  if (std::abs(test(solver, *m) - top) > near_level * top) m = at_level(solver, *m, top, p.slope, reason);
  if (!m) return false;
  // Downwards as far as there are motions, then upwards from the first one.
  std::deque<BranchMotion> motions{*m};
  double product = test(solver, *m), slope = p.slope;
  for (const double factor : {1 / level_ratio, level_ratio})
    while (product > extrapolation_error && motions.size() < most_levels) {
      const auto& last = factor < 1 ? motions.back() : motions.front();
      auto next = at_level(solver, last, factor * test(solver, last), slope, reason);
      if (!next) break;
      product *= test(solver, *next);
      if (factor < 1)
        motions.push_back(std::move(*next));
      else
        motions.push_front(std::move(*next));
    }
  if (product > extrapolation_error) {
    if (reason.empty()) reason = "no motion with a small value of the quantity is found";
    return false;
  }
  const auto end = extrapolated({motions.begin(), motions.end()}, start_.quantity);
  p.residual = end.error;
  p.at[static_cast<std::size_t>(p.free)] = end.parameter / range_[static_cast<std::size_t>(p.free)];
  p.motion = std::move(motions.back());
  // The predictions need motions of equal values.
  set_base(p, *m, solver.guess(*m, (top - test(solver, *m)) / p.slope));
  return true;
}

void BifurcationCurve::set_base(Located& p, BranchMotion m, BranchGuess level) const {
  p.base_at = p.at;
  const auto of = static_cast<std::size_t>(p.free);
  p.base_at[of] = level.parameter / range_[of];
  p.level = std::move(level);
  p.base = std::move(m);
}

/// The motion at which the search for the next bifurcation begins, by a polynomial through those of the last
/// points of a curve: its values at the value `x` of a key, over its range.
BifurcationCurve::Predicted BifurcationCurve::predicted(const std::vector<Located>& points, std::size_t key,
                                                        double x) const {
  std::vector<const Located*> nodes;
  for (auto p = points.rbegin(); p != points.rend() && nodes.size() < most_nodes; ++p) {
    if (nodes.size() > 1 &&
        !((nodes[0]->base_at[key] - nodes[1]->base_at[key]) * (nodes[1]->base_at[key] - p->base_at[key]) > 0))
      break;
    nodes.push_back(&*p);
  }
  Predicted all{.state = nodes.front()->level.state, .at = 0, .length = 0};
  auto& [state, at, length] = all;
  for (auto* list : {&state.q, &state.v, &state.z}) std::ranges::fill(*list, 0.0);
  for (const auto* node : nodes) {
    double weight = 1;
    for (const auto* other : nodes)
      if (other != node) weight *= (x - other->base_at[key]) / (node->base_at[key] - other->base_at[key]);
    const auto add = [weight](std::vector<double>& sum, const std::vector<double>& part) {
      for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * part[i];
    };
    add(state.q, node->level.state.q);
    add(state.v, node->level.state.v);
    add(state.z, node->level.state.z);
    at += weight * node->base_at[1 - key];
    length += weight * node->level.length;
  }
  return all;
}

/// The bifurcation near a point of the plane. The search begins at a motion that is predicted from those of
/// the last points, which have equal values of a positive quantity.
std::optional<BifurcationCurve::Located> BifurcationCurve::locate(const std::vector<Located>& points,
                                                                  int free, const Plane& near,
                                                                  std::string& reason) const {
  const auto& last = points.back();
  const auto* before = points.size() > 1 ? &points[points.size() - 2] : nullptr;
  const auto of = static_cast<std::size_t>(free), other = 1 - of;
  const auto s = solver(free, near[other] * range_[other]);
  Located p;
  p.at = near;
  p.free = free;
  p.slope = last.slope;
  auto& base = p.motion;
  const auto begin = predicted(points, other, near[other]);
  base.point.state = begin.state;
  base.parameter = begin.at * range_[of];
  base.model = s.model(base.parameter, &last.base.model->map, begin.length);
  auto& map = base.model->map;
  reason = map.shift(std::vector<double>(last.base.point.starts.front().size()), base.point.state);
  if (!reason.empty()) return {};
  map.chart(base.point.state);
  const auto f = map.size();
  auto& tangent = base.tangent = last.base.tangent;
  tangent.head(f) = map.local(last.base.model->map.displacement(last.base.tangent.head(f)));
  if (before && free != last.free) {
    // The tangent along the other key: less the part along the curve by which the fixed key changes.
    const double share = tangent[tangent.size() - 1] / (last.base_at[other] - before->base_at[other]);
    auto change = all_of(last.level.state);
    const auto earlier = all_of(before->level.state);
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= earlier[i];
    tangent.head(f) -= share / s.scale() * map.local(change);
    tangent[tangent.size() - 1] = -share * (last.base_at[of] - before->base_at[of]);
  }
  const double size = length_of(tangent, f);
  tangent /= size;
  p.slope /= size;
  if (!(is_positive() ? vanishing(s, p, reason) : zero(s, p, reason))) return {};
  return p;
}

bool BifurcationCurve::begin() {
  const double second = property(scene_, second_.key, Family::nonsmooth).value();
  Located from;
  from.at = {start_.parameter / range_[0], second / range_[1]};
  from.motion = start_.motion;
  from.slope = start_.slope;
  set_base(from, start_.motion, start_.solver.guess(start_.motion, 0));
  std::string reason;
  if (is_positive() && !vanishing(solver(0, second), from, reason)) {
    ends_.reasons[0] = ends_.reasons[1] = reason;
    return false;
  }
  points_ = {std::move(from)};
  return true;
}

bool BifurcationCurve::advance() {
  if (points_.empty()) {
    if (!begin()) return false;
  } else {
    while (!advance_on_side(ends_.reasons[side_])) {
      if (side_++ == 1) return false;
      points_.erase(points_.begin() + 1, points_.end());
    }
  }
  ++ends_.points;
  if (side_ == 0) first_side_ = ends_.points;
  return true;
}

bool BifurcationCurve::advance_on_side(std::string& reason) {
  if (points_.size() == 1) {
    direction_ = {0, side_ == 0 ? -1.0 : 1.0};
    step_ = first_share * greatest_step();
    at_end_ = false;
  }
  while (!at_end_ && points_.size() < most_points) {
    const auto& last = points_.back();
    std::size_t stepped = std::abs(direction_[1]) >= std::abs(direction_[0]) ? 1 : 0;
    Plane near{last.at[0] + step_ * direction_[0], last.at[1] + step_ * direction_[1]};
    double length = step_;
    std::string ends;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      const double bound = (direction_[k] < 0 ? low_[k] : high_[k]) / range_[k];
      if (!((near[k] - bound) * direction_[k] > 0)) continue;
      ends = fmt::format("the range of {} ends", keys_[k]);
      length = (bound - last.at[k]) / direction_[k];
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
        near[i] = last.at[i] + length * direction_[i];
      near[k] = bound;
      stepped = k;
    }
    if (!ends.empty() && !(length > 0)) {
      reason = ends;
      return false;
    }
    std::optional<Located> next;
    try {
      next = locate(points_, static_cast<int>(1 - stepped), near, reason);
    } catch (const ModelError& e) {
      reason = e.what();
    }
    Plane chord{};
    double size = 0;
    if (next) {
      chord = {next->at[0] - last.at[0], next->at[1] - last.at[1]};
      size = std::hypot(chord[0], chord[1]);
      const double cosine = (chord[0] * direction_[0] + chord[1] * direction_[1]) / size;
      if (points_.size() > 1 && cosine < BranchStep::least_cosine) {
        reason = "the curve turns too fast";
        next.reset();
      }
    }
    if (!next) {
      step_ *= BranchStep::reduction;
      if (step_ > least_share * greatest_step()) continue;
      return false;
    }
    points_.push_back(std::move(*next));
    direction_ = {chord[0] / size, chord[1] / size};
    step_ = std::min(greatest_step(), BranchStep::after(step_, points_.back().iterations));
    at_end_ = !ends.empty();
    if (at_end_) reason = ends;
    return true;
  }
  if (!at_end_) reason = fmt::format("{} points", most_points);
  return false;
}

CurvePoint BifurcationCurve::point() const {
  const auto& p = points_.back();
  CurvePoint c{.curve = ends_.curve,
               .kind = start_.kind,
               .parameter = p.at[0] * range_[0],
               .second = p.at[1] * range_[1],
               .orbit = branch_orbit(start_.solver.periods(), p.motion),
               .joint = {},
               .residual = p.residual * (is_positive() && p.free == 1 ? range_[0] / range_[1] : 1)};
  if (is_positive()) c.joint = contact_name(p.motion, start_.quantity);
  return c;
}

bool BifurcationCurve::begins_on(const std::vector<CurvePoint>& list) const {
  const double p = start_.parameter / range_[0],
               r = property(scene_, second_.key, Family::nonsmooth).value() / range_[1];
  for (std::size_t i = 1; i < list.size(); ++i) {
    if (list[i].kind != start_.kind || list[i].curve != list[i - 1].curve) continue;
    const auto place = [&](const CurvePoint& c) {
      return Eigen::Vector2d(c.parameter / range_[0] - p, c.second / range_[1] - r);
    };
    const auto a = place(list[i - 1]), chord = Eigen::Vector2d(place(list[i]) - a);
    const double share = std::clamp(-a.dot(chord) / chord.squaredNorm(), 0.0, 1.0);
    if ((a + share * chord).norm() < same_curve) return true;
  }
  return false;
}

}  // namespace freeplay
