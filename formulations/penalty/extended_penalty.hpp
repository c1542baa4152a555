// ExtendedPenalty: penalty dynamics of the vector [x, (v₀, m) of each contact]. v₀ and the mass m of a
// contact are constant between its events, but depend on parameters like the rest of the state.
//
// An object of a displaced system evaluates contact forces beside the anchors of the nominal one
// (ContactAnchor). So does a nominal object at displaced states (pin()), so that differences may be long
// against the depth of a contact.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "formulations/penalty/dynamics.hpp"
#include "simulation/table_rows.hpp"

namespace freeplay {

class ExtendedPenalty {
 public:
  using Vector = std::vector<double>;
  using Present = PenaltyDynamics;

  /// `nominal`: the object of the nominal system; null if this is one.
  ExtendedPenalty(std::unique_ptr<PenaltyDynamics> dynamics, double speed_scale,
                  ExtendedPenalty* nominal = nullptr)
      : system(dynamics->system()),
        f_(std::move(dynamics)),
        e_(system.make_evaluation()),
        nominal_(nominal),
        speed_scale_(speed_scale) {}

  int size() const { return retained_offset() + 2 * system.contacts(); }
  int retained_offset() const { return f_->size(); }
  int impulse_offset() const { return f_->impulse_offset(); }
  int bristle_offset() const { return f_->bristle_offset(); }
  int bristles() const { return f_->bristles(); }
  int state_offset() const { return f_->state_offset(); }
  int integral_offset() const { return f_->integral_offset(); }

  void operator()(const Vector& x, Vector& dxdt, double t);
  const Vector& directional(const Vector& x, double t, std::span<const Vector> directions,
                            std::span<const double> times, std::span<Vector> out);
  bool includes_parameter(std::size_t c) const { return f_->includes_parameter(c); }
  PenaltyDynamics& dynamics() { return *f_; }
  void take_mode(const PenaltyDynamics& other);
  /// [x, retained data] in the present mode.
  Vector extended(const Vector& x) const;

  /// Contact k at a state.
  const ContactRow& row(int k, const Vector& x, double t) { return f_->contact_rows.at(k, x, t); }
  /// Rate of its gap (m/s), its acceleration if dx/dt is `slope`, and the effective mass of an impact.
  double gap_rate(int k, const Vector& x, double t);
  double gap_acceleration(int k, const Vector& x, const Vector& slope, double t);
  double effective_mass(int k, const Vector& x, double t) { return f_->effective_mass(row(k, x, t)); }
  /// w² of a closed contact (contact_law.hpp). Beside an anchor it is a polynomial in the state, which w is
  /// not.
  double squared_touch_speed(int k, const Vector& x, double t);
  /// Force (N) of a closed contact before it is clamped at zero.
  double unclamped_force(int k, const Vector& x, double t);
  /// Energy (J) stored in closed contacts that dissipate.
  double stored_energy(const Vector& x, double t);
  double observed(const Column& column, const Vector& x, double t);

  std::vector<PenaltyContact>& contacts() { return f_->contacts(); }
  const std::vector<PenaltyContact>& contacts() const { return f_->contacts(); }
  const Phases& phases() const { return f_->phases; }
  void touch(bool on) {
    f_->touching = on;
    anchored_.clear();
  }
  /// @name From here on, evaluations beside x use the anchors at x
  ///@{
  void pin(const Vector& x, double t);
  void unpin() {
    pinned_ = false;
    f_->anchors = nullptr;
  }
  ///@}
  /// Greatest absolute rate; angles count at the longest arm.
  double greatest(const double* rates) const;
  double speed_scale() const { return speed_scale_; }
  const System& system;
  double knot = INFINITY;

 private:
  void prepare(const Vector& x, double t);
  const std::vector<ContactAnchor>& anchors_at(const Vector& x, double t);
  double elastic_energy(int k, const ContactRow& at) const;

  std::unique_ptr<PenaltyDynamics> f_;
  mutable Evaluation e_;
  ExtendedPenalty* nominal_;
  bool pinned_ = false;
  double speed_scale_;
  std::vector<ContactAnchor> anchors_;
  Vector anchored_, slope_;  // anchored_: x and t of the anchors
};

inline double observed(const Column& column, ExtendedPenalty& f, const std::vector<double>& x, double t) {
  return f.observed(column, x, t);
}
inline void take_varied_mode(ExtendedPenalty& f, const PenaltyDynamics& dynamics) { f.take_mode(dynamics); }
inline double curved_length(const ExtendedPenalty&, const std::vector<double>&, double length) {
  return length;
}
double curved_speed(const ExtendedPenalty& f, const std::vector<double>& x);
double further_spacing(const ExtendedPenalty& f, const std::vector<double>& x, const std::vector<double>& dx);

}  // namespace freeplay
