// Contact problems in islands against the dense problem of the same rows: D entry by entry, and the
// velocities, which are unique where D is positive definite and friction small (as are the
// impulses).
#include "formulations/contact/contact_islands.hpp"

#include <catch2/catch.hpp>

#include <Eigen/LU>
#include <random>

#include "verification/support/random_contact.hpp"

using namespace freeplay;

namespace {

/// `bodies` in a row, some of them joined to the next by two constraint rows, and a contact of each
/// body with the next; in `rows` groups side by side that no row connects.
struct Row {
  std::vector<double> mass, G_values;
  CsrPattern G;
  std::vector<SparseRow> rows;
  ContactProblem whole;
  std::vector<int> place, id;

  Row(test::Random& u, int groups, int bodies, bool joints, bool friction) {
    G.columns = 3 * groups * bodies;
    for (int i = 0; i < G.columns; ++i) mass.push_back(std::exp(u(-1, 1)));
    const auto touch = [&](int a, int b) {
      SparseRow row;
      for (const int body : {a, b})
        for (int k = 0; k < 3 && body >= 0; ++k) row.push(3 * body + k, u());
      return row;
    };
    whole.reserve_rates(2 * groups * bodies);
    for (int g = 0; g < groups; ++g)
      for (int i = 0; i < bodies; ++i) {
        const int body = g * bodies + i, next = i + 1 < bodies ? body + 1 : -1;
        if (joints && next >= 0 && i % 3 == 0)
          for (int k = 0; k < 2; ++k) {
            const auto row = touch(body, next);
            for (int e = 0; e < row.size; ++e) {
              G.column.push_back(row.column[e]);
              G_values.push_back(row.value[e]);
            }
            G.end_row();
          }
        ContactUnknown c;
        c.normal = whole.rows++;
        c.target_n = std::max(0.0, u());
        rows.push_back(touch(body, next));
        if (friction) {
          c.tangent = whole.rows++;
          c.friction = 0.02;
          rows.push_back(touch(body, next));
        }
        whole.unknowns.push_back(c);
        id.push_back(body);
      }
    for (int r = 0; r < whole.rows; ++r) {
      place.push_back(r);
      whole.b[r] = u();
    }
  }
};

}  // namespace

TEST_CASE("contact problems split into islands have the velocities of the whole problem",
          "[contact-problem][islands]") {
  test::Random u;
  for (int trial = 0; trial < 60; ++trial) {
    const int groups = 1 + trial % 4, bodies = 2 + trial % 29;
    const bool joints = trial % 2 == 1, friction = trial % 3 != 0;
    Row p(u, groups, bodies, joints, friction);
    CAPTURE(trial, groups, bodies, joints, friction);
    SaddlePoint saddle(p.mass, p.G);
    REQUIRE(saddle.factor(p.G_values.data()));
    const int rows = p.whole.rows, n = p.G.columns;
    Responses responses(rows);
    responses.use(saddle);
    std::vector<std::vector<double>> whole_response;
    ContactProblem dense(LcpSolver::newton);
    dense.reserve(rows);
    dense.rows = rows;
    dense.unknowns = p.whole.unknowns;
    for (int r = 0; r < rows; ++r) {
      responses.take(r, p.rows[r]);
      std::vector<double> a(n), lambda(p.G.rows), sparse(n);
      saddle.respond(p.rows[r], nullptr, 0, a.data(), lambda.data());
      responses.add(r, 1, sparse.data());
      REQUIRE(sparse == a);
      whole_response.push_back(a);
      dense.b[r] = p.whole.b[r];
    }
    for (int r = 0; r < rows; ++r)
      for (int s = 0; s < rows; ++s)
        dense.D(r, s) = p.rows[std::max(r, s)].dot(whole_response[std::min(r, s)].data());

    ContactIslands islands(saddle, n, LcpSolver::automatic, 1e-11);
    const auto solution = islands.solve(p.whole, p.place, p.id, p.rows, responses);
    REQUIRE(solution.solved);
    CHECK(islands.count() >= groups);
    dense.set_least_scale(0);
    REQUIRE(dense.solve().solved);
    const double scale = dense.scale();
    for (int r = 0; r < rows; ++r) {
      for (int s = 0; s < rows; ++s) {
        INFO("D " << r << " " << s);
        CHECK(islands.D(r, s) == dense.D(r, s));
      }
      CHECK(islands.rate(r) == Approx(dense.rate(r)).margin(1e-7 * scale));
    }
    // The contact laws, with the dense matrix.
    dense.unknowns = p.whole.unknowns;
    CHECK(dense.residual() <= 1e-9 * scale);
  }
}

TEST_CASE("an island without a new contact keeps its impulses", "[contact-problem][islands]") {
  test::Random u;
  Row p(u, 3, 5, false, true);
  SaddlePoint saddle(p.mass, p.G);
  REQUIRE(saddle.factor(p.G_values.data()));
  Responses responses(p.whole.rows);
  responses.use(saddle);
  for (int r = 0; r < p.whole.rows; ++r) responses.take(r, p.rows[r]);
  ContactIslands islands(saddle, p.G.columns, LcpSolver::automatic, 1e-11);
  auto first = p.whole;
  REQUIRE(islands.solve(first, p.place, p.id, p.rows, responses).pivots > 0);
  auto again = p.whole;
  CHECK(islands.solve(again, p.place, p.id, p.rows, responses).pivots == 0);
  for (std::size_t i = 0; i < first.unknowns.size(); ++i) {
    CHECK(again.unknowns[i].impulse_n == first.unknowns[i].impulse_n);
    CHECK(again.unknowns[i].impulse_t == first.unknowns[i].impulse_t);
  }
  // The last contact of each group is new: all three are solved again, with the result of a single
  // solve.
  auto less = p.whole;
  std::vector<int> id, place;
  std::erase_if(less.unknowns, [&](const ContactUnknown& c) { return (&c - less.unknowns.data()) % 5 == 4; });
  for (std::size_t i = 0; i < p.id.size(); ++i)
    if (i % 5 != 4) id.push_back(p.id[i]);
  islands.clear();
  REQUIRE(islands.solve(less, p.place, id, p.rows, responses).solved);
  auto more = p.whole;
  REQUIRE(islands.solve(more, p.place, p.id, p.rows, responses).pivots > 0);
  for (std::size_t i = 0; i < first.unknowns.size(); ++i)
    CHECK(more.unknowns[i].impulse_n == Approx(first.unknowns[i].impulse_n).margin(1e-9));
}

TEST_CASE("sparse factorisation against a dense factorisation", "[contact-problem][islands]") {
  test::Random u;
  SparseLu lu;
  for (const int n : {1, 2, 7, 40})
    for (const int w : {0, 1, 3, 6}) {
      if (w >= n) continue;
      Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
      std::vector<int> begin{0}, column;
      std::vector<double> values;
      for (int i = 0; i < n; ++i) {
        for (int j = std::max(0, i - w); j <= std::min(n - 1, i + w); ++j) {
          values.push_back(A(i, j) = u());
          column.push_back(j);
        }
        begin.push_back(static_cast<int>(column.size()));
      }
      Eigen::VectorXd x(n);
      for (int i = 0; i < n; ++i) x[i] = u();
      const Eigen::VectorXd expected = A.fullPivLu().solve(x);
      const auto solution = [&](SparseLu& by, std::vector<double> of) {
        auto rows = begin, columns = column;
        by.analyse(rows, columns);
        by.values() = std::move(of);
        REQUIRE(by.factor(1e-12));
        Eigen::VectorXd y = x;
        by.solve(y.data());
        return y;
      };
      CHECK((solution(lu, values) - expected).norm() <= 1e-9 * (1 + expected.norm()));
      // Whatever values were factorised before, the digits are the same.
      auto dominant = values;
      for (int i = 0; i < n; ++i)
        for (int e = begin[i]; e < begin[i + 1]; ++e)
          if (column[e] == i) dominant[e] += 20;
      for (const auto& of : {dominant, values, dominant}) {
        SparseLu fresh;
        CHECK(solution(lu, of) == solution(fresh, of));
      }
    }
}
