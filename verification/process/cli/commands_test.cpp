// The commands on studies and measurements as a user runs them, on small studies.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

std::string case_file(const char* name) {
  return (test::source_folder() / "cases/flores2011-experiment" / name).string();
}

/// Time, crank angle and value of the accelerometer's samples in signals.csv.
std::vector<std::array<double, 3>> accelerations(const std::filesystem::path& run) {
  std::vector<std::array<double, 3>> rows;
  for (const auto& line : test::lines_of(test::file_text(run / "signals.csv")))
    if (const auto f = test::fields_of(line); f[0] == "accelerometer")
      rows.push_back({std::stod(f[1]), std::stod(f[2]), std::stod(f[3])});
  return rows;
}

}  // namespace

TEST_CASE("validate accepts a run against itself and detects a different clearance", "[study]") {
  test::TemporaryFolder folder;
  const auto scene = case_file("guide.toml"), place = folder.path().string();
  const std::string turns = " --set run.revolutions=6 --set run.discard=1";
  REQUIRE(test::freeplay("run " + scene + turns + " --formulation nonsmooth -o " + place + "/run").status ==
          0);
  std::string csv = "t,acceleration\n";
  for (const auto& [t, angle, value] : accelerations(folder.path() / "run"))
    csv += fmt::format("{},{}\n", t, value);
  write_file(folder.path() / "measured.csv", csv);
  const auto agreement = [&](const std::string& set) {
    const auto o =
        test::succeeded("validate " + scene + " --revolutions 10 --data " + place + "/measured.csv -o " +
                        place + "/" + (set.empty() ? "same" : "other") + turns + set);
    CHECK_THAT(o.out, Contains("peak ratio, median"));
    return test::read_json(folder.path() / (set.empty() ? "same" : "other") / "validation.json");
  };
  const auto verdict = [](const nlohmann::json& v) {
    return v["models"]["nonsmooth"]["verdict"].get<std::string>();
  };
  // Five revolutions may be too few to find half a clearance, and then no verdict is given.
  CHECK(verdict(agreement("")) != "differs");
  // Four times the clearance: the test finds twice with these revolutions.
  CHECK(verdict(agreement(" --set joints.gudgeon.clearance=1e-3")) == "differs");
  CHECK(std::filesystem::file_size(folder.path() / "same/figures/overlay.png") > 10000);
}

TEST_CASE("validate reports a constant offset of the measured signal and removes it on request", "[study]") {
  test::TemporaryFolder folder;
  const auto scene = case_file("guide.toml"), place = folder.path().string();
  const std::string turns = " --set run.revolutions=6 --set run.discard=1";
  test::succeeded("run " + scene + turns + " --formulation nonsmooth -o " + place + "/run");
  const auto write = [&](double offset) {
    std::string csv = "t,acceleration,uncertainty\n";
    for (const auto& [t, angle, value] : accelerations(folder.path() / "run"))
      csv += fmt::format("{},{},0.1\n", t, value + offset);
    write_file(folder.path() / "measured.csv", csv);
  };
  const auto validation = [&](const std::string& option) {
    const auto out = test::succeeded("validate " + scene + " --revolutions 6 --data " + place +
                                     "/measured.csv -o " + place + "/v" + turns + option);
    return std::pair(out, test::read_json(folder.path() / "v/validation.json"));
  };
  write(0);
  const double without = validation("").second["measured"]["offset"]["value_m_per_s2"];
  write(10);
  const auto [said, found] = validation("");
  const auto& offset = found["measured"]["offset"];
  // Exactly 10 more than without, and 10 is 100 uncertainties.
  CHECK(offset["value_m_per_s2"].get<double>() == Approx(without + 10).epsilon(1e-6));
  CHECK(offset["beyond_uncertainty"] == true);
  CHECK(offset["removed"] == false);
  CHECK_THAT(said.err, Contains("constant offset") && Contains("--remove-offset"));
  CHECK_THAT(said.out, Contains("offset of the measured signal"));
  const auto [same, removed] = validation(" --remove-offset");
  CHECK(removed["measured"]["offset"]["removed"] == true);
  CHECK(removed["measured"]["offset"]["value_m_per_s2"].get<double>() == Approx(without + 10).epsilon(1e-6));
  CHECK_THAT(same.out, Contains("offset removed, a fitted value") && Contains("evidence"));
  // The mean over 6 turns of 0.3 s is a change of the slider's speed, at one crank angle, of below 1 m/s: at
  // most 0.6 m/s² of each, model and file.
  for (const auto* model : {"penalty", "nonsmooth"})
    CHECK(std::abs(removed["models"][model]["offset_m_per_s2"].get<double>()) < 1.2);
  test::refused("validate " + scene + " --remove-offset", Contains("--remove-offset requires --data"));
}

TEST_CASE("figures use the crank's angle and contain the plotted values") {
  for (const char* speed : {"200", "-200"}) {
    CAPTURE(speed);
    test::TemporaryFolder folder;
    test::succeeded("compare " + case_file("guide.toml") +
                    " --set run.revolutions=1.3 --set run.discard=0 --set " +
                    "drives.motor.speed_rpm=" + speed + " -o " + folder.path().string());
    // The last whole revolution of the accelerometer, as in signals.csv: angles on the circle,
    // unrounded values.
    std::vector<std::pair<double, double>> rows;
    for (const auto& [t, angle, value] : accelerations(folder.path() / "penalty"))
      if (const double turns = angle / (2 * std::numbers::pi); std::abs(turns) < 1)
        rows.emplace_back(360 * (turns - std::floor(turns)), value);
    REQUIRE(rows.size() > 2900);
    const auto drawn = test::data_blocks(folder.path() / "figures/acceleration.dat").at(0);
    REQUIRE(drawn.size() >= rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) {
      CHECK(std::abs(drawn[i][0] - rows[i].first) < 1e-9);
      CHECK(drawn[i][1] == rows[i].second);
    }
  }
}

TEST_CASE("tradeoff: finer settings cost more and have less error; statistics have their own scale",
          "[study]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(folder.path() / "study.toml",
             fmt::format("scene = \"{0}/cases/flores2011/scene.toml\"\nstarts = 2\nrevolutions = 1\n"
                         "[variants.ideal]\nscene = \"{0}/cases/tradeoff/ideal.toml\"\nset = "
                         "[\"run.revolutions=0.1\", \"run.discard=0\"]\n"
                         "[variants.loose]\nset = [\"run.revolutions=0.04\", \"run.discard=0\", "
                         "\"penalty.contact=exact\"]\n",
                         test::source_folder().string()));
  const auto o = test::succeeded("tradeoff " + place + "/study.toml --allow-outside --repeats 1 -o " + place +
                                 "/out --document " + place + "/doc");
  for (const auto& line : test::lines_of(o.out)) {
    CAPTURE(line);
    if (line.find("e-") != std::string::npos && line.find("known") == std::string::npos &&
        line.find("Model") == std::string::npos)
      CHECK(line.size() <= 80);
  }
  const auto document = test::read_json(folder.path() / "out/tradeoff.json");
  const auto of = [&](const char* scene, const std::string& method, double fineness) {
    for (const auto& s : document["scenes"][scene]["settings"])
      if (s["method"] == method && s["fineness"].get<double>() == Approx(fineness)) return s;
    FAIL(method);
    return nlohmann::json();
  };
  for (const char* error : {"error_events", "error_energy"}) {
    CAPTURE(error);
    CHECK(of("loose", "adams_bashforth_moulton", 1e-9)[error] <
          of("loose", "adams_bashforth_moulton", 1e-5)[error]);
  }
  CHECK(of("loose", "moreau-jean", 1e-6)["error_events"] < of("loose", "moreau-jean", 1e-5)["error_events"]);
  CHECK(of("loose", "moreau-jean", 1e-6)["steps"] > of("loose", "moreau-jean", 1e-4)["steps"]);
  // First contact at 4.42 ms, penalty against impact law: the model error is some per cent
  // (K^(-2/5)).
  CHECK(document["scenes"]["loose"]["model_error_of_penalty"].get<double>() > 1e-3);
  CHECK(document["scenes"]["loose"]["model_error_of_penalty"].get<double>() < 0.2);
  CHECK(of("loose", "event-driven", 1e-9)["statistics_in_standard_errors"].is_number());
  CHECK(of("ideal", "event-driven", 1e-9)["statistics_in_standard_errors"].is_null());
  CHECK(std::filesystem::exists(folder.path() / "doc/tradeoff.md"));
  CHECK(std::filesystem::exists(folder.path() / "doc/figures/tradeoff_loose.png"));
}

TEST_CASE("validate with a study: calibration, matrix, verdicts, figures, and repetition without a run",
          "[study][long]") {
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const auto smaller = [&](const char* name, std::vector<std::pair<std::string, std::string>> changes) {
    std::string text = test::file_text(case_file(name));
    changes.insert(changes.end(), {{"scene = \"", "scene = \"" + case_file("")},
                                   {"revolutions = 50", "revolutions = 1"},
                                   {"revolutions = 25", "revolutions = 1"},
                                   {"discard = 2", "discard = 1"},
                                   {"starts = 8", "starts = 2"}});
    for (const auto& [from, to] : changes) {
      CAPTURE(from);
      REQUIRE(text.find(from) != std::string::npos);
      for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
        text.replace(at, from.size(), to);
    }
    write_file(folder.path() / name, text);
  };
  smaller("study.toml", {{"[100.0, 150.0, 200.0, 250.0]", "[100.0, 200.0]"},
                         {"nonsmooth.step=2e-6", "nonsmooth.step=1e-5"},
                         {"starts = 3", "starts = 2"}});
  smaller("calibrate.toml", {{"points = 80", "points = 20"}, {"starts = 3", "starts = 1"}});
  const auto command =
      "validate " + place + "/study.toml --allow-outside -o " + place + "/out --document " + place + "/doc";
  const auto o = test::freeplay(command);
  CAPTURE(o.err);
  REQUIRE(o.status <= 1);  // two revolutions need not satisfy any finding
  const auto first = test::read_json(folder.path() / "out/experiment.json");
  for (const char* variant : {"chain", "paper", "guide", "calibrated"}) {
    CAPTURE(variant);
    CHECK(first["verdicts"][variant]["nonsmooth"].size() > 8);
    CHECK(first["verdicts"][variant]["penalty"].size() > 8);
  }
  const std::string text = test::file_text(folder.path() / "doc/experiment.md");
  for (const char* part : {"X6", "X9", "calibrated", "Fitted", "predicted"}) CHECK_THAT(text, Contains(part));
  // Repeated: all runs exist, the verdicts are the same.
  REQUIRE(test::freeplay(command).status == o.status);
  CHECK(test::read_json(folder.path() / "out/experiment.json")["verdicts"] == first["verdicts"]);
  // Runs of two revolutions may contradict a fit or leave it open: then the command reports it, with
  // the corresponding status.
  const auto again =
      test::freeplay("calibrate " + place + "/calibrate.toml --allow-outside -o " + place + "/out");
  const auto all = test::read_json(folder.path() / "out/calibration.json")["fitted_to_all"];
  bool contradicted = false;
  for (const auto& target : all["fitted"])
    contradicted = contradicted || target["contradicted_by_runs"].get<bool>();
  const bool holds = all["holds"].get<bool>();
  CHECK((!contradicted || !holds));
  CHECK(again.status == (holds ? 0 : 1));
  const auto says = [&](const char* text) { return again.err.find(text) != again.err.npos; };
  CHECK((says("Calibration rejected") || says("Calibration open")) == !holds);
  for (const auto& unknown : all["unknowns"]) CHECK(unknown["low"].is_null() == !holds);
}

TEST_CASE("terminal output stays within 80 columns") {
  test::TemporaryFolder folder;
  const auto cases = (test::source_folder() / "cases").string() + "/", scene = test::flores().string(),
             place = " -o " + folder.path().string();
  const std::string brief = " --set run.revolutions=0.1 --set run.discard=0",
                    penalty = "run --formulation penalty --no-figures ";
  for (const auto& arguments :
       {"check --why " + scene, "check " + case_file("guide.toml"), penalty + scene + brief + place,
        "compare " + scene + brief + place + "/c",
        // Names of gears with their flank, and the sentences on a film.
        penalty + cases + "epicyclic-gear/scene.toml --set run.duration=0.02" + place,
        penalty + cases + "lubricated-pin/scene.toml --set run.revolutions=1 --set run.discard=0" + place})
    for (const auto& line : test::lines_of(test::succeeded(arguments).out)) {
      CAPTURE(arguments, line);
      if (line.find('/') == std::string::npos) CHECK(test::width(line) <= 80);  // a path may have any length
    }
}

// freeplay check, run and compare: questions about units, and the status of a comparison that stops.

TEST_CASE("unit plausibility: the program asks once on stderr and continues", "[sense]") {
  const auto scene = test::scene_file("pendulum").string();
  const auto plain = test::freeplay("check " + scene);
  CHECK(plain.err.empty());
  const auto o = test::freeplay("check " + scene + " --set gravity=[0,-9810]");
  CHECK(o.status == plain.status);
  CHECK_THAT(o.err, Contains("question: gravity of 9810 m/s²"));
  CHECK(o.err.find("question", 1) == o.err.npos);
  test::TemporaryFolder folder;
  const auto run = test::succeeded("run " + scene + " --formulation nonsmooth --set gravity=[0,-9810]" +
                                   " --set run.duration=1e-3 -o " + (folder.path() / "r").string());
  CHECK_THAT(run.err, Contains("question: gravity of 9810 m/s²"));
  for (const auto& line : test::lines_of(run.err)) CHECK(line.size() <= 82);  // two characters of two bytes
}

TEST_CASE("compare ends with status 1 if either formulation stops", "[compare]") {
  // A step of 0.1 s, a third of a turn, moves the journal far through its bearing.
  const test::TemporaryFolder folder;
  const auto run = test::freeplay("compare " + test::scene_file("gudgeon").string() +
                                  " --set nonsmooth.step=0.1 --set run.duration=0.2 -o " +
                                  (folder.path() / "out").string());
  CAPTURE(run.out, run.err);
  CHECK(run.status == 1);
  CHECK_THAT(run.err, Contains("nonsmooth: stopped"));
}

TEST_CASE("events.csv names each pair of a group, whose contacts are found by proximity", "[groups]") {
  // Two discs fall onto the floor at once, and onto each other: the second one after the rebound of the first.
  test::TemporaryFolder folder;
  const auto place = folder.path().string();
  write_file(
      folder.path() / "heap.toml",
      "gravity = [0, -9.81]\n[groups.g]\nmass = 0.1\nradius = 0.01\npositions = [[0.1, 0.011], [0.1, 0.032], "
      "[0.2, 0.011]]\nwalls = [[0, 0], [0.3, 0]]\nsurface = \"s\"\npairs = \"near\"\n"
      "[surfaces.s]\nrestitution = 0.5\nfriction = 0.3\n[run]\nduration = 0.1\nstart = \"given\"\n"
      "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-4\n");
  test::succeeded("run " + place + "/heap.toml --formulation nonsmooth -o " + place + "/out");
  std::set<std::string> pairs;
  for (const auto& line : test::lines_of(test::file_text(folder.path() / "out/events.csv")))
    pairs.insert(test::fields_of(line)[1]);
  CHECK(pairs == std::set<std::string>{"joint", "g-1-g-2", "g-wall1-g-1", "g-wall1-g-3"});
}
