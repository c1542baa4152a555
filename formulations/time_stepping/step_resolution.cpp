#include "formulations/time_stepping/step_resolution.hpp"

#include <cmath>
#include <numeric>

#include "formulations/time_stepping/contact_set.hpp"

namespace freeplay {
namespace {

/// How far a curve departs, by its knots between a and b, from the straight line that a step of Δx = |b − a| takes it for: with [y′] the
/// jump of its slope at a knot |[y′]| Δx/4, and of a jump of the value the share of the shorter piece beside it, |[y]| Δx/(2w).
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
    std::vector<double> any(static_cast<std::size_t>(system.n()));  // two bodies alike in none
    std::iota(any.begin(), any.end(), 1.0);
    if (system.passage(k, any.data(), 1) > 0) passing_.push_back(k);
  }
  passes_ = !passing_.empty() || !system.families().empty();
  for (const auto& reader : system.curve_readers()) greatest_.push_back(reader.course.greatest().value);
}

/// What moves far in a step may come and go between two of them.
void StepResolution::judge_passage(const StepData& s, const ContactSet& contacts) {
  const double h = s.length();
  for (const int k : passing_)
    for (const auto* v : {&s.v_old, &s.v})
      if (const double share = s.system.passage(k, v->data(), h); share > passage.share) passage = {share, k};
  for (const int k : contacts.seated())
    for (const auto* v : {&s.v_old, &s.v})
      if (const double share = System::passage(contacts.shape(k), v->data(), h); share > passage.share)
        passage = {share, contacts.told_as(k)};
}

/// A fixed step takes what it reads for straight between its ends: of a sine of N steps a period it misses (2π/N)²/8. Two places
/// within, so that no period that divides the step is missed.
void StepResolution::judge_bend(const StepData& s) {
  const auto& readers = s.system.curve_readers();
  const auto take = [&](double share, double most, std::size_t i) {
    if (share > most * bend.over) bend = {share, share / most, static_cast<int>(i)};
  };
  for (std::size_t i = 0; i < readers.size(); ++i) {
    const auto& reader = readers[i];
    const double a = reader.argument(s.t_old, s.q_old.data(), s.v_old.data()).value,
                 b = reader.argument(s.t, s.q.data(), s.v.data()).value;
    if (a == b || !(greatest_[i] > 0)) continue;
    // A sine or a row of kinks at equal distances, each met by one step of five: 20 and more steps a period.
    if (reader.of != CurveReader::Of::time) take(departure_at_knots(reader, a, b) / greatest_[i], 0.1, i);
    if (!std::isfinite(reader.variation(a, b > a))) continue;
    const auto y = [&](double x) { return reader.course.value(a + x * (b - a)); };
    const double from = y(0), to = y(1);
    for (const double x : {0.37, 0.5})
      take(std::abs(y(x) - (from + x * (to - from))) / greatest_[i], 0.01, i);
  }
}

}  // namespace freeplay
