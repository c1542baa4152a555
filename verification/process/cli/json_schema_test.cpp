// freeplay schema: the schemas accept all scenes and studies of cases/ and all templates, by an
// independent validator, and refuse wrong ones.
#include <fmt/format.h>
#include <sys/wait.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "io/files/output_file.hpp"
#include "io/scene/section.hpp"
#include "verification/support/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

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
