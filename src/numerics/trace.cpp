#include "numerics/trace.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <exception>
#include <utility>

namespace freeplay {
namespace {

thread_local Trace* active_trace = nullptr;

/// Arrays of old contents of outputs are numbered below those of inputs.
constexpr int old_arrays = -1000;

bool is(const Traced& x, double constant) { return x.is_constant() && x.value == constant; }

}  // namespace

double result_of(Operation operation, double a, double b) {
  switch (operation) {
    case Operation::add:
      return a + b;
    case Operation::subtract:
      return a - b;
    case Operation::multiply:
      return a * b;
    case Operation::divide:
      return a / b;
    case Operation::negate:
      return -a;
    case Operation::sqrt:
      return std::sqrt(a);
    case Operation::abs:
      return std::abs(a);
    case Operation::sin:
      return std::sin(a);
    case Operation::cos:
      return std::cos(a);
    case Operation::exp:
      return std::exp(a);
    case Operation::tanh:
      return std::tanh(a);
    case Operation::floor:
      return std::floor(a);
    case Operation::round:
      return std::round(a);
    case Operation::atan2:
      return std::atan2(a, b);
    case Operation::max:
      return std::max(a, b);
    case Operation::less:
      return a < b ? 1 : 0;
    case Operation::less_equal:
      return a <= b ? 1 : 0;
    case Operation::equal:
      return a == b ? 1 : 0;
    case Operation::both:
      return a != 0 && b != 0 ? 1 : 0;
    case Operation::either:
      return a != 0 || b != 0 ? 1 : 0;
    default:
      throw std::logic_error("no operation of numbers");
  }
}

bool relation_holds(double a, Relation relation, double b) {
  switch (relation) {
    case Relation::less:
      return a < b;
    case Relation::less_equal:
      return a <= b;
    default:
      return a == b;
  }
}

Traced record(Operation operation, const Traced& a, const Traced& b) {
  if (a.is_constant() && b.is_constant()) return {result_of(operation, a.value, b.value)};
  return Trace::active()->record(operation, a, b);
}

bool compare(const Traced& a, Relation relation, const Traced& b) {
  if (a.is_constant() && b.is_constant()) return relation_holds(a.value, relation, b.value);
  return Trace::active()->compare(a, relation, b);
}

Traced holds(const Traced& a, Relation relation, const Traced& b) {
  return record(relation == Relation::less         ? Operation::less
                : relation == Relation::less_equal ? Operation::less_equal
                                                   : Operation::equal,
                a, b);
}

Traced select(const Traced& condition, const Traced& a, const Traced& b) {
  if (condition.is_constant()) return condition.value != 0 ? a : b;
  return Trace::active()->choose(condition, a, b);
}

void require(const Traced& condition) {
  if (!condition.is_constant()) return Trace::active()->require(condition);
  if (condition.value == 0) throw NotTraceable("a condition never holds");
}

Traced locate(const Traced& x, std::span<const double> knots) {
  const auto found = static_cast<double>(std::ranges::upper_bound(knots, x.value) - knots.begin());
  if (x.is_constant() || knots.empty()) return {found};
  return Trace::active()->look_up(Operation::locate, x, knots, found);
}

Traced pick(const Traced& index, std::span<const double> column) {
  const double found = column[static_cast<std::size_t>(index.value)];
  if (index.is_constant() || std::ranges::all_of(column, [](double x) { return x == 0; })) return {found};
  return Trace::active()->look_up(Operation::pick, index, column, found);
}

void only_differentiated(const char* reason) {
  if (!Trace::active()->is_unshared()) throw NotTraceable(reason);
}

std::vector<Traced> call_outside(OutsideFunction function, std::span<const Traced> x, const char* reason) {
  only_differentiated(reason);
  return Trace::active()->call(std::make_shared<const OutsideFunction>(std::move(function)), x);
}

double value_of(const Traced& x) {
  if (!x.is_constant()) throw NotTraceable("a place is found by iteration");
  return x.value;
}

Trace* Trace::active() {
  if (!active_trace) throw std::logic_error("a traced number without a trace");
  return active_trace;
}

bool TracedObject::same_structure(const TracedObject& o) const {
  return lanes_ == o.lanes_ && std::ranges::equal(functions_, o.functions_, [](const auto& a, const auto& b) {
           return a == b || *a == *b;
         });
}

Trace::Trace(TracedObject& object, std::string_view name)
    : object_(object),
      f_(std::make_shared<TracedFunction>()),
      outer_(std::exchange(active_trace, this)),
      exceptions_(std::uncaught_exceptions()) {
  const auto place = object.functions_.size();
  if (place < object.like_.size() && object.like_[place]->name == name) like_ = object.like_[place];
  f_->name = name;
}

Trace::~Trace() {
  active_trace = outer_;
  if (std::uncaught_exceptions() != exceptions_) return;
  if (like_ && next_ == like_->path.size() && f_->guards == like_->guards && f_->outputs == like_->outputs) {
    object_.functions_.push_back(std::move(like_));
    return;
  }
  stop_following();
  object_.functions_.push_back(std::move(f_));
}

int TracedObject::slot(double value) {
  if (!shares_) {
    constants_.push_back(value);
    return static_cast<int>(constants_.size()) - 1;
  }
  const auto [at, is_new] =
      slot_.try_emplace(std::bit_cast<std::uint64_t>(value), static_cast<int>(constants_.size()));
  if (is_new) constants_.push_back(value);
  return at->second;
}

std::vector<int> TracedFunction::uses(int by_result) const {
  std::vector<int> list(nodes.size(), 0);
  const auto use = [&](int node, int times) { list[static_cast<std::size_t>(node)] += times; };
  for (const auto& o : outputs) use(o.node, by_result);
  for (const auto& g : guards) {
    use(g.a, by_result);
    if (g.b >= 0) use(g.b, by_result);
  }
  for (std::size_t i = nodes.size(); i-- > 0;)
    if (list[i] > 0) nodes[i].each_operand([&](int node) { use(node, 1); });
  return list;
}

bool TracedObject::last_reads_from(int array) const {
  const auto& f = *functions_.back();
  const auto uses = f.uses();
  for (std::size_t i = 0; i < f.nodes.size(); ++i)
    if (uses[i] > 0 && f.nodes[i].operation == Operation::input && f.nodes[i].a >= array) return true;
  return false;
}

int TracedObject::table(std::span<const double> values) {
  if (!shares_) {
    constants_.insert(constants_.end(), values.begin(), values.end());
    return static_cast<int>(constants_.size() - values.size());
  }
  std::vector<std::uint64_t> bits;
  for (const double x : values) bits.push_back(std::bit_cast<std::uint64_t>(x));
  const auto [at, is_new] = tables_.try_emplace(std::move(bits), static_cast<int>(constants_.size()));
  if (is_new) constants_.insert(constants_.end(), values.begin(), values.end());
  return at->second;
}

/// The slot of a constant, without looking it up if it is the expected one.
int Trace::slot(double value) {
  if (const auto* next = like_ ? expected() : nullptr; next && next->operation == Operation::constant) {
    const auto& known = object_.constants_;
    const auto at = static_cast<std::size_t>(next->a);  // large if negative
    if (at < known.size() && std::bit_cast<std::uint64_t>(known[at]) == std::bit_cast<std::uint64_t>(value))
      return next->a;
  }
  return object_.slot(value);
}

int Trace::intern(Operation operation, int a, int b, int c) {
  const TracedFunction::Node node{operation, a, b, c};
  if (!object_.shares_) {
    f_->nodes.push_back(node);
    return size() - 1;
  }
  if (like_) {
    // All calls so far were those of like_, so an equal call has the same node.
    if (const auto* next = expected(); next && *next == node) {
      const int found = like_->path[next_++];
      followed_ = std::max(followed_, found + 1);
      return found;
    }
    stop_following();
  }
  const auto [at, is_new] = known_.try_emplace(std::array{static_cast<int>(operation), a, b, c}, size());
  if (is_new) f_->nodes.push_back(node);
  f_->path.push_back(at->second);
  return at->second;
}

void Trace::stop_following() {
  if (!like_) return;
  f_->nodes.assign(like_->nodes.begin(), like_->nodes.begin() + followed_);
  f_->path.assign(like_->path.begin(), like_->path.begin() + static_cast<long>(next_));
  like_ = nullptr;
  for (const auto& n : f_->nodes)
    known_.emplace(std::array{static_cast<int>(n.operation), n.a, n.b, n.c}, static_cast<int>(known_.size()));
}

/// 0 and ±1 are written into the text: they are structure rather than parameters.
int Trace::node_of(const Traced& x) {
  if (!x.is_constant()) return x.node;
  if (!object_.shares_) return intern(Operation::constant, object_.slot(x.value), 0);
  for (const double plain : {0.0, 1.0, -1.0})
    if (x.value == plain) return intern(Operation::constant, -1, static_cast<int>(plain));
  return intern(Operation::constant, slot(x.value), 0);
}

Traced Trace::input(int array, int index, double value) {
  Traced x(value);
  x.node = intern(Operation::input, array, index);
  return x;
}

std::vector<Traced> Trace::inputs(int array, std::span<const double> values) {
  std::vector<Traced> list;
  for (const double x : values) list.push_back(input(array, static_cast<int>(list.size()), x));
  return list;
}

Traced Trace::old(int array, int index) { return input(old_arrays + array, index, 0); }

void Trace::output(int array, int index, const Traced& x) {
  const int node = node_of(x);
  if (node == old(array, index).node) return;
  f_->outputs.push_back({array, index, node});
}

void Trace::outputs(int array, std::span<const Traced> x) {
  for (std::size_t i = 0; i < x.size(); ++i) output(array, static_cast<int>(i), x[i]);
}

/// An output's old content is no operand, because it depends on earlier calls.
int Trace::operand(const Traced& x) {
  const int node = node_of(x);
  if (nodes()[node].operation == Operation::input && nodes()[node].a < 0)
    throw NotTraceable("an element reads a quantity that another element has not set");
  return node;
}

Traced Trace::record(Operation operation, const Traced& a, const Traced& b) {
  const auto negative = [&](const Traced& x) { return freeplay::record(Operation::negate, x); };
  if (object_.shares_) switch (operation) {
      case Operation::add:
        if (is(a, 0)) return b;
        if (is(b, 0)) return a;
        break;
      case Operation::subtract:
        if (is(b, 0)) return a;
        if (is(a, 0)) return negative(b);
        break;
      case Operation::multiply:
        if (is(a, 0) || is(b, 0)) return {0};
        if (is(a, 1)) return b;
        if (is(b, 1)) return a;
        if (is(a, -1)) return negative(b);
        if (is(b, -1)) return negative(a);
        break;
      case Operation::divide:
        if (is(a, 0)) return {0};
        if (is(b, 1)) return a;
        if (is(b, -1)) return negative(a);
        break;
      case Operation::both:
        if (a.is_constant()) return a.value != 0 ? b : a;
        if (b.is_constant()) return b.value != 0 ? a : b;
        break;
      case Operation::either:
        if (a.is_constant()) return a.value != 0 ? a : b;
        if (b.is_constant()) return b.value != 0 ? b : a;
        break;
      default:
        break;
    }
  Traced x(result_of(operation, a.value, b.value));
  const bool two = operation <= Operation::divide || operation >= Operation::atan2;
  int left = operand(a), right = -1;
  if (operation == Operation::negate && nodes()[left].operation == Operation::negate) {
    x.node = nodes()[left].a;
    return x;
  }
  if (two) right = operand(b);
  // The rounding of a sum or product does not depend on the order of its two operands.
  if ((operation == Operation::add || operation == Operation::multiply) && right < left)
    std::swap(left, right);
  x.node = intern(operation, left, right);
  return x;
}

Traced Trace::choose(const Traced& condition, const Traced& a, const Traced& b) {
  Traced x(condition.value != 0 ? a.value : b.value);
  const int on = operand(condition), left = operand(a);
  x.node = intern(Operation::select, on, left, operand(b));
  return x;
}

Traced Trace::look_up(Operation operation, const Traced& x, std::span<const double> values, double found) {
  Traced result(found);
  const int at = operand(x);
  result.node = intern(operation, at, object_.table(values), static_cast<int>(values.size()));
  return result;
}

std::vector<Traced> Trace::call(std::shared_ptr<const OutsideFunction> function, std::span<const Traced> x) {
  int last = -1;
  std::vector<double> in, out(function->results);
  for (const auto& argument : x) {
    const int node = operand(argument);
    last = intern(Operation::argument, node, last);
    in.push_back(argument.value);
  }
  function->evaluate(in.data(), out.data());
  const int call = intern(Operation::outside, last, static_cast<int>(object_.outside_.size()));
  object_.outside_.push_back(std::move(function));
  std::vector<Traced> results(out.begin(), out.end());
  for (std::size_t i = 0; i < out.size(); ++i)
    results[i].node = intern(Operation::result, call, static_cast<int>(i));
  return results;
}

void Trace::require(const Traced& condition) {
  if (condition.is_constant()) return freeplay::require(condition);
  f_->guards.push_back({Relation::equal, operand(condition), -1, true, size()});
}

bool Trace::compare(const Traced& a, Relation relation, const Traced& b) {
  const bool holds = relation_holds(a.value, relation, b.value);
  const TracedFunction::Guard guard{relation, operand(a), operand(b), holds, size()};
  const bool known = std::ranges::any_of(f_->guards, [&](const TracedFunction::Guard& g) {
    return g.relation == guard.relation && g.a == guard.a && g.b == guard.b;
  });
  if (!known) f_->guards.push_back(guard);
  return holds;
}

}  // namespace freeplay
