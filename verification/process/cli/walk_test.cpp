// scripts/walk: the commands of documentation pages are executed in an empty folder and print the
// output shown.
#include "io/scene/section.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

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
