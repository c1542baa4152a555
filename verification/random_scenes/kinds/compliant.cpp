// Random scenes with springs of variable rate, bushings and cams.
#include <algorithm>
#include <numbers>

#include "verification/random_scenes/draft.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Law of a spring of this rate about a length (or angle); `force` is the size of its force there.
std::string law(Draw& draw, double rate, double rest, double unit, double force, const char* table,
                const char* free) {
  if (draw.chance(0.3)) {
    std::string points;
    double at = rest - unit, pull = -rate * unit * draw.between(0.2, 1);
    for (int i = 0; i < draw.whole(2, 5); ++i) {
      points += toml("{}{}", i ? ", " : "", Vec2{at, pull});
      at += unit * draw.between(0.2, 1);
      pull += rate * unit * draw.between(0, 1);
    }
    return toml("{} = [{}]\n{}", table, points,
                draw.chance(0.3) ? toml("one_way = '{}'\n", draw.chance(0.5) ? "pull" : "push") : "");
  }
  auto text = toml("stiffness = {}\n{} = {}\n", rate, free, rest);
  if (draw.chance(0.4)) text += toml("cubic = {}\n", rate / (unit * unit) * draw());
  if (draw.chance(0.4)) text += toml("preload = {}\n", force * draw.either_way(1));
  if (draw.chance(0.5)) text += toml("one_way = '{}'\n", draw.chance(0.6) ? "pull" : "push");
  return text;
}

}  // namespace

void compliant(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double L = s.length, m = s.mass;
  const int count = draw.whole(1, 3);
  std::string last = "ground";
  double lightest = m;
  for (int i = 0; i < count; ++i) {
    DraftBody b;
    b.name = toml("b{}", i);
    b.mass = m * draw.decades(-0.5, 0.5);
    b.inertia = b.mass * L * L * draw.between(0.1, 0.5);
    b.at = {L * (i + 1), L * draw.either_way(0.1)};
    b.angle = draw.either_way(0.3);
    b.velocity = draw.along(0.3 * s.speed * draw());
    b.spin = draw.either_way(0.5) * s.speed / L;
    out.body(b);
    lightest = std::min({lightest, b.mass, b.inertia / (L * L)});
    const double rate = b.mass * std::pow(draw.between(1, 6) / s.time(), 2);
    // Cubic terms, tables and preload raise the frequency by a factor of at most about three.
    out.fastest = std::max(out.fastest, 6 * std::sqrt(rate / std::min(lightest, b.mass)));
    const auto between = toml("between = ['{}', '{}']\n", last, b.name);
    const auto damped = draw.chance(0.4);
    if (draw.chance(0.5)) {
      out.load("bushing",
               toml("{}at = [{}, {}]\naxis = {}\nstiffness = {}\ndamping = {}\ntorsional_stiffness = {}\n",
                    between, Vec2{last == "ground" ? 0.5 * L : 0.4 * L, 0}, Vec2{-0.5 * L, 0}, draw.along(1),
                    Vec2{rate, rate * draw()}, Vec2{damped ? b.mass / s.time() * draw() : 0, 0},
                    0.2 * rate * L * L));
    } else {
      out.load("spring-damper", between + toml("at = [{}, {}]\n", Vec2{0, 0}, Vec2{0.1 * L, 0}) +
                                    law(draw, rate, L * draw.between(0.7, 1.3), 0.5 * L, 0.3 * rate * L,
                                        "force_table", "free_length") +
                                    (damped ? toml("damping = {}\n", b.mass / s.time() * draw()) : ""));
      out.load("torsional-spring-damper", between + law(draw, 0.2 * rate * L * L, draw.either_way(0.5), 0.5,
                                                        0.05 * rate * L * L, "torque_table", "free_angle"));
    }
    last = b.name;
  }
  out.flight = 0.1 * s.time();
  out.speed = s.speed;
  out.duration = draw.between(2, 8) * s.time();
}

void cams(Draw& draw, Draft& out) {
  const auto s = sizes(draw);
  const double R = s.length, lift = R * draw.between(0.02, 0.12), omega = s.speed / lift * draw.sign();
  const bool roller = draw.chance(0.5), driven = draw.chance(0.6);
  const double r = roller ? R * draw.between(0.1, 0.3) : 0;
  DraftBody cam{"cam", s.mass, s.mass * R * R * draw.between(0.3, 1), {0, 0}, draw.angle(), {0, 0}, omega};
  DraftBody follower;
  follower.name = "follower";
  follower.mass = s.mass * mass_factor(draw);
  follower.inertia = follower.mass * R * R;
  const double slope = draw.angle();  // the direction of its guide
  const Vec2 up{std::cos(slope), std::sin(slope)};
  const double height = R + r + lift * draw.between(1.01, 1.5);
  follower.at = height * up + (roller ? 0.0 : R * draw.either_way(0.2)) * perp(up);
  follower.angle = slope - std::numbers::pi / 2;
  follower.velocity = s.speed * draw.either_way(0.5) * up;
  out.body(cam);
  out.body(follower);
  out.joint("revolute", "ground", "cam", {0, 0}, {0, 0});
  const auto shaft = out.last_joint();
  out.joint("translational", "ground", "follower", follower.at, {0, 0},
            toml("axis = {}\nangle = {}\n", up, follower.angle));
  out.text += "[contacts.lobe]\ntype = \"cam\"\nbetween = [\"cam\", \"follower\"]\nsurface = \"s\"\n";
  // In its own frame the follower is above the cam.
  out.text += roller ? toml("follower = 'roller'\nroller_radius = {}\n", r) : "axis = [-1, 0]\n";
  out.text += toml("base_radius = {}\n", R);
  if (draw.chance(0.3)) {
    std::string points;
    const int n = draw.whole(5, 12);
    for (int i = 0; i < n; ++i) {
      const double phi = 2 * std::numbers::pi * i / n;
      points += toml("{}{}", i ? ", " : "", Vec2{phi, 0.5 * lift * (1 - std::cos(phi))});
    }
    out.text += toml("lift_table = [{}]\n", points);
  } else {
    out.text += toml("law = '{}'\nlift = {}\nstart = {}\nrise = {}\ndwell = {}\nreturn = {}\n",
                     draw.chance(0.5) ? "cycloidal" : "polynomial", lift, draw.angle(), draw.between(2, 2.6),
                     draw.between(0, 1), draw.between(2, 2.6));
  }
  if (driven) out.drive(shaft, toml("speed = {}\n", omega));
  const double rate = follower.mass * std::pow(draw.between(0.1, 0.7) * omega, 2);
  out.fastest = std::abs(omega);
  out.load("spring-damper",
           toml("between = ['ground', 'follower']\nat = [{}, [0, 0]]\nstiffness = {}\nfree_length = {}\n",
                (height + 3 * R) * up + dot(perp(up), follower.at) * perp(up), rate,
                3 * R + lift * draw.between(0, 6)));
  out.ends(s.speed, 0.2 * lift / s.speed, draw.between(5, 30) / std::abs(omega));
  out.surface(draw, follower.mass, s.speed, R, lift * draw.decades(-3, -2));
}

}  // namespace freeplay::verification::random_scenes
