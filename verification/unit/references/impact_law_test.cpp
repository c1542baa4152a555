// Impact laws against results derived by hand or by an independent program: three balls in a row,
// Kane and Levinson's pendulum, and the single impact with slip, stick and slip reversal.
#include <Eigen/Eigenvalues>

#include "formulations/contact/impact.hpp"
#include "formulations/contact/impact_island.hpp"
#include "verification/references/impact_tables.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("Newton's cradle: velocities after a simultaneous impact by each impact law", "[impact]") {
  // Unit masses, D = [2, −1; −1, 2]. The first ball at 1 m/s, the others in contact at rest (first
  // block of rows): by all laws the last two move off together, and none reproduces the cradle.
  // With the third ball at −0.5 m/s and different restitutions the laws differ. Worked in
  // fractions.
  struct Row {
    ImpactLaw law;
    double e12, e23, u3, after[3];
  };
  const double s = 0.57868932583326;
  const Row rows[] = {{ImpactLaw::newton, 1, 1, 0, {-1.0 / 3, 2.0 / 3, 2.0 / 3}},
                      {ImpactLaw::poisson, 1, 1, 0, {-1.0 / 3, 2.0 / 3, 2.0 / 3}},
                      {ImpactLaw::energetic, 1, 1, 0, {-1.0 / 3, 2.0 / 3, 2.0 / 3}},
                      {ImpactLaw::newton, 0.5, 0.5, 0, {0, 0.5, 0.5}},
                      {ImpactLaw::poisson, 0.5, 0.5, 0, {0, 0.5, 0.5}},
                      {ImpactLaw::energetic, 0.5, 0.5, 0, {0, 0.5, 0.5}},
                      {ImpactLaw::newton, 0, 1, 0, {1.0 / 3, 1.0 / 3, 1.0 / 3}},
                      {ImpactLaw::poisson, 0, 1, 0, {1.0 / 6, 1.0 / 6, 2.0 / 3}},
                      {ImpactLaw::newton, 1, 0, -0.5, {-0.5, 0.5, 0.5}},
                      {ImpactLaw::poisson, 1, 0, -0.5, {-2.0 / 3, 7.0 / 12, 7.0 / 12}},
                      {ImpactLaw::energetic, 1, 0, -0.5, {-s, 0.5 * (0.5 + s), 0.5 * (0.5 + s)}}};
  for (const auto& row : rows) {
    ImpactProblem impact(row.law, LcpSolver::automatic, 1e-12);
    Eigen::MatrixXd D(2, 2);
    D << 2, -1, -1, 2;
    const double u[3] = {1, 0, row.u3};
    Eigen::VectorXd rates(2);
    rates << u[1] - u[0], u[2] - u[1];
    std::vector<ImpactContact> contacts(2);
    contacts[0].normal = 0;
    contacts[0].restitution = row.e12;
    contacts[1].normal = 1;
    contacts[1].restitution = row.e23;
    CAPTURE(static_cast<int>(row.law), row.e12, row.e23, row.u3);
    REQUIRE(impact.solve(D, rates, 2, contacts).empty());
    const double P = contacts[0].impulse_n, Q = contacts[1].impulse_n;
    CHECK(u[0] - P == Approx(row.after[0]).margin(1e-10));
    CHECK(u[1] + P - Q == Approx(row.after[1]).margin(1e-10));
    CHECK(u[2] + Q == Approx(row.after[2]).margin(1e-10));
  }
}

TEST_CASE("Kane and Levinson's pendulum: a run by Newton's impact law reports the gain of energy",
          "[impact][event-driven]") {
  // The change of energy by each law is a claim of "impact-laws".
  auto scene = read_scene(test::scene_file("kane_levinson"));
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.run.duration = 1e-6;
  for (const auto& row : reference::kane_levinson)
    for (const auto law : {ImpactLaw::newton, ImpactLaw::poisson, ImpactLaw::energetic}) {
      scene.mechanism.surfaces[0].restitution = row.e;
      scene.nonsmooth.impact_law = law;
      const auto run = test::simulate(scene, Family::nonsmooth);
      CAPTURE(static_cast<int>(law), row.e);
      CHECK(run.extremes.gains == (law == ImpactLaw::newton ? 1 : 0));
      CHECK((test::count(test::notes_of(run), "increased the energy") > 0) == (law == ImpactLaw::newton));
    }
  // Time stepping uses Newton's law, and reports the gain as well.
  scene = read_scene(test::scene_file("kane_levinson"));
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  const auto run = test::simulate(scene, Family::nonsmooth);
  CHECK(run.extremes.gains == 1);
  CHECK(run.extremes.greatest_gain == Approx(run.ledger.kinetic - run.ledger.initial).epsilon(1e-6));
}

TEST_CASE("single impacts by three impact laws agree with an independent program", "[impact]") {
  REQUIRE(reference::single_impacts.size() > 8);
  for (const auto& row : reference::single_impacts) {
    const std::pair<ImpactLaw, const double*> laws[] = {{ImpactLaw::newton, row.newton},
                                                        {ImpactLaw::poisson, row.poisson},
                                                        {ImpactLaw::energetic, row.energetic}};
    for (const auto& [law, expected] : laws) {
      ImpactProblem impact(law, LcpSolver::automatic, 1e-12);
      Eigen::MatrixXd D(2, 2);
      D << row.D_nn, row.D_nt, row.D_nt, row.D_tt;
      Eigen::VectorXd rates(2);
      rates << row.v_n_minus, row.v_t_minus;
      std::vector<ImpactContact> contacts(1);
      contacts[0].normal = 0;
      contacts[0].tangent = 1;
      contacts[0].friction = row.mu;
      contacts[0].restitution = row.e;
      CAPTURE(static_cast<int>(law), row.mu, row.e, row.v_t_minus, row.v_n_minus, row.D_nt);
      REQUIRE(impact.solve(D, rates, 2, contacts).empty());
      CHECK(contacts[0].impulse_n == Approx(expected[0]).epsilon(1e-10));
      CHECK(contacts[0].impulse_t == Approx(expected[1]).margin(1e-10 * expected[0]).epsilon(0));
    }
  }
}

TEST_CASE("a single impact agrees with its integration over the normal impulse", "[impact]") {
  // D = [1, d; d, t]: slip to the end (μ small), stick once slip has stopped, reversal where
  // |d| > μ t.
  const double e = 0.6, u_n = -1;
  struct Row {
    double d, t, u_t, mu;
  };
  for (const auto law : {ImpactLaw::poisson, ImpactLaw::energetic})
    for (const auto& row : {Row{0.2, 1.5, 1.0, 0.1}, Row{0.2, 1.5, 0.05, 0.4}, Row{-0.9, 2.0, 0.3, 0.2},
                            Row{0.9, 2.0, -0.3, 0.2}, Row{0.5, 1.0, 0.0, 0.8}, Row{0.9, 1.0, 2.0, 0.9}}) {
      const auto impact = routh_impact(law, 1, row.d, row.t, u_n, row.u_t, row.mu, e);
      // The same by small steps of the normal impulse, with the friction determined in each step.
      double n = u_n, s = row.u_t, p = 0, q = 0, work = 0, rubbed = 0, compressed = 0, pressed = 0;
      const double dP = 1e-6;
      while (n < 0 || (law == ImpactLaw::poisson ? p < pressed * (1 + e) : work < compressed * (1 - e * e))) {
        double c = s > 1e-9    ? -row.mu
                   : s < -1e-9 ? row.mu
                               : std::clamp(-(row.d + s / dP) / row.t, -row.mu, row.mu);
        const double before = n, slid = s;
        n += dP * (1 * 1 + c * row.d);
        s += dP * (row.d + c * row.t);
        p += dP;
        q += c * dP;
        work += 0.5 * (before + n) * dP;
        rubbed += 0.5 * (slid + s) * c * dP;
        if (n <= 0) compressed = work, pressed = p;
      }
      CAPTURE(static_cast<int>(law), row.d, row.t, row.u_t, row.mu);
      REQUIRE(impact.ended);
      CHECK(impact.impulse_n == Approx(p).epsilon(1e-5));
      CHECK(impact.impulse_t == Approx(q).margin(1e-5 * p));
      CHECK(impact.normal_work == Approx(work).epsilon(1e-5));
      CHECK(impact.tangential_work == Approx(rubbed).margin(1e-5 * -work));
    }
}

TEST_CASE("the energetic law gives each of several contacts its work whenever restitution ratios exist",
          "[impact]") {
  // Without friction they always exist: z_i (D z)_i = e_i² P_i |u_i|, P = −D⁻¹u the compression
  // impulse, has one solution z > 0 (the minimum of ½ zᵀD z − Σ e_i² P_i |u_i| ln z_i), and P + z
  // is the impulse. The coupling in D is negative here: contacts push each other apart, and
  // compression loads all.
  std::mt19937_64 engine(7);
  const auto uniform = [&](double low, double high) {
    return std::uniform_real_distribution(low, high)(engine);
  };
  int tried = 0;
  while (tried < 300) {
    const int n = 2 + tried % 3;
    Eigen::MatrixXd A(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) A(i, j) = uniform(-1, 1);
    Eigen::MatrixXd D = A * A.transpose() + 0.05 * Eigen::MatrixXd::Identity(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        if (i != j) D(i, j) = -std::abs(D(i, j));
    if (D.eigenvalues().real().minCoeff() < 1e-3) continue;
    Eigen::VectorXd P(n);
    for (auto& p : P) p = uniform(0.1, 2);
    const Eigen::VectorXd u = -D * P;
    if (u.maxCoeff() > -1e-3) continue;  // all approach
    ++tried;
    std::vector<ImpactContact> contacts(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i) {
      contacts[static_cast<std::size_t>(i)].normal = i;
      contacts[static_cast<std::size_t>(i)].restitution = uniform(0.05, 1);
    }
    ImpactProblem impact(ImpactLaw::energetic, LcpSolver::automatic, 1e-12);
    CAPTURE(tried, D, u);
    REQUIRE(impact.solve(D, u, n, contacts).empty());
    CHECK_FALSE(impact.wedged());
    Eigen::VectorXd z(n);
    for (int i = 0; i < n; ++i) z[i] = contacts[static_cast<std::size_t>(i)].impulse_n - P[i];
    const Eigen::VectorXd off = D * z;
    for (int i = 0; i < n; ++i) {
      const double e = contacts[static_cast<std::size_t>(i)].restitution;
      CHECK(z[i] * off[i] == Approx(e * e * P[i] * -u[i]).epsilon(1e-9));
    }
  }
}
