// The derivative of a mode's right-hand side along several directions by traced equations
// (dynamics/system_tangent.hpp). It includes derivatives with respect to the parameters of the directions.
#include "formulations/event_driven/event_tangent.hpp"

#include <algorithm>
#include <utility>

#include "dynamics/system_tangent.hpp"

namespace freeplay {

struct EventDynamics::TracedTangent {
  using Block = SystemTangent::Block;
  std::vector<Block> q, v, z;
  SystemTangent::MotionSlopes motion;
  std::vector<SystemTangent::ContactSlopes> contacts;
};

void EventDynamics::use_tangent(std::shared_ptr<SystemTangent> traced) {
  traced_ = nullptr;
  along_traced_ = false;
  // Forces of films and of joint friction are not traced.
  if (!traced || films.any() || system.frictions() > 0) return;
  traced_ = std::move(traced);
  const auto n = static_cast<std::size_t>(system.n()), states = static_cast<std::size_t>(system.states());
  using Blocks = std::vector<SystemTangent::Block>;
  traced_room_ = std::make_shared<TracedTangent>(
      TracedTangent{Blocks(n), Blocks(n), Blocks(states), traced_->make_slopes(),
                    std::vector<SystemTangent::ContactSlopes>(contacts.size())});
}

bool EventDynamics::includes_parameter(std::size_t c) const { return along_traced_ && traced_->covers(c); }

/// False if the equations have another branch at this state than where they were traced, or if the forces of
/// dependent rows are shared: how they are shared depends on parameters, too.
bool EventDynamics::differentiate_traced(const Vector& x, double t, std::span<const Vector> directions,
                                         std::span<Vector> out) {
  constexpr int width = TangentTape::width;
  const int n = system.n(), m = system.rows(), states = system.states(), used = rows.used();
  const int count = static_cast<int>(directions.size());
  if (used > 0 && rows.dependent()) return false;
  auto& d = *tangent_;
  auto& w = *traced_room_;
  const SystemTangent::Point point{t,
                                   x.data(),
                                   x.data() + n,
                                   x.data() + state_offset(),
                                   d.acceleration.data(),
                                   lambda.data(),
                                   e.cosine.data(),
                                   e.sine.data()};
  if (!traced_->begin(point)) return false;
  for (int k = 0; k < system.contacts(); ++k) {
    const auto& c = contacts[k];
    if (c.unknown < 0) continue;
    if (!traced_->begin(point, k, {c.lambda_n, c.slip == 0 ? c.lambda_t : 0.0, static_cast<double>(c.slip)}))
      return false;
  }
  const SystemTangent::Block still = SystemTangent::Block::Zero();
  for (int first = 0; first < count; first += width) {
    const int some = std::min(width, count - first);
    SystemTangent::gather(directions, first, 0, w.q);
    SystemTangent::gather(directions, first, n, w.v);
    SystemTangent::gather(directions, first, state_offset(), w.z);
    const SystemTangent::Directions along{&still, w.q.data(), w.v.data(), w.z.data(), first};
    traced_->motion(along, w.motion);
    for (int k = 0; k < system.contacts(); ++k)
      if (contacts[k].unknown >= 0) traced_->contact(k, along, w.motion, w.contacts[k]);
    auto& slopes = d.slopes;
    for (int s = 0; s < some; ++s) {
      for (int i = 0; i < n; ++i) slopes.force[i] = w.motion.force[i][s];
      for (int k = 0; k < m; ++k) slopes.side[k] = w.motion.side[k][s];
      for (int k = 0; k < states; ++k) slopes.flow[k] = w.motion.flow[k][s];
      slopes.drive = w.motion.power[SystemTangent::drive][s];
      slopes.load = w.motion.power[SystemTangent::load][s];
      slopes.damping = w.motion.power[SystemTangent::damping][s];
      slopes.friction_power = 0;
      for (int k = 0; k < system.contacts() && used > 0; ++k) {
        const auto& c = contacts[k];
        if (c.unknown < 0) continue;
        const auto& contact = w.contacts[k];
        slopes.rows[c.unknown] = contact.side[0][s];
        if (c.tangent_unknown >= 0) slopes.rows[c.tangent_unknown] = contact.side[1][s];
        slopes.friction[k] = contact.friction[s];
        slopes.friction_power -= c.lambda_t * contact.slide[s];
      }
      double* column = out[first + s].data();
      std::copy_n(directions[first + s].data() + n, n, column);
      respond(x, slopes, column);
    }
  }
  std::ranges::fill(d.slopes.friction, 0.0);
  return true;
}

}  // namespace freeplay
