// Gauss–Seidel with a dense D (gauss_seidel.hpp), alone or in turn with Newton's method (newton.cpp).

#include "formulations/contact/gauss_seidel.hpp"

namespace freeplay {

SolverSummary sparse_sweeps(SparseIsland& x, double accepted, std::vector<double>& rates, int most) {
  rates.resize(x.slots.size());
  for (std::size_t r = 0; r < rates.size(); ++r) rates[r] = x.rate(static_cast<int>(r));
  struct ByRows {
    SparseIsland& x;
    std::vector<double>& u;
    std::vector<ContactUnknown>& unknowns;
    double entry(int r, int s) const { return x.entry(r, s); }
    double impulse(int r, double) const { return x.impulse[r]; }
    double rate(int r) const { return u[r]; }
    double residual() const { return x.residual(); }
    void change(int r, double by) {  // D is symmetric
      x.impulse[r] += by;
      for (int e = x.begin[r]; e < x.begin[r + 1]; ++e) u[x.column[e]] += by * x.value[e];
    }
  } by_rows{x, rates, x.unknowns};
  return sweep_contacts(by_rows, accepted, most);
}

SolverSummary sweeps(ContactEquations& p, double accepted, SolverRoom& room, int most) {
  auto& u = room.rates;
  u.conservativeResize(std::max<Eigen::Index>(u.size(), p.rows));
  for (const auto& c : p.unknowns)
    for (const int row : {c.normal, c.tangent})
      if (row >= 0) u[row] = p.rate(row);
  struct Dense {
    ContactEquations& p;
    Eigen::VectorXd& u;
    std::vector<ContactUnknown>& unknowns;
    double entry(int r, int s) const { return p.D(r, s); }
    double impulse(int, double own) const { return own; }
    double rate(int r) const { return u[r]; }
    double residual() const { return p.residual(); }
    void change(int r, double by) { u.head(p.rows) += by * p.D.col(r).head(p.rows); }
  } dense{p, u, p.unknowns};
  return sweep_contacts(dense, accepted, most);
}

SolverSummary gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  return sweeps(p, accepted, room, 2000);
}

/// Newton's method and Gauss–Seidel in turn. Newton's method starts from the impulses of the last
/// problem: if no contact has changed its mode, one or two steps solve the problem. Otherwise 100
/// sweeps provide a new initial guess, from which Newton's method needs few steps, whereas sweeps
/// converge slowly if many contacts share a load. If this fails, up to 2000 sweeps follow.
SolverSummary mixed_gauss_seidel(ContactEquations& p, double accepted, SolverRoom& room) {
  auto sum = newton_from_last(p, accepted, room);
  const auto add = [&](const SolverSummary& one) {
    sum.solved = one.solved;
    sum.iterations += one.iterations;
  };
  if (!sum.solved) add(sweeps(p, accepted, room, 100));
  if (!sum.solved) add(newton_from(From::given, p, accepted));
  if (!sum.solved) add(sweeps(p, accepted, room, 2000));
  return sum;
}

}  // namespace freeplay
