// Reading of scenes: the reference scene, overrides, every kind of invalid input with its message,
// and agreement of docs/reference/scene.md with the schema.
#include <fstream>
#include <numbers>
#include <tuple>

#include "io/scene/schema.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/magnitude.hpp"
#include "plots/drawing/style.hpp"
#include "study/settings/study.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using test::refusal;

namespace {

/// A small valid scene; its first text is replaced by the second.
std::string scene(const std::string& from = "", const std::string& to = "") {
  std::string text = R"([bodies.a]
mass = 1.0
inertia = 0.1
[bodies.b]
mass = 2.0
inertia = 0.2
[joints.pivot]
type = "revolute"
between = ["ground", "a"]
at = [[0, 0], [0.5, 0]]
[joints.loose]
type = "revolute"
between = ["a", "b"]
at = [[-0.5, 0], [0.2, 0]]
clearance = 1e-3
bearing_radius = 1e-2
surface = "steel"
[joints.guide]
type = "translational"
between = ["ground", "b"]
axis = [1, 0]
[surfaces.steel]
young = 2e11
poisson = 0.3
restitution = 0.5
friction = 0.1
[drives.motor]
joint = "pivot"
speed_rpm = 60
[run]
revolutions = 2
[penalty]
contact = "exact"
[nonsmooth]
step = 1e-5
[instruments.accelerometer]
body = "b"
bandwidth = 100
sampling = 1000
)";
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  return text;
}

}  // namespace

TEST_CASE("the reference scene is read with its values", "[scene]") {
  const auto s = read_scene(test::flores());
  REQUIRE(s.mechanism.bodies.size() == 3);
  REQUIRE(s.mechanism.bodies[0].name == "crank");  // in the order of the file
  REQUIRE(s.mechanism.joints.size() == 4);
  const auto& gudgeon = std::get<RevoluteJoint>(s.mechanism.joints[2]);
  REQUIRE(gudgeon.clearance->radial == 0.25e-3);
  REQUIRE(main_drive(s.mechanism)->speed == Approx(200 * 2 * std::numbers::pi / 60));
  REQUIRE(s.run.duration == Approx(3.6));
  REQUIRE(s.run.discard == Approx(0.6));
  REQUIRE(s.penalty.contact == ContactLaw::lankarani_nikravesh);
  REQUIRE(s.nonsmooth.step == 1e-5);
  REQUIRE(s.instruments.at(0).bandwidth == 1000);
}

TEST_CASE("an override sets one number of a list", "[scene]") {
  const std::string text = scene() + test::body("c", 1, 1, "points = { pin = [0.1, 0.2] }\n") +
                           "[joints.named]\ntype = \"revolute\"\nbetween = [\"b\", \"c\"]\n"
                           "at = [[0.3, 0], \"pin\"]\n";
  auto s = parse_scene(text, "s",
                       {"bodies.a.position=[1, 2]", "bodies.a.position[1]=5 mm", "joints.named.at[0][0]=0.4",
                        "joints.named.at[1][1]=0.25", "gravity[1]=-1", "bodies.c.points.pin[0]=0.15"});
  CHECK(s.mechanism.bodies[0].position == Vec2(1, 5e-3));
  const auto& at = std::get<RevoluteJoint>(s.mechanism.joints.back()).at;
  CHECK(at[0] == Vec2(0.4, 0));
  CHECK(at[1] == Vec2(0.1, 0.25));  // one number in place of a name keeps the other
  CHECK(s.mechanism.gravity.y() == -1);
  s.set("bodies.a.position[0]", 4);
  CHECK(s.mechanism.bodies[0].position == Vec2(4, 5e-3));
  s.mechanism.bodies[0].position = {7, 8};  // a scene changed in code
  s.set("bodies.a.position[0]", 9);
  CHECK(s.mechanism.bodies[0].position == Vec2(9, 8));

  const auto says = [&](const std::string& option) {
    return test::refusal_of<SceneError>([&] { parse_scene(text, "s", {option}); });
  };
  CHECK_THAT(says("bodies.a.position[2]=1"), Contains("bodies.a.position has no such number"));
  CHECK_THAT(says("bodies.a.mass[0]=1"), Contains("bodies.a.mass has no such number"));
  CHECK_THAT(says("joints.named.at[1]=1"), Contains("joints.named.at has no such number"));
  CHECK_THAT(says("bodies.a.position[x]=1"), Contains("must end with indices such as [0]"));
  CHECK_THAT(says("bodies.a.position[0=1"), Contains("must end with indices such as [0]"));
  CHECK_THAT(says("bodies.a.position[-1]=1"), Contains("must end with indices such as [0]"));
  CHECK_THAT(says("bodies.z.position[0]=1"), Contains("bodies.z"));
  CHECK_THAT(says("joints.named.at[0][0]=heavy"), Contains("joints.named.at"));
}

TEST_CASE("invalid scenes are refused with place, key and remedy", "[scene]") {
  REQUIRE(refusal(scene()) == "accepted");
  const test::Edit list[] = {
      {"mass = 1.0", "mass = -1.0", "s.toml:2:8: bodies.a.mass: must be greater than 0, is -1"},
      {"mass = 1.0", "mass = 0", "bodies.a.mass: must be greater than 0"},
      {"mass = 1.0", "mass = nan", "bodies.a.mass: must be finite"},
      {"mass = 1.0", "mass = inf", "bodies.a.mass: must be finite"},
      {"mass = 1.0", "mass = \"heavy\"", "s.toml:2:8: bodies.a.mass: must be a number, is a text"},
      {"mass = 1.0", "", "s.toml:1:1: bodies.a.mass: is missing"},
      {"mass = 1.0", "mas = 1.0\nmass = 1.0",
       "s.toml:2:7: bodies.a.mas: is not a key of a body; did you mean mass?"},
      {"mass = 1.0", "mass = 1.0\nmass = 2.0", "s.toml:3:"},
      {"mass = 1.0", "mass = = 1", "not TOML"},
      {"mass = 1.0", "mass = [1]", "must be a number, is a list"},
      {"mass = 1.0", "mass = 2026-01-01", "must be a number, is a date"},
      {"mass = 1.0", "mass = {a = 1}", "must be a number, is a table"},
      {"[bodies.b]", "[bodies.\"a\\nb\"]", "a name must be made of letters"},
      {"type = \"revolute\"", "type = \"a\\nb\"", "\"a\\nb\" is unknown"},
      {"inertia = 0.1", "inertia = true", "bodies.a.inertia: must be a number, is true or false"},
      {"[bodies.b]", "[bodies.ground]", "bodies.ground: \"ground\" is the fixed frame"},
      {"[bodies.b]", "[bodies.\"b,c\"]", "a name must be made of letters"},
      {"type = \"revolute\"", "type = \"hinge\"",
       "joints.pivot.type: \"hinge\" is unknown\n  one of \"revolute\""},
      {"\"ground\", \"a\"", "\"ground\", \"z\"",
       "joints.pivot.between: there is no body \"z\"; there is: ground, a, b"},
      {"\"ground\", \"a\"", "\"a\", \"a\"", "joints.pivot.between: joins \"a\" to itself"},
      {"\"ground\", \"a\"", "\"a\"", "joints.pivot.between: must name two bodies, names 1"},
      {"\"ground\", \"a\"", "1, 2", "joints.pivot.between: must be a list of names"},
      {"[[0, 0], [0.5, 0]]", "[[0, 0]]", "joints.pivot.at: must be two points"},
      {"[[0, 0], [0.5, 0]]", "[[0, 0], [0.5, 0, 1]]", "must be a pair [x, y], is a list of 3"},
      {"[[0, 0], [0.5, 0]]", "[[0, 0], [0.5, nan]]", "joints.pivot.at: must be finite"},
      {"clearance = 1e-3", "clearance = 0.0", "joints.loose.clearance: must be greater than 0"},
      {"bearing_radius = 1e-2\n", "", "joints.loose.bearing_radius: is missing"},
      {"bearing_radius = 1e-2", "bearing_radius = 1e-4",
       "joints.loose.bearing_radius: must be greater than the clearance"},
      {"surface = \"steel\"\n", "", "joints.loose.surface: is missing"},
      {"surface = \"steel\"", "surface = \"wood\"",
       "joints.loose.surface: there is no surface \"wood\"; there is: steel"},
      {"clearance = 1e-3\n", "",
       "joints.loose.bearing_radius: does not apply to a revolute joint without clearance"},
      {"axis = [1, 0]", "axis = [0, 0]", "joints.guide.axis: must not be zero"},
      {"axis = [1, 0]", "axes = [0, 1]", "joints.guide.axes: is not a key of a joint; did you mean axis?"},
      {"poisson = 0.3", "poisson = 0.6", "surfaces.steel.poisson: must be between 0 and 0.5, is 0.6"},
      {"poisson = 0.3\n", "", "young and poisson go together"},
      {"restitution = 0.5", "restitution = 1.5", "surfaces.steel.restitution: must be between 0 and 1"},
      {"friction = 0.1", "friction = -0.1", "surfaces.steel.friction: must be 0 or greater"},
      {"restitution = 0.5", "restitution = 0.5\nyield_speed = 0",
       "surfaces.steel.yield_speed: must be greater than 0"},
      {"restitution = 0.5", "yield_speed = 0.1", "surfaces.steel.yield_speed: needs restitution"},
      {"restitution = 0.5", "restitution = 0.5\nrestitution_table = [[0, 1], [1, 0.5]]",
       "surfaces.steel.restitution: cannot be combined with restitution_table"},
      {"restitution = 0.5", "yield_speed = 0.1\nrestitution_table = [[0, 1], [1, 0.5]]",
       "surfaces.steel.yield_speed: cannot be combined with restitution_table"},
      {"restitution = 0.5", "restitution_table = [[0, 1]]",
       "surfaces.steel.restitution_table: must have two points or more"},
      {"restitution = 0.5", "restitution_table = [[1, 1], [1, 0.5]]",
       "surfaces.steel.restitution_table: must increase"},
      {"restitution = 0.5", "restitution_table = [[-1, 1], [1, 0.5]]",
       "surfaces.steel.restitution_table: must have approach speeds of 0 or greater, has -1"},
      {"restitution = 0.5", "restitution_table = [[0, 1], [1, 1.5]]",
       "surfaces.steel.restitution_table: must have restitutions between 0 and 1, has 1.5"},
      {"joint = \"pivot\"", "joint = \"nope\"", "drives.motor.joint: there is no joint \"nope\""},
      {"joint = \"pivot\"", "joint = \"guide\"", "drives.motor.joint: must be a revolute joint"},
      {"speed_rpm = 60", "speed_rpm = 60\ntorque = 1",
       "drives.motor: needs exactly one of speed_rpm, speed, torque"},
      {"speed_rpm = 60", "", "drives.motor: needs exactly one of speed_rpm, speed, torque"},
      {"speed_rpm = 60", "torque_table = [[0, 1], [0, 2]]", "drives.motor.torque_table: must increase"},
      {"speed_rpm = 60", "torque = 1", "run.revolutions: needs a drive that turns at a prescribed speed"},
      {"revolutions = 2", "revolutions = 2\nduration = 1",
       "run: needs exactly one of revolutions and duration"},
      {"revolutions = 2", "", "run: needs exactly one of revolutions and duration"},
      {"revolutions = 2", "revolutions = 0", "run.revolutions: must be greater than 0"},
      {"revolutions = 2", "revolutions = 2\ndiscard = 3", "run.discard: must be less than the length"},
      {"revolutions = 2", "revolutions = 2\nstart = \"rest\"", "run.start: \"rest\" is unknown"},
      {"contact = \"exact\"", "contact = \"hertz-ish\"", "penalty.contact: \"hertz-ish\" is unknown"},
      {"contact = \"exact\"", "friction_v0 = 1.0", "penalty.friction_v1: must be greater than friction_v0"},
      {"contact = \"exact\"", "tolerance = 0", "penalty.tolerance: must be greater than 0"},
      {"step = 1e-5", "step = -1e-5", "nonsmooth.step: must be greater than 0"},
      {"step = 1e-5", "stepp = 1e-5", "nonsmooth.stepp: is not a key of [nonsmooth]; did you mean step?"},
      {"sampling = 1000", "sampling = 150",
       "instruments.accelerometer.sampling: must exceed twice the bandwidth"},
      {"body = \"b\"", "body = \"ground\"", "instruments.accelerometer.body: must be a moving body"},
      {"[bodies.a]", "[bodies]\nx = 3\n[bodies.a]", "bodies.x: must be a table, is a number"},
      {"[bodies.a]", "[#bodies.a]", "s.toml:1:2: not TOML: the name of a table must begin with"},
      {"mass = 1.0", "mass ó = 1.0", "s.toml:2:6: not TOML: non-ASCII characters"},
      {"step = 1e-5", "scheme = \"eventful\"", "nonsmooth.scheme: \"eventful\" is unknown"},
      {"step = 1e-5", "solver = \"guess\"", "nonsmooth.solver: \"guess\" is unknown"},
      {"step = 1e-5", "step = 1e-5\nimpact_law = \"poisson\"",
       "nonsmooth.impact_law: time stepping needs \"newton\""},
      {"step = 1e-5", "lcp_tolerance = -1", "nonsmooth.lcp_tolerance: must be greater than 0"},
      {"contact = \"exact\"", "integrator = \"euler\"", "penalty.integrator: \"euler\" is unknown"},
      {"contact = \"exact\"", "stabilisation = \"projection\"",
       "penalty.stabilisation: \"projection\" changes"},
      {"contact = \"exact\"", "stabilisation = \"none\"\nalpha = 1",
       "penalty.alpha: is not read with stabilisation = \"none\""},
      {"friction = 0.1", "friction = 0.1\ntangential_restitution = 2",
       "surfaces.steel.tangential_restitution: must be between 0 and 1"},
      {"axis = [1, 0]", "axis = [1, 0]\nclearance = 1e-3", "joints.guide.slider_length: is missing"},
      {"axis = [1, 0]", "axis = [1, 0]\nclearance = 1e-3\nslider_length = 0.1\nslider_height = 0",
       "joints.guide.slider_height: must be greater than 0"},
      {"axis = [1, 0]", "axis = [1, 0]\nclearance = 1e-3\nslider_length = 0.1\nslider_height = 0.1",
       "joints.guide.surface: is missing"},
      {"axis = [1, 0]", "axis = [1, 0]\nslider_length = 0.1",
       "joints.guide.slider_length: does not apply to a translational joint without clearance"},
  };
  const std::pair<std::string, const char*> added[] = {
      {"[smooth]\nx = 1\n", "smooth: is not a key of a scene"},
      {"[contacts.c]\ntype = \"sphere\"\n", "contacts.c.type: \"sphere\" is unknown"},
      {"[contacts.c]\ntype = \"plane\"\nbetween = [\"ground\", \"b\"]\n", "contacts.c.surface: is missing"},
      {test::plane("c", "ground", "b", 0, "steel", "radius = -1\n"),
       "contacts.c.radius: must be 0 or greater"},
      {test::plane("c", "ground", "b", 0, "steel", "radii = [1, 1]\n"),
       "contacts.c.radii: does not apply to a plane contact"},
      {test::discs("c", "a", "b", 1, 0, "steel"), "contacts.c.radii: must be two positive lengths"},
      {test::discs("loose", "a", "b", 1, 1, "steel"), "contacts.loose: a joint has the same name"},
      {"[lubricants.oil]\nviscosity = 0\n", "lubricants.oil.viscosity: must be greater than 0"},
      {"[loads.l]\ntype = \"wind\"\n", "loads.l.type: \"wind\" is unknown"},
      {"[loads.l]\ntype = \"force\"\nbody = \"ground\"\nforce = [1, 0]\n",
       "loads.l.body: must be a moving body"},
      {"[loads.l]\ntype = \"joint-friction\"\njoint = \"pivot\"\nforce = 1\n",
       "loads.l.joint: must be a translational joint"},
      {test::spring("l", "a", "b", {}, {}, -1, 0), "loads.l.stiffness: must be 0 or greater"},
  };
  for (const auto& [text, words] : added) {
    CAPTURE(text);
    CHECK_THAT(refusal(scene() + text), Contains(words));
  }
  for (const auto& bad : list) {
    CAPTURE(bad.from, bad.to);
    const auto said = refusal(scene(bad.from, bad.to));
    CHECK_THAT(said, Contains(bad.words));
    CHECK(test::fault_of(said + "\n").empty());
  }
  CHECK_THAT(refusal(""), Contains("the scene needs at least one body"));
}

TEST_CASE(
    "docs/reference/scene.md, "
    "docs/reference/study.md and docs/reference/figures.md list exactly the keys of the reader, "
    "with their units and defaults",
    "[scene][docs]") {
  std::size_t listed = 0;
  // Keys of a study or a style stand at the root of its file, and so they do in its page.
  std::size_t keys_of_all = 0;
  for (const auto& [file, root, schema] :
       {std::tuple("docs/reference/scene.md", "", &scene_schema()),
        std::tuple("docs/reference/study.md", "study.", &study_schema()),
        std::tuple("docs/reference/figures.md", "style.", &plots::style_schema())}) {
    keys_of_all += schema->keys().size();
    std::ifstream in(test::source_folder() / file);
    REQUIRE(in);
    std::string line;
    bool keys = false;  // within a table of keys
    while (std::getline(in, line)) {
      if (!line.starts_with("| ")) keys = false;
      if (line.starts_with("| key |")) keys = true;
      if (!keys || !line.starts_with("| `")) continue;
      const auto path = root + line.substr(3, line.find('`', 3) - 3);
      CAPTURE(line);
      const auto* key = schema->find(path);
      REQUIRE(key);
      const auto expected = "| `" + key->path.substr(std::string_view(root).size()) + "` | " + key->type +
                            " | " + key->unit + " | " + key->fallback + " | " + key->meaning + " |";
      REQUIRE(line == expected);
      ++listed;
    }
  }
  REQUIRE(listed == keys_of_all);
}

TEST_CASE(
    "every unit of a key has bounds, docs/reference/scene.md lists them, and what lies beyond is refused",
    "[scene][docs][bounded]") {
  const auto page = test::file_text(test::source_folder() / "docs/reference/scene.md");
  for (const auto& m : magnitudes) CHECK_THAT(page, Contains(row_of(m)));
  for (const auto* schema : {&scene_schema(), &study_schema(), &plots::style_schema()})
    for (const auto& key : schema->keys()) {
      CAPTURE(key.path);
      CHECK(magnitude_of(key.unit));
    }
  const auto refused = [](const std::string& set, const char* what) {
    CAPTURE(set);
    CHECK_THROWS_WITH(read_scene(test::flores(), {set}), Contains(set) && Contains(what));
    CHECK_THROWS_AS(read_scene(test::flores(), {set}), SceneError);
  };
  refused("joints.gudgeon.bearing_radius=1e300", "must be at most 1e+09 m, is 1e+300");
  refused("joints.gudgeon.bearing_radius=inf", "must be finite");
  refused("joints.gudgeon.clearance=1e-300", "must be at least 1e-18 m");
  refused("bodies.slider.velocity=[0.0, 1e9]", "must be at most 299792458 m/s");
  refused("drives.motor.speed_rpm=-1e30", "must be at most 1e+13 rpm");
  refused("instruments.accelerometer.sampling=1e15", "must be at most 1e+09 Hz");
  refused("instruments.accelerometer.sampling=9e8", "1e+09 samples");  // 3.6 s of them
  refused("nonsmooth.step=1e-300", "must be at least 1e-18 s");
  refused("bodies.slider.mass=1e300", "must be at most 1e+40 kg");
  refused("gravity=[1e300, 0]", "must be at most 1e+16 m/s²");
  CHECK_NOTHROW(read_scene(test::flores(), {"joints.gudgeon.bearing_radius=1e9"}));
}
