// Trace: the graph of operations that Traced numbers leave behind, for one compiled function
//
//     int f(const double* constants, const double* const* in, double* const* out)
//
// with several input and output arrays. Equal operations share a node. Constants other than 0 and
// ±1 are slots of a table that all functions of one object share (TracedObject), so the C text, from
// which the key of the cache is made, contains no value of a parameter: scenes that differ in
// parameters only share one object.
//
// An object for lanes has functions that do several computations side by side, each in its lane, with
// vector types of the compiler: all arrays, and the table of constants, have one number for each lane
// in turn. Each lane has the digits that the function has alone. Such functions return a bit for each
// lane in which a guard failed.
//
// Usage:
//
//     TracedObject object;
//     {
//       Trace trace(object, "place");
//       std::vector<Traced> q = trace.inputs(1, values);   // input array 1
//       ...                                                // evaluate templates
//       trace.output(0, 3, x);                             // output array 0, entry 3
//     }                                                    // appends the function to the object
//     object.text();
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <unordered_map>
#include <utility>
#include <vector>

#include "numerics/traced.hpp"

namespace freeplay {

/// A compiled function. Returns 0, or 1 if a comparison has another result than at the sample; the
/// outputs are then undefined. With lanes: bit i for lane i.
using CompiledFunction = int (*)(const double* constants, const double* const* in, double* const* out);

/// The functions of one compiled object and the constants that they share.
class TracedObject {
 public:
  /// `lanes`: number of lanes, a power of two; 0: functions of plain numbers.
  explicit TracedObject(int lanes = 0) : lanes_(lanes) {}
  int lanes() const { return lanes_; }
  /// C text of all functions, and of the table `freeplay_functions` of them in their order.
  std::string text() const;
  const std::vector<double>& constants() const { return constants_; }
  int functions() const { return static_cast<int>(names_.size()); }
  /// Number of operations of all functions.
  long operations() const { return operations_; }

 private:
  friend class Trace;
  int slot(double value);

  std::vector<double> constants_;
  std::unordered_map<std::uint64_t, int> slot_;  // by the bits of the value
  std::vector<std::string> names_;
  std::string functions_;
  long operations_ = 0;
  int lanes_;
};

class Trace {
 public:
  Trace(TracedObject& object, std::string_view name);
  /// Appends the function to its object, unless an exception is in flight.
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  Traced input(int array, int index, double value);
  std::vector<Traced> inputs(int array, std::span<const double> values);
  /// The present content of an output entry. An output that still is its own old content is not
  /// written.
  Traced old(int array, int index);
  void output(int array, int index, const Traced& x);
  void outputs(int array, std::span<const Traced> x);

  /// Adds a guard that fails where a condition does not hold, whatever it is at the sample.
  void require(const Traced& condition);

  /// Used by Traced.
  Traced record(Operation operation, const Traced& a, const Traced& b);
  Traced choose(const Traced& condition, const Traced& a, const Traced& b);
  bool compare(const Traced& a, Relation relation, const Traced& b);
  static Trace* active();

 private:
  struct Node {
    Operation operation;
    int a, b;  // operands; of an input its array and index; of a constant its slot
    int c;     // third operand, −1: none
  };
  struct Guard {
    Relation relation;
    int a, b;  // b = −1: a is a condition
    bool result;
    int after;  // number of nodes when it was recorded
  };
  struct Output {
    int array, index, node;
  };
  int node_of(const Traced& x);
  int operand(const Traced& x);
  int intern(Operation operation, int a, int b, int c = -1);
  std::string name_of(int node) const;
  std::string expression(const Node& node) const;
  std::string failing(const Guard& guard) const;
  bool is_condition(int node) const;
  void write();

  TracedObject& object_;
  std::string name_;
  Trace* outer_;
  int exceptions_;
  std::vector<Node> nodes_;
  std::map<std::tuple<int, int, int, int>, int> known_;
  std::vector<Guard> guards_;
  std::vector<Output> outputs_;
};

}  // namespace freeplay
