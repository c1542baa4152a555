#include "formulations/contact/finite_film.hpp"

#include <Eigen/LU>
#include <boost/math/quadrature/gauss.hpp>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numbers>
#include <utility>

#include "numerics/dual.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd;
constexpr double pi = std::numbers::pi;
constexpr double bend = 2;  // of u = ln(1 − ln(1 − ε)/bend)
const double last_u = std::log(1 - std::log(FiniteFilm::least_thickness) / bend);

/// Length (rad) of the narrowest gap.
template <class T>
T narrow(const T& epsilon) {
  using std::sqrt;
  return sqrt(2 * (1 - epsilon));
}

// Cubic B-splines on equal intervals, with continuous third derivatives at the second and the last but one
// point.

/// Coefficients of splines through each column.
MatrixXd spline_through(const MatrixXd& columns) {
  const auto n = columns.rows();
  MatrixXd A = MatrixXd::Zero(n + 2, n + 2), b = MatrixXd::Zero(n + 2, columns.cols());
  for (Eigen::Index i = 0; i < n; ++i) {
    A.row(i).segment(i, 3) << 1.0 / 6, 4.0 / 6, 1.0 / 6;
    b.row(i) = columns.row(i);
  }
  A.row(n).head(5) << 1, -4, 6, -4, 1;
  A.row(n + 1).tail(5) << 1, -4, 6, -4, 1;
  return A.partialPivLu().solve(b);
}

/// The interval of a place among n points, counted in intervals, and the weights of its coefficients.
template <class T>
struct Cell {
  int first;
  std::array<T, 4> weight;
  Cell(const T& place, int n) : first(std::clamp(static_cast<int>(std::floor(value_of(place))), 0, n - 2)) {
    const T s = place - static_cast<double>(first), r = 1 - s;
    weight = {r * r * r / 6, (4 + s * s * (3 * s - 6)) / 6, (4 + r * r * (3 * r - 6)) / 6, s * s * s / 6};
  }
};

template <class T>
Cell<T> cell_of(const T& epsilon, int n) {
  using std::log;
  return {log(1 - log(1 - epsilon) / bend) * ((n - 1) / last_u), n};
}

/// asinh, also of Dual numbers.
template <class T>
T area_sinh(const T& x) {
  using std::log, std::sqrt;
  return x < 0 ? -log(sqrt(x * x + 1) - x) : log(sqrt(x * x + 1) + x);
}

/// Half the circle, 0 ≤ θ ≤ π: points and finite volumes.
struct Circle {
  static constexpr int N = 384;
  std::vector<double> cosine, sine, cubed, weight, flow;  ///< cos θ, sin θ, H³, dθ; H³/dθ between points

  explicit Circle(double epsilon) {
    const double k = std::pow((1 - epsilon) / (1 + epsilon), 0.25), h = pi / N;
    const auto cosine_at = [k](double s) {  // tan(θ/2) = k tan(s/2)
      const double c = std::cos(s / 2), d = k * std::sin(s / 2);
      return (c * c - d * d) / (c * c + d * d);
    };
    const auto length_at = [k, h](double s) {
      const double c = std::cos(s / 2), d = k * std::sin(s / 2);
      return h * k / (c * c + d * d);
    };
    for (int i = 0; i <= N; ++i) {
      const double s = i * h, c = cosine_at(s), half = i == 0 || i == N ? 0.5 : 1;
      cosine.push_back(c);
      sine.push_back(i == 0 || i == N ? 0 : std::sqrt((1 - c) * (1 + c)));
      cubed.push_back(std::pow(1 - epsilon * c, 3));
      weight.push_back(half * length_at(s));
      if (i < N) flow.push_back(std::pow(1 - epsilon * cosine_at(s + h / 2), 3) / length_at(s + h / 2));
    }
  }

  /// P_m of λ for a source, which is cosine or sine.
  std::vector<double> mode(double lambda, const std::vector<double>& source) const {
    // The sine's P vanishes at both ends; the cosine's has no slope there.
    const bool odd = &source == &sine;
    const int first = odd ? 1 : 0, last = odd ? N - 1 : N;
    std::vector<double> P(N + 1), upper(N + 1);
    for (int i = first; i <= last; ++i) {  // Thomas's algorithm
      const double below = i > 0 ? flow[i - 1] : 0, above = i < N ? flow[i] : 0;
      const double diagonal = below + above + lambda * lambda * cubed[i] * weight[i];
      const double pivot = diagonal - (i > first ? below * upper[i - 1] : 0);
      upper[i] = above / pivot;
      P[i] = (source[i] * weight[i] + (i > first ? below * P[i - 1] : 0)) / pivot;
    }
    for (int i = last - 1; i >= first; --i) P[i] += upper[i] * P[i + 1];
    return P;
  }
};

/// Pressures by w_r and by w_t at the places ζ of Gauss's rule, at one ε.
class Pressures {
 public:
  Pressures(double epsilon, double length) : circle_(epsilon) {
    using Rule = boost::math::quadrature::gauss<double, 20>;  // abscissas > 0
    const double lengths = length / narrow(epsilon);
    const int modes = std::min(96, 8 + static_cast<int>(std::ceil(4 * lengths / pi)));
    for (std::size_t k = 0; k < Rule::abscissa().size(); ++k) {
      const double z = length * Rule::abscissa()[k];
      axial_.push_back(2 * length * Rule::weights()[k]);
      short_.push_back(0.5 * (length * length - z * z));
      for (const int s : {0, 1}) {
        auto& P = at_[s].emplace_back(Circle::N + 1);
        for (int i = 0; i <= Circle::N; ++i) P[i] = short_.back() * source(s)[i] / circle_.cubed[i];
      }
    }
    short_total_ = 2.0 / 3 * length * length * length;
    for (const int s : {0, 1})
      for (int i = 0; i <= Circle::N; ++i)
        short_full_[s] +=
            2 * short_total_ * circle_.weight[i] * source(s)[i] * source(s)[i] / circle_.cubed[i];
    full_ = short_full_;
    for (int m = 1; m <= modes; ++m) {
      const double lambda = (2 * m - 1) * pi / (2 * length), share = (m % 2 ? 4 : -4) / ((2 * m - 1) * pi);
      for (const int s : {0, 1}) {
        auto P = circle_.mode(lambda, source(s));
        for (int i = 0; i <= Circle::N; ++i) {
          P[i] -= source(s)[i] / (lambda * lambda * circle_.cubed[i]);
          full_[s] += 2 * 8 / ((2 * m - 1) * pi * lambda) * circle_.weight[i] * source(s)[i] * P[i];
        }
        for (std::size_t k = 0; k < at_[s].size(); ++k) {
          const double here = share * std::cos(lambda * length * Rule::abscissa()[k]);
          for (int i = 0; i <= Circle::N; ++i) at_[s][k][i] += here * P[i];
        }
      }
    }
  }

  std::array<double, 2> full_ratios() const { return {full_[0] / short_full_[0], full_[1] / short_full_[1]}; }
  /// Ratios of the cavitated film.
  std::array<double, 2> cavitated_ratios(double cosine) const {
    // G_t/sin α has a limit at both ends.
    const double sine = std::max(1e-4, std::sqrt((1 - cosine) * (1 + cosine)));
    std::array<double, 2> G{}, plain{};
    for (std::size_t k = 0; k < axial_.size(); ++k)
      add_positive(at_[0][k], at_[1][k], cosine, sine, axial_[k], G);
    std::vector<double> c(Circle::N + 1), s(Circle::N + 1);
    for (int i = 0; i <= Circle::N; ++i) {
      c[i] = circle_.cosine[i] / circle_.cubed[i];
      s[i] = circle_.sine[i] / circle_.cubed[i];
    }
    add_positive(c, s, cosine, sine, short_total_, plain);
    const double scale = std::hypot(plain[0], plain[1]);
    return {G[0] / scale, G[1] / (scale * sine)};
  }

 private:
  const std::vector<double>& source(int s) const { return s == 0 ? circle_.cosine : circle_.sine; }

  /// Adds ∫ n P dθ over P > 0, P = cos α even + sin α odd, times a factor.
  void add_positive(const std::vector<double>& even, const std::vector<double>& odd, double cosine,
                    double sine, double factor, std::array<double, 2>& G) const {
    double radial = 0, tangential = 0;
    for (const double side : {1.0, -1.0}) {
      const auto at = [&](int i) { return cosine * even[i] + side * sine * odd[i]; };
      const auto add = [&](int i, double P, double share) {
        // Weights at both ends of the half circle have their half already.
        const double f = (i == 0 || i == Circle::N ? 1 : 0.5) * share * P * circle_.weight[i];
        radial += f * circle_.cosine[i];
        tangential += side * f * circle_.sine[i];
      };
      double a = at(0);
      for (int i = 0; i < Circle::N; ++i) {
        const double b = at(i + 1);
        if (a > 0) add(i, a, b > 0 ? 1 : a / (a - b));
        if (b > 0) add(i + 1, b, a > 0 ? 1 : b / (b - a));
        a = b;
      }
    }
    G[0] += factor * radial;
    G[1] += factor * tangential;
  }

  Circle circle_;
  std::vector<double> axial_, short_;
  double short_total_ = 0;                              // ∫ of the short bearing's profile over ζ
  std::array<std::vector<std::vector<double>>, 2> at_;  // of w_r and w_t, at each ζ
  std::array<double, 2> full_{}, short_full_{};
};

std::vector<double> stored(const MatrixXd& m) {  // row by row
  std::vector<double> list;
  for (Eigen::Index i = 0; i < m.rows(); ++i)
    for (Eigen::Index j = 0; j < m.cols(); ++j) list.push_back(m(i, j));
  return list;
}

}  // namespace

FiniteFilm::FiniteFilm(double length) {
  std::array<MatrixXd, 2> full{MatrixXd(ratios, 1), MatrixXd(ratios, 1)};
  std::array<MatrixXd, 2> part{MatrixXd(ratios, directions), MatrixXd(ratios, directions)};
  for (int i = 0; i < ratios; ++i) {
    const double epsilon = -std::expm1(-bend * std::expm1(last_u * i / (ratios - 1)));
    const double delta = narrow(epsilon), span = std::asinh(1 / delta);
    const Pressures pressures(epsilon, length);
    const auto all = pressures.full_ratios();
    for (const int s : {0, 1}) full[s](i, 0) = all[s];
    for (int j = 0; j < directions; ++j) {
      const double place = 2.0 * j / (directions - 1) - 1;
      const auto some = pressures.cavitated_ratios(std::clamp(delta * std::sinh(place * span), -1.0, 1.0));
      for (const int s : {0, 1}) part[s](i, j) = some[s];
    }
  }
  for (const int s : {0, 1}) {
    full_[s] = stored(spline_through(full[s]));
    cavitated_[s] = stored(spline_through(spline_through(part[s]).transpose()).transpose());
  }
}

template <class T>
std::array<T, 2> FiniteFilm::full(const T& epsilon) const {
  const auto u = cell_of(epsilon, ratios);
  std::array<T, 2> found{};
  for (const int s : {0, 1})
    for (int i = 0; i < 4; ++i) found[s] += full_[s][u.first + i] * u.weight[i];
  return found;
}

template <class T>
std::array<T, 2> FiniteFilm::cavitated(const T& epsilon, const T& cosine) const {
  const T delta = narrow(epsilon);
  const auto u = cell_of(epsilon, ratios);
  const Cell<T> v((area_sinh(T(cosine / delta)) / area_sinh(T(1 / delta)) + 1) * (0.5 * (directions - 1)),
                  directions);
  std::array<T, 2> found{};
  for (const int s : {0, 1})
    for (int i = 0; i < 4; ++i) {
      T sum = 0;
      for (int j = 0; j < 4; ++j)
        sum += cavitated_[s][(u.first + i) * (directions + 2) + v.first + j] * v.weight[j];
      found[s] += sum * u.weight[i];
    }
  return found;
}

template std::array<double, 2> FiniteFilm::full(const double&) const;
template std::array<Dual<4>, 2> FiniteFilm::full(const Dual<4>&) const;
template std::array<double, 2> FiniteFilm::cavitated(const double&, const double&) const;
template std::array<Dual<4>, 2> FiniteFilm::cavitated(const Dual<4>&, const Dual<4>&) const;

std::shared_ptr<const FiniteFilm> finite_film(double length) {
  constexpr std::size_t most = 32;  // of 35 kB each
  static std::mutex mutex;
  static std::vector<std::pair<double, std::shared_ptr<const FiniteFilm>>> kept;
  const std::scoped_lock lock(mutex);
  for (const auto& [of, film] : kept)
    if (of == length) return film;
  if (kept.size() == most) kept.erase(kept.begin());
  return kept.emplace_back(length, std::make_shared<const FiniteFilm>(length)).second;
}

}  // namespace freeplay
