// The harmonics of one turn from its own samples. With φ_j the crank's angle at a sample, the coefficients of
//
//     a(φ) = Σ_{k=−K}^{K} c_k e^{ikφ},   c_{−k} = c̄_k,   minimise   Σ_j |a_j − a(φ_j)|²,
//
// so a periodic signal without harmonics beyond K is found to rounding, wherever its samples lie and however many
// make a turn: nothing is interpolated. The normal equations are Hermitian and Toeplitz,
//
//     Σ_l g_{k−l} c_l = b_k,   g_m = Σ_j e^{−imφ_j},   b_k = Σ_j a_j e^{−ikφ_j},
//
// near to the identity, and solved by conjugate gradients with products by fast transforms (Feichtinger, Gröchenig
// and Strohmer, Efficient numerical methods in non-uniform sampling theory, 1995). Sums over even samples are
// Bluestein's chirp transform, over others a fast transform of what they leave on an even grid (Barnett, Magland and af Klinteberg,
// SIAM J. Sci. Comput. 41 (2019) C479): N log N either way.
#pragma once

#include <complex>
#include <map>
#include <span>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace freeplay {

using Harmonics = std::vector<std::complex<double>>;  ///< c_0, c_1, …, c_K

class TurnTransform {
 public:
  /// `highest`: K. The samples must determine it: 2K + 1 of them or more, nowhere farther apart than π/K.
  explicit TurnTransform(int highest) : highest_(highest) {}
  /// Of samples at any angles (rad).
  Harmonics uneven(std::span<const double> angles, std::span<const double> values);
  /// Of samples at start + j · step (rad).
  Harmonics even(double start, double step, std::span<const double> values);

 private:
  using List = std::vector<std::complex<double>>;
  Harmonics solve(const List& b, const List& product) const;
  /// Σ_j values_j e^{−ikj·step}, k = 0 … most.
  List chirp(double step, std::span<const double> values, int most);
  /// Σ_j values_j e^{−ik angles_j}, k = 0 … most, to 1e-13 of Σ|values_j|.
  List sums(std::span<const double> angles, std::span<const double> values, int most);
  /// Phases and the transform of the chirp, for n samples and m sums.
  struct Chirp {
    std::size_t n = 0, m = 0, size = 0;
    List phase, transform;
  };
  const Chirp& chirp_of(double step, std::size_t n, std::size_t m);
  /// The transform of g, by which it is multiplied.
  List product_of(const List& g);
  void forward(List& out, const List& in) const { fft_.fwd(out, in); }

  int highest_;
  double step_ = 0;
  std::map<std::size_t, List> products_;  // of even samples, by their number
  std::vector<Chirp> chirps_;             // of this step
  mutable Eigen::FFT<double> fft_;        // its plans are kept
};

/// Means of the signal over `bins` equal parts of the turn from angle 0 on.
std::vector<double> bin_means(const Harmonics& c, int bins);

}  // namespace freeplay
