// The set-valued contact laws against closed forms: the rest of a bouncing ball, a block that stops
// on a slope, Painlevé's rod. The ball's impacts and time of rest are claims of "closed-forms",
// energy over elastic impacts of "invariants".
#include "verification/references/bouncing_ball.hpp"
#include "verification/references/dry_friction.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

Scene scene_of(const char* name, Scheme scheme) {
  auto scene = read_scene(test::scene_file(name));
  scene.nonsmooth.scheme = scheme;
  if (!scene.nonsmooth.step) scene.nonsmooth.step = 1e-5;
  return scene;
}

double rest_time(const Result& run) {
  for (const auto& e : run.events)
    if (e.kind == EventKind::contact) return e.t;
  return NAN;
}

}  // namespace

TEST_CASE("the end of an accumulation of impacts is reported in a run that ends shortly before it",
          "[analytic][event-driven]") {
  // Bounces lower than 1e-9 of the radius, which last some microseconds, end at the time at which
  // they come to rest.
  auto scene = scene_of("bouncing_ball", Scheme::event_driven);
  const double rest = reference::ball_accumulation_time({0.5, 9.81, 0.5});
  for (const double before : {1e-9, 1e-8, 1e-7, 1e-6, 3e-6, 1e-5}) {
    scene.run.duration = rest - before;
    const auto run = test::finished(scene, Family::nonsmooth);
    CAPTURE(before, run.events.back().t);
    for (const auto& e : run.events) CHECK(e.t <= scene.run.duration);
    CHECK(run.events.back().t > rest - 3e-5);
  }
}

TEST_CASE("a bouncing ball by time stepping: the error of the time of rest is of order h ln(1/h)",
          "[order]") {
  const reference::BouncingBall ball{0.5, 9.81, 0.5};
  auto scene = scene_of("bouncing_ball", Scheme::moreau_jean);
  std::vector<double> steps, errors;
  for (const double h : {1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5}) {
    double worst = 0;  // the error is a sawtooth over the instant of rest within its step
    for (int part = 0; part < 40; ++part) {
      scene.nonsmooth.step = h * (1 + 0.5 * part / 40);
      const auto run = test::simulate(scene, Family::nonsmooth);
      worst = std::max(worst, std::abs(rest_time(run) - reference::ball_accumulation_time(ball)));
    }
    // Each of the ln(v₁/(g h))/ln(1/e) impacts that a step can resolve is displaced by up to h, and
    // the errors accumulate: the sum is h ln(1/h).
    steps.push_back(h);
    errors.push_back(worst / std::log(reference::ball_impact(ball, 1).approach / (ball.gravity * h)));
  }
  CAPTURE(errors);
  const double p = test::observed_order(steps, errors);
  CHECK(p > 0.9);
  CHECK(p < 1.1);
}

TEST_CASE("a block on two feet stops on a slope and then sticks or slides back", "[analytic]") {
  for (const double mu : {0.5, 0.2}) {
    const reference::BlockOnSlope block{20 * M_PI / 180, mu, 9.81, 1.5};
    REQUIRE(block.sticks() == (mu == 0.5));
    for (const auto scheme : {Scheme::event_driven, Scheme::moreau_jean}) {
      auto scene = scene_of("block_on_slope", scheme);
      scene.mechanism.surfaces[0].friction = mu;
      scene.nonsmooth.step = 1e-4;
      CAPTURE(mu, static_cast<int>(scheme));
      const auto run = test::finished(scene, Family::nonsmooth);
      const auto exact = reference::block_state(block, scene.run.duration);
      // Event-driven: rounding and 1e-10 a step. Time stepping: the stop lies within one step,
      // where the deceleration of 6 m/s² acts up to h = 1e-4 s too long or too short.
      const double bound = scheme == Scheme::event_driven ? 1e-10 : 6e-4;
      CHECK(run.final_state.v[0] == Approx(exact.velocity).margin(bound).epsilon(0));
      CHECK(run.final_state.q[0] == Approx(exact.position).margin(bound * 0.5).epsilon(0));
      CHECK(run.final_state.q[2] == Approx(0).margin(1e-12));
      const double lost = run.ledger.friction;
      const double way = *reference::block_stopping_distance(block);
      const double slid = way + std::abs(exact.position - way);
      CHECK(lost == Approx(2.0 * block.grip() * slid).epsilon(scheme == Scheme::event_driven ? 1e-9 : 1e-3));
    }
  }
}

TEST_CASE("Painlevé's rod: event-driven integration stops with the reason, time stepping reports the jamming",
          "[event-driven][painleve]") {
  const auto refused = test::simulate(scene_of("painleve_rod", Scheme::event_driven), Family::nonsmooth);
  CHECK(refused.ending.status == Ending::Status::failed);
  CHECK_THAT(refused.ending.reason, Catch::Contains("Painlev") && Catch::Contains("end"));

  const auto locked_up = test::finished(scene_of("painleve_rod", Scheme::moreau_jean), Family::nonsmooth);
  CHECK_THAT(test::notes_of(locked_up), Catch::Contains("Painlev"));
  // Below the critical friction, D_NN/D_NT = 1.3366, the event-driven scheme continues.
  auto mild = scene_of("painleve_rod", Scheme::event_driven);
  mild.mechanism.surfaces[0].friction = 1.3;
  mild.run.duration = 1e-3;
  CHECK_NOTHROW(test::finished(mild, Family::nonsmooth));
}

TEST_CASE("contacts of the corners of a fast spinning rod are not missed", "[analytic][event-driven]") {
  // The lower tip is at 0.55 − 0.2 t − 0.5 |sin 100 t|: its first root, bracketed by steps of a
  // microsecond.
  const auto tip = [](double t) { return 0.55 - 0.2 * t - 0.5 * std::abs(std::sin(100 * t)); };
  double t = 0.2;
  while (tip(t) > 0) t += 1e-6;
  auto scene = scene_of("spinning_rod", Scheme::event_driven);
  scene.run.duration = 0.4;
  const auto touches = test::touches(test::simulate(scene, Family::nonsmooth));
  REQUIRE(!touches.empty());
  CHECK(touches[0].t == Approx(t).margin(1e-6).epsilon(0));
}

TEST_CASE("a ball under a large load still bounces", "[analytic][event-driven]") {
  // Without gravity a load of 1000 N accelerates the ball towards the floor: its bounces end by
  // their height, not by the time scale of the scene. First rebound e v, v² = 2 F h/m; rest after
  // (1 + e)/(1 − e) times the fall's time.
  auto scene = scene_of("bouncing_ball", Scheme::event_driven);
  scene.mechanism.gravity = {0, 0};
  scene.mechanism.loads.push_back(ForceLoad{"press", 0, {0, 0}, {0, -1000}});
  scene.run.duration = 0.1;
  const auto run = test::simulate(scene, Family::nonsmooth);
  const auto touches = test::touches(run);
  REQUIRE(touches.size() > 10);
  const double a = 1000 / 0.3, fall = std::sqrt(2 * 0.5 / a);
  CHECK(touches[0].v_n_plus == Approx(0.5 * a * fall).epsilon(1e-9));
  CHECK(rest_time(run) == Approx(3 * fall).margin(1e-9).epsilon(0));
  CHECK(run.final_state.q[1] == Approx(0.05).margin(1e-14));
  CHECK(run.final_state.v[1] == Approx(0).margin(1e-14));
}

namespace {

std::string plane(const std::string& name, const std::string& i, const std::string& j, Vec2 on_i, Vec2 on_j,
                  Vec2 axis) {
  return test::plane(name, i, j, 0, "s",
                     fmt::format("at = [[{}, {}], [{}, {}]]\naxis = [{}, {}]\nstiffness = 1e8\n", on_i.x(),
                                 on_i.y(), on_j.x(), on_j.y(), axis.x(), axis.y()));
}

/// A force (N) along x at a height on a body; it grows from zero within `ramp` (s), if given.
std::string push(const std::string& body, double force, double height, double ramp = 0) {
  const auto at = fmt::format("at = [0, {}]\n", height);
  if (ramp == 0) return test::force("P", body, {force, 0}, at);
  return test::force("P", body, {force, 0}, at + "factor = \"f\"\nagainst = \"time\"\n") +
         test::table("f", fmt::format("[[0, 0], [{}, 1]]", ramp));
}

std::string rub(const std::string& joint, const std::string& limit) {
  return test::joint_friction(joint + "_rub", joint, limit + "\nregularisation = 1e-4\n");
}

constexpr const char* given = "start = \"given\"\n";

/// A run that finishes without a paradox.
Result regular(const test::Way& way, const std::string& text, const std::vector<std::string>& more = {}) {
  const auto run = test::finished(way, text, more);
  CHECK_THAT(test::notes_of(run), !Catch::Contains("Painlev"));
  return run;
}

const std::array ways{test::event_driven, test::automatic, test::fixed_steps(1e-4)};

}  // namespace

TEST_CASE("a friction oscillator sticks and slips as in closed form, however short its sticks are",
          "[analytic][event-driven][friction-limit]") {
  std::mt19937 random(4711);
  const auto u = [&](double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); };
  for (int i = 0; i < 60; ++i) {
    reference::FrictionOscillator o;
    o.m = std::pow(10, u(-2, 2));
    o.k = std::pow(10, u(0, 4));
    const double w = std::sqrt(o.k / o.m);
    o.bound = u(0.2, 3) * 0.01 * o.k;
    o.amplitude = o.bound * (i % 2 == 0 ? u(0.8, 8) : u(0.95, 1.6));
    o.omega = w * u(0.2, 2.5);
    o.phase = i % 3 == 0 ? 0 : u(0, 6);
    const reference::FrictionOscillator::State start{0, i % 5 == 0 ? 0 : u(-1, 1) * o.bound / o.k, 0};
    const double f = o.omega / (2 * M_PI), end = u(3, 12) / f;
    const auto text =
        test::body("m", o.m, 1e-3, fmt::format("position = [{}, 0]\nvelocity = [0, 0]\n", start.x)) +
        test::guide("rail", "ground", "m") +
        test::spring("sp", "ground", "m", {-10, 0}, {0, 0}, o.k, 10, "damping = 0\n") +
        rub("rail", fmt::format("force = {}", o.bound)) +
        test::drive("d", "rail", "force = \"h\"\nagainst = \"time\"\n") +
        test::curve("h", "harmonic",
                    fmt::format("amplitude = {}\nfrequency = {}\nphase = {}\n", o.amplitude, f, o.phase)) +
        test::run_for(end, given);
    const auto exact = o.at(end, start);
    CAPTURE(i, exact.sticks);
    const auto run = test::finished(test::event_driven, text, {"nonsmooth.tolerance=1e-11"});
    // Thousands of steps at 1e-11 of the coordinates, of which friction forgets the oldest.
    const double size = std::max(o.amplitude / o.k, std::abs(exact.x));
    CHECK(run.final_state.q[0] == Approx(exact.x).margin(1e-7 * size).epsilon(0));
    CHECK(run.final_state.v[0] == Approx(exact.v).margin(1e-7 * size * std::max(w, o.omega)).epsilon(0));
  }
}

TEST_CASE("blocks in a row reach their friction limits one after the other and start together",
          "[analytic][event-driven][friction-limit]") {
  // Each block takes the excess of those before it. The row starts when the push P t/T reaches the
  // sum of the limits, at t₀, and then x = P (t − t₀)³/(6 T Σm).
  for (const bool by_reaction : {false, true})
    for (const int n : {2, 3, 5}) {
      double limits = 0, mass = 0;
      std::string text = "gravity = [0, -9.81]\n" + test::surface("s", 0.3);
      for (int i = 0; i < n; ++i) {
        const double m = 1 + 0.5 * ((3 * i) % 4), mu = 0.2 + 0.15 * ((2 * i) % 3);
        limits += mu * m * 9.81;
        mass += m;
        const auto name = fmt::format("b{}", i), joint = fmt::format("j{}", i);
        text += test::body(name, m, 0.1, fmt::format("position = [{}, 0]\n", i)) +
                test::guide(joint, "ground", name) +
                rub(joint, by_reaction ? fmt::format("friction = {}", mu)
                                       : fmt::format("force = {}", mu * m * 9.81));
        if (i > 0)
          text += plane(fmt::format("c{}", i), fmt::format("b{}", i - 1), name, {0.5, 0}, {-0.5, 0}, {0, -1});
      }
      const double P = 2.5 * limits, late = 1 - limits / P, exact = P * late * late * late / (6 * mass);
      CAPTURE(n, by_reaction);
      const auto run =
          test::finished(test::event_driven, text + push("b0", P, 0, 1) + test::run_for(1, given));
      for (int i = 0; i < n; ++i)
        // the default tolerance of 1e-8 a step
        CHECK(run.final_state.q[static_cast<std::size_t>(3 * i)] - i == Approx(exact).epsilon(1e-6));
    }
}

TEST_CASE("friction locks a drawer that is pushed off centre by more than L/(2 mu)",
          "[analytic][friction-limit]") {
  // Two opposite corners carry N = P e/L each: a = P (1 − 2 μ e/L)/m, or rest.
  const double L = 0.5, b = 0.1, mu = 0.4, m = 2, P = 30, duration = 0.2;
  for (const auto& way : ways)
    for (const double share : {-0.5, 0.9, 1.1, 3.0})
      for (const double ramp : {0.0, duration}) {
        const double e = share * L / (2 * mu), a = std::max(0.0, P * (1 - std::abs(share)) / m);
        std::string text = test::body("m", m, m * (L * L + 4 * b * b) / 12);
        for (const double x : {-L / 2, L / 2})
          for (const double y : {-b, b})
            text += plane(fmt::format("c{}{}", x > 0, y > 0), "ground", "m", {0, y}, {x, y},
                          {y < 0 ? 1.0 : -1.0, 0});
        text += test::surface("s", 0, mu) + push("m", P, e, ramp) + test::run_for(duration, given);
        CAPTURE(way.name, share, ramp);
        const auto run = regular(way, text);
        const double exact = a * duration * duration / (ramp > 0 ? 6 : 2);
        // the midpoint rule has h² of the ramp: (1e-4/0.2)² = 2.5e-7
        CHECK(run.final_state.q[0] == Approx(exact).epsilon(1e-6).margin(1e-12));
        CHECK(run.final_state.q[2] == Approx(0).margin(1e-9));
      }
}

TEST_CASE("a wedge below its friction angle holds a block, with contacts or with guides",
          "[analytic][friction-limit]") {
  // Physics Forums, thread 784787: mu = 0.25 on all three faces. At 300 lbf statics has a solution,
  // for example with the forces (N, T) = (470.8, -113.0) lbf on the face, (193.0, -44.0) at the wall
  // and (444.0, 107.0) at the floor, each 4 lbf below its limit; sliding either way has none.
  const double lb = 0.45359237, lbf = 4.4482216152605, foot = 0.3048, a = 10 * M_PI / 180;
  for (const bool guided : {false, true})
    for (const auto& way : ways) {
      // Fixed steps stop there: joint friction that reactions bound admits several impulses.
      if (guided && way.stepping()) continue;
      auto text = "gravity = [0, -9.80665]\n" +
                  test::body("block", 400 * lb, 4, fmt::format("position = [0, {}]\n", 2 * foot)) +
                  test::body("wedge", 1e-3 * lb, 4e-5) + test::guide("wall", "ground", "block", {0, 1}) +
                  test::guide("floor", "ground", "wedge") + rub("wall", "friction = 0.25") +
                  rub("floor", "friction = 0.25") + push("wedge", -300 * lbf, 0);
      if (guided)
        text += test::guide("face", "wedge", "block", {std::cos(a), std::sin(a)}, {0, 0}, {0, -2 * foot}) +
                rub("face", "friction = 0.25");
      else
        text += plane("face", "wedge", "block", {0, 0}, {0, -2 * foot}, {std::cos(a), std::sin(a)}) +
                test::surface("s", 0.1, 0.25);
      CAPTURE(guided, way.name);
      const auto run = regular(way, text + test::run_for(0.2, given));
      // 1e-13 of 1.3 kN on 0.45 g for 0.2 s
      CHECK(run.final_state.q[3] == Approx(0).margin(6e-9));
      CHECK(run.final_state.q[1] == Approx(2 * foot).margin(6e-9));
    }
}

TEST_CASE("a block on several feet slides when the push reaches its friction limit",
          "[analytic][friction-limit]") {
  // The push P t/T, a little above or below the centre of mass, moves the load from foot to foot before
  // the block slides at t₀ = T μ m g/P: x = P (T − t₀)³/(6 T m). A pair of feet is relieved just before
  // t₀ in the first scene, at a fourth of the time in the second one.
  struct Feet {
    double m, mu, height, P, lever;
    std::vector<double> at;
  };
  const std::vector<double> five{-0.2697286404, -0.07676639385, 0.1019087867, 0.2262440477, 0.2697286404},
      four{-0.48757445679, 0.0027285602, 0.20775580483, 0.48757445679};
  const Feet scenes[] = {{2.7503725527, 0.8197902254, 0.10027254632, 50.1370623397, 0.02432899525, five},
                         {0.60506162594, 0.08630456005, 0.17860930969, 1.0333509811, -0.11745759696, four}};
  for (const auto& way : {test::event_driven, test::automatic})
    for (const auto& f : scenes) {
      std::string text = "gravity = [0, -9.81]\n" +
                         test::body("b", f.m, 0.1 * f.m, fmt::format("position = [0, {}]\n", f.height)) +
                         test::surface("s", 0.5, f.mu) + push("b", f.P, f.lever, 1);
      for (std::size_t i = 0; i < f.at.size(); ++i)
        text += plane(fmt::format("c{}", i), "ground", "b", {0, 0}, {f.at[i], -f.height}, {1, 0});
      CAPTURE(f.P, way.name);
      const auto run = test::finished(way, text + test::run_for(1, given));
      const double late = 1 - f.mu * f.m * 9.81 / f.P;
      CHECK(run.final_state.q[0] == Approx(f.P * late * late * late / (6 * f.m)).epsilon(1e-6));
      CHECK(run.final_state.q[2] == Approx(0).margin(1e-8));
    }
}

TEST_CASE("a wedge under a heavy block takes its only motion, or names two", "[analytic][friction-limit]") {
  // The block M in its guide (mu_w) rests on the wedge m on its floor guide (mu_f) with a face at the
  // angle a (mu), and P pushes the wedge. With all three sliding in the direction s of the wedge,
  //
  //     s A [N, N_w, N_f, |ẍ|]ᵀ = [0, M g, P, m g]ᵀ
  //
  // has at most one solution per choice of signs; statics is a set of inequalities. The first three
  // scenes have one motion, the third with the face open. In the last one the wedge sticks, or leaves.
  struct Wedge {
    double M, m, mu, mu_w, mu_f, P, cosine, sine, acceleration;  // acceleration of the wedge along x
  };
  const double two = NAN;
  const Wedge scenes[] = {
      {131.286608877, 0.204219328429, 0.191323776485, 0.349879162107, 0.467617511714, -2287.3680723,
       0.99012325529431, 0.14019964096031, -63.654253195},
      {155.018807248, 0.195943227345, 0.47454863784, 0.43119962523, 0.319517993555, -3183.16460266,
       0.99682020440676, 0.079683624958142, -91.498386906},
      {131.878508099, 0.494174775488, 0.525403853923, 0.551925859784, 0.432116708533, 1158.37866314,
       0.88016819253255, 0.4746619353329, 1158.37866314 / 0.494174775488 - 0.432116708533 * 9.81},
      {53.7854063152, 0.701808910912, 0.415321279524, 0.506826409947, 0.546947580795, 247.142679843,
       0.99544891180631, 0.095296715492409, two}};
  for (const auto& w : scenes) {
    const auto text = "gravity = [0, -9.81]\n" + test::body("block", w.M, 0.1 * w.M, "position = [0, 1]\n") +
                      test::body("wedge", w.m, 0.1 * w.m) + test::guide("wall", "ground", "block", {0, 1}) +
                      test::guide("floor", "ground", "wedge") +
                      rub("wall", fmt::format("friction = {}", w.mu_w)) +
                      rub("floor", fmt::format("friction = {}", w.mu_f)) + push("wedge", w.P, 0) +
                      plane("face", "wedge", "block", {0, 0}, {0, -1}, {w.cosine, w.sine}) +
                      test::surface("s", 0.1, w.mu) + test::run_for(0.1, given);
    const auto run = test::simulate(test::scene_by(test::event_driven, text), Family::nonsmooth);
    CAPTURE(w.P, run.ending.reason);
    if (std::isnan(w.acceleration)) {
      CHECK(run.ending.status != Ending::Status::finished);
      CHECK_THAT(run.ending.reason, Catch::Contains("several motions") && Catch::Contains("face sticking") &&
                                        Catch::Contains("; or face"));
      continue;
    }
    REQUIRE(run.ending.status == Ending::Status::finished);
    CHECK(run.final_state.q[3] == Approx(w.acceleration * 0.1 * 0.1 / 2).epsilon(1e-6));
  }
}
