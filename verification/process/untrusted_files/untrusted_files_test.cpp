// Hundreds of hostile files in every command that reads one: nothing in them is executed, nothing
// outside is written, and no message about them moves a cursor.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <nlohmann/json.hpp>

#include "io/files/output_file.hpp"
#include "verification/support/support.hpp"
#include "verification/process/untrusted_files/inputs.hpp"

using namespace freeplay;

namespace {

/// A folder for the corpus, and a count of its files.
class Corpus {
 public:
  Corpus() : bait_(folder_.path()), texts_(test::hostile_texts(bait_)) {}
  const std::vector<std::string>& texts() const { return texts_; }
  const std::filesystem::path& place() const { return bait_.folder; }

  void add(const std::filesystem::path& name, const std::string& text) {
    make_folder((bait_.folder / name).parent_path());
    write_file(bait_.folder / name, text);
    ++files_;
  }
  /// Runs the program on them; `status`: the required one, −1 for any.
  test::Told run(const std::vector<std::string>& arguments, int status = -1) {
    const auto told = test::run_program(bait_, arguments);
    INFO(fmt::format("{}", fmt::join(arguments, " ")).substr(0, 300));
    INFO("status " << told.status << "\n" << told.err.substr(0, 1000));
    CHECK(told.decent());
    CHECK(bait_.untouched());
    if (status >= 0) CHECK(told.status == status);
    return told;
  }
  int files() const { return files_; }

 private:
  test::TemporaryFolder folder_;
  test::Bait bait_;
  std::vector<std::string> texts_;
  int files_ = 0;
};

/// A text as a possible file name; "" if it cannot be one.
std::string as_file_name(std::string text) {
  for (char& c : text)
    if (c == '/' || c == '\0') c = '_';
  text = text.substr(0, 200);
  return text == "." || text == ".." ? "" : text;
}

/// JSON of any bytes, as another program may have written it.
std::string raw(const nlohmann::json& document) {
  return document.dump(1, ' ', false, nlohmann::json::error_handler_t::ignore);
}

nlohmann::json origin(const std::string& text) {
  return {{"version", text},     {"commit", text},
          {"scene_file", text},  {"scene", text},
          {"overrides", {text}}, {"options", {{"run", {{"duration", 1.0}, {"discard", 0.0}}}}}};
}

}  // namespace

TEST_CASE("hostile scenes in every command that reads one", "[security][hostile]") {
  Corpus corpus;
  const auto& texts = corpus.texts();
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto& text = texts[i];
    const auto place = fmt::format("s{}", i);
    corpus.add(place + "/title.toml", test::rig(test::in_toml(text)));
    corpus.add(place + "/raw.toml", test::rig("\"" + text + "\""));
    corpus.add(place + "/joint.toml",
               test::rig("\"\"") + "\n[joints." + test::in_toml(text) + "]\ntype = \"revolute\"\n");
    corpus.add(place + "/value.toml",
               test::rig("\"\"") + "\n[loads.l]\ntype = " + test::in_toml(text) + "\n");
    corpus.run({"check", place + "/title.toml"});
    corpus.run({"check", place + "/raw.toml"});
    corpus.run({"check", place + "/joint.toml"}, 2);
    corpus.run({"check", place + "/value.toml"}, 2);
    const char* const verbs[] = {"run", "drift", "laws", "compare", "advise", "modes", "poincare"};
    const auto k = i % std::size(verbs);
    std::vector<std::string> arguments{verbs[k], place + "/title.toml"};
    if (k == 0) arguments.insert(arguments.end(), {"--formulation", i % 2 ? "penalty" : "nonsmooth"});
    if (k < 4 || k == 6) arguments.insert(arguments.end(), {"-o", place + "/out"});
    if (k == 4) arguments.insert(arguments.end(), {"--error", "50"});
    if (k == 6)
      arguments.insert(arguments.end(),
                       {"--section", i % 2 ? text.substr(0, text.find('\0')) : "every 0.01 s"});
    corpus.run(arguments);
    if (text.find('\0') == text.npos)
      corpus.run({"check", place + "/joint.toml", "--set", "joints.gudgeon.surface=" + text}, 2);
    // By its own name, and by that of its folder, into a folder named after it.
    if (const auto name = as_file_name(text); !name.empty()) {
      corpus.add(std::filesystem::path(place) / name / "scene.toml", test::rig(test::in_toml(text)));
      const auto file = (std::filesystem::path(place) / name / "scene.toml").string();
      std::vector<std::string> named{"run", file, "--formulation", "nonsmooth"};
      if (i % 3 != 0) named.emplace_back("--no-figures");
      corpus.run(named);
      if (i % 4 == 0) corpus.run({"laws", file});
    }
  }
  CHECK(corpus.files() > 180);
}

TEST_CASE("hostile studies and measurements in every command that reads one", "[security][hostile]") {
  Corpus corpus;
  const auto& texts = corpus.texts();
  corpus.add("scene.toml", test::rig("\"rig\""));
  const std::string head =
      "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\n"
      "revolutions = 1\ndiscard = 0\nstarts = 1\nformulations = [\"nonsmooth\"]\n";
  const std::string settled =
      "scene = \"scene.toml\"\n[axes.a]\nkey = \"surfaces.steel.friction\"\nvalues = [0.0, 0.1]\n";
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto quoted = test::in_toml(texts[i]);
    const auto name = fmt::format("study{}.toml", i), data = fmt::format("data{}.csv", i);
    const std::string parts[] = {
        "title = " + quoted + "\nclaims = " + quoted + "\n",
        "joint = " + quoted + "\nscene = " + quoted + "\n",
        head + "[axes." + quoted + "]\nkey = \"run.discard\"\nvalues = [0.0]\n",
        head + "[axes.a]\nkey = " + quoted + "\nvalues = [1.0]\nunit = " + quoted + "\n",
        head + "[variants." + quoted + "]\ntitle = " + quoted + "\n",
        head + "[variants.a]\nscene = " + quoted + "\nset = [" + quoted + "]\n",
        head + "fit = " + quoted + "\nclaims = \"flores2011\"\n",
        settled + "[bifurcation]\naxis = " + quoted + "\nsection = " + quoted + "\n",
        settled + "[bifurcation]\naxis = \"a\"\nsection = \"every 0.01 s\"\ncolumns = [" + quoted + "]\n",
        settled + "[basin]\nx = " + quoted + "\ny = \"a\"\nsection = " + quoted + "\n"};
    corpus.add(name, parts[i % std::size(parts)]);
    for (const char* verb : {"sweep", "calibrate", "validate", "bifurcation", "basin"})
      corpus.run({verb, name, "-o", "out"});
    if (i % std::size(parts) < 2)
      corpus.run({"tradeoff", name, "-o", "out"});  // others may be valid, and take long
    std::string measured = i % 2 ? "t,acceleration\n" : texts[i] + ",t,acceleration\n";
    for (int k = 0; k < 20; ++k)
      measured += i % 2 ? fmt::format("{},{}\n", 0.001 * k, texts[i]) : fmt::format("0,{},1\n", 0.001 * k);
    corpus.add(data, measured);
    corpus.run({"validate", "scene.toml", "--data", data, "--set", "run.revolutions=1.1", "-o", "out"}, 2);
  }
  CHECK(corpus.files() > 75);
}

TEST_CASE("hostile result folders in the commands that read one", "[security][hostile]") {
  Corpus corpus;
  const auto& texts = corpus.texts();
  for (std::size_t i = 0; i < texts.size(); ++i) {
    const auto& text = texts[i];
    const auto place = fmt::format("r{}", i);
    const auto file = [&](const char* name) { return place + "/" + name; };
    switch (i % 7) {
      case 0:
        corpus.add(file("drift.json"), raw({{"provenance", origin(text)}}));
        corpus.add(file("drift.csv"),
                   "stabilisation,t,length,closure\n" + (i % 2 ? text : "none") + ",0,1,1\nnone,1,2,2\n");
        break;
      case 1:
        corpus.add(file("laws.json"), raw({{"mass_kg", 1},
                                           {"approach_m_per_s", 1},
                                           {"restitution_asked", 0.5},
                                           {"provenance", origin(text)}}));
        corpus.add(file("impact_loops.csv"),
                   "law,delta,force\nflores,0,0\nflores,1,1\n" + (i % 2 ? text + ",1,1\n" : ""));
        corpus.add(file("delivered.csv"), "law,requested,delivered\nflores,0,0\nflores,1,1\n");
        corpus.add(file("friction.csv"), "law,speed,coefficient\nflores,0,0\nflores,1,1\n");
        break;
      case 2:
        corpus.add(file("tradeoff.json"),
                   raw({{"provenance", origin(text)}, {"scenes", {{"a", {{"scene_file", text}}}}}}));
        corpus.add(
            file("tradeoff.csv"),
            "scene,method,formulation,events,state,rhs,cpu_s\na,m,penalty,1,1,1,1\na,m,penalty,2,2,2,2\n" +
                (i % 2 ? text + ",m,penalty,1,1,1,1\n" : ""));
        break;
      case 3:
        corpus.add(file("extremes.json"), raw({{"provenance", origin(text)}}));
        corpus.add(file("extremes.csv"), "axis,label,value,formulation,outcome\n" + text +
                                             ",1,1,penalty,right\n" + "a," + text + ",2,penalty,right\n");
        corpus.add(file("limits.csv"), "axis,formulation,value\na,penalty,1\n");
        break;
      default:
        corpus.add(
            file("run.json"),
            raw({{"formulation", text}, {"provenance", origin(text)}, {"undetermined_reactions", {text}}}));
        corpus.add(file("forces.csv"), "t," + text + ".fx_mean," + text + ".m_mean," + text +
                                           ".m\n0,,,\n1,1,1,1\n2,1,2,2\n3,2,1,1\n");
        corpus.run({"run", "--from", file("run.json")}, 2);
        corpus.run({"run", "--resume", place}, 2);
        break;
    }
    corpus.run({"figures", place});
    corpus.run({"report", place});
    // A comparison with such names of joints and channels.
    if (i % 3 == 0) {
      const auto twin = place + "c";
      corpus.add(twin + "/comparison.json", raw({{"provenance", origin(text)},
                                                 {"penalty", {{"revolutions_counted", 1}}},
                                                 {"pairing", {{"pairs", nlohmann::json::array()}}}}));
      for (const char* run : {"penalty", "nonsmooth"}) {
        corpus.add(twin + "/" + run + "/trajectory.csv",
                   "t," + text + ".ex," + text + ".ey," + text + ".gap\n0,0,0,1\n1,0,0,1\n");
        corpus.add(twin + "/" + run + "/signals.csv",
                   "channel,t,crank_angle,value\n" + text + ",0,0,1\n" + text + ",1,7,1\n");
        corpus.add(twin + "/" + run + "/run.json", raw({{"provenance", origin(text)}}));
      }
      corpus.run({"figures", twin});
      corpus.run({"report", twin});
    }
    // The name of the folder itself.
    if (const auto name = as_file_name(text); !name.empty() && i % 3 == 1) {
      const std::filesystem::path named = std::filesystem::path(place + "n") / name;
      corpus.add(named / "drift.json", raw({{"provenance", origin("1")}}));
      corpus.add(named / "drift.csv", "stabilisation,t,length,closure\nnone,0,1,1\nnone,1,2,2\n");
      corpus.run({"figures", named.string()}, 0);
    }
  }
  CHECK(corpus.files() > 150);
}
