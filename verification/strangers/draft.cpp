#include "verification/strangers/draft.hpp"

namespace freeplay::verification::strangers {

Sizes sizes(Draw& draw) { return {draw.decades(-3, 1), draw.decades(-2.5, 2.5), draw.decades(-3, 2)}; }

double mass_factor(Draw& draw) { return draw.chance(0.15) ? draw.decades(-3, 3) : draw.decades(-0.5, 0.5); }

void Draft::surface(Draw& draw, double m, double v, double R, double depth, bool smooth) {
  const double poisson = 0.3, K = 1.25 * m * v * v / std::pow(depth, 2.5);
  const double young = 2 * (1 - poisson * poisson) * 0.75 * K / std::sqrt(R);
  const double dice = draw();
  const double e = dice < 0.1 ? 0 : dice < 0.3 ? 1 : draw.between(0.05, 0.98);
  const double rough = draw();
  text += fmt::format("[surfaces.s]\nyoung = {}\npoisson = {}\nrestitution = {}\n", number(young),
                      number(poisson), number(e));
  // Elastic ones are without friction more often: those can be turned back in time.
  const bool friction = !smooth && rough > (e == 1 ? 0.7 : 0.35);
  if (friction)
    text += fmt::format("friction = {}\n",
                        number(draw.chance(0.5) ? draw.between(0, 0.3) : draw.between(0.3, 1.5)));
  if (friction && draw.chance(0.1)) text += fmt::format("tangential_restitution = {}\n", number(draw()));
  elastic_ = e == 1 && !friction;
}

void Draft::run(Draw& draw) {
  // At most 20,000 steps; a share of the flight between a 50th and a 500th, and of a spring's swing.
  if (fastest > 0) duration = std::min(duration, 20000 * 0.02 / fastest);
  double step = flight * draw.decades(-2.7, -1.7);
  if (fastest > 0) step = std::min(step, 0.02 / fastest);
  step = std::max(step, duration / 20000);
  text +=
      fmt::format("[run]\nduration = {}\nstart = \"{}\"\n", number(duration), given ? "given" : "assembled");
  text += fmt::format("[nonsmooth]\nstep = {}\n", number(step));
  // Regularising speeds and the floor of v₀ are shares of the scene's own speed, which its units cannot change.
  text += fmt::format("[penalty]\nfriction_v0 = {}\nfriction_v1 = {}\nv0_floor = {}\n", number(1e-3 * speed),
                      number(1e-2 * speed), number(1e-3 * speed));
  text += fmt::format("alpha = {0}\nbeta = {0}\n", number(1 / duration));
}

}  // namespace freeplay::verification::strangers
