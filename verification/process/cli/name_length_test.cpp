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
