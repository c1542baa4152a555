// The command `sensitivity`: zero values and missing derivatives in its result, its figure, and its errors.
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// A ball that is dropped from (0.1, 0.55) with a horizontal speed of −0.25 m/s: x = 0 at the end,
/// after 0.4 s.
const std::string ball = "gravity = [0, -9.81]\n" +
                         test::body("ball", 0.3, 3e-4, "position = [0.1, 0.55]\nvelocity = [-0.25, 0]\n") +
                         test::plane("table", "ground", "ball", 0.05, "hard") + test::surface("hard", 0.5) +
                         test::run_for(0.4, "start = \"given\"\n[nonsmooth]\nscheme = \"event-driven\"\n");

struct Command {
  test::TemporaryFolder folder;
  test::Outcome run(const std::string& words) const {
    const auto place = folder.path().string();
    write_file(folder.path() / "ball.toml", ball);
    return test::freeplay("sensitivity " + place + "/ball.toml -o " + place + "/out " + words);
  }
  nlohmann::json document() const { return test::read_json(folder.path() / "out/sensitivity.json"); }
};

}  // namespace

TEST_CASE("a value of zero and a missing derivative have no relative influence", "[sensitivity]") {
  const Command c;
  const auto run =
      c.run("--of end.ball.x --of event.1.t --of event.9.t --to bodies.ball.position[0] --to gravity[1]");
  CAPTURE(run.out, run.err);
  REQUIRE(run.status == 0);
  const auto q = c.document()["quantities"];
  CHECK(std::abs(q[0]["value"].get<double>()) < 1e-14);
  CHECK(q[0]["derivatives"]["bodies.ball.position[0]"].get<double>() == Approx(1));
  CHECK(q[0]["relative_influence"]["bodies.ball.position[0]"].is_null());
  CHECK(q[0]["condition"].is_null());
  // t = √(2H/g)
  CHECK(q[1]["relative_influence"]["gravity[1]"].get<double>() == Approx(-0.5));
  CHECK(q[1]["condition"].get<double>() == Approx(0.5));
  CHECK(q[1]["error"]["gravity[1]"].get<double>() <
        1e-6 * std::abs(q[1]["derivatives"]["gravity[1]"].get<double>()));
  CHECK(q[1]["inexact"].empty());
  CHECK_THAT(run.out, Contains(" ± "));
  CHECK(q[2]["error"]["gravity[1]"].is_null());
  CHECK(q[2]["condition"].is_null());
}

TEST_CASE("the figure of influences names all its quantities", "[sensitivity]") {
  const Command c;
  const auto run = c.run(
      "--of event.1.t --of event.1.v_n_minus --of event.1.impulse_n --of end.ball.y --of end.ball.vy "
      "--of energy.kinetic --of energy.dissipated_in_contacts --to gravity[1]");
  CAPTURE(run.out, run.err);
  REQUIRE(run.status == 0);
  // two columns of four
  CHECK_THAT(test::file_text(c.folder.path() / "out/figures/sensitivity.gp"), Contains("vertical maxrows 4"));
}

TEST_CASE("the command sensitivity refuses wrong quantities and deviations", "[sensitivity]") {
  const Command c;
  const auto refused = [&](const std::string& words, const std::string& text) {
    const auto run = c.run(words);
    CAPTURE(words, run.out);
    CHECK(run.status != 0);
    CHECK_THAT(run.err, Contains(text));
  };
  refused("--of event.9.t --to gravity[1]", "reaches none of the quantities");
  refused("--of event.1.t --spread gravity[1]=0.1 --spread gravity[1]=0.2", "has a deviation already");
  refused("--of end.bal.y --to gravity[1]", "did you mean ball.y?");
  refused("--of end.t --to gravity[1]", "has no derivative");
}
