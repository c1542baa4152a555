// Many contacts outside joints: the rest positions of piles of discs in both nonsmooth schemes, and
// the motions that friction admits. The claims of "complementarity" contain the forces in piles and
// random piles.
#include <Eigen/LU>

#include "formulations/contact/contact_problem.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/random_contact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

using test::Disc, test::pile;

Result run(const std::string& text, Scheme scheme) {
  auto scene = parse_scene(text, "pile");
  scene.nonsmooth.scheme = scheme;
  scene.nonsmooth.step = 1e-4;
  return test::simulate(scene, Family::nonsmooth);
}

}  // namespace

TEST_CASE("small piles come to rest in the positions of statics", "[cross][piles]") {
  for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
    CAPTURE(static_cast<int>(scheme));
    // Moreau–Jean corrects penetrations of up to g h² a step; both keep gaps within a ten-millionth
    // of a disc.
    const double near = 1e-7;
    const double R = 0.05;
    // A disc in a groove of two walls at 45 degrees: its centre is √2 R above the bottom.
    auto r = run(pile({{0, 2 * R, R}}, 0, M_PI / 4, 0.3, 0.5, 1), scheme);
    REQUIRE(r.ending.status == Ending::Status::finished);
    CHECK(r.final_state.q[0] == Approx(0).margin(near));
    CHECK(r.final_state.q[1] == Approx(std::sqrt(2) * R).margin(near).epsilon(0));

    // One disc on two touching ones: the force on a lower disc from above and that from the floor
    // pass through both its contacts, so each makes 15 degrees with its normal: the pile is stable
    // for μ > tan 15° = 0.268.
    const std::vector<Disc> pyramid{{0.5, R, R}, {0.5 + 2 * R, R, R}, {0.5 + R, R + std::sqrt(3) * R, R}};
    for (const double mu : {0.25, 0.29}) {
      CAPTURE(mu);
      r = run(pile(pyramid, 2, 0, mu, 0, 0.2), scheme);
      CAPTURE(r.ending.reason);
      REQUIRE(r.ending.status == Ending::Status::finished);
      const double sunk = pyramid[2].y - r.final_state.q[7];
      if (mu < 0.268)
        CHECK(sunk > 1e-3);
      else
        CHECK(std::abs(sunk) < near);
    }
  }
}

TEST_CASE("Painlevé's configuration is reported exactly where the motion is not unique",
          "[contact-problem][painleve]") {
  // One contact with 0 < D_NN ≤ μ|D_NT|, D positive definite. By hand: open needs b_N ≥ 0; stick
  // P = −D⁻¹b within the cone; slip with u_T of sign s has P_N = −b_N/(D_NN − sμ D_NT) ≥ 0 and s
  // u_T ≥ 0.
  test::Random u;
  int unique = 0, more = 0;
  for (int i = 0; i < 400; ++i) {
    ContactProblem p;
    p.reserve(2);
    p.rows = 2;
    const double nn = u(0.2, 1), nt = u(0.3, 1), mu = nn / nt * u(1.05, 2);
    p.D << nn, nt, nt, (nt * nt / nn) * u(1.1, 3);
    p.b << u(), u();
    ContactUnknown c;
    c.normal = 0;
    c.tangent = 1;
    c.friction = mu;
    p.unknowns.push_back(c);
    int motions = p.b[0] >= 0;
    const Eigen::Vector2d P = -p.D.topLeftCorner(2, 2).inverse() * p.b.head(2);
    motions += P[0] > 0 && std::abs(P[1]) <= mu * P[0];
    for (const double s : {1.0, -1.0}) {
      const double Pn = -p.b[0] / (nn - s * mu * nt), slide = p.b[1] + (nt - s * mu * p.D(1, 1)) * Pn;
      motions += Pn > 0 && s * slide > 0;
    }
    const auto modes = p.modes(9);
    REQUIRE(modes.decided);
    REQUIRE(static_cast<int>(modes.motions.size()) == motions);
    const auto result = p.solve();
    REQUIRE(result.solved == (motions > 0));
    CHECK(result.ambiguous == (motions > 1 && p.unknowns[0].impulse_n > 0));
    unique += motions == 1;
    more += motions > 1;
    if (result.ambiguous) {
      const auto text = describe_motions(p, [](int) { return std::string("tip"); });
      CHECK_THAT(text, Catch::Contains("tip open") && Catch::Contains("; or tip"));
    }
  }
  CHECK(unique > 50);
  CHECK(more > 10);
}
