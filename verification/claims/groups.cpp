// Groups of equal discs: a one-dimensional gas against its closed form, conserved sums of a gas,
// contact forces in a column.
#include "verification/claims/claim.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

// m, m/s, s, m
constexpr double radius = 0.01, speed = 1, duration = 1, length = 0.36;
// m, centres
constexpr std::array start{0.0211, 0.0547, 0.0839, 0.1163, 0.1502, 0.1918, 0.2297, 0.2761};

/// Equal discs on a line exchange their velocities in elastic impacts. Reduced by 2r for each disc
/// to the left, their positions are those of points that pass through one another and are reflected
/// at the walls (Tonks, Phys. Rev. 50, 1936).
std::vector<double> rods_after(double t) {
  const double room = length - 2 * radius * start.size();
  std::vector<double> points;
  for (std::size_t i = 0; i < start.size(); ++i) {
    const double at = start[i] - radius * static_cast<double>(2 * i + 1) + speed * t;
    const double turned = std::fmod(at, 2 * room);
    points.push_back(turned < room ? turned : 2 * room - turned);
  }
  std::ranges::sort(points);
  for (std::size_t i = 0; i < points.size(); ++i) points[i] += radius * static_cast<double>(2 * i + 1);
  return points;
}

Result rods(const std::string& pairs, const std::string& how) {
  std::string places;
  for (const double x : start) places += fmt::format("[{}, 0], ", x);
  return Simulation(
             parse_scene(
                 fmt::format("[groups.g]\nmass = 0.1\nradius = {}\npositions = [{}]\nvelocity = [{}, 0]\n"
                             "walls = [[0, 1], [0, -1], [{}, -1], [{}, 1]]\nsurface = \"s\"\npairs = \"{}\"\n"
                             "[surfaces.s]\nrestitution = 1\n[run]\nduration = {}\nstart = \"given\"\n"
                             "[nonsmooth]\n{}\n",
                             radius, places, speed, length, length, pairs, duration, how),
                 "rods"),
             "nonsmooth")
      .run();
}

void gas_of_rods(Findings& f) {
  const auto expected = rods_after(duration);
  const auto greatest_error = [&](const Result& run) {
    double most = 0;
    for (std::size_t i = 0; i < expected.size(); ++i)
      most = greatest(most, std::abs(run.final_state.q[3 * i] - expected[i]));
    return most;
  };
  const double room = length - 2 * radius * start.size();
  // Each point meets each other point twice during its way to and fro.
  const double meetings = speed * duration / room * static_cast<double>(start.size());
  const double h = 1e-5;
  const char* const subject = "eight discs on a line between walls, e = 1";
  f.at_most(
      claim_name(subject, "positions after 1 s, greatest error, pairs = near", "Moreau–Jean, h = 1e-5 s"),
      "m", greatest_error(rods("near", fmt::format("scheme = \"moreau-jean\"\nstep = {}", h))),
      2 * speed * h * meetings, "one-dimensional gas (Tonks 1936)",
      "each of about 40 impacts of a disc is up to a step late, at 2 m/s");
  f.at_most(claim_name(subject, "positions after 1 s, greatest error, pairs = each", "event-driven"), "m",
            greatest_error(rods("each", "scheme = \"event-driven\"")), 1e-8,
            "one-dimensional gas (Tonks 1936)",
            "times of impacts to 1e-11 s; each of 40 impacts carries the errors of earlier ones");
}

std::string gas_group(const char* name, double x, double v, const char* more) {
  return fmt::format(
      "[groups.{}]\nmass = 0.2\nradius = 0.05\ngrid = [6, 10]\norigin = [{}, {}]\nspacing = [0.12, 0.12]\n"
      "stagger = 0.02\nvelocity = [{}, {}]\nsurface = \"s\"\npairs = \"near\"\n{}",
      name, x, 0.1 * x, v, 0.1 * v, more);
}

/// Two groups of discs that fly through each other, without walls or weight.
void sums_of_a_gas(Findings& f) {
  Simulation simulation(
      parse_scene(gas_group("a", 0, 0.8, "") + gas_group("b", 0.75, -0.7, "touches = \"a\"\n") +
                      "[surfaces.s]\nrestitution = 1\n[run]\nduration = 0.6\nstart = \"given\"\n[nonsmooth]\n"
                      "scheme = \"moreau-jean\"\nstep = 1e-4\nlcp_tolerance = 1e-12\n",
                  "gas"),
      "nonsmooth");
  const auto sums = [](const State& s) {
    std::array<double, 3> all{};  // P_x, P_y, 2T
    for (std::size_t b = 0; b < s.v.size(); b += 3) {
      all[0] += 0.2 * s.v[b];
      all[1] += 0.2 * s.v[b + 1];
      all[2] += 0.2 * (s.v[b] * s.v[b] + s.v[b + 1] * s.v[b + 1]);
    }
    return all;
  };
  const auto before = sums(simulation.state()), after = (simulation.run(), sums(simulation.state()));
  const double scale = 0.2 * 120;  // kg m/s, of all discs at 1 m/s
  f.within(
      "two colliding groups of 60 discs, "
      "e = 1: change of momentum over total mass × 1 m/s [Moreau–Jean, h = 1e-4 s]",
      "", std::hypot(after[0] - before[0], after[1] - before[1]) / scale, 0, 1e-12,
      "0: impulses of a pair are opposite", "rounding of 6,000 steps and some hundred impacts");
  f.relative("two colliding groups of 60 discs, e = 1: kinetic energy after 0.6 s [Moreau–Jean, h = 1e-4 s]",
             "J", 0.5 * after[2], 0.5 * before[2], 1e-6, "initial energy: u⁺ = −u⁻ does no work",
             "residual of the contact problems in some hundred impacts");
}

/// A column of n discs: contact k transmits m g (n − k), the wall n m g, all other contacts n (n −
/// 1)/2 m g together.
void column(Findings& f) {
  const int n = 20;
  const double weight = 0.3 * 9.81;
  Simulation simulation(
      parse_scene(
          fmt::format(
              "gravity = [0, -9.81]\n[groups.g]\nmass = 0.3\nradius = 0.1\ngrid = [1, {}]\n"
              "origin = [0, 0.1]\n"
              "spacing = [1, 0.2]\nwalls = [[0, 0], [1, 0]]\nsurface = \"s\"\npairs = \"near\"\n"
              "[surfaces.s]\nrestitution = 0.5\nfriction = 0.3\n[run]\nduration = 0.3\nstart = \"given\"\n"
              "[nonsmooth]\nscheme = \"moreau-jean\"\nstep = 1e-3\nlcp_tolerance = 1e-10\n",
              n),
          "column"),
      "nonsmooth");
  test::LastForces last;
  simulation.run({.observers = {&last}});
  double on_wall = 0, between = 0;
  for (std::size_t e = 0; e < last.elements.size(); ++e)
    (last.elements[e].name.ends_with("wall1") ? on_wall : between) += last.now.elements[e].fn;
  const char* reason = "contact problems are solved to 1e-10 of g h; forces range from one weight to twenty";
  f.relative("column of 20 discs at rest: normal force on the floor [Moreau–Jean, h = 1e-3 s]", "N", on_wall,
             n * weight, 1e-7, "n m g", reason);
  f.relative("column of 20 discs at rest: sum of normal forces between discs [Moreau–Jean, h = 1e-3 s]", "N",
             between, 0.5 * n * (n - 1) * weight, 1e-7, "Σ m g (n − k)", reason);
}

}  // namespace

Parts groups() { return {gas_of_rods, sums_of_a_gas, column}; }

}  // namespace freeplay::verification
