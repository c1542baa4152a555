#include "analysis/return_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "dynamics/assembly/projection.hpp"
#include "dynamics/system.hpp"
#include "formulations/variation/differences.hpp"
#include "mechanism/error.hpp"
#include "values/family.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

constexpr double turn_of_map = 2 * std::numbers::pi;
/// A contact is closed at the section if its gap, relative to its measure, and its rate, relative to the
/// greatest speed, are below this.
constexpr double closed_gap = 1e-8;
/// Multipliers closer to the unit circle than this do not decide about stability. A double multiplier
/// is known to the square root of the error of the map.
constexpr double undecided = 1e-5;
/// Steps are doubled up to `most_steps` until the derivative of the map changes by less than `settled`.
constexpr int most_steps = 1 << 16;
constexpr double settled = 1e-8;
/// Likewise where time stepping made steps, whose errors are greater.
constexpr double settled_steps = 1e-4;
/// Rounding errors of a motion of some hundred steps, over those of its state.
constexpr double rounded_operations = 100;

}  // namespace

std::vector<double> list_of(const SectionState& s) {
  auto all = all_of(s);
  for (const auto& c : s.contacts) all.insert(all.end(), {c.v0, c.mass});
  return all;
}

ReturnMap::ReturnMap(const Scene& scene, const System& system, double length, bool autonomous, StopToken stop,
                     Family family)
    : scene_(scene), system_(system), stop_(stop), autonomous_(autonomous), length_(length), family_(family) {
  curved_ = system.size();
  for (int k = 0; k < system.contacts(); ++k)
    if (system.contact_facts(k).has_clearance) curved_ = std::min(curved_, system.contact_facts(k).clearance);
}

Eigen::Index ReturnMap::size() const {
  return shape_.cols() + basis_.cols() + system_.states() + static_cast<Eigen::Index>(retained_.size());
}

double ReturnMap::time_unit() const { return length_ / turn_of_map; }

std::string ReturnMap::take_closed(const SectionState& s) {
  closed_.clear();
  if (family_ == Family::penalty) return take_retained(s);
  auto e = system_.make_evaluation();
  system_.place(s.t, s.q.data(), e);
  double fastest = 0;
  for (const double v : s.v) fastest = std::max(fastest, std::abs(v));
  for (int k = 0; k < system_.contacts(); ++k) {
    ContactRow row;
    system_.contact(k, s.q.data(), s.v.data(), e, row);
    const double measure = system_.contact_facts(k).measure();
    if (std::abs(row.gap) < closed_gap * (measure > 0 ? measure : curved_) &&
        std::abs(row.normal.dot(s.v.data())) < closed_gap * fastest)
      closed_.push_back(k);
  }
  return {};
}

std::string ReturnMap::take_retained(const SectionState& s) {
  renewed_.clear();
  constants_.clear();
  retained_.clear();
  if (std::ranges::none_of(s.contacts, &PenaltyMode::closed)) return {};
  const auto end = motion(s, s.t + length_, 0);
  if (!end.stopped.empty()) return end.stopped;
  for (std::size_t k = 0; k < s.contacts.size(); ++k) {
    if (!s.contacts[k].closed || !end.retains[k]) continue;
    if (!end.renewed[k]) {
      constants_.push_back(static_cast<int>(k));
      continue;
    }
    renewed_.push_back(static_cast<int>(k));
    retained_.insert(retained_.end(), {s.contacts[k].v0, s.contacts[k].mass});
  }
  return {};
}

void ReturnMap::chart(const State& s) {
  const int n = system_.n();
  roots_ = VectorXd(n);
  for (int i = 0; i < n; ++i) roots_[i] = std::sqrt(system_.mass()[i]);
  MatrixXd rows = weighted_rows(system_, closed_, s);
  for (Eigen::Index k = 0; k < rows.cols(); ++k)
    if (const double size = rows.col(k).norm(); size > 0) rows.col(k) /= size;
  basis_ = MatrixXd::Identity(n, n);
  if (rows.cols() > 0) basis_ = orthogonal_complement(rows, 1e-9);
  shape_ = basis_;
  if (shift_.size() == 0) return;
  MatrixXd more(n, rows.cols() + 1);
  more << rows, shift_.cwiseProduct(roots_).normalized();
  shape_ = orthogonal_complement(more, 1e-9);
}

double ReturnMap::remove_shift(std::vector<double>& difference) const {
  if (shift_.size() == 0) return 0;
  const auto n = roots_.size();
  Eigen::Map<VectorXd> change(difference.data(), n);
  const VectorXd along = shift_.cwiseProduct(roots_);
  const double part = along.dot(change.cwiseProduct(roots_)) / along.squaredNorm();
  change -= part * shift_;
  return part;
}

std::vector<double> ReturnMap::displacement(const VectorXd& u) const {
  const auto f = basis_.cols(), s = shape_.cols();
  const auto n = roots_.size();
  std::vector<double> list(list_size());
  Eigen::Map<VectorXd> all(list.data(), static_cast<Eigen::Index>(list.size()));
  all.head(n) = (shape_ * u.head(s)).cwiseQuotient(roots_);
  all.segment(n, n) = (basis_ * u.segment(s, f)).cwiseQuotient(roots_) / time_unit();
  for (int k = 0; k < system_.states(); ++k) all[2 * n + k] = u[s + f + k] * system_.state_scale(k);
  for (std::size_t i = 0; i < retained_.size(); ++i)
    list[place_of_retained(i)] = u[s + f + system_.states() + static_cast<Eigen::Index>(i)] * retained_[i];
  return list;
}

std::size_t ReturnMap::list_size() const {
  const int retained = family_ == Family::penalty ? 2 * system_.contacts() : 0;
  const int entries = 2 * system_.n() + system_.states() + retained;
  return static_cast<std::size_t>(entries);
}

/// The place of retained_[i] in a list of (q, v, z, retained data).
std::size_t ReturnMap::place_of_retained(std::size_t i) const {
  const int first = 2 * system_.n() + system_.states() + 2 * renewed_[i / 2];
  return static_cast<std::size_t>(first) + i % 2;
}

std::string ReturnMap::shift(const std::vector<double>& difference, SectionState& s) const {
  const auto n = s.q.size();
  for (std::size_t i = 0; i < n; ++i) {
    s.q[i] += difference[i];
    s.v[i] += difference[n + i];
  }
  for (std::size_t k = 0; k < s.z.size(); ++k) s.z[k] += difference[2 * n + k];
  for (std::size_t i = 0; i < retained_.size(); ++i) {
    auto& c = s.contacts[static_cast<std::size_t>(renewed_[i / 2])];
    (i % 2 == 0 ? c.v0 : c.mass) += difference[place_of_retained(i)];
  }
  if (!project_onto_constraints(system_, closed_, s)) return "the mechanism cannot be closed there";
  auto e = system_.make_evaluation();
  system_.place(s.t, s.q.data(), e);
  for (int k = 0; k < system_.contacts(); ++k) {
    const auto& name = system_.contact_facts(k).name;
    const bool overlaps = system_.gap(k, s.q.data(), e) < 0;
    if (family_ != Family::penalty) {
      if (overlaps && std::ranges::find(closed_, k) == closed_.end())
        return fmt::format("contact {} overlaps there", name);
      continue;
    }
    const auto& c = s.contacts[static_cast<std::size_t>(k)];
    if (!(c.v0 > 0 && c.mass > 0)) return fmt::format("contact {} has no approach speed there", name);
    if (overlaps != c.closed)
      return fmt::format("contact {} {} there", name, c.closed ? "is open" : "overlaps");
  }
  return {};
}

VectorXd ReturnMap::local(const std::vector<double>& difference) const {
  const Eigen::Map<const VectorXd> all(difference.data(), static_cast<Eigen::Index>(difference.size()));
  const auto n = static_cast<Eigen::Index>(system_.n()), f = basis_.cols(), s = shape_.cols();
  VectorXd u(size());
  u.head(s) = shape_.transpose() * all.head(n).cwiseProduct(roots_);
  u.segment(s, f) = basis_.transpose() * all.segment(n, n).cwiseProduct(roots_) * time_unit();
  for (int k = 0; k < system_.states(); ++k) u[s + f + k] = all[2 * n + k] / system_.state_scale(k);
  for (std::size_t i = 0; i < retained_.size(); ++i)
    u[s + f + system_.states() + static_cast<Eigen::Index>(i)] =
        difference[place_of_retained(i)] / retained_[i];
  return u;
}

VariedKey ReturnMap::direction(const SectionState& s, Eigen::Index c) const {
  const VectorXd unit = VectorXd::Unit(size(), c);
  const VectorXd dq = (shape_ * unit.head(shape_.cols())).cwiseQuotient(roots_);
  double most = 0;
  for (int i = 0; i < system_.n(); ++i)
    most = std::max(most, std::abs(dq[i]) / (system_.is_angle(i) ? 1 : curved_));
  const double spacing = most > 0 ? 1e-3 / most : 1;
  const auto d = difference(spacing, list_of(s), [&](std::size_t i) {
    SectionState moved = s;
    move(difference_places[i] * spacing * unit, moved);
    return list_of(moved);
  });
  return {.name = "the state of the section", .start = d.slope, .refused = {}};
}

EndState ReturnMap::motion(const SectionState& s, double end, int steps, std::vector<VariedKey> keys) const {
  return run_end_state({.scene = scene_,
                        .system = system_,
                        .start = s,
                        .end = end,
                        .keys = std::move(keys),
                        .stop = stop_,
                        .longest_step = steps > 0 ? length_ / steps : INFINITY,
                        .equations = &kept_->equations,
                        .contacts = s.contacts},
                       family_);
}

ReturnPoint ReturnMap::run(const SectionState& s, double length, int steps, const MapKey* key,
                           bool to_return) const {
  std::vector<VariedKey> keys;
  for (Eigen::Index c = 0; c < size(); ++c) keys.push_back(direction(s, c));
  if (autonomous_ && to_return) {
    keys.push_back({.name = "the period", .start = std::vector<double>(list_size()), .refused = {}});
    keys.back().end_rate = length;
  }
  if (key) {
    const VariedStart from{.start = s,
                           .end = s.t + length,
                           .of =
                               [&](const Scene&, const System& system) {
                                 SectionState moved = s;
                                 if (!project_onto_constraints(system, closed_, moved))
                                   throw ModelError(key->name, "the mechanism cannot be closed there");
                                 return list_of(moved);
                               },
                           .end_of =
                               [&](const Scene& scene, const System& system) {
                                 return s.t +
                                        (key->length && to_return ? key->length(scene, system) : length);
                               }};
    keys.push_back(vary(scene_, system_, from, key->name, family_, kept_->displaced));
  }
  ReturnPoint p;
  p.state = s;
  for (const auto& k : keys) p.starts.push_back(k.start);
  p.end = motion(s, s.t + length, steps, std::move(keys));
  p.failure = p.end.stopped.empty() ? p.end.refused : p.end.stopped;
  return p;
}

ReturnPoint ReturnMap::at(const SectionState& s, int steps, const MapKey* key) const {
  auto p = run(s, length_, steps, key, true);
  if (p.failure.empty()) p.failure = compare_contacts(p);
  if (p.failure.empty()) compare(p, key != nullptr);
  return p;
}

double ReturnMap::accepted(const ReturnPoint& p) const {
  const double tolerance = family_ == Family::penalty ? scene_.penalty.tolerance : scene_.nonsmooth.tolerance;
  return std::max(accepted_errors * tolerance, rounding(p));
}

double ReturnMap::rounding(const ReturnPoint& p) const {
  const auto n = p.state.q.size();
  const double time = std::max(std::abs(p.state.t), std::abs(p.end.state.t));
  double fastest = p.end.fastest;
  for (const double v : p.state.v) fastest = std::max(fastest, std::abs(v));
  auto rounded = list_of(p.state);
  for (std::size_t i = 0; i < rounded.size(); ++i) rounded[i] = std::abs(rounded[i]);
  for (std::size_t i = 0; i < n; ++i) {
    rounded[i] += time * std::abs(p.state.v[i]);
    rounded[n + i] += time * fastest / time_unit();
  }
  const VectorXd u = local(rounded).cwiseAbs();
  double greatest = 0;
  for (std::size_t i = 0; i < rounded.size(); ++i) {
    double error = rounded[i];
    for (Eigen::Index c = 0; c < u.size(); ++c)
      error += std::abs(p.end.columns[static_cast<std::size_t>(c)][i]) * u[c];
    greatest = std::max(greatest, error / p.end.scales[i]);
  }
  return rounded_operations * std::numeric_limits<double>::epsilon() * greatest;
}

ReturnPoint ReturnMap::value(const SectionState& s, int steps) const {
  ReturnPoint p;
  p.state = s;
  p.end = motion(s, s.t + length_, steps);
  p.failure = p.end.stopped;
  if (p.failure.empty()) p.failure = compare_contacts(p);
  if (p.failure.empty()) compare_states(p);
  return p;
}

ReturnPoint ReturnMap::until(const SectionState& s, double t, int steps, const MapKey* key) const {
  return run(s, t - s.t, steps, key, false);
}

/// The reason why the contacts at both ends of a penalty motion cannot be compared; empty without one.
std::string ReturnMap::compare_contacts(const ReturnPoint& p) const {
  for (std::size_t k = 0; k < p.state.contacts.size(); ++k) {
    const auto &from = p.state.contacts[k], &to = p.end.contacts[k];
    const auto& name = system_.contact_facts(static_cast<int>(k)).name;
    if (from.closed != to.closed)
      return fmt::format("contact {} is {} at the start of the motion and {} at its end", name,
                         from.closed ? "closed" : "open", from.closed ? "open" : "closed");
    if (!from.closed || !p.end.retains[k]) continue;
    const bool renewed = std::ranges::find(renewed_, static_cast<int>(k)) != renewed_.end();
    if (from.in_impact != to.in_impact || from.eased != to.eased || renewed != (p.end.renewed[k] != 0))
      return fmt::format("contact {} has an impact only in some of the motions", name);
  }
  return {};
}

void ReturnMap::compare_states(ReturnPoint& p) const {
  auto& change = p.change;
  const auto append = [&](const std::vector<double>& to, const std::vector<double>& from) {
    for (std::size_t i = 0; i < to.size(); ++i) change.push_back(to[i] - from[i]);
  };
  append(p.end.state.q, p.state.q);
  append(p.end.state.v, p.state.v);
  append(p.end.state.z, p.state.z);
  for (std::size_t k = 0; k < p.state.contacts.size(); ++k) {
    const auto &from = p.state.contacts[k], &to = p.end.contacts[k];
    const bool acts = from.closed && p.end.retains[k];
    change.insert(change.end(), {acts ? to.v0 - from.v0 : 0, acts ? to.mass - from.mass : 0});
  }
  for (int i = 2; i < system_.n(); i += 3)
    change[static_cast<std::size_t>(i)] = std::remainder(change[static_cast<std::size_t>(i)], turn_of_map);
  p.shift = remove_shift(change);
  for (std::size_t i = 0; i < change.size(); ++i)
    p.greatest = std::max(p.greatest, std::abs(change[i]) / p.end.scales[i]);
}

void ReturnMap::compare(ReturnPoint& p, bool with_key) const {
  compare_states(p);
  p.residual = local(p.change);
  p.map.resize(size(), size());
  for (Eigen::Index c = 0; c < size(); ++c) p.map.col(c) = local(p.end.columns[static_cast<std::size_t>(c)]);
  if (autonomous_) p.flow = local(p.end.columns[static_cast<std::size_t>(size())]);
  if (with_key) p.by_key = local(p.end.columns.back()) - local(p.starts.back());
}

std::string refine(const ReturnMap& map, ReturnPoint& p, int& steps, const MapKey* key) {
  if (map.size() == 0) return {};
  for (; steps <= most_steps / 2;) {
    steps *= 2;
    auto finer = map.at(p.state, steps, key);
    if (!finer.failure.empty()) return finer.failure;
    const double change = (finer.map - p.map).cwiseAbs().maxCoeff();
    p = std::move(finer);
    const double enough = p.end.stepped ? settled_steps : settled;
    if (change <= enough * std::max(1.0, p.map.cwiseAbs().maxCoeff())) return {};
  }
  return fmt::format("the derivative of the return map still changes between {} and {} steps per motion",
                     most_steps / 2, most_steps);
}

Multipliers multipliers_of(const ReturnPoint& p, bool autonomous) {
  Multipliers found;
  if (p.map.size() == 0) return found;
  const auto values = general_eigen(p.map).values;
  found.values.assign(values.begin(), values.end());
  std::ranges::stable_sort(found.values, [](const auto& a, const auto& b) {
    return std::pair(std::abs(a), a.imag()) > std::pair(std::abs(b), b.imag());
  });
  auto decisive = found.values;
  if (autonomous && !decisive.empty())  // that of a shift along the motion
    decisive.erase(std::ranges::min_element(decisive, {}, [](const auto& m) { return std::abs(m - 1.0); }));
  found.stable = std::ranges::all_of(decisive, [](const auto& m) { return std::abs(m) < 1 - undecided; });
  return found;
}

}  // namespace freeplay
