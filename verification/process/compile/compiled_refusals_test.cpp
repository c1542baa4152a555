// Compiled mechanisms where they must not be used: pivots that degenerate, tables of time, objects
// of another user or of another structure. The expected digits are those of the general evaluation.
#include <unistd.h>

#include "compile/compile.hpp"
#include "compile/compiled_object.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/files/digest.hpp"
#include "numerics/saddle_point.hpp"
#include "verification/support/compiled_runs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
namespace fs = std::filesystem;

namespace {

/// A slider-crank without a drive, whose rod is as long as its crank: the rows are dependent where
/// the crank is at 90°.
const std::string equal_lengths =
    test::body("crank", 1, 0.1) + test::body("rod", 2, 0.3) + test::body("slider", 3, 0.2) +
    test::pin("main", "ground", "crank") + test::pin("pin", "crank", "rod", {0.1, 0}, {-0.05, 0}) +
    test::pin("gudgeon", "rod", "slider", {0.05, 0}) + test::guide("guide", "ground", "slider") +
    test::run_for(0.1, "start = \"given\"\n");

State at_crank_angle(double angle) {
  const double x = 0.1 * std::cos(angle), y = 0.1 * std::sin(angle);
  return {0, {0, 0, angle, 1.5 * x, 0.5 * y, -angle, 2 * x, 0, 0}, std::vector<double>(9), {}};
}

/// A pendulum.
const Scene& bar() {
  static const auto scene =
      parse_scene("gravity = [0, -9.81]\n" + test::body("bar", 1, 0.1) +
                      test::pin("pin", "ground", "bar", {}, {0.5, 0.1}) + test::run_for(1),
                  "bar");
  return scene;
}

TracedSystem traced_of(const Scene& scene, const System& system) {
  return trace_system(system, assemble(scene.mechanism, scene.run.start), {});
}

}  // namespace

TEST_CASE("a torque table of time: steps across its knots take the mean, also in compiled runs",
          "[compiled]") {
  const test::CompilerCache cache;
  // The pulse of 1 N m lasts 1 ms, after the middle of a step of 5 ms. The rotor of 0.1 kg m² gains
  // 0.01 rad/s, and none if the table is evaluated at the middle.
  auto scene = parse_scene(
      test::body("rotor", 1, 0.1) + test::pin("pin", "ground", "rotor") +
          test::drive("motor", "pin",
                      "against = \"time\"\n"
                      "torque_table = [[0.0131, 0.0], [0.0131001, 1.0], [0.0141, 1.0], [0.0141001, 0.0]]\n") +
          test::run_for(0.05, "start = \"given\"\n") + "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 5e-3\n",
      "pulse");
  const auto compiled = test::run_as(scene, "nonsmooth", Compile::always);
  CHECK(compiled.compiled.used);
  CHECK(compiled.compiled.general_parts.empty());
  // One step of ten has knots; it evaluates forces twice or three times.
  CHECK(compiled.compiled.refused >= 1);
  CHECK(compiled.compiled.refused <= 4);
  CHECK(compiled.final_state.v[2] == Approx(0.01).epsilon(1e-9));
  CHECK(compiled.final_state.v == test::run_as(scene, "nonsmooth", Compile::never).final_state.v);
}

TEST_CASE("compiled steps are not refused for a body whose angle stays 0", "[compiled]") {
  const test::CompilerCache cache;
  const auto scene = parse_scene(
      "gravity = [0, -9.81]\n" + test::body("ball", 1, 0.1, "position = [0, 0.2]\n") +
          test::plane("table", "ground", "ball", 0.05) + test::surface("s", 0.5) +
          test::run_for(0.4, "start = \"given\"\n") + "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-3\n",
      "ball");
  const auto compiled = test::run_as(scene, "nonsmooth", Compile::always),
             general = test::run_as(scene, "nonsmooth", Compile::never);
  CHECK(compiled.compiled.used);
  CHECK(compiled.compiled.refused == 0);
  test::check_same_run(compiled, general);
}

TEST_CASE("pivots that degenerate leave the linear system to the general path", "[compiled]") {
  const test::CompilerCache cache;
  const auto scene = parse_scene(equal_lengths, "equal lengths");
  System system(scene.mechanism);
  const auto traced = trace_system(system, at_crank_angle(1), {});
  REQUIRE(traced.solves);
  auto functions = test::compiled(traced);
  system.compiled().attach(functions);
  const double pi = std::acos(-1.0);
  for (const double angle : {1.0, 1.5, 0.5 * pi - 1e-9}) {
    INFO(angle);
    const auto at = at_crank_angle(angle);
    auto e = system.make_evaluation();
    system.place(0, at.q.data(), e);
    std::vector<double> factors(static_cast<std::size_t>(traced.factors)), ratios(100);
    const double* in[] = {e.G.data()};
    double* out[] = {factors.data(), ratios.data()};
    const bool degenerate = angle > 1.55;
    CHECK((functions.solve.factor(functions.constants.data(), in, out) != 0) == degenerate);
    SaddlePoint general(system.mass(), system.pattern()), fast(system.mass(), system.pattern());
    fast.use(system.compiled().solve());
    const std::vector<double> f(9, 1.0), r(e.phi.size(), 0.5);
    std::vector<double> a[2], lambda[2];
    for (const int i : {0, 1}) {
      auto& saddle = i == 0 ? general : fast;
      a[i].resize(9);
      lambda[i].resize(r.size());
      REQUIRE(saddle.factor(e.G.data()));
      saddle.solve(f.data(), r.data(), a[i].data(), lambda[i].data());
    }
    CHECK(a[0] == a[1]);
    CHECK(lambda[0] == lambda[1]);
    CHECK(general.singular() == fast.singular());
  }
}

TEST_CASE("an object of another structure under the name of this one is not called", "[compiled]") {
  const test::CompilerCache cache;
  const auto crank = parse_scene(equal_lengths, "crank");
  System pendulum_system(bar().mechanism), crank_system(crank.mechanism);
  const auto of_bar = traced_of(bar(), pendulum_system);
  const auto of_crank = trace_system(crank_system, at_crank_angle(1), {});
  REQUIRE(of_bar.object.functions() == of_crank.object.functions());
  REQUIRE(compiled_object(of_bar.object.text(), of_bar.object.functions()).reason.empty());
  const auto first = cache.objects();
  REQUIRE(first.size() == 1);
  REQUIRE(compiled_object(of_crank.object.text(), of_crank.object.functions()).reason.empty());
  for (const auto& file : cache.objects())
    if (file != first[0]) fs::rename(file, first[0]);
  const auto object = compiled_object(of_bar.object.text(), of_bar.object.functions());
  REQUIRE(object.reason.empty());
  CHECK_FALSE(object.cached);
  auto functions = of_bar.functions(object.table);
  functions.object = object.library;
  const auto start = assemble(bar().mechanism, bar().run.start);
  CHECK(differing_quantities(pendulum_system, functions, start, {}) == 0);
  CHECK(compiled_object(of_bar.object.text(), of_bar.object.functions()).cached);
}

TEST_CASE("objects and cache folders of another user are not used", "[compiled]") {
  if (geteuid() != 0) return;  // only root can give files away
  const test::CompilerCache cache;
  const System system(bar().mechanism);
  const auto traced = traced_of(bar(), system);
  const auto get = [&] { return compiled_object(traced.object.text(), traced.object.functions()); };
  REQUIRE(get().reason.empty());
  CHECK(get().cached);
  REQUIRE(chown(cache.objects()[0].c_str(), 65534, 65534) == 0);
  CHECK_FALSE(get().cached);
  CHECK(get().cached);  // the new one
  REQUIRE(chown((cache.folder.path() / "freeplay").c_str(), 65534, 65534) == 0);
  CHECK(get().reason.find("belongs to another user") != std::string::npos);
  CHECK_FALSE(get().library);
}

namespace {

/// A `cc` that does its work and then something else, in a folder that is first in PATH. The number of
/// its compilations is the number of lines of the file `log`.
class OtherCompiler {
 public:
  explicit OtherCompiler(const std::string& then) {
    std::ofstream(place_.path() / "cc")
        << "#!/bin/sh\nPATH=" << std::getenv("PATH") << "\ncase $1 in -v) exec cc -v;; esac\necho >>"
        << place_.path().string() << "/log\ncc \"$@\" || exit 1\n" + then + "\n";
    fs::permissions(place_.path() / "cc", fs::perms::owner_all);
    path_.emplace("PATH", (place_.path().string() + ":" + std::getenv("PATH")).c_str());
  }
  long compilations() const {
    const auto log = place_.path() / "log";
    return fs::exists(log) ? std::ranges::count(test::file_text(log), '\n') : 0;
  }

 private:
  test::TemporaryFolder place_;
  std::optional<test::Environment> path_;
};

const char* const one_function =
    "static int f(const double *k, const double *const *in, double *const *out) { out[0][0] = k[0]; "
    "return 0; }\n"
    "int (*const freeplay_functions[])(const double *, const double *const *, double *const *) = {f, 0};\n";

}  // namespace

TEST_CASE("an object that the compiler left incomplete is not loaded", "[compiled]") {
  const test::CompilerCache cache;
  // The loader maps pages beyond the end of such a file; reading them would end this process by SIGBUS.
  const OtherCompiler half("truncate -s 5000 object");
  const auto object = compiled_object(one_function, 1);
  CHECK_FALSE(object.library);
  CHECK(object.reason == "cc left an incomplete object");
  CHECK(cache.objects().empty());
}

TEST_CASE("a failed compilation is not repeated by the process", "[compiled]") {
  const test::CompilerCache cache;
  const OtherCompiler failing("exit 1");
  for (const int i : {0, 1}) {
    INFO(i);
    const auto object = compiled_object(one_function, 1);
    CHECK_FALSE(object.library);
    CHECK(object.reason.starts_with("cc failed"));
    CHECK(failing.compilations() == 1);
  }
}

TEST_CASE("sealed objects that cannot be loaded are compiled again", "[compiled]") {
  const test::CompilerCache cache;
  REQUIRE(compiled_object(one_function, 1).library);
  const auto file = cache.objects().at(0);
  constexpr std::size_t seal = 32;
  auto whole = test::file_text(file);
  whole.resize(whole.size() - seal);
  auto foreign = whole;
  foreign[18] ^= 1;  // e_machine
  for (const auto& bytes : {whole.substr(0, 5000), foreign, std::string("not an object")}) {
    std::ofstream(file, std::ios::binary) << bytes << digest(bytes);
    CHECK_FALSE(compiled_object(one_function, 1, {}, false).library);
    const auto again = compiled_object(one_function, 1);
    CHECK(again.library);
    CHECK_FALSE(again.cached);
    CHECK(compiled_object(one_function, 1).cached);
  }
}

TEST_CASE("an empty entry in PATH does not execute tools of the working folder", "[compiled]") {
  const test::CompilerCache cache;
  const test::TemporaryFolder folder;
  for (const char* tool : {"cc", "as", "ld", "collect2"}) {
    std::ofstream(folder.path() / tool)
        << "#!/bin/sh\n>" << (folder.path() / "executed").string() << "\nexit 1\n";
    fs::permissions(folder.path() / tool, fs::perms::owner_all);
  }
  const test::Environment path("PATH", (":" + std::string(std::getenv("PATH"))).c_str());
  const auto before = fs::current_path();
  fs::current_path(folder.path());
  const auto done = test::freeplay("run " + test::flores().string() +
                                   " --formulation penalty --compile --no-figures --set run.revolutions=0.02 "
                                   "--set run.discard=0 -o out");
  fs::current_path(before);
  CHECK(done.status == 0);
  CHECK(test::file_text(folder.path() / "out/run.json").find("\"used\": true") != std::string::npos);
  CHECK_FALSE(fs::exists(folder.path() / "executed"));
}

TEST_CASE("a mechanism whose compilation would take too long is not compiled, and the result says so",
          "[compiled]") {
  const test::CompilerCache cache;
  // 3,000 springs have about 370,000 operations: 110 s, more than half the time limit of 120 s.
  auto text = test::body("b", 1, 0.1, "position = [0.1, 0.2]\n") + test::run_for(1e-4, "start = \"given\"\n");
  for (int i = 0; i < 3000; ++i)
    text += test::spring(fmt::format("s{}", i), "ground", "b", {1.0 * i, 1}, {1.0 / (i + 2), 0.1}, 1, 1,
                         "damping = 1\n");
  const OtherCompiler never("");
  CompiledStructures structures;
  for (const bool study : {false, true, true}) {
    Simulation simulation(parse_scene(text, "springs"), "penalty",
                          {.compile = Compile::always, .structures = study ? &structures : nullptr});
    const auto made = simulation.run().compiled;
    CHECK_FALSE(made.used);
    CHECK(made.reason.find("more than half the time limit of the compiler (120 s)") != std::string::npos);
  }
  CHECK(structures.any());  // the failure is known
  CHECK(never.compilations() == 0);
}

TEST_CASE("a run compiles only if its rest can save the time", "[compiled]") {
  const test::CompilerCache cache;
  const System system(bar().mechanism);
  const double seconds = compile_seconds(traced_of(bar(), system).object);
  const auto start = assemble(bar().mechanism, bar().run.start);
  const auto compiled = [&](double worth) {
    System own(bar().mechanism);
    return *compile_system(own, start, {}, {}, TracedFor::any, nullptr, false, worth);
  };
  const auto refused = compiled(0.9 * seconds);
  CHECK_FALSE(refused.used);
  CHECK(refused.reason.find("more than the rest of the run can save") != std::string::npos);
  CHECK(compiled(1.1 * seconds).used);
  CHECK(compiled(0.9 * seconds).used);  // from the cache
}
