// Poincaré sections of a run: the state at selected instants,
//
//     period      t_k = from + k T,   k = 1, 2, …                   (stroboscopic)
//     crossing    s(q(t)) = 0; s is a coordinate or relative angle minus a value, rising or falling
//     touch       the onset of a contact, from the contact log
//
// The state at an instant within a step is taken from the method's dense output. A crossing is the
// root of s on it (Alefeld, Potra and Shi's algorithm 748, ACM Trans. Math. Softw. 21 (1995) 327).
// If both ends of a step are on one side and the rates show that s has an extremum between them,
// the extremum is located first, so that a grazing motion counts twice or not at all. s is carried
// from step to step: a crossing is counted once, also if a projection moved the state across it.
//
// Convention: at the instant of an impact the state is the one before the impact. Angles cross a
// value once in every turn. Observed runs are bitwise identical to others.
#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

struct Phase;

/// One value of the state: a coordinate, a difference of two coordinates, the position of a translational
/// joint, or a value of a contact.
struct StateColumn {
  enum class Kind {
    coordinate,  ///< q[first] − q[second] (m, rad), or the value of `travel`
    rate,        ///< v[first] − v[second], or the rate of `travel`
    ex,          ///< m, eccentricity of the contact `first`, world axes
    ey,          ///< m
    gap,         ///< m
    ex_c,        ///< ex over the clearance of a journal bearing, computed as gap + |e|
    ey_c,
    phase,    ///< share of the period, from 0 to 1
    approach  ///< m/s, rate at which the gap closes at the onset
  };
  Kind kind = Kind::coordinate;
  int first = -1, second = -1;  ///< −1: none
  bool angle = false;           ///< rad, reported within (−π, π]
  /// Position of a translational joint along its axis (dynamics/phase.hpp); null for other columns.
  std::shared_ptr<const Phase> travel = {};
  /// The period of a cyclic value: 2π for an angle, 1 for a phase; 0 if it is not cyclic.
  double circle() const;
  /// The coordinate (angles of any number of turns) and its rate, whatever the kind.
  double coordinate(std::span<const double> q, std::span<const double> v) const;
  double rate(std::span<const double> q, std::span<const double> v) const;
};

/// Selection of the instants.
struct SectionRule {
  enum class Kind { period, crossing, touch };
  enum class Direction { upwards, downwards, either };
  Kind kind = Kind::period;
  double period = 0;      ///< s, T, also the period of phases; 0: none
  double from = 0;        ///< s
  StateColumn what = {};  ///< the crossing value s
  double value = 0;       ///< m or rad
  Direction direction = Direction::either;
  std::vector<int> contacts = {};  ///< contacts whose onsets are used; empty: all
};

/// The points of a section, one row of columns each. begin() of another run appends to them.
class SectionPoints final : public Observer {
 public:
  /// Greatest number of stored points; further points are only counted.
  static constexpr std::size_t most = 1'000'000;

  /// `discard` (s): earlier points are not stored.
  SectionPoints(SectionRule rule, std::vector<StateColumn> columns, double discard);

  std::size_t size() const { return t_.size(); }
  double t(std::size_t i) const { return t_[i]; }  ///< s
  std::span<const double> row(std::size_t i) const {
    return {rows_.data() + i * columns_.size(), columns_.size()};
  }
  /// Number of missing points: onsets whose state was no longer stored when they became final.
  long lost() const { return lost_; }
  /// Points beyond `most`.
  long beyond() const { return beyond_; }

  /// Time (s) before which no step is needed, except the last one before it. Sections that follow() get
  /// all steps otherwise.
  double next() const {
    return follows() ? INFINITY : rule_.from + static_cast<double>(index_) * rule_.period;
  }
  /// Whether it needs the states of all steps.
  bool follows() const { return rule_.kind != SectionRule::Kind::period; }

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void event(const Event& event) override;

 private:
  /// The state at the end of a step, for onsets that become final later.
  struct Place {
    double t = 0;
    bool in_impact = false;  // whether the step has impacts within
    std::vector<double> q, v;
  };
  void each_period(const Step& step);
  void crossings(const Step& step);
  void cross(const Step& step, double a, double b, double s_a, double s_b);
  void keep_place(const Step& step);
  void settle_touches(const Step& step);
  bool touched(double t);
  const Place& place(long index) const { return places_[static_cast<std::size_t>(index) % places_.size()]; }
  double distance(std::span<const double> q, std::span<const double> v) const;
  double distance_at(const Step& step, double t);
  void point(const Step& step, double t);
  void keep(const Step& step, double t, double approach);

  SectionRule rule_;
  std::vector<StateColumn> columns_;
  double discard_;
  bool wants_contacts_ = false;
  long index_ = 1;               // of the next period
  double begin_ = 0, last_ = 0;  // begin_: s; last_: value of s at the end of the last step
  std::vector<double> q_, v_;
  std::vector<ContactPlace> contacts_;
  std::vector<Place> places_;  // ring buffer
  long newest_ = -1;
  std::vector<ContactEvent> touches_;  // not yet processed
  long lost_ = 0, beyond_ = 0;
  std::vector<double> t_, rows_;
};

}  // namespace freeplay
