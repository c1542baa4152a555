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
  OwnLaw law{
      [](const void*, const char*, double, double, double) { return std::nan(""); }, {}, "nothing", "0"};
  SECTION("NaN") {}
  SECTION("its exceptions reach the caller") {
    law.force = [](const void*, const char*, double, double, double) -> double {
      throw std::domain_error("no such depth");
    };
    scene.penalty.own = std::make_shared<OwnLaw>(law);
    Simulation simulation(scene, "penalty");
    CHECK_THROWS_WITH(simulation.run(), "no such depth");
    return;
  }
  scene.penalty.own = std::make_shared<OwnLaw>(law);
  Simulation simulation(scene, "penalty");
  const auto result = simulation.run();
  CHECK(result.ending.status == Ending::Status::failed);
  CHECK(!result.ending.reason.empty());
}

TEST_CASE("a plugin is loaded from its file, and its run can be repeated only with it",
          "[own-law][program]") {
  const test::TemporaryFolder folder;
  const auto scene = read_scene(test::flores());
  const auto h = built_in(scene);
  const auto source = folder.path() / "law.c", plugin = folder.path() / "law.so";
  const auto compiled = [&](const std::string& text) {
    write_file(source, text);
    return std::system(
               fmt::format("cc -O1 -shared -fPIC -o {} {} -lm", plugin.string(), source.string()).c_str()) ==
           0;
  };
  const std::string version = "int freeplay_law_abi(void) { return 1; }\n";
  REQUIRE(compiled(
      version +
      fmt::format(
          "#include <math.h>\ndouble freeplay_normal_force(const char* contact, double d, double rate, "
          "double v0) "
          "{{ return contact[0] == 'g' ? {} * d * sqrt(d) * (1 + {} * rate / v0) : NAN; }}\n",
          h.K, h.chi)));
  const auto place = [&](const char* name) { return (folder.path() / name).string(); };
  const std::string run = fmt::format("run {} --set run.revolutions=0.1 --set run.discard=0 --no-figures ",
                                      test::flores().string());
  REQUIRE(
      test::freeplay(run + "--formulation penalty -o " + place("one") + " --law-plugin " + plugin.string())
          .status == 0);
  CHECK_THAT(test::file_text(place("one") + "/run.json"),
             Contains("law = \\\"law.so\\\"") && Contains("normal forces come from law.so"));
  test::refused("run --no-figures --from " + place("one") + " -o " + place("two"),
                Contains("the run uses normal forces of law.so") && Contains("--law-plugin"));
  test::succeeded("run --no-figures --from " + place("one") + " -o " + place("two") + " --law-plugin " +
                  plugin.string());
  CHECK(test::file_text(place("one") + "/trajectory.csv") ==
        test::file_text(place("two") + "/trajectory.csv"));

  test::refused(run + "--formulation nonsmooth -o " + place("three") + " --law-plugin " + plugin.string(),
                Contains("impact laws have no normal force"));
  const auto refused = [&](const std::string& why) {
    test::refused(run + "--formulation penalty -o " + place("three") + " --law-plugin " + plugin.string(),
                  Contains("is not a plugin of contact forces") && Contains(why));
  };
  REQUIRE(compiled("int freeplay_law_abi(void) { return 2; }\n"));
  refused("freeplay_law_abi() is 2");
  REQUIRE(compiled(version));
  refused("does not export freeplay_normal_force");
  // Cut short anywhere: what is mapped behind a file's end cannot be read.
  REQUIRE(compiled(
      version + "double freeplay_normal_force(const char* c, double d, double r, double v) { return d; }\n"));
  const auto whole = test::file_text(plugin.string());
  REQUIRE(whole.size() > 8192);
  for (std::size_t size = 4; size < whole.size(); size += size < 4096 ? 509 : 1021) {
    CAPTURE(size);
    write_file(plugin, whole.substr(0, size));
    refused("it is incomplete");
  }
  write_file(plugin, "no shared object");
  refused("");
}
