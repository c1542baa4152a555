#include "dynamics/system_tangent.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "dynamics/planar.hpp"
#include "dynamics/system_tracer.hpp"
#include "numerics/tangent_tape.hpp"

namespace freeplay {
namespace {

using List = std::vector<Traced>;

List ones(Trace& trace, int array, int size) {
  return trace.inputs(array, std::vector<double>(static_cast<std::size_t>(size), 1));
}

using enum SystemTangent::Array;

using Use = SystemTangent::Use;

void trace_motion(TracedObject& object, const System& system, const State& at, Use use) {
  if (!SystemTracer::points(system)) throw NotTraceable("pieces of tables or curves");
  Trace trace(object, "motion");
  const auto t = trace.input(of_t, 0, at.t);
  const auto q = trace.inputs(of_q, at.q), v = trace.inputs(of_v, at.v), z = trace.inputs(of_z, at.z);
  const auto a = ones(trace, of_a, system.n()), lambda = ones(trace, of_lambda, system.rows());
  auto e = system.make_evaluation<Traced>();
  system.place(t, q.data(), e);
  system.rate(q.data(), v.data(), e);
  system.forces(t, q.data(), v.data(), z.data(), e);
  List flow(z.size());
  system.flow(t, q.data(), v.data(), z.data(), flow.data());
  auto& force = e.force;
  auto& side = e.gamma;
  const auto& p = system.pattern();
  for (std::size_t i = 0; i < force.size(); ++i) force[i] -= Traced(system.mass()[i]) * a[i];
  List rate = e.phi_t;
  for (std::size_t k = 0; k < side.size(); ++k) {
    for (int s = p.begin[k]; s < p.begin[k + 1]; ++s) {
      const auto c = static_cast<std::size_t>(p.column[s]);
      force[c] -= e.G[s] * lambda[k];
      side[k] -= e.G[s] * a[c];
      rate[k] += e.G[s] * v[c];
    }
    e.power.drive += lambda[k] * e.phi_t[k];
  }
  trace.outputs(0, force);
  trace.outputs(1, side);
  trace.outputs(2, flow);
  trace.outputs(3, std::array{e.power.drive, e.power.load, e.power.damping});
  if (use != Use::penalty) return;
  trace.outputs(4, rate);
  trace.outputs(5, e.phi);
}

void trace_contact(TracedObject& object, const System& system, const State& at, int k, Use use) {
  const auto& facts = system.contact_facts(k);
  if (facts.lubricant) throw NotTraceable("a lubricated joint");
  Trace trace(object, "contact");
  const auto q = trace.inputs(of_q, at.q), v = trace.inputs(of_v, at.v);
  const auto a = ones(trace, of_a, system.n());
  const auto normal = trace.input(of_contact, 0, 1), sticking = trace.input(of_contact, 1, 0),
             slip = trace.input(of_contact, 2, 1);
  auto e = system.make_evaluation<Traced>();
  for (std::size_t b = 0; b < e.cosine.size(); ++b) {
    if (std::ranges::find(facts.bodies, static_cast<int>(b)) == facts.bodies.end()) continue;
    e.cosine[b] = cos(q[3 * b + 2]);
    e.sine[b] = sin(q[3 * b + 2]);
  }
  ContactRowOf<Traced> row;
  system.contact(k, q.data(), v.data(), e, row);
  std::map<int, Traced> force;
  const auto rest = [&](const SparseRowOf<Traced>& w, Traced gamma) {
    for (int i = 0; i < w.size; ++i) gamma -= w.value[i] * a[static_cast<std::size_t>(w.column[i])];
    return gamma;
  };
  const auto push = [&](const SparseRowOf<Traced>& w, const Traced& f) {
    for (int i = 0; i < w.size; ++i) force[w.column[i]] += w.value[i] * f;
  };
  push(row.normal, normal);
  const bool modes = use == Use::modes;
  if (modes) {
    trace.output(1, 0, rest(row.normal, row.gamma_n));
  } else {
    trace.output(3, 0, row.gap);
    trace.output(3, 1, row.normal.dot(v.data()));
  }
  if (row.tangent.size > 0) {
    const Traced friction = modes ? sticking - slip * Traced(*facts.surface.friction) * normal : sticking;
    push(row.tangent, friction);
    if (modes) trace.output(1, 1, rest(row.tangent, row.gamma_t));
    trace.output(2, 0, row.tangent.dot(v.data()));
    if (modes) trace.output(2, 1, friction);
  }
  for (const auto& [c, f] : force) trace.output(0, c, f);
}

/// The motion and then each contact.
TracedObject trace_all(const System& system, const State& at, Use use) {
  auto object = TracedObject::unshared();
  trace_motion(object, system, at, use);
  for (int k = 0; k < system.contacts(); ++k) trace_contact(object, system, at, k, use);
  return object;
}

}  // namespace

void SystemTangent::gather(std::span<const std::vector<double>> directions, int first, int offset,
                           std::vector<Block>& blocks) {
  const int some = std::min(TangentTape::width, static_cast<int>(directions.size()) - first);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    blocks[i].setZero();
    for (int s = 0; s < some; ++s)
      blocks[i][s] = directions[static_cast<std::size_t>(first + s)][static_cast<std::size_t>(offset) + i];
  }
}

std::unique_ptr<SystemTangent> SystemTangent::trace(const System& system, const State& near,
                                                    std::span<const Parameter> parameters, Use use) {
  const auto sample = moved(system, near, still_coordinates(system, near), 1);
  try {
    const auto nominal = trace_all(system, sample, use);
    std::unique_ptr<SystemTangent> all(new SystemTangent(system, use));
    all->vary(nominal, sample, parameters);
    return all;
  } catch (const NotTraceable&) {
    return nullptr;
  }
}

/// Forms the derivatives of the constants, and differentiates the functions.
void SystemTangent::vary(const TracedObject& nominal, const State& sample,
                         std::span<const Parameter> parameters) {
  const auto& constants = nominal.constants();
  const auto count = parameters.size();
  std::vector<std::vector<double>> slope(count, std::vector<double>(constants.size()));
  covered_.assign(count, true);
  for (std::size_t p = 0; p < count; ++p) {
    const auto& parameter = parameters[p];
    if (!parameter.systems[0]) continue;
    std::vector<TracedObject> displaced;
    try {
      for (const auto* system : parameter.systems) displaced.push_back(trace_all(*system, sample, use_));
    } catch (const NotTraceable&) {
    }
    covered_[p] = displaced.size() == parameter.systems.size() &&
                  std::ranges::all_of(displaced, [&](const auto& d) { return d.same_structure(nominal); });
    if (!covered_[p]) continue;
    const auto at = [&](std::size_t i, std::size_t slot) { return displaced[i].constants()[slot]; };
    for (std::size_t s = 0; s < constants.size(); ++s)
      slope[p][s] = (8 * (at(2, s) - at(1, s)) - (at(3, s) - at(0, s))) / (12 * parameter.spacing);
  }
  // Constants that all parameters change alike are one.
  std::map<std::vector<double>, int> known;
  index_.assign(constants.size(), -1);
  std::vector<std::vector<double>> changes;
  for (std::size_t s = 0; s < constants.size(); ++s) {
    std::vector<double> key;
    for (const auto& list : slope) key.push_back(list[s]);
    if (std::ranges::all_of(key, [](double x) { return x == 0; })) continue;
    auto change = key;
    key.push_back(constants[s]);
    const auto [entry, is_new] = known.try_emplace(std::move(key), static_cast<int>(varied_.size()));
    index_[s] = entry->second;
    if (!is_new) continue;
    varied_.push_back(constants[s]);
    changes.push_back(std::move(change));
  }
  constexpr auto width = static_cast<std::size_t>(TangentTape::width);
  constant_.assign(varied_.size() + 1, Block::Zero());
  slopes_.assign((count + width - 1) / width, constant_);
  for (std::size_t i = 0; i < varied_.size(); ++i)
    for (std::size_t p = 0; p < count; ++p)
      slopes_[p / width][i][static_cast<long>(p % width)] = changes[i][p];

  const auto n = static_cast<std::size_t>(system_.n());
  TangentInputs in;
  in.values = {{sample.t},
               sample.q,
               sample.v,
               sample.z,
               std::vector<double>(n, 1),
               std::vector<double>(static_cast<std::size_t>(system_.rows()), 1),
               {},
               {},
               {1, 0, 1}};
  in.directions = {along_t, along_q, along_v, along_z, -1, -1, -1, -1, -1};
  in.varied = index_;
  in.varied_values = of_parameters;
  in.varied_directions = along_parameters;
  in.known = [this](Operation operation, int array, int index) -> std::optional<std::pair<int, int>> {
    if (array != of_q || !system_.is_angle(index)) return {};
    return std::pair{operation == Operation::cos ? of_cosine : of_sine, planar::body_of(index)};
  };
  TracedObject derivatives;
  for (int f = 0; f < nominal.functions(); ++f) {
    const auto& function = nominal.function(f);
    append_tangent(derivatives, function.name, function, constants, in);
  }
  for (int f = 0; f < nominal.functions(); ++f) {
    TangentTape tape(derivatives.function(f), derivatives.constants(), first_direction);
    if (f == 0)
      motion_ = std::move(tape);
    else
      contacts_.push_back(std::move(tape));
  }
}

SystemTangent::Inputs SystemTangent::inputs(const Point& p) const {
  Inputs in{};
  in[of_t] = &p.t;
  in[of_q] = p.q;
  in[of_v] = p.v;
  in[of_z] = p.z;
  in[of_a] = p.a;
  in[of_lambda] = p.lambda;
  in[of_cosine] = p.cosine;
  in[of_sine] = p.sine;
  in[of_parameters] = varied_.data();
  return in;
}

SystemTangent::BlockInputs SystemTangent::inputs(const Directions& d) const {
  const auto& c = d.first_parameter < 0
                      ? constant_
                      : slopes_[static_cast<std::size_t>(d.first_parameter / TangentTape::width)];
  return {d.t, d.q, d.v, d.z, c.data()};
}

bool SystemTangent::begin(const Point& point) { return motion_.values(inputs(point).data()); }

bool SystemTangent::begin(const Point& point, int contact, const ContactForce& force) {
  auto in = inputs(point);
  const double values[] = {force.normal, force.tangential, force.slip};
  in[of_contact] = values;
  return contacts_[static_cast<std::size_t>(contact)].values(in.data());
}

SystemTangent::MotionSlopes SystemTangent::make_slopes() const {
  const auto blocks = [](int size) { return std::vector<Block>(static_cast<std::size_t>(size)); };
  const int rows = use_ == Use::penalty ? system_.rows() : 0;
  return {blocks(system_.n()), blocks(system_.rows()), blocks(system_.states()),
          blocks(powers),      blocks(rows),           blocks(rows)};
}

void SystemTangent::motion(const Directions& d, MotionSlopes& out) {
  Block* to[6];
  int i = 0;
  for (auto* list : {&out.force, &out.side, &out.flow, &out.power, &out.rate, &out.place}) {
    std::ranges::fill(*list, Block::Zero());
    to[i++] = list->data();
  }
  motion_.directions(inputs(d).data(), to);
}

void SystemTangent::contact(int k, const Directions& d, MotionSlopes& motion, ContactSlopes& out) {
  std::array<Block, 2> sliding{Block::Zero(), Block::Zero()}, approach = sliding;
  for (auto& block : out.side) block = Block::Zero();
  Block* to[] = {motion.force.data(), out.side.data(), sliding.data(), approach.data()};
  contacts_[static_cast<std::size_t>(k)].directions(inputs(d).data(), to);
  out.slide = sliding[0];
  out.friction = sliding[1];
  out.gap = approach[0];
  out.rate = approach[1];
}

}  // namespace freeplay
