// Compression and expansion of several contacts that D couples, with Coulomb's friction along each. λ runs through a phase
// from 0 to 1: in compression what approaches is slowed down together, u_N ≥ (1 − λ) u_N⁻, in expansion the impulses
// r P_C grow together, λ r P_C. Within a piece of it in which nothing that slides stops, and nothing that bore no impulse begins to, all
// impulses and rates are linear in λ and one contact problem has them; where that happens a new piece begins. So friction always opposes the sliding of
// its instant, and never drives. The path is an assumption, as of any law for impacts at once; a single contact has the one that
// its normal impulse goes (routh.hpp), and this is the same.
//
// Poisson's law is compression, then expansion with each contact's restitution as its ratio; the energetic one looks for other
// ratios.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "formulations/contact/impact_island.hpp"

namespace freeplay {

class ImpactPhases {
 public:
  bool compress(ImpactIsland& island, const std::vector<ImpactContact>& contacts);
  /// Expansion with the given ratios of impulses, after compress(); the contacts get the impulses of both.
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
  /// What a phase is followed with.
  struct Course {
    ImpactIsland& island;
    Phase phase;
    const std::vector<double>& ratio;  // of expansion
    double none;                       // m/s, what rounding leaves of a rate that has stopped
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
