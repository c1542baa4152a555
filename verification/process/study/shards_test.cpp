// Divided studies: any number of shards, in any order, with interruptions, gives the result of one
// process; and refusals.
#include "analysis/lyapunov.hpp"
#include "study/partition/divided.hpp"
#include "study/partition/division.hpp"
#include "study/partition/merge.hpp"
#include "study/partition/shard.hpp"
#include "study/sweep/sweep.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Place : test::BallStudy {
  Study read = read_study(study);
  Place()
      : BallStudy(
            "range = [0.2, 0.8, 11]\n[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n[derived]\n"
            "rise = \"highest - 0.05\"") {}
  Division division() const { return divided_sweep(read, {}, "sweep", {"study.toml"}, subject_of(read)); }
  std::filesystem::path at(const std::string& name) const { return folder.path() / name; }
  ShardMade make(const std::string& into, std::size_t k, StopToken stop = {}) const {
    return make_shard(division(), at(into),
                      {.shard = k, .scratch = at("scratch"), .threads = 1, .stop = stop});
  }
};

/// All machine-independent rows, sorted by their text.
std::vector<std::string> dump(const std::filesystem::path& file) {
  const Database database(file, Database::Access::read);
  std::vector<std::string> rows;
  for (const std::string table :
       {"named", "turns", "flights", "impacts", "measures", "spectra", "traces", "work", "derived"}) {
    Database::Statement s(database, "SELECT * FROM " + table);
    while (s.step()) {
      rows.push_back(table);
      for (int c = 0; c < s.columns(); ++c)  // a number bit for bit, a text or blob byte for byte
        rows.back() += s.is_text(c) ? "|" + s.text(c) : fmt::format("|{:a} {}", s.number(c), s.text(c));
    }
  }
  std::ranges::sort(rows);
  return rows;
}

std::vector<std::string> made_by_one(const Place& place) {
  make_folder(place.at("one"));
  {
    const FolderLock lock(place.at("one"), "sweep", FolderLock::Use::together);
    Results results(place.at("one") / "sweep.db", place.read);
    sweep(place.read, plan(place.read, {}), {}, results, lock, 1, {});
    results.derive(place.read);
  }
  return dump(place.at("one") / "sweep.db");
}

}  // namespace

TEST_CASE("shards of any number, in any order, merge to the result of one process", "[shards]") {
  const Place place;
  const auto expected = made_by_one(place);
  REQUIRE(expected.size() > 22);
  const std::size_t shards = GENERATE(1, 2, 5, 22);
  make_plan(place.division(), place.at("out"), shards);
  for (std::size_t k = shards; k >= 1; --k) CHECK_FALSE(place.make("out", k).found);
  CHECK(place.make("out", 1).found);
  const auto merged = merge_shards(place.division(), place.at("out"), place.at("scratch"));
  CHECK(merged.units == 22);
  CHECK(dump(place.at("out") / "sweep.db") == expected);
  CHECK(merge_shards(place.division(), place.at("out"), place.at("scratch")).found);
  CHECK(std::filesystem::is_empty(place.at("scratch")));
}

TEST_CASE("a stopped shard resumes from its copy on the shared folder", "[shards]") {
  const Place place;
  const auto expected = made_by_one(place);
  make_plan(place.division(), place.at("out"), 2);
  std::atomic<bool> stop{false};
  std::size_t first = 0;
  const auto division = place.division();
  const auto make = [&](const auto& on_progress) {
    return make_shard(division, place.at("out"),
                      {.shard = 1,
                       .scratch = place.at("scratch"),
                       .threads = 1,
                       .stop = StopToken(stop),
                       .on_progress = on_progress});
  };
  REQUIRE(make([&](std::size_t done, std::size_t) { stop = stop || done >= 3; }).interrupted);
  CHECK(state_of(place.at("out"), 1).state == "stopped");
  CHECK(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  stop = false;
  make([&](std::size_t done, std::size_t) { first = first == 0 ? done : first; });
  CHECK(first > 3);  // existing runs are counted, and not repeated
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "shards/1.part.db"));
  place.make("out", 2);
  merge_shards(division, place.at("out"), place.at("scratch"));
  CHECK(dump(place.at("out") / "sweep.db") == expected);
}

TEST_CASE("missing and damaged shards are refused with the command that makes them", "[shards][errors]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 4);
  for (std::size_t k : {1, 2, 4}) place.make("out", k);
  const auto refusal = [&] {
    return test::refusal_of<SceneError>(
        [&] { merge_shards(place.division(), place.at("out"), place.at("scratch")); });
  };
  CHECK_THAT(refusal(), Contains("1 of 4 shards") && Contains("--shard 3/4 -o ") && Contains("missing"));
  CHECK_FALSE(std::filesystem::exists(place.at("out") / "sweep.db"));
  place.make("out", 3);
  const auto file = place.at("out") / "shards" / read_seal(place.at("out"), 2)->file;
  std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
  CHECK_THAT(refusal(), Contains("--shard 2/4") && Contains("incomplete"));
  CHECK_FALSE(place.make("out", 2).found);
  {  // one byte changed
    std::fstream damaged(place.at("out") / "shards" / read_seal(place.at("out"), 4)->file,
                         std::ios::in | std::ios::out);
    damaged.seekp(5000);
    damaged.put('\x7f');
  }
  CHECK_THAT(refusal(), Contains("--shard 4/4") && Contains("damaged"));
  place.make("out", 4);
  CHECK(refusal() == "accepted");
}

TEST_CASE("a study that changed after planning is refused", "[shards][errors]") {
  Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  test::put_ball_study(place.folder.path(), "range = [0.2, 0.7, 11]");
  place.read = read_study(place.study);
  CHECK_THROWS_WITH(place.make("out", 2), Contains("has changed since it was planned"));
  CHECK_THROWS_WITH(make_plan(place.division(), place.at("out"), 2), Contains("another plan"));
  CHECK_THROWS_WITH(merge_shards(place.division(), place.at("out"), place.at("scratch")),
                    Contains("changed"));
}

TEST_CASE("shards of another program are refused", "[shards][errors]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 1);
  auto m = read_manifest(place.at("out"));
  m.program += "instructions = \"another\"\n";
  CHECK_THROWS_WITH(require_same(m, place.division(), place.at("out")), Contains("another program"));
}

// Converting counts that are not integers is undefined in the language.
TEST_CASE("files beside shards with values of a wrong type are refused in the program's own words",
          "[shards][errors][security]") {
  const Place place;
  make_plan(place.division(), place.at("out"), 2);
  place.make("out", 1);
  const auto shards = place.at("out") / "shards";
  const auto manifest = test::read_json(shards / "manifest.json"), seal = test::read_json(shards / "1.json");
  const auto missing = [](nlohmann::json j, const char* key) {
    j.erase(key);
    return j;
  };
  const auto with = [](nlohmann::json j, const char* key, const nlohmann::json& value) {
    j[key] = value;
    return j;
  };
  for (const auto& wrong :
       {missing(manifest, "units"), missing(manifest, "format"), with(manifest, "shards", "2"),
        with(manifest, "units", 11.5), with(manifest, "units", 1e300), with(manifest, "shards", -1),
        with(manifest, "arguments", {1}), with(manifest, "verb", nullptr), nlohmann::json::array()}) {
    write_file(shards / "manifest.json", wrong.dump());
    CAPTURE(wrong.dump());
    CHECK_THROWS_WITH(read_manifest(place.at("out")),
                      Contains("manifest.json: is not a manifest of this version (") && !Contains("json."));
  }
  write_file(shards / "manifest.json", manifest.dump());
  const auto whole = read_manifest(place.at("out"));
  REQUIRE(fault_of(*read_seal(place.at("out"), 1), whole, place.at("out"), true).empty());
  for (const auto& wrong : {missing(seal, "file"), with(seal, "bytes", -1), with(seal, "units", 1e300),
                            with(seal, "failed", 0.5), with(seal, "reasons", {1}), with(seal, "host", 7)}) {
    write_file(shards / "1.json", wrong.dump());
    CAPTURE(wrong.dump());
    CHECK(fault_of(*read_seal(place.at("out"), 1), whole, place.at("out"), true) == "its seal is damaged");
  }
  write_file(shards / "2.state.json", R"({"state": "running", "done": 1e300, "total": -5})");
  const auto state = state_of(place.at("out"), 2);
  CHECK(state.state.empty());
  CHECK(state.done == 0);
  CHECK(state.total == 0);
}

TEST_CASE("the five commands of docs/how-to/cluster.md work as described", "[shards][docs]") {
  const Place place;
  std::ifstream page(test::source_folder() / "docs/how-to/cluster.md");
  std::string line;
  while (std::getline(page, line) && line != "```sh") {
  }
  std::vector<std::string> commands;
  while (std::getline(page, line) && line != "```") {
    REQUIRE(line.starts_with("freeplay "));
    commands.push_back(line.substr(9, line.find('#') - 9));
    if (const auto at = line.find("1/4"); at != line.npos)
      for (const char* k : {"2", "3", "4"})
        commands.push_back(commands[1].substr(0, at - 9) + k + commands[1].substr(at - 8));
  }
  REQUIRE(commands.size() == 8);
  for (const auto& command : commands) {
    INFO(command);
    CHECK(std::system(fmt::format("cd '{}' && '{}/freeplay' {} >>said 2>&1", place.folder.path().string(),
                                  FREEPLAY_BINARY_DIR, command)
                          .c_str()) == 0);
  }
  CHECK(dump(place.at("out/study/sweep.db")) == made_by_one(place));
}

TEST_CASE("starts of an ensemble are divided like runs, and none is repeated after the merge", "[shards]") {
  const test::TemporaryFolder folder;
  const auto out = folder.path() / "out";
  const auto run = [&](const std::string& options) {
    return test::freeplay(
        fmt::format("ensemble {} --starts 3 --rows 3 --set run.revolutions=0.1 --set run.discard=0.02 {} {}",
                    test::flores().string(), options, out.string()));
  };
  REQUIRE(run("--plan 2 -o").status == 0);
  REQUIRE(run("--shard 2/2 -o").status == 0);
  CHECK(run("--merge").status == 2);
  REQUIRE(run("--shard 1/2 -o").status == 0);
  REQUIRE(run("--merge").status == 0);
  const auto again = run("-o");
  REQUIRE(again.status == 0);
  CHECK_THAT(again.out, Contains("3 starts, 3 finished"));
  for (const char* name : {"statistics.csv", "starts.csv", "bands.csv", "figures/ensemble.pdf"})
    CHECK(std::filesystem::exists(out / name));
  const auto outcome = test::read_json(out / "ensemble.json");
  CHECK(outcome["ensemble"]["finished"] == 3);
  CHECK(outcome["ensemble"]["cpu_seconds"] == 0);  // the time of starts is that of the made ones
  CHECK(test::freeplay("ensemble " + test::flores().string() + " --starts 1").status == 2);
}

// Lyapunov exponents of attractors by the commands, whole and divided into shards: of a basin with two
// periodic attractors against closed forms and single runs, of a bifurcation diagram; and work that cannot be
// divided.

namespace {

/// A torsional oscillator with a stop, of verification/references/orbits.hpp (ImpactOscillator): J,
/// c, k, e and the frequency of the torque. Its steady oscillation and a motion with one impact per
/// period coexist.
constexpr double inertia = 0.5, damping = 1, restitution = 0.7, frequency = 30;
constexpr double period_of_torque = 2 * std::numbers::pi / frequency;

std::string stopped_rotor() {
  return test::body("rotor", 1, inertia) + test::pin("axle", "ground", "rotor") +
         test::torsion("spring", "ground", "rotor", 200, fmt::format("damping = {}\n", damping)) +
         test::stop("stop", "angle-stop", "axle", "radius = 0.1\nupper = 0.02\n", "hard") +
         test::surface("hard", restitution) + test::harmonic("torque", 4, period_of_torque) +
         test::drive("shaker", "axle", "torque_curve = \"torque\"\nagainst = \"time\"\n") +
         test::run_for(104 * period_of_torque, "start = \"given\"\n") +
         "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-10\n";
}

std::string rotor_basin() {
  return "scene = \"scene.toml\"\n" + test::axis("angle", "bodies.rotor.angle", "-0.002, 0") +
         test::axis("speed", "bodies.rotor.angular_velocity", "-0.45, 0.5") +
         "[basin]\nx = \"angle\"\ny = \"speed\"\nsection = \"every period\"\ncolumns = [\"axle.angle\"]\n"
         "discard = 100\nkeep = 12\nexponents = true\n";
}

std::string case_scene(const char* name) {
  return (test::source_folder() / "cases" / name / "scene.toml").string();
}

/// Two strengths of shaking, swept up and down: two units of a division.
std::string ball_study() {
  return fmt::format(
      "scene = \"{}\"\n[axes.strength]\nkey = \"curves.shake.amplitude\"\nvalues = [0.6e-3, 1.065e-3]\n"
      "[bifurcation]\nsection = \"each touch\"\ncolumns = [\"phase\", \"approach\"]\ndiscard = 60\n"
      "keep = 20\n"
      "exponents = true\nset = ['joints.rail.type=\"translational\"', "
      "'joints.rail.between=[\"ground\", \"ball\"]', 'joints.rail.axis=[0, 1]', "
      "'nonsmooth.scheme=\"event-driven\"']\n",
      case_scene("ball-on-table"));
}

}  // namespace

TEST_CASE("exponents of a basin are those of runs from the same starts, also divided",
          "[attractors][lyapunov]") {
  const test::StudyDesk desk;
  desk.put("scene.toml", stopped_rotor());
  desk.put("study.toml", rotor_basin());
  const auto basin = [&](const std::string& options) {
    return test::succeeded(fmt::format("basin {} {}", desk.at("study.toml").string(), options)).out;
  };
  const auto one = desk.at("one").string(), divided = desk.at("divided").string();
  basin("-o " + one);
  for (const char* options : {"--plan 2 -o ", "--shard 2/2 -o ", "--shard 1/2 -o ", "--merge "})
    basin(options + divided);
  CHECK_THAT(basin("-o " + divided), Contains("from the store, 0 new"));
  for (const char* file : {"basin.csv", "basin.json"})
    CHECK(test::file_text(desk.at("divided") / file) == test::file_text(desk.at("one") / file));

  const test::Columns cells(desk.at("one/basin.csv"));
  CHECK(cells.header() == "x,y,attractor,period,axle.angle,exponent,exponent_error");
  REQUIRE(cells.rows() == 4);
  bool is_impact[2] = {};
  for (std::size_t i = 0; i < cells.rows(); ++i) {
    const double angle = cells.at(i, "x"), speed = cells.at(i, "y"), exponent = cells.at(i, "exponent");
    CAPTURE(angle, speed);
    CHECK(cells.at(i, "period") == 1);
    const auto scene =
        read_scene(desk.at("scene.toml"), {fmt::format("bodies.rotor.angle={:.17g}", angle),
                                           fmt::format("bodies.rotor.angular_velocity={:.17g}", speed)});
    LyapunovRequest request{.batches = 4, .transient = 100 * period_of_torque};
    const auto averaged = lyapunov(scene, request);
    request.cycle = period_of_torque;
    const auto found = lyapunov(scene, request);
    REQUIRE(averaged.failure.empty());
    REQUIRE(found.failure.empty());
    REQUIRE(found.exponents.size() == 2);
    const bool impact = found.impacts > 0;
    is_impact[impact] = true;
    // Both multipliers are complex and have equal moduli: half the logarithm of the determinant, to which the
    // damper contributes −c/J per time and an impact 2 ln e. Bound: eight digits, with a tolerance of 1e-10.
    const double expected = -damping / inertia / 2 + (impact ? std::log(restitution) / period_of_torque : 0);
    CHECK(exponent == Approx(expected).epsilon(1e-8));
    CHECK(found.exponents[0].value == Approx(exponent).epsilon(1e-8));
    CHECK(averaged.sum / 2 == Approx(exponent).epsilon(1e-8));
  }
  CHECK(is_impact[false]);
  CHECK(is_impact[true]);
}

TEST_CASE("a bifurcation diagram with exponents in shards has the tables of one process",
          "[shards][lyapunov]") {
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "study.toml", ball_study());
  const auto run = [&](const std::string& options) {
    test::succeeded("bifurcation " + place + "/study.toml --allow-outside " + options);
  };
  run("-o " + place + "/one");
  for (const char* options : {"--plan 2 -o ", "--shard 2/2 -o ", "--shard 1/2 -o ", "--merge ", "-o "})
    run(options + place + "/two");
  for (const char* file : {"bifurcation.csv", "bifurcation.json"}) {
    const auto one = test::file_text(folder.path() / "one" / file);
    CHECK_THAT(one, Contains("exponent"));
    CHECK(test::file_text(folder.path() / "two" / file) == one);
  }
}

TEST_CASE("work that cannot be divided is refused with the reason", "[shards][errors]") {
  const auto branches = (test::source_folder() / "cases/ball-on-table/branches.toml").string();
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  for (const auto& [command, answer] :
       {std::pair{"continue " + branches + " --plan 2 -o " + place,
                  "--plan: a continuation cannot be divided, because each motion of a branch starts"},
        {"lyapunov " + case_scene("impact-oscillator") + " --shard 1/2 -o " + place,
         "--shard: lyapunov cannot be divided; sweep, bifurcation, basin, calibrate and ensemble can"},
        {"sweep " + branches + " --plan 2 -o " + place, "continue: the study has no axes to sweep"},
        {"sweep " + branches + " -o " + place, "continue: the study has no axes to sweep"}}) {
    test::refused(command, Contains(answer));
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}
