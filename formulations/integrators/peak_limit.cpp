#include "formulations/integrators/peak_limit.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// Share of the clearance, or of the length of a contact without one, above which a gap is open.
constexpr double open_share = 1e-3;

}  // namespace

PeakLimit::PeakLimit(const System& system) : system_(system) {
  for (int k = 0; k < system.contacts(); ++k)
    if (const auto& surface = system.contact_facts(k).surface; surface.friction_by_speed())
      add(true, k, surface.peak.curve(*surface.friction));
  for (const int k : system.reactive_frictions()) add(false, k, *system.friction_facts(k).reaction);
  if (!peaks_.empty()) evaluation_ = system.make_evaluation();
}

void PeakLimit::add(bool of_contact, int index, const StribeckCurve& curve) {
  if (!(curve.more > 0)) return;
  const double far = std::pow(std::log(1e12), 1 / curve.exponent);  // e^(−farⁿ) = 1e-12
  peaks_.push_back(
      {of_contact, index, far * curve.stribeck, curve.stribeck / (2 * std::max(2.0, curve.exponent))});
}

/// u (m/s) at a placed state; NaN if the contact is open.
double PeakLimit::sliding(const Peak& peak, const double* q, const double* v) {
  if (!peak.of_contact) {
    system_.friction(peak.index, q, v, evaluation_, slide_);
    return slide_.dot(v);
  }
  system_.contact(peak.index, q, v, evaluation_, contact_);
  const bool open = contact_.gap > open_share * system_.contact_facts(peak.index).clearance;
  return open ? NAN : contact_.tangent.dot(v);
}

double PeakLimit::find(double t0, const double* q0, const double* v0, double t1, const double* q1,
                       const double* v1) {
  system_.place(t0, q0, evaluation_);
  for (auto& peak : peaks_) peak.before = sliding(peak, q0, v0);
  system_.place(t1, q1, evaluation_);
  double worst = 0;
  for (const auto& peak : peaks_) {
    const double from = peak.before, to = sliding(peak, q1, v1), way = std::abs(to - from);
    const bool outside = std::abs(from) > peak.far;
    if (std::isnan(way) || (outside && (to > from) == (from > 0))) continue;
    const double reach = (outside ? std::abs(from) - peak.far : 0) + peak.fine;
    if (way > reach + 0.5 * peak.fine) worst = std::max(worst, way / reach);
  }
  return worst;
}

}  // namespace freeplay
