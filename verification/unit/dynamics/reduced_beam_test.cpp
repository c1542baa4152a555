// Beams reduced to a few of their modes, against full beams and closed forms.
#include "analysis/reduced_modes.hpp"
#include "io/scene/write_scene.hpp"
#include "mechanism/beam.hpp"
#include "verification/unit/dynamics/unit_beams.hpp"

using namespace freeplay;
using test::bent, test::frequencies, test::light, test::unit_beam;

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
