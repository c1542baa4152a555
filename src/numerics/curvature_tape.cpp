#include "numerics/curvature_tape.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// The interval functions that boost's lack, for numbers and for intervals.
double square_of(double x) { return x * x; }
Interval square_of(const Interval& x) { return square(x); }
bool is_zero(double x) { return x == 0; }
bool is_zero(const Interval& x) { return x.lower() == 0 && x.upper() == 0; }
double lower(double x) { return x; }
double lower(const Interval& x) { return x.lower(); }
double upper(double x) { return x; }
double upper(const Interval& x) { return x.upper(); }
std::optional<double> angle_of(double y, double x) {
  if (y == 0 && x == 0) return {};
  return std::atan2(y, x);
}

/// Result of a < b, a ≤ b or a = b; empty if it is not the same in the whole box.
template <class N>
std::optional<bool> relation(const N& a, Relation how, const N& b) {
  switch (how) {
    case Relation::less:
      if (upper(a) < lower(b)) return true;
      if (lower(a) >= upper(b)) return false;
      return {};
    case Relation::less_equal:
      if (upper(a) <= lower(b)) return true;
      if (lower(a) > upper(b)) return false;
      return {};
    case Relation::equal:
      if (lower(a) == upper(a) && lower(b) == upper(b) && lower(a) == lower(b)) return true;
      if (upper(a) < lower(b) || lower(a) > upper(b)) return false;
      return {};
  }
  return {};
}

/// A condition, 1 or 0; empty if it is undecided.
template <class N>
std::optional<bool> condition(const N& x) {
  if (lower(x) != upper(x)) return {};
  return lower(x) != 0;
}

template <class List>
auto& at(List& list, int i) {
  return list[static_cast<std::size_t>(i)];
}

bool is_linear(Operation operation) {
  switch (operation) {
    case Operation::input:
    case Operation::add:
    case Operation::subtract:
    case Operation::negate:
    case Operation::select:
    case Operation::max:
    case Operation::abs:
    case Operation::floor:
    case Operation::round:
      return true;
    default:
      return false;
  }
}

}  // namespace

template <class N>
CurvatureTape<N>::CurvatureTape(const TracedObject& object, const TracedFunction& f) : guards_(f.guards) {
  const auto uses = f.uses();
  const auto& constants = object.constants();
  steps_.resize(f.nodes.size());
  value_.assign(f.nodes.size(), N(0));
  for (std::size_t i = 0; i < f.nodes.size(); ++i) {
    const auto& n = f.nodes[i];
    auto& s = steps_[i];
    s = {n.operation, n.a, n.b, n.c};
    if (n.operation >= Operation::argument && uses[i] > 0)
      throw NotTraceable("a function calls code that is not traced");
    if (n.operation == Operation::constant) {
      value_[i] = n.a < 0 ? N(static_cast<double>(n.b)) : N(at(constants, n.a));
    } else if (n.operation == Operation::input) {
      s.varies = n.a >= 0;
      if (s.varies) variables_ = std::max(variables_, static_cast<std::size_t>(n.b) + 1);
    } else {
      n.each_operand([&](int x) { s.varies = s.varies || at(steps_, x).varies; });
    }
    if (n.operation == Operation::locate || n.operation == Operation::pick) {
      s.varies = false;  // constant within a piece
      s.b = static_cast<int>(tables_.size());
      tables_.insert(tables_.end(), constants.begin() + n.b, constants.begin() + n.b + n.c);
    }
    if (n.operation == Operation::floor || n.operation == Operation::round ||
        (n.operation >= Operation::less && n.operation < Operation::select))
      s.varies = false;
    if (uses[i] == 0) s = {Operation::constant, -1, -1, -1};
  }
  adjoint_.assign(steps_.size(), N(0));
  slope_ = bend_ = adjoint_;
  partials_.resize(steps_.size());
  int last = -1;
  for (const auto& o : f.outputs) last = std::max(last, o.index);
  outputs_.assign(static_cast<std::size_t>(last) + 1, 0);
  for (const auto& o : f.outputs) at(outputs_, o.index) = o.node;
  std::vector<char> needed;
  for (const int output : outputs_) {
    needed.assign(steps_.size(), 0);
    at(needed, output) = 1;
    auto& list = below_.emplace_back();
    for (int i = output; i >= 0; --i) {
      const auto& s = at(steps_, i);
      if (!at(needed, i) || !s.varies) continue;
      list.push_back(i);
      f.nodes[static_cast<std::size_t>(i)].each_operand([&](int x) { at(needed, x) = 1; });
    }
  }
  input_.assign(variables_, -1);
  above_.resize(variables_);
  bent_.assign(variables_, 0);
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (steps_[i].operation == Operation::input && steps_[i].varies)
      at(input_, f.nodes[i].b) = static_cast<int>(i);
  for (std::size_t v = 0; v < variables_; ++v) {
    if (input_[v] < 0) continue;
    needed.assign(steps_.size(), 0);
    at(needed, input_[v]) = 1;
    for (std::size_t i = 0; i < steps_.size(); ++i) {
      const auto& s = steps_[i];
      if (!s.varies) continue;
      if (s.operation != Operation::input)
        f.nodes[i].each_operand([&](int x) { needed[i] = needed[i] || at(needed, x); });
      if (!needed[i]) continue;
      above_[v].push_back(static_cast<int>(i));
      const bool scaled =
          s.operation == Operation::multiply && !(at(steps_, s.a).varies && at(steps_, s.b).varies);
      const bool divided = s.operation == Operation::divide && !at(steps_, s.b).varies;
      if (!is_linear(s.operation) && !scaled && !divided) bent_[v] = 1;
    }
  }
}

template <class N>
void CurvatureTape<N>::set_constants(std::span<const double> constants) {
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (steps_[i].operation == Operation::constant && steps_[i].a >= 0)
      value_[i] = constants[static_cast<std::size_t>(steps_[i].a)];
}

template <class N>
bool CurvatureTape<N>::decided(const TracedFunction::Guard& guard) const {
  if (guard.b < 0) {
    const auto holds = condition(at(value_, guard.a));
    return holds && *holds;
  }
  const auto result = relation(at(value_, guard.a), guard.relation, at(value_, guard.b));
  return result && *result == guard.result;
}

template <class N>
bool CurvatureTape<N>::apply(std::size_t i, std::span<const N> x) {
  using std::sin, std::cos, std::sqrt, std::exp, std::tanh, std::abs;
  const auto& s = steps_[i];
  N& y = value_[i];
  Partials& d = partials_[i];
  const auto& a = s.a >= 0 && s.operation != Operation::input ? at(value_, s.a) : y;
  const auto& b =
      s.b >= 0 && s.operation < Operation::locate && s.operation != Operation::input ? at(value_, s.b) : y;
  switch (s.operation) {
    case Operation::constant:
      return true;
    case Operation::input:
      y = s.varies ? at(x, s.b) : N(0);
      return true;
    case Operation::add:
      y = a + b;
      d.a = d.b = N(1);
      return true;
    case Operation::subtract:
      y = a - b;
      d.a = N(1), d.b = N(-1);
      return true;
    case Operation::multiply:
      y = s.a == s.b ? square_of(a) : N(a * b);
      d.a = b, d.b = a, d.ab = N(1);
      return true;
    case Operation::divide: {
      if (lower(b) <= 0 && upper(b) >= 0) return false;
      const N inverse = N(1) / b;
      y = a / b;
      d.a = inverse, d.b = -y * inverse, d.ab = -square_of(inverse), d.bb = N(2) * y * square_of(inverse);
      return true;
    }
    case Operation::negate:
      y = -a;
      d.a = N(-1);
      return true;
    case Operation::sqrt:
      if (!s.varies) {
        y = sqrt(a);
        return true;
      }
      if (!(lower(a) > 0)) return false;
      y = sqrt(a);
      d.a = N(0.5) / y, d.aa = N(-0.25) / (y * a);
      return true;
    case Operation::abs:
      if (lower(a) < 0 && upper(a) > 0) return false;
      y = abs(a);
      d.a = N(lower(a) >= 0 ? 1 : -1);
      return true;
    case Operation::sin:
      y = sin(a);
      d.a = cos(a), d.aa = -y;
      return true;
    case Operation::cos:
      y = cos(a);
      d.a = -sin(a), d.aa = -y;
      return true;
    case Operation::exp:
      y = exp(a);
      d.a = d.aa = y;
      return true;
    case Operation::tanh:
      y = tanh(a);
      d.a = N(1) - square_of(y), d.aa = N(-2) * y * d.a;
      return true;
    case Operation::floor:
    case Operation::round:
      if (result_of(s.operation, lower(a), 0) != result_of(s.operation, upper(a), 0)) return false;
      y = N(result_of(s.operation, lower(a), 0));
      return true;
    case Operation::atan2: {
      const auto angle = angle_of(a, b);
      if (!angle) return false;
      y = *angle;
      const N r = square_of(a) + square_of(b), rr = square_of(r);
      d.a = b / r, d.b = -a / r;
      d.aa = N(-2) * a * b / rr, d.bb = -d.aa, d.ab = (square_of(a) - square_of(b)) / rr;
      return true;
    }
    case Operation::max: {
      const auto less = relation(a, Relation::less, b);
      if (!less) return false;
      y = *less ? b : a;
      d.a = N(*less ? 0 : 1), d.b = N(*less ? 1 : 0);
      return true;
    }
    case Operation::less:
    case Operation::less_equal:
    case Operation::equal: {
      const auto how = s.operation == Operation::less         ? Relation::less
                       : s.operation == Operation::less_equal ? Relation::less_equal
                                                              : Relation::equal;
      const auto holds = relation(a, how, b);
      if (!holds) return false;
      y = N(*holds ? 1 : 0);
      return true;
    }
    case Operation::both:
    case Operation::either: {
      const auto one = condition(a), other = condition(b);
      if (!one || !other) return false;
      y = N((s.operation == Operation::both ? *one && *other : *one || *other) ? 1 : 0);
      return true;
    }
    case Operation::select: {
      const auto first = condition(a);
      if (!first) return false;
      y = *first ? b : at(value_, s.c);
      d.a = N(*first ? 1 : 0);  // of b; the other one is 1 − d.a
      return true;
    }
    case Operation::locate: {
      const auto* from = tables_.data() + s.b;
      const auto place = [&](double z) { return std::upper_bound(from, from + s.c, z) - from; };
      if (place(lower(a)) != place(upper(a))) return false;
      y = N(static_cast<double>(place(lower(a))));
      return true;
    }
    case Operation::pick:
      if (lower(a) != upper(a)) return false;
      y = N(tables_[static_cast<std::size_t>(s.b) + static_cast<std::size_t>(lower(a))]);
      return true;
    default:
      return false;
  }
}

template <class N>
bool CurvatureTape<N>::evaluate(std::span<const N> x) {
  for (std::size_t i = 0; i < steps_.size(); ++i)
    if (!apply(i, x)) return false;
  return std::ranges::all_of(guards_, [&](const auto& g) { return decided(g); });
}

template <class N>
template <class F>
void CurvatureTape<N>::each_operand(int i, F f) const {
  const auto& s = at(steps_, i);
  const auto& d = at(partials_, i);
  if (s.operation == Operation::input) return;
  if (s.operation == Operation::select) {
    const int from = is_zero(d.a) ? s.c : s.b;
    if (at(steps_, from).varies) f(from, N(1));
    return;
  }
  if (at(steps_, s.a).varies) f(s.a, d.a);
  if (s.b >= 0 && at(steps_, s.b).varies) f(s.b, d.b);
}

template <class N>
void CurvatureTape<N>::gradient(std::size_t k, std::span<N> g) {
  const auto& list = below_[k];
  std::ranges::fill(g, N(0));
  if (list.empty()) return;
  for (const int i : list) at(adjoint_, i) = N(0);
  at(adjoint_, list.front()) = N(1);
  for (const int i : list) {
    const N& y = at(adjoint_, i);
    if (at(steps_, i).operation == Operation::input) at(g, at(steps_, i).b) += y;
    each_operand(i, [&](int x, const N& by) { at(adjoint_, x) += y * by; });
  }
}

template <class N>
void CurvatureTape<N>::accumulate(std::span<const N> weights) {
  std::ranges::fill(adjoint_, N(0));
  for (std::size_t k = 0; k < outputs_.size(); ++k) at(adjoint_, outputs_[k]) += weights[k];
  for (int i = static_cast<int>(steps_.size()) - 1; i >= 0; --i) {
    if (!at(steps_, i).varies || is_zero(at(adjoint_, i))) continue;
    each_operand(i, [&](int x, const N& by) { at(adjoint_, x) += at(adjoint_, i) * by; });
  }
}

template <class N>
void CurvatureTape<N>::gradient(std::span<const N> weights, std::span<N> g) {
  accumulate(weights);
  for (std::size_t v = 0; v < variables_; ++v) g[v] = input_[v] < 0 ? N(0) : at(adjoint_, input_[v]);
}

template <class N>
void CurvatureTape<N>::second(std::span<const N> weights, std::vector<N>& H) {
  H.assign(variables_ * variables_, N(0));
  accumulate(weights);
  for (std::size_t v = 0; v < variables_; ++v) {
    if (!bent_[v]) continue;
    for (const int i : above_[v]) {
      at(slope_, i) = N(i == input_[v] ? 1 : 0);
      each_operand(i, [&](int x, const N& by) {
        if (!is_zero(at(slope_, x))) at(slope_, i) += at(slope_, x) * by;
      });
    }
    for (int i = static_cast<int>(steps_.size()) - 1; i >= 0; --i) {
      const auto& s = at(steps_, i);
      if (!s.varies) continue;
      N& y = at(bend_, i);
      if (s.operation == Operation::input) {
        at(H, static_cast<int>(v * variables_) + s.b) = y;
        y = N(0);
        continue;
      }
      if (!is_zero(y)) {
        each_operand(i, [&](int x, const N& by) { at(bend_, x) += y * by; });
        y = N(0);
      }
      const N& w = at(adjoint_, i);
      if (is_linear(s.operation) || is_zero(w)) continue;
      const auto& d = at(partials_, i);
      const N none(0);
      const N &da = at(slope_, s.a), &db = s.b >= 0 ? at(slope_, s.b) : none;
      if (is_zero(da) && is_zero(db)) continue;
      if (at(steps_, s.a).varies) at(bend_, s.a) += w * (d.aa * da + d.ab * db);
      if (s.b >= 0 && at(steps_, s.b).varies) at(bend_, s.b) += w * (d.ab * da + d.bb * db);
    }
    for (const int i : above_[v]) at(slope_, i) = N(0);
  }
}

template class CurvatureTape<double>;
template class CurvatureTape<Interval>;

}  // namespace freeplay
