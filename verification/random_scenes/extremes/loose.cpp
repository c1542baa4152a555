// Joints with clearance where the first two contacts of the test rig are not sufficient: two joints
// in one chain, and a thousand revolutions.
#include "verification/random_scenes/extremes/extremes.hpp"
#include "verification/support/runs.hpp"

namespace freeplay::verification::random_scenes {
namespace {

/// Greatest error of three contacts, relative to the permitted errors. An impact acts `delay` s
/// late and changes the speed of the joint by a·delay, a being the gap's acceleration; the bounce
/// of duration 2u/a that follows changes by 2·delay. So it shifts later contacts by up to 3·delay;
/// at the end of a flight f at v ≈ ½ a f … a f, a shift of s changes the approach speed by up to
/// 2s/f of itself.
double onset_error_of_three(const Result& run, const Result& exact, const std::array<double, 3>& delays,
                            double found_to) {
  double worst = 0, shift = found_to;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto a = test::touch(run, i), b = test::touch(exact, i);
    if (a.contact != b.contact) return INFINITY;
    double since = 0;  // last contact of this joint, or the start
    for (std::size_t j = 0; j < i; ++j)
      if (const auto before = test::touch(exact, j); before.contact == b.contact) since = before.t;
    const double may = shift + 1e-6 * b.t;
    worst = std::max({worst, std::abs(a.t - b.t) / may,
                      std::abs(a.v_n_minus / b.v_n_minus - 1) / (1e-4 + 2 * may / (b.t - since))});
    shift += 3 * delays[i];
  }
  return worst;
}

/// Two pins with clearance in one chain, up to the third contact, the first of the other pin. The
/// event-driven scheme is compared with penalty at two stiffnesses, by the exponent of the contact
/// duration of Hertz, K^(−2/5), and with time stepping at two step sizes.
Verdict two_loose(Family family) {
  auto scene = read_scene(test::scene_file("four_bar_two"));
  scene.run.duration = 0.0105;  // between the third contact and the fourth
  scene.run.discard = 0;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.scheme = Scheme::event_driven;
  scene.nonsmooth.tolerance = 1e-12;
  const auto exact = test::simulate(scene, Family::nonsmooth);
  const double third = test::touch(exact, 2).t;
  scene.nonsmooth.scheme = Scheme::moreau_jean;
  const double young = *scene.mechanism.surfaces[0].young;
  double worst = 0;
  Result run;
  std::array<double, 2> late{};
  for (const int i : {0, 1}) {
    *scene.mechanism.surfaces[0].young = young * std::array{1e2, 1e4}[i];
    const double h = std::array{1e-5, 1e-6}[i];
    scene.nonsmooth.step = h;
    run = test::simulate(scene, family);
    if (run.ending.status != Ending::Status::finished && test::touches(run).size() < 3)
      return {Outcome::refused, run.ending.reason};
    std::array<double, 3> delays{h, h, h};
    if (family == Family::penalty)
      for (std::size_t k = 0; k < 3; ++k) delays[k] = test::touch(run, k).duration;
    worst = std::max(worst, onset_error_of_three(run, exact, delays, family == Family::penalty ? 0 : h));
    late[i] = std::abs(test::touch(run, 2).t - third);
  }
  // The leading term alone gives a factor of 100^(2/5) for a hundredfold stiffness: half as much
  // again for the next terms.
  if (family == Family::penalty)
    worst = std::max(worst, std::abs(std::log(late[0] / late[1] / std::pow(100, 0.4))) / std::log(1.5));
  return within(run, worst, 1,
                "first three contact onsets against the event-driven scheme, error over its bound");
}

/// The clearance of the rig over a thousand revolutions. The motion is not known for that long.
/// Every run must keep positions to a thousandth of the clearance, the energy to the fifth digit of
/// the loss, and the wall. The penetration is at most Hertz's depth for the slider's whole mass (no
/// effective mass is greater) at the fastest approach, twice that under a lasting load; in time
/// stepping the distance of one step, between events rounding.
Verdict long_loose(Family family, Scheme scheme) {
  auto scene = read_scene(test::flores());
  scene.instruments.clear();
  scene.run.discard = 0;
  scene.run.duration = 1000 * 0.3;
  scene.run.output_step = 1;
  scene.penalty.contact = ContactLaw::exact;
  scene.nonsmooth.scheme = scheme;
  const double c = std::get<RevoluteJoint>(scene.mechanism.joints[2]).clearance->radial;
  const auto run = test::simulate(scene, family);
  const auto& contact = run.contacts.at(0);
  const double v = contact.fastest_approach, mass = scene.mechanism.bodies[2].mass;
  const double lost = run.ledger.contact + run.ledger.friction;
  const double yields = family == Family::penalty
                            ? 2 * std::pow(5 * mass * v * v / (4 * contact.model.stiffness), 0.4)
                        : scheme == Scheme::moreau_jean ? *scene.nonsmooth.step * v
                                                        : 1e-6 * c;
  const double position = run.extremes.constraint_length / (1e-3 * c),
               energy = std::abs(run.ledger.closure()) / (1e-5 * lost), wall = contact.penetration / yields;
  auto assessed =
      within(run, std::max({position, energy, wall}), 1, "of the bounds on Φ, energy, penetration");
  assessed.detail += fmt::format(" (Φ {:.1g}, energy {:.1g}, penetration {:.1g})", position, energy, wall);
  return assessed;
}

}  // namespace

std::vector<Cell> loose_cells() {
  std::vector<Cell> cells;
  for (const auto family : {Family::penalty, Family::nonsmooth})
    cells.push_back({"scene", "two loose joints in one chain", 0,
                     family == Family::penalty ? "penalty" : "moreau-jean",
                     [=] { return two_loose(family); }});
  for (const auto& [name, family, scheme] : {std::tuple{"penalty", Family::penalty, Scheme::moreau_jean},
                                             {"moreau-jean", Family::nonsmooth, Scheme::moreau_jean},
                                             {"event-driven", Family::nonsmooth, Scheme::event_driven}})
    cells.push_back({"scene", "1,000 loose revolutions", 0, name,
                     [family = family, scheme = scheme] { return long_loose(family, scheme); }});
  return cells;
}

}  // namespace freeplay::verification::random_scenes
