#include "simulation/film_statistics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

namespace freeplay {

FilmStatistics::FilmStatistics(std::unique_ptr<FilmProbe> probe, double discard)
    : probe_(std::move(probe)), discard_(discard) {}

void FilmStatistics::Tally::add(const FilmState& s, double seconds) {
  ratio += seconds * s.ratio;
  thickness += seconds * s.thickness;
  load += seconds * s.load;
  speed += seconds * s.speed;
  loss += seconds * s.loss;
  if (!(s.load > 0)) return;  // without a load there is no attitude angle
  cosine += seconds * std::cos(s.attitude);
  sine += seconds * std::sin(s.attitude);
}

void FilmStatistics::Tally::compare(const FilmState& s, double t) {
  if (!any || s.thickness < least_thickness) {
    least_thickness = s.thickness;
    least_at = t;
  }
  greatest_ratio = std::max(greatest_ratio, s.ratio);
  greatest_load = std::max(greatest_load, s.load);
  greatest_loss = std::max(greatest_loss, s.loss);
  any = true;
}

void FilmStatistics::begin(const Layout& layout, const State&) {
  const auto films = probe_->joints().size();
  q_.resize(3 * layout.bodies.size());
  v_.resize(q_.size());
  now_.resize(films);
  if (tallies_.size() != films) tallies_.assign(films, {});  // else a continued run
}

void FilmStatistics::evaluate(const Step& step, double t) {
  step.state(t, q_, v_);
  probe_->evaluate(t, q_, v_, now_);
  for (std::size_t k = 0; k < now_.size(); ++k) tallies_[k].compare(now_[k], t);
}

void FilmStatistics::step(const Step& step) {
  const double from = std::max(step.t0, discard_), h = step.t1 - from;
  if (now_.empty() || !(h > 0)) return;
  constexpr double root = 0.7745966692414834;  // √(3/5)
  constexpr std::array nodes{0.5 - 0.5 * root, 0.5, 0.5 + 0.5 * root}, weights{5.0 / 18, 8.0 / 18, 5.0 / 18};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    evaluate(step, from + nodes[i] * h);
    for (std::size_t k = 0; k < now_.size(); ++k) tallies_[k].add(now_[k], weights[i] * h);
  }
  evaluate(step, step.t1);
  time_ += h;
}

void FilmStatistics::into(Result& result) const {
  std::ranges::move(probe_->notes(), std::back_inserter(result.notes));
  if (!(time_ > 0)) return;
  const auto names = probe_->joints();
  for (std::size_t k = 0; k < tallies_.size(); ++k) {
    const auto contact = std::ranges::find(result.contacts, names[k], &ContactSummary::name);
    if (contact == result.contacts.end()) continue;
    const auto& x = tallies_[k];
    auto& s = contact->film.emplace();
    s.mean_ratio = x.ratio / time_;
    s.greatest_ratio = x.greatest_ratio;
    s.mean_thickness = x.thickness / time_;
    s.least_thickness = x.least_thickness;
    s.least_at = x.least_at;
    s.mean_load = x.load / time_;
    s.greatest_load = x.greatest_load;
    s.mean_speed = x.speed / time_;
    s.attitude = std::atan2(x.sine, x.cosine);
    if (s.mean_load > 0) s.sommerfeld = probe_->sommerfeld(k, s.mean_load, s.mean_speed);
    s.mean_loss = x.loss / time_;
    s.greatest_loss = x.greatest_loss;
  }
}

}  // namespace freeplay
