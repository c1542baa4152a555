// Cells of the table of compare, from planted results: errors beside values, transients, long names.
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

Comparison planted(double revolutions) {
  Comparison c;
  for (auto* run : {&c.penalty, &c.nonsmooth}) {
    run->revolutions = revolutions;
    run->observed = 1;
    run->window.emplace();
    run->window->batches = 8;
    run->window->batch = 0.125;
  }
  const auto plant = [&](Window::Term term, double value, double error) {
    c.penalty.window->energy[term] = value;
    c.penalty.window->error[term] = error;
  };
  plant(Window::drives, 0.31, 4.1);
  plant(Window::stored, 8.2e-11, 1.2e-10);
  plant(Window::stabilisation, -2e-16, 1e-10);
  plant(Window::friction, 0.0293, 0.0012);
  return c;
}

}  // namespace

TEST_CASE("a value below its standard error is printed with its own digits", "[compare]") {
  const auto table = comparison_table(read_scene(test::flores()), planted(10), false);
  CHECK_THAT(table, Contains(" 0.31 ± 4.1 ") && Contains(" (0.82 ± 1.2)e-10 ") &&
                        Contains(" -2e-16 ± 1e-10 ") && Contains(" 0.0293 ± 0.0012 "));
  CHECK_THAT(table, Contains("standard error, from 8 batches of 0.125 s\n"));
}

TEST_CASE("energies of a single transient have no error", "[compare]") {
  const auto table = comparison_table(read_scene(test::flores()), planted(0), false);
  for (const auto& line : test::lines_of(table))
    if (line.starts_with("energy:")) CHECK_THAT(line, !Contains("±"));
  CHECK_THAT(table, Contains(" 0.31 ") && Contains("none for energies of a single transient\n"));
}

TEST_CASE("the verdict takes extreme values and differences of pairs from the runs", "[compare]") {
  auto c = planted(10);
  c.joints = {"pin"};
  for (auto* run : {&c.penalty, &c.nonsmooth}) run->contacts.resize(1);
  c.penalty.contacts[0].fastest_approach = 2;
  c.nonsmooth.contacts[0].fastest_approach = 3;
  c.penalty.contacts[0].greatest_impulse = 1;
  c.nonsmooth.contacts[0].greatest_impulse = 1.5;
  ContactEvent a, b;
  a.kind = b.kind = EventKind::impact;
  a.v_n_minus = -1, b.v_n_minus = -3;
  a.impulse_n = 0.08093, b.impulse_n = 0.05175;
  c.pairing.pairs = {{a, b}};
  const auto v = comparison_values(read_scene(test::flores()), c);
  REQUIRE(v.approaches.size() == 1);
  REQUIRE(v.impulses.size() == 1);
  // |a − b| over the mean of both: 1/2.5, 0.5/1.25, 2/2 and 0.02918/0.06634.
  CHECK(v.approaches[0].relative() == Approx(0.4));
  CHECK(v.impulses[0].relative() == Approx(0.4));
  CHECK(v.events.speed == Approx(1));
  CHECK(v.events.impulse == Approx(0.4398553).epsilon(1e-6));
}

TEST_CASE("a long name of a contact is printed once for consecutive pairs", "[compare]") {
  auto c = planted(10);
  c.joints = {"mesh.backward", "pin"};
  c.not_matched.resize(2);
  c.frictional = {false, false};
  for (auto* run : {&c.penalty, &c.nonsmooth}) run->contacts.resize(2);
  const auto at = [](double t, int contact) {
    ContactEvent e;
    e.t = t;
    e.contact = contact;
    return ImpactPair{e, e};
  };
  // 13 characters do not fit the column of 12.
  c.pairing.pairs = {at(1e-3, 0), at(2e-3, 0), at(3e-3, 1), at(4e-3, 0)};
  const auto scene = read_scene(test::flores());
  CHECK(test::count(comparison_table(scene, c, false), "\nmesh.backward\n") == 2);
  CHECK(test::count(comparison_table(scene, c, true), "\n| mesh.backward | ") == 3);
}

TEST_CASE("compare ends with status 1 if either formulation stops", "[compare][program]") {
  // A step of 0.1 s, a third of a turn, moves the journal far through its bearing.
  const test::TemporaryFolder folder;
  const auto run = test::freeplay("compare " + test::scene_file("gudgeon").string() +
                                  " --set nonsmooth.step=0.1 --set run.duration=0.2 -o " +
                                  (folder.path() / "out").string());
  CAPTURE(run.out, run.err);
  CHECK(run.status == 1);
  CHECK_THAT(run.err, Contains("nonsmooth: stopped"));
}
