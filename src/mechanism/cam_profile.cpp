#include "mechanism/cam_profile.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

namespace freeplay {
namespace {

/// Solves a_i x_{i−1} + b_i x_i + c_i x_{i+1} = r_i with cyclic indices, by the Sherman–Morrison
/// correction of the tridiagonal system.
std::vector<double> solve_cyclic(const std::vector<double>& a, const std::vector<double>& b,
                                 const std::vector<double>& c, const std::vector<double>& r) {
  const std::size_t n = b.size();
  const auto tridiagonal = [&](std::vector<double> d, std::vector<double> x) {
    for (std::size_t i = 1; i < n; ++i) {
      const double w = a[i] / d[i - 1];
      d[i] -= w * c[i - 1];
      x[i] -= w * x[i - 1];
    }
    x[n - 1] /= d[n - 1];
    for (std::size_t i = n - 1; i-- > 0;) x[i] = (x[i] - c[i] * x[i + 1]) / d[i];
    return x;
  };
  const double corner = c[n - 1], other = a[0], g = -b[0];
  auto d = b;
  d[0] -= g;
  d[n - 1] -= corner * other / g;
  std::vector<double> u(n, 0);
  u[0] = g;
  u[n - 1] = corner;
  const auto x = tridiagonal(d, r), z = tridiagonal(d, u);
  const double share = (x[0] + other * x[n - 1] / g) / (1 + z[0] + other * z[n - 1] / g);
  auto sum = x;
  for (std::size_t i = 0; i < n; ++i) sum[i] -= share * z[i];
  return sum;
}

}  // namespace

CamProfile::PieceOf<Traced> CamProfile::piece(const Traced& i) const {
  const auto entry = [&](auto member) {
    return entry_of(pieces_.size(), i, [&](std::size_t k) { return member(pieces_[k]); });
  };
  PieceOf<Traced> p;
  p.begin = entry([](const Piece& x) { return x.begin; });
  p.width = entry([](const Piece& x) { return x.width; });
  for (std::size_t n = 0; n < std::size(p.c); ++n) p.c[n] = entry([n](const Piece& x) { return x.c[n]; });
  p.A = entry([](const Piece& x) { return x.A; });
  p.B = entry([](const Piece& x) { return x.B; });
  p.w = entry([](const Piece& x) { return x.w; });
  return p;
}

/// A rise over the width, or a return: the same with u → width − u.
CamProfile::Piece CamProfile::ramp(CamLaw law, double lift, double begin, double width, bool down) {
  Piece p;
  p.begin = begin;
  p.width = width;
  const double sign = down ? -1 : 1;
  // Each law is odd about its middle, so a return is the lift minus a rise.
  p.c[0] = down ? lift : 0;
  switch (law) {
    case CamLaw::harmonic:
      p.c[0] += 0.5 * sign * lift;
      p.A = -0.5 * sign * lift;
      p.w = std::numbers::pi / width;
      break;
    case CamLaw::cycloidal:
      p.c[1] = sign * lift / width;
      p.B = -sign * lift / (2 * std::numbers::pi);
      p.w = 2 * std::numbers::pi / width;
      break;
    case CamLaw::polynomial:
      p.c[3] = 10 * sign * lift / std::pow(width, 3);
      p.c[4] = -15 * sign * lift / std::pow(width, 4);
      p.c[5] = 6 * sign * lift / std::pow(width, 5);
      break;
  }
  return p;
}

CamProfile CamProfile::standard(CamLaw law, double lift, double start, double rise, double dwell,
                                double fall) {
  CamProfile profile;
  auto& list = profile.pieces_;
  const auto flat = [&](double begin, double width, double height) {
    if (!(width > 1e-12)) return;
    Piece p;
    p.begin = begin;
    p.width = width;
    p.c[0] = height;
    list.push_back(p);
  };
  list.push_back(ramp(law, lift, start, rise, false));
  flat(start + rise, dwell, lift);
  list.push_back(ramp(law, lift, start + rise + dwell, fall, true));
  flat(start + rise + dwell + fall, turn - rise - dwell - fall, 0);
  profile.narrowest_ = std::min(rise, fall);
  profile.finish();
  return profile;
}

CamProfile CamProfile::through(const std::vector<std::pair<double, double>>& points) {
  CamProfile profile;
  const std::size_t n = points.size();
  std::vector<double> width(n), a(n), b(n), c(n), r(n);
  const auto y = [&](std::size_t i) { return points[i % n].second; };
  for (std::size_t i = 0; i < n; ++i)
    width[i] = points[(i + 1) % n].first - points[i].first + (i + 1 == n ? turn : 0);
  for (std::size_t i = 0; i < n; ++i) {
    const double before = width[(i + n - 1) % n];
    a[i] = before;
    b[i] = 2 * (before + width[i]);
    c[i] = width[i];
    r[i] = 6 * ((y(i + 1) - y(i)) / width[i] - (y(i) - y(i + n - 1)) / before);
  }
  const auto bend = solve_cyclic(a, b, c, r);
  for (std::size_t i = 0; i < n; ++i) {
    Piece p;
    p.begin = points[i].first;
    p.width = width[i];
    const double m0 = bend[i], m1 = bend[(i + 1) % n], w = width[i];
    p.c[0] = y(i);
    p.c[1] = (y(i + 1) - y(i)) / w - w * (2 * m0 + m1) / 6;
    p.c[2] = 0.5 * m0;
    p.c[3] = (m1 - m0) / (6 * w);
    profile.pieces_.push_back(p);
    profile.narrowest_ = std::min(profile.narrowest_, w);
  }
  profile.finish();
  auto& thirds = profile.thirds_;
  thirds.emplace_back();
  for (const auto& p : profile.pieces_) thirds[0].push_back(std::abs(6 * p.c[3]));
  for (std::size_t span = 1; 2 * span <= n; span *= 2) {
    const auto& half = thirds.back();
    std::vector<double> whole(n);
    for (std::size_t i = 0; i < n; ++i) whole[i] = std::max(half[i], half[(i + span) % n]);
    thirds.push_back(std::move(whole));
  }
  return profile;
}

double CamProfile::greatest_third(double a, double b) const {
  const auto n = pieces_.size();
  const double first = pieces_.front().begin;
  const auto inside = [&](double x) { return x - turn * std::floor((x - first) / turn); };
  const double from = inside(a), to = inside(b);
  const auto i = index_at(from), j = index_at(to);
  const bool all = b - a >= turn / 2 || (i == j && from > to);
  const auto count = all ? n : (j + n - i) % n + 1;
  const auto level = static_cast<std::size_t>(std::bit_width(count)) - 1;
  const auto& list = thirds_[level];
  return std::max(list[i], list[(i + count - (std::size_t{1} << level)) % n]);
}

/// Bounds: the greatest sample plus half a spacing times the greatest next derivative.
void CamProfile::finish() {
  for (const auto& p : pieces_) {
    const double w = p.w, spacing = p.width / samples();
    double third = w * w * w * std::hypot(p.A, p.B);
    third += std::abs(6 * p.c[3]) + p.width * (std::abs(24 * p.c[4]) + p.width * std::abs(60 * p.c[5]));
    double d1 = 0, d2 = 0;
    for (int i = 0; i <= samples(); ++i) {
      const auto y = value(p, spacing * i);
      d1 = std::max(d1, std::abs(y.d1));
      d2 = std::max(d2, std::abs(y.d2));
    }
    d2 += 0.5 * spacing * third;
    d1 += 0.5 * spacing * d2;
    bounds_.d1 = std::max(bounds_.d1, d1);
    bounds_.d2 = std::max(bounds_.d2, d2);
  }
}

}  // namespace freeplay
