// Pairing of contacts on lists of events made by hand, the condition "matched", and cells of the table
// from planted results: errors beside values, transients, long names.
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

ContactEvent impact(double t, double v, int contact = 0) {
  ContactEvent e;
  e.t = t;
  e.contact = contact;
  e.v_n_minus = -v;
  e.v_n_plus = 0.5 * v;
  e.impulse_n = v;
  return e;
}
ContactEvent lasting(double t, double v) {
  auto e = impact(t, v);
  e.kind = EventKind::contact;
  return e;
}
ContactEvent separation(double t, double duration) {
  ContactEvent e;
  e.t = t;
  e.kind = EventKind::separation;
  e.duration = duration;
  return e;
}

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

TEST_CASE("pairing of contacts ends where the motions diverge", "[compare]") {
  const std::vector<ContactEvent> a{impact(1, 1), impact(2, .5), impact(3, .3)};
  const std::vector<ContactEvent> b{impact(1.009, 1), impact(2.09, .5), impact(3.4, .3)};
  const auto p = pair_impacts(a, b, 1);
  REQUIRE(p.pairs.size() == 2);
  REQUIRE(p.horizon == 2.09);
  // A truncated list is known up to its last event: missing events after it are no difference.
  const std::vector<ContactEvent> cut{impact(1, 1), impact(2, .5)};
  const std::vector<ContactEvent> whole{impact(1.009, 1), impact(2.01, .5), impact(3.01, .3)};
  const auto known = pair_impacts(cut, whole, 1, 2);
  REQUIRE(known.pairs.size() == 1);  // the second ends where the list does
  REQUIRE_THAT(known.ended_by, Contains("events of a run end there"));
  REQUIRE_THAT(pair_impacts(cut, whole, 1).ended_by,
               Contains("contact event 3") && Contains("the nonsmooth run only"));
  REQUIRE_THAT(p.ended_by, Contains("contact event 3"));
  REQUIRE(pair_impacts(a, a, 1).pairs.size() == 3);
  REQUIRE(pair_impacts(a, {a[0]}, 1).pairs.size() == 1);
}

TEST_CASE("contacts far apart in time are not paired, however long the time before them", "[compare]") {
  // 487 ms of 2 s is less than a quarter of the time since the start, and no earlier event makes
  // the motions diverge.
  const auto first = pair_impacts({impact(2, 1)}, {impact(2.487, 1)}, 1);
  CHECK(first.pairs.empty());
  CHECK_THAT(first.ended_by, Contains("ten times more than the preceding events"));
  // Before the first contact event both runs have the same motion: their times may differ by ten
  // thousandths of the flight.
  CHECK(pair_impacts({impact(2, 1)}, {impact(2.019, 1)}, 1).pairs.size() == 1);
  CHECK(pair_impacts({impact(2, 1)}, {impact(2.021, 1)}, 1).pairs.empty());
}

TEST_CASE("the time difference of a pair of contacts is compared with the preceding flight", "[compare]") {
  // A contact lasts from 1 s to 3 s, followed by a flight of 10 ms: 4 ms are a large part of the
  // flight, though a small one of the 2 s since the previous contact; 2 ms are within a quarter,
  // and within the difference expected from the previous pair.
  const std::vector<ContactEvent> a{lasting(1, 1), separation(3, 2), impact(3.010, 1)};
  const std::vector<ContactEvent> late{lasting(1.002, 1), separation(3, 1.998), impact(3.014, 1)};
  const auto parted = pair_impacts(a, late, 1);
  CHECK(parted.pairs.size() == 1);
  CHECK_THAT(parted.ended_by, Contains("contact event 2") && Contains("a quarter of the preceding flight"));
  const std::vector<ContactEvent> near{lasting(1.002, 1), separation(3, 1.998), impact(3.012, 1)};
  CHECK(pair_impacts(a, near, 1).pairs.size() == 2);
}

TEST_CASE("a pair is no farther apart than 10 degrees of a turn", "[compare]") {
  // Speeds that differ by a third make 30 ms of a flight of 0.2 s probable; a turn of 0.36 s leaves
  // 10 ms.
  const std::vector<ContactEvent> a{impact(0.1, 1), impact(0.3, 1)};
  const std::vector<ContactEvent> b{impact(0.1005, 1.33), impact(0.33, 1)};
  CHECK(pair_impacts(a, b, 1).pairs.size() == 2);
  const auto p = pair_impacts(a, b, 1, INFINITY, 0.36);
  CHECK(p.pairs.size() == 1);
  CHECK_THAT(p.ended_by, Contains("10 degrees"));
}

TEST_CASE("a contact that rests at the start does not count as a first contact", "[compare]") {
  const std::vector<ContactEvent> resting{lasting(0, 0), separation(0.5, 0.5), impact(1, 1)};
  const std::vector<ContactEvent> not_resting{separation(0.5, 0.5), impact(1.001, 1)};
  const auto p = pair_impacts(resting, not_resting, 1);
  REQUIRE(p.pairs.size() == 1);
  CHECK(p.pairs[0].penalty.t == 1);
}

TEST_CASE("an impact is paired with a short lasting contact but not with a long one", "[compare]") {
  const std::vector<ContactEvent> a{impact(1, 1)};
  CHECK(pair_impacts(a, {lasting(1.001, 1), separation(1.101, 0.1)}, 1).pairs.size() == 1);
  const auto p = pair_impacts(a, {lasting(1.001, 1), separation(1.501, 0.5)}, 1);
  CHECK(p.pairs.empty());
  CHECK_THAT(p.ended_by, Contains("an impact (penalty), onset of sustained contact"));
  // One whose end is not known may last for ever.
  CHECK(pair_impacts(a, {lasting(1.001, 1)}, 1).pairs.empty());
}

TEST_CASE("the horizon of the comparison ends for all contacts where the first one diverges", "[compare]") {
  const std::vector<ContactEvent> a{impact(1, 1, 0), impact(1.5, 1, 1), impact(2, 1, 0)};
  const std::vector<ContactEvent> b{impact(1.001, 1, 0), impact(1.7, 1, 1), impact(2.001, 1, 0)};
  const auto p = pair_impacts(a, b, 2);
  CHECK(p.pairs.size() == 1);
  CHECK_THAT(p.ended_by, Contains("contact event 1 of contact 2"));
  CHECK_THAT(pair_impacts(a, b, 2, INFINITY, INFINITY, {"pin", "guide"}).ended_by,
             Contains("contact event 1 of guide"));
}

TEST_CASE("the load during an impact of the penalty run is separated from its impulse", "[compare]") {
  // m = 2 kg, e = 0.5: the impact law has P = 2·1.5 v. The penalty contact lasts D with a load of 100 N
  // (g̈₀ = −50 m/s²), which it carries beside the impact: P = 2·1.5 v + 100 D.
  auto nonsmooth = impact(1, 1);
  nonsmooth.impulse_n = 3;
  auto penalty = nonsmooth;
  penalty.duration = 1e-3;
  penalty.impulse_n = 3 + 100 * 1e-3;
  const auto light = pair_impacts({penalty}, {nonsmooth}, 1);
  REQUIRE(light.pairs.size() == 1);
  CHECK(light.pairs[0].load == Approx(0.1).epsilon(1e-12));
  CHECK(light.pairs[0].impulse() == Approx(3).epsilon(1e-12));
  CHECK_FALSE(light.pairs[0].loaded());
  penalty.impulse_n = 3 + 3.1;
  CHECK(pair_impacts({penalty}, {nonsmooth}, 1).pairs[0].loaded());
  // The effective mass is unknown where another contact has an impact at the same instant.
  auto other = impact(1, 1, 1);
  CHECK(std::isnan(pair_impacts({penalty, other}, {nonsmooth, other}, 2).pairs[0].load));
}

TEST_CASE("onsets that only one run resolves are merged", "[compare]") {
  // Bounces of 1, 0.5 and 0.25 ms within a penalty impact of 2 ms; the next impact is paired again.
  auto soft = impact(1, 1);
  soft.duration = 2e-3;
  const std::vector<ContactEvent> penalty{soft, impact(1.5, 1)};
  const std::vector<ContactEvent> nonsmooth{impact(1, 1), impact(1.001, 0.5), impact(1.0015, 0.25),
                                            impact(1.00175, 0.1), impact(1.5, 1)};
  const auto p = pair_impacts(penalty, nonsmooth, 1);
  REQUIRE(p.pairs.size() == 2);
  CHECK(p.complete);
  CHECK(p.pairs[0].merged_nonsmooth == 3);
  CHECK(p.pairs[0].merged_penalty == 0);
  // A flight that is longer than any impact of the penalty run is not merged.
  const std::vector<ContactEvent> apart{lasting(1, 1), separation(1.4, 0.4), impact(1.5, 1)};
  const std::vector<ContactEvent> bounces{impact(1, 1), impact(1.2, 0.5), impact(1.5, 1)};
  CHECK(pair_impacts(apart, bounces, 1).pairs.empty());
}

TEST_CASE("impacts that overlap in the penalty run are not comparable one by one", "[compare]") {
  // Within the impact of the first contact (2 ms), the second begins, at a third of the nonsmooth speed.
  auto soft = impact(1, 1);
  soft.duration = 2e-3;
  const auto p = pair_impacts({soft, impact(1.001, 0.3, 1)}, {impact(1, 1), impact(1.001, 1, 1)}, 2, INFINITY,
                              INFINITY, {"rear", "front"});
  CHECK(p.pairs.size() == 1);
  CHECK(p.overlapping);
  CHECK_THAT(p.ended_by, Contains("of front") && Contains("factor of two") &&
                             Contains("within an impact at rear of the penalty run") &&
                             Contains("not comparable one by one"));
}

TEST_CASE("compare reports restitution as matched only if all relevant properties match", "[compare]") {
  struct Case {
    double tangential, friction;
    bool as_given, matched;
    const char* says;
  };
  for (const auto& c :
       {Case{0, 0.1, false, true, "(impact law); matched"},
        Case{0.9, 0.1, false, false, "the contact law ignores the tangential restitution 0.9"},
        // Without friction it acts on nothing.
        Case{0.9, 0, false, true, "(impact law); matched"},
        Case{0, 0.1, true, false, "restitution as given"}}) {
    CAPTURE(c.tangential, c.friction, c.as_given);
    auto scene = read_scene(test::flores());
    auto& surface = scene.mechanism.surfaces[0];
    surface.tangential_restitution = c.tangential;
    surface.friction = c.friction;
    scene.nonsmooth.scheme = Scheme::event_driven;
    scene.run.duration = 0.01;
    scene.run.discard = 0;
    scene.instruments.clear();
    test::TemporaryFolder folder;
    const auto comparison = compare(scene, {.matched = !c.as_given}, folder.path());
    const auto table = comparison_table(scene, comparison, false);
    const auto json = to_json(comparison);
    CHECK_THAT(table, Contains(c.says));
    CHECK((table.find("(impact law); matched") != table.npos) == c.matched);
    CHECK(json["restitution_matched"].get<bool>() == c.matched);
    CHECK(json["not_matched"].contains("gudgeon") == !c.matched);
    CHECK((table.find("Friction: ") != table.npos) == (c.friction > 0));
  }
}

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
  auto a = impact(0, 1), b = impact(0, 3);
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

TEST_CASE("impacts are not compared with sustained contact of the other run", "[compare]") {
  auto c = planted(10);
  c.joints = {"die", "pin"};
  for (auto* run : {&c.penalty, &c.nonsmooth}) run->contacts.resize(2);
  auto& die = c.nonsmooth.contacts[0];
  die.impacts = 1, die.fastest_approach = 0.04, die.greatest_impulse = 2, die.lasting_fraction = 0.1;
  c.penalty.contacts[0].lasting_fraction = 0.1;
  for (auto* run : {&c.penalty, &c.nonsmooth})
    run->contacts[1].impacts = 20, run->contacts[1].fastest_approach = 1;
  const auto scene = read_scene(test::flores());
  const auto v = comparison_values(scene, c);
  REQUIRE(v.approaches.size() == 1);
  CHECK(v.approaches[0].name == "pin");
  CHECK(v.one_sided == std::vector<std::string>{"die (sustained contact in penalty)"});
  CHECK_THAT(verdict(v), Contains("not compared: die (sustained contact in penalty)"));
  // A run that does not touch at all differs.
  c.penalty.contacts[0].lasting_fraction = 0;
  CHECK(comparison_values(scene, c).approaches.size() == 2);
  CHECK(comparison_values(scene, c).one_sided.empty());
}

TEST_CASE("a long name of a contact is printed once for consecutive pairs", "[compare]") {
  auto c = planted(10);
  c.joints = {"mesh.backward", "pin"};
  c.not_matched.resize(2);
  c.frictional = {false, false};
  for (auto* run : {&c.penalty, &c.nonsmooth}) run->contacts.resize(2);
  const auto at = [](double t, int contact) {
    const auto e = impact(t, 0, contact);
    return ImpactPair{e, e};
  };
  // 13 characters do not fit the column of 12.
  c.pairing.pairs = {at(1e-3, 0), at(2e-3, 0), at(3e-3, 1), at(4e-3, 0)};
  const auto scene = read_scene(test::flores());
  CHECK(test::count(comparison_table(scene, c, false), "\nmesh.backward\n") == 2);
  CHECK(test::count(comparison_table(scene, c, true), "\n| mesh.backward | ") == 3);
}
