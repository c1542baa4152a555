// The method of Adams against Boost.Odeint's stepper of the same method, bit for bit: orders, rejected
// steps and restarts included. The reference steps in units of its error scales, as Adams does.
#include "formulations/integrators/adams.hpp"

#include <catch2/catch.hpp>

#include <boost/numeric/odeint/stepper/adaptive_adams_bashforth_moulton.hpp>
#include <boost/numeric/odeint/stepper/controlled_adams_bashforth_moulton.hpp>
#include <cmath>
#include <set>

using namespace freeplay;

namespace {

/// A chain of n oscillators of the first order, driven, and stiffer in every other interval of time.
struct OscillatorChain {
  bool stiff = false;
  long calls = 0;
  void operator()(const Vector& x, Vector& dxdt, double t) {
    ++calls;
    const std::size_t n = x.size();
    for (std::size_t i = 0; i < n; ++i) {
      const double left = i > 0 ? x[i - 1] : std::sin(3 * t), right = i + 1 < n ? x[i + 1] : 0;
      dxdt[i] = left - right - 0.1 * x[i] * x[i] * x[i] - (stiff ? 30 * x[i] : 0);
    }
  }
};

/// Step control as Adams has it, in the interface of Odeint.
struct OdeintAdjuster {
  double tolerance;
  double adjust_stepsize(std::size_t order, double h, const Vector& error, const Vector&,
                         const Vector&) const {
    constexpr double refused = 1e10;
    double ratio = 0;
    for (const double e : error) {
      const double share = std::abs(e) / tolerance;
      ratio = share < refused ? std::max(ratio, share) : refused;
      if (!(share < refused)) break;
    }
    const double factor = 0.9 * std::pow(ratio, -1.0 / (static_cast<double>(order) + 1));
    return h * std::min(ratio <= 1 ? std::max(1.0, 0.9 * factor) : factor, 2.0);
  }
  static double threshold() { return 0.9; }
};

class OdeintReference {
 public:
  OdeintReference(const ErrorNorm& norm, double first)
      : norm_(norm), stepper_({norm.tolerance}), dt_(first) {}
  void restart(const Vector& x, double t, double h) {
    x_ = x;
    t_ = t;
    dt_ = h;
    scale_.assign(x.size(), 1e9);
    for (std::size_t i = 0; i < norm_.absolute.size(); ++i)
      scale_[i] = norm_.absolute[i] + norm_.relative[i] * std::abs(x[i]);
    y_.resize(x.size());
    y_new_.resize(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) y_[i] = x[i] / scale_[i];
    stepper_.reset();
  }
  void step(OscillatorChain& f) {
    const auto scaled = [&](const Vector& y, Vector& dydt, double t) {
      Vector x(y.size()), slope(y.size());
      for (std::size_t i = 0; i < y.size(); ++i) x[i] = y[i] * scale_[i];
      f(x, slope, t);
      for (std::size_t i = 0; i < y.size(); ++i) dydt[i] = slope[i] / scale_[i];
    };
    while (stepper_.try_step(scaled, y_, t_, y_new_, dt_) != boost::numeric::odeint::success) ++rejected;
    std::swap(y_, y_new_);
    for (std::size_t i = 0; i < x_.size(); ++i) x_[i] = y_[i] * scale_[i];
  }
  double t() const { return t_; }
  double next() const { return dt_; }
  const Vector& x() const { return x_; }
  long rejected = 0;

 private:
  using Table = boost::numeric::odeint::adaptive_adams_bashforth_moulton<8, Vector>;
  ErrorNorm norm_;
  boost::numeric::odeint::controlled_adams_bashforth_moulton<Table, OdeintAdjuster> stepper_;
  double t_ = 0, dt_;
  Vector scale_, x_, y_, y_new_;
};

}  // namespace

TEST_CASE("the method of Adams has the digits of Odeint's stepper", "[integrators]") {
  // Numbers of components with and without a rest beside groups of two and four.
  for (const std::size_t n : {1u, 2u, 3u, 4u, 5u, 26u, 27u})
    for (const double tolerance : {1e-5, 1e-9}) {
      ErrorNorm norm;
      norm.tolerance = tolerance;
      norm.absolute.assign(n < 5 ? n : n - 2, 0.5);  // the last ones have no error control
      norm.relative.assign(norm.absolute.size(), 1);
      const double first = 1e-4;
      OscillatorChain f, g;
      Adams method(norm, first);
      OdeintReference reference(norm, first);
      Vector x(n);
      for (std::size_t i = 0; i < n; ++i) x[i] = std::cos(static_cast<double>(i));
      method.start(f, 0, x);
      reference.restart(x, 0, first);
      std::set<double> lengths;
      long differing = 0;
      for (int step = 1; step <= 900; ++step) {
        if (step % 150 == 0) {  // an event: another right-hand side and a new history
          f.stiff = g.stiff = !f.stiff;
          const double h = std::min(1e-2 * reference.next(), first);
          method.limit_step(INFINITY);
          reference.restart(reference.x(), reference.t(), h);
        }
        CAPTURE(n, tolerance, step, method.t, method.x, reference.t(), differing);
        REQUIRE(method.step(f, 1e9));
        reference.step(g);
        differing += method.x != reference.x() || method.t != reference.t();
        lengths.insert(method.t - method.t_old);
      }
      CAPTURE(n, tolerance, method.t, method.rejected);
      CHECK(differing == 0);
      CHECK(method.rejected == reference.rejected);
      CHECK(method.rejected > 5);
      CHECK(lengths.size() > 50);
      CHECK(f.calls == g.calls + 1);  // start() evaluates as well
    }
}
