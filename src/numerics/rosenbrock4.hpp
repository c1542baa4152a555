// One step of Shampine's implicit method of order 4 with an error estimate of order 3, A-stable
// (Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.7). The coefficients
// are those of odeint's rosenbrock4, with one sign corrected. A step does not allocate; odeint's
// does, because its matrices are in uBLAS.
#pragma once

#include <memory>

namespace freeplay {

class Rosenbrock4 {
 public:
  /// The problem dx/dt = f(x, t) as plain functions with their context.
  struct Problem {
    void* context;
    void (*side)(void* context, const double* x, double* dxdt, double t);
    /// J = ∂f/∂x, column-major, and ∂f/∂t.
    void (*jacobian)(void* context, const double* x, double t, double* J, double* dfdt);
  };
  explicit Rosenbrock4(int size);
  ~Rosenbrock4();
  Rosenbrock4(const Rosenbrock4& other);  ///< of the same size; no state passes from step to step
  Rosenbrock4& operator=(const Rosenbrock4& other);
  Rosenbrock4(Rosenbrock4&&) noexcept;
  Rosenbrock4& operator=(Rosenbrock4&&) noexcept;

  /// One step of length h from (x, t). The cost of the dense solves grows with the cube of the
  /// number of unknowns on which right-hand sides depend, without integrals of others (dx_i/dt = x_j).
  void step(const Problem& problem, const double* x, double t, double h, double* x_new, double* error);
  /// Whether J has an odd number of real eigenvalues above 4/h, where h is the length of the last step. The
  /// method damps such a mode, although the motion leaves its equilibrium within a part of the step, and the
  /// estimate of the error does not detect that. With 4/h the step has a pole, and below 4/h its modes grow.
  bool damps_growth() const;

 private:
  struct Storage;
  std::unique_ptr<Storage> storage_;
};

}  // namespace freeplay
