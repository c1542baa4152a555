// Closing of a mechanism: the pose nearest to a rough one in a metric (movable_rows.hpp), with
// Φ(q, 0) = 0 and all contacts inside their clearance. Held coordinates keep their values.
#pragma once

#include <mutex>
#include <vector>

#include "dynamics/assembly/movable_rows.hpp"
#include "values/stop.hpp"

namespace freeplay {

struct Mechanism;
class System;

/// To be held while Ipopt solves: MUMPS, the linear solver of Debian's Ipopt, has global state.
std::unique_lock<std::mutex> ipopt_lock();

/// Length scale of a mechanism, to which errors of positions are related.
double length_scale(const System& system);

class Closing {
 public:
  Closing(const Mechanism& mechanism, const System& system, const StopToken& stop, Metric metric);

  /// Finds the pose nearest to q. Returns false if none was found; `best` is then the best pose
  /// that is not closed.
  bool close(std::vector<double>& q, std::vector<double>& best) const;
  /// Closes q from an arbitrary start, for which a nearest pose has no meaning.
  bool close_from(std::vector<double>& q) const;
  /// The pose nearest to `rough` by Newton's method from q, which is closed or nearly so.
  bool approach(const std::vector<double>& rough, std::vector<double>& q) const;
  /// Newton steps of least length onto Φ = 0, to rounding accuracy.
  void close_exactly(std::vector<double>& q) const;
  /// Removes whole turns that a search added.
  void unwind_to(const std::vector<double>& given, std::vector<double>& q) const;

  /// The greatest violation or overlap at q (m or rad).
  double open(const std::vector<double>& q) const;
  /// The greatest violation of a joint as a length (m).
  double worst(const std::vector<double>& q) const;
  double length() const { return length_; }
  /// Violations up to this are closed (m or rad).
  double accepted() const { return accepted_; }

 private:
  bool move(const std::vector<double>& rough, std::vector<double>& q) const;
  std::vector<int> left_out(const std::vector<double>& q) const;

  const Mechanism& mechanism_;
  const System& system_;
  const StopToken& stop_;
  Metric metric_;
  double length_, accepted_;
};

}  // namespace freeplay
