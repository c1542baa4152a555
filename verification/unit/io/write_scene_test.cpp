// Writing of scenes: the text of to_toml is read back bit for bit for every scene, first_difference
// finds the differing key, and Scene::set is equivalent to --set.
#include "io/scene/write_scene.hpp"

#include <bit>
#include <cstdint>
#include <limits>
#include <regex>

#include "io/files/escaping.hpp"
#include "io/scene/schema.hpp"
#include "io/scene/toml_text.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;

namespace {

Scene written_and_read(const Scene& scene) { return parse_scene(to_toml(scene), "again"); }

void require_round_trip(const Scene& scene) {
  const auto text = to_toml(scene);
  CAPTURE(text);
  const auto again = parse_scene(text, "again");
  REQUIRE(first_difference(text, to_toml(again)).empty());
  REQUIRE(to_toml(again) == text);
  REQUIRE(same_facts(again, scene));
}

bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

SpeedDrive& first_drive(Scene& scene) { return std::get<SpeedDrive>(scene.mechanism.drives.at(0)); }

std::string refusal(Scene& scene, const std::string& key, const std::string& value) {
  return test::refusal_of<SceneError>([&] { scene.set(key, value); });
}

}  // namespace

TEST_CASE("every scene is read back from its canonical text", "[scene]") {
  int scenes = 0;
  for (const auto& file : test::all_scenes()) {
    CAPTURE(file.string());
    const auto scene = read_scene(file);
    ++scenes;
    require_round_trip(scene);
    const auto again = written_and_read(scene);
    REQUIRE(same_bits(again.run.duration, scene.run.duration));
    REQUIRE(same_bits(again.run.discard, scene.run.discard));
    for (std::size_t b = 0; b < scene.mechanism.bodies.size(); ++b) {
      const auto &was = scene.mechanism.bodies[b], &is = again.mechanism.bodies.at(b);
      REQUIRE(is.name == was.name);
      REQUIRE(same_bits(is.inertia, was.inertia));
      REQUIRE(is.position.has_value() == was.position.has_value());
      REQUIRE(same_bits(is.position.value_or(Vec2{}).x(), was.position.value_or(Vec2{}).x()));
    }
    if (const auto* drive = main_drive(scene.mechanism)) {
      REQUIRE(same_bits(main_drive(again.mechanism)->speed, drive->speed));
      REQUIRE(same_bits(main_drive(again.mechanism)->initial_angle, drive->initial_angle));
    }
  }
  REQUIRE(scenes >= 22);
}

TEST_CASE("a canonical text names every key of the schema", "[scene]") {
  std::set<std::string> written;
  const auto write = [&](const Scene& scene) {
    for (const auto& line : canonical_lines(to_toml(scene))) {
      const auto first = line.key.find('.'), last = line.key.rfind('.');
      written.insert(first == last ? line.key : line.key.substr(0, first) + ".*" + line.key.substr(last));
    }
  };
  auto scene = read_scene(test::scene_file("every_key"));
  write(scene);
  // Keys of laws, integrators and schemes other than the file's.
  for (const auto& law : friction_laws()) {
    scene.penalty.friction = law.law;
    write(scene);
  }
  scene.penalty.contact = ContactLaw::kelvin_voigt;
  scene.penalty.kelvin_stiffness = scene.penalty.kelvin_damping = 1;
  scene.penalty.integrator = Integrator::rk4;
  scene.mechanism.assembly = {Configuration::Branch::open, {{{0, 1, 2}}}, {{{2, 1, 0}}}};
  scene.nonsmooth.scheme = Scheme::event_driven;  // the file's scheme is the default for its step
  write(scene);
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  scene.nonsmooth.step.reset();
  write(scene);
  for (const char* section : {"area = 1e-4\nsecond_moment = 1e-9\nmodes = 2\n",
                              "section = \"rectangle\"\nwidth = 0.01\nheight = 0.01\n",
                              "section = \"tube\"\ndiameter = 0.02\nwall = 0.001\n[instruments.gauge]\n"
                              "type = \"strain-gauge\"\nbeam = \"rod\"\nplace = 0.5\noffset = 0.01\n"
                              "bandwidth = 10\nsampling = 100\n",
                              "section = \"circle\"\nsections = [[0, 0.02], [0.5, 0.01]]\n"})
    write(parse_scene(
        test::body("a", 1, 1) +
            "[beams.rod]\nbetween = [\"ground\", \"a\"]\nlength = 1\nyoung = 2e11\ndensity = 8e3\n" +
            section +
            "[loads.piece]\ntype = \"beam\"\nbetween = [\"ground\", \"a\"]\nlength = 1\n"
            "axial_stiffness = 1\nbending_stiffness = 1\n[tolerances.rod]\n"
            "key = \"beams.rod.length\"\nupper = 1e-3\nlower = -1e-4\n" +
            test::run_for(1),
        "beams"));
  const std::set<std::string> other_spellings = {"drives.*.speed_rpm",
                                                 "drives.*.torque",
                                                 "run.revolutions",
                                                 "instruments.*.counts",
                                                 "bodies.*.points",
                                                 "ground.points",
                                                 "drives.*.synchronous_speed_rpm",
                                                 "curves.*.frequency",
                                                 "curves.*.file",
                                                 "curves.*.columns",
                                                 "beams.*.frequency_range",
                                                 "beams.*.damping_ratio",
                                                 "beams.*.damping_frequency",
                                                 "groups.*.grid",
                                                 "groups.*.origin",
                                                 "groups.*.spacing",
                                                 "groups.*.stagger"};
  for (const auto& key : scene_schema().keys()) {
    CAPTURE(key.path);
    REQUIRE(written.contains(key.path) != other_spellings.contains(key.path));
  }
}

TEST_CASE("changing one number of a canonical text changes exactly that value", "[scene]") {
  const auto text = to_toml(read_scene(test::scene_file("every_key")));
  const std::regex number("-?[0-9][0-9.e+-]*");
  int numbers = 0;
  for (const auto& [key, value, line] : canonical_lines(text)) {
    if (value.empty() || value[0] == '"' || value.find('.') == value.npos || key.ends_with("axis")) continue;
    for (std::sregex_iterator it(value.begin(), value.end(), number), end; it != end; ++it) {
      const double x = std::stod(it->str());
      // The [0, 0] that these pass through.
      if (x == 0 && (key.ends_with("damping_table") || key.ends_with("radial_table"))) continue;
      // orders of harmonics
      if (x == std::floor(x) && key.ends_with("harmonics")) continue;
      // a point body has no point except its centre
      if (x == 0 && key == "joints.string.at") continue;
      auto moved = value;
      moved.replace(static_cast<std::size_t>(it->position()), static_cast<std::size_t>(it->length()),
                    fmt::format("{}{}",
                                key.ends_with("teeth") ? x + 1
                                : x == 0               ? 1.5e-3
                                                       : x * (1 + 0x1p-30),
                                key.ends_with("teeth") ? ".0" : ""));
      CAPTURE(key, moved);
      const auto again = to_toml(parse_scene(text, "again", {key + "=" + moved}));
      REQUIRE(first_difference(text, again) == fmt::format("{} is {} here and {} there", key, value, moved));
      const auto at = text.find(line, text.find("[" + key.substr(0, key.rfind('.')) + "]\n"));
      const auto tail = text.substr(key.find('.') == key.npos ? text.find(line) : at).substr(line.size());
      REQUIRE(again.ends_with(tail));  // and no later line changed
      ++numbers;
    }
  }
  REQUIRE(numbers > 120);
}

TEST_CASE("scenes with overrides are read back from their canonical text", "[scene]") {
  const std::vector<std::vector<std::string>> sets = {
      {"drives.motor.speed_rpm=-77.7", "run.revolutions=1.1", "run.discard=0.3"},
      {"drives.motor.speed_rpm=0.1", "drives.motor.initial_angle=1e-300"},
      {"penalty.contact=kelvin-voigt", "penalty.kelvin_stiffness=1e7", "penalty.kelvin_damping=3"},
      {"penalty.contact=pereira"},
      {"penalty.contact=johnson", "penalty.damping=hertz"},
      {"penalty.stabilisation=none", "penalty.integrator=rk4", "penalty.step=3e-7"},
      {"penalty.friction=lugre", "penalty.bristle_damping=1e-9"},
      {"nonsmooth.scheme=event-driven", "nonsmooth.impact_law=energetic"},
      {"run.start=ideal", "run.eliminate=false", "run.output_step=1.25e-4"},
      {"title=\"\"\"two \\\"lines\\\" and\n a \\\\, a tab \\t, é, \\u0001 and \\u007f = [x]\"\"\""},
      {"gravity=[-0.0, 5e-324]", "bodies.crank.mass=9.007199254740993e29"},
      {"bodies.crank.position=[1e9, -123456789.012345678]", "bodies.crank.angle=0.1"},
      {"bodies.crank.angle=1e9", "bodies.crank.angular_velocity=3"},
      {"instruments.eye.type=encoder", "instruments.eye.joint=main", "instruments.eye.sampling=1e4",
       "instruments.eye.counts=1023.7", "instruments.eye.noise=0", "instruments.eye.seed=4294967295"},
      {"instruments.eye.type=encoder", "instruments.eye.joint=main", "instruments.eye.sampling=1e4",
       "instruments.eye.resolution=1e-3"},
      {"instruments.eye.body=slider", "instruments.eye.axis=[1, 3]", "instruments.eye.bandwidth=10",
       "instruments.eye.sampling=1e4", "instruments.eye.order=3"},
  };
  for (const auto& overrides : sets) {
    CAPTURE(overrides);
    Scene scene;
    REQUIRE_NOTHROW(scene = read_scene(test::flores(), overrides));
    require_round_trip(scene);
  }
  const auto scene = read_scene(test::flores(), sets[9]);
  REQUIRE(written_and_read(scene).mechanism.title ==
          "two \"lines\" and\n a \\, a tab \t, é, \x01 and \x7f = [x]");
  REQUIRE(std::signbit(written_and_read(read_scene(test::flores(), sets[10])).mechanism.gravity.x()));
}

TEST_CASE("scenes built in code are read back from their canonical text", "[scene]") {
  for (const double clearance : {0.0, 1e-3}) {
    auto scene = test::row_of_four_bars(3, clearance);
    require_round_trip(scene);
    REQUIRE(written_and_read(scene).mechanism.joints.size() == scene.mechanism.joints.size());
  }

  // Random bits in every kind of number of a scene, including unit vectors: none may lose its last
  // digit.
  std::mt19937_64 random(7);
  const auto any = [&] {
    for (;;)
      if (const auto x = std::bit_cast<double>(random()); std::abs(x) <= 1e8) return x;
  };
  const auto some = [&] { return std::abs(std::remainder(any(), 1.0)) + 1e-3; };
  for (int i = 0; i < 200; ++i) {
    auto scene = read_scene(test::scene_file("every_key"));
    auto& m = scene.mechanism;
    for (auto& b : m.bodies)
      if (!b.made)
        b = {b.name, std::max(std::abs(any()), 1e-30), some(), {any(), any()}, any(), {any(), any()}, any()};
    first_drive(scene) = {"motor", first_drive(scene).joint, any(), any()};
    const double turn = any();
    std::get<TranslationalJoint>(m.joints[3]).axis = {std::cos(turn), std::sin(turn)};
    std::get<PlaneContact>(m.contacts[0]).axis = {std::sin(turn), -std::cos(turn)};
    scene.instruments[0].axis = {-std::sin(turn), std::cos(turn)};
    scene.instruments[2].resolution = some();
    scene.run.duration = 2 + some();
    scene.run.discard = some();
    scene.run.output_step = some();
    require_round_trip(scene);
    const auto again = written_and_read(scene);
    REQUIRE(same_bits(main_drive(again.mechanism)->speed, main_drive(m)->speed));
    REQUIRE(same_bits(*again.instruments[2].resolution, *scene.instruments[2].resolution));
    REQUIRE(same_bits(std::get<TranslationalJoint>(again.mechanism.joints[3]).axis.y(), std::sin(turn)));
  }
}

TEST_CASE("values that a scene cannot hold are refused on reading back", "[scene]") {
  const auto good = test::row_of_four_bars(1, 1e-3);
  const auto message = [](const Scene& scene) {
    return test::refusal_of<SceneError>([&] { written_and_read(scene); });
  };
  REQUIRE(message(good) == "accepted");
  auto bad = good;
  bad.mechanism.bodies[0].mass = std::numeric_limits<double>::quiet_NaN();
  CHECK_THAT(message(bad), Contains("bodies.upright0.mass: must be finite"));
  bad = good;
  bad.mechanism.gravity = {0, -std::numeric_limits<double>::infinity()};
  CHECK_THAT(message(bad), Contains("gravity: must be finite"));
  bad = good;
  bad.mechanism.bodies[0].name = "two \"words\"";
  CHECK_THAT(message(bad), Contains("a name must be made of letters"));
  bad = good;
  bad.mechanism.bodies[1].name = bad.mechanism.bodies[0].name;
  CHECK_THAT(message(bad), Contains("not TOML"));
  bad = good;
  std::get<RevoluteJoint>(bad.mechanism.joints.back()).clearance->surface = -1;
  CHECK_THAT(message(bad), Contains("surface: is missing"));
  std::get<RevoluteJoint>(bad.mechanism.joints.back()).clearance->surface = 8;
  CHECK_THAT(message(bad), Contains("joints.back1.surface: index 8 is out of range"));
  bad = good;
  std::get<RevoluteJoint>(bad.mechanism.joints[0]).between = {ground, 99};
  CHECK_THAT(message(bad), Contains("joints.foot0.between: index 99 is out of range"));
  bad = good;
  bad.instruments.emplace_back();
  bad.instruments[0].name = "eye";
  bad.instruments[0].kind = Instrument::Kind::encoder;
  bad.instruments[0].pair = {0, ground};
  CHECK_THAT(message(bad), Contains("instruments.eye.joint: no joint connects the two bodies"));
}

TEST_CASE("the first difference of two scenes", "[scene]") {
  const auto file = test::flores();
  const auto text = [&](const std::vector<std::string>& overrides) {
    return to_toml(read_scene(file, overrides));
  };
  const auto plain = text({});
  REQUIRE(first_difference(plain, plain).empty());
  REQUIRE(first_difference(text({"joints.gudgeon.clearance=1e-3"}), plain) ==
          "joints.gudgeon.clearance is 0.001 here and 0.00025 there");
  REQUIRE(first_difference(plain, text({"joints.gudgeon.bearing_length=0.5"})) ==
          "joints.gudgeon.bearing_length is missing here");
  REQUIRE(first_difference(text({"loads.p={type='torque',body='rod',torque=1}"}), plain) ==
          "loads.p is missing there");
  REQUIRE(first_difference(text({"title=\"a [b] = c\""}), text({"title=d"})) ==
          "title is \"a [b] = c\" here and \"d\" there");
  REQUIRE(first_difference(text({"nonsmooth.impact_law=newton", "nonsmooth.scheme=event-driven"}),
                           text({"nonsmooth.impact_law=poisson", "nonsmooth.scheme=event-driven"})) ==
          "nonsmooth.impact_law is \"newton\" here and \"poisson\" there");
  auto scene = read_scene(file);
  REQUIRE(same_facts(scene, parse_scene(plain, "elsewhere")));
  std::swap(scene.penalty.friction_v0, scene.penalty.friction_v1);
  REQUIRE_FALSE(same_facts(scene, read_scene(file)));
  auto row = test::row_of_four_bars(2, 1e-3), other = row;
  other.mechanism.surfaces.push_back(other.mechanism.surfaces[0]);
  other.mechanism.surfaces[1].name = "brass";
  auto swapped = other;
  std::swap(swapped.mechanism.surfaces[0], swapped.mechanism.surfaces[1]);
  REQUIRE(first_difference(to_toml(other), to_toml(swapped)) ==
          "surfaces.steel is before surfaces.brass here and after it there");
}

TEST_CASE("Scene::set is equivalent to --set", "[scene]") {
  const std::vector<std::pair<std::string, std::string>> keys = {
      {"drives.motor.speed_rpm", "250"},
      {"run.revolutions", "3"},
      {"run.discard", "0.5"},
      {"joints.gudgeon.clearance", "1e-3"},
      {"surfaces.steel.restitution", "0.3"},
      {"penalty.contact", "flores"},
      {"nonsmooth.scheme", "\"event-driven\""},
      {"bodies.crank.position", "[0.1, 0.2]"},
      {"bodies.crank.angle", "0.25"},
      {"title", "any words at all"},
      {"run.eliminate", "false"},
      {"loads.push", "{type = 'torque', body = 'rod', torque = 1}"},
      {"instruments.accelerometer.order", "5"},
  };
  const auto original = read_scene(test::flores());
  std::vector<std::string> overrides;
  auto all = original;
  for (const auto& [key, value] : keys) {
    CAPTURE(key, value);
    const auto expected = read_scene(test::flores(), {key + "=" + value});
    auto scene = original;
    scene.set(key, value);
    REQUIRE(first_difference(to_toml(scene), to_toml(expected)).empty());
    REQUIRE_FALSE(same_facts(scene, original));
    REQUIRE(scene.text == original.text);
    REQUIRE(scene.file == original.file);
    REQUIRE(scene.overrides == expected.overrides);

    overrides.push_back(key + "=" + value);  // and cumulative overrides
    all.set(key, value);
    REQUIRE(first_difference(to_toml(all), to_toml(read_scene(test::flores(), overrides))).empty());
    REQUIRE(all.overrides == overrides);
  }

  auto scene = original;  // the same number of revolutions takes less time at a greater speed
  scene.set("drives.motor.speed_rpm", 400);
  REQUIRE(scene.run.duration == Approx(original.run.duration / 2));
  REQUIRE(scene.run.discard == Approx(original.run.discard / 2));
  scene.set("drives.motor.speed_rpm", 200);
  REQUIRE(same_facts(scene, original));
}

TEST_CASE("a refused call of Scene::set leaves the scene unchanged", "[scene]") {
  const auto read = read_scene(test::flores(), {"joints.gudgeon.clearance=1e-3"});
  auto changed = read;
  changed.mechanism.bodies[0].mass = 3;
  auto built = test::row_of_four_bars(1, 1e-3);
  for (const auto& original : {read, changed, built}) {
    auto scene = original;
    const std::vector<std::array<std::string, 3>> bad = {
        {"penalty.contcat", "flores", "did you mean contact?"},
        {"penalty.contact", "rubber", "is unknown"},
        {"surfaces.steel.restitution", "1.5", "must be between 0 and 1"},
        {"gravity", "9.81", "must be a pair"},
        {"run.discard", "1e9", "must be less than the length of the run"},
        {"run.duration", "-1", ""},
        {"run.revolutions", "-1", ""},
        {"", "1", "must be KEY=VALUE"},
        {"gravity", "", "has no value"},
        {"a=b", "1", "has no ="},
        {"title.x", "1", "is a value, not a table"},
        {"gravity", "[1, 2]\ntitle = \"x\"", "must set one value"},
    };
    for (const auto& [key, value, why] : bad) {
      CAPTURE(key, value);
      const auto message = refusal(scene, key, value);
      CHECK_THAT(message, StartsWith("--set " + visible(key + "=" + value) + ": "));
      CHECK_THAT(message, Contains(why));
      REQUIRE(same_facts(scene, original));
      REQUIRE(scene.text == original.text);
      REQUIRE(scene.file == original.file);
      REQUIRE(scene.overrides == original.overrides);
    }
  }
  // A value elsewhere that conflicts with the key: the message contains the override, and the
  // place.
  auto scene = read;
  REQUIRE_THAT(refusal(scene, "joints.gudgeon.clearance", "1"),
               StartsWith("--set joints.gudgeon.clearance=1: ") && Contains("scene.toml:") &&
                   Contains("joints.gudgeon.bearing_radius: must be greater than the clearance"));
  REQUIRE(same_facts(scene, read));
}

TEST_CASE("Scene::set keeps changes made in code", "[scene]") {
  const auto read = read_scene(test::flores(), {"joints.gudgeon.clearance=1e-3"});
  auto scene = read;
  scene.mechanism.bodies[0].mass = 3;
  scene.penalty.tolerance = 1e-7;
  scene.set("surfaces.steel.friction", 0.2);
  REQUIRE(scene.mechanism.bodies[0].mass == 3);
  REQUIRE(scene.penalty.tolerance == 1e-7);
  REQUIRE(*scene.mechanism.surfaces[0].friction == 0.2);
  REQUIRE(std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->radial == 1e-3);
  REQUIRE(scene.file == read.file);
  REQUIRE(scene.text == to_toml(scene));  // the text read before no longer describes the scene
  REQUIRE(scene.overrides.empty());

  // Any spelling, in any order; the duration is now a separate value.
  const double duration = scene.run.duration, discard = scene.run.discard;
  scene.set("drives.motor.speed_rpm", 120);
  REQUIRE(same_bits(first_drive(scene).speed, 120.0 * 2 * std::numbers::pi / 60));
  REQUIRE(scene.run.duration == duration);
  scene.set("run.revolutions", 10);
  REQUIRE(scene.run.duration == Approx(5));
  REQUIRE(scene.run.discard == discard);
  scene.set("run.duration", 4);
  scene.set("drives.motor.speed", 10);
  REQUIRE(scene.run.duration == 4);
  REQUIRE(first_drive(scene).speed == 10);
  REQUIRE(scene.mechanism.bodies[0].mass == 3);
  REQUIRE_THAT(refusal(scene, "run.revolutions", "1e-3"), Contains("run.discard: must be less"));

  // Changed again after set.
  scene.mechanism.bodies[1].mass = 5;
  scene.set("title", "changed");
  REQUIRE(scene.mechanism.bodies[1].mass == 5);
  REQUIRE(scene.mechanism.title == "changed");

  auto keyed = read_scene(test::scene_file("every_key"));
  keyed.mechanism.gravity = {0, -1};
  keyed.set("instruments.encoder.counts", 100);
  REQUIRE(*keyed.instruments[2].resolution == 2 * std::numbers::pi / 100);
  keyed.set("drives.brake.torque", 0.5);
  keyed.set("drives.spin.torque_table", "[[0, 1], [1, 2]]");
  keyed.set("drives.spin.against", "angle");
  REQUIRE(std::get<TorqueDrive>(keyed.mechanism.drives[1]).table.size() == 1);
  REQUIRE(std::get<TorqueDrive>(keyed.mechanism.drives[2]).table.size() == 2);
  REQUIRE_THAT(refusal(keyed, "drives.motor.torque", "1"), Contains("needs exactly one of"));
}

TEST_CASE("naming the default scheme explicitly gives the same canonical text", "[write_scene]") {
  const auto text = [](std::vector<std::string> set) {
    return to_toml(parse_scene("[bodies.b]\nmass = 1\ninertia = 1\n[run]\nduration = 1\n", "s.toml", set));
  };
  const std::string step = "nonsmooth.step=1e-5", chosen = "nonsmooth.step='automatic'";
  REQUIRE(text({step}) == text({step, "nonsmooth.scheme='moreau-jean'"}));
  // which does not read it
  REQUIRE_THROWS_AS(text({step, "nonsmooth.scheme='automatic'"}), SceneError);
  REQUIRE(text({chosen}) == text({chosen, "nonsmooth.scheme='automatic'"}));
  REQUIRE(text({chosen}) != text({chosen, "nonsmooth.scheme='moreau-jean'"}));
}
