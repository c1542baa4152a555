// KeyRules: the rules of a scene's keys that concern several numbers or other elements. The reader of
// files (KeysReader) and the check of scenes in code (check_scene.cpp) derive from it, and differ in
// how an error is thrown.
//
// A KeyRules refers to the mechanism as read so far; it does not own it.
#pragma once

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "io/scene/spelling.hpp"
#include "io/scene/toml_text.hpp"
#include "mechanism/keys.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {

/// Message about a scene without bodies.
inline constexpr const char* no_bodies =
    "the scene needs at least one body: [bodies.NAME] with mass and inertia";

class KeyRules {
 protected:
  explicit KeyRules(const Mechanism& mechanism) : mechanism_(mechanism) {}
  ~KeyRules() = default;

  /// Throws the error about a key; "" for the table.
  virtual void refuse(std::string_view key, const std::string& message) const = 0;
  [[noreturn]] void fail(std::string_view key, const std::string& message) const {
    refuse(key, message);
    std::abort();  // compilers do not rely on overriding functions that never return
  }

  /// Index of the element with this name, or −1.
  template <class List>
  static int index_of(const List& list, std::string_view name) {
    int i = 0;
    for (const auto& item : list) {
      if (name_of_item(item) == name) return i;
      ++i;
    }
    return -1;
  }
  /// The same; refuses an unknown name. `what` describes the elements, `names` are further names for
  /// the message.
  template <class List>
  int named(std::string_view key, std::string_view what, const List& list, std::string_view name,
            std::vector<std::string> names = {}) const {
    const int i = index_of(list, name);
    if (i >= 0) return i;
    for (const auto& item : list) names.push_back(name_of_item(item));
    fail(key, fmt::format("there is no {} {}{}", what, toml_quoted(name),
                          meant(name, names, "there is:", Beside::list)));
  }
  /// Message about two keys for one fact.
  static std::string exactly_one(const Key& a, const Key& b) {
    return fmt::format("needs exactly one of {} and {}", a.name, b.name);
  }

  /// Limits the number of points of a list.
  void bounded(std::string_view key, std::size_t points) const;
  /// The first column of a table increases.
  void increasing(std::string_view key, const Curve::Points& table) const;
  /// Points of a curve.
  void sampled(std::string_view key, const Curve::Points& points) const;
  /// Successive points of walls differ.
  void wall(std::string_view key, const std::vector<Vec2>& points) const;
  /// The curve permits this use.
  void usable(std::string_view key, int curve, Curve::Use use) const;
  void differ(const std::array<int, 2>& pair) const;
  /// Whether the name of a beam's end says that it is free. A body may have that name.
  bool is_free(std::string_view name) const {
    return name == "free" && index_of(mechanism_.bodies, name) < 0;
  }
  void not_zero(const Vec2& axis) const {
    if (!(axis.norm() > 0)) fail("axis", "must not be zero");
  }
  void two_lengths(std::string_view key, double first, double second) const {
    if (!(first > 0 && second > 0)) fail(key, "must be two positive lengths");
  }
  void moving_body(std::string_view key, int body) const {
    if (body == ground) fail(key, "must be a moving body, is the ground");
  }
  /// A film needs the length of its bearing, and a clearance greater than its thickness.
  void film(std::string_view key, int lubricant, double clearance,
            const std::optional<double>& bearing_length) const;
  /// The joint has one degree of freedom.
  void moving(std::string_view key, const Joint& joint) const;
  /// The joints of a ratio with backlash hold two bodies to the ground. The axis of a slider is on its
  /// first body.
  void grounded(int joint, int of) const;
  /// Appends a group to those that another one touches. `above`: the groups before that one.
  void touch(std::string_view key, std::span<const Group> above, std::string_view name,
             std::vector<int>& list) const;
  /// The angle with the name "A-B-C".
  JointAngle angle(std::string_view key, const std::string& text) const;
  void known_drive(std::string_view key, std::string_view name) const {
    named(key, "drive", mechanism_.drives, name);
  }
  /// A strain gauge at this place (m) is on the beam, and not at a free end.
  void on_beam(std::string_view key, const Beam& beam, double place) const;
  /// The beam whose sections a strain gauge measures.
  const Beam& gauged(std::string_view key, std::string_view name) const {
    const auto& beam = mechanism_.beams[static_cast<std::size_t>(named(key, "beam", mechanism_.beams, name))];
    if (beam.is_reduced())
      fail(key, "must be a full beam: a reduced one has no sections; remove its key modes");
    return beam;
  }
  /// Refuses a joint of none of these kinds.
  template <class... Kinds>
  const Joint& of_kind(std::string_view key, int index) const {
    const auto& joint = mechanism_.joints[static_cast<std::size_t>(index)];
    if ((std::holds_alternative<Kinds>(joint) || ...)) return joint;
    std::string list;
    ((list += fmt::format("{}{}", list.empty() ? "" : " or ", Kinds::type)), ...);
    fail(key, fmt::format("must be a {} joint, \"{}\" is not", list, name_of(joint)));
  }

  const Mechanism& mechanism_;

 private:
  static const std::string& name_of_item(const auto& item) {
    if constexpr (requires { item.name; })
      return item.name;
    else
      return name_of(item);
  }
};

}  // namespace freeplay
