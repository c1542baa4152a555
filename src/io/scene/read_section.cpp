#include "io/scene/read_section.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "dynamics/phase.hpp"
#include "io/files/escaping.hpp"
#include "io/scene/quantity.hpp"
#include "io/scene/schema.hpp"
#include "mechanism/error.hpp"
#include "mechanism/piecewise.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

using Kind = StateColumn::Kind;

constexpr const char* forms =
    "\"every period\", \"every 0.1 s\", \"JOINT.angle crosses 30 deg upwards\" or \"each touch of CONTACT\"";

[[noreturn]] void refuse(const std::string& key, const std::string& why) { throw ModelError(key, why); }

std::vector<std::string> words_of(std::string_view text) {
  std::istringstream in{std::string(text)};
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

std::string joined(const std::vector<std::string>& words, std::size_t from, std::size_t to) {
  std::string text;
  for (std::size_t i = from; i < to; ++i) text += (i > from ? " " : "") + words[i];
  return text;
}

/// Reads "0.1 s", "30 deg", or a number in SI units.
double quantity(const std::string& text, const char* unit, const std::string& key) {
  const auto read = read_quantity(text, unit);
  if (!read.wrong.empty()) {
    char* end = nullptr;
    const double x = std::strtod(text.c_str(), &end);
    if (!text.empty() && *end == 0 && std::isfinite(x)) return x;
    refuse(key, read.wrong);
  }
  return read.value;
}

/// Whether a revolute joint of that name has clearance.
bool loose_pin(const Scene& scene, const std::string& name) {
  return std::ranges::any_of(scene.mechanism.joints, [&](const Joint& joint) {
    const auto* pin = std::get_if<RevoluteJoint>(&joint);
    return pin && pin->clearance && pin->name == name;
  });
}

const NamedColumn* find(const std::vector<NamedColumn>& list, std::string_view name) {
  const auto it = std::ranges::find(list, name, &NamedColumn::name);
  return it == list.end() ? nullptr : &*it;
}

/// Suggestions for an unknown column, for messages.
std::string like(std::string_view word, const std::vector<NamedColumn>& list) {
  std::vector<std::string> names;
  for (const auto& c : list) names.push_back(c.name);
  const auto near = nearest_word(word, names);
  if (!near.empty()) return fmt::format("did you mean {}?", near);
  if (names.size() > 12) names.resize(12);
  return fmt::format("there are {}{}", fmt::join(names, ", "), list.size() > names.size() ? ", ..." : "");
}

SectionRule read_touch(const std::vector<std::string>& words, const Layout& layout, const std::string& key) {
  SectionRule rule{.kind = SectionRule::Kind::touch};
  if (layout.contacts.empty()) refuse(key, "the scene has no contacts");
  if (words.size() == 2) return rule;
  if (words.size() != 4 || words[2] != "of")
    refuse(key, fmt::format("\"{}\" is not a section; sections are {}",
                            visible(joined(words, 0, words.size())), forms));
  for (std::size_t k = 0; k < layout.contacts.size(); ++k)
    if (layout.contacts[k] == words[3]) rule.contacts.push_back(static_cast<int>(k));
  if (rule.contacts.empty())
    refuse(key, fmt::format("\"{}\" has no contacts; those with contacts are {}", visible(words[3]),
                            fmt::join(layout.contacts, ", ")));
  return rule;
}

SectionRule read_crossing(const std::vector<std::string>& words, const Scene& scene, const Layout& layout,
                          const std::string& key) {
  SectionRule rule{.kind = SectionRule::Kind::crossing};
  auto list = coordinate_columns(scene, layout.bodies);
  std::erase_if(list, [](const NamedColumn& c) { return c.column.kind != Kind::coordinate; });
  const auto* found = find(list, words[0]);
  if (!found)
    refuse(key, fmt::format("\"{}\" is not a coordinate of a section; {}", visible(words[0]),
                            like(words[0], list)));
  rule.what = found->column;
  auto end = words.size();
  constexpr std::pair<const char*, SectionRule::Direction> directions[] = {
      {"upwards", SectionRule::Direction::upwards},
      {"downwards", SectionRule::Direction::downwards},
      {"either", SectionRule::Direction::either}};
  for (const auto& [word, direction] : directions)
    if (words.back() == word) {
      rule.direction = direction;
      --end;
    }
  if (end < 3)
    refuse(key, fmt::format("{} needs a value, for example: {} crosses 0 upwards", words[0], words[0]));
  rule.value = quantity(joined(words, 2, end), found->unit == "m" ? "m" : "rad", key);
  return rule;
}

SectionRule read_period(const std::vector<std::string>& words, std::optional<double> known,
                        const std::string& key) {
  SectionRule rule{.kind = SectionRule::Kind::period};
  const auto from = std::ranges::find(words, "from");
  const auto end = static_cast<std::size_t>(from - words.begin());
  if (end == 2 && words[1] == "period") {
    if (!known)
      refuse(key,
             "\"every period\": the drives of the scene define no period, or several; give it, such as "
             "\"every 0.1 s\"");
    rule.period = *known;
  } else {
    rule.period = quantity(joined(words, 1, end), "s", key);
    if (!(rule.period > 0))
      refuse(key, fmt::format("the period must be greater than 0 s, is {} s", rule.period));
  }
  if (from != words.end()) rule.from = quantity(joined(words, end + 1, words.size()), "s", key);
  return rule;
}

}  // namespace

std::vector<NamedColumn> coordinate_columns(const Scene& scene, const std::vector<std::string>& bodies) {
  std::vector<NamedColumn> list;
  struct Part {
    const char *place, *rate;
    const char *unit, *rate_unit;
    bool angle;
  };
  constexpr Part parts[] = {{"x", "vx", "m", "m/s", false},
                            {"y", "vy", "m", "m/s", false},
                            {"theta", "omega", "rad", "rad/s", true}};
  for (std::size_t b = 0; b < bodies.size(); ++b)
    for (std::size_t i = 0; i < 3; ++i) {
      const int at = static_cast<int>(3 * b + i);
      list.push_back(
          {bodies[b] + "." + parts[i].place, parts[i].unit, {Kind::coordinate, at, -1, parts[i].angle}});
      list.push_back({bodies[b] + "." + parts[i].rate, parts[i].rate_unit, {Kind::rate, at, -1, false}});
    }
  for (const auto& joint : scene.mechanism.joints) {
    const std::string& name = name_of(joint);
    if (const auto* slide = std::get_if<TranslationalJoint>(&joint)) {
      Phase travel{.link = {slide->between[0], slide->between[1], slide->at[0], slide->at[1]}};
      travel.of = Phase::Of::travel;
      travel.axis = slide->axis;
      const auto along = std::make_shared<const Phase>(travel);
      list.push_back({name + ".position", "m", {.kind = Kind::coordinate, .travel = along}});
      list.push_back({name + ".rate", "m/s", {.kind = Kind::rate, .travel = along}});
    }
    if (!std::holds_alternative<RevoluteJoint>(joint)) continue;
    const auto between = bodies_of(joint);
    const auto angle = [&](int body) { return body == ground ? -1 : 3 * body + 2; };
    list.push_back({name + ".angle", "rad", {Kind::coordinate, angle(between[1]), angle(between[0]), true}});
    list.push_back({name + ".rate", "rad/s", {Kind::rate, angle(between[1]), angle(between[0]), false}});
  }
  return list;
}

std::optional<double> drive_period(const Scene& scene) {
  const auto& m = scene.mechanism;
  if (const auto* drive = main_drive(m); drive && drive->speed != 0)
    return 2 * std::numbers::pi / std::abs(drive->speed);
  std::optional<double> period;
  for (const auto& curve : m.curves) {
    const double own = curve.shape == Curve::Shape::harmonic ? curve.period
                       : curve.repeats                       ? curve.lay().period()
                                                             : 0;
    if (!(own > 0)) continue;
    if (period && std::abs(own - *period) > 1e-12 * own) return std::nullopt;
    period = own;
  }
  return period;
}

SectionRule read_section(std::string_view text, const Scene& scene, const Layout& layout,
                         const std::string& key, std::optional<double> period) {
  const auto words = words_of(text);
  if (!period) period = drive_period(scene);
  const auto rule = [&] {
    if (words.size() >= 2 && words[0] == "every") return read_period(words, period, key);
    if (words.size() >= 2 && words[0] == "each" && words[1] == "touch") return read_touch(words, layout, key);
    if (words.size() >= 2 && words[1] == "crosses") return read_crossing(words, scene, layout, key);
    refuse(key, fmt::format("\"{}\" is not a section; sections are {}", visible(text), forms));
  };
  auto made = rule();
  // The period from which phases are computed.
  if (made.kind != SectionRule::Kind::period && period) made.period = *period;
  return made;
}

std::vector<NamedColumn> all_columns(const Scene& scene, const Layout& layout, const SectionRule& rule) {
  auto list = coordinate_columns(scene, layout.bodies);
  std::vector<std::string> names;
  for (std::size_t k = 0; k < layout.contacts.size(); ++k) {
    auto name = layout.contacts[k];
    const auto same = std::ranges::count(layout.contacts, name);
    // Contacts of one translational joint with clearance have the same name.
    if (same > 1) name += fmt::format(".{}", std::ranges::count(names, layout.contacts[k]) + 1);
    names.push_back(layout.contacts[k]);
    const int at = static_cast<int>(k);
    list.push_back({name + ".ex", "m", {Kind::ex, at}});
    list.push_back({name + ".ey", "m", {Kind::ey, at}});
    list.push_back({name + ".gap", "m", {Kind::gap, at}});
    if (loose_pin(scene, layout.contacts[k])) {
      list.push_back({name + ".ex_c", "", {Kind::ex_c, at}});
      list.push_back({name + ".ey_c", "", {Kind::ey_c, at}});
    }
  }
  if (rule.period > 0) list.push_back({"phase", "", {Kind::phase}});
  if (rule.kind == SectionRule::Kind::touch) list.push_back({"approach", "m/s", {Kind::approach}});
  return list;
}

NamedColumn read_column(std::string_view text, const Scene& scene, const Layout& layout,
                        const SectionRule& rule, const std::string& key) {
  const auto list = all_columns(scene, layout, rule);
  const auto* found = find(list, text);
  if (found) return *found;
  if (text == "phase") refuse(key, "\"phase\": the drives of the scene define no period, or several");
  if (text == "approach")
    refuse(key, "\"approach\": exists only for sections \"each touch\" (contact onset)");
  refuse(key, fmt::format("\"{}\" is not a column of the section; {}", visible(text), like(text, list)));
}

std::vector<std::string> shown_columns(const Scene& scene, const Layout& layout, const SectionRule& rule) {
  const auto& m = scene.mechanism;
  for (const auto& name : layout.contacts)
    if (loose_pin(scene, name)) return {name + ".ex_c", name + ".ey_c"};
  if (rule.kind == SectionRule::Kind::touch)
    return {rule.period > 0 ? "phase" : layout.bodies.back() + ".x", "approach"};
  for (auto i = m.joints.size(); i-- > 0;) {
    if (!std::holds_alternative<RevoluteJoint>(m.joints[i])) continue;
    const auto drives = [&](const Drive& d) {
      const auto prescribes = [&](const auto& x) {
        using X = std::decay_t<decltype(x)>;
        return (std::is_same_v<X, SpeedDrive> || std::is_same_v<X, MotionDrive>)&&x.joint ==
               static_cast<int>(i);
      };
      return std::visit(prescribes, d);
    };
    if (std::ranges::none_of(m.drives, drives))
      return {name_of(m.joints[i]) + ".angle", name_of(m.joints[i]) + ".rate"};
  }
  return {layout.bodies.back() + ".y", layout.bodies.back() + ".vy"};
}

}  // namespace freeplay
