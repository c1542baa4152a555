#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>

#include "io/read_mechanism.hpp"
#include "model/scene.hpp"

namespace freeplay {
namespace {

/// Sets one dotted key of the document; what does not parse as a TOML value is taken as a text.
void apply_override(toml::table& root, SceneSource& source, const std::string& given) {
  const auto equals = given.find('=');
  const auto bad = [&](const char* why) { throw SceneError(fmt::format("--set {}: {}", given, why)); };
  if (equals == given.npos || equals == 0)
    bad("must be KEY=VALUE, for example joints.gudgeon.clearance=1e-3");
  const std::string key = given.substr(0, equals), value = given.substr(equals + 1);
  if (value.empty()) bad("has no value");

  toml::table parsed;
  try {
    parsed = parse_toml("value = " + value, "");
  } catch (const SceneError&) {  // a bare text
    parsed.insert("value", value);
  }
  if (parsed.size() != 1) bad("must set one value");

  toml::table* table = &root;
  std::istringstream segments(key);
  std::string segment;
  std::vector<std::string> names;
  while (std::getline(segments, segment, '.')) names.push_back(segment);
  for (std::size_t i = 0; i + 1 < names.size(); ++i) {
    if (!table->contains(names[i])) table->insert(names[i], toml::table{});
    table = table->get_as<toml::table>(names[i]);
    if (!table) bad(fmt::format("{} is a value, not a table", names[i]).c_str());
  }
  if (names.empty() || names.back().empty()) bad("has an empty key");
  table->insert_or_assign(names.back(), std::move(*parsed.get("value")));
  source.overridden[key] = given;
}

std::optional<int> read_format(Section& root) {
  constexpr Range known{[](double x) { return x == newest_format; },
                        "1, the only format there is so far (a later freeplay may know more)"};
  const auto format = root.maybe_number("format", known);
  if (!format) return std::nullopt;
  return static_cast<int>(*format);
}

RunOptions read_run(Section& s, const Mechanism& mechanism) {
  RunOptions o;
  const auto* drive = main_drive(mechanism);
  if (s.has("revolutions") == s.has("duration")) s.fail("", "needs exactly one of revolutions and duration");
  double unit = 1;
  if (s.has("revolutions")) {
    if (!drive || drive->speed == 0)
      s.fail("revolutions", "needs a drive that turns at a prescribed speed; give duration (s) instead");
    unit = 2 * std::numbers::pi / std::abs(drive->speed);
    o.duration = s.number("revolutions", positive) * unit;
  } else {
    o.duration = s.number("duration", positive);
  }
  o.discard = s.number("discard", non_negative, 0) * unit;
  if (o.discard >= o.duration) s.fail("discard", "must be less than the length of the run");
  o.start = static_cast<RunOptions::Start>(s.choice("start", {"assembled", "ideal", "given"}, 0));
  o.eliminate = s.flag("eliminate", o.eliminate);
  o.output_step = s.maybe_number("output_step", positive);
  if (o.output_step && *o.output_step < 1e-8 * o.duration)
    s.fail("output_step", fmt::format("must be at least {:.3g} s: a hundred million rows of trajectory.csv",
                                      1e-8 * o.duration));
  o.forces = s.flag("forces", o.forces);
  s.done("[run]");
  return o;
}

PenaltyOptions read_penalty(Section s) {
  PenaltyOptions o;
  o.contact = static_cast<ContactLaw>(s.choice("contact", contact_law_names, static_cast<int>(o.contact)));
  if (s.has("damping")) {
    if (o.contact < ContactLaw::johnson)
      s.fail("damping",
             "belongs to line contacts (johnson and below in `freeplay laws`); this law has its own");
    std::vector<std::string> point(contact_law_names.begin(),
                                   contact_law_names.begin() + static_cast<int>(ContactLaw::kelvin_voigt));
    o.damping = static_cast<ContactLaw>(s.choice("damping", point));
  }
  if (o.contact == ContactLaw::kelvin_voigt || s.has("kelvin_stiffness") || s.has("kelvin_damping")) {
    o.kelvin_stiffness = s.maybe_number("kelvin_stiffness", positive);
    o.kelvin_damping = s.maybe_number("kelvin_damping", non_negative);
  }
  o.friction = static_cast<FrictionLaw>(s.choice("friction", friction_law_names, 0));
  o.friction_v0 =
      s.number("friction_v0", o.friction == FrictionLaw::ambrosio ? non_negative : positive, o.friction_v0);
  o.friction_v1 = s.number("friction_v1", positive, o.friction_v1);
  o.friction_static = s.number("friction_static", one_or_more, o.friction_static);
  o.friction_decay = s.number("friction_decay", non_negative, o.friction_decay);
  o.friction_viscous = s.number("friction_viscous", non_negative, o.friction_viscous);
  o.bristle_stiffness = s.number("bristle_stiffness", positive, o.bristle_stiffness);
  o.bristle_damping = s.number("bristle_damping", non_negative, o.bristle_damping);
  if (o.friction == FrictionLaw::ambrosio && o.friction_v1 <= o.friction_v0)
    s.fail("friction_v1",
           fmt::format("must be greater than friction_v0 = {}, is {}", o.friction_v0, o.friction_v1));
  o.stabilisation =
      static_cast<Stabilisation>(s.choice("stabilisation", {"none", "baumgarte", "projection"}, 1));
  for (const char* key : {"alpha", "beta"})
    if (s.has(key) && o.stabilisation != Stabilisation::baumgarte)
      s.fail(key, "belongs to penalty.stabilisation = \"baumgarte\"");
  o.alpha = s.number("alpha", non_negative, o.alpha);
  o.beta = s.number("beta", non_negative, o.beta);
  o.integrator = static_cast<Integrator>(
      s.choice("integrator",
               {"rk4", "dopri5", "fehlberg78", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"},
               static_cast<int>(o.integrator)));
  if (o.integrator == Integrator::adams_bashforth_moulton && o.stabilisation == Stabilisation::projection)
    s.fail("stabilisation",
           "\"projection\" moves the state after each step, which a multistep integrator cannot take; "
           "use \"baumgarte\", or a one-step integrator");
  o.tolerance = s.number("tolerance", positive, o.tolerance);
  o.step = s.number("step", positive, o.step);
  o.v0_floor = s.maybe_number("v0_floor", positive);
  s.done("[penalty]");
  return o;
}

NonsmoothOptions read_nonsmooth(Section s) {
  NonsmoothOptions o;
  o.scheme = static_cast<Scheme>(s.choice("scheme", {"moreau-jean", "event-driven"}, 0));
  o.step = s.number("step", positive, o.step);
  o.tolerance = s.number("tolerance", positive, o.tolerance);
  o.solver = static_cast<LcpSolver>(
      s.choice("solver", {"automatic", "enumeration", "lemke", "gauss-seidel", "newton"}, 0));
  o.lcp_tolerance = s.number("lcp_tolerance", positive, o.lcp_tolerance);
  o.impact_law = static_cast<ImpactLaw>(s.choice("impact_law", {"newton", "poisson", "energetic"}, 0));
  if (o.impact_law != ImpactLaw::newton && o.scheme == Scheme::moreau_jean)
    s.fail(
        "impact_law",
        "time stepping has only \"newton\": a step's impulse is of impacts and of lasting contact together, "
        "and the others would let a resting contact rebound; use scheme = \"event-driven\"");
  s.done("[nonsmooth]");
  return o;
}

Instrument read_instrument(const Mechanism& mechanism, const std::string& name, Section& s) {
  using Kind = Instrument::Kind;
  Instrument i;
  i.name = name;
  i.kind =
      static_cast<Kind>(s.choice("type", {"accelerometer", "lvdt", "encoder", "load-cell", "torque"}, 0));
  i.sampling = s.number("sampling", positive);
  i.noise = s.maybe_number("noise", non_negative);
  if (i.noise) i.seed = static_cast<unsigned>(s.number("seed", whole, i.seed));
  if (i.kind == Kind::encoder || i.kind == Kind::load_cell) {
    const auto joint = s.text("joint");
    const auto found = std::ranges::find(mechanism.joints, joint, [](const Joint& j) { return name_of(j); });
    if (found == mechanism.joints.end()) s.fail("joint", fmt::format("there is no joint \"{}\"", joint));
    i.joint = static_cast<int>(found - mechanism.joints.begin());
    i.pair = bodies_of(*found);
  }
  if (i.kind == Kind::encoder) {
    if (s.has("counts") == s.has("resolution")) s.fail("", "needs exactly one of counts and resolution");
    i.resolution = s.has("resolution") ? s.number("resolution", positive)
                                       : 2 * std::numbers::pi / s.number("counts", one_or_more);
    s.done("an encoder");
    return i;
  }
  if (i.kind == Kind::torque) {
    i.drive = s.text("drive");
    if (std::ranges::find(mechanism.drives, i.drive, [](const Drive& d) { return name_of(d); }) ==
        mechanism.drives.end())
      s.fail("drive", fmt::format("there is no drive \"{}\"", i.drive));
  } else {
    i.axis = read_axis(s);
  }
  if (i.kind == Kind::accelerometer || i.kind == Kind::lvdt) {
    i.body = body_index(mechanism, s, "body", s.text("body"));
    if (i.body == ground) s.fail("body", "must be a moving body, is the ground");
  }
  i.range = s.maybe_number("range", positive);
  i.resolution = s.maybe_number("resolution", positive);
  if (i.kind != Kind::lvdt) {
    i.bandwidth = s.number("bandwidth", positive);
    const double order = s.number("order", one_or_more, i.order);
    if (order != std::floor(order) || order > 8) s.fail("order", "must be a whole number from 1 to 8");
    i.order = static_cast<int>(order);
    if (i.sampling <= 2 * i.bandwidth)
      s.fail("sampling",
             fmt::format("must exceed twice the bandwidth {} Hz, is {} Hz", i.bandwidth, i.sampling));
  }
  constexpr const char* names[] = {"an accelerometer", "an LVDT", "an encoder", "a load cell",
                                   "a torque sensor"};
  s.done(names[static_cast<int>(i.kind)]);
  return i;
}

}  // namespace

const std::vector<std::string> contact_law_names = {"hertz",
                                                    "hunt-crossley",
                                                    "herbert-mcwhannell",
                                                    "lee-wang",
                                                    "lankarani-nikravesh",
                                                    "gonthier",
                                                    "zhiying-qishao",
                                                    "flores",
                                                    "hu-guo",
                                                    "carvalho-martins",
                                                    "exact",
                                                    "kelvin-voigt",
                                                    "johnson",
                                                    "esdu-78035",
                                                    "radzimovsky",
                                                    "liu",
                                                    "persson",
                                                    "pereira"};
const std::vector<std::string> friction_law_names = {"ambrosio", "threlfall", "bengisu-akay", "lugre",
                                                     "brown-mcphee"};

const SpeedDrive* main_drive(const Mechanism& mechanism) {
  for (const auto& drive : mechanism.drives)
    if (const auto* speed = std::get_if<SpeedDrive>(&drive)) return speed;
  return nullptr;
}

Scene parse_scene(const std::string& text, const std::string& name,
                  const std::vector<std::string>& overrides) {
  Scene scene;
  scene.file = name;
  scene.text = text;
  scene.overrides = overrides;
  SceneSource source{name, {}};
  toml::table document = parse_toml(text, name);
  for (const auto& o : overrides) apply_override(document, source, o);

  Section root(document, "", "", source);
  scene.format = read_format(root);
  scene.mechanism = read_mechanism(root);
  auto run = root.child("run");
  scene.run = read_run(run, scene.mechanism);
  scene.penalty = read_penalty(root.child("penalty"));
  scene.nonsmooth = read_nonsmooth(root.child("nonsmooth"));
  for (auto& [key, s] : root.children("instruments"))
    scene.instruments.push_back(read_instrument(scene.mechanism, key, s));
  root.done("a scene");
  return scene;
}

Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_scene(read_text(file), file.string(), overrides);
}

}  // namespace freeplay
