#include "numerics/tangent_tape.hpp"

#include <algorithm>
#include <cmath>
#include <span>
#include <stdexcept>

namespace freeplay {
namespace {

/// A number and its derivative along the direction.
struct Differentiated {
  Traced value, slope;
};

/// Replays the operations of a function in the active trace.
class Replay {
 public:
  Replay(Trace& trace, const TracedObject& object, const TracedFunction& f, const TangentInputs& inputs)
      : trace_(trace), object_(object), nodes_(f.nodes), constants_(object.constants()), inputs_(inputs) {
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
  Traced look_up(const Node& n) const {
    const auto table =
        std::span(constants_).subspan(static_cast<std::size_t>(n.b), static_cast<std::size_t>(n.c));
    return n.operation == Operation::locate ? locate(at(n.a).value, table) : pick(at(n.a).value, table);
  }
  /// Numbers without derivatives: an argument itself, the results of a call, and each of them.
  Traced outside(const Node& n) {
    if (n.operation == Operation::argument) return at(n.a).value;
    if (n.operation == Operation::result) return results_[static_cast<std::size_t>(n.b)];
    std::vector<Traced> x;
    for (int i = n.a; i >= 0; i = nodes_[static_cast<std::size_t>(i)].b) x.push_back(at(i).value);
    std::ranges::reverse(x);
    results_ = trace_.call(object_.outside()[static_cast<std::size_t>(n.b)], x);
    return {};
  }
  Differentiated differentiated(const Node& n);

  Trace& trace_;
  const TracedObject& object_;
  const std::vector<Node>& nodes_;
  const std::vector<double>& constants_;
  const TangentInputs& inputs_;
  std::vector<Differentiated> pairs_;
  std::vector<Traced> results_;  // of the last call
};

Differentiated Replay::differentiated(const Node& n) {
  if (n.operation == Operation::constant) return constant(n);
  if (n.operation == Operation::input) return n.a < 0 ? Differentiated{} : input(n);
  if (n.operation >= Operation::argument) return {outside(n), 0};
  if (n.operation >= Operation::locate) return {look_up(n), 0};
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

void append_tangent(TracedObject& to, std::string_view name, const TracedObject& from,
                    const TracedFunction& f, const TangentInputs& inputs) {
  Trace trace(to, name);
  const Replay replay(trace, from, f, inputs);
  for (const auto& o : f.outputs) {
    const auto& slope = replay.at(o.node).slope;
    if (!slope.is_constant()) trace.output(o.array, o.index, slope);
  }
}

namespace {

template <class List>
auto& at(List& list, int i) {
  return list[static_cast<std::size_t>(i)];
}

}  // namespace

/// Chooses and orders the steps of a tape, and the places of their results.
class TangentTape::Builder {
 public:
  Builder(TangentTape& tape, const TracedObject& object, const TracedFunction& f, int first_direction)
      : tape_(tape),
        object_(object),
        nodes_(f.nodes),
        constants_(object.constants()),
        first_(first_direction),
        wide_(f.nodes.size()),
        uses_(f.uses()),
        place_(f.nodes.size(), -1) {
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      const auto& n = nodes_[i];
      wide_[i] = n.operation == Operation::input && n.a >= first_;
      n.each_operand([&](int x) { wide_[i] = wide_[i] || at(wide_, x); });
    }
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (uses_[i] > 0) add(static_cast<int>(i));
    for (auto g : f.guards) {
      g.a = at(place_, g.a);
      if (g.b >= 0) g.b = at(place_, g.b);
      tape_.guards_.push_back(g);
    }
    for (const auto& o : f.outputs) tape_.outputs_.push_back({o.array, o.index, block(o.node)});
    share_blocks();
  }

 private:
  using Node = TracedFunction::Node;

  void add(int i) {
    if (at(wide_, i))
      add_block(i);
    else
      add_value(i);
  }
  void add_value(int i) {
    const auto& n = at(nodes_, i);
    if (n.operation == Operation::argument) {
      at(place_, i) = at(place_, n.a);
      return;
    }
    if (n.operation == Operation::result) {
      at(place_, i) = at(place_, n.a) + n.b;
      return;
    }
    at(place_, i) = static_cast<int>(tape_.values_.size());
    tape_.values_.push_back(n.operation != Operation::constant ? 0 : n.a < 0 ? n.b : at(constants_, n.a));
    if (n.operation == Operation::constant) return;
    if (n.operation == Operation::outside) return add_call(i);
    if (n.operation == Operation::locate || n.operation == Operation::pick) {
      const auto from = constants_.begin() + n.b;
      tape_.value_steps_.push_back(
          {n.operation, at(place_, i), at(place_, n.a), static_cast<int>(tape_.tables_.size()), n.c});
      tape_.tables_.insert(tape_.tables_.end(), from, from + n.c);
      return;
    }
    const auto operand = [&](int x) { return x < 0 ? 0 : at(place_, x); };
    if (n.operation == Operation::input)
      tape_.value_steps_.push_back({n.operation, at(place_, i), n.a, n.b, 0});
    else
      tape_.value_steps_.push_back({n.operation, at(place_, i), operand(n.a), operand(n.b), operand(n.c)});
  }
  void add_call(int i) {
    const auto& n = at(nodes_, i);
    Call call{at(object_.outside(), n.b), {}, {}};
    for (int a = n.a; a >= 0; a = at(nodes_, a).b) call.arguments.push_back(at(place_, a));
    std::ranges::reverse(call.arguments);
    call.x.resize(call.arguments.size());
    tape_.values_.resize(tape_.values_.size() + call.function->results - 1);
    tape_.value_steps_.push_back({n.operation, at(place_, i), static_cast<int>(tape_.calls_.size()), 0, 0});
    tape_.calls_.push_back(std::move(call));
  }
  /// A product of a direction and a number that only this sum uses.
  bool is_own_product(int i) const {
    return at(wide_, i) && at(nodes_, i).operation == Operation::multiply && at(uses_, i) == 1;
  }
  std::pair<int, int> factors(int i) const {  // the direction first
    const auto& n = at(nodes_, i);
    return at(wide_, n.a) ? std::pair{n.a, n.b} : std::pair{n.b, n.a};
  }
  /// The block of a product, which is computed once another step needs it.
  int block(int i) {
    if (at(wide_, i) && at(place_, i) < 0) {
      const auto [direction, number] = factors(i);
      put(i, Kind::multiply, block(direction), -1, at(place_, number));
    }
    return at(wide_, i) ? at(place_, i) : -1;
  }
  void put(int i, Kind kind, int a, int b, int c) {
    at(place_, i) = blocks_++;
    tape_.block_steps_.push_back({kind, at(place_, i), a, b, c});
  }
  void add_block(int i) {
    const auto& n = at(nodes_, i);
    switch (n.operation) {
      case Operation::input:
        return put(i, Kind::input, n.a - first_, n.b, -1);
      case Operation::add:
      case Operation::subtract: {
        const bool plus = n.operation == Operation::add;
        int a = n.a, b = n.b;
        if (plus && !is_own_product(b)) std::swap(a, b);
        if (is_own_product(b) && a != b) {
          const auto [direction, number] = factors(b);
          return put(i, plus ? Kind::add_product : Kind::subtract_product, block(a), block(direction),
                     at(place_, number));
        }
        return put(i, plus ? Kind::add : Kind::subtract, block(n.a), block(n.b), -1);
      }
      case Operation::negate:
        return put(i, Kind::negate, block(n.a), -1, -1);
      case Operation::multiply:
        if (!is_own_product(i)) (void)block(i);
        return;
      case Operation::divide:
        return put(i, Kind::divide, block(n.a), -1, at(place_, n.b));
      case Operation::select:  // a number among the choices is 0
        return put(i, Kind::select, block(n.b), block(n.c), at(place_, n.a));
      default:
        throw std::logic_error("a derivative is not linear in its directions");
    }
  }
  /// Blocks take the places of others that no later step reads. Block 0 is zero.
  void share_blocks() {
    std::vector<int> last(static_cast<std::size_t>(blocks_), -1), home(static_cast<std::size_t>(blocks_), -1);
    const int steps = static_cast<int>(tape_.block_steps_.size());
    const auto blocks_of = [](const BlockStep& s, auto f) {
      if (s.kind == Kind::input) return;
      if (s.a >= 0) f(s.a);
      if (s.b >= 0) f(s.b);
    };
    for (int i = 0; i < steps; ++i) blocks_of(at(tape_.block_steps_, i), [&](int x) { at(last, x) = i; });
    for (const auto& o : tape_.outputs_) at(last, o.block) = steps;
    std::vector<int> open;
    int count = 1;
    for (int i = 0; i < steps; ++i) {
      auto& s = at(tape_.block_steps_, i);
      const auto was = s;
      if (s.kind != Kind::input) {
        s.a = was.a < 0 ? 0 : at(home, was.a);
        s.b = was.b < 0 ? 0 : at(home, was.b);
      }
      blocks_of(was, [&](int x) {
        if (at(last, x) != i) return;
        open.push_back(at(home, x));
        at(last, x) = -1;  // once, if both operands are the same
      });
      if (open.empty()) {
        s.out = count++;
      } else {
        s.out = open.back();
        open.pop_back();
      }
      at(home, was.out) = s.out;
    }
    for (auto& o : tape_.outputs_) o.block = at(home, o.block);
    tape_.blocks_.assign(static_cast<std::size_t>(count), Block::Zero());
  }

  TangentTape& tape_;
  const TracedObject& object_;
  const std::vector<Node>& nodes_;
  const std::vector<double>& constants_;
  int first_, blocks_ = 0;
  std::vector<char> wide_;
  std::vector<int> uses_, place_;
};

TangentTape::TangentTape(const TracedObject& object, const TracedFunction& f, int first_direction) {
  const Builder builder(*this, object, f, first_direction);
}

bool TangentTape::values(const double* const* in) {
  double* v = values_.data();
  for (const auto& s : value_steps_) {
    double& y = v[s.out];
    switch (s.operation) {
      case Operation::input:
        y = in[s.a][s.b];
        break;
      case Operation::add:
        y = v[s.a] + v[s.b];
        break;
      case Operation::subtract:
        y = v[s.a] - v[s.b];
        break;
      case Operation::multiply:
        y = v[s.a] * v[s.b];
        break;
      case Operation::divide:
        y = v[s.a] / v[s.b];
        break;
      case Operation::select:
        y = v[s.a] != 0 ? v[s.b] : v[s.c];
        break;
      case Operation::locate:
        y = static_cast<double>(std::upper_bound(&tables_[s.b], &tables_[s.b] + s.c, v[s.a]) - &tables_[s.b]);
        break;
      case Operation::pick:
        y = tables_[static_cast<std::size_t>(s.b) + static_cast<std::size_t>(v[s.a])];
        break;
      case Operation::outside: {
        auto& call = calls_[s.a];
        for (std::size_t i = 0; i < call.x.size(); ++i) call.x[i] = v[call.arguments[i]];
        call.function->evaluate(call.x.data(), &y);
        break;
      }
      default:
        y = result_of(s.operation, v[s.a], v[s.b]);
    }
  }
  for (const auto& g : guards_)
    if (g.b < 0 ? v[g.a] == 0 : relation_holds(v[g.a], g.relation, v[g.b]) != g.result) return false;
  return true;
}

void TangentTape::directions(const Block* const* in, Block* const* out) {
  Block* b = blocks_.data();
  const double* v = values_.data();
  for (const auto& s : block_steps_) {
    Block& y = b[s.out];
    switch (s.kind) {
      case Kind::input:
        y = in[s.a][s.b];
        break;
      case Kind::add:
        y = b[s.a] + b[s.b];
        break;
      case Kind::subtract:
        y = b[s.a] - b[s.b];
        break;
      case Kind::negate:
        y = -b[s.a];
        break;
      case Kind::multiply:
        y = b[s.a] * v[s.c];
        break;
      case Kind::divide:
        y = b[s.a] / v[s.c];
        break;
      case Kind::select:
        y = v[s.c] != 0 ? b[s.a] : b[s.b];
        break;
      case Kind::add_product:
        y = b[s.a] + b[s.b] * v[s.c];
        break;
      case Kind::subtract_product:
        y = b[s.a] - b[s.b] * v[s.c];
        break;
    }
  }
  for (const auto& o : outputs_) out[o.array][o.index] += b[o.block];
}

}  // namespace freeplay
