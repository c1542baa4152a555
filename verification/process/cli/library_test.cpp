// The library as a user has it: installed, found from a project outside the source tree, with its
// public headers alone, several simulations in threads; and the program that is installed with it.
#include <sys/wait.h>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <thread>

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

/// The build, installed into a folder, and the examples built against it as a user builds them; either is
/// made once, when it is needed.
class Installed {
 public:
  static const Installed& get() {
    static const Installed once;
    return once;
  }
  fs::path folder() const { return folder_.path(); }
  fs::path prefix() const { return folder() / "prefix"; }
  std::string program() const { return (prefix() / "bin/freeplay").string(); }
  std::string example(const char* name) const {
    static const bool built = build_examples();
    REQUIRE(built);
    return (folder() / "examples/build" / name).string();
  }

 private:
  Installed() {
    quiet(folder(), fmt::format("'{}' --install '{}' --prefix prefix", FREEPLAY_CMAKE, FREEPLAY_BINARY_DIR));
  }
  bool build_examples() const {
    fs::copy(test::source_folder() / "verification/library", folder() / "examples");
    quiet(folder() / "examples",
          fmt::format("'{0}' -G Ninja -S . -B build -DCMAKE_PREFIX_PATH='{1}' -DCMAKE_CXX_COMPILER='{2}' "
                      "-DCMAKE_EXE_LINKER_FLAGS='{3}' && '{0}' --build build",
                      FREEPLAY_CMAKE, prefix().string(), FREEPLAY_CXX, FREEPLAY_LINK_FLAGS));
    return true;
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

TEST_CASE("the code of docs/reference/library.md is that of verification/library", "[library]") {
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

TEST_CASE("external programs print the events of the command line program", "[library][slow]") {
  const auto& installed = Installed::get();
  const auto place = installed.folder() / "events";
  fs::create_directories(place);
  fs::copy_file(test::flores(), place / "scene.toml", fs::copy_options::overwrite_existing);
  const auto rows_of = [&](const std::string& options) {
    quiet(place, fmt::format("{} run scene.toml --set joints.gudgeon.clearance=1e-3 -o out {}",
                             installed.program(), options));
    auto rows = test::lines_of(test::file_text(place / "out/events.csv"));
    rows.erase(rows.begin());
    return rows;
  };
  // The second that the examples run is 10/3 revolutions at 200 rpm.
  const std::string second = "--set run.revolutions=3.3333333333333335 --formulation ";
  for (const std::string formulation : {"penalty", "nonsmooth"}) {
    CAPTURE(formulation);
    const auto printed =
        test::lines_of(quiet(place, fmt::format("{} scene.toml {} 1.0 joints.gudgeon.clearance=1e-3",
                                                installed.example("events"), formulation)));
    const auto rows = rows_of(second + formulation);
    REQUIRE(rows.size() == printed.size());
    REQUIRE(rows.size() > 20);
    for (std::size_t i = 0; i < rows.size(); ++i) CHECK(numbers(printed[i]) == numbers(rows[i]));
    if (formulation == "penalty") continue;
    const auto ten_lines = test::lines_of(quiet(place, installed.example("main")));
    REQUIRE(rows.size() == ten_lines.size());
    for (std::size_t i = 0; i < rows.size(); ++i) CHECK(ten_lines[i] == as_printed(rows[i]));
    // The whole scene, whose run continues: the results of the first second are its beginning.
    const auto whole = rows_of("--formulation nonsmooth");
    REQUIRE(whole.size() > rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) CHECK(whole[i] == rows[i]);
  }
}

TEST_CASE("an external program: mechanism in code, observers, threads, snapshots and errors",
          "[library][slow]") {
  const auto& installed = Installed::get();
  const auto program = installed.example("pendulum");
  const auto done = shell(installed.folder() / "examples", program);
  INFO(done.said);
  CHECK(done.status == 0);
  CHECK_THAT(done.said, !Contains("FAILED"));
}

TEST_CASE("an external program: ranges within clearances agree with the closed form", "[library][slow]") {
  const auto& installed = Installed::get();
  const auto done = shell(installed.folder() / "examples", installed.example("play"));
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
