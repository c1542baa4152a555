#include "dynamics/system_tangent.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "dynamics/planar.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {
namespace {

using List = std::vector<Traced>;
using Block = SystemTangent::Block;
using Point = SystemTangent::Point;
using Use = SystemTangent::Use;

/// Arrays of inputs of the traced functions; directions come last.
enum Array {
  of_t,
  of_q,
  of_v,
  of_z,
  of_a,
  of_lambda,
  of_cosine,
  of_sine,
  of_forces,
  of_pieces,
  of_parameters,
  first_direction,
  along_t = first_direction,
  along_q,
  along_v,
  along_z,
  along_parameters,
  arrays
};

constexpr std::size_t forces_of_contact = 6;
constexpr auto width = static_cast<std::size_t>(TangentTape::width);

List inputs(Trace& trace, int array, const double* values, int size) {
  return trace.inputs(array, std::span(values, static_cast<std::size_t>(size)));
}

List ones(Trace& trace, int array, int size) {
  return trace.inputs(array, std::vector<double>(static_cast<std::size_t>(size), 1));
}

/// The pieces of all phases as inputs; none if the point has none.
std::vector<PieceOf<Traced>> traced_pieces(Trace& trace, const System& system, const Point& at) {
  std::vector<PieceOf<Traced>> pieces;
  for (int k = 0; at.pieces && k < system.phases(); ++k)
    pieces.push_back({trace.input(of_pieces, 2 * k, at.pieces[k].low),
                      trace.input(of_pieces, 2 * k + 1, at.pieces[k].high)});
  return pieces;
}

void trace_motion(TracedObject& object, const System& system, const Point& at, Use use) {
  Trace trace(object, "motion");
  const auto t = trace.input(of_t, 0, at.t);
  const auto q = inputs(trace, of_q, at.q, system.n()), v = inputs(trace, of_v, at.v, system.n()),
             z = inputs(trace, of_z, at.z, system.states());
  const auto a = ones(trace, of_a, system.n()), lambda = ones(trace, of_lambda, system.rows());
  const auto pieces = traced_pieces(trace, system, at);
  auto e = system.make_evaluation<Traced>();
  e.pieces = at.pieces ? pieces.data() : nullptr;
  const ReadingOf<Traced> reading{nullptr, e.pieces};
  system.place(t, q.data(), e);
  system.rate(q.data(), v.data(), e);
  system.forces(t, q.data(), v.data(), z.data(), e, reading);
  List flow(z.size());
  system.flow(t, q.data(), v.data(), z.data(), flow.data(), reading);
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

/// Forces along rows, and residuals of the rows at given accelerations.
class RowForces {
 public:
  explicit RowForces(List a) : a_(std::move(a)) {}
  void push(const SparseRowOf<Traced>& row, const Traced& f) {
    for (int i = 0; i < row.size; ++i) force_[row.column[i]] += row.value[i] * f;
  }
  Traced rest(const SparseRowOf<Traced>& row, Traced gamma) const {
    for (int i = 0; i < row.size; ++i) gamma -= row.value[i] * a_[static_cast<std::size_t>(row.column[i])];
    return gamma;
  }
  void output(Trace& trace) const {
    for (const auto& [c, f] : force_) trace.output(0, c, f);
  }

 private:
  List a_;
  std::map<int, Traced> force_;
};

EvaluationOf<Traced> orient(const System& system, const List& q, auto takes) {
  auto e = system.make_evaluation<Traced>();
  for (std::size_t b = 0; b < e.cosine.size(); ++b) {
    if (!takes(static_cast<int>(b))) continue;
    e.cosine[b] = cos(q[3 * b + 2]);
    e.sine[b] = sin(q[3 * b + 2]);
  }
  return e;
}

void trace_contact(TracedObject& object, const System& system, const Point& at, int k, Use use) {
  const auto& facts = system.contact_facts(k);
  Trace trace(object, "contact");
  const auto q = inputs(trace, of_q, at.q, system.n()), v = inputs(trace, of_v, at.v, system.n());
  RowForces forces(ones(trace, of_a, system.n()));
  const auto normal = trace.input(of_forces, 0, 1), sticking = trace.input(of_forces, 1, 0),
             slip = trace.input(of_forces, 2, 1);
  auto e = orient(system, q, [&](int b) { return std::ranges::find(facts.bodies, b) != facts.bodies.end(); });
  std::vector<PieceOf<Traced>> pieces;
  if (system.is_outline(k)) pieces = traced_pieces(trace, system, at);
  e.pieces = pieces.empty() ? nullptr : pieces.data();
  ContactRowOf<Traced> row;
  system.contact(k, q.data(), v.data(), e, row);
  const bool modes = use == Use::modes;
  forces.push(row.normal, normal);
  if (modes) trace.output(1, 0, forces.rest(row.normal, row.gamma_n));
  if (!modes || facts.lubricant) {
    trace.output(3, 0, row.gap);
    trace.output(3, 1, row.normal.dot(v.data()));
  }
  if (row.tangent.size > 0) {
    const Traced friction = modes ? sticking - slip * Traced(*facts.surface.friction) * normal : sticking;
    forces.push(row.tangent, friction);
    if (modes) trace.output(1, 1, forces.rest(row.tangent, row.gamma_t));
    trace.output(2, 0, row.tangent.dot(v.data()));
    if (modes) trace.output(2, 1, friction);
  }
  if (facts.lubricant) {
    forces.push(row.normal, trace.input(of_forces, 3, 0));
    forces.push(row.film, trace.input(of_forces, 4, 0));
    forces.push(row.spin, trace.input(of_forces, 5, 0));
    trace.output(4, 0, row.film.dot(v.data()));
    trace.output(4, 1, row.spin.dot(v.data()));
  }
  forces.output(trace);
}

void trace_friction(TracedObject& object, const System& system, const Point& at, int k) {
  Trace trace(object, "friction");
  const auto q = inputs(trace, of_q, at.q, system.n()), v = inputs(trace, of_v, at.v, system.n());
  RowForces forces(ones(trace, of_a, system.n()));
  SparseRowOf<Traced> row;
  const Traced gamma =
      system.friction(k, q.data(), v.data(), orient(system, q, [](int) { return true; }), row);
  forces.push(row, trace.input(of_forces, 0, 1));
  forces.output(trace);
  trace.output(1, 0, forces.rest(row, gamma));
  trace.output(2, 0, row.dot(v.data()));
}

}  // namespace

SystemTangent::SystemTangent(const System& system, Use use, std::vector<Parameter> parameters)
    : system_(system),
      use_(use),
      parameters_(std::move(parameters)),
      covered_(parameters_.size(), true),
      functions_(friction_function(system.frictions())) {}

TracedObject SystemTangent::record(const System& system, std::size_t function, const Point& point) const {
  auto object = TracedObject::unshared();
  const int k = static_cast<int>(function) - 1;
  if (function == 0)
    trace_motion(object, system, point, use_);
  else if (k < system.contacts())
    trace_contact(object, system, point, k, use_);
  else
    trace_friction(object, system, point, k - system.contacts());
  return object;
}

std::unique_ptr<SystemTangent::Branch> SystemTangent::trace(std::size_t function, const Point& point) {
  const auto nominal = record(system_, function, point);
  auto branch = std::make_unique<Branch>();
  branch->in_pieces = point.pieces != nullptr;
  const auto n = static_cast<std::size_t>(system_.n()), rows = static_cast<std::size_t>(system_.rows());
  TangentInputs in;
  in.values = {{point.t},
               {point.q, point.q + n},
               {point.v, point.v + n},
               {point.z, point.z + system_.states()},
               std::vector<double>(n, 1),
               std::vector<double>(rows, 1),
               {},
               {},
               {1, 0, 1, 0, 0, 0},
               {}};
  for (int k = 0; point.pieces && k < system_.phases(); ++k)
    for (const double end : {point.pieces[k].low, point.pieces[k].high}) in.values.back().push_back(end);
  in.directions = {along_t, along_q, along_v, along_z, -1, -1, -1, -1, -1, -1};
  in.varied = vary(*branch, nominal, function, point);
  in.varied_values = of_parameters;
  in.varied_directions = along_parameters;
  in.known = [this](Operation operation, int array, int index) -> std::optional<std::pair<int, int>> {
    if (array != of_q || !system_.is_angle(index)) return {};
    return std::pair{operation == Operation::cos ? of_cosine : of_sine, planar::body_of(index)};
  };
  TracedObject derivative;
  append_tangent(derivative, "tangent", nominal, nominal.function(0), in);
  branch->tape = TangentTape(derivative, derivative.function(0), first_direction);
  return branch;
}

/// Forms the derivatives of the constants by the parameters. Returns the index of each constant among those
/// that vary, or −1.
std::vector<int> SystemTangent::vary(Branch& branch, const TracedObject& nominal, std::size_t function,
                                     const Point& point) {
  const auto& constants = nominal.constants();
  const auto& nodes = nominal.function(0).nodes;
  const auto count = parameters_.size();
  std::vector<std::vector<double>> slope(count, std::vector<double>(constants.size()));
  for (std::size_t p = 0; p < count; ++p) {
    const auto& parameter = parameters_[p];
    if (!parameter.systems[0] || !covered_[p]) continue;
    std::vector<TracedObject> displaced;
    for (const auto* system : parameter.systems) displaced.push_back(record(*system, function, point));
    const auto is_like = [&](const auto& d) { return d.same_structure(nominal); };
    const auto is_refined = [](const auto& f) { return f->refined; };
    if (!std::ranges::all_of(nominal.outside(), is_refined) || !std::ranges::all_of(displaced, is_like)) {
      exclude(p);
      continue;
    }
    const auto at = [&](std::size_t i, std::size_t slot) { return displaced[i].constants()[slot]; };
    for (std::size_t s = 0; s < constants.size(); ++s)
      if (at(2, s) != at(1, s) || at(3, s) != at(0, s))
        slope[p][s] = (8 * (at(2, s) - at(1, s)) - (at(3, s) - at(0, s))) / (12 * parameter.spacing);
    for (const auto& n : nodes)
      if ((n.operation == Operation::locate || n.operation == Operation::pick) &&
          std::ranges::any_of(
              std::span(slope[p]).subspan(static_cast<std::size_t>(n.b), static_cast<std::size_t>(n.c)),
              [](double x) { return x != 0; })) {
        exclude(p);
        slope[p].assign(constants.size(), 0);
        break;
      }
  }
  // Constants that all parameters change alike are one.
  std::map<std::vector<double>, int> known;
  std::vector<int> index(constants.size(), -1);
  branch.slopes.resize((count + width - 1) / width);
  for (std::size_t s = 0; s < constants.size(); ++s) {
    std::vector<double> key;
    for (const auto& list : slope) key.push_back(list[s]);
    if (std::ranges::all_of(key, [](double x) { return x == 0; })) continue;
    key.push_back(constants[s]);
    const auto [entry, is_new] = known.try_emplace(std::move(key), static_cast<int>(branch.varied.size()));
    index[s] = entry->second;
    if (!is_new) continue;
    branch.varied.push_back(constants[s]);
    for (auto& block : branch.slopes) block.push_back(Block::Zero());
    for (std::size_t p = 0; p < count; ++p)
      branch.slopes[p / width].back()[static_cast<long>(p % width)] = slope[p][s];
  }
  if (constant_.size() < branch.varied.size()) constant_.assign(branch.varied.size(), Block::Zero());
  return index;
}

/// From now on no derivative includes the parameter.
void SystemTangent::exclude(std::size_t parameter) {
  covered_[parameter] = false;
  for (auto& function : functions_)
    for (auto& branch : function.branches)
      for (auto& block : branch->slopes[parameter / width]) block[static_cast<long>(parameter % width)] = 0;
}

void SystemTangent::begin(std::size_t function, const Point& p, const double* forces) {
  auto& [branches, present] = functions_[function];
  const double* in[first_direction] = {
      &p.t, p.q, p.v, p.z, p.a, p.lambda, p.cosine, p.sine, forces, p.pieces ? &p.pieces->low : nullptr};
  const auto fits = [&](Branch& branch) {
    in[of_parameters] = branch.varied.data();
    return branch.in_pieces == (p.pieces != nullptr) && branch.tape.values(in);
  };
  if (present && fits(*present)) return;
  for (auto& branch : branches)
    if (branch.get() != present && fits(*branch)) {
      present = branch.get();
      return;
    }
  if (branches.size() == most_branches) branches.erase(branches.begin());
  branches.push_back(trace(function, p));
  present = branches.back().get();
  // Rounding may decide a comparison otherwise than in the trace; both results are then right.
  (void)fits(*present);
}

void SystemTangent::prepare(const State& near) {
  const auto at = moved(system_, near, still_coordinates(system_, near), 1);
  auto e = system_.make_evaluation();
  system_.place(at.t, at.q.data(), e);
  std::vector<Piece> pieces;
  for (int k = 0; k < system_.phases(); ++k)
    pieces.push_back(system_.phase(k).piece(system_.phase(k).at(at.q.data(), at.v.data()).value, true));
  const std::vector<double> a(at.q.size()), lambda(static_cast<std::size_t>(system_.rows()));
  const Point point{at.t,          at.q.data(),     at.v.data(),   at.z.data(),  a.data(),
                    lambda.data(), e.cosine.data(), e.sine.data(), pieces.data()};
  begin(point);
  for (int k = 0; k < system_.contacts(); ++k) begin_contact(point, k, {});
  for (int k = 0; k < system_.frictions(); ++k) begin_friction(point, k, 0);
}

void SystemTangent::begin(const Point& point) { begin(0, point, nullptr); }

void SystemTangent::begin_contact(const Point& point, int contact, const ContactForce& f) {
  const double forces[forces_of_contact] = {f.normal, f.tangential, f.slip, f.film_normal, f.film, f.torque};
  begin(contact_function(contact), point, forces);
}

void SystemTangent::begin_friction(const Point& point, int friction, double force) {
  begin(friction_function(friction), point, &force);
}

SystemTangent::MotionSlopes SystemTangent::make_slopes() const {
  const auto blocks = [](int size) { return std::vector<Block>(static_cast<std::size_t>(size)); };
  const int rows = use_ == Use::penalty ? system_.rows() : 0;
  return {blocks(system_.n()), blocks(system_.rows()), blocks(system_.states()),
          blocks(powers),      blocks(rows),           blocks(rows)};
}

void SystemTangent::differentiate(std::size_t function, const Directions& d, Block* const* out) {
  auto& branch = *functions_[function].present;
  const auto block = static_cast<std::size_t>(std::max(0, d.first_parameter)) / width;
  const bool varies = d.first_parameter >= 0 && block < branch.slopes.size();
  const auto& parameters = varies ? branch.slopes[block] : constant_;
  const Block* in[arrays - first_direction] = {d.t, d.q, d.v, d.z, parameters.data()};
  branch.tape.directions(in, out);
}

void SystemTangent::motion(const Directions& d, MotionSlopes& out) {
  Block* to[6];
  int i = 0;
  for (auto* list : {&out.force, &out.side, &out.flow, &out.power, &out.rate, &out.place}) {
    std::ranges::fill(*list, Block::Zero());
    to[i++] = list->data();
  }
  differentiate(0, d, to);
}

void SystemTangent::contact(int k, const Directions& d, MotionSlopes& motion, ContactSlopes& out) {
  const Block zero = Block::Zero();
  std::array sliding{zero, zero}, approach{zero, zero}, film{zero, zero};
  out.side = {zero, zero};
  Block* to[] = {motion.force.data(), out.side.data(), sliding.data(), approach.data(), film.data()};
  differentiate(contact_function(k), d, to);
  out.slide = sliding[0];
  out.friction = sliding[1];
  out.gap = approach[0];
  out.rate = approach[1];
  out.film = film[0];
  out.spin = film[1];
}

void SystemTangent::friction(int k, const Directions& d, MotionSlopes& motion, FrictionSlopes& out) {
  out.side = out.slide = Block::Zero();
  Block* to[] = {motion.force.data(), &out.side, &out.slide};
  differentiate(friction_function(k), d, to);
}

DirectionBlocks::DirectionBlocks(const System& system, int state_offset)
    : q_(static_cast<std::size_t>(system.n())),
      v_(q_.size()),
      z_(static_cast<std::size_t>(system.states())),
      state_offset_(state_offset) {}

int DirectionBlocks::take(std::span<const std::vector<double>> directions, std::span<const double> times,
                          int first) {
  const int some = std::min(TangentTape::width, static_cast<int>(directions.size()) - first);
  const auto begin = static_cast<std::size_t>(first);
  const auto gather = [&](std::vector<Block>& blocks, std::size_t offset) {
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      blocks[i].setZero();
      for (int s = 0; s < some; ++s)
        blocks[i][s] = directions[begin + static_cast<std::size_t>(s)][offset + i];
    }
  };
  gather(q_, 0);
  gather(v_, q_.size());
  gather(z_, static_cast<std::size_t>(state_offset_));
  t_.setZero();
  for (int s = 0; s < some && !times.empty(); ++s) t_[s] = times[begin + static_cast<std::size_t>(s)];
  return some;
}

UnitDirections::UnitDirections(int rates, int offset, int states, int size, int further)
    : places(static_cast<std::size_t>(rates + states)),
      directions(places.size() + 1, std::vector<double>(static_cast<std::size_t>(size + further))),
      columns(places.size() + 1, std::vector<double>(static_cast<std::size_t>(size))),
      times(places.size() + 1) {
  std::iota(places.begin(), places.begin() + rates, 0);
  std::iota(places.begin() + rates, places.end(), offset);
  for (std::size_t i = 0; i < places.size(); ++i) directions[i][static_cast<std::size_t>(places[i])] = 1;
  times.back() = 1;
}

void UnitDirections::put(double* J, double* dfdt) const {
  const auto size = columns[0].size();
  std::fill_n(J, size * size, 0.0);
  for (std::size_t i = 0; i < places.size(); ++i)
    std::ranges::copy(columns[i], J + static_cast<std::size_t>(places[i]) * size);
  std::ranges::copy(columns.back(), dfdt);
}

}  // namespace freeplay
