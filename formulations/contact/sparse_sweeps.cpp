#include "formulations/contact/sparse_sweeps.hpp"

#include "formulations/contact/sweeps.hpp"

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

}  // namespace freeplay
