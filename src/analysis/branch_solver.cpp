#include "analysis/branch_solver.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "analysis/periodicity.hpp"
#include "analysis/varied_key.hpp"
#include "mechanism/error.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr int most_corrections = 12;
/// Steps with the derivative of an earlier one, each of which reduces the residual at least by this factor.
/// They have reached its errors if it is below this share of the accepted one.
constexpr int most_simplified = 10;
constexpr double simplified_reduction = 0.3, reached_share = 1e-2;
/// Newton's method has converged if its last step was below this: its error is of the order of the square.
constexpr double negligible_step = 1e-8;
/// It diverges if it changes the key by more than this, over its range.
constexpr double farthest_step = 1;

double map_length(const BranchSetup& setup, int periods, const Scene& scene, const System& system) {
  return periods * section_period(excitation_of(scene.mechanism, system), setup.period);
}

/// Times of onsets after the section, s.
std::vector<double> onset_times(const BranchMotion& m) {
  std::vector<double> list;
  for (const auto& onset : m.point.end.onsets) list.push_back(onset.t - m.point.state.t);
  return list;
}

std::vector<double> difference_of(const SectionState& a, const SectionState& b) {
  auto list = list_of(a);
  const auto other = list_of(b);
  for (std::size_t i = 0; i < list.size(); ++i) list[i] -= other[i];
  return list;
}

std::string diverged(const BranchMotion& m, double accepted) {
  return fmt::format("Newton's method does not converge; its residual is {:.3g}, above {:.3g}",
                     m.point.greatest, accepted);
}

}  // namespace

double length_of(const VectorXd& tangent, Eigen::Index local) {
  return std::hypot(tangent.head(local).norm(), tangent[tangent.size() - 1]);
}

BranchModel::BranchModel(const Parameter& key, const BranchSetup& setup, int periods, double value)
    : scene(key.at(value)),
      system(scene.mechanism),
      map(scene, system, setup.autonomous ? 1 : map_length(setup, periods, scene, system), setup.autonomous,
          setup.stop, setup.family) {}

std::vector<int> BranchMotion::sequence() const {
  std::vector<int> list;
  for (const auto& onset : point.end.onsets) list.push_back(onset.contact);
  return list;
}

BranchSolver::BranchSolver(const Scene& given, BranchSetup setup, int periods)
    : varied_(property(given, setup.key, setup.family)), setup_(std::move(setup)), periods_(periods) {}

MapKey BranchSolver::key() const {
  MapKey k{.name = setup_.key};
  if (!setup_.autonomous)
    k.length = [this](const Scene& scene, const System& system) {
      return map_length(setup_, periods_, scene, system);
    };
  return k;
}

std::shared_ptr<BranchModel> BranchSolver::model(double parameter, const ReturnMap* like,
                                                 double length) const {
  auto m = std::make_shared<BranchModel>(varied_, setup_, periods_, parameter);
  if (like) m->map.take_closed(*like);
  if (setup_.autonomous) m->map.set_length(length);
  return m;
}

/// τ · (x − x_k) − s
double BranchSolver::excess(const BranchCondition& c, const SectionState& s, double parameter) const {
  const auto& map = c.base.model->map;
  return c.tangent.head(map.size()).dot(map.local(difference_of(s, c.base.point.state))) / scale_ +
         c.tangent[c.tangent.size() - 1] * (parameter - c.base.parameter) / setup_.range() - c.distance;
}

/// Rows: the map over σ, then the condition. Columns: u/σ, ln T if unknown, ξ.
MatrixXd BranchSolver::system_at(const BranchCondition& c, const BranchModel& m, const ReturnPoint& p) const {
  const auto f = m.map.size(), extra = static_cast<Eigen::Index>(setup_.autonomous ? 1 : 0);
  MatrixXd A(f + 1, f + extra + 1);
  A.topLeftCorner(f, f) = p.map - MatrixXd::Identity(f, f);
  if (setup_.autonomous) A.block(0, f, f, 1) = p.flow / scale_;
  A.topRightCorner(f, 1) = p.by_key * (setup_.range() / scale_);
  const auto local = c.base.model->map.size();
  const auto tangent = c.tangent.head(local);
  const auto part = [&](std::size_t column) {
    return tangent.dot(c.base.model->map.local(p.starts[column])) / scale_;
  };
  for (Eigen::Index k = 0; k < f; ++k) A(f, k) = part(static_cast<std::size_t>(k)) * scale_;
  if (setup_.autonomous) A(f, f) = 0;
  A(f, f + extra) = part(p.starts.size() - 1) * setup_.range() + c.tangent[c.tangent.size() - 1];
  return A;
}

std::optional<BranchSolver::Residual> BranchSolver::residual(const BranchCondition& c,
                                                             const BranchMotion& near,
                                                             const BranchGuess& at) const {
  const auto there = model(at.parameter, &c.base.model->map, at.length);
  Residual r{.start = at.state, .value = {}};
  if (!there->map.shift(std::vector<double>(list_of(r.start).size()), r.start).empty()) return {};
  const auto p = there->map.value(r.start, steps_);
  if (!p.failure.empty()) return {};
  r.greatest = p.greatest;
  const auto f = near.model->map.size();
  r.value = VectorXd(f + 1);
  r.value.head(f) = near.model->map.local(p.change) / scale_;
  r.value[f] = excess(c, r.start, at.parameter);
  return r;
}

/// A guess changed by a step (state, period, key) in the coordinates of a motion.
BranchGuess BranchSolver::moved(const BranchMotion& near, BranchGuess from, const VectorXd& step) const {
  const auto f = near.model->map.size();
  const auto by = near.model->map.displacement(scale_ * step.head(f));
  const auto n = from.state.q.size();
  for (std::size_t i = 0; i < n; ++i) {
    from.state.q[i] += by[i];
    from.state.v[i] += by[n + i];
  }
  for (std::size_t k = 0; k < from.state.z.size(); ++k) from.state.z[k] += by[2 * n + k];
  for (std::size_t k = 0; k < from.state.contacts.size(); ++k) {
    const auto place = 2 * n + from.state.z.size() + 2 * k;
    from.state.contacts[k].v0 += by[place];
    from.state.contacts[k].mass += by[place + 1];
  }
  from.parameter += setup_.range() * step[step.size() - 1];
  if (setup_.autonomous) from.length *= 1 + step[f];
  return from;
}

std::optional<BranchMotion> BranchSolver::solve(const BranchCondition& c, const BranchGuess& guess,
                                                std::string& reason) const {
  const auto by = key();
  BranchMotion m;
  BranchGuess at = guess;
  double before = INFINITY, step = INFINITY, accepted = 0;
  bool reached = false;  // the errors of the map
  const std::vector<double> none(list_of(at.state).size());
  try {
    for (; m.iterations <= most_corrections; ++m.iterations) {
      if (setup_.stop()) throw Interrupted();
      m.parameter = at.parameter;
      m.model = model(m.parameter, &c.base.model->map, at.length);
      auto& map = m.model->map;
      reason = map.shift(none, at.state);
      if (!reason.empty()) return {};
      map.chart(at.state);
      m.point = map.at(at.state, steps_, &by);
      reason = m.point.failure;
      if (!reason.empty()) return {};
      accepted = map.accepted(m.point);
      const auto f = map.size();
      if (f != c.base.model->map.size()) {
        reason = "the number of degrees of freedom changes";
        return {};
      }
      const double beside = excess(c, at.state, m.parameter);
      const auto A = system_at(c, *m.model, m.point);
      const MinimumNorm inverse(A, neutral_direction);
      if (m.point.greatest <= accepted && std::abs(beside) < 1e-9 &&
          (reached || step < negligible_step || m.point.greatest > 0.5 * before)) {
        m.multipliers = multipliers_of(m.point, setup_.autonomous);
        VectorXd ahead = VectorXd::Zero(f + 1);
        ahead[f] = 1;
        m.tangent = inverse.solve(ahead);
        m.tangent /= length_of(m.tangent, f);
        return m;
      }
      if (m.iterations > 1 && m.point.greatest > 10 * before && m.point.greatest > accepted) break;
      before = m.point.greatest;
      VectorXd rest(f + 1);
      rest.head(f) = -m.point.residual / scale_;
      rest[f] = -beside;
      at.state = m.point.state;
      at.length = map.length();
      // Steps with this derivative are cheap: a run without variational equations costs a small part of one
      // with them. The next evaluation with derivatives is where they have reached the errors of the map, or
      // no longer reduce the residual fast.
      double last = m.point.greatest;
      reached = false;
      for (int i = 0; i <= most_simplified; ++i) {
        const VectorXd change = inverse.solve(rest);
        const bool far = !(std::abs(change[change.size() - 1]) <= farthest_step) ||
                         (setup_.autonomous && !(std::abs(change[f]) < 0.5));
        if (far && i == 0) {
          reason = diverged(m, accepted);
          return {};
        }
        if (far) break;
        const auto kept = at;
        at = moved(m, std::move(at), change);
        step = length_of(change, f);
        if (i == most_simplified) break;
        const auto r = residual(c, m, at);
        if (i > 0 && (!r || r->greatest > last)) at = kept;
        if (!r) break;
        const bool reduced = r->greatest <= simplified_reduction * last;
        reached = !reduced && r->greatest <= reached_share * accepted;
        if (!reduced) break;
        at.state = r->start;
        rest = -r->value;
        last = r->greatest;
      }
      if (last < before) {  // the last step was not Newton's
        before = INFINITY;
        step = INFINITY;
      }
    }
  } catch (const ModelError& e) {
    reason = e.what();
    return {};
  }
  reason = diverged(m, accepted);
  return {};
}

BranchGuess BranchSolver::guess(const BranchMotion& base, double distance) const {
  return moved(base, {base.point.state, base.parameter, base.model->map.length()}, distance * base.tangent);
}

std::optional<BranchMotion> BranchSolver::along(const BranchMotion& base, double distance,
                                                std::string& reason) const {
  return solve({base, base.tangent, distance}, guess(base, distance), reason);
}

std::optional<BranchMotion> BranchSolver::at_key(const BranchMotion& base, const BranchGuess& guess,
                                                 std::string& reason) const {
  VectorXd tangent = VectorXd::Zero(base.tangent.size());
  tangent[tangent.size() - 1] = 1;
  return solve({base, tangent, (guess.parameter - base.parameter) / setup_.range()}, guess, reason);
}

std::optional<BranchMotion> BranchSolver::begin(const SectionState& near, double parameter, double length,
                                                bool rising, std::string& reason) {
  BranchMotion base;
  base.parameter = parameter;
  base.model = model(parameter, nullptr, length);
  auto& map = base.model->map;
  reason = map.take_closed(near);
  if (!reason.empty()) return {};
  base.point.state = near;
  map.chart(near);
  if (map.size() == 0 && map.closed().empty()) {
    reason = "the motion has no degrees of freedom at the section";
    return {};
  }
  base.tangent = VectorXd::Zero(map.size() + (setup_.autonomous ? 1 : 0) + 1);
  auto m = at_key(base, {near, parameter, length}, reason);
  if (!m) return {};
  reason = refine_motion(*m);
  if (!reason.empty()) return {};
  if (!rising) m->tangent = -m->tangent;
  if (margin(*m) < 0.5) reason = recentre(*m);
  if (!reason.empty()) return {};
  const auto f = m->model->map.size();
  const double u = m->tangent.head(f).norm(), xi = std::abs(m->tangent_key());
  if (u > 0 && xi > 0) {
    const double ratio = u / xi;
    scale_ *= ratio;
    m->tangent.head(f) /= ratio;
    m->tangent /= length_of(m->tangent, f);
  }
  return m;
}

std::optional<EndState> BranchSolver::beside(const BranchMotion& m, const VectorXd& u, double xi) const {
  try {
    const auto there = model(m.parameter + xi * setup_.range(), &m.model->map, m.model->map.length());
    auto s = m.point.state;
    if (!there->map.shift(m.model->map.displacement(scale_ * u), s).empty()) return {};
    auto end = there->map.motion(s, s.t + there->map.length(), fewest_map_steps);
    if (!end.stopped.empty()) return {};
    return end;
  } catch (const ModelError&) {
    return {};
  }
}

std::string BranchSolver::refine_motion(BranchMotion& m) {
  const auto by = key();
  int steps = steps_;
  const auto why = refine(m.model->map, m.point, steps, &by);
  steps_ = std::max(steps_, steps / 2);
  m.multipliers = multipliers_of(m.point, setup_.autonomous);
  return why;
}

double BranchSolver::margin(const BranchMotion& m) {
  double least = 0.5;
  const double length = m.model->map.length();
  for (const double t : onset_times(m)) least = std::min({least, t / length, 1 - t / length});
  return least;
}

std::string BranchSolver::recentre(BranchMotion& m) const {
  const auto times = onset_times(m);
  if (times.empty()) return {};
  const auto& map = m.model->map;
  const double length = map.length();
  double begin = times.back() - length, longest = times.front() - begin, at = begin + 0.5 * longest;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] - times[i - 1] > longest) {
      longest = times[i] - times[i - 1];
      at = times[i - 1] + 0.5 * longest;
    }
  const double start = m.point.state.t;
  if (at < 0) at += length;
  if (at == 0) return {};
  const auto by = key();
  const auto part = map.until(m.point.state, start + at, steps_, &by);
  if (!part.failure.empty()) return part.failure;
  const auto f = map.size();
  std::vector<double> ahead(list_of(m.point.state).size());
  for (std::size_t c = 0; c < part.end.columns.size(); ++c) {
    const double share = c + 1 < part.end.columns.size() ? scale_ * m.tangent[static_cast<Eigen::Index>(c)]
                                                         : setup_.range() * m.tangent_key();
    for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] += share * part.end.columns[c][i];
  }
  SectionState s(part.end.state, part.end.contacts);
  // The same phase in the first period, where rounding errors of times and turns are least.
  if (const double periods = std::floor(s.t / length + 1e-9); periods != 0) {
    const double whole = 2 * std::numbers::pi;
    for (std::size_t i = 2; i < s.q.size(); i += 3)
      s.q[i] -= periods * whole * std::round((m.point.end.state.q[i] - m.point.state.q[i]) / whole);
    s.t -= periods * length;
  }
  BranchMotion moved;
  moved.parameter = m.parameter;
  moved.model = model(m.parameter, nullptr, length);
  auto& there = moved.model->map;
  if (auto why = there.take_closed(s); !why.empty()) return why;
  if (auto why = there.shift(std::vector<double>(ahead.size()), s); !why.empty()) return why;
  there.chart(s);
  moved.point = there.at(s, steps_, &by);
  if (!moved.point.failure.empty()) return moved.point.failure;
  moved.multipliers = multipliers_of(moved.point, setup_.autonomous);
  moved.iterations = m.iterations;
  const auto g = there.size();
  moved.tangent = VectorXd::Zero(g + m.tangent.size() - f);
  moved.tangent.tail(m.tangent.size() - f) = m.tangent.tail(m.tangent.size() - f);
  moved.tangent.head(g) = there.local(ahead) / scale_;
  moved.tangent /= length_of(moved.tangent, g);
  m = std::move(moved);
  return {};
}

}  // namespace freeplay
