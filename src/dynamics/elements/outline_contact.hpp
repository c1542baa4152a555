// Dynamics of mechanism/elements/outline_contact.hpp, which states the outline.
#pragma once

#include <algorithm>
#include <limits>

#include "dynamics/elements/dynamics.hpp"
#include "dynamics/outline_pair.hpp"
#include "mechanism/elements/outline_contact.hpp"

namespace freeplay {

template <>
struct Dynamics<OutlineContact> : OutlineContact {
  void build(auto& b) const {
    auto facts = b.facts(name, between, surface);
    const double both = radius + corner_radius;
    facts.radius = radius * corner_radius / both;  // 0: a point, or a sharp corner
    facts.stiffness = stiffness;
    facts.arm = both;
    facts.clearance = 1e-3 * (facts.radius > 0 ? facts.radius : both);  // scale for tolerances
    const auto link = b.link(between, at);
    const auto corners = centres();
    OutlinePair pair{link, radius, corner_radius};
    double width = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < corners.size(); ++k) {
      OutlinePair::Edge edge{corners[k], along(k)};
      edge.length = (corners[(k + 1) % corners.size()] - edge.from).norm();
      const bool back = corners.size() == 2 && k == 1;
      edge.phase = back ? pair.edges[0].phase : b.phase(OutlinePair::phase(link, edge));
      pair.edges.push_back(edge);
      pair.reach = std::max(pair.reach, edge.from.norm());
      double thick = 0;
      for (const auto& c : corners) thick = std::max(thick, cross(edge.along, c - edge.from));
      width = std::min(width, thick);
      // Corners of a turning body are arms: bounds of motion may not neglect its rotation.
      if (between[0] != ground) b.reach((at[0] + edge.from).norm());
    }
    pair.width = width;
    b.pair(pair, facts);
  }
};

}  // namespace freeplay
