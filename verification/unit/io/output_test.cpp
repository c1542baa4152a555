// Files, events and pairing.
#include <sys/resource.h>
#include <csignal>

#include "simulation/contact_log.hpp"
#include "simulation/statistics.hpp"
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// During its lifetime no file of this process grows beyond `most` bytes, as on a
/// full disk.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t most) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit{most, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;

 private:
  rlimit before_{};
  void (*handler_)(int);
};

}  // namespace

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
  {
    const SmallFiles limit(1000);
    REQUIRE_THROWS_WITH(write_file(folder.path() / "b.csv", std::string(1 << 20, 'x')),
                        Contains("File too large"));
  }
  REQUIRE_FALSE(std::filesystem::exists(folder.path() / "b.csv"));
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

TEST_CASE("pairing of contacts ends where the motions diverge", "[compare]") {
  const auto touch = [](double t, double v) {
    ContactEvent e;
    e.t = t;
    e.v_n_minus = -v;
    return e;
  };
  const std::vector<ContactEvent> a{touch(1, 1), touch(2, .5), touch(3, .3)};
  const std::vector<ContactEvent> b{touch(1.009, 1), touch(2.09, .5), touch(3.4, .3)};
  const auto p = pair_impacts(a, b, 1);
  REQUIRE(p.pairs.size() == 2);
  REQUIRE(p.horizon == 2.09);
  // A truncated list is known up to its last event: missing events after it are no difference.
  const std::vector<ContactEvent> cut{touch(1, 1), touch(2, .5)};
  const std::vector<ContactEvent> whole{touch(1.009, 1), touch(2.01, .5), touch(3.01, .3)};
  const auto known = pair_impacts(cut, whole, 1, 2);
  REQUIRE(known.pairs.size() == 1);  // the second ends where the list does
  REQUIRE_THAT(known.ended_by, Contains("events of a run end there"));
  REQUIRE_THAT(pair_impacts(cut, whole, 1).ended_by,
               Contains("contact event 3") && Contains("the nonsmooth run only"));
  REQUIRE_THAT(p.ended_by, Contains("contact event 3"));
  REQUIRE(pair_impacts(a, a, 1).pairs.size() == 3);
  REQUIRE(pair_impacts(a, {a[0]}, 1).pairs.size() == 1);
}
