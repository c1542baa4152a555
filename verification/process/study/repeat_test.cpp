// freeplay run --from: run.json is sufficient to repeat any run byte for byte, and contains all
// that affects its digits.
#include "dynamics/assembly/assembly.hpp"
#include "facade/run_folder.hpp"
#include "io/files/digest.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/write_scene.hpp"
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Path = std::filesystem::path;
using Words = std::vector<std::string>;

namespace {

nlohmann::json json_of(const Path& folder) { return test::read_json(folder / "run.json"); }

/// Repeats the run of a folder in another one.
void check_repeats(const Path& folder) {
  const auto again = Path(folder.string() + "-again");
  std::filesystem::remove_all(again);
  const auto o = test::succeeded("run --no-figures --from " + (folder / "run.json").string());
  CHECK(o.err.empty());
  CHECK_THAT(o.out, Contains("results in " + again.string()));
  test::check_same(again, folder);
}

const Words short_run{"run.revolutions=0.3", "run.discard=0.05", "run.output_step=1e-4"};

Words with(Words list, const Words& more) {
  list.insert(list.end(), more.begin(), more.end());
  return list;
}
}  // namespace

TEST_CASE("run --from repeats a run of each kind bit for bit", "[repeat]") {
  struct Kind {
    const char* name;
    const char* formulation;
    Words more;
    const char* option;
  };
  const Kind kinds[] = {
      {"adams", "penalty", {"penalty.tolerance=1e-7"}, " --forces"},
      {"dopri5", "penalty", {"penalty.integrator=dopri5", "penalty.contact=flores"}, ""},
      {"fast", "penalty", {}, " --accuracy fast"},
      {"moreau", "nonsmooth", {"joints.gudgeon.clearance=1e-3", "nonsmooth.step=3e-5"}, " --forces"},
      {"events", "nonsmooth", {"nonsmooth.scheme=event-driven"}, ""}};
  test::TemporaryFolder place;
  const auto scene = place.path() / "scene.toml";
  for (const auto& kind : kinds) {
    INFO(kind.name);
    write_file(scene, test::file_text(test::flores()));
    const auto folder = place.path() / kind.name;
    std::string sets;
    for (const auto& key : with(short_run, kind.more)) sets += " --set " + key;
    test::succeeded(fmt::format("run {} --no-figures --formulation {} -o {}{}{}", scene.string(),
                                kind.formulation, folder.string(), sets, kind.option));
    REQUIRE(std::filesystem::file_size(folder / "trajectory.csv") > 1000);
    write_file(scene, "no scene any more [");  // only run.json is read
    check_repeats(folder);
  }
}

TEST_CASE("run --from repeats the runs of a comparison, including the matched and the ideal one",
          "[repeat]") {
  test::TemporaryFolder place;
  const auto& folder = place.path();
  compare(
      *open_scene(test::flores(), with(short_run, {"run.forces=true", "penalty.contact=lankarani-nikravesh",
                                                   "surfaces.steel.restitution=0.46"})),
      {}, folder);
  const auto matched = json_of(folder / "nonsmooth");
  const double delivered = matched.at("contacts").at("gudgeon").at("restitution_delivered");
  CHECK(delivered > 0.6);  // not the 0.46 of the surface
  const auto& how = matched.at("provenance").at("identity").at("formulation");
  CHECK(how.at(1) == "matched = true");
  CHECK(how.at(2) == fmt::format("restitution = [{}]", delivered));
  CHECK(json_of(folder / "penalty").at("provenance").at("identity").at("formulation").at(1) ==
        "matched = false");
  for (const char* run : {"penalty", "nonsmooth", "ideal"}) {
    INFO(run);
    check_repeats(folder / run);
  }
  CHECK_FALSE(std::filesystem::exists(folder / "ideal-again" / "events.csv"));
}

TEST_CASE("run --from repeats a scene changed in code, and a given start", "[repeat]") {
  test::TemporaryFolder place;
  auto scene = read_scene(test::flores(), short_run);
  scene.mechanism.title = "Changed \"in code\"\n";
  std::get<RevoluteJoint>(scene.mechanism.joints.at(2)).clearance->radial = 0.4e-3;
  scene.penalty.tolerance = 1e-7;
  scene.instruments.front().noise = 0.25;
  std::set<std::string> digests;
  for (const auto& [formulation, given] :
       {std::pair("penalty", false), {"penalty", true}, {"nonsmooth", true}}) {
    const auto folder = place.path() / fmt::format("{}-{}", formulation, given);
    RunPlan plan{.formulation = formulation, .matched = true, .folder = folder};
    if (given) {
      plan.start = assemble(scene.mechanism, RunOptions::Start::ideal);
      plan.start->t = 0;
    }
    REQUIRE(run_scene(scene, plan).ending.status == Ending::Status::finished);
    INFO(folder);
    check_repeats(folder);
    const auto identity = json_of(folder).at("provenance").at("identity");
    CHECK(identity.at("given").size() == (given ? 4 : 0));
    digests.insert(identity.at("digest"));
  }
  // A run with another start of the journal is a different run.
  CHECK(digests.size() == 3);
}

TEST_CASE("run --from: another program is reported, damage and further options are refused", "[repeat]") {
  test::TemporaryFolder place;
  const auto folder = place.path() / "run", file = folder / "run.json", again = place.path() / "again";
  const auto scene =
      read_scene(test::flores(), with(short_run, {"penalty.tolerance=1e-5", "run.revolutions=0.1"}));
  run_scene(scene, {.formulation = "penalty", .folder = folder});
  const auto whole = test::file_text(file);
  const auto document = json_of(folder);
  const auto repeat = [&](const std::string& options) {
    return test::freeplay(fmt::format("run --from {} -o {}{}", file.string(), again.string(), options));
  };
  const auto refused = [&](const std::string& text, const std::string& why) {
    write_file(file, text);
    const auto o = repeat("");
    CAPTURE(o.out, o.err, why);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Contains(file.string() + ": ") && Contains(why));
    CHECK(std::ranges::count(o.err, '\n') == 1);
    CHECK(o.out.empty());
    CHECK_FALSE(std::filesystem::exists(again));
  };
  const auto changed = [&](const char* part, const auto& how) {
    auto other = document;
    how(other["provenance"]["identity"][part]);
    return other.dump();
  };
  const auto sealed = [](nlohmann::json other) {
    auto& i = other["provenance"]["identity"];
    std::string parts[4];
    const char* names[] = {"scene", "formulation", "given", "program"};
    for (int k = 0; k < 4; ++k)
      for (const auto& line : i[names[k]]) parts[k] += line.get<std::string>() + "\n";
    i["digest"] = Identity{parts[0], parts[1], parts[2], parts[3]}.digest();
    return other.dump();
  };
  REQUIRE(nlohmann::json::parse(sealed(document)) == document);
  const auto restated = [&](const char* part, const auto& value) {
    auto other = document;
    other["provenance"]["identity"][part][0] = value;
    return sealed(other);
  };
  for (const auto& text : {whole.substr(0, whole.size() / 2), std::string(), std::string("{}"),
                           changed("scene", [](auto& lines) { lines[0] = "format = 3"; }),
                           changed("scene", [](auto& lines) { lines[0] = 1; }),
                           changed("program", [](auto& lines) { lines.erase(1); }),
                           changed("digest", [](auto& digest) { digest = "0"; })})
    refused(text, "is damaged");
  refused(restated("scene", "format = 3"), "format: must be 1");
  refused(restated("formulation", "formulation = 3"), "has no formulation");
  auto other = document;
  other["provenance"]["overrides"] = "none";
  refused(other.dump(), "is damaged");
  other["provenance"].erase("identity");
  refused(other.dump(), "an earlier version wrote it");
  std::filesystem::remove(file);
  CHECK(repeat("").status == 2);
  write_file(file, whole);
  for (const char* option :
       {" --formulation penalty", " --set run.duration=1", " --accuracy fast", " --forces"})
    test::refused("run --from " + file.string() + option, Contains("the only other options are -o"));
  CHECK(repeat(" " + test::flores().string()).status == 2);
  CHECK(repeat(" --resume " + folder.string()).status == 2);
  test::refused(fmt::format("run --from {} -o {}", folder.string(), folder.string()),
                Contains("contains the run to be repeated"));
  CHECK(test::file_text(file) == whole);
  CHECK_FALSE(std::filesystem::exists(again));

  other = document;
  for (auto& line : other["provenance"]["identity"]["program"])
    if (line.get<std::string>().starts_with("flags = ")) line = "flags = \"-O3 -ffast-math\"";
  write_file(file, sealed(other));
  const auto o = repeat("");
  CAPTURE(o.err);
  CHECK(o.status == 0);
  CHECK_THAT(o.err, Contains("results may not be bitwise identical"));
  CHECK(std::ranges::count(o.err, '\n') == 1);
  CHECK(test::file_text(again / "trajectory.csv") == test::file_text(folder / "trajectory.csv"));
  write_file(file, whole);
  test::check_same(again, folder);  // and its provenance is that of the program that repeated it
}

TEST_CASE("an identity depends on values, not on their spelling", "[repeat][scene]") {
  const auto text = test::file_text(test::flores());
  const auto of = [](const Scene& scene, const char* formulation = "penalty", bool matched = false) {
    return Simulation(scene, formulation, {.matched = matched}).identity();
  };
  const auto scene = parse_scene(text, "a.toml", short_run);
  const auto own = of(scene);
  CHECK(own == of(parse_scene("# A remark.\n\n" + text + "\n# another\n", "b.toml", short_run)));
  CHECK(own ==
        // the default
        of(parse_scene(text, "a.toml", with(short_run, {"penalty.friction_v0=1e-4"}))));
  CHECK(own == of(parse_scene("format = 1\n" + text, "a.toml", short_run)));
  CHECK(own == of(parse_scene(own.scene, "again")));
  CHECK(own == of(scene, "penalty", true));  // matching affects impact laws alone
  CHECK(own.digest() == of(scene).digest());
  std::vector<std::string> digests{own.digest(), of(scene, "nonsmooth").digest(),
                                   of(scene, "nonsmooth", true).digest()};
  for (const char* set :
       {"penalty.friction_v0=2e-4", "penalty.integrator=dopri5", "penalty.stabilisation=none",
        "nonsmooth.step=2e-5", "run.start=assembled", "run.forces=true", "gravity=[0.0,-1e-300]"})
    digests.push_back(of(parse_scene(text, "a.toml", with(short_run, {set}))).digest());
  auto given = assemble(scene.mechanism, scene.run.start);
  digests.push_back(Simulation(scene, "penalty", {.start = given}).identity().digest());
  given.v[0] += 1e-12;
  digests.push_back(Simulation(scene, "penalty", {.start = given}).identity().digest());
  std::ranges::sort(digests);
  CHECK(std::ranges::adjacent_find(digests) == digests.end());
  for (const auto& d : digests) CHECK(d.size() == 32);
  // The program's identification in its own words.
  for (const char* key : {"version = ", "sources = ", "compiler = ", "flags = ", "build = ",
                          "instructions = ", "processor = ", "libraries = "})
    CHECK_THAT(own.program, Contains(key));
  CHECK(own.program.find("commit") == own.program.npos);
  // Parts are separated in the digest.
  CHECK(Identity{"ab", "", "", ""}.digest() != Identity{"a", "b", "", ""}.digest());
}

TEST_CASE("the digest is FNV-1a of 128 bits", "[repeat]") {
  // Test vectors of the draft: the offset basis for the empty text, one round of it for "a".
  CHECK(digest("") == "6c62272e07bb014262b821756295c58d");
  CHECK(digest("a") == "d228cb696f1a8caf78912b704e4a8964");
  CHECK(digest("foobar") == "343e1662793c64bf6f0d3597ba446f18");
}

TEST_CASE("a scene may state its format; errors state the format it was read in", "[repeat][scene]") {
  const auto text = test::file_text(test::flores());
  for (const auto& [line, message] :
       {std::pair("format = 1", "accepted"),
        {"format = 2", "accepted"},
        {"format = 0", "s.toml:1:10: format: must be 1 or 2 (later versions may know more), is 0"},
        {"format = 3", "s.toml:1:10: format: must be 1 or 2 (later versions may know more), is 3"},
        {"format = 1.5", "s.toml:1:10: format: must be 1 or 2 (later versions may know more), is 1.5"},
        {"format = \"1\"", "s.toml:1:10: format: must be a number, is a text"},
        {"formt = 1", "did you mean format?"}})
    CHECK_THAT(test::refusal(line + ("\n" + text)), Contains(message));
  CHECK(to_toml(parse_scene(text, "s.toml")).starts_with("format = 2\ntitle = "));

  // Defaults of a scene of format 1 keep their meaning: Moreau-Jean at 1e-5 s.
  const std::string bare = "[bodies.b]\nmass = 1\ninertia = 1\n[run]\nduration = 1\n";
  const auto old = parse_scene("format = 1\n" + bare, "s").nonsmooth;
  CHECK(old.scheme_in_force() == Scheme::moreau_jean);
  CHECK(old.step == 1e-5);
  CHECK_FALSE(parse_scene("format = 1\n" + bare + "[nonsmooth]\nstep = \"automatic\"\n", "s").nonsmooth.step);
  const auto now = parse_scene(bare, "s").nonsmooth;
  CHECK(now.scheme_in_force() == Scheme::automatic);
  CHECK_FALSE(now.step);
  CHECK(parse_scene(bare, "s", {"nonsmooth.step=1e-4"}).nonsmooth.scheme_in_force() == Scheme::moreau_jean);

  test::TemporaryFolder place;
  for (const bool stated : {false, true}) {
    const auto file = place.path() / "s.toml", folder = place.path() / "run";
    write_file(file, (stated ? "format = 2\n" : "") + text);
    const auto o = test::succeeded("check " + file.string());
    CHECK((o.out.find("not stated in the scene") == o.out.npos) == stated);
    run_scene(read_scene(file, with(short_run, {"run.revolutions=0.1"})),
              {.formulation = "nonsmooth", .folder = folder});
    const auto p = json_of(folder).at("provenance");
    CHECK(p.at("format") == 2);
    CHECK(p.contains("format_note") != stated);
    check_repeats(folder);
  }
}
