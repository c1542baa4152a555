#include "verification/timing/scaling.hpp"

#include <fmt/format.h>
#include <time.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>

#include "facade/simulation.hpp"
#include "verification/support/apart.hpp"
#include "verification/support/support.hpp"

namespace freeplay::verification {

namespace {

std::vector<int> doubled(int from, int to) {
  std::vector<int> list;
  for (int count = from; count <= to; count *= 2) list.push_back(count);
  return list;
}

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

Scene row(int count) {
  auto scene = test::row_of_four_bars(count, 1e-3);
  scene.run.duration = 0.05;
  return scene;
}

/// One run; its cost, in one line for another process.
std::string run_once(const Growth& growth, int count) {
  auto scene = growth.scene(count);
  const auto bodies = scene.mechanism.bodies.size();
  const double before = processor_seconds();
  Simulation simulation(std::move(scene), name_of(growth.family));
  const double setup = processor_seconds() - before;
  const auto result = simulation.run({.keep_events = false});
  const auto& work = result.work;
  const long units = growth.family == Family::penalty ? work.rhs : work.steps;
  double lasting = 0;
  for (const auto& c : result.contacts) lasting += c.lasting_fraction;
  return fmt::format("{} {:.9g} {:.9g} {} {:.9g} {:.9g} {:.9g} {}", bodies, setup,
                     1e6 * result.cpu_seconds / static_cast<double>(units), units,
                     static_cast<double>(work.lcp_solves) / static_cast<double>(units),
                     static_cast<double>(work.pivots) / static_cast<double>(std::max(1L, work.lcp_solves)),
                     result.contacts.empty() ? 0 : lasting / static_cast<double>(result.contacts.size()),
                     result.ending.status == Ending::Status::finished ? "" : result.ending.reason);
}

const char* unit_of(const Growth& g) { return g.family == Family::penalty ? "right-hand side" : "step"; }

/// Predicted cost for sizes from fit_from on; empty for smaller ones.
std::string predicted(const Growth& g, const std::vector<Cost>& costs, const Cost& c) {
  for (const auto& first : costs)
    if (first.count >= g.fit_from && c.count >= first.count)
      return fmt::format("{:.6g}", first.microseconds * std::pow(double(c.count) / first.count, g.predicted));
  return "";
}

}  // namespace

Scene loose_chain(int links) {
  constexpr double length = 0.1, mass = 0.1, rate = 1, play = 1e-3;
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  m.surfaces.push_back(test::steel(0.5));
  m.surfaces.back().friction = 0.05;
  for (int k = 0; k < links; ++k) {
    const double down = (k + 0.5) * length + (k + 1) * play;
    m.bodies.push_back({fmt::format("link{}", k + 1),
                        mass,
                        mass * length * length / 12,
                        {0, -down},
                        -M_PI / 2,
                        {rate * down, 0},
                        rate});
    RevoluteJoint pin{fmt::format("pin{}", k + 1),
                      {k == 0 ? ground : k - 1, k},
                      {k == 0 ? Vec2{0, 0} : Vec2{length / 2, 0}, {-length / 2, 0}},
                      {}};
    pin.clearance = Clearance{play, 0.02, 0, std::nullopt, -1};
    m.joints.push_back(pin);
  }
  scene.run.duration = 0.05;
  scene.run.start = RunOptions::Start::given;
  scene.nonsmooth.step = 1e-4;
  return scene;
}

std::vector<Growth> growths() {
  return {
      {"row", "a row of four-bars that share their uprights, one loose joint each, 0.05 s at steps of 1e-4 s",
       "loose joints", Family::nonsmooth, doubled(1, 4096), row, 64, 1,
       "each four-bar knows its neighbours alone, and contacts on different couplers do not know each other"},
      {"chain", "a chain of links in loose pins that hangs and swings, 0.05 s at steps of 1e-4 s", "links",
       Family::nonsmooth, doubled(4, 256), loose_chain, 16, 1,
       "every contact lasts and knows its neighbours: one problem with a band matrix"},
      {"row-penalty", "the same row in the penalty formulation", "loose joints", Family::penalty,
       doubled(1, 256),
       [](int count) {
         auto scene = row(count);
         scene.run.duration = 0.01;
         return scene;
       },
       16, 1, "a right-hand side evaluates each body once and solves a sparse system without fill"},
  };
}

Cost measure(const Growth& growth, int count, int repetitions) {
  Cost cost{.count = count, .microseconds = std::numeric_limits<double>::infinity(), .ending = {}};
  for (int i = 0; i < repetitions; ++i) {
    const auto apart = run_apart([&] { return run_once(growth, count); }, 3600);
    std::istringstream in(apart.said);
    double setup, microseconds;
    if (apart.signal != 0 || !(in >> cost.bodies >> setup >> microseconds >> cost.units >> cost.solves >>
                               cost.pivots >> cost.lasting))
      throw std::runtime_error(
          fmt::format("{} of {}: no result (signal {})", growth.name, count, apart.signal));
    std::getline(in >> std::ws, cost.ending);
    cost.setup_s = i == 0 ? setup : std::min(cost.setup_s, setup);
    cost.microseconds = std::min(cost.microseconds, microseconds);
    cost.megabytes = std::max(cost.megabytes, apart.megabytes);
  }
  return cost;
}

double exponent(const Growth& growth, const std::vector<Cost>& costs) {
  std::vector<double> count, cost;
  for (const auto& c : costs)
    if (c.count >= growth.fit_from) {
      count.push_back(c.count);
      cost.push_back(c.microseconds);
    }
  return count.size() < 2 ? std::nan("") : test::observed_order(count, cost);
}

Table cost_table(const Measured& measured) {
  const auto& [g, costs] = measured;
  Table t({g.counted, "bodies", "µs", "µs each", "set-up s", "MB", "problems", "pivots"});
  for (const auto& c : costs)
    t.row(c.count, c.bodies, fmt::format("{:.4g}", c.microseconds),
          fmt::format("{:.3g}", c.microseconds / c.count), fmt::format("{:.2g}", c.setup_s),
          fmt::format("{:.0f}", c.megabytes), fmt::format("{:.3g}", c.solves),
          fmt::format("{:.3g}", c.pivots));
  return t;
}

std::string conclusion(const Measured& measured) {
  const auto& [g, costs] = measured;
  const double found = exponent(g, costs);
  std::string text = std::isnan(found)
                         ? fmt::format("No exponent: it needs at least {} {}.\n", g.fit_from, g.counted)
                         : fmt::format("Exponent from {} {} on: {:.2f}; predicted {:g}, for {}.\n",
                                       g.fit_from, g.counted, found, g.predicted, g.reason);
  for (const auto& c : costs)
    if (!c.ending.empty()) text += fmt::format("The run with {} failed: {}\n", c.count, c.ending);
  return text;
}

nlohmann::json to_json(const std::vector<Measured>& all) {
  auto list = nlohmann::json::array();
  for (const auto& [g, costs] : all) {
    const double found = exponent(g, costs);
    list.push_back({{"scene", g.name},
                    {"what", g.what},
                    {"counted", g.counted},
                    {"unit", unit_of(g)},
                    {"fit_from", g.fit_from},
                    {"predicted_exponent", g.predicted},
                    {"exponent", std::isnan(found) ? nlohmann::json() : nlohmann::json(found)}});
  }
  return {{"scenes", list}};
}

Table scaling_table(const std::vector<Measured>& all) {
  Table table("scene,count,bodies,microseconds,predicted,setup_s,megabytes,units,solves,pivots,lasting");
  const auto digits = [](double x) { return fmt::format("{:.6g}", x); };
  for (const auto& [g, costs] : all)
    for (const auto& c : costs)
      table.row(g.name, c.count, c.bodies, digits(c.microseconds), predicted(g, costs, c), digits(c.setup_s),
                fmt::format("{:.1f}", c.megabytes), c.units, digits(c.solves), digits(c.pivots),
                digits(c.lasting));
  return table;
}

std::string scaling_page(const std::vector<Measured>& all, int repetitions) {
  std::string text = fmt::format(
      "# Cost against size\n\nWritten by `freeplay scaling --document docs/verification`: the fastest of "
      "{} runs, each "
      "in a separate process with one thread. *µs*: processor time of a step or a right-hand side; *each*: "
      "divided by the number of elements; *set-up*: time from the scene to the first step; *MB*: peak "
      "memory of the process; *problems*: contact problems per step; *pivots*: pivots, sweeps or Newton "
      "steps per problem. Times depend on the machine; exponents and counts do "
      "not.\n\n![cost](figures/scaling.png)\n",
      repetitions);
  for (const auto& m : all)
    text += fmt::format("\n## {}\n\n{}, {}; µs a {}.\n\n{}\n{}", m.growth.name, m.growth.what,
                        name_of(m.growth.family), unit_of(m.growth), cost_table(m).markdown(), conclusion(m));
  return text;
}

}  // namespace freeplay::verification
