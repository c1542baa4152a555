#include "formulations/event_driven/mode_equations.hpp"

#include "formulations/integrators/crossing.hpp"
#include "numerics/complementarity.hpp"
#include "simulation/residuals.hpp"

namespace freeplay {

ActiveRows::ActiveRows(int n, int m, int most) : n_(n), m_(m), rows_(static_cast<std::size_t>(most)) {
  b.setZero(most);
}

/// Few contacts are active at one time: the room for their dense matrices grows with the greatest
/// number so far.
void ActiveRows::make_room(int rows) {
  if (rows <= room_) return;
  constexpr int least = 16;
  room_ = std::min(std::max({rows, 2 * room_, least}), most());
  response_.resize(static_cast<std::size_t>(room_) * static_cast<std::size_t>(n_));
  reaction_.resize(static_cast<std::size_t>(room_) * static_cast<std::size_t>(m_));
  K.conservativeResize(room_, room_);
}

void ActiveRows::put(int r, SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside,
                     double factor) {
  make_room(r + 1);
  rows_[static_cast<std::size_t>(r)] = row;
  saddle.respond(row, beside, factor, response_.data() + static_cast<long>(r) * n_,
                 reaction_.data() + static_cast<long>(r) * m_);
}

int ActiveRows::add(SaddlePoint& saddle, const SparseRow& row, const SparseRow* beside, double factor) {
  put(used_, saddle, row, beside, factor);
  return used_++;
}

void ActiveRows::fill() {
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s < used_; ++s) K(r, s) = row(r).dot(response(s));
}

void ActiveRows::fill_symmetric() {
  for (int r = 0; r < used_; ++r)
    for (int s = 0; s <= r; ++s) K(r, s) = K(s, r) = row(r).dot(response(s));
}

void ActiveRows::solve() {
  if (used_ == 1 && std::abs(K(0, 0)) > 0 && std::isfinite(K(0, 0))) {  // as below
    x.resize(1);
    x[0] = b[0] / K(0, 0);
    dependent_ = false;
    turn_ = K(0, 0) < 0 ? -1 : 1;
    return;
  }
  const auto active = K.topLeftCorner(used_, used_);
  lu_.compute(active);
  dependent_ = !(lu_.pivot_ratio() > 1e-11);
  turn_ = lu_.sign();
  if (dependent_)
    x = MinimumNorm(active, 1e-10).solve(b.head(used_));
  else
    lu_.solve(b.head(used_), x);
}

void ActiveRows::share(const Eigen::VectorXd& weight) {
  const Eigen::VectorXd root = weight.cwiseSqrt();
  const Eigen::MatrixXd weighted = K.topLeftCorner(used_, used_) * root.asDiagonal();
  x = root.asDiagonal() * MinimumNorm(weighted, 1e-10).solve(b.head(used_));
}

/// x = x₀ + √W Q r with the orthonormal kernel Q of K √W, and the least r.
bool ActiveRows::share_within(const Eigen::VectorXd& weight, const Eigen::MatrixXd& C,
                              const Eigen::VectorXd& c) {
  const double unit = std::max(x.cwiseAbs().maxCoeff(), 1e-300), margin = 1e-11;
  Eigen::VectorXd h = -(C * x + c) / unit;
  if (h.maxCoeff() <= 0) return true;
  const Eigen::VectorXd root = weight.cwiseSqrt();
  const Eigen::MatrixXd weighted = K.topLeftCorner(used_, used_) * root.asDiagonal();
  const Eigen::MatrixXd free = root.asDiagonal() * orthogonal_complement(weighted.transpose(), 1e-10);
  if (free.cols() == 0) return false;
  Eigen::MatrixXd G = C * free;
  for (Eigen::Index i = 0; i < G.rows(); ++i) {
    h[i] += margin;
    const double length = G.row(i).norm();
    if (length <= 1e-10 * C.row(i).norm()) {  // no choice of x changes this condition
      if (h[i] > 2 * margin) return false;
      h[i] = -1;
      continue;
    }
    G.row(i) /= length;
    h[i] /= length;
  }
  Eigen::VectorXd r;
  if (!least_distance(G, h, 0.1 * margin, r) || !((G * r - h).minCoeff() > -0.5 * margin)) return false;
  x += unit * (free * r);
  return true;
}

void ActiveRows::apply(double* a, double* lambda) const {
  for (int r = 0; r < used_; ++r) {
    const double force = x[r];
    const double *own = response(r), *reactions = reaction(r);
    for (int i = 0; i < n_; ++i) a[i] += force * own[i];
    for (int k = 0; k < m_; ++k) lambda[k] += force * reactions[k];
  }
}

ModeFilms::ModeFilms(const System& system) {
  for (int k = 0; k < system.contacts(); ++k)
    if (const auto film = make_film(system.contact_facts(k))) films_.push_back({k, *film});
}

void ModeFilms::add(const System& system, const double* q, const double* v, Evaluation& e) {
  loss_ = 0;
  for (const auto& f : films_) {
    system.contact(f.contact, q, v, e, row_);
    const auto film = film_action(f.law, v, row_);
    if (!film) continue;
    row_.normal.add_to(e.force.data(), film->normal);
    row_.film.add_to(e.force.data(), film->tangential);
    row_.spin.add_to(e.force.data(), film->torque);
    loss_ += film->loss;
  }
}

void ModeFilms::report(const System& system, const double* q, const double* v, Evaluation& e, Forces& out) {
  for (const auto& f : films_) {
    system.contact(f.contact, q, v, e, row_);
    if (const auto film = film_action(f.law, v, row_))
      system.report().film(f.contact, q, e, row_, film->normal, film->tangential, film->torque, 1, out);
  }
}

ModeEquations::ModeEquations(const System& s, const std::vector<double>& restitution, RowFacts facts,
                             double speed_scale)
    : system(s),
      contacts(s.contacts()),
      preloaded(s.frictions()),
      saddle(s.mass(), s.pattern(), SolvePath::automatic, facts),
      e(s.make_evaluation()),
      films(s),
      rows(s.n(), s.rows(), 2 * s.contacts() + s.frictions()),
      coupled(s),
      a(s.n()),
      lambda(s.rows()),
      facts_(facts),
      speed_scale_(speed_scale),
      placed_(s.n()) {
  saddle.use(s.compiled().solve());
  for (int k = 0; k < s.contacts(); ++k) {
    contacts[k].restitution = restitution[k];
    if (const auto& surface = s.contact_facts(k).surface; surface.restitution_by_speed())
      contacts[k].by_speed = &surface;
  }
  for (int k = 0; k < s.frictions(); ++k) {
    preloaded[k].bound = preloaded[k].opposite = s.friction_facts(k).bound;
    preloaded[k].share = s.slide_share(k);
  }
  extremes.penetration.assign(s.contacts(), 0);
}

/// Many contacts are evaluated one by one at the same state; its sines and rows are computed once.
void ModeEquations::place(const double* q, double t) {
  if (t == placed_t_ && std::equal(placed_.begin(), placed_.end(), q)) return;
  system.place(t, q, e, phases.pieces());
  placed(q, t);
}

bool ModeEquations::solve_free(const Vector& x, double t) {
  shared_force = 0;
  const double *q = x.data(), *v = q + system.n();
  ++work.rhs;
  ++work.factorisations;
  place(q, t);
  system.rate(q, v, e);
  system.forces(t, q, v, x.data() + state_offset(), e, {nullptr, phases.pieces()});
  for (int k = 0; k < system.frictions(); ++k) {
    auto& p = preloaded[k];
    p.gamma = system.friction(k, q, v, e, p.row);
    p.rate = p.row.dot(v);
    p.lambda = -p.slip * p.bound;
    if (p.slip != 0) p.row.add_to(e.force.data(), p.lambda);
  }
  if (films.any()) films.add(system, q, v, e);
  if (!saddle.factor(e.G.data())) return false;
  saddle.solve(e.force.data(), e.gamma.data(), a.data(), lambda.data());
  if (coupled.reads_reactions() && saddle.singular() && !facts_.redundant) {
    trouble =
        "constraint rows are linearly dependent, so the reactions that bound joint friction are not unique "
        "(redundant joints, or a singular position)";
    return false;
  }
  return true;
}

double ModeEquations::unconstrained_mobility(const SparseRow& row) const {
  double free = 0;
  for (int c = 0; c < row.size; ++c) free += row.value[c] * row.value[c] / system.mass()[row.column[c]];
  return free;
}

const ContactRow& ModeEquations::look(int k, const Vector& x, double t) {
  place(x.data(), t);
  system.contact(k, x.data(), x.data() + system.n(), e, contacts[k].row);
  return contacts[k].row;
}

double ModeEquations::slide_rate(int k, const Vector& x, double t) {
  const double* v = x.data() + system.n();
  place(x.data(), t);
  system.friction(k, x.data(), v, e, preloaded[k].row);
  return preloaded[k].row.dot(v);
}

double ModeEquations::closed_gap(int k, const double* q) const {
  return std::max(1e-9 * system.contact_facts(k).clearance, 8 * gap_rounding(system, k, q));
}

void ModeEquations::keep_extremes(const Vector& x, double t) {
  place(x.data(), t);
  keep_residuals(system, e, extremes);
  for (int k = 0; k < system.contacts(); ++k)
    extremes.penetration[k] = std::max(extremes.penetration[k], -system.gap(k, x.data(), e));
}

double ModeEquations::greatest(const double* rates) const {
  double most = 0;
  for (int i = 0; i < system.n(); ++i)
    most = std::max(most, std::abs(rates[i]) * (system.is_angle(i) ? system.longest_arm() : 1));
  return most;
}

double ModeEquations::centripetal_scale(const double* v) const {
  double fastest = 0;
  for (int i = 0; i < system.n(); ++i)
    if (system.is_angle(i)) fastest = std::max(fastest, std::abs(v[i]));
  return fastest * fastest * system.longest_arm();
}

void ModeEquations::measure_speeds(const Vector& x) {
  fastest_ = std::max(fastest_, greatest(x.data() + system.n()));
  speed_tolerance_ = 1e-10 * speed_scale_ + 1e-14 * fastest_;
  slide_tolerance_ = 1e-7 * speed_scale_ + 1e-12 * fastest_;
}

}  // namespace freeplay
