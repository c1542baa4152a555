#include "numerics/trace_tangent.hpp"

namespace freeplay {
namespace {

/// A number and its derivative along the direction.
struct Differentiated {
  Traced value, slope;
};

/// Replays the operations of a function in the active trace.
class Replay {
 public:
  Replay(Trace& trace, const TracedFunction& f, const std::vector<double>& constants,
         const TangentInputs& inputs)
      : trace_(trace), nodes_(f.nodes), constants_(constants), inputs_(inputs) {
    pairs_.reserve(nodes_.size());
    std::size_t g = 0;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      pairs_.push_back(differentiated(nodes_[i]));
      for (; g < f.guards.size() && f.guards[g].after <= static_cast<int>(i) + 1; ++g) check(f.guards[g]);
    }
  }
  const Differentiated& at(int node) const { return pairs_[static_cast<std::size_t>(node)]; }

 private:
  using Node = TracedFunction::Node;

  void check(const TracedFunction::Guard& g) {
    if (g.b < 0)
      trace_.require(at(g.a).value);
    else
      (void)compare(at(g.a).value, g.relation, at(g.b).value);
  }
  Differentiated constant(const Node& n) {
    const auto slot = static_cast<std::size_t>(n.a);
    const int index = inputs_.varied[slot];
    if (index < 0) return {constants_[slot], 0};
    return {trace_.input(inputs_.varied_values, index, constants_[slot]),
            trace_.input(inputs_.varied_directions, index, 0)};
  }
  Differentiated input(const Node& n) {
    const auto array = static_cast<std::size_t>(n.a);
    const auto value = trace_.input(n.a, n.b, inputs_.values[array][static_cast<std::size_t>(n.b)]);
    const int direction = inputs_.directions[array];
    return {value, direction < 0 ? Traced(0) : trace_.input(direction, n.b, 0)};
  }
  /// Sine or cosine of the operand of a node.
  Traced turned(Operation operation, const Node& n) {
    const auto& x = nodes_[static_cast<std::size_t>(n.a)];
    const auto& value = at(n.a).value;
    if (x.operation == Operation::input && inputs_.known)
      if (const auto other = inputs_.known(operation, x.a, x.b))
        return trace_.input(other->first, other->second, result_of(operation, value.value, 0));
    return record(operation, value);
  }
  Differentiated differentiated(const Node& n);

  Trace& trace_;
  const std::vector<Node>& nodes_;
  const std::vector<double>& constants_;
  const TangentInputs& inputs_;
  std::vector<Differentiated> pairs_;
};

Differentiated Replay::differentiated(const Node& n) {
  if (n.operation == Operation::constant) return constant(n);
  if (n.operation == Operation::input) return n.a < 0 ? Differentiated{} : input(n);
  const auto& [a, da] = at(n.a);
  const auto [b, db] = n.b < 0 ? Differentiated{} : at(n.b);
  switch (n.operation) {
    case Operation::add:
      return {a + b, da + db};
    case Operation::subtract:
      return {a - b, da - db};
    case Operation::multiply:
      return {a * b, da * b + a * db};
    case Operation::divide: {
      const Traced y = a / b;
      return {y, (da - y * db) * (Traced(1) / b)};
    }
    case Operation::negate:
      return {-a, -da};
    case Operation::sqrt: {
      const Traced y = sqrt(a);
      if (da.is_constant()) return {y, 0};
      return {y, da * select(holds(Traced(0), Relation::less, y), Traced(0.5) / y, Traced(0))};
    }
    case Operation::abs:
      if (da.is_constant()) return {abs(a), 0};
      return {abs(a), select(holds(a, Relation::less, Traced(0)), -da, da)};
    case Operation::sin:
      return {turned(Operation::sin, n), da.is_constant() ? Traced(0) : da * turned(Operation::cos, n)};
    case Operation::cos:
      return {turned(Operation::cos, n), da.is_constant() ? Traced(0) : -(da * turned(Operation::sin, n))};
    case Operation::exp: {
      const Traced y = exp(a);
      return {y, da * y};
    }
    case Operation::tanh: {
      const Traced y = tanh(a);
      return {y, da * (Traced(1) - y * y)};
    }
    case Operation::atan2:
      return {atan2(a, b), (b * da - a * db) * (Traced(1) / (a * a + b * b))};
    case Operation::max: {
      if (da.is_constant() && db.is_constant()) return {max(a, b), 0};
      return {max(a, b), select(holds(a, Relation::less, b), db, da)};
    }
    case Operation::select: {
      const auto& [c, dc] = at(n.c);
      const bool still = db.is_constant() && dc.is_constant();
      return {select(a, b, c), still ? Traced(0) : select(a, db, dc)};
    }
    default:  // conditions
      return {record(n.operation, a, b), 0};
  }
}

}  // namespace

void append_tangent(TracedObject& to, std::string_view name, const TracedFunction& f,
                    const std::vector<double>& constants, const TangentInputs& inputs) {
  Trace trace(to, name);
  const Replay replay(trace, f, constants, inputs);
  for (const auto& o : f.outputs) {
    const auto& slope = replay.at(o.node).slope;
    if (!slope.is_constant()) trace.output(o.array, o.index, slope);
  }
}

}  // namespace freeplay
