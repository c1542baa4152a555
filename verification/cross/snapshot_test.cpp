// Snapshots of whole simulations. At random accepted steps of a run, in every integrator and scheme and
// wherever the motion may stand (in flight, within an impact, sliding, sticking, on a film, before and behind
// a knot of a table), the simulation is written down from within an observer, read into a new one and run on.
// All that anybody could see of the rest must be that of the uninterrupted run, bit for bit.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <bitset>
#include <fstream>
#include <iterator>
#include <random>
#include <set>

#include "facade/simulation.hpp"
#include "io/output_file.hpp"
#include "model/scene.hpp"
#include "sim/statistics.hpp"
#include "sim/trajectory.hpp"
#include "values/snapshot.hpp"
#include "verification/piles.hpp"
#include "verification/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using Bytes = std::vector<std::byte>;

/// The bits of values: NaNs are equal to themselves, and zeros have signs.
template <class... T>
Bytes bits(T&... values) {
  Bytes bytes;
  MemoryWriter m(bytes);
  m(values...);
  return bytes;
}

/// Where the motion stands at the end of a step.
enum Place { flight, contact, slide, stick, film, impact, before_knot, behind_knot, places };
const char* name_of(Place p) {
  return std::array{
      "flight", "contact", "slide", "stick", "film", "impact", "before a knot", "behind a knot"}[p];
}
using Places = std::bitset<places>;

/// All that an observer is shown, as bits.
class Record final : public Observer {
 public:
  struct Moment {
    Snapshot snapshot;
    Bytes statistics;
    std::size_t steps, events, samples;
    double t;
  };
  Record(Simulation& simulation, bool forces)
      : simulation_(simulation), forces_(forces), statistics(simulation.scene().run.discard) {
    const auto& surfaces = simulation.scene().mechanism.surfaces;
    if (!surfaces.empty()) mu_ = surfaces.front().friction.value_or(0);
  }
  Wants wants() const override { return {forces_, true}; }
  void begin(const Layout& layout, const State& state) override {
    statistics.begin(layout, state);
    contacts_.resize(layout.contacts.size());
    q_.resize(state.q.size());
    v_.resize(state.v.size());
    now_.elements.resize(layout.forces.size());
    now_.acceleration.resize(state.v.size());
    elements_.clear();
    for (std::size_t e = 0; e < layout.forces.size(); ++e)
      if (layout.forces[e].kind == ForceElement::Kind::contact && elements_.size() < contacts_.size())
        elements_.push_back(e);
  }
  void event(const Event& e) override {
    statistics.event(e);
    auto copy = e;
    events.push_back(bits(copy));
  }
  void sample(std::size_t channel, double t, double value) override {
    samples.push_back(bits(channel, t, value));
  }
  void step(const Step& step) override {
    double t0 = step.t0, t1 = step.t1;
    step.state(0.5 * (t0 + t1), q_, v_);
    auto seen = bits(t0, t1, q_, v_);
    std::vector<double> lambda(step.multipliers().begin(), step.multipliers().end());
    auto ledger = step.ledger();
    step.state(t1, q_, v_);
    step.contacts(t1, q_, contacts_);
    const auto more = [&](const Bytes& b) { seen.insert(seen.end(), b.begin(), b.end()); };
    more(bits(q_, v_, lambda, ledger));
    if (forces_) {
      step.forces(t1, now_);
      auto before = step.before(), within = step.within();
      more(bits(now_, before, within));
    }
    steps.push_back(seen);
    where.push_back(forces_ ? place(step) : Places());
    if (wanted.contains(steps.size())) {
      Moment m{simulation_.snapshot(), {}, steps.size(), events.size(), samples.size(), t1};
      MemoryWriter w(m.statistics);
      statistics.save(w);
      moments.push_back(m);
    }
  }
  void end(const RunEnd& end) override { statistics.end(end); }

  std::vector<Bytes> steps, events, samples;
  std::vector<Places> where;     // at the end of each step
  std::set<std::size_t> wanted;  // a snapshot after so many steps
  std::vector<Moment> moments;
  std::vector<double> knots;

 private:
  Places place(const Step& step) {
    Places p;
    bool touches = false;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      const auto &f = now_.elements[elements_[k]], &b = step.before().elements[elements_[k]],
                 &w = step.within().elements[elements_[k]];
      if (b.fn > 0 || w.fn > 0) p.set(impact);
      if (f.fn == 0) continue;
      touches = true;
      if (contacts_[k].gap > 1e-7) {
        p.set(film);
        continue;
      }
      if (!(f.fn > 0)) continue;
      p.set(contact);
      if (mu_ > 0 && std::abs(f.ft) >= 0.999 * mu_ * f.fn) p.set(slide);
      if (mu_ > 0 && std::abs(f.ft) < 0.9 * mu_ * f.fn) p.set(stick);
    }
    if (!touches && !elements_.empty() && !p[impact]) p.set(flight);
    for (const double knot : knots) p.set(step.t1 < knot ? before_knot : behind_knot);
    return p;
  }
  Simulation& simulation_;
  const bool forces_;
  double mu_ = 0;
  std::vector<std::size_t> elements_;  // of the contacts
  std::vector<ContactPlace> contacts_;
  std::vector<double> q_, v_;
  Forces now_;

 public:
  ContactStatistics statistics;
};

/// All of a result but what it cost; its events are those of the record.
Bytes bits_of(Result r) {
  auto& s = r.final_state;
  auto all = bits(r.formulation, r.ending.status, r.ending.reason, r.t_end, r.observed, s.t, s.q, s.v, s.z,
                  r.revolutions, r.ledger, r.work, r.extremes, r.notes, r.undetermined);
  for (auto& c : r.contacts) {
    auto& m = c.model;
    const auto more = bits(c.name, m.restitution_asked, m.restitution_delivered, m.stiffness, m.exponent,
                           m.chi, c.flight_fraction, c.impact_fraction, c.lasting_fraction, c.impacts,
                           c.counted_impacts, c.impacts_per_revolution, c.fastest_approach, c.median_approach,
                           c.median_impulse, c.greatest_impulse, c.penetration, c.penetration_ratio);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

/// Whether `rest` is the end of `all`, from there on.
void require_rest(const char* what, const std::vector<Bytes>& rest, const std::vector<Bytes>& all,
                  std::size_t from) {
  INFO(what);
  REQUIRE(rest.size() == all.size() - from);
  const auto [a, b] = std::mismatch(rest.begin(), rest.end(), all.begin() + static_cast<long>(from));
  (void)b;
  INFO("the first " << a - rest.begin() << " of " << rest.size() << " are equal");
  REQUIRE(a == rest.end());
}

struct Case {
  std::string scene;  // text
  std::string formulation;
  std::vector<std::string> set = {};
  std::vector<Place> in = {};  // places where some snapshots must fall
  bool matched = false;
  bool forces = true;
  std::vector<double> knots = {};
};

std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), {}};
}
std::string text(const std::string& name) { return text_of(test::scene_file(name)); }

void check(const Case& c) {
  CAPTURE(c.formulation, c.set);
  const auto scene = parse_scene(c.scene, "snapshot.toml", c.set);
  const auto simulation = [&] { return Simulation(scene, c.formulation, {.matched = c.matched}); };
  const auto run_on = [](Simulation& s, Record& record, Trajectory& path) {
    auto result = s.run({.observers = {&path, &record}});
    record.statistics.into(result);
    return result;
  };
  std::mt19937 engine(20240611);
  std::set<std::size_t> chosen;
  std::vector<Places> where;
  {  // Which steps there are.
    auto s = simulation();
    Record record(s, true);
    record.knots = c.knots;
    const auto result = s.run({.observers = {&record}});
    INFO(result.ending.reason);
    REQUIRE(result.ending.status == Ending::Status::finished);
    where = record.where;
    REQUIRE(where.size() > 5);
    for (const auto place : c.in) {
      std::vector<std::size_t> there;
      for (std::size_t i = 0; i + 1 < where.size(); ++i)
        if (where[i][place]) there.push_back(i + 1);
      INFO("in " << name_of(place) << ": " << there.size() << " of " << where.size() << " steps");
      REQUIRE(there.size() >= 2);
      for (int i = 0; i < 3; ++i) chosen.insert(there[engine() % there.size()]);
    }
    while (chosen.size() < std::min<std::size_t>(20, where.size() - 1))
      chosen.insert(1 + engine() % (where.size() - 1));
  }
  auto whole = simulation();
  Record all(whole, c.forces);
  all.wanted = chosen;
  Trajectory path;
  const auto result = run_on(whole, all, path);
  const auto result_bits = bits_of(result);
  REQUIRE(all.moments.size() == chosen.size());
  REQUIRE(all.steps.size() == where.size());  // watched in another way, the run is the same

  const auto go_on = [&](Simulation& s, const Record::Moment& m) {
    INFO("after " << m.steps << " of " << all.steps.size() << " steps, t = " << m.t << ": "
                  << where[m.steps - 1].to_string());
    s.restore(m.snapshot);
    REQUIRE(s.t() == m.t);
    REQUIRE((s.snapshot().memory == m.snapshot.memory));
    Record rest(s, c.forces);
    MemoryReader r(m.statistics);
    rest.statistics.load(r);
    Trajectory rest_path;
    const auto end = run_on(s, rest, rest_path);
    require_rest("steps", rest.steps, all.steps, m.steps);
    require_rest("events", rest.events, all.events, m.events);
    require_rest("samples", rest.samples, all.samples, m.samples);
    REQUIRE((bits_of(end) == result_bits));
    REQUIRE(end.events.size() == rest.events.size());
    std::size_t row = 0;
    while (row < path.size() && path.t(row) <= m.t) ++row;
    REQUIRE(rest_path.size() == path.size() - row + 1);  // its first row is where it began
    bool equal = true;
    for (std::size_t i = 1; i < rest_path.size(); ++i, ++row)
      equal = equal && rest_path.t(i) == path.t(row) && std::ranges::equal(rest_path.q(i), path.q(row)) &&
              std::ranges::equal(rest_path.v(i), path.v(row));
    REQUIRE(equal);
  };
  for (const auto& m : all.moments) {
    auto fresh = simulation();
    go_on(fresh, m);
  }
  // Into one that has a past of its own.
  go_on(whole, all.moments[engine() % all.moments.size()]);
}

/// The slider-crank with every kind of instrument on it.
std::string rig(const std::string& more = "") {
  return text("gudgeon") + R"(
[instruments.accelerometer]
type = "accelerometer"
body = "slider"
bandwidth = 2000.0
sampling = 20000.0
order = 3
noise = 0.1
seed = 7
[instruments.lvdt]
type = "lvdt"
body = "slider"
sampling = 7000.0
resolution = 1e-7
[instruments.encoder]
type = "encoder"
joint = "main"
counts = 4096
sampling = 5000.0
[instruments.cell]
type = "load-cell"
joint = "gudgeon"
axis = [0.6, 0.8]
bandwidth = 3000.0
sampling = 10000.0
[instruments.shaft]
type = "torque"
drive = "motor"
bandwidth = 1000.0
sampling = 10000.0
)" + more;
}

/// A cell on a pin of the long chain, whose forces come from sparse factors.
std::string chain() {
  return text("long_chain") + R"(
[instruments.cell]
type = "load-cell"
joint = "pin1"
axis = [1.0, 0.0]
bandwidth = 500.0
sampling = 2000.0
)";
}

/// A block on a rail whose guide is preloaded, on a spring and a damper, knocking a stop; a flywheel on a
/// torsional spring, driven by a table of torques.
std::string loads() {
  return R"(
gravity = [0.0, -9.81]
[bodies.block]
mass = 1.0
inertia = 0.01
position = [0.0, 0.0]
velocity = [0.5, 0.0]
[bodies.wheel]
mass = 1.0
inertia = 0.01
position = [3.0, 0.0]
[joints.guide]
type = "translational"
between = ["ground", "block"]
[joints.axle]
type = "revolute"
between = ["ground", "wheel"]
at = [[3.0, 0.0], [0.0, 0.0]]
[contacts.stop]
type = "plane"
between = ["ground", "block"]
at = [[0.06, 0.0], [0.05, 0.0]]
axis = [0.0, 1.0]
surface = "rubber"
[surfaces.rubber]
restitution = 0.6
friction = 0.2
[drives.brake]
joint = "axle"
torque_table = [[0.0, 0.1], [0.02, 0.5], [0.05, -0.4], [0.07, 0.0]]
[loads.spring]
type = "spring-damper"
between = ["ground", "block"]
at = [[0.5, 0.0], [0.0, 0.0]]
stiffness = 400.0
damping = 3.0
free_length = 0.4
[loads.bar]
type = "torsional-spring-damper"
between = ["ground", "wheel"]
stiffness = 2.0
damping = 0.05
[loads.push]
type = "force"
body = "wheel"
at = [0.1, 0.0]
force = [0.0, 0.3]
[loads.rub]
type = "joint-friction"
joint = "guide"
force = 2.0
regularisation = 1e-3
[run]
duration = 0.3
discard = 0.02
output_step = 1e-3
start = "given"
[penalty]
contact = "kelvin-voigt"
kelvin_stiffness = 1e6
kelvin_damping = 30.0
tolerance = 1e-7
[nonsmooth]
step = 2e-4
[instruments.shaft]
type = "torque"
drive = "brake"
bandwidth = 200.0
sampling = 1000.0
)";
}

}  // namespace

TEST_CASE("snapshots: every penalty integrator goes on bit for bit", "[snapshot]") {
  const auto set = [](const std::string& integrator, std::vector<std::string> more) {
    more.insert(more.end(), {"penalty.integrator=\"" + integrator + "\"", "run.duration=0.02",
                             "run.discard=0.003", "run.output_step=1e-4", "penalty.tolerance=1e-7"});
    return more;
  };
  for (const auto& [integrator, more] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"rk4", {"penalty.step=5e-6"}},
           {"dopri5", {}},
           {"fehlberg78", {"penalty.stabilisation=\"projection\""}},
           {"bulirsch_stoer", {"surfaces.steel.friction=0.1"}},
           {"bulirsch_stoer", {"penalty.stabilisation=\"projection\""}},
           {"adams_bashforth_moulton", {}},
           {"rosenbrock4", {"penalty.stabilisation=\"none\"", "penalty.tolerance=1e-6"}}})
    check({rig(), "penalty", set(integrator, more), {flight, contact, slide}});
}

TEST_CASE("snapshots: friction's zones and bristles", "[snapshot]") {
  for (const auto& [law, own] : {std::pair{"ambrosio", "penalty.friction_v1=0.3"},
                                 {"threlfall", "run.discard=0"},
                                 {"bengisu-akay", "penalty.friction_static=1.2"},
                                 {"brown-mcphee", "penalty.friction_static=1.2"},
                                 {"lugre", "penalty.friction_static=1.2"}})
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check(
          {text("ring"),
           "penalty",
           {fmt::format("penalty.friction=\"{}\"", law), fmt::format("penalty.integrator=\"{}\"", integrator),
            "penalty.tolerance=1e-6", "penalty.friction_v0=0.02", own, "run.duration=0.03"},
           {flight, contact, stick}});
  // A block that slides up a slope and stays there, on its bristles.
  for (const char* integrator :
       {"rosenbrock4", "dopri5", "fehlberg78", "bulirsch_stoer", "adams_bashforth_moulton"})
    check({text("block_on_slope"),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.contact=\"kelvin-voigt\"",
            "penalty.kelvin_stiffness=1e5", "penalty.kelvin_damping=200", "penalty.friction=\"lugre\"",
            "penalty.bristle_stiffness=3e3", "penalty.friction_v0=0.01", "penalty.tolerance=1e-7",
            "bodies.block.velocity=[0.3,0]", "run.duration=0.08", "run.output_step=1e-3"},
           {contact, slide, stick}});
}

TEST_CASE("snapshots: on a film, and where it hands over", "[snapshot]") {
  const auto oiled = [](std::string scene) {
    const std::string surface = "surface = \"steel\"\n";
    scene.insert(scene.find(surface), "bearing_length = 0.02\nlubricant = \"oil\"\n");
    return scene + "[lubricants.oil]\nviscosity = 0.004\nhand_over = 1e-5\n";
  };
  for (const char* integrator : {"dopri5", "adams_bashforth_moulton", "rosenbrock4"})
    check({oiled(rig()),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.tolerance=1e-6",
            "run.duration=0.02", "run.output_step=1e-4"},
           {film}});
}

TEST_CASE("snapshots: springs, dampers, preloaded friction and tables", "[snapshot]") {
  const std::vector knots{0.02, 0.05, 0.07};
  for (const char* integrator : {"dopri5", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"})
    check({loads(),
           "penalty",
           {fmt::format("penalty.integrator=\"{}\"", integrator)},
           {before_knot, behind_knot, contact, flight},
           false,
           true,
           knots});
  check({loads(), "nonsmooth", {}, {before_knot, behind_knot, impact, flight}, false, true, knots});
  check({loads(),
         "nonsmooth",
         {"nonsmooth.scheme=\"event-driven\""},
         {before_knot, behind_knot, impact, flight},
         false,
         true,
         knots});
}

TEST_CASE("snapshots: sparse factors with their pivots, and redundant rows", "[snapshot]") {
  for (const bool forces : {true, false}) {
    for (const char* integrator : {"dopri5", "adams_bashforth_moulton"})
      check({chain(),
             "penalty",
             {fmt::format("penalty.integrator=\"{}\"", integrator), "penalty.tolerance=1e-5",
              "run.duration=0.06", "run.output_step=1e-3"},
             {flight},
             false,
             forces});
    check({chain(),
           "nonsmooth",
           {"nonsmooth.step=5e-4", "run.output_step=1e-3"},
           {flight, impact},
           false,
           forces});
    check({chain(),
           "nonsmooth",
           {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-6", "run.duration=0.2",
            "run.output_step=1e-3"},
           {flight},
           false,
           forces});
  }
  check({text("redundant_rail"),
         "penalty",
         {"penalty.tolerance=1e-5", "run.duration=0.03", "run.output_step=1e-3"},
         {flight}});
  check({text("redundant_rail"),
         "nonsmooth",
         {"nonsmooth.step=5e-4", "run.duration=0.1", "run.output_step=1e-3"},
         {flight}});
  check({text("redundant_rail"),
         "nonsmooth",
         {"nonsmooth.scheme=\"event-driven\"", "nonsmooth.tolerance=1e-6", "run.duration=0.1",
          "run.output_step=1e-3"},
         {flight}});
}

TEST_CASE("snapshots: both nonsmooth schemes, in flight, in contact and at impacts", "[snapshot]") {
  const std::string events = "nonsmooth.scheme=\"event-driven\"", output = "run.output_step=1e-4";
  for (const bool matched : {false, true}) {
    check({rig(),
           "nonsmooth",
           {"run.duration=0.03", "run.discard=0.01", output, "nonsmooth.step=2e-5"},
           {flight, contact, impact, slide},
           matched});
    check({rig(),
           "nonsmooth",
           {"run.duration=0.03", "run.discard=0.01", output, events},
           {flight, contact, impact},
           matched});
  }
  for (const char* law : {"poisson", "energetic"})
    check({rig(),
           "nonsmooth",
           {"run.duration=0.02", output, events, fmt::format("nonsmooth.impact_law=\"{}\"", law)},
           {flight, impact}});
  const std::string stepping = "nonsmooth.scheme=\"moreau-jean\"";
  check({text("block_on_slope"), "nonsmooth", {}, {contact, slide}});
  check({text("block_on_slope"), "nonsmooth", {stepping, "nonsmooth.step=5e-4"}, {contact, slide, stick}});
  check({text("dragged_block"), "nonsmooth", {"run.duration=0.6"}, {contact, slide, stick}});
  check({text("dragged_block"), "nonsmooth", {stepping, "nonsmooth.step=1e-3"}, {contact, slide, stick}});
  check({text("bouncing_ball"), "nonsmooth", {events, "run.output_step=1e-3"}, {flight, impact}});
  check({text("four_bar_two"),
         "nonsmooth",
         {events, "run.duration=0.1", "run.output_step=1e-3"},
         {flight, impact}});
}

TEST_CASE("snapshots: chosen steps, and the default before, within and behind its hand-overs", "[snapshot]") {
  const std::vector<std::string> chosen{"nonsmooth.scheme=\"moreau-jean\"", "nonsmooth.step=\"automatic\""},
      automatic{"nonsmooth.scheme=\"automatic\"", "nonsmooth.step=\"automatic\""};
  const std::vector knots{0.02, 0.05, 0.07};
  for (const auto& way : {chosen, automatic}) {
    const auto set = [&](std::vector<std::string> more) {
      more.insert(more.end(), way.begin(), way.end());
      return more;
    };
    for (const bool matched : {false, true})
      check({rig(),
             "nonsmooth",
             set({"run.duration=0.03", "run.discard=0.01", "run.output_step=1e-4"}),
             {flight, contact, impact},
             matched});
    check({loads(), "nonsmooth", set({}), {before_knot, behind_knot, impact, flight}, false, true, knots});
    check({text("bouncing_ball"), "nonsmooth", set({"run.output_step=1e-3"}), {flight, impact}});
    check({text("block_on_slope"), "nonsmooth", set({"run.output_step=1e-3"}), {contact, slide}});
    check({text("dragged_block"), "nonsmooth", set({"run.duration=0.6"}), {contact, slide, stick}});
    check({chain(),
           "nonsmooth",
           set({"nonsmooth.tolerance=1e-6", "nonsmooth.step_tolerance=1e-4", "run.duration=0.1",
                "run.output_step=1e-3"}),
           {flight}});
    check({test::random_pile(8), "nonsmooth", set({"run.duration=0.1"}), {contact, impact}, false, false});
  }
  // Hands over three times; most of its steps are those of time stepping.
  check({test::random_pile(1), "nonsmooth", {"run.duration=0.443"}, {contact, impact}});
}

TEST_CASE("snapshots: a loose guide's four corners, and every solver of contact problems", "[snapshot]") {
  check({text("free_slider"), "nonsmooth", {"run.output_step=1e-3"}, {flight, impact}});
  check({text("free_slider"),
         "penalty",
         {"penalty.contact=\"kelvin-voigt\"", "penalty.kelvin_stiffness=1e6", "penalty.kelvin_damping=50",
          "surfaces.steel.tangential_restitution=0", "run.output_step=1e-3", "penalty.tolerance=1e-6"},
         {flight, contact, slide}});
  for (const char* solver : {"automatic", "enumeration", "lemke", "gauss-seidel", "newton"})
    for (const char* scene : {"free_slider", "dragged_block", "four_bar_two"}) {
      CAPTURE(scene);
      check({text(scene),
             "nonsmooth",
             {"nonsmooth.scheme=\"moreau-jean\"", fmt::format("nonsmooth.solver=\"{}\"", solver),
              "nonsmooth.step=5e-4", "run.output_step=1e-3", "run.duration=0.2"},
             {std::string_view(scene) == "free_slider" ? impact : contact}});
    }
}

TEST_CASE("snapshots: back to before the first step, in a simulation that has a past", "[snapshot]") {
  const auto check_again = [](const Scene& scene, const std::string& formulation) {
    CAPTURE(formulation, scene.overrides);
    Simulation simulation(scene, formulation);
    const auto empty = simulation.snapshot();
    Record first(simulation, true), second(simulation, true);
    const auto whole = simulation.run({.observers = {&first}});
    REQUIRE(whole.ending.status == Ending::Status::finished);
    simulation.restore(empty);
    REQUIRE(simulation.t() == 0);
    const auto again = simulation.run({.observers = {&second}});
    CHECK((second.steps == first.steps));
    CHECK((second.events == first.events));
    CHECK((second.samples == first.samples));
    CHECK((bits_of(again) == bits_of(whole)));
  };
  for (const char* integrator :
       {"rk4", "dopri5", "fehlberg78", "bulirsch_stoer", "adams_bashforth_moulton", "rosenbrock4"}) {
    const auto with = fmt::format("penalty.integrator=\"{}\"", integrator);
    std::vector<std::string> sets{with, "penalty.tolerance=1e-7", "run.duration=0.012"};
    if (std::string_view(integrator) == "rk4") sets.emplace_back("penalty.step=1e-5");
    check_again(parse_scene(rig(), "snapshot.toml", sets), "penalty");
  }
  for (const char* scheme : {"moreau-jean", "event-driven"}) {
    const auto with = fmt::format("nonsmooth.scheme=\"{}\"", scheme);
    check_again(parse_scene(chain(), "snapshot.toml",
                            {with, "nonsmooth.step=5e-4", "nonsmooth.tolerance=1e-6", "run.duration=0.1"}),
                "nonsmooth");
  }
  for (const char* scheme : {"moreau-jean", "automatic"})
    check_again(parse_scene(test::random_pile(1), "snapshot.toml",
                            {fmt::format("nonsmooth.scheme=\"{}\"", scheme), "run.duration=0.45"}),
                "nonsmooth");
  check_again(parse_scene(chain(), "snapshot.toml", {"penalty.tolerance=1e-7", "run.duration=0.05"}),
              "penalty");
}

TEST_CASE("snapshots: one that begins to be watched behind it", "[snapshot]") {
  // Sparse factors: those of the forces' own are made when somebody first wants forces.
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    const auto scene = parse_scene(chain(), "snapshot.toml",
                                   {"penalty.tolerance=1e-7", "nonsmooth.step=5e-4", "run.duration=0.1"});
    Simulation seen(scene, formulation), restored(scene, formulation);
    seen.run({.until = 0.05});
    restored.restore(seen.snapshot());
    Record a(seen, true), b(restored, true);
    const auto rest = seen.run({.observers = {&a}}), again = restored.run({.observers = {&b}});
    CHECK((a.steps == b.steps));
    CHECK((a.samples == b.samples));
    CHECK_FALSE(a.samples.empty());
    CHECK((bits_of(rest) == bits_of(again)));
  }
}

TEST_CASE("snapshots: another start goes along", "[snapshot]") {
  const auto scene = read_scene(test::scene_file("pendulum"), {"run.duration=0.1", "penalty.tolerance=1e-6"});
  for (const char* formulation : {"penalty", "nonsmooth"}) {
    Simulation first(scene, formulation);
    first.run({.until = 0.05});
    Simulation begun(scene, formulation, {.start = first.state()}), fresh(scene, formulation);
    begun.run({.until = 0.07});
    fresh.restore(begun.snapshot());
    CHECK(fresh.layout().start[0].gap == begun.layout().start[0].gap);
    CHECK((bits_of(fresh.run()) == bits_of(begun.run())));
  }
}

TEST_CASE("snapshots: instruments that rested go on at the present", "[snapshot][instruments]") {
  const auto scene = parse_scene(rig(), "snapshot.toml", {"run.duration=0.03", "penalty.tolerance=1e-7"});
  Simulation rested(scene, "penalty");
  rested.run({.until = 0.0151});
  test::Listener listener;
  double last = 0;
  std::array<double, 5> first{};
  listener.on_sample = [&](std::size_t channel, double t, double) {
    if (first[channel] == 0) first[channel] = t;
    last = std::max(last, t);
  };
  rested.run({.observers = {&listener}});
  CHECK(last <= 0.03 + 1e-9);
  for (std::size_t i = 0; i < first.size(); ++i) {
    CAPTURE(scene.instruments[i].name);
    CHECK(first[i] > 0.0151);
    CHECK(first[i] <= 0.0151 + (1 + 1e-6) / scene.instruments[i].sampling);
  }
}

TEST_CASE("snapshots: through a file and back", "[snapshot][files]") {
  test::TemporaryFolder folder;
  const auto file = folder.path() / "a.snapshot";
  const auto scene = parse_scene(rig(), "snapshot.toml", {"run.duration=0.01", "penalty.tolerance=1e-7"});
  Simulation one(scene, "penalty"), two(scene, "penalty");
  one.run({.until = 0.007});
  const auto s = one.snapshot();
  s.write(file);
  s.write(file);  // over an older one
  const auto r = Snapshot::read(file);
  CHECK(r.t == s.t);
  CHECK(r.program == s.program);
  CHECK(r.formulation == s.formulation);
  CHECK(r.scene == s.scene);
  CHECK((r.memory == s.memory));
  two.restore(r);
  CHECK((bits_of(two.run()) == bits_of(one.run())));
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) CHECK(entry.path() == file);
  CHECK_THROWS_AS(s.write(folder.path() / "none" / "a.snapshot"), SnapshotError);
}

TEST_CASE("snapshots: what does not belong is refused, and nothing is touched", "[snapshot][files]") {
  test::TemporaryFolder folder;
  const std::vector<std::string> set{"run.duration=0.01", "penalty.tolerance=1e-7"};
  const auto scene = parse_scene(rig(), "snapshot.toml", set);
  Simulation simulation(scene, "penalty");
  simulation.run({.until = 0.007});
  const auto own = simulation.snapshot();
  Simulation untouched(scene, "penalty");
  untouched.restore(own);
  const auto rest = bits_of(untouched.run());
  const auto refused = [&](const Snapshot& s, const std::string& why) {
    CHECK_THROWS_AS(simulation.restore(s), SnapshotError);
    CHECK_THROWS_WITH(simulation.restore(s), Contains(why));
    CHECK((simulation.snapshot().memory == own.memory));
  };
  {
    auto set_other = set;
    set_other.push_back("joints.gudgeon.clearance=3e-4");
    Simulation other(parse_scene(rig(), "snapshot.toml", set_other), "penalty");
    refused(other.snapshot(), "joints.gudgeon.clearance is 0.00025 here and 0.0003 there");
    Simulation longer(parse_scene(rig(), "snapshot.toml", {"run.duration=0.02", "penalty.tolerance=1e-7"}),
                      "penalty");
    refused(longer.snapshot(), "run.duration is 0.01 here and 0.02 there");
    Simulation another(read_scene(test::scene_file("pendulum")), "penalty");
    refused(another.snapshot(), "is of another scene");
  }
  Simulation nonsmooth(scene, "nonsmooth"), matched(scene, "nonsmooth", {.matched = true});
  refused(nonsmooth.snapshot(),
          "is of another formulation: formulation is \"penalty\" here and \"nonsmooth\" there");
  CHECK_THROWS_WITH(nonsmooth.restore(matched.snapshot()), Contains("matched is false here and true there"));
  CHECK_THROWS_WITH(matched.restore(nonsmooth.snapshot()), Contains("matched is true here and false there"));
  CHECK_THROWS_WITH(matched.restore(own),
                    Contains("formulation is \"nonsmooth\" here and \"penalty\" there"));
  auto changed = own;
  changed.program = "version = \"9.9.9\"\nsources = \"abc\"\n";
  refused(changed, "was taken by freeplay 9.9.9 (");
  for (const std::size_t size :
       {own.memory.size() - 1, own.memory.size() / 2, std::size_t{5}, std::size_t{0}}) {
    changed = own;
    changed.memory.resize(size);
    refused(changed, "cut short");
  }
  changed = own;
  changed.memory.push_back(std::byte{0});
  refused(changed, "longer than what it should hold");

  // Files.
  const auto file = folder.path() / "a.snapshot";
  own.write(file);
  const auto whole = text_of(file);
  const auto read_refused = [&](const std::string& bytes, const std::string& why) {
    write_file(file, bytes);
    CHECK_THROWS_WITH(Snapshot::read(file), Contains(file.string()) && Contains(why));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  };
  std::mt19937 engine(7);
  const auto body = whole.find('\n') + 1;
  for (const auto size : {whole.size() - 1, whole.size() / 2, body})
    read_refused(whole.substr(0, size), "is damaged");
  read_refused(whole + "x", "is damaged");
  for (const std::size_t size : {std::size_t{0}, std::size_t{4}, body - 1})
    read_refused(whole.substr(0, size), "is no snapshot of freeplay");
  for (int i = 0; i < 50; ++i) {
    auto flipped = whole;
    flipped[body + engine() % (whole.size() - body)] ^= static_cast<char>(1 << engine() % 8);
    read_refused(flipped, "is damaged");
  }
  for (std::size_t i = 0; i < body; ++i) {  // in the line before it
    auto flipped = whole;
    flipped[i] ^= 1;
    write_file(file, flipped);
    CAPTURE(flipped.substr(0, body));
    CHECK_THROWS_AS(Snapshot::read(file), SnapshotError);
  }
  const std::string version = "freeplay snapshot 1 ";
  REQUIRE(whole.starts_with(version));
  read_refused("freeplay snapshot 2 " + whole.substr(version.size()),
               "is a snapshot of version 2; this program reads version 1");
  read_refused("freeplay checkpoint 1 " + whole.substr(version.size()), "is no snapshot of freeplay");
  read_refused("t,x,y\n0,0,0\n", "is no snapshot of freeplay");
  CHECK_THROWS_WITH(Snapshot::read(folder.path()), Contains("is a folder, not a file"));
  CHECK_THROWS_WITH(Snapshot::read(folder.path() / "none"), Contains("none"));

  CHECK((bits_of(simulation.run()) == rest));
}
