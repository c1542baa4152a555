// Compiled functions of a System. Once CompiledSystem::attach() has set them, place(), rate(), forces() and
// contact() of double call them, and the saddle points of the formulations use `solve`. Each is
// bitwise identical to the templates; where a guard fails (a comparison has another result than at the
// sample, numerics/traced.hpp), the templates are evaluated.
//
//     place:    in t, q                          out cosine, sine, Φ, Φ_t, G, y″ of motions
//     rate:     in q, v, cosine, sine, y″        out γ
//     forces:   in t, q, v, z, cosine, sine      out f, powers
//         in pieces: also in ends of pieces      over a step: also in h, rates at its start, mean rates
//     contact:  in q, v, cosine, sine            out gap, γ's, entries of the rows
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "dynamics/evaluation.hpp"
#include "numerics/saddle_point.hpp"
#include "values/state.hpp"

namespace freeplay {

class System;

/// Functions of a right-hand side, which evaluate everything at one state (dynamics/motion_kernel.hpp).
///
///     motion:  in t, q, v, z
///              out cosine, sine, Φ, Φ_t, G, γ, f, powers, F, least pivot ratio of each block, G again,
///              a, λ, power of drives
///     state:   in t, q, v, z, (2α, β²)
///              out as before, but G v + Φ_t and γ − 2α (G v + Φ_t) − β² Φ in place of a and λ
///     slide:   in F, G, q, v, cosine, sine, a, λ, −s μ, power of drives, Φ_t
///              out gap, rows and γ's of a contact; a, λ with its force; mobility, λ_N, power of
///              drives, u_T
///
/// The slide is that of the only closed contact, or its contact without friction. The power of drives
/// has the reactions' part.
struct MotionFunctions {
  CompiledFunction motion = nullptr, state = nullptr;
  std::vector<CompiledFunction> slides;  ///< of each contact
};

/// The scheme for which larger functions are traced besides those of a System.
enum class TracedFor { any, fixed_steps, event_driven, penalty };

struct SystemFunctions {
  struct Contact {
    CompiledFunction function = nullptr;
    ContactRow pattern;  ///< sizes and columns of its rows
  };
  CompiledFunction place = nullptr, rate = nullptr, forces = nullptr;
  /// As Reading says; used if tables or curves depend on it.
  CompiledFunction place_in_pieces = nullptr, forces_in_pieces = nullptr, forces_over_step = nullptr;
  bool place_reads_pieces = false, reads_pieces = false, reads_steps = false;
  std::vector<Contact> contacts;  ///< one for each contact, or none
  SolveFunctions solve;
  std::vector<double> constants;
  std::shared_ptr<const void> object;  ///< keeps the functions loaded
  long refused = 0;                    ///< calls in which a guard failed
  MotionFunctions motion;
  /// Functions of time steps (formulations/time_stepping/lane_functions.hpp).
  std::vector<CompiledFunction> steps;
  /// Calls a function. Returns false if a guard failed.
  bool call(CompiledFunction function, const double* const* in, double* const* out) {
    if (function(constants.data(), in, out) == 0) return true;
    ++refused;
    return false;
  }
};

/// The traced functions of a System, before they are compiled.
struct TracedSystem {
  struct Contact {
    bool traced = false;
    ContactRow pattern;
  };
  TracedObject object;
  /// whether it is traced
  bool place = false, rate = false, forces = false, solves = false;
  bool place_in_pieces = false, forces_in_pieces = false, forces_over_step = false;
  /// Whether rows and forces depend on them (Reading).
  bool place_reads_pieces = false, reads_pieces = false, reads_steps = false;
  bool motion = false, state = false;
  int steps = 0;  ///< number of functions of time steps, which are the last ones; others append them
  /// Whether functions of another one may be called with the constants of this one.
  bool same_structure(const TracedSystem& o) const {
    return motion == o.motion && steps == o.steps && state == o.state && object.same_structure(o.object);
  }
  std::vector<Contact> contacts;
  int factors = 0;          ///< of the saddle point (SolveFunctions)
  std::vector<int> ratios;  ///< likewise
  bool eliminate = true;
  /// Parts that keep their templates, with the reasons.
  std::vector<std::string> untraced;

  /// The functions in the table of the compiled object.
  SystemFunctions functions(const CompiledFunction* table) const;
};

/// Traces a System near a state. Coordinates that one constraint row alone holds at a constant
/// value are constants, and guards check their values. `facts`: those of the saddle points.
/// `like`: that of a System that probably has the same structure, or null; it makes no difference but in
/// time.
TracedSystem trace_system(const System& system, const State& near, RowFacts facts,
                          TracedFor scheme = TracedFor::any, const TracedSystem* like = nullptr);

/// Number of entries that are not equal; NaN equals NaN. Lists of other sizes differ in one more.
long differing_numbers(const std::vector<double>& a, const std::vector<double>& b);

/// A state and others near it.
inline constexpr int states_compared = 5;
/// Number of quantities in which compiled functions and templates differ at the first `states` of
/// them; a sign of zero is no difference. Detaches all functions.
long differing_quantities(System& system, const SystemFunctions& functions, const State& near, RowFacts facts,
                          int states = states_compared);

}  // namespace freeplay
