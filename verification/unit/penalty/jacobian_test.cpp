// The exact Jacobian of the penalty formulation against central differences of its right-hand side,
// for every contact law, friction law and film, on a mechanism with loops, drives, springs and
// dampers.
#include "dynamics/system.hpp"
#include "formulations/penalty/dynamics.hpp"
#include "mechanism/laws.hpp"
#include "verification/support/jacobian_check.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene scene_with(const std::string& penalty, const std::string& lubricant) {
  return parse_scene(test::two_bodies() +
                         test::surface("steel", 0.6,
                                       "young = 2e5\npoisson = 0.3\nfriction = 0.3\nlayer_modulus = 2e5\n"
                                       "layer_poisson = 0.3\nlayer_thickness = 0.1\n") +
                         "[lubricants.oil]\nviscosity = 0.1\n" + lubricant + "\n" +
                         test::pin("loose", "ground", "b", {0.0, 0.1}, {0.2, 0.1},
                                   test::loose(0.3, 0.6, "steel") + "bearing_length = 0.2\n") +
                         (lubricant.empty() ? "" : "lubricant = \"oil\"\n") +
                         test::drive("motor", "pin", "torque_table = [[0.0, 0.2], [1.0, 1.4]]\n") +
                         test::spring("spring", "a", "b", {0.3, 0.1}, {0.2, -0.3}, 40, 0.2, "damping = 3\n") +
                         test::torsion("torsion", "ground", "b", 3, "damping = 0.4\nfree_angle = 0.1\n") +
                         test::joint_friction("rub", "slide", "force = 5\nregularisation = 10.0\n") +
                         test::run_for(1) + "[penalty]\n" + penalty,
                     "jacobian");
}

struct Setting {
  std::string penalty, lubricant;
  ContactLaw contact = ContactLaw::flores;
  std::string law = {};
  FrictionLaw friction = FrictionLaw::ambrosio;
};

}  // namespace

TEST_CASE("the exact Jacobian equals differences of the right-hand side for every contact and friction law",
          "[penalty][jacobian]") {
  std::vector<Setting> settings;
  for (const auto& law : contact_laws())
    settings.push_back({law.kind == ContactKind::spring_damper
                            ? "contact = \"kelvin-voigt\"\nkelvin_stiffness = 1e4\nkelvin_damping = 10.0\n"
                            : "",
                        "", law.law, std::string(law.text)});
  const std::pair<std::string_view, std::string_view> keys[] = {
      {"friction_v0", "0.5"},    {"friction_v1", "2.0"},      {"friction_static", "1.4"},
      {"friction_decay", "0.5"}, {"friction_viscous", "0.1"}, {"bristle_stiffness", "10.0"},
      {"bristle_damping", "0.3"}};
  for (const auto& law : friction_laws()) {
    std::string text = "friction = \"" + std::string(law.text) + "\"\n";
    for (const auto& [key, value] : keys)
      if (law.reads(key)) text += std::string(key) + " = " + std::string(value) + "\n";
    settings.push_back({text, "", ContactLaw::flores, std::string(law.text), law.law});
  }
  for (const char* film : {"short", "long"})
    for (const char* cavitation : {"half-sommerfeld", "none"})
      settings.push_back({"", std::string("film = \"") + film + "\"\ncavitation = \"" + cavitation +
                                  "\"\nhand_over = 0.05\n"});
  const auto setting = GENERATE_COPY(from_range(settings));
  CAPTURE(setting.law, setting.lubricant);
  auto scene = scene_with(setting.penalty, setting.lubricant);
  scene.penalty.contact = setting.contact;
  scene.penalty.friction = setting.friction;
  const System system(scene.mechanism);
  std::mt19937 engine(20261121);
  std::uniform_real_distribution<double> uniform(-1, 1);

  for (int trial = 0; trial < 4; ++trial) {
    std::vector<PenaltyContact> contacts(1);
    auto& c = contacts[0];
    c.law = make_contact_force(scene, system.contact_facts(0));
    if (facts_of(scene.penalty.friction).compliant)
      c.shear = ShearSpring{0.3, 0.8, c.law.elastic.exponent, 0};
    else
      c.friction = make_friction(scene.penalty, 0.3);
    if (!setting.lubricant.empty()) {
      const auto& oil = *system.contact_facts(0).lubricant;
      c.film = Film{
          oil.film == Lubricant::Film::short_bearing ? Film::Kind::short_bearing : Film::Kind::long_bearing,
          oil.cavitation == Lubricant::Cavitation::half_sommerfeld,
          oil.viscosity,
          0.2,
          0.6,
          0.3,
          *oil.hand_over};
    }
    PenaltyDynamics f(system, scene.penalty, contacts, RowFacts{false});
    PenaltyDynamics::Vector x(f.size());
    for (auto& y : x) y = uniform(engine);
    // The journal of b is at (0, 0.1) + e: in contact by a twentieth of its clearance, or within a
    // film.
    const double angle = 3 * uniform(engine), theta = x[5];
    const double length = trial == 0 && c.film ? 0.2 : trial == 1 && c.film ? 0.27 : 0.315;
    x[3] = length * std::cos(angle) - (0.2 * std::cos(theta) - 0.1 * std::sin(theta));
    x[4] = 0.1 + length * std::sin(angle) - (0.2 * std::sin(theta) + 0.1 * std::cos(theta));
    f.contacts()[0].closed = length > 0.3;
    f.contacts()[0].v0 = 2.0;
    const double t = 0.4;
    const auto& row = f.contact_rows.at(0, x, t);
    f.contacts()[0].zone = c.shear ? trial % 3 - 1 : c.friction->zone(row.tangent.dot(x.data() + system.n()));

    CAPTURE(trial);
    CHECK(test::jacobian_error(f, x, t) < 1e-6);
  }
}
