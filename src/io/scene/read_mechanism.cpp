// Reads the elements of a mechanism: `type` or a key selects the kind, then the kind's keys are
// read.
#include "io/scene/read_mechanism.hpp"

#include <fmt/format.h>

#include <type_traits>

#include "io/scene/keys_reader.hpp"

namespace freeplay {
namespace {

/// Elements that later elements may name.
struct Scope {
  const Mechanism& mechanism;
  const Ground& fixed;
};

/// Reads an element of one of the kinds in V, selected by `type`.
template <class V, std::size_t... I>
V read_kind(const std::string& name, const Scope& scope, Section& s, std::index_sequence<I...>) {
  const int kind = s.choice("type", {std::string(std::variant_alternative_t<I, V>::type)...});
  V element;
  const auto read = [&]<std::size_t K>() {
    auto& x = element.template emplace<K>();
    x.name = name;
    read_keys(s, scope.mechanism, x, scope.fixed);
  };
  static_cast<void>(((kind == static_cast<int>(I) ? (read.template operator()<I>(), true) : false) || ...));
  return element;
}

/// Reads an element of one of the kinds in V, selected by which of their keys is given.
template <class V, std::size_t... I>
V read_chosen(const std::string& name, const Scope& scope, Section& s, std::index_sequence<I...>) {
  int given = 0;
  std::string all;
  V element;
  const auto look = [&]<std::size_t K>() {
    for (const auto key : std::variant_alternative_t<K, V>::chosen_by) {
      all += fmt::format("{}{}", all.empty() ? "" : ", ", key);
      if (!s.has(key)) continue;
      ++given;
      element.template emplace<K>().name = name;
    }
  };
  (look.template operator()<I>(), ...);
  if (given == 0) s.lacks("", fmt::format("needs exactly one of {}", all));
  if (given > 1) s.fail("", fmt::format("needs exactly one of {}", all));
  std::visit([&](auto& x) { read_keys(s, scope.mechanism, x, scope.fixed); }, element);
  return element;
}

template <class V>
V read_element(const std::string& name, const Scope& scope, Section& s) {
  constexpr auto kinds = std::make_index_sequence<std::variant_size_v<V>>{};
  if constexpr (requires { std::variant_alternative_t<0, V>::chosen_by; })
    return read_chosen<V>(name, scope, s, kinds);
  else
    return read_kind<V>(name, scope, s, kinds);
}

/// Reads the groups; their discs follow the other bodies.
void read_groups(Section& root, Mechanism& m) {
  const auto own = m.bodies.size();
  for (auto& [name, s] : root.children("groups")) {
    Group group;
    group.name = name;
    read_keys(s, m, group);
    group.first = static_cast<int>(m.bodies.size());
    for (std::size_t b = 0; b < m.bodies.size(); ++b)
      for (int n = 0; b < own && n < group.size(); ++n)
        if (m.bodies[b].name == group.body_name(n + 1))
          s.fail("", fmt::format("its disc {} has the same name as bodies.{}", n + 1, m.bodies[b].name));
    for (int n = 0; n < group.size(); ++n) m.bodies.push_back(group.body(n));
    m.groups.push_back(std::move(group));
  }
}

/// A controller shares its joint with no prescribed motion and no other controller.
void refuse_second_control(const Mechanism& m, const Section& s) {
  struct Driven {
    int joint;
    bool controlled, prescribed;
  };
  const auto driven = [](const Drive& drive) {
    return std::visit(
        []<class D>(const D& d) -> Driven {
          return {d.joint, std::is_base_of_v<ControlLaw, D>,
                  std::is_same_v<D, SpeedDrive> || std::is_same_v<D, MotionDrive>};
        },
        drive);
  };
  const auto last = driven(m.drives.back());
  for (std::size_t k = 0; k + 1 < m.drives.size(); ++k) {
    const auto other = driven(m.drives[k]);
    if (other.joint != last.joint) continue;
    if ((last.controlled && (other.controlled || other.prescribed)) || (other.controlled && last.prescribed))
      s.fail("joint",
             fmt::format("\"{}\" is driven by drives.{} already; a controller shares its joint with no "
                         "prescribed motion and no other controller",
                         name_of(m.joints[static_cast<std::size_t>(last.joint)]), name_of(m.drives[k])));
  }
}

}  // namespace

Mechanism read_mechanism(Section& root) {
  Mechanism m;
  if (root.has("title")) m.title = root.text("title");
  if (root.has("gravity")) m.gravity = root.point("gravity");
  Ground fixed;
  auto frame = root.child("ground");
  read_keys(frame, m, fixed);
  const Scope scope{m, fixed};
  const auto facts = [&]<class X>(const char* table, std::vector<X>& list) {
    for (auto& [name, s] : root.children(table)) {
      X x;
      x.name = name;
      read_keys(s, m, x);
      list.push_back(std::move(x));
    }
  };
  const auto elements = [&]<class V>(const char* table, std::vector<V>& list) {
    for (auto& [name, s] : root.children(table)) list.push_back(read_element<V>(name, scope, s));
  };
  facts("bodies", m.bodies);
  facts("surfaces", m.surfaces);
  read_groups(root, m);
  if (m.bodies.empty())
    root.fail("bodies", "the scene needs at least one body: [bodies.NAME] with mass and inertia");
  facts("lubricants", m.lubricants);
  facts("curves", m.curves);
  elements("joints", m.joints);
  for (auto& [name, s] : root.children("contacts")) {
    for (const auto& joint : m.joints)
      if (name_of(joint) == name)
        s.fail("", "a joint has the same name, so events would be ambiguous; rename one");
    m.contacts.push_back(read_element<Contact>(name, scope, s));
  }
  const std::string* crank = nullptr;
  for (auto& [name, s] : root.children("drives")) {
    m.drives.push_back(read_element<Drive>(name, scope, s));
    refuse_second_control(m, s);
    const bool counts = std::visit(
        [](const auto& d) {
          if constexpr (requires { d.crank; }) return d.crank;
          return false;
        },
        m.drives.back());
    if (!counts) continue;
    if (const auto* motion = std::get_if<MotionDrive>(&m.drives.back()); motion && motion->slides(m))
      s.fail("crank",
             "needs a revolute joint, whose revolutions are counted; a translational joint has no "
             "angle");
    if (crank)
      s.fail("crank", fmt::format("drives.{} already counts the revolutions; only one drive may", *crank));
    crank = &name;
  }
  elements("loads", m.loads);
  auto assembly = root.child("assembly");
  read_keys(assembly, m, m.assembly);
  return m;
}

}  // namespace freeplay
