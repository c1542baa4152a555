// User-supplied normal forces: a copy of a built-in law gives the motion of the built-in one, in
// explicit and implicit methods; the provenance reports it; a run is repeated and continued with
// the same law only.
#include "dynamics/system.hpp"
#include "facade/law_plugin.hpp"
#include "formulations/contact/contact_law.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// The built-in law of the rig's contact: the same formula in separate code.
struct Hertz {
  double K, chi;
};

double hertz(const void* context, const char* contact, double delta, double rate, double v0) {
  const auto& h = *static_cast<const Hertz*>(context);
  if (std::string(contact) != "gudgeon") return std::nan("");
  return h.K * delta * std::sqrt(delta) * (1 + h.chi * rate / v0);
}

std::shared_ptr<const OwnLaw> own(const Hertz& h) {
  return std::make_shared<OwnLaw>(OwnLaw{hertz, std::make_shared<Hertz>(h), "hertz", "0123"});
}

Hertz built_in(const Scene& scene) {
  const System system(scene.mechanism);
  const auto law = make_contact_force(scene, system.contact_facts(0));
  return {law.elastic.stiffness, law.chi};
}

}  // namespace

TEST_CASE("a user-supplied copy of a built-in law moves the rig in the same way", "[own-law]") {
  const std::string integrator = GENERATE("adams_bashforth_moulton", "dopri5", "rosenbrock4");
  auto scene = read_scene(test::flores(),
                          {"run.revolutions=0.1", "run.discard=0", "penalty.integrator=" + integrator});
  Simulation inside(scene, "penalty");
  const auto expected = inside.run();
  scene.penalty.own = own(built_in(scene));
  Simulation outside(scene, "penalty");
  const auto found = test::finished(outside);
  REQUIRE(found.events.size() == expected.events.size());
  REQUIRE(found.events.size() >= 2);
  // Explicit methods take the same steps up to the last bits of the formula; an implicit one has
  // its matrix by differences.
  const double bound = integrator == "rosenbrock4" ? 1e-6 : 1e-9;
  for (std::size_t i = 0; i < found.events.size(); ++i) {
    CAPTURE(integrator, i);
    CHECK(found.events[i].t == Approx(expected.events[i].t).epsilon(bound));
    CHECK(found.events[i].impulse_n ==
          Approx(expected.events[i].impulse_n).epsilon(100 * bound).margin(1e-9));
  }
  // The elastic energy by quadrature: the balance closes as for the built-in law.
  CHECK(std::abs(found.ledger.closure()) < 1e-6 * found.ledger.scale());
  CHECK(found.ledger.elastic == Approx(expected.ledger.elastic).margin(1e-9));
}

TEST_CASE("a user-supplied law is reported, and an impact law cannot be matched with it", "[own-law]") {
  auto scene = read_scene(test::flores(), {"run.revolutions=0.05", "run.discard=0"});
  const auto before = Simulation(scene, "penalty").identity();
  const auto h = built_in(scene);
  scene.penalty.own = own(h);
  Simulation outside(scene, "penalty");
  CHECK(outside.identity().digest() != before.digest());
  CHECK_THAT(outside.identity().formulation,
             Contains("law = \"hertz\"") && Contains("law_digest = \"0123\""));
  const auto result = outside.run();
  REQUIRE(!result.notes.empty());
  CHECK_THAT(result.notes[0], Contains("normal forces come from hertz (digest 0123)"));
  CHECK(std::isnan(result.contacts[0].model.restitution_delivered));
  CHECK_THROWS_WITH(Simulation(scene, "nonsmooth", {.matched = true}),
                    Contains("the effective restitution of hertz is unknown"));
  // Of an impact law it is no part.
  CHECK(Simulation(scene, "nonsmooth").identity().formulation.find("law") == std::string::npos);
  // A snapshot requires the law that it was taken with.
  const auto snapshot = outside.snapshot();
  auto other = scene;
  other.penalty.own.reset();
  CHECK_THROWS_AS(Simulation(other, "penalty").restore(snapshot), SnapshotError);
}

TEST_CASE("a law that returns no finite number stops the run with its reason", "[own-law]") {
  auto scene = read_scene(test::flores(), {"run.revolutions=0.1", "run.discard=0"});
  const auto run = [&](auto force) {
    scene.penalty.own = std::make_shared<OwnLaw>(OwnLaw{force, {}, "nothing", "0"});
    return Simulation(scene, "penalty").run();
  };
  const auto result = run([](const void*, const char*, double, double, double) { return std::nan(""); });
  CHECK(result.ending.status == Ending::Status::failed);
  CHECK(!result.ending.reason.empty());
  // Its exceptions reach the caller.
  CHECK_THROWS_WITH(run([](const void*, const char*, double, double, double) -> double {
                      throw std::domain_error("no such depth");
                    }),
                    "no such depth");
}
