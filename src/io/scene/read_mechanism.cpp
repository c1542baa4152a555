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
  for (auto& [name, s] : root.children("groups")) {
    Group group;
    group.name = name;
    read_keys(s, m, group);
    group.first = static_cast<int>(m.bodies.size());
    for (int n = 0; n < group.size(); ++n) m.bodies.push_back(group.body(n));
    m.groups.push_back(std::move(group));
  }
}

/// Reads the beams; their pieces follow the other bodies.
void read_beams(Section& root, Mechanism& m, const Ground& fixed) {
  for (auto& [name, s] : root.children("beams")) {
    Beam beam;
    beam.name = name;
    read_keys(s, m, beam, fixed);
    add_beam(m, std::move(beam));
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
  read_beams(root, m, fixed);
  if (m.bodies.empty()) root.fail("bodies", no_bodies);
  facts("lubricants", m.lubricants);
  facts("profiles", m.profiles);
  facts("curves", m.curves);
  // Joints that name other joints follow those.
  auto joints = root.children("joints");
  for (const bool names_others : {false, true})
    for (auto& [name, s] : joints)
      if ((s.is_text("type") && s.text("type") == RatioJoint::type) == names_others)
        m.joints.push_back(read_element<Joint>(name, scope, s));
  elements("contacts", m.contacts);
  elements("drives", m.drives);
  elements("loads", m.loads);
  auto assembly = root.child("assembly");
  read_keys(assembly, m, m.assembly);
  return m;
}

}  // namespace freeplay
