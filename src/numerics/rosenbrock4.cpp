#include "numerics/rosenbrock4.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "numerics/dense.hpp"

namespace freeplay {
namespace {

constexpr int stages = 6;
/// γ, and of stage s: y = x + Σ a_sk g_k at t + time_s h, and
///     (1/(γh) − J) g_s = f(y) + h d_s ∂f/∂t + Σ c_sk g_k/h.
/// The last stage starts at the end of the fifth and is the error. d is the sum of each row of the
/// method's γ_ij. Boost 1.74 has the fourth entry with the wrong sign;
/// verification/property/order/smooth_order_test.cpp verifies the order.
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

/// Solves (s − J) g = b, s = 1/(γh). Two kinds of unknowns need no factorisation:
///
///     others     columns of zeros in J, such as works and impulses, on which no right-hand side depends:
///                g_i = (b_i + J_i g)/s
///     integrals  dx_i/dt = x_j, such as coordinates: g_i = (b_i + g_j)/s
struct Rosenbrock4::Storage {
  struct Integral {
    Eigen::Index i, j;
    int column;  // of j in the matrix
  };
  Eigen::MatrixXd jacobian, matrix;
  DenseLu factors;
  Eigen::VectorXd dfdt, y, b, part, x;
  std::array<Eigen::VectorXd, stages> g;
  std::vector<Eigen::Index> kept, others;
  std::vector<Integral> integrals;
  std::vector<int> kind;           // −1: of the others, −2: an integral, else the place in kept
  std::vector<int> entries;        // of each row
  std::vector<Eigen::Index> only;  // the last one
  double diagonal_entry = 1;

  void divide();
  void factorise(double s);
  void solve(Eigen::VectorXd& out);  ///< Changes b.
};

/// Sorts the unknowns by the entries of J.
void Rosenbrock4::Storage::divide() {
  const auto size = jacobian.cols();
  std::ranges::fill(kind, -1);
  std::ranges::fill(entries, 0);
  for (Eigen::Index c = 0; c < size; ++c)
    for (Eigen::Index r = 0; r < size; ++r) {
      if (jacobian(r, c) == 0) continue;
      const auto row = static_cast<std::size_t>(r);
      kind[static_cast<std::size_t>(c)] = 0;
      ++entries[row];
      only[row] = c;
    }
  kept.clear();
  others.clear();
  integrals.clear();
  for (std::size_t i = 0; i < kind.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i), j = only[i];
    if (kind[i] == -1) {
      others.push_back(row);
    } else if (kind[i] == 0 && entries[i] == 1 && j != row && kind[static_cast<std::size_t>(j)] >= 0 &&
               jacobian(row, j) == 1) {
      integrals.push_back({row, j, 0});
      kind[i] = -2;
      kind[static_cast<std::size_t>(j)] = 1;  // it is no integral itself
    }
  }
  for (std::size_t i = 0; i < kind.size(); ++i) {
    if (kind[i] < 0) continue;
    kind[i] = static_cast<int>(kept.size());
    kept.push_back(static_cast<Eigen::Index>(i));
  }
  for (auto& one : integrals) one.column = kind[static_cast<std::size_t>(one.j)];
  const auto unknowns = static_cast<Eigen::Index>(kept.size());
  if (part.size() == unknowns) return;
  matrix.resize(unknowns, unknowns);
  part.resize(unknowns);
  x.resize(unknowns);
}

void Rosenbrock4::Storage::factorise(double s) {
  diagonal_entry = s;
  for (Eigen::Index c = 0; c < matrix.cols(); ++c) {
    const double* column = jacobian.col(kept[static_cast<std::size_t>(c)]).data();
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      matrix(r, c) = -column[kept[static_cast<std::size_t>(r)]];
    matrix(c, c) += s;
  }
  for (const auto& one : integrals) {
    const double* column = jacobian.col(one.i).data();
    for (Eigen::Index r = 0; r < matrix.rows(); ++r)
      matrix(r, one.column) -= column[kept[static_cast<std::size_t>(r)]] / s;
  }
  factors.compute(matrix);
}

void Rosenbrock4::Storage::solve(Eigen::VectorXd& out) {
  const double s = diagonal_entry;
  if (!kept.empty()) {
    for (Eigen::Index r = 0; r < part.size(); ++r) part[r] = b[kept[static_cast<std::size_t>(r)]];
    for (const auto& one : integrals) {
      const double* column = jacobian.col(one.i).data();
      const double share = b[one.i] / s;
      for (Eigen::Index r = 0; r < part.size(); ++r)
        part[r] += column[kept[static_cast<std::size_t>(r)]] * share;
    }
    factors.solve(part, x);
    for (Eigen::Index r = 0; r < part.size(); ++r) out[kept[static_cast<std::size_t>(r)]] = x[r];
  }
  for (const auto& one : integrals) out[one.i] = (b[one.i] + out[one.j]) / s;
  const auto add = [&](Eigen::Index i) {
    const double* column = jacobian.col(i).data();
    for (const auto r : others) b[r] += column[r] * out[i];
  };
  for (const auto i : kept) add(i);
  for (const auto& one : integrals) add(one.i);
  for (const auto r : others) out[r] = b[r] / s;
}

Rosenbrock4::Rosenbrock4(int size) : storage_(std::make_unique<Storage>()) {
  auto& s = *storage_;
  for (auto* matrix : {&s.jacobian, &s.matrix}) matrix->resize(size, size);
  s.factors.compute(Eigen::MatrixXd::Identity(size, size));
  for (auto* v : {&s.dfdt, &s.y, &s.b, &s.part, &s.x}) v->resize(size);
  const auto places = static_cast<std::size_t>(size);
  for (auto* list : {&s.kept, &s.others}) list->reserve(places);
  s.integrals.reserve(places);
  s.kind.resize(places);
  s.entries.resize(places);
  s.only.resize(places);
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
      p.jacobian(p.context, x, t, s.jacobian.data(), s.dfdt.data());
      s.divide();
      s.factorise(1 / (diagonal * h));
    }
    if (d[k] != 0) s.b += h * d[k] * s.dfdt;
    for (int i = 0; i < k; ++i) s.b += c[k][i] / h * s.g[i];
    s.solve(s.g[k]);
  }
  Eigen::Map<Eigen::VectorXd>(x_new, n) = s.y + s.g[stages - 1];
  Eigen::Map<Eigen::VectorXd>(error, n) = s.g[stages - 1];
}

bool Rosenbrock4::damps_growth() const {
  // The determinant of 4/h − J, reduced to the retained unknowns by positive factors
  return !storage_->kept.empty() && storage_->factors.sign() < 0;
}

}  // namespace freeplay
