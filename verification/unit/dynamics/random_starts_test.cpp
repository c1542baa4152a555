// Starts of random mechanisms (random_bars.hpp) whose scenes state some of their initial values
// (stated.hpp). Poses follow from closed forms, rates from the null space of rows that are derived
// there.
#include "dynamics/assembly/assembly.hpp"
#include "verification/support/rig.hpp"
#include "verification/unit/dynamics/random_bars.hpp"

using namespace freeplay;
using namespace freeplay::test::bars;

namespace {

/// The state of a start in the order of the bars.
struct Start {
  VectorXd q, v;
  std::string assumed, refused;
};
Start start_of(const Made& m, const std::string& text) {
  Start s{VectorXd(3 * static_cast<Eigen::Index>(m.bars.size())), {}, {}, {}};
  s.v = s.q;
  const auto scene = parse_scene(text, "random.toml");
  try {
    const auto state = assemble(scene.mechanism, scene.run.start, &s.assumed);
    for (std::size_t b = 0; b < m.bars.size(); ++b) {
      const auto at = std::ranges::find(scene.mechanism.bodies, m.bars[b].name, &Body::name) -
                      scene.mechanism.bodies.begin();
      for (int c = 0; c < 3; ++c) {
        const auto to = 3 * static_cast<Eigen::Index>(b) + c;
        s.q[to] = state.q[static_cast<std::size_t>(3 * at + c)];
        s.v[to] = state.v[static_cast<std::size_t>(3 * at + c)];
      }
    }
  } catch (const ModelError& e) {
    s.refused = e.what();
  }
  return s;
}

/// The least mass-weighted velocities of the absent coordinates, by a dense decomposition.
VectorXd completed(const MatrixXd& G, const VectorXd& mass, const VectorXd& v,
                   const std::vector<bool>& held) {
  VectorXd all = VectorXd::Zero(v.size());
  MatrixXd free = G;
  for (Eigen::Index c = 0; c < v.size(); ++c) {
    if (held[static_cast<std::size_t>(c)]) {
      all[c] = v[c];
      free.col(c).setZero();
    } else {
      free.col(c) /= std::sqrt(mass[c]);
    }
  }
  VectorXd wanted = -(G * all);
  for (Eigen::Index k = 0; k < free.rows(); ++k) {
    const double size = free.row(k).norm();
    free.row(k) /= size > 0 ? size : 1;
    wanted[k] /= size > 0 ? size : 1;
  }
  Eigen::CompleteOrthogonalDecomposition<MatrixXd> decomposition;
  decomposition.setThreshold(1e-9);
  decomposition.compute(free);
  const VectorXd x = decomposition.solve(wanted);
  for (Eigen::Index c = 0; c < v.size(); ++c)
    if (!held[static_cast<std::size_t>(c)]) all[c] = x[c] / std::sqrt(mass[c]);
  return all;
}

struct Failures {
  int silent = 0, refused = 0;
  std::string first;
  void add(bool is_refusal, const std::string& what, const std::string& text) {
    ++(is_refusal ? refused : silent);
    if (first.empty()) first = what + "\n" + text;
  }
};

/// A random mechanism with the rows of its joints, and velocities that they allow.
struct Moving {
  Made made;
  VectorXd q, v;
  MatrixXd G;
  double speed = 0;  ///< m/s, the greatest

  Moving(Maker& maker, Random& r) : made(maker.make()), q(made.pose()), v(VectorXd::Zero(q.size())) {
    VectorXd phi;
    made.rows(q, phi, G);
    REQUIRE(phi.cwiseAbs().maxCoeff() < 1e-13 * std::max(1.0, made.length));
    const MatrixXd kernel = Eigen::FullPivLU<MatrixXd>(G).kernel();
    for (Eigen::Index k = 0; k < kernel.cols(); ++k)
      v += r.between(-3, 3) / kernel.col(k).norm() * kernel.col(k);
    for (Eigen::Index i = 0; i < v.size(); i += 3)
      speed = std::max({speed, std::hypot(v[i], v[i + 1]), made.length * std::abs(v[i + 2])});
  }
};

}  // namespace

TEST_CASE("random starts keep stated values and complete absent ones", "[assembly]") {
  constexpr std::uint64_t seed = 11;
  Random r(seed);
  Maker maker(r);
  Failures failures;
  for (int n = 0; n < 60; ++n) {
    const Moving drawn(maker, r);
    const auto& [m, q, v, at_pose, speed] = drawn;
    VectorXd phi;
    MatrixXd G;
    // Every value, or angles only, or each with probability one half.
    const int mode = n % 3;
    Stated stated(m.bars.size());
    for (auto& s : stated)
      for (std::size_t i = 0; i < 4; ++i)
        s[i] = mode == 0 ? i == 1 || (i > 1 && r.below(2) == 1) : mode == 2 || r.below(2) == 1;
    const char* const runs[] = {"", "start = \"assembled\"\n", "start = \"ideal\"\n", "start = \"given\"\n"};
    const std::string run = runs[r.below(mode == 0 ? 3 : 4)];
    const auto where = fmt::format("{} of seed {}: {}, mode {}", n, seed, m.kind, mode);
    // Velocities belong to this pose only if the stated positions determine it.
    auto positions = stated;
    for (auto& s : positions) s[2] = s[3] = false;
    auto text = text_of(m, q, v, positions, r, run);
    const auto pose = start_of(m, text);
    const auto refusal = [&](const Start& s) {
      if (!s.refused.empty()) failures.add(true, where + ": " + s.refused, text);
      return !s.refused.empty();
    };
    if (refusal(pose)) continue;
    m.rows(pose.q, phi, G);
    double moved = 0, change = 0;
    for (Eigen::Index c = 0; c < q.size(); ++c) {
      const double amount = std::abs(pose.q[c] - q[c]) / (c % 3 == 2 ? 1 : m.length);
      moved = std::max(moved, amount);
      if (positions[static_cast<std::size_t>(c / 3)][c % 3 == 2 ? 1 : 0]) change = std::max(change, amount);
    }
    // Where values are absent, the first guess may not close; the note names the one that does.
    const auto silent = [&](const Start& t) {
      return t.assumed.empty() || (mode == 1 && t.assumed.find("initial guess") != std::string::npos);
    };
    if (!silent(pose) || change > 1e-9 || phi.cwiseAbs().maxCoeff() > 1e-12 * std::max(1.0, m.length))
      failures.add(false,
                   fmt::format("{}: stated pose changed by {:.2g}, open by {:.2g} {}", where, change,
                               phi.cwiseAbs().maxCoeff(), pose.assumed),
                   text);
    if (mode != 1 && moved > 1e-8)
      failures.add(false, fmt::format("{}: another pose, by {:.2g}", where, moved), text);
    if (moved > 1e-9) continue;
    text = text_of(m, q, v, stated, r, run);
    const auto start = start_of(m, text);
    if (refusal(start)) continue;
    std::vector<bool> held;
    for (const auto& s : stated) held.insert(held.end(), {s[2], s[2], s[3]});
    const VectorXd expected = completed(at_pose, m.masses(), v, held);
    double worst = 0;
    for (Eigen::Index c = 0; c < q.size(); ++c)
      worst = std::max(worst, std::abs(start.v[c] - expected[c]) * (c % 3 == 2 ? m.length : 1) / speed);
    if (!silent(start) || !(worst < 1e-7))
      failures.add(false,
                   fmt::format("{}: rates differ by {:.2g} of the speed {}", where, worst, start.assumed),
                   text);
  }
  INFO(failures.first);
  CHECK(failures.silent == 0);
  CHECK(failures.refused == 0);
}

TEST_CASE("random contradictory starts are refused or reported", "[assembly]") {
  constexpr std::uint64_t seed = 12;
  Random r(seed);
  Maker maker(r);
  Failures failures;
  for (int n = 0; n < 60; ++n) {
    Moving drawn(maker, r);
    auto& [m, q, v, G, speed] = drawn;
    const bool rate = n % 2 == 1;
    const double size = n % 3 == 0 ? 1e-13 : n % 3 == 1 ? 1e-6 : 0.2;
    const auto c = r.below(static_cast<int>(q.size()));
    if (rate)
      v[c] += 2 * size * speed / (c % 3 == 2 ? m.length : 1);
    else
      q[c] += 2 * size * (c % 3 == 2 ? 1 : m.length);
    const Stated stated(m.bars.size(), std::array<bool, 4>{true, true, rate, rate});
    const auto text = text_of(m, q, v, stated, r, n % 5 == 0 ? "start = \"ideal\"\n" : "");
    const auto start = start_of(m, text);
    const auto where = fmt::format("{} of seed {}: {}, {} changed by {:.1g}", n, seed, m.kind, c, size);
    const bool small = size<1e-12, large = size> 1e-2;
    if (large && start.refused.find("joints.j") == std::string::npos)
      failures.add(false, where + ": not refused: " + start.refused + start.assumed, text);
    if (large && start.refused.find("bodies.b") == std::string::npos)
      failures.add(false, where + ": no value named: " + start.refused, text);
    if (!large && !start.refused.empty()) failures.add(true, where + ": " + start.refused, text);
    if (!large && start.refused.empty() && small != start.assumed.empty())
      failures.add(false, where + ": note: " + start.assumed, text);
  }
  INFO(failures.first);
  CHECK(failures.silent == 0);
  CHECK(failures.refused == 0);
}
