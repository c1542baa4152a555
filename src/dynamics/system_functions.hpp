// Compiled functions of a System. Once System::attach() has set them, place(), rate(), forces() and
// contact() of double call them, and the saddle points of the formulations use `solve`. Each gives
// the digits of the templates; where a guard fails (a comparison has another result than at the
// sample, numerics/traced.hpp), the templates are evaluated.
//
//     place:    in t, q                          out cosine, sine, Φ, Φ_t, G
//     rate:     in q, v, cosine, sine            out γ
//     forces:   in t, q, v, z, cosine, sine      out f, powers
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

struct SystemFunctions {
  struct Contact {
    CompiledFunction function = nullptr;
    ContactRow pattern;  ///< sizes and columns of its rows
  };
  CompiledFunction place = nullptr, rate = nullptr, forces = nullptr;
  std::vector<Contact> contacts;  ///< one for each contact, or none
  SolveFunctions solve;
  std::vector<double> constants;
  std::shared_ptr<const void> object;  ///< keeps the functions loaded
  long refused = 0;                    ///< calls in which a guard failed
};

/// The traced functions of a System, before they are compiled.
struct TracedSystem {
  struct Contact {
    bool traced = false;
    ContactRow pattern;
  };
  TracedObject object;
  bool place = false, rate = false, forces = false, solves = false;  ///< whether it is traced
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
TracedSystem trace_system(const System& system, const State& near, RowFacts facts);

/// Number of quantities in which compiled functions and templates differ at a state and at four
/// others near it; a sign of zero is no difference. Detaches all functions.
long differing_quantities(System& system, const SystemFunctions& functions, const State& near,
                          RowFacts facts);

}  // namespace freeplay
