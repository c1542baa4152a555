// Fourier coefficients of one turn of a signal from its own samples. With φ_j the crank angle at
// sample j, the coefficients of
//
//     a(φ) = Σ_{k=−K}^{K} c_k e^{ikφ},   c_{−k} = c̄_k,   minimise   Σ_j |a_j − a(φ_j)|².
//
// The samples are not interpolated. A periodic signal without harmonics above K is recovered to
// rounding, for any position and number of samples. The normal equations are Hermitian and
// Toeplitz,
//
//     Σ_l g_{k−l} c_l = b_k,   g_m = Σ_j e^{−imφ_j},   b_k = Σ_j a_j e^{−ikφ_j},
//
// and close to a multiple of the identity. They are solved by conjugate gradients with FFT products
// (Feichtinger, Gröchenig and Strohmer, Efficient numerical methods in non-uniform sampling theory,
// 1995). Sums over uniform samples use Bluestein's chirp transform; sums over nonuniform samples
// use an FFT with the exponential-of-semicircle kernel (Barnett, Magland and af Klinteberg, SIAM J.
// Sci. Comput. 41 (2019) C479). Both take O(N log N) operations.
//
// A TurnTransform owns the FFT plans and chirps, so one object should transform many turns. It is
// not safe for concurrent use.
#pragma once

#include <complex>
#include <map>
#include <span>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace freeplay {

using Harmonics = std::vector<std::complex<double>>;  ///< c_0, c_1, …, c_K

/// Computes the harmonics 0 … K of turns.
class TurnTransform {
 public:
  /// `highest`: K. The samples of a turn must determine the harmonics: at least 2K + 1 samples,
  /// with no distance above π/K.
  explicit TurnTransform(int highest) : highest_(highest) {}
  /// Harmonics of samples at arbitrary angles (rad).
  Harmonics uneven(std::span<const double> angles, std::span<const double> values);
  /// Harmonics of samples at start + j·step (rad).
  Harmonics even(double start, double step, std::span<const double> values);

 private:
  using List = std::vector<std::complex<double>>;
  Harmonics solve(const List& b, const List& product) const;
  /// Σ_j values_j e^{−ikj·step}, k = 0 … most.
  List chirp(double step, std::span<const double> values, int most);
  /// Σ_j values_j e^{−ik angles_j}, k = 0 … most, to 1e-13 of Σ|values_j|.
  List sums(std::span<const double> angles, std::span<const double> values, int most);
  /// Phases and transform of the chirp, for n samples and m sums.
  struct Chirp {
    std::size_t n = 0, m = 0, size = 0;
    List phase, transform;
  };
  const Chirp& chirp_of(double step, std::size_t n, std::size_t m);
  /// Transform of g for the product with the Toeplitz matrix.
  List product_of(const List& g);
  void forward(List& out, const List& in) const { fft_.fwd(out, in); }

  int highest_;
  double step_ = 0;
  std::map<std::size_t, List> products_;  // for uniform samples, by their number
  std::vector<Chirp> chirps_;             // for the present step
  mutable Eigen::FFT<double> fft_;        // keeps its plans
};

/// Means of the signal over `bins` equal parts of the turn, beginning at angle 0.
std::vector<double> bin_means(const Harmonics& c, int bins);

}  // namespace freeplay
