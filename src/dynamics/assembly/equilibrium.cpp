#include "dynamics/assembly/equilibrium.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "dynamics/planar.hpp"
#include "mechanism/error.hpp"
#include "mechanism/mechanism.hpp"
#include "numerics/dense.hpp"

namespace freeplay {

using Eigen::MatrixXd, Eigen::VectorXd;

MatrixXd null_space(const MatrixXd& C, const VectorXd& weights) {
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  if (C.rows() == 0) return back.asDiagonal();
  const MatrixXd weighted = (C * back.asDiagonal()).transpose();
  return back.asDiagonal() * orthogonal_complement(weighted, 1e-10);
}

Curvatures curvatures(const MatrixXd& K, const MatrixXd& Z, const VectorXd& weights) {
  if (Z.cols() == 0) return {VectorXd(0), VectorXd(0), Z};
  const MatrixXd H = Z.transpose() * K * Z;
  const MatrixXd symmetric = 0.5 * (H + H.transpose());
  const auto apart = symmetric_eigen(symmetric);
  Curvatures c{apart.values, {}, Z * apart.vectors};
  const MatrixXd size = K.cwiseAbs();
  const VectorXd back = weights.cwiseSqrt().cwiseInverse();
  const double all = K.size() > 0 ? (back.asDiagonal() * size * back.asDiagonal()).maxCoeff() : 0;
  c.doubt.resize(c.value.size());
  for (int d = 0; d < c.value.size(); ++d) {
    const VectorXd x = c.direction.col(d).cwiseAbs();
    c.doubt[d] = 1e-11 * x.dot(size * x) + 1e-14 * all;
  }
  return c;
}

namespace {

/// Throws ModelError: no equilibrium, with the reason.
[[noreturn]] void no_equilibrium(const std::string& why) {
  throw ModelError("run.start", "no equilibrium: " + why);
}

/// A point on the manifold with its reactions and the remaining force.
struct RestPlace {
  AtRest at;
  VectorXd mu;
  VectorXd left;  ///< R in unit weights: the force that no reaction balances
};

/// Descent of the potential energy on the manifold Φ = 0 to a point without remaining force, for given
/// elastic and closed contacts.
class Descent {
 public:
  Descent(const Mechanism& mechanism, Statics& statics, const VectorXd& from, const StopToken& stop)
      : mechanism_(mechanism), s_(statics), stop_(stop), from_(from), weights_(VectorXd::Ones(from.size())) {
    reach_ = s_.length();
    for (int i = 0; i < from.size(); ++i) {
      if (s_.system().is_angle(i))
        weights_[i] = s_.length() * s_.length();
      else
        for (int j = i % planar::coordinates; j < i; j += planar::coordinates)
          reach_ = std::max(reach_, std::abs(from[i] - from[j]));
    }
    root_ = weights_.cwiseSqrt();
  }

  /// Descends until the remaining force is below `share` of the forces; `radius` (m) of the first
  /// step.
  RestPlace settle(VectorXd q, double radius, double share = 1e-12) {
    constexpr int most = 4000;
    if (auto closed = close(q)) q = *closed;
    RestPlace now = place(q);
    int polished = 0;
    for (int i = 0; i < most; ++i, ++steps) {
      if (stop_()) throw Interrupted();
      const auto l = s_.linearise(now.at, now.mu);
      const MatrixXd K = l.settled();
      const MatrixXd Z = null_space(now.at.C, weights_);
      if (Z.cols() == 0) return now;
      const auto h = curvatures(0.5 * (K + K.transpose()), Z, weights_);
      // The force along each direction, and its rounding: of the forces, and of positions under stiff
      // springs.
      const VectorXd push = h.direction.transpose() * now.left.cwiseProduct(root_);
      const VectorXd sizes = s_.sizes(now.at, now.mu);
      const VectorXd rounding = h.direction.cwiseAbs().transpose() *
                                (share * sizes + 1e-15 * (sizes.cwiseQuotient(root_).sum() * root_ +
                                                          K.cwiseAbs() * now.at.q.cwiseAbs()));
      VectorXd whole(push.size());  // the Newton step with absolute curvatures
      bool arrived = true;
      for (int d = 0; d < push.size(); ++d) {
        const bool pushed = std::abs(push[d]) > rounding[d];
        const bool curved = std::abs(h.value[d]) > h.doubt[d];
        whole[d] = !pushed ? 0 : curved ? push[d] / std::abs(h.value[d]) : std::copysign(INFINITY, push[d]);
        arrived &= !pushed;
      }
      if (arrived || whole.norm() < 1e-15 * reach_) {
        // Newton steps to rounding accuracy in directions with curvature, as long as the residual
        // decreases.
        if (share > 1e-9 || polished++ >= 3) return now;
        VectorXd step = VectorXd::Zero(q.size());
        for (int d = 0; d < push.size(); ++d)
          if (h.value[d] > h.doubt[d]) step += push[d] / h.value[d] * h.direction.col(d);
        const auto next = close(now.at.q + step);
        if (!next) return now;
        RestPlace better = place(*next);
        if (!(better.left.norm() < now.left.norm())) return now;
        now = std::move(better);
        continue;
      }
      polished = 0;
      // The shift that limits the step to the radius, by bisection of its logarithm.
      VectorXd s = whole;
      if (!(whole.norm() <= radius)) {
        double high = push.norm() / radius, low = 1e-18 * high;
        while (high > 1.001 * low) {
          const double shift = std::sqrt(low * high);
          double length = 0;
          for (int d = 0; d < push.size(); ++d)
            if (whole[d] != 0) length = std::hypot(length, push[d] / (std::abs(h.value[d]) + shift));
          (length > radius ? low : high) = shift;
        }
        for (int d = 0; d < push.size(); ++d)
          s[d] = whole[d] == 0 ? 0 : push[d] / (std::abs(h.value[d]) + high);
      }
      VectorXd step = h.direction * s;
      const double whole_way = allowed(step);
      step *= whole_way;
      s *= whole_way;
      const double length = s.norm();
      const double promised = push.dot(s) - 0.5 * s.cwiseAbs2().dot(h.value);
      const auto closed = close(now.at.q + step);
      bool accepted = false;
      if (closed && (*closed - now.at.q).cwiseProduct(root_).norm() < 2 * length + 1e-12 * reach_) {
        RestPlace next = place(*closed);
        const double fallen = -s_.climb(now.at, next.at);
        const double ratio = fallen / promised;
        // Near the minimum the decrease of energy is lost in rounding, so the remaining force
        // decides. A force that was within its rounding before need not decrease.
        const VectorXd still = h.direction.transpose() * next.left.cwiseProduct(root_);
        const auto excess = [&](const VectorXd& x) {
          return x.cwiseAbs().cwiseQuotient(rounding).maxCoeff();
        };
        const bool near = length < 1e-5 * s_.length() && excess(still) < std::max(1.0, 0.5 * excess(push));
        accepted = ratio > 1e-3 || near;
        if (ratio > 0.75 || near) radius = std::max(radius, 2 * length);
        if (!(ratio >= 0.25) && !near) radius = 0.3 * length;
        if (accepted) now = std::move(next);
      } else {
        radius = 0.25 * length;
      }
      if (accepted) refuse_endless(now.at.q);
      // No step helps: rounding, or a kink that cannot be passed.
      if (!(radius > 1e-16 * s_.length())) {
        if ((push.cwiseAbs() - 1e-8 * h.direction.cwiseAbs().transpose() * sizes).maxCoeff() <= 0) return now;
        refuse_stuck(now, l);
      }
    }
    refuse_stuck(now, s_.linearise(now.at, now.mu));
  }
  int steps = 0;

 private:
  RestPlace place(const VectorXd& q) {
    RestPlace p;
    s_.look(q, p.at);
    p.mu = VectorXd::Zero(p.at.C.rows());
    const VectorXd R = p.at.force.cwiseQuotient(root_);
    p.left = R;
    if (p.at.C.rows() > 0) {
      const MatrixXd B = (p.at.C * root_.cwiseInverse().asDiagonal()).transpose();
      p.mu = MinimumNorm(B, 1e-10).solve(R);
      p.left -= B * p.mu;
    }
    return p;
  }
  /// Projects q onto the manifold by steps of least length; empty if they do not converge to
  /// rounding.
  std::optional<VectorXd> close(VectorXd q) {
    AtRest at;
    double before = std::numeric_limits<double>::infinity();
    for (int pass = 0; pass < 12; ++pass) {
      s_.look(q, at);
      if (at.C.rows() == 0) return q;
      const double open = at.c.cwiseAbs().maxCoeff();
      if (!std::isfinite(open)) return std::nullopt;
      if (open <= 1e-15 * reach_ || (open <= 1e-12 * reach_ && open >= 0.5 * before)) return q;
      before = open;
      const MatrixXd B = at.C * root_.cwiseInverse().asDiagonal();
      const VectorXd step = MinimumNorm(B, 1e-10).solve(-at.c);
      q += step.cwiseQuotient(root_);
    }
    return before <= 1e-9 * s_.length() ? std::optional(q) : std::nullopt;
  }
  /// Factor that limits a step: no angle by more than a radian, no contact by more than it could
  /// pass through undetected.
  double allowed(const VectorXd& step) const {
    double turn = 0, pass = 0;
    for (int i = 0; i < step.size(); ++i)
      if (s_.system().is_angle(i)) turn = std::max(turn, std::abs(step[i]));
    for (int k = 0; k < s_.system().contacts(); ++k)
      pass = std::max(pass, 2 * s_.system().passage(k, step.data(), 1));
    return 1 / std::max({1.0, turn, pass});
  }
  void refuse_endless(const VectorXd& q) const {
    const VectorXd gone = q - from_;
    for (int i = 0; i < gone.size(); ++i) {
      const bool angle = s_.system().is_angle(i);
      if (std::abs(gone[i]) < (angle ? 1e3 : 1e5 * reach_)) continue;
      const auto& body = mechanism_.bodies[planar::body_of(i)].name;
      no_equilibrium(
          fmt::format("bodies.{} {} without limit ({} {}{:.3g} {} so far); no force or joint "
                      "restrains it",
                      body, angle ? "turns" : "moves", planar::name(i), gone[i] < 0 ? "" : "+", gone[i],
                      angle ? "rad" : "m"));
    }
  }
  [[noreturn]] void refuse_stuck(const RestPlace& p, const Linearised& l) const {
    const MatrixXd Z = null_space(p.at.C, weights_), H = Z.transpose() * l.settled() * Z;
    if ((H - H.transpose()).norm() > 1e-6 * H.norm())
      no_equilibrium("the forces have no potential (their work depends on the path)");
    const VectorXd gone = p.at.q - from_;
    for (int i = 0; i < gone.size(); ++i)
      if (s_.system().is_angle(i) && std::abs(gone[i]) > 100)
        no_equilibrium(fmt::format(
            "after {} steps bodies.{} still turns (theta {:+.3g} rad so far); a force drives its rotation",
            steps, mechanism_.bodies[planar::body_of(i)].name, gone[i]));
    Eigen::Index worst = 0;
    p.left.cwiseAbs().maxCoeff(&worst);
    no_equilibrium(fmt::format(
        "none found in {} steps: bodies.{} has an unbalanced load along {} of {:.3g} "
        "{}",
        steps, mechanism_.bodies[planar::body_of(worst)].name, planar::name(static_cast<int>(worst)),
        p.left[worst] * root_[worst], s_.system().is_angle(static_cast<int>(worst)) ? "N m" : "N"));
  }

  const Mechanism& mechanism_;
  Statics& s_;
  const StopToken& stop_;
  VectorXd from_, weights_, root_;
  double reach_ = 1;
};

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
  system.report().rows(system.pattern(), s.q.data(), e, at.multipliers.data(), 1, out);
  ContactRow row;
  for (int k = 0; k < system.contacts(); ++k) {
    if (!(at.normal[k] > 0)) continue;
    system.contact(k, s.q.data(), s.v.data(), e, row);
    system.report().contact(k, s.q.data(), e, row, at.normal[k], 0, 1, out);
  }
  system.report().loads(0, s.q.data(), s.v.data(), s.z.data(), e, 1, out);
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
