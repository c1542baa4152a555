// Tables over time: the effect of a pulse is its area, however short the pulse, in every integrator
// and scheme.
#include "verification/support/named.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

using Table = std::vector<std::pair<double, double>>;

/// A wheel of 0.1 kg m² on its axle, driven by a table over time alone.
std::string wheel(const Table& table) {
  std::string text;
  for (const auto& [t, torque] : table)
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", t, torque);
  return test::body("wheel", 1.0, 0.1) + test::pin("axle", "ground", "wheel") +
         test::drive("motor", "axle", fmt::format("torque_table = [{}]\n", text)) + test::run_for(1.0);
}

/// ∫ M dt and ∫∫ M dt² from 0 to 1 s: the table is linear between knots and constant beyond them.
std::pair<long double, long double> moments(const Table& table) {
  const auto value = [&](long double t) -> long double {
    if (t <= table.front().first) return table.front().second;
    for (std::size_t i = 1; i < table.size(); ++i)
      if (t <= table[i].first)
        return table[i - 1].second + (table[i].second - static_cast<long double>(table[i - 1].second)) *
                                         (t - table[i - 1].first) /
                                         (table[i].first - static_cast<long double>(table[i - 1].first));
    return table.back().second;
  };
  std::vector<long double> at{0};
  for (const auto& knot : table)
    if (knot.first > 0 && knot.first < 1) at.push_back(knot.first);
  at.push_back(1);
  long double speed = 0, angle = 0;
  for (std::size_t i = 1; i < at.size(); ++i) {
    const long double h = at[i] - at[i - 1], a = value(at[i - 1]), b = value(at[i]);
    angle += h * speed + h * h * (2 * a + b) / 6;
    speed += h * (a + b) / 2;
  }
  return {speed, angle};
}

const auto methods = test::with_integrators({test::penalty_by("rk4"), test::event_driven, test::automatic,
                                             test::chosen_steps, test::fixed_steps(3e-3)});

}  // namespace

TEST_CASE("pulses shorter than any step turn a wheel by their area", "[knots]") {
  const auto way = GENERATE(from_range(methods));
  CAPTURE(way.name);
  std::mt19937 engine(18);
  std::uniform_real_distribution<double> uniform(0, 1);
  for (int trial = 0; trial < 12; ++trial) {
    // Up to four pulses of 1e-9 to 1e-2 s and of at most 1 N m s, on a slowly varying torque.
    Table table{{0, 0.5}};
    double t = 0, least = 1;
    for (int pulse = 0; pulse < 1 + trial % 4; ++pulse) {
      t += 0.01 + 0.2 * uniform(engine);
      const double width = std::pow(10, -2 - 7 * uniform(engine)), height = (2 * uniform(engine) - 1) / width;
      for (const auto& [share, level] : {std::pair{0.0, 0.0}, {0.1, height}, {0.9, height}, {1.0, 0.0}})
        table.emplace_back(t + share * width, level + 0.5 - t);
      least = std::min(least, width);
      t += width;
    }
    CAPTURE(trial, least);
    std::vector<std::string> step;
    if (std::string(way.name) == "rk4") step = {"penalty.step=3e-3"};
    const auto run = test::finished(way, wheel(table), step);
    const auto [speed, angle] = moments(table);
    // Torques are linear between knots: quadratures of second order and above are exact there. The
    // remaining error is rounding of the knots themselves (1e-16 of 1 s, in a width of 1e-9: 1e-7
    // of the pulse) and each method's tolerance.
    CHECK(run.final_state.v[2] == Approx(double(speed / 0.1L)).margin(1e-5));
    // A fixed step applies the mean of a pulse over the step: the error of the angle is the effect
    // of the pulse over half a step.
    CHECK(run.final_state.q[2] == Approx(double(angle / 0.1L)).margin(way.fixed() ? 4 * 10 * 1.5e-3 : 1e-5));
    CHECK(run.work.rejected < 400);
    CHECK(run.work.steps < 5000);
  }
}
