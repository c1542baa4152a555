// Published mechanisms.
#include "verification/claims/claim.hpp"
#include "verification/references/loose_guide.hpp"
#include "verification/references/seven_body.hpp"
#include "verification/references/slider_crank.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

void seven_bodies(Findings& f) {
  // Angles of the mechanism are a body's angle, or two bodies' difference, and a constant.
  const struct {
    const char* name;
    int body, less;  // −1: none
    double offset;
  } angles[] = {{"β", 0, -1, 0}, {"Θ", 1, 0, -M_PI},     {"γ", 2, -1, M_PI / 2}, {"φ", 3, 4, M_PI / 2},
                {"δ", 4, -1, 0}, {"Ω", 5, 6, -M_PI / 2}, {"ε", 6, -1, M_PI / 2}};
  const char* const subject = "seven-body mechanism";
  auto scene = read_scene(test::scene_file("seven_body"));
  const auto rates = reference::seven_body_velocities(reference::seven_body_end);
  const auto claim = [&](Family family, const char* how, double bound, const std::string& reason) {
    const auto end = test::simulate(scene, family).final_state;
    for (std::size_t i = 0; i < std::size(angles); ++i) {
      const auto& a = angles[i];
      const auto of = [&](const std::vector<double>& x) {
        return x[3 * a.body + 2] - (a.less < 0 ? 0 : x[3 * a.less + 2]);
      };
      f.within(claim_name(subject, fmt::format("angle {}", a.name), how), "rad", of(end.q) + a.offset,
               reference::seven_body_end[i], bound, "IVP test set, recomputed in long double", reason);
      const auto rate = claim_name(subject, fmt::format("angular velocity of {}", a.name), how);
      const std::string source = "loop closure and energy at the published positions";
      if (std::abs(rates[i]) > 1000)
        f.within(rate, "rad/s", of(end.v), rates[i], 1e-6, source,
                 "1e-9 rad of position is 1e-6 rad/s by the crank's acceleration");
      else
        f.relative(rate, "rad/s", of(end.v), rates[i], 1e-7, source,
                   "1e-9 of the crank's angular velocity, times the change of the transmission ratio");
    }
  };
  const char* const reason = "required accuracy; tolerance 1e-12 per step";
  claim(Family::penalty, "penalty", 1e-9, reason);
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-12;
  claim(Family::nonsmooth, "event-driven", 1e-9, reason);
}

void slider_crank(Findings& f) {
  auto scene = test::read_short(test::flores(), 0.7);
  scene.mechanism = idealised(scene.mechanism);
  const double speed = 200 * 2 * M_PI / 60;
  const auto exact = reference::slider_crank(0.05, 0.3, speed * 0.7, speed);
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    const auto end = test::simulate(scene, family).final_state;
    const bool penalty = family == Family::penalty;
    const char* const name = penalty ? "penalty" : "Moreau–Jean, h = 1e-5 s";
    f.within(claim_name("paper's ideal slider-crank", "slider position after 0.7 s", name), "m", end.q[6],
             exact.x, penalty ? 1e-9 : 1e-8, "loop closure",
             penalty ? "drift at α = β = 5 over 2.3 turns" : "positions are projected at each step");
    f.within(claim_name("paper's ideal slider-crank", "slider velocity after 0.7 s", name), "m/s", end.v[6],
             exact.velocity, penalty ? 1e-7 : 1e-6, "loop closure",
             penalty ? "drift at α = β = 5 over 2.3 turns"
                     : "velocities at the end of a step: (ω h)² of 1 m/s, margin of 20");
  }
}

void rows_of_four_bars(Findings& f) {
  // Twenty seconds through the aligned positions, where the constraint Jacobian loses rank.
  for (const int count : {1, 5}) {
    auto scene = test::row_of_four_bars(count, 0);
    scene.run.duration = 20;
    scene.nonsmooth.step = 1e-3;
    const auto run = test::simulate(scene, Family::nonsmooth);
    const double change = run.ending.status == Ending::Status::finished
                              ? std::abs(run.ledger.kinetic + run.ledger.potential - run.ledger.initial)
                              : INFINITY;
    f.at_most(
        claim_name("row of four-bars through singular positions",
                   fmt::format("energy error after 20 s, {}", count == 1 ? "one four-bar" : "five four-bars"),
                   "Moreau–Jean, h = 1e-3 s"),
        "J", change, 0.1, "0 (IFToMM benchmark A02)", "requirement of the benchmark");
  }
}

void guide(Findings& f) {
  auto scene = read_scene(test::source_folder() / "cases/flores2010-translational/scene.toml");
  scene.nonsmooth.scheme = Scheme::event_driven;
  for (const auto& table : reference::guide_tables) {
    scene.mechanism.bodies[2].angular_velocity = table.slider_speed;
    scene.mechanism.surfaces[0].friction = table.friction;
    scene.mechanism.surfaces[0].tangential_restitution = table.e_T;
    const auto& last = table.impacts.back();
    scene.run.duration = last.t + 1e-6;
    const auto touch = test::touch(test::simulate(scene, Family::nonsmooth), table.impacts.size() - 1);
    const auto subject =
        fmt::format("slider-crank with clearance in the guide, ω₃ = {} rad/s, μ = {}, e_T = {}",
                    table.slider_speed, table.friction, table.e_T);
    f.within(claim_name(subject, fmt::format("time of impact {}", table.impacts.size()), "event-driven"), "s",
             touch.t, last.t, 1e-11, "independent event-driven program",
             "tolerance 1e-10 per step; two runs of the independent program differ by less than 1e-12 s");
    f.relative(claim_name(subject, fmt::format("tangential impulse of impact {}", table.impacts.size()),
                          "event-driven"),
               "N s", touch.impulse_t, last.impulse_t, 1e-7, "independent event-driven program",
               "each impact multiplies an error by a few");
  }
}

/// Free flight of the slider within the guide's clearance during the first 2 ms.
void guide_flight(Findings& f) {
  const reference::LooseGuide m;
  const auto exact = reference::guide_flight(m, 0.002L);
  auto scene = read_scene(test::source_folder() / "cases/flores2010-translational/scene.toml");
  scene.run.duration = 0.002;
  scene.nonsmooth.scheme = Scheme::event_driven;
  const std::string source = "two angles, order 8 in long double",
                    digits = "tolerance 1e-9 of 1 mm per step, some hundred steps; published: ",
                    shift = ", which differs by the error of explicit Euler steps of 0.6e-5 to 8e-5 s";
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    const auto end = test::simulate(scene, family).final_state;
    const auto name = [&](const char* quantity) {
      return claim_name("slider-crank with clearance in the guide, free flight to 2 ms", quantity,
                        family == Family::penalty ? "penalty" : "event-driven");
    };
    f.within(name("crank angle"), "rad", end.q[2], double(exact[0]), 6e-9, source,
             digits + "0.043936 turns, 0.276058 rad" + shift);
    f.within(name("rod angle"), "rad", end.q[5], double(exact[1]), 1e-9, source,
             digits + "−0.135102" + shift);
    f.relative(name("angular velocity of the crank"), "rad/s", end.v[2], double(exact[2]), 1e-7, source,
               digits + "120.824" + shift);
    f.relative(name("angular velocity of the rod"), "rad/s", end.v[5], double(exact[3]), 1e-7, source,
               digits + "−56.680" + shift);
    f.within(name("slider height over clearance"), "", end.q[7] / 1e-3,
             double(reference::guide_height(m, exact)), 1e-6, source, digits + "0.4871" + shift);
  }
}

}  // namespace

Parts mechanisms() { return {seven_bodies, slider_crank, rows_of_four_bars, guide_flight, guide}; }

}  // namespace freeplay::verification
