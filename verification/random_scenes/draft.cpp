#include "verification/random_scenes/draft.hpp"

#include <algorithm>

namespace freeplay::verification::random_scenes {
namespace {

constexpr double poisson = 0.3;

/// Young's modulus of both bodies of a Hertzian contact of stiffness K and radius R: K = (4/3)
/// E/(2(1 − ν²)) √R.
double young_of(double K, double R) { return 2 * (1 - poisson * poisson) * 0.75 * K / std::sqrt(R); }
/// Hertz's impact: a mass m at speed v penetrates to `depth` where 5/4 m v² = K depth^(5/2).
double stiffness_for(double m, double v, double depth) { return 1.25 * m * v * v / std::pow(depth, 2.5); }

}  // namespace

Sizes sizes(Draw& draw) { return {draw.decades(-3, 1), draw.decades(-2.5, 2.5), draw.decades(-3, 2)}; }

double mass_factor(Draw& draw) { return draw.chance(0.15) ? draw.decades(-3, 3) : draw.decades(-0.5, 0.5); }

std::size_t Draft::body(const DraftBody& b) {
  table("bodies." + b.name, fmt::format("mass = {}\ninertia = {}\nposition = {}\nangle = {}\n",
                                        number(b.mass), number(b.inertia), point(b.at), number(b.angle)));
  if (given || approximate)
    text += fmt::format("velocity = {}\nangular_velocity = {}\n", point(b.velocity), number(b.spin));
  return 3 * static_cast<std::size_t>(bodies_++);
}

void Draft::surface(Draw& draw, double m, double v, double R, double depth, bool smooth) {
  const double young = young_of(stiffness_for(m, v, depth), R);
  const double dice = draw();
  const double e = dice < 0.1 ? 0 : dice < 0.3 ? 1 : draw.between(0.05, 0.98);
  const double rough = draw();
  table("surfaces.s", fmt::format("young = {}\npoisson = {}\nrestitution = {}\n", number(young),
                                  number(poisson), number(e)));
  // Elastic scenes are without friction more often: those can be run backwards in time.
  const bool friction = !smooth && rough > (e == 1 ? 0.7 : 0.35);
  if (friction)
    text += fmt::format("friction = {}\n",
                        number(draw.chance(0.5) ? draw.between(0, 0.3) : draw.between(0.3, 1.5)));
  if (friction && draw.chance(0.1)) text += fmt::format("tangential_restitution = {}\n", number(draw()));
}

double Draft::surface(double e, double m, double v, double R, double time) {
  // Hertz: an impact lasts 2.943 d/v
  const double d = v * time / 2.943, K = stiffness_for(m, v, d);
  const double young = exact(K * 1.5 * (1 - poisson * poisson) / std::sqrt(R));
  table("surfaces.s", fmt::format("young = {}\npoisson = 0.3\nrestitution = {}\n", number(young), number(e)));
  contact = std::min(contact, time);
  return young * std::sqrt(R) / (1.5 * (1 - poisson * poisson));
}

void Draft::surface(double e) {
  table("surfaces.s", fmt::format("young = 2e11\npoisson = 0.3\nrestitution = {}\n", number(e)));
}

std::shared_ptr<DrivenMotion> Draft::driven(const std::string& joint, const DrawnCurve& curve, bool rate,
                                            double initial, double until) {
  const auto name = fmt::format("y{}", curves_++);
  table("curves." + name, curve.lines);
  drive(joint, fmt::format("{} = \"{}\"\n{}", rate ? "velocity" : "position", name,
                           rate ? fmt::format("initial = {}\n", number(initial)) : ""));
  return std::make_shared<DrivenMotion>(curve, rate, exact(initial), until);
}

void Draft::steady(std::size_t coordinate, double at, double rate, double size) {
  scene.prescribed.push_back({coordinate,
                              [=](double t, Coordinates, Coordinates) {
                                return CurvePoint{at + rate * t, rate, 0};
                              },
                              size, std::abs(rate), 0});
}

void Draft::prescribed(std::size_t coordinate, std::shared_ptr<DrivenMotion> motion) {
  const double size = motion->size, rate = motion->rate, bend = motion->bend;
  scene.prescribed.push_back(
      {coordinate, [motion = std::move(motion)](double t, Coordinates, Coordinates) { return motion->at(t); },
       size, rate, bend});
}

void Draft::run(Draw& draw) {
  // At most 20,000 steps; between a 50th and a 500th of the flight, and of the period of a spring.
  if (fastest > 0) duration = std::min(duration, 20000 * 0.02 / fastest);
  double step = flight * draw.decades(-2.7, -1.7);
  if (fastest > 0) step = std::min(step, 0.02 / fastest);
  step = std::max(step, duration / 20000);
  table("run",
        fmt::format("duration = {}\nstart = \"{}\"\n", number(duration), given ? "given" : "assembled"));
  table("nonsmooth", fmt::format("step = {}\n", number(step)));
  // Regularising speeds and the floor of v₀ are fractions of the scene's speed, which its units
  // cannot change.
  table("penalty",
        fmt::format("friction_v0 = {0}\nfriction_v1 = {1}\nv0_floor = {0}\nalpha = {2}\nbeta = {2}\n",
                    number(1e-3 * speed), number(1e-2 * speed), number(1 / duration)));
  scene.text = text;
}

void Draft::finish(double until) {
  scene.shortest = std::min(flight, until);
  until = std::min(until, 100 * scene.shortest);
  if (std::isfinite(contact)) until = std::min(until, longest * contact);
  scene.duration = exact(until);
  scene.step = exact(std::max(scene.shortest / 200, until / 20000));
  scene.contact_step =
      exact(std::min(std::isfinite(contact) ? contact / 40 : INFINITY, scene.shortest / 200));
  table("run", fmt::format("duration = {}\nstart = \"{}\"\noutput_step = {}\n", number(until),
                           given ? "given" : "assembled", number(scene.duration / rows)));
  if (!given) table("assembly", "approximate = true\n");
  scene.text = text;
}

double stop_stiffness(Draft& out, double inertia, double arm_squared, double time) {
  const double ks = exact(inertia / arm_squared * std::pow(std::numbers::pi / time, 2));
  out.contact = std::numbers::pi * std::sqrt(inertia / (arm_squared * ks));
  return ks;
}

void moving(Draft& out, std::size_t coordinate, reference::OneCoordinate one, double stiffness,
            double exponent, double arm) {
  one.rest = 1e-7 * out.scene.speed / arm;
  Moving m{coordinate, one, one};
  for (auto& w : m.compliant.walls) w.stiffness = stiffness, w.exponent = exponent;
  m.compliant.rest = exact(1e-3 * out.scene.speed) / arm;
  out.scene.moving.push_back(std::move(m));
}

void finish_moving(Draft& out, double duration) {
  out.finish(duration);
  for (auto& m : out.scene.moving) {
    m.rigid.step = m.compliant.step = out.scene.shortest / 400;
    m.compliant.step_in_contact =
        std::min(std::isfinite(out.contact) ? out.contact / 200 : INFINITY, m.rigid.step);
    m.rigid.step_in_contact = m.rigid.step;
  }
}

}  // namespace freeplay::verification::random_scenes
