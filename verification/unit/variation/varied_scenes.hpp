// Random scenes whose derivatives are compared with Richardson-extrapolated differences of whole runs.
#pragma once

#include "analysis/sensitivity.hpp"
#include "analysis/varied_key.hpp"
#include "facade/identify.hpp"
#include "verification/random_scenes/numbers.hpp"
#include "verification/support/rig.hpp"

namespace freeplay::test::varied {

using verification::random_scenes::Draw;
using verification::random_scenes::exact;
using verification::random_scenes::toml;

struct RandomCase {
  std::string text;
  std::vector<std::string> quantities, keys;
};

inline std::vector<std::string> with_events(std::vector<std::string> more) {
  more.insert(more.end(),
              {"event.1.t", "event.1.v_n_minus", "event.1.impulse_n", "event.3.t", "event.3.impulse_n"});
  return more;
}

/// The nonsmooth settings of all scenes.
inline const std::string by_events = "[nonsmooth]\nscheme = \"event-driven\"\ntolerance = 1e-12\n";

/// A random number as a scene's text has it.
inline double number(Draw& r, double low, double high) { return exact(r.between(low, high)); }

/// A disc with spin between a floor and two walls.
inline RandomCase disc_in_box(Draw& r) {
  const double m = r.between(0.1, 2), radius = r.between(0.02, 0.1), friction = number(r, 0.02, 0.6),
               restitution = number(r, 0.5, 0.9), spin = number(r, -20, 20), vy = number(r, -2, 2),
               vx = number(r, -2, 2), y = number(r, 0.2, 0.8), x = number(r, -0.3, 0.3),
               inertia = exact(m * radius * radius * r.between(0.3, 0.6)), gy = -number(r, 5, 12),
               gx = number(r, -2, 2);
  const auto wall = [&](const char* name, const char* keys) {
    return plane(name, "ground", "disc", exact(radius), "s", keys);
  };
  return {fmt::format("gravity = [{}, {}]\n", gx, gy) +
              body("disc", exact(m), inertia,
                   fmt::format("position = [{}, {}]\nvelocity = [{}, {}]\nangular_velocity = {}\n", x, y, vx,
                               vy, spin)) +
              wall("floor", "") + wall("left", "at = [[-0.6, 0], [0, 0]]\naxis = [0.1, -1]\n") +
              wall("right", "at = [[0.6, 0], [0, 0]]\naxis = [0.2, 1]\n") +
              surface("s", restitution, friction) + run_for(1.2, "start = \"given\"\n") + by_events,
          with_events({"end.disc.x", "end.disc.vy", "end.disc.omega", "energy.dissipated_by_friction",
                       "energy.dissipated_in_contacts", "mean.floor.fn", "mean.disc.y"}),
          {"surfaces.s.restitution", "surfaces.s.friction", "bodies.disc.mass", "bodies.disc.inertia",
           "gravity[1]", "contacts.floor.radius", "bodies.disc.velocity[0]"}};
}

/// A pendulum with a spring between two end stops.
inline RandomCase stopped_pendulum(Draw& r) {
  const double restitution = number(r, 0.6, 0.95), damping = number(r, 0.1, 1), stiffness = number(r, 5, 40),
               lower = -number(r, 0.5, 1.2), inertia = number(r, 0.02, 0.1), mass = number(r, 0.5, 3),
               gravity = -number(r, 5, 12);
  return {
      fmt::format("gravity = [0, {}]\n", gravity) + body("bar", mass, inertia, "position = [0.3, 0]\n") +
          pin("pivot", "ground", "bar", {}, {-0.3, 0}) +
          stop("stop", "angle-stop", "pivot", fmt::format("lower = {}\nupper = 0.6\nradius = 0.2\n", lower)) +
          spring("spring", "ground", "bar", {0.4, 0.5}, {0.1, 0.05}, stiffness, 0.4,
                 fmt::format("damping = {}\n", damping)) +
          surface("s", restitution) + run_for(1.5) + by_events,
      with_events({"end.bar.theta", "end.bar.omega", "end.pivot.fy", "mean.pivot.fx",
                   "energy.dissipated_in_dampers"}),
      {"surfaces.s.restitution", "bodies.bar.mass", "bodies.bar.inertia", "contacts.stop.lower",
       "loads.spring.stiffness", "loads.spring.damping", "joints.pivot.at[1][0]", "gravity[1]"}};
}

/// A free journal in a free bearing with friction.
inline RandomCase ring_and_journal(Draw& r) {
  const double friction = number(r, 0.02, 0.4), restitution = number(r, 0.6, 0.95), spin = number(r, -30, 30),
               vy = number(r, -0.5, 0.5), vx = number(r, -0.5, 0.5), y = number(r, -4e-4, 4e-4),
               x = number(r, -4e-4, 4e-4), mass = number(r, 0.2, 1), turn = number(r, -5, 5),
               ring = number(r, 0.5, 3);
  return {
      body("ring", ring, 0.01, fmt::format("angular_velocity = {}\n", turn)) +
          body("journal", mass, 0.0004,
               fmt::format("position = [{}, {}]\nvelocity = [{}, {}]\nangular_velocity = {}\n", x, y, vx, vy,
                           spin)) +
          pin("pin", "ring", "journal", {}, {}, loose(1e-3, 0.02)) + surface("s", restitution, friction) +
          run_for(0.02, "start = \"given\"\n") + by_events,
      with_events(
          {"end.journal.vx", "end.ring.omega", "end.pin.ex", "end.pin.gap", "energy.dissipated_in_contacts"}),
      {"surfaces.s.restitution", "surfaces.s.friction", "joints.pin.clearance", "joints.pin.bearing_radius",
       "bodies.journal.mass", "bodies.ring.inertia", "bodies.journal.velocity[0]"}};
}

/// A driven slider-crank whose gudgeon pin has clearance.
inline RandomCase slider_crank(Draw& r) {
  const double speed = number(r, 10, 40), friction = number(r, 0.01, 0.3), restitution = number(r, 0.5, 0.9),
               clearance = number(r, 1e-4, 5e-4), slider = number(r, 0.5, 2),
               inertia = number(r, 0.005, 0.02), rod = number(r, 0.5, 2);
  return {"gravity = [0, -9.81]\n" + body("crank", 1, 0.001) + body("rod", rod, inertia) +
              body("slider", slider, 0.001) + pin("main", "ground", "crank") +
              pin("big_end", "crank", "rod", {0.05, 0}, {-0.15, 0}) +
              pin("gudgeon", "rod", "slider", {0.15, 0}, {}, loose(clearance, 0.011)) +
              guide("guide", "ground", "slider") + surface("s", restitution, friction) +
              motor("motor", "main", speed) + run_for(0.03, "start = \"ideal\"\n") + by_events,
          with_events(
              {"end.slider.x", "end.slider.vx", "end.rod.omega", "energy.work_of_drives", "end.guide.fy"}),
          {"surfaces.s.restitution", "surfaces.s.friction", "joints.gudgeon.clearance", "bodies.slider.mass",
           "joints.big_end.at[0][0]", "drives.motor.speed"}};
}

/// A bar on a pivot or a slider on a guide with elements of all kinds whose forces have kinks or jumps.
inline RandomCase with_elements(Draw& r) {
  const bool turns = r.between(0, 1) < 0.6;
  const auto either = [&](double share) { return r.between(0, 1) < share; };
  const double mass = r.between(0.5, 2), speed = r.between(1, 6) * (either(0.5) ? 1 : -1);
  std::string text, joint = turns ? "'revolute'" : "'translational'";
  RandomCase c;
  const char* spring = turns ? "torsional-spring-damper" : "spring-damper";
  c.keys = {"bodies.p.mass"};
  c.quantities = {turns ? "end.p.theta" : "end.p.x",
                  turns ? "end.p.omega" : "end.p.vx",
                  "energy.kinetic",
                  "energy.dissipated_in_dampers",
                  "energy.work_of_drives",
                  turns ? "mean.p.alpha" : "mean.p.ax"};
  text = toml("gravity = [{}, {}]\n[bodies.p]\nmass = {}\ninertia = {}\n", turns ? 0.0 : r.between(-2, 2),
              -r.between(0, 5), mass, r.between(0.05, 0.2));
  text += turns
              ? toml("position = [0, -0.1]\nangular_velocity = {}\nvelocity = [{}, 0]\n", speed, 0.1 * speed)
              : toml("position = [0.5, 0]\nvelocity = [{}, 0]\n", 0.2 * speed);
  text += "[joints.h]\ntype = " + joint + "\nbetween = ['ground', 'p']\n" +
          (turns ? "at = [[0, 0], [0, 0.1]]\n" : "at = [[0, 0], [0, 0]]\naxis = [1, 0]\n");
  // Lengths of the slider are a tenth of the angles of the bar, its forces ten times the torques.
  const double unit = turns ? 1 : 0.1, rest = turns ? 0 : 0.5, force = turns ? 1 : 10, rate = force / unit;
  text += toml("[loads.s]\ntype = '{}'\nbetween = ['ground', 'p']\n", spring);
  const bool one_way = either(0.4);
  if (either(0.3)) {
    text += toml("{} = [[{}, {}], [{}, {}], [{}, {}], [{}, {}]]\n", turns ? "torque_table" : "force_table",
                 rest - 1 * unit, -r.between(5, 8) * force, rest - 0.3 * unit, -r.between(0.5, 2) * force,
                 rest + 0.2 * unit, r.between(0.5, 2) * force, rest + 1 * unit, r.between(5, 8) * force);
    const std::string table = turns ? "loads.s.torque_table" : "loads.s.force_table";
    c.keys.insert(c.keys.end(), {table + "[1][0]", table + "[2][1]"});
  } else {
    text += toml("stiffness = {}\n{} = {}\n", r.between(2, 8) * rate, turns ? "free_angle" : "free_length",
                 rest + r.between(-0.3, 0.3) * unit);
    c.keys.insert(c.keys.end(), {"loads.s.stiffness", turns ? "loads.s.free_angle" : "loads.s.free_length"});
  }
  if (either(0.4)) {
    text += toml("damping_table = [[{}, {}], [{}, {}], [0, 0], [{}, {}], [{}, {}]]\n", -6 * unit,
                 -r.between(0.5, 1) * force, -3 * unit, -r.between(0.05, 0.15) * force,
                 r.between(1, 3) * unit, r.between(0.05, 0.15) * force, 6 * unit, r.between(0.5, 1) * force);
    c.keys.push_back("loads.s.damping_table[3][0]");
    c.keys.push_back("loads.s.damping_table[1][1]");
  } else {
    text += toml("damping = {}\n", r.between(0.02, 0.2) * rate);
    c.keys.push_back("loads.s.damping");
  }
  if (one_way) text += either(0.5) ? "one_way = 'pull'\n" : "one_way = 'push'\n";
  if (either(0.5)) {
    text += toml(
        "[loads.b]\ntype = '{}'\nbetween = ['ground', 'p']\nlower = {}\nupper = {}\nstiffness = {}\n"
        "damping = {}\n",
        turns ? "torsional-bump-stop" : "bump-stop", rest - r.between(0.2, 0.6) * unit,
        rest + r.between(0.2, 0.6) * unit, r.between(20, 80) * rate, r.between(0.2, 1) * rate);
    c.keys.insert(c.keys.end(), {"loads.b.upper", "loads.b.lower", "loads.b.stiffness", "loads.b.damping"});
  }
  const double kind = r.between(0, 1);
  text += kind < 0.8 ? "[drives.m]\njoint = 'h'\n" : "";
  if (kind < 0.35) {
    const std::string target = turns ? "target_angle" : "target_position",
                      limit = turns ? "torque_limit" : "force_limit";
    text += toml("{} = {}\nproportional = {}\nderivative = {}\nintegral = {}\n{} = {}\n", target,
                 rest + r.between(-0.5, 0.5) * unit, r.between(3, 10) * rate, r.between(0.05, 0.3) * rate,
                 either(0.5) ? r.between(1, 10) * rate : 0.0, limit, r.between(0.5, 2) * force);
    c.keys.insert(c.keys.end(), {"drives.m." + target, "drives.m.proportional", "drives.m." + limit});
  } else if (kind < 0.55 && turns) {
    text += toml("target_speed = {}\nproportional = {}\nintegral = {}\ntorque_limit = {}\n", r.between(3, 10),
                 r.between(0.1, 0.6), r.between(0.5, 3), r.between(0.5, 1.5));
    c.keys.insert(c.keys.end(), {"drives.m.target_speed", "drives.m.proportional", "drives.m.torque_limit"});
  } else if (kind < 0.65 && turns) {
    text += toml("voltage = {}\nresistance = {}\ntorque_constant = {}\ninductance = {}\n", r.between(1, 5),
                 r.between(0.5, 2), r.between(0.1, 0.4), r.between(0.005, 0.05));
    c.keys.insert(c.keys.end(), {"drives.m.voltage", "drives.m.resistance"});
  } else if (kind < 0.8) {
    text += toml("{} = {}\n", turns ? "torque" : "force", r.between(-1, 1) * force);
    c.keys.push_back(turns ? "drives.m.torque" : "drives.m.force");
  }
  text += toml(
      "[run]\nduration = {}\nstart = 'given'\n[nonsmooth]\nscheme = 'event-driven'\ntolerance = 1e-12\n"
      "[penalty]\ntolerance = 1e-12\n",
      r.between(0.8, 2));
  c.text = std::move(text);
  return c;
}

/// Derivatives of a scene's quantities with respect to keys.
inline Sensitivities of(const std::string& text, std::vector<std::string> quantities,
                        std::vector<std::string> keys, const std::vector<std::string>& options = {}) {
  return sensitivities(parse_scene(text, "s.toml", options),
                       {.of = std::move(quantities), .to = std::move(keys)});
}

/// Checks the derivatives of a quantity by its first keys, in their order.
inline void check_derivatives(const Sensitivity& q, const std::vector<double>& expected, double relative,
                              double margin = 0) {
  REQUIRE(q.derivatives.size() >= expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CAPTURE(q.name, i);
    CHECK(q.derivatives[i] == Approx(expected[i]).epsilon(relative).margin(margin));
  }
}

/// Values of the quantities with another value of one key.
inline std::vector<double> values_at(const RandomCase& c, const std::string& key, double value,
                                     const std::string& formulation) {
  const auto scene = property(parse_scene(c.text, "random"), key, family_of(formulation)).at(value);
  std::vector<double> values;
  for (const auto& q :
       sensitivities(scene, {.of = c.quantities, .to = {}, .formulation = formulation}).quantities)
    values.push_back(q.value);
  return values;
}

/// Extrapolated differences of whole runs for one key, with their own errors: truncation by the
/// change between extrapolations, noise of the runs by the finest one.
struct Differences {
  std::vector<double> slopes, errors;
};
inline Differences differences(const RandomCase& c, const std::string& key, double p,
                               const std::string& formulation) {
  const double h = 2.5e-5 * (p != 0 ? std::abs(p) : 1);
  std::vector<std::vector<double>> at;
  for (const double d : {-2.0, -1.0, -0.5, -0.25, 0.25, 0.5, 1.0, 2.0})
    at.push_back(values_at(c, key, p + d * h, formulation));
  Differences found;
  for (std::size_t q = 0; q < c.quantities.size(); ++q) {
    const auto slope = [&](std::size_t j, double d) { return (at[7 - j][q] - at[j][q]) / (2 * d * h); };
    const double coarse = (4 * slope(1, 1) - slope(0, 2)) / 3, fine = (4 * slope(2, 0.5) - slope(1, 1)) / 3,
                 finest = (4 * slope(3, 0.25) - slope(2, 0.5)) / 3;
    found.slopes.push_back(fine + (fine - coarse) / 15);
    found.errors.push_back(std::max(std::abs(fine - coarse), std::abs(finest - fine)));
  }
  return found;
}

inline RandomCase random_case(int i, Draw& r) {
  return i % 4 == 0   ? disc_in_box(r)
         : i % 4 == 1 ? stopped_pendulum(r)
         : i % 4 == 2 ? ring_and_journal(r)
                      : slider_crank(r);
}

struct Compared {
  int compared = 0, refused = 0, unresolved = 0;
  int beyond = 0;  ///< the true error exceeds the estimate
  int silent = 0;  ///< the true error exceeds 1e-4 of the scale, and the derivative is not marked
  double worst = 0;
  std::string summary() const {
    return fmt::format(
        "{} derivatives compared, greatest error {:.2g}, {} beyond their estimate, {} silent, {} "
        "refused, {} unresolved",
        compared, worst, beyond, silent, refused, unresolved);
  }
};

/// Compares the derivatives of `scenes` random cases with respect to one random key each;
/// `bound_of`: relative bound for a key. Without `errors` none are estimated, for which further runs are made.
template <class MakeCase, class BoundOf>
Compared compare_random(int scenes, unsigned seed, MakeCase make_case, const std::string& formulation,
                        BoundOf bound_of, bool errors = true) {
  Compared all;
  for (int i = 0; i < scenes; ++i) {
    Draw r(seed, i);
    const auto c = make_case(i, r);
    const auto s =
        sensitivities(parse_scene(c.text, "random"),
                      {.of = c.quantities, .to = c.keys, .formulation = formulation, .errors = errors});
    const auto key = static_cast<std::size_t>(r.between(0, static_cast<double>(c.keys.size()) * 0.999));
    const double p = s.key_values[key];
    const auto expected = differences(c, c.keys[key], p, formulation);
    for (std::size_t q = 0; q < c.quantities.size(); ++q) {
      const auto& found = s.quantities[q];
      const double measured = found.derivatives[key], truth = expected.slopes[q],
                   own = 2 * expected.errors[q];
      const double scale = std::abs(truth) + 1e-3 * std::abs(found.value / (p != 0 ? p : 1));
      if (std::isnan(measured)) {
        CHECK_FALSE(found.reasons[key].empty());
        ++all.refused;
        continue;
      }
      // Where the differences themselves do not settle, neighbouring runs have other events.
      if (!(own < 2e-5 * scale)) {
        ++all.unresolved;
        continue;
      }
      ++all.compared;
      const double miss = std::max(0.0, std::abs(measured - truth) - own), error = miss / scale;
      all.worst = std::max(all.worst, error);
      all.beyond += errors && !(miss <= found.errors[key]);
      all.silent += errors && miss > 1e-4 * derivative_scale(s, found, key) && !is_inexact(s, found, key);
      CAPTURE(i, c.quantities[q], c.keys[key], measured, truth, own);
      CHECK(error < bound_of(c.keys[key]));
    }
  }
  return all;
}

}  // namespace freeplay::test::varied
