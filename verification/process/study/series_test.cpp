// freeplay calibrate of a study of time series: fitted and predicted series apart, result files and figures.
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "verification/references/backlash_slider.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

TEST_CASE("calibrate reports fitted and predicted series apart", "[calibrate]") {
  const test::StudyDesk desk("friction-damper");
  constexpr reference::BacklashSlider damper{4.5e-3, 5.8e6, 9.7e3};
  std::string study = "scene = \"scene.toml\"\nrestitution = \"as-given\"\nformulations = [\"nonsmooth\"]\n" +
                      test::unknown("play", "loads.link.upper", 1e-3, 1e-2, "unit = \"m\"\n");
  for (const auto& [name, amplitude] : {std::pair("large", 25e-3), {"small", 12e-3}}) {
    std::vector<double> x;
    for (int i = 0; i <= 768; ++i) x.push_back(amplitude * std::sin(std::numbers::pi * i / 256));
    const auto forces = damper.forces(x, -5e-4);
    std::string text = "t,force,displacement\n";
    for (std::size_t i = 0; i < x.size(); ++i)
      text += fmt::format("{},{},{}\n", static_cast<double>(i) / 256, forces[i], x[i]);
    desk.put(fmt::format("{}.csv", name), text);
    study += test::target(
        name, "series",
        fmt::format(
            "set = [\"run.duration=3\", \"loads.link.stiffness=5.8e6\", \"loads.band.force=9700\", "
            "\"curves.stroke.amplitude={}\"]\nchannel = \"actuator.fx_mean\"\ndata = \"{}.csv\"\nfrom = "
            "1\nagainst = \"displacement\"\nunit = \"m\"\nlevels = [5000]\n{}",
            amplitude, name, amplitude < 20e-3 ? "hold_out = true\n" : ""));
  }
  desk.put("study.toml", study);
  const auto o = desk.run("calibrate");
  CAPTURE(o.out, o.err);
  REQUIRE(o.status == 0);
  const auto fitted = o.out.find("\nFitted\n"), predicted = o.out.find("\nPredicted\n");
  REQUIRE(fitted != std::string::npos);
  REQUIRE(predicted != std::string::npos);
  CHECK(o.out.substr(fitted, predicted - fitted).find("small") == std::string::npos);
  CHECK(o.out.substr(predicted, o.out.find("rms, mean:") - predicted).find("large") == std::string::npos);
  const auto document = nlohmann::json::parse(test::file_text(desk.at("out/calibration.json")));
  const auto& fit = document.at("fitted_to_all");
  CHECK(fit.at("fitted").size() == 1);
  CHECK(fit.at("fitted").contains("large"));
  CHECK(fit.at("predicted").size() == 1);
  CHECK(fit.at("predicted").at("small").at("nonsmooth").at("flanks").at("unpaired") == 0);
  // The reasons of the bound are those of the unit test of the same loop; the damping of 2 kN s/m adds 160 N
  // at 0.08 m/s, 0.03 mm of the flank.
  CHECK(fit.at("unknowns").at("play").at("value").get<double>() == Approx(damper.play).epsilon(0.02));
  const auto rows = test::read_csv(desk.at("out/series.csv"));
  CHECK(rows.size() == 1 + 2 * 513);  // from 1 s to 3 s at 256 Hz
  for (const char* figure : {"out/figures/series_large.pdf", "out/figures/series_small.pdf"})
    CHECK(std::filesystem::exists(desk.at(figure)));
}
