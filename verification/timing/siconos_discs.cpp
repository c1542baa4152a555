// Discs in a box with Siconos as packaged in Debian: Moreau–Jean with θ = ½, its own broad phase
// (SpaceFilter) and Gauss–Seidel over blocks for friction in the plane. Not part of the build;
// scripts/benchmark time-discs compiles and runs it.
//
//     siconos_discs COLUMNS ROWS STEPS TOLERANCE EVERY
//         discs of radius 1 m; a line of CSV every EVERY steps
#include <Friction_cst.h>
#include <SolverOptions.h>
#include <Disk.hpp>
#include <MechanicsFwd.hpp>
#include <SiconosKernel.hpp>
#include <SpaceFilter.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

int main(int argc, char** argv) {
  if (argc < 6) return std::fprintf(stderr, "siconos_discs COLUMNS ROWS STEPS TOLERANCE EVERY\n"), 2;
  const int columns = std::atoi(argv[1]), rows = std::atoi(argv[2]), steps = std::atoi(argv[3]),
            every = std::atoi(argv[5]);
  const double tolerance = std::atof(argv[4]), r = 1, mass = 1, g = 9.81, h = 1e-3, friction = 0.3, e = 0.2;
  const double across = 2.1, up = 2.02, stagger = 0.05,
               width = across * (columns - 1) + 2 * r + 0.1 + stagger;

  auto nsds = std::make_shared<NonSmoothDynamicalSystem>(0, steps * h * 2);
  auto osi = std::make_shared<MoreauJeanOSI>(0.5);
  std::vector<SP::Disk> discs;
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      auto q = std::make_shared<SiconosVector>(3), v = std::make_shared<SiconosVector>(3),
           f = std::make_shared<SiconosVector>(3);
      q->zero(), v->zero(), f->zero();
      (*q)(0) = r + 0.05 + across * column + (row % 2 == 1 ? stagger : 0);
      (*q)(1) = r + 0.01 + up * row;
      (*f)(1) = -mass * g;
      auto d = std::make_shared<Disk>(r, mass, q, v);
      d->setFExtPtr(f);
      nsds->insertDynamicalSystem(d);
      discs.push_back(d);
    }
  // A x + B y + C = 0; without a width: unbounded
  auto planes = std::make_shared<SimpleMatrix>(3, 6);
  planes->zero();
  (*planes)(0, 1) = 1;
  (*planes)(1, 0) = 1;
  (*planes)(2, 0) = -1;
  (*planes)(2, 2) = width;
  auto space = std::make_shared<SpaceFilter>(3, 6, planes);
  space->insertNonSmoothLaw(std::make_shared<NewtonImpactFrictionNSL>(e, 0., friction, 2), 0, 0);
  auto problem = std::make_shared<FrictionContact>(2, SICONOS_FRICTION_2D_NSGS);
  problem->numericsSolverOptions()->dparam[SICONOS_DPARAM_TOL] = tolerance;
  problem->numericsSolverOptions()->iparam[SICONOS_IPARAM_MAX_ITER] = 20000;
  problem->setMStorageType(NM_SPARSE_BLOCK);
  problem->setNumericsVerboseMode(false);
  problem->setKeepLambdaAndYState(true);
  auto sim = std::make_shared<TimeStepping>(nsds, std::make_shared<TimeDiscretisation>(0, h), osi, problem);
  sim->insertInteractionManager(space);
  sim->setNewtonOptions(SICONOS_TS_LINEAR);
  sim->setNewtonMaxIteration(1);

  const auto report = [&](int n, double seconds, double worst, long iterations) {
    double kinetic = 0, deep = 0;
    for (const auto& d : discs) {
      const auto &q = *d->q(), &v = *d->velocity();
      kinetic += 0.5 * mass * (v(0) * v(0) + v(1) * v(1)) + 0.25 * mass * r * r * v(2) * v(2);
      deep = std::max({deep, r - q(1), r - q(0), q(0) + r - width});
      for (const auto& o : discs)
        if (o != d) deep = std::max(deep, 2 * r - std::hypot((*o->q())(0) - q(0), (*o->q())(1) - q(1)));
    }
    std::printf("siconos,%d,%.1f,%.3e,%.8g,%.2e,%ld\n", n, seconds / n * 1e6, deep, kinetic, worst,
                iterations / n);
    std::fflush(stdout);
  };
  double spent = 0, worst = 0;
  long iterations = 0;
  for (int n = 1; n <= steps; ++n) {
    const std::clock_t begin = std::clock();  // of the process, which has one thread
    sim->computeOneStep();
    sim->nextStep();
    spent += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (const double left = problem->numericsSolverOptions()->dparam[SICONOS_DPARAM_RESIDU];
        std::isfinite(left))
      worst = std::max(worst, left);
    iterations += problem->numericsSolverOptions()->iparam[SICONOS_IPARAM_ITER_DONE];
    if (n % every == 0) report(n, spent, worst, iterations);
  }
}
