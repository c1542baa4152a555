// Scenes with the return maps of their own coordinates, differenced without the variational equations, for
// tests of multipliers.
#pragma once

#include <complex>

#include "analysis/orbit.hpp"
#include "numerics/dense.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/references/sensitivity.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::maps {

using random_scenes::Draw;
using random_scenes::toml;

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

inline std::string harmonic(double amplitude, double period) {
  return fmt::format("[curves.shake]\nshape = \"harmonic\"\namplitude = {:.17g}\nperiod = {:.17g}\n",
                     amplitude, period);
}

/// A disc between two walls of a box that shakes.
inline RandomMap disc_in_shaking_box(Draw& r) {
  const double half = r.between(0.07, 0.09);
  return on_rails(test::body("box", 1, 0.01) +
                      test::body("disc", r.between(0.1, 1), 1e-3, "velocity = [0.3, 0]\n") +
                      test::guide("guide", "ground", "box") + test::guide("rail", "ground", "disc") +
                      toml(R"([contacts.left]
type = 'plane'
between = ['box', 'disc']
at = [[{}, 0], [0, 0]]
axis = [0, -1]
radius = 0.05
surface = 's'
[contacts.right]
type = 'plane'
between = ['box', 'disc']
at = [[{}, 0], [0, 0]]
axis = [0, 1]
radius = 0.05
surface = 's'
[surfaces.s]
restitution = {}
[drives.shaker]
joint = 'guide'
position = 'shake'
)",
                           -half, half, r.between(0.3, 0.7)) +
                      harmonic(r.between(0.01, 0.02), r.between(0.08, 0.2)) + test::run_for(1) + event_driven,
                  {1});
}

/// A pendulum on the pin of a crank of constant speed, with a spring, a damper and a stop.
inline RandomMap pendulum_on_crank(Draw& r) {
  const double arm = r.between(0.03, 0.06), length = r.between(0.15, 0.25);
  const auto pose = [=](const State& s, double angle, double rate) {
    State moved = s;
    const double crank = s.q[2], turn = s.v[2];
    moved.q[3] = arm * std::cos(crank) + length * std::sin(angle);
    moved.q[4] = arm * std::sin(crank) - length * std::cos(angle);
    moved.q[5] = angle;
    moved.v[3] = -arm * turn * std::sin(crank) + length * rate * std::cos(angle);
    moved.v[4] = arm * turn * std::cos(crank) + length * rate * std::sin(angle);
    moved.v[5] = rate;
    return moved;
  };
  return {"gravity = [0, -9.81]\n" + test::body("crank", 1, 0.01) +
              test::body("bar", r.between(0.5, 2), r.between(0.005, 0.02),
                         fmt::format("position = [{}, {}]\n", arm, -length)) +
              test::pin("main", "ground", "crank") +
              test::pin("pivot", "crank", "bar", {arm, 0}, {0, length}) +
              toml(R"([loads.spring]
type = 'torsional-spring-damper'
between = ['ground', 'bar']
stiffness = {}
damping = {}
[contacts.stop]
type = 'plane'
between = ['ground', 'bar']
at = [[{}, 0], [0, {}]]
axis = [0, -1]
radius = 0
surface = 's'
[surfaces.s]
restitution = {}
[drives.motor]
joint = 'main'
speed = {}
)",
                   r.between(0.5, 2), r.between(0.01, 0.05), -r.between(0.01, 0.05), -length,
                   r.between(0.4, 0.8), r.between(6, 12)) +
              test::run_for(1) + event_driven,
          [](const State& s) {
            return std::vector{s.q[5], s.v[5]};
          },
          [=](const State& s, const std::vector<double>& u) { return pose(s, u[0], u[1]); }};
}

/// Two masses with springs and dampers, one driven by a force, the other with a stop.
inline RandomMap two_masses(Draw& r) {
  const auto damper = [&] { return fmt::format("damping = {:.17g}\n", r.between(0.5, 3)); };
  return on_rails(
      test::body("one", r.between(0.3, 1), 0.01) +
          test::body("two", r.between(0.3, 1), 0.01, "position = [1, 0]\n") +
          test::guide("first", "ground", "one") + test::guide("second", "ground", "two") +
          test::spring("base", "ground", "one", {-1, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
          test::spring("link", "one", "two", {0, 0}, {0, 0}, r.between(100, 400), 1, damper()) +
          toml(R"([contacts.stop]
type = 'travel-stop'
joint = 'second'
upper = {}
surface = 's'
[surfaces.s]
restitution = {}
[drives.shaker]
joint = 'first'
force = 'shake'
against = 'time'
)",
               1 + r.between(0.002, 0.01), r.between(0.4, 0.8)) +
          harmonic(r.between(2, 6), r.between(0.2, 0.4)) + test::run_for(1) + event_driven,
      {0, 1});
}

/// A journal that stays in contact with a bearing, which shakes; without friction, with a damper. The
/// contact is closed at the section.
inline RandomMap journal_in_shaken_bearing(Draw& r) {
  const double clearance = r.between(0.01, 0.03);
  const auto pose = [=](const State& s, double angle, double rate) {
    State moved = s;
    moved.q[3] = s.q[0] + clearance * std::sin(angle);
    moved.q[4] = s.q[1] - clearance * std::cos(angle);
    moved.v[3] = s.v[0] + clearance * rate * std::cos(angle);
    moved.v[4] = s.v[1] + clearance * rate * std::sin(angle);
    return moved;
  };
  return {"gravity = [0, -9.81]\n" + test::body("bearing", 1, 0.01) +
              toml(R"([bodies.journal]
mass = {}
point = true
position = [0, {}]
[joints.pin]
type = 'revolute'
between = ['bearing', 'journal']
at = [[0, 0], [0, 0]]
clearance = {}
bearing_radius = 0.05
surface = 's'
[loads.damper]
type = 'spring-damper'
between = ['bearing', 'journal']
at = [[0.5, 0], [0, 0]]
stiffness = {}
damping = {}
free_length = 0.5
[surfaces.s]
restitution = 0.5
[drives.shaker]
joint = 'guide'
position = 'shake'
)",
                   r.between(0.5, 2), -clearance, clearance, r.between(5, 20), r.between(1, 5)) +
              test::guide("guide", "ground", "bearing") +
              harmonic(r.between(2e-4, 1e-3), r.between(0.2, 0.5)) + test::run_for(1) + event_driven,
          [](const State& s) {
            const double x = s.q[3] - s.q[0], y = s.q[4] - s.q[1], u = s.v[3] - s.v[0], w = s.v[4] - s.v[1];
            return std::vector{std::atan2(x, -y), (x * w - y * u) / (x * x + y * y)};
          },
          [=](const State& s, const std::vector<double>& u) { return pose(s, u[0], u[1]); }};
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
