// Every contact solver against every other, on random problems with a unique solution: D of random
// mechanisms is a Gram matrix WᵀAW, and friction so small that D_NN > μ Σ|D_·T| keeps the
// frictional map a P-map. Frictionless problems against a convex quadratic program solved by Ipopt.
#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>

#include "dynamics/system.hpp"
#include "numerics/saddle_point.hpp"
#include "verification/support/random_contact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::Random;
using test::random_problem;
using test::solve_by;

namespace {

/// min ½ PᵀDP + (b − target)ᵀP, P ≥ 0: its optimality conditions are the frictionless contact
/// problem.
class QuadraticProgram : public Ipopt::TNLP {
 public:
  using Index = Ipopt::Index;
  using Number = Ipopt::Number;
  explicit QuadraticProgram(const ContactProblem& p)
      : D(p.D.topLeftCorner(p.rows, p.rows)), c(p.rows), x(p.rows) {
    for (const auto& u : p.unknowns) c[u.normal] = p.b[u.normal] - u.target_n;
  }
  bool get_nlp_info(Index& n, Index& m, Index& j, Index& h, IndexStyleEnum& style) override {
    n = static_cast<Index>(c.size());
    m = j = 0;
    h = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Index n, Number* lo, Number* hi, Index, Number*, Number*) override {
    std::fill(lo, lo + n, 0.0);
    std::fill(hi, hi + n, 1e19);
    return true;
  }
  bool get_starting_point(Index n, bool, Number* y, bool, Number*, Number*, Index, bool, Number*) override {
    std::fill(y, y + n, 1.0);
    return true;
  }
  bool eval_f(Index n, const Number* y, bool, Number& f) override {
    const Eigen::Map<const Eigen::VectorXd> P(y, n);
    f = 0.5 * P.dot(D * P) + c.dot(P);
    return true;
  }
  bool eval_grad_f(Index n, const Number* y, bool, Number* g) override {
    const Eigen::Map<const Eigen::VectorXd> P(y, n);
    Eigen::Map<Eigen::VectorXd>(g, n) = D * P + c;
    return true;
  }
  bool eval_g(Index, const Number*, bool, Index, Number*) override { return true; }
  bool eval_jac_g(Index, const Number*, bool, Index, Index, Index*, Index*, Number*) override { return true; }
  bool eval_h(Index n, const Number*, bool, Number factor, Index, const Number*, bool, Index, Index* row,
              Index* column, Number* value) override {
    for (Index i = 0, k = 0; i < n; ++i)
      for (Index j = 0; j <= i; ++j, ++k)
        if (value)
          value[k] = factor * D(i, j);
        else {
          row[k] = i;
          column[k] = j;
        }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn, Index n, const Number* y, const Number*, const Number*, Index,
                         const Number*, const Number*, Number, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    x = Eigen::Map<const Eigen::VectorXd>(y, n);
  }
  Eigen::MatrixXd D;
  Eigen::VectorXd c, x;
};

Eigen::VectorXd by_ipopt(const ContactProblem& p) {
  Ipopt::SmartPtr<QuadraticProgram> program = new QuadraticProgram(p);
  Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  ipopt->Options()->SetNumericValue("tol", 1e-12);
  REQUIRE(ipopt->Initialize("") == Ipopt::Solve_Succeeded);
  REQUIRE(ipopt->OptimizeTNLP(GetRawPtr(program)) == Ipopt::Solve_Succeeded);
  return program->x;
}

}  // namespace

TEST_CASE("all contact solvers find the same impulses without a fallback", "[contact-problem]") {
  Random u;
  for (int trial = 0; trial < 3000; ++trial) {
    const int contacts = 1 + trial % 4;
    auto p = random_problem(u, contacts, true);
    auto reference = p;
    const auto by_lemke = solve_by(LcpSolver::lemke, reference);
    REQUIRE(by_lemke.solved);
    REQUIRE(by_lemke.retries == 0);
    for (const auto solver :
         {LcpSolver::automatic, LcpSolver::enumeration, LcpSolver::gauss_seidel, LcpSolver::newton}) {
      auto q = p;
      const auto result = solve_by(solver, q);
      CAPTURE(trial, contacts, static_cast<int>(solver), result.residual);
      REQUIRE(result.solved);
      // Newton's method has no guarantee of convergence; the others must converge alone.
      if (solver != LcpSolver::newton) REQUIRE(result.retries == 0);
      for (std::size_t i = 0; i < q.unknowns.size(); ++i) {
        REQUIRE(q.unknowns[i].impulse_n == Approx(reference.unknowns[i].impulse_n).margin(1e-8));
        REQUIRE(q.unknowns[i].impulse_t == Approx(reference.unknowns[i].impulse_t).margin(1e-8));
      }
    }
  }
}

TEST_CASE("Newton's method alone solves nearly every problem", "[contact-problem]") {
  Random u;
  int alone = 0;
  for (int trial = 0; trial < 1000; ++trial) {
    auto p = random_problem(u, 3, true);
    alone += solve_by(LcpSolver::newton, p).retries == 0;
  }
  CHECK(alone > 950);
}

TEST_CASE("frictionless problems against a quadratic program solved by Ipopt", "[contact-problem]") {
  Random u;
  for (int trial = 0; trial < 60; ++trial) {
    auto p = random_problem(u, 1 + trial % 8, false);
    const Eigen::VectorXd expected = by_ipopt(p);
    REQUIRE(p.solve().solved);
    // An interior point stays √tol away from the bounds of degenerate unknowns; 1e-6 is far above
    // it.
    for (const auto& c : p.unknowns) CHECK(c.impulse_n == Approx(expected[c.normal]).margin(1e-6));
  }
}

TEST_CASE("frictionless problems from simulation steps against Ipopt", "[contact-problem]") {
  // Velocities and Delassus matrices of a row of eight four-bars in motion, of all contacts with a
  // gap below three tenths of the clearance.
  auto scene = test::row_of_four_bars(8, 1e-3);
  scene.mechanism.surfaces[0].friction.reset();
  const System system(scene.mechanism);
  Simulation simulation(scene, "nonsmooth");
  SaddlePoint saddle(system.mass(), system.pattern());
  auto e = system.make_evaluation();
  std::vector<double> lambda(system.rows()), a(system.n());
  int tried = 0, pressed = 0;
  for (int i = 1; i <= 400; ++i) {
    REQUIRE(simulation.run({.until = i * 1e-3}).ending.status == Ending::Status::finished);
    const auto state = simulation.state();
    system.place(state.t, state.q.data(), e);
    REQUIRE(saddle.factor(e.G.data()));
    std::vector<SparseRow> rows;
    ContactProblem p;
    p.reserve(8);
    for (int k = 0; k < system.contacts(); ++k) {
      ContactRow row;
      system.contact(k, state.q.data(), state.v.data(), e, row);
      if (row.gap > 3e-4) continue;
      ContactUnknown c;
      c.normal = p.rows;
      // As if a step of 1 ms of gravity were added: a journal on its wall is loaded.
      p.b[p.rows++] = row.normal.dot(state.v.data()) - 1e-3 * 9.81 * row.normal.value[1];
      rows.push_back(row.normal);
      p.unknowns.push_back(c);
    }
    if (p.rows < 2) continue;
    for (int r = 0; r < p.rows; ++r) {
      saddle.respond(rows[r], nullptr, 0, a.data(), lambda.data());
      for (int s = 0; s < p.rows; ++s) p.D(s, r) = rows[s].dot(a.data());
    }
    const Eigen::VectorXd expected = by_ipopt(p);
    REQUIRE(p.solve().solved);
    for (const auto& c : p.unknowns) {
      CHECK(c.impulse_n == Approx(expected[c.normal]).margin(1e-6));
      pressed += c.impulse_n > 1e-6;
    }
    ++tried;
  }
  CHECK(tried > 50);
  CHECK(pressed > 50);
}

TEST_CASE("a solver that fails is replaced by the next, and the retry is counted", "[contact-problem]") {
  // A chain of 100 contacts, D the second difference: Gauss–Seidel converges like (1 − π²/n²) a
  // sweep and would need some 20,000 sweeps; its limit is 2,000.
  ContactProblem p(LcpSolver::gauss_seidel);
  const int n = 100;
  p.reserve(n);
  p.rows = n;
  for (int i = 0; i < n; ++i) {
    p.D(i, i) = 2;
    if (i > 0) p.D(i, i - 1) = p.D(i - 1, i) = -1;
    p.b[i] = -1;
    ContactUnknown c;
    c.normal = i;
    p.unknowns.push_back(c);
  }
  const auto result = p.solve();
  CHECK(result.solved);
  CHECK(result.retries == 1);
  // D P = 1: P_i = i (n + 1 − i)/2.
  for (int i = 0; i < n; ++i) CHECK(p.unknowns[i].impulse_n == Approx(0.5 * (i + 1) * (n - i)));
}

TEST_CASE("Painlevé's configuration is reported, and collinear contacts are solved", "[contact-problem]") {
  // Painlevé: D_NN = 1, D_NT = 2, μ = 1, approaching and sliding to the right. The closed form
  // tries separation, stick and slip without success; P_N = −b/(D_NN − μ D_NT) < 0.
  ContactProblem p;
  p.reserve(2);
  p.rows = 2;
  p.D << 1, 2, 2, 5;
  p.b << -1, 10;
  ContactUnknown c;
  c.normal = 0;
  c.tangent = 1;
  c.friction = 0.9;
  p.unknowns.push_back(c);
  const auto result = p.solve();
  // Jamming: stick needs |P_T| ≤ μ P_N. u = 0: P = −D⁻¹b = (25, −12), within the cone. Open has
  // u_N = −1, slip to the right P_N = 1/(1 − 1.8) < 0, slip to the left P_N = 1/2.8 and u_T > 0:
  // stick is the only motion, and no other is reported.
  CHECK(result.solved);
  CHECK_FALSE(result.ambiguous);
  REQUIRE(p.modes(9).decided);
  CHECK(p.modes(9).motions.size() == 1);
  CHECK(p.unknowns[0].impulse_n == Approx(25));
  CHECK(p.unknowns[0].impulse_t == Approx(-12));

  ContactProblem q(LcpSolver::gauss_seidel);
  q.reserve(2);
  q.rows = 2;
  q.D << 1, 1, 1, 1;  // two collinear contacts with different required opening velocities: Gauss–Seidel
                      // converges slowly
  q.b << -1, -1;
  for (int i : {0, 1}) {
    ContactUnknown x;
    x.normal = i;
    x.target_n = i;
    q.unknowns.push_back(x);
  }
  const auto tie = q.solve();
  CHECK(tie.solved);
  CHECK(q.unknowns[1].impulse_n == Approx(2));
  CHECK(q.unknowns[0].impulse_n == Approx(0).margin(1e-10));
}
