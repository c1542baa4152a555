// The horizon of a comparison as the growth of differences predicts it. The formulations differ in each
// impact: the contact of the penalty formulation lasts a time d and returns the speeds of the gap in a ratio
// e', so that against the impact law with restitution e
//
//     the impact is late by d e'/(1 + e'),   its impulse is greater by the share (e' − e)/(1 + e).
//
// The variational equations of the event-driven run take these differences to all contact onsets
// (analysis/growth.hpp). The predicted horizon is where the onsets, displaced by them, no longer
// correspond to those of the nonsmooth run by the rule of compare (compare.hpp). d and e' are those of
// the paired impacts; beyond them, the means of the contact.
#pragma once

#include <string>
#include <vector>

#include "study/comparison/compare.hpp"

namespace freeplay {

/// The nonsmooth run and the pairs found, as far as the prediction needs them.
struct PredictionBasis {
  const Pairing& pairing;
  std::vector<ContactEvent> nonsmooth;  ///< all events of the nonsmooth run
  std::vector<double> restitution;      ///< of each contact
  double end = 0;                       ///< s, of the run
  double turn = INFINITY;               ///< s, as for pair_impacts()
  long most_evaluations = 0;            ///< of the right-hand side
};

/// Throws Interrupted if a stop is requested.
PredictedHorizon predict_horizon(const Scene& scene, const PredictionBasis& basis, const StopToken& stop);

}  // namespace freeplay
