// Places, normals and sliding directions of random profiles, harmonics, tables, lobes and pockets on bearing,
// journal or both, against a search over all directions that shares no code with the program.
#include "dynamics/system.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/references/profiled_journal.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using verification::random_scenes::Draw;

namespace {

constexpr double radius = 0.02, gap_scale = 1e-4;  // m, of the bearing; clearance
constexpr Vec2 bearing_at{0.01, -0.02}, journal_at{0.03, 0.015};

struct Deviation {
  reference::SurfaceDeviation surface;
  std::string keys;
};

/// Harmonics or a table whose p + p″ is at most `bend`, and p at most 0.4 of the clearance.
Deviation drawn(Draw& draw, double bend) {
  std::vector<std::array<double, 3>> rows;
  std::vector<std::pair<double, double>> points;
  if (draw.chance(0.4)) {
    const int n = draw.whole(5, 20);
    for (int k = 0; k < n; ++k)
      points.emplace_back(2 * M_PI * (k + draw.either_way(0.2)) / n, draw.either_way(1));
  } else {
    for (int k = draw.whole(1, 4); k > 0; --k) {
      const double n = draw.whole(1, 12), size = 1 / std::max(1.0, n * n - 1);
      rows.push_back({n, draw.either_way(size), draw.either_way(size)});
    }
  }
  const reference::SurfaceDeviation shape(rows, points);
  double p = 0, w = 0;
  for (int k = 0; k < 2000; ++k) {
    const auto y = shape.at(2 * M_PI * k / 2000);
    p = std::max(p, std::abs(y.p)), w = std::max(w, std::abs(y.p + y.bend));
  }
  const double scale = std::min(0.4 * gap_scale / p, bend / w);
  std::string list;
  for (auto& [n, cosine, sine] : rows)
    list += fmt::format("[{}, {:.17g}, {:.17g}], ", n, cosine *= scale, sine *= scale);
  for (auto& [angle, y] : points) list += fmt::format("[{:.17g}, {:.17g}], ", angle, y *= scale);
  return {reference::SurfaceDeviation(rows, points),
          fmt::format("{} = [{}]\n", points.empty() ? "harmonics" : "points", list)};
}

struct Counts {
  int profiles = 0, single = 0, several = 0, refused = 0;
};

/// Compares one profile, or two, at ten positions.
void compare(Draw& draw, Counts& counts) {
  const int which = draw.whole(0, 3);  // bearing, journal, both, one that touches in several places
  const bool strong = which == 3, of_bearing = strong ? draw.chance(0.5) : which != 1;
  const double bend =
      gap_scale * (strong ? draw.between(1.5, 4) : draw.between(0.1, 0.9) * (which == 2 ? 0.5 : 1));
  reference::ProfiledJournal one;
  one.clearance = gap_scale, one.radius = radius;
  one.arms = {{{bearing_at.x(), bearing_at.y()}, {journal_at.x(), journal_at.y()}}};
  std::string keys, tables;
  for (const bool journal : {false, true}) {
    if (which != 2 && journal == of_bearing) continue;
    const auto profile = drawn(draw, bend);
    (journal ? one.journal : one.bearing) = profile.surface;
    keys += fmt::format("{}_profile = \"{}\"\n", journal ? "journal" : "bearing", journal ? "j" : "b");
    tables += fmt::format("[profiles.{}]\n{}", journal ? "j" : "b", profile.keys);
  }
  one.tabulate();
  std::optional<System> built;
  try {
    built.emplace(parse_scene(test::body("ring", 1, 1) + test::body("shaft", 1, 1) +
                                  test::surface("s", 0.5, 0.1) +
                                  test::pin("pin", "ring", "shaft", bearing_at, journal_at,
                                            test::loose(gap_scale, radius) + keys) +
                                  tables + test::run_for(1),
                              "profiles")
                      .mechanism);
  } catch (const SceneError&) {
    // Several places where both radii of curvature agree.
    CHECK(strong);
    ++counts.refused;
    return;
  }
  ++counts.profiles;
  const auto& system = *built;
  auto e = system.make_evaluation();
  ContactRow row;
  for (int trial = 0; trial < 10; ++trial) {
    const double at = draw.angle(), turn = draw.angle(), away = gap_scale * draw.between(0.4, 1.3);
    const Vec2 d{away * std::cos(at), away * std::sin(at)};
    std::vector<double> q{draw.either_way(1), draw.either_way(1), draw.angle(), 0, 0, turn}, v(6);
    for (auto& x : v) x = draw.either_way(1);
    const Vec2 centre = Placement{q.data()}.point(0, bearing_at) + d,
               arm = Placement{q.data()}.point(1, journal_at);
    q[3] = centre.x() - arm.x(), q[4] = centre.y() - arm.y();
    reference::ProfiledJournal::Six place{};
    std::copy(q.begin(), q.end(), place.begin());
    const auto expected = one.place(place);
    system.place(0, q.data(), e);
    double least = INFINITY;
    for (int k = 0; k < system.contacts(); ++k) {
      system.contact(k, q.data(), v.data(), e, row);
      if (row.gap > least) continue;
      least = row.gap;
      if (row.gap > expected.gap + 1e-12) continue;
      CAPTURE(which, trial, tables, row.gap, expected.gap, expected.second);
      // Near the wall, where another place is not as near, normals and directions of sliding agree. The place is
      // known to 1e-16 m over the curvature of G, 1e-2 of the clearance or more: 1e-9 rad, by the levers of p″.
      if (expected.gap > 0.05 * gap_scale || expected.second < expected.gap + 0.01 * gap_scale) continue;
      const double normal = row.normal.dot(v.data()), sliding = row.tangent.dot(v.data());
      std::array<double, 6> speeds{};
      std::copy(v.begin(), v.end(), speeds.begin());
      CHECK(normal == Approx(one.times(expected.normal, speeds)).margin(1e-7));
      CHECK(sliding == Approx(one.times(expected.tangent, speeds)).margin(1e-7));
      ++(system.contacts() == 1 ? counts.single : counts.several);
    }
    CAPTURE(which, trial, tables, least, expected.gap);
    // Rounding of positions of 1 m. Beyond the reach of an arc its gap is exact to 1e-6 of itself, and arcs are not
    // those of gaps that no journal can close.
    if (system.contacts() == 1)
      CHECK(least ==
            Approx(expected.gap).margin(1e-14 + 1e-6 * gap_scale * (expected.gap > 0.05 * gap_scale)));
    else if (expected.gap < 0.02 * gap_scale && expected.gap > -0.3 * gap_scale)
      CHECK((least > 0) == (expected.gap > 0));
  }
}

void compare_all(int count, std::uint64_t seed) {
  Counts counts;
  for (int i = 0; i < count; ++i) {
    Draw draw(seed, static_cast<std::uint64_t>(i));
    compare(draw, counts);
  }
  CAPTURE(counts.profiles, counts.single, counts.several, counts.refused);
  CHECK(counts.profiles > count * 3 / 4);
  CHECK(counts.single > count);
  CHECK(counts.several > count / 10);
}

}  // namespace

TEST_CASE("five hundred random profiles have the places of a search over all directions", "[profiles]") {
  compare_all(500, 1);
}

TEST_CASE("ten thousand random profiles have the places of a search over all directions",
          "[profiles][long]") {
  compare_all(10'000, 2);
}
