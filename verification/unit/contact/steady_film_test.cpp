// Steady running of a lubricated joint: limits of the load, and `freeplay laws --film`. Closed
// forms of the coefficients are in verification/claims/film_coefficients.cpp.
#include "formulations/contact/steady_film.hpp"

#include "verification/references/journal_bearing.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::string pin_scene() { return (test::source_folder() / "cases/lubricated-pin/scene.toml").string(); }

/// The gudgeon pin of the case.
constexpr reference::JournalBearing pin{true, true, 0.2, 11.125e-3, 20e-3, 0.25e-3};

}  // namespace

TEST_CASE("a film carries loads up to that at its hand-over thickness", "[film]") {
  const Film film{Film::Kind::short_bearing, true, pin.viscosity, pin.length, pin.radius, pin.clearance,
                  0.01 * pin.clearance};
  const double omega = 20, most = pin.capacity(0.99, omega);
  // Rounding, times d ln ε/d ln W < 1.
  CHECK(steady_ratio(film, most * (1 - 1e-9), omega).value() == Approx(0.99).epsilon(1e-8));
  CHECK_FALSE(steady_ratio(film, most * (1 + 1e-9), omega));
  // Near the centre W = π μωRL³ε/(4c²); the next order is ε².
  const double unit =
      pin.viscosity * omega * pin.radius * std::pow(pin.length, 3) / std::pow(pin.clearance, 2);
  CHECK(steady_ratio(film, 3.141592653589793 / 4 * unit * 1e-5, omega).value() == Approx(1e-5).epsilon(1e-8));
}

TEST_CASE("freeplay laws --film reports the steady running of a lubricated joint", "[program][film]") {
  const test::TemporaryFolder folder;
  const auto out = (folder.path() / "film").string();
  const double omega = 1500 * 3.141592653589793 / 30, e = 0.6, load = pin.capacity(e, omega);
  const auto found = test::succeeded("laws " + pin_scene() + " --film gudgeon --rpm 1500 --load " +
                                     fmt::format("{}", load) + " -o " + out);
  CHECK_THAT(found.out, Contains("eccentricity ratio        0.6\n"));
  const auto j = test::read_json(folder.path() / "film/film.json");
  CHECK(j["eccentricity_ratio"].get<double>() == Approx(e).epsilon(1e-12));
  CHECK(j["attitude_angle_rad"].get<double>() == Approx(pin.attitude(e, omega)).epsilon(1e-12));
  CHECK(j["stiffness_N_per_m"][0][1].get<double>() > 0);
  CHECK(j["stiffness_N_per_m"][1][0].get<double>() < 0);

  // 2000 N at 1500 rpm in other units.
  const auto in_units = [](const std::string& load_and_speed) {
    const auto text = test::succeeded("laws " + pin_scene() + " --film gudgeon " + load_and_speed);
    return text.out;
  };
  const auto plain = in_units("--load 2000 --rpm 1500");
  CHECK(in_units("--load '2 kN' --rpm '1500 rpm'") == plain);
  CHECK_THAT(plain, Contains("eccentricity ratio"));

  test::succeeded("laws " + pin_scene() + " --film gudgeon -o " + out);
  std::ifstream csv(folder.path() / "film/film.csv");
  std::string line;
  int lines = 0;
  while (std::getline(csv, line)) ++lines;
  CHECK(lines == 100);  // header, ε = 0.01 … 0.99
}

TEST_CASE("freeplay laws --film refuses joints without film and loads beyond its capacity",
          "[program][film]") {
  const auto refused = [](const std::string& options) {
    const auto found = test::freeplay("laws " + pin_scene() + options);
    CHECK(found.status == 2);
    return found.err;
  };
  CHECK_THAT(refused(" --film main"), Contains("no lubricated joint") && Contains("use one of: gudgeon"));
  CHECK_THAT(refused(" --film gudgeon --load 1"), Contains("--load and --rpm must be given together"));
  CHECK_THAT(refused(" --film gudgeon --load 1 --rpm 0"), Contains("must be greater than 0"));
  CHECK_THAT(refused(" --film gudgeon --load 1e9 --rpm 100"), Contains("the film carries at most"));
  CHECK_THAT(refused(" --film gudgeon --load '800 kg' --rpm 100"),
             Contains("--load") && Contains("is a mass, must be a force"));
  CHECK_THAT(refused(" --load 1 --rpm 100"), Contains("--film"));
}

TEST_CASE("run.json has the statistics of each film", "[program][film]") {
  const test::TemporaryFolder folder;
  const auto out = (folder.path() / "run").string();
  test::succeeded("run " + pin_scene() +
                  " --formulation nonsmooth --set run.revolutions=0.5 --set run.discard=0.1 -o " + out);
  const auto film = test::read_json(folder.path() / "run/run.json")["contacts"]["gudgeon"]["film"];
  const double greatest = film["greatest_eccentricity_ratio"], least = film["least_thickness_m"];
  CHECK(greatest > film["mean_eccentricity_ratio"].get<double>());
  // Both are of the same instant: h = c(1 − ε).
  CHECK(least == Approx(pin.clearance * (1 - greatest)).epsilon(1e-12));
  CHECK(film["least_thickness_at_s"].get<double>() > 0.1 * 0.3);
  CHECK(film["sommerfeld_number"].get<double>() ==
        Approx(pin.viscosity * film["mean_speed_rad_per_s"].get<double>() / (2 * 3.141592653589793) *
               pin.length * 2 * pin.radius / film["mean_load_N"].get<double>() *
               std::pow(pin.radius / pin.clearance, 2))
            .epsilon(1e-12));
}
