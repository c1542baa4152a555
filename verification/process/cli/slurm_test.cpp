// Slurm commands that do not answer: submit and status end in time with a message. Licences of the
// files that scripts/bundle ships.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <fstream>
#include <iterator>

#include "verification/support/ball_study.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Cluster {
  Cluster() {
    test::put_ball_study(folder.path(), "values = [0.5, 0.6]", "formulations = [\"nonsmooth\"]\n");
    make_folder(folder.path() / "bin");
    command("sinfo", "echo 0/1/0/1");
    command("sbatch", "echo 7");
    command("squeue", ":");
  }
  void command(const std::string& name, const std::string& does) const {
    const auto file = folder.path() / "bin" / name;
    write_file(file, "#!/bin/sh\n" + does + "\n");
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
  }
  /// Exit status, what was printed, and seconds.
  struct Ended {
    int status;
    std::string said;
    double seconds;
  };
  Ended run(const std::string& arguments) const {
    const auto began = std::chrono::steady_clock::now();
    const int status = std::system(
        fmt::format("cd '{0}' && PATH='{0}/bin':$PATH FREEPLAY_SLURM_SECONDS=1 timeout 50 '{1}/freeplay' {2} "
                    ">said 2>&1",
                    folder.path().string(), FREEPLAY_BINARY_DIR, arguments)
            .c_str());
    std::ifstream in(folder.path() / "said");
    return {WEXITSTATUS(status),
            {std::istreambuf_iterator<char>(in), {}},
            std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count()};
  }
  test::TemporaryFolder folder;
};

}  // namespace

TEST_CASE("a Slurm command that does not answer is ended and named", "[shards][errors]") {
  const Cluster cluster;
  const std::string submit = "submit study.toml --slurm --array 1 -o out";
  CHECK(cluster.run(submit).status == 0);
  for (const auto& [hangs, status] :
       {std::pair<std::string, int>{"squeue", 1}, {"sbatch", 1}, {"sinfo", 0}}) {
    CAPTURE(hangs);
    const Cluster one;
    // A grandchild process that keeps the pipe open does not delay the end either.
    one.command(hangs, "[ \"$1\" = --version ] && exit; sleep 100 & wait");
    const auto outcome = one.run(hangs == "sinfo" ? "submit study.toml --slurm -o out" : submit);
    CAPTURE(outcome.said);
    CHECK(outcome.status == status);
    if (status == 1) CHECK_THAT(outcome.said, Contains(hangs) && Contains("no answer within 1 s"));
    // a time limit of one second for a command; the rest for a busy machine
    CHECK(outcome.seconds < 20);
  }
  cluster.command("squeue", "sleep 100");
  const auto outcome = cluster.run("status study.toml -o out");
  CAPTURE(outcome.said);
  CHECK(outcome.status == 0);
  CHECK_THAT(outcome.said, Contains("0 of 2 units") && Contains("squeue: no answer within 1 s"));
  CHECK(outcome.seconds < 20);
}

TEST_CASE("licences of all shipped parts are shipped", "[docs]") {
  const test::TemporaryFolder folder;
  const auto out = (folder.path() / "licences").string();
  const auto of = [&](const std::string& files) {
    return std::system(fmt::format("cd '{}' && {} | xargs scripts/licences '{}' 2>'{}/why'",
                                   test::source_folder().string(), files, out, folder.path().string())
                           .c_str());
  };
  REQUIRE(of(fmt::format("ldd '{}/freeplay' | awk '$3 ~ /^\\// {{print $3}}' | grep -v san",
                         FREEPLAY_BINARY_DIR)) == 0);
  const auto text = [&](const std::string& name) { return test::file_text(out + "/" + name); };
  for (const auto& [package, licence] : {std::pair{"coinor-libipopt1v5", "Public License"},
                                         {"libklu1", "LGPL-2.1"},
                                         {"libmumps-seq-5.5", "CeCILL"},
                                         {"libtbb12", "Apache-2.0"},
                                         {"libsqlite3-0", "public domain"},
                                         {"libeigen3-dev", "MPL"}}) {
    CAPTURE(package);
    CHECK_THAT(text(std::string(package) + ".txt"), Contains(licence, Catch::CaseSensitive::No));
    CHECK_THAT(text("README"), Contains(package));
  }
  CHECK(std::filesystem::exists(out + "/common/LGPL-2.1"));
  CHECK(std::filesystem::exists(out + "/common/Apache-2.0"));
  // A file that belongs to no package has an unreviewed licence.
  write_file(folder.path() / "lib.so", "");
  CHECK(of(fmt::format("echo '{}'", (folder.path() / "lib.so").string())) != 0);
}
