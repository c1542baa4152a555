// Options of a run ([run]) and of the two formulations ([penalty], [nonsmooth]).
//
// Each options struct states its defaults, units, meanings and ranges in keys() (keys.hpp). Each
// enumeration has one table here that maps its values to the words of a scene file. The contact and
// friction laws are the exception: each is a file of formulations/contact, and mechanism/laws.hpp
// lists them.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

#include "mechanism/keys.hpp"
#include "mechanism/laws.hpp"
#include "values/enumerators.hpp"

namespace freeplay {

struct OwnLaw;  // mechanism/outside.hpp

/// A key that is read only under some choices of other keys. The reader refuses the key under any
/// other choice, the canonical text of a scene omits it there, and docs/reference/scene.md names
/// the choices. All three use the rows of own_keys().
template <class Options>
struct OwnKey {
  /// the key
  std::string_view name;
  /// Whether the current choices read the key.
  bool (*read)(const Options&, std::string_view name);
  std::string_view by;                         ///< the key that chooses
  std::string_view (*chosen)(const Options&);  ///< the word now chosen for that key
  std::string_view belongs;                    ///< the choices that read it
  std::array<std::string_view, 2> also = {};   ///< further keys that take part in the choice
};

/// The row of a key. Every options struct whose keys() calls k.own() has a function
/// own_keys(options) beside it.
template <class Options>
constexpr const OwnKey<Options>& own_key(const Options& o, std::string_view name) {
  for (const auto& row : own_keys(o))
    if (row.name == name) return row;
  throw std::logic_error("own_keys() lacks a key");
}

/// Options of a run, [run].
struct RunOptions {
  /// Treatment of the initial positions and velocities.
  enum class Start {
    assembled,   ///< rough positions are made consistent; journals start inside their bearings
    ideal,       ///< positions and velocities of the ideal joints: journals are concentric
    given,       ///< positions and velocities as stated; refused if they are inconsistent
    equilibrium  ///< at rest in the equilibrium that a descent from the rough positions reaches
  };
  double duration = 0;  ///< s, > 0
  double discard = 0;   ///< s, excluded from the statistics, 0 ≤ discard < duration
  /// treatment of the initial positions and velocities
  Start start = Start::assembled;
  bool eliminate = true;  ///< eliminate coordinates that one constraint row alone fixes
  bool forces = false;    ///< write forces.csv beside trajectory.csv
  /// s between rows of trajectory.csv; default duration/20000
  std::optional<double> output_step = {};

  static constexpr std::string_view what = "[run]";
  static void keys(auto& k, auto& o) {
    k.length({"revolutions", "", "length of the run in revolutions of the driven joint; or duration"},
             {"duration", "s", "length of the run; or revolutions"}, o.duration);
    k.part_of_length(
        {"discard", "as the length",
         "initial part of the run excluded from statistics, in revolutions (with `duration` in s)", "0"},
        o.discard);
    k.check(o.discard < o.duration, "discard", "must be less than the length of the run");
    k.choose({"start", "", ""}, o.start);
    k.take({"eliminate", "",
            "eliminates coordinates that are fixed by a single constraint row; false keeps the full DAE"},
           o.eliminate);
    k.take(
        {"forces", "", "write forces.csv: reactions, contact forces, drive torques, loads and accelerations"},
        o.forces);
    k.take({"output_step", "s", "spacing of the rows of trajectory.csv and forces.csv", "duration/20000"},
           o.output_step, positive);
    k.check(!o.output_step || *o.output_step >= 1e-8 * o.duration, "output_step", "must be at least ",
            1e-8 * o.duration, " s: a hundred million rows of trajectory.csv");
  }
};

/// One enumerator a law, in the order in which `freeplay laws` lists them. The facts of a law are
/// in its own file, formulations/contact/laws/NAME.hpp.
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
  pereira,
  gharib_hurmuzlu,
  elastic_foundation
};
/// The facts of each friction law are in formulations/contact/friction/NAME.hpp.
enum class FrictionLaw { ambrosio, threlfall, bengisu_akay, lugre, brown_mcphee, andersson, mindlin };
/// Integrator of the penalty formulation.
enum class Integrator { rk4, dopri5, bulirsch_stoer, adams_bashforth_moulton, rosenbrock4 };

/// Properties of an integrator.
template <>
struct Traits<Integrator> {
  bool adaptive = true;  ///< reads penalty.tolerance; the others read penalty.step
  /// Uses earlier steps: the state must not be changed between two steps.
  bool keeps_history = false;
};

/// Stabilisation of the constraints of the penalty formulation.
enum class Stabilisation {
  none,
  baumgarte,
  /// After each accepted step, least mass-weighted change onto Φ = 0, then G v + Φ_t = 0.
  projection
};

/// Options of the penalty formulation, [penalty].
struct PenaltyOptions {
  /// law of the normal force
  ContactLaw contact = ContactLaw::exact;
  /// A contact law supplied in code, which replaces `contact`; it has no key.
  std::shared_ptr<const OwnLaw> own = {};
  /// The point law whose damping factor χ(e) a line contact uses; hertz means none. Default: the
  /// line law's own, or exact.
  std::optional<ContactLaw> damping = {};
  std::optional<double> kelvin_stiffness = {};  ///< N/m
  std::optional<double> kelvin_damping = {};    ///< N s/m
  /// law of the friction force
  FrictionLaw friction = FrictionLaw::ambrosio;
  double friction_v0 = 1e-4;  ///< m/s, regularisation speed of friction laws
  /// m/s, > friction_v0: speed of full friction (Ambrósio), Stribeck speed (Andersson)
  double friction_v1 = 1e-3;
  double friction_static = 1;   ///< μ_s/μ ≥ 1 (Bengisu–Akay, LuGre, Brown–McPhee, Andersson)
  double friction_decay = 1e3;  ///< s/m, ξ of the Bengisu–Akay law
  /// s/m: adds F_N·friction_viscous·v_T (LuGre's σ₂, Brown–McPhee, Andersson)
  double friction_viscous = 0;
  double bristle_stiffness = 1e5;  ///< 1/m, LuGre's σ₀ divided by F_N
  double bristle_damping = 10;     ///< s/m, LuGre's σ₁ divided by F_N
  /// stabilisation of the constraints
  Stabilisation stabilisation = Stabilisation::baumgarte;
  double alpha = 5;  ///< 1/s: G a = γ − 2αΦ̇ − β²Φ
  double beta = 5;   ///< 1/s
  /// integrator
  Integrator integrator = Integrator::adams_bashforth_moulton;
  /// Accept a step if every |error_i| ≤ tolerance·scale_i (see tolerance.hpp).
  double tolerance = 1e-9;
  double step = 1e-6;  ///< s, step of the fixed-step integrator
  /// m/s, least v₀ at contact onset; default: see tolerance.hpp
  std::optional<double> v0_floor = {};

  static constexpr std::string_view what = "[penalty]";
  static void keys(auto& k, auto& o) {
    k.choose_listed({"contact", "", "contact law; `freeplay laws` lists all"}, o.contact);
    if (k.own("damping", o))
      k.choose_some(
          {"damping", "",
           "point law for the damping factor of line contacts, \"hertz\" for none; pereira has its own",
           "\"exact\""},
          o.damping, [](ContactLaw law) { return facts_of(law).kind == ContactKind::point; });
    if (k.own("kelvin_stiffness", o)) k.take({"kelvin_stiffness", "N/m", "K"}, o.kelvin_stiffness, positive);
    if (k.own("kelvin_damping", o)) k.take({"kelvin_damping", "N s/m", "D"}, o.kelvin_damping, non_negative);
    k.choose({"friction", "", ""}, o.friction);
    const auto& friction = facts_of(o.friction);
    const auto of_friction = [&](const Key& key, auto& x, const Range& range) {
      if (k.own(key.name, o)) k.take(key, x, range);
    };
    of_friction({"friction_v0", "m/s",
                 "sliding speed that regularises friction: zero friction below it (Ambrósio), v₀ (Threlfall, "
                 "Bengisu–Akay), Stribeck's (LuGre), v_t (Brown–McPhee)"},
                o.friction_v0, friction.positive_v0 ? positive : non_negative);
    of_friction({"friction_v1", "m/s",
                 "Ambrósio: full friction above this sliding speed; Andersson: Stribeck's speed"},
                o.friction_v1, positive);
    of_friction({"friction_static", "",
                 "Bengisu–Akay, LuGre, Brown–McPhee, Andersson: static over kinetic friction, ≥ 1"},
                o.friction_static, one_or_more);
    of_friction({"friction_decay", "s/m", "Bengisu–Akay: ξ, decay from static to kinetic friction"},
                o.friction_decay, non_negative);
    of_friction(
        {"friction_viscous", "s/m", "LuGre, Brown–McPhee, Andersson: viscous friction over the normal force"},
        o.friction_viscous, non_negative);
    of_friction({"bristle_stiffness", "1/m", "LuGre: σ₀ over the normal force"}, o.bristle_stiffness,
                positive);
    of_friction({"bristle_damping", "s/m", "LuGre: σ₁ over the normal force"}, o.bristle_damping,
                non_negative);
    k.check(!friction.v1_above_v0 || o.friction_v1 > o.friction_v0, "friction_v1",
            "must be greater than friction_v0 = ", o.friction_v0, ", is ", o.friction_v1);
    k.choose({"stabilisation", "", ""}, o.stabilisation);
    if (k.own("alpha", o)) k.take({"alpha", "1/s", "damping, ≥ 0"}, o.alpha, non_negative);
    if (k.own("beta", o)) k.take({"beta", "1/s", "frequency, ≥ 0"}, o.beta, non_negative);
    k.choose({"integrator", "", ""}, o.integrator);
    k.check(!(choice_of(o.integrator).traits.keeps_history && o.stabilisation == Stabilisation::projection),
            "stabilisation",
            "\"projection\" changes the state after each step and needs a one-step integrator; use "
            "\"baumgarte\" with multistep integrators");
    k.take({"tolerance", "",
            "adaptive integrators: a step is accepted when every absolute error is below tolerance × scale"},
           o.tolerance, positive);
    if (k.own("step", o)) k.take({"step", "s", "of the fixed-step integrator"}, o.step, positive);
    k.take({"v0_floor", "m/s", "least approach speed for the scaling of contact damping", "see penalty.md"},
           o.v0_floor, positive);
  }
};

/// Integration scheme of the nonsmooth formulation.
enum class Scheme { automatic, moreau_jean, event_driven };

/// Properties of a scheme.
template <>
struct Traits<Scheme> {
  bool adaptive = false;  ///< reads nonsmooth.tolerance; the others read nonsmooth.step
};

/// Solver of the contact problem. Automatic: closed form for one contact, enumeration for two,
/// Lemke up to ContactProblem::most_for_lemke contacts, Gauss–Seidel for more. If a solver fails,
/// the others are tried.
enum class LcpSolver { automatic, enumeration, lemke, gauss_seidel, newton };
/// Restitution as a ratio of velocities (Newton), of impulses (Poisson) or of the work of the
/// normal impulse (Stronge), or contacts of springs with slip (compliant).
enum class ImpactLaw { newton, poisson, energetic, compliant };

/// Properties of an impact law.
template <>
struct Traits<ImpactLaw> {
  /// Whether the impulse of a time step, which sums impacts and lasting contact, can satisfy it.
  bool time_stepping = false;
};

/// Options of the nonsmooth formulation, [nonsmooth].
struct NonsmoothOptions {
  /// Default: Moreau–Jean if `step` is a number, else automatic.
  std::optional<Scheme> scheme = {};
  /// s, of Moreau–Jean; empty means "automatic": chosen by step_tolerance
  std::optional<double> step = {};
  /// Tolerance of automatically chosen time steps, with the meaning of `tolerance`.
  double step_tolerance = 1e-6;
  /// Tolerance of the event-driven scheme's integrator, with the meaning of penalty.tolerance.
  double tolerance = 1e-10;
  /// solver of the contact problem
  LcpSolver solver = LcpSolver::automatic;
  double lcp_tolerance = 1e-10;  ///< accept a solve if its relative residual is smaller
  /// meaning of the restitution
  ImpactLaw impact_law = ImpactLaw::newton;

  /// The scheme that a run uses.
  constexpr Scheme scheme_in_force() const {
    return scheme.value_or(step ? Scheme::moreau_jean : Scheme::automatic);
  }
  /// Whether the scheme takes time steps whose size step_tolerance determines.
  constexpr bool chooses_steps() const;

  static constexpr std::string_view what = "[nonsmooth]";
  static void keys(auto& k, auto& o) {
    k.choose({"scheme", "", "", "automatic, or moreau-jean where `step` is a number"}, o.scheme);
    if (k.own("step", o))
      k.number_or("automatic", {"step", "s", "time step; \"automatic\": chosen by an estimate of the error"},
                  o.step, positive);
    if (k.own("step_tolerance", o))
      k.take({"step_tolerance", "",
              "an adaptive time step is accepted when every absolute error is below step_tolerance × scale"},
             o.step_tolerance, positive);
    if (k.own("tolerance", o))
      k.take({"tolerance", "",
              "a step between events is accepted when every absolute error is below tolerance × scale"},
             o.tolerance, positive);
    k.choose({"solver", "", "of the contact problem; others are tried after a failure: "}, o.solver);
    k.take({"lcp_tolerance", "", "a complementarity solve is accepted when its relative residual is below"},
           o.lcp_tolerance, positive);
    k.choose({"impact_law", "", "hypothesis of restitution; time stepping has only the first: "},
             o.impact_law);
    k.check(
        o.scheme_in_force() != Scheme::moreau_jean || choice_of(o.impact_law).traits.time_stepping,
        "impact_law",
        "time stepping needs \"newton\": with the other laws a resting contact would rebound; use scheme = "
        "\"event-driven\"");
  }
};

/// @name Words of the enumerations
///@{
inline constexpr auto start_names = complete<RunOptions::Start>(
    {{RunOptions::Start::assembled, "assembled",
      "stated positions and velocities are kept, and the constraints determine absent "
      "ones"},
     {RunOptions::Start::ideal, "ideal", "the ideal joints' configuration and velocities"},
     {RunOptions::Start::given, "given", "as given"},
     {RunOptions::Start::equilibrium, "equilibrium", "at rest where the forces balance"}});
inline constexpr auto integrator_names = complete<Integrator>(
    {{Integrator::rk4, "rk4", "fixed step; the others are adaptive", {.adaptive = false}},
     {Integrator::dopri5, "dopri5"},
     {Integrator::bulirsch_stoer, "bulirsch_stoer"},
     {Integrator::adams_bashforth_moulton, "adams_bashforth_moulton", "multistep", {.keeps_history = true}},
     {Integrator::rosenbrock4, "rosenbrock4", "implicit, for stiff scenes"}});
inline constexpr auto stabilisation_names =
    complete<Stabilisation>({{Stabilisation::none, "none"},
                             {Stabilisation::baumgarte, "baumgarte"},
                             {Stabilisation::projection, "projection", "after each accepted step"}});
inline constexpr auto scheme_names =
    complete<Scheme>({{Scheme::automatic,
                       "automatic",
                       "event-driven, with time stepping where events accumulate",
                       {.adaptive = true}},
                      {Scheme::moreau_jean, "moreau-jean", "time stepping"},
                      {Scheme::event_driven,
                       "event-driven",
                       "impacts and changes of contact mode located individually",
                       {.adaptive = true}}});
inline constexpr auto solver_names = complete<LcpSolver>(
    {{LcpSolver::automatic, "automatic",
      "closed form for one contact, enumeration for two, Lemke for more, Gauss-Seidel for many"},
     {LcpSolver::enumeration, "enumeration"},
     {LcpSolver::lemke, "lemke"},
     {LcpSolver::gauss_seidel, "gauss-seidel"},
     {LcpSolver::newton, "newton"}});
inline constexpr auto impact_law_names =
    complete<ImpactLaw>({{ImpactLaw::newton, "newton", "rates", {.time_stepping = true}},
                         {ImpactLaw::poisson, "poisson", "impulses"},
                         {ImpactLaw::energetic, "energetic", "work, Stronge"},
                         {ImpactLaw::compliant, "compliant", "springs with slip, Maw, Barber and Fawcett"}});
constexpr std::span<const Choice<RunOptions::Start>> choices(RunOptions::Start) { return start_names; }
std::span<const Choice<ContactLaw>> choices(ContactLaw);
std::span<const Choice<FrictionLaw>> choices(FrictionLaw);
constexpr std::span<const Choice<Integrator>> choices(Integrator) { return integrator_names; }
/// Fehlberg's 7(8) pair is not offered. It estimates its error by k₁ + k₁₁ − k₁₂ − k₁₃, two stages
/// at each end of the step. For a force that depends on time alone this estimate is 0 whatever the
/// error (Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, II.5).
inline constexpr RemovedWord removed_integrators[] = {
    {"fehlberg78",
     "its error estimate vanishes for forces that depend on time only; use \"bulirsch_stoer\", also of "
     "high order"}};
constexpr std::span<const RemovedWord> removed_words(Integrator) { return removed_integrators; }
constexpr std::span<const Choice<Stabilisation>> choices(Stabilisation) { return stabilisation_names; }
constexpr std::span<const Choice<Scheme>> choices(Scheme) { return scheme_names; }
constexpr std::span<const Choice<LcpSolver>> choices(LcpSolver) { return solver_names; }
constexpr std::span<const Choice<ImpactLaw>> choices(ImpactLaw) { return impact_law_names; }
///@}

constexpr bool NonsmoothOptions::chooses_steps() const {
  const auto in_force = scheme_in_force();
  return (in_force == Scheme::moreau_jean && !step) ||
         (in_force == Scheme::automatic && choice_of(impact_law).traits.time_stepping);
}

/// @name Keys that are read only under some choices
///@{
inline constexpr std::array penalty_own_keys = [] {
  using O = PenaltyOptions;
  using Row = OwnKey<O>;
  constexpr auto contact = [](const O& o) { return facts_of(o.contact).text; };
  constexpr auto line = [](const O& o, std::string_view) {
    return facts_of(o.contact).kind == ContactKind::line;
  };
  constexpr auto kelvin = [](const O& o, std::string_view) {
    return facts_of(o.contact).kind == ContactKind::spring_damper;
  };
  constexpr auto friction = [](const O& o) { return facts_of(o.friction).text; };
  constexpr auto of_law = [](const O& o, std::string_view key) { return facts_of(o.friction).reads(key); };
  constexpr auto stabilisation = [](const O& o) { return text_of(o.stabilisation); };
  constexpr auto baumgarte = [](const O& o, std::string_view) {
    return o.stabilisation == Stabilisation::baumgarte;
  };
  constexpr auto integrator = [](const O& o) { return text_of(o.integrator); };
  constexpr auto fixed = [](const O& o, std::string_view) {
    return !choice_of(o.integrator).traits.adaptive;
  };
  constexpr std::string_view lines = "line contacts, johnson and below in `freeplay laws`",
                             laws = "friction laws that name it in `freeplay laws`";
  return std::array{Row{"damping", line, "contact", contact, lines},
                    Row{"kelvin_stiffness", kelvin, "contact", contact, "contact = \"kelvin-voigt\""},
                    Row{"kelvin_damping", kelvin, "contact", contact, "contact = \"kelvin-voigt\""},
                    Row{"friction_v0", of_law, "friction", friction, laws},
                    Row{"friction_v1", of_law, "friction", friction, laws},
                    Row{"friction_static", of_law, "friction", friction, laws},
                    Row{"friction_decay", of_law, "friction", friction, laws},
                    Row{"friction_viscous", of_law, "friction", friction, laws},
                    Row{"bristle_stiffness", of_law, "friction", friction, laws},
                    Row{"bristle_damping", of_law, "friction", friction, laws},
                    Row{"alpha", baumgarte, "stabilisation", stabilisation, "stabilisation = \"baumgarte\""},
                    Row{"beta", baumgarte, "stabilisation", stabilisation, "stabilisation = \"baumgarte\""},
                    Row{"step", fixed, "integrator", integrator, "integrator = \"rk4\""}};
}();
inline constexpr std::array nonsmooth_own_keys = [] {
  using O = NonsmoothOptions;
  using Row = OwnKey<O>;
  constexpr auto scheme = [](const O& o) { return text_of(o.scheme_in_force()); };
  return std::array{
      // The automatic scheme chooses the steps of its time stepping. The word "automatic" is
      // therefore valid for it, a number is not.
      Row{"step",
          [](const O& o, std::string_view) {
            return o.scheme_in_force() == Scheme::moreau_jean ||
                   (o.scheme_in_force() == Scheme::automatic && !o.step);
          },
          "scheme", scheme, "scheme = \"moreau-jean\""},
      Row{"step_tolerance",
          [](const O& o, std::string_view) { return o.chooses_steps(); },
          "scheme",
          scheme,
          "scheme = \"automatic\" with impact_law \"newton\", and \"moreau-jean\" with step \"automatic\"",
          {"step", "impact_law"}},
      Row{"tolerance",
          [](const O& o, std::string_view) { return choice_of(o.scheme_in_force()).traits.adaptive; },
          "scheme", scheme, "scheme = \"automatic\" and \"event-driven\""}};
}();
constexpr std::span<const OwnKey<PenaltyOptions>> own_keys(const PenaltyOptions&) { return penalty_own_keys; }
constexpr std::span<const OwnKey<NonsmoothOptions>> own_keys(const NonsmoothOptions&) {
  return nonsmooth_own_keys;
}
///@}

/// The key that refines the steps of a run when its value is reduced, for use in messages.
constexpr std::string_view fineness_key(const PenaltyOptions& o) {
  return choice_of(o.integrator).traits.adaptive ? "penalty.tolerance" : "penalty.step";
}
/// `stepped`: whether the automatic scheme has switched to time stepping.
constexpr std::string_view fineness_key(const NonsmoothOptions& o, bool stepped = false) {
  if (o.scheme_in_force() == Scheme::moreau_jean && o.step) return "nonsmooth.step";
  return o.chooses_steps() && (stepped || o.scheme_in_force() == Scheme::moreau_jean)
             ? "nonsmooth.step_tolerance"
             : "nonsmooth.tolerance";
}

}  // namespace freeplay
