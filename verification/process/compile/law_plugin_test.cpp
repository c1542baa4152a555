// Plugins of user-supplied forces, compiled from C: run by the program, required on repetition, and
// refused if incomplete. own_law_test.cpp and own_force_test.cpp test the forces themselves.
#include "dynamics/system.hpp"
#include "formulations/contact/contact_law.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

const std::string version = "int freeplay_law_abi(void) { return 1; }\n";

/// A folder with a plugin, and runs with it.
struct Desk {
  test::TemporaryFolder folder;
  std::string at(const std::string& name) const { return (folder.path() / name).string(); }
  std::string plugin = at("law.so"), with = " --law-plugin " + plugin;

  bool compiled(const std::string& text) const {
    write_file(at("law.c"), text);
    return std::system(fmt::format("cc -O1 -shared -fPIC -o {} {} -lm", plugin, at("law.c")).c_str()) == 0;
  }
  /// A run can be repeated only with its plugin, and then has the same rows.
  void check_repetition(const std::string& name, const char* used) const {
    const auto again = "run --no-figures --from " + at(name) + " -o " + at(name + "-again");
    test::refused(again, Contains(used) && Contains("--law-plugin"));
    test::succeeded(again + with);
    CHECK(test::file_text(at(name + "/trajectory.csv")) ==
          test::file_text(at(name + "-again/trajectory.csv")));
  }
};

}  // namespace

TEST_CASE("a plugin with loads only runs in both formulations and is required on repetition", "[own-force]") {
  const Desk desk;
  REQUIRE(desk.compiled(
      version +
      "#include <stddef.h>\n"
      "const char* const* freeplay_loads(void) { static const char* const n[] = {\"hand\", NULL}; "
      "return n; }\n"
      "void freeplay_load_force(const char* load, double t, const double* r, const double* v, double* f) {\n"
      "  f[0] = load[0] == 'h' ? 3 - 40 * r[0] - 1.5 * v[0] : t, f[1] = 0;\n}\n"));
  write_file(desk.at("block.toml"), test::body("block", 2, 0.1) +
                                        "[loads.hand]\ntype = \"force\"\nbody = \"block\"\nforce = [0, 0]\n" +
                                        test::run_for(1.5, "start = \"given\"\n"));
  // The step response of a damped oscillator: m = 2 kg, k = 40 N/m, c = 1.5 N s/m, F = 3 N.
  const double decay = 1.5 / 4, w = std::sqrt(20 - decay * decay);
  const double end =
      3.0 / 40 * (1 - std::exp(-decay * 1.5) * (std::cos(w * 1.5) + decay / w * std::sin(w * 1.5)));
  for (const std::string formulation : {"penalty", "nonsmooth"}) {
    test::succeeded("run --no-figures --formulation " + formulation + desk.with + " -o " +
                    desk.at(formulation) + " " + desk.at("block.toml"));
    const test::Columns rows(desk.at(formulation + "/trajectory.csv"));
    CHECK(rows.at(rows.rows() - 1, "block.x") == Approx(end).margin(1e-5));
    desk.check_repetition(formulation, "the run uses the force of hand of law.so");
  }
  test::refused("run --no-figures --formulation penalty" + desk.with + " -o " + desk.at("no") + " " +
                    test::flores().string(),
                Contains("hand is not one; the scene has none"));
}

TEST_CASE("a run uses the contact forces of a plugin, records it, and is repeated only with it",
          "[own-law]") {
  const Desk desk;
  const auto scene = read_scene(test::flores());
  const System system(scene.mechanism);
  // The scene's own law again, as C (own_law_test.cpp compares forces); NaN for any contact but the gudgeon.
  const auto law = make_contact_force(scene, system.contact_facts(0));
  REQUIRE(desk.compiled(
      version +
      fmt::format(
          "#include <math.h>\ndouble freeplay_normal_force(const char* contact, double d, double rate, "
          "double v0) "
          "{{ return contact[0] == 'g' ? {} * d * sqrt(d) * (1 + {} * rate / v0) : NAN; }}\n",
          law.elastic.stiffness, law.chi)));
  const std::string run = fmt::format("run {} --set run.revolutions=0.1 --set run.discard=0 --no-figures{} ",
                                      test::flores().string(), desk.with);
  test::succeeded(run + "--formulation penalty -o " + desk.at("one"));
  CHECK_THAT(test::file_text(desk.at("one/run.json")),
             Contains("law = \\\"law.so\\\"") && Contains("normal forces come from law.so"));
  desk.check_repetition("one", "the run uses normal forces of law.so");
  test::refused(run + "--formulation nonsmooth -o " + desk.at("three"),
                Contains("impact laws have no normal force"));
}

TEST_CASE("a file that is no complete plugin of contact forces is refused with the reason", "[own-law]") {
  const Desk desk;
  const auto refused = [&](const std::string& why) {
    test::refused("run " + test::flores().string() + " --no-figures --formulation penalty" + desk.with +
                      " -o " + desk.at("none"),
                  Contains("is not a plugin of contact forces") && Contains(why));
  };
  REQUIRE(desk.compiled("int freeplay_law_abi(void) { return 2; }\n"));  // the program's is 1
  refused("freeplay_law_abi() is 2");
  REQUIRE(desk.compiled(version));
  refused("does not export freeplay_normal_force");
  write_file(desk.plugin, "no shared object");
  refused("");  // in the loader's own words

  // Loading a truncated file would end the program by SIGBUS. Cut it from its four-byte ELF mark on, at
  // more places in the first page, which has the headers.
  REQUIRE(desk.compiled(
      version + "double freeplay_normal_force(const char* c, double d, double r, double v) { return d; }\n"));
  const auto whole = test::file_text(desk.plugin);
  REQUIRE(whole.size() > 8192);  // some cuts are beyond the first page
  for (std::size_t size = 4; size < whole.size(); size += size < 4096 ? 509 : 1021) {
    CAPTURE(size);
    write_file(desk.plugin, whole.substr(0, size));
    refused("it is incomplete");
  }
}
