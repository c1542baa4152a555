#include "analysis/reduced_modes.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"

namespace freeplay {
namespace {

std::vector<Mode> oscillations(const System& system, const State& at) {
  double left = 0;
  auto modes = find_modes(system, as_it_stands(system, at, {}, left), {}).modes;
  std::erase_if(modes, [](const Mode& m) { return m.kind != Mode::Kind::swing; });
  return modes;
}

}  // namespace

std::vector<ReducedFrequency> reduced_frequencies(const Mechanism& mechanism, const State& at) {
  const System reduced(mechanism), full(with_full_beams(mechanism));
  const auto all = oscillations(full, at);
  const auto product = [&](const Mode& a, const Mode& b) {
    std::complex<double> sum = 0;
    for (std::size_t c = 0; c < a.shape.size(); ++c)
      sum += full.mass()[c] * std::conj(a.shape[c]) * b.shape[c];
    return std::norm(sum);
  };
  std::vector<ReducedFrequency> list;
  if (all.empty()) return list;
  for (const auto& mode : oscillations(reduced, at)) {
    const auto nearest = std::ranges::max_element(
        all, {}, [&](const Mode& other) { return product(mode, other) / std::sqrt(product(other, other)); });
    list.push_back({mode.natural(), nearest->natural()});
  }
  return list;
}

}  // namespace freeplay
