// SystemTangent: derivatives of the equations of motion of a System along several directions of the state and
// of parameters of the mechanism at once. With the accelerations a, multipliers λ and the forces of contacts,
// films and joint friction held at their values at the state, they are those of
//
//     motion:    f − Gᵀλ − M a,   γ − G a,   ż,   powers of drives (Φ_t included), loads and dampers
//     contact:   W_N λ_N + W_T λ_T + W_F λ_F + W_ω τ,   γ_N − W_N a,   γ_T − W_T a,   W_T v,   λ_T
//     friction:  W λ,   γ − W a,   W v
//
// of contact modes, or for contact forces that depend on the state (penalty formulation)
//
//     motion:    likewise, and   G v + Φ_t,   Φ
//     contact:   W_N F_N + W_T F_T + W_F F_F + W_ω τ,   g,   W_N v,   W_T v
//
// with λ_T = λ_T0 − s μ λ_N: s = ±1 and λ_T0 = 0 of a sliding contact, s = 0 of a sticking one; λ_F and τ are
// the tangential force and the couple of a film, for which also g, W_N v, W_F v and W_ω v are differentiated.
// The derivatives of a and of the multipliers follow from these residuals by the linear system that the state
// itself has (formulations/event_driven/event_jacobian.cpp).
//
// Each function is evaluated once with a recording number (numerics/traced.hpp), and the recorded operations
// are differentiated (numerics/tangent_tape.hpp). Where a comparison in it has another result, the function
// is traced again at that state, and both traces are kept. Their number is that of the branches of the
// equations that a run visits, at most `most_branches` of each function: few elements compare, because the
// pieces of tables and curves are operations.
//
// Parameters appear as constants of the operations: their derivatives by a parameter are differences of
// fourth order between the traces of displaced systems, formed once. A parameter is not covered if it changes
// the operations themselves or the numbers of a table, or if a function calls code that is not traced (unless a traced step
// refines its results).
//
// Usage:
//
//     SystemTangent tangent(system, SystemTangent::Use::modes, parameters);
//     tangent.begin(point);
//     tangent.motion(directions, out);                                 // for each block of directions
#pragma once

#include <array>
#include <memory>
#include <span>
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
  SystemTangent(const System& system, Use use, std::vector<Parameter> parameters = {});

  /// Whether derivatives with respect to a parameter are complete, in the functions that have begun.
  bool covers(std::size_t parameter) const { return covered_[parameter]; }

  /// A state with its accelerations and multipliers, the cosines and sines of the bodies' angles, and the
  /// pieces of all phases (null: tables are evaluated at the state).
  struct Point {
    double t;
    const double *q, *v, *z, *a, *lambda, *cosine, *sine;
    const Piece* pieces = nullptr;
  };
  /// Forces at a contact.
  struct ContactForce {
    double normal = 0;
    double tangential = 0;  ///< N, in a mode: friction besides that of slip with the surface's μ
    double slip = 0;
    double film_normal = 0, film = 0, torque = 0;  ///< N, N m, of a film along its rows
  };
  /// Traces all functions near a state, so that none is traced there later.
  void prepare(const State& near);
  /// @name Evaluates all numbers of a function at a state
  ///@{
  void begin(const Point& point);
  void begin_contact(const Point& point, int contact, const ContactForce& force);
  void begin_friction(const Point& point, int friction, double force);
  ///@}

  /// A block of directions: of t (one entry), q, v and z.
  struct Directions {
    const Block *t, *q, *v, *z;
    /// The first parameter of the block; −1: the parameters are constant.
    int first_parameter;
  };
  enum Power { drive, load, damping, powers };
  struct MotionSlopes {
    std::vector<Block> force, side, flow, power;
    std::vector<Block> rate, place;  ///< of G v + Φ_t and Φ, for penalty
  };
  struct ContactSlopes {
    std::array<Block, 2> side;  ///< of the normal and of the tangential row
    Block slide, friction;      ///< of W_T v and λ_T
    Block gap, rate;            ///< of g and W_N v, for penalty and films
    Block film, spin;           ///< of W_F v and W_ω v, for films
  };
  struct FrictionSlopes {
    Block side, slide;  ///< of γ − W a and W v
  };
  MotionSlopes make_slopes() const;
  /// @name Derivatives at the state of begin(). Forces of contacts and friction are added to those of the
  /// motion
  ///@{
  void motion(const Directions& d, MotionSlopes& out);
  void contact(int k, const Directions& d, MotionSlopes& motion, ContactSlopes& out);
  void friction(int k, const Directions& d, MotionSlopes& motion, FrictionSlopes& out);
  ///@}

 private:
  static constexpr std::size_t most_branches = 32;
  /// A function in one branch.
  struct Branch {
    TangentTape tape;
    bool in_pieces = false;
    std::vector<double> varied;  // constants that vary
    /// Their derivatives, for each block of parameters in turn.
    std::vector<std::vector<Block>> slopes;
  };
  struct Function {
    std::vector<std::unique_ptr<Branch>> branches;
    Branch* present = nullptr;
  };
  void begin(std::size_t function, const Point& point, const double* forces);
  std::unique_ptr<Branch> trace(std::size_t function, const Point& point);
  TracedObject record(const System& system, std::size_t function, const Point& point) const;
  std::vector<int> vary(Branch& branch, const TracedObject& nominal, std::size_t function,
                        const Point& point);
  void exclude(std::size_t parameter);
  void differentiate(std::size_t function, const Directions& d, Block* const* out);
  std::size_t contact_function(int k) const { return 1 + static_cast<std::size_t>(k); }
  std::size_t friction_function(int k) const { return contact_function(system_.contacts() + k); }

  const System& system_;
  Use use_;
  std::vector<Parameter> parameters_;
  std::vector<bool> covered_;
  std::vector<Function> functions_;  // the motion, contacts, joint friction
  std::vector<Block> constant_;      // zeros
};

/// Blocks of some of a list of directions, whose entries are the coordinates, their rates and, from an offset
/// on, the states of elements.
class DirectionBlocks {
 public:
  DirectionBlocks(const System& system, int state_offset);
  /// Those from `first` on; entries without a direction are 0. `times`: of t. Returns their number.
  int take(std::span<const std::vector<double>> directions, std::span<const double> times, int first);
  SystemTangent::Directions along(int first_parameter) const {
    return {&t_, q_.data(), v_.data(), z_.data(), first_parameter};
  }

 private:
  SystemTangent::Block t_;
  std::vector<SystemTangent::Block> q_, v_, z_;
  int state_offset_;
};

/// The directions of a Jacobian: unit vectors of the first `rates` components of a state and of `states` from
/// an offset on, then the unit of time.
struct UnitDirections {
  std::vector<int> places;
  std::vector<std::vector<double>> directions, columns;  ///< columns: derivatives along them
  std::vector<double> times;

  /// `further`: components of directions behind those of the state.
  UnitDirections(int rates, int offset, int states, int size, int further = 0);
  /// Writes the columns to J (column-major), whose other columns become 0, and to dfdt.
  void put(double* J, double* dfdt) const;
};

}  // namespace freeplay
