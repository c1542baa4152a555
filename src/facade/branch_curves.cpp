#include "facade/branch_curves.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "facade/varied_key.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

using Eigen::VectorXd;

/// Steps in the plane of both keys, each over its range: default, first and least one over the greatest.
constexpr double default_step = 0.02, first_share = 0.1, least_share = 1e-3;
constexpr double growth = 1.5, reduction = 0.5;
/// Cosine of the greatest angle between successive chords.
constexpr double least_cosine = 0.9;
constexpr int most_points = 1000;  // to each side
/// A zero is located if the arclength changes by less than this; most motions for it.
constexpr double located = 1e-8;
constexpr int most_motions = 12;
/// First arclength at an unknown slope.
constexpr double first_arclength = 1e-4;
/// Shares of a positive quantity of the motions from which its zero is extrapolated.
constexpr double levels[] = {4e-3, 2e-3, 1e-3};
/// Greatest share of the last one.
constexpr double greatest_last = 4e-3;

/// Tangent for a search along another key: across the old one, as far as the state changes.
void turn(VectorXd& tangent, Eigen::Index local) {
  auto& key = tangent[tangent.size() - 1];
  const double state = tangent.head(local).norm();
  if (state > 1e-6 * std::abs(key))
    key = 0;
  else
    key = 1;
  tangent /= length_of(tangent, local);
}

void extrapolate(std::vector<double>& x, const std::vector<double>& before, double share) {
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += share * (x[i] - before[i]);
}

}  // namespace

BifurcationCurve::BifurcationCurve(const Scene& scene, const SecondKey& second, CurveStart start, int number)
    : scene_(scene), second_(second), start_(std::move(start)), number_(number) {
  const auto& setup = start_.solver.setup();
  keys_ = {setup.key, second.key};
  low_ = {std::min(setup.from, setup.to), std::min(second.from, second.to)};
  high_ = {std::max(setup.from, setup.to), std::max(second.from, second.to)};
  range_ = {high_[0] - low_[0], high_[1] - low_[1]};
  low_[0] -= range_[0];
  high_[0] += range_[0];
}

BranchSolver BifurcationCurve::solver(int free, double fixed) const {
  Scene scene = scene_;
  set_number_key(scene, keys_[1 - free], Family::nonsmooth, fixed);
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

/// Moves along the branch to small values of the positive quantity, and extrapolates to zero.
bool BifurcationCurve::vanishing(const BranchSolver& solver, Located& p, std::string& reason) const {
  // To a motion of this kind: from the prediction to greater values.
  double inwards = 0;
  std::optional<BranchMotion> m = along(solver, p.motion, 0, reason);
  const double unit = p.slope != 0 ? levels[0] / p.slope : first_arclength;
  for (const double steps : {1.0, 3.0, 9.0, 27.0}) {
    if (m) break;
    inwards = steps * unit;
    m = along(solver, p.motion, inwards, reason);
  }
  if (!m) return false;
  std::vector<BranchMotion> motions{*m};
  if (p.slope == 0) {
    const double f = test(solver, *m);
    for (const double side : {1.0, -1.0}) {
      auto next = along(solver, *m, side * first_arclength, reason);
      if (!next) continue;
      p.slope = side * (test(solver, *next) - f) / first_arclength;
      break;
    }
    if (p.slope == 0) return false;
  }
  for (const double level : levels)
    for (int tries = 0; tries < 3; ++tries) {
      const double f = test(solver, motions.back());
      double step = (level - f) / p.slope;
      if (std::abs(f - level) < 0.2 * level) break;
      auto next = along(solver, motions.back(), step, reason);
      for (int halvings = 0; !next && halvings < 4; ++halvings)
        next = along(solver, motions.back(), step *= 0.5, reason);
      if (!next) break;
      const double slope = (test(solver, *next) - f) / step;
      if (slope * p.slope > 0) p.slope = slope;
      motions.push_back(std::move(*next));
    }
  std::ranges::stable_sort(motions, std::greater(), [&](const auto& one) { return test(solver, one); });
  if (motions.size() < 2 || !(test(solver, motions.back()) < greatest_last)) {
    if (reason.empty()) reason = "no motion with a small value of the quantity is found";
    return false;
  }
  const auto end = extrapolated(motions, start_.quantity);
  p.residual = end.error;
  p.at[static_cast<std::size_t>(p.free)] = end.parameter / range_[static_cast<std::size_t>(p.free)];
  p.motion = std::move(motions.back());
  return true;
}

/// The bifurcation near a point of the plane. `ahead`: distance from the last point over that between the last
/// two.
std::optional<BifurcationCurve::Located> BifurcationCurve::locate(const std::vector<Located>& points,
                                                                  double ahead, int free, const Plane& near,
                                                                  std::string& reason) const {
  const auto& last = points.back();
  const auto of = static_cast<std::size_t>(free);
  const auto s = solver(free, near[1 - of] * range_[1 - of]);
  Located p;
  p.at = near;
  p.free = free;
  auto& base = p.motion;
  base.parameter = near[of] * range_[of];
  // The motion next to the last bifurcation keeps its distance from it.
  if (is_positive() && free == last.free) base.parameter += last.motion.parameter - last.at[of] * range_[of];
  base.point.state = last.motion.point.state;
  double length = last.motion.model->map.length();
  if (points.size() > 1) {
    const auto& before = points[points.size() - 2].motion;
    extrapolate(base.point.state.q, before.point.state.q, ahead);
    extrapolate(base.point.state.v, before.point.state.v, ahead);
    extrapolate(base.point.state.z, before.point.state.z, ahead);
    length += ahead * (length - before.model->map.length());
  }
  Scene scene = scene_;
  set_number_key(scene, keys_[1 - of], Family::nonsmooth, near[1 - of] * range_[1 - of]);
  base.model = std::make_shared<BranchModel>(scene, s.setup(), s.periods(), base.parameter);
  auto& map = base.model->map;
  map.set_closed(last.motion.model->map.closed());
  if (s.setup().autonomous) map.set_length(length);
  reason = map.shift(std::vector<double>(last.motion.point.starts.front().size()), base.point.state);
  if (!reason.empty()) return {};
  map.chart(base.point.state);
  const auto f = map.size();
  base.tangent = last.motion.tangent;
  base.tangent.head(f) = map.local(last.motion.model->map.displacement(last.motion.tangent.head(f)));
  base.tangent /= length_of(base.tangent, f);
  p.slope = last.slope;
  if (free != last.free) {
    turn(base.tangent, f);
    p.slope = 0;
  }
  if (!(is_positive() ? vanishing(s, p, reason) : zero(s, p, reason))) return {};
  return p;
}

std::vector<BifurcationCurve::Located> BifurcationCurve::follow_to(
    double side, const Located& from, const std::function<void(const CurvePoint&)>& on_point,
    std::string& reason) const {
  std::vector<Located> points{from};
  Plane direction{0, side};
  const double greatest = second_.step ? *second_.step / range_[1] : default_step;
  double step = first_share * greatest, last_step = 0;
  while (points.size() < most_points) {
    const auto& last = points.back();
    std::size_t stepped = std::abs(direction[1]) >= std::abs(direction[0]) ? 1 : 0;
    Plane near{last.at[0] + step * direction[0], last.at[1] + step * direction[1]};
    double length = step;
    std::string ends;
    for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
      const double bound = (direction[k] < 0 ? low_[k] : high_[k]) / range_[k];
      if (!((near[k] - bound) * direction[k] > 0)) continue;
      ends = fmt::format("the range of {} ends", keys_[k]);
      length = (bound - last.at[k]) / direction[k];
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}})
        near[i] = last.at[i] + length * direction[i];
      near[k] = bound;
      stepped = k;
    }
    if (!ends.empty() && !(length > 0)) {
      reason = ends;
      return points;
    }
    std::optional<Located> next;
    try {
      next =
          locate(points, last_step > 0 ? length / last_step : 0, static_cast<int>(1 - stepped), near, reason);
    } catch (const ModelError& e) {
      reason = e.what();
    }
    Plane chord{};
    double size = 0;
    if (next) {
      chord = {next->at[0] - last.at[0], next->at[1] - last.at[1]};
      size = std::hypot(chord[0], chord[1]);
      const double cosine = (chord[0] * direction[0] + chord[1] * direction[1]) / size;
      if (points.size() > 1 && cosine < least_cosine) {
        reason = "the curve turns too fast";
        next.reset();
      }
    }
    if (!next) {
      step *= reduction;
      if (step > least_share * greatest) continue;
      return points;
    }
    points.push_back(std::move(*next));
    if (on_point) on_point(point_of(points.back()));
    direction = {chord[0] / size, chord[1] / size};
    last_step = size;
    if (!ends.empty()) {
      reason = ends;
      return points;
    }
    step = std::min(greatest, growth * step);
  }
  reason = fmt::format("{} points", most_points);
  return points;
}

CurvePoint BifurcationCurve::point_of(const Located& p) const {
  CurvePoint c{.curve = number_,
               .kind = start_.kind,
               .parameter = p.at[0] * range_[0],
               .second = p.at[1] * range_[1],
               .orbit = branch_orbit(start_.solver.periods(), p.motion),
               .joint = {},
               .residual = p.residual * (is_positive() && p.free == 1 ? range_[0] / range_[1] : 1)};
  if (is_positive()) c.joint = contact_name(p.motion, start_.quantity);
  return c;
}

std::pair<std::vector<CurvePoint>, CurveEnds> BifurcationCurve::follow(
    const std::function<void(const CurvePoint&)>& on_point) {
  const double second = number_of_key(scene_, second_.key, Family::nonsmooth);
  Located from{.at = {start_.parameter / range_[0], second / range_[1]}, .motion = start_.motion};
  if (on_point) on_point(point_of(from));
  CurveEnds ends;
  ends.curve = number_;
  ends.kind = start_.kind;
  ends.parameter = start_.parameter;
  auto list = follow_to(-1, from, on_point, ends.reasons[0]);
  std::ranges::reverse(list);
  const auto up = follow_to(1, from, on_point, ends.reasons[1]);
  list.insert(list.end(), up.begin() + 1, up.end());
  std::vector<CurvePoint> points;
  for (const auto& p : list) points.push_back(point_of(p));
  ends.points = static_cast<int>(points.size());
  return {std::move(points), std::move(ends)};
}

}  // namespace freeplay
