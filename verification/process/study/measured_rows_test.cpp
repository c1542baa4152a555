// freeplay calibrate and validate with measured rows: the twelve quoted rows of cases/planar-impacts.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("verbs fit and predict measured rows", "[rows]") {
  const test::StudyDesk desk("planar-impacts");
  const auto folder = test::source_folder() / "cases/planar-impacts";
  desk.put("twelve.csv", test::file_text(folder / "twelve.csv"));
  desk.put("study.toml",
           test::replaced(test::file_text(folder / "study.toml"), "planar-impacts.csv", "twelve.csv"));
  const auto fitted = desk.run("calibrate");
  CAPTURE(fitted.out, fitted.err);
  REQUIRE(fitted.status == 0);
  CHECK_THAT(fitted.out, Contains("newton [nonsmooth]: Newton, Coulomb friction"));
  CHECK_THAT(fitted.out, !Contains("predicted"));
  const auto calibration = nlohmann::json::parse(test::file_text(desk.at("out/calibration.json")));
  CHECK(calibration["models"][0]["fits"][0]["rows"] == 12);
  CHECK_FALSE(calibration["models"][0].contains("predicted"));
  const auto predicted = desk.run("validate");
  CAPTURE(predicted.out, predicted.err);
  REQUIRE(predicted.status == 0);
  CHECK_THAT(predicted.out, Contains("without part 0 (6 rows fitted)"));
  CHECK_THAT(predicted.out, Contains("models, "));
  const auto document = nlohmann::json::parse(test::file_text(desk.at("out/rows.json")));
  CHECK(document["models"][0]["predicted"][0]["count"] == 12);
  // A line for each row of each model, after the header.
  CHECK(test::read_csv(desk.at("out/rows.csv")).size() == 1 + 12 * document["models"].size());
}
