// A ball that bounces on a table with Siconos as packaged in Debian: Moreau–Jean with θ = ½, a
// linear relation for the gap and Newton's law. Not part of the build; scripts/benchmark
// side-by-side compiles and runs it.
//
//     siconos_ball DURATION STEP RESTITUTION DROP
//         prints steps, CPU µs per step and the height at the end (m)
#include <SiconosKernel.hpp>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>

int main(int argc, char** argv) {
  if (argc < 5) return std::fprintf(stderr, "siconos_ball DURATION STEP RESTITUTION DROP\n"), 2;
  const double duration = std::atof(argv[1]), h = std::atof(argv[2]), e = std::atof(argv[3]),
               drop = std::atof(argv[4]), mass = 0.3, inertia = 3e-4, g = 9.81;
  auto q = std::make_shared<SiconosVector>(3), v = std::make_shared<SiconosVector>(3),
       weight = std::make_shared<SiconosVector>(3);
  q->zero(), v->zero(), weight->zero();
  (*q)(0) = drop;  // above contact
  (*weight)(0) = -mass * g;
  auto M = std::make_shared<SimpleMatrix>(3, 3);
  M->eye();
  (*M)(0, 0) = (*M)(1, 1) = mass;
  (*M)(2, 2) = inertia;
  auto ball = std::make_shared<LagrangianLinearTIDS>(q, v, M);
  ball->setFExtPtr(weight);
  auto H = std::make_shared<SimpleMatrix>(1, 3);
  H->zero();
  (*H)(0, 0) = 1;
  auto table = std::make_shared<Interaction>(std::make_shared<NewtonImpactNSL>(e),
                                             std::make_shared<LagrangianLinearTIR>(H));
  auto nsds = std::make_shared<NonSmoothDynamicalSystem>(0, duration * 2);
  nsds->insertDynamicalSystem(ball);
  nsds->link(table, ball);
  auto sim = std::make_shared<TimeStepping>(nsds, std::make_shared<TimeDiscretisation>(0, h),
                                            std::make_shared<MoreauJeanOSI>(0.5), std::make_shared<LCP>());
  sim->setNewtonOptions(SICONOS_TS_LINEAR);
  const long steps = std::lround(duration / h);
  const std::clock_t begin = std::clock();  // of the process, which has one thread
  for (long n = 0; n < steps; ++n) {
    sim->computeOneStep();
    sim->nextStep();
  }
  const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::printf("%ld %.4f %.12g\n", steps, 1e6 * seconds / static_cast<double>(steps), (*ball->q())(0));
}
