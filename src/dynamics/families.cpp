#include "dynamics/families.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "mechanism/mechanism.hpp"

namespace freeplay {

std::vector<ContactFamily> families_of(const Mechanism& mechanism, const Group& group, double longest_arm) {
  std::vector<ContactFamily> list;
  const BodyRange own{group.first, group.size()};
  const auto surface = [&](int index) { return mechanism.surfaces[static_cast<std::size_t>(index)]; };
  const auto discs = [&](ContactFamily::Of of, const std::string& name, const BodyRange& first,
                         double radius) {
    ContactFamily f;
    f.of = of;
    f.name = name;
    f.first = first;
    f.second = own;
    f.radius_i = radius;
    f.radius_j = group.radius;
    f.facts.surface = surface(group.surface);
    f.facts.radius = radius * group.radius / (radius + group.radius);
    f.facts.clearance = 1e-3 * f.facts.radius;  // scale for tolerances
    list.push_back(std::move(f));
  };
  if (group.size() > 1 && !group.alone) discs(ContactFamily::Of::own, group.name, own, group.radius);
  for (const int g : group.touches) {
    const auto& other = mechanism.groups[static_cast<std::size_t>(g)];
    discs(ContactFamily::Of::others, fmt::format("{}-{}", other.name, group.name),
          {other.first, other.size()}, other.radius);
  }
  for (int w = 0; w < group.wall_count(); ++w) {
    const auto from = group.walls[static_cast<std::size_t>(w)],
               to = group.walls[static_cast<std::size_t>(w) + 1];
    ContactFamily f;
    f.of = ContactFamily::Of::wall;
    f.name = fmt::format("{}-wall{}", group.name, w + 1);
    f.second = own;
    f.radius_j = group.radius;
    f.at = from;
    f.axis = (to - from).direction();
    f.facts.surface = surface(group.wall_surface.value_or(group.surface));
    f.facts.radius = group.radius;
    f.facts.arm = longest_arm;
    f.facts.clearance = 1e-3 * std::max(group.radius, longest_arm);  // scale for tolerances
    list.push_back(std::move(f));
  }
  for (auto& f : list) f.facts.name = f.name;
  return list;
}

bool found_near(const Group& group, const std::vector<ContactFamily>& families) {
  if (group.pairs) return *group.pairs == Group::Pairs::near;
  long pairs = 0;
  for (const auto& f : families) pairs += f.pairs();
  return pairs > Group::most_listed;
}

}  // namespace freeplay
