// Keys that only some laws, integrators and schemes read: refused with the others, in a file and as
// an option; and each key that is read has an effect. The rows of own_keys()
// (mechanism/options.hpp) list them; here they are derived again from runs.
#include "io/files/recorded_run.hpp"
#include "io/scene/schema.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/support/handovers.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::refusal;

namespace {

const std::string bare = "[bodies.b]\nmass = 1\ninertia = 1\n[run]\nduration = 1\n";

/// A method to integrate: lines of its table.
struct Way {
  std::string name, lines;
};
const std::vector<Way> integrators = [] {
  std::vector<Way> list;
  for (const auto& i : choices(Integrator{}))
    list.push_back({std::string(i.text), fmt::format("integrator = \"{}\"\n", i.text)});
  return list;
}();
const std::vector<Way> schemes = {{"fixed steps", "scheme = \"moreau-jean\"\nstep = 1e-3\n"},
                                  {"chosen steps", "scheme = \"moreau-jean\"\n"},
                                  {"event-driven", "scheme = \"event-driven\"\n"},
                                  {"automatic", "scheme = \"automatic\"\n"}};
/// A value other than the default for every key of [nonsmooth] and [penalty] except the choices.
const std::map<std::string, std::string> values = {{"nonsmooth.step", "2e-3"},
                                                   {"nonsmooth.step_tolerance", "1e-4"},
                                                   {"nonsmooth.tolerance", "1e-7"},
                                                   {"nonsmooth.solver", "\"gauss-seidel\""},
                                                   {"nonsmooth.lcp_tolerance", "1e-2"},
                                                   {"penalty.tolerance", "1e-7"},
                                                   {"penalty.step", "2e-6"},
                                                   {"penalty.alpha", "50"},
                                                   {"penalty.beta", "50"},
                                                   {"penalty.friction_v0", "2e-4"},
                                                   {"penalty.friction_v1", "2e-3"},
                                                   {"penalty.v0_floor", "10"}};

/// The line of a text that begins with `key`.
int line_of(const std::string& text, const std::string& key) {
  return static_cast<int>(
             std::count(text.begin(), text.begin() + static_cast<long>(text.find("\n" + key)) + 1, '\n')) +
         1;
}

/// Whether a key beside the lines of a method is read; a refusal names place, key, present choice
/// and remedy.
bool accepted(const std::string& table, const Way& way, const std::string& key, const std::string& value) {
  const auto name = key.substr(key.find('.') + 1);
  const auto text = bare + "[" + table + "]\n" + way.lines;
  if (way.lines.find("\n" + name + " =") != way.lines.npos) return true;  // it is among them
  const auto own = text + name + " = " + value + "\n";
  const auto in_file = refusal(own), as_option = refusal(text, {key + "=" + value});
  CAPTURE(way.name, key, in_file, as_option);
  if (in_file == "accepted") {
    CHECK(as_option == "accepted");
    return true;
  }
  CHECK_THAT(in_file, Contains(fmt::format("s.toml:{}:", line_of(own, name + " ="))) &&
                          Contains(key + ": is not read with ") && Contains("it belongs to ") &&
                          Contains("; remove it"));
  CHECK_THAT(as_option, Contains(fmt::format("--set {}={}: {}: is not read with ", key, value, key)));
  return false;
}

struct Seen {
  std::vector<double> q, v;
  long steps, right_hand_sides, pivots, retries;
  std::string reason;
  bool operator==(const Seen&) const = default;
};
Seen seen(const Scene& scene, Family family) {
  const auto run = test::simulate(scene, family);
  return {run.final_state.q, run.final_state.v,    run.work.steps,   run.work.rhs,
          run.work.pivots,   run.work.lcp_retries, run.ending.reason};
}

}  // namespace

TEST_CASE("keys of [nonsmooth] have an effect in a scheme or are refused", "[scene][own-keys]") {
  // A pile of discs: impacts, lasting contacts with friction, coupled. A disc in a wedge makes the
  // automatic scheme hand over.
  const auto pile = test::random_pile(1) + "\n";
  int read = 0, refused = 0;
  for (const auto& way : schemes)
    for (const auto& [key, value] : values) {
      if (!key.starts_with("nonsmooth.")) continue;
      CAPTURE(way.name, key);
      if (!accepted("nonsmooth", way, key, value)) {
        ++refused;
        continue;
      }
      ++read;
      // lcp_tolerance affects the one iterative solver.
      const bool iterates = key == "nonsmooth.lcp_tolerance";
      std::vector<std::string> set = {iterates ? "run.duration=0.2" : "run.duration=0.45"};
      if (iterates) set.emplace_back("nonsmooth.solver=gauss-seidel");
      std::vector<std::string> more = set;
      for (auto* list : {&set, &more}) {
        std::istringstream lines(way.lines);
        for (std::string line; std::getline(lines, line);) {
          std::erase(line, ' ');
          if (list == &set || !line.starts_with(key.substr(key.find('.') + 1) + "="))
            list->push_back("nonsmooth." + line);
        }
      }
      more.push_back(key + "=" + value);
      const bool adapts = key == "nonsmooth.step_tolerance";
      if (adapts) set[0] = more[0] = "run.duration=1.5";
      const auto text = adapts ? std::string(verification::wedge) : pile;
      CHECK_FALSE(seen(parse_scene(text, "discs", set), Family::nonsmooth) ==
                  seen(parse_scene(text, "discs", more), Family::nonsmooth));
    }
  CHECK(read == 4 * 2 + 2 + 2 +
                    // solver and lcp_tolerance by all; step, step_tolerance and tolerance by two
                    // each
                    2);
  CHECK(refused == 4 * 5 - read);
}

TEST_CASE("keys of [penalty] have an effect in an integrator or are refused", "[scene][own-keys]") {
  int read = 0;
  for (const auto& way : integrators)
    for (const auto& [key, value] : values) {
      if (!key.starts_with("penalty.")) continue;
      CAPTURE(way.name, key);
      const bool fixed = way.name == "rk4";
      if (!accepted("penalty", way, key, value)) {
        CHECK((key == "penalty.step" && !fixed));
        continue;
      }
      ++read;
      // Where friction is too steep for a step of rk4, implicit steps at penalty.tolerance replace
      // it.
      const bool steep = fixed && key == "penalty.tolerance";
      const std::vector<std::string> set = {"run.revolutions=0.03",
                                            "run.discard=0",
                                            "surfaces.steel.friction=0.1",
                                            "penalty.integrator=" + way.name,
                                            fixed ? "penalty.step=1e-6" : "run.discard=0",
                                            steep ? "penalty.friction_v0=1e-9" : "run.discard=0",
                                            steep ? "penalty.friction_v1=2e-9" : "run.discard=0"};
      auto more = set;
      more.push_back(key + "=" + value);
      CHECK_FALSE(seen(read_scene(test::flores(), set), Family::penalty) ==
                  seen(read_scene(test::flores(), more), Family::penalty));
    }
  CHECK(read == 6 * static_cast<int>(integrators.size()) + 1);  // step by rk4 alone
}

TEST_CASE("keys of laws and of stabilisation are refused with another choice", "[scene][own-keys]") {
  for (const auto& law : friction_laws())
    for (const auto& row : own_keys(PenaltyOptions{})) {
      if (row.by != "friction") continue;
      const auto own = fmt::format("friction = \"{}\"\n", law.text);
      CAPTURE(law.text, row.name);
      const char* const value = row.name == "friction_v0" ? "2e-5" : "2";  // below friction_v1
      CHECK(accepted("penalty", {"law", own}, fmt::format("penalty.{}", row.name), value) ==
            law.reads(row.name));
    }
  for (const auto& law : contact_laws()) {
    const auto own = fmt::format("contact = \"{}\"\n", law.text);
    CAPTURE(law.text);
    CHECK(accepted("penalty", {"law", own}, "penalty.damping", "\"hertz\"") ==
          (law.kind == ContactKind::line));
    for (const char* key : {"penalty.kelvin_stiffness", "penalty.kelvin_damping"})
      CHECK(accepted("penalty", {"law", own}, key, "2") == (law.kind == ContactKind::spring_damper));
  }
  for (const auto& s : choices(Stabilisation{}))
    for (const char* key : {"penalty.alpha", "penalty.beta"}) {
      const auto own = fmt::format("stabilisation = \"{}\"\nintegrator = \"dopri5\"\n", s.text);
      CHECK(accepted("penalty", {"by", own}, key, "2") == (s.value == Stabilisation::baumgarte));
    }
}

TEST_CASE("every key of [run], [penalty] and [nonsmooth] is covered by these tests", "[scene][own-keys]") {
  std::set<std::string> tested = {"nonsmooth.scheme",      "nonsmooth.impact_law",
                                  "penalty.contact",       "penalty.friction",
                                  "penalty.stabilisation", "penalty.integrator"};  // choices
  for (const auto& [key, value] : values) tested.insert(key);
  for (const auto& row : own_keys(PenaltyOptions{})) tested.insert(fmt::format("penalty.{}", row.name));
  for (const auto& key : scene_schema().keys()) {
    CAPTURE(key.path);
    if (key.path.starts_with("penalty.") || key.path.starts_with("nonsmooth."))
      CHECK(tested.contains(std::string(key.path)));
    // No scheme and no integrator reads [run]: it sets the duration, the start and the recorded
    // output.
    if (!key.path.starts_with("run.")) continue;
    const std::string name(key.path.substr(4)), value = name == "start"      ? "\"given\""
                                                        : key.type[0] == 't' ? "true"
                                                                             : "0.5";
    if (name == "revolutions" || name == "duration") continue;
    for (const auto& way : schemes)
      CHECK(refusal(bare + name + " = " + value + "\n[nonsmooth]\n" + way.lines) == "accepted");
    for (const auto& way : integrators)
      CHECK(refusal(bare + name + " = " + value + "\n[penalty]\n" + way.lines) == "accepted");
  }
}

TEST_CASE("an option that changes a choice makes keys of the file idle, with a note", "[scene][own-keys]") {
  const auto text =
      bare + "[nonsmooth]\nstep = 1e-4\n[penalty]\nintegrator = \"rk4\"\nstep = 1e-5\nalpha = 2\n";
  const auto scene = parse_scene(
      text, "s.toml",
      {"nonsmooth.scheme=event-driven", "penalty.integrator=dopri5", "penalty.stabilisation=none"});
  REQUIRE(scene.idle.size() == 3);
  CHECK(
      scene.idle[0] ==
      "penalty.alpha is not read with stabilisation = \"none\": it belongs to stabilisation = \"baumgarte\"");
  CHECK(scene.idle[1] ==
        "penalty.step is not read with integrator = \"dopri5\": it belongs to integrator = \"rk4\"");
  CHECK(scene.idle[2] ==
        "nonsmooth.step is not read with scheme = \"event-driven\": it belongs to scheme = \"moreau-jean\"");
  // They are not part of the scene, and its canonical text is read back.
  const auto plain = parse_scene(
      bare, "s.toml",
      {"nonsmooth.scheme=event-driven", "penalty.integrator=dopri5", "penalty.stabilisation=none"});
  CHECK(same_facts(scene, plain));
  CHECK(parse_scene(to_toml(scene), "again").idle.empty());
  // An invalid value is refused nevertheless; so is a key that an option gives beside the choice,
  // in either order.
  CHECK_THAT(refusal(bare + "[nonsmooth]\nstep = -1\n", {"nonsmooth.scheme=event-driven"}),
             Contains("nonsmooth.step: must be greater than 0"));
  for (const auto& options :
       std::vector<std::vector<std::string>>{{"nonsmooth.scheme=automatic", "nonsmooth.step=1e-4"},
                                             {"nonsmooth.step=1e-4", "nonsmooth.scheme=automatic"}})
    CHECK_THAT(
        refusal(bare, options),
        Contains("--set nonsmooth.step=1e-4: nonsmooth.step: is not read with scheme = \"automatic\""));
  // In code the later of two settings decides.
  auto in_code = parse_scene(bare, "s.toml");
  in_code.set("nonsmooth.step", 1e-4);
  in_code.set("nonsmooth.scheme", "event-driven");
  CHECK(in_code.nonsmooth.scheme_in_force() == Scheme::event_driven);
  CHECK_THROWS_AS(in_code.set("nonsmooth.step", 1e-4), SceneError);
}

TEST_CASE("scenes recorded by former versions are read without the keys that had no effect",
          "[scene][own-keys]") {
  // The canonical text of former versions named every key of [nonsmooth] for every scheme.
  Identity recorded;
  recorded.scene = to_toml(parse_scene(bare + "[nonsmooth]\nstep = 1e-4\n", "s.toml"));
  const auto at = recorded.scene.find("[nonsmooth]\n") + std::string("[nonsmooth]\n").size();
  recorded.scene.insert(at, "step_tolerance = 1e-06\ntolerance = 1e-10\n");
  recorded.formulation = "formulation = \"nonsmooth\"\nmatched = false\n";
  const auto setup = setup_of(recorded, {});
  CHECK(setup.scene.nonsmooth.step == 1e-4);
}

TEST_CASE("recommendations name a key that the run reads", "[own-keys]") {
  NonsmoothOptions o;
  CHECK(fineness_key(o) == "nonsmooth.tolerance");
  CHECK(fineness_key(o, true) == "nonsmooth.step_tolerance");
  o.impact_law = ImpactLaw::poisson;  // without hand-overs
  CHECK(fineness_key(o, true) == "nonsmooth.tolerance");
  o = {.step = 1e-4};
  CHECK(fineness_key(o) == "nonsmooth.step");
  o = {.scheme = Scheme::moreau_jean};
  CHECK(fineness_key(o) == "nonsmooth.step_tolerance");
  PenaltyOptions p;
  CHECK(fineness_key(p) == "penalty.tolerance");
  p.integrator = Integrator::rk4;
  CHECK(fineness_key(p) == "penalty.step");
}

TEST_CASE("revolutions and seconds have the same bounds", "[scene]") {
  const auto turning = bare.substr(0, bare.find("[run]")) +
                       "[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"b\"]\n"
                       "[drives.d]\njoint = \"pin\"\nspeed = 2.0\n[run]\n";
  // 2 rad/s: a revolution of π s. The bounds of seconds are 1e-18 and 1e9
  // (mechanism/magnitude.hpp).
  CHECK(refusal(turning + "revolutions = 3e8\n") == "accepted");
  CHECK_THAT(refusal(turning + "revolutions = 4e8\n"),
             Contains("s.toml:11:15: run.revolutions: must be at most 1e+09 s, is 125663706"));
  CHECK_THAT(refusal(turning + "revolutions = 1e-301\n"),
             Contains("run.revolutions: must be at least 1e-18 s"));
  CHECK(refusal(turning + "revolutions = 1e-18\n") == "accepted");
}
