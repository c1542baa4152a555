// Surfaces of bearings and journals in pictures: poses, their magnification, and films.
#include "io/scene/bearing_line.hpp"

#include "io/scene/pose_file.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/figures/pose.hpp"
#include "plots/film/film_drawing.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr double R = 0.02, c = 1e-3, degree = M_PI / 180;

/// A bearing of the ground at (0.1, 0.2) with two lobes, a journal with three.
Scene lobed(const std::string& journal = "journal_profile = \"j\"\n") {
  return parse_scene(
      test::body("shaft", 1, 1) + test::surface("s", 0.5) +
          test::pin("pin", "ground", "shaft", {0.1, 0.2}, {0.01, 0},
                    test::loose(c, R) + "bearing_profile = \"b\"\n" + journal) +
          "[profiles.b]\nharmonics = [[2, 1e-4, 0]]\n[profiles.j]\nharmonics = [[3, 0, 2e-5]]\n" +
          test::run_for(1),
      "lobed");
}
/// The shaft at the angle θ with its centre at d from the bearing's.
std::vector<double> pose(const Vec2& d, double theta) {
  return {0.1 + d.x() - 0.01 * std::cos(theta), 0.2 + d.y() - 0.01 * std::sin(theta), theta};
}

std::vector<plots::Shape> shapes_of(const Scene& scene, const std::vector<double>& q) {
  std::vector<plots::Shape> list;
  for (const auto& s : pose_shapes(scene, q))
    list.push_back({std::string(s.kind), s.name, s.at.x(), s.at.y(), s.more.x(), s.more.y()});
  return list;
}
/// Greatest distance of a surface in the direction φ from the bearing's centre.
double reach(const std::vector<plots::Shape>& shapes, std::string_view kind, double phi) {
  double most = -INFINITY;
  for (const auto& s : shapes)
    if (s.kind == kind) most = std::max(most, (s.x - 0.1) * std::cos(phi) + (s.y - 0.2) * std::sin(phi));
  return most;
}

}  // namespace

TEST_CASE("the magnified surfaces of a bearing and a journal have the magnified gap", "[figures][profiles]") {
  const auto scene = lobed();
  // Directions of whole degrees are those of points of both surfaces.
  const Vec2 d{4e-4, -3e-4};
  const double theta = 50 * degree;
  const auto shapes = shapes_of(scene, pose(d, theta));
  for (const double factor : {1.0, 7.0}) {
    CAPTURE(factor);
    const auto drawn = plots::magnified(shapes, factor);
    for (int k = 0; k < 360; ++k) {
      const double phi = k * degree, p_b = 1e-4 * std::cos(2 * phi), p_j = 2e-5 * std::sin(3 * (phi - theta));
      const double out = d.x() * std::cos(phi) + d.y() * std::sin(phi);
      // Convex curves reach farthest in the direction of the normal: rounding only.
      CHECK(reach(drawn, "bearing", phi) == Approx(R - c + factor * (c + p_b)).margin(1e-14));
      CHECK(reach(drawn, "journal", phi) == Approx(R - c + factor * (p_j + out)).margin(1e-14));
    }
  }
}

TEST_CASE("a joint with a profile shows both surfaces in place of its circle", "[figures][profiles]") {
  const auto count = [](const std::vector<plots::Shape>& shapes, std::string_view kind) {
    return std::ranges::count_if(shapes, [&](const plots::Shape& s) { return s.kind == kind; });
  };
  const auto both = shapes_of(lobed(""), pose({0, 0}, 0));  // a round journal, too
  CHECK(count(both, "bearing") == 361);
  CHECK(count(both, "journal") == 361);
  for (const auto& s : both)
    if (s.kind == "loose") CHECK(s.a == 0);
  CHECK(has_profiles(lobed().mechanism));
  auto round = lobed();
  auto& joint = std::get<RevoluteJoint>(round.mechanism.joints[0]);
  joint.clearance->bearing_profile = joint.clearance->journal_profile = -1;
  CHECK_FALSE(has_profiles(round.mechanism));
  CHECK(count(shapes_of(round, pose({0, 0}, 0)), "journal") == 0);
  CHECK(magnified_words(20, true, false) == "deflection × 20");
  CHECK(magnified_words(5, false, true) == "clearance and deviations × 5");
  CHECK(magnified_words(5, true, true) == "deflection, clearance and deviations × 5");
}

TEST_CASE("a film draws surfaces in the frames of their bodies, magnified", "[animate][profiles]") {
  const auto scene = lobed();
  const auto& joint = std::get<RevoluteJoint>(scene.mechanism.joints[0]);
  const auto lines = surface_lines(scene.mechanism, joint);
  REQUIRE(lines.size() == 2);
  report::FilmRun run;
  run.t = {0};
  run.bodies = {"shaft"};
  const Vec2 d{2e-4, 1e-4};
  const auto q = pose(d, 0.7);
  for (const double x : q) run.poses.push_back({x});
  run.shapes.push_back({"loose", "pin", -1, -1, {joint.at[0]}, {0, 0}});
  run.shapes.push_back({"bearing", "pin", -1, -1, lines[0].points, {0, 0}, lines[0].nominal});
  run.shapes.push_back({"journal", "pin", 0, 0, lines[1].points, {0, 0}, lines[1].nominal});
  CHECK(run.has_surfaces());
  const auto expected = plots::magnified(shapes_of(scene, q), 9);
  for (const std::size_t which : {1, 2}) {
    const auto line = run.line(run.shapes[which], {0, 0}, 9);
    std::size_t k = 0;
    for (const auto& s : expected) {
      if (s.kind != run.shapes[which].kind) continue;
      REQUIRE(k < line.size());
      CHECK((line[k++] - Vec2{s.x, s.y}).norm() < 1e-14);
    }
    CHECK(k == 361);
  }
  const std::vector runs{run};
  const report::FilmDrawing drawing(runs, {.title = "t", .magnify = 9});
  CHECK(drawing.frame(0, 0).find("clearance and deviations × 9") != std::string::npos);
}
