#include "study/wear/worn_bearing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "study/wear/worn_profile.hpp"

namespace freeplay {
namespace {

constexpr int most_passes = 32;

double area_between(std::span<const double> inner, std::span<const double> outer, double radius) {
  if (outer.empty() || inner.empty()) return 0;  // round: not worn
  double sum = 0;
  for (std::size_t k = 0; k < inner.size(); ++k)
    sum += (outer[k] - inner[k]) * (radius + 0.5 * (outer[k] + inner[k]));
  return std::numbers::pi * 2 / static_cast<double>(inner.size()) * sum;
}

/// The class after the widest range of directions on the bearing without loads.
std::size_t after_widest_gap(std::span<const BearingLoad> loads) {
  std::size_t first = 0;
  double widest = 0;
  for (std::size_t k = 0; k < loads.size(); ++k) {
    const auto& before = loads[k > 0 ? k - 1 : loads.size() - 1];
    const double gap = std::remainder(loads[k].on_bearing - before.on_bearing, 2 * std::numbers::pi);
    const double range = gap < 0 ? gap + 2 * std::numbers::pi : gap;
    if (range > widest) widest = range, first = k;
  }
  return first;
}

/// The greatest value of a periodic function: that of the parabola through the greatest one and its neighbours.
double greatest_of(const std::vector<double>& list) {
  if (list.empty()) return 0;
  const auto n = list.size();
  const auto k = static_cast<std::size_t>(std::ranges::max_element(list) - list.begin());
  const double middle = list[k], before = list[(k + n - 1) % n], after = list[(k + 1) % n];
  const double bend = 2 * middle - before - after, rise = after - before;
  return bend > 0 ? middle + rise * rise / (8 * bend) : middle;
}

/// The factor f with which the growth removes `area` (m²): the root of f Σ ρ Δh ± f² Σ Δh²/2, `sign`: 1 if the
/// radius grows.
double factor_of(std::span<const double> growth, std::span<const double> form, double radius, double sign,
                 double area) {
  double first = 0, second = 0;
  for (std::size_t k = 0; k < growth.size(); ++k) {
    first += growth[k] * (radius + form[k]);
    second += 0.5 * growth[k] * growth[k];
  }
  const double step = 2 * std::numbers::pi / static_cast<double>(growth.size());
  first *= step, second *= sign * step;
  if (!(first > 0)) return 0;
  const double root = first * first + 4 * second * area;
  if (root < 0) throw NoEquilibrium("the wear of a cycle exceeds the radius of the journal");
  return 2 * area / (first + std::sqrt(root));
}

}  // namespace

WornBearing::WornBearing(WearingJoint joint)
    : joint_(std::move(joint)), bearing_(joint_.bearing_form), journal_(joint_.journal_form) {
  if (joint_.journal > 0 && journal_.empty()) journal_.assign(bearing_.size(), 0.0);
  joint_.journal_form = journal_;
}

std::vector<double> WornBearing::bearing_depth() const {
  auto depth = bearing_;
  for (std::size_t k = 0; k < depth.size(); ++k) depth[k] -= joint_.bearing_form[k];
  return depth;
}
std::vector<double> WornBearing::journal_depth() const {
  auto depth = joint_.journal_form;
  for (std::size_t k = 0; k < depth.size(); ++k) depth[k] -= journal_[k];
  return depth;
}

double WornBearing::bearing_area() const {
  return area_between(joint_.bearing_form, bearing_, joint_.foundation.bearing_radius);
}
double WornBearing::journal_area() const {
  return area_between(journal_, joint_.journal_form, joint_.foundation.journal_radius());
}

double WornBearing::greatest_bearing() const { return greatest_of(bearing_depth()); }
double WornBearing::greatest_journal() const { return greatest_of(journal_depth()); }

double WornBearing::greatest_clearance() const {
  return joint_.foundation.clearance + greatest_bearing() + greatest_journal();
}

double WornBearing::measured_clearance() const {
  const double c = joint_.foundation.clearance;
  const auto count = support_points(bearing_.size());
  const auto widest = [&](std::span<const double> form, double radius, double sign) {
    if (form.empty()) return 0.0;
    auto h = support_deviations(form, radius, count);
    for (auto& value : h) value = c + sign * value;
    h = convex_support(h);
    double most = 0;
    for (std::size_t k = 0; k < count; ++k) most = std::max(most, h[k] + h[(k + count / 2) % count]);
    return 0.5 * most - c;
  };
  const auto& f = joint_.foundation;
  return c + widest(bearing_, f.bearing_radius, 1) + widest(journal_, f.journal_radius(), -1);
}

void WornBearing::growth(const BearingLoad& load, double sliding) {
  const auto n = bearing_.size();
  const double step = 2 * std::numbers::pi / static_cast<double>(n);
  deeper_bearing_.resize(n);
  for (std::size_t k = 0; k < n; ++k) deeper_bearing_[k] = joint_.bearing * pressure_.p[k] * sliding;
  if (!(joint_.journal > 0)) return;
  // The place ψ of the journal touches the bearing at φ = ψ + θ_j − θ_i − (x × e)/R_j.
  deeper_journal_.resize(n);
  const double turn = load.on_bearing - load.on_journal, R = joint_.foundation.journal_radius();
  for (std::size_t k = 0; k < n; ++k) {
    const double there = step * static_cast<double>(k) + turn;
    const Vec2 e{std::cos(there), std::sin(there)};
    const double place = (there - cross(pressure_.centre, e) / R) / step, low = std::floor(place);
    const auto count = static_cast<long>(n), at = static_cast<long>(low) % count;
    const auto a = static_cast<std::size_t>(at < 0 ? at + count : at), b = a + 1 == n ? 0 : a + 1;
    deeper_journal_[k] = joint_.journal * sliding * std::lerp(pressure_.p[a], pressure_.p[b], place - low);
  }
}

void WornBearing::apply(const BearingLoad& load, double sliding, LastStep& last) {
  const auto& f = joint_.foundation;
  const double area = load.force * sliding / f.length;
  pressure_.warm = last.softening > 0;
  if (pressure_.warm) pressure_.centre = last.centre;
  auto& softening = last.softening;
  const auto press = [&] {
    solve(f, bearing_, journal_, load.on_bearing - load.on_journal, load.force, load.on_bearing,
          softening * sliding, pressure_);
    growth(load, sliding);
    const double of_bearing =
        joint_.bearing > 0 ? factor_of(deeper_bearing_, bearing_, f.bearing_radius, 1, joint_.bearing * area)
                           : 0;
    const double of_journal = joint_.journal > 0 ? factor_of(deeper_journal_, journal_, f.journal_radius(),
                                                             -1, joint_.journal * area)
                                                 : 0;
    softening = of_bearing * joint_.bearing + of_journal * joint_.journal;
    return std::pair(of_bearing, of_journal);
  };
  if (softening == 0) {  // the first step of this class
    softening = joint_.bearing + joint_.journal;
    press();
    pressure_.warm = true;
  }
  const auto [of_bearing, of_journal] = press();
  last.centre = pressure_.centre;
  if (joint_.bearing > 0)
    for (std::size_t k = 0; k < bearing_.size(); ++k) bearing_[k] += of_bearing * deeper_bearing_[k];
  if (joint_.journal > 0)
    for (std::size_t k = 0; k < journal_.size(); ++k) journal_[k] -= of_journal * deeper_journal_[k];
}

void WornBearing::pass(std::span<const BearingLoad> loads, double share, int number) {
  constexpr double golden = 0.6180339887498949, silver = 0.4142135623730950;
  const auto within = [&](double step) { return std::fmod(0.5 + step * number, 1.0) - 0.5; };
  for (std::size_t i = 0; i < loads.size(); ++i) {
    const auto k = (first_ + (number % 2 == 1 ? loads.size() - 1 - i : i)) % loads.size();
    auto load = loads[k];
    if (!(load.work > 0 && load.force > 0)) continue;
    load.on_bearing += load.width_on_bearing * within(golden);
    load.on_journal += load.width_on_journal * within(silver);
    apply(load, share * load.work / load.force, last_[k]);
  }
}

void WornBearing::wear(std::span<const BearingLoad> loads, double share, double tolerance) {
  if (!(share > 0) || loads.empty()) return;
  first_ = after_widest_gap(loads);
  const auto bearing = bearing_, journal = journal_;
  const auto run = [&](int passes) {
    bearing_ = bearing, journal_ = journal;
    last_.assign(loads.size(), {});
    for (int i = 0; i < passes; ++i) pass(loads, share / passes, i);
  };
  const auto apart = [](const std::vector<double>& a, const std::vector<double>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) sum += std::abs(a[k] - b[k]);
    return sum;
  };
  const auto greatest = [](const std::vector<double>& a, const std::vector<double>& b) {
    double most = 0;
    for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, std::abs(a[k] - b[k]));
    return most;
  };
  const auto settled = [&](const std::vector<double>& now, const std::vector<double>& coarse,
                           const std::vector<double>& before) {
    return apart(now, coarse) <= tolerance * apart(now, before) &&
           std::abs(greatest(now, before) - greatest(coarse, before)) <= tolerance * greatest(now, before);
  };
  int passes = std::max(2, passes_ / 2);
  run(passes / 2);
  for (;; passes *= 2) {
    const auto coarse_bearing = bearing_, coarse_journal = journal_;
    run(passes);
    if (2 * passes > most_passes ||
        (settled(bearing_, coarse_bearing, bearing) && settled(journal_, coarse_journal, journal))) {
      passes_ = passes;
      return;
    }
  }
}

}  // namespace freeplay
