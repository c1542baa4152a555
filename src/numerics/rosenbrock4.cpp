// Compiled as C++17 (see the header).
#include "numerics/rosenbrock4.hpp"

#include <algorithm>
#include <boost/numeric/odeint/stepper/rosenbrock4.hpp>
#include <vector>

namespace freeplay {
namespace {

/// Boost 1.74 has d4 with the wrong sign, which makes the method one of first order whenever the right-hand
/// side depends on time. d4 is the sum of the fourth row of the method's matrix γ_ij, as d1 to d3 are of
/// theirs; verification/order/smooth_order_test.cpp has the order.
struct Coefficients : boost::numeric::odeint::default_rosenbrock_coefficients<double> {
  const double d4 = -0.3620000000000023e-01;
};

}  // namespace

struct Rosenbrock4::Storage {
  using Stepper = boost::numeric::odeint::rosenbrock4<double, Coefficients>;
  Stepper stepper;
  Stepper::state_type x, x_new, error;
  std::vector<double> jacobian;
};

Rosenbrock4::Rosenbrock4(int size) : storage_(std::make_unique<Storage>()) {
  const auto n = static_cast<std::size_t>(size);
  for (auto* v : {&storage_->x, &storage_->x_new, &storage_->error}) v->resize(n, false);
  storage_->jacobian.resize(n * n);
}
Rosenbrock4::~Rosenbrock4() = default;
Rosenbrock4::Rosenbrock4(const Rosenbrock4& other)
    : Rosenbrock4(static_cast<int>(other.storage_->jacobian.empty() ? 0 : other.storage_->x.size())) {}
Rosenbrock4& Rosenbrock4::operator=(const Rosenbrock4& other) { return *this = Rosenbrock4(other); }
Rosenbrock4::Rosenbrock4(Rosenbrock4&&) noexcept = default;
Rosenbrock4& Rosenbrock4::operator=(Rosenbrock4&&) noexcept = default;

void Rosenbrock4::step(const Problem& p, const double* x, double t, double h, double* x_new, double* error) {
  auto& s = *storage_;
  const auto side = [&](const auto& y, auto& dydt, double at) { p.side(p.context, &y[0], &dydt[0], at); };
  const auto jacobian = [&](const auto& y, auto& J, double at, auto& dfdt) {
    p.jacobian(p.context, &y[0], at, s.jacobian.data(), &dfdt[0]);
    const std::size_t n = y.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) J(i, j) = s.jacobian[j * n + i];
  };
  std::copy(x, x + s.x.size(), s.x.begin());
  s.stepper.do_step(std::make_pair(side, jacobian), s.x, t, s.x_new, h, s.error);
  std::copy(s.x_new.begin(), s.x_new.end(), x_new);
  std::copy(s.error.begin(), s.error.end(), error);
}

}  // namespace freeplay
