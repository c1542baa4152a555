// Beams: large static deflections against the elastica, frequencies against closed forms, conservation.
#include "mechanism/beam.hpp"

#include "analysis/reduced_modes.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/modes.hpp"
#include "io/scene/read_scene.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A beam of length 1 m, EI = 1 N m², 1 kg/m and EA (N), nearly without rotary inertia.
std::string unit_beam(const std::string& from, const std::string& to, int elements, double axial,
                      const std::string& more = "") {
  return fmt::format(
      "[beams.rod]\nbetween = [\"{}\", \"{}\"]\nlength = 1.0\nelements = {}\nyoung = {}\ndensity = 1.0\n"
      "area = 1.0\nsecond_moment = {}\n{}",
      from, to, elements, axial, 1 / axial, more);
}

/// A body of little mass at a place: 1e-5 of the beam.
std::string light(const std::string& name, double x) {
  return test::body(name, 1e-5, 1e-7, fmt::format("position = [{}, 0.0]\nangle = 0.0\n", x));
}

/// The equilibrium of a cantilever from the origin along x with loads on its tip: place and angle of the tip.
std::array<double, 3> bent(int elements, const std::string& loads, const std::string& more = "") {
  const auto scene = parse_scene(
      light("tip", 1) + unit_beam("ground", "tip", elements, 1e5, more) + loads + test::run_for(1), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  const auto q = find_equilibrium(scene.mechanism, system, from.q, {}).state.q;
  return {q[0], q[1], q[2]};
}

/// Natural frequencies (rad/s) of a scene about its start.
std::vector<double> frequencies(const std::string& text) {
  const auto scene = parse_scene(text + test::run_for(1), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  double left = 0;
  std::vector<double> list;
  for (const auto& mode : find_modes(system, as_it_stands(system, from, {}, left), {}).modes)
    if (mode.kind == Mode::Kind::swing) list.push_back(std::abs(mode.s));
  CHECK(left < 1e-7);  // N, rounding of positions times EA/l
  return list;
}

}  // namespace

TEST_CASE("a cantilever under a couple bends to a circle", "[beams]") {
  // Radius EI/M. An element replaces its arc by its chord, 2 sin(φ)/φ with the series to φ²: order 4.
  const double turn = 0.5 * std::numbers::pi;
  const auto error = [&](double h) {
    const auto tip = bent(static_cast<int>(std::round(1 / h)),
                          fmt::format("[loads.m]\ntype = \"torque\"\nbody = \"tip\"\ntorque = {}\n", turn));
    CHECK(tip[2] == Approx(turn).epsilon(1e-9));
    return std::hypot(tip[0] - 1 / turn, tip[1] - 1 / turn);
  };
  test::check_order({1.0 / 4, 1.0 / 8, 1.0 / 16}, error, 3.7, 4.3);
  CHECK(error(1.0 / 16) < 1e-6);
}

TEST_CASE("a cantilever under an end force is the elastica", "[beams]") {
  // EI θ″ = −(1 + ε) P cos θ, ε = P sin θ/EA, with θ(0) = 0 and θ′(1) = 0, by shooting with 4000 Runge–Kutta steps.
  // For EA = 1e13 N the same numbers agree with the elliptic integrals to 1e-12, and with the five digits of
  // Mattiasson, Int. J. Numer. Methods Eng. 17 (1981) 145.
  struct Known {
    double load, angle, x, y;
  };
  for (const auto& known : {Known{1, 0.4613534273518615, 0.9435692161032524, 0.30172274345243166},
                            Known{5, 1.2153844996868517, 0.6123806773517615, 0.7138269354816363},
                            Known{10, 1.4303055851892479, 0.44501604846592624, 0.810688944981563}}) {
    CAPTURE(known.load);
    const auto error = [&](double h) {
      const auto tip = bent(static_cast<int>(std::round(1 / h)), test::force("f", "tip", {0, known.load}));
      return std::hypot(tip[0] - known.x, tip[1] - known.y);
    };
    test::check_order({1.0 / 8, 1.0 / 16, 1.0 / 32}, error, 3.5, 4.5);
    CHECK(error(1.0 / 32) < 1e-6);
  }
}

TEST_CASE("small deflections are exact for any number of elements", "[beams]") {
  // P l³/(3 EI), with shear P l/(κGA) more; a couple turns the tip by M l/EI.
  for (const int elements : {1, 2, 5}) {
    CAPTURE(elements);
    const double load = 1e-6;
    CHECK(bent(elements, test::force("f", "tip", {0, load}))[1] == Approx(load / 3).epsilon(1e-8));
    const auto soft =
        bent(elements, test::force("f", "tip", {0, load}), "shear_modulus = 12\nshear_factor = 0.5\n");
    CHECK(soft[1] == Approx(load * (1.0 / 3 + 1.0 / 6)).epsilon(1e-8));
  }
}

TEST_CASE("a curved beam at rest has its curvature", "[beams]") {
  const auto tip = bent(16, "", "curvature = 1.0\n");
  CHECK(std::hypot(tip[0] - std::sin(1.0), tip[1] - (1 - std::cos(1.0))) < 1e-6);
}

TEST_CASE("bending frequencies converge with second order to closed forms", "[beams]") {
  // Squares of the roots k of 1 + cos k cosh k + μ k (cos k sinh k − sin k cosh k) = 0 (cantilever with the tip's mass μ),
  // of cos k cosh k = 1 (clamped at both ends), and n π between pins. Rigid pieces raise the kinetic energy of
  // a wave by (k h)²/12.
  const std::string clamp = light("end", 1) +
                            "[joints.clamp]\ntype = \"rigid\"\nbetween = [\"ground\", \"end\"]\n"
                            "at = [[1, 0], [0, 0]]\n";
  struct Known {
    std::string text, from, to;
    std::vector<double> frequency;
  };
  const double pi = std::numbers::pi;
  const std::string simple = light("begin", 0) + light("end", 1) + test::pin("A", "ground", "begin") +
                             test::pin("B", "ground", "end", {1, 0});
  for (const auto& known :
       {Known{"", "ground", "free", {3.516015268500151, 22.034491564666766, 61.69721441354909}},
        Known{"", "free", "ground", {3.516015268500151, 22.034491564666766, 61.69721441354909}},
        Known{light("end", 1), "ground", "end", {3.515944950217487, 22.034050902512632, 61.69598058460896}},
        Known{clamp, "ground", "end", {22.37328544806132, 61.67282286792025}},
        Known{simple, "begin", "end", {pi * pi, 4 * pi * pi, 9 * pi * pi}}})
    for (std::size_t n = 0; n < known.frequency.size(); ++n) {
      CAPTURE(known.from, known.to, known.frequency[n]);
      const auto error = [&](double h) {
        const auto found = frequencies(
            known.text + unit_beam(known.from, known.to, static_cast<int>(std::round(1 / h)), 1e6));
        REQUIRE(found.size() > n);
        return std::abs(found[n] / known.frequency[n] - 1);
      };
      test::check_order({1.0 / 8, 1.0 / 16, 1.0 / 32}, error, 1.8, 2.2);
      CHECK(error(1.0 / 32) < 1.5 * known.frequency[n] / (24 * 32 * 32));
    }
}

TEST_CASE("shear and rotary inertia lower frequencies as in Timoshenko's beam", "[beams]") {
  // Between pins, with k = n π: ω⁴ ρI ρA/(κGA EI) − ω² (ρA/EI + k² (ρI/EI + ρA/(κGA))) + k⁴ = 0.
  const double axial = 400, shear = 0.5 * 0.4 * axial, rotary = 1 / axial;
  for (const int n : {1, 2, 3}) {
    const double k = n * std::numbers::pi, a = rotary / shear, b = 1 + k * k * (rotary + 1 / shear),
                 known = std::sqrt((b - std::sqrt(b * b - 4 * a * k * k * k * k)) / (2 * a));
    CAPTURE(n, known);
    const auto error = [&](double h) {
      const auto found =
          frequencies(light("begin", 0) + light("end", 1) + test::pin("A", "ground", "begin") +
                      test::pin("B", "ground", "end", {1, 0}) +
                      unit_beam("begin", "end", static_cast<int>(std::round(1 / h)), axial,
                                fmt::format("shear_modulus = {}\nshear_factor = 0.5\n", 0.4 * axial)));
      double nearest = INFINITY;  // among those of axial vibration
      for (const double w : found) nearest = std::min(nearest, std::abs(w / known - 1));
      return nearest;
    };
    test::check_order({1.0 / 8, 1.0 / 16, 1.0 / 32}, error, 1.8, 2.2);
  }
}

TEST_CASE("a flying beam keeps its momentum and its energy", "[beams]") {
  // Two bodies at the ends of a soft beam, thrown with a spin. EA = 10 kN, EI = 1 N m², 1 kg/m.
  const auto* reduction = GENERATE("", "modes = 0\n", "modes = 2\n");
  CAPTURE(reduction);
  const auto end = [](const std::string& name, double x, const std::string& velocity) {
    return test::body(name, 0.2, 1e-3, fmt::format("position = [{}, 0.0]\nangle = 0.0\n{}", x, velocity));
  };
  const auto scene = parse_scene(
      end("a", 0, "velocity = [0.0, 1.0]\nangular_velocity = 2.0\n") +
          end("b", 1, "velocity = [0.3, -1.0]\nangular_velocity = -1.0\n") +
          "[beams.rod]\nbetween = [\"a\", \"b\"]\nlength = 1.0\nelements = 4\nyoung = 1e4\ndensity = 1.0\n"
          "area = 1.0\nsecond_moment = 1e-4\nshear_modulus = 4e3\n" +
          reduction + test::run_for(0.5),
      "beam");
  for (const Family family : {Family::nonsmooth, Family::penalty}) {
    CAPTURE(name_of(family));
    const auto motion = test::motion_rows(scene, family, 0.01);
    const auto momentum = [&](const test::MotionRow& row) {
      std::array<double, 3> p{};
      for (std::size_t i = 0; i < scene.mechanism.bodies.size(); ++i) {
        const auto& b = scene.mechanism.bodies[i];
        const double *q = row.q.data() + 3 * i, *v = row.v.data() + 3 * i;
        p[0] += b.mass * v[0], p[1] += b.mass * v[1];
        p[2] += b.mass * (q[0] * v[1] - q[1] * v[0]) + b.inertia * v[2];
      }
      return p;
    };
    const auto before = momentum(motion.rows.front());
    const double lost = motion.worst([&](const auto& row) {
      const auto p = momentum(row);
      return std::hypot(p[0] - before[0], p[1] - before[1], p[2] - before[2]);
    });
    CHECK(lost < 1e-8);
    // The bodies lose a large part of their kinetic energy to the beam.
    const auto& ledger = motion.run.ledger;
    CHECK(std::abs(ledger.closure()) < 1e-6 * ledger.scale());
  }
}

TEST_CASE("a mechanism with a beam is assembled as with a rigid link", "[beams]") {
  // A slider-crank whose bodies at the ends of the rod state no position: the rod has 0.12 m at the crank angle 60°,
  // and turns with ω_crank r cos φ/(l cos β), sin β = r sin φ/l.
  const double r = 0.05, l = 0.12, speed = 20, phi = std::numbers::pi / 3,
               beta = std::asin(r / l * std::sin(phi));
  const auto scene = parse_scene(
      test::body("crank", 1, 1e-3) + test::body("big_end", 0.1, 1e-5) + test::body("eye", 0.1, 1e-5) +
          test::body("slider", 1, 1e-3, "position = [0.15, 0.0]\n") + test::pin("main", "ground", "crank") +
          test::pin("big", "crank", "big_end", {r, 0}) + test::pin("gudgeon", "eye", "slider") +
          test::guide("guide", "ground", "slider") +
          test::drive("motor", "main", fmt::format("speed = {}\ninitial_angle = {}\n", speed, phi)) +
          fmt::format(
              "[beams.rod]\nbetween = [\"big_end\", \"eye\"]\nlength = {}\nyoung = 2e11\ndensity = 7800\n"
              "section = \"circle\"\ndiameter = 5e-3\nelements = 3\n",
              l) +
          "[assembly]\napproximate = true\n" + test::run_for(1),
      "beam");
  const auto s = assemble(scene.mechanism, RunOptions::Start::assembled);
  const double x = r * std::cos(phi) + l * std::cos(beta),
               turn = -speed * r * std::cos(phi) / (l * std::cos(beta));
  CHECK(std::abs(s.q[9] - x) < 1e-12);  // slider
  CHECK(s.v[9] == Approx(-speed * r * std::sin(phi) + l * std::sin(beta) * turn).epsilon(1e-9));
  for (const std::size_t piece : {0, 1, 2}) {
    CAPTURE(piece);
    const std::size_t i = 3 * (4 + piece);
    const double share = (static_cast<double>(piece) + 0.5) / 3;
    CHECK(std::abs(s.q[i] - (r * std::cos(phi) + share * l * std::cos(beta))) < 1e-12);
    CHECK(std::abs(std::remainder(s.q[i + 2] + beta, 2 * std::numbers::pi)) < 1e-12);
    CHECK(s.v[i + 2] == Approx(turn).epsilon(1e-9));
  }
}

TEST_CASE("stated positions that strain a beam are kept, with a note", "[beams]") {
  const auto start = [](double length) {
    const auto scene =
        parse_scene(light("a", 0) + light("b", 1) +
                        fmt::format("[beams.rod]\nbetween = [\"a\", \"b\"]\nlength = {}\nyoung = 1e5\n"
                                    "density = 1\narea = 1\nsecond_moment = 1e-5\n",
                                    length) +
                        test::run_for(1),
                    "beam");
    std::string assumed, given;
    const auto s = assemble(scene.mechanism, RunOptions::Start::assembled, &assumed);
    CHECK(s.q[3] == 1);
    assemble(scene.mechanism, RunOptions::Start::given, &given);
    CHECK(given == assumed);
    return assumed;
  };
  CHECK_THAT(start(0.9), Catch::Matchers::Contains("strained"));
  CHECK(start(1).empty());
}

TEST_CASE("a beam with a free end begins on its unloaded arc and moves with its body", "[beams]") {
  // p(s) = p₀ + (sin(α + κs) − sin α, cos α − cos(α + κs))/κ, from the point p₀ = r + R(θ) a of the hub in the direction
  // α = θ + angle; s is negative from the second end.
  const double bend = 0.8, angle = 0.4, own = 0.5, spin = 3;
  const Vec2 centre{0.3, -0.2}, at{0.05, 0.1}, velocity{1, 2};
  const double c = std::cos(angle), n = std::sin(angle), alpha = angle + own;
  const Vec2 from = centre + Vec2{c * at.x() - n * at.y(), n * at.x() + c * at.y()};
  for (const bool first : {true, false}) {
    CAPTURE(first);
    const auto on_hub = fmt::format("[{}, {}]", at.x(), at.y()), turned = fmt::format("{}", own);
    const auto hub = test::body("hub", 1, 1e-3,
                                fmt::format("position = [{}, {}]\nangle = {}\nvelocity = [{}, {}]\n"
                                            "angular_velocity = {}\n",
                                            centre.x(), centre.y(), angle, velocity.x(), velocity.y(), spin));
    const auto ends =
        fmt::format("curvature = {}\nat = [{}, {}]\nangles = [{}, {}]\n", bend, first ? on_hub : "[0, 0]",
                    first ? "[0, 0]" : on_hub, first ? turned : "0", first ? "0" : turned);
    const auto scene = parse_scene(
        hub + unit_beam(first ? "hub" : "free", first ? "free" : "hub", 3, 1e4, ends) + test::run_for(1),
        "beam");
    CHECK(scene.mechanism.loads.size() == 3);
    CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
    std::string assumed;
    const auto s = assemble(scene.mechanism, RunOptions::Start::assembled, &assumed);
    CHECK(assumed.empty());
    for (const std::size_t piece : {0, 1, 2}) {
      CAPTURE(piece);
      const double along = (static_cast<double>(piece) + 0.5) / 3 - (first ? 0 : 1),
                   end = alpha + bend * along;
      const Vec2 place =
          from + 1 / bend * Vec2{std::sin(end) - std::sin(alpha), std::cos(alpha) - std::cos(end)};
      const Vec2 moves = velocity + spin * perp(place - centre);
      const std::size_t i = 3 * (1 + piece);
      CHECK(std::hypot(s.q[i] - place.x(), s.q[i + 1] - place.y()) < 1e-12);
      CHECK(std::abs(s.q[i + 2] - end) < 1e-12);
      CHECK(std::hypot(s.v[i] - moves.x(), s.v[i + 1] - moves.y()) < 1e-12);
      CHECK(std::abs(s.v[i + 2] - spin) < 1e-12);
    }
  }
}

TEST_CASE("a force at a free end bends a cantilever but for a half piece", "[beams]") {
  // P L³/(3EI) at the end; the rigid half of the last piece lacks its share P (l/2)³/(3EI).
  const double load = 1e-6;
  for (const int elements : {1, 2, 5}) {
    CAPTURE(elements);
    const double half = 0.5 / elements;
    const auto scene = parse_scene(unit_beam("ground", "free", elements, 1e5) +
                                       test::force("f", fmt::format("rod-{}", elements), {0, load},
                                                   fmt::format("at = [{}, 0]\n", half)) +
                                       test::run_for(1),
                                   "beam");
    const System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
    const auto q = find_equilibrium(scene.mechanism, system, start.q, {}).state.q;
    const auto* tip = q.data() + q.size() - 3;
    CHECK(tip[1] + half * std::sin(tip[2]) == Approx(load / 3 * (1 - half * half * half)).epsilon(1e-8));
  }
}

TEST_CASE("ends of beams that are free wrongly are refused", "[beams]") {
  const auto said = [](const std::string& keys) {
    return test::refusal(test::body("hub", 1, 1, "points = { rim = [1, 0] }\n") +
                         "[beams.rod]\nlength = 1\nyoung = 1\ndensity = 1\narea = 1\nsecond_moment = 1\n" +
                         keys + test::run_for(1));
  };
  CHECK(said("between = [\"hub\", \"free\"]\nat = [\"rim\", [0, 0]]\n") == "accepted");
  test::check_messages(said, {{"between = [\"free\", \"free\"]\n", "both are free"},
                              {"between = [\"hub\", \"free\"]\nat = [[0, 0], [1, 0]]\n", "at the free end"},
                              {"between = [\"free\", \"hub\"]\nat = [\"rim\", [0, 0]]\n", "at the free end"},
                              {"between = [\"hub\", \"free\"]\nangles = [0, 1]\n", "at the free end"}});
  // A body of that name is what the name means.
  const auto scene = parse_scene(
      test::body("hub", 1, 1) + test::body("free", 1, 1) + unit_beam("hub", "free", 2, 1) + test::run_for(1),
      "beam");
  CHECK(scene.mechanism.beams[0].between == std::array{0, 1});
}

TEST_CASE("the length of a beam follows from stated positions of its ends", "[beams]") {
  const auto text = [](const std::string& body, const std::string& keys) {
    return body +
           "[beams.rod]\nyoung = 1e5\ndensity = 1\narea = 1\nsecond_moment = 1e-5\n"
           "between = [\"ground\", \"b\"]\n" +
           keys + test::run_for(1);
  };
  const auto length = [&](const std::string& body, const std::string& keys) {
    return parse_scene(text(body, keys), "beam").mechanism.beams[0].length;
  };
  const auto centre = test::body("b", 1, 1, "position = [4, 3]\n"),
             turned =
                 test::body("b", 1, 1, fmt::format("position = [4, 3]\nangle = {}\n", std::numbers::pi / 2));
  CHECK(length(centre, "") == Approx(5).epsilon(1e-15));
  // The point (2, 0) of a body at a right angle is at (4, 5); from (1, 1) it is 5 m away.
  CHECK(length(turned, "at = [[1, 1], [2, 0]]\n") == Approx(5).epsilon(1e-15));
  // An arc of radius 5 m over a chord of 5 m has a sixth of a circle, to either side; a half circle is the longest.
  for (const char* bend : {"0.2", "-0.2"})
    CHECK(length(centre, fmt::format("curvature = {}\n", bend)) ==
          Approx(5 * std::numbers::pi / 3).epsilon(1e-14));
  CHECK(length(centre, "curvature = 1e-9\n") == Approx(5).epsilon(1e-14));
  CHECK(length(centre, "length = 7\n") == 7);

  const auto said = [&](const std::string& body, const std::string& keys) {
    return test::refusal(text(body, keys));
  };
  using Catch::Matchers::Contains;
  CHECK_THAT(said(test::body("b", 1, 1), ""),
             Contains("beams.rod.length") && Contains("bodies.b states no position"));
  CHECK_THAT(said(centre, "at = [[0, 0], [1, 0]]\n"), Contains("bodies.b states no angle"));
  CHECK_THAT(said(centre, "at = [[4, 3], [0, 0]]\n"), Contains("same place"));
  CHECK_THAT(said(centre, "curvature = 0.5\n"), Contains("no such arc"));
  CHECK_THAT(test::refusal(test::replaced(text(centre, ""), "\"b\"", "\"free\"")),
             Contains("free end needs it"));

  // The position varies, and with it the length.
  auto scene = parse_scene(text(centre, ""), "beam");
  scene.set("bodies.b.position", "[8, 6]");
  CHECK(scene.mechanism.beams[0].length == Approx(10).epsilon(1e-15));
}

TEST_CASE("a range of frequencies determines the number of elements", "[beams]") {
  // Between pins, ω = (3π)² at the third frequency: l ≤ √0.24/(3π) makes 20 pieces of 1 m, with an error −(3π/20)²/24.
  const double pi = std::numbers::pi, omega = 9 * pi * pi;
  const auto text = [&](const std::string& keys) {
    return light("begin", 0) + light("end", 1) + test::pin("A", "ground", "begin") +
           test::pin("B", "ground", "end", {1, 0}) +
           "[beams.rod]\nbetween = [\"begin\", \"end\"]\nyoung = 1e6\ndensity = 1\narea = 1\nsecond_moment = 1e-6\n" +
           keys;
  };
  const auto range = [](double hertz) { return fmt::format("frequency_range = {}\n", hertz); };
  auto scene = parse_scene(text(range(omega / (2 * pi))) + test::run_for(1), "beam");
  const auto& rod = scene.mechanism.beams[0];
  CHECK(rod.elements == 20);
  CHECK(rod.resolved() >= omega);
  CHECK(rod.highest() == Approx(2 * 1e3 * 20));
  const double error = frequencies(text(range(omega / (2 * pi)))).at(2) / omega - 1;
  CHECK(error > -0.01);
  CHECK(error < -0.005);
  CHECK(parse_scene(text("") + test::run_for(1), "beam").mechanism.beams[0].elements == 8);
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));

  // In a scene without its text, the range replaces the number.
  scene.text.clear();
  scene.set("beams.rod.frequency_range", 4 * omega / (2 * pi));
  CHECK(scene.mechanism.beams[0].elements == 39);
  const auto said = [&](const std::string& keys) { return test::refusal(text(keys) + test::run_for(1)); };
  test::check_messages(said, {{"elements = 4\n" + range(1), "determines elements"},
                              {range(1e6), "more than 1000 elements"},
                              {range(0), "greater than 0"}});
}

TEST_CASE("a damping ratio at a frequency is that of a mode there", "[beams]") {
  // Damping τK gives each mode the ratio ω τ/2: 2 % at 2 Hz, and in proportion to the natural frequency elsewhere.
  const auto keys = [](const std::string& more) {
    return unit_beam("ground", "free", 8, 1e4, more) + test::run_for(1);
  };
  const auto scene = parse_scene(keys("damping_ratio = 0.02\ndamping_frequency = 2\n"), "beam");
  const System system(scene.mechanism);
  const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
  double left = 0;
  const auto modes = find_modes(system, as_it_stands(system, from, {}, left), {}).modes;
  int swings = 0;
  for (const auto& mode : modes) {
    if (mode.kind != Mode::Kind::swing) continue;
    CHECK(mode.damping() == Approx(0.02 * mode.natural() / 2).epsilon(1e-6));
    ++swings;
  }
  CHECK(swings >= 3);
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  const auto said = [&](const std::string& more) { return test::refusal(keys(more)); };
  test::check_messages(said, {{"damping_ratio = 0.1\n", "damping_frequency: is missing"},
                              {"damping_frequency = 1\n", "damping_ratio: is missing"},
                              {"damping = 1\ndamping_ratio = 0.1\ndamping_frequency = 1\n", "determined by"},
                              {"damping_ratio = -1\ndamping_frequency = 1\n", "0 or greater"}});
}

TEST_CASE("sections along a beam deflect as the integral of M x/EI", "[beams]") {
  // Cantilevers of 1 m with a force P at the end, EI₀ = 1 N m². With the half EI beyond the middle,
  // ∫ P (1 − x)²/EI dx = P (1 − 1/8)/3 + 2 P/(8 · 3); with EI = EI₀ (1 − x/2), P (2 ln 2 − 1).
  const double load = 1e-6;
  const auto text = [](int elements, const std::string& sections) {
    return fmt::format(
        "[beams.rod]\nbetween = [\"ground\", \"tip\"]\nlength = 1\nelements = {}\nyoung = 1e5\ndensity = 2\n"
        "sections = [{}]\n",
        elements, sections);
  };
  const auto deflection = [&](int elements, const std::string& sections) {
    const auto scene = parse_scene(
        light("tip", 1) + text(elements, sections) + test::force("f", "tip", {0, load}) + test::run_for(1),
        "beam");
    CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
    const System system(scene.mechanism);
    const auto from = assemble(scene.mechanism, RunOptions::Start::assembled);
    return find_equilibrium(scene.mechanism, system, from.q, {}).state.q[1] / load;
  };
  const std::string step = "[0, 1, 1e-5], [0.5, 0.5, 5e-6]";
  const std::vector<double> lengths{1.0 / 4, 1.0 / 8, 1.0 / 16};
  test::check_order(
      lengths,
      [&](double h) { return std::abs(deflection(static_cast<int>(1 / h), step) - (7.0 / 24 + 2.0 / 24)); },
      1.9, 2.1);
  test::check_order(
      lengths,
      [&](double h) {
        const int elements = static_cast<int>(1 / h);
        std::string rows;
        for (int n = 0; n < elements; ++n)
          rows += fmt::format("{}[{}, 1, {}]", n == 0 ? "" : ", ", n * h, 1e-5 * (1 - 0.5 * (n + 0.5) * h));
        return std::abs(deflection(elements, rows) - (2 * std::numbers::ln2 - 1));
      },
      1.8, 2.2);

  // Masses by the density of 2 kg/m³; greatest ρA/EI; one number of the list varies alone.
  auto scene = parse_scene(light("tip", 1) + text(4, step) + test::run_for(1), "beam");
  const auto& m = scene.mechanism;
  for (const std::size_t piece : {0, 1, 2, 3})
    CHECK(m.bodies[1 + piece].mass == Approx(piece < 2 ? 0.5 : 0.25));
  CHECK(m.beams[0].wave_factor() == Approx(2));
  scene.set("beams.rod.sections[1][2]", 2e-6);
  CHECK(scene.mechanism.beams[0].section_moment(0.75) == 2e-6);
  CHECK(scene.mechanism.beams[0].section_moment(0.25) == 1e-5);
  CHECK(scene.mechanism.beams[0].wave_factor() == Approx(5));

  const auto said = [&](const std::string& rows) {
    return test::refusal(light("tip", 1) + text(4, rows) + test::run_for(1));
  };
  test::check_messages(said, {{"[0.1, 1, 1]", "the first 0"},
                              {"[0, 1, 1], [0, 1, 1]", "ascending shares"},
                              {"[0, 1, 1], [1, 1, 1]", "less than 1"},
                              {"[0, 1, 0]", "greater than 0"},
                              {"[0, 1]", "list of 3 numbers"},
                              {"[0, \"1 m\", 1]", "must be an area"},
                              {"[0, 1, 1]]\narea = 1\n#", "without sections"},
                              {"[0, 1, 0.6]]\nsection = \"tube\"\n#", "half of the diameter"}});
}

namespace {

/// A cantilever with a heavy body at its tip, and a beam between pins; each with 8 elements.
std::vector<std::string> reducible(const std::string& keys) {
  return {test::body("tip", 0.5, 0.01, "position = [1, 0]\nangle = 0\n") +
              unit_beam("ground", "tip", 8, 1e6, keys),
          light("begin", 0) + light("end", 1) + test::pin("A", "ground", "begin") +
              test::pin("B", "ground", "end", {1, 0}) + unit_beam("begin", "end", 8, 1e6, keys)};
}
std::string keeping(int modes) { return fmt::format("modes = {}\n", modes); }

}  // namespace

TEST_CASE("frequencies of a reduced beam are bounds that decrease to those of the full beam", "[beams]") {
  // The reduced beam is the full one with constraints, so that no frequency is lower (Rayleigh, Courant and Fischer).
  // With all 8 modes, only motions of the pieces' rotations against each other are missing. They begin beyond the band
  // of bending waves, at about √48 8² = 443 rad/s: at least five times the third frequency, and the error is of the
  // order of this ratio's inverse fourth power.
  for (const std::size_t which : {0, 1}) {
    CAPTURE(which);
    const auto full = frequencies(reducible("")[which]);
    std::vector<double> above(3, INFINITY);
    for (const int modes : {0, 1, 2, 4, 8}) {
      CAPTURE(modes);
      const auto found = frequencies(reducible(keeping(modes))[which]);
      CHECK(found.size() ==
            static_cast<std::size_t>((which == 0 ? 3 : 2) + modes));  // of the bodies at the ends
      for (std::size_t n = 0; n < std::min<std::size_t>(3, found.size()); ++n) {
        CAPTURE(n);
        CHECK(found[n] > full[n] * (1 - 1e-7));
        CHECK(found[n] < above[n] * (1 + 1e-7));
        above[n] = found[n];
      }
    }
    for (std::size_t n = 0; n < 3; ++n) CHECK(above[n] < full[n] * (1 + 1e-3));
  }
}

TEST_CASE("frequencies of reduced and full beams are paired by their shapes", "[beams]") {
  for (const auto& text : reducible(keeping(3))) {
    const auto scene = parse_scene(text + test::run_for(1), "beam");
    const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
    const auto list = reduced_frequencies(scene.mechanism, start);
    REQUIRE(list.size() >= 5);
    // A retained mode leaves the residual of the fourth and higher ones: below one per cent for the first two.
    for (const std::size_t n : {0, 1}) {
      CHECK(list[n].error() > -1e-7);
      CHECK(list[n].error() < 0.01);
    }
  }
}

TEST_CASE("static deflections of a reduced beam are exact for any number of modes", "[beams]") {
  const double load = 1e-6;
  for (const int modes : {0, 2, 5}) {
    CAPTURE(modes);
    CHECK(bent(5, test::force("f", "tip", {0, load}), keeping(modes))[1] == Approx(load / 3).epsilon(1e-8));
    const auto soft = bent(5, test::force("f", "tip", {0, load}),
                           "shear_modulus = 12\nshear_factor = 0.5\n" + keeping(modes));
    CHECK(soft[1] == Approx(load * (1.0 / 3 + 1.0 / 6)).epsilon(1e-8));
  }
  // The pieces lie on P x² (3 L − x)/(6 EI), with its slope.
  const auto scene =
      parse_scene(light("tip", 1) + unit_beam("ground", "tip", 5, 1e5, keeping(2)) +
                      test::force("f", "tip", {0, load}) + test::run_for(1, "start = \"equilibrium\"\n"),
                  "beam");
  const auto s = assemble(scene.mechanism, RunOptions::Start::equilibrium);
  for (const std::size_t piece : {0, 1, 2, 3, 4}) {
    CAPTURE(piece);
    const double x = (static_cast<double>(piece) + 0.5) / 5;
    CHECK(s.q[3 * piece + 3] == Approx(x).epsilon(1e-9));
    CHECK(s.q[3 * piece + 4] == Approx(load * x * x * (3 - x) / 6).epsilon(1e-7));
    CHECK(s.q[3 * piece + 5] == Approx(load * x * (1 - x / 2)).epsilon(1e-7));
  }
}

TEST_CASE("rows of a reduced beam are independent and hold at the start", "[beams]") {
  // Ends that are displaced, turned and moving.
  const auto scene = parse_scene(
      test::body("a", 1, 1, "position = [0, 0]\nangle = 0.1\nvelocity = [1, 2]\nangular_velocity = 3\n") +
          test::body("b", 1, 1,
                     "position = [1.01, 0.2]\nangle = -0.2\nvelocity = [-1, 0.5]\nangular_velocity = -2\n") +
          unit_beam("a", "b", 6, 1e5, "at = [[0.1, 0.05], [0, 0]]\nangles = [0.1, 0.2]\n" + keeping(2)) +
          test::run_for(1),
      "beam");
  const System system(scene.mechanism);
  CHECK(system.rows() == 3 * 6 - 2);
  const auto s = assemble(scene.mechanism, RunOptions::Start::assembled);
  CHECK(redundant_rows(system, s.q).empty());
  auto e = system.make_evaluation();
  system.place(0, s.q.data(), e);
  const auto& p = system.pattern();
  for (std::size_t row = 0; row < e.phi.size(); ++row) {
    double rate = 0;
    for (int k = p.begin[row]; k < p.begin[row + 1]; ++k) rate += e.G[k] * s.v[p.column[k]];
    CHECK(std::abs(e.phi[row]) < 1e-14);
    CHECK(std::abs(rate) < 1e-13);
  }
  CHECK(s.q[0] == 0);
  CHECK(same_facts(parse_scene(to_toml(scene), "again"), scene));
  CHECK(with_full_beams(scene.mechanism).loads.size() == 7);
  CHECK(System(with_full_beams(scene.mechanism)).rows() == 0);
}

TEST_CASE("a slider-crank moves with a reduced rod as with a full one, in fewer steps", "[beams]") {
  // The rod's weight under the acceleration r ω² bends it by 5 ρA r ω² l⁴/(384 EI) ≈ 0.13 mm. Symmetric modes beyond
  // the third have less than (4.73/17.28)⁴ < 1 % of this. A reduced beam lacks the stiffness by its normal force, at most
  // 0.4 N of Euler's 42 N: half a per cent of the frequency, a phase of 0.04 in 20 ms.
  const auto scene = [](const std::string& keys) {
    return parse_scene(
        test::body("crank", 1, 1e-3) + test::body("big_end", 0.1, 1e-5) + test::body("eye", 5e-3, 1e-7) +
            test::body("slider", 5e-3, 1e-6, "position = [0.15, 0.0]\n") +
            test::pin("main", "ground", "crank") + test::pin("big", "crank", "big_end", {0.05, 0}) +
            test::pin("gudgeon", "eye", "slider") + test::guide("guide", "ground", "slider") +
            test::drive("motor", "main", "speed = 20\ninitial_angle = 1\n") +
            "[beams.rod]\nbetween = [\"big_end\", \"eye\"]\nlength = 0.12\nyoung = 2e9\ndensity = 7800\n"
            "section = \"circle\"\ndiameter = 5e-3\nelements = 7\n" +
            keys + "[assembly]\napproximate = true\n[penalty]\nintegrator = \"dopri5\"\n" +
            test::run_for(0.02),
        "beam");
  };
  const auto deflection = [](const test::MotionRow& row) {  // of the middle piece from the chord
    const auto place = [&](std::size_t body) { return Vec2{row.q[3 * body], row.q[3 * body + 1]}; };
    const Vec2 chord = place(2) - place(1);
    return cross(chord, place(7) - place(1)) / chord.norm();
  };
  for (const Family family : {Family::penalty, Family::nonsmooth}) {
    CAPTURE(name_of(family));
    const auto full = test::motion_rows(scene(""), family, 1e-3),
               reduced = test::motion_rows(scene(keeping(3)), family, 1e-3);
    REQUIRE(full.rows.size() == reduced.rows.size());
    const double most = full.worst(deflection);
    CHECK(most > 5e-5);
    for (std::size_t i = 0; i < full.rows.size(); ++i) {
      CAPTURE(i);
      CHECK(std::abs(deflection(full.rows[i]) - deflection(reduced.rows[i])) < 0.1 * most);
    }
    // The highest frequency falls from 2 c/l = 5.9e4 rad/s to that of the masses at the ends on EA/L.
    if (family == Family::penalty) CHECK(reduced.run.work.rhs < full.run.work.rhs / 2);
  }
}

TEST_CASE("beams that cannot be reduced are refused", "[beams]") {
  const auto said = [](const std::string& keys) {
    return test::refusal(
        test::body("hub", 1, 1) +
        "[beams.rod]\nyoung = 1e6\ndensity = 1\narea = 1\nsecond_moment = 1e-6\nlength = 1\n" + keys +
        test::run_for(1));
  };
  const std::string held = "between = [\"ground\", \"hub\"]\n";
  CHECK(said(held + "modes = 8\n") == "accepted");
  test::check_messages(said, {{held + "modes = 9\n", "at most the number of elements"},
                              {held + "modes = -1\n", "a whole number"},
                              {held + "modes = 1\nelements = 65\n", "at most 64 elements"},
                              {held + "modes = 1\ncurvature = 0.1\n", "without curvature"},
                              {"between = [\"hub\", \"free\"]\nmodes = 1\n", "at both ends"},
                              {held + "modes = 1\n[instruments.g]\ntype = \"strain-gauge\"\nbeam = \"rod\"\n"
                                      "place = 0.5\n",
                               "must be a full beam"}});
  // Thick pieces rotate without displacement: ρI l is many times ρA l³/12.
  const auto thick =
      test::body("hub", 1, 1) +
      "[beams.rod]\nyoung = 1\ndensity = 1\narea = 1\nsecond_moment = 1\nlength = 1\nmodes = 8\n" + held +
      test::run_for(1);
  CHECK_THROWS_WITH(System(parse_scene(thick, "beam").mechanism),
                    Catch::Matchers::Contains("beams.rod.modes"));
}
