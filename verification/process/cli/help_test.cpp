// Help of the program: every command's help within 80 columns, the page made from it, and the
// suggestions for a misspelt word.
#include <fmt/format.h>
#include <sys/wait.h>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "io/files/output_file.hpp"
#include "io/scene/section.hpp"
#include "io/scene/spelling.hpp"
#include "verification/random_scenes/scene.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::vector<std::string> verbs() {
  std::vector<std::string> list;
#define VERB(name) list.emplace_back(#name);
#include "cli/verbs.def"
  return list;
}

}  // namespace

TEST_CASE("docs/reference/diagnostics.md lists every diagnostic", "[help][pages]") {
  const auto page = read_text(test::source_folder() / "docs/reference/diagnostics.md");
  const auto listed = test::succeeded("doctor --diagnostics");
  CHECK(page.ends_with(listed.out));
}

TEST_CASE("docs/reference/verbs.md shows each verb's help, which fits 80 columns", "[help][pages]") {
  std::string expected =
      "# Commands (verbs)\n\n"
      "This page lists the commands of the program (verbs) with their options and examples, as "
      "printed by\n"
      "`freeplay help` and `freeplay help VERB`; `scripts/pages` writes it.\n";
  const auto show = [&](const std::string& text) { expected += fmt::format("\n```text\n{}```\n", text); };
  show(test::succeeded("help").out);
  for (const auto& verb : verbs()) {
    CAPTURE(verb);
    const auto page = test::succeeded("help " + verb).out;
    CHECK_THAT(page, Contains("usage: freeplay " + verb) && Contains("\nexample"));
    CHECK(page == test::freeplay(verb + " --help").out);
    for (const auto& line : test::lines_of(page)) {
      CAPTURE(line);
      CHECK(test::width(line) <= 80);
    }
    expected += fmt::format("\n## {}\n", verb);
    show(page);
  }
  INFO("make it anew: scripts/pages --make verbs");
  CHECK(read_text(test::source_folder() / "docs/reference/verbs.md") == expected);
}

TEST_CASE("the help of extremes names all kinds of random scenes", "[help]") {
  const auto page = test::succeeded("help extremes").out;
  using verification::random_scenes::Suite;
  for (const auto suite : {Suite::rows, Suite::flexible})
    for (const auto& kind : verification::random_scenes::kinds(suite)) CHECK_THAT(page, Contains(kind));
  for (const char* set : {"new", "elements", "flexible"}) CHECK_THAT(page, Contains(set));
}

TEST_CASE("the man page and the completions for three shells contain every command", "[help]") {
  if (std::system("command -v python3 >/dev/null") != 0) {
    WARN("python3 is missing: scripts/shell-pages is not tested");
    return;
  }
  const test::TemporaryFolder folder;
  const auto script = test::source_folder() / "scripts/shell-pages";
  const auto program = std::filesystem::path(FREEPLAY_BINARY_DIR) / "freeplay";
  REQUIRE(std::system(fmt::format("'{}' '{}' '{}'", script.string(), program.string(), folder.path().string())
                          .c_str()) == 0);
  const auto file = [&](const char* name) { return read_text(folder.path() / name); };
  for (const auto& verb : verbs()) {
    CAPTURE(verb);
    CHECK_THAT(file("freeplay.1"), Contains("\n.SS " + verb + "\n"));
    CHECK_THAT(file("freeplay.bash"), Contains("\n    " + verb + ") options='--help"));
    CHECK_THAT(file("_freeplay"), Contains("\n    " + verb + ") options=("));
    CHECK_THAT(file("freeplay.fish"), Contains(" -a " + verb + " -d "));
  }
  CHECK_THAT(file("freeplay.bash"), Contains("'run --formulation') words='penalty nonsmooth'"));
}

TEST_CASE("the distance of two words counts insertions, deletions, substitutions and transpositions",
          "[help]") {
  // By hand, from the definition.
  CHECK(edit_distance("", "abc") == 3);
  CHECK(edit_distance("run", "run") == 0);
  CHECK(edit_distance("rum", "run") == 1);
  CHECK(edit_distance("rnu", "run") == 1);
  CHECK(edit_distance("clearence", "clearance") == 1);
  CHECK(edit_distance("kitten", "sitting") == 3);
  // no letter moves twice: the unrestricted distance would be 2
  CHECK(edit_distance("ca", "abc") == 3);
  CHECK(nearest_word("fourbar", {"cam", "four-bar", "pendulum"}) == "four-bar");
  CHECK(nearest_word("wheel", {"cam", "pendulum"}).empty());
  // A revolute joint has an angle in place of a position.
  CHECK(nearest_word("bearing.position", {"bearing.rate", "bearing.angle", "rail.position"}) ==
        "bearing.angle");
  CHECK(nearest_word("rail.angle", {"bearing.angle", "rail.position"}) == "rail.position");
}

TEST_CASE("the program's overview lists every verb, whatever words follow an end of options", "[help]") {
  const auto overview = test::freeplay("help").out;
  for (const auto& verb : verbs()) CHECK_THAT(overview, Contains("\n  " + verb + " "));
  CHECK(test::freeplay("-- check").err == overview);
}

TEST_CASE("a verb of freeplay-verify names the program where it is missing", "[help][errors]") {
  const test::TemporaryFolder folder;
  const auto program = folder.path() / "freeplay", said = folder.path() / "said";
  std::filesystem::copy_file(std::filesystem::path(FREEPLAY_BINARY_DIR) / "freeplay", program);
  CHECK(std::system(fmt::format("'{}' verify cams 2>'{}'", program.string(), said.string()).c_str()) != 0);
  CHECK(test::file_text(said) ==
        fmt::format("freeplay verify: needs the program {}-verify: No such file or directory\n",
                    program.string()));
}

// freeplay schema: the schemas accept all scenes and studies of cases/ and all templates, by an
// independent validator, and refuse wrong ones.

namespace {

/// Exit status of a command. Its output goes to a file.
int status_of(const std::string& command, const std::filesystem::path& output) {
  return WEXITSTATUS(std::system(fmt::format("{} > '{}' 2>&1", command, output.string()).c_str()));
}

}  // namespace

TEST_CASE("JSON schemas accept all cases and templates and refuse wrong documents", "[scene][docs]") {
  const test::TemporaryFolder folder;
  const auto output = folder.path() / "output", file = folder.path() / "s.toml";
  // scripts/install-deps installs the validator, so that this test cannot pass without it.
  REQUIRE(status_of("python3 -c 'import tomllib, jsonschema'", output) == 0);
  const auto validate =
      fmt::format("'{}' '{}/freeplay'", (test::source_folder() / "scripts/validate-schemas").string(),
                  FREEPLAY_BINARY_DIR);
  const int status = status_of(validate, output);
  INFO(read_text(output));
  CHECK(status == 0);
  const auto refused = [&](const std::string& text) {
    write_file(file, text);
    CHECK(status_of(validate + " " + file.string(), output) == 1);
    return read_text(output);
  };
  CHECK_THAT(refused("[bodies.a]\nmas = 1\n"), Contains("bodies.a: ") && Contains("'mas' was unexpected"));
  CHECK_THAT(refused("[bodies.a]\nmass = true\n"), Contains("bodies.a.mass: True is not valid"));
  CHECK_THAT(refused("scene = \"s.toml\"\n[axes.a]\nkeys = \"b\"\n"),
             Contains("axes.a.keys: 'b' is not of type 'array'"));
}

// scripts/walk: the commands of documentation pages are executed in an empty folder and print the
// output shown.

namespace {

/// Status of scripts/walk for a page; its errors are written to `said`.
int walk(const std::filesystem::path& page, const std::filesystem::path& said) {
  const auto script = test::source_folder() / "scripts/walk";
  const auto program = std::filesystem::path(FREEPLAY_BINARY_DIR) / "freeplay";
  return std::system(fmt::format("'{}' '{}' '{}' >'{}' 2>&1", script.string(), page.string(),
                                 program.string(), said.string())
                         .c_str());
}

}  // namespace

TEST_CASE("the commands of the tutorial and README work as shown", "[pages][tutorial][slow]") {
  const test::TemporaryFolder folder;
  const auto said = folder.path() / "said";
  for (const auto* page : {"docs/tutorials/first-steps.md", "README.md"}) {
    const int status = walk(test::source_folder() / page, said);
    INFO(read_text(said));
    CHECK(status == 0);
  }
}

TEST_CASE("a page with wrong output or a failing command is refused", "[pages]") {
  const test::TemporaryFolder folder;
  const auto page = folder.path() / "page.md", said = folder.path() / "said";
  const auto tells = [&](const std::string& block) {
    write_file(page, "words\n" + block + "words\n");
    const bool good = walk(page, said) == 0;
    INFO(read_text(said));
    return good;
  };
  const std::string begin = "```console\n";
  CHECK(tells(begin + "$ echo one; echo two\none\ntwo\n```\n"));
  CHECK(tells(begin + "$ echo one; echo two\n...\ntwo\n```\n"));
  CHECK_FALSE(tells(begin + "$ echo one; echo two\none\n```\n"));
  CHECK_FALSE(tells(begin + "$ echo one\ntwo\n```\n"));
  CHECK_FALSE(tells(begin + "$ echo 0.2 mm\n0.3 mm\n```\n"));
  CHECK(tells("```console about\n$ echo 0.2 mm\n0.3 mm\n```\n"));
  CHECK_FALSE(tells("```console about\n$ echo 0.2 mm\n0.3 m\n```\n"));
  CHECK_FALSE(tells(begin + "$ false\n```\n"));
  CHECK(tells(begin + "$ false   # exit status 1\n```\n"));
  CHECK(tells("```toml a.toml\nx = 1\ny = 2\n```\n```diff a.toml\n x = 1\n-y = 2\n+y = 3\n```\n" + begin +
              "$ cat a.toml\nx = 1\ny = 3\n```\n"));
  CHECK_FALSE(tells("```toml a.toml\nx = 1\n```\n```diff a.toml\n-x = 2\n+x = 3\n```\n"));
}
