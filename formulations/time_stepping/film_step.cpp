#include "formulations/time_stepping/film_step.hpp"

#include <algorithm>
#include <cmath>

#include "formulations/contact/film.hpp"
#include "numerics/dual.hpp"

namespace freeplay {
namespace {

/// rad, rotation of a polar row in one step from which it is taken as constant.
constexpr double far_rotation = 0.3;

/// θ(z) = 1/(1 − e^(−z)) − 1/z, z ≥ 0.
double fitted(double z) {
  if (z < 1e-2) return 0.5 + z / 12;  // the next term is z³/720
  return -1 / std::expm1(-z) - 1 / z;
}

}  // namespace

FilmStep::FilmStep(const System& system) : n_(system.n()), m_(system.rows()) {
  for (int k = 0; k < system.contacts(); ++k)
    if (const auto film = make_film(system.contact_facts(k))) {
      Place f;
      f.contact = k;
      f.law = *film;
      films_.push_back(f);
    }
  const auto most = 3 * films_.size();
  response_.resize(most * static_cast<std::size_t>(n_));
  reaction_.resize(most * static_cast<std::size_t>(m_));
  D_.setZero(static_cast<Eigen::Index>(most), static_cast<Eigen::Index>(most));
}

void FilmStep::take(int film, const ContactRow& row, double gap) {
  auto& f = films_[static_cast<std::size_t>(film)];
  f.row = row;
  f.gap = gap;
}

/// Resistance (N s/m) of a full film against squeeze and against tangential motion.
std::array<double, 2> FilmStep::resistance(const Place& f, double gap) {
  Film full = f.law;
  full.cavitated = false;
  const double share = full.share(gap), ratio = full.ratio(gap);
  return {-share * full.force(ratio, 1.0, 0.0).radial, -share * full.force(ratio, 0.0, 1.0).tangential};
}

void FilmStep::begin(double h, SaddlePoint& saddle, const double* v_old) {
  h_ = h;
  used_ = 0;
  for (auto& f : films_) {
    f.first = -1;
    f.mobility = 0;
    if (!(f.law.share(f.row.gap) > 0)) {
      if (!(f.gap > 0) || f.row.normal.size == 0) continue;
      saddle.respond(f.row.normal, nullptr, 0, response(used_), reaction(used_));
      f.mobility = f.row.normal.dot(response(used_));
      continue;
    }
    f.first = used_;
    used_ += 3;
    for (int a = 0; a < 3; ++a) {
      saddle.respond(f.of(a), nullptr, 0, response(f.first + a), reaction(f.first + a));
      f.y_old[a] = f.of(a).dot(v_old);
    }
  }
  for (const auto& f : films_)
    for (int a = 0; f.first >= 0 && a < 3; ++a)
      for (int s = 0; s < used_; ++s) D_(f.first + a, s) = f.of(a).dot(response(s));
  for (auto& f : films_)
    if (f.first >= 0) {
      f.mobility = D_(f.first, f.first);
      set_theta(f);
    }
}

void FilmStep::set_theta(Place& f) {
  const int r = f.first;
  const double share = f.law.share(f.row.gap);
  const auto resisted = resistance(f, f.row.gap);
  for (int a = 0; a < 2; ++a) f.theta[a] = fitted(h_ * resisted[a] * D_(r + a, r + a));
  f.theta[2] = fitted(h_ * share * f.law.shear(f.law.ratio(f.row.gap)) * D_(r + 2, r + 2));
  // Polar rows that rotate far within the step, as when a journal passes the centre, are taken as
  // constant.
  f.gamma = {f.row.gamma_n, f.row.gamma_film, 0};
  if (std::abs(f.row.turn) * h_ > far_rotation) {
    f.gamma[0] -= f.row.turn * f.row.turn * (f.law.clearance - f.row.gap);
    f.gamma[1] += f.row.turn * f.y_old[0];  // n·ė = −ġ
  }
}

void FilmStep::linearise(const double* v_new) {
  K_.setIdentity(used_, used_);
  for (auto& f : films_) {
    if (f.first < 0) continue;
    std::array<Dual<4>, 3> y;
    for (int a = 0; a < 3; ++a) {
      f.y[a] = mean_rate(f, a, v_new);
      y[a] = f.y[a];
      y[a].slope[a] = 1;
    }
    const auto action = *film_action<Dual<4>>(f.law, f.row.gap, y[0], y[1], y[2]);
    const std::array<const Dual<4>*, 3> forces{&action.normal, &action.tangential, &action.torque};
    for (int a = 0; a < 3; ++a) {
      f.p[a] = h_ * forces[a]->value;
      for (int b = 0; b < 3; ++b) f.J[a][b] = h_ * forces[a]->slope[b];
      for (int s = 0; s < used_; ++s)
        for (int b = 0; b < 3; ++b) K_(f.first + a, s) -= f.J[a][b] * f.theta[b] * D_(f.first + b, s);
    }
  }
  if (used_ > 0) lu_.compute(K_);
}

/// Adds impulses p_ to v and λ.
void FilmStep::apply(double* v, double* lambda) const {
  for (int r = 0; r < used_; ++r) {
    for (int i = 0; i < n_; ++i) v[i] += p_[r] * response(r)[i];
    for (int k = 0; k < m_; ++k) lambda[k] += p_[r] * reaction(r)[k];
  }
}

void FilmStep::resist(double* v, double* lambda) {
  if (used_ == 0) return;
  rhs_.resize(used_);
  for (const auto& f : films_)
    for (int a = 0; f.first >= 0 && a < 3; ++a) {
      rhs_[f.first + a] = f.p[a];
      for (int b = 0; b < 3; ++b) rhs_[f.first + a] += f.J[a][b] * (mean_rate(f, b, v) - f.y[b]);
    }
  lu_.solve(rhs_, p_);
  apply(v, lambda);
}

void FilmStep::relax(double* own, double* own_reaction) const {
  if (used_ == 0) return;
  rhs_.resize(used_);
  for (const auto& f : films_)
    for (int a = 0; f.first >= 0 && a < 3; ++a) {
      rhs_[f.first + a] = 0;
      for (int b = 0; b < 3; ++b) rhs_[f.first + a] += f.J[a][b] * f.theta[b] * f.of(b).dot(own);
    }
  lu_.solve(rhs_, p_);
  apply(own, own_reaction);
}

void FilmStep::finish(const double* v_old, const double* v_new) {
  p_.resize(used_);
  way_.resize(used_);
  for (const auto& f : films_) {
    const double thickness = std::max(f.gap, f.law.hand_over);
    const double moved = 0.5 * h_ * std::abs(f.row.normal.dot(v_old) + f.row.normal.dot(v_new)) / thickness;
    if (moved > thickness_change.share && f.gap > 0) {
      // If a step is short compared with the film's own time constant, passing over the film has
      // little effect.
      const double share = moved * std::min(1.0, h_ * resistance(f, f.gap)[0] * f.mobility);
      if (share > thickness_change.share) thickness_change = {share, f.contact};
    }
    for (int a = 0; f.first >= 0 && a < 3; ++a) {
      p_[f.first + a] = f.p[a];
      for (int b = 0; b < 3; ++b) p_[f.first + a] += f.J[a][b] * (mean_rate(f, b, v_new) - f.y[b]);
    }
    if (f.first < 0) continue;
    for (int b = 0; b < 2; ++b) {
      const double change = f.of(b).dot(v_new) - f.y_old[b] - h_ * f.gamma[b];
      way_[2 * f.first / 3 + b] = h_ * (f.theta[b] - 0.5) * change;
    }
  }
  if (used_ == 0) return;
  // D of normal and film rows. It is singular where bodies cannot move against each other along a
  // row; no displacement is needed there.
  const int size = 2 * used_ / 3;
  const auto row = [](int i) { return 3 * (i / 2) + i % 2; };
  E_.resize(size, size);
  double greatest = 0;
  for (int i = 0; i < size; ++i)
    for (int j = 0; j < size; ++j) {
      E_(i, j) = D_(row(i), row(j));
      greatest = std::max(greatest, E_(i, j));
    }
  E_.diagonal().array() += 1e-12 * greatest;
  E_lu_.compute(E_);
  E_lu_.solve(way_.head(size), beyond_);
}

double FilmStep::greatest_change() const {
  double most = 0;
  for (int i = 0; used_ > 0 && i < n_; ++i) {
    double sum = 0;
    for (int r = 0; r < used_; ++r) sum += std::abs(p_[r] * response(r)[i]);
    most = std::max(most, sum);
  }
  return most;
}

double FilmStep::loss(const double* v_old, const double* v_new) const {
  double sum = 0;
  for (const auto& f : films_)
    for (int a = 0; f.first >= 0 && a < 3; ++a)
      sum -= 0.5 * p_[f.first + a] * (f.of(a).dot(v_old) + f.of(a).dot(v_new));
  return sum;
}

void FilmStep::report(const System& system, const double* q, const Evaluation& e, const double* in_impact,
                      Forces& smooth, Forces& within) const {
  for (const auto& f : films_) {
    if (f.first < 0) continue;
    std::array<double, 3> p{}, by{};
    for (int a = 0; a < 3; ++a) {
      for (int b = 0; b < 3; ++b) by[a] += f.J[a][b] * f.theta[b] * f.of(b).dot(in_impact);
      p[a] = p_[f.first + a] - by[a];
    }
    system.report().film(f.contact, q, e, f.row, p[0], p[1], p[2], 1, smooth);
    system.report().film(f.contact, q, e, f.row, by[0], by[1], by[2], 1, within);
  }
}

}  // namespace freeplay
