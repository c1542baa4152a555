// Each contact solver alone, by the interface that all share. On random problems with one solution,
// every solver that reports success returns the same impulses. The residual is the same for dense
// problems and for D stored by rows.
#include <catch2/catch.hpp>

#include "formulations/contact/gauss_seidel.hpp"
#include "formulations/contact/island_groups.hpp"
#include "formulations/contact/newton.hpp"
#include "verification/support/random_contact.hpp"

using namespace freeplay;

namespace {

/// The same problem with D by rows.
SparseIsland island_of(const ContactEquations& p) {
  SparseIsland x;
  x.unknowns = p.unknowns;
  x.begin.push_back(0);
  for (int r = 0; r < p.rows; ++r) {
    x.slots.push_back(r);
    x.b.push_back(p.b[r]);
    for (int s = 0; s < p.rows; ++s) {
      x.column.push_back(s);
      x.value.push_back(p.D(r, s));
    }
    x.begin.push_back(static_cast<int>(x.column.size()));
  }
  x.gather();
  return x;
}

}  // namespace

TEST_CASE("every solver returns the unique solution of a contact problem", "[contact]") {
  for (int seed = 0; seed < 40; ++seed) {
    test::Random u{std::mt19937(static_cast<unsigned>(seed))};
    const ContactEquations problem = test::random_problem(u, 1 + seed % 5, true);
    const double accepted = 1e-11 * problem.scale();
    SolverRoom room;
    ContactEquations reference = problem;
    REQUIRE(lemke(reference, accepted, room).solved);
    REQUIRE(reference.residual() <= 1e-10 * problem.scale());
    std::vector<Solver*> solvers{enumeration,  copositive_lemke,   newton,
                                 gauss_seidel, mixed_gauss_seidel, proximal};
    if (problem.unknowns.size() == 1) solvers.push_back(closed_form);
    for (const auto solver : solvers) {
      ContactEquations p = problem;
      const auto found = solver(p, accepted, room);
      REQUIRE(found.solved);
      CHECK(p.residual() <= 1e-10 * problem.scale());
      for (std::size_t i = 0; i < p.unknowns.size(); ++i) {
        CHECK(p.unknowns[i].impulse_n == Approx(reference.unknowns[i].impulse_n).margin(1e-8));
        CHECK(p.unknowns[i].impulse_t == Approx(reference.unknowns[i].impulse_t).margin(1e-8));
      }
    }
  }
}

TEST_CASE("a solver reports its failure, and Newton steps from the last impulses leave them unchanged",
          "[contact]") {
  test::Random u{std::mt19937(7)};
  ContactEquations p = test::random_problem(u, 5, true);
  SolverRoom room;
  // No impulses: no starting point.
  CHECK_FALSE(newton_from_last(p, 1e-11, room).solved);
  for (auto& c : p.unknowns) c.impulse_n = c.normal >= 0 ? 1e9 : 0;
  const auto given = p.unknowns;
  const auto found = newton_from_last(p, 0, room);  // no residual is accepted
  CHECK_FALSE(found.solved);
  CHECK(found.iterations > 0);
  for (std::size_t i = 0; i < given.size(); ++i) CHECK(p.unknowns[i].impulse_n == given[i].impulse_n);
  CHECK_FALSE(sweeps(p, 0, room, 3).solved);
  // A lever on a stop whose friction prevents sliding towards it: its two rows have one degree of
  // freedom, and D_NN < μ D_NT.
  ContactUnknown lever{.normal = 0, .tangent = 1, .friction = 2};
  CHECK_FALSE(solve_one(lever, -1, 1, 1, 1, 1));
  CHECK(solve_one(lever, -1, -1, 1, 1, 1));
  CHECK(solve_one(lever, -1, 1, 1, 0.1, 1));
}

TEST_CASE("an island stored by rows has the residual and the solution of the dense problem", "[contact]") {
  for (int seed = 0; seed < 20; ++seed) {
    test::Random u{std::mt19937(static_cast<unsigned>(100 + seed))};
    ContactEquations p = test::random_problem(u, 3 + seed % 6, true);
    for (auto& c : p.unknowns) {
      c.impulse_n = c.normal >= 0 ? std::max(0.0, u()) : 0;
      c.impulse_t = c.tangent >= 0 ? u() : 0;
    }
    auto x = island_of(p);
    CHECK(x.residual() == p.residual());
    CHECK(x.attainable() == Approx(p.attainable()));
    const double accepted = 1e-11 * p.scale();
    SolverRoom room;
    REQUIRE(lemke(p, accepted, room).solved);
    Eigen::VectorXd rates(p.rows);
    SparseNewton newton;
    auto swept = x;
    REQUIRE(newton.solve(x, accepted, 100).solved);
    REQUIRE(sweep_contacts(swept, accepted, rates, 5000).solved);
    for (auto* island : {&x, &swept}) {
      island->scatter();
      for (std::size_t i = 0; i < p.unknowns.size(); ++i) {
        CHECK(island->unknowns[i].impulse_n == Approx(p.unknowns[i].impulse_n).margin(1e-8));
        CHECK(island->unknowns[i].impulse_t == Approx(p.unknowns[i].impulse_t).margin(1e-8));
      }
    }
  }
}
