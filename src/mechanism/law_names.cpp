#include <vector>

#include "mechanism/options.hpp"

namespace freeplay {
namespace {

template <class Law, class Facts>
std::vector<Choice<Law>> names_of(std::span<const Facts> laws) {
  std::vector<Choice<Law>> list;
  for (const auto& facts : laws) list.push_back({facts.law, facts.text});
  return list;
}

}  // namespace

std::span<const Choice<ContactLaw>> choices(ContactLaw) {
  static const auto names = names_of<ContactLaw>(contact_laws());
  return names;
}
std::span<const Choice<FrictionLaw>> choices(FrictionLaw) {
  static const auto names = names_of<FrictionLaw>(friction_laws());
  return names;
}

}  // namespace freeplay
