#include "dynamics/lane_closed_forms.hpp"

#include <initializer_list>

namespace freeplay {
namespace {

/// As in solvers.cpp.
constexpr double same_freedom = 1e-12;

/// max |x| of residuals of the laws, which must be finite and small.
void take_residuals(LaneImpulses& s, std::initializer_list<Traced> impulses,
                    const std::vector<Traced>& residuals, std::initializer_list<Traced> rates,
                    const Traced& tolerance) {
  Traced unfinished, size;
  for (const auto& P : impulses) unfinished += zero_if_finite(P);
  for (const auto& x : residuals) {
    s.residual_rate = max(s.residual_rate, abs(x));
    unfinished += zero_if_finite(x);
  }
  for (const auto& rate : rates) size = max(size, abs(rate));
  s.conditions.push_back(holds(unfinished, Relation::equal, 0));
  s.conditions.push_back(both(less(0, size), at_most(s.residual_rate, tolerance * size)));
  s.residual = s.residual_rate / size;
}

/// Appends the residuals of a row with friction: its rate and impulse, and the greatest impulse.
void take_friction(std::vector<Traced>& residuals, const Traced& u, const Traced& D, const Traced& P,
                   const Traced& bound) {
  residuals.push_back(least(abs(u), D * abs(P + select(less(u, 0), -bound, bound))));
  residuals.push_back(D * max(0, abs(P) - bound));
}

}  // namespace

LaneImpulses with_friction(const std::array<Traced, 3>& D, const Traced& bn0, const Traced& bt,
                           const Traced& target, const Traced& friction, const Traced& tolerance) {
  LaneImpulses s;
  const auto &nn = D[0], &nt = D[1], &tt = D[2];
  const auto need = [&](const Traced& condition) { s.conditions.push_back(condition); };
  const Traced bn = bn0 - target;
  need(less(bn, 0));
  const Traced determinant = nn * tt - nt * nt;
  need(less(Traced(same_freedom) * nn * tt, determinant));
  const Traced Pn = (-bn * tt + bt * nt) / determinant, Pt = (-bt * nn + bn * nt) / determinant;
  const Traced sticks = both(at_most(0, Pn), at_most(abs(Pt), friction * Pn));
  std::array<Traced, 2> slips, P, T;
  for (int i = 0; i < 2; ++i) {
    const Traced s_mu = i == 0 ? friction : -friction, slope = nn - s_mu * nt;
    P[i] = -bn / slope;
    T[i] = i == 0 ? -(friction * P[i]) : friction * P[i];
    const Traced rate = bt + nt * P[i] + tt * T[i];
    slips[i] = both(less(0, slope), both(at_most(0, P[i]), at_most(0, i == 0 ? rate : -rate)));
  }
  need(either(sticks, either(slips[0], slips[1])));
  s.normal = select(sticks, Pn, select(slips[0], P[0], P[1]));
  s.tangent = select(sticks, Pt, select(slips[0], T[0], T[1]));
  need(less(0, s.normal));
  need(less(friction * abs(nt), nn));  // no other motion
  std::vector residuals{least(abs(nn) * s.normal, bn0 + nn * s.normal + nt * s.tangent - target)};
  take_friction(residuals, bt + nt * s.normal + tt * s.tangent, tt, s.tangent, friction * s.normal);
  take_residuals(s, {s.tangent}, residuals, {bn0, target, bt}, tolerance);
  return s;
}

LaneImpulses frictionless(const Traced& nn, const Traced& bn0, const Traced& target,
                          const Traced& tolerance) {
  LaneImpulses s;
  s.normal = -(bn0 - target) / nn;
  s.conditions = {less(0, s.normal), less(0, nn)};
  take_residuals(s, {}, {least(abs(nn) * s.normal, bn0 + nn * s.normal - target)}, {bn0, target}, tolerance);
  return s;
}

LaneImpulses sliding(const Traced& D, const Traced& b, const Traced& bound, const Traced& tolerance) {
  LaneImpulses s;
  const Traced stick = -b / D;
  s.slide = select(less(stick, -bound), -bound, select(less(bound, stick), bound, stick));
  s.conditions.push_back(less(0, D));
  std::vector<Traced> residuals;
  take_friction(residuals, b + D * s.slide, D, s.slide, bound);
  take_residuals(s, {s.slide}, residuals, {b}, tolerance);
  return s;
}

LaneImpulses with_slide(const LaneMode& m, const Traced& tolerance) {
  constexpr double nearly = 1 - 1e-9;  // as in enumeration()
  LaneImpulses s;
  const auto need = [&](const Traced& condition) { s.conditions.push_back(condition); };
  const auto side_of = [](const Traced& last) { return select(less(last, 0), -1, 1); };
  need(less(0, m.last_n));
  need(at_most(m.bound * nearly, abs(m.last_s)));
  const Traced slide_side = side_of(m.last_s);
  Traced K = m.nn, side;
  if (m.friction) {
    need(at_most(*m.friction * m.last_n * nearly, abs(m.last_t)));
    side = side_of(m.last_t);
    K += side * *m.friction * m.nt;
  }
  s.normal = -(m.bn - m.target + m.ns * slide_side * m.bound) / K;
  need(less(0, s.normal));
  s.slide = slide_side * m.bound;
  Traced rate_n = m.bn + m.nn * s.normal, rate_s = m.bs + m.ns * s.normal;
  std::vector<Traced> residuals;
  if (m.friction) {
    s.tangent = side * (*m.friction * s.normal);
    need(less(*m.friction * abs(m.nt), m.nn));  // no other motion
    rate_n += m.nt * s.tangent;
    rate_s += m.ts * s.tangent;
  } else {
    need(less(0, m.nn));
  }
  residuals.push_back(least(abs(m.nn) * s.normal, rate_n + m.ns * s.slide - m.target));
  if (m.friction)
    take_friction(residuals, m.bt + m.nt * s.normal + m.tt * s.tangent + m.ts * s.slide, m.tt, s.tangent,
                  *m.friction * s.normal);
  take_friction(residuals, rate_s + m.ss * s.slide, m.ss, s.slide, m.bound);
  take_residuals(s, {s.normal, s.tangent, s.slide}, residuals, {m.bn, m.target, m.bt, m.bs}, tolerance);
  return s;
}

}  // namespace freeplay
