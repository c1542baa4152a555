// A right-hand side in units of its error scales, for methods whose error control has a single
// absolute tolerance.
#pragma once

#include "formulations/integrators/methods.hpp"

namespace freeplay {

/// Components without a scale have
/// units so large that their error never counts.
class ScaledSide {
 public:
  explicit ScaledSide(ErrorNorm norm) : norm_(std::move(norm)) {}
  /// Sets the scales at a state: absolute_i + relative_i |x_i|.
  void measure(const Vector& x) {
    constexpr double unmeasured = 1e9;
    scale_.assign(x.size(), unmeasured);
    for (std::size_t i = 0; i < norm_.absolute.size(); ++i)
      if (std::isfinite(norm_.absolute[i]))
        scale_[i] = norm_.absolute[i] + norm_.relative[i] * std::abs(x[i]);
    x_.resize(x.size());
    dxdt_.resize(x.size());
  }
  void to_scaled(const Vector& x, Vector& y) const {
    for (std::size_t i = 0; i < x.size(); ++i) y[i] = x[i] / scale_[i];
  }
  void from_scaled(const Vector& y, Vector& x) const {
    for (std::size_t i = 0; i < x.size(); ++i) x[i] = y[i] * scale_[i];
  }
  template <class F>
  void evaluate(F& f, const Vector& y, Vector& dydt, double t) {
    from_scaled(y, x_);
    f(x_, dxdt_, t);
    to_scaled(dxdt_, dydt);
  }
  /// The derivative of the last evaluation, in the units of x.
  const Vector& last() const { return dxdt_; }
  const Vector& scale() const { return scale_; }
  double tolerance() const { return norm_.tolerance; }
  /// Only the scales of the last start are serialized. `size`: of a state.
  template <class M>
  void serialize(M& m, std::size_t size) {
    m(scale_);
    if constexpr (M::reading) {
      if (!scale_.empty() && scale_.size() != size)
        throw MemoryError("the snapshot's integrator has another size, or is damaged");
      x_.resize(size);
      dxdt_.resize(size);
    }
  }

 private:
  ErrorNorm norm_;
  Vector scale_, x_, dxdt_;
};

}  // namespace freeplay
