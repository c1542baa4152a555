// Tapes of lanes (numerics/lane_tape.hpp). The expected numbers are those of the operations in plain
// numbers, one lane at a time.
#include "numerics/lane_tape.hpp"

#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>
#include <random>
#include <vector>

#include "numerics/trace.hpp"

using namespace freeplay;

namespace {

constexpr int tape_inputs = 6, tape_outputs = 9;

/// A random function of numbers with tables, choices and guards. The graph follows from the seed, the
/// constants from the lane, too.
TracedObject random_function(unsigned seed, int lane, int lanes) {
  TracedObject object(lanes);
  Trace trace(object, "f");
  std::mt19937 graph(seed), values(1000 * seed + static_cast<unsigned>(lane));
  const auto number = [&] { return std::uniform_real_distribution(-2.0, 2.0)(values); };
  std::vector<Traced> list = trace.inputs(0, std::vector<double>(tape_inputs, 0.5)), conditions;
  std::vector<double> knots, column;
  for (int i = 0; i < 5; ++i) {
    knots.push_back(number());
    column.push_back(number());
  }
  column.push_back(number());
  std::ranges::sort(knots);
  for (std::size_t i = 0; i < 3; ++i) list.push_back(list[i] + number());
  const auto any = [&](const auto& from) { return from[graph() % from.size()]; };
  for (int i = 0; i < 150; ++i) {
    const auto a = any(list), b = any(list), c = any(list);
    switch (graph() % 22) {
      case 0:
        list.push_back(a / b);
        break;
      case 1:
        list.push_back(-a);
        break;
      case 2:
        list.push_back(sqrt(a));
        break;
      case 3:
        list.push_back(abs(a));
        break;
      case 4:
        list.push_back(sin(a) + cos(b));
        break;
      case 5:
        list.push_back(exp(a) * tanh(b));
        break;
      case 6:
        list.push_back(floor(a) - round(3 * b));
        break;
      case 7:
        list.push_back(atan2(a, b));
        break;
      case 8:
        list.push_back(max(a, b));
        break;
      case 9:
        conditions.push_back(holds(a, i % 2 == 0 ? Relation::less : Relation::less_equal, b));
        break;
      case 10:
        conditions.push_back(holds(a, Relation::equal, b));
        break;
      case 11:
        if (conditions.empty()) break;
        conditions.push_back(i % 2 == 0 ? both(any(conditions), any(conditions))
                                        : either(any(conditions), any(conditions)));
        break;
      case 12:
        if (!conditions.empty()) list.push_back(select(any(conditions), a, b));
        break;
      case 13:
        list.push_back(pick(locate(a, knots), column));
        break;
      case 14:
        list.push_back(a * b + c);
        break;
      case 15:
        list.push_back(c - a * b);
        break;
      case 16:
        list.push_back(a * b - c);
        break;
      case 17:
        list.push_back(a * b - b * c);
        break;
      case 18:
        list.push_back(a - b);
        break;
      case 19:
        list.push_back(a * b);
        break;
      case 20:
        list.push_back(a + a);
        break;
      default:
        list.push_back(a + b);
    }
  }
  // Each of three guards fails in one of 40 lanes, one never.
  const auto last = list.back();
  (void)(list[0] < 1.9);
  (void)(list[1] <= -1.9);
  (void)(list[2] == 7);
  trace.require(holds(-1.9, Relation::less, list[3]));
  for (int i = 0; i < tape_outputs; ++i) trace.output(0, i, i == 0 ? last : any(list));
  return object;
}

/// The outputs in plain numbers; empty if a guard fails.
std::optional<std::vector<double>> in_plain_numbers(const TracedFunction& f,
                                                    const std::vector<double>& constants,
                                                    const std::vector<double>& inputs) {
  std::vector<double> x(f.nodes.size());
  const auto at = [&](int node) { return x[static_cast<std::size_t>(node)]; };
  const auto uses = f.uses();
  for (std::size_t i = 0; i < x.size(); ++i) {
    const auto& n = f.nodes[i];
    if (uses[i] == 0) continue;
    if (n.operation == Operation::constant)
      x[i] = n.a < 0 ? n.b : constants[static_cast<std::size_t>(n.a)];
    else if (n.operation == Operation::input)
      x[i] = inputs[static_cast<std::size_t>(n.b)];
    else if (n.operation == Operation::select)
      x[i] = at(n.a) != 0 ? at(n.b) : at(n.c);
    else if (n.operation == Operation::locate)
      x[i] = static_cast<double>(
          std::upper_bound(constants.begin() + n.b, constants.begin() + n.b + n.c, at(n.a)) -
          constants.begin() - n.b);
    else if (n.operation == Operation::pick)
      x[i] = constants[static_cast<std::size_t>(n.b + static_cast<int>(at(n.a)))];
    else
      x[i] = result_of(n.operation, at(n.a), n.b < 0 ? 0 : at(n.b));
  }
  for (const auto& g : f.guards)
    if (g.b < 0 ? at(g.a) == 0 : relation_holds(at(g.a), g.relation, at(g.b)) != g.result) return {};
  std::vector<double> outputs(tape_outputs, 0);
  for (const auto& o : f.outputs) outputs[static_cast<std::size_t>(o.index)] = at(o.node);
  return outputs;
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b) ||
         (std::isnan(a) && std::isnan(b));
}

struct TapeCounts {
  long numbers = 0, differing = 0, failed = 0, alone = 0;
};

/// A function at random inputs. `shared`: its outputs replace its inputs.
void compare_tape(unsigned seed, int lanes, bool shared, TapeCounts& counts) {
  const auto first = random_function(seed, 0, lanes);
  const auto& f = first.function(0);
  LaneTape tape(f, lanes);
  const auto width = static_cast<std::size_t>(lanes);
  std::vector<std::vector<double>> constants;
  alignas(64) static std::array<double, 8 * 200> all;
  alignas(64) static std::array<std::array<double, 8 * 16>, 3> arrays;
  REQUIRE(first.constants().size() <= 200);
  for (std::size_t lane = 0; lane < width; ++lane) {
    const auto own = random_function(seed, static_cast<int>(lane), lanes);
    REQUIRE(own.same_structure(first));
    constants.push_back(own.constants());
    for (std::size_t i = 0; i < own.constants().size(); ++i) all[i * width + lane] = own.constants()[i];
  }
  std::mt19937 random(seed);
  for (int call = 0; call < 12; ++call) {
    // The arrays of the first calls, others, and the first ones again.
    auto& in = arrays[call % 5 == 4 ? 1 : 0];
    auto& out = shared ? in : arrays[2];
    std::vector<std::vector<double>> inputs(width);
    for (auto& list : inputs)
      for (int i = 0; i < tape_inputs; ++i)
        list.push_back(call == 3 && i == 4 ? 0.0 : std::uniform_real_distribution(-2.0, 2.0)(random));
    for (std::size_t i = 0; i < tape_inputs; ++i)
      for (std::size_t lane = 0; lane < width; ++lane) in[i * width + lane] = inputs[lane][i];
    const double* from[] = {in.data()};
    double* to[] = {out.data()};
    const auto bits = static_cast<unsigned>(tape(all.data(), from, to));
    int failed = 0;
    for (std::size_t lane = 0; lane < width; ++lane) {
      const auto expected = in_plain_numbers(f, constants[lane], inputs[lane]);
      CHECK((bits >> lane & 1) == (expected ? 0 : 1));
      failed += !expected;
      if (!expected) continue;
      for (const auto& o : f.outputs) {
        const auto at = static_cast<std::size_t>(o.index);
        ++counts.numbers;
        counts.differing += !same_bits(out[at * width + lane], (*expected)[at]);
      }
    }
    CHECK(bits >> width == 0);
    counts.failed += failed;
    counts.alone += failed == 1;
  }
}

}  // namespace

TEST_CASE("a tape has the digits of plain numbers in each lane", "[lanes]") {
  if (!LaneTape::usable()) return;
  TapeCounts counts;
  for (unsigned seed = 1; seed <= 60; ++seed)
    for (const int lanes : {LaneTape::few, LaneTape::many})
      for (const bool shared : {false, true}) compare_tape(seed, lanes, shared, counts);
  CHECK(counts.differing == 0);
  // 60·24·(4 + 8) computations of up to 9 numbers; guards fail in 7 %, that is 1270 of them.
  CHECK(counts.numbers > 120000);
  CHECK(counts.failed > 500);
  CHECK(counts.alone > 200);  // in one lane only
}

TEST_CASE("a guard of a tape fails where the relation has another result than at the sample", "[lanes]") {
  if (!LaneTape::usable()) return;
  alignas(64) const double x[8] = {0.5, 1, 1.5, NAN, 1, 1, 1, 1};
  const double* in[] = {x};
  for (const double sample : {0.5, 1.0, 1.5, std::nan("")})
    for (const auto relation : {Relation::less, Relation::less_equal, Relation::equal}) {
      TracedObject object(LaneTape::few);
      {
        Trace trace(object, "f");
        (void)trace.compare(trace.input(0, 0, sample), relation, trace.input(0, 1, 1));
      }
      LaneTape tape(object.function(0), LaneTape::few);
      int expected = 0;
      for (int lane = 0; lane < 4; ++lane)
        if (relation_holds(x[lane], relation, 1) != relation_holds(sample, relation, 1))
          expected |= 1 << lane;
      CHECK(tape(nullptr, in, nullptr) == expected);
    }
}

TEST_CASE("a tape may exchange its inputs", "[lanes]") {
  if (!LaneTape::usable()) return;
  TracedObject object(LaneTape::few);
  {
    Trace trace(object, "f");
    const auto x = trace.inputs(0, std::vector{1.0, 2.0, 3.0});
    trace.output(0, 0, x[1]);
    trace.output(0, 1, x[0]);
    trace.output(0, 2, x[0] * x[1] + x[2]);
    trace.output(1, 0, x[0] * x[1] + x[2]);
    trace.output(1, 1, 1);
  }
  LaneTape tape(object.function(0), LaneTape::few);
  alignas(64) double x[12] = {1, 2, 3, 4, 10, 20, 30, 40, 100, 200, 300, 400}, y[8];
  const double* in[] = {x};
  double* out[] = {x, y};
  CHECK(tape(nullptr, in, out) == 0);
  for (int lane = 0; lane < 4; ++lane) {
    const double a = 1 + lane, b = 10 * a;
    CHECK(x[lane] == b);
    CHECK(x[4 + lane] == a);
    CHECK(x[8 + lane] == a * b + 100 * a);
    CHECK(y[lane] == x[8 + lane]);
    CHECK(y[4 + lane] == 1);
  }
}
