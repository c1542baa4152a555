// Lines of beams in figures: through the nodes and along a known curve, magnified about the unloaded beam, alike in
// poses and films.
#include "io/scene/beam_line.hpp"

#include <regex>

#include "io/scene/pose_file.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/figures/pose.hpp"
#include "plots/film/film_drawing.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double length = 2, radius = length / (std::numbers::pi / 2);
constexpr int pieces = 6;

/// Place and direction of the arc at the angle phi from its start at the origin, where it is along x.
Vec2 on_arc(double phi, double r = radius) { return {r * std::sin(phi), r * (1 - std::cos(phi))}; }

/// A cantilever from the ground at the origin along x to a body whose centre is 0.1 m beyond the end of the beam.
Scene cantilever(double curvature = 0) {
  return parse_scene(
      test::body("tip", 1, 1) +
          fmt::format("[beams.rod]\nbetween = [\"ground\", \"tip\"]\nat = [[0, 0], [-0.1, 0]]\n"
                      "length = {}\nelements = {}\nyoung = 1e9\ndensity = 1e3\narea = 1e-4\n"
                      "second_moment = 1e-9\ncurvature = {}\n",
                      length, pieces, curvature) +
          test::run_for(1),
      "cantilever");
}

/// q of the cantilever bent to an arc that turns by `angle`.
std::vector<double> bent(double angle) {
  const double r = length / angle;
  const auto end = on_arc(angle, r);
  std::vector<double> q{end.x() + 0.1 * std::cos(angle), end.y() + 0.1 * std::sin(angle), angle};
  for (int n = 0; n < pieces; ++n) {
    const double phi = angle * (n + 0.5) / pieces;
    const auto p = on_arc(phi, r);
    q.insert(q.end(), {p.x(), p.y(), phi});
  }
  return q;
}

std::vector<PoseShape> line_in(const Scene& scene, const std::vector<double>& q) {
  auto shapes = pose_shapes(scene, q);
  std::erase_if(shapes, [](const PoseShape& s) { return s.kind != "beam"; });
  return shapes;
}

/// Distance from a point to the nearest of the drawn points.
double gap(const Vec2& point, const std::vector<PoseShape>& line) {
  double least = INFINITY;
  for (const auto& s : line) least = std::min(least, (s.at - point).norm());
  return least;
}

}  // namespace

TEST_CASE("a bent beam is one line through its ends and the middles of its pieces", "[figures][beams]") {
  const auto scene = cantilever();
  const double quarter = std::numbers::pi / 2;
  const auto q = bent(quarter);
  const auto line = line_in(scene, q);
  REQUIRE(line.size() > 2 * pieces);
  // Nodes are on the line to rounding: its weights there are 0 and 1.
  CHECK(line.front().at.norm() < 1e-12);
  CHECK((line.back().at - on_arc(quarter)).norm() < 1e-12);
  for (int n = 0; n < pieces; ++n) CHECK(gap(on_arc(quarter * (n + 0.5) / pieces), line) < 1e-12);
  const Vec2 middle{0, radius};
  double turned = -1;
  for (const auto& s : line) {
    CHECK(std::abs((s.at - middle).norm() - radius) < 1e-3 * length);
    // In the order of the length, at equal shares of it in each interval.
    const double phi = std::atan2(s.at.x(), radius - s.at.y());
    CHECK(phi > turned);
    turned = phi;
    // Its place on the unloaded beam, on the chord from the origin.
    CHECK(std::abs(cross(s.more, line.back().at)) < 1e-12);
  }
  // Neither pieces nor elements are drawn by themselves.
  for (const auto& s : pose_shapes(scene, q)) {
    CAPTURE(s.kind, s.name);
    CHECK((s.kind == "beam" || s.kind == "support" || s.name == "tip"));
  }
}

TEST_CASE("the deflection of a beam is magnified about the chord between its ends", "[figures][beams]") {
  // An arc of the small angle a has the deflection a s (L − s)/(2 L) from its chord, to a² of itself.
  constexpr double angle = 1e-3;
  const auto line = line_in(cantilever(), bent(angle));
  std::vector<plots::Shape> shapes;
  for (const auto& s : line)
    shapes.push_back({std::string(s.kind), s.name, s.at.x(), s.at.y(), s.more.x(), s.more.y()});
  const Vec2 along = line.back().at.direction();
  for (const double factor : {1.0, 10.0}) {
    const auto drawn = plots::magnified(shapes, factor);
    for (const auto& s : drawn) {
      const Vec2 p{s.x, s.y};
      const double x = dot(along, p), deflection = cross(p, along);
      // 1e-5 of the greatest deflection: terms of a² = 1e-6; a cubic has no error for the parabola of small angles.
      CHECK(std::abs(deflection - factor * angle * x * (length - x) / (2 * length)) <
            1e-5 * factor * angle * length / 8);
    }
    CHECK(std::hypot(drawn.front().x, drawn.front().y) < 1e-15);
    CHECK(std::hypot(drawn.back().x - line.back().at.x(), drawn.back().y - line.back().at.y()) < 1e-15);
  }
}

TEST_CASE("a curved beam without load has no deflection to magnify", "[figures][beams]") {
  const double quarter = std::numbers::pi / 2;
  // Between nodes θ = π/12 apart the cubic differs from the arc by r θ⁴/384 = 1.2e-5 r.
  for (const auto& s : line_in(cantilever(1 / radius), bent(quarter)))
    CHECK((s.at - s.more).norm() < 2e-5 * radius);
}

TEST_CASE("the line of a beam reaches its free end, half a piece beyond the outer middle",
          "[figures][beams]") {
  Mechanism mechanism = cantilever().mechanism;
  mechanism.beams.front().between[1] = free_end;
  const auto line = beam_lines(mechanism).front();
  const double a = 0.3;
  // The last piece at (3, 4), turned by a.
  const auto points = drawn(line, [&](int body, const Vec2& at) {
    if (body != mechanism.beams.front().first + pieces - 1) return at;
    return Vec2{3, 4} + at.x() * Vec2{std::cos(a), std::sin(a)} + at.y() * Vec2{-std::sin(a), std::cos(a)};
  });
  const Vec2 end = Vec2{3, 4} + 0.5 * length / pieces * Vec2{std::cos(a), std::sin(a)};
  CHECK((points.back().at - end).norm() < 1e-12);
}

TEST_CASE("a film draws a beam as one line, with its magnification in words", "[animate][beams]") {
  const auto scene = cantilever();
  report::FilmRun run;
  run.t = {0};
  run.beams = beam_lines(scene.mechanism);
  for (const auto& body : scene.mechanism.bodies) run.bodies.push_back(body.name);
  for (const double x : bent(0.2)) run.poses.push_back({x});
  const std::vector runs{run};
  const double factor = GENERATE(1.0, 10.0);
  const report::FilmDrawing drawing(runs, {.title = "t", .magnify = factor});
  const auto svg = drawing.frame(0, 0);
  CHECK((svg.find("deflection × 10") != svg.npos) == (factor == 10));
  std::smatch found;
  REQUIRE(std::regex_search(svg, found, std::regex("<polyline points=\"([-0-9., ]+)\" fill=\"none\"")));
  std::istringstream numbers(std::regex_replace(found[1].str(), std::regex(","), " "));
  const Vec2 corner{0, 34};  // of the panel
  for (const auto& s : line_in(scene, bent(0.2))) {
    double x = NAN, y = NAN;
    numbers >> x >> y;
    const auto p = drawing.place(0, DrawnBeamPoint{s.at, s.more}.magnified(factor)) - corner;
    CHECK(std::abs(p.x() - x) < 0.02);  // two decimals
    CHECK(std::abs(p.y() - y) < 0.02);
  }
}
