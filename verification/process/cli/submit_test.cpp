// freeplay submit: contents of files and names enter the batch scripts only as quoted words.
#include <fmt/format.h>
#include <sys/stat.h>
#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "study/partition/division.hpp"
#include "study/partition/record.hpp"
#include "verification/support/ball_study.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string hostile =
    "a'b\"c $(touch canary) `touch canary` \\ %j\n#SBATCH --wrap=touch\n; touch canary #";

/// A planned study, and calls for its scripts.
struct Planned : test::BallStudy {
  Planned() : BallStudy("range = [0.2, 0.8, 3]") {
    const auto o = run({"sweep", study.string(), "--plan", "2", "-o", out.string()});
    CAPTURE(o.err);
    REQUIRE(o.status == 0);
  }
  auto submit(const std::vector<std::string>& more, const std::filesystem::path& into) const {
    std::vector<std::string> words{"submit", study.string(), "--slurm", "--dry-run", "-o", into.string()};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
  }
  auto submit(const std::vector<std::string>& more = {}) const { return submit(more, out); }
  nlohmann::json manifest() const {
    return nlohmann::json::parse(std::ifstream(out / "shards/manifest.json"));
  }
};

}  // namespace

TEST_CASE("quoted words are read back unchanged by a shell", "[security][shards]") {
  const std::vector<std::string> words{
      "plain/a-b_c.toml", "", "two words", hostile, "'", "\\", "$HOME", "*", "~"};
  test::TemporaryFolder folder;
  const auto script = folder.path() / "script", said = folder.path() / "said";
  write_file(script, "printf '%s\\0' " + shell_words(words) + " > " + shell_words({said.string()}) + "\n");
  REQUIRE(std::system(("sh " + shell_words({script.string()})).c_str()) == 0);
  std::ifstream in(said, std::ios::binary);
  for (const auto& word : words) {
    std::string back;
    REQUIRE(std::getline(in, back, '\0'));
    CHECK(back == word);
  }
  CHECK(shell_words({"plain/a-b_c.toml", "-o"}) == "plain/a-b_c.toml -o");
}

TEST_CASE("options that do not fit into a line of a Slurm script are refused", "[security][shards]") {
  const Planned place;
  for (const auto* option : {"--partition", "--time"})
    for (const auto& text : {hostile, std::string("a b"), std::string("a\nb"), std::string("\"")}) {
      const auto o = place.submit({option, text});
      CAPTURE(option, text, o.err);
      CHECK(o.status == 2);
      CHECK(o.out.empty());
      CHECK_THAT(o.err, Contains(option));
      CHECK(std::ranges::count(o.err, '\n') <= 2);
    }
  const auto o = place.submit({"--partition", "short,long-1", "--time", "1-12:00:00"});
  CHECK(o.status == 0);
  CHECK_THAT(o.out,
             Contains("#SBATCH --partition=short,long-1\n") && Contains("#SBATCH --time=1-12:00:00\n"));
  for (const auto* name : {"a\nb", "a'b", "a\"b", "a\\b", "%j", "a\x7f"}) {
    CAPTURE(name);
    const auto refused = place.submit({}, place.folder.path() / name);
    CHECK(refused.status == 2);
    CHECK_THAT(refused.err, Contains("-o "));
    CHECK_FALSE(std::filesystem::exists(place.folder.path() / name));
  }
  const auto spaced = place.submit({}, place.folder.path() / "two words");
  CHECK(spaced.status == 0);
  CHECK_THAT(spaced.out, Contains("two words/shards/log/%A_%a.log\"\n"));
}

TEST_CASE("an invalid node name does not reach the script", "[security][shards]") {
  const Planned place;
  const auto fail_on = [&](int k, const std::string& host) {
    write_file(place.out / fmt::format("shards/{}.state.json", k),
               nlohmann::json{{"state", "failed"}, {"reason", "scratch is full"}, {"host", host}}.dump());
  };
  fail_on(1, "node7");
  fail_on(2, "node8\n#SBATCH --wrap=touch");
  const auto o = place.submit();
  CAPTURE(o.err);
  CHECK(o.status == 0);
  CHECK_THAT(o.out, Contains("#SBATCH --exclude=node7\n") && !Contains("wrap"));
  write_file(place.out / "shards/1.state.json", "{\"state\": 5, \"host\": []}");
  CHECK(place.submit().status == 0);
}

TEST_CASE("a plan of another study or with invalid content is refused", "[security][shards]") {
  const Planned place;
  const auto file = place.out / "shards/manifest.json";
  const auto study = place.study.string();
  const auto first = place.manifest();
  const auto refused = [&](const nlohmann::json& m) {
    write_file(file, m.dump());
    for (const auto& o :
         {place.submit(), place.run({"sweep", study, "--shard", "1/2", "-o", place.out.string()}),
          place.run({"sweep", study, "--merge", place.out.string()})}) {
      CAPTURE(m.dump(), o.out, o.err);
      CHECK(o.status != 0);
      CHECK_THAT(o.out, !Contains("#SBATCH"));
      CHECK(std::ranges::count(o.err, '\n') <= 2);
    }
  };
  // The plan's digest is that of its content: these are forged with a matching digest, as is
  // possible for anyone.
  const auto forged = [&](const char* key, const nlohmann::json& value) {
    auto m = first;
    m[key] = value;
    m["plan"] = plan_digest(m.get<Manifest>());
    return m;
  };
  refused(forged("verb", "run"));
  refused(forged("verb", "sweep; touch canary"));
  refused(forged("arguments", {study, "--allow-outside"}));
  refused(forged("arguments", {study, "-o", "/elsewhere"}));
  refused(forged("arguments", {"--help"}));
  refused(forged("arguments", nlohmann::json::array()));
  refused(forged("arguments", {"x\n#SBATCH --wrap=touch"}));
  refused(forged("arguments", {study, "--set", "run.duration=1"}));  // an ensemble's
  auto ensemble = forged("verb", "ensemble");
  ensemble["arguments"] = {study, "-o", "/elsewhere"};
  ensemble["plan"] = plan_digest(ensemble.get<Manifest>());
  refused(ensemble);
  CHECK(place.run({"status", study, "-o", place.out.string()}).status == 2);
  refused(forged("shards", std::uint64_t{1} << 62));
  refused(forged("units", std::uint64_t{1} << 62));
  std::filesystem::remove(file);
  REQUIRE(mkfifo(file.c_str(), 0600) == 0);  // reading does not wait for a writer
  CHECK(place.submit().status == 2);
  std::filesystem::remove(file);
  write_file(file, first.dump());
  CHECK(place.submit().status == 0);
  std::filesystem::rename(place.out / "shards", place.folder.path() / "elsewhere");
  std::filesystem::create_directory_symlink(place.folder.path() / "elsewhere", place.out / "shards");
  CHECK(place.submit().status == 2);
}

TEST_CASE("a merge that fails on a node is not sent there again", "[shards]") {
  const Planned place;
  for (const char* shard : {"1/2", "2/2"})
    REQUIRE(place.run({"sweep", place.study.string(), "--shard", shard, "-o", place.out.string()}).status ==
            0);
  setenv("SLURMD_NODENAME", "node3", 1);
  const auto first = place.submit(), later = place.submit({"--round", "2", "--exclude", "node5"}),
             refused = place.submit({"--exclude", "node5\n#SBATCH --wrap=touch"});
  unsetenv("SLURMD_NODENAME");
  CHECK_THAT(first.out, !Contains("--exclude"));
  // Later rounds receive both.
  CHECK_THAT(later.out,
             Contains("#SBATCH --exclude=node3,node5\n") && Contains("--round 3 --exclude node3,node5"));
  CHECK(refused.status == 2);
  CHECK_THAT(refused.err, Contains("--exclude"));
}

// Slurm commands that do not answer: submit and status end in time with a message. Licences of the
// files that scripts/bundle ships.

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
