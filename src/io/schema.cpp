#include "io/schema.hpp"

#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

namespace freeplay {
namespace {

constexpr SchemaKey keys[] = {
    {"format", "number", "", "1",
     "format of the scene, a whole number; one that is stated keeps its meaning when defaults change; 1 is "
     "the "
     "newest"},
    {"title", "text", "", "\"\"", "what the scene is; stands in results and figures"},
    {"gravity", "point", "m/s²", "[0, 0]", "acceleration of gravity in the plane of motion"},

    {"bodies.*.mass", "number", "kg", "required", "mass, > 0"},
    {"bodies.*.inertia", "number", "kg m²", "required", "moment of inertia about the centre of mass, > 0"},
    {"bodies.*.position", "point", "m", "[0, 0]", "centre of mass at the start; may be rough"},
    {"bodies.*.angle", "number", "rad", "0", "angle at the start; may be rough"},
    {"bodies.*.velocity", "point", "m/s", "[0, 0]",
     "velocity of the centre of mass at the start; may be rough"},
    {"bodies.*.angular_velocity", "number", "rad/s", "0", "angular velocity at the start; may be rough"},

    {"joints.*.type", "text", "", "required", "\"revolute\", \"translational\" or \"rigid\""},
    {"joints.*.between", "names", "", "required", "two bodies, or \"ground\" and a body"},
    {"joints.*.at", "points", "m", "[[0, 0], [0, 0]]",
     "the joint's point in each body's frame, from its centre of mass; ground: world"},
    {"joints.*.axis", "point", "", "[1, 0]", "translational: direction of sliding in the first body's frame"},
    {"joints.*.angle", "number", "rad", "0",
     "translational, rigid: angle of the second body less that of the first"},
    {"joints.*.clearance", "number", "m", "–",
     "revolute: radial clearance, bearing radius less journal radius; translational: half the play between a "
     "rectangular slider and its walls; left out: ideal"},
    {"joints.*.bearing_radius", "number", "m", "–",
     "revolute with clearance: radius of the bearing, on the first body; the journal is on the second"},
    {"joints.*.bearing_length", "number", "m", "–",
     "revolute with clearance: length of the bearing; line-contact laws need it"},
    {"joints.*.slider_length", "number", "m", "–", "translational with clearance: the slider along the axis"},
    {"joints.*.slider_height", "number", "m", "–",
     "translational with clearance: the slider across the axis"},
    {"joints.*.corner_radius", "number", "m", "–",
     "translational with clearance: rounding of the slider's corners, for the stiffness of penalty contacts"},
    {"joints.*.surface", "text", "", "–", "joints with clearance: the surface of its contacts"},

    {"joints.*.lubricant", "text", "", "–", "revolute with clearance: what fills it; left out: dry"},

    {"contacts.*.type", "text", "", "required", "\"plane\" or \"discs\""},
    {"contacts.*.between", "names", "", "required",
     "two bodies, or \"ground\" and a body; a plane is on the first"},
    {"contacts.*.at", "points", "m", "[[0, 0], [0, 0]]",
     "plane: a point of the wall, and the centre of the disc; discs: their centres"},
    {"contacts.*.axis", "point", "", "[1, 0]",
     "plane: direction of the wall in the first body's frame; free space lies on its left"},
    {"contacts.*.radius", "number", "m", "0", "plane: radius of the disc; 0: a point"},
    {"contacts.*.radii", "point", "m", "required", "discs: both radii; they touch from outside"},
    {"contacts.*.surface", "text", "", "required", "the surface of the contact"},

    {"lubricants.*.viscosity", "number", "Pa s", "required", "dynamic viscosity, > 0"},
    {"lubricants.*.film", "text", "", "\"short\"",
     "\"short\" (Ocvirk) or \"long\" (Sommerfeld) journal bearing"},
    {"lubricants.*.cavitation", "text", "", "\"half-sommerfeld\"",
     "\"half-sommerfeld\": no tension in the film; \"none\": full film"},
    {"lubricants.*.hand_over", "number", "m", "clearance/100",
     "film thickness below which the film fades out and dry contact takes over"},

    {"surfaces.*.young", "number", "Pa", "–", "Young's modulus, > 0; the penalty formulation needs it"},
    {"surfaces.*.poisson", "number", "", "–", "Poisson's ratio, 0 to 0.5; goes with young"},
    {"surfaces.*.restitution", "number", "", "–", "coefficient of restitution asked for, 0 to 1"},
    {"surfaces.*.friction", "number", "", "–", "Coulomb's coefficient, ≥ 0; left out: frictionless"},
    {"surfaces.*.tangential_restitution", "number", "", "0",
     "e_T of impact laws, 0 to 1: Coulomb's law acts on v_T⁺ + e_T v_T⁻"},

    {"drives.*.joint", "text", "", "required", "the revolute joint that is driven (translational: none yet)"},
    {"drives.*.speed_rpm", "number", "rpm", "–", "prescribed speed of the second body relative to the first"},
    {"drives.*.speed", "number", "rad/s", "–", "the same in rad/s; or speed_rpm"},
    {"drives.*.initial_angle", "number", "rad", "from the bodies",
     "speed drive: relative angle at t = 0; default: that of the bodies' `angle` keys"},
    {"drives.*.torque", "number", "N m", "–",
     "constant torque on the second body, its opposite on the first"},
    {"drives.*.torque_table", "points", "s or rad, N m", "–",
     "tabulated torque: [[t or angle, torque], ...], linear between"},
    {"drives.*.lag", "number", "s", "–",
     "torque, torque_table: the torque follows with a first-order lag of this time constant, from 0"},
    {"drives.*.against", "text", "", "\"time\"",
     "torque_table: \"time\" (constant outside) or \"angle\" (repeats every 2π)"},

    {"loads.*.type", "text", "", "required",
     "\"force\", \"torque\", \"spring-damper\", \"torsional-spring-damper\" or \"joint-friction\""},
    {"loads.*.body", "text", "", "required", "force, torque: the loaded body"},
    {"loads.*.at", "point(s)", "m", "[0, 0]",
     "force: the loaded point in the body's frame; spring-damper: its two ends"},
    {"loads.*.force", "point or number", "N", "required",
     "force: constant force in the world's directions; joint-friction: the bound of the friction force"},
    {"loads.*.torque", "number", "N m", "required", "torque: constant torque"},
    {"loads.*.between", "names", "", "required", "spring-dampers: two bodies, or \"ground\" and a body"},
    {"loads.*.stiffness", "number", "N/m or N m/rad", "0", "spring-dampers: rate, ≥ 0"},
    {"loads.*.damping", "number", "N s/m or N m s/rad", "0", "spring-dampers: damping, ≥ 0"},
    {"loads.*.free_length", "number", "m", "0", "spring-damper: length without force"},
    {"loads.*.free_angle", "number", "rad", "0", "torsional-spring-damper: relative angle without torque"},
    {"loads.*.joint", "text", "", "required", "joint-friction: the translational joint"},
    {"loads.*.regularisation", "number", "m/s", "–",
     "joint-friction: speed below which the penalty formulation's friction is linear; it needs it"},

    {"run.revolutions", "number", "", "–", "length of the run in turns of the driven joint; or duration"},
    {"run.duration", "number", "s", "–", "length of the run; or revolutions"},
    {"run.discard", "number", "as the length", "0",
     "start of the run left out of the statistics: revolutions, with `duration` seconds"},
    {"run.start", "text", "", "\"assembled\"",
     "\"assembled\" (rough positions made consistent), \"ideal\" (the ideal joints' configuration and "
     "velocities) or \"given\" (as they stand)"},
    {"run.eliminate", "true or false", "", "true",
     "coordinates that one constraint row alone fixes leave the solves beforehand; false keeps the whole "
     "DAE"},
    {"run.output_step", "number", "s", "duration/20000",
     "spacing of the rows of trajectory.csv and forces.csv"},
    {"run.forces", "true or false", "", "false",
     "write forces.csv: reactions, contact forces, drive torques, loads and accelerations"},

    {"penalty.contact", "text", "", "\"exact\"", "contact law; `freeplay laws` lists all"},
    {"penalty.damping", "text", "", "\"exact\"",
     "line contacts: the point law whose damping factor they take, \"hertz\" for none; pereira: its own"},
    {"penalty.kelvin_stiffness", "number", "N/m", "–", "kelvin-voigt: K"},
    {"penalty.kelvin_damping", "number", "N s/m", "–", "kelvin-voigt: D"},
    {"penalty.friction", "text", "", "\"ambrosio\"",
     "\"ambrosio\", \"threlfall\", \"bengisu-akay\", \"lugre\" or \"brown-mcphee\""},
    {"penalty.friction_v0", "number", "m/s", "1e-4",
     "sliding speed that regularises friction: none below it (Ambrósio), v₀ (Threlfall, Bengisu–Akay), "
     "Stribeck's (LuGre), v_t (Brown–McPhee)"},
    {"penalty.friction_v1", "number", "m/s", "1e-3", "Ambrósio: full friction above this sliding speed"},
    {"penalty.friction_static", "number", "", "1",
     "Bengisu–Akay, LuGre, Brown–McPhee: static over kinetic friction, ≥ 1"},
    {"penalty.friction_decay", "number", "s/m", "1000",
     "Bengisu–Akay: ξ, decay from static to kinetic friction"},
    {"penalty.friction_viscous", "number", "s/m", "0",
     "LuGre, Brown–McPhee: viscous friction over the normal force"},
    {"penalty.bristle_stiffness", "number", "1/m", "1e5", "LuGre: σ₀ over the normal force"},
    {"penalty.bristle_damping", "number", "s/m", "10", "LuGre: σ₁ over the normal force"},
    {"penalty.stabilisation", "text", "", "\"baumgarte\"",
     "\"none\", \"baumgarte\" or \"projection\" (after each accepted step)"},
    {"penalty.alpha", "number", "1/s", "5", "Baumgarte: damping, ≥ 0"},
    {"penalty.beta", "number", "1/s", "5", "Baumgarte: frequency, ≥ 0"},
    {"penalty.integrator", "text", "", "\"adams_bashforth_moulton\"",
     "\"dopri5\", \"fehlberg78\", \"bulirsch_stoer\", \"adams_bashforth_moulton\", \"rosenbrock4\" "
     "(implicit, for stiff scenes; all these adaptive) or \"rk4\" (fixed step)"},
    {"penalty.tolerance", "number", "", "1e-9",
     "adaptive integrators: a step is accepted when every |error| is below tolerance × scale"},
    {"penalty.step", "number", "s", "1e-6", "rk4: step"},
    {"penalty.v0_floor", "number", "m/s", "see penalty.md",
     "least approach speed that a contact's damping is scaled with"},

    {"nonsmooth.scheme", "text", "", "\"moreau-jean\"",
     "\"moreau-jean\" (time stepping) or \"event-driven\" (impacts and changes of contact located one by "
     "one)"},
    {"nonsmooth.step", "number", "s", "1e-5", "moreau-jean: step"},
    {"nonsmooth.tolerance", "number", "", "1e-10",
     "event-driven: a step of its integrator is accepted when every |error| is below tolerance × scale"},
    {"nonsmooth.impact_law", "text", "", "\"newton\"",
     "\"newton\"; event-driven also \"poisson\" or \"energetic\" (Stronge): what restitution is a ratio of"},
    {"nonsmooth.solver", "text", "", "\"automatic\"",
     "contact problem: \"enumeration\", \"lemke\", \"gauss-seidel\", \"newton\", or \"automatic\" (closed "
     "form for one contact, enumeration for two, then Lemke, Gauss-Seidel for many); another takes over "
     "when one fails"},
    {"nonsmooth.lcp_tolerance", "number", "", "1e-10",
     "a complementarity solve is accepted when its relative residual is below"},

    {"instruments.*.type", "text", "", "\"accelerometer\"",
     "\"accelerometer\" (m/s²), \"lvdt\" (m, position of a body), \"encoder\" (rad, angle of a joint), "
     "\"load-cell\" (N, force of a joint on its second body) or \"torque\" (N m, of a drive)"},
    {"instruments.*.body", "text", "", "required", "accelerometer, lvdt: the body it is fixed to"},
    {"instruments.*.axis", "point", "", "[1, 0]",
     "accelerometer, lvdt, load-cell: direction of measurement in the world"},
    {"instruments.*.bandwidth", "number", "Hz", "required",
     "accelerometer, load-cell, torque: −3 dB frequency of its Butterworth low-pass"},
    {"instruments.*.order", "number", "", "2",
     "accelerometer, load-cell, torque: order of the low-pass, 1 to 8"},
    {"instruments.*.joint", "text", "", "required",
     "encoder: the joint whose angle it shows; load-cell: whose force"},
    {"instruments.*.drive", "text", "", "required", "torque: the drive whose torque it shows"},
    {"instruments.*.counts", "number", "", "–", "encoder: counts per revolution; or resolution"},
    {"instruments.*.sampling", "number", "Hz", "required", "samples per second in signals.csv"},
    {"instruments.*.noise", "number", "of the channel", "–", "standard deviation of a sample's noise"},
    {"instruments.*.seed", "number", "", "1", "of the noise, a whole number"},
    {"instruments.*.range", "number", "of the channel", "–", "full scale: samples are clipped to ± this"},
    {"instruments.*.resolution", "number", "of the channel", "–",
     "step of the samples, rounded down; an encoder's is 2π/counts"},

    {"study.title", "text", "", "\"\"", "what the study asks"},
    {"study.scene", "text", "", "required", "scene file, relative to the study's"},
    {"study.claims", "text", "", "–", "list of published findings to judge: \"flores2011\""},
    {"study.fit", "text", "", "–",
     "study whose calibration `validate` runs first; adds a variant \"calibrated\""},
    {"study.joint", "text", "", "–", "contact that flights and impacts are taken from; sweeps need it"},
    {"study.accelerometer", "text", "", "–", "instrument whose signal is judged; sweeps need it"},
    {"study.position", "text", "", "–", "LVDT of the same sampling"},
    {"study.formulations", "names", "", "both", "\"penalty\", \"nonsmooth\""},
    {"study.restitution", "text", "", "\"delivered\"",
     "the impact law's: \"delivered\" by the penalty law, or \"as-given\""},
    {"study.revolutions", "number", "", "50", "counted in each run"},
    {"study.discard", "number", "", "2", "revolutions before those"},
    {"study.starts", "number", "", "8", "perturbed starts of each case"},
    {"study.seed", "number", "", "1", "of the starts, a whole number"},
    {"study.turn", "number", "", "1", "share of a turn that the crank's start angle is drawn from"},
    {"study.play", "number", "", "0.9", "share of the clearance that loose parts start within"},
    {"study.flight_angle", "number", "degrees", "2",
     "flights count that last at least this turn of the crank"},
    {"study.impact_speed", "number", "m/s", "0.01", "impacts count that approach at least this fast"},
    {"study.line_share", "number", "", "0.05",
     "a line of the spectrum is dominant from this share of the ideal greatest acceleration"},
    {"study.axes.*.key", "text", "", "required", "scene key that varies"},
    {"study.axes.*.values", "numbers", "", "required", "what it takes"},
    {"study.axes.*.unit", "text", "", "\"\"", "as shown"},
    {"study.axes.*.scale", "number", "", "1", "shown value over the key's"},
    {"study.variants.*.title", "text", "", "its name", "what it switches on"},
    {"study.variants.*.scene", "text", "", "the study's", "another scene file"},
    {"study.variants.*.set", "names", "", "[]", "keys of the scene, KEY=VALUE"},
    {"study.variants.*.formulations", "names", "", "the study's", "as in the study"},
    {"study.variants.*.starts", "number", "", "the study's", "as in the study"},
    {"study.variants.*.revolutions", "number", "", "the study's", "as in the study"},
    {"study.calibrate.formulation", "text", "", "\"nonsmooth\"", "which is fitted"},
    {"study.calibrate.points", "number", "", "64", "of the space-filling set that the surface is fitted to"},
    {"study.calibrate.starts", "number", "", "2", "perturbed starts of each point and target"},
    {"study.calibrate.revolutions", "number", "", "20", "counted in each run"},
    {"study.calibrate.unknowns.*.key", "text", "", "required", "scene key that is fitted"},
    {"study.calibrate.unknowns.*.low", "number", "", "required", "least value"},
    {"study.calibrate.unknowns.*.high", "number", "", "required", "greatest value"},
    {"study.calibrate.unknowns.*.scale", "text", "", "\"linear\"", "or \"log\""},
    {"study.calibrate.unknowns.*.unit", "text", "", "\"\"", "as shown"},
    {"study.calibrate.targets.*.set", "names", "", "[]", "keys of the scene for this target, KEY=VALUE"},
    {"study.calibrate.targets.*.statistic", "text", "", "required", "of a run; docs/study.md lists them"},
    {"study.calibrate.targets.*.value", "number", "", "–", "as measured"},
    {"study.calibrate.targets.*.data", "text", "", "–",
     "measured file that the statistic is computed from, instead"},
    {"study.calibrate.targets.*.tolerance", "number", "", "0.1",
     "relative standard uncertainty of the value"},
};

int edit_distance(std::string_view a, std::string_view b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int above = row[j];
      row[j] = std::min({row[j - 1] + 1, above + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

}  // namespace

std::span<const SchemaKey> schema() { return keys; }

const SchemaKey* find_key(std::string_view path) {
  const auto it = std::ranges::find(keys, path, &SchemaKey::path);
  return it == std::end(keys) ? nullptr : &*it;
}

std::string nearest_key(std::string_view path) {
  const auto dot = path.rfind('.');
  const std::string_view table = dot == path.npos ? "" : path.substr(0, dot + 1);
  const std::string_view name = path.substr(table.size());
  std::string best;
  int least = static_cast<int>(name.size()) / 2 + 1;
  for (const auto& k : keys) {
    if (!k.path.starts_with(table)) continue;
    const auto candidate = k.path.substr(table.size());
    if (candidate.find('.') != candidate.npos) continue;
    const int d = edit_distance(name, candidate);
    if (d < least) {
      least = d;
      best = candidate;
    }
  }
  return best;
}

}  // namespace freeplay
