// freeplay validate of a study with measured points: verdicts, files and refusals.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "io/files/output_file.hpp"
#include "verification/support/ball_study.hpp"

using namespace freeplay;

namespace {

/// The bouncing ball rises by e² times its drop of 0.5 m.
struct Points : test::BallStudy {
  Points()
      : BallStudy(
            "values = [0.5, 0.8]\n[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n[derived]\n"
            "rise = "
            "\"highest - 0.05\"",
            "claims = \"points\"\npoints = \"points.csv\"\nformulations = [\"nonsmooth\"]\n") {}
  test::Outcome validate(const std::string& points) const {
    write_file(folder.path() / "points.csv", points);
    return run({"validate", study.string(), "-o", out.string()});
  }
};

}  // namespace

TEST_CASE("a study is compared with measured points", "[studies]") {
  const Points study;
  const auto good =
      study.validate("quantity,e,value,uncertainty\nrise,0.5,0.1251,0.001\nrise,0.8,0.3195,0.001\n");
  CAPTURE(good.out, good.err);
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Catch::Contains("agrees: rise: 0 of 2 points outside"));
  auto document = nlohmann::json::parse(test::file_text(study.out / "points.json"));
  const auto& one = document["agreement"][0];
  CHECK(one["verdict"] == "agrees");
  CHECK(one["rms"].get<double>() == Approx(std::sqrt((1e-8 + 25e-8) / 2)).epsilon(1e-3));
  CHECK(one["greatest"].get<double>() == Approx(0.0005).epsilon(1e-3));
  CHECK_THAT(test::file_text(study.out / "points.csv"),
             Catch::Contains("rise,given,nonsmooth,0.5,0.1251,0.001,0.12"));

  const auto off =
      study.validate("quantity,e,value,uncertainty\nrise,0.5,0.1269,0.001\nrise,0.8,0.3221,0.001\n");
  CHECK(off.status == 0);  // a result, as any other
  CHECK_THAT(off.out, Catch::Contains("differs: rise: 1 of 2 points outside"));
  const auto open = study.validate("quantity,e,value\nrise,0.5,0.13\n");
  CHECK_THAT(open.out, Catch::Contains("is undecided: rise: greatest error"));
}

TEST_CASE("wrong files of measured points are refused with their line", "[studies]") {
  const Points study;
  const std::pair<const char*, const char*> wrong[] = {
      {"", "has no header"},
      {"quantity,value\nrise,1\n", "line 1: the column e is missing"},
      {"quantity,e,value\n", "has no values"},
      {"quantity,e,value\nfall,0.5,1\n", "line 2: the study has no measure or derived column \"fall\""},
      {"quantity,e,value\nrise,0.6,1\n", "line 2: the study makes no run at these values"},
      {"quantity,e,value\n\nrise,0.5,x\n", "line 3: value must be a number"},
      {"quantity,e,value\nrise,0.5,inf\n", "line 2: value must be a number"},
      {"quantity,e,value,uncertainty\nrise,0,5,0.1,0.2\n", "line 2: has 5 fields, the header has 4"},
      {"quantity,e,value,uncertainty\nrise,0.5,0.1,-1\n", "line 2: uncertainty must be"}};
  for (const auto& [text, message] : wrong) {
    const auto o = study.validate(text);
    CAPTURE(text, o.out, o.err);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Catch::Contains(message));
    CHECK_FALSE(std::filesystem::exists(study.out / "points.json"));
  }
}
