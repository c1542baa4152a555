// Tables, curves and branches on values in compiled functions. The expected digits are those of the
// templates with plain numbers, which other tests compare with closed forms.
#include "compile/compiled_object.hpp"
#include "mechanism/cam_profile.hpp"
#include "mechanism/curve.hpp"
#include "mechanism/piecewise.hpp"
#include "numerics/choice.hpp"
#include "numerics/trace.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

const std::vector<double> knots{-1, 0, 0.25, 2};
const std::vector<double> entries{3, -1, 5, 0.5, 7};

/// Look-ups, whole numbers and choices of a number; `size` is a constant.
template <class T>
std::vector<T> looked_up(const T& x, double size) {
  const auto i = interval_of(knots.size(), x, [&](std::size_t k) { return size * knots[k]; });
  const auto entry = entry_of(entries.size(), i, [&](std::size_t k) { return size * entries[k]; });
  return {entry * x, T(floor_of(3 * x)) * x, T(round_of(7 * x)), limited(x, 0.6 * size),
          choose(
              is_equal(x, 0.5), [] { return T(1); }, [&] { return x / (x - 0.5); })};
}

/// The functions of x, of `lanes` lanes.
TracedObject traced_look_ups(double size, int lanes = 0) {
  TracedObject object(lanes);
  {
    Trace trace(object, "f");
    trace.outputs(0, looked_up(trace.input(0, 0, 0.3), size));
  }
  return object;
}

/// Places around knots, halves and limits.
std::vector<double> places() {
  std::vector<double> list{-INFINITY, INFINITY, NAN, -0.0, 1e-320, 1e15};
  // Knots of the function alone and of the lanes, and halves.
  for (const double knot : knots)
    for (const double share : {1.5, 0.5, 0.75, 0.875, 0.5 / 7})
      for (const double y : {share * knot, std::nextafter(share * knot, 9.0)}) list.push_back(y);
  for (double x = -2.5; x <= 2.5; x += 1.0 / 56)
    for (const double y : {x, std::nextafter(x, -9.0), std::nextafter(x, 9.0)}) list.push_back(y);
  return list;
}

bool same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

/// Whether a compiled function gives these numbers.
bool gives(CompiledFunction f, const TracedObject& object, double x, const std::vector<double>& expected) {
  const auto y = test::call(f, object, {x}, expected.size());
  REQUIRE(y);
  return std::ranges::equal(*y, expected, same);
}

std::vector<Piecewise> curves() {
  using Shape = Curve::Shape;
  std::vector<Piecewise> list;
  Curve c{.name = "c", .shape = Shape::ramp, .from = 1, .to = 3, .start = -0.5, .rise = 1.25};
  list.push_back(c.lay());
  c.profile = Curve::Profile::cycloidal;
  list.push_back(c.lay());
  c.shape = Shape::rise_dwell_return;
  c.dwell = 0.4;
  c.fall = 0.7;
  c.rest = 0.3;
  list.push_back(c.lay());
  c.repeats = true;
  list.push_back(c.lay());
  list.push_back(list.back().antiderivative(0.2, -1));  // gains in each period
  list.push_back(
      Curve{.name = "h", .shape = Shape::harmonic, .mean = 0.5, .amplitude = 2, .period = 0.9, .phase = 1}
          .lay());
  Curve table{.name = "t", .shape = Shape::table, .points = {{-1, 2}, {-0.25, 0.5}, {0.5, 1}, {1.5, 2}}};
  for (const auto between : {Curve::Between::linear, Curve::Between::spline})
    for (const bool repeats : {false, true}) {
      table.between = between;
      table.repeats = repeats;
      list.push_back(table.lay());
    }
  return list;
}

}  // namespace

TEST_CASE("compiled look-ups, whole numbers and choices have the digits of plain numbers", "[compiled]") {
  const test::CompilerCache cache;
  const auto object = traced_look_ups(1.5);
  CHECK(object.text() == traced_look_ups(0.7).text());  // tables are constants
  const auto compiled = compiled_object(object.text(), 1);
  REQUIRE(compiled.reason.empty());
  const std::size_t outputs = looked_up(0.0, 1).size();
  constexpr int width = 4;
  const auto lanes = traced_look_ups(1.5, width);
  const auto together = compiled_object(lanes.text(), 1);
  REQUIRE(together.reason.empty());
  std::vector<TracedObject> alone;
  alignas(64) double constants[64 * width], x[width], found[8 * width];
  REQUIRE(lanes.constants().size() <= 64);
  for (int lane = 0; lane < width; ++lane) {
    alone.push_back(traced_look_ups(0.5 + lane, width));
    for (std::size_t k = 0; k < lanes.constants().size(); ++k)
      constants[k * width + static_cast<std::size_t>(lane)] = alone.back().constants()[k];
  }
  long differing = 0;
  for (const double at : places()) {
    differing += !gives(*compiled.table, object, at, looked_up(at, 1.5));
    for (int lane = 0; lane < width; ++lane) x[lane] = at * (1 + lane);
    const double* in[] = {x};
    double* out[] = {found};
    REQUIRE((*together.table)(constants, in, out) == 0);
    for (int lane = 0; lane < width; ++lane) {
      const auto one = looked_up(x[lane], 0.5 + lane);
      for (std::size_t k = 0; k < outputs; ++k)
        differing += !same(found[k * width + static_cast<std::size_t>(lane)], one[k]);
    }
  }
  CHECK(differing == 0);
}

TEST_CASE("compiled curves: values, slopes, and means of steps without a knot", "[compiled]") {
  const test::CompilerCache cache;
  const auto list = curves();
  TracedObject object;
  for (std::size_t k = 0; k < list.size(); ++k) {
    const auto number = std::to_string(k);
    {
      Trace trace(object, "jet" + number);
      const auto j = list[k].jet(trace.input(0, 0, 0.3));
      trace.outputs(0, std::vector{j.value, j.slope, j.bend, list[k].value(trace.input(0, 0, 0.3))});
    }
    Trace trace(object, "mean" + number);
    trace.output(0, 0, list[k].mean(trace.input(0, 0, 0.3), trace.input(1, 0, 0.31)));
  }
  const auto compiled = compiled_object(object.text(), object.functions());
  REQUIRE(compiled.reason.empty());
  long differing = 0, taken = 0, refused = 0, unexpected = 0;
  for (std::size_t k = 0; k < list.size(); ++k)
    for (double x = -3; x < 4; x += 1.0 / 64) {
      const auto j = list[k].jet(x);
      differing += !gives(compiled.table[2 * k], object, x, {j.value, j.slope, j.bend, list[k].value(x)});
      for (const double width : {1e-5, 0.07, -0.07, 0.0}) {
        const double a = x + 0.003, b = a + width;
        const auto mean = test::call(compiled.table[2 * k + 1], object, {a, b}, 1);
        const bool between = list[k].next_knot(std::min(a, b)) < std::max(a, b);
        unexpected += mean.has_value() != !(between || width == 0);
        refused += !mean;
        if (!mean) continue;
        ++taken;
        differing += !same((*mean)[0], list[k].mean(a, b));
      }
    }
  CHECK(differing == 0);
  CHECK(unexpected == 0);
  CHECK(taken > 9000);
  CHECK(refused > 2500);
}

TEST_CASE("a compiled cam profile has the digits of the profile", "[compiled]") {
  const test::CompilerCache cache;
  std::vector<CamProfile> list;
  for (const auto law : {CamLaw::cycloidal, CamLaw::polynomial, CamLaw::harmonic})
    list.push_back(CamProfile::standard(law, 0.01, 0.4, 1.2, 0.5, 1.7));
  list.push_back(CamProfile::through({{0.1, 0.0}, {1.3, 0.01}, {2.9, 0.004}, {5.0, 0.006}}));
  TracedObject object;
  for (std::size_t k = 0; k < list.size(); ++k) {
    Trace trace(object, "lift" + std::to_string(k));
    const auto y = list[k].at(trace.input(0, 0, 1.0));
    trace.outputs(0, std::vector{y.h, y.d1, y.d2, y.d3});
  }
  const auto compiled = compiled_object(object.text(), object.functions());
  REQUIRE(compiled.reason.empty());
  long differing = 0;
  for (std::size_t k = 0; k < list.size(); ++k)
    for (double phi = -9; phi < 9; phi += 1.0 / 64) {
      const auto expected = list[k].at(phi);
      differing +=
          !gives(compiled.table[k], object, phi, {expected.h, expected.d1, expected.d2, expected.d3});
    }
  CHECK(differing == 0);
}
