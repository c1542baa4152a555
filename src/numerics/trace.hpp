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
// in turn. Each lane is bitwise identical to the function alone. Such functions return a bit for each
// lane in which a guard failed. One lane has plain numbers.
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
//
// An object may follow another one, `like`. As long as its functions record the same operations in the
// same order, each call is compared with that of the other function instead of being looked up, and the
// functions are shared. At the first difference the function is recorded as usual, so the result is the
// same in any case.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "numerics/traced.hpp"

namespace freeplay {

/// A compiled function. Returns 0, or 1 if a comparison has another result than at the sample; the
/// outputs are then undefined. With lanes: bit i for lane i.
using CompiledFunction = int (*)(const double* constants, const double* const* in, double* const* out);

/// The result of an operation on numbers; that of a condition is 1 or 0.
double result_of(Operation operation, double a, double b);
bool relation_holds(double a, Relation relation, double b);

/// The graph of one function. Numbers of nodes refer to `nodes`.
struct TracedFunction {
  struct Node {
    Operation operation;
    int a, b;  // operands; of an input its array and index; of a constant its slot
    int c;     // third operand, −1: none
    // A look-up has one operand a; b is the first slot of its table, c the number of entries. A call and its
    // results have one, too; b is the number of the function, or of the result.
    bool operator==(const Node&) const = default;
    /// Calls f with each operand.
    void each_operand(auto f) const {
      if (operation == Operation::constant || operation == Operation::input) return;
      f(a);
      if (operation >= Operation::locate && operation != Operation::argument) return;
      if (b >= 0) f(b);
      if (c >= 0) f(c);
    }
  };
  struct Guard {
    Relation relation;
    int a, b;  // b = −1: a is a condition
    bool result;
    int after;  // number of nodes when it was recorded
    bool operator==(const Guard&) const = default;
  };
  struct Output {
    int array, index, node;
    bool operator==(const Output&) const = default;
  };
  std::string name;
  std::vector<Node> nodes;
  std::vector<Guard> guards;
  std::vector<Output> outputs;
  /// How often operations use each node on which outputs and guards depend; 0 for other nodes. An output
  /// or guard counts as `by_result` uses.
  std::vector<int> uses(int by_result = 1) const;
  /// The node of each call of Trace::intern(), in their order. It follows from the calls, so it is not
  /// compared.
  std::vector<int> path;
  bool operator==(const TracedFunction& o) const {
    return name == o.name && nodes == o.nodes && guards == o.guards && outputs == o.outputs;
  }
};

/// The functions of one compiled object and the constants that they share.
class TracedObject {
 public:
  /// `lanes`: number of lanes, a power of two; 0: functions of plain numbers. `like`: an object to
  /// follow, or null.
  explicit TracedObject(int lanes = 0, const TracedObject* like = nullptr) : lanes_(lanes) {
    if (like) like_ = like->functions_;
  }
  /// An object to be differentiated (tangent_tape.hpp): no constant is folded, and each use of one has a
  /// slot of its own, so that the traces of two scenes that differ in parameters have the same slots.
  static TracedObject unshared() {
    TracedObject object;
    object.shares_ = false;
    return object;
  }
  int lanes() const { return lanes_; }
  /// C text of all functions, and of the table `freeplay_functions` of them in their order.
  std::string text() const;
  const std::vector<double>& constants() const { return constants_; }
  int functions() const { return static_cast<int>(functions_.size()); }
  const TracedFunction& function(int i) const { return *functions_[static_cast<std::size_t>(i)]; }
  /// Functions that are called.
  const std::vector<std::shared_ptr<const OutsideFunction>>& outside() const { return outside_; }
  /// Whether the last function depends on entries of an input array from this one on.
  bool last_reads_from(int array) const;
  /// Removes the last function.
  void drop_last() { functions_.pop_back(); }
  /// Whether the text of another object is the same; its constants may differ. Faster than the texts.
  bool same_structure(const TracedObject& o) const;

 private:
  friend class Trace;
  using Functions = std::vector<std::shared_ptr<const TracedFunction>>;
  int slot(double value);
  /// First of the slots of a table.
  int table(std::span<const double> values);

  std::vector<double> constants_;
  std::unordered_map<std::uint64_t, int> slot_;  // by the bits of the value
  std::map<std::vector<std::uint64_t>, int> tables_;
  std::vector<std::shared_ptr<const OutsideFunction>> outside_;
  Functions functions_, like_;
  int lanes_;
  bool shares_ = true;
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
  Traced look_up(Operation operation, const Traced& x, std::span<const double> values, double found);
  std::vector<Traced> call(std::shared_ptr<const OutsideFunction> function, std::span<const Traced> x);
  /// Whether the function is only differentiated.
  bool is_unshared() const { return !object_.shares_; }
  bool compare(const Traced& a, Relation relation, const Traced& b);
  static Trace* active();

 private:
  struct Hash {
    std::size_t operator()(const std::array<int, 4>& key) const {
      std::size_t h = 0;
      for (const int x : key) h = (h ^ static_cast<unsigned>(x)) * 0x9e3779b97f4a7c15u;
      return h ^ h >> 32;
    }
  };
  int node_of(const Traced& x);
  int operand(const Traced& x);
  int intern(Operation operation, int a, int b, int c = -1);
  int slot(double value);
  const std::vector<TracedFunction::Node>& nodes() const { return like_ ? like_->nodes : f_->nodes; }
  int size() const { return like_ ? followed_ : static_cast<int>(f_->nodes.size()); }
  /// The node of the next call if it is that of `like_`, or null.
  const TracedFunction::Node* expected() const {
    return next_ < like_->path.size() ? &like_->nodes[static_cast<std::size_t>(like_->path[next_])] : nullptr;
  }
  void stop_following();

  TracedObject& object_;
  std::shared_ptr<TracedFunction> f_;
  std::shared_ptr<const TracedFunction> like_;  // while it is followed; its nodes are not in f_
  std::size_t next_ = 0;                        // call in the path of like_
  int followed_ = 0;                            // nodes of like_ that were recorded
  Trace* outer_;
  int exceptions_;
  std::unordered_map<std::array<int, 4>, int, Hash> known_;  // nodes
};

}  // namespace freeplay
