// Attractors with Lyapunov exponents computed in shards, and refusals of work that cannot be divided.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

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

std::string rotor_study() {
  return fmt::format(
      "scene = \"{}\"\n[axes.angle]\nkey = \"bodies.rotor.angle\"\nvalues = [-0.5, 0.5]\n[axes.speed]\n"
      "key = \"bodies.rotor.angular_velocity\"\nvalues = [0, 1]\n[basin]\nsection = \"every 0.5 s\"\n"
      "period = 0.5\ndiscard = 8\nkeep = 4\ncolumns = [\"axle.angle\"]\nexponents = true\n",
      case_scene("bistable-rotor"));
}

}  // namespace

TEST_CASE("attractors with exponents in shards have the tables of one process",
          "[shards][lyapunov]") {
  const test::TemporaryFolder folder;
  const auto place = folder.path().string();
  const bool basin = GENERATE(false, true);
  const std::string verb = basin ? "basin" : "bifurcation";
  write_file(folder.path() / "study.toml", basin ? rotor_study() : ball_study());
  const auto run = [&](const std::string& options) {
    test::succeeded(verb + " " + place + "/study.toml --allow-outside " + options);
  };
  run("-o " + place + "/one");
  for (const char* options : {"--plan 2", "--shard 2/2", "--shard 1/2"})
    run(options + (" -o " + place + "/two"));
  run("--merge " + place + "/two");
  run("-o " + place + "/two");
  for (const char* end : {".csv", ".json"}) {
    const auto one = test::file_text(folder.path() / "one" / (verb + end));
    CHECK_THAT(one, Contains("exponent"));
    CHECK(test::file_text(folder.path() / "two" / (verb + end)) == one);
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
