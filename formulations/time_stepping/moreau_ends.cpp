// What follows a step of Moreau's: positions are brought back to Φ = 0 and g ≥ 0, and after a smooth one velocities to the rates at
// its end.
#include <fmt/format.h>

#include <algorithm>

#include "formulations/time_stepping/moreau.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

/// What is pressed drifts off by an error of third order as well as in: it is moved back one by one, which is enough for
/// gaps that are a small part of the tolerance.
void MoreauStepper::draw_closed(double t_new) {
  for (int k = 0; k < system_.contacts(); ++k) {
    auto& c = contacts_[k];
    if (!c.closed || c.unknown < 0 || !(problem_.unknowns[c.unknown].impulse_n > 0)) continue;
    c.gap = system_.gap(k, q_.data(), end_);
    if (!(c.gap > 0.01 * slack_)) continue;
    if (many_) {
      const int place = many_->first[k];
      rows_[place] = c.row.normal;
      respond(place);
      push(place, -c.gap / along(c.row.normal, place), q_.data());
    } else {
      saddle_.respond(c.row.normal, nullptr, 0, dq_.data(), lambda_dq_.data(), Multipliers::kept);
      const double by = c.gap / c.row.normal.dot(dq_.data());
      for (int i = 0; i < system_.n(); ++i) q_[i] -= by * dq_[i];
    }
    system_.place(t_new, q_.data(), end_);
    c.gap = system_.gap(k, q_.data(), end_);
  }
}

/// What a curve of time is ahead of the mean of its end rates is driven too: its lift against gravity and springs is work of
/// drives. (Its share of bring_back()'s first move.)
void MoreauStepper::book_leads() {
  const int first_driven = system_.rows() - system_.drive_rows();
  for (int k = 0; k < system_.rows(); ++k) {
    const bool timed = k >= first_driven && (e_.phi_t[k] != 0 || end_.phi_t[k] != 0);
    r_[k] = timed ? -end_.phi[k] : 0;
  }
  saddle_.solve(nullptr, r_.data(), dq_.data(), lambda_dq_.data(), Multipliers::kept);
  for (int i = 0; i < system_.n(); ++i) dq_[i] += q_[i];
  const double lift = system_.potential(dq_.data()) - system_.potential(q_.data());
  integrals_.drive += lift;
  integrals_.stabilisation -= lift;
}

/// What gaps between many bodies are known to (m). Of a row that just fits between two walls not all can be without it, and to ask
/// for that in every step would cost more than the steps.
double MoreauStepper::rounding_of_places() const {
  double farthest = 0;
  for (int i = 0; i < system_.n(); ++i)
    if (i % 3 != 2) farthest = std::max(farthest, std::abs(q_[i]));
  return 8 * std::numeric_limits<double>::epsilon() * farthest;
}

/// dq_ of a position problem that has no solution: a row of bodies that just fits between two walls asks by rounding for more
/// room than there is. Sweeps find what of it there is room for; what stays is the run's greatest penetration.
void MoreauStepper::compromise() {
  std::ranges::fill(dq_, 0.0);
  auto& p = position_problem_;
  for (auto& u : p.unknowns) u.impulse_n = 0;
  for (int sweep = 0; sweep < 200; ++sweep)
    for (auto& u : p.unknowns) {
      const int place = place_of(u.normal);
      const double mobility = along(rows_[place], place);
      if (!(mobility > 0)) continue;
      const double gap = p.b[u.normal] + rows_[place].dot(dq_.data());
      const double by = std::max(-u.impulse_n, -gap / mobility);
      u.impulse_n += by;
      push(place, by, dq_.data());
    }
}

/// One Newton step of least mass-weighted length onto Φ(q⁺, t⁺) = 0, then contacts whose gap is still
/// negative are opened to zero along A W_N, which leaves Φ alone to first order.
bool MoreauStepper::bring_back(double t_new) {
  const int n = system_.n(), m = system_.rows();
  const double potential = system_.potential(q_.data());
  if (films_.any()) films_.displace(q_.data(), [&](int k) { return contacts_[k].unknown >= 0; });
  const auto place_end = [&] { system_.place_near(t_new, q_.data(), q_mid_.data(), e_, end_); };
  place_end();
  const auto move = [&](const double* dq) {
    for (int i = 0; i < n; ++i) q_[i] += dq[i];
  };
  if (system_.has_motions()) book_leads();
  if (m > 0) {
    for (int k = 0; k < m; ++k) r_[k] = -end_.phi[k];
    saddle_.solve(nullptr, r_.data(), dq_.data(), lambda_dq_.data(), Multipliers::kept);
    move(dq_.data());
    place_end();
  }
  if (near_) keep_near(0, q_.data(), nullptr, nullptr);
  const auto look = [&] {
    for (const int k : live_) contacts_[k].gap = gap_of(k, q_.data(), end_);
  };
  look();
  const bool held = many_ && hold_lasting();
  if (held) {
    place_end();
    look();
  }
  bool moved = false;
  const double rounding = many_ ? rounding_of_places() : 0;
  for (const int k : live_)
    moved |= contacts_[k].gap < -rounding && in_reach(contacts_[k]) && !(held && contacts_[k].held);
  if (moved) {
    position_problem_.clear();
    if (many_) many_->id.clear();
    auto& p = position_problem_;
    for (const int k : live_) {
      auto& c = contacts_[k];
      if (c.row.normal.size == 0 || !in_reach(c) || (c.gap >= 0 && c.unknown < 0)) continue;
      const int place = many_ ? many_->first[k] : p.rows;
      if (many_) {
        many_->place[p.rows] = place;
        many_->id.push_back(k);
      }
      // The velocities' problem has left the response to this very row where it was its own place.
      const bool known =
          !many_ && !films_.any() && c.unknown >= 0 && problem_.unknowns[c.unknown].normal == place;
      if (!known) {
        rows_[place] = c.row.normal;
        respond(place);
      }
      ContactUnknown u;
      u.normal = p.rows;
      p.b[p.rows++] = c.gap;
      p.unknowns.push_back(u);
    }
    ContactSolution result;
    if (many_) {
      many_->positions.clear();
      result = many_->positions.solve(p, many_->place, many_->id, rows_, many_->responses);
    } else {
      for (int r = 0; r < p.rows; ++r)
        for (int s = 0; s <= r; ++s) p.D(r, s) = p.D(s, r) = rows_[r].dot(response(s));
      result = p.solve();
    }
    work_.pivots += result.pivots;
    if (result.solved) {
      for (const auto& u : p.unknowns)
        if (u.impulse_n > 0) push(place_of(u.normal), u.impulse_n, q_.data());
      place_end();
    } else {
      const auto deepest = [&] {
        double least = 0;
        for (const int k : live_)
          if (in_reach(contacts_[k])) least = std::min(least, contacts_[k].gap);
        return least;
      };
      const double before = deepest();
      compromise();
      move(dq_.data());
      place_end();
      look();
      if (!(deepest() >= before)) {
        for (int i = 0; i < n; ++i) q_[i] -= dq_[i];
        place_end();
      }
    }
  }
  if (reach_ == Reach::closed) draw_closed(t_new);
  integrals_.stabilisation += system_.potential(q_.data()) - potential;
  if (near_ && moved) keep_near(0, q_.data(), nullptr, nullptr);
  for (const int k : live_) {
    if (moved || reach_ == Reach::closed) contacts_[k].gap = gap_of(k, q_.data(), end_);
    auto& deepest = extremes_.penetration[told_as(k)];
    if (in_reach(contacts_[k])) deepest = std::max(deepest, -contacts_[k].gap);
  }
  keep_residuals(system_, end_, extremes_);
  return true;
}

/// Rates at the middle of a step, continued by ±(h/2)γ, miss those at its end by an error of third order, by which what
/// stays in contact on a turning normal would lift off: least mass-weighted change of v onto the rates at q⁺ of joints, of
/// what is pressed and of what sticks. Of what slides the error is of second order, γ being that of v⁻: friction has its
/// share of what brings its normal rate back, W_N + (P_T/P_N) W_T, or it would be of first order over a run.
bool MoreauStepper::meet_rates() {
  const int n = system_.n(), m = system_.rows();
  const auto preloaded = problem_.unknowns.size() - slides_.size();
  const auto sticks = [](const ContactUnknown& u, double bound) {
    return u.tangent >= 0 && std::abs(u.impulse_t) < bound * (1 - 1e-9);
  };
  int used = 0;
  const auto take = [&](const SparseRow& row, double least) {
    least_impulse_[used] = least;
    slope_[used] = 0;
    held_[used] = -1;
    rows_[used++] = row;
  };
  const auto each_pressed = [&](auto take) {
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& c = contacts_[k];
      if (!c.closed || c.unknown < 0) continue;
      const auto& u = problem_.unknowns[c.unknown];
      if (u.impulse_n > 0) take(k, sticks(u, u.friction * u.impulse_n));
    }
  };
  const auto each_preloaded = [&](auto take) {
    for (int k = 0; k < system_.frictions(); ++k) {
      const auto& u = problem_.unknowns[preloaded + static_cast<std::size_t>(k)];
      if (sticks(u, u.bound) && (driven_.empty() || driven_[static_cast<std::size_t>(k)] == 0)) take(k);
    }
  };
  const auto look = [&](int k) { system_.contact(k, q_.data(), v_.data(), end_, end_row_); };
  const auto look_along = [&](int k) { system_.friction(k, q_.data(), v_.data(), end_, end_row_.tangent); };
  each_pressed([&](int k, bool stuck) {
    look(k);
    const auto& u = problem_.unknowns[contacts_[k].unknown];
    take(end_row_.normal, -u.impulse_n);
    if (stuck) {
      take(end_row_.tangent, -INFINITY);
      held_[used - 1] = contacts_[k].unknown;
    } else if (u.tangent >= 0) {
      slope_[used - 1] = u.impulse_t / u.impulse_n;
      along_[used - 1] = end_row_.tangent;
    }
  });
  each_preloaded([&](int k) {
    look_along(k);
    take(end_row_.tangent, -INFINITY);
  });
  if (m == 0 && used == 0) return true;
  ++work_.factorisations;
  if (!saddle_.factor(end_.G.data())) {
    failure_ =
        fmt::format("t = {:.9g} s: the constraint equations are not finite or cannot be factorised", t_);
    return false;
  }
  const double before = system_.kinetic(v_.data());
  for (int k = 0; k < m; ++k)
    r_[k] = -end_.phi_t[k] - row_dot(system_.pattern(), end_.G.data(), k, v_.data());
  saddle_.solve(nullptr, r_.data(), dq_.data(), lambda_dq_.data());
  for (int r = 0; r < used; ++r) {
    respond(r, &along_[r], slope_[r]);
    if (!(along(rows_[r], r) > 0)) {  // friction that draws in (Painlevé)
      slope_[r] = 0;
      respond(r, nullptr, 0);
    }
    end_impulse_[r] = 0;
  }
  for (int i = 0; i < n; ++i) v_[i] += dq_[i];
  // One by one, for they may depend on each other. False: friction's shares drive each other on, further with every sweep.
  const auto sweep_rates = [&] {
    double first = 0, begun = 0, most = 0;
    for (int sweep = 0; sweep < (used > 1 ? 20 : 1); ++sweep) {
      most = 0;
      for (int r = 0; r < used; ++r) {
        const double rate = rows_[r].dot(v_.data()), d = along(rows_[r], r);
        if (!(d > 0)) continue;
        // No more is taken back than the step has pressed: what still parts then, parts, and friction no longer holds it.
        double impulse = std::max(end_impulse_[r] - rate / d, least_impulse_[r]);
        if (held_[r] >= 0) {
          const auto& u = problem_.unknowns[static_cast<std::size_t>(held_[r])];
          const double bound = u.friction * std::max(0.0, u.impulse_n + end_impulse_[r - 1]);
          impulse = std::clamp(impulse, -bound - u.impulse_t, bound - u.impulse_t);
        }
        const double by = impulse - end_impulse_[r];
        most = std::max(most, std::abs(by) * d);
        end_impulse_[r] = impulse;
        push(r, by, v_.data());
      }
      first = std::max(first, most);
      if (sweep == 0) begun = most;
      if (!(most > 1e-6 * first)) return true;
    }
    return !(most > begun);
  };
  v_end_ = v_;
  if (!sweep_rates()) {  // without friction's shares their problem is symmetric, and sweeps come to an end
    v_ = v_end_;
    for (int r = 0; r < used; ++r) {
      end_impulse_[r] = slope_[r] = 0;
      respond(r, nullptr, 0);
    }
    sweep_rates();
  }
  double rubbed = 0;
  each_pressed([&, r = 0](int k, bool stuck) mutable {
    const double normal = end_impulse_[r], tangential = slope_[r] * normal;
    if (slope_[r] != 0) rubbed += tangential * along_[r].dot(v_.data());
    ++r;
    contacts_[k].impulse_n += normal;
    contacts_[k].impulse_t += stuck ? end_impulse_[r++] : tangential;
  });
  integrals_.friction -= rubbed;
  // What ideal joints do nothing of is the drives' (account()).
  (system_.drive_rows() > 0 ? integrals_.drive : integrals_.stabilisation) +=
      system_.kinetic(v_.data()) - before - rubbed;
  if (!watching_) return true;
  for (int i = 0; i < n; ++i) smooth_.acceleration[i] += dq_[i];
  for (int r = 0; r < used; ++r) push(r, end_impulse_[r], smooth_.acceleration.data());
  if (many_) {
    std::ranges::fill(force_, 0.0);
    for (int r = 0; r < used; ++r) {
      rows_[r].add_to(force_.data(), end_impulse_[r]);
      along_[r].add_to(force_.data(), end_impulse_[r] * slope_[r]);
    }
    saddle_.solve(force_.data(), nullptr, dq_.data(), lambda_free_.data());
    for (int k = 0; k < m; ++k) lambda_dq_[k] += lambda_free_[k];
  } else {
    for (int r = 0; r < used; ++r)
      for (int k = 0; k < m; ++k) lambda_dq_[k] += end_impulse_[r] * reaction(r)[k];
  }
  system_.report_rows(q_.data(), end_, lambda_dq_.data(), 1, smooth_);
  int r = 0;
  each_pressed([&](int k, bool stuck) {
    look(k);
    const double normal = end_impulse_[r], tangential = slope_[r] * normal;
    ++r;
    system_.report_contact(k, q_.data(), end_, end_row_, normal, stuck ? end_impulse_[r++] : tangential, 1,
                           smooth_);
  });
  each_preloaded([&](int k) {
    look_along(k);
    system_.report_friction(k, q_.data(), v_.data(), end_, end_row_.tangent, end_impulse_[r++], 1, smooth_);
  });
  return true;
}

}  // namespace freeplay
