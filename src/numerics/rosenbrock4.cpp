#include "numerics/rosenbrock4.hpp"

#include <array>

#include "numerics/dense.hpp"

namespace freeplay {
namespace {

constexpr int stages = 6;
/// γ, and of stage s: y = x + Σ a_sk g_k at t + time_s h, and
///     (1/(γh) − J) g_s = f(y) + h d_s ∂f/∂t + Σ c_sk g_k/h.
/// The last stage starts at the end of the fifth and is the error. d is the sum of each row of the
/// method's γ_ij. Boost 1.74 has the fourth entry with the wrong sign;
/// verification/order/smooth_order_test.cpp verifies the order.
constexpr double diagonal = 0.25;
constexpr std::array<double, stages> time{0, 0.386, 0.21, 0.63, 1, 1};
constexpr std::array<double, stages> d{0.25, -0.1043, 0.1035, -0.3620000000000023e-01, 0, 0};
constexpr double a[stages][stages - 1] = {
    {},
    {0.1544000000000000e+01},
    {0.9466785280815826e+00, 0.2557011698983284e+00},
    {0.3314825187068521e+01, 0.2896124015972201e+01, 0.9986419139977817e+00},
    {0.1221224509226641e+01, 0.6019134481288629e+01, 0.1253708332932087e+02, -0.6878860361058950e+00},
    {0.1221224509226641e+01, 0.6019134481288629e+01, 0.1253708332932087e+02, -0.6878860361058950e+00, 1}};
constexpr double c[stages][stages - 1] = {
    {},
    {-0.5668800000000000e+01},
    {-0.2430093356833875e+01, -0.2063599157091915e+00},
    {-0.1073529058151375e+00, -0.9594562251023355e+01, -0.2047028614809616e+02},
    {0.7496443313967647e+01, -0.1024680431464352e+02, -0.3399990352819905e+02, 0.1170890893206160e+02},
    {0.8083246795921522e+01, -0.7981132988064893e+01, -0.3152159432874371e+02, 0.1631930543123136e+02,
     -0.6058818238834054e+01}};

}  // namespace

struct Rosenbrock4::Storage {
  Eigen::MatrixXd matrix;
  DenseLu factors;
  Eigen::VectorXd dfdt, y, b;
  std::array<Eigen::VectorXd, stages> g;
};

Rosenbrock4::Rosenbrock4(int size) : storage_(std::make_unique<Storage>()) {
  auto& s = *storage_;
  s.matrix.resize(size, size);
  s.factors.compute(Eigen::MatrixXd::Identity(size, size));
  for (auto* v : {&s.dfdt, &s.y, &s.b}) v->resize(size);
  for (auto& v : s.g) v.resize(size);
}
Rosenbrock4::~Rosenbrock4() = default;
Rosenbrock4::Rosenbrock4(const Rosenbrock4& other)
    : Rosenbrock4(static_cast<int>(other.storage_->y.size())) {}
Rosenbrock4& Rosenbrock4::operator=(const Rosenbrock4& other) { return *this = Rosenbrock4(other); }
Rosenbrock4::Rosenbrock4(Rosenbrock4&&) noexcept = default;
Rosenbrock4& Rosenbrock4::operator=(Rosenbrock4&&) noexcept = default;

void Rosenbrock4::step(const Problem& p, const double* x, double t, double h, double* x_new, double* error) {
  auto& s = *storage_;
  const Eigen::Index n = s.y.size();
  const Eigen::Map<const Eigen::VectorXd> start(x, n);
  for (int k = 0; k < stages; ++k) {
    s.y = start;
    for (int i = 0; i < k; ++i) s.y += a[k][i] * s.g[i];
    p.side(p.context, s.y.data(), s.b.data(), t + time[k] * h);
    if (k == 0) {
      p.jacobian(p.context, x, t, s.matrix.data(), s.dfdt.data());
      s.matrix *= -1;
      s.matrix.diagonal().array() += 1 / (diagonal * h);
      s.factors.compute(s.matrix);
    }
    if (d[k] != 0) s.b += h * d[k] * s.dfdt;
    for (int i = 0; i < k; ++i) s.b += c[k][i] / h * s.g[i];
    s.factors.solve(s.b, s.g[k]);
  }
  Eigen::Map<Eigen::VectorXd>(x_new, n) = s.y + s.g[stages - 1];
  Eigen::Map<Eigen::VectorXd>(error, n) = s.g[stages - 1];
}

}  // namespace freeplay
