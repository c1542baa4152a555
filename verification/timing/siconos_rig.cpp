// The slider-crank with clearance in its gudgeon pin with Siconos as packaged in Debian, in the two
// coordinates that verification/references/loose_slider_crank.hpp derives by hand: Moreau–Jean with
// θ = ½, a relation of gap and sliding that depends on time, Newton's law with Coulomb friction.
// Not part of the build; scripts/benchmark time-to-accuracy compiles and runs it.
//
//     siconos_rig DURATION STEP CONTACTS
//         prints steps and CPU seconds, then the times of the first contact onsets (s), a line each:
//         the step's beginning and the time in which the gap vanishes with the approach speed there
#include <Friction_cst.h>
#include <SolverOptions.h>
#include <SiconosKernel.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "verification/references/loose_slider_crank.hpp"

using namespace freeplay::reference;

namespace {

const LooseSliderCrank<double> rig = [] {
  LooseSliderCrank<double> m;
  m.friction = 0.01;
  return m;
}();

double crank(double t) { return rig.start_angle + rig.speed * t; }

/// θ of the rod and x of the slider; the force of the accelerated crank pin is internal.
class Rig : public LagrangianDS {
 public:
  using LagrangianDS::LagrangianDS;
  void computeFInt(double t, SP::SiconosVector q, SP::SiconosVector) override {
    (*_fInt)(0) = -moment() * std::sin(crank(t) - (*q)(0));
    (*_fInt)(1) = 0;
  }
  void computeFInt(double t) override { computeFInt(t, _q[0], _q[1]); }
  void computeJacobianFIntq(double t, SP::SiconosVector q, SP::SiconosVector) override {
    _jacobianFIntq->zero();
    (*_jacobianFIntq)(0, 0) = moment() * std::cos(crank(t) - (*q)(0));
  }
  void computeJacobianFIntq(double t) override { computeJacobianFIntq(t, _q[0], _q[1]); }

 private:
  static double moment() { return rig.rod_mass * rig.rod_centre * rig.crank_length * rig.speed * rig.speed; }
};

/// Contact frame: n = e/|e|, t = n turned by +90°.
struct Frame {
  double gap, n_x, n_y, pin_x, pin_y, turn_x, turn_y;
  Frame(double t, double theta, double x) {
    const double phi = crank(t), r = rig.crank_length, l = rig.rod_length;
    const double e_x = x - r * std::cos(phi) - l * std::cos(theta),
                 e_y = -r * std::sin(phi) - l * std::sin(theta), e = std::hypot(e_x, e_y);
    gap = rig.clearance - e;
    n_x = e > 0 ? e_x / e : 1;
    n_y = e > 0 ? e_y / e : 0;
    pin_x = -r * rig.speed * std::sin(phi);
    pin_y = r * rig.speed * std::cos(phi);
    turn_x = -std::sin(theta);
    turn_y = std::cos(theta);
  }
};

class Gudgeon : public LagrangianRheonomousR {
 public:
  Gudgeon() {
    _jachq = std::make_shared<SimpleMatrix>(2, 2);
    _hDot = std::make_shared<SiconosVector>(2);
  }
  void computeh(double t, const BlockVector& q, BlockVector&, SiconosVector& y) override {
    y(0) = Frame(t, q(0), q(1)).gap;
    if (y.size() > 1) y(1) = 0;
  }
  void computehDot(double t, const BlockVector& q, BlockVector&) override {
    const Frame f(t, q(0), q(1));
    (*_hDot)(0) = f.n_x * f.pin_x + f.n_y * f.pin_y;
    (*_hDot)(1) = f.n_y * f.pin_x - f.n_x * f.pin_y;
  }
  void computeJachq(double t, const BlockVector& q, BlockVector&) override {
    const Frame f(t, q(0), q(1));
    const double l = rig.rod_length;
    (*_jachq)(0, 0) = l * (f.n_x * f.turn_x + f.n_y * f.turn_y);
    (*_jachq)(0, 1) = -f.n_x;
    (*_jachq)(1, 0) = -l * (-f.n_y * f.turn_x + f.n_x * f.turn_y) - rig.bearing_radius;
    (*_jachq)(1, 1) = -f.n_y;
  }
};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return std::fprintf(stderr, "siconos_rig DURATION STEP CONTACTS\n"), 2;
  const double duration = std::atof(argv[1]), h = std::atof(argv[2]);
  const auto wanted = static_cast<std::size_t>(std::atoi(argv[3]));
  const auto start = ideal_start(rig);
  auto q = std::make_shared<SiconosVector>(2), v = std::make_shared<SiconosVector>(2);
  (*q)(0) = start[0], (*q)(1) = start[2], (*v)(0) = start[1], (*v)(1) = start[3];
  auto M = std::make_shared<SimpleMatrix>(2, 2);
  M->zero();
  (*M)(0, 0) = rig.rod_inertia_about_pin(), (*M)(1, 1) = rig.slider_mass;
  auto bodies = std::make_shared<Rig>(q, v, M);
  bodies->allocateFInt();
  bodies->allocateJacobianFIntq();
  auto law = std::make_shared<NewtonImpactFrictionNSL>(0.46, 0., rig.friction, 2);
  auto pin = std::make_shared<Interaction>(law, std::make_shared<Gudgeon>());
  auto nsds = std::make_shared<NonSmoothDynamicalSystem>(0, duration * 2);
  nsds->insertDynamicalSystem(bodies);
  nsds->link(pin, bodies);
  auto problem = std::make_shared<FrictionContact>(2, SICONOS_FRICTION_2D_NSGS);
  problem->numericsSolverOptions()->dparam[SICONOS_DPARAM_TOL] = 1e-12;
  problem->numericsSolverOptions()->iparam[SICONOS_IPARAM_MAX_ITER] = 10000;
  problem->setNumericsVerboseMode(false);
  auto sim = std::make_shared<TimeStepping>(nsds, std::make_shared<TimeDiscretisation>(0, h),
                                            std::make_shared<MoreauJeanOSI>(0.5), problem);
  sim->setNewtonTolerance(1e-12);
  sim->setNewtonMaxIteration(20);
  const long steps = std::lround(duration / h);
  std::vector<double> onsets;
  bool pressed = false;
  const std::clock_t begin = std::clock();  // of the process, which has one thread
  for (long n = 0; n < steps; ++n) {
    const double t = h * static_cast<double>(n);
    const auto &q0 = *bodies->q(), &v0 = *bodies->velocity();
    const Frame f(t, q0(0), q0(1));
    const double rate = rig.rod_length * (f.n_x * f.turn_x + f.n_y * f.turn_y) * v0(0) - f.n_x * v0(1) +
                        f.n_x * f.pin_x + f.n_y * f.pin_y;
    sim->computeOneStep();
    const bool now = (*pin->lambda(1))(0) > 0;
    if (now && !pressed && onsets.size() < wanted) onsets.push_back(t + (rate < 0 ? -f.gap / rate : 0));
    pressed = now;
    sim->nextStep();
  }
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%ld %.6g\n", steps, seconds);
  for (const double t : onsets) std::printf("%.12g\n", t);
}
