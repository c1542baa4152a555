// Names of the greatest permitted length pass through every command that reads result files; longer
// ones are refused at their place.
#include "values/name_length.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::StartsWith;

namespace {

/// A pendulum with clearance, and discs in a group that touch each other, a wall and a second
/// group.
std::string scene(std::size_t length) {
  const auto name = [&](char letter) { return std::string(length, letter); };
  return fmt::format(R"(gravity = [0, -9.81]
[bodies.{body}]
mass = 1
inertia = 0.03
position = [0.3, 0]
[groups.{group}]
radius = 0.01
mass = 0.01
surface = "{surface}"
positions = [[1, 0.0101], [1.03, 0.0101]]
walls = [[0.9, 0], [1.5, 0]]
[groups.{other}]
radius = 0.01
mass = 0.01
surface = "{surface}"
positions = [[1.1, 0.0101]]
touches = ["{group}"]
[joints.{joint}]
type = "revolute"
between = ["ground", "{body}"]
at = [[0, 0], [-0.3, 0]]
clearance = 1e-4
bearing_radius = 1e-2
surface = "{surface}"
[loads.{load}]
type = "force"
body = "{body}"
force = [0, 0.1]
[surfaces.{surface}]
young = 2e11
poisson = 0.3
restitution = 0.5
[run]
duration = 0.02
[instruments.{sensor}]
body = "{body}"
axis = [1, 0]
bandwidth = 500
sampling = 4000
)",
                     fmt::arg("body", name('b')), fmt::arg("group", name('g')), fmt::arg("other", name('o')),
                     fmt::arg("joint", name('j')), fmt::arg("load", name('l')),
                     fmt::arg("surface", name('s')), fmt::arg("sensor", name('i')));
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
