// Beams: large static deflections against the elastica, frequencies against closed forms, conservation.
#include "mechanism/beam.hpp"

#include "io/scene/write_scene.hpp"
#include "verification/unit/dynamics/unit_beams.hpp"

using namespace freeplay;
using test::bent, test::frequencies, test::light, test::unit_beam;

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

namespace {

/// Angular frequencies of a cantilever of Timoshenko with length, EI and ρA of 1, the shear stiffness S = κGA and R = ρI
/// (Han, Benaroya and Wei, J. Sound Vib. 225 (1999) 935), below √(S/R). With y′ − ψ the shear angle,
///   S (y″ − ψ′) + ω² y = 0,  ψ″ + S (y′ − ψ) + R ω² ψ = 0,  λ⁴ + ω² (1/S + R) λ² + R ω⁴/S − ω² = 0 for e^{λx},
/// λ = ±α, ±iβ, and ψ = a sinh αx for y = cosh αx, ψ = b cos βx for y = sin βx. Two shapes are clamped at x = 0;
/// at x = 1, ψ′ and y′ − ψ of a sum of them vanish.
std::vector<double> timoshenko_cantilever(double S, double R, std::size_t count) {
  const auto determinant = [&](double w) {
    const double square = w * w, half = 0.5 * square * (1 / S + R),
                 root = std::sqrt(half * half - R * square * square / S + square),
                 alpha = std::sqrt(root - half), beta = std::sqrt(root + half);
    const double a = (alpha * alpha + square / S) / alpha, b = (beta * beta - square / S) / beta;
    const double ch = std::cosh(alpha), sh = std::sinh(alpha), c = std::cos(beta), s = std::sin(beta);
    // y = cosh αx − cos βx, ψ = a sinh αx + b sin βx; and y = sinh αx − (a/b) sin βx, ψ = a (cosh αx − cos βx).
    const double bend1 = a * alpha * ch + b * beta * c, shear1 = (alpha - a) * sh + (beta - b) * s,
                 bend2 = a * (alpha * sh + beta * s), shear2 = (alpha - a) * ch + (a - a / b * beta) * c;
    return bend1 * shear2 - bend2 * shear1;
  };
  std::vector<double> list;
  for (double w = 0.5; list.size() < count; w *= 1.01) {
    double low = w, high = 1.01 * w;
    if (determinant(low) * determinant(high) > 0) continue;
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (determinant(low) * determinant(middle) > 0 ? low : high) = middle;
    }
    list.push_back(low);
  }
  return list;
}

}  // namespace

TEST_CASE("a cantilever has the frequencies of Timoshenko's beam", "[beams]") {
  // Nearly rigid in shear they are those of Euler and Bernoulli.
  CHECK(timoshenko_cantilever(1e6, 1e-6, 1)[0] == Approx(3.516015268500151).epsilon(1e-5));
  const double axial = 400, shear = 0.5 * 0.4 * axial;
  const auto known = timoshenko_cantilever(shear, 1 / axial, 3);
  for (const bool free_first : {false, true})
    for (const double frequency : known) {
      CAPTURE(free_first, frequency);
      const auto error = [&](double h) {
        double nearest = INFINITY;  // among those of axial vibration
        for (const double w :
             frequencies(unit_beam(free_first ? "free" : "ground", free_first ? "ground" : "free",
                                   static_cast<int>(std::round(1 / h)), axial,
                                   fmt::format("shear_modulus = {}\nshear_factor = 0.5\n", 0.4 * axial))))
          nearest = std::min(nearest, std::abs(w / frequency - 1));
        return nearest;
      };
      test::check_order({1.0 / 8, 1.0 / 16, 1.0 / 32}, error, 1.8, 2.2);
      CHECK(error(1.0 / 32) < 1.5 * frequency / (24 * 32 * 32));
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
