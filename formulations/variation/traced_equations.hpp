// TracedEquations: the traced equations of a System and of the keys of runs with derivatives
// (dynamics/system_tangent.hpp). They are formed at the first run and kept for later ones with the same keys:
// a return map has many runs of one System, whose trace costs as much as some hundred evaluations.
//
// The owner also owns the System and the displaced systems of the keys, which must live as long.
#pragma once

#include <algorithm>
#include <memory>
#include <utility>
#include <vector>

#include "dynamics/system_tangent.hpp"
#include "formulations/variation/sensitivity.hpp"

namespace freeplay {

class TracedEquations {
 public:
  /// Traced near a state unless they are known. Null without keys.
  std::shared_ptr<SystemTangent> of(const System& system, const std::vector<VariedKey>& keys,
                                    const State& near, SystemTangent::Use use) {
    if (keys.empty()) return nullptr;
    std::vector<SystemTangent::Parameter> parameters;
    for (const auto& key : keys) parameters.push_back({key.systems, key.spacing});
    const auto same = [](const auto& a, const auto& b) {
      return a.systems == b.systems && (!a.systems[0] || a.spacing == b.spacing);
    };
    const auto known = std::ranges::find_if(
        list_, [&](const auto& one) { return std::ranges::equal(one.parameters, parameters, same); });
    if (known != list_.end()) return known->equations;
    auto traced = std::make_shared<SystemTangent>(system, use, parameters);
    traced->prepare(near);
    list_.push_back({std::move(parameters), std::move(traced)});
    return list_.back().equations;
  }

 private:
  struct Entry {
    std::vector<SystemTangent::Parameter> parameters;
    std::shared_ptr<SystemTangent> equations;
  };
  std::vector<Entry> list_;
};

}  // namespace freeplay
