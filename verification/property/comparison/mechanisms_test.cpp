// Both formulations and the event-driven scheme on nine mechanisms (four slider-cranks, a big end
// with clearance, four-bars with clearance in one and two pins, pendulums, a free ring and
// journal), against the solutions of verification/references/impact_tables.hpp.
#include "verification/references/impact_tables.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Required accuracy of a method: the error of the time of impact i, and of its velocities and
/// impulses relative to its approach speed and normal impulse, after a flight of this length.
struct Way {
  const char* name;
  Family family;
  std::vector<std::string> keys;
  double (*time)(int i);
  double (*relative)(int i, double flight);
};
const Way ways[] = {
    // The tables have 10 to 11 digits in times and 9 in rates.
    {"event-driven",
     Family::nonsmooth,
     {"nonsmooth.scheme=\"event-driven\""},
     [](int) { return 1e-11; },
     [](int, double) { return 1e-8; }},
    // Tolerance 1e-9 of the clearance and speed per step, some hundred steps a flight, and an
    // amplification of up to ten per impact: 1e-7, 1e-6, 1e-5 of a speed. A time is a position
    // error over a speed: 1e-9 s after one impact.
    {"penalty",
     Family::penalty,
     {},
     [](int i) {
       return std::array{1e-9, 3e-9, 1e-8}[static_cast<std::size_t>(i)];
     },
     [](int i, double) { return 2e-7 * std::pow(10, i); }},
    // An impact is displaced by up to a step, and each later one inherits that: 2h per impact.
    // Velocities change over a step by about their size times h over the flight, at either end of
    // it: 4h/flight per impact so far.
    {"Moreau–Jean",
     Family::nonsmooth,
     {"nonsmooth.step=1e-6"},
     [](int i) { return 2e-6 * (i + 1); },
     [](int i, double flight) { return 4e-6 * (i + 1) / flight; }}};

}  // namespace

TEST_CASE("each method reproduces the event-driven tables of nine mechanisms", "[cross][event-driven]") {
  for (const auto& way : ways)
    for (const auto& table : reference::impact_tables) {
      auto scene = test::read_short(test::scene_file(table.scene), 0.035, way.keys);
      scene.instruments.clear();
      CAPTURE(way.name, table.scene);
      const auto run = test::finished(scene, way.family);
      const auto found = test::touches(run);
      double before = 0;
      for (int i = 0; i < 3; ++i) {
        const auto& expected = way.family == Family::penalty ? table.penalty[i] : table.nonsmooth[i];
        CAPTURE(i, expected.t);
        REQUIRE(static_cast<int>(found.size()) > i);
        const auto& e = found[i];
        REQUIRE(run.contacts.at(static_cast<std::size_t>(e.contact)).name == expected.joint);
        const double relative = way.relative(i, expected.t - before), speed = -expected.v_n_minus;
        const auto meets = [](double value, double exact, double bound) {
          CHECK(value == Approx(exact).margin(bound).epsilon(0));
        };
        meets(e.t, expected.t, way.time(i));
        meets(e.v_n_minus, expected.v_n_minus, relative * speed);
        meets(e.v_n_plus, expected.v_n_plus, relative * speed);
        meets(e.v_t_minus, expected.v_t_minus, relative * (speed + std::abs(expected.v_t_minus)));
        meets(e.impulse_n, expected.impulse_n, relative * expected.impulse_n);
        meets(e.impulse_t, expected.impulse_t, relative * expected.impulse_n);
        before = expected.t;
      }
    }
}
