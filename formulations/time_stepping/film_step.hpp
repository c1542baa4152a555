// FilmStep: lubricant films in a Moreau–Jean step, implicit in the velocities. With the rates
// y = Rᵀv of a film's rows at q_m (ġ, w_t and the relative spin), its force F at the film thickness
// of q_m, and D = RᵀAR,
//
//     p = h F(y_θ),     y_θ = (1 − θ) Rᵀv + θ Rᵀv⁺ − (θ − ½) h γ,     v⁺ = v_free + A R p.
//
// Newton's method linearises p = p₀ + J (y_θ − y₀), J = h ∂F/∂y, which gives (1 − θJD) p = p₀ + J
// (y_θ,free − y₀). Contact impulses in the same step act against the film's resistance: a contact's
// response A W becomes A W + A R (1 − θJD)⁻¹ θJ RᵀA W. With z = h C D of each row, where C is the
// resistance of the full film along it,
//
//     θ = 1/(1 − e^(−z)) − 1/z = ½ + z/12 − …
//
// is exact for a single constant resistance (exponential fitting: Liniger and Willoughby, SIAM J.
// Numer. Anal. 7 (1970) 47). It is of second order where the step resolves the film, and avoids the
// oscillations of θ = ½ (v⁺ = −v as z → ∞) where it does not. A motion that a film stops within a
// step covers the distance of y_θ instead of the mean of the end rates. With the change of the
// rates δ = Rᵀ(v⁺ − v) − h γ, positions are therefore displaced along A R such that the rows move
// by h (θ − ½) δ.
//
// Usage in a step: take() each film's row, begin(), linearise() and resist() until the velocities
// converge, finish(), displace().
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "formulations/contact/film.hpp"
#include "numerics/dense.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {

class FilmStep {
 public:
  explicit FilmStep(const System& system);
  bool any() const { return !films_.empty(); }
  int size() const { return static_cast<int>(films_.size()); }
  int contact(int film) const { return films_[static_cast<std::size_t>(film)].contact; }

  /// Sets the row of a film's contact at q_m, and its gap (m) at the beginning of the step.
  void take(int film, const ContactRow& row, double gap);
  /// Called after take() of all films: a step of h (s) from v_old; `saddle` is factorised at q_m.
  void begin(double h, SaddlePoint& saddle, const double* v_old);
  /// Linearises about the step that would end with v_new.
  void linearise(const double* v_new);
  /// Adds the effect of the films to a motion without them.
  void resist(double* v, double* lambda);
  /// Adds the films' resistance to the response of a row's impulse and to its reactions.
  void relax(double* own, double* own_reaction) const;
  /// Greatest change of a coordinate's rate by the last resist(), the scale of rounding errors.
  double greatest_change() const;
  /// Computes the impulses at the end of the step.
  void finish(const double* v_old, const double* v_new);
  /// Displaces positions at the end of the step for motion that films stopped within it, except at
  /// contacts that `pressed`.
  template <class Pressed>
  void displace(double* q, Pressed pressed) const {
    for (const auto& f : films_)
      for (int a = 0; f.first >= 0 && !pressed(f.contact) && a < 2; ++a)
        for (int i = 0; i < n_; ++i) q[i] += beyond_[2 * f.first / 3 + a] * response(f.first + a)[i];
  }
  /// Energy dissipated by the films (J).
  double loss(const double* v_old, const double* v_new) const;
  /// Adds the impulses of the films. The share due to a velocity change `in_impact` by impacts is
  /// added to `within`.
  void report(const System& system, const double* q, const Evaluation& e, const double* in_impact,
              Forces& smooth, Forces& within) const;

  /// The greatest relative change of a film's thickness in one step, where the film mattered, and
  /// its contact.
  struct ThicknessChange {
    double share = 0;
    int contact = -1;
    template <class M>
    void serialize(M& m) {
      m(share, contact);
    }
  };
  ThicknessChange thickness_change;

 private:
  struct Place {
    int contact = -1;
    Film law;
    ContactRow row;
    double gap = 0;                      // m, at the beginning of the step
    double mobility = 0;                 // 1/kg, of its normal row
    int first = -1;                      // of its three rows in response_, −1: dry in this step
    std::array<double, 3> y_old, gamma;  // Rᵀv, γ
    std::array<double, 3> theta, y, p;   // y_θ of the linearisation, and its impulses
    std::array<std::array<double, 3>, 3> J;
    const SparseRow& of(int a) const { return a == 0 ? row.normal : a == 1 ? row.film : row.spin; }
  };
  double* response(int r) { return response_.data() + static_cast<long>(r) * n_; }
  const double* response(int r) const { return response_.data() + static_cast<long>(r) * n_; }
  double* reaction(int r) { return reaction_.data() + static_cast<long>(r) * m_; }
  const double* reaction(int r) const { return reaction_.data() + static_cast<long>(r) * m_; }
  double mean_rate(const Place& f, int a, const double* v_new) const {
    return (1 - f.theta[a]) * f.y_old[a] + f.theta[a] * f.of(a).dot(v_new) -
           (f.theta[a] - 0.5) * h_ * f.gamma[a];
  }
  void set_theta(Place& f);
  static std::array<double, 2> resistance(const Place& f, double gap);
  void apply(double* v, double* lambda) const;

  std::vector<Place> films_;
  int n_, m_, used_ = 0;
  double h_ = 0;
  std::vector<double> response_, reaction_;  // A R and its multipliers, a column for each row
  Eigen::MatrixXd D_, K_, E_;
  DenseLu lu_, E_lu_;
  // m, displacement of normal and film rows; kg m, the vector along A R that produces it
  Eigen::VectorXd way_, beyond_;
  mutable Eigen::VectorXd rhs_, p_;
};

}  // namespace freeplay
