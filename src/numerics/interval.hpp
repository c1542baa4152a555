// Interval arithmetic for enclosures (Boost.Interval; Moore, Kearfott and Cloud, Introduction to Interval
// Analysis, 2009): the result of an operation contains its results for all numbers of the operands.
//
// The rounding mode of the processor is not switched. The ends of a result have the rounding errors of usual
// arithmetic, some 1e-16 relative; who uses an enclosure adds them where they count.
#pragma once

#include <boost/numeric/interval.hpp>
#include <cmath>
#include <optional>

namespace freeplay {

namespace interval_policies = boost::numeric::interval_lib;
using Interval = boost::numeric::interval<
    double, interval_policies::policies<
                interval_policies::save_state_nothing<interval_policies::rounded_transc_exact<double>>,
                interval_policies::checking_base<double>>>;

/// The interval of all numbers within `radius` of `center`.
inline Interval around(double center, double radius) { return {center - radius, center + radius}; }

/// The angle of the point (x, y); empty if the points include the origin. About the negative x axis it continues
/// beyond π, where std::atan2 jumps: it is meant for derivatives.
inline std::optional<Interval> angle_of(const Interval& y, const Interval& x) {
  if (x.lower() > 0) return atan(y / x);
  const double quarter = std::acos(0.0);
  if (y.lower() > 0) return quarter - atan(x / y);
  if (y.upper() < 0) return -quarter - atan(x / y);
  if (x.upper() < 0) return 2 * quarter + atan(y / x);
  return {};
}

}  // namespace freeplay
