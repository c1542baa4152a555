#include "formulations/penalty/extended_penalty.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {

/// Sets the retained data of all contacts and, in a displaced system, the anchors at x.
void ExtendedPenalty::prepare(const Vector& x, double t) {
  f_->knot = knot;
  for (int k = 0; k < system.contacts(); ++k) {
    auto& c = f_->contacts()[k];
    c.v0 = x[retained_offset() + 2 * k];
    c.mass = x[retained_offset() + 2 * k + 1];
  }
  if (nominal_) {
    f_->touching = nominal_->f_->touching;
    f_->anchors = &nominal_->anchors_at(x, t);
  }
}

const std::vector<ContactAnchor>& ExtendedPenalty::anchors_at(const Vector& x, double t) {
  if (anchored_.size() == x.size() + 1 && anchored_.back() == t &&
      std::equal(x.begin(), x.end(), anchored_.begin()))
    return anchors_;
  prepare(x, t);
  f_->anchor(x, t, anchors_);
  anchored_ = x;
  anchored_.push_back(t);
  return anchors_;
}

void ExtendedPenalty::pin(const Vector& x, double t) {
  anchors_at(x, t);
  pinned_ = true;
  f_->anchors = &anchors_;
}

void ExtendedPenalty::operator()(const Vector& x, Vector& dxdt, double t) {
  prepare(x, t);
  (*f_)(x, dxdt, t);
  std::fill(dxdt.begin() + retained_offset(), dxdt.end(), 0.0);
}

const ExtendedPenalty::Vector& ExtendedPenalty::directional(const Vector& x, double t,
                                                            std::span<const Vector> directions,
                                                            std::span<const double> times,
                                                            std::span<Vector> out) {
  prepare(x, t);
  slope_ = f_->directional(x, t, directions, times, out);
  slope_.resize(x.size());
  for (auto& column : out) std::fill(column.begin() + retained_offset(), column.end(), 0.0);
  return slope_;
}

void ExtendedPenalty::take_mode(const PenaltyDynamics& other) {
  for (std::size_t k = 0; k < f_->contacts().size(); ++k)
    f_->contacts()[k].mode() = other.contacts()[k].mode();
  f_->phases = other.phases;
  knot = other.knot;
  anchored_.clear();
}

ExtendedPenalty::Vector ExtendedPenalty::extended(const Vector& x) const {
  auto all = x;
  for (const auto& c : f_->contacts()) all.insert(all.end(), {c.v0, c.mass});
  return all;
}

double ExtendedPenalty::gap_rate(int k, const Vector& x, double t) {
  return row(k, x, t).normal.dot(x.data() + system.n());
}

double ExtendedPenalty::gap_acceleration(int k, const Vector& x, const Vector& slope, double t) {
  const auto& at = row(k, x, t);
  return at.normal.dot(slope.data() + system.n()) - at.gamma_n;
}

double ExtendedPenalty::elastic_energy(int k, const ContactRow& at) const {
  const auto& elastic = f_->contacts()[k].law.elastic;
  if (!f_->anchors) return elastic.energy(std::max(0.0, -at.gap));
  const auto& anchor = (*f_->anchors)[static_cast<std::size_t>(k)];
  return elastic.energy(anchor.delta) + anchor.elastic * (-at.gap - anchor.delta);
}

double ExtendedPenalty::squared_touch_speed(int k, const Vector& x, double t) {
  prepare(x, t);
  const auto& at = row(k, x, t);
  const double rate = at.normal.dot(x.data() + system.n());
  return rate * rate + 2 / f_->contacts()[k].mass * elastic_energy(k, at);
}

double ExtendedPenalty::unclamped_force(int k, const Vector& x, double t) {
  prepare(x, t);
  const auto& at = row(k, x, t);
  const auto& c = f_->contacts()[k];
  const double delta = std::max(0.0, -at.gap), rate = -at.normal.dot(x.data() + system.n());
  const double v0 = c.in_impact ? c.law.touch_speed(delta, rate, c.mass) : c.v0;
  return c.law.unclamped(c.law.elastic.force(delta), rate, v0);
}

double ExtendedPenalty::stored_energy(const Vector& x, double t) {
  prepare(x, t);
  double sum = 0;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = f_->contacts()[k];
    if (c.closed && c.law.dissipates()) sum += elastic_energy(k, row(k, x, t));
  }
  return sum;
}

double ExtendedPenalty::observed(const Column& column, const Vector& x, double t) {
  using Of = Column::Of;
  switch (column.of) {
    case Of::time:
      return t;
    case Of::position:
      return x[column.index];
    case Of::velocity:
      return x[static_cast<std::size_t>(system.n()) + column.index];
    case Of::contact: {
      const int k = static_cast<int>(column.index);
      system.place(t, x.data(), e_);
      const auto e = system.eccentricity(k, x.data(), e_);
      return ContactPlace{e.x(), e.y(), system.gap(k, x.data(), e_)}.*column.place;
    }
    default:
      break;
  }
  prepare(x, t);
  auto forces = system.make_forces();
  slope_.resize(x.size());
  f_->report(x, t, slope_, forces);
  return column.of == Of::acceleration ? forces.acceleration[column.index]
                                       : forces.elements[column.index].*column.force;
}

double ExtendedPenalty::greatest(const double* rates) const {
  const double arm = system.longest_arm();
  double most = 0;
  for (int i = 0; i < system.n(); ++i)
    most = std::max(most, (system.is_angle(i) ? arm : 1) * std::abs(rates[i]));
  return most;
}

double curved_speed(const ExtendedPenalty& f, const std::vector<double>& x) {
  double speed = std::max(f.greatest(x.data() + f.system.n()), f.speed_scale());
  for (int k = 0; k < f.system.frictions(); ++k)
    if (const auto& v = f.system.friction_facts(k).regularisation) speed = std::min(speed, *v);
  return speed;
}

double further_spacing(const ExtendedPenalty& f, const std::vector<double>& x,
                       const std::vector<double>& dx) {
  double most = 0;
  for (std::size_t i = static_cast<std::size_t>(f.retained_offset()); i < x.size(); ++i)
    if (dx[i] != 0) most = std::max(most, std::abs(dx[i]) / (1e-3 * std::abs(x[i])));
  for (int k = 0; k < f.bristles(); ++k)
    if (const auto& c = f.contacts()[k]; c.closed && c.friction)
      most = std::max(most, std::abs(dx[f.bristle_offset() + k]) * c.friction->sigma0 / 1e-2);
  return most;
}

}  // namespace freeplay
