// Cases of other programs (cases/published), each with an independent reference, here contact
// problems: Exudyn's contact tests, tests 1 to 4 of Chung and Ooi, rows of balls,
// a ball against a rod, and a joint with backlash. The scenes are in cases/published.
#include "verification/claims/claim.hpp"
#include "verification/references/published/newtons_cradle.hpp"
#include "verification/references/published/single_impacts.hpp"
#include "verification/references/published/spring_damper_contacts.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

/// Claims on the end of a fall onto a floor with a linear spring and damper.
void fall_on_linear_floor(Findings& f, const char* name, const char* subject,
                          const reference::LinearContact::State& exact, double stepping_bound,
                          const char* stepping_reason) {
  const double height = double(exact.gap + reference::exudyn_radius), speed = double(exact.rate);
  const std::string source = "parabolas and damped oscillations joined at roots, in long double",
                    reason = "tolerance 1e-12 of a length of 0.1 m and more, over some 400 steps";
  const auto claim = [&](const Result& run, const char* scheme, double bound, double times,
                         const std::string& why) {
    f.within(claim_name(subject, "height at the end", scheme), "m", run.final_state.q[1], height, bound,
             source, why);
    f.within(claim_name(subject, "velocity at the end", scheme), "m/s", run.final_state.v[1], speed,
             bound * times, source, why + "; velocity: the bound of the height over the shortest flight");
  };
  const auto scene = read_scene(test::published(name));
  claim(test::finished(test::penalty, scene), "penalty, bump stop", 4e-11, 10, reason);
  claim(test::finished(test::event_driven, scene), "event-driven, bump stop", 4e-11, 10, reason);
  claim(test::finished(test::fixed_steps(1e-6), scene), "Moreau–Jean, h = 1e-6 s, bump stop", stepping_bound,
        10, stepping_reason);
  const auto contact = read_scene(test::published(name).parent_path() / "contact.toml");
  claim(test::finished(test::penalty, contact), "penalty, contact", 4e-11, 10, reason);
}

void exudyn_contacts(Findings& f) {
  const char *const damped = "Exudyn's contactCoordinateTest", *const elastic =
                                                                   "Exudyn's postNewtonStepContactTest";
  fall_on_linear_floor(
      f, "exudyn-contact-coordinate", damped,
      reference::exudyn_contact_coordinate(false).at(0.25L, reference::exudyn_contact_coordinate_start), 1e-4,
      "first order: the damper's force, 800 m/s² at onset, is up to h too early or late at each of two "
      "impacts; 0.1 s of flight follow");
  fall_on_linear_floor(f, "exudyn-post-newton", elastic,
                       reference::exudyn_post_newton().at(0.5L, reference::exudyn_post_newton_start), 1.4e-7,
                       "k v h²/(2 m) at each of six changes of contact, 4.4e-8 m/s, over 0.5 s");
}

/// The impact of a run against Hertz's closed form and, where one was read, the published figure.
void hertz_impact(Findings& f, const std::string& subject, const Scene& scene, double stiffness,
                  const reference::ElasticImpact& exact, double speed, double onset) {
  const auto run = test::finished(test::penalty, scene);
  const auto touch = test::touch(run, 0);
  const auto& contact = run.contacts[0];
  const std::string hertz = "Hertz 1881: energy of K δ^(3/2)",
                    fine = "rk4 with 4,000 steps or more in the contact: order 5/2";
  const auto name = [&](const char* what) { return claim_name(subject, what, "penalty, Hertz"); };
  f.relative(name("contact stiffness"), "N/m^1.5", contact.model.stiffness, stiffness, 1e-12, "4/3 E* √R",
             "rounding");
  f.relative(name("greatest overlap"), "m", contact.penetration, exact.depth, 1e-6, hertz,
             "evaluated at the ends of steps: too small by up to (h ω)²/8 = 1e-7");
  f.relative(name("greatest force"), "N", contact.model.stiffness * std::pow(contact.penetration, 1.5),
             exact.force, 1.5e-6, hertz, "3/2 of the overlap's bound");
  f.relative(name("duration"), "s", touch.duration, exact.duration, 1e-7, "2.9432755… δ/v", fine);
  f.relative(name("impulse"), "N s", touch.impulse_n, exact.impulse, 1e-8, "2 m v", fine);
  f.relative(name("separation speed"), "m/s", touch.v_n_plus, speed, 1e-8, "conservation of energy", fine);
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-6, "Moreau–Jean, h = 1e-6 s")}) {
    const auto rigid = test::touch(test::finished(way, scene), 0);
    f.within(claim_name(subject, "time of the impact", way.name), "s", rigid.t, onset,
             way.stepping() ? 1e-6 : 1e-15, "gap over speed", way.stepping() ? "one step" : "rounding");
    f.relative(claim_name(subject, "impulse", way.name), "N s", rigid.impulse_n, exact.impulse, 1e-12,
               "2 m v", "rounding");
  }
}

/// Replaces the material of all bodies; `factor` of Young's modulus: 2 against a rigid plane.
void make_of(Scene& scene, const reference::ChungOoiSphere& sphere, double factor) {
  for (auto& body : scene.mechanism.bodies) body.mass = sphere.mass(), body.inertia = sphere.inertia();
  scene.mechanism.surfaces[0].young = factor * sphere.young;
  scene.mechanism.surfaces[0].poisson = sphere.poisson;
}

constexpr const char* paper = "Chung and Ooi 2011, figures as digitised by Kratos";
constexpr const char* percent = "reading: 1 % of the axis of the figure";

void chung_ooi_elastic(Findings& f) {
  const auto read = [&](const char* subject, const Scene& scene, const reference::ChungOoiReading& figure,
                        double axis) {
    const auto run = test::finished(test::penalty, scene);
    const auto& contact = run.contacts[0];
    const auto force = [&](double overlap) { return contact.model.stiffness * std::pow(overlap, 1.5) / 1e3; };
    const auto name = [&](const char* what) { return claim_name(subject, what, "penalty, Hertz"); };
    f.within(name("greatest force against the published figure"), "kN", force(contact.penetration),
             figure.force, 0.12, paper, percent);
    f.within(name("force at an overlap of the published figure"), "kN", force(figure.overlap * 1e-6),
             figure.force_at_overlap, 0.12, paper, percent);
    f.within(name("duration against the published figure"), "µs", test::touch(run, 0).duration * 1e6,
             figure.duration, axis / 100, paper, percent);
  };
  using Sphere = reference::ChungOoiSphere;
  // Each test has two materials; those of the scene have published figures.
  const auto claim = [&](const char* name, bool plane, double onset, const char* subject,
                         const Sphere& sphere, const reference::ChungOoiReading& figure, double axis,
                         const char* second_subject, const Sphere& second) {
    auto scene = read_scene(test::published(name));
    const auto hertz = [&](const char* title, const Sphere& s) {
      if (plane)
        hertz_impact(f, title, scene, s.plane_stiffness(), s.plane_impact(), s.speed, onset);
      else
        hertz_impact(f, title, scene, s.pair_stiffness(), s.pair_impact(), 2 * s.speed, onset);
    };
    hertz(subject, sphere);
    read(subject, scene, figure, axis);
    make_of(scene, second, plane ? 2 : 1);
    hertz(second_subject, second);
  };
  claim("chung-ooi-1", false, 5e-5, "Chung and Ooi 1, two glass spheres", reference::chung_ooi_glass,
        reference::chung_ooi_1_read, 60, "Chung and Ooi 1, two limestone spheres",
        reference::chung_ooi_limestone);
  claim("chung-ooi-2", true, 5e-4, "Chung and Ooi 2, aluminium sphere and rigid plane",
        reference::chung_ooi_aluminium, reference::chung_ooi_2_read, 800,
        "Chung and Ooi 2, magnesium sphere and rigid plane", reference::chung_ooi_magnesium);
}

std::array<test::Way, 3> schemes_of_impact() {
  return {test::penalty, test::event_driven, test::fixed_steps(1e-6, "Moreau–Jean, h = 1e-6 s")};
}

void chung_ooi_restitution(Findings& f) {
  auto scene = read_scene(test::published("chung-ooi-3"));
  for (const double e : {0.2, 0.4, 0.6, 0.8, 1.0})
    for (const auto& way : schemes_of_impact()) {
      scene.mechanism.surfaces[0].restitution = e;
      const auto touch = test::touch(test::finished(way, scene), 0);
      f.within(claim_name("Chung and Ooi 3, sphere and rigid plane",
                          fmt::format("delivered restitution at e = {}", e), way.name),
               "", -touch.v_n_plus / touch.v_n_minus, e, way.penalty() ? 1e-7 : 1e-12,
               "Chung and Ooi 2011: the restitution that is asked for",
               way.penalty() ? "tolerance 1e-12 per step of a ratio of speeds" : "rounding");
    }
}

struct Rebound {
  double restitution, spin, angle;
};
/// Of test 4 at the angle from the normal.
Rebound oblique_rebound(Scene scene, double degrees, const test::Way& way) {
  const auto& sphere = reference::chung_ooi_oxide;
  const double a = degrees * M_PI / 180, v = sphere.speed * std::sin(a);
  scene.mechanism.bodies[0].velocity = {v, -sphere.speed * std::cos(a)};
  const auto end = test::finished(way, scene).final_state.v;
  return {end[0] / v, -end[2], std::atan2(end[0] + sphere.radius * end[2], end[1]) * 180 / M_PI};
}

void chung_ooi_oblique(Findings& f) {
  const auto scene = read_scene(test::published("chung-ooi-4"));
  const char* const subject = "Chung and Ooi 4, oblique impact";
  for (const double degrees : {20.0, 40.0, 60.0, 80.0})
    for (const auto& way : schemes_of_impact()) {
      const auto exact = reference::chung_ooi_rebound(degrees);
      const auto found = oblique_rebound(scene, degrees, way);
      // What remains of the sliding speed, in the penalty formulation: at most friction_v1.
      const double V = reference::chung_ooi_oxide.speed, r = reference::chung_ooi_oxide.radius,
                   slip = exact.slides || !way.penalty() ? 0 : 1e-3;
      const double t = way.penalty() ? 1e-7 : 1e-12;
      const auto name = [&](const char* what) {
        return claim_name(subject, fmt::format("{} at {}°", what, degrees), way.name);
      };
      const std::string source = exact.slides ? "impulse of gross sliding, v − μ (1 + e) V cos θ"
                                              : "rolling of a rigid sphere, 5/7 of the tangential speed",
                        reason = slip > 0        ? "friction falls to 0 from friction_v1 = 1e-3 m/s on"
                                 : way.penalty() ? "tolerance 1e-12 per step of a ratio of speeds"
                                                 : "rounding";
      const double radian = degrees * M_PI / 180;
      f.within(name("tangential restitution"), "", found.restitution, exact.tangential_restitution,
               t + 2.0 / 7 * slip / (V * std::sin(radian)), source, reason);
      f.within(name("spin"), "rad/s", found.spin, exact.spin, t * V / r + 5.0 / 7 * slip / r, source, reason);
      f.within(name("angle of rebound of the contact point"), "°", found.angle, exact.angle,
               60 * (t + slip / (V * std::cos(radian))), source, reason + ", in degrees");
    }
  for (const auto& point : reference::chung_ooi_4_read) {
    const auto name = [&](const char* what, double degrees) {
      return claim_name(subject, fmt::format("{} at {:.0f}° against the published figure", what, degrees),
                        "event-driven");
    };
    const auto at = [&](double degrees) { return oblique_rebound(scene, degrees, test::event_driven); };
    f.within(name("tangential restitution", point.restitution.at), "", at(point.restitution.at).restitution,
             point.restitution.value, 0.006, paper, percent);
    f.within(name("spin", point.spin.at), "rad/s", at(point.spin.at).spin, point.spin.value, 8, paper,
             percent);
    f.within(name("angle of rebound of the contact point", point.angle.at), "°", at(point.angle.at).angle,
             point.angle.value, 1.2, paper, percent);
  }
}

/// Claims on the velocities of a row of balls at the end of a run.
void velocities_of_balls(Findings& f, const std::string& subject, const Scene& scene, const test::Way& way,
                         const std::vector<long double>& exact, double bound, const std::string& source,
                         const std::string& reason) {
  const auto end = test::finished(way, scene).final_state;
  for (std::size_t i = 0; i < exact.size(); ++i)
    f.within(claim_name(subject, fmt::format("velocity of ball {}", i + 1), way.name), "m/s", end.v[3 * i],
             double(exact[i]), bound, source, reason);
}

void rows_with_gaps(Findings& f) {
  const test::Way stepping = test::fixed_steps(1e-5, "Moreau–Jean, h = 1e-5 s");
  const auto claim = [&](const char* name, const std::string& subject, double e,
                         const reference::BallRow& row, double duration) {
    auto scene = read_scene(test::published(name));
    scene.mechanism.surfaces[0].restitution = e;
    scene.run.duration = duration;
    for (std::size_t i = 0; i < row.mass.size(); ++i) scene.mechanism.bodies[i].mass = double(row.mass[i]);
    auto after = row;
    after.collide(e);
    for (const auto& way : {test::penalty, test::event_driven, stepping})
      velocities_of_balls(f, subject, scene, way, after.velocity,
                          way.penalty() ? (e < 1 ? 1e-7 : 1e-9) : 1e-12, "sequence of binary impacts",
                          way.penalty() ? "tolerance 1e-12 per step, some 1000 steps; restitution: 1e-7"
                                        : "rounding: each impact has its own event or step");
  };
  claim("newtons-cradle-3-gaps", "three balls with gaps", 1, {{1, 1, 1}, {1, 0, 0}, {0.05L, 0.001L}}, 0.1);
  claim("newtons-cradle-3-gaps", "three balls with gaps, e = 0.9", 0.9,
        {{1, 1, 1}, {1, 0, 0}, {0.05L, 0.001L}}, 1);
  claim("newtons-cradle-3-unequal", "three balls of masses 1, 2, 3 with gaps", 1,
        {{1, 2, 3}, {1, 0, 0}, {0.05L, 0.001L}}, 0.1);
  claim("newtons-cradle-3-unequal", "three balls of masses 3, 2, 1 with gaps", 1,
        {{3, 2, 1}, {1, 0, 0}, {0.05L, 0.001L}}, 0.1);
  claim("newtons-cradle-5-gaps", "five balls with gaps", 1,
        {{1, 1, 1, 1, 1}, {1, 0, 0, 0, 0}, {0.05L, 0.001L, 0.001L, 0.001L}}, 0.1);
  claim("newtons-cradle-5-two-strikers", "two balls strike three, with gaps", 1,
        {{1, 1, 1, 1, 1}, {1, 1, 0, 0, 0}, {0.001L, 0.05L, 0.001L, 0.001L}}, 0.1);
}

template <std::size_t N>
void touching_balls(Findings& f, const char* name, const std::string& subject,
                    const std::array<long double, N>& before) {
  auto scene = read_scene(test::published(name));
  double momentum = 0;
  std::size_t strikers = 0;
  for (std::size_t i = 0; i < N; ++i) {
    scene.mechanism.bodies[i].velocity = {double(before[i]), 0};
    momentum += double(before[i]);
    if (before[i] > 0) strikers = i + 1;
  }
  // The strikers touch each other, and their last one is 50 mm from the row.
  for (std::size_t i = 0; i < N; ++i)
    scene.mechanism.bodies[i].position = {0.2 * double(i) + (i < strikers ? 0 : 0.05), 0};
  const auto after = reference::touching_row_velocities<N>(before);
  velocities_of_balls(f, subject, scene, test::penalty, {after.begin(), after.end()}, 1e-9,
                      "Hertz contacts, method of order 8 in long double",
                      "tolerance 1e-12 of the speed, some 600 steps");
  const auto end = test::finished(test::penalty, scene).final_state;
  double sum = 0;
  for (std::size_t i = 0; i < N; ++i) sum += end.v[3 * i];
  f.within(claim_name(subject, "momentum after the impact", "penalty"), "N s", sum, momentum, 1e-12,
           "conservation of momentum", "forces of action and reaction are equal: rounding");
  f.within(claim_name(subject, "kinetic energy after the impact", "penalty"), "J",
           test::kinetic_energy(scene, end), momentum / 2, 1e-9, "conservation of energy",
           "bound of the velocities");
}

void touching_rows(Findings& f) {
  touching_balls<3>(f, "newtons-cradle-3-touching", "one ball strikes two that touch", {1, 0, 0});
  touching_balls<5>(f, "newtons-cradle-5-touching", "one ball strikes four that touch", {1, 0, 0, 0, 0});
  touching_balls<5>(f, "newtons-cradle-5-touching", "two touching balls strike three that touch",
                    {1, 1, 0, 0, 0});
  // Rigid balls: Newton's law at all contacts simultaneously.
  for (const auto& way : {test::event_driven, test::fixed_steps(1e-5, "Moreau–Jean, h = 1e-5 s")}) {
    const auto claim = [&](const char* name, const char* subject, long double n) {
      std::vector<long double> after{(1 - n) / (n + 1)};
      after.resize(std::size_t(n) + 1, 2 / (n + 1));
      velocities_of_balls(f, subject, read_scene(test::published(name)), way, after, 1e-12,
                          "Newton's law at all contacts: (1 − n)/(1 + n) and 2/(1 + n)", "rounding");
    };
    claim("newtons-cradle-3-touching", "one ball strikes two that touch", 2);
    claim("newtons-cradle-5-touching", "one ball strikes four that touch", 4);
  }
}

void ball_and_rod(Findings& f) {
  auto scene = read_scene(test::published("ball-and-rod"));
  const char* const subject = "ball against a free rod";
  const reference::BallAndRod exact{0.5, 1, 1.0 / 12, 0.3, 2, 0.5};
  const test::Way stepping = test::fixed_steps(1e-5, "Moreau–Jean, h = 1e-5 s");
  for (const auto& way : {test::penalty, test::event_driven, stepping}) {
    const auto run = test::finished(way, scene);
    const auto claim = [&](const char* what, const char* unit, double measured, double expected) {
      f.relative(claim_name(subject, what, way.name), unit, measured, expected, way.penalty() ? 1e-4 : 1e-12,
                 "impulse of the effective mass",
                 way.penalty() ? "contact time: the rod turns by 3e-4 rad in 0.11 ms" : "rounding");
    };
    claim("impulse", "N s", test::touch(run, 0).impulse_n, exact.impulse());
    claim("velocity of the ball", "m/s", run.final_state.v[4], -exact.ball_speed());
    claim("velocity of the rod", "m/s", run.final_state.v[1], -exact.rod_speed());
    claim("angular velocity of the rod", "rad/s", run.final_state.v[2], -exact.spin());
    claim("energy loss", "J", run.ledger.contact, exact.loss());
  }
  scene.mechanism.bodies[1].position = {reference::slender_rod_percussion(1), 0.06};
  for (const auto& way : {test::event_driven, stepping}) {
    const auto end = test::finished(way, scene).final_state;
    f.within(claim_name(subject, "velocity of the far end, struck at the centre of percussion", way.name),
             "m/s", end.v[1] - 0.5 * end.v[2], 0, 1e-12, "J/(M s) = L/2", "rounding");
  }
}

void backlash_joint(Findings& f) {
  const test::Way stepping = test::fixed_steps(1e-6, "Moreau–Jean, h = 1e-6 s");
  const std::string source = "closed forms between changes of contact, joined at roots",
                    tolerance = "tolerance 1e-12 per step, some 10⁴ steps";
  {
    const char* const subject = "rotor in backlash against a locked load";
    const auto& b = reference::backlash_free;
    auto scene = read_scene(test::published("backlash-joint-free"));
    const auto end = b.at(0.2L, reference::backlash_free_start);
    for (const auto& way : {test::penalty, test::event_driven, stepping}) {
      const auto q = test::finished(way, scene).final_state;
      const std::string late =
          "the damper's couple, (c/J) ω, is up to h too early or late at each of six contacts";
      f.within(claim_name(subject, "angle after 0.2 s, six contacts", way.name), "rad", q.q[2],
               double(end.delta), way.stepping() ? 8e-4 : 1e-8, source,
               way.stepping() ? late + ", over a path of 0.65 rad" : tolerance);
      f.relative(claim_name(subject, "angular velocity after 0.2 s, six contacts", way.name), "rad/s", q.v[2],
                 double(end.omega), way.stepping() ? 1.2e-3 : 1e-8, source,
                 way.stepping() ? late : tolerance);
    }
    scene.run.duration = 0.01;
    for (const auto& way : {test::penalty, test::event_driven, stepping})
      f.within(claim_name(subject, "restitution of the first contact", way.name), "",
               -test::finished(way, scene).final_state.v[2] / 10, double(b.restitution()),
               way.stepping() ? 2e-4 : 1e-10, "Schwager and Pöschel 2007, exp(−ζ φ/√(1 − ζ²))",
               way.stepping() ? "(c/J) h" : "tolerance 1e-12 per step, some 100 steps");
  }
  {
    const char* const subject = "driven rotor and load with backlash";
    const auto b = reference::backlash_driven();
    const auto scene = read_scene(test::published("backlash-joint-driven"));
    const auto exact = b.bodies(b.at(0.2L, reference::backlash_driven_start));
    for (const auto& way : {test::penalty, test::event_driven, stepping}) {
      const auto end = test::finished(way, scene).final_state;
      const auto claim = [&](const char* what, double angle, double rate, long double at, long double speed) {
        const std::string reason = way.stepping()
                                       ? "(c/J) h of the relative rate, 6 rad/s, at each of seven contacts; "
                                         "angles: over 0.2 s"
                                       : tolerance;
        f.within(claim_name(subject, fmt::format("angle of the {} after 0.2 s", what), way.name), "rad",
                 angle, double(at), way.stepping() ? 2e-3 : 1e-8, source, reason);
        f.within(claim_name(subject, fmt::format("angular velocity of the {} after 0.2 s", what), way.name),
                 "rad/s", rate, double(speed), way.stepping() ? 1e-2 : 1e-8, source, reason);
      };
      claim("rotor", end.q[2], end.v[2], exact.rotor_angle, exact.rotor_rate);
      claim("load", end.q[5], end.v[5], exact.load_angle, exact.load_rate);
    }
  }
}

}  // namespace

void published_contacts(Findings& f) {
  exudyn_contacts(f);
  chung_ooi_elastic(f);
  chung_ooi_restitution(f);
  chung_ooi_oblique(f);
  rows_with_gaps(f);
  touching_rows(f);
  ball_and_rod(f);
  backlash_joint(f);
}

Parts published_cases() { return {published_smooth, published_impacts, published_contacts}; }

}  // namespace freeplay::verification
