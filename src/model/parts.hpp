// The parts that a System is made of: constraint rows and contact pairs, each kind a file of rows/ and pairs/ and
// listed here once, and the drives and loads of a Mechanism with what stepping adds to them.
#pragma once

#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "model/elements.hpp"
#include "model/pairs/angle_stop.hpp"
#include "model/pairs/cam_flat.hpp"
#include "model/pairs/cam_roller.hpp"
#include "model/pairs/flank.hpp"
#include "model/pairs/line.hpp"
#include "model/pairs/round.hpp"
#include "model/rows/angle.hpp"
#include "model/rows/distance.hpp"
#include "model/rows/mesh.hpp"
#include "model/rows/motion.hpp"
#include "model/rows/point.hpp"
#include "model/rows/slide.hpp"
#include "model/rows/sliding.hpp"
#include "model/rows/spin.hpp"

namespace freeplay {

using ConstraintRows =
    std::tuple<std::vector<PointRows>, std::vector<SlideRow>, std::vector<AngleRow>, std::vector<SpeedRow>,
               std::vector<MotionRow>, std::vector<MeshRow<InvoluteMesh>>, std::vector<MeshRow<RackMesh>>,
               std::vector<DistanceRow>>;
using Pair = std::variant<RoundPair, LinePair, CamFlatPair, CamRollerPair, FlankPair<InvoluteMesh>,
                          FlankPair<RackMesh>, AngleStopPair>;
using FrictionRow = std::variant<SlidingRow, SpinRow>;

/// A drive or load in place.
template <class Facts>
struct Placed {
  Facts facts;
  Link link;
  int element = -1;  ///< in System::force_elements()
  int state = -1;    ///< first-order state, −1: none
  int phase = -1;    ///< index of its angle in System::phases, −1: none
};

template <class... Lists>
struct PlacedKinds;
template <class... D, class... L>
struct PlacedKinds<std::variant<D...>, std::variant<L...>> {
  using type = std::tuple<std::vector<Placed<D>>..., std::vector<Placed<L>>...>;
};
using PlacedElements = PlacedKinds<Drive, Load>::type;

/// Whether a kind of drive or load applies a force by itself (the others add rows).
template <class Facts>
concept Acts = requires(const Facts& f) {
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

/// What an element makes the solver carry.
struct Carried {
  std::string name;
  std::string_view kind;  ///< its word in a scene
  int rows = 0, contacts = 0, frictions = 0, states = 0;
  bool force = false;  ///< a term of the right-hand side
  int families = 0;    ///< of contacts that are found as they come near
};

}  // namespace freeplay
