// Links, special files and other names in a received or shared folder: nothing is written through
// them, and nothing waits for them.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include "io/files/input_file.hpp"
#include "verification/support/rig.hpp"
#include "verification/process/untrusted_files/inputs.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Place {
  Place() : bait(folder.path()) {
    make_folder(folder.path() / "elsewhere");
    write_file(folder.path() / "elsewhere/kept", "kept\n");
    write_file(bait.folder / "scene.toml", test::rig("\"rig\""));
  }
  void link(const std::filesystem::path& name, const std::filesystem::path& target) const {
    make_folder((bait.folder / name).parent_path());
    std::filesystem::create_symlink(target, bait.folder / name);
  }
  std::filesystem::path elsewhere() const { return folder.path() / "elsewhere"; }
  /// Whether no file was added to, or removed from, the folder that links lead to.
  bool elsewhere_untouched() const {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(elsewhere()))
      count += entry.path().filename() == "kept" ? 1 : 100;
    return count == 1;
  }
  test::TemporaryFolder folder;
  test::Bait bait;
};

bool is_link(const std::filesystem::path& path) {
  return std::filesystem::is_symlink(std::filesystem::symlink_status(path));
}

}  // namespace

TEST_CASE("planted links in a result folder are replaced or refused, never followed", "[security]") {
  for (const auto* name : {"run.json.partial", "run.json", "trajectory.csv.partial", "trajectory.csv",
                           "events.csv", "signals.csv.partial", "run.checkpoint", "run.checkpoint.partial"}) {
    CAPTURE(name);
    const Place place;
    place.link(std::filesystem::path("out") / name, place.bait.victim);
    const auto outcome =
        test::run_program(place.bait, {"run", "scene.toml", "--formulation", "nonsmooth", "-o", "out"});
    CAPTURE(outcome.err);
    CHECK(outcome.status == 0);
    CHECK(place.bait.untouched());
    CHECK_FALSE(is_link(place.bait.folder / "out" / name));
  }
  for (const auto* name : {"penalty", "nonsmooth", "ideal", "figures"}) {
    CAPTURE(name);
    const Place place;
    for (const auto* other : {"reaction_a.pdf", "run.json"})
      write_file(place.elsewhere() / other, "also mine\n");
    place.link(std::filesystem::path("out") / name, place.elsewhere());
    const auto outcome = test::run_program(place.bait, {"compare", "scene.toml", "-o", "out"});
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
  REQUIRE(test::run_program(place.bait, {"laws", "scene.toml", "-o", "laws"}).status == 0);
  const auto figures = place.bait.folder / "laws/figures";
  for (const auto* suffix : {".pdf", ".png", ".gp", ".dat"}) {
    remove_file(figures / (std::string("friction_laws") + suffix));
    std::filesystem::create_symlink(place.bait.victim, figures / (std::string("friction_laws") + suffix));
  }
  std::filesystem::create_symlink(place.elsewhere(), figures / "friction_laws.partial");
  make_folder(figures / "impact_loops.partial/deep");
  const auto outcome = test::run_program(place.bait, {"figures", "laws"});
  CAPTURE(outcome.err);
  CHECK(outcome.status == 0);
  CHECK(place.bait.untouched());
  CHECK(place.elsewhere_untouched());
  for (const auto& entry : std::filesystem::directory_iterator(figures)) {
    CAPTURE(entry.path().string());
    CHECK_FALSE(is_link(entry.path()));
    CHECK(entry.path().extension() != ".partial");
  }
}

TEST_CASE("a folder given by the user may be reached through links", "[security]") {
  const Place place;
  place.link("way", place.elsewhere());
  CHECK(test::run_program(place.bait, {"run", "scene.toml", "--formulation", "nonsmooth", "-o", "way/out"})
            .status == 0);
  CHECK(std::filesystem::exists(place.elsewhere() / "out/run.json"));
  CHECK(test::run_program(place.bait, {"run", "scene.toml", "--formulation", "nonsmooth", "-o", "way"})
            .status == 0);
  CHECK(std::filesystem::exists(place.elsewhere() / "run.json"));
}

TEST_CASE("a file with a second hard link is not written", "[security]") {
  const Place place;
  const auto out = place.bait.folder / "out";
  make_folder(out);
  for (const auto* name : {"run.json.partial", "trajectory.csv", "trajectory.csv.partial"})
    std::filesystem::create_hard_link(place.bait.victim, out / name);
  CHECK(
      test::run_program(place.bait, {"run", "scene.toml", "--formulation", "penalty", "-o", "out"}).status ==
      0);
  CHECK(place.bait.untouched());
  // A file to be resumed must belong to this run.
  std::filesystem::create_hard_link(place.bait.victim, out / "more.csv.partial");
  OutputFile more(out / "more.csv", true);
  CHECK_THROWS_AS(more.go_on_at(2), OutputError);
  CHECK(place.bait.untouched());
}

TEST_CASE("a planted database is refused", "[security][study]") {
  for (const auto* name : {"sweep.db", "sweep.db-wal", "sweep.db-journal", "sweep.db-shm"}) {
    CAPTURE(name);
    const Place place;
    write_file(place.bait.folder / "study.toml",
               "scene = \"scene.toml\"\njoint = \"gudgeon\"\naccelerometer = \"accelerometer\"\n"
               "revolutions = 1\nstarts = 1\n");
    place.link(std::filesystem::path("out") / name, place.bait.victim);
    const auto outcome = test::run_program(place.bait, {"sweep", "study.toml", "-o", "out"});
    CHECK(outcome.status == 1);
    CHECK_THAT(outcome.err, Contains("is a symbolic link"));
    CHECK(place.bait.untouched());
  }
}

TEST_CASE("special files are refused at once wherever a file is read", "[security]") {
  const Place place;
  const auto at = [&](const char* name) { return (place.bait.folder / name).string(); };
  REQUIRE(mkfifo(at("fifo").c_str(), 0600) == 0);
  make_folder(place.bait.folder / "dir");
  const int socket_descriptor = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const auto here = std::filesystem::current_path();
  REQUIRE(chdir(place.bait.folder.c_str()) == 0);  // the path of a socket is short
  std::string("socket").copy(address.sun_path, sizeof address.sun_path - 1);
  const bool bound = bind(socket_descriptor, reinterpret_cast<sockaddr*>(&address), sizeof address) == 0;
  REQUIRE(chdir(here.c_str()) == 0);
  REQUIRE(bound);
  for (const auto& [name, what] : {std::pair{"fifo", "a FIFO"},
                                   {"dir", "a folder"},
                                   {"socket", "a socket"},
                                   {"/dev/zero", "a device"},
                                   {"/dev/tty", "a device"}}) {
    const std::vector<std::vector<std::string>> commands{
        {"check", name},
        {"run", name, "--formulation", "penalty", "-o", "out"},
        {"sweep", name, "-o", "out"},
        {"validate", name, "-o", "out"},
        {"validate", "scene.toml", "--data", name, "--set", "run.revolutions=1.1", "-o", "out"},
        {"run", "--from", name, "-o", "out"}};
    for (const auto& command : commands) {
      if (command[1] == "--from" && std::string(name) == "dir")
        continue;  // the folder of a run is a valid argument
      const auto outcome = test::run_program(place.bait, command);
      CAPTURE(command, outcome.err);
      CHECK(outcome.status == 2);
      if (std::string(name) != "/dev/tty") CHECK_THAT(outcome.err, Contains(what));
      CHECK_FALSE(std::filesystem::exists(place.bait.folder / "out"));
    }
  }
  close(socket_descriptor);
  // As parts of a result folder, and of a run to resume.
  for (const auto* name : {"drift.json", "drift.csv"}) {
    make_folder(place.bait.folder / "results");
    REQUIRE(mkfifo((place.bait.folder / "results" / name).c_str(), 0600) == 0);
  }
  CHECK(test::run_program(place.bait, {"figures", "results"}).status == 2);
  make_folder(place.bait.folder / "resumed");
  REQUIRE(mkfifo((place.bait.folder / "resumed/run.checkpoint").c_str(), 0600) == 0);
  CHECK(test::run_program(place.bait, {"run", "--resume", "resumed"}).status == 2);
  // And an oversized file: refused by its size, not read.
  write_file(place.bait.folder / "big.toml", "");
  std::filesystem::resize_file(place.bait.folder / "big.toml", std::uintmax_t{1} << 40);
  CHECK_THAT(test::run_program(place.bait, {"check", "big.toml"}).err, Contains("exceeds 16 MiB"));
}

TEST_CASE("a study refers only to files beside or below it, unless it is trusted", "[security][study]") {
  const Place place;
  const auto outside = place.folder.path() / "outside.toml";
  write_file(outside, test::rig("\"outside\""));
  make_folder(place.bait.folder / "studies/below");
  write_file(place.bait.folder / "studies/below/scene.toml", test::rig("\"below\""));
  place.link("studies/link.toml", outside);
  place.link("studies/inner.toml", "below/scene.toml");
  // No accelerometer of that name: the named files are read, and no run is made.
  const auto outcome = [&](const std::string& scene, std::vector<std::string> more = {}) {
    write_file(place.bait.folder / "studies/study.toml",
               fmt::format("scene = \"{}\"\njoint = \"gudgeon\"\naccelerometer = \"none\"\n", scene));
    more.insert(more.begin(), {"sweep", "studies/study.toml", "-o", "out"});
    const auto t = test::run_program(place.bait, more);
    CHECK(t.status != 0);
    return t.err;
  };
  for (const auto& scene : {std::string("../scene.toml"), std::string("../../outside.toml"), outside.string(),
                            std::string("link.toml"), std::string("below/../../scene.toml"),
                            std::string("/dev/zero"), std::string("../studies-of-others/scene.toml")}) {
    CAPTURE(scene);
    CHECK_THAT(outcome(scene),
               Contains("studies/study.toml:1:9: scene: ") && Contains("pass --allow-outside"));
  }
  for (const auto& scene :
       {std::string("below/scene.toml"), std::string("inner.toml"), std::string("../studies/inner.toml"),
        (place.bait.folder / "studies/below/scene.toml").string()}) {
    CAPTURE(scene);
    CHECK_THAT(outcome(scene), !Contains("--allow-outside"));
  }
  CHECK_THAT(outcome(outside.string(), {"--allow-outside"}), !Contains("is outside"));
}
