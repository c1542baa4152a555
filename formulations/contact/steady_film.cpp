#include "formulations/contact/steady_film.hpp"

#include <cmath>
#include <numbers>
#include <utility>
#include <variant>

#include "dynamics/system.hpp"
#include "mechanism/scene.hpp"
#include "numerics/bracketed_root.hpp"
#include "numerics/dual.hpp"
#include "values/diagnostic.hpp"

namespace freeplay {
namespace {

SteadyFilm::Matrix scaled(const SteadyFilm::Matrix& m, double factor) {
  auto r = m;
  for (auto& row : r)
    for (auto& x : row) x *= factor;
  return r;
}

/// Film force on the journal along x and y.
std::array<Dual<4>, 2> film_force_xy(const Film& film, const std::array<Dual<4>, 2>& e,
                                     const std::array<Dual<4>, 2>& rate, double speed) {
  const Dual<4> length = sqrt(e[0] * e[0] + e[1] * e[1]);
  const Dual<4> nx = e[0] / length, ny = e[1] / length;
  const auto f = film.force<Dual<4>>(length / film.clearance, nx * rate[0] + ny * rate[1],
                                     nx * rate[1] - ny * rate[0] - 0.5 * speed * length);
  return {f.radial * nx - f.tangential * ny, f.radial * ny + f.tangential * nx};
}

/// Fills the critical mass and the whirl ratio.
void find_threshold(SteadyFilm& s) {
  const auto &K = s.stiffness, &C = s.damping;
  const double k =
      (K[0][0] * C[1][1] + K[1][1] * C[0][0] - K[0][1] * C[1][0] - K[1][0] * C[0][1]) / (C[0][0] + C[1][1]);
  const double nu2 =
      ((k - K[0][0]) * (k - K[1][1]) - K[0][1] * K[1][0]) / (C[0][0] * C[1][1] - C[0][1] * C[1][0]);
  if (!(nu2 > 0)) return;
  s.whirl_ratio = std::sqrt(nu2) / s.speed;
  // In a full film k vanishes, up to rounding.
  const bool none = k <= 1e-12 * (std::abs(K[0][1]) + std::abs(K[1][0]));
  s.critical_mass = none ? 0 : k / nu2;
}

}  // namespace

SteadyFilm::Matrix SteadyFilm::scaled_stiffness(double clearance) const {
  return scaled(stiffness, clearance / load);
}

SteadyFilm::Matrix SteadyFilm::scaled_damping(double clearance) const {
  return scaled(damping, clearance * speed / load);
}

double sommerfeld_number(const Film& film, double load, double speed) {
  const double slenderness = film.radius / film.clearance;
  return film.viscosity * speed / (2 * std::numbers::pi) * film.length * 2 * film.radius / load *
         slenderness * slenderness;
}

SteadyFilm steady_film(const Film& film, double ratio, double speed) {
  SteadyFilm s;
  const double e = ratio * film.clearance;
  const auto f = film.force<double>(ratio, 0.0, -0.5 * speed * e);
  s.load = std::hypot(f.radial, f.tangential);
  s.speed = speed;
  s.ratio = ratio;
  s.attitude = std::atan2(f.tangential, -f.radial);
  s.sommerfeld = sommerfeld_number(film, s.load, speed);
  s.thickness = film.clearance - e;
  s.loss = film.shear<double>(ratio) * speed * speed + 0.5 * f.tangential * speed * e;

  std::array<Dual<4>, 2> place{e * std::cos(s.attitude), e * std::sin(s.attitude)}, rate{};
  for (int j = 0; j < 2; ++j) place[j].slope[j] = rate[j].slope[2 + j] = 1;
  const auto F = film_force_xy(film, place, rate, speed);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) {
      s.stiffness[i][j] = -F[i].slope[j];
      s.damping[i][j] = -F[i].slope[2 + j];
    }
  find_threshold(s);
  return s;
}

std::optional<double> steady_ratio(const Film& film, double load, double speed) {
  // The load increases with ε.
  const auto excess = [&](double ratio) {
    const auto f = film.force<double>(ratio, 0.0, -0.5 * speed * ratio * film.clearance);
    return std::hypot(f.radial, f.tangential) - load;
  };
  const double most = film.ratio(0.0);
  if (!(excess(most) >= 0)) return std::nullopt;
  return bracketed_root(excess, 0.0, most, {52, 200});
}

std::optional<std::string> range_note(const std::string& joint, const Film& film) {
  constexpr double longest_short = 0.5, shortest_long = 2;  // L/D
  const double length = film.length / (2 * film.radius);
  const auto note = [&](const char* side, double limit) {
    return diagnostic<Diagnostic::film_length>(joint, text_of(film.kind), length, side, limit);
  };
  if (film.kind == Film::Kind::short_bearing && length > longest_short * (1 + 1e-9))
    return note("up to", longest_short);
  if (film.kind == Film::Kind::long_bearing && length < shortest_long * (1 - 1e-9))
    return note("from", shortest_long);
  return std::nullopt;
}

namespace {

class FilmsOfSystem final : public FilmProbe {
 public:
  explicit FilmsOfSystem(const Mechanism& mechanism) : system_(mechanism), e_(system_.make_evaluation()) {
    for (int k = 0; k < system_.contacts(); ++k) {
      const auto& facts = system_.contact_facts(k);
      const auto law = make_film(facts);
      if (!law) continue;
      for (const auto& joint : mechanism.joints)
        if (const auto* pin = std::get_if<RevoluteJoint>(&joint); pin && pin->name == facts.name)
          films_.push_back({facts.name, k, *law, pin->between});
    }
  }

  std::vector<std::string> joints() const override {
    std::vector<std::string> names;
    for (const auto& film : films_) names.push_back(film.joint);
    return names;
  }

  std::vector<std::string> notes() const override {
    std::vector<std::string> list;
    for (const auto& film : films_)
      if (auto note = range_note(film.joint, film.law)) list.push_back(std::move(*note));
    return list;
  }

  void evaluate(double t, std::span<const double> q, std::span<const double> v,
                std::span<FilmState> out) override {
    if (films_.empty()) return;
    system_.place(t, q.data(), e_);
    const auto omega = [&](int body) {
      return body == ground ? 0 : v[3 * static_cast<std::size_t>(body) + 2];
    };
    for (std::size_t k = 0; k < films_.size(); ++k) {
      const auto& film = films_[k];
      system_.contact(film.contact, q.data(), v.data(), e_, row_);
      const double speed = omega(film.bodies[0]) + omega(film.bodies[1]);
      auto& s = out[k] = {};
      s.thickness = row_.gap;
      s.ratio = 1 - row_.gap / film.law.clearance;
      s.speed = std::abs(speed);
      const auto action = film_action(film.law, v.data(), row_);
      if (!action) continue;
      // The normal row measures the gap: its force acts towards the bearing's centre.
      s.load = std::hypot(action->normal, action->tangential);
      s.attitude = std::atan2(speed < 0 ? -action->tangential : action->tangential, action->normal);
      s.loss = action->loss;
    }
  }

  double sommerfeld(std::size_t film, double load, double speed) const override {
    return sommerfeld_number(films_[film].law, load, speed);
  }

 private:
  struct JointFilm {
    std::string joint;
    int contact;
    Film law;
    std::array<int, 2> bodies;
  };
  System system_;
  Evaluation e_;
  ContactRow row_;
  std::vector<JointFilm> films_;
};

}  // namespace

std::unique_ptr<FilmProbe> film_probe(const Scene& scene) {
  return std::make_unique<FilmsOfSystem>(scene.mechanism);
}

}  // namespace freeplay
