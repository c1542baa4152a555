// What a run amounts to revolution by revolution, from the samples of its instruments and its events: the
// numbers that an experiment prints. Angles are in degrees of the crank, 0 ≤ angle < 360.
//
// Rules. The first `discard` seconds do not count. What samples give is of the whole turns among them: a turn
// begins with the first sample that counts and lasts 2π/|ω|. What events give is of all the time that counts, and
// per turn means per 2π/|ω| of it, whole or not. The peak of a turn is the greatest |a| of its samples. A flight
// counts where it ends, when the crank has turned by at least `flight_angle` during it, an impact when it
// approaches at `impact_speed` or faster; the share of flights is of the time, whether they count or not. The
// spectrum's line k is the root mean square over turns of the amplitude of the k-th harmonic of the turn, from
// its own samples (harmonics.hpp), below 0.4 of the sampling; it is dominant when it reaches `line_share` of the
// ideal mechanism's greatest acceleration. The mean turn is that of the same harmonics, each averaged with its phase over the
// turns: c_h = (1/N) Σ_k c_hk, its root mean square √(|c_0|² + 2 Σ |c_h|²), its peak the greatest |a| of mean_bins parts.
//
// Of several contacts flights and impacts are counted together, and the share of flights is the mean of theirs. A turn need not
// be a crank's: with the speed 2π/T it is a period, and angles are phases of it. Without one (speed 0) there are no angles,
// every flight counts, and of what samples give only the greatest and the root mean square are left, of all that count.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "measure/harmonics.hpp"
#include "values/event.hpp"

namespace freeplay {

struct TurnRules {
  double discard = 0;  ///< s
  double speed = 0;    ///< rad/s of the crank; negative: it turns backwards through its angles; 0: no turns
  double crank_start = 0;      ///< rad at t = 0
  double flight_angle = 2;     ///< degrees
  double impact_speed = 0.01;  ///< m/s
  double line_share = 0.05;
  double sampling = 0;       ///< Hz, of the position sensor; the accelerometer's samples say when they are
  double ideal_maximum = 0;  ///< m/s², through the same instrument
  int joint = 0;  ///< contact that flights and impacts are taken from; −1: none is known, they are NaN
  std::vector<int> others = {};  ///< contacts that they are taken from beside it
};

struct Flight {
  double loss = 0, angle = 0;  ///< degrees: where contact is lost, how far the crank turns until it returns
  double duration = 0;         ///< s
  double deceleration = 0;     ///< m/s², mean −d|v|/dt of the position's signal; NaN where too short
  int contact = 0;             ///< whose it is
};
/// An impact that counts, as TurnRules have it.
struct CountedImpact {
  double angle = 0;     ///< degrees
  double approach = 0;  ///< m/s
  double impulse = 0;   ///< N s
  int contact = 0;      ///< whose it is
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
    mean_turn_rms,
    mean_turn_peak,
    energy_per_turn,
    count
  };
  static const std::array<std::string_view, count>& names();
  /// What values a statistic can take: its means and intervals are made accordingly.
  enum class Kind { real, positive, share, direction };
  static Kind kind(Name name);
  std::array<double, count> value{};
  std::vector<double> peaks;  ///< m/s², of each turn
  std::vector<Flight> flights;
  std::vector<CountedImpact> impacts;
  std::vector<double> spectrum;  ///< m/s², amplitude of harmonic k+1
  std::vector<TracePoint> last_turn;
  std::vector<Harmonics> turns;   ///< m/s², of each turn against the crank's angle
  std::vector<double> mean_turn;  ///< m/s², mean signal in each of mean_bins parts of the turn
};
inline constexpr int mean_bins = 720;

/// Whole turns (of `turn` s) among n ≥ 2 even samples that span `span` s. Turns of P samples each have N·P of them, rounded
/// down where they begin with a sample.
int whole_turns(std::size_t n, double span, double turn);

class TurnMeter {
 public:
  explicit TurnMeter(const TurnRules& rules) : rules_(rules), touching_(1 + rules.others.size()) {}
  /// In the order of time. Before its first event a contact is taken to be open, unless that is its loss.
  void event(const ContactEvent& e);
  void acceleration(double t, double value);
  void position(double t, double value);
  /// After the run, which ended at `end` (s). `energy_lost`: J, since the discarded time.
  TurnMetrics finish(double end, double energy_lost) const;

 private:
  double degrees(double t) const;
  double turn() const;                         // s
  std::size_t first_of(int whole_turn) const;  // sample
  struct Touching {
    double left_at = 0;  // s, of the present flight; NaN in contact
    bool lost = false;   // the present flight's beginning was seen
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
  double flown_ = 0;                // s, of the time that counts, of all contacts
  std::vector<Touching> touching_;  // of `joint` and `others`
};

/// The p-quantile of a sorted list, linear between its members.
double quantile(const std::vector<double>& sorted, double p);

/// Mean direction of angles in degrees, in [0, 360).
double mean_angle(const std::vector<double>& degrees);
/// An angle in degrees, in [0, 360), and in [−180, 180).
double whole_circle(double degrees);
double half_circle(double degrees);

}  // namespace freeplay
