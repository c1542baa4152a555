#include "io/scene/key_rules.hpp"

#include <algorithm>
#include <cmath>

namespace freeplay {
namespace {

/// Index of the first point that does not lie after the one before it; 0 if there is none.
std::size_t first_disorder(const Curve::Points& points) {
  for (std::size_t i = 1; i < points.size(); ++i)
    if (!(points[i].first > points[i - 1].first)) return i;
  return 0;
}

}  // namespace

void KeyRules::bounded(std::string_view key, std::size_t points) const {
  // Keeps a canonical text well below the size limit of a scene.
  constexpr std::size_t most = 100'000;
  if (points > most) fail(key, fmt::format("must have at most {} points, has {}", most, points));
}

void KeyRules::increasing(std::string_view key, const Curve::Points& table) const {
  if (const auto i = first_disorder(table))
    fail(key,
         fmt::format("must increase in its first column; {} follows {}", table[i].first, table[i - 1].first));
}

void KeyRules::sampled(std::string_view key, const Curve::Points& points) const {
  if (points.size() < 2) fail(key, fmt::format("must have at least two points, has {}", points.size()));
  bounded(key, points.size());
  if (const auto i = first_disorder(points))
    fail(key, fmt::format("must increase in x; {:.9g} follows {:.9g}", points[i].first, points[i - 1].first));
}

void KeyRules::wall(std::string_view key, const std::vector<Vec2>& points) const {
  if (points.size() < 2) fail(key, fmt::format("must be at least two points, is {}", points.size()));
  for (std::size_t i = 1; i < points.size(); ++i)
    if (!((points[i] - points[i - 1]).norm() > 0))
      fail(key, fmt::format("points {} and {} are equal and define no wall", i, i + 1));
}

void KeyRules::usable(std::string_view key, int curve, Curve::Use use) const {
  const auto& named = mechanism_.curves[static_cast<std::size_t>(curve)];
  if (const auto why = named.refusal(use); !why.empty())
    fail(key, fmt::format("the curve {} {}", toml_quoted(named.name), why));
}

void KeyRules::differ(const std::array<int, 2>& pair) const {
  if (pair[0] != pair[1]) return;
  if (pair[0] == free_end) fail("between", "one end must be on a body or the ground; both are free");
  fail("between",
       fmt::format("joins \"{}\" to itself",
                   pair[0] == ground ? "ground" : mechanism_.bodies[static_cast<std::size_t>(pair[0])].name));
}

void KeyRules::film(std::string_view key, int lubricant, double clearance,
                    const std::optional<double>& bearing_length) const {
  if (!bearing_length) fail("bearing_length", "is missing: the film force of a lubricant needs it");
  const auto& oil = mechanism_.lubricants[static_cast<std::size_t>(lubricant)];
  if (oil.hand_over && *oil.hand_over >= clearance)
    fail(key, "its hand_over must be less than the clearance of the joint");
}

void KeyRules::moving(std::string_view key, const Joint& joint) const {
  if (!std::holds_alternative<RevoluteJoint>(joint) && !std::holds_alternative<TranslationalJoint>(joint))
    fail(key, fmt::format("must be a revolute or translational joint, {} is a {} joint",
                          toml_quoted(name_of(joint)),
                          std::visit([](const auto& j) { return std::decay_t<decltype(j)>::type; }, joint)));
}

void KeyRules::on_beam(std::string_view key, const Beam& beam, double place) const {
  if (!(place <= beam.length))
    fail(key, fmt::format("must be at most the length of the beam, {:.9g} m", beam.length));
  const int section = static_cast<int>(std::lround(place / beam.piece()));
  if ((section == 0 && beam.is_free(0)) || (section == beam.elements && beam.is_free(1)))
    fail(key, "is at the free end, which has no strain");
}

void KeyRules::grounded(int joint, int of) const {
  for (const auto& [key, index] : {std::pair{"joint", joint}, std::pair{"of", of}}) {
    const auto& on = mechanism_.joints[static_cast<std::size_t>(index)];
    const auto& pair = bodies_of(on);
    const bool slides = std::holds_alternative<TranslationalJoint>(on);
    if (pair[0] == ground || (!slides && pair[1] == ground)) continue;
    fail(key, fmt::format("{} must have the ground as {} body: a ratio with backlash acts between two "
                          "bodies; remove backlash, or use a load of type \"elastic-ratio\"",
                          toml_quoted(name_of(on)), slides ? "its first" : "a"));
  }
  if (RatioJoint::coupled(mechanism_, joint, of)[0] == ground)
    fail("of", "turns the body of the joint that follows; name a joint of another body");
}

void KeyRules::touch(std::string_view key, std::span<const Group> above, std::string_view name,
                     std::vector<int>& list) const {
  const int group = named(key, "group above it called", above, name);
  if (std::ranges::find(list, group) != list.end())
    fail(key, fmt::format("names {} twice", toml_quoted(name)));
  list.push_back(group);
}

JointAngle KeyRules::angle(std::string_view key, const std::string& text) const {
  const auto joint = [&](const std::string& name) { return index_of(mechanism_.joints, name); };
  // Names may contain "-", so try all divisions of the text into three names.
  std::vector<JointAngle> found;
  for (auto a = text.find('-'); a != text.npos; a = text.find('-', a + 1))
    for (auto b = text.find('-', a + 1); b != text.npos; b = text.find('-', b + 1)) {
      const JointAngle angle{
          {joint(text.substr(0, a)), joint(text.substr(a + 1, b - a - 1)), joint(text.substr(b + 1))}};
      const auto [A, B, C] = angle.joints;
      if (A >= 0 && B >= 0 && C >= 0 && A != B && B != C) found.push_back(angle);
    }
  if (found.size() == 1) return found.front();
  std::vector<std::string> names;
  for (const auto& j : mechanism_.joints) names.push_back(name_of(j));
  fail(key, found.empty() ? fmt::format("{} is not an angle A-B-C at joint B between joints A and C{}",
                                        toml_quoted(text), listed("joints are", names))
                          : fmt::format("{} is ambiguous ({} readings); give the joints names without -",
                                        toml_quoted(text), found.size()));
}

}  // namespace freeplay
