// Discs declared as one group. Their motion equals that with every contact declared, for either
// storage of pairs; no contact is missed; forces at rest are those of statics.
#include <Eigen/LU>

#include "dynamics/families.hpp"
#include "dynamics/system.hpp"
#include "formulations/contact/contact_problem.hpp"
#include "mechanism/group.hpp"
#include "verification/property/comparison/snapshot_check.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/random_contact.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

const std::string surface = test::surface("s", 0.4, "young = 1e7\npoisson = 0.3\nfriction = 0.3\n");

/// 12 discs of 0.05 m with initial velocities in a box, three to a row.
std::vector<Vec2> places() {
  std::vector<Vec2> list;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 3; ++column)
      list.emplace_back(0.06 + 0.115 * column + (row % 2 == 1 ? 0.013 : 0), 0.06 + 0.11 * row);
  return list;
}

std::string run_keys(double duration, double step) {
  return fmt::format(
      "[run]\nduration = {}\nstart = \"given\"\n[nonsmooth]\nscheme = \"moreau-jean\"\nstep = {}\n", duration,
      step);
}

std::string grouped(const std::string& pairs, double duration = 0.3) {
  std::string text = "gravity = [0.7, -9.81]\n[groups.g]\nmass = 0.2\nradius = 0.05\npositions = [";
  for (const auto& p : places()) text += fmt::format("[{}, {}], ", p.x(), p.y());
  return text +
         fmt::format(
             "]\nvelocity = [0.3, -0.2]\nwalls = [[0, 1], [0, 0], [0.36, 0], [0.36, 1]]\nsurface = \"s\"\n"
             "pairs = \"{}\"\n",
             pairs) +
         surface + run_keys(duration, 1e-3);
}

/// The same scene with every contact declared.
std::string declared(double duration = 0.3) {
  std::string text = "gravity = [0.7, -9.81]\n", contacts;
  const auto list = places();
  for (std::size_t i = 0; i < list.size(); ++i)
    text +=
        fmt::format("[bodies.d{}]\nmass = 0.2\ninertia = {}\nposition = [{}, {}]\nvelocity = [0.3, -0.2]\n",
                    i, 0.5 * 0.2 * 0.05 * 0.05, list[i].x(), list[i].y());
  for (std::size_t i = 0; i < list.size(); ++i)
    for (std::size_t j = i + 1; j < list.size(); ++j)
      text +=
          test::discs(fmt::format("c{}_{}", i, j), fmt::format("d{}", i), fmt::format("d{}", j), 0.05, 0.05);
  const std::array<std::array<double, 3>, 3> walls{{{0, 0, -1}, {0, 1, 0}, {0.36, 0, 1}}};
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (std::size_t i = 0; i < list.size(); ++i)
      text += test::plane(fmt::format("w{}_{}", w, i), "ground", fmt::format("d{}", i), 0.05, "s",
                          fmt::format("at = [[{}, {}], [0, 0]]\naxis = [{}, {}]\n", walls[w][0],
                                      w == 0 ? 1 : 0, walls[w][1], walls[w][2]));
  return text + surface + run_keys(duration, 1e-3);
}

State end_of(const std::string& text, Family family, Scheme scheme, long* touches = nullptr) {
  auto scene = parse_scene(text, "discs.toml");
  scene.nonsmooth.scheme = scheme;
  const auto r = test::finished(scene, family);
  if (touches) *touches = r.work.events;
  return r.final_state;
}

}  // namespace

TEST_CASE("discs of a group move bit for bit as with every contact declared", "[groups]") {
  const auto way = GENERATE(std::pair{Family::nonsmooth, Scheme::moreau_jean},
                            std::pair{Family::nonsmooth, Scheme::event_driven},
                            std::pair{Family::penalty, Scheme::moreau_jean});
  // The event-driven scheme and penalty take more CPU for the same time.
  const bool steps = way.first == Family::nonsmooth && way.second == Scheme::moreau_jean;
  const double duration = steps ? 0.6 : 0.05;
  CAPTURE(static_cast<int>(way.first), static_cast<int>(way.second));
  long touches = 0;
  const auto apart = end_of(declared(duration), way.first, way.second, &touches);
  CHECK(touches > (steps ? 50 : 3));
  const auto each = end_of(grouped("each", duration), way.first, way.second);
  CHECK(each.q == apart.q);
  CHECK(each.v == apart.v);
  if (!steps) return;
  const auto near = end_of(grouped("near", duration), way.first, way.second);
  CHECK(near.q == apart.q);
  CHECK(near.v == apart.v);
}

TEST_CASE("contacts and reports of a group's discs do not depend on the storage of pairs", "[groups]") {
  auto each = test::simulate(parse_scene(grouped("each"), "g.toml"), Family::nonsmooth),
       near = test::simulate(parse_scene(grouped("near"), "g.toml"), Family::nonsmooth);
  for (auto* run : {&each, &near})  // simultaneous events may be in either order
    std::ranges::sort(run->events, {}, [](const Event& e) { return std::pair(e.t, e.joint); });
  REQUIRE(each.events.size() > 30);
  REQUIRE(near.events.size() == each.events.size());
  for (std::size_t i = 0; i < each.events.size(); ++i) {
    CHECK(near.events[i].joint == each.events[i].joint);
    CHECK(near.events[i].t == each.events[i].t);
    CHECK(near.events[i].impulse_n == each.events[i].impulse_n);
  }
  REQUIRE(near.contacts.size() == 4);  // the group and three walls
  CHECK(near.contacts[0].name == "g");
  CHECK(near.contacts[2].name == "g-wall2");
  const auto impacts = [](const Result& run) {
    long sum = 0;
    for (const auto& c : run.contacts) sum += c.impacts;
    return sum;
  };
  const auto deepest = [](const Result& run) {
    return std::ranges::max(run.contacts, {}, &ContactSummary::penetration).penetration;
  };
  CHECK(impacts(near) == impacts(each));
  CHECK(deepest(near) == deepest(each));
}

TEST_CASE("a run with pairs that form and dissolve continues from a snapshot bit for bit",
          "[groups][snapshot]") {
  snapshots::check({grouped("near", 0.2), "nonsmooth"});
}

TEST_CASE("the neighbour list holds every pair within reach, and none is missed while it is valid",
          "[groups]") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-1, 1);
  for (int trial = 0; trial < 20; ++trial) {
    std::string text = "[surfaces.s]\nrestitution = 0.5\n";
    const int count = 5 + 10 * trial;
    for (const auto& [name, radius] : {std::pair{"a", 0.05}, {"b", 0.11}})
      text += fmt::format(
          "[groups.{}]\nmass = 1\nradius = {}\ngrid = [{}, 1]\nspacing = [1, 1]\nsurface = \"s\"\npairs = "
          "\"near\"\nwalls = [[-0.5, 0.3], [0.5, -0.4]]\n{}",
          name, radius, count, name[0] == 'b' ? "touches = \"a\"\n" : "");
    const auto scene = parse_scene(text + "[run]\nduration = 1\n", "n.toml");
    const System system(scene.mechanism);
    REQUIRE(system.families().size() == 5);
    REQUIRE(system.contacts() == 0);
    Neighbours list(system.families());
    std::vector<double> q(static_cast<std::size_t>(system.n())), v(q.size());
    for (auto& x : q) x = place(random);
    const double reach = 0.02 * (1 + trial);
    list.find(q.data(), reach);
    const auto within = [&](double most) {
      std::set<Neighbours::Pair> pairs;
      for (std::size_t k = 0; k < system.families().size(); ++k)
        system.families()[k].each([&](int i, int j) {
          if (system.families()[k].gap(q.data(), i, j) < most) pairs.insert({static_cast<int>(k), i, j});
        });
      return pairs;
    };
    const auto all = within(reach);
    REQUIRE(list.found() == std::vector<Neighbours::Pair>(all.begin(), all.end()));
    // Any motion within the permitted speed, up to the permitted displacement.
    for (auto& x : v) x = place(random);
    const double h = 0.999 * reach / list.moved(q.data(), 1, v.data(), v.data());
    REQUIRE(list.moved(q.data(), h, v.data(), v.data()) < reach);
    for (std::size_t c = 0; c < q.size(); ++c) q[c] += h * v[c];
    CHECK(list.moved(q.data(), 0, nullptr, nullptr) < reach);
    for (const auto& pair : within(0)) CHECK(all.contains(pair));
  }
}

TEST_CASE("rows of discs that just fit between two walls stay at rest", "[groups]") {
  // Their gaps are rounding errors of either sign: one cannot be corrected without changing
  // another.
  for (const auto& [columns, rows] : {std::pair{5, 10}, {10, 10}, {12, 3}})
    for (const double h : {1e-3, 1e-4}) {
      CAPTURE(columns, rows, h);
      const auto scene = parse_scene(
          fmt::format("gravity = [0, -9.81]\n[groups.g]\nmass = 1\nradius = 0.1\ngrid = [{}, {}]\n"
                      "origin = [0.1, 0.1]\nspacing = [0.2, 0.2]\nwalls = [[0, 3], [0, 0], [{:.17g}, 0], "
                      "[{:.17g}, 3]]\n"
                      "surface = \"s\"\npairs = \"near\"\n",
                      columns, rows, 0.2 * columns, 0.2 * columns) +
              surface + run_keys(100 * h, h),
          "grid.toml");
      Simulation simulation(scene, "nonsmooth");
      const auto begin = simulation.state().q;
      const auto result = test::finished(simulation);
      const auto end = simulation.state().q;
      double moved = 0;
      for (std::size_t i = 0; i < end.size(); ++i)
        if (i % 3 != 2) moved = std::max(moved, std::abs(end[i] - begin[i]));
      // Solved to 1e-10 of g h: columns are unstable, and may tilt by the remaining error in 100
      // steps.
      CHECK(moved < 100 * 1e-10 * 9.81 * h * 100 * h + 1e-13);
    }
}

TEST_CASE(
    "a box of discs comes to rest: floor forces balance the weight, wall forces balance, "
    "energy only decreases",
    "[groups]") {
  const double h = 1e-3, weight = 40 * 0.02 * 9.81;
  const auto scene = parse_scene(
      "gravity = [0, -9.81]\n[groups.g]\nmass = 0.02\nradius = 0.01\ngrid = [8, 5]\norigin = [0.012, 0.011]\n"
      "spacing = [0.0215, 0.021]\nstagger = 0.003\nwalls = [[0, 1], [0, 0], [0.18, 0], [0.18, 1]]\nsurface = "
      "\"s\"\n" +
          std::string(surface) + run_keys(1.5, h) + "lcp_tolerance = 1e-10\n",
      "box.toml");
  Simulation simulation(scene, "nonsmooth");
  REQUIRE(simulation.layout().contacts.empty());  // pairs form and dissolve
  std::map<std::string, ElementForce> last;
  double energy = INFINITY, rise = 0, deepest = 0, momentum = 0, pushed = 0, moving = 0;
  std::vector<double> q(3 * 40), v(q.size());
  test::Listener listener;
  listener.want.forces = true;
  listener.on_step = [&](const Step& step) {
    const auto ledger = step.ledger();
    const double now = ledger.kinetic + ledger.potential;
    rise = std::max(rise, now - energy);
    energy = now;
    Forces f;
    step.forces(step.t1, f);
    step.state(step.t1, q, v);
    const auto& within = step.within();
    for (std::size_t e = 0; e < simulation.layout().forces.size(); ++e) {
      const auto& name = simulation.layout().forces[e].name;
      last[name] = f.elements[e];
      if (name == "g-wall2") pushed += f.elements[e].fn * (step.t1 - step.t0) + within.elements[e].fn;
      if (name == "g-wall1" || name == "g-wall3")  // friction along them
        pushed += f.elements[e].fy * (step.t1 - step.t0) + within.elements[e].fy;
    }
    momentum = moving = 0;
    for (std::size_t b = 0; b < 40; ++b) {
      momentum += 0.02 * v[3 * b + 1];
      moving = std::max(moving, std::hypot(v[3 * b], v[3 * b + 1]));
      deepest = std::max({deepest, 0.01 - q[3 * b + 1], 0.01 - q[3 * b], q[3 * b] - 0.17});
      for (std::size_t a = 0; a < b; ++a)
        deepest = std::max(deepest, 0.02 - std::hypot(q[3 * a] - q[3 * b], q[3 * a + 1] - q[3 * b + 1]));
    }
  };
  REQUIRE(simulation.run({.observers = {&listener}}).ending.status == Ending::Status::finished);
  // A disc that rolls at millimetres a second has an acceleration below a ten-thousandth of g.
  CHECK(moving < 1e-2);  // some roll on without resistance
  CHECK(last["g-wall2"].fn + last["g-wall1"].fy + last["g-wall3"].fy == Approx(weight).epsilon(1e-4));
  CHECK(last["g-wall1"].fx + last["g-wall2"].fx + last["g-wall3"].fx == Approx(0).margin(1e-4 * weight));
  // The momentum is the impulse of gravity and the box, to the rounding of 1,500 steps.
  CHECK(momentum == Approx(pushed - weight * 1.5).margin(1e-10 * weight));
  // The position correction, g h² deep, may raise the energy of every disc in each step.
  CHECK(rise < weight * 9.81 * h * h);
  // Sampled from positions: for discs with several simultaneous impacts the error is below a
  // hundredth of their displacement in a step, at 0.5 m/s.
  CHECK(deepest < 0.1 * 0.5 * h);
}

TEST_CASE("an invalid group is refused at its key", "[groups][scene]") {
  const auto refused = [](const std::string& from, const std::string& to, const std::string& says) {
    CAPTURE(says);
    const auto text = test::replaced(grouped("near"), from, to);
    CHECK_THAT(test::refusal_of([&] { Simulation(parse_scene(text, "g.toml"), "nonsmooth"); }),
               Catch::Contains(says));
  };
  refused("radius = 0.05", "radius = 0", "groups.g.radius: must be greater than 0");
  refused("mass = 0.2\n", "", "groups.g.mass: is missing");
  refused("positions = [", "grid = [3, 4]\npositions = [", "needs exactly one of positions and grid");
  refused("surface = \"s\"", "surface = \"t\"", "groups.g.surface: there is no surface \"t\"");
  refused("[0, 1], [0, 0]", "[0, 0], [0, 0]", "groups.g.walls: points 1 and 2 are equal");
  refused("pairs = \"near\"", "pairs = \"all\"", "groups.g.pairs");
  refused("pairs = \"near\"", "touches = [\"g\"]",
          "groups.g.touches: there is no group above it called \"g\"");
  refused("scheme = \"moreau-jean\"\nstep", "scheme = \"event-driven\"\n# step",
          "groups.g.pairs: \"near\" needs");
  refused("[groups.g]", "[bodies.g-3]\nmass = 1\ninertia = 1\n[groups.g]",
          "its disc 3 has the same name as bodies.g-3");
}

// Many contacts outside joints: the rest positions of piles of discs in both nonsmooth schemes, and
// the motions that friction admits. The claims of "complementarity" contain the forces in piles and
// random piles.

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
