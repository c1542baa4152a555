// Loads and wear of bearings, against closed forms in both formulations: a journal that turns under its
// weight, an impact, a bearing touched on both sides, turns of a drive, and restored observers.
#include "simulation/bearing_load.hpp"

#include "facade/run_folder.hpp"
#include "simulation/bearing_pressure.hpp"
#include "simulation/pressure_table.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double g = 9.81, R = 0.02, c = 1e-3, mass = 2, length = 0.02, k_b = 1e-15, k_j = 3e-16;
constexpr double modulus = 2e11 / (2 * (1 - 0.3 * 0.3));

/// A frictionless journal in a bearing of the ground, which turns at `spin`.
std::string journal(Vec2 place, Vec2 velocity, double spin, Vec2 gravity, double restitution,
                    const std::string& run, const std::string& keys = "", const std::string& surface = "") {
  return fmt::format("gravity = [{:.17g}, {:.17g}]\n", gravity.x(), gravity.y()) +
         test::body("shaft", mass, 1e-4,
                    fmt::format("position = [{:.17g}, {:.17g}]\nvelocity = [{:.17g}, {:.17g}]\nangle = 0\n"
                                "angular_velocity = {:.17g}\n",
                                place.x(), place.y(), velocity.x(), velocity.y(), spin)) +
         test::surface("s", restitution, "young = 2e11\npoisson = 0.3\n" + surface) +
         test::pin("pin", "ground", "shaft", {}, {},
                   test::loose(c, R) + fmt::format("bearing_length = {}\nbearing_wear = {}\n", length, k_b) +
                       keys) +
         run;
}
const std::string journal_wears = fmt::format("journal_wear = {}\n", k_j);

BearingLoads loads_of(const Scene& scene, Family family) {
  BearingLoadObserver observer(scene);
  Simulation simulation(scene, test::name_of(family));
  test::finished(simulation, {&observer});
  const auto list = observer.loads();
  REQUIRE(list.size() == 1);
  return list[0];
}
BearingLoads loads_of(const test::Way& way, const std::string& text) {
  return loads_of(test::scene_by(way, text), way.family);
}
double total(const BearingLoads& loads, double BearingLoad::*part) {
  double sum = 0;
  for (const auto& one : loads.loads) sum += one.*part;
  return sum;
}

}  // namespace

TEST_CASE("a journal that turns under its weight wears its bearing at one place and itself evenly",
          "[wear]") {
  // The direction is inside a class. The journal makes one turn after the discarded start.
  const double direction = 0.3005, spin = 20 * M_PI, T = 0.1;
  const Vec2 down{std::cos(direction), std::sin(direction)};
  const auto text =
      journal(c * down, {0, 0}, spin, g * down, 0.3,
              test::run_for(2 * T, fmt::format("start = \"given\"\ndiscard = {}\n", T)), journal_wears);
  const double force = mass * g, sliding = (R - c) * spin * T, work = force * sliding;
  for (const auto& way :
       {test::event_driven, test::automatic, test::chosen_steps, test::fixed_steps(1e-4), test::penalty}) {
    CAPTURE(way.name);
    const auto loads = loads_of(way, text);
    CHECK(loads.joint == "pin");
    CHECK(loads.time == Approx(T).epsilon(1e-9));
    CHECK_FALSE(loads.merged);
    // A rigid journal rests. On the contact law it may oscillate about its rest δ = (m g/K)^(2/3) = 3.6e-7 m
    // with a speed of at most √(1.2 g δ) = 2.1e-3 m/s, which changes the impulse by 4.2e-3/(g T).
    const double bound = way.penalty() ? 6e-3 : 1e-6;
    CHECK(total(loads, &BearingLoad::work) == Approx(work).epsilon(bound));
    CHECK(total(loads, &BearingLoad::impulse) == Approx(force * T).epsilon(bound));
    if (!way.penalty()) CHECK(loads.sliding == Approx(sliding).epsilon(1e-6));
    double steady = 0;
    for (const auto& one : loads.loads) {
      CHECK(std::remainder(one.on_bearing - direction, 2 * M_PI) == Approx(0).margin(1e-6));
      CHECK(one.width_on_bearing < 1e-5);
      // an even distribution over a degree, by samples four times as dense
      CHECK(one.width_on_journal < 1.2 * M_PI / 180);
      if (!way.penalty()) CHECK(one.force == Approx(force).epsilon(1e-6));
      if (one.work > 0.5 * work / 360) ++steady;
    }
    CHECK(steady >= 359);
    CHECK(steady <= 361);

    const auto surfaces = pressures(test::scene_by(way, text), {loads}).at(0);
    REQUIRE(surfaces.journal);
    double on_bearing = 0, on_journal = 0, mean = 0;
    const double step = 2 * M_PI / pressure_angles;
    for (std::size_t k = 0; k < pressure_angles; ++k) {
      on_bearing += surfaces.bearing.wear_rate[k] * R * step;
      on_journal += surfaces.journal->wear_rate[k] * (R - c) * step;
      mean +=
          surfaces.bearing.mean[k] * length * R * step * std::cos(step * static_cast<double>(k) - direction);
      // Even wear of the journal. Samples every quarter of a degree differ by 5 % from class to class, and
      // the widths of neighbouring classes leave gaps of 3 %.
      CHECK(surfaces.journal->wear_rate[k] ==
            Approx(k_j * work / (length * T * 2 * M_PI * (R - c))).epsilon(0.08));
    }
    // Archard's law: the worn area is k F s/L.
    CHECK(on_bearing == Approx(k_b * work / (length * T)).epsilon(bound));
    CHECK(on_journal == Approx(k_j * work / (length * T)).epsilon(bound));
    CHECK(mean == Approx(force).epsilon(bound + 1e-4));  // the hat functions
    // The contact is narrower than a degree: 0.2°.
    const auto worn = std::ranges::count_if(surfaces.bearing.wear_rate, [](double w) { return w > 0; });
    CHECK(worn <= 4);
    CHECK(surfaces.bearing.greatest[static_cast<std::size_t>(std::lround(direction / step))] > 0);
    if (!way.penalty()) {
      const double a = std::sqrt(4 * force * R * (R - c) / c / (M_PI * modulus * length));
      CHECK(surfaces.greatest == Approx(3 * M_PI / 8 * 2 * force / (M_PI * a * length)).epsilon(1e-3));
    }
  }
}

TEST_CASE("an impact wears by its impulse times the sliding speed", "[wear]") {
  // The journal flies from the middle along x and touches once: P = m (1 + e) v, v_T = R_j ω.
  const double v = 0.3, spin = 40, e = 0.6, touch = c / v;
  const auto run = test::run_for(1.5 * touch, "start = \"given\"\n");
  const double impulse = mass * (1 + e) * v, work = impulse * (R - c) * spin;
  const auto text = journal({0, 0}, {v, 0}, spin, {0, 0}, e, run, journal_wears);
  for (const auto& way : {test::event_driven, test::automatic, test::fixed_steps(1e-5), test::penalty}) {
    CAPTURE(way.name);
    const auto loads = loads_of(way, text);
    REQUIRE_FALSE(loads.loads.empty());
    // the force on a contact law by Gauss's rule from its onset, where it grows as the power 3/2 of the depth
    const double bound = way.penalty() ? 1e-4 : 1e-9;
    CHECK(total(loads, &BearingLoad::work) == Approx(work).epsilon(bound));
    CHECK(total(loads, &BearingLoad::impulse) == Approx(impulse).epsilon(bound));
    for (const auto& one : loads.loads) CHECK(one.on_bearing == Approx(0).margin(1e-6));
    if (way.penalty()) continue;
    REQUIRE(loads.loads.size() == 1);
    // The journal has turned by ω c/v. A fixed step places the impact within itself.
    CHECK(loads.loads[0].on_journal ==
          Approx(-spin * touch).epsilon(0).margin(way.fixed() ? 1e-5 * spin : 1e-9));
    // Linear contact F = (π/2) E* L δ: F_max = v √(m k), mean of F² over F for a half sine π/4.
    CHECK(loads.loads[0].force ==
          Approx(M_PI / 4 * v * std::sqrt(mass * M_PI / 2 * modulus * length)).epsilon(1e-6));
    CHECK(loads.sliding == 0);
  }
}

TEST_CASE("the force that an impact stands for is that of the elastic foundation's own impact", "[wear]") {
  // Without loss, the nonsmooth estimate is the mean of F² over F of the penalty run. δ/c is 0.02, over which
  // the exponent of F(δ) varies by 0.01.
  const auto layer = "layer_modulus = 2e9\nlayer_poisson = 0.4\nlayer_thickness = 1e-3\n";
  const auto text = journal({0, 0}, {0.3, 0}, 40, {0, 0}, 1,
                            test::run_for(1.5 * c / 0.3, "start = \"given\"\n"), "", layer) +
                    "[penalty]\ncontact = \"elastic-foundation\"\nintegrator = \"dopri5\"\n";
  const auto rigid = loads_of(test::event_driven, text), soft = loads_of(test::penalty, text);
  REQUIRE(rigid.loads.size() == 1);
  CHECK(rigid.merged);
  double squares = 0;
  for (const auto& one : soft.loads) squares += one.force * one.work;
  const double work = total(soft, &BearingLoad::work);
  CHECK(work == Approx(rigid.loads[0].work).epsilon(1e-4));
  CHECK(squares / work == Approx(rigid.loads[0].force).epsilon(5e-3));
  CHECK(soft.sliding > 0);
  // The contact is 8 mm wide: α = acos(1/1.02). A layer of 1 m has the same K with a thousandfold modulus.
  const auto notes_on = [&](const std::string& scene_text) {
    const auto scene = test::scene_by(test::event_driven, scene_text);
    Result result;
    into(result, scene, {rigid}, pressures(scene, {rigid}));
    return test::notes_of(result);
  };
  CHECK(notes_on(text).empty());
  CHECK_THAT(notes_on(test::replaced(test::replaced(text, "thickness = 1e-3", "thickness = 1"),
                                     "layer_modulus = 2e9", "layer_modulus = 2e12")),
             Contains("the elastic layer is 1e+03 mm thick"));
}

TEST_CASE("a journal that rests on both sides of an oval bearing wears it by the resultant", "[wear]") {
  // p = a cos 2φ with a = c/2 and weight along x: e = √(8a(c − a)), contacts at the angles ± acos(e/4a) =
  // ±45°.
  const double a = 0.5 * c, e = std::sqrt(8 * a * (c - a)), spin = 30, T = 0.1;
  const auto text = journal({e, 0}, {0, 0}, spin, {g, 0}, 0, test::run_for(T, "start = \"given\"\n"),
                            "bearing_profile = \"oval\"\n") +
                    fmt::format("[profiles.oval]\nharmonics = [[2, {:.17g}, 0]]\n", a);
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto loads = loads_of(way, text);
    const double force = mass * g;
    CHECK(total(loads, &BearingLoad::work) == Approx(force * (R - c) * spin * T).epsilon(1e-3));
    const auto surfaces = pressures(test::scene_by(way, text), {loads}).at(0);
    CHECK_FALSE(surfaces.journal);
    CHECK(surfaces.omitted == 0);
    Vec2 sum{0, 0};
    const double step = 2 * M_PI / pressure_angles;
    for (std::size_t k = 0; k < pressure_angles; ++k) {
      const double phi = std::remainder(step * static_cast<double>(k), 2 * M_PI);
      sum += surfaces.bearing.mean[k] * length * R * step * Vec2{std::cos(phi), std::sin(phi)};
      // Polar angle of the place with the normal at 45°, where p′ = −2a: 45° + p′/R = 42°; the contacts are
      // 0.3° wide, and the hat functions 1°.
      if (surfaces.bearing.mean[k] > 0)
        CHECK(std::abs(phi) == Approx(M_PI / 4 - 2 * a / R).epsilon(0).margin(1.5 * M_PI / 180));
    }
    CHECK(sum.x() == Approx(force).epsilon(2e-3));
    CHECK(sum.y() == Approx(0).margin(2e-3 * force));
  }
}

TEST_CASE("the loads of the turns of a drive add up to those of the run", "[wear]") {
  const std::vector<std::string> sets{"joints.gudgeon.bearing_length=0.02",
                                      "joints.gudgeon.bearing_wear=1e-15", "run.revolutions=2.5",
                                      "run.discard=0.5"};
  for (const auto& way : {test::penalty, test::fixed_steps(1e-5)}) {
    CAPTURE(way.name);
    auto scene = read_scene(test::flores(), sets);
    way.choose(scene);
    const auto loads = loads_of(scene, way.family);
    REQUIRE(loads.work_of_turns.size() == 2);
    CHECK(loads.work_of_turns[0] + loads.work_of_turns[1] ==
          Approx(total(loads, &BearingLoad::work)).epsilon(1e-9));
    for (const double work : loads.work_of_turns) CHECK(work > 0);
  }
}

TEST_CASE("a restored observer of loads continues bit for bit", "[wear]") {
  auto scene = read_scene(test::flores(),
                          {"joints.gudgeon.bearing_length=0.02", "joints.gudgeon.bearing_wear=1e-15",
                           "joints.gudgeon.journal_wear=1e-15", "run.revolutions=0.5", "run.discard=0"});
  for (const auto& way : {test::penalty, test::event_driven}) {
    CAPTURE(way.name);
    way.choose(scene);
    BearingLoadObserver whole(scene), first(scene), second(scene);
    Simulation simulation(scene, test::name_of(way.family));
    const double half = 0.5 * scene.run.duration;
    simulation.run({.until = half, .observers = {&whole, &first}});
    std::vector<std::byte> bytes;
    MemoryWriter writer(bytes);
    first.save(writer);
    MemoryReader reader(bytes);
    second.load(reader);
    CHECK(reader.at_end());
    simulation.run({.observers = {&whole, &second}});
    const auto a = whole.loads().at(0), b = second.loads().at(0);
    REQUIRE(a.loads.size() == b.loads.size());
    CHECK(a.sliding == b.sliding);
    CHECK(a.time == b.time);
    for (std::size_t k = 0; k < a.loads.size(); ++k) {
      CHECK(a.loads[k].work == b.loads[k].work);
      CHECK(a.loads[k].force == b.loads[k].force);
      CHECK(a.loads[k].on_journal == b.loads[k].on_journal);
    }
  }
}

TEST_CASE("run folders have pressures of bearings that wear, and no others", "[wear]") {
  const test::TemporaryFolder folder;
  const auto run = [&](const std::vector<std::string>& sets, const char* name) {
    auto all = sets;
    all.insert(all.end(), {"run.revolutions=0.25", "run.discard=0"});
    const auto scene = read_scene(test::flores(), all);
    CHECK(BearingLoadObserver::needed(scene) == !sets.empty());
    run_scene(scene, {.formulation = "nonsmooth", .folder = folder.path() / name});
    return test::files_of(folder.path() / name);
  };
  const auto plain = run({}, "plain");
  CHECK_FALSE(plain.contains("pressure.csv"));
  CHECK_FALSE(nlohmann::json::parse(plain.at("run.json")).contains("bearings"));
  const auto worn = run({"joints.gudgeon.bearing_length=0.02", "joints.gudgeon.bearing_wear=1e-15"}, "worn");
  // observation does not change the motion
  CHECK(worn.at("trajectory.csv") == plain.at("trajectory.csv"));
  const auto lines = test::lines_of(worn.at("pressure.csv"));
  REQUIRE(lines.size() == pressure_angles + 1);
  CHECK(lines[0] ==
        "angle,gudgeon.bearing.pressure_greatest,gudgeon.bearing.pressure_mean,gudgeon.bearing.sliding,"
        "gudgeon.bearing.wear_rate");
  const auto document = nlohmann::json::parse(worn.at("run.json"));
  const auto& bearing = document["bearings"]["gudgeon"];
  const double time = bearing["observed_s"], work = bearing["force_times_sliding_N_m"];
  CHECK(bearing["bearing_wear_rate_m2_per_s"].get<double>() == Approx(1e-15 * work / (0.02 * time)));
  CHECK_FALSE(bearing.contains("journal_wear_rate_m2_per_s"));
}

TEST_CASE("wear is refused without the data that it needs", "[wear]") {
  const auto said = [](const std::string& keys,
                       const std::string& surface = "young = 2e11\npoisson = 0.3\n") {
    return test::refusal(
        test::body("shaft", 1, 1) + test::surface("s", 0.5, surface) + "[lubricants.oil]\nviscosity = 0.1\n" +
        test::pin("pin", "ground", "shaft", {}, {}, test::loose(c, R) + keys) + test::run_for(1));
  };
  const std::string wear = "bearing_wear = 1e-15\n", wide = "bearing_length = 0.02\n";
  CHECK(said(wear + wide) == "accepted");
  CHECK_THAT(said(wear), Contains("joints.pin.bearing_wear: needs bearing_length"));
  CHECK_THAT(said("journal_wear = 1e-15\n"), Contains("joints.pin.journal_wear: needs bearing_length"));
  CHECK_THAT(said(wear + wide + "lubricant = \"oil\"\n"),
             Contains("joints.pin.bearing_wear: cannot be combined with a lubricant"));
  CHECK_THAT(said("bearing_wear = -1e-15\n" + wide),
             Contains("joints.pin.bearing_wear: must be 0 or greater"));
  CHECK_THAT(said("bearing_wear = \"1 m\"\n" + wide), Contains("must be a wear coefficient"));
  CHECK_THAT(said(wear + wide, ""),
             Contains("surfaces.s.young: is missing: the pressure in the bearing \"pin\""));
  CHECK(said(wear + wide, "layer_modulus = 2e9\nlayer_poisson = 0.4\nlayer_thickness = 1e-3\n") ==
        "accepted");
  CHECK(said("bearing_wear = \"1e-6 mm³/N/m\"\n" + wide) == "accepted");
}
