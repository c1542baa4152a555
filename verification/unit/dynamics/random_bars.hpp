// Random mechanisms of bars with random frames: chains, slider-cranks, four-bars, toggles and yokes,
// with the rows of their joints, and their scenes with some of the initial values.
#pragma once

#include <Eigen/Dense>
#include <random>

#include "verification/support/runs.hpp"

namespace freeplay::test::bars {

using Eigen::MatrixXd, Eigen::VectorXd;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double between(double a, double b) { return a + (b - a) * static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double angle() { return between(-std::numbers::pi, std::numbers::pi); }
  double decades(double a, double b) { return std::pow(10, between(a, b)); }
  int below(int n) { return static_cast<int>(between(0, n)); }

 private:
  std::mt19937_64 engine_;
};

inline Vec2 unit(double angle) { return {std::cos(angle), std::sin(angle)}; }
inline Vec2 turned(const Vec2& r, double angle) {
  return {std::cos(angle) * r.x() - std::sin(angle) * r.y(),
          std::sin(angle) * r.x() + std::cos(angle) * r.y()};
}

struct Bar {
  std::string name;
  double mass, inertia;
  Vec2 at;
  double angle;
};

/// A joint of bodies i and j (−1: ground) with points p and r: pin, guide along `axis` without
/// rotation, or slot of i along `axis`.
struct Link {
  enum class Kind { pin, guide, slot } kind;
  std::string name;
  int i, j;
  Vec2 p, r, axis;
};

struct Made {
  std::string kind;
  std::vector<Bar> bars;
  std::vector<Link> links;
  double length = 0;

  VectorXd pose() const {
    return stacked([](const Bar& b) { return Eigen::Vector3d(b.at.x(), b.at.y(), b.angle); });
  }
  VectorXd masses() const {
    return stacked([](const Bar& b) { return Eigen::Vector3d(b.mass, b.mass, b.inertia); });
  }
  /// Three values of each bar.
  template <class Values>
  VectorXd stacked(const Values& of) const {
    VectorXd x(3 * static_cast<long>(bars.size()));
    for (std::size_t b = 0; b < bars.size(); ++b) x.segment<3>(3 * static_cast<long>(b)) = of(bars[b]);
    return x;
  }
  /// Violations of the joints at q, and the rows of their rates.
  void rows(const VectorXd& q, VectorXd& phi, MatrixXd& G) const {
    std::vector<std::pair<double, VectorXd>> list;
    const auto at = [&](int b) { return b < 0 ? Vec2{} : Vec2{q[3 * b], q[3 * b + 1]}; };
    const auto turn = [&](int b) { return b < 0 ? 0 : q[3 * b + 2]; };
    for (const auto& l : links) {
      const Vec2 own = turned(l.p, turn(l.i)), other = turned(l.r, turn(l.j));
      const Vec2 d = at(l.j) + other - at(l.i) - own;
      // The rate of dot(n, d), with n turning with body i if it does.
      const auto along = [&](const Vec2& n, bool follows) {
        VectorXd row = VectorXd::Zero(q.size());
        if (l.j >= 0) row.segment<3>(3 * l.j) << n.x(), n.y(), dot(n, perp(other));
        if (l.i >= 0)
          row.segment<3>(3 * l.i) -=
              Eigen::Vector3d(n.x(), n.y(), dot(n, perp(own)) - (follows ? dot(perp(n), d) : 0));
        list.emplace_back(dot(n, d), row);
      };
      if (l.kind == Link::Kind::pin) {
        along({1, 0}, false);
        along({0, 1}, false);
        continue;
      }
      along(perp(turned(l.axis, turn(l.i))), true);
      if (l.kind != Link::Kind::guide) continue;
      VectorXd row = VectorXd::Zero(q.size());
      if (l.j >= 0) row[3 * l.j + 2] = 1;
      if (l.i >= 0) row[3 * l.i + 2] = -1;
      list.emplace_back(turn(l.j) - turn(l.i), row);
    }
    phi.resize(static_cast<long>(list.size()));
    G.resize(phi.size(), q.size());
    for (std::size_t k = 0; k < list.size(); ++k) {
      phi[static_cast<long>(k)] = list[k].first;
      G.row(static_cast<long>(k)) = list[k].second.transpose();
    }
  }
};

class Maker {
 public:
  explicit Maker(Random& r) : r_(r) {}

  Made make() {
    for (;;) {
      made_ = {};
      scale_ = r_.decades(-2, 1);
      const Vec2 o{scale_ * r_.between(-1, 1), scale_ * r_.between(-1, 1)};
      const int kind = r_.below(5);
      const bool done = kind == 0   ? chain(o)
                        : kind == 1 ? slider(o)
                        : kind == 2 ? four_bar(o)
                        : kind == 3 ? toggle(o)
                                    : yoke(o);
      if (done) {
        made_.length = scale_;
        return made_;
      }
    }
  }

 private:
  struct Ends {
    int body;
    Vec2 near, far;  // of its frame
  };
  /// A bar between two points of the world.
  Ends bar(const Vec2& a, const Vec2& b) {
    const Vec2 line = b - a;
    const double l = line.norm(), inside = r_.angle();
    const Vec2 near = l * Vec2{r_.between(-0.7, 0.1), r_.between(-0.2, 0.2)};
    const double mass = r_.decades(-1.5, 1.5);
    double angle = std::atan2(line.y(), line.x()) - inside;
    angle -= 2 * std::numbers::pi * std::round(angle / (2 * std::numbers::pi));
    const Ends e{static_cast<int>(made_.bars.size()), turned(near, inside),
                 turned(near, inside) + l * unit(inside)};
    made_.bars.push_back({fmt::format("b{}", e.body), mass, mass * l * l * r_.between(0.03, 0.3),
                          a - turned(e.near, angle), angle});
    return e;
  }
  int block(const Vec2& at) {
    const double mass = r_.decades(-1.5, 1.5);
    made_.bars.push_back(
        {fmt::format("b{}", made_.bars.size()), mass, mass * scale_ * scale_ * r_.between(0.01, 0.1), at, 0});
    return static_cast<int>(made_.bars.size()) - 1;
  }
  void link(Link::Kind kind, int i, int j, const Vec2& p, const Vec2& r, const Vec2& axis = {1, 0}) {
    const auto name = fmt::format("j{}", made_.links.size());
    const bool swap = kind == Link::Kind::pin && r_.below(2) == 1;
    made_.links.push_back(swap ? Link{kind, name, j, i, r, p, axis} : Link{kind, name, i, j, p, r, axis});
  }
  void pin(int i, int j, const Vec2& p, const Vec2& r) { link(Link::Kind::pin, i, j, p, r); }
  /// The corner of a triangle on a–b with sides la and lb, on a random side.
  std::optional<Vec2> corner(const Vec2& a, const Vec2& b, double la, double lb) {
    const Vec2 d = b - a;
    const double l = d.norm(), x = (l * l + la * la - lb * lb) / (2 * l), h = la * la - x * x;
    if (!(h > 0.01 * la * la)) return std::nullopt;
    return a + (x / l) * d + ((r_.below(2) == 1 ? 1 : -1) * std::sqrt(h) / l) * perp(d);
  }
  double side(double a, double b) { return scale_ * r_.between(a, b); }

  bool chain(const Vec2& o) {
    made_.kind = "chain";
    const int n = 1 + r_.below(4);
    Vec2 at = o, on = o;
    int last = -1;
    for (int i = 0; i < n; ++i) {
      const Vec2 next = at + side(0.3, 1) * unit(r_.angle());
      const auto e = bar(at, next);
      pin(last, e.body, on, e.near);
      last = e.body, on = e.far, at = next;
    }
    return true;
  }
  /// A slider at the end of a rod from p, on the body `from` at `on`.
  bool slide(const Vec2& p, int from, const Vec2& on, double rod) {
    const double course = r_.angle();
    const Vec2 u = unit(course), foot = p + (rod * r_.between(-0.8, 0.8)) * perp(u);
    const double across = (foot - p).norm(),
                 s = (r_.below(2) == 1 ? 1 : -1) * std::sqrt(rod * rod - across * across);
    const Vec2 end = foot + s * u;
    const auto e = bar(p, end);
    pin(from, e.body, on, e.near);
    const Vec2 off{side(-0.1, 0.1), side(-0.1, 0.1)};
    const int b = block(end - off);
    pin(e.body, b, e.far, off);
    link(Link::Kind::guide, -1, b, foot + side(-1, 1) * u, off, u);
    return true;
  }
  bool slider(const Vec2& o) {
    made_.kind = "slider-crank";
    const Vec2 a = o + side(0.2, 0.5) * unit(r_.angle());
    const auto crank = bar(o, a);
    pin(-1, crank.body, o, crank.near);
    return slide(a, crank.body, crank.far, side(0.6, 1.5));
  }
  struct Corner {
    Ends rocker;
    Vec2 at;  // of the world
  };
  /// Crank, coupler and rocker; returns the rocker and the place of its end.
  std::optional<Corner> loop(const Vec2& o) {
    const Vec2 d = o + side(0.5, 1) * unit(r_.angle()), a = o + side(0.2, 0.6) * unit(r_.angle());
    const auto c = corner(a, d, side(0.3, 1.2), side(0.3, 1.2));
    if (!c) return std::nullopt;
    const auto crank = bar(o, a), coupler = bar(a, *c), rocker = bar(d, *c);
    pin(-1, crank.body, o, crank.near);
    pin(crank.body, coupler.body, crank.far, coupler.near);
    pin(coupler.body, rocker.body, coupler.far, rocker.far);
    pin(-1, rocker.body, d, rocker.near);
    return Corner{rocker, *c};
  }
  bool four_bar(const Vec2& o) {
    made_.kind = "four-bar";
    return loop(o).has_value();
  }
  bool toggle(const Vec2& o) {
    made_.kind = "toggle";
    const auto end = loop(o);
    return end && slide(end->at, end->rocker.body, end->rocker.far, side(0.5, 1.2));
  }
  bool yoke(const Vec2& o) {
    made_.kind = "yoke";
    const double course = r_.angle(), slant = course + r_.between(0.6, 2.5);
    const Vec2 u = unit(course), a = o + side(0.2, 0.6) * unit(r_.angle());
    const auto crank = bar(o, a);
    pin(-1, crank.body, o, crank.near);
    const Vec2 p{side(-0.2, 0.2), side(-0.2, 0.2)}, r{side(-0.2, 0.2), side(-0.2, 0.2)};
    // The slot passes through the crank's pin.
    const Vec2 at = a - side(-0.5, 0.5) * unit(slant) - p;
    const int b = block(at);
    link(Link::Kind::guide, -1, b, at + r + side(-1, 1) * u, r, u);
    link(Link::Kind::slot, b, crank.body, p, crank.far, unit(slant));
    return true;
  }

  Random& r_;
  Made made_;
  double scale_ = 1;
};

/// Which values a scene states: position, angle, velocity and angular velocity of each body.
using Stated = std::vector<std::array<bool, 4>>;

inline std::string text_of(const Made& m, const VectorXd& q, const VectorXd& v, const Stated& stated,
                           Random& r, const std::string& run) {
  std::string text = "format = 2\n";
  const auto body = [&](int b) {
    return b < 0 ? std::string("ground") : m.bars[static_cast<std::size_t>(b)].name;
  };
  std::vector<int> order;
  for (int b = 0; b < static_cast<int>(m.bars.size()); ++b) order.insert(order.begin() + r.below(b + 1), b);
  for (const int b : order) {
    const auto& facts = m.bars[static_cast<std::size_t>(b)];
    const auto& s = stated[static_cast<std::size_t>(b)];
    std::string keys;
    if (s[0]) keys += fmt::format("position = [{}, {}]\n", q[3 * b], q[3 * b + 1]);
    if (s[1]) keys += fmt::format("angle = {}\n", q[3 * b + 2]);
    if (s[2]) keys += fmt::format("velocity = [{}, {}]\n", v[3 * b], v[3 * b + 1]);
    if (s[3]) keys += fmt::format("angular_velocity = {}\n", v[3 * b + 2]);
    text += test::body(facts.name, facts.mass, facts.inertia, keys);
  }
  for (const auto& l : m.links) {
    const char* type = l.kind == Link::Kind::pin     ? "revolute"
                       : l.kind == Link::Kind::guide ? "translational"
                                                     : "slot";
    text += joint(l.name, type, body(l.i), body(l.j), l.p, l.r,
                  l.kind == Link::Kind::pin ? "" : fmt::format("axis = [{}, {}]\n", l.axis.x(), l.axis.y()));
  }
  if (r.below(3) == 0) text += drive("motor", "j0", "voltage = 12\nresistance = 1\ntorque_constant = 0.1\n");
  return text + run_for(1, run);
}

}  // namespace freeplay::test::bars
