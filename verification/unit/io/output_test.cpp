// Files and events.
#include "simulation/contact_log.hpp"
#include "simulation/statistics.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("a file appears complete or not at all", "[files]") {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "a.csv";
  {
    OutputFile file(path);
    file.write("half");
  }
  REQUIRE(std::filesystem::is_empty(folder.path()));
  write_file(path, "whole");
  REQUIRE(std::filesystem::file_size(path) == 5);
  REQUIRE_THROWS_AS(OutputFile(folder.path() / "none" / "c.csv"), OutputError);
}

TEST_CASE("there is one zero in a file", "[files]") {
  test::TemporaryFolder folder;
  const auto path = folder.path() / "zero.csv";
  OutputFile file(path);
  for (const double x : {-0.0, 0.0, -1e-300}) {
    file.number(x);
    file.write("\n");
  }
  file.commit();
  CHECK(test::file_text(path) == "0\n0\n-1e-300\n");
}

TEST_CASE("contact log: impacts, lasting contact, order, counts", "[events]") {
  ContactLog log(2);
  ContactStatistics statistics(0);
  Layout layout;
  layout.contacts = {"a", "b"};
  statistics.begin(layout, {});
  std::vector<ContactEvent> out;
  const auto drain = [&] {
    log.drain([&](const ContactEvent& e) {
      out.push_back(e);
      statistics.event({e, layout.contacts[e.contact]});
    });
  };
  log.record_onset(0, 1.0, 0, -0.5, 0, 0, 0.1);
  log.record_onset(1, 1.02, 0, -0.2, 0, 0, 0.1);
  log.record_separation(1, 1.05, 0, 0.1, 0, 2.0, 0, 0.03);
  drain();
  REQUIRE(out.empty());  // the contact at 1.0 is still undecided
  log.advance(1.2);
  drain();
  REQUIRE(out.size() == 2);
  REQUIRE(out[0].kind == EventKind::contact);
  REQUIRE(out[1].kind == EventKind::impact);
  log.record_separation(0, 3.0, 0, 0.1, 0, 9.0, 0, 2.0);
  drain();
  const std::vector<double> undecided{log.undecided_since(0), log.undecided_since(1)};
  statistics.end({{}, 4.0, log.held_back(), undecided});
  const auto& tallies = statistics.tallies();
  REQUIRE(out.at(2).kind == EventKind::separation);
  REQUIRE(tallies[0].lasting_time == Approx(2));
  REQUIRE(tallies[1].impact_time == Approx(0.03));
  REQUIRE(tallies[1].approach.total() == 1);
  REQUIRE(tallies[0].time == Approx(4));
}
