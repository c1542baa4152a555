// Friction laws at the same regularisation speed, against the inverse of each law's formula.
#include "formulations/contact/friction_law.hpp"
#include "formulations/contact/law_curves.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

TEST_CASE("each friction law reaches 95 % of kinetic friction at the regularisation speed", "[laws]") {
  const double v = 3e-3;
  const PenaltyOptions o;
  // c(v) = 0.95 μ solved for v₀, or for v₁ with v₀ = 0; bisection to rounding.
  const auto v0 = [&](FrictionLaw law) {
    const auto found = regularised(facts_of(law), o, v);
    REQUIRE(found);
    CHECK(make_friction(*found, 1).steady(v) == Approx(0.95).epsilon(1e-12));
    CHECK(regularisation_speed(facts_of(law), *found).value_or(0) == Approx(v).epsilon(1e-12));
    return law == FrictionLaw::ambrosio ? found->friction_v1 : found->friction_v0;
  };
  CHECK(v0(FrictionLaw::ambrosio) == Approx(v / 0.95));
  CHECK(v0(FrictionLaw::threlfall) == Approx(3 * v / std::log(20)));
  CHECK(v0(FrictionLaw::bengisu_akay) == Approx(v / (1 - std::sqrt(0.05))));
  CHECK(v0(FrictionLaw::brown_mcphee) == Approx(4 * v / std::atanh(0.95)));
  CHECK(v0(FrictionLaw::andersson) == Approx(v / std::atanh(0.95)));
  for (const auto law : {FrictionLaw::lugre, FrictionLaw::mindlin}) {
    CHECK_FALSE(regularised(facts_of(law), o, v));
    CHECK_FALSE(regularisation_speed(facts_of(law), o));
  }
  // Creep under half of the kinetic friction.
  const auto creep = [&](FrictionLaw law) {
    return creep_speed(facts_of(law), regularised(facts_of(law), o, v).value_or(o), 0.5);
  };
  CHECK(creep(FrictionLaw::ambrosio) == Approx(0.5 / 0.95 * v));
  CHECK(creep(FrictionLaw::threlfall) == Approx(std::log(2) / std::log(20) * v));
  CHECK(creep(FrictionLaw::andersson) == Approx(std::atanh(0.5) / std::atanh(0.95) * v));
}

TEST_CASE("with static friction the regularisation speed is the first at which 95 % are reached", "[laws]") {
  PenaltyOptions o;
  o.friction_static = 1.5;
  // 1.5 [1 − (x − 1)²] = 0.95 with x < 1.
  const auto found = regularised(facts_of(FrictionLaw::bengisu_akay), o, 1e-3);
  REQUIRE(found);
  CHECK(found->friction_v0 == Approx(1e-3 / (1 - std::sqrt(1 - 0.95 / 1.5))));
}
