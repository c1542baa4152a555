#include "dynamics/assembly/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "dynamics/assembly/descent.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
namespace {

using Eigen::MatrixXd, Eigen::VectorXd;

/// Elastic laws by which all forces together would compress each contact by `depth` of its
/// clearance.
Compliances soft(const System& system, const VectorXd& sizes, double depth) {
  double all = 0;
  for (int i = 0; i < sizes.size(); ++i)
    if (!system.is_angle(i)) all += sizes[i];
  Compliances list(system.contacts());
  for (int k = 0; k < system.contacts(); ++k) {
    // Walls and discs have a thousandth of their size in place of a clearance.
    const auto& facts = system.contact_facts(k);
    const double give =
        std::min(depth, 0.3) * facts.clearance * (facts.has_clearance ? 1 : std::max(1.0, depth));
    const double stiffness = (all > 0 ? all : 1) / give;
    list[k] = {[stiffness](double d) { return stiffness * d; }, [stiffness](double) { return stiffness; },
               [stiffness](double d) { return 0.5 * stiffness * d * d; }};
  }
  return list;
}

/// The active-set method. On return `s` has the closed contacts.
RestPlace settle_rigid(const Mechanism& mechanism, Statics& s, const VectorXd& q, const StopToken& stop,
                       int& steps) {
  const auto& system = s.system();
  Descent descent(mechanism, s, q, stop);
  AtRest at;
  s.look(q, at);
  const VectorXd sizes = s.sizes(at, VectorXd::Zero(at.C.rows()));
  VectorXd from = q;
  if (system.contacts() > 0)
    for (const double depth : {100.0, 10.0, 1.0, 0.1, 0.01}) {
      s.yield_by(soft(system, sizes, depth));
      from = descent.settle(from, 0.1 * s.length(), 1e-6).at.q;
    }
  s.yield_by(soft(system, sizes, 1e-3));
  RestPlace now = descent.settle(from, 0.1 * s.length());
  const auto close = [&](int k) { s.closed.insert(std::ranges::lower_bound(s.closed, k), k); };
  for (int k = 0; k < system.contacts(); ++k)
    if (now.at.elastic[k] > 0) close(k);
  for (int round = 0; round < 10 + 10 * system.contacts(); ++round) {
    if (s.closed.empty()) break;
    now = descent.settle(now.at.q, 0.01 * s.length());
    // Opens the contact with the greatest tension; closes every overlapping contact.
    int pulls = -1;
    double most = 1e-11 * s.sizes(now.at, now.mu).maxCoeff();
    for (std::size_t i = 0; i < s.closed.size(); ++i)
      if (now.mu[system.rows() + static_cast<int>(i)] > most) {
        pulls = static_cast<int>(i);
        most = now.mu[system.rows() + pulls];
      }
    bool changed = pulls >= 0;
    if (pulls >= 0) s.closed.erase(s.closed.begin() + pulls);
    for (int k = 0; k < system.contacts(); ++k)
      if (now.at.elastic[k] > 0 && now.at.gap[k] < -1e-9 * system.contact_facts(k).clearance) {
        close(k);
        changed = true;
      }
    if (!changed) {
      steps = descent.steps;
      return now;
    }
    if (s.closed.empty()) now = descent.settle(now.at.q, 0.01 * s.length());
  }
  steps = descent.steps;
  if (s.closed.empty()) return now;
  no_equilibrium(
      "the set of closed contacts does not converge; contacts may open and close each other in "
      "turn");
}

}  // namespace

Equilibrium find_equilibrium(const Mechanism& mechanism, const System& system, const std::vector<double>& q,
                             const Compliances& elastic, const StopToken& stop) {
  const VectorXd start = Eigen::Map<const VectorXd>(q.data(), static_cast<Eigen::Index>(q.size()));
  Equilibrium found;
  // Rigid contacts first; elastic contacts continue from there, so that both find the same
  // equilibrium.
  Statics guarded(system);
  RestPlace place = settle_rigid(mechanism, guarded, start, stop, found.steps);
  Statics yielding(system, elastic);
  Statics* s = &guarded;
  if (!elastic.empty() && system.contacts() > 0) {
    Descent descent(mechanism, yielding, place.at.q, stop);
    double least = guarded.length();
    for (int k = 0; k < system.contacts(); ++k) least = std::min(least, system.contact_facts(k).clearance);
    place = descent.settle(place.at.q, 1e-3 * least);
    found.steps += descent.steps;
    s = &yielding;
  }
  found.state.q.assign(place.at.q.data(), place.at.q.data() + place.at.q.size());
  found.state.v.assign(q.size(), 0);
  found.state.z = place.at.z;
  for (int k = 0; k < system.rows(); ++k)
    found.multipliers.push_back(place.mu[k] * (system.is_angle_row(k) ? s->length() : 1));
  found.normal = place.at.elastic;
  for (std::size_t i = 0; i < s->closed.size(); ++i)
    found.normal[s->closed[i]] = -place.mu[system.rows() + static_cast<int>(i)];
  for (int k = 0; k < system.contacts(); ++k)
    if (found.normal[k] > 0) found.pressed.push_back(k);

  VectorXd weights = VectorXd::Ones(start.size());
  for (int i = 0; i < start.size(); ++i)
    if (system.is_angle(i)) weights[i] = s->length() * s->length();
  const MatrixXd K = s->linearise(place.at, place.mu).settled(), Z = null_space(place.at.C, weights);
  const MatrixXd H = Z.transpose() * K * Z;
  const auto h = curvatures(0.5 * (K + K.transpose()), Z, weights);
  if (H.size() > 0 && (H - H.transpose()).cwiseAbs().maxCoeff() >
                          std::max(1e-6 * h.value.cwiseAbs().maxCoeff(), h.doubt.cwiseAbs().maxCoeff()))
    no_equilibrium(
        "the forces have no potential there (their work depends on the path), so descent cannot find the "
        "equilibrium");
  found.freedoms = static_cast<int>(Z.cols());
  for (int d = 0; d < h.value.size(); ++d) {
    found.runaway += h.value[d] < -h.doubt[d];
    found.indifferent += std::abs(h.value[d]) <= h.doubt[d];
  }
  found.kind = found.runaway > 0       ? Equilibrium::Kind::unstable
               : found.indifferent > 0 ? Equilibrium::Kind::marginal
                                       : Equilibrium::Kind::stable;
  return found;
}

Forces static_forces(const System& system, const Equilibrium& at) {
  auto e = system.make_evaluation();
  const auto& s = at.state;
  system.place(0, s.q.data(), e);
  Forces out = system.make_forces();
  system.report_rows(s.q.data(), e, at.multipliers.data(), 1, out);
  ContactRow row;
  for (int k = 0; k < system.contacts(); ++k) {
    if (!(at.normal[k] > 0)) continue;
    system.contact(k, s.q.data(), s.v.data(), e, row);
    system.report_contact(k, s.q.data(), e, row, at.normal[k], 0, 1, out);
  }
  system.report_loads(0, s.q.data(), s.v.data(), s.z.data(), e, 1, out);
  return out;
}

std::string describe(const Equilibrium& at) {
  const auto motions = [&](int n) {
    return fmt::format("{} of {} motion{}", n, at.freedoms, at.freedoms == 1 ? "" : "s");
  };
  switch (at.kind) {
    case Equilibrium::Kind::stable:
      return at.freedoms == 0 ? "stable: no degrees of freedom" : "stable";
    case Equilibrium::Kind::marginal:
      return fmt::format("marginal: {} without stiffness", motions(at.indifferent));
    default:
      return fmt::format("unstable: {} without restoring force", motions(at.runaway));
  }
}

}  // namespace freeplay
