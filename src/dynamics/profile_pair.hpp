// Contact pair of a journal and a bearing of which one or both deviate from a circle (mechanism/profile.hpp).
//
// With d = r_j − r_i, n(φ) = (cos φ, sin φ), t = perp n, and the support functions H_b = R_b + p_b(φ − θ_i)
// of the bearing and H_j = R_j + p_j(φ − θ_j) of the journal,
//
//     G(φ) = c + p_b − p_j − d·n,    G′ = p_b′ − p_j′ − d·t,    κ = G″ = p_b″ − p_j″ + d·n
//
// g is the least G over the arc of the pair. Where G′ = 0, the points of both surfaces with the normal n face
// each other, so g is their distance exactly. The place moves with
//
//     φ̇ = s/κ,    s = t·ḋ + p_b″ ω_i − p_j″ ω_j
//
// or, at an end of the arc, which is fixed in body f, with φ̇ = ω_f. In both cases
//
//     ġ = −n·ḋ − p_b′ ω_i + p_j′ ω_j  (at an end: + G′ ω_f)
//     g̈ = −n·d̈ − p_b′ α_i + p_j′ α_j  (at an end: + G′ α_f)
//         + p_b″ (φ̇ − ω_i)² − p_j″ (φ̇ − ω_j)² − 2 φ̇ t·ḋ + φ̇² d·n
//     v_T = t·ḋ + H_j ω_j − H_b ω_i
//     v̇_T = t·d̈ + H_j α_j − H_b α_i − φ̇ n·ḋ + p_j′ (φ̇ − ω_j) ω_j − p_b′ (φ̇ − ω_i) ω_i
//
// For round surfaces these are the equations of RoundPair (pairs.hpp). The forces do not change the angular
// momentum, exactly where g = 0.
//
// The least G is found as in cam_pairs.hpp: an interval is divided until bounds of G and G′ exclude it, or κ
// > 0 holds in it and Newton's method ends in its only minimum. The bound of |G‴| is that of p_b‴ and p_j‴
// in the interval plus |d|. Only directions with c + least p − |d| cos(φ − ψ) < G(ψ) are searched, ψ: direction of
// d. Around a whole arc none is where Newton's method ends in a minimum less than w₀ (below), which is the
// least. No state is kept.
//
// Bounds. Let w₀ be the least difference of the radii of curvature on the arc (ContactArc::least). While g <
// w₀/2, κ = w − G > w₀/2, and the place moves continuously. Farther away it may jump, and only the bound of ġ
// is used. Ends of an arc are not touched, except a cut: there one pair separates when the next one closes,
// at equal gaps and rates.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "dynamics/pairs.hpp"
#include "mechanism/profile.hpp"

namespace freeplay {

struct ProfilePair {
  Link link;
  double clearance = 0, bearing_radius = 0;  ///< m, c and R_b
  std::shared_ptr<const OutOfRound> surfaces;
  ContactArc arc;

  /// A place of the arc.
  template <class T>
  struct PlaceOf {
    T phi = 0;  ///< rad, direction of the normal from the x axis of body f
    bool end = false;
    T co = 1, si = 0;
    CamProfile::ValueOf<T> b, j;     ///< p_b and p_j
    T gap = 0, slope = 0, bend = 0;  ///< G, G′ and κ
  };
  using Place = PlaceOf<double>;

  const Roundness& bearing() const { return surfaces->bearing; }
  const Roundness& journal() const { return surfaces->journal; }
  /// Body f.
  int frame() const { return arc.on_journal ? link.j : link.i; }
  /// m, below this gap the place is unique.
  double reach() const { return 0.5 * arc.least; }
  /// The place of least G, for d in the axes of body f and the angle θ_j − θ_i.
  Place nearest(const Vec2& d, double angle) const;

  double gap(const double* q, const Vec2& d, const Evaluation& e) const {
    return nearest(in_frame(d, e), theta(q, link.j) - theta(q, link.i)).gap;
  }
  /// Bounds on the gap's second derivative within a step; d at its end.
  GapMotion motion(const MotionBounds& bounds, const Vec2& d) const;
  /// Rotation within a time h of the bodies whose surfaces deviate, as a share of half a wave.
  double passage(const double* v, double h) const {
    const auto share = [&](const Roundness& r, int body) {
      return r.is_round() ? 0 : std::abs(omega(v, body)) * h / r.narrowest();
    };
    return share(bearing(), link.i) + share(journal(), link.j);
  }

  /// Not inlined, so that the rows of common pairs stay as they are.
  template <class T>
  [[gnu::noinline]] void rows(const ContactFacts& facts, const T* q, const Arms<T>& a, const T* v,
                              const EvaluationOf<T>& e, ContactRowOf<T>& row) const {
    const int i = link.i, j = link.j;
    const auto p = place(in_frame(a.d, e), T(theta(q, j) - theta(q, i)));
    const Vec2Of<T> n = in_world({p.co, p.si}, e), t = perp(n), rate = relative_velocity(link, a, v);
    const T wi = omega(v, i), wj = omega(v, j), along = dot(t, rate);
    const Vec2Of<T> still = centripetal(a.ri, wi, a.rj, wj), inward = -n, back = -t;
    // Beyond the reach κ may vanish.
    const T bend = choose(
        is_below(p.bend, reach()), [&] { return T(reach()); }, [&] { return p.bend; });
    const T turn = p.end ? omega(v, frame()) : T((along + p.b.d2 * wi - p.j.d2 * wj) / bend);
    const T past_i = turn - wi, past_j = turn - wj;
    row.gap = p.gap;
    row.gamma_n = dot(n, still) - (p.b.d2 * past_i * past_i - p.j.d2 * past_j * past_j - 2 * turn * along +
                                   turn * turn * dot(n, a.d));
    T lever_i = -p.b.d1, lever_j = p.j.d1;
    if (p.end) (arc.on_journal ? lever_j : lever_i) += p.slope;
    push(row.normal, i, n, T(cross(a.ri, n) + lever_i));
    push(row.normal, j, inward, T(cross(a.rj, inward) + lever_j));
    if (!facts.surface.friction) return;
    row.gamma_t = turn * dot(n, rate) + p.b.d1 * past_i * wi - p.j.d1 * past_j * wj - dot(t, still);
    push(row.tangent, i, back, T(cross(a.ri, back) - (bearing_radius + p.b.h)));
    push(row.tangent, j, t, T(cross(a.rj, t) + (bearing_radius - clearance + p.j.h)));
  }

 private:
  struct Search;
  /// The place in the direction phi.
  template <class T>
  PlaceOf<T> look(const Vec2Of<T>& d, const T& angle, const T& phi) const {
    using std::cos, std::sin;
    PlaceOf<T> x;
    x.phi = phi;
    x.co = cos(phi), x.si = sin(phi);
    x.b = bearing().at(arc.on_journal ? T(phi + angle) : phi);
    x.j = journal().at(arc.on_journal ? phi : T(phi - angle));
    const T out = d.x() * x.co + d.y() * x.si;
    x.gap = clearance + x.b.h - x.j.h - out;
    x.slope = x.b.d1 - x.j.d1 - (d.y() * x.co - d.x() * x.si);
    x.bend = x.b.d2 - x.j.d2 + out;
    return x;
  }
  Place descend(const Vec2& d, double angle, Place x, double a, double b) const;
  Place place(const Vec2& d, double angle) const { return nearest(d, angle); }
  /// The direction is found outside the trace. One more Newton step has the derivatives of the place by the
  /// state and by the amplitudes.
  PlaceOf<Traced> place(const Vec2Of<Traced>& d, const Traced& angle) const {
    const auto found = [pair = *this](const double* x, double* y) {
      const auto p = pair.nearest({x[0], x[1]}, x[2]);
      y[0] = p.phi, y[1] = p.end ? 1 : 0;
    };
    const auto y =
        call_outside({2, found, true}, std::array{d.x(), d.y(), angle}, "a place is found by iteration");
    auto x = look(d, angle, y[0]);
    x.end = y[1] > Traced(0.5);
    if (x.end) return x;
    return look(d, angle, Traced(y[0] - x.slope / max(x.bend, Traced(1e-9 * clearance))));
  }
  template <class T>
  Vec2Of<T> in_frame(const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    const int f = frame();
    if (f == ground) return d;
    const T &c = e.cosine[f], &s = e.sine[f];
    return {c * d.x() + s * d.y(), c * d.y() - s * d.x()};
  }
  template <class T>
  Vec2Of<T> in_world(const Vec2Of<T>& d, const EvaluationOf<T>& e) const {
    const int f = frame();
    if (f == ground) return d;
    const T &c = e.cosine[f], &s = e.sine[f];
    return {c * d.x() - s * d.y(), s * d.x() + c * d.y()};
  }
};

}  // namespace freeplay
