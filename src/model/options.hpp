// What the author of a scene asks of a run and of each formulation, and the sensors that watch it. Options say
// their unit, their meaning and the inequality they stand in; docs/scene.md has the same list for users.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "model/mechanism.hpp"

namespace freeplay {

struct RunOptions {
  enum class Start {
    assembled,  ///< rough positions made consistent, journals inside their bearings
    ideal,      ///< the ideal joints' positions and velocities: journals concentric
    given       ///< positions and velocities as they stand; refused if they are not consistent
  };
  double duration = 0;  ///< s, > 0
  double discard = 0;   ///< s left out of the statistics, 0 ≤ discard < duration
  Start start = Start::assembled;
  bool eliminate = true;                   ///< coordinates that a row alone fixes leave the solves beforehand
  bool forces = false;                     ///< forces.csv beside trajectory.csv
  std::optional<double> output_step = {};  ///< s between rows of trajectory.csv; default duration/20000
};

/// Each has its file, formulations/laws/contact/NAME.hpp; what is known of it: contact_laws() in laws.hpp.
enum class ContactLaw {
  hertz,
  hunt_crossley,
  herbert_mcwhannell,
  lee_wang,
  lankarani_nikravesh,
  gonthier,
  zhiying_qishao,
  flores,
  hu_guo,
  carvalho_martins,
  exact,
  kelvin_voigt,
  johnson,
  esdu,
  radzimovsky,
  liu,
  persson,
  pereira
};
/// Likewise formulations/laws/friction/NAME.hpp and friction_laws().
enum class FrictionLaw { ambrosio, threlfall, bengisu_akay, lugre, brown_mcphee };
enum class Integrator { rk4, dopri5, fehlberg78, bulirsch_stoer, adams_bashforth_moulton, rosenbrock4 };

enum class Stabilisation {
  none,
  baumgarte,
  projection  ///< least mass-weighted movement onto Φ = 0, then onto G v + Φ_t = 0, after each accepted step
};

extern const std::vector<std::string> contact_law_names, friction_law_names;

struct PenaltyOptions {
  ContactLaw contact = ContactLaw::exact;
  std::optional<ContactLaw> damping =
      {};  ///< a point law's χ(e) for a line contact; hertz: none. Default exact
  std::optional<double> kelvin_stiffness = {};  ///< N/m
  std::optional<double> kelvin_damping = {};    ///< N s/m
  FrictionLaw friction = FrictionLaw::ambrosio;
  double friction_v0 = 1e-4;       ///< m/s: the speed that each friction law is regularised with
  double friction_v1 = 1e-3;       ///< m/s, Ambrósio: full friction above it; friction_v1 > friction_v0
  double friction_static = 1;      ///< μ_s/μ ≥ 1 (Bengisu–Akay, LuGre, Brown–McPhee)
  double friction_decay = 1e3;     ///< s/m, ξ of Bengisu–Akay
  double friction_viscous = 0;     ///< s/m: adds F_N·friction_viscous·v_T (LuGre's σ₂, Brown–McPhee)
  double bristle_stiffness = 1e5;  ///< 1/m, LuGre's σ₀ over F_N
  double bristle_damping = 10;     ///< s/m, LuGre's σ₁ over F_N
  Stabilisation stabilisation = Stabilisation::baumgarte;
  double alpha = 5;  ///< 1/s: G a = γ − 2αΦ̇ − β²Φ
  double beta = 5;   ///< 1/s
  Integrator integrator = Integrator::adams_bashforth_moulton;
  double tolerance =
      1e-9;            ///< a step is accepted when every |error_i| ≤ tolerance·scale_i (see tolerance.hpp)
  double step = 1e-6;  ///< s, of the fixed-step integrator
  std::optional<double> v0_floor = {};  ///< m/s: least v₀ a contact may start with; default see tolerance.hpp
};

enum class Scheme { moreau_jean, event_driven };
/// How the contact problem is solved; automatic: closed form for one contact, enumeration for two, Lemke up
/// to ContactProblem::most_for_lemke contacts, Gauss–Seidel beyond. The others take over when one fails.
enum class LcpSolver { automatic, enumeration, lemke, gauss_seidel, newton };
/// Restitution by rates (Newton), impulses (Poisson) or work of the normal impulse (Stronge).
enum class ImpactLaw { newton, poisson, energetic };

struct NonsmoothOptions {
  Scheme scheme = Scheme::moreau_jean;
  double step = 1e-5;        ///< s, of Moreau–Jean
  double tolerance = 1e-10;  ///< of the event-driven scheme's integrator, as penalty.tolerance
  LcpSolver solver = LcpSolver::automatic;
  double lcp_tolerance = 1e-10;  ///< a solve is accepted when its relative residual is below
  ImpactLaw impact_law = ImpactLaw::newton;
};

/// A sensor. What a field does not belong to, it is not read for.
struct Instrument {
  enum class Kind {
    accelerometer,  ///< m/s², of a body's centre of mass along an axis of the world, through a low-pass
    lvdt,           ///< m, position of a body's centre of mass along an axis of the world
    encoder,        ///< rad, angle of a joint
    load_cell,      ///< N, force of a joint on its second body along an axis of the world, through a low-pass
    torque          ///< N m, torque of a drive, through a low-pass
  };
  Kind kind = Kind::accelerometer;
  std::string name;
  int body = ground;
  std::array<int, 2> pair{ground, ground};  ///< encoder: the joint's bodies
  int joint = -1;                           ///< encoder and load cell: index of the joint
  std::string drive;                        ///< torque: name of the drive
  Vec2 axis{1, 0};                          ///< unit vector
  double bandwidth = 0;                     ///< Hz, −3 dB
  int order = 2;                            ///< of the Butterworth low-pass, 1 to 8
  double sampling = 0;                      ///< Hz
  std::optional<double> noise = {};         ///< standard deviation of a sample, in the channel's unit
  unsigned seed = 1;                        ///< of the noise
  std::optional<double> range = {};         ///< ± full scale; samples are clipped there
  std::optional<double> resolution = {};    ///< step of the samples, rounded down; an encoder's is 2π/counts
};

inline bool measures_force(Instrument::Kind kind) {
  return kind == Instrument::Kind::load_cell || kind == Instrument::Kind::torque;
}

}  // namespace freeplay
