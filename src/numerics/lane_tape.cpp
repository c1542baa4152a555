#include "numerics/lane_tape.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "numerics/wide_registers.hpp"

#ifdef __x86_64__
#include <emmintrin.h>
#endif

namespace freeplay {
namespace {

using Step = LaneTape::Step;
using Quadruple = double __attribute__((vector_size(32), may_alias));
using Marks = long long __attribute__((vector_size(32), may_alias));
using Whole = long long __attribute__((may_alias));

/// Codes of steps: those of Operation, and these.
enum TapeCode {
  sum_with_product = static_cast<int>(Operation::pick) + 1,  // a + b c
  difference_with_product,                                   // a − b c
  product_less,                                              // b c − a
  copied,
  // guards, which fail where a and b are not so
  needs_less,
  needs_less_equal,
  needs_equal,
  needs_not_less,
  needs_not_less_equal,
  needs_not_equal,
  needs_condition,
  end_of_tape,
  tape_codes
};
/// Rooms of −1, 0 and 1.
constexpr int constants_of_structure = 3;

/// Functions of the math library, look-ups, and roots, which are rounded correctly alone and together.
void each(double (*f)(double), const Step& s, int lanes) {
  for (int i = 0; i < lanes; ++i) s.result[i] = f(s.a[i]);
}
void each_angle(const Step& s, int lanes) {
  for (int i = 0; i < lanes; ++i) s.result[i] = std::atan2(s.a[i], s.b[i]);
}
void each_root(const Step& s, int lanes) {
#ifdef __x86_64__
  for (int i = 0; i < lanes; i += 2) _mm_store_pd(s.result + i, _mm_sqrt_pd(_mm_load_pd(s.a + i)));
#else
  each(std::sqrt, s, lanes);
#endif
}
/// std::upper_bound among the knots from b to c of each lane.
void each_place(const Step& s, int lanes) {
  for (int lane = 0; lane < lanes; ++lane) {
    const double* knots = s.b + lane;
    const double x = s.a[lane];
    long left = (s.c - s.b) / lanes, place = 0;
    while (left > 0) {
      const long half = left / 2;
      if (x < knots[(place + half) * lanes]) {
        left = half;
      } else {
        place += half + 1;
        left -= half + 1;
      }
    }
    reinterpret_cast<Whole*>(s.result)[lane] = place;
  }
}
/// The entry of each lane's column from b on.
void each_entry(const Step& s, int lanes) {
  for (int lane = 0; lane < lanes; ++lane)
    s.result[lane] = s.b[reinterpret_cast<const Whole*>(s.a)[lane] * lanes + lane];
}

// clang-format off
#define FREEPLAY_QUADS _Pragma("GCC unroll 4") for (int i = 0; i < quads; ++i)
#define FREEPLAY_NEXT goto*(++s)->code  // NOLINT(bugprone-macro-parentheses)

/// Does all steps for 4·quads lanes. Returns a bit for each lane in which a guard failed. Without
/// steps: gives the address of each code.
template <int quads>
FREEPLAY_WIDE int evaluate(const Step* s, const void* const** addresses) {
  static const void* const codes[tape_codes] = {
      nullptr, nullptr, &&add, &&subtract, &&multiply, &&divide, &&negate, &&sqrt, &&abs, &&sin, &&cos, &&exp,
      &&tanh, &&floor, &&round, &&atan2, &&max, &&less, &&at_most, &&equal, &&both, &&either, &&select,
      &&locate, &&pick, &&sum, &&difference, &&product_less, &&copy, &&no_less, &&no_at_most, &&no_equal,
      &&any_less, &&any_at_most, &&any_equal, &&condition, &&end};
  if (!s) {
    *addresses = codes;
    return 0;
  }
  constexpr int lanes = 4 * quads;
  Marks bad[quads]{};
  const Quadruple *a, *b, *c;
  Quadruple* y;
  const auto take = [&] {
    a = reinterpret_cast<const Quadruple*>(s->a);
    b = reinterpret_cast<const Quadruple*>(s->b);
    c = reinterpret_cast<const Quadruple*>(s->c);
    y = reinterpret_cast<Quadruple*>(s->result);
  };
  goto*s->code;

  add: take(); FREEPLAY_QUADS y[i] = a[i] + b[i]; FREEPLAY_NEXT;
  subtract: take(); FREEPLAY_QUADS y[i] = a[i] - b[i]; FREEPLAY_NEXT;
  multiply: take(); FREEPLAY_QUADS y[i] = a[i] * b[i]; FREEPLAY_NEXT;
  divide: take(); FREEPLAY_QUADS y[i] = a[i] / b[i]; FREEPLAY_NEXT;
  negate: take(); FREEPLAY_QUADS y[i] = -a[i]; FREEPLAY_NEXT;
  sum: take(); FREEPLAY_QUADS y[i] = a[i] + b[i] * c[i]; FREEPLAY_NEXT;
  difference: take(); FREEPLAY_QUADS y[i] = a[i] - b[i] * c[i]; FREEPLAY_NEXT;
  product_less: take(); FREEPLAY_QUADS y[i] = b[i] * c[i] - a[i]; FREEPLAY_NEXT;
  copy: take(); FREEPLAY_QUADS y[i] = a[i]; FREEPLAY_NEXT;
  abs: take(); FREEPLAY_QUADS y[i] = (Quadruple)((Marks)a[i] & 0x7fffffffffffffffLL); FREEPLAY_NEXT;
  max: take();
    FREEPLAY_QUADS {
      const Marks m = a[i] < b[i];
      y[i] = (Quadruple)((m & (Marks)b[i]) | (~m & (Marks)a[i]));
    }
    FREEPLAY_NEXT;
  select: take();
    FREEPLAY_QUADS {
      const Marks m = (Marks)c[i];
      y[i] = (Quadruple)((m & (Marks)a[i]) | (~m & (Marks)b[i]));
    }
    FREEPLAY_NEXT;
  less: take(); FREEPLAY_QUADS y[i] = (Quadruple)(a[i] < b[i]); FREEPLAY_NEXT;
  at_most: take(); FREEPLAY_QUADS y[i] = (Quadruple)(a[i] <= b[i]); FREEPLAY_NEXT;
  equal: take(); FREEPLAY_QUADS y[i] = (Quadruple)(a[i] == b[i]); FREEPLAY_NEXT;
  both: take(); FREEPLAY_QUADS y[i] = (Quadruple)((Marks)a[i] & (Marks)b[i]); FREEPLAY_NEXT;
  either: take(); FREEPLAY_QUADS y[i] = (Quadruple)((Marks)a[i] | (Marks)b[i]); FREEPLAY_NEXT;
  no_less: take(); FREEPLAY_QUADS bad[i] |= ~(a[i] < b[i]); FREEPLAY_NEXT;
  no_at_most: take(); FREEPLAY_QUADS bad[i] |= ~(a[i] <= b[i]); FREEPLAY_NEXT;
  no_equal: take(); FREEPLAY_QUADS bad[i] |= ~(a[i] == b[i]); FREEPLAY_NEXT;
  any_less: take(); FREEPLAY_QUADS bad[i] |= a[i] < b[i]; FREEPLAY_NEXT;
  any_at_most: take(); FREEPLAY_QUADS bad[i] |= a[i] <= b[i]; FREEPLAY_NEXT;
  any_equal: take(); FREEPLAY_QUADS bad[i] |= a[i] == b[i]; FREEPLAY_NEXT;
  condition: take(); FREEPLAY_QUADS bad[i] |= ~(Marks)a[i]; FREEPLAY_NEXT;
  sqrt: each_root(*s, lanes); FREEPLAY_NEXT;
  sin: each(std::sin, *s, lanes); FREEPLAY_NEXT;
  cos: each(std::cos, *s, lanes); FREEPLAY_NEXT;
  exp: each(std::exp, *s, lanes); FREEPLAY_NEXT;
  tanh: each(std::tanh, *s, lanes); FREEPLAY_NEXT;
  floor: each(std::floor, *s, lanes); FREEPLAY_NEXT;
  round: each(std::round, *s, lanes); FREEPLAY_NEXT;
  atan2: each_angle(*s, lanes); FREEPLAY_NEXT;
  locate: each_place(*s, lanes); FREEPLAY_NEXT;
  pick: each_entry(*s, lanes); FREEPLAY_NEXT;
end:
  int bits = 0;
  for (int i = 0; i < lanes; ++i) bits |= bad[i / 4][i % 4] != 0 ? 1 << i : 0;
  return bits;
}
#undef FREEPLAY_NEXT
#undef FREEPLAY_QUADS
// clang-format on

template <class List>
decltype(auto) item(List& list, int i) {
  return list[static_cast<std::size_t>(i)];
}

}  // namespace

bool LaneTape::usable() {
#ifdef __x86_64__
  return has_wide_registers;
#else
  return true;
#endif
}

bool LaneTape::Call::looks_up() const {
  return code == static_cast<int>(Operation::locate) || code == static_cast<int>(Operation::pick);
}

void LaneTape::Call::each_operand(auto f) const {
  f(a);
  if (looks_up()) return;
  if (b >= 0) f(b);
  if (c >= 0) f(c);
}

/// Chooses and orders the calls.
class LaneTape::Builder {
 public:
  Builder(std::vector<Call>& calls, const TracedFunction& f)
      : calls_(calls), nodes_(f.nodes), uses_(f.uses(2)), joined_(nodes_.size()) {
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (uses_[i] > 0) join(nodes_[i]);
    auto guard = f.guards.begin();
    const auto guards_until = [&](std::size_t node) {
      for (; guard != f.guards.end() && static_cast<std::size_t>(guard->after) <= node; ++guard) add(*guard);
    };
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      guards_until(i);
      if (uses_[i] > 0 && !joined_[i]) add(static_cast<int>(i));
    }
    guards_until(nodes_.size());
    order();
  }

 private:
  /// Calls whose operands are computed equally early follow each other: they do not wait for each other.
  void order() {
    std::vector<int> level(nodes_.size());
    std::vector<std::pair<int, Call>> list;
    for (const auto& call : calls_) {
      int at = 0;
      call.each_operand([&](int node) { at = std::max(at, item(level, node) + 1); });
      if (call.result >= 0) item(level, call.result) = at;
      list.emplace_back(at, call);
    }
    std::ranges::stable_sort(list, {}, [](const auto& x) { return std::pair{x.first, x.second.code}; });
    std::ranges::transform(list, calls_.begin(), [](const auto& x) { return x.second; });
  }
  /// A product that is used once.
  bool is_own_product(int node) const {
    return item(nodes_, node).operation == Operation::multiply && item(uses_, node) == 1;
  }
  /// Chooses the product that a sum or difference computes.
  void join(const TracedFunction::Node& n) {
    if (n.operation != Operation::add && n.operation != Operation::subtract) return;
    if (is_own_product(n.b))
      item(joined_, n.b) = true;
    else if (is_own_product(n.a))
      item(joined_, n.a) = true;
  }
  void add(const TracedFunction::Guard& g) {
    const int code = g.b < 0                              ? needs_condition
                     : g.relation == Relation::less       ? needs_less
                     : g.relation == Relation::less_equal ? needs_less_equal
                                                          : needs_equal;
    calls_.push_back({g.b < 0 || g.result ? code : code + needs_not_less - needs_less, g.a, g.b, -1, -1});
  }
  void add(int node) {
    const auto& n = item(nodes_, node);
    const int code = static_cast<int>(n.operation);
    const bool plus = n.operation == Operation::add;
    const auto with_product = [&](int sum, int other, int product) {
      calls_.push_back({sum, other, item(nodes_, product).a, item(nodes_, product).b, node});
    };
    if (n.operation == Operation::constant || n.operation == Operation::input) return;
    if (n.operation == Operation::select)
      calls_.push_back({code, n.b, n.c, n.a, node});
    else if (!plus && n.operation != Operation::subtract)
      calls_.push_back({code, n.a, n.b, n.c, node});
    else if (item(joined_, n.b))
      with_product(plus ? sum_with_product : difference_with_product, n.a, n.b);
    else if (item(joined_, n.a))
      with_product(plus ? sum_with_product : product_less, n.b, n.a);
    else
      calls_.push_back({code, n.a, n.b, -1, node});
  }

  std::vector<Call>& calls_;
  const std::vector<TracedFunction::Node>& nodes_;
  std::vector<int> uses_;
  std::vector<bool> joined_;  // products that a sum computes
};

/// Finds the addresses for the arrays of a call.
class LaneTape::Assembler {
 public:
  explicit Assembler(LaneTape& tape)
      : tape_(tape), home_(tape.nodes_.size()), last_(tape.nodes_.size(), -1), room_(tape.nodes_.size(), -1) {
    tape_.evaluate_(nullptr, &codes_);
    for (std::size_t i = 0; i < tape_.calls_.size(); ++i)
      tape_.calls_[i].each_operand([&](int node) { item(last_, node) = static_cast<int>(i); });
    for (const auto& o : tape_.outputs_) item(last_, o.node) = static_cast<int>(tape_.calls_.size());
    find_homes();
    for (std::size_t i = 0; i < tape_.calls_.size(); ++i) add(static_cast<int>(i));
    // An input that is an output may be overwritten by another one.
    for (const auto& o : tape_.outputs_)
      if (item(tape_.nodes_, o.node).operation == Operation::input && item(room_, o.node) < 0)
        item(home_, o.node) = copy(home(o.node), room(o.node));
    for (const auto& o : tape_.outputs_)
      if (home(o.node) != output(o)) copy(home(o.node), output(o));
    tape_.steps_.push_back({codes_[end_of_tape], nullptr, nullptr, nullptr, nullptr});
  }

 private:
  double* output(const TracedFunction::Output& o) const {
    return item(tape_.out_, o.array) + static_cast<std::ptrdiff_t>(o.index) * tape_.lanes_;
  }
  double* constant(int slot) const {
    return const_cast<double*>(tape_.constants_) + static_cast<std::ptrdiff_t>(slot) * tape_.lanes_;
  }
  /// Homes of constants, inputs, and of results that are written to their outputs at once.
  void find_homes() {
    std::map<const double*, int> taken;  // by inputs and outputs
    for (std::size_t i = 0; i < home_.size(); ++i) {
      const auto& n = tape_.nodes_[i];
      if (n.operation == Operation::constant) home_[i] = n.a >= 0 ? constant(n.a) : tape_.room(n.b + 1);
      if (n.operation != Operation::input || n.a < 0) continue;
      if (n.a >= static_cast<int>(tape_.in_.size())) continue;  // not needed
      home_[i] = const_cast<double*>(item(tape_.in_, n.a)) + static_cast<std::ptrdiff_t>(n.b) * tape_.lanes_;
      taken[home_[i]] += 2;
    }
    for (const auto& o : tape_.outputs_) ++taken[output(o)];
    for (const auto& o : tape_.outputs_)
      if (double* place = output(o); !item(home_, o.node) && taken[place] == 1) item(home_, o.node) = place;
  }
  void add(int number) {
    const auto& call = item(tape_.calls_, number);
    const Step step{codes_[call.code], home(call.a), second(call), third(call), nullptr};
    tape_.steps_.push_back(step);
    call.each_operand([&](int node) {
      if (item(last_, node) == number && item(room_, node) >= 0)
        free_.push_back(std::exchange(item(room_, node), -1));
    });
    if (call.result < 0) return;
    if (!item(home_, call.result)) item(home_, call.result) = room(call.result);
    tape_.steps_.back().result = item(home_, call.result);
  }
  double* copy(const double* from, double* to) {
    tape_.steps_.push_back({codes_[copied], from, nullptr, nullptr, to});
    return to;
  }
  /// A room for the result of a node, which may be that of an operand.
  double* room(int node) {
    int& number = item(room_, node);
    if (free_.empty()) {
      number = next_room_++;
    } else {
      number = free_.back();
      free_.pop_back();
    }
    return tape_.room(number);
  }
  double* home(int node) const { return node < 0 ? nullptr : item(home_, node); }
  double* second(const Call& call) const { return call.looks_up() ? constant(call.b) : home(call.b); }
  /// The end of a table of knots.
  double* third(const Call& call) const { return call.looks_up() ? constant(call.b + call.c) : home(call.c); }

  LaneTape& tape_;
  const void* const* codes_ = nullptr;
  int next_room_ = constants_of_structure;
  std::vector<double*> home_;  // of each node; null: not yet
  std::vector<int> last_;      // call that reads it last; −1: none
  std::vector<int> room_;      // −1: none
  std::vector<int> free_;
};

LaneTape::LaneTape(const TracedFunction& f, int lanes)
    : lanes_(lanes),
      evaluate_(lanes == many ? evaluate<many / 4> : evaluate<few / 4>),
      nodes_(f.nodes),
      outputs_(f.outputs) {
  const Builder builder(calls_, f);
  rooms_.resize((calls_.size() + outputs_.size() + constants_of_structure) *
                static_cast<std::size_t>(lanes / 4));
  for (int i = 0; i < constants_of_structure; ++i) std::fill_n(room(i), lanes, i - 1);
  const auto uses = f.uses();
  int inputs = 0, outputs = 0;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    if (uses[i] > 0 && nodes_[i].operation == Operation::input) inputs = std::max(inputs, nodes_[i].a + 1);
  for (const auto& o : outputs_) outputs = std::max(outputs, o.array + 1);
  in_.resize(static_cast<std::size_t>(inputs));
  out_.resize(static_cast<std::size_t>(outputs));
}

void LaneTape::assemble(const double* constants, const double* const* in, double* const* out) {
  constants_ = constants;
  std::copy_n(in, in_.size(), in_.begin());
  std::copy_n(out, out_.size(), out_.begin());
  steps_.clear();
  const Assembler assembler(*this);
}

int LaneTape::operator()(const double* constants, const double* const* in, double* const* out) {
  if (steps_.empty() || constants != constants_ || !std::equal(in_.begin(), in_.end(), in) ||
      !std::equal(out_.begin(), out_.end(), out))
    assemble(constants, in, out);
  return evaluate_(steps_.data(), nullptr);
}

}  // namespace freeplay
