// SystemTangent: derivatives of the equations of motion of a System along several directions of the state and
// of parameters of the mechanism at once. With the accelerations a, multipliers λ and contact forces held at
// their values at the state, they are those of
//
//     motion:    f − Gᵀλ − M a,   γ − G a,   ż,   powers of drives (Φ_t included), loads and dampers
//     contact:   W_N λ_N + W_T λ_T,   γ_N − W_N a,   γ_T − W_T a,   W_T v,   λ_T
//
// of contact modes, or for contact forces that depend on the state (penalty formulation)
//
//     motion:    likewise, and   G v + Φ_t,   Φ
//     contact:   W_N F_N + W_T F_T,   g,   W_N v,   W_T v
//
// with λ_T = λ_T0 − s μ λ_N: s = ±1 and λ_T0 = 0 of a sliding contact, s = 0 of a sticking one. The
// derivatives of a and of the multipliers follow from these residuals by the linear system that the state
// itself has (formulations/event_driven/event_jacobian.cpp).
//
// The System is evaluated once with a recording number (numerics/traced.hpp), and the recorded operations are
// differentiated (numerics/tangent_tape.hpp). Parameters appear as constants of the operations: their
// derivatives by a parameter are differences of fourth order between the traces of displaced systems, formed
// once. A parameter that changes the operations themselves is not covered.
//
// Usage:
//
//     auto tangent = SystemTangent::trace(system, near, parameters);   // null if an element cannot be traced
//     if (!tangent->begin(point)) ...                                  // use another way at this state
//     tangent->motion(directions, out);                                // for each block of directions
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dynamics/system.hpp"
#include "numerics/tangent_tape.hpp"
#include "values/state.hpp"

namespace freeplay {

class SystemTangent {
 public:
  using Block = TangentTape::Block;

  /// Systems with displaced values of a parameter, at difference_places · spacing beside its value
  /// (formulations/variation/differences.hpp); null for a direction that is none of a parameter.
  struct Parameter {
    std::array<const System*, 4> systems{};
    double spacing = 0;
  };
  enum class Use { modes, penalty };
  static std::unique_ptr<SystemTangent> trace(const System& system, const State& near,
                                              std::span<const Parameter> parameters, Use use = Use::modes);

  /// Whether derivatives with respect to a parameter are complete.
  bool covers(std::size_t parameter) const { return covered_[parameter]; }

  /// A state with its accelerations and multipliers, and the cosines and sines of the bodies' angles.
  struct Point {
    double t;
    const double *q, *v, *z, *a, *lambda, *cosine, *sine;
  };
  /// Forces of a contact in its mode.
  struct ContactForce {
    double normal, tangential;  ///< N; tangential: of a sticking contact, else 0
    double slip;
  };
  /// False if a comparison in the equations has another result than where they were traced.
  [[nodiscard]] bool begin(const Point& point);
  [[nodiscard]] bool begin(const Point& point, int contact, const ContactForce& force);

  /// A block of directions: of t (one entry), q, v and z.
  struct Directions {
    const Block *t, *q, *v, *z;
    /// The first parameter of the block; −1: the parameters are constant.
    int first_parameter;
  };
  /// Fills blocks with the entries from `offset` on of the directions from `first` on. Entries of a block
  /// without a direction are 0.
  static void gather(std::span<const std::vector<double>> directions, int first, int offset,
                     std::vector<Block>& blocks);
  enum Power { drive, load, damping, powers };
  struct MotionSlopes {
    std::vector<Block> force, side, flow, power;
    std::vector<Block> rate, place;  ///< of G v + Φ_t and Φ, for penalty
  };
  struct ContactSlopes {
    std::array<Block, 2> side;  ///< of the normal and of the tangential row
    Block slide, friction;      ///< of W_T v and λ_T
    Block gap, rate;            ///< of g and W_N v, for penalty
  };
  MotionSlopes make_slopes() const;
  /// At the state of begin().
  void motion(const Directions& d, MotionSlopes& out);
  /// Adds the forces to those of the motion.
  void contact(int k, const Directions& d, MotionSlopes& motion, ContactSlopes& out);

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
    of_contact,
    of_parameters,
    first_direction,
    along_t = first_direction,
    along_q,
    along_v,
    along_z,
    along_parameters,
    arrays
  };

 private:
  SystemTangent(const System& system, Use use) : system_(system), use_(use) {}
  using Inputs = std::array<const double*, first_direction>;
  using BlockInputs = std::array<const Block*, arrays - first_direction>;
  Inputs inputs(const Point& point) const;
  BlockInputs inputs(const Directions& d) const;
  void vary(const TracedObject& nominal, const State& sample, std::span<const Parameter> parameters);

  const System& system_;
  Use use_;
  TangentTape motion_;
  std::vector<TangentTape> contacts_;
  std::vector<bool> covered_;
  std::vector<int> index_;      // of each constant among those that vary, or −1
  std::vector<double> varied_;  // constants that vary
  /// Their derivatives for each block of parameters in turn, and a block of zeros.
  std::vector<std::vector<Block>> slopes_;
  std::vector<Block> constant_;
};

}  // namespace freeplay
