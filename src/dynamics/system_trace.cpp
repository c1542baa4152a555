// Traces a System (system_functions.hpp), and compares compiled functions with its templates.
#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "dynamics/planar.hpp"
#include "dynamics/system.hpp"
#include "dynamics/system_functions.hpp"
#include "numerics/saddle_point.hpp"

namespace freeplay {
namespace {

/// Coordinates that one constraint row alone holds at a constant value, at rest: their values.
std::vector<std::optional<double>> still_coordinates(const System& system, const State& at) {
  std::vector<std::optional<double>> still(static_cast<std::size_t>(system.n()));
  const auto& p = system.pattern();
  for (int k = 0; k < system.rows() - system.drive_rows(); ++k) {
    const int c = p.column[p.begin[k]];
    if (p.begin[k + 1] - p.begin[k] == 1 && at.v[c] == 0) still[c] = at.q[c];
  }
  return still;
}

/// A state near another one, so that no comparison at it is a tie: journals are not concentric and
/// nothing is at rest. Still coordinates stay.
State moved(const System& system, const State& from, const std::vector<std::optional<double>>& still,
            unsigned seed) {
  std::minstd_rand random(seed);
  std::uniform_real_distribution<double> around(-1, 1);
  State at = from;
  const double length = system.longest_arm() > 0 ? system.longest_arm() : 1;
  for (int c = 0; c < system.n(); ++c) {
    const double scale = system.is_angle(c) ? 1 : length, q = around(random), v = around(random);
    if (still[c]) continue;
    at.q[c] += 1e-3 * scale * q;
    at.v[c] += 0.1 * scale * v;
  }
  at.z.resize(static_cast<std::size_t>(system.states()));
  for (int k = 0; k < system.states(); ++k) at.z[k] += 1e-3 * system.state_scale(k) * around(random);
  return at;
}

class SystemTracer {
 public:
  SystemTracer(const System& system, const State& near)
      : system_(system),
        still_(still_coordinates(system, near)),
        at_(moved(system, near, still_, 1)),
        sample_(system.make_evaluation()) {
    system.place(at_.t, at_.q.data(), sample_);
  }

  void place(TracedObject& object) {
    Trace trace(object, "place");
    const auto t = trace.input(0, 0, at_.t);
    const auto q = coordinates(trace, 1, at_.q, true);
    auto e = fresh(trace);
    system_.place(t, q.data(), e);
    trace.outputs(0, cosine_ = e.cosine);
    trace.outputs(1, sine_ = e.sine);
    trace.outputs(2, e.phi);
    trace.outputs(3, e.phi_t);
    trace.outputs(4, G_ = e.G);
    for (std::size_t i = 0; i < G_.size(); ++i)
      fixed_.push_back(G_[i].node == trace.old(4, static_cast<int>(i)).node);
  }
  void rate(TracedObject& object) {
    Trace trace(object, "rate");
    const auto q = coordinates(trace, 0, at_.q, true), v = coordinates(trace, 1, at_.v, false);
    auto e = fresh(trace);
    orient(trace, 2, e);
    for (std::size_t k = 0; k < e.gamma.size(); ++k) e.gamma[k] = trace.old(0, static_cast<int>(k));
    system_.rate(q.data(), v.data(), e);
    trace.outputs(0, e.gamma);
  }
  void forces(TracedObject& object) {
    Trace trace(object, "forces");
    const auto t = trace.input(0, 0, at_.t);
    const auto q = coordinates(trace, 1, at_.q, true), v = coordinates(trace, 2, at_.v, false);
    const auto z = trace.inputs(3, at_.z);
    auto e = fresh(trace);
    orient(trace, 4, e);
    system_.forces(t, q.data(), v.data(), z.data(), e);
    trace.outputs(0, e.force);
    trace.output(1, 0, e.power.drive);
    trace.output(2, 0, e.power.load);
    trace.output(3, 0, e.power.damping);
  }
  /// `pattern` gets the columns of the rows, and the values of the spin row.
  void contact(TracedObject& object, int k, const std::string& name, ContactRow& pattern) {
    Trace trace(object, name);
    const auto& bodies = system_.contact_facts(k).bodies;
    const auto of_pair = [&](int c) {
      return planar::body_of(c) == bodies[0] || planar::body_of(c) == bodies[1];
    };
    const auto q = coordinates(trace, 0, at_.q, true, of_pair),
               v = coordinates(trace, 1, at_.v, false, of_pair);
    auto e = fresh(trace);
    orient(trace, 2, e);
    ContactRowOf<Traced> row;
    system_.contact(k, q.data(), v.data(), e, row);
    const auto put = [&](int array, const SparseRowOf<Traced>& from, SparseRow& to) {
      to.size = from.size;
      to.column = from.column;
      for (int i = 0; i < from.size; ++i) {
        to.value[i] = from.value[i].value;
        if (array >= 0)
          trace.output(array, i, from.value[i]);
        else
          (void)value_of(from.value[i]);
      }
    };
    trace.output(0, 0, row.gap);
    put(1, row.normal, pattern.normal);
    put(2, row.tangent, pattern.tangent);
    put(3, row.film, pattern.film);
    put(-1, row.spin, pattern.spin);
    trace.output(4, 0, row.gamma_n);
    trace.output(5, 0, row.gamma_t);
    if (row.film.size == 0) return;  // nobody reads these without a film
    trace.output(6, 0, row.gamma_film);
    trace.output(7, 0, row.turn);
  }
  /// Values of G at the sample, and whether they are constant.
  std::vector<double> G() const { return sample_.G; }
  std::vector<bool> fixed() const {
    auto fixed = fixed_;
    for (std::size_t i = 0; i < G_.size(); ++i)
      if (G_[i].is_constant()) fixed[i] = true;
    return fixed;
  }

 private:
  /// The inputs of an array. A still coordinate is its value, or its rate 0; a guard checks that.
  std::vector<Traced> coordinates(Trace& trace, int array, const std::vector<double>& values,
                                  bool positions) {
    return coordinates(trace, array, values, positions, [](int) { return true; });
  }
  std::vector<Traced> coordinates(Trace& trace, int array, const std::vector<double>& values, bool positions,
                                  auto takes) {
    auto list = trace.inputs(array, values);
    for (std::size_t c = 0; c < list.size(); ++c)
      if (still_[c] && takes(static_cast<int>(c))) {
        const Traced value(positions ? *still_[c] : 0);
        (void)(list[c] == value);
        list[c] = value;
      }
    return list;
  }
  /// An evaluation whose matrix entries are the old ones until they are set.
  EvaluationOf<Traced> fresh(Trace& trace) const {
    auto e = system_.make_evaluation<Traced>();
    const auto old = [&](int array, std::vector<Traced>& list) {
      for (std::size_t i = 0; i < list.size(); ++i) list[i] = trace.old(array, static_cast<int>(i));
    };
    old(3, e.phi_t);
    old(4, e.G);
    return e;
  }
  /// The bodies' orientations as inputs `array` and array + 1, or constants for still bodies.
  void orient(Trace& trace, int array, EvaluationOf<Traced>& e) const {
    for (std::size_t b = 0; b < e.cosine.size(); ++b) {
      const int at = static_cast<int>(b);
      e.cosine[b] = cosine_[b].is_constant() ? cosine_[b] : trace.input(array, at, sample_.cosine[b]);
      e.sine[b] = sine_[b].is_constant() ? sine_[b] : trace.input(array + 1, at, sample_.sine[b]);
    }
  }

  const System& system_;
  std::vector<std::optional<double>> still_;
  State at_;
  Evaluation sample_;
  std::vector<Traced> cosine_, sine_, G_;
  std::vector<bool> fixed_;
};

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

TracedSystem trace_system(const System& system, const State& near, RowFacts facts) {
  TracedSystem s;
  auto& object = s.object;
  s.eliminate = facts.eliminate;
  SystemTracer tracer(system, near);
  // Elements with kinks look up the piece at a value, which throws.
  if (!traced(s.untraced, "constraint rows", [&] { tracer.place(object); })) return s;
  s.place = true;
  s.rate = traced(s.untraced, "constraint rows", [&] { tracer.rate(object); });
  s.forces = traced(s.untraced, "drives and loads", [&] { tracer.forces(object); });
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
  return s;
}

SystemFunctions TracedSystem::functions(const CompiledFunction* table) const {
  SystemFunctions f;
  f.constants = object.constants();
  if (place) f.place = *table++;
  if (rate) f.rate = *table++;
  if (forces) f.forces = *table++;
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
  for (const auto* list : {&e.cosine, &e.sine, &e.phi, &e.phi_t, &e.G, &e.gamma, &e.force}) put(*list);
  put(std::array{e.power.drive, e.power.load, e.power.damping});
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

long differing_quantities(System& system, const SystemFunctions& functions, const State& near,
                          RowFacts facts) {
  const auto still = still_coordinates(system, near);
  long differing = 0;
  for (unsigned seed = 0; seed < 5; ++seed) {
    auto at = seed == 0 ? near : moved(system, near, still, seed);
    at.z.resize(static_cast<std::size_t>(system.states()));  // a given start may leave them out
    SaddlePoint general(system.mass(), system.pattern(), SolvePath::automatic, facts);
    system.attach({});
    const auto expected = quantities(system, at, general);
    system.attach(functions);
    SaddlePoint fast(system.mass(), system.pattern(), SolvePath::automatic, facts);
    fast.use(system.solve_functions());
    const auto found = quantities(system, at, fast);
    if (found.size() != expected.size()) ++differing;
    for (std::size_t i = 0; i < found.size() && i < expected.size(); ++i)
      if (!(found[i] == expected[i] || (std::isnan(found[i]) && std::isnan(expected[i])))) ++differing;
  }
  system.attach({});
  return differing;
}

}  // namespace freeplay
