// Beams at the start of a run: assembly, stated positions that strain them, free ends, and lengths from
// positions.
#include "mechanism/beam.hpp"

#include "io/scene/write_scene.hpp"
#include "verification/unit/dynamics/unit_beams.hpp"

using namespace freeplay;
using test::light, test::unit_beam;

TEST_CASE("a mechanism with a beam is assembled as with a rigid link", "[beams]") {
  // A slider-crank whose bodies at the ends of the rod state no position: the rod has 0.12 m at the crank
  // angle 60°, and turns with ω_crank r cos φ/(l cos β), sin β = r sin φ/l.
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
  // p(s) = p₀ + (sin(α + κs) − sin α, cos α − cos(α + κs))/κ, from the point p₀ = r + R(θ) a of the hub
  // in the direction α = θ + angle; s is negative from the second end.
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
  // An arc of radius 5 m over a chord of 5 m has a sixth of a circle, to either side; a half circle is
  // the longest.
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
