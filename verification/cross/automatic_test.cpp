// The default scheme: event-driven, with a hand-over to time stepping and back where events are more than can be told one by
// one. That it costs nothing where it is not needed, finishes where event-driven does not, and loses nothing on the way.
#include <fmt/format.h>
#include <catch2/catch.hpp>

#include <map>

#include "facade/simulation.hpp"
#include "io/write_scene.hpp"
#include "model/error.hpp"
#include "model/scene.hpp"
#include "values/memory.hpp"
#include "verification/claims/force_balance.hpp"
#include "verification/piles.hpp"
#include "verification/support.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using Bytes = std::vector<std::byte>;

Bytes bits(const std::vector<Event>& events) {
  auto copy = events;
  Bytes bytes;
  MemoryWriter m(bytes);
  m(copy);
  return bytes;
}

Scene with(Scene scene, std::optional<Scheme> scheme) {
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step.reset();
  scene.instruments.clear();
  return scene;
}

/// A ball of e = 0.28 spinning in the corner of floor and wall at 500 rad/s, friction 0.1: once it rolls on the wall it is
/// kicked between the two, tens of thousands of times.
const char* corner = R"(
gravity = [0.0, -9.81]
[bodies.ball]
mass = 1.54325
inertia = 2.15082e-05
position = [-0.029709440263269583, 0.039612587017692776]
velocity = [-0.09117309399792044, 0.2074957040009306]
angular_velocity = -497.985
[surfaces.s]
restitution = 0.281436
friction = 0.1
[contacts.floor]
type = "plane"
between = ["ground", "ball"]
at = [[0, -0.06469845507030915], [0.0, 0.0]]
axis = [1, 0]
radius = 0.005279574543769977
surface = "s"
[contacts.right]
type = "plane"
between = ["ground", "ball"]
at = [[0.06469845507030915, 0], [0.0, 0.0]]
axis = [0, 1]
radius = 0.005279574543769977
surface = "s"
[run]
duration = 3.0
start = "given"
)";

/// A disc that falls without restitution between two steep walls, friction 1: it jams.
const char* wedge = R"(
gravity = [0, -9.81]
[bodies.d]
mass = 1.0
inertia = 0.00125
position = [0.001, 0.13423855596804396]
velocity = [0, -0.5]
[contacts.l]
type = "plane"
between = ["ground", "d"]
axis = [0.7023723340926309, -0.7118097388356455]
radius = 0.05
surface = "s"
[contacts.r]
type = "plane"
between = ["ground", "d"]
axis = [0.7023723340926309, 0.7118097388356455]
radius = 0.05
surface = "s"
[surfaces.s]
restitution = 0.0
friction = 1.0
[run]
start = "given"
duration = 1.5
)";

/// The normal impulses that contacts gave, as steps show them.
class Impulses final : public Observer {
 public:
  struct At {
    double t;
    std::vector<double> sums;  // N s, since the start
  };
  std::vector<At> at;
  Wants wants() const override { return {.forces = true}; }
  void begin(const Layout& layout, const State& state) override {
    elements_.clear();
    for (std::size_t e = 0; e < layout.forces.size(); ++e)
      if (layout.forces[e].kind == ForceElement::Kind::contact) elements_.push_back(e);
    sum_.elements.resize(layout.forces.size());
    sum_.acceleration.resize(state.v.size());
    at.push_back({state.t, std::vector<double>(elements_.size())});
  }
  void step(const Step& step) override {
    sum_.add(1, step.before());
    keep(step.t0);
    step.add_impulse(step.t0, step.t1, sum_);
    sum_.add(1, step.within());
    keep(step.t1);
  }
  /// Of contact k, up to the time t.
  double up_to(double t, std::size_t k) const {
    double sum = 0;
    for (const auto& a : at)
      if (a.t <= t) sum = a.sums[k];
    return sum;
  }

 private:
  void keep(double t) {
    at.push_back({t, {}});
    for (const auto e : elements_) at.back().sums.push_back(sum_.elements[e].fn);
  }
  std::vector<std::size_t> elements_;
  Forces sum_;
};

struct Books {
  Result result;
  double momentum, moment;  // left over, relative
  double impulses;          // of events less those of steps, over the greatest sum
  int out_of_turn = 0;      // events
};

/// Runs a scene by the default scheme and does its books.
Books booked(const Scene& scene) {
  Simulation simulation(scene, "nonsmooth");
  Impulses impulses;
  verification::BalanceWatch balance(scene.mechanism, true, scene.run.duration);
  Books b{simulation.run({.observers = {&impulses, &balance}}), 0, 0, 0};
  b.momentum = balance.linear();
  b.moment = balance.angular();
  // Of each contact touches and losses take turns: an impact is both, a lasting contact ends in a separation.
  const auto contacts = b.result.contacts.size();
  std::vector<bool> lasts(contacts);
  std::vector<double> told(contacts), last(contacts, INFINITY);
  for (const auto& e : b.result.events) {
    const auto k = static_cast<std::size_t>(e.contact);
    b.out_of_turn += lasts[k] != (e.kind == EventKind::separation);
    lasts[k] = e.kind == EventKind::contact;
    last[k] = lasts[k] ? e.t - e.t_uncertainty : INFINITY;
    if (!lasts[k]) told[k] += e.impulse_n;
  }
  double greatest = 0, apart = 0;
  for (std::size_t k = 0; k < contacts; ++k) {
    const double sum = impulses.up_to(last[k] < INFINITY ? last[k] : impulses.at.back().t, k);
    CAPTURE(k, sum, told[k], lasts[k]);
    greatest = std::max(greatest, impulses.at.back().sums[k]);
    apart = std::max(apart, std::abs(sum - told[k]));
  }
  b.impulses = apart / greatest;
  return b;
}

}  // namespace

TEST_CASE("automatic: without a hand-over it is event-driven, bit for bit", "[automatic]") {
  for (const auto* name : {"gudgeon", "big_end", "four_bar", "ring", "bouncing_ball", "block_on_slope"}) {
    CAPTURE(name);
    auto scene = read_scene(test::scene_file(name));
    scene.run.discard = 0;
    const auto automatic = test::simulate(with(scene, Scheme::automatic), Family::nonsmooth),
               events = test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth);
    REQUIRE(automatic.ending.status == Ending::Status::finished);
    CHECK(automatic.work.handovers == 0);
    CHECK(automatic.work.stepped == 0);
    CHECK(automatic.work.rhs == events.work.rhs);
    CHECK((bits(automatic.events) == bits(events.events)));
    CHECK(automatic.notes == events.notes);
  }
  auto rig = read_scene(test::flores());
  const auto automatic = test::simulate(with(rig, Scheme::automatic), Family::nonsmooth),
             events = test::simulate(with(rig, Scheme::event_driven), Family::nonsmooth);
  CHECK(automatic.work.handovers == 0);
  CHECK(events.events.size() > 50);
  CHECK((bits(automatic.events) == bits(events.events)));
}

TEST_CASE("automatic: what event-driven does not finish is finished, and nothing is lost on the way",
          "[automatic]") {
  struct Scene_ {
    const char* name;
    std::string text;
    double duration;
    bool stops;  // event-driven
  };
  for (const auto& s : std::vector<Scene_>{{"corner", corner, 3, true},
                                           {"wedge", wedge, 1.5, true},
                                           {"pile 1", test::random_pile(1), 0.6, false},
                                           {"pile 8", test::random_pile(8), 0.3, false},
                                           {"pile 11", test::random_pile(11), 0.3, false}}) {
    auto scene = parse_scene(s.text, s.name);
    scene.run.duration = s.duration;
    const auto b = booked(with(scene, Scheme::automatic));
    const auto& run = b.result;
    CAPTURE(s.name, run.ending.reason, run.notes, run.work.handovers, run.work.stepped);
    REQUIRE(run.ending.status == Ending::Status::finished);
    REQUIRE(run.work.handovers > 0);
    if (s.stops) {
      const auto events = test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth);
      CHECK(events.ending.status == Ending::Status::failed);
    }
    // Energies are integrated with the state, to nonsmooth.step_tolerance a step.
    CHECK(std::abs(run.ledger.closure()) < 1e-6 * run.ledger.scale());
    CHECK(run.ledger.kinetic + run.ledger.potential < run.ledger.initial + 1e-6 * run.ledger.scale());
    for (const auto& c : run.contacts) CHECK(c.penetration_ratio < 1e-6);
    // Momenta: the same forces and states, integrated to the tolerances.
    // Forces of contacts that are decided together jump within steps, and the run says so.
    const bool together = std::ranges::any_of(
        run.notes, [](const auto& n) { return n.find("decided together jump") != n.npos; });
    if (!together) {
      CHECK(b.momentum < 1e-6);
      CHECK(b.moment < 1e-6);
      // Impulses of a smooth time step are extrapolated in forces and not in events: the difference is what a step may be off,
      // 1e-6 of the scale each, some hundreds of them.
      CHECK(b.impulses < 1e-3);
    }
    CHECK(b.out_of_turn == 0);
    const auto told =
        std::ranges::find_if(run.notes, [](const auto& n) { return n.starts_with("time stepping"); });
    REQUIRE(told != run.notes.end());
    CHECK_THAT(*told, Contains(fmt::format("took over {} times, for {:.3g} s in all", run.work.handovers,
                                           run.work.stepped)));
    CHECK(told->size() > told->find("at most): ") + 20);  // and why
  }
}

TEST_CASE("automatic: laws that time stepping does not have stay with event-driven", "[automatic]") {
  auto scene = read_scene(test::scene_file("gudgeon"));
  scene.run.duration = 0.05;
  scene.run.discard = 0;
  for (const auto law : {ImpactLaw::energetic, ImpactLaw::poisson}) {
    scene.nonsmooth.impact_law = law;
    const auto automatic = test::simulate(with(scene, std::nullopt), Family::nonsmooth),
               events = test::simulate(with(scene, Scheme::event_driven), Family::nonsmooth);
    CHECK(automatic.events.size() > 5);
    CHECK((bits(automatic.events) == bits(events.events)));
  }
  // Where it stops nobody takes over.
  auto stuck = with(parse_scene(wedge, "wedge"), Scheme::automatic);
  stuck.nonsmooth.impact_law = ImpactLaw::energetic;
  const auto run = test::simulate(stuck, Family::nonsmooth);
  CHECK(run.work.handovers == 0);
}

TEST_CASE("automatic: which scheme the keys mean", "[automatic][scene]") {
  const std::string scene = wedge;
  const auto options = [&](const std::string& more) {
    return parse_scene(scene + "[nonsmooth]\n" + more, "keys").nonsmooth;
  };
  CHECK(options("").scheme_in_force() == Scheme::automatic);
  CHECK(options("step = \"automatic\"").scheme_in_force() == Scheme::automatic);
  CHECK(options("step = 1e-4").scheme_in_force() == Scheme::moreau_jean);
  CHECK(options("step = 1e-4").step == 1e-4);
  CHECK(options("scheme = \"event-driven\"").scheme_in_force() == Scheme::event_driven);
  CHECK(options("scheme = \"moreau-jean\"").scheme_in_force() == Scheme::moreau_jean);
  CHECK_FALSE(options("scheme = \"moreau-jean\"").step);
  CHECK_FALSE(options("scheme = \"moreau-jean\"\nstep = \"automatic\"").step);
  CHECK(options("scheme = \"moreau-jean\"\nstep = 1e-4\nstep_tolerance = 1e-5").step_tolerance == 1e-5);
  CHECK_THROWS_WITH(options("step = \"chosen\""), Contains("step") && Contains("automatic"));
  CHECK_THROWS_AS(options("step = \"chosen\""), SceneError);
  CHECK_THROWS_WITH(options("scheme = \"best\""), Contains("automatic") && Contains("moreau-jean"));
  CHECK_THROWS_AS(options("step = 0.0"), SceneError);
  CHECK_THROWS_AS(options("step_tolerance = 0.0"), SceneError);
  CHECK_THROWS_AS(options("step = 1e-4\nimpact_law = \"poisson\""), SceneError);
  CHECK_THROWS_AS(options("scheme = \"moreau-jean\"\nimpact_law = \"poisson\""), SceneError);
  CHECK_NOTHROW(options("impact_law = \"poisson\""));

  // A number and no scheme is the fixed step, digit for digit.
  const auto fixed = test::simulate(parse_scene(scene + "[nonsmooth]\nstep = 1e-3", "a"), Family::nonsmooth),
             named = test::simulate(
                 parse_scene(scene + "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-3", "b"),
                 Family::nonsmooth);
  CHECK(fixed.work.steps == 1500);
  CHECK((bits(fixed.events) == bits(named.events)));
  CHECK(fixed.final_state.q == named.final_state.q);

  // Canonical texts read back, and runs are the same exactly where they are.
  std::map<std::string, std::string> digests;
  for (const char* more :
       {"", "step = \"automatic\"", "scheme = \"automatic\"", "step = 1e-4", "scheme = \"moreau-jean\"",
        "scheme = \"moreau-jean\"\nstep = 1e-4", "scheme = \"event-driven\"", "step_tolerance = 1e-5"}) {
    CAPTURE(more);
    const auto one = parse_scene(scene + "[nonsmooth]\n" + more, "one");
    const auto again = parse_scene(to_toml(one), "again");
    CHECK(to_toml(again) == to_toml(one));
    CHECK(again.nonsmooth.scheme_in_force() == one.nonsmooth.scheme_in_force());
    CHECK(again.nonsmooth.step == one.nonsmooth.step);
    const auto digest = Simulation(one, "nonsmooth").identity().digest();
    CHECK(Simulation(again, "nonsmooth").identity().digest() == digest);
    digests[more] = digest;
  }
  // Identity is by what a scene says: of two schemes never the same.
  CHECK(digests[""] == digests["step = \"automatic\""]);
  for (const char* a :
       {"", "step = 1e-4", "scheme = \"moreau-jean\"", "scheme = \"event-driven\"", "step_tolerance = 1e-5"})
    for (const char* b : {"", "step = 1e-4", "scheme = \"moreau-jean\"", "scheme = \"event-driven\"",
                          "step_tolerance = 1e-5"})
      CHECK((digests[a] == digests[b]) == (std::string(a) == b));
}
