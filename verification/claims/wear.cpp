// Wear of bearings and the load of their elastic foundation, against closed forms and quadrature.
#include <numbers>

#include "simulation/bearing_load.hpp"
#include "simulation/bearing_pressure.hpp"
#include "study/wear/worn_bearing.hpp"
#include "verification/claims/claim.hpp"
#include "verification/references/bearing_wear.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification {
namespace {

using std::numbers::pi;

constexpr double force = 100, coefficient = 1e-15, play = 0.5e-3;  // N, m²/N, m
constexpr reference::BoreAndJournal bore{10e-3, play, 20e-3};
/// Pa/m: 100 N on the narrowest lune press 4 MPa, which deflects by 4e-11 m.
constexpr double rigid = 1e17;

std::string micrometres(double depth) { return fmt::format("{:g} µm", 1e6 * depth); }

WornBearing unworn(std::size_t n, bool bearing) {
  return WornBearing({"pin",
                      {bore.bore, play, bore.length, rigid, 0},
                      bearing ? coefficient : 0,
                      bearing ? 0 : coefficient,
                      std::vector<double>(n),
                      {}});
}

void constant_load(Findings& f) {
  constexpr std::size_t n = 720;
  for (const double depth : {1e-6, 10e-6, 100e-6}) {
    const double area = reference::lune_area_by_chord(bore, depth);
    BearingLoad load;
    load.on_bearing = 0.3, load.force = force;
    load.work = force * reference::sliding_to(bore, area, force, coefficient);
    auto worn = unworn(n, true);
    worn.wear(std::vector{load}, 1, 1e-4);
    const auto name = [&](const char* quantity) {
      return claim_name(fmt::format("bearing worn by {} under a constant load", micrometres(depth)),
                        quantity);
    };
    const std::string source = "pin's circle outside the bore (verification/references/bearing_wear.hpp)";
    f.relative(name("worn area"), "m²", worn.bearing_area(), area, 1e-9, "A = k F s/L",
               "the area is imposed; rounding of 1e-16 R² in 1e-9 m²");
    f.relative(name("greatest depth"), "m", worn.greatest_bearing(), depth, 1e-3, source,
               "required accuracy; means over two angles change a lune of 14 angles by 4e-4");
    // Directions with a depth of more than a hundredth of the greatest, as half of their number.
    std::size_t within = 0;
    for (const double d : worn.bearing_depth()) within += d > 0.01 * depth;
    const double spacing = 360.0 / n;
    f.within(name("half angle"), "°", 0.5 * spacing * static_cast<double>(within),
             reference::lune_half_angle(bore, depth) * 180 / pi, spacing, source, "spacing of the angles");
  }
}

void rotating_load(Findings& f) {
  for (const bool bearing : {true, false}) {
    const double depth = 100e-6, radius = bearing ? bore.bore : bore.journal(), side = bearing ? 1 : -1;
    const double area = pi * depth * (2 * radius + side * depth);
    constexpr int classes = 60;
    std::vector<BearingLoad> loads;
    for (int i = 0; i < classes; ++i) {
      BearingLoad load;
      const double width = 2 * pi / classes, angle = width * (i + 0.5);
      (bearing ? load.on_bearing : load.on_journal) = angle;
      (bearing ? load.width_on_bearing : load.width_on_journal) = width;
      load.force = force;
      load.work = force * reference::sliding_to(bore, area, force, coefficient) / classes;
      loads.push_back(load);
    }
    auto worn = unworn(180, bearing);
    worn.wear(loads, 1, 0.01);
    const auto depths = bearing ? worn.bearing_depth() : worn.journal_depth();
    const auto [least, most] = std::ranges::minmax_element(depths);
    const double even = reference::even_depth(radius, area, side);
    const std::string subject = bearing ? "bearing under a load that rotates with the journal"
                                        : "journal under a load fixed in the bearing";
    const std::string reason =
        "passes are doubled until depths change by 1 %; the rest is 1.7 times as large";
    f.relative(claim_name(subject, "least depth of wear"), "m", *least, even, 0.03, "even wear of the area",
               reason);
    f.relative(claim_name(subject, "greatest depth of wear"), "m", *most, even, 0.03, "even wear of the area",
               reason);
  }
}

void foundation(Findings& f) {
  constexpr double stiffness = 1e12;  // Pa/m
  const std::vector<double> round(720);
  Pressure pressure;
  for (const double depth : {1e-6, 10e-6, 100e-6}) {
    const double load = reference::foundation_load(bore, stiffness, depth);
    solve({bore.bore, play, bore.length, stiffness, 0}, round, {}, 0, load, 0.3, 0, pressure);
    f.relative(
        claim_name("journal on an elastic foundation",
                   fmt::format("penetration under the load of {}", micrometres(depth))),
        "m", pressure.centre.norm() - play, depth, 1e-5, "Gauss's quadrature of the exact geometry",
        "parabolas through angles h apart: h³/15 of the third derivative, 2e-6 of the narrowest contact");
  }
  for (const double ratio : {0.01, 0.1, 1.0}) {
    const double alpha = std::acos(1 / (1 + ratio));
    const double expected = reference::gauss(
        [&](double phi) {
          const double half = std::sin(0.5 * phi);
          return (ratio * std::cos(phi) - 2 * half * half) * std::cos(phi);
        },
        -alpha, alpha);
    f.relative(claim_name("contact law of the elastic foundation",
                          fmt::format("force over K L R c at a penetration of {} c", ratio)),
               "", RoundFoundation::force(ratio), expected, 1e-12, "Gauss's quadrature",
               "rounding of a closed form with terms of the size of 1");
  }
}

void turning_shaft(Findings& f) {
  // The resultant is the load of 100 N at rest on the shaft, which slides by 2π R_j a turn.
  auto scene = read_scene(test::source_folder() / "cases/wear-steady/scene.toml");
  scene.run.duration = 3, scene.run.discard = 1;
  const double expected = 2 * force * 2 * pi * bore.journal();
  for (const auto family : {Family::penalty, Family::nonsmooth}) {
    BearingLoadObserver observer(scene);
    Simulation simulation(scene, test::name_of(family));
    test::finished(simulation, {&observer});
    const auto loads = observer.loads();
    double work = 0;
    for (const auto& load : loads.at(0).loads) work += load.work;
    f.relative(claim_name("bearing on a turning shaft", "work of the normal force over two turns",
                          test::name_of(family)),
               "N m", work, expected, 1e-3, "F · 2π R_j a turn",
               "the block has come to rest: impacts of a fall of 0.5 mm with e = 0.3 end after 10 ms");
  }
}

}  // namespace

Parts wear() { return {constant_load, rotating_load, foundation, turning_shaft}; }

}  // namespace freeplay::verification
