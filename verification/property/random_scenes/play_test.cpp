// Output play of random linkages with one to three loops against samples of all joint states.
//
// A crank and up to three dyads, each a coupler and a rocker on the ground, the coupler on a point of the body
// before. The pose of a sample follows from intersections of circles: with the offsets e of the pins of a dyad,
// the coupler's end is at the distances l and r of the displaced centres.
#include "analysis/play/play.hpp"
#include "io/scene/read_scene.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

struct Dyad {
  Vec2 tip;   ///< of the body before, in its frame
  Vec2 base;  ///< of the rocker on the ground
  double coupler, rocker;
  int side;                         ///< of the coupler's end from the line between the centres
  std::array<double, 3> clearance;  ///< of the coupler's pins and the rocker's bearing
};

struct Linkage {
  double crank, angle;
  std::vector<Dyad> dyads;
};

Vec2 turned_by(double angle, const Vec2& v) {
  return {std::cos(angle) * v.x() - std::sin(angle) * v.y(),
          std::sin(angle) * v.x() + std::cos(angle) * v.y()};
}

/// Angles of the coupler and the rocker, and the distance (as a sine) from their dead centres.
struct DyadPose {
  double coupler, rocker, sine;
};
DyadPose close(const Dyad& d, const Vec2& pin, const std::array<Vec2, 3>& e) {
  const Vec2 a = pin + e[0], b = d.base + e[2] - e[1], line = b - a;
  const double distance = line.norm(),
               along = (distance * distance + d.coupler * d.coupler - d.rocker * d.rocker) / (2 * distance),
               across = d.side * std::sqrt(d.coupler * d.coupler - along * along);
  const Vec2 n = (1 / distance) * line, end = a + along * n + across * perp(n);
  const Vec2 c = end - a, r = end - b;
  return {std::atan2(c.y(), c.x()), std::atan2(r.y(), r.x()), std::abs(cross(c, r)) / (d.coupler * d.rocker)};
}

/// The angle of the last rocker, with the offsets of each dyad; the least sine of all dyads.
std::pair<double, double> output(const Linkage& linkage, const std::vector<std::array<Vec2, 3>>& e) {
  Vec2 origin{0, 0};
  double angle = linkage.angle, sine = 1;
  for (std::size_t k = 0; k < linkage.dyads.size(); ++k) {
    const auto& d = linkage.dyads[k];
    const auto pose = close(d, origin + turned_by(angle, d.tip), e[k]);
    origin = d.base + e[k][2], angle = pose.rocker, sine = std::min(sine, pose.sine);
  }
  return {angle, sine};
}

Linkage random_linkage(std::mt19937& random, int loops) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  for (;;) {
    Linkage x{between(0.04, 0.1), between(-3, 3), {}};
    for (int k = 0; k < loops; ++k) {
      Dyad d{k == 0 ? Vec2{x.crank, 0} : Vec2{between(0.05, 0.15), between(-0.1, 0.1)},
             {between(-0.2, 0.2) + 0.25 * k, between(-0.2, 0.2)},
             between(0.1, 0.4),
             between(0.1, 0.3),
             between(-1, 1) < 0 ? -1 : 1,
             {between(1e-5, 3e-4), between(1e-5, 3e-4), between(-2e-4, 2e-4)}};
      for (auto& c : d.clearance) c = std::max(c, 0.0);
      x.dyads.push_back(d);
    }
    const auto [angle, sine] = output(x, std::vector<std::array<Vec2, 3>>(x.dyads.size()));
    if (std::isfinite(angle) && sine > 0.35) return x;
  }
}

Scene scene_of(const Linkage& x) {
  std::string text = test::body("crank", 1, 1, fmt::format("position = [0.0, 0.0]\nangle = {}\n", x.angle)) +
                     test::pin("main", "ground", "crank") +
                     test::drive("motor", "main", fmt::format("speed = 1.0\ninitial_angle = {}\n", x.angle)) +
                     test::surface("s", 0.5) + "[assembly]\napproximate = true\n" + test::run_for(1);
  std::string before = "crank";
  Vec2 origin{0, 0};
  double angle = x.angle;
  const auto keys = [](double c) { return c > 0 ? test::loose(c, 0.01) : ""; };
  for (std::size_t k = 0; k < x.dyads.size(); ++k) {
    const auto& d = x.dyads[k];
    const Vec2 pin = origin + turned_by(angle, d.tip);
    const auto pose = close(d, pin, {});
    const auto coupler = fmt::format("coupler{}", k + 1), rocker = fmt::format("rocker{}", k + 1);
    text +=
        test::body(coupler, 1, 1,
                   fmt::format("position = [{}, {}]\nangle = {}\n", pin.x(), pin.y(), pose.coupler)) +
        test::body(rocker, 1, 1,
                   fmt::format("position = [{}, {}]\nangle = {}\n", d.base.x(), d.base.y(), pose.rocker)) +
        test::pin("A" + coupler, before, coupler, d.tip, {}, keys(d.clearance[0])) +
        test::pin("B" + coupler, coupler, rocker, {d.coupler, 0}, {d.rocker, 0}, keys(d.clearance[1])) +
        test::pin("G" + coupler, "ground", rocker, d.base, {}, keys(d.clearance[2]));
    before = rocker, origin = d.base, angle = pose.rocker;
  }
  return parse_scene(text, "linkage");
}

/// Least and greatest output over random offsets, half of them with all journals on their rims.
std::pair<double, double> sampled(const Linkage& x, std::mt19937& random, int samples) {
  std::uniform_real_distribution<double> turn(-std::numbers::pi, std::numbers::pi), share(0, 1);
  std::vector<std::array<Vec2, 3>> e(x.dyads.size());
  const double ideal = output(x, e).first;
  double least = INFINITY, greatest = -INFINITY;
  for (int i = 0; i < samples; ++i) {
    for (std::size_t k = 0; k < e.size(); ++k)
      for (std::size_t p = 0; p < 3; ++p) {
        const double radius = x.dyads[k].clearance[p] * (i % 2 == 0 ? 1 : std::sqrt(share(random)));
        e[k][p] = turned_by(turn(random), {radius, 0});
      }
    const double y = ideal + std::remainder(output(x, e).first - ideal, 2 * std::numbers::pi);
    least = std::min(least, y), greatest = std::max(greatest, y);
  }
  return {least, greatest};
}

void compare(int samples) {
  constexpr int linkages = 200;
  for (int i = 0; i < linkages; ++i) {
    const int loops = 1 + i % 3;
    std::mt19937 random(static_cast<unsigned>(i));
    const auto x = random_linkage(random, loops);
    const auto play = find_play(scene_of(x), {.quantities = {fmt::format("rocker{}.theta", loops)}});
    const auto& r = play.positions.front().ranges.front();
    const double ideal = output(x, std::vector<std::array<Vec2, 3>>(x.dyads.size())).first;
    const double turns = 2 * std::numbers::pi * std::round((r.ideal - ideal) / (2 * std::numbers::pi));
    CAPTURE(i, loops, r.width(), r.gap());
    CHECK(r.ideal == Approx(ideal + turns).margin(1e-13));
    const auto [least, greatest] = sampled(x, random, samples);
    // What rounding makes of an angle of 3 rad.
    CHECK(least + turns >= r.bound_least - 1e-14);
    CHECK(greatest + turns <= r.bound_greatest + 1e-14);
    CHECK(r.gap() <= 1e-9);
    // A random state of four pins or fewer is near the extreme often enough.
    if (loops == 1) CHECK(greatest - least >= 0.95 * r.width());
  }
}

/// A slider-crank with a loose gudgeon under its weight that turns at 0.5 rad/s; a damper makes the journal settle.
/// `load`: a force on the slider.
Scene slow_slider_crank(const Vec2& load, double turns) {
  return parse_scene(
      "gravity = [0.0, -9.81]\n" + test::body("crank", 1, 0.01) + test::body("rod", 1, 0.01) +
          test::body("slider", 1, 0.01) + test::pin("main", "ground", "crank") +
          test::pin("big_end", "crank", "rod", {0.05, 0}, {-0.15, 0}) +
          test::pin("gudgeon", "rod", "slider", {0.15, 0}, {}, test::loose(1e-3, 11e-3)) +
          test::guide("guide", "ground", "slider") +
          test::surface("s", 0.3, "young = 207e9\npoisson = 0.3\n") + test::motor("motor", "main", 0.5) +
          test::spring("damper", "ground", "slider", {1, 0}, {}, 1e-6, 0.7, "damping = 2.0\n") +
          test::force("load", "slider", load) + fmt::format("[run]\nrevolutions = {}\n", turns),
      "slow");
}

/// Runs over `turns` stay within the range, and follow the loaded poses.
void follow_loads(const std::vector<Vec2>& loads, double turns) {
  constexpr double r = 0.05, l = 0.3, c = 1e-3;
  const auto slider = [](double crank, double rod) {
    return r * std::cos(crank) + std::sqrt(rod * rod - std::pow(r * std::sin(crank), 2));
  };
  for (const Vec2& load : loads) {
    const auto scene = slow_slider_crank(load, turns);
    const auto play = find_play(scene, {.quantities = {"slider.x"},
                                        .over = "main",
                                        .to = 4 * std::numbers::pi,
                                        .points = 721,
                                        .loads = true});
    REQUIRE(play.jumps.empty());
    for (const Family family : {Family::nonsmooth, Family::penalty}) {
      CAPTURE(load.x(), load.y(), name_of(family));
      const auto motion = test::motion_rows(scene, family, 0.01);
      double outside = -INFINITY;
      std::vector<double> beside;
      for (const auto& row : motion.rows) {
        const double crank = row.q[2], x = row.q[6];
        outside = std::max({outside, slider(crank, l - c) - x, x - slider(crank, l + c)});
        if (row.t < 5) continue;
        // The deviation of the loaded pose, between its positions.
        const double place = std::clamp(crank / std::numbers::pi * 180, 0.0, 719.999);
        const auto i = static_cast<std::size_t>(place);
        const auto deviation = [&](std::size_t k) {
          return play.positions[k].up.values[0] - play.positions[k].ranges[0].ideal;
        };
        const double loaded = deviation(i) + (place - std::floor(place)) * (deviation(i + 1) - deviation(i));
        beside.push_back(std::abs(x - slider(crank, l) - loaded));
      }
      // Penetration is below 1e-3 of the clearance. The damper's force, 2 N s/m · 0.025 m/s, is 1 % of half the weight
      // of the rod; the first swing of the journal decays by half in a second.
      CHECK(outside < 1e-3 * c);
      std::ranges::sort(beside);
      CHECK(beside[beside.size() / 2] < 0.015 * c);
      CHECK(beside.back() < 0.04 * c);
    }
  }
}

}  // namespace

TEST_CASE("slow motions stay within the range and follow the loaded poses", "[play]") {
  follow_loads({{3, -20}}, 0.5);
}

TEST_CASE("slow motions over two turns stay within the range under several loads", "[play][long]") {
  follow_loads({{3, -20}, {-3, -20}, {0, -60}}, 2);
}

TEST_CASE("no sample of joint states leaves the bounds of random linkages", "[play]") { compare(5000); }

TEST_CASE("no sample of a million joint states leaves the bounds of random linkages", "[play][long]") {
  compare(1'000'000);
}
