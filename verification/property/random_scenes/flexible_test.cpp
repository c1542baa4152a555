// Random mechanisms with beams: the generator, and two hundred scenes by every scheme and integrator.
#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "io/scene/write_scene.hpp"
#include "verification/random_scenes/checks/checks.hpp"
#include "verification/random_scenes/runner.hpp"
#include "verification/random_scenes/transform.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using namespace freeplay::verification::random_scenes;

namespace {

/// Two hundred scenes of a selection have these kinds and words; `look` is called with each.
void check_draws(const std::string& selection, const std::set<std::string>& kinds,
                 const std::vector<const char*>& words, const std::function<void(const Scene&)>& look) {
  std::set<std::string> seen;
  std::string all;
  for (int i = 0; i < 200; ++i) {
    const auto drawn = draw(1, i, selection);
    CAPTURE(i, drawn.text);
    seen.insert(drawn.kind);
    all += drawn.text;
    look(parse_scene(drawn.text, "random scene"));
  }
  CHECK(seen == kinds);
  for (const char* word : words) {
    CAPTURE(word);
    CHECK(all.find(word) != all.npos);
  }
}

}  // namespace

TEST_CASE("random mechanisms with beams contain every kind, and beams, joints and contacts of all sorts",
          "[random-scenes][beams]") {
  check_draws("flexible", {"flying-beams", "cantilevers", "beam-loops"},
              {"\"rectangle\"", "\"circle\"", "\"tube\"", "second_moment", "shear_modulus", "curvature",
               "damping", "elements = 1\n", "elements = 8\n", "\"translational\"", "clearance", "\"plane\"",
               "\"discs\"", "speed =", "torque =", "gravity"},
              [](const Scene& scene) {
                CHECK_FALSE(scene.mechanism.beams.empty());
                CHECK(scene.mechanism.beams.size() <= 3);
              });
}

TEST_CASE("the pieces of a beam stated by themselves begin as the beam, and transformations are undone",
          "[random-scenes][beams]") {
  for (int i = 0; i < 30; ++i) {
    const auto scene = parse_scene(draw(2, i, "flexible").text, "random scene"), pieces = by_pieces(scene);
    CAPTURE(i);
    const auto a = assemble(scene.mechanism, scene.run.start),
               b = assemble(pieces.mechanism, pieces.run.start);
    for (std::size_t k = 0; k < a.q.size(); ++k) {
      CHECK(std::abs(a.q[k] - b.q[k]) <= 1e-12 * (1 + std::abs(a.q[k])));
      CHECK(std::abs(a.v[k] - b.v[k]) <= 1e-9 * (1 + std::abs(a.v[k])));
    }
    CHECK(same_facts(pieces, reordered(reordered(pieces))));
    CHECK(same_facts(pieces, rescaled(rescaled(pieces, {8, 2, 0.25}), {0.125, 0.5, 4})));
  }
}

TEST_CASE("random beams with sections, free ends and modes are drawn by their selection alone",
          "[random-scenes][beams]") {
  check_draws("beams", {"sectioned-beams", "reduced-beams"},
              {"sections = [[0, ", "], [0.5, ", "\"free\"", "damping_ratio", "modes = 0\n", "modes = 3\n",
               "\"translational\""},
              [](const Scene& scene) { CHECK_NOTHROW(System(scene.mechanism)); });
}

namespace {

/// Scenes by every method: none has a defect, at most 3 % of the runs are refused.
void check_flexible(const std::string& selection, int count) {
  const test::TemporaryFolder folder;
  const auto rows = judge_all({.seed = 17, .count = count, .kinds = selection}, folder.path(), {});
  CHECK(rows.size() > 5 * static_cast<std::size_t>(count));
  std::size_t refused = 0;
  for (const auto& r : rows) {
    INFO(r.index << " (" << r.kind << ", " << r.way << "): " << r.verdict.check << " " << r.verdict.detail);
    CHECK_FALSE(is_defect(r.verdict.outcome, Suite::flexible));
    refused += r.verdict.outcome == Outcome::refused;
  }
  CHECK(static_cast<double>(refused) <= 0.03 * static_cast<double>(rows.size()));
}

}  // namespace

TEST_CASE("random beams with sections, free ends and modes are correct in every method",
          "[random-scenes][beams]") {
  for (int i = 0; i < 6; ++i) {
    const auto scene = draw(17, i, "beams");
    std::vector<const Way*> by;
    for (const auto& way : ways(Suite::flexible))
      if (has_model(scene, way)) by.push_back(&way);
    assess(scene, by, [&](const Verdict& v) {
      INFO(i << " (" << scene.kind << "): " << v.check << " " << v.detail);
      CHECK_FALSE(is_defect(v.outcome, Suite::flexible));
    });
  }
}

TEST_CASE("two hundred random mechanisms with beams are correct, doubtful or refused in every method",
          "[random-scenes][beams][long]") {
  check_flexible("flexible", 200);
  check_flexible("beams", 200);
}
