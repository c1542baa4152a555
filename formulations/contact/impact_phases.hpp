// ImpactPhases: compression and expansion of several contacts that D couples, with Coulomb friction
// along each phase. A parameter λ runs through a phase from 0 to 1. In compression, the approach
// speeds decrease in proportion, u_N ≥ (1 − λ) u_N⁻. In expansion, the impulses r P_C grow in
// proportion, λ r P_C. A phase consists of pieces. Within a piece no sliding contact stops and no
// contact without impulse begins to be pressed, so that all impulses and rates are linear in λ and
// follow from one contact problem. Each such change begins a new piece. Friction therefore always
// opposes the present sliding and never drives. The path is an assumption, as in any law for
// simultaneous impacts. For a single contact it equals the path along its normal impulse
// (impact_island.hpp).
//
// Poisson's law is compression, followed by expansion with each contact's restitution as its ratio.
// The energetic law iterates the ratios.
//
// Usage: compress(), then expand() with ratios, as often as needed, then add_works().
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "formulations/contact/impact_island.hpp"

namespace freeplay {

class ImpactPhases {
 public:
  bool compress(ImpactIsland& island, const std::vector<ImpactContact>& contacts);
  /// Expansion with the given ratios of impulses, after compress(); `contacts` get the impulses of
  /// both phases.
  bool expand(ImpactIsland& island, std::vector<ImpactContact>& contacts, const std::vector<double>& ratio);
  /// @name Impulses and works of each phase
  ///@{
  const std::vector<ImpactContact>& compression() const { return compression_; }
  const std::vector<ImpactContact>& expansion() const { return expansion_; }
  ///@}
  /// Adds the works of both phases to the island's.
  void add_works(ImpactIsland& island) const;

 private:
  enum class Phase { compression, expansion };
  /// Data of a phase that stay constant along it.
  struct Course {
    ImpactIsland& island;
    Phase phase;
    const std::vector<double>& ratio;  // of expansion
    double none;                       // m/s, rates below this are zero up to rounding
  };
  bool follow(const Course& course, Eigen::VectorXd& rates, std::vector<ImpactContact>& done);
  bool piece(const Course& course, double from, double to, const Eigen::VectorXd& rates);
  bool goes_on(const Course& course, double from, const Eigen::VectorXd& rates) const;
  double first_change(const Course& course, double from, const Eigen::VectorXd& rates, double early,
                      double late) const;
  std::optional<double> piece_until_change(const Course& course, double from, const Eigen::VectorXd& rates);
  static double ahead(const Course& course, const ImpactContact& c, double at, const Eigen::VectorXd& rates);

  Eigen::VectorXd after_compression_, after_, trial_, early_, late_;  // rates
  std::vector<ImpactContact> compression_, expansion_, piece_;
};

}  // namespace freeplay
