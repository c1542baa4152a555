#include "formulations/penalty/law_curves.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <cmath>
#include <nlohmann/json.hpp>

#include "formulations/penalty/contact_law.hpp"
#include "formulations/penalty/friction_law.hpp"
#include "io/output_file.hpp"
#include "io/run_json.hpp"

namespace freeplay {
namespace {

using Pair = std::array<double, 2>;  // δ, δ̇

/// m δ̈ = −F(δ, δ̇) from first touch until the contact opens, in 2000 steps or so.
std::string impact_loop(const ContactForce& law, const char* name, const ImpactSetting& s) {
  const double h = elastic_duration(law.elastic, s.mass, s.speed) / 500;
  const auto force = [&](const Pair& y) {
    return y[0] > 0 ? law.force(law.elastic.force(y[0]), y[1], s.speed) : 0;
  };
  const auto side = [&](const Pair& y, Pair& d, double) {
    d[0] = y[1];
    d[1] = -force(y) / s.mass;
  };
  boost::numeric::odeint::runge_kutta4<Pair> stepper;
  Pair y{0, s.speed};
  std::string rows = fmt::format("{},0,{}\n", name, law.viscous * s.speed);
  for (int i = 0; i < 20000; ++i) {
    stepper.do_step(side, y, i * h, h);
    if (!(y[0] > 0)) break;
    rows += fmt::format("{},{},{}\n", name, y[0], force(y));
  }
  return rows + fmt::format("{},0,0\n", name);
}

}  // namespace

void write_law_curves(const Scene& scene, const ImpactSetting& setting, const std::filesystem::path& folder) {
  const System system(scene.mechanism);
  if (system.contacts() == 0) throw ModelError("", "has no joint with clearance, so no contact law");
  const auto& facts = system.contact_facts(0);

  std::string loops = "law,delta,force\n", delivered = "law,requested,delivered\n",
              friction = "law,speed,coefficient\n";
  for (const auto& law : contact_laws()) {
    Scene one = scene;
    one.penalty.contact = law.law;
    if (law.law < ContactLaw::johnson) one.penalty.damping.reset();
    if (law.law >= ContactLaw::johnson && !facts.bearing_length) continue;
    if (law.law == ContactLaw::kelvin_voigt &&
        !(one.penalty.kelvin_stiffness && one.penalty.kelvin_damping)) {
      // The spring that stores the impact's energy at Hertz's depth, with the damper that delivers e in full.
      one.penalty.contact = ContactLaw::hertz;
      const auto hertz = make_contact_force(one, facts).elastic;
      const double depth =
          std::pow(1.25 * setting.mass * setting.speed * setting.speed / hertz.stiffness, 0.4);
      one.penalty.contact = law.law;
      one.penalty.kelvin_stiffness = setting.mass * setting.speed * setting.speed / (depth * depth);
      const double log_e = std::log(std::max(1e-3, facts.surface.restitution.value_or(1)));
      const double zeta = -log_e / std::hypot(3.14159265358979, log_e);
      one.penalty.kelvin_damping = 2 * zeta * std::sqrt(*one.penalty.kelvin_stiffness * setting.mass);
    }
    loops += impact_loop(make_contact_force(one, facts), law.name.data(), setting);
    if (!is_point_law(law.law)) continue;
    for (int i = 1; i <= 50; ++i)
      delivered += fmt::format("{},{},{}\n", law.name, 0.02 * i,
                               delivered_restitution(damping_factor(law.law, 0.02 * i)));
  }
  for (std::size_t i = 0; i < friction_law_names.size(); ++i) {
    Scene one = scene;
    one.penalty.friction = static_cast<FrictionLaw>(i);
    const auto law = make_friction(one.penalty, 1);  // over μ
    for (int k = -200; k <= 200; ++k) {
      const double v = 5e-2 * std::max(one.penalty.friction_v1, one.penalty.friction_v0) * k / 2;
      const int zone = law.zone(v);
      // LuGre in steady sliding: ż = 0.
      const double x = v / law.v0, z = (v < 0   ? -1
                                        : v > 0 ? 1
                                                : 0) *
                                       (law.mu + (law.mu_static - law.mu) * std::exp(-x * x)) / law.sigma0;
      friction += fmt::format("{},{},{}\n", friction_law_names[i], v, law.coefficient(v, zone, z));
    }
  }
  make_folder(folder);
  write_file(folder / "impact_loops.csv", loops);
  write_file(folder / "delivered.csv", delivered);
  write_file(folder / "friction.csv", friction);
  const nlohmann::json document = {{"contact", facts.name},
                                   {"mass_kg", setting.mass},
                                   {"approach_m_per_s", setting.speed},
                                   {"restitution_asked", facts.surface.restitution.value_or(1)},
                                   {"provenance", provenance(scene)}};
  write_file(folder / "laws.json", document.dump(2) + "\n");
}

}  // namespace freeplay
