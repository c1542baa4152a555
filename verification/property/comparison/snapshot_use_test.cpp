// Snapshots in use: return to the start, observation from the snapshot on, a changed start, files,
// and refusals.
#include "verification/property/comparison/snapshot_check.hpp"

using namespace freeplay;
using namespace freeplay::snapshots;
using Catch::Matchers::Contains;

namespace {

Scene crank(std::vector<std::string> set = {"run.duration=0.01"}) {
  set.emplace_back("penalty.tolerance=1e-7");
  return read_scene(test::scene_file("tests/instrumented_crank"), set);
}

}  // namespace

TEST_CASE("snapshots: return to a state before the first step, in a simulation that has run", "[snapshot]") {
  const auto check_again = [](const std::string& text, const std::string& formulation,
                              const std::vector<std::string>& set) {
    CAPTURE(formulation, set);
    Simulation simulation(parse_scene(text, "snapshot.toml", set), formulation);
    const auto empty = simulation.snapshot();
    Record first(simulation, true), second(simulation, true);
    const auto whole = test::finished(simulation, {&first});
    simulation.restore(empty);
    REQUIRE(simulation.t() == 0);
    const auto again = simulation.run({.observers = {&second}});
    CHECK((second.steps == first.steps));
    CHECK((second.events == first.events));
    CHECK((second.samples == first.samples));
    CHECK((bits_of(again) == bits_of(whole)));
  };
  for (const std::string integrator :
       {"rk4", "dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"})
    check_again(text("tests/instrumented_crank"), "penalty",
                {"penalty.integrator=" + integrator, "run.duration=0.012",
                 integrator == "rk4" ? "penalty.step=1e-5" : "penalty.tolerance=1e-7"});
  check_again(chain(), "penalty", {"penalty.tolerance=1e-7", "run.duration=0.05"});
  check_again(chain(), "nonsmooth",
              {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=5e-4", "run.duration=0.1"});
  check_again(chain(), "nonsmooth",
              {"nonsmooth.scheme=event-driven", "nonsmooth.tolerance=1e-6", "run.duration=0.1"});
  for (const std::string scheme : {"moreau-jean", "automatic"})
    check_again(test::random_pile(1), "nonsmooth", {"nonsmooth.scheme=" + scheme, "run.duration=0.45"});
}

TEST_CASE("snapshots: observation that begins after the snapshot", "[snapshot]") {
  // Sparse factors: the separate factors of forces are made at the first request for forces.
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    const auto scene = parse_scene(chain(), "snapshot.toml",
                                   {"penalty.tolerance=1e-7", "nonsmooth.step=5e-4", "run.duration=0.1"});
    Simulation seen(scene, formulation), restored(scene, formulation);
    seen.run({.until = 0.05});
    restored.restore(seen.snapshot());
    Record a(seen, true), b(restored, true);
    const auto rest = seen.run({.observers = {&a}}), again = restored.run({.observers = {&b}});
    CHECK((a.steps == b.steps));
    CHECK((a.samples == b.samples));
    CHECK_FALSE(a.samples.empty());
    CHECK((bits_of(rest) == bits_of(again)));
  }
}

TEST_CASE("snapshots: a changed start is included", "[snapshot]") {
  const auto scene = read_scene(test::scene_file("pendulum"), {"run.duration=0.1", "penalty.tolerance=1e-6"});
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    Simulation first(scene, formulation);
    first.run({.until = 0.05});
    Simulation begun(scene, formulation, {.start = first.state()}), fresh(scene, formulation);
    begun.run({.until = 0.07});
    fresh.restore(begun.snapshot());
    CHECK(fresh.layout().start[0].gap == begun.layout().start[0].gap);
    CHECK((bits_of(fresh.run()) == bits_of(begun.run())));
  }
}

TEST_CASE("snapshots: paused instruments resume at the present time", "[snapshot][instruments]") {
  const auto scene = crank({"run.duration=0.03"});
  Simulation rested(scene, "penalty");
  rested.run({.until = 0.0151});
  test::Listener listener;
  double last = 0;
  std::array<double, 5> first{};
  listener.on_sample = [&](std::size_t channel, double t, double) {
    if (first[channel] == 0) first[channel] = t;
    last = std::max(last, t);
  };
  rested.run({.observers = {&listener}});
  CHECK(last <= 0.03 + 1e-9);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CAPTURE(scene.instruments[i].name);
    CHECK(first[i] > 0.0151);
    CHECK(first[i] <= 0.0151 + (1 + 1e-6) / scene.instruments[i].sampling);
  }
}

TEST_CASE("snapshots: written to a file and read back", "[snapshot][files]") {
  test::TemporaryFolder folder;
  const auto file = folder.path() / "a.snapshot";
  const auto scene = crank();
  Simulation one(scene, "penalty"), two(scene, "penalty");
  one.run({.until = 0.007});
  const auto s = one.snapshot();
  s.write(file);
  s.write(file);  // over an older one
  const auto r = Snapshot::read(file);
  CHECK(r.t == s.t);
  CHECK(r.program == s.program);
  CHECK(r.formulation == s.formulation);
  CHECK(r.scene == s.scene);
  CHECK((r.memory == s.memory));
  two.restore(r);
  CHECK((bits_of(two.run()) == bits_of(one.run())));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) CHECK(entry.path() == file);
  CHECK_THROWS_AS(s.write(folder.path() / "none" / "a.snapshot"), SnapshotError);
}

TEST_CASE("snapshots: one that does not fit is refused, and the simulation stays unchanged",
          "[snapshot][files]") {
  test::TemporaryFolder folder;
  const auto scene = crank();
  Simulation simulation(scene, "penalty");
  simulation.run({.until = 0.007});
  const auto own = simulation.snapshot();
  Simulation untouched(scene, "penalty");
  untouched.restore(own);
  const auto rest = bits_of(untouched.run());
  const auto refused = [&](const Snapshot& s, const std::string& why) {
    CHECK_THROWS_AS(simulation.restore(s), SnapshotError);
    CHECK_THROWS_WITH(simulation.restore(s), Contains(why));
    CHECK((simulation.snapshot().memory == own.memory));
  };
  const auto of = [](const Scene& other) { return Simulation(other, "penalty").snapshot(); };
  refused(of(crank({"run.duration=0.01", "joints.gudgeon.clearance=3e-4"})),
          "joints.gudgeon.clearance is 0.00025 here and 0.0003 there");
  refused(of(crank({"run.duration=0.02"})), "run.duration is 0.01 here and 0.02 there");
  refused(of(read_scene(test::scene_file("pendulum"))), "is of another scene");
  Simulation nonsmooth(scene, "nonsmooth"), matched(scene, "nonsmooth", {.matched = true});
  refused(nonsmooth.snapshot(),
          "is of another formulation: formulation is \"penalty\" here and \"nonsmooth\" there");
  CHECK_THROWS_WITH(nonsmooth.restore(matched.snapshot()), Contains("matched is false here and true there"));
  CHECK_THROWS_WITH(matched.restore(nonsmooth.snapshot()), Contains("matched is true here and false there"));
  CHECK_THROWS_WITH(matched.restore(own),
                    Contains("formulation is \"nonsmooth\" here and \"penalty\" there"));
  auto changed = own;
  changed.program = "version = \"9.9.9\"\nsources = \"abc\"\n";
  refused(changed, "was taken by freeplay 9.9.9 (");
  for (const std::size_t size :
       {own.memory.size() - 1, own.memory.size() / 2, std::size_t{5}, std::size_t{0}}) {
    changed = own;
    changed.memory.resize(size);
    refused(changed, "incomplete");
  }
  changed = own;
  changed.memory.push_back(std::byte{0});
  refused(changed, "the snapshot is too long");

  // Files.
  const auto file = folder.path() / "a.snapshot";
  own.write(file);
  const auto whole = test::file_text(file);
  const auto read_refused = [&](const std::string& bytes, const std::string& why) {
    write_file(file, bytes);
    CHECK_THROWS_WITH(Snapshot::read(file), Contains(file.string()) && Contains(why));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  };
  std::mt19937 engine(7);
  const auto body = whole.find('\n') + 1;
  for (const auto size : {whole.size() - 1, whole.size() / 2, body})
    read_refused(whole.substr(0, size), "is damaged");
  read_refused(whole + "x", "is damaged");
  for (const std::size_t size : {std::size_t{0}, std::size_t{4}, body - 1})
    read_refused(whole.substr(0, size), "is not a snapshot of freeplay");
  for (int i = 0; i < 50; ++i) {
    auto flipped = whole;
    flipped[body + engine() % (whole.size() - body)] ^= static_cast<char>(1 << engine() % 8);
    read_refused(flipped, "is damaged");
  }
  for (std::size_t i = 0; i < body; ++i) {  // in the line before it
    auto flipped = whole;
    flipped[i] ^= 1;
    write_file(file, flipped);
    CAPTURE(flipped.substr(0, body));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  }
  const std::string version = "freeplay snapshot 2 ";
  REQUIRE(whole.starts_with(version));
  read_refused("freeplay snapshot 1 " + whole.substr(version.size()),
               "is a snapshot of version 1; this program reads version 2");
  read_refused("freeplay checkpoint 2 " + whole.substr(version.size()), "is not a snapshot of freeplay");
  read_refused("t,x,y\n0,0,0\n", "is not a snapshot of freeplay");
  CHECK_THROWS_WITH(Snapshot::read(folder.path()), Contains("is a folder, not a file"));
  CHECK_THROWS_WITH(Snapshot::read(folder.path() / "none"), Contains("none"));

  CHECK((bits_of(simulation.run()) == rest));
}
