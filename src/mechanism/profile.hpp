// Deviations from roundness of bearings and journals, and the places at which they can touch.
//
// A surface of nominal radius R has, in the direction φ of its body, the support function
//
//     H(φ) = R + p(φ),    p = Σ (c_n cos nφ + s_n sin nφ)    or the periodic cubic spline through a table:
//
// the distance from the joint's point to the tangent whose normal has the direction φ. The radius at the
// polar angle φ is R + p(φ) − p′²/(2R) up to terms of third order in p/R and p′/R. The radius of curvature is
// R + p + p″. A harmonic of order 1 is exactly a shift of the centre by (c_1, s_1).
//
// With the clearance c = R_b − R_j and the journal's centre at d from that of the bearing, let, in directions
// φ of the world,
//
//     G(φ) = h(φ) − d·n(φ),    h = c + p_b(φ − θ_i) − p_j(φ − θ_j)
//
// The journal is inside the bearing if G ≥ 0 everywhere, thus if d is in the convex set C = {d: d·n ≤ h}. It
// touches at minima of G with G = 0. w = h + h″ = G + G″ is the difference of the radii of curvature: the
// journal touches only where w ≥ 0. On an arc of less than a half turn with w > 0 it touches in at most one
// place, since for two places a < b with G = G′ = 0
//
//     ∫ w sin(φ − a) dφ = [G′ sin(φ − a) − G cos(φ − a)] = 0.
//
// For the same reason the least gap of such an arc is at one place, which moves continuously, while it is
// less than the least w of the arc. Hence
//
// - if w > 0 everywhere, the joint has one contact, with the least G of the turn;
// - else the boundary of C is smooth arcs between corners, at which two arcs touch at once. Each arc is a
//   contact, with the least G of the arc. The arcs are fixed in the body whose surface deviates. They are the
//   runs of successive vertices of the convex hull of the points n/h (polar duality), extended by one sample.
//
// An arc of a half turn or more is cut into three parts. At a cut one contact follows another, without a
// corner. The parts are unequal, so that no cut is at a place of symmetry, where a journal may rest.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "mechanism/cam_profile.hpp"
#include "mechanism/keys.hpp"

namespace freeplay {

struct Mechanism;
struct RevoluteJoint;

/// A named deviation of a bearing or journal from its radius.
struct Profile {
  static constexpr std::string_view what = "a profile";
  /// Greatest order of a harmonic.
  static constexpr double most_waves = 1000;
  std::string name;                                    ///< of the profile in the scene
  std::vector<std::vector<double>> harmonics = {};     ///< rows n, c_n (m), s_n (m)
  std::vector<std::pair<double, double>> points = {};  ///< (rad, m): angle, p; empty: harmonics

  static void keys(auto& k, auto& p) {
    k.rows(
        {"harmonics", "m",
         "rows [n, cosine, sine] of a Fourier series of the deviation, n a whole number: waves over a turn; or "
         "points"},
        std::vector<std::string_view>{"", "m", "m"}, p.harmonics);
    k.pairs(
        {"points", "rad, m",
         "[[angle, deviation], ...], angles increasing within a turn, or a CSV file: joined by a periodic cubic "
         "spline; in place of harmonics"},
        p.points);
    k.check(p.harmonics.empty() != p.points.empty(), "", "needs exactly one of harmonics and points");
    for (const auto& row : p.harmonics)
      k.check(row.size() == 3 && row[0] >= 0 && row[0] <= most_waves && row[0] == static_cast<int>(row[0]),
              "harmonics", "must have rows [n, cosine, sine] with a whole number n from 0 to ", most_waves);
    if (p.points.empty()) return;
    k.check(p.points.size() >= 3, "points", "must be three points or more, are ",
            static_cast<double>(p.points.size()));
    k.check(p.points.back().first < p.points.front().first + CamProfile::turn * (1 - 1e-9), "points",
            "must stay within one turn, without the first point again at its end; span ",
            p.points.back().first - p.points.front().first);
  }
};

/// The deviation p(φ) of a surface.
class Roundness {
 public:
  /// Bounds over the turn.
  struct Bounds {
    double low = 0, high = 0;       ///< m, of p
    double d1 = 0, d2 = 0, d3 = 0;  ///< m/rad, ..., of |p′|, |p″| and |p‴|
  };

  /// A round surface.
  Roundness() = default;
  /// The surface with this deviation.
  explicit Roundness(const Profile& profile);

  /// p and its derivatives; T is double or a traced number.
  template <class T>
  CamProfile::ValueOf<T> at(const T& phi) const {
    using std::cos, std::sin;
    CamProfile::ValueOf<T> y;
    if (table_) y = table_->at(phi);
    for (const auto& [n, c, s] : harmonics_) {
      if (n == 0) {
        y.h += c;
        continue;
      }
      const T angle = n * phi, co = cos(angle), si = sin(angle);
      const T even = c * co + s * si, odd = n * (s * co - c * si);
      y.h += even;
      y.d1 += odd;
      y.d2 -= n * n * even;
      y.d3 -= n * n * odd;
    }
    return y;
  }
  /// Bounds over the turn.
  const Bounds& bounds() const { return bounds_; }
  /// m/rad³, bound of |p‴| from a to b (rad), a ≤ b.
  double third(double a, double b) const { return table_ ? table_->greatest_third(a, b) : bounds_.d3; }
  /// m, bounds of p + p″ over the turn, of a table: p″ is linear between its points. None for harmonics.
  const std::optional<std::array<double, 2>>& curvature() const { return curvature_; }
  /// Whether p is constant.
  bool is_round() const { return bounds_.d1 == 0; }
  /// rad, half of the shortest wave, or the least distance of points.
  double narrowest() const { return narrowest_; }

 private:
  std::vector<std::array<double, 3>> harmonics_;
  std::optional<CamProfile> table_;
  std::optional<std::array<double, 2>> curvature_;
  Bounds bounds_;
  double narrowest_ = CamProfile::turn / 2;
};

/// Directions in which a bearing and a journal may touch.
struct ContactArc {
  bool whole = true;                       ///< all directions; else from `from` to `to`
  bool on_journal = false;                 ///< whether the angles are those of the journal's body
  double from = 0, to = CamProfile::turn;  ///< rad
  double least = 0;                        ///< m, lower bound of w on the arc, > 0
};

/// A bearing and a journal of which one or both deviate from a circle.
struct OutOfRound {
  /// deviations of both surfaces
  Roundness bearing, journal;
  std::vector<ContactArc> arcs;  ///< empty if there is a refusal
  std::string refusal;           ///< why the contacts are not described; "" if they are

  /// `clearance` (m): c
  OutOfRound(Roundness bearing_surface, Roundness journal_surface, double clearance, double journal_radius);
};

/// That of a joint with a profile; empty for other joints. Throws ModelError if its contacts are not
/// described.
std::optional<OutOfRound> out_of_round(const Mechanism& mechanism, const RevoluteJoint& joint);

}  // namespace freeplay
