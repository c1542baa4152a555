// Help of the program: every command's help within 80 columns, the page made from it, and the
// suggestions for a misspelt word.
#include "io/scene/section.hpp"
#include "io/scene/spelling.hpp"
#include "verification/support/messages.hpp"
#include "verification/support/rig.hpp"

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
