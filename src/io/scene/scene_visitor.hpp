// The canonical order of a scene's tables, and the base of the visitors that go through it: the
// writer of the canonical text (write_scene.cpp) and the check of scenes in code (check_scene.cpp).
// Both visit the same keys: those with an effect.
//
// Use: derive V from SceneVisitor<V>, add the other verbs of mechanism/keys.hpp and
//
//     bool open(table)          whether to visit the keys of this table of options
//     void open(table, name)    an element
//     void type(word)           its kind
//     void word(key, value)     an enumeration
//
// then call each_section(visitor, scene).
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "dynamics/instruments.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {

template <class V>
class SceneVisitor {
 public:
  void take(const Key& key, const auto& x, const auto&... range) { self().need(key, x, range...); }
  void flag(const Key& key, bool x) {
    if (x) self().need(key, x);  // omitted if false, so that older scenes keep their canonical text
  }
  void choose(const Key& key, const auto& x) {
    if constexpr (requires { x.has_value(); }) {
      if (x) self().word(key, *x);
    } else {
      self().word(key, x);
    }
  }
  void choose_other(const Key& key, auto x) {
    if (static_cast<int>(x) != 0) choose(key, x);
  }
  void choose_listed(const Key& key, auto x) { choose(key, x); }
  template <class G>
  const G* group(std::string_view, const std::optional<G>& x) const {
    return x ? &*x : nullptr;
  }
  void deviation(const Key& key, const auto& x, const std::string&) { self().need(key, x); }
  bool when(bool holds) const { return holds; }
  bool when(bool holds, std::initializer_list<std::string_view>, const char*) const { return holds; }
  /// A key that no choice in force reads is omitted.
  template <class O>
  bool own(std::string_view name, const O& o) const {
    return own_key(o, name).read(o, name);
  }
  bool when_given(std::string_view) const { return true; }
  void points(const Key&, std::string_view, const std::vector<NamedPoint>&) const {
  }  // written where they are used
  void point_of(const Key& key, int, const Vec2& at) { self().need(key, at); }
  void from_bodies(const Key& key, const std::optional<double>& x) { self().need(key, x); }
  void joint_angle(const Key& key, double angle, int) { self().need(key, angle); }
  void joint_place(const Key& key, double place, int) { self().need(key, place); }
  void ratio_offset(const Key& key, double offset, int, int, double) { self().need(key, offset); }
  void coupled(int, int, const std::array<int, 2>&) const {}
  void grounded(int, int) const {}
  /// Other spellings of a value are not written.
  void together(std::initializer_list<TypedKey>, const auto&, const auto&) const {}
  void beam_length(const Key& key, const auto& beam) { self().need(key, beam.length, positive); }
  void length(const Key&, const Key& seconds, double x) { self().need(seconds, x); }
  void part_of_length(const Key& key, double x) { self().need(key, x); }
  void table(const Key&, const Key& points, const TorqueDrive::Table& list) { self().pairs(points, list); }
  void maybe_surface(const Key& key, const std::optional<int>& index) {
    if (index && *index >= 0) self().surface(key, *index);
  }
  void maybe_curve(const Key& key, int index, Curve::Use use = Curve::Use::value) {
    if (index >= 0) self().curve(key, index, use);
  }
  void number_or_curve(const Key& key, const CurveOr& x, const Range& range = any_number,
                       Curve::Use use = Curve::Use::value) {
    x.curve < 0 ? self().need(key, x.constant, range) : self().curve(key, x.curve, use);
  }
  template <class J>
  void maybe_joint_of(const Key& key, int index) {
    if (index >= 0) self().template joint<J>(key, index);
  }
  void maybe_joint(const Key& key, int index) { maybe_joint_of<RevoluteJoint>(key, index); }
  template <class J>
  const J* joint(const Key& key, int index) {
    return std::get_if<J>(self().template joint_of<J>(key, index));
  }

 protected:
  V& self() { return static_cast<V&>(*this); }
  /// The element at an index. Throws SceneError if there is none.
  template <class List>
  const typename List::value_type& at(const List& list, int index, std::string_view key) const {
    if (index < 0 || index >= static_cast<int>(list.size()))
      throw SceneError("", fmt::format("{}.{}", path_, key),
                       fmt::format("index {} is out of range; there are {}", index, list.size()));
    return list[static_cast<std::size_t>(index)];
  }
  /// A joint by its index, or by its bodies if code gave only those.
  const Joint& joint_at(const std::vector<Joint>& joints, int index, const std::array<int, 2>& pair,
                        std::string_view key) const {
    if (index >= 0) return at(joints, index, key);
    const auto found = std::ranges::find(joints, pair, [](const Joint& j) { return bodies_of(j); });
    if (found == joints.end())
      throw SceneError("", fmt::format("{}.{}", path_, key), "no joint connects the two bodies");
    return *found;
  }

  std::string path_;  // of the open table
};

/// Visits all keys of a scene but format and title.
template <class Visitor>
void each_section(Visitor& v, const Scene& scene) {
  const auto& m = scene.mechanism;
  v.need({"gravity", "", ""}, m.gravity);
  const auto visit = [&](const char* table, const auto& x) {
    using X = std::decay_t<decltype(x)>;
    v.open(table, x.name);
    if constexpr (requires { X::type; }) v.type(X::type);
    X::keys(v, x);
  };
  const auto facts = [&](const char* table, const auto& list) {
    for (const auto& x : list) visit(table, x);
  };
  const auto elements = [&](const char* table, const auto& list) {
    for (const auto& element : list)
      std::visit(
          [&](const auto& x) {
            if constexpr (requires { x.made; })
              if (x.made) return;
            visit(table, x);
          },
          element);
  };
  const auto options = [&](const char* table, const auto& o) {
    if (v.open(table)) std::decay_t<decltype(o)>::keys(v, o);
  };
  for (const auto& body : m.bodies)
    if (!body.made) visit("bodies", body);
  facts("surfaces", m.surfaces);
  facts("lubricants", m.lubricants);
  facts("profiles", m.profiles);
  facts("curves", m.curves);
  elements("joints", m.joints);
  elements("contacts", m.contacts);
  facts("groups", m.groups);
  facts("beams", m.beams);
  elements("drives", m.drives);
  elements("loads", m.loads);
  if (m.assembly.asks()) options("assembly", m.assembly);
  options("run", scene.run);
  options("penalty", scene.penalty);
  // Omit a scheme that is the default choice: equal runs have equal texts.
  auto nonsmooth = scene.nonsmooth;
  nonsmooth.scheme = {};
  // Only the Moreau–Jean scheme reads the step.
  if (scene.nonsmooth.scheme_in_force() != Scheme::moreau_jean) nonsmooth.step = {};
  if (nonsmooth.scheme_in_force() != scene.nonsmooth.scheme_in_force())
    nonsmooth.scheme = scene.nonsmooth.scheme;
  options("nonsmooth", nonsmooth);
  for (const auto& i : scene.instruments) {
    v.open("instruments", i.name);
    v.choose({"type", "", ""}, i.kind);
    with_kind(i.kind, [&](auto kind) { kind.keys(v, i); });
  }
  facts("tolerances", scene.tolerances);
}

}  // namespace freeplay
