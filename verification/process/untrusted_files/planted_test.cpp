// Links, special files and other names in a received or shared folder: nothing is written through
// them, and nothing waits for them.
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "io/files/input_file.hpp"
#include "verification/process/untrusted_files/inputs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace std::string_literals;
using Catch::Matchers::Contains;

namespace {

const std::string run = "run scene.toml --formulation nonsmooth -o ";

/// A sandbox with a scene, and a folder with a file outside it, to which links may lead.
struct Place : test::Sandbox {
  Place() {
    make_folder(elsewhere());
    write_file(elsewhere() / "kept", "kept\n");
    add("scene.toml", test::rig("\"rig\""));
  }
  void link(const std::filesystem::path& name, const std::filesystem::path& target) const {
    make_folder(at(name).parent_path());
    std::filesystem::remove(at(name));
    std::filesystem::create_symlink(target, at(name));
  }
  std::filesystem::path elsewhere() const { return folder.path() / "elsewhere"; }
  /// Whether no file was added to, or removed from, the folder that links lead to.
  bool elsewhere_untouched() const {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(elsewhere()))
      count += entry.path().filename() == "kept" ? 1 : 100;
    return count == 1;
  }
  bool is_link(const std::filesystem::path& name) const {
    return std::filesystem::is_symlink(std::filesystem::symlink_status(at(name)));
  }
};

}  // namespace

TEST_CASE("planted links in a result folder are replaced or refused, never followed", "[security]") {
  for (const auto* name : {"run.json.partial", "run.json", "trajectory.csv.partial", "trajectory.csv",
                           "events.csv", "signals.csv.partial", "run.checkpoint", "run.checkpoint.partial"}) {
    CAPTURE(name);
    const Place place;
    const auto file = std::filesystem::path("out") / name;
    place.link(file, place.bait.victim);
    CHECK(place.run(run + "out").status == 0);
    CHECK_FALSE(place.is_link(file));
  }
  for (const auto* name : {"penalty", "nonsmooth", "ideal", "figures"}) {
    CAPTURE(name);
    const Place place;
    for (const auto* other : {"reaction_a.pdf", "run.json"})
      write_file(place.elsewhere() / other, "also mine\n");
    place.link(std::filesystem::path("out") / name, place.elsewhere());
    const auto outcome = place.run("compare scene.toml -o out");
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Contains(fmt::format("out/{}: is a link", name)));
    for (const auto* other : {"reaction_a.pdf", "run.json"}) {
      CHECK(read_file(place.elsewhere() / other, 100) == "also mine\n");
      remove_file(place.elsewhere() / other);
    }
    CHECK(place.elsewhere_untouched());
  }
}

TEST_CASE("figures replace planted links, and leftover files are removed", "[security][figures]") {
  const Place place;
  REQUIRE(place.run("laws scene.toml -o laws").status == 0);
  for (const auto* suffix : {".pdf", ".png", ".gp", ".dat"})
    place.link(std::string("laws/figures/friction_laws") + suffix, place.bait.victim);
  place.link("laws/figures/friction_laws.partial", place.elsewhere());
  make_folder(place.at("laws/figures/impact_loops.partial/deep"));
  CHECK(place.run("figures laws").status == 0);
  CHECK(place.elsewhere_untouched());
  for (const auto& entry : std::filesystem::directory_iterator(place.at("laws/figures"))) {
    CAPTURE(entry.path().string());
    CHECK_FALSE(place.is_link(entry.path()));
    CHECK(entry.path().extension() != ".partial");
  }
}

TEST_CASE("a style that is a link is read at its target, and remains", "[security][style]") {
  const Place place;
  REQUIRE(place.run("laws scene.toml -o laws").status == 0);
  place.link("laws/figures/style.toml", place.bait.victim);  // which is no style
  CHECK(place.run("figures laws").status == 2);
  CHECK(place.is_link("laws/figures/style.toml"));
}

TEST_CASE("a folder given by the user may be reached through links", "[security]") {
  const Place place;
  place.link("way", place.elsewhere());
  for (const std::string inner : {"/out", ""}) {
    CHECK(place.run(run + "way" + inner).status == 0);
    CHECK(std::filesystem::exists(place.elsewhere().string() + inner + "/run.json"));
  }
}

TEST_CASE("a file with a second hard link is not written", "[security]") {
  const Place place;
  make_folder(place.at("out"));
  for (const auto* name : {"out/run.json.partial", "out/trajectory.csv", "out/trajectory.csv.partial"})
    std::filesystem::create_hard_link(place.bait.victim, place.at(name));
  CHECK(place.run("run scene.toml --formulation penalty -o out").status == 0);
  // A file to be resumed must belong to this run.
  std::filesystem::create_hard_link(place.bait.victim, place.at("out/more.csv.partial"));
  OutputFile more(place.at("out/more.csv"), true);
  CHECK_THROWS_AS(more.go_on_at(2), OutputError);
  CHECK(place.bait.untouched());
}

TEST_CASE("a planted database is refused", "[security][study]") {
  for (const auto* name : {"sweep.db", "sweep.db-wal", "sweep.db-journal", "sweep.db-shm"}) {
    CAPTURE(name);
    const Place place;
    place.add("study.toml",
              "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\n"
              "revolutions = 1\nstarts = 1\n");
    place.link(std::filesystem::path("out") / name, place.bait.victim);
    const auto outcome = place.run("sweep study.toml -o out");
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Contains("is a symbolic link"));
  }
}

TEST_CASE("special files are refused at once wherever a file is read", "[security]") {
  const Place place;
  const auto make_fifo = [&](const char* name) {
    make_folder(place.at(name).parent_path());
    REQUIRE(mkfifo(place.at(name).c_str(), 0600) == 0);
  };
  make_fifo("fifo");
  make_folder(place.at("dir"));
  const int socket_descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto here = std::filesystem::current_path();
  REQUIRE(chdir(place.bait.folder.c_str()) == 0);  // the path of a socket is short
  std::string("socket").copy(address.sun_path, sizeof address.sun_path - 1);
  const bool bound = bind(socket_descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  REQUIRE(chdir(here.c_str()) == 0);
  REQUIRE(bound);
  const std::pair<std::string, const char*> files[] = {
      {"fifo", "a FIFO"},
      {"dir", "a folder"},
      {"socket", "a socket"},
      {"/dev/zero", "a device"},
      {"/dev/tty", ""}};  // where there is none, another message
  for (const auto& [name, what] : files)
    for (const char* command :
         {"check {}", "run {} --formulation penalty -o out", "sweep {} -o out", "validate {} -o out",
          "validate scene.toml --data {} --set run.revolutions=1.1 -o out", "run --from {} -o out"}) {
      if (std::string(command).starts_with("run --from") && name == "dir")
        continue;  // the folder of a run is a valid argument
      const auto outcome = place.run(fmt::format(fmt::runtime(command), name));
      CAPTURE(command, name, outcome.err);
      CHECK(outcome.status == 2);
      CHECK_THAT(outcome.err, Contains(what));
      CHECK_FALSE(std::filesystem::exists(place.at("out")));
    }
  close(socket_descriptor);
  // As parts of a result folder, and of a run to resume.
  for (const auto* name : {"results/drift.json", "results/drift.csv", "resumed/run.checkpoint"})
    make_fifo(name);
  CHECK(place.run("figures results").status == 2);
  CHECK(place.run("run --resume resumed").status == 2);
  // And an oversized file: refused by its size, not read.
  place.add("big.toml", "");
  std::filesystem::resize_file(place.at("big.toml"), std::uintmax_t{1} << 40);
  CHECK_THAT(place.run("check big.toml").err, Contains("exceeds 16 MiB"));
}

TEST_CASE("a study refers only to files beside or below it, unless it is trusted", "[security][study]") {
  const Place place;
  const auto outside = place.folder.path() / "outside.toml";
  write_file(outside, test::rig("\"outside\""));
  place.add("studies/below/scene.toml", test::rig("\"below\""));
  place.link("studies/link.toml", outside);
  place.link("studies/inner.toml", "below/scene.toml");
  // No accelerometer of that name: the named files are read, and no run is made.
  const auto said = [&](const std::string& scene, const std::string& more = {}) {
    place.add("studies/study.toml",
              fmt::format("scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"none\"\n", scene));
    const auto outcome = place.run("sweep studies/study.toml -o out" + more);
    CHECK(outcome.status != 0);
    return outcome.err;
  };
  for (const auto& scene : {"../scene.toml"s, "../../outside.toml"s, outside.string(), "link.toml"s,
                            "below/../../scene.toml"s, "/dev/zero"s, "../studies-of-others/scene.toml"s}) {
    CAPTURE(scene);
    CHECK_THAT(said(scene), Contains("studies/study.toml:1:9: scene: ") && Contains("pass --allow-outside"));
  }
  for (const auto& scene : {"below/scene.toml"s, "inner.toml"s, "../studies/inner.toml"s,
                            place.at("studies/below/scene.toml").string()}) {
    CAPTURE(scene);
    CHECK_THAT(said(scene), !Contains("--allow-outside"));
  }
  CHECK_THAT(said(outside.string(), " --allow-outside"), !Contains("is outside"));
}
