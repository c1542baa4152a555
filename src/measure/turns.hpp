// Metrics of a run per turn (revolution) of its crank, from the samples of its instruments and its
// contact events. They are the quantities that experiments publish. Angles are in degrees of the
// crank, 0 ≤ angle < 360.
//
// Definitions:
// - Start: the first `discard` seconds are excluded.
// - Turns: metrics of samples are taken over whole turns. A turn begins with the first included
//   sample and lasts 2π/|ω|. Metrics of events are taken over the whole included time; "per turn"
//   then means per 2π/|ω| of it.
// - Peak of a turn: the greatest |a| of its samples.
// - Flight: counted at its end, if the crank turned by at least `flight_angle` during it. The share
//   of flights is a share of the time and includes all flights.
// - Impact: counted if its approach speed is at least `impact_speed`.
// - Spectrum: line k is the root mean square over turns of the amplitude of harmonic k, each from
//   the samples of its turn (harmonics.hpp), up to 0.4 of the sampling rate. A line is dominant if
//   it reaches `line_share` times the greatest acceleration of the ideal mechanism.
// - Mean turn: the complex mean of the same harmonics, c_h = (1/N) Σ_k c_hk. Its root mean square
//   is √(|c_0|² + 2 Σ |c_h|²), its peak the greatest |a| of mean_bins parts.
//
// With several contacts, flights and impacts are counted together, and the share of flights is the
// mean of the contacts' shares. With the speed 2π/T, a turn is a period T of any motion, and angles
// are its phase. With speed 0 there are no turns: all flights count, and samples give only the
// greatest value and the root mean square.
//
// Use: pass events and samples to a TurnMeter in the order of time, then call finish(). The meter
// owns all samples of the run.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "measure/harmonics.hpp"
#include "values/event.hpp"

namespace freeplay {

/// Least flights, impacts and spectral lines that count, by the definitions above.
struct TurnThresholds {
  double flight_angle = 2;     ///< degrees
  double impact_speed = 0.01;  ///< m/s
  double line_share = 0.05;
};

/// Parameters of the definitions above.
struct TurnRules {
  double discard = 0;      ///< s
  double speed = 0;        ///< rad/s of the crank; negative: its angle decreases; 0: no turns
  double crank_start = 0;  ///< rad at t = 0
  TurnThresholds thresholds;
  double sampling = 0;       ///< Hz, of the position sensor; accelerations come with their times
  double ideal_maximum = 0;  ///< m/s², of the ideal mechanism through the same instrument
  int joint = 0;  ///< contact whose flights and impacts are counted; −1: none, the metrics are NaN
  std::vector<int> others = {};  ///< further contacts whose flights and impacts are counted
};

/// A flight between two contacts.
struct Flight {
  /// degrees: angle at the loss of contact; angle of the crank until contact returns
  double loss = 0, angle = 0;
  double duration = 0;  ///< s
  /// m/s², mean −d|v|/dt of the position signal; NaN if the flight is too short
  double deceleration = 0;
  int contact = 0;  ///< index of the contact
};
/// An impact that is counted, as defined above.
struct CountedImpact {
  double angle = 0;     ///< degrees
  double approach = 0;  ///< m/s
  double impulse = 0;   ///< N s
  int contact = 0;      ///< index of the contact
};
/// One sample of the last turn.
struct TracePoint {
  double angle = 0, acceleration = 0, position = 0;  ///< degrees, m/s², m
};

/// Metrics of one run. The scalars are in the order of names(); those per turn are means over
/// turns.
struct TurnMetrics {
  /// The scalars of a run: peaks and spectra in m/s², ratios to the ideal maximum, angles in
  /// degrees, energy in J. docs/reference/study.md defines each.
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
    mean_turn_rms,
    mean_turn_peak,
    energy_per_turn,
    count
  };
  static const std::array<std::string_view, count>& names();
  /// Range of a metric; means and intervals are computed accordingly.
  enum class Kind { real, positive, share, direction };
  static Kind kind(Name name);
  std::array<double, count> value{};
  std::vector<double> peaks;  ///< m/s², of each turn
  std::vector<Flight> flights;
  std::vector<CountedImpact> impacts;
  std::vector<double> spectrum;  ///< m/s², amplitude of harmonic k+1
  std::vector<TracePoint> last_turn;
  std::vector<Harmonics> turns;   ///< m/s², harmonics of each turn over the crank angle
  std::vector<double> mean_turn;  ///< m/s², mean signal in each of mean_bins parts of the turn
};
/// Number of parts of the mean turn.
inline constexpr int mean_bins = 720;

/// Number of whole turns (of `turn` s) among n ≥ 2 uniform samples that span `span` s. The first
/// sample is at the beginning of a turn, so N turns of P samples each need ⌊N P⌋ samples.
int whole_turns(std::size_t n, double span, double turn);

/// Accumulates events and samples of a run, and computes its metrics.
class TurnMeter {
 public:
  explicit TurnMeter(const TurnRules& rules) : rules_(rules), touching_(1 + rules.others.size()) {}
  /// Records an event, in the order of time. Before its first event a contact counts as open,
  /// unless that event is its separation.
  void event(const ContactEvent& e);
  void acceleration(double t, double value);
  void position(double t, double value);
  /// Computes the metrics after the run, which ended at `end` (s). `energy_lost`: J, dissipated
  /// after the discarded time.
  TurnMetrics finish(double end, double energy_lost) const;

 private:
  double degrees(double t) const;
  double turn() const;                         // s
  std::size_t first_of(int whole_turn) const;  // sample
  struct Touching {
    double left_at = 0;  // s, start of the present flight; NaN in contact
    bool lost = false;   // whether the start of the present flight was observed
  };
  struct Flown {
    double from = 0, to = 0;  // s
    int contact = 0;
  };
  void touch(Touching& one, int contact, double t, double until);
  void flight(TurnMetrics& m, const Flown& flown) const;
  void whole_window(TurnMetrics& m) const;
  void peaks(TurnMetrics& m, int turns) const;
  void contacts(TurnMetrics& m, double end) const;
  void harmonics(TurnMetrics& m, int turns) const;
  void last_turn(TurnMetrics& m) const;

  TurnRules rules_;
  std::vector<double> times_, acceleration_;  // s, m/s²
  std::vector<double> position_;              // at (first_x_ + i)/sampling
  long first_x_ = -1;
  std::vector<Flown> flights_;
  std::vector<CountedImpact> impacts_;
  double flown_ = 0;                // s, included flight time of all contacts
  std::vector<Touching> touching_;  // of `joint` and `others`
};

/// p-quantile of a sorted list, by linear interpolation between its members.
double quantile(const std::vector<double>& sorted, double p);

/// Mean direction of angles in degrees, in [0, 360).
double mean_angle(const std::vector<double>& degrees);
/// The angle in degrees, reduced to [0, 360) by the first and to [−180, 180) by the second.
double whole_circle(double degrees);
double half_circle(double degrees);

}  // namespace freeplay
