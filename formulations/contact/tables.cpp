// Tables of all laws, generated from the enumerators; the file of each law has its row.
#include <array>

#include "formulations/contact/contact_parts.hpp"
#include "formulations/contact/friction_parts.hpp"
#include "generated/contact_laws.hpp"
#include "generated/friction_laws.hpp"
#include "mechanism/laws.hpp"

namespace freeplay {
namespace {

template <ScopedEnum E, class Facts, class F>
constexpr auto table(F row) {
  return each_enumerator<E, std::array<Facts, static_cast<std::size_t>(enumerators<E>())>>(row);
}

constexpr auto all_contact_laws = table<ContactLaw, ContactLawFacts>([](auto law) {
  using L = Law<law()>;
  return ContactLawFacts{.law = law(),
                         .text = L::text,
                         .formula = L::formula,
                         .source = L::source,
                         .range = L::range,
                         .kind = L::kind,
                         .takes_restitution = L::takes_restitution,
                         .positive_restitution = L::positive_restitution,
                         .damping = L::damping,
                         .least_clearance = L::least_clearance,
                         .clearance_end = L::clearance_end};
});

constexpr auto all_friction_laws = table<FrictionLaw, FrictionLawFacts>([](auto law) {
  using L = Law<law()>;
  return FrictionLawFacts{.law = law(),
                          .text = L::text,
                          .formula = L::formula,
                          .source = L::source,
                          .range = L::range,
                          .keys = L::keys,
                          .bristle = L::bristle,
                          .compliant = L::compliant,
                          .positive_v0 = L::positive_v0,
                          .v1_above_v0 = L::v1_above_v0};
});

/// Law names are unique.
constexpr bool distinct(const auto& laws) {
  for (std::size_t i = 0; i < laws.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (laws[i].text == laws[j].text) return false;
  return true;
}
static_assert(distinct(all_contact_laws) && distinct(all_friction_laws));

/// A line law takes its damping factor from a point law.
constexpr bool damped_by_point_laws() {
  for (const auto& l : all_contact_laws)
    if (l.damping && all_contact_laws[static_cast<std::size_t>(*l.damping)].kind != ContactKind::point)
      return false;
  return true;
}
static_assert(damped_by_point_laws());

}  // namespace

std::span<const ContactLawFacts> contact_laws() { return all_contact_laws; }
const ContactLawFacts& facts_of(ContactLaw law) { return all_contact_laws[static_cast<std::size_t>(law)]; }

std::span<const FrictionLawFacts> friction_laws() { return all_friction_laws; }
const FrictionLawFacts& facts_of(FrictionLaw law) { return all_friction_laws[static_cast<std::size_t>(law)]; }

}  // namespace freeplay
