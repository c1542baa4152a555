#include "model/mechanism.hpp"

namespace freeplay {

Mechanism idealised(Mechanism mechanism) {
  mechanism.contacts.clear();
  for (auto& joint : mechanism.joints)
    std::visit(
        [](auto& j) {
          if constexpr (requires { j.clearance; }) j.clearance.reset();
        },
        joint);
  return mechanism;
}

const SpeedDrive* main_drive(const Mechanism& mechanism) {
  const SpeedDrive* first = nullptr;
  for (const auto& drive : mechanism.drives)
    if (const auto* speed = std::get_if<SpeedDrive>(&drive)) {
      if (speed->crank) return speed;
      if (!first) first = speed;
    }
  return first;
}

}  // namespace freeplay
