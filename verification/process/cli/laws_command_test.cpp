// The command laws (contact laws, friction laws, films), and the commands drift and verify.
#include "formulations/contact/contact_law.hpp"
#include "mechanism/laws.hpp"
#include "verification/references/journal_bearing.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// The lubricated gudgeon pin of a case.
std::string pin_scene() { return (test::source_folder() / "cases/lubricated-pin/scene.toml").string(); }
constexpr reference::JournalBearing pin{true, true, 0.2, 11.125e-3, 20e-3, 0.25e-3};
constexpr double pi = std::numbers::pi;

/// The message with which check refuses a scene with these options.
std::string refused_check(const std::string& sets) {
  const auto o = test::freeplay("check " + test::flores().string() + sets);
  return o.out + o.err;
}

}  // namespace

TEST_CASE("the program lists laws and refuses meaningless combinations", "[laws]") {
  const auto list = test::succeeded("laws").out;
  for (const auto& law : contact_laws()) CHECK_THAT(list, Contains(std::string(law.text)));
  for (const auto& law : friction_laws()) CHECK_THAT(list, Contains(std::string(law.text)));
  CHECK_THAT(test::succeeded("laws --restitution 0.46").out, Contains("0.71499"));
  for (const char* invalid : {"--restitution 2", "--friction --regularisation 0", "--regularisation 1e-3"})
    CHECK(test::freeplay(std::string("laws ") + invalid).status == 2);
  test::check_messages(refused_check,
                       {{" --set penalty.contact=johnson", "joints.gudgeon.bearing_length: is missing"},
                        {" --set penalty.contact=kelvin-voigt", "penalty.kelvin_stiffness: is missing"},
                        {" --set penalty.damping=exact", "it belongs to line contacts"}});
}

TEST_CASE("laws --friction prints all laws at one speed within 80 columns", "[laws]") {
  const auto said = test::succeeded("laws --friction --regularisation 2e-3").out;
  for (const auto& law : friction_laws()) CHECK_THAT(said, Contains("\n" + std::string(law.text) + " "));
  CHECK_THAT(said, Contains("friction_v1 = 0.002105"));
  for (const auto& line : test::lines_of(said))
    CHECK(std::ranges::count_if(line, [](char c) { return (c & 0xC0) != 0x80; }) <= 80);
}

TEST_CASE("the commands laws, drift and verify from the command line") {
  const test::TemporaryFolder folder;
  const auto out = " -o " + folder.path().string();
  const auto scene = test::flores().string();
  const auto said = test::succeeded("laws " + scene + " --mass 2 --speed 0.3" + out + "/laws").out;
  CHECK_THAT(said, Contains("Which law: docs/how-to/contact-law.md"));
  // Hertz's undamped impact: F = K δ^1.5 at δ = (5 m v²/(4K))^(2/5), duration 2.9432 δ/v.
  const auto facts = test::first_contact(read_scene(test::flores()));
  const double K = hertz_stiffness(*facts.surface.young, *facts.surface.poisson, facts.radius),
               depth = std::pow(1.25 * 2 * 0.09 / K, 0.4);
  std::istringstream row(said.substr(said.find("\nhertz ") + 7));
  double force = 0, most = 0, duration = 0, e = 0;
  row >> force >> most >> duration >> e;
  // printed with four digits
  CHECK(force == Approx(K * std::pow(depth, 1.5)).epsilon(1e-3));
  CHECK(most == Approx(depth).epsilon(1e-3));
  CHECK(duration == Approx(2.9432 * depth / 0.3).epsilon(1e-3));
  CHECK(e == 1);
  CHECK(std::filesystem::file_size(folder.path() / "laws/laws.json") > 100);
  CHECK_THAT(
      test::succeeded("drift " + scene + " --set run.revolutions=0.1 --set run.discard=0" + out + "/drift")
          .out,
      Contains("baumgarte") && Contains("projection"));
  test::succeeded("figures " + (folder.path() / "drift").string());
  CHECK_THAT(test::succeeded("verify impact-laws --document " + folder.path().string()).out,
             Contains("claims hold"));
  CHECK(std::filesystem::file_size(folder.path() / "verification.md") > 100);
  CHECK(test::freeplay("verify nonsense").status == 2);
}

TEST_CASE("laws shows each kind of contact once, and names a scene without contacts", "[laws]") {
  const test::TemporaryFolder folder;
  const auto said = [&](const std::string& scene, const std::string& more = "") {
    return test::succeeded("laws " + (test::source_folder() / scene).string() + more + " -o " +
                           (folder.path() / "laws").string())
        .out;
  };
  const auto press = said("src/cli/templates/press.toml");
  CHECK_THAT(press, Contains("in contact small_end,") && Contains("in contact die,") &&
                        !Contains("\nkelvin-voigt "));
  CHECK_THAT(press, Contains("impact_loops_small_end.pdf") && Contains("impact_loops_die.pdf"));
  const auto facts = test::read_json(folder.path() / "laws/laws.json");
  REQUIRE(facts["contacts"].size() == 2);
  CHECK(facts["contacts"][1]["names"] == nlohmann::json{"die"});
  // The lands of the wheel have equal facts.
  const auto wheel = said("cases/geneva-wheel/scene.toml");
  CHECK_THAT(wheel, Contains("in contacts land_1, land_2, land_3, land_4,") && Contains("impact_loops.pdf"));
  CHECK(test::count(wheel, "Free impact") == 1);
  CHECK_THAT(said("cases/geneva-wheel/scene.toml",
                  " --set penalty.contact=kelvin-voigt --set penalty.kelvin_stiffness=1e7 --set "
                  "penalty.kelvin_damping=3"),
             Contains("\nkelvin-voigt "));
  const auto none = (test::source_folder() / "cases/seven-body/scene.toml").string();
  test::refused("laws " + none, Contains(none + ": has no contact"));
}

TEST_CASE("check and run refuse a scene that neither formulation takes with the same status",
          "[laws][errors]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "s.toml";
  // Neither a stiffness nor a restitution: for penalty and nonsmooth.
  write_file(
      file,
      test::body("ball", 1, 0.1, "position = [0.0, 1.0]\n") +
          "[surfaces.plain]\nfriction = 0.1\n[contacts.floor]\ntype = \"plane\"\nbetween = [\"ground\", "
          "\"ball\"]\naxis = [1.0, 0.0]\nradius = 0.1\nsurface = \"plain\"\n" +
          test::run_for(1));
  const auto checked = test::freeplay("check " + file.string());
  CHECK(checked.status == 2);
  CHECK(test::count(checked.out, "not available") == 2);
  for (const char* formulation : {"penalty", "nonsmooth"})
    CHECK(test::freeplay(fmt::format("run {} --formulation {} -o {}/out", file.string(), formulation,
                                     folder.path().string()))
              .status == 2);
}

TEST_CASE("laws --film reports the steady running of a lubricated joint", "[film]") {
  const test::TemporaryFolder folder;
  const auto out = " -o " + (folder.path() / "film").string();
  const auto film = [](const std::string& options) {
    return test::succeeded("laws " + pin_scene() + " --film gudgeon" + options).out;
  };
  const double omega = 1500 * pi / 30, e = 0.6;
  CHECK_THAT(film(fmt::format(" --rpm 1500 --load {}", pin.capacity(e, omega)) + out),
             Contains("eccentricity ratio        0.6\n"));
  const auto j = test::read_json(folder.path() / "film/film.json");
  CHECK(j["eccentricity_ratio"].get<double>() == Approx(e).epsilon(1e-12));
  CHECK(j["attitude_angle_rad"].get<double>() == Approx(pin.attitude(e, omega)).epsilon(1e-12));
  CHECK(j["stiffness_N_per_m"][0][1].get<double>() > 0);
  CHECK(j["stiffness_N_per_m"][1][0].get<double>() < 0);
  // 2000 N at 1500 rpm in other units.
  const auto plain = film(" --load 2000 --rpm 1500");
  CHECK(film(" --load '2 kN' --rpm '1500 rpm'") == plain);
  CHECK_THAT(plain, Contains("eccentricity ratio"));
  film(out);
  CHECK(test::lines_of(test::file_text(folder.path() / "film/film.csv")).size() ==
        100);  // header, ε = 0.01 … 0.99
}

TEST_CASE("laws --film refuses joints without film and loads beyond its capacity", "[film]") {
  test::check_messages(
      [](const std::string& options) {
        const auto found = test::freeplay("laws " + pin_scene() + options);
        CHECK(found.status == 2);
        return found.err;
      },
      {{" --film main", "no lubricated joint"},
       {" --film main", "use one of: gudgeon"},
       {" --film gudgeon --load 1", "--load and --rpm must be given together"},
       {" --film gudgeon --load 1 --rpm 0", "must be greater than 0"},
       {" --film gudgeon --load 1e9 --rpm 100", "the film carries at most"},
       {" --film gudgeon --load '800 kg' --rpm 100", "--load"},
       {" --film gudgeon --load '800 kg' --rpm 100", "is a mass, must be a force"},
       {" --load 1 --rpm 100", "--film"}});
}

TEST_CASE("check, laws and run note a film outside its range of L/D", "[film]") {
  const test::TemporaryFolder folder;
  const auto text = test::file_text(test::source_folder() / "cases/finite-bearing/scene.toml");  // L/D = 1
  for (const std::string film : {"short", "long", "finite"}) {
    CAPTURE(film);
    const auto scene = (folder.path() / (film + ".toml")).string(), out = (folder.path() / film).string();
    write_file(scene, test::replaced(text, "film = \"finite\"", "film = \"" + film + "\""));
    const auto run =
        test::succeeded("run " + scene + " --set run.duration=1e-3 --formulation nonsmooth -o " + out).out;
    for (const auto& report :
         {run, test::read_json(folder.path() / film / "run.json")["notes"].dump(),
          test::succeeded("check " + scene).out, test::succeeded("laws " + scene + " --film bearing").out})
      CHECK((report.find("film at L/D = 1 overestimates") != std::string::npos) == (film != "finite"));
  }
}

TEST_CASE("run.json has the statistics of each film", "[film]") {
  const test::TemporaryFolder folder;
  test::succeeded("run " + pin_scene() +
                  " --formulation nonsmooth --set run.revolutions=0.5 --set run.discard=0.1 -o " +
                  (folder.path() / "run").string());
  const auto film = test::read_json(folder.path() / "run/run.json")["contacts"]["gudgeon"]["film"];
  const auto value = [&](const char* name) { return film[name].get<double>(); };
  CHECK(value("greatest_eccentricity_ratio") > value("mean_eccentricity_ratio"));
  // Both are of the same instant: h = c(1 − ε).
  CHECK(value("least_thickness_m") ==
        Approx(pin.clearance * (1 - value("greatest_eccentricity_ratio"))).epsilon(1e-12));
  CHECK(value("least_thickness_at_s") > 0.1 * 0.3);
  CHECK(value("sommerfeld_number") ==
        Approx(pin.viscosity * value("mean_speed_rad_per_s") / (2 * pi) * pin.length * 2 * pin.radius /
               value("mean_load_N") * std::pow(pin.radius / pin.clearance, 2))
            .epsilon(1e-12));
}
