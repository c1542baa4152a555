// Numbers with a unit as text: conversion of every unit in both directions, digits, dimensions, and
// their places in a scene.
#include "io/scene/quantity.hpp"

#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

double read(std::string_view text, std::string_view unit) {
  const auto q = read_quantity(text, unit);
  CAPTURE(text, unit, q.wrong);
  REQUIRE(q.wrong.empty());
  return q.value;
}
std::string wrong(std::string_view text, std::string_view unit) { return read_quantity(text, unit).wrong; }

std::string scene_text(const std::string& clearance) {
  return "[bodies.a]\nmass = \"500 g\"\ninertia = \"5 kg cm2\"\n" +
         test::body("b", 0.5, 5e-4, "angle = \"60 deg\"\n") + test::pin("pivot", "ground", "a") +
         "[joints.loose]\ntype = \"revolute\"\nbetween = [\"a\", \"b\"]\n"
         "at = [[\"50 mm\", 0], [0, \"-5 cm\"]]\nclearance = " +
         clearance +
         "\nbearing_radius = \"1 cm\"\nsurface = \"steel\"\n[surfaces.steel]\n"
         "young = \"207 GPa\"\npoisson = \"30 %\"\n" +
         test::drive("motor", "pivot", "speed = \"120 rpm\"\n") +
         "[run]\nduration = \"200 ms\"\ndiscard = \"0.1 s\"\n";
}

}  // namespace

TEST_CASE("every unit converts to itself, with every prefix and power", "[units]") {
  int read_back = 0;
  for (const auto& u : named_units()) {
    const std::string symbol(u.symbol);
    CAPTURE(symbol);
    // A unit in itself has the value 1; squared and inverse, likewise.
    CHECK(read("1 " + symbol, symbol) == 1);
    CHECK(read("-2.5e3 " + symbol + "2", symbol + "^2") == -2500);
    CHECK(read("3/" + symbol, "1/" + symbol) == 3);
    CHECK(read("3 " + symbol + "^-1", "1/" + symbol) == 3);
    if (u.prefixes)
      for (const auto& [prefix, factor] :
           {std::pair{"k", 7e3}, {"m", 7e-3}, {"µ", 7e-6}, {"M", 7e6}, {"n", 7e-9}}) {
        CHECK(read(fmt::format("7 {}{}", prefix, symbol), symbol) == factor);
        // In both directions: 7 of the small ones, and the number that makes 7 of the large ones.
        const double there = read(fmt::format("7 {}", symbol), prefix + symbol);
        CHECK(read(fmt::format("{} {}{}", there, prefix, symbol), symbol) == Approx(7).epsilon(1e-15));
        ++read_back;
      }
    if (!u.means.empty()) {
      const double there = read("1 " + symbol, u.means), back = read("1 " + std::string(u.means), symbol);
      CHECK(there * back == Approx(1).epsilon(4e-16));
      ++read_back;
    }
  }
  CHECK(read_back > 50);
}

TEST_CASE("values of units agree with the standards", "[units]") {
  const double pi = std::numbers::pi;
  // to the last bit: the digits are shifted before they are read
  CHECK(read("0.1 mm", "m") == 0.1e-3);
  CHECK(read("0.3 mm", "m") == 0.3e-3);
  CHECK(read("207 GPa", "Pa") == 207e9);
  CHECK(read("5 kg cm2", "kg m²") == 5e-4);
  CHECK(read("5 kg·cm²", "kg m²") == 5e-4);
  CHECK(read("5 kg*cm^2", "kg m²") == 5e-4);
  CHECK(read("10 N/mm", "N/m") == 1e4);
  CHECK(read("60 deg", "rad") == 60 * pi / 180);
  CHECK(read("60°", "rad") == 60 * pi / 180);
  CHECK(read("120 rpm", "rad/s") == 120 * 2 * pi / 60);
  CHECK(read("20 rad/s", "rpm") == Approx(20 * 60 / (2 * pi)).epsilon(4e-16));
  CHECK(read("9.81 m/s^2", "m/s²") == 9.81);
  CHECK(read("981 cm s^-2", "m/s²") == 9.81);
  CHECK(read("1 rev/s", "rad/s") == 2 * pi);
  CHECK(read("2 deg", "degrees") == 2);
  CHECK(read("30 cP", "Pa s") == 0.03);
  CHECK(read("1 kN m/rad", "N m/rad") == 1000);
  // NIST Special Publication 811, appendix B: exact except for psi.
  CHECK(read("1 in", "m") == 0.0254);
  CHECK(read("1 ft", "m") == 0.3048);
  CHECK(read("1 lb", "kg") == 0.45359237);
  CHECK(read("1 lbf", "N") == Approx(4.4482216152605).epsilon(1e-15));
  CHECK(read("1 kgf", "N") == 9.80665);
  CHECK(read("1 psi", "Pa") == Approx(6894.757).epsilon(1e-7));
  CHECK(read("1 lbf/in", "N/m") == Approx(175.1268).epsilon(5e-7));  // seven digits
  CHECK(read("2 min", "s") == 120);
  CHECK(read("1 h", "s") == 3600);
  CHECK(read("46 %", "") == 0.46);
  CHECK(read("24 V", "V") == 24);
  CHECK(read("20 mH", "H") == 0.02);
  CHECK(read("1.5 kΩ", "ohm") == 1500);
  CHECK(read("50 N mm/A", "N m/A") == 0.05);
  CHECK(read("2 mV s/rad", "V s/rad") == 0.002);
  CHECK(read("12 V/rpm", "V s/rad") == Approx(12 * 60 / (2 * pi)).epsilon(4e-16));
}

TEST_CASE("wrong dimensions, unknown units and missing units are refused by name", "[units]") {
  CHECK_THAT(wrong("0.1 kg", "m"), Contains("\"0.1 kg\" is a mass, must be a length"));
  CHECK_THAT(wrong("50 Hz", "rad/s"), Contains("is a frequency, must be an angular velocity"));
  CHECK_THAT(wrong("3 N m", "N m/rad"), Contains("is a torque or an energy, must be a torsional stiffness"));
  CHECK_THAT(wrong("1 kg m^-4", "m"), Contains("is a quantity in kg m^-4"));
  CHECK_THAT(wrong("12 V", "ohm"), Contains("\"12 V\" is a voltage, must be a resistance"));
  CHECK_THAT(wrong("0.05 N m", "N m/A"), Contains("must be a torque per current"));
  CHECK_THAT(wrong("3 furlong", "m"), Contains("\"furlong\" is not a known unit; must be a length"));
  CHECK_THAT(wrong("0.1", "m"), Contains("must be a number, is a text") && Contains("has no unit"));
  CHECK_THAT(wrong("1", ""), Contains("must be a number, is a text"));
  for (const auto* bad : {"1 m/", "1 m//s", "1 m^", "1 m^-", "1 m^x", "1 mm m?", "1 1",
                          "1 m2m2m2m2m2m2m2m2m2", "1 \x1b[31m", "1 m\n", "1 \xff", "1e3e3 m", "1 kkg"})
    CHECK(!wrong(bad, "m").empty());
  CHECK_THAT(wrong("3 s", "as the length"), Contains("must be a number without a unit here"));
  CHECK(std::isinf(read("1e400 m", "m")));
  CHECK(read("1e-99999999999999999999 m", "m") == 0);
}

TEST_CASE("numbers of a scene may have units, with bit-identical values in SI", "[units][scene]") {
  auto scene = parse_scene(scene_text("\"0.1 mm\""), "s.toml");
  const auto& m = scene.mechanism;
  CHECK(m.bodies[0].mass == m.bodies[1].mass);
  CHECK(m.bodies[0].inertia == m.bodies[1].inertia);
  CHECK(m.bodies[1].angle == 60 * std::numbers::pi / 180);
  const auto& clearance_joint = std::get<RevoluteJoint>(m.joints[1]);
  CHECK(clearance_joint.at[0].x() == 0.05);
  CHECK(clearance_joint.at[1].y() == -0.05);
  CHECK(clearance_joint.clearance->radial == 1e-4);
  CHECK(*m.surfaces[0].young == 207e9);
  CHECK(*m.surfaces[0].poisson == 0.3);
  CHECK(main_drive(m)->speed == SpeedDrive::from_rpm(120));
  CHECK(scene.run.duration == 0.2);
  CHECK(scene.run.discard == 0.1);
  // The canonical text is in SI and without units.
  const auto text = to_toml(scene);
  CHECK_THAT(text, Contains("clearance = 0.0001\n") && Contains("at = [[0.05, 0.0], [0.0, -0.05]]"));
  CHECK(same_facts(parse_scene(text, "again"), scene));
  // On the command line, alone or in a point.
  scene.set("joints.loose.clearance", "0.2 mm");
  scene.set("joints.loose.at", "[[\"5 cm\", 0], [0, \"-50 mm\"]]");
  CHECK(std::get<RevoluteJoint>(scene.mechanism.joints[1]).clearance->radial == 2e-4);
  CHECK(std::get<RevoluteJoint>(scene.mechanism.joints[1]).at == clearance_joint.at);

  CHECK_THAT(test::refusal(scene_text("\"0.1 kg\"")),
             Contains("s.toml:16:13: joints.loose.clearance: \"0.1 kg\" is a mass, must be a length"));
  CHECK_THAT(test::refusal(scene_text("\"-0.1 mm\"")), Contains("must be greater than 0, is \"-0.1 mm\""));
  CHECK_THAT(test::refusal(scene_text("\"1e30 km\"")), Contains("must be at most 1e+09 m"));
  CHECK_THAT(test::refusal(scene_text("\"small\"")), Contains("must be a number, is a text"));
}

TEST_CASE("the discarded part of a run in revolutions may be given as a time", "[units][scene]") {
  const auto scene = read_scene(test::flores(), {"run.discard=100 ms"});
  CHECK(scene.run.discard == 0.1);
  CHECK(read_scene(test::flores()).run.discard == Approx(0.6));
}

TEST_CASE("numbers of a curve may have units that match their use", "[units][driving][scene]") {
  const std::string start = test::body("rotor", 2.0, 0.05) + test::body("block", 1, 1) +
                            test::pin("main", "ground", "rotor") + test::guide("guide", "ground", "block") +
                            test::run_for(0.5);
  const auto said = [&](const std::string& curve, const std::string& drive) {
    return test::refusal(start + "[curves.c]\n" + curve + "[drives.d]\n" + drive);
  };
  const auto* spin = "joint = \"main\"\nvelocity = \"c\"\n";
  const auto* slide = "joint = \"guide\"\nvelocity = \"c\"\ninitial = \"20 mm\"\n";
  const std::string ramp = "shape = \"ramp\"\nto = \"120 rpm\"\nrise = \"500 ms\"\n";
  const auto scene = parse_scene(start + "[curves.c]\n" + ramp + "[drives.d]\n" + spin, "s.toml");
  CHECK(scene.mechanism.curves[0].to == 120 * 2 * std::numbers::pi / 60);
  CHECK(scene.mechanism.curves[0].rise == 0.5);
  CHECK_THAT(to_toml(scene), !Contains("rpm"));
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  CHECK_THAT(said(ramp, slide),
             Contains("drives.d.velocity: the y of the curve \"c\" is an angular velocity, must be a speed"));
  CHECK(said("shape = \"ramp\"\nto = \"30 mm/s\"\nrise = 0.5\n", slide) == "accepted");
  CHECK_THAT(said("shape = \"ramp\"\nto = 3\nrise = \"20 deg\"\n", spin),
             Contains("the x of the curve \"c\" is an angle, must be a time"));
  CHECK_THAT(
      said("shape = \"ramp\"\nfrom = \"3 m\"\nto = \"120 rpm\"\nrise = 1\n", spin),
      Contains("curves.c.to: \"120 rpm\" is an angular velocity, but another number of y is a length"));
  CHECK_THAT(said("shape = \"ramp\"\nto = \"120 rqm\"\nrise = 1\n", spin),
             Contains("\"rqm\" is not a known unit"));
  CHECK(said("shape = \"harmonic\"\namplitude = \"20 deg\"\nperiod = \"1 s\"\n",
             "joint = \"main\"\nposition = \"c\"\n") == "accepted");
  CHECK(said("shape = \"table\"\npoints = [[\"0 deg\", \"0 kN\"], [\"0.1 rad\", 5], [\"3 deg\", 2]]\n",
             "joint = \"main\"\ntorque_curve = \"c\"\nagainst = \"angle\"\n") != "accepted");
  const std::string drag =
      "shape = \"table\"\npoints = [[\"-10 rpm\", \"3 N mm\"], [\"10 rpm\", \"-3 N mm\"]]\n";
  CHECK(said(drag, "joint = \"main\"\ntorque_curve = \"c\"\nagainst = \"speed\"\n") == "accepted");
  CHECK_THAT(said(drag, "joint = \"main\"\ntorque_curve = \"c\"\nagainst = \"angle\"\n"),
             Contains("the x of the curve \"c\" is an angular velocity, must be an angle"));
  CHECK_THAT(said(drag, "joint = \"guide\"\nforce = \"c\"\nagainst = \"speed\"\n"),
             Contains("the y of the curve \"c\" is a torque or an energy, must be a force"));
  // A number with its unit needs no blank, unless a curve is called so.
  CHECK(said("value = \"12 V\"\n",
             "joint = \"main\"\nvoltage = \"12V\"\nresistance = \"0.8 ohm\"\n"
             "torque_constant = \"50 N mm/A\"\ninductance = \"20 mH\"\n") == "accepted");
}

TEST_CASE("US and shop units have their legal values", "[quantities]") {
  // NIST Special Publication 811, appendix B; slug = lbf s²/ft, lbf = lb · 9.80665 m/s².
  CHECK(read("1 slug", "kg") == Approx(14.593902937206364).epsilon(4e-16));
  CHECK(read("1 lbm", "kg") == Approx(0.45359237).epsilon(4e-16));
  CHECK(read("16 oz", "kg") == Approx(0.45359237).epsilon(4e-16));
  CHECK(read("3 mil", "m") == Approx(76.2e-6).epsilon(4e-16));
  CHECK(read("3 thou", "m") == Approx(76.2e-6).epsilon(4e-16));
  CHECK(read("3 inch", "m") == Approx(76.2e-3).epsilon(4e-16));
  CHECK(read("25 micron", "m") == Approx(25e-6).epsilon(4e-16));
  CHECK(read("60 RPM", "rad/s") == Approx(2 * std::numbers::pi).epsilon(4e-16));
  CHECK(read("2 rps", "rad/s") == Approx(4 * std::numbers::pi).epsilon(4e-16));
}

TEST_CASE("a hyphen multiplies units, and pounds times a length are a torque", "[quantities]") {
  CHECK(read("5 N-m", "N m") == 5);
  CHECK(read("5 kN-m/rad", "N m/rad") == 5000);
  CHECK(read("5 N-m-s/rad", "N m s/rad") == 5);
  CHECK(read("5 kg-m2", "kg m2") == 5);
  CHECK(read("5 s-1", "1/s") == 5);
  CHECK(read("5 m s-2", "m/s2") == 5);
  const double lbf = 4.4482216152605, inch = 0.0254, foot = 0.3048, lb = 0.45359237;
  for (const char* unit : {"lb-in", "in-lb", "lbf-in", "in-lbf", "lb-inch"})
    CHECK(read(std::string("3 ") + unit, "N m") == Approx(3 * lbf * inch).epsilon(1e-15));
  for (const char* unit : {"ft-lb", "lb-ft", "ft-lbf"})
    CHECK(read(std::string("3 ") + unit, "N m") == Approx(3 * lbf * foot).epsilon(1e-15));
  CHECK(read("3 oz-in", "N m") == Approx(3 * lbf * inch / 16).epsilon(1e-15));
  CHECK(read("3 ft-lb/rad", "N m/rad") == Approx(3 * lbf * foot).epsilon(1e-15));
  CHECK(read("3 lb-in-s2", "kg m2") == Approx(3 * lbf * inch).epsilon(1e-15));
  // With a power they are a moment of inertia.
  CHECK(read("3 lb-in2", "kg m2") == Approx(3 * lb * inch * inch).epsilon(1e-15));
  CHECK(read("3 lb-ft^2", "kg m2") == Approx(3 * lb * foot * foot).epsilon(1e-15));
  CHECK(read("3 slug-ft2", "kg m2") == Approx(3 * lbf * foot).epsilon(1e-15));
  for (const char* text : {"5 -m", "5 N-", "5 N--m", "5 N/-m", "5 N-1m-"})
    CHECK_THAT(wrong(text, "N m"), Contains("is not a known unit"));
}
