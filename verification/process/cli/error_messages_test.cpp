// Errors as the program prints them: one line in its own words, with the place; nothing is written. And
// questions about a scene that is valid but cannot run as intended.
#include "values/name_length.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using test::replaced;

namespace {

/// Arguments of the program, and words of its message. $ is the folder of the files, SCENE the scene
/// of the paper.
struct Mistake {
  std::string arguments, words;
  int status = 2;
};

/// Files of scenes, and options; their keys are tested in scene_test.cpp and errors_test.cpp.
const std::vector<Mistake> scenes{
    {"check $/empty.toml", "the scene needs at least one body"},
    {"check $/not.toml", "not.toml:1:8: not TOML"},
    {"check $/key.toml", "key.toml:2:8: bodies.a.mass: must be greater than 0, is -1"},
    {"check $/open.toml", "open.toml:5:1: joints.left: cannot be closed"},
    {"check $/none.toml", "no such file"},
    {"check $", "is a folder, not a file"},
    {"check /dev/null", "is a device, not a file"},
    {"run SCENE --formulation nonsmooth -o $/r --set joints.gudgeon.clearance=-1",
     "--set joints.gudgeon.clearance=-1: joints.gudgeon.clearance: must be greater than 0, is -1"},
    {"run SCENE --formulation nonsmooth -o $/r --set joints.gudgeon.clearance", "must be KEY=VALUE"},
    {"run SCENE --formulation penalty -o $/r --set surfaces.steel.restitution=0 --set penalty.contact=exact",
     "restitution greater than 0"},
    {"check --set penalty.contact=florse SCENE",
     "penalty.contact: \"florse\" is unknown; did you mean \"flores\"?\n  one of \"hertz\""},
    {"check --set drives.motor.joint=mian SCENE",
     "there is no joint \"mian\"; did you mean main?\n  there is: main, big_end, gudgeon, guide"}};

/// Words of a command line.
const std::vector<Mistake> command_lines{
    {"run SCENE --formulation magic", "magic"},
    {"run SCENE", "--formulation is required"},
    {"run SCENE --formulation penalty --nope", "--nope"},
    {"run SCENE --formulation penalty -o SCENE/x", "scene.toml", 1},
    {"rum", "rum: unknown verb; did you mean run?"},
    {"SCENE", "the verb comes first, as in: freeplay check "},
    {"help cmopare", "unknown verb cmopare; did you mean compare?"},
    {"run --formulaton=penalty SCENE", "--formulaton: unknown option of run; did you mean --formulation?"},
    {"check SCENE two", "two: unexpected argument of check"},
    {"new fourbar", "fourbar is unknown; did you mean four-bar?\n  one of "},
    {"verify cmas", "unknown set of claims \"cmas\"; did you mean cams?"},
    {"laws --mass 3", "--mass requires scene"},
    {"validate --as-given SCENE", "--as-given requires --data"},
    {"validate SCENE", "a scene needs --data"},
    {"advise --error -1% SCENE", "greater than 0 per cent"},
    {"figures $/none", "none"}};

/// Texts of studies after those of the rig, and of measurements. errors_test.cpp and study_test.cpp have
/// further ones.
const std::vector<std::pair<const char*, const char*>> studies{
    {"jiont = 1\n", "jiont: is not a key of a study; did you mean joint?"},
    {"[axes.c]\nkey = \"joints.gudgeon.clearance\"\nvalues = [\"a\"]\n", "must be a number, is a text"},
    {"[axes.c]\nkey = \"joints.gudgeon.clearance\"\nvalues = [-1]\n",
     "axes.c: joints.gudgeon.clearance: must be"},
    {"[variants.v]\nset = [\"a\"]\n", "variants.v"},
    {"[variants.v]\nset = [1]\n", "must be a list of names"},
    {"starts = 0\n", "a whole number from 1"}};
const std::vector<std::pair<const char*, const char*>> measurements{
    {"", "is empty"},
    {"t,acceleration\n0,1\n0,1\n", ":3: t must increase"},
    {"t,acceleration\n0,1\n", "has 1 samples"}};

/// Files in a folder, and their errors.
class Desk {
 public:
  void check(const std::vector<Mistake>& mistakes) const {
    for (auto [arguments, words, status] : mistakes) {
      arguments = filled(arguments);
      const auto o = test::freeplay(arguments);
      CAPTURE(arguments, o.err);
      CHECK(o.status == status);
      CHECK(o.out.empty());
      CHECK(test::fault_of(o.err).empty());
      CHECK_THAT(o.err, Contains(filled(words)));
    }
    CHECK_FALSE(std::filesystem::exists(folder_.path() / "r"));  // a refused run leaves no files
  }
  void put(const std::string& name, const std::string& text) const {
    make_folder((folder_.path() / name).parent_path());
    write_file(folder_.path() / name, text);
  }

 private:
  std::string filled(std::string text) const {
    for (const auto& [mark, path] : {std::pair{"$", folder_.path()}, {"SCENE", test::flores()}})
      while (text.find(mark) != text.npos) text = replaced(text, mark, path.string());
    return text;
  }
  test::TemporaryFolder folder_;
};

/// The beginning of a study of the guided rig.
std::string study_head() {
  return fmt::format(
      "scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\nrevolutions = 1\n",
      (test::source_folder() / "cases/flores2011-experiment/guide.toml").string());
}

/// Output without the line ends at the width of a terminal.
std::string flat(const std::string& text) {
  std::istringstream in(text);
  std::string out;
  for (std::string word; in >> word;) out += word + " ";
  return out;
}

}  // namespace

TEST_CASE("errors of scenes and of command lines are reported in the program's own words", "[errors]") {
  const Desk desk;
  desk.put("empty.toml", "");
  desk.put("not.toml", "mass = = 1\n");
  desk.put("key.toml", "[bodies.a]\nmass = -1\n");
  // A rod of 0.3 m between pins 1 m apart.
  desk.put("open.toml", test::body("rod", 1, 0.01, "position = [0.1, 0.02]\n") +
                            test::pin("left", "ground", "rod", {}, {-0.15, 0}) +
                            test::pin("right", "ground", "rod", {1, 0}, {0.15, 0}) + test::run_for(1));
  desk.check(scenes);
  desk.check(command_lines);
  CHECK(test::freeplay("").status == 2);
}

TEST_CASE("errors of studies and measurements are reported in the program's own words", "[study][errors]") {
  const Desk desk;
  std::vector<Mistake> list;
  const auto study = [&](const std::string& text, const std::string& words,
                         const std::string& verb = "sweep --allow-outside") {
    const auto name = fmt::format("study{}.toml", list.size());
    desk.put(name, text);
    list.push_back({verb + " $/" + name + " -o $/r", words});
  };
  study("", "scene: is missing");
  study("scene = = 1\n", "not TOML");
  study(study_head(), "has no [calibrate]", "calibrate --allow-outside");
  study(replaced(study_head(), "\"accelerometer\"", "\"nope\""), "nope");
  study(replaced(study_head(), "guide.toml", "none.toml"), "no such file");
  for (const auto& [text, words] : studies) study(study_head() + text, words);
  // A scene in place of a study, and a study in place of a scene.
  for (const char* verb : {"sweep", "bifurcation", "basin", "calibrate", "tradeoff"})
    list.push_back({fmt::format("{} SCENE", verb),
                    "SCENE: is a scene; a study refers to one by scene = \"scene.toml\""});
  desk.put("study.toml", "scene = \"s.toml\"\n");
  for (const char* verb : {"check", "run --formulation penalty", "compare", "poincare", "advise"})
    list.push_back({fmt::format("{} $/study.toml", verb),
                    "$/study.toml: is a study, for freeplay sweep, bifurcation or basin"});
  for (const auto& [text, words] : measurements) {
    const auto name = fmt::format("data{}.csv", list.size());
    desk.put(name, text);
    list.push_back({"validate SCENE --data $/" + name + " -o $/r", words});
  }
  list.push_back({"validate SCENE --data $/none.csv -o $/r", "none.csv"});
  desk.check(list);
}

TEST_CASE("errors of result files are reported in the program's own words", "[errors]") {
  const Desk desk;
  std::vector<Mistake> list;
  for (const char* text :
       {"{", "[]", "3", "{\"provenance\": 3}", "{\"provenance\": {\"identity\": 7}}",
        "{\"provenance\": {\"identity\": {\"scene\": [1]}}}", "{\"provenance\": {}}", "\xFF\xFE"}) {
    const auto name = fmt::format("run{}.json", list.size());
    desk.put(name, text);
    list.push_back({"run --from $/" + name + " -o $/r", name});
  }
  desk.put("db/sweep.db", std::string(2000, 'x'));
  desk.put("good.toml", study_head());
  for (const auto& mistake :
       {Mistake{"run --resume $/nowhere", "nowhere"},
        {"figures $", "contains no result files to draw"},
        {"sweep --allow-outside $/good.toml -o $/db", "it is not a database of results", 1}})
    list.push_back(mistake);
  desk.check(list);
}

TEST_CASE("check and run ask about a missing guide, a rod that is too short and steps that are too long",
          "[whole-turn]") {
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  auto text = test::file_text(test::flores());
  const auto from = text.find("[joints.guide]");
  write_file(folder.path() / "unguided.toml", text.erase(from, text.find("[surfaces.steel]") - from));
  const auto unguided = place + "/unguided.toml", flores = test::flores().string(),
             locks = flores + " --set 'joints.big_end.at[1][0]=-0.02' --set 'joints.gudgeon.at[0][0]=0.02'";
  const std::string
      guide =
          "question: bodies.slider is connected by joints.gudgeon only, at its centre of mass, and has no "
          "guide",
      turn = "question: drives.motor cannot make a full turn: after 53.",
      brief = " -o " + place + "/out --formulation nonsmooth --set run.discard=0 --set run.revolutions=";
  const auto checked = test::freeplay("check " + unguided);
  CHECK_THAT(flat(checked.err), Contains(guide));
  CHECK_THAT(flat(checked.out), Contains("undriven motion 2 motions without a drive, of rod, slider"));
  CHECK_THAT(flat(test::freeplay("check " + locks).err), Contains(turn));
  CHECK_THAT(flat(test::freeplay("run " + unguided + brief + "0.03").err), Contains(guide));
  // 0.03 turns are 11 degrees.
  CHECK_THAT(flat(test::freeplay("run " + locks + brief + "0.03").err), !Contains("cannot make a full turn"));
  CHECK_THAT(flat(test::freeplay("check " + flores).out), !Contains("undriven motion"));
  // Steps of 60 degrees of the crank.
  const auto o = test::freeplay("run " + flores + brief + "3 --set nonsmooth.step=0.05");
  CAPTURE(o.out, o.err);
  CHECK(o.status == 1);
  CHECK_THAT(o.out + o.err, Contains("the clearance, which an impact law must keep near zero"));
  CHECK_THAT(o.err, Contains("question: nonsmooth.step = 0.05 s is 60 deg of rotation of drives.motor"));
}

// Names of the greatest permitted length pass through every command that reads result files; longer
// ones are refused at their place.

namespace {

/// A pendulum with clearance, and discs in a group that touch each other, a wall and a second
/// group.
std::string scene(std::size_t length) {
  const auto name = [&](char letter) { return std::string(length, letter); };
  const auto group = [&](char letter, const char* positions, const std::string& keys) {
    return fmt::format("[groups.{}]\nradius = 0.01\nmass = 0.01\nsurface = \"{}\"\npositions = {}\n{}",
                       name(letter), name('s'), positions, keys);
  };
  return "gravity = [0, -9.81]\n" + test::body(name('b'), 1, 0.03, "position = [0.3, 0]\n") +
         group('g', "[[1, 0.0101], [1.03, 0.0101]]", "walls = [[0.9, 0], [1.5, 0]]\n") +
         group('o', "[[1.1, 0.0101]]", fmt::format("touches = [\"{}\"]\n", name('g'))) +
         test::pin(name('j'), "ground", name('b'), {}, {-0.3, 0}, test::loose(1e-4, 1e-2, name('s'))) +
         fmt::format("[loads.{}]\ntype = \"force\"\nbody = \"{}\"\nforce = [0, 0.1]\n", name('l'),
                     name('b')) +
         test::surface(name('s'), 0.5, "young = 2e11\npoisson = 0.3\n") +
         test::run_for(0.02, "output_step = 1e-4\n") +
         fmt::format("[instruments.{}]\nbody = \"{}\"\naxis = [1, 0]\nbandwidth = 500\nsampling = 4000\n",
                     name('i'), name('b'));
}

std::filesystem::path written(const test::TemporaryFolder& folder, const std::string& text,
                              const char* name) {
  const auto file = folder.path() / name;
  std::ofstream(file) << text;
  return file;
}

}  // namespace

TEST_CASE("the longest names pass through every command that reads result files", "[names]") {
  const test::TemporaryFolder folder;
  const auto file = written(folder, scene(longest_name), "scene.toml").string();
  const auto at = folder.path().string() + "/", run = at + "run", both = at + "both";
  const auto b = std::string(longest_name, 'b'), j = std::string(longest_name, 'j');
  for (const auto& command : {
           fmt::format("check {}", file),
           fmt::format("run {} --formulation nonsmooth --forces -o {}", file, run),
           fmt::format("figures {}", run),
           fmt::format("plot {} --y {}.y --y {}.gap", run, b, j),
           fmt::format("report {} -o {}page.html", run, at),
           fmt::format("animate {} --svg --fps 100 -o {}slides", run, at),
           fmt::format("export {} --every 2 --vtk {}frames", run, at),
           fmt::format("compare {} --forces -o {}", file, both),
           fmt::format("report {} -o {}both.html", both, at),
           fmt::format("ensemble {} --starts 4 --column {}.y -o {}ensemble", file, b, at),
       }) {
    INFO(command.substr(0, 60));
    const auto o = test::freeplay(command);
    INFO(o.err);
    CHECK(o.status == 0);
  }
}

TEST_CASE("a name longer than the limit is refused at its place", "[names]") {
  const test::TemporaryFolder folder;
  const auto file = written(folder, scene(longest_name + 1), "scene.toml").string();
  for (const auto* verb : {"check", "run --formulation nonsmooth"}) {
    test::refused(
        fmt::format("{} {} -o {}", verb, file, (folder.path() / "out").string()),
        StartsWith(fmt::format("{}:2:1: bodies.{}: a name must have at most 100 characters, has 101", file,
                               std::string(longest_name + 1, 'b'))));
    CHECK_FALSE(std::filesystem::exists(folder.path() / "out"));
  }
}
