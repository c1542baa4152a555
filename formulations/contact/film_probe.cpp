#include "formulations/contact/film_probe.hpp"

#include <array>
#include <cmath>
#include <variant>

#include "dynamics/system.hpp"
#include "formulations/contact/film_force.hpp"
#include "formulations/contact/steady_film.hpp"
#include "mechanism/mechanism.hpp"

namespace freeplay {
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

std::unique_ptr<FilmProbe> make_film_probe(const Mechanism& mechanism) {
  return std::make_unique<FilmsOfSystem>(mechanism);
}

}  // namespace freeplay
