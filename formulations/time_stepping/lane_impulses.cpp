#include "formulations/time_stepping/lane_impulses.hpp"

namespace freeplay {
namespace {

void append(std::vector<Traced>& list, const std::array<Traced, 2>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

}  // namespace

LaneImpulses alone(const SingleContact<Traced>& c, bool rubs, const Traced& tolerance) {
  LaneImpulses s;
  if (!rubs) {
    s.normal = -(c.bn - c.target_n) / c.nn;
    s.need(is_below(0, s.normal));
    s.need(is_below(0, c.nn));
    s.take_residuals({}, {normal_residual(c.nn, s.normal, c.bn + c.nn * s.normal - c.target_n)},
                     {c.bn, c.target_n}, tolerance);
    return s;
  }
  s.need(is_below(c.bn - c.target_n, 0));
  const Traced determinant = c.determinant();
  s.need(is_below(Traced(same_freedom) * c.nn * c.tt, determinant));
  const auto found = pressed(c, determinant);
  s.need(found.holds);
  const auto& [Pn, Pt] = found.P;
  s.normal = Pn;
  s.tangent = Pt;
  s.need(is_below(0, Pn));
  s.need(is_below(c.friction * abs(c.nt), c.nn));  // no other motion
  std::vector<Traced> residuals{normal_residual(c.nn, Pn, c.bn + c.nn * Pn + c.nt * Pt - c.target_n)};
  append(residuals, friction_residuals(c.tt, Pt, c.bt + c.nt * Pn + c.tt * Pt, c.friction * Pn));
  s.take_residuals({Pt}, residuals, {c.bn, c.target_n, c.bt}, tolerance);
  return s;
}

LaneImpulses slide_alone(const Traced& D, const Traced& b, const Traced& bound, const Traced& tolerance) {
  LaneImpulses s;
  s.slide = friction_impulse(D, b, bound);
  s.need(is_below(0, D));
  const auto residuals = friction_residuals(D, s.slide, b + D * s.slide, bound);
  s.take_residuals({s.slide}, {residuals.begin(), residuals.end()}, {b}, tolerance);
  return s;
}

LaneImpulses with_slide(const SingleContact<Traced>& c, bool rubs, const JointBeside& j,
                        const Traced& tolerance) {
  constexpr double nearly = 1 - 1e-9;  // as in enumeration()
  LaneImpulses s;
  const auto side_of = [](const Traced& last) { return select(is_below(last, 0), -1, 1); };
  s.need(is_below(0, j.last_n));
  s.need(is_at_most(j.bound * nearly, abs(j.last)));
  const Traced slide_side = side_of(j.last);
  Traced K = c.nn, side;
  if (rubs) {
    s.need(is_at_most(c.friction * j.last_n * nearly, abs(j.last_t)));
    side = side_of(j.last_t);
    K += side * c.friction * c.nt;
  }
  s.normal = -(c.bn - c.target_n + j.ns * slide_side * j.bound) / K;
  s.need(is_below(0, s.normal));
  s.slide = slide_side * j.bound;
  Traced rate_n = c.bn + c.nn * s.normal, rate_s = j.b + j.ns * s.normal;
  if (rubs) {
    s.tangent = side * (c.friction * s.normal);
    s.need(is_below(c.friction * abs(c.nt), c.nn));  // no other motion
    rate_n += c.nt * s.tangent;
    rate_s += j.ts * s.tangent;
  } else {
    s.need(is_below(0, c.nn));
  }
  std::vector<Traced> residuals{normal_residual(c.nn, s.normal, rate_n + j.ns * s.slide - c.target_n)};
  if (rubs)
    append(residuals,
           friction_residuals(c.tt, s.tangent, c.bt + c.nt * s.normal + c.tt * s.tangent + j.ts * s.slide,
                              c.friction * s.normal));
  append(residuals, friction_residuals(j.ss, s.slide, rate_s + j.ss * s.slide, j.bound));
  s.take_residuals({s.normal, s.tangent, s.slide}, residuals, {c.bn, c.target_n, c.bt, j.b}, tolerance);
  return s;
}

}  // namespace freeplay
