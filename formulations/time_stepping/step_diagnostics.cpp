#include "formulations/time_stepping/step_diagnostics.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "formulations/contact/contact_problem.hpp"
#include "formulations/time_stepping/contact_set.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

/// Relative change of a film's thickness in a fixed step from which there is a warning, and the advised one.
constexpr double coarse_film_change = 0.3, advised_film_change = 0.1;
/// Accepted deviation of a curve over its greatest value, at knots and within a piece: that of a sine, or of
/// knots at equal distances of which one step in five meets one, with about 20 steps per period.
constexpr double accepted_at_knots = 0.1, accepted_in_piece = 0.01;
/// Places within a step where a curve is compared; no period that divides the step has zeros at both.
constexpr double places_in_step[] = {0.37, 0.5};
/// Greatest advised step over the present one.
constexpr double greatest_advice = 0.5;

/// Deviation of a curve, due to its knots between a and b, from the straight line by which a step
/// of Δx = |b − a| approximates it: |[y′]| Δx/4 for a jump [y′] of its slope at a knot, and |[y]|
/// Δx/(2w) for a jump of its value, where w is the width of the shorter adjacent piece.
double departure_at_knots(const CurveReader& reader, double a, double b) {
  constexpr int most = 64;  // more are not resolved anyway
  if (reader.place.kinks.empty()) return 0;
  const bool up = b > a;
  const double path = std::abs(b - a);
  double sum = 0;
  auto piece = reader.place.piece(a, up);
  for (int passed = 0; passed < most; ++passed) {
    const double knot = up ? piece.high : piece.low;
    if (!(up ? knot < b : knot > b)) break;
    const auto next = reader.place.piece(knot, up);
    const double width = std::min(piece.high - piece.low, next.high - next.low);
    const auto jump = reader.course.jump(knot);
    sum += jump.slope * path / 4 + jump.value * path / (2 * width);
    piece = next;
  }
  return sum;
}

}  // namespace

StepResolution::StepResolution(const System& system) {
  for (int k = 0; k < system.contacts(); ++k) {
    // no two bodies have equal velocities
    std::vector<double> any(static_cast<std::size_t>(system.n()));
    std::iota(any.begin(), any.end(), 1.0);
    if (system.passage(k, any.data(), 1) > 0) passing_.push_back(k);
  }
  passes_ = !passing_.empty() || !system.families().empty();
  for (const auto& reader : system.curves().readers) greatest_.push_back(reader.course.greatest().value);
}

/// A contact that moves far in a step may close and open between its ends.
void StepResolution::assess_passage(const StepData& s, const ContactSet& contacts) {
  const double h = s.length();
  for (const int k : passing_)
    for (const auto* v : {&s.v_old, &s.v})
      if (const double share = s.system.passage(k, v->data(), h); share > passage.share) passage = {share, k};
  for (const int k : contacts.slot_contacts())
    for (const auto* v : {&s.v_old, &s.v})
      if (const double share = System::passage(contacts.shape(k), v->data(), h); share > passage.share)
        passage = {share, contacts.reported_index(k)};
}

/// A fixed step takes a curve as straight between its ends; for a sine of N steps per period the
/// error is (2π/N)²/8. The check uses two places within the step, so that it detects every period
/// that divides the step.
void StepResolution::assess_curves(const StepData& s) {
  const auto& readers = s.system.curves().readers;
  const auto take = [&](double share, double most, std::size_t i) {
    if (share > most * curve_deviation.over) curve_deviation = {share, share / most, static_cast<int>(i)};
  };
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const auto& reader = readers[i];
    const double a = reader.argument(s.t_old, s.q_old.data(), s.v_old.data()).value,
                 b = reader.argument(s.t, s.q.data(), s.v.data()).value;
    if (a == b || !(greatest_[i] > 0)) continue;
    if (reader.of != CurveReader::Of::time)
      take(departure_at_knots(reader, a, b) / greatest_[i], accepted_at_knots, i);
    if (!std::isfinite(reader.variation(a, b > a))) continue;
    const auto y = [&](double x) { return reader.course.value(a + x * (b - a)); };
    const double from = y(0), to = y(1);
    for (const double x : places_in_step)
      take(std::abs(y(x) - (from + x * (to - from))) / greatest_[i], accepted_in_piece, i);
  }
}

void add_step_notes(const StepDiagnostics& found, const System& system, bool fixed,
                    const FilmStep::ThicknessChange& thickness_change,
                    const StepResolution::CurveDeviation& curve_deviation, std::vector<std::string>& notes) {
  if (!found.motions.empty()) notes.push_back(diagnostic<Diagnostic::several_motions>(found.motions));
  if (found.lockups > 0) notes.push_back(diagnostic<Diagnostic::lockup_impulse>(found.lockups, found.lockup));
  if (found.undecided > 0)
    notes.push_back(diagnostic<Diagnostic::not_searched>(found.undecided, most_for_modes));
  if (found.inelastic > 0) notes.push_back(diagnostic<Diagnostic::no_restitution_steps>(found.inelastic));
  if (found.unsettled > 0)
    notes.push_back(diagnostic<Diagnostic::film_iteration>(found.unsettled, finer_key(fixed)));
  if (fixed && thickness_change.share > coarse_film_change)
    notes.push_back(diagnostic<Diagnostic::film_not_resolved>(
        system.contact_facts(thickness_change.contact).name, thickness_change.share,
        advised_film_change / thickness_change.share));
  if (curve_deviation.over > 1)
    notes.push_back(diagnostic<Diagnostic::curve_not_resolved>(
        system.curves().readers[static_cast<std::size_t>(curve_deviation.reader)].name, curve_deviation.share,
        std::min(1 / std::max(std::sqrt(curve_deviation.over), 10 * curve_deviation.share),
                 greatest_advice)));
  if (found.uncorrected > 0)
    notes.push_back(diagnostic<Diagnostic::position_residual>(found.uncorrected, found.residual));
  if (found.locked > 0)
    notes.push_back(diagnostic<Diagnostic::self_locking>(found.locked, found.locked_since));
  if (found.unswept > 0)
    notes.push_back(diagnostic<Diagnostic::torque_iteration>(found.unswept, finer_key(fixed)));
}

}  // namespace freeplay
