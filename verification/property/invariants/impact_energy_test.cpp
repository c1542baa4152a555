// Energy at impacts and in time steps, over random mechanisms and states (a failure prints the
// seed).
#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/impact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

constexpr unsigned seed = 20261121;

/// D = WᵀM⁻¹W of a random impact: rows of `contacts` contacts on a random mechanism of fewer or
/// more degrees of freedom.
Eigen::MatrixXd random_delassus(std::mt19937& engine, int rows, int freedoms) {
  std::normal_distribution<double> normal;
  const Eigen::MatrixXd W = Eigen::MatrixXd::NullaryExpr(rows, freedoms, [&] { return normal(engine); });
  return W * W.transpose();
}

struct Tried {
  int solved = 0, gained = 0;
  double greatest_gain = 0;  // over the greatest possible loss of the impact
};

Tried try_impacts(ImpactLaw law, int most_contacts, bool friction, bool common, int trials) {
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::normal_distribution<double> normal;
  Tried tried;
  for (int trial = 0; trial < trials; ++trial) {
    const int n = 1 + trial % most_contacts, rows = friction ? 2 * n : n;
    const auto D = random_delassus(engine, rows, rows + 2);
    Eigen::VectorXd u(rows);
    for (int i = 0; i < rows; ++i) u[i] = normal(engine);
    for (int i = 0; i < rows; i += friction ? 2 : 1)  // closed contacts approach or rest
      u[i] = uniform(engine) < 0.3 ? 0 : -std::abs(u[i]);
    std::vector<ImpactContact> contacts(n);
    const double e = uniform(engine), mu = uniform(engine);
    for (int i = 0; i < n; ++i) {
      contacts[i].normal = friction ? 2 * i : i;
      contacts[i].tangent = friction ? 2 * i + 1 : -1;
      contacts[i].friction = friction ? mu : 0;
      contacts[i].restitution = common ? e : uniform(engine);
    }
    ImpactProblem impact(law, LcpSolver::automatic, 1e-11);
    if (!impact.solve(D, u, rows, contacts).empty()) continue;
    ++tried.solved;
    // The energy released by a full stop from these velocities: ½ uᵀD⁻¹u.
    const double scale = 0.5 * u.dot(D.ldlt().solve(u));
    const double gain = (impact.normal_work() + impact.tangential_work()) / scale;
    if (gain > 1e-9) {
      ++tried.gained;
      tried.greatest_gain = std::max(tried.greatest_gain, gain);
    }
  }
  return tried;
}

}  // namespace

TEST_CASE("frictionless impacts with one coefficient of restitution never raise the energy, in any law",
          "[invariant][impact]") {
  // Newton: T⁺ − T⁻ = Pᵀ(u⁺ + u⁻)/2 with u⁺ + e u⁻ = s ≥ 0, s ⊥ P: it is −(1 − e)/(1 + e) ½
  // PᵀDP ≤ 0 (Glocker 2001).
  for (const auto law : {ImpactLaw::newton, ImpactLaw::poisson, ImpactLaw::energetic}) {
    const auto tried = try_impacts(law, 4, false, true, 5000);
    CAPTURE(seed, static_cast<int>(law), tried.solved);
    CHECK(tried.gained == 0);
    CHECK(tried.solved > 4900);
  }
}

TEST_CASE("with friction, a single contact gains energy by Newton's law but never by the energetic law",
          "[invariant][impact]") {
  const auto energetic = try_impacts(ImpactLaw::energetic, 1, true, true, 20000);
  CHECK(energetic.solved == 20000);
  CHECK(energetic.gained == 0);
  const auto newton = try_impacts(ImpactLaw::newton, 1, true, true, 20000);
  CAPTURE(newton.gained, newton.greatest_gain);
  CHECK(newton.gained > 0);  // the reason for the energetic law
}

TEST_CASE("no time step raises the energy beyond the bound of the scheme", "[invariant]") {
  // Rings and journals without drive, load or friction, one restitution; free flight is exact.
  // Contacts work Pᵀ(u⁻ + u⁺)/2 in a step, with u⁺ + e u⁻ ⊥ P and, since the normals turn,
  // u⁺ = u⁻ − hγ + DP. Eliminated: (1 − e)/(2(1 + e)) (hγᵀP − PᵀDP), which is at most
  // (1 − e)/(8(1 + e)) h² γᵀD⁻¹γ whatever P is.
  std::mt19937 engine(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int steps = 0, impacts = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const double r = 0.5 + 0.5 * uniform(engine);
    auto text = test::surface("s", r) + test::run_for(1, "start = \"given\"\n");
    const int bodies = 2 + trial % 3;
    for (int b = 0; b < bodies; ++b) {
      const double mass = std::exp(2 * uniform(engine)), inertia = 0.01 * std::exp(2 * uniform(engine)),
                   vx = uniform(engine), vy = uniform(engine), spin = 20 * uniform(engine);
      text += test::body(fmt::format("b{}", b), mass, inertia,
                         fmt::format("velocity = [{}, {}]\nangular_velocity = {}\n", vx, vy, spin));
    }
    // a ring of joints with clearance, each journal off centre but free
    for (int b = 0; b < bodies; ++b)
      text += test::pin(fmt::format("j{}", b), b == 0 ? "ground" : fmt::format("b{}", b - 1),
                        fmt::format("b{}", b), {}, {}, test::loose(1e-3, 2e-2));
    auto scene = parse_scene(text, "ring");
    const double h = trial % 2 ? 1e-4 : 1e-5;
    scene.nonsmooth.step = h;
    const System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, RunOptions::Start::given);
    Simulation simulation(scene, "nonsmooth", {.start = start});
    auto e = system.make_evaluation();
    ContactRow row;
    double before = system.kinetic(start.v.data());
    const double initial = before;
    auto state = start;
    std::vector<double> middle(system.n());
    for (int i = 1; i <= 300; ++i) {
      // The configuration of the scheme, half a step later.
      for (int c = 0; c < system.n(); ++c) middle[c] = state.q[c] + 0.5 * h * state.v[c];
      system.place(state.t, middle.data(), e);
      Eigen::MatrixXd W = Eigen::MatrixXd::Zero(system.n(), system.contacts());
      Eigen::VectorXd gamma = Eigen::VectorXd::Zero(system.contacts());
      for (int k = 0; k < system.contacts(); ++k) {
        system.contact(k, middle.data(), state.v.data(), e, row);
        for (int c = 0; c < row.normal.size; ++c) W(row.normal.column[c], k) = row.normal.value[c];
        gamma[k] = row.gamma_n;
      }
      const Eigen::MatrixXd D =
          W.transpose() *
          Eigen::Map<const Eigen::VectorXd>(system.mass().data(), system.n()).cwiseInverse().asDiagonal() * W;
      const double bound = 1e-13 * initial + (1 - r) / (8 * (1 + r)) * h * h *
                                                 gamma.dot(D.completeOrthogonalDecomposition().solve(gamma));
      REQUIRE(simulation.run({.until = i * h}).ending.status == Ending::Status::finished);
      state = simulation.state();
      const double now = system.kinetic(state.v.data());
      CAPTURE(seed, trial, i, h, before, now);
      REQUIRE(now - before <= bound);
      impacts += now < before * (1 - 1e-9);
      before = now;
      ++steps;
    }
  }
  CHECK(steps == 120000);
  CHECK(impacts > 1000);
}
