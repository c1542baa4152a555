// The library as a user has it: installed, found from a project outside the source tree, with its
// public headers alone, several simulations in threads; and the program that is installed with it.
#include <sys/wait.h>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <thread>

#include "dynamics/assembly/assembly.hpp"
#include "freeplay.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

struct Shell {
  int status;
  std::string said;  // on both streams
};
/// Runs a command in a folder.
Shell shell(const fs::path& folder, const std::string& command) {
  const auto log = folder / "said";
  const int status = std::system(
      fmt::format("cd '{}' && ( {} ) >'{}' 2>&1 </dev/null", folder.string(), command, log.string()).c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), test::file_text(log)};
}
std::string quiet(const fs::path& folder, const std::string& command) {
  const auto done = shell(folder, command);
  INFO(command << "\n" << done.said);
  REQUIRE(done.status == 0);
  return done.said;
}

/// The build, installed into a folder, and the examples built against it as a user builds them;
/// once.
class Installed {
 public:
  static const Installed& get() {
    static const Installed once;
    return once;
  }
  fs::path folder() const { return folder_.path(); }
  fs::path prefix() const { return folder() / "prefix"; }
  std::string program() const { return (prefix() / "bin/freeplay").string(); }
  std::string example(const char* name) const { return (folder() / "examples/build" / name).string(); }

 private:
  Installed() {
    quiet(folder(), fmt::format("'{}' --install '{}' --prefix prefix", FREEPLAY_CMAKE, FREEPLAY_BINARY_DIR));
    fs::copy(test::source_folder() / "verification/library", folder() / "examples");
    quiet(folder() / "examples",
          fmt::format("'{0}' -G Ninja -S . -B build -DCMAKE_PREFIX_PATH='{1}' -DCMAKE_CXX_COMPILER='{2}' "
                      "-DCMAKE_EXE_LINKER_FLAGS='{3}' && '{0}' --build build",
                      FREEPLAY_CMAKE, prefix().string(), FREEPLAY_CXX, FREEPLAY_LINK_FLAGS));
  }
  test::TemporaryFolder folder_;
};

/// A row of events.csv as main.cpp prints an event.
std::string as_printed(const std::string& row) {
  const auto field = test::fields_of(row);
  REQUIRE(field.size() == 12);
  char out[200];
  std::snprintf(out, sizeof out, "%.12g %s %g", std::stod(field[0]), field[1].c_str(), std::stod(field[8]));
  return out;
}

std::vector<double> numbers(const std::string& row) {
  std::vector<double> all;
  for (const auto& f : test::fields_of(row))
    if (f.find_first_not_of("0123456789+-.e") == f.npos) all.push_back(std::stod(f));
  REQUIRE(all.size() == 10);
  return all;
}

/// Text with every sequence of blanks as one, so that indentation does not matter.
std::string even(const std::string& text) {
  std::string out;
  for (const char c : text)
    if (!std::isspace(static_cast<unsigned char>(c)))
      out += c;
    else if (!out.empty() && out.back() != ' ')
      out += ' ';
  return out;
}

}  // namespace

TEST_CASE("an external program prints the events of the command line program", "[library]") {
  const auto& installed = Installed::get();
  const auto place = installed.folder() / "ten-lines";
  fs::create_directories(place);
  fs::copy_file(test::flores(), place / "scene.toml", fs::copy_options::overwrite_existing);
  const auto printed = test::lines_of(quiet(place, installed.example("main")));
  REQUIRE(printed.size() > 20);

  // The same second: 10/3 revolutions at 200 rpm.
  const std::string command = fmt::format(
      "{} run scene.toml --formulation nonsmooth --set joints.gudgeon.clearance=1e-3", installed.program());
  quiet(place, command + " --set run.revolutions=3.3333333333333335 -o second");
  auto rows = test::lines_of(test::file_text(place / "second/events.csv"));
  rows.erase(rows.begin());
  REQUIRE(rows.size() == printed.size());
  for (std::size_t i = 0; i < rows.size(); ++i) CHECK(printed[i] == as_printed(rows[i]));

  // The whole scene, whose run continues: the final results of the first second are its beginning.
  quiet(place, command + " -o whole");
  auto whole = test::lines_of(test::file_text(place / "whole/events.csv"));
  whole.erase(whole.begin());
  REQUIRE(whole.size() > rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) CHECK(whole[i] == rows[i]);
}

TEST_CASE("an external program prints all digits of all columns, in both formulations", "[library]") {
  const auto& installed = Installed::get();
  const auto place = installed.folder() / "digits";
  fs::create_directories(place);
  const auto scene = test::flores().string();
  for (const std::string formulation : {"nonsmooth", "penalty"}) {
    const auto printed =
        test::lines_of(quiet(place, fmt::format("{} {} {} 1.0 joints.gudgeon.clearance=1e-3",
                                                installed.example("events"), scene, formulation)));
    quiet(place, fmt::format("{} run {} --formulation {} --set joints.gudgeon.clearance=1e-3 "
                             "--set run.revolutions=3.3333333333333335 -o {}",
                             installed.program(), scene, formulation, formulation));
    auto rows = test::lines_of(test::file_text(place / formulation / "events.csv"));
    rows.erase(rows.begin());
    REQUIRE(rows.size() == printed.size());
    REQUIRE(rows.size() > 20);
    for (std::size_t i = 0; i < rows.size(); ++i) CHECK(numbers(printed[i]) == numbers(rows[i]));
  }
}

TEST_CASE("an external program: mechanism in code, observers, threads, snapshots and errors", "[library]") {
  const auto& installed = Installed::get();
  const auto done = shell(installed.folder() / "examples", installed.example("pendulum"));
  INFO(done.said);
  CHECK(done.status == 0);
  CHECK_THAT(done.said, !Contains("FAILED"));
}

TEST_CASE("each public header compiles alone with only the standard library", "[library][long]") {
  const auto& installed = Installed::get();
  const auto headers = installed.prefix() / "include/freeplay", place = installed.folder() / "headers";
  fs::create_directories(place);
  int count = 0;
  for (const auto& entry : fs::recursive_directory_iterator(headers)) {
    if (!entry.is_regular_file()) continue;
    const auto name = fs::relative(entry.path(), headers).string();
    INFO(name);
    const auto text = test::file_text(entry.path());
    for (const auto& line : test::lines_of(text)) {
      if (!line.starts_with("#include")) continue;
      for (const char* foreign :
           {"Eigen", "toml", "boost", "fmt", "nlohmann", "klu", "coin", "tbb", "sqlite"})
        CHECK_THAT(line, !Contains(foreign));
    }
    std::ofstream(place / fmt::format("{}.cpp", ++count)) << "#include \"" << name << "\"\n";
  }
  CHECK(count > 10);
  quiet(place, fmt::format(
                   "'{}' -std=c++20 -fsyntax-only -Wall -Wextra -Wconversion -Werror -pedantic -I '{}' *.cpp",
                   FREEPLAY_CXX, headers.string()));
}

TEST_CASE("the installation contains only files for users", "[library]") {
  const auto prefix = Installed::get().prefix();
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(prefix))
    if (entry.is_regular_file()) found.push_back(fs::relative(entry.path(), prefix).string());
  const auto has = [&](const std::string& end) {
    return std::ranges::any_of(found, [&](const std::string& f) { return f.ends_with(end); });
  };
  for (const char* file :
       {"bin/freeplay", "libfreeplay.a", "libfreeplay_core.a", "include/freeplay/freeplay.hpp",
        "freeplayConfig.cmake", "freeplayConfigVersion.cmake", "freeplayTargets.cmake",
        "pkgconfig/freeplay.pc", "share/freeplay/cases/flores2011/scene.toml"})
    CHECK(has(file));
  for (const char* file :
       {"freeplay-tests", "libfreeplay_claims.a", "libfreeplay_study.a", "system.hpp", "main.cpp"})
    CHECK(!has(file));
  // No file that CMake reads contains the path of the build.
  for (const auto& file : found)
    if (file.ends_with(".cmake")) {
      const auto text = test::file_text(prefix / file);
      CHECK_THAT(text, !Contains(test::source_folder().string() + "/src"));
      CHECK_THAT(text, !Contains(std::string(FREEPLAY_BINARY_DIR) + "/lib"));
    }
}

TEST_CASE("the installed program runs the installed scenes", "[library]") {
  const auto& installed = Installed::get();
  const auto place = installed.folder() / "elsewhere";
  fs::create_directories(place);
  const auto scene = (installed.prefix() / "share/freeplay/cases/flores2011/scene.toml").string();
  const std::string short_run = " --set run.revolutions=0.5 --set run.discard=0.1";
  CHECK_THAT(quiet(place, installed.program() + " check " + scene), Contains("gudgeon"));
  quiet(place, installed.program() + " run " + scene + short_run + " --formulation penalty");
  CHECK(fs::exists(place / "out/flores2011-penalty/run.json"));
  quiet(place, installed.program() + " compare " + scene + short_run);
  CHECK(fs::exists(place / "out/flores2011/comparison.json"));
  quiet(place, installed.program() + " figures out/flores2011");
  CHECK_THAT(quiet(place, installed.program() + " laws --restitution 0.46"), Contains("lankarani-nikravesh"));
}

TEST_CASE("four scenes in four threads give the same bits as in sequence", "[library]") {
  struct Case {
    fs::path file;
    const char* formulation;
    double until;  // s
  };
  // Dense and sparse solves, two simultaneous assemblies by Ipopt, contacts of every kind,
  // instruments.
  const std::vector<Case> cases{
      {test::flores(), "penalty", 0.1},
      {test::scene_file("four_bar_two"), "nonsmooth", 0.2},
      {test::scene_file("long_chain"), "nonsmooth", 0.1},
      {test::source_folder() / "cases/flores2010-translational/scene.toml", "penalty", 0.02}};
  struct Seen {
    Result result;
    std::vector<double> numbers;
  };
  const auto all = [](const Case& c) {
    auto scene = read_scene(c.file);
    // so that an assembly is necessary
    for (auto& body : scene.mechanism.bodies) body.angle = body.angle.value_or(0) + 1e-3;
    scene.run.start = RunOptions::Start::assembled;
    Simulation simulation(scene, c.formulation);
    Seen seen;
    test::Listener listener;
    listener.want = {.forces = true, .samples = true};
    Forces now;
    listener.on_step = [&](const Step& step) {
      step.forces(step.t1, now);
      for (const auto& f : now.elements) seen.numbers.insert(seen.numbers.end(), {f.fx, f.fy, f.m});
    };
    listener.on_sample = [&](std::size_t, double t, double value) {
      seen.numbers.insert(seen.numbers.end(), {t, value});
    };
    seen.result = simulation.run({.until = c.until, .observers = {&listener}});
    for (const auto& e : seen.result.events)
      seen.numbers.insert(seen.numbers.end(),
                          {e.t, e.v_n_minus, e.v_n_plus, e.impulse_n, e.impulse_t, e.duration});
    return seen;
  };
  std::vector<Seen> apart, together(cases.size());
  for (const auto& c : cases) apart.push_back(all(c));
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < cases.size(); ++i)
    threads.emplace_back([&, i] { together[i] = all(cases[i]); });
  for (auto& t : threads) t.join();

  const auto bits = [](const std::vector<double>& a, const std::vector<double>& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
  };
  for (std::size_t i = 0; i < cases.size(); ++i) {
    INFO(cases[i].file);
    const auto &a = apart[i].result, &b = together[i].result;
    CHECK(a.ending.status == Ending::Status::finished);
    CHECK(a.ending.reason == b.ending.reason);
    CHECK(bits(a.final_state.q, b.final_state.q));
    CHECK(bits(a.final_state.v, b.final_state.v));
    CHECK(a.ledger.closure() == b.ledger.closure());
    CHECK(a.work.rhs == b.work.rhs);
    CHECK(!apart[i].numbers.empty());
    CHECK(bits(apart[i].numbers, together[i].numbers));
  }
}

TEST_CASE("observation changes no digit, and a snapshot taken during observation continues the run",
          "[library]") {
  struct Case {
    const char *formulation, *key, *value;
  };
  for (const auto& c :
       {Case{"penalty", "penalty.integrator", "adams_bashforth_moulton"},
        Case{"penalty", "penalty.integrator", "dopri5"}, Case{"nonsmooth", "nonsmooth.scheme", "moreau-jean"},
        Case{"nonsmooth", "nonsmooth.scheme", "event-driven"}}) {
    INFO(c.formulation << " " << c.value);
    auto scene = read_scene(test::flores());
    scene.set(c.key, c.value);
    Simulation alone(scene, c.formulation), watched(scene, c.formulation);
    const auto plain = alone.run({.until = 0.2});

    test::Listener listener;
    listener.want = {.forces = true, .samples = true};
    listener.on_sample = [](std::size_t, double, double) {};
    Forces f;
    std::vector<double> q(9), v(9);
    std::optional<Snapshot> midway;
    listener.on_step = [&](const Step& step) {
      const double middle = 0.5 * (step.t0 + step.t1);
      step.forces(middle, f);
      step.add_impulse(step.t0, middle, f);
      step.state(middle, q, v);
      if (!midway && step.t1 > 0.1) midway = watched.snapshot();
    };
    const auto seen = watched.run({.until = 0.2, .observers = {&listener}});
    REQUIRE(!plain.events.empty());
    CHECK(plain.final_state.q == seen.final_state.q);
    CHECK(plain.final_state.v == seen.final_state.v);
    CHECK(plain.work.rhs == seen.work.rhs);
    CHECK(plain.events.size() == seen.events.size());
    REQUIRE(midway);
    CHECK(midway->t > 0.1);
    Simulation later(scene, c.formulation);
    later.restore(*midway);
    const auto rest = later.run({.until = 0.2});
    CHECK(rest.final_state.q == plain.final_state.q);
    CHECK(rest.final_state.v == plain.final_state.v);
  }
}

TEST_CASE("access to forces that were not requested is an error", "[library]") {
  Simulation simulation(read_scene(test::flores()), "penalty");
  test::Listener listener;
  Forces f;
  listener.on_step = [&](const Step& step) {
    CHECK_THROWS_AS(step.forces(step.t1, f), std::logic_error);
    CHECK_THROWS_AS(step.add_impulse(step.t0, step.t1, f), std::logic_error);
    CHECK_THROWS_AS(step.before(), std::logic_error);
    CHECK_THROWS_AS(step.within(), std::logic_error);
  };
  simulation.run({.until = 1e-3, .observers = {&listener}});
  listener.want = {.forces = true};
  listener.on_step = [&](const Step& step) {
    Forces unshaped, sum;
    step.forces(step.t1, unshaped);
    CHECK(unshaped.elements.size() == simulation.layout().forces.size());
    sum.add(1, step.before());
    CHECK(sum.acceleration.size() == unshaped.acceleration.size());
  };
  simulation.run({.until = 2e-3, .observers = {&listener}});
}

TEST_CASE("a scene in code is refused under the same rules as a file", "[library]") {
  Scene scene = read_scene(test::flores());
  const auto refused = [&](const char* formulation = "penalty") {
    try {
      Simulation simulation(scene, formulation);
    } catch (const ModelError& e) {
      return e.key;
    }
    return std::string("nothing");
  };
  CHECK(refused() == "nothing");
  auto& m = scene.mechanism;
  SECTION("mass") {
    m.bodies[1].mass = -1;
    CHECK(refused() == "bodies.rod.mass");
  }
  SECTION("not a number") {
    m.bodies[1].inertia = NAN;
    CHECK(refused() == "bodies.rod.inertia");
  }
  SECTION("body") {
    std::get<RevoluteJoint>(m.joints[1]).between = {0, 3};
    CHECK(refused() == "joints.big_end.between");
  }
  SECTION("surface") {
    std::get<RevoluteJoint>(m.joints[2]).clearance->surface = 1;
    CHECK(refused() == "joints.gudgeon.surface");
  }
  SECTION("no surface") {
    std::get<RevoluteJoint>(m.joints[2]).clearance->surface = -1;
    CHECK(refused() == "joints.gudgeon.surface");
  }
  SECTION("bearing smaller than the clearance") {
    std::get<RevoluteJoint>(m.joints[2]).clearance->bearing_radius = 1e-4;
    CHECK(refused().starts_with("joints.gudgeon"));
  }
  SECTION("drive") {
    std::get<SpeedDrive>(m.drives[0]).joint = 9;
    CHECK(refused() == "drives.motor.joint");
  }
  SECTION("duplicate name") {
    m.bodies[2].name = "rod";
    CHECK(refused() != "nothing");
  }
  SECTION("a body without a name") {
    m.bodies[2].name = "";
    CHECK(refused() != "nothing");
  }
  SECTION("the caller sets the length of the run") {
    scene.run.duration = 0;
    CHECK(refused() == "nothing");
  }
  SECTION("a start of another mechanism") {
    CHECK_THROWS_AS(Simulation(scene, "penalty", {.start = State{0, {0, 0, 0}, {0, 0, 0}, {}}}), ModelError);
    auto start = assemble(m, RunOptions::Start::assembled);
    start.z = {1};  // no drive of this mechanism has a lag
    CHECK_THROWS_AS(Simulation(scene, "penalty", {.start = start}), ModelError);
    CHECK_THROWS_AS(Simulation(scene, "nonsmooth", {.start = start}), ModelError);
  }
}

TEST_CASE("the code of docs/reference/library.md is compiled", "[library]") {
  std::string examples;
  for (const auto& entry : fs::directory_iterator(test::source_folder() / "verification/library"))
    examples += even(test::file_text(entry.path())) + " ";
  bool within = false;
  std::string block, language;
  int count = 0;
  for (const auto& line :
       test::lines_of(test::file_text(test::source_folder() / "docs/reference/library.md"))) {
    if (!line.starts_with("```")) {
      if (within) block += line + "\n";
      continue;
    }
    if (!within) language = line.substr(3);
    if (within && (language == "cpp" || language == "cmake")) {
      ++count;
      INFO(block);
      auto wanted = even(block);
      if (!wanted.empty() && wanted.back() == ' ') wanted.pop_back();
      CHECK(examples.find(wanted) != examples.npos);
    }
    within = !within;
    block.clear();
  }
  CHECK(count >= 6);
}
