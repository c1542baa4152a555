// Case studies of ratios, freewheels, worms, friction with Stribeck's peak, restitution by approach speed,
// films of finite length and beams, and published cases of the same elements, by every scheme: against closed forms
// and references that integrate between located events (Python, order 8, tolerance 1e-13).
#include <numbers>

#include "dynamics/assembly/assembly.hpp"
#include "dynamics/assembly/modes.hpp"
#include "dynamics/system.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene scene_of(const std::string& file, const std::vector<std::string>& options = {}) {
  return read_scene(test::source_folder() / "cases" / file, options);
}

const test::Way event_schemes[] = {test::event_driven, test::automatic};
const test::Way ways[] = {test::penalty, test::event_driven, test::automatic, test::chosen_steps,
                          test::fixed_steps(1e-4)};
/// One of the bounds of the penalty formulation, events, adaptive and fixed steps.
double bound(const test::Way& way, double penalty, double events, double chosen, double fixed) {
  return way.penalty() ? penalty : way.fixed() ? fixed : way.chosen() ? chosen : events;
}

}  // namespace

TEST_CASE("case study: a belt drive with play, and with elasticity", "[cases]") {
  const double J1 = 1e-4, J2 = 2e-3, r = 0.5, T = 0.02, play = 0.01, R = 0.05, e = 0.4;
  const double fall = r * T / J1, first = std::sqrt(2 * play / fall), approach = R * fall * first;
  const auto loose = scene_of("belt-drive/scene.toml");
  for (const auto& way : event_schemes) {
    CAPTURE(way.name);
    const auto run = test::finished(way, loose);
    // The motion before contact is a polynomial.
    CHECK(test::touch(run, 0).t == Approx(first).epsilon(1e-10));
    CHECK(-test::touch(run, 0).v_n_minus == Approx(approach).epsilon(1e-10));
    CHECK(test::touch(run, 0).v_n_plus == Approx(e * approach).epsilon(1e-10));
  }
  const auto soft = test::finished(test::penalty, loose);
  CHECK(test::touch(soft, 0).t == Approx(first).epsilon(1e-8));
  CHECK(-test::touch(soft, 0).v_n_minus == Approx(approach).epsilon(1e-8));
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto end = test::finished(way, loose).final_state;
    // Both pulleys together; the compression of the teeth decays in the penalty formulation.
    const double speed = 20 - 0.1 * T / (J1 + r * r * J2);
    CHECK(end.v[2] == Approx(speed).epsilon(bound(way, 1e-7, 1e-9, 1e-9, 1e-9)));
    CHECK(end.v[5] == Approx(r * speed).epsilon(bound(way, 1e-7, 1e-9, 1e-9, 1e-9)));
    // x = y − r θ = (a/ω²)(1 − cos ωt), ω² = k (1/J₂ + r²/J₁). Fixed steps: ω t (ω h)²/24, margin of two.
    const double k = 10, w = std::sqrt(k * (1 / J2 + r * r / J1)), x = fall / (w * w);
    const auto elastic = test::finished(way, scene_of("belt-drive/elastic.toml")).final_state;
    CHECK(elastic.q[5] - r * elastic.q[2] ==
          Approx(x * (1 - std::cos(0.1 * w))).margin(x * bound(way, 1e-5, 1e-5, 1e-3, 5e-4)));
  }
}

TEST_CASE("case study: feed per stroke of a freewheel, with and without overrunning", "[cases]") {
  const double A = 0.1, k = 0.5;  // T/(J A Ω²)
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Penalty: slip and creep of 1e-5 rad/s. Adaptive steps: tolerance. Fixed: A Ω² h² of six events.
    const double error = bound(way, 1e-4, 1e-8, 1e-4, 1e-5);
    const auto overruns = test::finished(way, scene_of("freewheel-feed/scene.toml"));
    CHECK(overruns.final_state.q[5] == Approx(3 * A * (1 + k) * (1 + k) / (2 * k)).margin(error));
    const auto follows =
        test::finished(way, scene_of("freewheel-feed/scene.toml", {"loads.brake.torque=0.5"}));
    CHECK(follows.final_state.q[5] == Approx(3 * 2 * A).margin(error));
  }
}

TEST_CASE("case study: a worm lifts, holds and lowers a load", "[cases]") {
  const double gamma = std::numbers::pi / 36, rho = std::atan(0.12), tan = std::tan(gamma);
  const double up = tan / std::tan(gamma + rho), back = std::tan(gamma - rho) / tan;
  const double J1 = 1e-4, J2 = (0.1 + 20 * 0.05 * 0.05) / 1600, L = 20 * 9.81 * 0.05 / 40;
  const double drum = 0.05 / 40;  // m, height per angle of the worm
  // 1.2 N m for 0.1 s, which fall to 0 within h; from 0.3 s on −0.15 N m, which rise within h.
  const double h = 1e-4, inertia = J1 + J2 / up, brake = L / up, lower = J1 + back * J2;
  const double w0 = (1.2 - brake) / inertia * 0.1, w1 = w0 + (0.6 - brake) * h / inertia;
  const double stop =
      w0 * 0.05 + w0 * h + (0.4 - 0.5 * brake) * h * h / inertia + w1 * w1 * inertia / (2 * brake);
  const double slope = 0.15 / h, late = h * (1 + back * L / 0.15), w2 = -slope * late * late / (2 * lower),
               a = (-0.15 - back * L) / lower, rest = 0.1 - h;
  const double end = stop - slope * late * late * late / (6 * lower) + w2 * rest + 0.5 * a * rest * rest;
  const auto at = [&](const test::Way& way, double duration) {
    return test::finished(way, scene_of("worm-hoist/scene.toml", {fmt::format("run.duration={}", duration)}))
        .final_state;
  };
  for (const auto& way : ways) {
    CAPTURE(way.name);
    // Penalty: 1e-5 rad/s of slip at the worm. Steps: the ramp of 0.1 ms within one step, h w of 190 rad/s.
    const double error = drum * bound(way, 1e-5, 1e-8, 0.02, 0.02);
    CHECK(at(way, 0.1).v[2] == Approx(w0).epsilon(bound(way, 1e-6, 1e-9, 1e-4, 1e-4)));
    CHECK(at(way, 0.25).q[7] + 1 == Approx(drum * stop).margin(error));
    CHECK(at(way, 0.3).q[7] + 1 == Approx(drum * stop).margin(error));
    CHECK(at(way, 0.4).q[7] + 1 == Approx(drum * end).margin(2 * error));
  }
}

TEST_CASE("case study: period of stick-slip with Stribeck's friction", "[cases]") {
  // unit/contact/fixed_friction_test.cpp has the reference and reasons of the bounds.
  const double slip = 0.404293443543, period = 1.46032830388, end = -0.00560348603414;
  for (const auto& way : ways) {
    CAPTURE(way.name);
    const auto run = test::finished(way, scene_of("stick-slip/scene.toml"));
    // Four slips, four times the error of one.
    CHECK(run.final_state.q[3] ==
          Approx(end + 0.1 * (6 - 1 - 3 * period - slip)).margin(0.4 * bound(way, 1e-4, 1e-6, 5e-3, 1e-4)));
  }
}

TEST_CASE("case study: bounces of a ball whose restitution falls with its speed", "[cases]") {
  const double e0 = 0.95, yield = 0.05, g = 9.81;
  const auto scene = scene_of("yielding-ball/scene.toml");
  for (const auto& way : {test::event_driven, test::automatic, test::penalty}) {
    CAPTURE(way.name);
    const auto found = test::touches(test::finished(way, scene));
    REQUIRE(found.size() >= 6);
    double v = std::sqrt(2 * g * 0.5);
    for (std::size_t k = 0; k < 6; ++k) {
      v = e0 * std::pow(v, 0.75) * std::pow(yield, 0.25);
      // Penalty: the weight during the contact, up to 1e-2 of each rebound, adds over six.
      CHECK(found[k].v_n_plus == Approx(v).epsilon(way.penalty() ? 3e-2 : 1e-10));
    }
  }
}

TEST_CASE("case study: equilibrium of a journal in films of finite length, short and long", "[cases]") {
  const double c = 1e-4, W = 294.0872 * 9.81, mu = 0.01, w = 100, R = 0.05, L = 0.1, pi = std::numbers::pi;
  // Bisection of the closed forms of half-Sommerfeld films.
  const auto eccentricity = [&](auto load) {
    double low = 0.01, high = 0.99;
    for (int i = 0; i < 60; ++i) (load(0.5 * (low + high)) < W ? low : high) = 0.5 * (low + high);
    return low;
  };
  const double short_film = eccentricity([&](double e) {
    return mu * w * R * L * L * L / (4 * c * c) * e * std::sqrt(16 * e * e + pi * pi * (1 - e * e)) /
           ((1 - e * e) * (1 - e * e));
  });
  const double long_film = eccentricity([&](double e) {
    return 6 * mu * w * R * R * R * L / (c * c) * e * std::sqrt(4 * e * e + pi * pi * (1 - e * e)) /
           ((2 + e * e) * (1 - e * e));
  });
  const struct {
    const char* film;
    double epsilon, attitude;
  } rows[] = {{"finite", 0.6, std::atan2(1.0758, 0.69767)},  // unit/contact/finite_film_test.cpp
              {"short", short_film, std::atan2(pi * std::sqrt(1 - short_film * short_film), 4 * short_film)},
              {"long", long_film, std::atan2(pi * std::sqrt(1 - long_film * long_film), 2 * long_film)}};
  for (const auto& row : rows)
    for (const auto& way : {test::penalty, test::event_driven, test::chosen_steps}) {
      CAPTURE(row.film, way.name);
      const auto scene =
          scene_of("finite-bearing/scene.toml", {fmt::format("lubricants.oil.film=\"{}\"", row.film)});
      const auto end = test::finished(way, scene).final_state;
      // Error of the film 3e-4 of its force, loss of speed 3e-5, and the digits of the references.
      CHECK(std::hypot(end.q[0], end.q[1]) == Approx(row.epsilon * c).epsilon(3e-4));
      CHECK(std::atan2(end.q[0], -end.q[1]) == Approx(row.attitude).epsilon(5e-4));
    }
}

TEST_CASE("case study: a press whose columns are elastic", "[cases][beams]") {
  // At the lower dead centre the columns are longer by the overlap d of 0.05 mm: 2 EA d/L. The contact is closed and
  // the drive prescribes the crank, so that the head is at d − a (t − t₀)²/2, a = r ω² (1 + r/l). The acceleration −a of
  // head, crank and (half) columns, and (r ω² − a)/2 of the rod's centre, make the force on the die smaller.
  const double E = 207e9, A = 20e-3 * 40e-3, L = 0.45, d = 0.05e-3, r = 0.05, l = 0.25,
               w = 2 * std::numbers::pi, a = r * w * w * (1 + r / l);
  const double columns = 2 * E * A / L * d, inertia = -(40 + 30 + 7850 * A * L) * a + 8 * (r * w * w - a) / 2;
  const double lowest = (1.5 * std::numbers::pi + 0.5) / w;
  const auto scene = scene_of("press-frame/scene.toml", {fmt::format("run.duration={}", lowest)});
  Simulation simulation(scene, "nonsmooth");
  test::LastForces forces;
  test::finished(simulation, {&forces});
  // The axial waves of the columns decay within 0.1 ms and the rod is vertical: the extension is d, with the pull of
  // half a column's inertia, 1e-4 of the force. Pieces place this inertia to a twentieth of itself, 0.3 N.
  const double tension = forces.normal("left-1") + forces.normal("right-1");
  CHECK(tension == Approx(columns).epsilon(1e-3));
  CHECK(forces.normal("die") - tension == Approx(inertia).epsilon(0.02));
}

TEST_CASE("case study: frequency, path and impacts of a flexure parallelogram", "[cases][beams]") {
  const double E = 206e9, L = 0.08, b = 10e-3, h = 0.5e-3, EI = E * b * h * h * h / 12;
  const auto scene = scene_of("flexure-parallelogram/scene.toml");
  {
    // Two springs of 12 EI/L³, with 13/35 of their mass: Rayleigh's quotient with the static deflection, whose error is
    // of the square of the mass ratio of 0.015.
    const System system(scene.mechanism);
    const auto start = assemble(scene.mechanism, RunOptions::Start::assembled);
    double left = 0, first = INFINITY;
    for (const auto& mode : find_modes(system, as_it_stands(system, start, {}, left), {}).modes)
      if (mode.kind == Mode::Kind::swing) first = std::min(first, mode.natural());
    const double mass = 0.3 + 2 * 13.0 / 35 * 7850 * b * h * L;
    CHECK(first == Approx(std::sqrt(24 * EI / (L * L * L) / mass) / (2 * std::numbers::pi)).epsilon(2e-4));
    CHECK(first == Approx(9.18).epsilon(1e-3));
  }
  // The stage moves on y = −0.6 x²/L and keeps its angle; the next term is of the order (x/L)⁴, 3e-3 of it.
  for (const auto& way : {test::fixed_steps(1e-4), test::penalty}) {
    CAPTURE(way.name);
    const auto motion = test::motion_rows(scene_of("flexure-parallelogram/scene.toml", {"run.duration=0.06"}),
                                          way.family, 1e-4);
    const auto far = *std::ranges::max_element(motion.rows, {}, [](const auto& row) { return row.q[0]; });
    CHECK(far.q[0] == Approx(4.13e-3).epsilon(5e-3));
    CHECK(far.q[1] - L == Approx(-0.6 * far.q[0] * far.q[0] / L).epsilon(3e-3));
    CHECK(motion.worst([](const auto& row) { return row.q[2]; }) < 2e-5);
  }
  CHECK(test::touches(test::finished(test::fixed_steps(1e-4), scene)).size() == 5);
}

TEST_CASE("case study: the first impact of a slider-crank with a flexible rod", "[cases][beams]") {
  // Up to it the slider keeps its speed of 0, and the rod, without a torque about the crank pin, its line through the
  // slider: the journal has crossed the clearance c when r (1 − cos θ) + l (1 − cos(λ sin θ)) = c, λ = r/l. Displacements
  // across, up to 0.01 mm, change the distance by 0.2 µm, the axial strain by the rod's inertia by 0.2 µm: 1e-3 of c.
  const double r = 0.05, l = 0.3, lambda = r / l, c = 0.25e-3, w = 200 * 2 * std::numbers::pi / 60;
  double low = 0, high = 0.5;
  for (int i = 0; i < 60; ++i) {
    const double angle = 0.5 * (low + high),
                 crossed = r * (1 - std::cos(angle)) + l * (1 - std::cos(lambda * std::sin(angle)));
    (crossed < c ? low : high) = angle;
  }
  const double approach = w * std::sin(low) * (r + l * lambda * lambda * std::cos(low));
  for (const auto& way : {test::penalty, test::event_driven, test::chosen_steps}) {
    CAPTURE(way.name);
    const auto run = test::finished(
        way, scene_of("flores2011-flexible/scene.toml", {"run.revolutions=0.02", "run.discard=0"}));
    CHECK(test::touch(run, 0).t == Approx(low / w).epsilon(1e-3));
    CHECK(-test::touch(run, 0).v_n_minus == Approx(approach).epsilon(2e-3));
  }
}

TEST_CASE("published: LossyGearDemo1 of the Modelica Standard Library", "[cases]") {
  // unit/dynamics/mesh_loss_test.cpp has the reference; the published digits: DASSL, tolerance 1e-6.
  for (const auto& way : {test::penalty, test::event_driven, test::automatic, test::fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto end = test::finished(way, scene_of("published/modelica-lossy-gear/scene.toml")).final_state;
    const double error = bound(way, 1e-6, 1e-8, 0, 1e-6);
    CHECK(end.q[2] == Approx(3.32487044322e-05).margin(error));
    CHECK(end.v[2] == Approx(-0.032523858762).margin(10 * error));
    CHECK(-end.q[5] == Approx(1.66216871678e-5).margin(error + 1e-8));
    CHECK(-end.v[5] == Approx(-0.0162619240386).margin(10 * error + 1e-7));
  }
}

TEST_CASE("published: LossyGearDemo2 of the Modelica Standard Library", "[cases]") {
  // Backwards until 0.0635910958 s, stuck, forwards from 0.2303740159 s, stuck from 0.3083068569 s, backwards
  // from 0.4727383105 s. Closed form of the linear motions between roots, in Python. Published digits: of the
  // second inertia, DASSL, tolerance 1e-6.
  const struct {
    double t, angle, speed, published_angle, published_speed;
  } list[] = {{0.15, -0.00111809056553447, 0, -0.000559046142, 0},
              {0.27, -0.00108069139731126, 0.00224576706062152, -0.000540347410050, 0.00112288230283},
              {0.4, -0.00100354074461284, 0, -0.000501771990250, 0},
              {0.5, -0.0011783627589218, -0.0192485589841933, -0.000589183323069, -0.00962427809301}};
  for (const auto& way : {test::penalty, test::event_driven, test::automatic, test::fixed_steps(1e-4)})
    for (const auto& at : list) {
      CAPTURE(way.name, at.t);
      const auto end = test::finished(way, scene_of("published/modelica-lossy-gear/demo2.toml",
                                                    {fmt::format("run.duration={}", at.t)}))
                           .final_state;
      // Penalty: 1e-6 rad/s of creep. Fixed steps: h² α̇ of five events.
      const double error = bound(way, 1e-6, 1e-8, 0, 1e-6);
      CHECK(end.q[2] == Approx(at.angle).margin(error));
      CHECK(end.v[2] == Approx(at.speed).margin(10 * error));
      CHECK(-end.q[5] == Approx(at.published_angle).margin(error + 1e-8));
      CHECK(-end.v[5] == Approx(at.published_speed).margin(10 * error + 1e-7));
    }
}

TEST_CASE("published: LossyGearDemo3 of the Modelica Standard Library", "[cases]") {
  // Bearing friction B stops each inertia alone, −B/J = −500 rad/s²: the mesh is unloaded, and neither side
  // drives. A torque T on the second inertia then turns both beyond B + B/η, with (T − B − B/η)/(J + J/η).
  const double J = 1e-3, B = 0.5, eta = 0.25, limit = B + B / eta;
  for (const auto& way : {test::penalty, test::event_driven, test::automatic}) {
    CAPTURE(way.name);
    const auto at = [&](double duration, double torque) {
      return test::finished(way, scene_of("published/modelica-lossy-gear/demo3.toml",
                                          {fmt::format("run.duration={}", duration),
                                           fmt::format("loads.push.torque={}", -torque)}))
          .final_state;
    };
    // Penalty: 1e-6 rad/s of creep for 0.5 s.
    const double error = way.penalty() ? 1e-6 : 1e-9;
    const auto slows = at(0.01, 1), held = at(1, 1), barely = at(0.6, 0.96 * limit);
    CHECK(slows.q[2] == Approx(0.075).margin(error));
    CHECK(-slows.q[5] == Approx(0.075).margin(error));
    CHECK(slows.v[2] == Approx(5).margin(error));
    // Published at 1 s: 0.099999999017 rad.
    for (const auto& state : {held, barely}) {
      CHECK(state.q[2] == Approx(0.1).margin(error));
      CHECK(std::abs(state.v[2]) < error);
    }
    // The torque passes the limit `late` before 0.5 s, at the end of its rise of 0.1 ms.
    const double T = 1.04 * limit, late = 1e-4 * (1 - limit / T), alpha = (T - limit) / (J + J / eta);
    const auto turns = at(0.6, T);
    CHECK(turns.q[2] ==
          Approx(0.1 + alpha * (0.1 * 0.1 / 2 + late * 0.1 / 2 + late * late / 6)).margin(2 * error));
    CHECK(turns.v[2] == Approx(alpha * (0.1 + late / 2)).margin(2 * error));
  }
}

TEST_CASE("published: Friction of the Modelica Standard Library", "[cases]") {
  for (const auto& way : {test::penalty, test::event_driven, test::automatic, test::fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto end = test::finished(way, scene_of("published/modelica-friction/scene.toml")).final_state;
    const double error = bound(way, 1e-4, 1e-6, 0, 1e-3);
    CHECK(end.q[0] == Approx(1.76851781139).margin(error));
    CHECK(end.v[0] == Approx(6.8648403711).margin(error));
    // Published: tolerance 1e-6, which grows where slip begins.
    CHECK(end.q[0] == Approx(1.76846282132).margin(error + 1e-4));
    CHECK(end.v[0] == Approx(6.86485858981).margin(error + 1e-4));
  }
  for (const auto& way : event_schemes) {
    CAPTURE(way.name);
    const auto run = test::finished(way, scene_of("published/modelica-friction/stop.toml"));
    CHECK(test::touch(run, 0).t == Approx(0.0605970956085).epsilon(1e-8));
    CHECK(test::touch(run, 0).v_n_minus == Approx(-6.10565383814).epsilon(1e-8));
    CHECK(run.final_state.q[0] == Approx(-0.247513987282).margin(1e-8));
    CHECK(run.final_state.q[0] == Approx(-0.2475158480).margin(1e-5));  // published
  }
  CHECK_THROWS_WITH(test::finished(test::penalty, scene_of("published/modelica-friction/stop.toml",
                                                           {"contacts.stop.stiffness=1e8"})),
                    Catch::Matchers::Contains("needs a restitution greater than 0"));
}

TEST_CASE("published: stick-slip of PathSim", "[cases]") {
  const struct {
    double t, place, speed;
  } list[] = {{30, -0.356574741927155, -1.76335575687742},
              {60, 3.92936002172841, 0.927642392422872},
              {100, -4.21494135146019, 0.0153698788679004}};
  for (const auto& way :
       {test::penalty, test::event_driven, test::automatic, test::chosen_steps, test::fixed_steps(1e-3)})
    for (const auto& at : list) {
      CAPTURE(way.name, at.t);
      const auto end = test::finished(way, scene_of("published/pathsim-stick-slip/scene.toml",
                                                    {fmt::format("run.duration={}", at.t)}))
                           .final_state;
      // Penalty: 1e-6 m/s of creep for 7 s. Steps: h² v̇ of the changes, v̇ = 30 m/s².
      const double error = bound(way, 1e-5, 1e-8, 1e-4, 3e-5);
      CHECK(end.q[3] == Approx(at.place).epsilon(0).margin(error));
      CHECK(end.v[3] == Approx(at.speed).epsilon(0).margin(error));
    }
}

TEST_CASE("published: DemoFreeWheel of the Modelica Standard Library", "[cases]") {
  for (const auto& way : {test::penalty, test::event_driven, test::automatic, test::fixed_steps(1e-4)}) {
    CAPTURE(way.name);
    const auto end = test::finished(way, scene_of("published/modelica-free-wheel/scene.toml")).final_state;
    // Penalty: 1e-6 rad/s of slip for 1 s. Fixed steps: ω̇ h² = 157 · 1e-8 of ten events.
    const double error = bound(way, 1e-6, 1e-8, 0, 2e-5);
    CHECK(end.q[5] == Approx(3.53580107547).margin(error));
    CHECK(end.v[5] == Approx(2.39180934165).margin(error));
  }
}

TEST_CASE("published: cushions whose restitution depends on the speed", "[cases]") {
  const auto table = [](double v) {
    const auto at = [](double u) { return 0.39 + 0.257 * u - 0.044 * u * u; };
    const double low = 0.25 * std::floor(v / 0.25);
    return std::lerp(at(low), at(low + 0.25), (v - low) / 0.25);
  };
  for (const auto& way : {test::event_driven, test::automatic, test::penalty}) {
    CAPTURE(way.name);
    const auto found = test::touches(test::finished(way, scene_of("published/billiard-cushion/scene.toml")));
    REQUIRE(found.size() == 5);
    double v = 4.5, t = 0.5 / v;
    for (const auto& event : found) {
      CHECK(-event.v_n_minus == Approx(v).epsilon(way.penalty() ? 1e-6 : 1e-10));
      if (!way.penalty()) CHECK(event.t == Approx(t).epsilon(1e-10));  // contacts without duration
      v *= table(v), t += 1 / v;
    }
  }
}
