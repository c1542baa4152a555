// What a run amounts to revolution by revolution, from the samples of its instruments and its events: the
// numbers that an experiment prints. Angles are in degrees of the crank, 0 ≤ angle < 360.
//
// Rules. The first `discard` seconds do not count; a turn begins there and lasts 2π/ω. The peak of a turn is
// the greatest |a| of its samples. A flight counts when the crank turns by at least `flight_angle` during it,
// an impact when it approaches at `impact_speed` or faster. The spectrum's line k is the root mean square
// over turns of the amplitude of the k-th harmonic of the turn; it is dominant when it reaches `line_share`
// of the ideal mechanism's greatest acceleration.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "sim/contact_log.hpp"

namespace freeplay {

struct TurnRules {
  double discard = 0;          ///< s
  double speed = 0;            ///< rad/s of the crank, ≠ 0
  double crank_start = 0;      ///< rad at t = 0
  double flight_angle = 2;     ///< degrees
  double impact_speed = 0.01;  ///< m/s
  double line_share = 0.05;
  double sampling = 0;       ///< Hz, of the accelerometer and of the position sensor
  double ideal_maximum = 0;  ///< m/s², through the same instrument
  int joint = 0;             ///< contact that flights and impacts are taken from
};

struct Flight {
  double loss = 0, angle = 0;  ///< degrees: where contact is lost, how far the crank turns until it returns
  double duration = 0;         ///< s
  double deceleration = 0;     ///< m/s², mean −d|v|/dt of the position's signal; NaN where too short
};
/// An impact that counts, as TurnRules have it.
struct CountedImpact {
  double angle = 0;     ///< degrees
  double approach = 0;  ///< m/s
  double impulse = 0;   ///< N s
};
struct TracePoint {
  double angle = 0, acceleration = 0, position = 0;  ///< degrees, m/s², m
};

/// Scalars of one run, in the order of names(). Those per turn are means over turns.
struct TurnMetrics {
  enum Name {
    peak_5,
    peak_median,
    peak_95,
    peak_max,
    ratio_median,
    ratio_95,
    ratio_max,
    rms,
    impacts_per_turn,
    flights_per_turn,
    flight_share,
    loss_angle,
    return_angle,
    flight_duration,
    deceleration,
    lines,
    lines_total,
    line_greatest,
    energy_per_turn,
    count
  };
  static const std::array<std::string_view, count>& names();
  std::array<double, count> value{};
  std::vector<double> peaks;  ///< m/s², of each turn
  std::vector<Flight> flights;
  std::vector<CountedImpact> impacts;
  std::vector<double> spectrum;  ///< m/s², amplitude of harmonic k+1
  std::vector<TracePoint> last_turn;
  std::vector<double> mean_turn;  ///< m/s², mean signal in each of mean_bins parts of the turn
};
inline constexpr int mean_bins = 720;

class TurnMeter {
 public:
  explicit TurnMeter(const TurnRules& rules) : rules_(rules) {}
  void event(const ContactEvent& e);
  void acceleration(double t, double value);
  void position(double t, double value);
  /// After the run. `energy_lost`: J, over the counted turns.
  TurnMetrics finish(double energy_lost) const;

 private:
  double degrees(double t) const;
  void flight(TurnMetrics& m, double from, double to) const;

  TurnRules rules_;
  std::vector<double> acceleration_, position_;  // at (first_ + i)/sampling
  long first_a_ = -1, first_x_ = -1;
  std::vector<std::pair<double, double>> flights_;  // s: loss, return
  std::vector<CountedImpact> impacts_;
  double left_at_ = -1;
};

/// The p-quantile of a sorted list, linear between its members.
double quantile(const std::vector<double>& sorted, double p);

/// Mean direction of angles in degrees, in [0, 360).
double mean_angle(const std::vector<double>& degrees);

/// Amplitudes of harmonics 1, 2, … below `highest` of a signal given over whole turns: root mean square over
/// the turns. `points` samples each turn; a turn may begin and end between samples.
std::vector<double> harmonics(const std::vector<double>& signal, double points, int turns, int highest);

}  // namespace freeplay
