#include "simulation/bearing_pressure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

using std::numbers::pi;

/// Σ (−1)^(k − first) c(k) t^(2k + 1) over k ≥ first, for t < 0.5: at most 30 terms.
template <class Coefficient>
double odd_series(double t, int first, Coefficient c) {
  double sum = 0, power = std::pow(t, 2 * first + 1);
  for (int k = first; k < first + 30; ++k, power *= -t * t) {
    const double term = power * c(k);
    sum += term;
    if (std::abs(term) < 1e-18 * sum) break;
  }
  return sum;
}
constexpr double tangent_series_below = 0.5;  // tan α

/// tan α for cos α = 1/(1 + δ).
double tangent(double depth) { return std::sqrt(depth * (2 + depth)); }

/// Values at equal angles over the turn, joined by the cubics of Catmull and Rom.
class Periodic {
 public:
  explicit Periodic(std::span<const double> values)
      : values_(values), size_(static_cast<long>(values.size())) {}
  bool empty() const { return values_.empty(); }
  double at(long k) const {
    while (k < 0) k += size_;
    while (k >= size_) k -= size_;
    return values_[static_cast<std::size_t>(k)];
  }
  /// Value and derivative by the angle (rad) at an angle.
  std::array<double, 2> at_angle(double angle) const {
    const double step = 2 * pi / static_cast<double>(size_);
    const double place = (angle - 2 * pi * std::floor(angle / (2 * pi))) / step, low = std::floor(place);
    const auto k = static_cast<long>(low);
    const double s = place - low, a = at(k - 1), b = at(k), c = at(k + 1), d = at(k + 2);
    const double c1 = 0.5 * (c - a), c2 = a - 2.5 * b + 2 * c - 0.5 * d, c3 = 0.5 * (d - a) + 1.5 * (b - c);
    return {b + s * (c1 + s * (c2 + s * c3)), (c1 + s * (2 * c2 + 3 * s * c3)) / step};
  }
  double least() const { return empty() ? 0 : *std::ranges::min_element(values_); }
  double greatest() const { return empty() ? 0 : *std::ranges::max_element(values_); }

 private:
  std::span<const double> values_;
  long size_;
};

/// The forces on the bearing at a position of the journal, and their derivatives by it.
struct Resultant {
  Vec2 force{};
  double xx = 0, xy = 0, yx = 0, yy = 0;
  double greatest = 0;
};

class JournalSearch {
 public:
  JournalSearch(const Foundation& foundation, std::span<const double> bearing,
                std::span<const double> journal, double turn, Pressure& out)
      : f_(foundation),
        bearing_(bearing),
        journal_(journal),
        count_(static_cast<long>(bearing.size())),
        step_(2 * pi / static_cast<double>(count_)),
        turn_(turn),
        floor_(f_.clearance + bearing_.least() - journal_.greatest()),
        out_(out),
        half_(out.halves),
        points_(out.points),
        nodes_(out.nodes) {
    for (std::size_t i = 0; i < gauss.size(); ++i)
      turned_[i] = {std::cos(step_ * gauss[i]), std::sin(step_ * gauss[i])};
    half_turned_ = {std::cos(0.5 * step_), std::sin(0.5 * step_)};
    out_.p.resize(bearing.size());
    if (nodes_.size() != bearing.size()) {
      nodes_.resize(bearing.size());
      for (std::size_t k = 0; k < nodes_.size(); ++k) {
        const double angle = step_ * static_cast<double>(k);
        nodes_[k] = {std::cos(angle), std::sin(angle)};
      }
    }
    half_.resize(bearing.size());
    points_.resize(bearing.size());
    for (long k = 0; k < count_; ++k)
      half_[static_cast<std::size_t>(k)] =
          (9 * (bearing_.at(k) + bearing_.at(k + 1)) - bearing_.at(k - 1) - bearing_.at(k + 2)) / 16;
  }

  /// Finds the position under `load`; `softness`: 1/K + s.
  void solve(const Vec2& load, double softness) {
    Vec2 x = out_.warm ? out_.centre : first(load, softness);
    if (descend(x, load, softness, 30, exact)) return;
    if (out_.warm && (x = first(load, softness), descend(x, load, softness, 30, exact))) return;
    // From a soft foundation, whose contact is wide, in steps to the given one.
    const double force = load.norm();
    double soft = std::max(softness, f_.length * f_.bearing_radius * f_.clearance / force);
    x = first(load, soft);
    for (;; soft = std::max(softness, soft / 4)) {
      if (!descend(x, load, soft, 200, rough))
        throw NoEquilibrium(fmt::format(
            "no position of the journal balances a load of {:.4g} N on its bearing: the foundation is too "
            "soft, or too stiff for the rounding of its deflection",
            force));
      if (soft <= softness) return;
    }
  }

 private:
  /// Accepted share of the load that is not balanced; rough: at corners of worn surfaces.
  static constexpr double exact = 1e-8, rough = 1e-3;
  static constexpr double root = 0.7745966692414834;  // √(3/5)
  static constexpr std::array gauss{0.5 - 0.5 * root, 0.5, 0.5 + 0.5 * root};
  static constexpr std::array weight{5.0 / 18, 8.0 / 18, 5.0 / 18};

  Vec2 node(long k) const { return nodes_[static_cast<std::size_t>((k % count_ + count_) % count_)]; }
  /// δ in the direction e, where the bearing deviates by d, and the derivative of δ by x × e.
  std::array<double, 2> depth(const Vec2& x, const Vec2& e, double angle, double deviation) const {
    const double across = cross(x, e), R = f_.journal_radius();
    std::array<double, 2> dev{0, 0};
    if (!journal_.empty()) dev = journal_.at_angle(angle + across / R - turn_);
    const double rho = R + dev[0], chord = std::sqrt(rho * rho - across * across);
    return {dot(x, e) - f_.clearance + dev[0] - deviation - across * across / (rho + chord),
            -across / chord + dev[1] / R};
  }

  /// A first position: that of rigid surfaces, and from there as deep in the direction of the load as in a
  /// round bearing.
  ///
  /// The rigid journal is at the greatest x·F with x·e ≤ g everywhere, a vertex of two directions a and b. In
  /// polar duality it is the edge of the convex hull of the points e/g that the ray along F crosses. g
  /// depends on x in second order and is therefore taken anew.
  Vec2 first(const Vec2& load, double softness) {
    const double force = load.norm();
    const Vec2 along = (1 / force) * load;
    const auto ahead = static_cast<long>(std::lround(std::atan2(load.y(), load.x()) / step_));
    Vec2 x{0, 0}, a, b;
    for (int pass = 0; pass < 3; ++pass) {
      for (long k = 0; k < count_; ++k) {
        const Vec2 e = node(k);
        const double gap = dot(x, e) - depth(x, e, step_ * static_cast<double>(k), bearing_.at(k))[0];
        points_[static_cast<std::size_t>(k)] = (1 / std::max(gap, 1e-6 * f_.clearance)) * e;
      }
      const auto point = [&](long k) {
        return points_[static_cast<std::size_t>((k % count_ + count_) % count_)];
      };
      a = point(ahead - count_ / 4), b = point(ahead + count_ / 4);
      for (bool beyond = true; beyond;) {  // the farthest point beyond the line from a to b
        const Vec2 line = b - a;
        double most = 1e-12 * line.norm() * a.norm();
        Vec2 far;
        beyond = false;
        for (const auto& p : points_)
          if (const double over = cross(p - a, line); over > most && dot(p, along) > 0)
            most = over, far = p, beyond = true;
        if (beyond) (cross(along, far) > 0 ? b : a) = far;
      }
      const double det = cross(a, b);  // x·a = x·b = 1
      x = (1 / det) * Vec2{b.y() - a.y(), a.x() - b.x()};
    }
    const double ratio = force * softness / (f_.length * f_.bearing_radius * f_.clearance);
    const double deep = f_.clearance * std::max(0.5 * std::pow(1.5 * ratio, 2.0 / 3), 2 / pi * ratio);
    const double slant =
        dot(a.direction(), b.direction());  // cos² of half the angle between both: (1 + slant)/2
    return x + (deep / std::sqrt(std::max(0.5 * (1 + slant), 0.05))) * along;
  }

  /// Newton's method with step halving on |F − load|. Returns whether it has converged; p is then that at x.
  bool descend(Vec2& x, const Vec2& load, double softness, int most, double accepted) {
    const double force = load.norm();
    auto now = resultant(x, softness);
    double error = (now.force - load).norm();
    for (int i = 0; i < most && error > 1e-10 * force; ++i) {
      const double det = now.xx * now.yy - now.xy * now.yx;
      if (!(std::abs(det) > 0)) break;
      const Vec2 r = load - now.force;
      const Vec2 step{(now.yy * r.x() - now.xy * r.y()) / det, (now.xx * r.y() - now.yx * r.x()) / det};
      bool better = false;
      for (double share = 1; share > 1e-9 && !better; share *= 0.5) {
        const Vec2 to = x + share * step;
        const auto next = resultant(to, softness);
        const double left = (next.force - load).norm();
        if (!(next.greatest > 0) || !(left < (1 - 1e-4 * share) * error)) continue;
        x = to, now = next, error = left, better = true;
      }
      if (!better) break;
    }
    // Of a small load the rounding of x limits the accuracy.
    const double rounding = 64 * std::numeric_limits<double>::epsilon() * x.norm() * (now.xx + now.yy);
    if (!(error < std::max(accepted * force, std::min(rounding, 0.1 * force)))) return false;
    keep(x, softness);
    return true;
  }

  void keep(const Vec2& x, double softness) {
    std::ranges::fill(out_.p, 0.0);
    out_.greatest = resultant<true>(x, softness).greatest;
    out_.centre = x;
    double sum = 0;
    for (const double p : out_.p) sum += p;
    out_.total = f_.length * f_.bearing_radius * step_ * sum;
  }

  template <bool kept = false>
  Resultant resultant(const Vec2& x, double softness) {
    Resultant sum;
    // δ ≤ |x| cos(φ − ψ) − floor
    const double far = x.norm();
    long from = 0, to = count_;
    if (floor_ > 0) {
      const double wide = std::acos(std::min(1.0, floor_ / far)), psi = std::atan2(x.y(), x.x());
      const auto low = static_cast<long>(std::floor((psi - wide) / step_)) - 1,
                 high = static_cast<long>(std::ceil((psi + wide) / step_)) + 1;
      if (high - low < count_) from = low, to = high;
    }
    const double scale = f_.length * f_.bearing_radius * step_;
    Vec2 e = node(from);
    auto left = depth(x, e, step_ * static_cast<double>(from), bearing_.at(from));
    for (long k = from; k < to; ++k) {
      const Vec2 next = node(k + 1);
      const double angle = step_ * static_cast<double>(k);
      const auto at = static_cast<std::size_t>((k % count_ + count_) % count_);
      const auto middle = depth(x, rotated(e, half_turned_), angle + 0.5 * step_, half_[at]);
      const auto right = depth(x, next, angle + step_, bearing_.at(k + 1));
      if (std::isnan(left[0] + middle[0] + right[0])) return {};
      const double bend = 2 * (left[0] - 2 * middle[0] + right[0]), rise = right[0] - left[0] - bend;
      const auto parabola = [&](double s) { return left[0] + s * (rise + s * bend); };
      for (const auto& [a, b] : positive_parts(left[0], rise, bend)) {
        if (!(b > a)) continue;
        for (std::size_t i = 0; i < gauss.size(); ++i) {
          const double s = a + (b - a) * gauss[i], p = std::max(0.0, parabola(s)) / softness;
          const Vec2 direction = a == 0 && b == 1 ? rotated(e, turned_[i])
                                                  : rotated(e, {std::cos(step_ * s), std::sin(step_ * s)});
          const double w = weight[i] * (b - a), area = scale * w;
          sum.force += (area * p) * direction;
          const double slope = std::lerp(left[1], right[1], s);
          const Vec2 by{direction.x() + slope * direction.y(), direction.y() - slope * direction.x()};
          sum.xx += area / softness * direction.x() * by.x();
          sum.xy += area / softness * direction.x() * by.y();
          sum.yx += area / softness * direction.y() * by.x();
          sum.yy += area / softness * direction.y() * by.y();
          sum.greatest = std::max(sum.greatest, p);
          if constexpr (kept) {
            out_.p[at] += w * p * (1 - s);
            out_.p[at + 1 == out_.p.size() ? 0 : at + 1] += w * p * s;
          }
        }
        if constexpr (kept) {  // at the crest of the parabola, or at an end
          const double crest = bend < 0 ? std::clamp(-0.5 * rise / bend, a, b) : a;
          sum.greatest = std::max({sum.greatest, parabola(crest) / softness, parabola(b) / softness});
        }
      }
      e = next, left = right;
    }
    return sum;
  }

  /// e turned by the angle whose cosine and sine are given.
  static Vec2 rotated(const Vec2& e, const Vec2& by) {
    return {by.x() * e.x() - by.y() * e.y(), by.y() * e.x() + by.x() * e.y()};
  }

  /// Parts of [0, 1] in which left + s (rise + s bend) > 0; unused ones are empty.
  static std::array<std::array<double, 2>, 2> positive_parts(double left, double rise, double bend) {
    const double right = left + rise + bend;
    const double square = rise * rise - 4 * bend * left;
    if (!(square > 0)) {
      if (left > 0 && right > 0) return {{{0, 1}, {0, 0}}};
      return {};
    }
    // Without cancellation: q = −(rise ± √)/2, roots left/q and q/bend.
    const double q = -0.5 * (rise + std::copysign(std::sqrt(square), rise));
    double low = left / q, high = bend != 0 ? q / bend : INFINITY;
    if (q == 0) low = high = 0;
    if (low > high) std::swap(low, high);
    const double a = std::clamp(low, 0.0, 1.0), b = std::clamp(high, 0.0, 1.0);
    if (bend < 0) return {{{a, b}, {0, 0}}};
    if (bend > 0) return {{{0, a}, {b, 1}}};
    return left > 0 ? std::array<std::array<double, 2>, 2>{{{0, right > 0 ? 1 : a}, {0, 0}}}
                    : std::array<std::array<double, 2>, 2>{{{right > 0 ? a : 1, 1}, {0, 0}}};
  }

  const Foundation& f_;
  Periodic bearing_, journal_;
  long count_;
  double step_, turn_, floor_;
  std::array<Vec2, 3> turned_;
  Vec2 half_turned_;
  Pressure& out_;
  std::vector<double>& half_;          // m, deviations of the bearing midway between the angles
  std::vector<Vec2>&points_, &nodes_;  // nodes: the n directions
};

}  // namespace

double Foundation::half_width(double force) const {
  return std::sqrt(4 * force * bearing_radius * journal_radius() / (pi * modulus * length * clearance));
}

double Foundation::at(double force) const {
  return stiffness > 0 ? stiffness : 3 * pi / 8 * modulus / half_width(force);
}

double layer_stiffness(const Surface& surface) {
  if (!surface.layer_modulus) return 0;
  const double nu = *surface.layer_poisson;
  return (1 - nu) * *surface.layer_modulus / ((1 + nu) * (1 - 2 * nu) * *surface.layer_thickness);
}

Foundation foundation_of(const Mechanism& mechanism, const RevoluteJoint& joint) {
  const auto& c = *joint.clearance;
  const auto& surface = mechanism.surfaces[static_cast<std::size_t>(c.surface)];
  Foundation f{c.bearing_radius, c.radial, 0, layer_stiffness(surface), 0};
  if (!c.bearing_length)
    throw ModelError(fmt::format("joints.{}.bearing_length", joint.name),
                     "is missing: the pressure in a bearing follows from the force over it");
  f.length = *c.bearing_length;
  if (surface.young)
    f.modulus = *surface.young / (2 * (1 - *surface.poisson * *surface.poisson));
  else if (f.stiffness == 0)
    throw ModelError(
        fmt::format("surfaces.{}.young", surface.name),
        fmt::format("is missing: the pressure in the bearing \"{}\" is as wide as Hertz's contact; "
                    "give young and poisson, or a layer",
                    joint.name));
  return f;
}

double RoundFoundation::force(double depth) {
  const double t = tangent(depth);
  if (t < tangent_series_below)
    return odd_series(t, 1, [](int k) { return 2.0 / ((2 * k - 1) * (2 * k + 1)); }) / (1 + depth);
  return ((1 + t * t) * std::atan(t) - t) / (1 + depth);
}

double RoundFoundation::slope(double depth) {
  const double t = tangent(depth);
  return std::atan(t) + t / (1 + t * t);
}

double RoundFoundation::energy(double depth) {
  const double t = tangent(depth);
  if (t < tangent_series_below)
    return odd_series(t, 2, [](int k) { return 2.0 * (k - 1) / ((2 * k - 1) * (2 * k + 1)); });
  return 0.5 * (std::atan(t) * (3 + t * t) - 3 * t);
}

void solve(const Foundation& foundation, std::span<const double> bearing, std::span<const double> journal,
           double turn, double force, double direction, double softening, Pressure& out) {
  const auto& f = foundation;
  if (f.stiffness == 0 && 2 * f.half_width(force) > pi * f.bearing_radius)
    throw NoEquilibrium(
        fmt::format("under a load of {:.4g} N Hertz's contact would be {:.3g} mm wide, more than half of the "
                    "bearing's circumference: the clearance of {:.3g} mm is too small for it; give a layer",
                    force, 2e3 * f.half_width(force), 1e3 * f.clearance));
  JournalSearch(foundation, bearing, journal, turn, out)
      .solve({force * std::cos(direction), force * std::sin(direction)},
             1 / foundation.at(force) + softening);
}

std::vector<double> polar_deviations(const Roundness& surface, double radius, std::size_t n) {
  std::vector<double> list(n);
  for (std::size_t k = 0; k < n; ++k) {
    const auto p = surface.at(2 * pi * static_cast<double>(k) / static_cast<double>(n));
    list[k] = p.h - p.d1 * p.d1 / (2 * radius);
  }
  return list;
}

std::vector<double> polar_deviations(const Mechanism& mechanism, int profile, double radius, std::size_t n) {
  if (profile < 0) return {};
  return polar_deviations(Roundness(mechanism.profiles[static_cast<std::size_t>(profile)]), radius, n);
}

}  // namespace freeplay
