// KeysReader: the visitor that fills the facts and options of a scene from one section of its file
// (mechanism/keys.hpp). To the values of any document (io/scene/section.hpp) it adds those of
// a mechanism: curves, points, and names of elements, which it resolves to indices. Errors are
// SceneErrors with the position of the key.
//
// Use: read_keys(section, mechanism, x). A reader refers to the section and to the elements read so
// far; it owns neither.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

#include "dynamics/argument.hpp"
#include "io/scene/key_rules.hpp"
#include "io/scene/section.hpp"
#include "mechanism/ground.hpp"
#include "mechanism/instrument.hpp"
#include "mechanism/mechanism.hpp"
#include "mechanism/options.hpp"

namespace freeplay {

/// Visitor of the `keys()` functions of a scene that reads one section.
class KeysReader : public SectionReader, private KeyRules {
 public:
  /// `fixed`: the ground, whose named points elements may use.
  KeysReader(Section& section, const Mechanism& mechanism, const Ground& fixed)
      : SectionReader(section), KeyRules(mechanism), fixed_(fixed) {}

  using SectionReader::choose;
  void choose(const Key& key, Argument& x) {
    SectionReader::choose(key, x);
    against_ = x;
  }
  /// A key that only some choices read. Those choices may be read later, so the value is checked
  /// here and the key's validity in settle().
  template <class O>
  bool own(std::string_view name, const O& o) {
    own_.push_back([this, &o, &row = own_key(o, name)] { settle(o, row); });
    return true;
  }

  /// One of two keys for a quantity: `own` gives the value itself, `other` is converted to it.
  template <class Number>
  void either(const Key& other, const Range& range, double (*convert)(double), const Key& own,
              const Range& own_range, Number& x) {
    one_of(other, own);
    x = s_.has(own.name) ? s_.number(own, own_range) : convert(s_.number(other, range));
  }
  void table(const Key& constant, const Key& points, TorqueDrive::Table& table);
  /// Points of a curve, listed in the scene or in a file that it names.
  void samples(const Key& points, const Key& file, const Key& columns, Curve::Points& list);
  /// Index of the named curve, if the curve permits this use.
  void curve(const Key& key, int& curve, Curve::Use use = Curve::Use::value);
  void maybe_curve(const Key& key, int& index, Curve::Use use = Curve::Use::value) {
    if (s_.has(key.name)) curve(key, index, use);
  }
  /// A number, or the name of a curve.
  void number_or_curve(const Key& key, CurveOr& x, const Range& range = any_number,
                       Curve::Use use = Curve::Use::value);
  /// A list of points whose first column increases, listed in the scene or in a file that it names.
  /// May be absent.
  void pairs(const Key& key, TorqueDrive::Table& table);
  /// Centres of many discs: listed, in a file, or on a grid.
  void places(const Key& list, const Key& grid, const Key& origin, const Key& spacing, const Key& stagger,
              std::vector<Vec2>& places);
  /// Points of a path; consecutive points must differ.
  void way(const Key& key, std::vector<Vec2>& points);
  /// Names of groups that were read before.
  void groups(const Key& key, std::vector<int>& list);
  void maybe_surface(const Key& key, std::optional<int>& index) {
    if (s_.has(key.name)) surface(key, index.emplace(-1));
  }
  void length(const Key& turns, const Key& seconds, double& duration);
  void part_of_length(const Key& key, double& x);

  /// `free`: an end may be free_end.
  void between(std::string_view meaning, std::array<int, 2>& pair, bool free = false);
  void ends(std::string_view meaning, std::array<Vec2, 2>& at);
  /// Length of a beam. If the key is absent, it is that of the line or the arc between its ends, on the ground or on
  /// bodies with stated positions.
  void beam_length(const Key& key, Beam& beam);
  /// Named points of a body, in any frame. The point named `centre` is the centre of mass in that
  /// frame; the result is relative to it.
  void points(const Key& key, std::string_view centre, std::vector<NamedPoint>& list);
  /// A point of a body, by name or by coordinates.
  void point_of(const Key& key, int body, Vec2& at);
  /// Angles, each by the names of three joints, "A-B-C".
  void angles(const Key& key, std::vector<JointAngle>& list);
  void axis(std::string_view meaning, Vec2& axis);
  void radii(const Key& key, std::array<double, 2>& radii);
  void body(const Key& key, int& body);
  const Surface* surface(const Key& key, int& surface);
  void lubricant(const Key& key, int& lubricant, double clearance,
                 const std::optional<double>& bearing_length);
  /// A profile; may be absent.
  void profile(const Key& key, int& profile) {
    if (s_.has(key.name)) profile = named(key.name, "profile", mechanism_.profiles, s_.text(key.name));
  }
  void drive(const Key& key, std::string& drive);
  void gauge(const Key& beam, const Key& place, Instrument& i);
  void any_joint(const Key& key, int& joint, std::array<int, 2>& pair);
  /// A joint with one degree of freedom: revolute or translational.
  void moving_joint(const Key& key, int& joint);
  /// A revolute joint; may be absent.
  void maybe_joint(const Key& key, int& index) {
    if (!s_.has(key.name)) return;
    joint<RevoluteJoint>(key, index);
    follows_ = true;
  }
  /// A joint of kind J; may be absent.
  template <class J>
  void maybe_joint_of(const Key& key, int& index) {
    if (s_.has(key.name)) joint<J>(key, index);
  }
  /// Angle of a joint, or position along its axis. If the key is absent, it follows from the
  /// positions of the bodies.
  void joint_place(const Key& key, double& place, int joint);
  /// A joint of kind J.
  template <class J>
  const J* joint(const Key& key, int& joint) {
    joint = joint_index(key);
    return &std::get<J>(of_kind<J>(key.name, joint));
  }
  /// A joint of one of these kinds.
  template <class... Kinds>
  const Joint* joint_of(const Key& key, int& joint) {
    joint = joint_index(key);
    return &of_kind<Kinds...>(key.name, joint);
  }
  /// A value that, if its key is absent, follows from the positions of the bodies after all joints
  /// are read (read_scene.cpp).
  void from_bodies(const Key& key, std::optional<double>& x) {
    x.reset();
    take(key, x, any_number);
  }
  /// Offset of a ratio between two joints. If the key is absent, it follows from the bodies' positions.
  void ratio_offset(const Key& key, double& offset, int joint, int of, double ratio);
  void coupled(int joint, int of, std::array<int, 2>& pair) const {
    pair = RatioJoint::coupled(mechanism_, joint, of);
  }
  using KeyRules::grounded;
  /// Angle of a joint. If the key is absent, it follows from the angles of the bodies.
  void joint_angle(const Key& key, double& angle, int joint);

  /// Called after all keys were read. Checks the units of curves against those of their use, and
  /// refuses keys that the choices in force do not read.
  void settle() const;

 private:
  /// Refuses a key that is given but not read. A key of the file is noted as unused, not refused,
  /// if an option of the command line replaced the choice that read it.
  template <class O>
  void settle(const O& o, const OwnKey<O>& row) const {
    if (!s_.has(row.name) || row.read(o, row.name)) return;
    const auto option = [&](std::string_view key) { return !key.empty() && s_.by_option(key); };
    const bool chosen = option(row.by) || option(row.also[0]) || option(row.also[1]);
    unread(row.name, chosen && !option(row.name), row.by, row.chosen(o), row.belongs);
  }
  void unread(std::string_view key, bool laid_aside, std::string_view by, std::string_view chosen,
              std::string_view belongs) const;
  void one_of(const Key& a, const Key& b) const;
  int body_index(std::string_view key, const std::string& name) const;
  int joint_index(const Key& key);
  double stated_angle(int joint) const;
  Vec2 named_point(std::string_view key, int body, const std::string& name) const;

  void refuse(std::string_view key, const std::string& message) const override { s_.fail(key, message); }

  const Ground& fixed_;
  double unit_ = 1;                          // s, unit of times given in turns
  std::array<int, 2> pair_{ground, ground};  // bodies of the element's ends
  struct Named {
    std::string key;
    int curve;
    std::string_view unit;  // unit of y
  };
  std::vector<Named> named_;
  std::vector<std::function<void()>> own_;  // checks of keys that only some choices read
  Argument against_ = Argument::time;
  // The angle of another joint is used; a joint has a prescribed motion.
  bool follows_ = false, slides_ = false;
};

/// Reads all keys of x and refuses all others. `complete` sets members without a key before the
/// final checks.
template <class X, class Complete = void (*)(X&)>
void read_keys(
    Section& section, const Mechanism& mechanism, X& x, const Ground& fixed = {},
    const Complete& complete = [](X&) {}) {
  KeysReader reader(section, mechanism, fixed);
  X::keys(reader, x);
  complete(x);
  reader.settle();
  if constexpr (requires { x.what(); })
    section.done(std::string(x.what()));
  else
    section.done(std::string(X::what));
}

}  // namespace freeplay
