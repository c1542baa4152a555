// Random scenes with impacts, and the return maps of their own coordinates, differenced without the
// variational equations: for tests of multipliers and exponents.
#pragma once

#include <complex>

#include "analysis/orbit.hpp"
#include "numerics/dense.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::maps {

using random_scenes::Draw;

inline const std::string event_driven = "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";

/// A scene with its own coordinates u, on which the return map is differenced.
struct RandomMap {
  std::string text;
  std::function<std::vector<double>(const State&)> own;
  std::function<State(const State&, const std::vector<double>&)> with;
};

/// Coordinates of bodies on rails along x: (x, vx) of each.
inline RandomMap on_rails(std::string text, std::vector<std::size_t> bodies) {
  return {std::move(text),
          [=](const State& s) {
            std::vector<double> u;
            for (const auto b : bodies) u.insert(u.end(), {s.q[3 * b], s.v[3 * b]});
            return u;
          },
          [=](const State& s, const std::vector<double>& u) {
            State moved = s;
            for (std::size_t i = 0; i < bodies.size(); ++i) {
              moved.q[3 * bodies[i]] = u[2 * i];
              moved.v[3 * bodies[i]] = u[2 * i + 1];
            }
            return moved;
          }};
}

/// A smooth wall of a body for a disc (or a point, of radius 0) of another one, at a point of the former.
inline std::string wall(const char* name, const char* of, const char* disc, double radius, Vec2 at,
                        Vec2 axis) {
  return test::plane(
      name, of, disc, radius, "s",
      fmt::format("at = [[{}, {}], [0, 0]]\naxis = [{}, {}]\n", at.x(), at.y(), axis.x(), axis.y()));
}

/// The drive of a guide by the harmonic curve "shake"; `keys` say what the curve prescribes.
inline std::string shaker(const char* guide, double amplitude, double period,
                          const char* keys = "position = \"shake\"\n") {
  return test::drive("shaker", guide, keys) + test::harmonic("shake", amplitude, period);
}

/// Limits of a random number.
struct Range {
  double low, high;
};

/// A disc between two walls of a box that shakes.
inline std::string disc_in_box(Draw& r, Range restitution) {
  const double half = r.between(0.07, 0.09), mass = r.between(0.1, 1), amplitude = r.between(0.01, 0.02),
               period = r.between(0.08, 0.2);
  return test::body("box", 1, 0.01) + test::body("disc", mass, 1e-3, "velocity = [0.3, 0]\n") +
         test::guide("guide", "ground", "box") + test::guide("rail", "ground", "disc") +
         wall("left", "box", "disc", 0.05, {-half, 0}, {0, -1}) +
         wall("right", "box", "disc", 0.05, {half, 0}, {0, 1}) +
         test::surface("s", r.between(restitution.low, restitution.high)) +
         shaker("guide", amplitude, period) + event_driven;
}

/// Two masses with springs and dampers, one driven by a force, the other with a stop.
inline std::string masses_with_stop(Draw& r, Range restitution, Range damping) {
  const auto spring = [&](const char* name, const char* i, const char* j, Vec2 on_i) {
    const double stiffness = r.between(100, 400);
    return test::spring(name, i, j, on_i, {}, stiffness, 1,
                        fmt::format("damping = {}\n", r.between(damping.low, damping.high)));
  };
  const double one = r.between(0.3, 1), two = r.between(0.3, 1), amplitude = r.between(2, 6),
               period = r.between(0.2, 0.4), upper = 1 + r.between(0.002, 0.01);
  const auto base = spring("base", "ground", "one", {-1, 0}), link = spring("link", "one", "two", {});
  return test::body("one", one, 0.01) + test::body("two", two, 0.01, "position = [1, 0]\n") +
         test::guide("first", "ground", "one") + test::guide("second", "ground", "two") + base + link +
         test::stop("stop", "travel-stop", "second", fmt::format("upper = {}\n", upper)) +
         test::surface("s", r.between(restitution.low, restitution.high)) +
         shaker("first", amplitude, period, "force = \"shake\"\nagainst = \"time\"\n") + event_driven;
}

inline RandomMap disc_in_shaking_box(Draw& r) {
  return on_rails(disc_in_box(r, {0.3, 0.7}) + test::run_for(1), {1});
}

inline RandomMap two_masses(Draw& r) {
  return on_rails(masses_with_stop(r, {0.4, 0.8}, {0.5, 3}) + test::run_for(1), {0, 1});
}

/// A pendulum on the pin of a crank of constant speed, with a spring, a damper and a stop.
inline RandomMap pendulum_on_crank(Draw& r) {
  const double arm = r.between(0.03, 0.06), length = r.between(0.15, 0.25), mass = r.between(0.5, 2),
               inertia = r.between(0.005, 0.02), stiffness = r.between(0.5, 2),
               damping = r.between(0.01, 0.05), stop = -r.between(0.01, 0.05), e = r.between(0.4, 0.8);
  const auto pose = [=](const State& s, const std::vector<double>& u) {
    State moved = s;
    const double crank = s.q[2], turn = s.v[2], angle = u[0], rate = u[1];
    moved.q[3] = arm * std::cos(crank) + length * std::sin(angle);
    moved.q[4] = arm * std::sin(crank) - length * std::cos(angle);
    moved.q[5] = angle;
    moved.v[3] = -arm * turn * std::sin(crank) + length * rate * std::cos(angle);
    moved.v[4] = arm * turn * std::cos(crank) + length * rate * std::sin(angle);
    moved.v[5] = rate;
    return moved;
  };
  return {"gravity = [0, -9.81]\n" + test::body("crank", 1, 0.01) +
              test::body("bar", mass, inertia, fmt::format("position = [{}, {}]\n", arm, -length)) +
              test::pin("main", "ground", "crank") +
              test::pin("pivot", "crank", "bar", {arm, 0}, {0, length}) +
              test::torsion("spring", "ground", "bar", stiffness, fmt::format("damping = {}\n", damping)) +
              test::plane("stop", "ground", "bar", 0, "s",
                          fmt::format("at = [[{}, 0], [0, {}]]\naxis = [0, -1]\n", stop, -length)) +
              test::surface("s", e) + test::motor("motor", "main", r.between(6, 12)) + test::run_for(1) +
              event_driven,
          [](const State& s) {
            return std::vector{s.q[5], s.v[5]};
          },
          pose};
}

/// A journal that stays in contact with a bearing, which shakes; without friction, with a damper. The
/// contact is closed at the section.
inline RandomMap journal_in_shaken_bearing(Draw& r) {
  const double clearance = r.between(0.01, 0.03), mass = r.between(0.5, 2), stiffness = r.between(5, 20),
               damping = r.between(1, 5), amplitude = r.between(2e-4, 1e-3);
  const auto pose = [=](const State& s, const std::vector<double>& u) {
    State moved = s;
    const double angle = u[0], rate = u[1];
    moved.q[3] = s.q[0] + clearance * std::sin(angle);
    moved.q[4] = s.q[1] - clearance * std::cos(angle);
    moved.v[3] = s.v[0] + clearance * rate * std::cos(angle);
    moved.v[4] = s.v[1] + clearance * rate * std::sin(angle);
    return moved;
  };
  return {
      "gravity = [0, -9.81]\n" + test::body("bearing", 1, 0.01) +
          fmt::format("[bodies.journal]\nmass = {}\npoint = true\nposition = [0, {}]\n", mass, -clearance) +
          test::pin("pin", "bearing", "journal", {}, {}, test::loose(clearance, 0.05)) +
          test::spring("damper", "bearing", "journal", {0.5, 0}, {}, stiffness, 0.5,
                       fmt::format("damping = {}\n", damping)) +
          test::surface("s", 0.5) + test::guide("guide", "ground", "bearing") +
          shaker("guide", amplitude, r.between(0.2, 0.5)) + test::run_for(1) + event_driven,
      [](const State& s) {
        const double x = s.q[3] - s.q[0], y = s.q[4] - s.q[1], u = s.v[3] - s.v[0], w = s.v[4] - s.v[1];
        return std::vector{std::atan2(x, -y), (x * w - y * u) / (x * x + y * y)};
      },
      pose};
}

/// One of these, in turn.
inline RandomMap random_map(int i, Draw& r) {
  return i % 4 == 0   ? disc_in_shaking_box(r)
         : i % 4 == 1 ? pendulum_on_crank(r)
         : i % 4 == 2 ? two_masses(r)
                      : journal_in_shaken_bearing(r);
}

inline std::vector<double> map_of(const Scene& scene, const char* formulation, const RandomMap& m,
                                  const State& start, double until, const std::vector<double>& u) {
  Simulation s(scene, formulation, {.start = m.with(start, u)});
  s.run({.until = until, .keep_events = false});
  return m.own(s.state());
}

/// Derivative of the return map by extrapolated central differences over displacements h (m, rad,
/// m/s, rad/s).
inline Eigen::MatrixXd differenced(const Scene& scene, const char* formulation, const RandomMap& m,
                                   const Orbit& found, double h = 1e-5) {
  const auto centre = m.own(found.state);
  const auto n = static_cast<Eigen::Index>(centre.size());
  Eigen::MatrixXd D(n, n);
  const double until = found.state.t + found.periods * found.period;
  for (Eigen::Index j = 0; j < n; ++j) {
    const auto slope = [&](double d) {
      auto low = centre, high = centre;
      low[static_cast<std::size_t>(j)] -= d;
      high[static_cast<std::size_t>(j)] += d;
      const auto a = map_of(scene, formulation, m, found.state, until, low),
                 b = map_of(scene, formulation, m, found.state, until, high);
      Eigen::VectorXd change(n);
      for (Eigen::Index i = 0; i < n; ++i)
        change[i] = (b[static_cast<std::size_t>(i)] - a[static_cast<std::size_t>(i)]) / (2 * d);
      return change;
    };
    D.col(j) = (4 * slope(h) - slope(2 * h)) / 3;
  }
  return D;
}

/// Derivative of a return map with jumps: slopes at the centre of cubic polynomials through `count`
/// displacements within ±h (least squares), and their standard deviations from the residuals.
struct Fitted {
  Eigen::MatrixXd D, deviation;
};
inline Fitted fitted(const Scene& scene, const RandomMap& m, const Orbit& found, double h, int count) {
  const auto centre = m.own(found.state);
  const auto n = static_cast<Eigen::Index>(centre.size());
  const double until = found.state.t + found.periods * found.period;
  Fitted fit{Eigen::MatrixXd(n, n), Eigen::MatrixXd(n, n)};
  for (Eigen::Index j = 0; j < n; ++j) {
    Eigen::MatrixXd X(count, 4), Y(count, n);
    for (int i = 0; i < count; ++i) {
      const double share = (2.0 * i + 1 - count) / count;
      auto moved = centre;
      moved[static_cast<std::size_t>(j)] += share * h;
      const auto end = map_of(scene, "nonsmooth", m, found.state, until, moved);
      for (Eigen::Index k = 0; k < 4; ++k) X(i, k) = std::pow(share, static_cast<double>(k));
      for (Eigen::Index k = 0; k < n; ++k) Y(i, k) = end[static_cast<std::size_t>(k)];
    }
    const Eigen::MatrixXd inverse = (X.transpose() * X).inverse(), C = inverse * X.transpose() * Y;
    const Eigen::MatrixXd rest = Y - X * C;
    for (Eigen::Index k = 0; k < n; ++k) {
      fit.D(k, j) = C(1, k) / h;
      fit.deviation(k, j) = std::sqrt(rest.col(k).squaredNorm() / (count - 4) * inverse(1, 1)) / h;
    }
  }
  return fit;
}

/// Greatest difference of the sums of powers of the multipliers from those of D, relative. They do not depend
/// on the order of multipliers, and are smooth where two coincide.
inline double apart(const std::vector<std::complex<double>>& multipliers, const Eigen::MatrixXd& D) {
  double worst = 0;
  Eigen::MatrixXd power = D;
  for (Eigen::Index k = 1; k <= D.rows(); ++k, power = power * D) {
    std::complex<double> sum = 0;
    double scale = 1;
    for (const auto& x : multipliers) {
      sum += std::pow(x, static_cast<double>(k));
      scale += std::pow(std::abs(x), static_cast<double>(k));
    }
    worst = std::max(worst, std::abs(sum - power.trace()) / scale);
  }
  return worst;
}

/// Greatest change of the sums of powers if the entries of D change by three deviations of random signs.
inline double spread(const std::vector<std::complex<double>>& multipliers, const Fitted& fit) {
  Draw r(20261129, 0);
  const double here = apart(multipliers, fit.D);
  double most = 0;
  for (int i = 0; i < 16; ++i) {
    auto D = fit.D;
    for (auto& x : D.reshaped()) {
      const auto k = &x - D.data();
      x += (r.between(-1, 1) > 0 ? 3 : -3) * fit.deviation.data()[k];
    }
    most = std::max(most, std::abs(apart(multipliers, D) - here));
  }
  return most;
}

}  // namespace freeplay::verification::maps
