#include "dynamics/families.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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

Neighbours::Neighbours(std::span<const ContactFamily> families) : families_(families) {
  std::vector<int> begins;  // first bodies of the ranges; each range is a kind
  least_ = INFINITY;
  const auto enter = [&](const BodyRange& range, double radius) {
    if (range.count == 0 || std::ranges::find(begins, range.first) != begins.end()) return;
    kind_.resize(std::max(kind_.size(), static_cast<std::size_t>(range.first + range.count)), -1);
    for (int body = range.first; body < range.first + range.count; ++body) {
      kind_[static_cast<std::size_t>(body)] = static_cast<int>(begins.size());
      bodies_.push_back(body);
    }
    begins.push_back(range.first);
    least_ = std::min(least_, radius);
    widest_ = std::max(widest_, radius);
  };
  for (const auto& f : families) {
    enter(f.second, f.radius_j);
    enter(f.first, f.radius_i);
  }
  kinds_ = begins.size();
  family_.assign(kinds_ * kinds_, -1);
  for (std::size_t k = 0; k < families.size(); ++k) {
    const auto& f = families[k];
    if (f.of == ContactFamily::Of::wall) continue;
    const auto kind = [&](const BodyRange& r) {
      return static_cast<std::size_t>(kind_[static_cast<std::size_t>(r.first)]);
    };
    const auto a = kind(f.of == ContactFamily::Of::own ? f.second : f.first), b = kind(f.second);
    family_[a * kinds_ + b] = family_[b * kinds_ + a] = static_cast<int>(k);
  }
  at_.resize(2 * bodies_.size());
}

void Neighbours::find(const double* q, double reach) {
  reach_ = reach;
  found_.clear();
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Vec2 p = centre(q, bodies_[k]);
    at_[2 * k] = p.x();
    at_[2 * k + 1] = p.y();
  }
  for (std::size_t k = 0; k < families_.size(); ++k) {
    const auto& f = families_[k];
    if (f.of != ContactFamily::Of::wall) continue;
    for (int j = f.second.first; j < f.second.first + f.second.count; ++j)
      if (f.gap(q, ground, j) < reach) found_.push_back({static_cast<int>(k), ground, j});
  }
  // Distant cells may share a number. This only costs additional distance computations.
  const double width = 2 * widest_ + reach;
  const auto cell = [&](double x) {
    return static_cast<std::int64_t>(std::floor(std::clamp(x / width, -1e9, 1e9)));
  };
  const auto key = [](std::int64_t x, std::int64_t y) {
    return (static_cast<std::uint64_t>(x + (std::int64_t{1} << 31)) << 32) |
           static_cast<std::uint32_t>(y + (std::int64_t{1} << 31));
  };
  cells_.clear();
  for (const int body : bodies_) {
    const Vec2 p = centre(q, body);
    cells_.emplace_back(key(cell(p.x()), cell(p.y())), body);
  }
  std::ranges::sort(cells_);
  const auto look = [&](int a, int b) {
    const int k = family_of(a, b);
    if (k < 0) return;
    const auto& f = families_[static_cast<std::size_t>(k)];
    const bool turned =
        f.of == ContactFamily::Of::own ? a > b : b < f.second.first || b >= f.second.first + f.second.count;
    const int i = turned ? b : a, j = turned ? a : b;
    if (f.gap(q, i, j) < reach) found_.push_back({k, i, j});
  };
  for (std::size_t n = 0; n < cells_.size(); ++n) {
    const auto [own, a] = cells_[n];
    for (std::size_t m = n + 1; m < cells_.size() && cells_[m].first == own; ++m) look(a, cells_[m].second);
    const auto x = static_cast<std::int64_t>(own >> 32) - (std::int64_t{1} << 31),
               y = static_cast<std::int64_t>(own & 0xffffffffu) - (std::int64_t{1} << 31);
    for (const auto& [dx, dy] : {std::pair{0, 1}, {1, -1}, {1, 0}, {1, 1}}) {
      const auto other = key(x + dx, y + dy);
      for (auto c = std::ranges::lower_bound(cells_, std::pair{other, -1});
           c != cells_.end() && c->first == other; ++c)
        look(a, c->second);
    }
  }
  std::ranges::sort(found_);
}

double Neighbours::moved(const double* q, double h, const double* v0, const double* v1) const {
  double most = 0;
  for (std::size_t k = 0; k < bodies_.size(); ++k) {
    const Vec2 p = centre(q, bodies_[k]);
    double d = std::hypot(p.x() - at_[2 * k], p.y() - at_[2 * k + 1]);
    if (h > 0) d += 0.5 * h * (centre(v0, bodies_[k]).norm() + centre(v1, bodies_[k]).norm());
    if (!(d <= most)) most = d;  // also if d is not a number
  }
  return 2 * most;
}

double Neighbours::fastest(const double* v) const {
  double most = 0;
  for (const int body : bodies_) most = std::max(most, centre(v, body).norm());
  return most;
}

double Neighbours::advised(double moved) const {
  return std::max(std::clamp(8 * moved, 0.1 * least_, least_), 2 * moved);
}

}  // namespace freeplay
