// Lyapunov exponents of attractors over a parameter and over starts, stored and refused, and those of
// penalty runs. Their values are claims of "lyapunov".
#include "study/attractors/attractor_exponents.hpp"
#include "analysis/lyapunov.hpp"
#include "analysis/orbit.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;

namespace {

/// The vertical motion of cases/ball-on-table, event-driven; strengths A ω²/g.
std::string shaken(const std::string& strengths, const std::string& more) {
  return fmt::format(
      "scene = \"{}\"\n[axes.strength]\nkey = \"curves.shake.amplitude\"\nvalues = [{}]\n[bifurcation]\n"
      "direction = \"up\"\nsection = \"each touch\"\ncolumns = [\"phase\", \"approach\"]\ndiscard = 150\n"
      "keep = 30\nset = ['joints.rail.type=\"translational\"', "
      "'joints.rail.between=[\"ground\", \"ball\"]', 'joints.rail.axis=[0, 1]', "
      "'nonsmooth.scheme=\"event-driven\"']\n{}",
      (test::source_folder() / "cases/ball-on-table/scene.toml").string(), strengths, more);
}

struct WithExponents {
  SettledRuns runs;
  Classified classified;
  std::string csv;
};

WithExponents run_study(const Study& study, const std::filesystem::path& file) {
  AttractorStore store(file, {});
  WithExponents all;
  const auto chains = bifurcation_chains(study);
  all.runs = settle(study, *study.bifurcation, "bifurcation", chains, store, 2, {}, {});
  all.classified = attractors_at_each_value(all.runs);
  if (study.bifurcation->exponents)
    add_exponents(study, *study.bifurcation, chains, all.classified, store, 2, {}, {}, all.runs);
  all.csv = bifurcation_csv(study, all.runs, all.classified);
  return all;
}

Scene oscillator(const std::vector<std::string>& set) {
  return read_scene(test::source_folder() / "cases/impact-oscillator/scene.toml", set);
}

}  // namespace

TEST_CASE("exponents of a study are stored, and a study without them has the same results",
          "[attractors][lyapunov]") {
  const test::StudyDesk desk;
  const auto file = desk.at("a.db");
  const auto plain = run_study(desk.read(shaken("0.6e-3", "")), file);
  CHECK(plain.csv.starts_with("branch,value,attractor,period,t,phase,approach\n"));
  const auto has_table = [&] {
    const auto schema = Database(file, Database::Access::read).schema();
    return std::ranges::find(schema, "exponents", &SchemaObject::name) != schema.end();
  };
  CHECK_FALSE(has_table());
  // The runs are those of the study without exponents.
  const auto study = desk.read(shaken("0.6e-3", "exponents = true\n"));
  const auto with = run_study(study, file);
  CHECK(with.runs.made == 0);
  CHECK(has_table());
  CHECK(with.csv.starts_with("branch,value,attractor,period,t,phase,approach,exponent,exponent_error\n"));
  AttractorStore store(file, {});
  const auto& key = with.runs.chains[0][0].key;
  REQUIRE(store.find_exponent(key, 30));
  CHECK_FALSE(store.find_exponent(key, 31));
  store.store_exponent(key, 31, {-INFINITY, NAN, "why"});
  const auto again = store.find_exponent(key, 31);
  REQUIRE(again);
  CHECK(again->value == -INFINITY);
  CHECK(std::isnan(again->error));
  CHECK(again->reason == "why");
  CHECK(run_study(study, file).csv == with.csv);
}

TEST_CASE("a rotor at rest on a stop has the exponent minus infinity", "[attractors][lyapunov]") {
  const test::StudyDesk desk;
  const auto study = desk.read(
      fmt::format("scene = \"{}\"\n[axes.angle]\nkey = \"bodies.rotor.angle\"\nvalues = [-0.5, 0.5]\n"
                  "[axes.speed]\nkey = \"bodies.rotor.angular_velocity\"\nvalues = [0]\n"
                  "[basin]\nsection = \"every 0.5 s\"\nperiod = 0.5\ndiscard = 8\nkeep = 4\n"
                  "columns = [\"axle.angle\"]\nexponents = true\n",
                  (test::source_folder() / "cases/bistable-rotor/scene.toml").string()));
  AttractorStore store(desk.at("a.db"), {});
  const auto chains = basin_chains(study);
  auto runs = settle(study, *study.basin, "basin", chains, store, 2, {}, {});
  const auto classified = attractors_of_all(runs);
  add_exponents(study, *study.basin, chains, classified, store, 2, {}, {}, runs);
  for (const auto& chain : runs.chains) {
    REQUIRE(chain[0].exponent);
    CHECK(chain[0].exponent->value == -INFINITY);
  }
  CHECK_THAT(basin_text(study, runs, classified), Catch::Contains("period 1, exponent -inf"));
}

TEST_CASE("exponents of time stepping are refused in the study", "[attractors][lyapunov]") {
  const test::StudyDesk desk;
  const auto text = shaken("0.6e-3", "exponents = true\n");
  const auto stepped = test::replaced(text, "\"event-driven\"", "\"moreau-jean\"");
  CHECK_THAT(test::refusal_of([&] { run_study(desk.read(stepped), desk.at("a.db")); }),
             Catch::Contains("study.toml") && Catch::Contains("bifurcation.exponents: nonsmooth.scheme"));
  CHECK_THAT(test::refusal_of([&] { desk.read(shaken("0.6e-3", "exponent_periods = 9\n")); }),
             Catch::Contains("needs exponents = true"));
}

TEST_CASE("exponents of penalty and nonsmooth motions have the sum of the divergence", "[lyapunov]") {
  // Neither Hertz's force nor an elastic impact dissipates: the divergence is −c/m of the damper.
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    const auto found =
        lyapunov(oscillator({"run.duration=30", "curves.shake.frequency=2.5", "surfaces.end.young=1e7"}),
                 {.formulation = formulation, .batches = 8});
    REQUIRE(found.failure.empty());
    REQUIRE(found.exponents.size() == 2);
    CHECK(found.impacts > 5);
    CHECK(found.sum == Approx(-0.2 * std::numbers::pi).epsilon(1e-7));
  }
}

TEST_CASE("the exponent of a penalty orbit is the logarithm of its multiplier", "[lyapunov][orbit]") {
  const auto scene = oscillator({"curves.shake.frequency=1", "run.duration=90"});
  const auto motion = orbit(scene, {.formulation = "penalty", .settle = 30.3});
  REQUIRE(motion.failure.empty());
  REQUIRE(motion.multipliers.size() == 2);
  const double expected = std::log(std::abs(motion.multipliers[0]));  // of a period of 1 s
  REQUIRE(motion.stable);
  // Only the greatest one, from the state of the orbit. The vector aligns within 20 s by a factor of e^-7, of
  // which the mean over 20 s keeps a twentieth.
  const auto found = lyapunov(
      scene,
      {.formulation = "penalty", .batches = 8, .transient = 70, .exponents = 1, .start = motion.state});
  REQUIRE(found.failure.empty());
  REQUIRE(found.exponents.size() == 1);
  CHECK(found.exponents[0].value == Approx(expected).margin(1e-4));
}
