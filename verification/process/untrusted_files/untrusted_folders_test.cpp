// Result folders of the program, with a hostile text in place of each name, number and column in
// turn, in the commands that read them.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/files/output_file.hpp"
#include "verification/support/support.hpp"
#include "verification/process/untrusted_files/inputs.hpp"

using namespace freeplay;

namespace {

/// Replaces every string of a document, and every number where `numbers`.
void infect(nlohmann::json& at, const std::string& text, bool numbers) {
  for (auto& value : at)
    if (value.is_structured())
      infect(value, text, numbers);
    else if (value.is_string() || (numbers && value.is_number()))
      value = text;
}

/// A table with a text in its k-th field, counted through header and first row.
std::string infected(const std::string& table, const std::string& text, std::size_t k) {
  std::istringstream in(table);
  std::string line, out;
  std::size_t field = 0;
  for (int row = 0; std::getline(in, line); ++row) {
    if (row >= 2 || line.starts_with('#')) {
      out += line + '\n';
      continue;
    }
    std::istringstream cells(line);
    std::string cell;
    for (bool first = true; std::getline(cells, cell, ','); first = false, ++field)
      out += (first ? "" : ",") + (field == k ? text : cell);
    out += '\n';
  }
  return out;
}

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++n;
  return n;
}

}  // namespace

TEST_CASE("hostile texts in the folders of every command", "[security][hostile][long]") {
  const test::TemporaryFolder folder;
  const test::Bait bait(folder.path());
  const auto run = [&](const std::vector<std::string>& arguments) {
    const auto outcome = test::run_program(bait, arguments);
    INFO(fmt::format("{}", fmt::join(arguments, " ")).substr(0, 300));
    INFO("status " << outcome.status << "\n" << outcome.err.substr(0, 1000));
    CHECK(outcome.decent());
    CHECK(bait.untouched());
    return outcome.status;
  };
  write_file(bait.folder / "scene.toml", test::rig("\"rig\""));
  const std::string study =
      "title = \"study\"\nscene = \"scene.toml\"\n[axes.mu]\nkey = \"surfaces.steel.friction\"\n"
      "values = [0.0, 0.05]\n"
      "[axes.speed]\nkey = \"drives.motor.speed_rpm\"\nvalues = [190, 200]\n";
  write_file(
      bait.folder / "up.toml",
      study +
          "[bifurcation]\naxis = \"mu\"\nsection = \"every 0.01 s\"\nperiod = 0.01\ndiscard = 1\nkeep = 2\n");
  write_file(bait.folder / "cells.toml",
             study +
                 "[basin]\nx = \"mu\"\ny = \"speed\"\nsection = \"every 0.01 s\"\n"
                 "period = 0.01\ndiscard = 1\nkeep = 2\n");
  const std::vector<std::vector<std::string>> makers{
      {"run", "scene.toml", "--formulation", "nonsmooth", "--no-figures"},
      {"poincare", "scene.toml", "--section", "every 0.01 s"},
      {"bifurcation", "up.toml"},
      {"basin", "cells.toml"},
      {"scaling", "--most", "2", "--repeat", "1"},
      {"check", "scene.toml"}};
  const auto texts = test::hostile_texts(bait);
  for (std::size_t m = 0; m < makers.size(); ++m) {
    const auto made = fmt::format("made{}", m);
    auto arguments = makers[m];
    arguments.insert(arguments.end(), {"-o", made});
    CAPTURE(makers[m][0]);
    REQUIRE(run(arguments) == 0);
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(bait.folder / made))
      if (const auto kind = entry.path().extension(); kind == ".csv" || kind == ".json" || kind == ".toml")
        files.push_back(std::filesystem::relative(entry.path(), bait.folder / made));
    REQUIRE(!files.empty());
    for (std::size_t i = 0; i < texts.size(); ++i) {
      const auto place = fmt::format("r{}-{}", m, i);
      for (std::size_t f = 0; f < files.size(); ++f) {
        auto text = test::file_text(bait.folder / made / files[f]);
        if (f == i % files.size() && files[f].extension() == ".json") {
          auto document = nlohmann::json::parse(text);
          infect(document, texts[i], i / files.size() % 2 == 1);
          text = document.dump(1, ' ', false, nlohmann::json::error_handler_t::ignore);
        } else if (f == i % files.size()) {
          text = infected(text, texts[i], i / files.size());
        }
        std::filesystem::create_directories((bait.folder / place / files[f]).parent_path());
        write_file(bait.folder / place / files[f], text);
      }
      run({"figures", place});
      if (run({"report", place}) == 0) {
        // The page contains only its own two scripts, whatever the files contain.
        const auto page = test::file_text(bait.folder / place / "report.html");
        CHECK(count(page, "<script") == 2);
        CHECK(count(page, "</script") == 2);
        CHECK(count(page, "<title") == 1);
      }
      run({"plot", place, "--x", i % 3 ? "t" : texts[i].substr(0, texts[i].find('\0')), "--y", "gudgeon.gap",
           "-o", texts[i].substr(0, texts[i].find('\0'))});
      run({"export", place, "--hdf5", "--vtk"});
      run({"animate", place, "--svg", "--fps", "1"});
    }
  }
}
