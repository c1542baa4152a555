// freeplay check, run and compare: questions about units, and the status of a comparison that stops.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("unit plausibility: the program asks once on stderr and continues", "[sense]") {
  const auto scene = test::scene_file("pendulum").string();
  const auto plain = test::freeplay("check " + scene);
  CHECK(plain.err.empty());
  const auto o = test::freeplay("check " + scene + " --set gravity=[0,-9810]");
  CHECK(o.status == plain.status);
  CHECK_THAT(o.err, Contains("question: gravity of 9810 m/s²"));
  CHECK(o.err.find("question", 1) == o.err.npos);
  test::TemporaryFolder folder;
  const auto run = test::succeeded("run " + scene + " --formulation nonsmooth --set gravity=[0,-9810]" +
                                   " --set run.duration=1e-3 -o " + (folder.path() / "r").string());
  CHECK_THAT(run.err, Contains("question: gravity of 9810 m/s²"));
  for (const auto& line : test::lines_of(run.err)) CHECK(line.size() <= 82);  // two characters of two bytes
}

TEST_CASE("compare ends with status 1 if either formulation stops", "[compare]") {
  // A step of 0.1 s, a third of a turn, moves the journal far through its bearing.
  const test::TemporaryFolder folder;
  const auto run = test::freeplay("compare " + test::scene_file("gudgeon").string() +
                                  " --set nonsmooth.step=0.1 --set run.duration=0.2 -o " +
                                  (folder.path() / "out").string());
  CAPTURE(run.out, run.err);
  CHECK(run.status == 1);
  CHECK_THAT(run.err, Contains("nonsmooth: stopped"));
}
