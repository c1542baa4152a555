// Compiled runs in tests: a cache of their own, and the comparison with general runs.
#pragma once

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "compile/compiled_object.hpp"
#include "dynamics/system_functions.hpp"
#include "facade/simulation.hpp"
#include "mechanism/scene.hpp"
#include "verification/support/support.hpp"
#include "verification/support/ways.hpp"

namespace freeplay::test {

/// An environment variable that has another value, or none, for the duration of a test.
class Environment {
 public:
  Environment(const char* name, const char* value) : name_(name) {
    const char* was = std::getenv(name);
    had_ = was != nullptr;
    if (had_) before_ = was;
    set(value);
  }
  ~Environment() { set(had_ ? before_.c_str() : nullptr); }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  void set(const char* value) const { value ? setenv(name_, value, 1) : unsetenv(name_); }
  const char* name_;
  bool had_ = false;
  std::string before_;
};

/// Compiled objects are kept in a folder of their own; with `none`, nothing can be compiled.
struct CompilerCache {
  explicit CompilerCache(bool none = false)
      : cache("XDG_CACHE_HOME", none ? "/dev/null" : folder.path().c_str()) {}
  std::filesystem::path place() const { return folder.path() / "freeplay"; }
  std::vector<std::filesystem::path> objects() const {
    std::vector<std::filesystem::path> list;
    for (const auto& entry : std::filesystem::directory_iterator(place())) list.push_back(entry.path());
    return list;
  }
  TemporaryFolder folder;
  Environment cache;
};

inline Result run_as(const Scene& scene, std::string_view formulation, Compile compile) {
  return Simulation(scene, formulation, {.compile = compile}).run();
}

/// The functions of a traced system, compiled.
inline SystemFunctions compiled(const TracedSystem& traced) {
  const auto object = compiled_object(traced.object.text(), traced.object.functions());
  REQUIRE(object.reason.empty());
  auto functions = traced.functions(object.table);
  functions.object = object.library;
  return functions;
}

/// The outputs of a compiled function of numbers; empty if a guard fails.
inline std::optional<std::vector<double>> call(CompiledFunction f, const TracedObject& object,
                                               const std::vector<double>& x, std::size_t outputs) {
  std::vector<double> found(outputs, NAN);
  std::vector<const double*> in;
  for (const double& one : x) in.push_back(&one);
  double* out[] = {found.data()};
  if (f(object.constants().data(), in.data(), out) != 0) return std::nullopt;
  return found;
}

/// Every quantity of the result of a run is bitwise identical.
inline void check_same_run(const Result& a, const Result& b) {
  CHECK(a.ending.status == b.ending.status);
  CHECK(a.final_state.t == b.final_state.t);
  CHECK(a.final_state.q == b.final_state.q);
  CHECK(a.final_state.v == b.final_state.v);
  const auto &l = a.ledger, &m = b.ledger;
  CHECK(std::vector{l.kinetic, l.potential, l.initial, l.drive, l.load, l.contact, l.friction, l.passed,
                    l.stabilisation} == std::vector{m.kinetic, m.potential, m.initial, m.drive, m.load,
                                                    m.contact, m.friction, m.passed, m.stabilisation});
  const auto &w = a.work, &x = b.work;
  CHECK(std::vector{w.steps, w.rhs, w.factorisations, w.lcp_solves, w.lcp_retries, w.pivots, w.events} ==
        std::vector{x.steps, x.rhs, x.factorisations, x.lcp_solves, x.lcp_retries, x.pivots, x.events});
  const auto &e = a.extremes, &f = b.extremes;
  CHECK(std::vector{e.constraint_length, e.constraint_angle, e.lcp_residual, e.lcp_residual_rate,
                    e.greatest_gain, e.greatest_kinetic} ==
        std::vector{f.constraint_length, f.constraint_angle, f.lcp_residual, f.lcp_residual_rate,
                    f.greatest_gain, f.greatest_kinetic});
  CHECK(e.shortest_flight == f.shortest_flight);
  CHECK(e.penetration == f.penetration);
  CHECK(a.notes == b.notes);
  REQUIRE(a.events.size() == b.events.size());
  for (std::size_t i = 0; i < a.events.size(); ++i) {
    const auto &p = a.events[i], &q = b.events[i];
    CHECK(p.kind == q.kind);
    CHECK(p.contact == q.contact);
    CHECK(std::vector{p.t, p.crank_angle, p.v_n_minus, p.v_n_plus, p.v_t_minus, p.v_t_plus, p.impulse_n,
                      p.impulse_t, p.duration} == std::vector{q.t, q.crank_angle, q.v_n_minus, q.v_n_plus,
                                                              q.v_t_minus, q.v_t_plus, q.impulse_n,
                                                              q.impulse_t, q.duration});
  }
}

/// A run with events that is compiled in all parts is bitwise identical to one without compiled functions. Returns it.
inline Result check_all_compiled(const Way& way, const std::string& text) {
  const auto scene = scene_by(way, text);
  auto found = run_as(scene, name_of(way.family), Compile::always);
  CHECK(found.compiled.used);
  CHECK(found.compiled.general_parts.empty());
  CHECK(found.ending.status == Ending::Status::finished);
  CHECK(found.events_seen > 0);
  check_same_run(found, run_as(scene, name_of(way.family), Compile::never));
  return found;
}

/// Runs cases/NAME.toml for a duration (s). Compiled functions refuse at most a share of the
/// evaluations of the motion, of fixed steps: of the steps.
inline Result check_compiled(const std::string& name, double duration, const Way& way, double refused,
                             const std::vector<std::string>& keys = {}) {
  CAPTURE(name, way.name, keys);
  auto options = keys;
  options.insert(options.end(), way.options.begin(), way.options.end());
  auto scene = read_short(source_folder() / "cases" / (name + ".toml"), duration, options);
  way.choose(scene);
  const auto formulation = name_of(way.family);
  const auto found = run_as(scene, formulation, Compile::always);
  CHECK(found.compiled.used);
  CHECK(found.compiled.reason.empty());
  CHECK(static_cast<double>(found.compiled.refused) <=
        refused * static_cast<double>(way.fixed() ? found.work.steps : found.work.rhs));
  const auto evaluated = run_as(scene, formulation, Compile::never);
  CHECK_FALSE(evaluated.compiled.used);
  check_same_run(found, evaluated);

  Simulation compiled(scene, formulation, {.compile = Compile::always}),
      general(scene, formulation, {.compile = Compile::never}),
      whole(scene, formulation, {.compile = Compile::never});
  compiled.run({.until = 0.5 * duration});
  general.restore(compiled.snapshot());
  general.run();
  whole.run({.until = 0.5 * duration});
  whole.run();
  CHECK(general.state().q == whole.state().q);
  CHECK(general.state().v == whole.state().v);
  return found;
}

}  // namespace freeplay::test
