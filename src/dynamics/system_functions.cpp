#include "dynamics/system_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "dynamics/system.hpp"
#include "dynamics/system_tracer.hpp"

namespace freeplay {

// Traces a System (system_functions.hpp), and compares compiled functions with its templates.

std::vector<std::optional<double>> still_coordinates(const System& system, const State& at) {
  std::vector<std::optional<double>> still(static_cast<std::size_t>(system.n()));
  const auto& p = system.pattern();
  for (int k = 0; k < system.rows() - system.drive_rows(); ++k) {
    const int c = p.column[p.begin[k]];
    if (p.begin[k + 1] - p.begin[k] == 1 && at.v[c] == 0) still[c] = at.q[c];
  }
  return still;
}

State moved(const System& system, const State& from, const std::vector<std::optional<double>>& still,
            unsigned seed, double size) {
  std::minstd_rand random(seed);
  std::uniform_real_distribution<double> around(-1, 1);
  State at = from;
  const double length = system.size();
  for (int c = 0; c < system.n(); ++c) {
    const double scale = system.is_angle(c) ? 1 : length, q = around(random), v = around(random);
    if (still[c]) continue;
    at.q[c] += size * scale * q;
    at.v[c] += 0.1 * scale * v;
  }
  at.z.resize(static_cast<std::size_t>(system.states()));
  for (int k = 0; k < system.states(); ++k) at.z[k] += 1e-3 * system.state_scale(k) * around(random);
  return at;
}

namespace {

/// Runs f; without effect on the object if an element cannot be traced.
template <class F>
bool traced(std::vector<std::string>& untraced, const std::string& what, F f) {
  try {
    f();
    return true;
  } catch (const NotTraceable& e) {
    untraced.push_back(what + ": " + e.what());
    return false;
  }
}

}  // namespace

TracedSystem trace_system(const System& system, const State& near, RowFacts facts, TracedFor scheme,
                          const TracedSystem* like) {
  TracedSystem s;
  if (like) s.object = TracedObject(0, &like->object);
  auto& object = s.object;
  s.eliminate = facts.eliminate;
  SystemTracer tracer(system, near);
  // Elements with kinks look up the piece at a value, which throws.
  if (!traced(s.untraced, "constraint rows", [&] { tracer.place(object); })) return s;
  s.place = true;
  s.place_reads_pieces = system.has_motions() && system.phases() > 0;
  if (s.place_reads_pieces)
    s.place_in_pieces =
        traced(s.untraced, "constraint rows in pieces", [&] { tracer.place_in_pieces(object); });
  s.rate = traced(s.untraced, "constraint rows", [&] { tracer.rate(object); });
  using Reads = SystemTracer::Reads;
  const auto forces = [&](Reads reads) { return [&, reads] { tracer.forces(object, reads); }; };
  s.forces = traced(s.untraced, "drives and loads", forces(Reads::points));
  s.reads_pieces = system.phases() > 0;
  if (s.forces && s.reads_pieces)
    s.forces_in_pieces = traced(s.untraced, "drives and loads in pieces", forces(Reads::pieces));
  if (s.forces) {
    s.forces_over_step = traced(s.untraced, "drives and loads over steps", forces(Reads::steps));
    s.reads_steps = !s.forces_over_step || object.last_reads_from(6);
    if (!s.reads_steps) object.drop_last();
    s.forces_over_step = s.forces_over_step && s.reads_steps;
  }
  for (int k = 0; k < system.contacts(); ++k) {
    auto& contact = s.contacts.emplace_back();
    contact.traced = traced(s.untraced, system.contact_facts(k).name, [&] {
      tracer.contact(object, k, "contact_" + std::to_string(k), contact.pattern);
    });
  }
  if (facts.redundant) {
    s.untraced.emplace_back("linear system: constraint rows are dependent");
    return s;
  }
  const SaddlePoint saddle(system.mass(), system.pattern(), SolvePath::automatic, facts);
  traced(s.untraced, "linear system", [&] {
    s.solves = saddle.trace(object, tracer.G(), tracer.fixed(), s.factors, s.ratios);
    if (!s.solves) s.untraced.emplace_back("linear system: a block has too many rows");
  });
  if (!s.solves || !s.untraced.empty()) return s;
  // Forces of films and of joints with friction come between the state and the solution.
  if (scheme == TracedFor::event_driven && SystemTracer::motions(system))
    s.motion = traced(s.untraced, "right-hand sides", [&] { tracer.motion(object, saddle); });
  if (scheme == TracedFor::penalty && SystemTracer::points(system))
    s.state = traced(s.untraced, "right-hand sides", [&] { tracer.state(object, saddle); });
  return s;
}

SystemFunctions TracedSystem::functions(const CompiledFunction* table) const {
  SystemFunctions f;
  f.constants = object.constants();
  if (place) f.place = *table++;
  f.place_reads_pieces = place_reads_pieces;
  if (place_in_pieces) f.place_in_pieces = *table++;
  if (rate) f.rate = *table++;
  f.reads_pieces = reads_pieces;
  f.reads_steps = reads_steps;
  if (forces) f.forces = *table++;
  if (forces_in_pieces) f.forces_in_pieces = *table++;
  if (forces_over_step) f.forces_over_step = *table++;
  for (const auto& contact : contacts)
    f.contacts.push_back({contact.traced ? *table++ : nullptr, contact.pattern});
  if (solves) {
    f.solve.factor = *table++;
    f.solve.solve = *table++;
    f.solve.respond = *table++;
    f.solve.eliminate = eliminate;
    f.solve.factors = factors;
    f.solve.ratios = ratios;
  }
  if (motion) {
    f.motion.motion = *table++;
    for (std::size_t k = 0; k < contacts.size(); ++k) f.motion.slides.push_back(*table++);
  }
  if (state) f.motion.state = *table++;
  f.steps.assign(table, table + steps);
  return f;
}

namespace {

/// All quantities of a System at one state, in one order.
std::vector<double> quantities(const System& system, const State& at, SaddlePoint& saddle) {
  std::vector<double> all;
  const auto put = [&](const auto& list) { all.insert(all.end(), list.begin(), list.end()); };
  const double *q = at.q.data(), *v = at.v.data();
  auto e = system.make_evaluation();
  system.place(at.t, q, e);
  system.rate(q, v, e);
  system.forces(at.t, q, v, at.z.data(), e);
  for (const auto* list : {&e.cosine, &e.sine, &e.phi, &e.phi_t, &e.G, &e.gamma, &e.bend}) put(*list);
  const auto put_forces = [&] {
    put(e.force);
    put(std::array{e.power.drive, e.power.load, e.power.damping});
  };
  put_forces();
  std::vector<Piece> pieces;
  for (int k = 0; k < system.phases(); ++k) {
    const auto& phase = system.phase(k);
    const double x = phase.at(q, v).value;
    pieces.push_back(phase.piece(x, true));
    // A stage may be beyond its piece.
    if (k == 0 && pieces[0].high < INFINITY) pieces[0] = phase.piece(pieces[0].high, true);
  }
  if (!pieces.empty()) {
    system.place(at.t, q, e, pieces.data());
    for (const auto* list : {&e.phi, &e.phi_t, &e.G, &e.bend}) put(*list);
    system.forces(at.t, q, v, at.z.data(), e, {nullptr, pieces.data()});
    put_forces();
  }
  system.place(at.t, q, e);
  {
    auto mean = at.v;
    for (double& x : mean) x *= 1.001;
    const Sweep sweep{1e-5, v, mean.data()};
    system.forces(at.t, q, v, at.z.data(), e, {&sweep});
    put_forces();
  }
  std::vector<double> a(e.force.size()), lambda(e.gamma.size());
  const bool regular = saddle.factor(e.G.data());
  const auto solution = [&] {
    put(a);
    put(lambda);
  };
  if (regular) {
    saddle.solve(e.force.data(), e.gamma.data(), a.data(), lambda.data());
    solution();
  }
  for (int k = 0; k < system.contacts(); ++k) {
    ContactRow row;
    system.contact(k, q, v, e, row);
    put(std::array{row.gap, row.gamma_n, row.gamma_t});
    if (row.film.size > 0) put(std::array{row.gamma_film, row.turn});
    for (const auto* x : {&row.normal, &row.tangent, &row.film, &row.spin})
      for (int i = 0; i < x->size; ++i) put(std::array{static_cast<double>(x->column[i]), x->value[i]});
    if (!regular || row.normal.size == 0) continue;
    saddle.respond(row.normal, row.tangent.size > 0 ? &row.tangent : nullptr, 0.1, a.data(), lambda.data());
    solution();
  }
  return all;
}

}  // namespace

long differing_numbers(const std::vector<double>& a, const std::vector<double>& b) {
  long differing = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size() && i < b.size(); ++i)
    if (!(a[i] == b[i] || (std::isnan(a[i]) && std::isnan(b[i])))) ++differing;
  return differing;
}

long differing_quantities(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                          int states) {
  const auto still = still_coordinates(system, near);
  long differing = 0;
  for (unsigned seed = 0; seed < static_cast<unsigned>(states); ++seed) {
    auto at = seed == 0 ? near : moved(system, near, still, seed);
    at.z.resize(static_cast<std::size_t>(system.states()));  // a given start may leave them out
    SaddlePoint general(system.mass(), system.pattern(), SolvePath::automatic, facts);
    system.compiled().attach({});
    const auto expected = quantities(system, at, general);
    system.compiled().attach(functions);
    SaddlePoint fast(system.mass(), system.pattern(), SolvePath::automatic, facts);
    fast.use(system.compiled().solve());
    const auto found = quantities(system, at, fast);
    differing += differing_numbers(found, expected);
  }
  system.compiled().attach({});
  return differing;
}

// Calls of the compiled functions of a System (system_functions.hpp).

CompiledSystem::CompiledSystem() : functions_(std::make_shared<SystemFunctions>()) {}

void CompiledSystem::attach(SystemFunctions functions) {
  *functions_ = std::move(functions);
  functions_->solve.constants = functions_->constants.data();
  any_ = functions_->object != nullptr;
  contacts_ = any_ && !functions_->contacts.empty();
}

const SolveFunctions* CompiledSystem::solve() const { return &functions_->solve; }

long CompiledSystem::refused() const { return functions_->refused; }

bool CompiledSystem::place(double t, const double* q, Evaluation& e) const {
  const auto* pieces = functions_->place_reads_pieces ? e.pieces : nullptr;
  const auto function = pieces ? functions_->place_in_pieces : functions_->place;
  if (!function) return false;
  const double* in[] = {&t, q, pieces ? &pieces->low : nullptr};
  double* out[] = {e.cosine.data(), e.sine.data(), e.phi.data(), e.phi_t.data(), e.G.data(), e.bend.data()};
  return functions_->call(function, in, out);
}

bool CompiledSystem::rate(const double* q, const double* v, Evaluation& e) const {
  if (!functions_->rate) return false;
  const double* in[] = {q, v, e.cosine.data(), e.sine.data(), e.bend.data()};
  double* out[] = {e.gamma.data()};
  return functions_->call(functions_->rate, in, out);
}

bool CompiledSystem::forces(double t, const double* q, const double* v, const double* z, int states,
                            Evaluation& e, const Reading& reading) const {
  static_assert(sizeof(Piece) == 2 * sizeof(double));
  const auto& f = *functions_;
  const auto* pieces = f.reads_pieces ? reading.pieces : nullptr;
  const auto* sweep = f.reads_steps ? reading.sweep : nullptr;
  const auto function = pieces ? f.forces_in_pieces : sweep ? f.forces_over_step : f.forces;
  if (!function || !v || (!z && states > 0)) return false;
  const double* in[] = {&t, q, v, z, e.cosine.data(), e.sine.data(), nullptr, nullptr, nullptr};
  if (pieces) {
    in[6] = &pieces->low;
  } else if (sweep) {
    in[6] = &sweep->h;
    in[7] = sweep->start;
    in[8] = sweep->mean;
  }
  double* out[] = {e.force.data(), &e.power.drive, &e.power.load, &e.power.damping};
  return functions_->call(function, in, out);
}

bool CompiledSystem::contact(int k, const double* q, const double* v, const Evaluation& e,
                             ContactRow& row) const {
  const auto& contact = functions_->contacts[static_cast<std::size_t>(k)];
  if (!contact.function) return false;
  const double* in[] = {q, v, e.cosine.data(), e.sine.data()};
  double* out[] = {&row.gap,
                   row.normal.value.data(),
                   row.tangent.value.data(),
                   row.film.value.data(),
                   &row.gamma_n,
                   &row.gamma_t,
                   &row.gamma_film,
                   &row.turn};
  if (!functions_->call(contact.function, in, out)) return false;
  const auto shape = [](SparseRow& to, const SparseRow& from) {
    to.size = from.size;
    to.column = from.column;
  };
  shape(row.normal, contact.pattern.normal);
  shape(row.tangent, contact.pattern.tangent);
  row.film.size = row.spin.size = 0;
  if (contact.pattern.film.size > 0) {
    shape(row.film, contact.pattern.film);
    row.spin = contact.pattern.spin;  // its values are constant
  }
  return true;
}

}  // namespace freeplay
