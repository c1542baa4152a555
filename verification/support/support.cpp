#include "verification/support/support.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "facade/run_folder.hpp"
#include "mechanism/scene.hpp"

namespace freeplay::test {

std::filesystem::path source_folder() {
  const std::filesystem::path folder = FREEPLAY_SOURCE_DIR;
  std::error_code ignored;
  if (!std::filesystem::is_directory(folder / "verification/scenes", ignored))
    throw SceneError(
        fmt::format("{}: the folder that this program was built from is gone, and with it the scenes that "
                    "claims are judged on; verify and extremes run from a build in its source folder",
                    folder.string()));
  return folder;
}

std::vector<std::filesystem::path> all_scenes() {
  std::vector<std::filesystem::path> list;
  for (const auto* folder : {"cases", "verification/scenes", "src/cli/templates"})
    for (const auto& entry : std::filesystem::recursive_directory_iterator(source_folder() / folder))
      if (entry.path().extension() == ".toml" &&
          file_text(entry.path()).find("[bodies.") != std::string::npos)
        list.push_back(entry.path());
  return list;
}

Result simulate(const Scene& scene, Family family) {
  return run_scene(scene, {.formulation = name_of(family), .most_events = 1'000'000});
}

double kinetic_energy(const Scene& scene, const State& state) {
  return System(scene.mechanism).kinetic(state.v.data());
}

ContactFacts first_contact(const Scene& scene) { return System(scene.mechanism).contact_facts(0); }

std::vector<int> redundant_rows(const Scene& scene) {
  const State start = assemble(scene.mechanism, scene.run.start);
  return freeplay::redundant_rows(System(scene.mechanism), start.q);
}

ContactEvent touch(const Result& run, std::size_t i) {
  const auto list = touches(run);
  if (i < list.size()) return list[i];
  throw std::runtime_error(fmt::format("touch {} is missing: the {} run made {} until {:.6g} s{}", i + 1,
                                       run.formulation, list.size(), run.t_end,
                                       run.ending.reason.empty() ? "" : " (" + run.ending.reason + ")"));
}

double observed_order(const std::vector<double>& x, const std::vector<double>& y) {
  // Least squares through all points.
  double sx = 0, sy = 0, sxx = 0, sxy = 0;
  const double n = static_cast<double>(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double a = std::log(x[i]), b = std::log(y[i]);
    sx += a;
    sy += b;
    sxx += a * a;
    sxy += a * b;
  }
  return (n * sxy - sx * sy) / (n * sxx - sx * sx);
}

std::string file_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw std::runtime_error(file.string() + ": cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

TemporaryFolder::TemporaryFolder() {
  // Inside the build folder: tests write nothing outside the checkout.
  std::string pattern = FREEPLAY_BINARY_DIR "/test-XXXXXX";
  path_ = std::filesystem::canonical(mkdtemp(pattern.data()));
}
TemporaryFolder::~TemporaryFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

Outcome freeplay(const std::string& arguments) {
  TemporaryFolder folder;
  const auto out = folder.path() / "out", err = folder.path() / "err";
  const auto command = fmt::format("{}/freeplay {} >{} 2>{} </dev/null", FREEPLAY_BINARY_DIR, arguments,
                                   out.string(), err.string());
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), file_text(out), file_text(err)};
}

pid_t start_freeplay(const std::vector<std::string>& words, void (*prepare)()) {
  std::vector<std::string> all{std::string(FREEPLAY_BINARY_DIR) + "/freeplay"};
  all.insert(all.end(), words.begin(), words.end());
  std::vector<char*> pointers;
  for (auto& word : all) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  const pid_t id = fork();
  if (id < 0) throw std::runtime_error("no process");
  if (id == 0) {
    const int nowhere = open("/dev/null", O_RDWR);
    for (const int stream : {0, 1, 2}) dup2(nowhere, stream);
    if (prepare) prepare();
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  return id;
}

Surface steel(double restitution) {
  Surface surface;
  surface.name = "steel";
  surface.young = 207e9;
  surface.poisson = 0.3;
  surface.restitution = restitution;
  return surface;
}

Scene row_of_four_bars(int count, double clearance) {
  Scene scene;
  auto& m = scene.mechanism;
  m.gravity = {0, -9.81};
  m.surfaces.push_back(steel(0.5));
  m.surfaces.back().friction = 0.05;
  const auto link = [&](const std::string& name, Vec2 at, double angle, Vec2 velocity, double omega) {
    m.bodies.push_back({name, 1.0, 1.0 / 12, at, angle, velocity, omega});
    return static_cast<int>(m.bodies.size()) - 1;
  };
  const auto pin = [&](const std::string& name, int i, int j, Vec2 si, Vec2 sj, bool clearance_joint) {
    RevoluteJoint joint{name, {i, j}, {si, sj}, {}};
    if (clearance_joint) joint.clearance = Clearance{clearance, 20 * clearance, 0, std::nullopt, -1};
    m.joints.push_back(joint);
  };
  const double up = M_PI / 2;
  int before = link("upright0", {0, 0.5}, up, {-0.5, 0}, 1);
  pin("foot0", ground, before, {0, 0}, {-0.5, 0}, false);
  for (int k = 1; k <= count; ++k) {
    const auto n = std::to_string(k);
    const int upright = link("upright" + n, {double(k), 0.5}, up, {-0.5, 0}, 1);
    const int coupler = link("coupler" + n, {k - 0.5, 1}, 0, {-1, 0}, 0);
    pin("foot" + n, ground, upright, {double(k), 0}, {-0.5, 0}, false);
    pin("front" + n, upright, coupler, {0.5, 0}, {0.5, 0}, false);
    pin("back" + n, before, coupler, {0.5, 0}, {-0.5, 0}, clearance > 0);
    before = upright;
  }
  scene.run.duration = 0.1;
  scene.run.start = RunOptions::Start::given;
  scene.nonsmooth.step = 1e-4;
  return scene;
}

}  // namespace freeplay::test
