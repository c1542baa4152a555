#include "mechanism/outside.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

std::string loads_of(const Mechanism& mechanism) {
  std::string list;
  for (const auto& load : mechanism.loads)
    if (const auto* force = std::get_if<ForceLoad>(&load)) list += (list.empty() ? "" : ", ") + force->name;
  return list.empty() ? "the scene has none" : "such loads are " + list;
}

}  // namespace

Vec2Of<Traced> OwnForce::at(const std::string& load, const Traced& t, const Vec2Of<Traced>& place,
                            const Vec2Of<Traced>& velocity) const {
  constexpr std::size_t arguments = 5;
  // The arguments, the force, and its derivatives by each argument.
  const auto found = [own = *this, load](const double* in, double* out) {
    std::array<double, arguments> x{};
    std::copy_n(in, arguments, x.begin());
    out = std::ranges::copy(x, out).out;
    const auto put = [&](const Vec2& f) {
      *out++ = f.x();
      *out++ = f.y();
    };
    const auto value = [&] { return own.at(load, x[0], {x[1], x[2]}, {x[3], x[4]}); };
    put(value());
    for (double& y : x) {
      const double here = y, h = 6e-6 * std::fmax(std::abs(here), 1e-3);
      y = here + h;
      const Vec2 above = value();
      y = here - h;
      const Vec2 rise = above - value();
      y = here;
      put({rise.x() / (2 * h), rise.y() / (2 * h)});
    }
  };
  const std::array x{t, place.x(), place.y(), velocity.x(), velocity.y()};
  const auto y =
      call_outside({3 * arguments + 2, found}, x, "a load force is a function outside the program");
  Vec2Of<Traced> f{y[arguments], y[arguments + 1]};
  for (std::size_t i = 0; i < arguments; ++i) {
    const Traced change = x[i] - y[i];
    f.x() += y[arguments + 2 + 2 * i] * change;
    f.y() += y[arguments + 3 + 2 * i] * change;
  }
  return f;
}

void put(Scene& scene, const Outside& outside) {
  auto mechanism = scene.mechanism;
  std::size_t met = 0;
  for (auto& load : mechanism.loads)
    if (auto* force = std::get_if<ForceLoad>(&load)) {
      const auto found = outside.forces.find(force->name);
      force->own = found == outside.forces.end() ? nullptr : found->second;
      met += force->own ? 1 : 0;
    }
  if (met != outside.forces.size())
    for (const auto& [name, force] : outside.forces) {
      const auto named = [&name = name](const Load& load) {
        return std::holds_alternative<ForceLoad>(load) && name_of(load) == name;
      };
      if (std::ranges::none_of(mechanism.loads, named))
        throw SceneError(
            fmt::format("the external force {} needs a load of type \"force\", and {} is not one; {}",
                        force->name, name, loads_of(mechanism)));
    }
  scene.mechanism = std::move(mechanism);
  scene.penalty.own = outside.law;
}

Outside outside_of(const Scene& scene) {
  Outside outside{.law = scene.penalty.own};
  for (const auto& load : scene.mechanism.loads)
    if (const auto* force = std::get_if<ForceLoad>(&load); force && force->own)
      outside.forces[force->name] = force->own;
  return outside;
}

}  // namespace freeplay
