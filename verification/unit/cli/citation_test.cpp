// CITATION.cff and the README name the version of the build.
#include <regex>

#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("the citation states title, version and date, and the README agrees", "[citation]") {
  const auto text = [](const char* name) { return test::file_text(test::source_folder() / name); };
  const auto found = [](const std::string& in, const char* pattern) {
    std::smatch match;
    return std::regex_search(in, match, std::regex(pattern)) ? match[1].str() : std::string("absent");
  };
  const auto version = found(text("CMakeLists.txt"), "project\\(freeplay VERSION ([0-9.]+)");
  const auto citation = text("CITATION.cff");
  CHECK(found(citation, "\nversion: ([0-9.]+)\n") == version);
  const auto date = found(citation, "\ndate-released: ([0-9]{4}-[0-9]{2}-[0-9]{2})\n");
  CHECK(date != "absent");
  CHECK_THAT(text("README.md"), Contains(fmt::format("version {} ({})", version, date)));
  const auto title = found(citation, "\ntitle: \"([^\"]+)\"");
  CHECK_THAT(text("README.md"), Contains("*" + title + "*"));
}
