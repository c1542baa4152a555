// Poincaré sections of a run: the state at chosen instants,
//
//     every period      t_k = from + k T,   k = 1, 2, …                   (stroboscopic)
//     a crossing        s(q(t)) = 0, s a coordinate or an angle between two bodies less a value, rising or falling
//     each touch        the first instant of a contact, as the contact log has it
//
// at instants that lie within a step, by the method's own dense output: never at the nearest row. A crossing is the root of
// s on it (Alefeld, Potra and Shi's algorithm 748, ACM Trans. Math. Softw. 21 (1995) 327); where the ends of a step lie on
// one side and the rates say that s turned round between them, the turn is found first, so that a graze counts twice or
// not at all. The coordinate is carried from step to step: one crossing is counted once, also where a projection moved it.
//
// Sign convention: at an instant at which something is struck the state is the one before the impact. Angles cross a value
// in every turn. Watching changes no digit of the run.
#pragma once

#include <span>
#include <vector>

#include "simulation/observer.hpp"

namespace freeplay {

/// A place in the state: a coordinate, or the difference of two, or what a contact shows.
struct StateColumn {
  enum class Kind {
    coordinate,  ///< q[first] − q[second] (m, rad)
    rate,        ///< v[first] − v[second]
    ex,          ///< m, of the contact `first`: eccentricity, world axes
    ey,          ///< m
    gap,         ///< m
    ex_c,  ///< ex over the clearance of a journal in its bearing, which is its gap and its eccentricity together
    ey_c,
    phase,    ///< share of the period, from 0 to 1
    approach  ///< m/s, of the touch: rate at which the gap closes
  };
  Kind kind = Kind::coordinate;
  int first = -1, second = -1;  ///< −1: none
  bool angle = false;           ///< rad: told within (−π, π]
  /// The length of its circle, 0 for what lies on a line: 2π of an angle, 1 of a phase.
  double circle() const;
};

/// Which instants.
struct SectionRule {
  enum class Kind { period, crossing, touch };
  enum class Direction { upwards, downwards, either };
  Kind kind = Kind::period;
  double period = 0;      ///< s, T; also the one that phases count by, 0: none
  double from = 0;        ///< s
  StateColumn what = {};  ///< what crosses
  double value = 0;       ///< m or rad
  Direction direction = Direction::either;
  std::vector<int> contacts = {};  ///< whose touches; empty: of all
};

/// The section's points, a row of columns each; begin() of another run goes on behind what is there.
class SectionPoints final : public Observer {
 public:
  /// Further ones are counted and not kept: memory has an end.
  static constexpr std::size_t most = 1'000'000;

  /// `discard`: s, before which no point is kept.
  SectionPoints(SectionRule rule, std::vector<StateColumn> columns, double discard);

  std::size_t size() const { return t_.size(); }
  double t(std::size_t i) const { return t_[i]; }  ///< s
  std::span<const double> row(std::size_t i) const {
    return {rows_.data() + i * columns_.size(), columns_.size()};
  }
  /// Touches whose state was not kept any more when they were settled; then a point is missing.
  long lost() const { return lost_; }
  /// Points beyond `most`.
  long beyond() const { return beyond_; }

  void begin(const Layout& layout, const State& state) override;
  void step(const Step& step) override;
  void event(const Event& event) override;

 private:
  /// The end of a step, for touches that are settled later.
  struct Place {
    double t = 0;
    bool struck = false;  // the step has impacts within it
    std::vector<double> q, v;
  };
  void each_period(const Step& step);
  void crossings(const Step& step);
  void cross(const Step& step, double a, double b, double s_a, double s_b);
  void keep_place(const Step& step);
  void settle_touches(const Step& step);
  bool touched(double t);
  const Place& place(long index) const { return places_[static_cast<std::size_t>(index) % places_.size()]; }
  double distance(std::span<const double> q) const;
  double rate(std::span<const double> v) const;
  double distance_at(const Step& step, double t);
  void point(const Step& step, double t);
  void keep(const Step& step, double t, double approach);

  SectionRule rule_;
  std::vector<StateColumn> columns_;
  double discard_;
  bool wants_contacts_ = false;
  long index_ = 1;               // of the next period
  double begin_ = 0, last_ = 0;  // s; of what crosses, at the last step's end
  std::vector<double> q_, v_;
  std::vector<ContactPlace> contacts_;
  std::vector<Place> places_;  // a ring
  long newest_ = -1;
  std::vector<ContactEvent> touches_;  // not yet told
  long lost_ = 0, beyond_ = 0;
  std::vector<double> t_, rows_;
};

}  // namespace freeplay
