// Contents of the files of a run, read as a user reads them: rows of trajectory.csv against the
// parabola of a throw, names and residuals in run.json, and notes only with reason.

#include "formulations/contact/contact_problem.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

/// A disc of 0.05 m thrown above a floor at y = 0, which it does not reach within 0.4 s.
constexpr double from_x = 0.1, from_y = 0.5, angle = 0.2, vx = 1.5, vy = 2, spin = 3, g = 9.81, radius = 0.05;

std::string thrown(const std::string& run) {
  return fmt::format("gravity = [0.0, -{}]\n", g) +
         test::body(
             "stone", 0.3, 1e-4,
             fmt::format("position = [{}, {}]\nangle = {}\nvelocity = [{}, {}]\nangular_velocity = {}\n",
                         from_x, from_y, angle, vx, vy, spin)) +
         test::plane("floor", "ground", "stone", radius) +
         test::surface("s", 0.5, "young = 1e9\npoisson = 0.3\n") +
         fmt::format("[run]\nstart = \"given\"\n{}", run);
}

/// Runs a scene by the program, into a separate folder.
std::filesystem::path ran(const test::TemporaryFolder& place, const std::filesystem::path& scene,
                          const std::string& formulation) {
  static int count = 0;
  const auto folder = place.path() / fmt::format("{}", ++count);
  test::succeeded("run " + scene.string() + " --formulation " + formulation + " -o " + folder.string());
  return folder;
}
std::filesystem::path ran(const test::TemporaryFolder& place, const std::string& text,
                          const std::string& formulation) {
  write_file(place.path() / "scene.toml", text);
  return ran(place, place.path() / "scene.toml", formulation);
}

/// A block on its two corners, its centre of mass to one side: two contacts that share its weight.
const std::vector<std::string> off_centre{"contacts.right.at=[[0, 0], [0.06, -0.05]]", "run.start=given",
                                          "nonsmooth.step=1e-4", "nonsmooth.scheme=moreau-jean"};
Scene block() { return read_scene(test::scene_file("block_on_corners"), off_centre); }

}  // namespace

TEST_CASE("trajectory.csv of a throw is its parabola, row by row", "[written]") {
  struct Requested {
    const char* run;
    double step, duration;
    std::size_t rows;
  };
  const Requested list[] = {
      {"duration = 0.3\noutput_step = 0.01", 0.01, 0.3, 31},
      {"duration = 0.305\noutput_step = 0.01", 0.01, 0.305, 32},  // the end is not a multiple
      {"duration = 0.004", 0.004 / 20000, 0.004, 20001}};         // the defaults
  test::TemporaryFolder place;
  for (const auto& requested : list)
    for (const std::string way : {"penalty", "nonsmooth", "nonsmooth --set nonsmooth.scheme=event-driven",
                                  "nonsmooth --set nonsmooth.scheme=moreau-jean --set nonsmooth.step=1e-3"}) {
      CAPTURE(requested.run, way);
      const auto folder = ran(place, thrown(requested.run), way);
      const test::Columns csv(folder / "trajectory.csv");
      CHECK(csv.header() ==
            "t,stone.x,stone.y,stone.theta,stone.vx,stone.vy,stone.omega,floor.ex,floor.ey,floor.gap");
      REQUIRE(csv.rows() == requested.rows);
      // Time stepping is exact at the ends of its steps and linear between them: g h²/8, in speed g
      // h/2 less.
      const double h = way.ends_with("1e-3") ? 1e-3 : 0, off = g * h * h / 8 + 1e-9;
      double worst_t = 0, worst_q = 0, worst_v = 0;
      const auto meet = [](double& worst, double value, double expected) {
        worst = std::max(worst, std::abs(value - expected));
      };
      for (std::size_t i = 0; i < csv.rows(); ++i) {
        const auto& row = csv.row(i);
        REQUIRE(row.size() == 10);
        const double t = std::min(static_cast<double>(i) * requested.step, requested.duration);
        meet(worst_t, row[0], t);
        meet(worst_q, row[1], from_x + vx * t);
        meet(worst_q, row[2], from_y + vy * t - 0.5 * g * t * t);
        meet(worst_q, row[3], angle + spin * t);
        meet(worst_v, row[4], vx);
        meet(worst_v, row[5], vy - g * t);
        meet(worst_v, row[6], spin);
        meet(worst_q, row[9], from_y + vy * t - 0.5 * g * t * t - radius);
      }
      CHECK(worst_t <= 1e-15);  // multiples of a step up to their rounding
      CHECK(worst_q <= off);
      CHECK(worst_v <= 1e-8);
      CHECK(csv.row(csv.rows() - 1)[0] == requested.duration);
    }
}

TEST_CASE("run.json states the formulation, the ending and the residual of the contact laws", "[written]") {
  test::TemporaryFolder place;
  for (const std::string formulation : {"penalty", "nonsmooth"}) {
    const auto j = test::read_json(ran(place, thrown("duration = 0.01"), formulation) / "run.json");
    CHECK(j["formulation"] == formulation);
    CHECK(j["ending"]["status"] == "finished");
    CHECK(j["ending"]["t_s"] == 0.01);
    CHECK(j["notes"].empty());
    CHECK(j["greatest_complementarity_residual"] == 0);  // no contact
  }
  // Sweeps over contacts end below the tolerance, which is coarse enough here to be visible: a
  // sweep removes most of the residual, but not six digits of it.
  const auto left = [&](const char* tolerance) {
    std::string options = "nonsmooth --set nonsmooth.solver=gauss-seidel --set nonsmooth.lcp_tolerance=";
    options += tolerance;
    for (const auto& set : off_centre) options += " --set '" + set + "'";
    const auto j = test::read_json(ran(place, test::scene_file("block_on_corners"), options) / "run.json");
    const double rate = j["greatest_complementarity_residual_m_per_s"];
    CHECK(rate > 0);
    // Relative to the greatest velocity: that of a step of gravity, g h = 1e-3 m/s.
    CHECK(rate <= 2 * 1e-4 * g * j["greatest_complementarity_residual"].get<double>());
    return j["greatest_complementarity_residual"].get<double>();
  };
  const double coarse = left("1e-4"), fine = left("1e-12");
  CHECK(coarse <= 1e-4);
  CHECK(coarse > 1e-10);
  CHECK(fine <= 1e-12);
}

TEST_CASE("run.json names the scheme of the run", "[written]") {
  test::TemporaryFolder place;
  const auto scheme = [&](const std::string& set) {
    return test::read_json(ran(place, thrown("duration = 0.01"), "nonsmooth" + set) /
                           "run.json")["provenance"]["options"]["nonsmooth"]["scheme"]
        .get<std::string>();
  };
  CHECK(scheme("") == "automatic");
  CHECK(scheme(" --set nonsmooth.step=1e-4") == "moreau-jean");
  CHECK(scheme(" --set nonsmooth.scheme=moreau-jean") == "moreau-jean");
  CHECK(scheme(" --set nonsmooth.scheme=event-driven") == "event-driven");
}

TEST_CASE("the residual of a solve is the violation of the contact laws by its impulses",
          "[written][contact-problem]") {
  // A chain of six contacts, D the second difference, solved roughly: the residual is computed here
  // again.
  ContactProblem p(LcpSolver::gauss_seidel, 1e-3);
  const int n = 6;
  p.reserve(n);
  p.rows = n;
  for (int i = 0; i < n; ++i) {
    p.D(i, i) = 2;
    if (i > 0) p.D(i, i - 1) = p.D(i - 1, i) = -1;
    p.b[i] = i == 4 ? 0.5 : -1 - 0.1 * i;
    p.unknowns.emplace_back().normal = i;
  }
  const auto s = p.solve();
  REQUIRE(s.solved);
  double worst = 0;
  for (int i = 0; i < n; ++i) {
    double u = p.b[i];
    for (int j = 0; j < n; ++j) u += p.D(i, j) * p.unknowns[j].impulse_n;
    worst = std::max(worst, std::abs(std::min(2 * p.unknowns[i].impulse_n, u)));
  }
  CHECK(worst > 1e-9);
  CHECK(s.residual_rate == Approx(worst).epsilon(1e-9));
  CHECK(s.residual == Approx(worst / 1.5).epsilon(1e-9));  // the greatest |b| is 1.5
  Work work;
  Extremes extremes;
  s.count(work, extremes);
  ContactSolution other;
  other.residual = 0.5 * s.residual;
  other.residual_rate = 3;
  other.pivots = 7;
  other.retries = 2;
  other.ambiguous = true;
  other.count(work, extremes);
  CHECK(extremes.lcp_residual == s.residual);
  CHECK(extremes.lcp_residual_rate == 3);
  CHECK(extremes.ambiguous == 1);
  CHECK(work.pivots == s.pivots + 7);
  CHECK(work.lcp_retries == 2);
}

TEST_CASE("a correct run has no notes", "[written]") {
  // A bouncing ball, a resting block, a pendulum on a pivot with clearance: nothing there is
  // singular, jammed, doubtful or passed to another solver, in any scheme, with forces recorded or
  // not.
  const auto ball = test::scene_file("bouncing_ball"), pendulum = test::scene_file("pendulum");
  for (const bool forces : {false, true})
    for (const auto scheme : {Scheme::moreau_jean, Scheme::event_driven, Scheme::automatic})
      for (auto scene : {read_scene(ball), block(), read_scene(pendulum)}) {
        scene.run.duration = std::min(scene.run.duration, 0.4);
        scene.run.forces = forces;
        scene.nonsmooth.scheme = scheme;
        if (scheme == Scheme::moreau_jean)
          scene.nonsmooth.step = 1e-5;
        else
          scene.nonsmooth.step.reset();
        const auto run = test::simulate(scene, Family::nonsmooth);
        CAPTURE(scene.mechanism.title, static_cast<int>(scheme), forces, run.notes);
        CHECK(run.ending.status == Ending::Status::finished);
        CHECK(run.notes.empty());
      }
  auto scene = read_scene(pendulum);
  const auto run = test::simulate(scene, Family::penalty);
  CAPTURE(run.notes);
  CHECK(run.notes.empty());
}

TEST_CASE("a resting contact is solved from the impulses of the step before", "[written][contact-problem]") {
  // At rest the impulses of a step are those of the last up to rounding. A solver that starts from
  // them confirms them: one sweep or one case, a second where rounding changes them. Without a
  // start a sweep reduces the error by the factor of the coupling of the two corners; to 1e-10 that
  // is tens of sweeps, and the case "both stick" is the sixth. The first tenth of the steps is
  // excluded.
  for (const auto solver : {LcpSolver::gauss_seidel, LcpSolver::enumeration}) {
    auto scene = block();
    scene.nonsmooth.solver = solver;
    const auto run = test::simulate(scene, Family::nonsmooth);
    CAPTURE(static_cast<int>(solver), run.work.pivots, run.work.lcp_solves);
    REQUIRE(run.work.steps >= 2000);
    CHECK(run.work.lcp_solves >= run.work.steps);
    CHECK(static_cast<double>(run.work.pivots) <= 2.2 * static_cast<double>(run.work.lcp_solves));
  }
}

TEST_CASE("run and compare write the documented files", "[written]") {
  test::TemporaryFolder folder;
  const auto out = folder.path() / "c";
  test::succeeded("compare " + test::flores().string() +
                  " --set run.revolutions=1 --set run.discard=0 --set penalty.contact=exact -o " +
                  out.string());
  for (const auto* name :
       {"comparison.json", "comparison.md", "penalty/run.json", "penalty/trajectory.csv",
        "penalty/events.csv", "penalty/signals.csv", "nonsmooth/run.json", "ideal/signals.csv",
        "figures/acceleration.pdf", "figures/acceleration.png", "figures/acceleration.gp",
        "figures/acceleration.dat", "figures/journal_orbit.pdf", "figures/paired_impacts.pdf"}) {
    CAPTURE(name);
    CHECK(std::filesystem::exists(out / name));
    CHECK(std::filesystem::file_size(out / name) > 100);
  }
  const auto j = test::read_json(out / "comparison.json");
  CHECK(j["penalty"]["contacts"]["gudgeon"]["restitution_delivered"].get<double>() == Approx(0.46));
  CHECK(j["nonsmooth"]["contacts"]["gudgeon"]["restitution_delivered"].get<double>() == Approx(0.46));
  CHECK(j["pairing"]["pairs"].size() >= 3);
  std::ifstream events(out / "penalty/events.csv");
  std::string header;
  std::getline(events, header);
  CHECK(header ==
        "t,joint,kind,crank_angle,v_n_minus,v_n_plus,v_t_minus,v_t_plus,impulse_n,impulse_t,duration,t_"
        "uncertainty");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(out))
    CHECK(entry.path().extension() != ".partial");
}
