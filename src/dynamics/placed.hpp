// Drives and loads of a System with their links and indices. Only the sources of System include
// this file, so that a change of an element's dynamics recompiles these alone.
#pragma once

#include <tuple>
#include <variant>
#include <vector>

#include "dynamics/elements.hpp"
#include "dynamics/system.hpp"

namespace freeplay {

/// A drive or load with its place in the System.
template <class Facts>
struct Placed {
  Dynamics<Facts> facts;
  Link link;
  int element = -1;  ///< index in System::force_elements()
  int state = -1;    ///< index of its (first) first-order state; −1: none
  int phase = -1;    ///< index of its phase in System::phases; −1: none
};

template <class... Lists>
struct PlacedKinds;
template <class... D, class... L>
struct PlacedKinds<std::variant<D...>, std::variant<L...>> {
  using type = std::tuple<std::vector<Placed<D>>..., std::vector<Placed<L>>...>;
};
struct PlacedElements {
  PlacedKinds<Drive, Load>::type lists;
};

/// Whether a kind of drive or load applies a force by itself; the others add rows.
template <class Facts>
concept Acts = requires(const Dynamics<Facts>& f) {
  f.does_work();
};

/// Calls f with every item of every vector in a tuple of vectors.
template <class... Items, class F>
[[gnu::always_inline]] inline void for_each_item(const std::tuple<std::vector<Items>...>& lists, F f) {
  const auto over = [&f]<class Item>(const std::vector<Item>& list) __attribute__((always_inline)) {
    for (const auto& item : list) f(item);
  };
  (over(std::get<std::vector<Items>>(lists)), ...);
}

}  // namespace freeplay
