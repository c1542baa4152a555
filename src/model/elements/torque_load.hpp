// Constant torque on a body.
#pragma once

#include <string>

#include "model/body.hpp"
#include "values/forces.hpp"

namespace freeplay {

struct TorqueLoad {
  static constexpr std::string_view type = "torque", what = "a torque";
  static constexpr auto reports = ForceElement::Kind::torque;
  std::string name;
  int body = ground;
  double torque = 0;  ///< N m

  static void keys(auto& k, auto& l) {
    k.body({"body", "", "the loaded body"}, l.body);
    k.need({"torque", "N m", "constant torque"}, l.torque, any_number);
  }

  auto link(auto& b) const { return b.free_link({ground, body}, {}); }
  bool does_work() const { return true; }

  template <class T>
  void act(const auto& m, const auto& link, const T*, auto& out) const {
    out.couple(link, T(torque));
    out.power.load += torque * m.spin(link);
  }
};

}  // namespace freeplay
