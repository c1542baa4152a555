#include "formulations/variation/end_state.hpp"

#include <boost/math/tools/minima.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "formulations/variation/variational_run.hpp"

namespace freeplay {
namespace {

constexpr std::size_t parts = 4;  // of a step
/// A minimum is known to half the digits of the force in its time, thus to all digits in its value.
constexpr int bits = 26;

}  // namespace

void LeastForces::add_step(double t0, double h, const std::function<bool(int)>& closed,
                           const std::function<double(int, double)>& force) {
  if (!(h > 0)) return;
  if (!begun_)
    for (int k = 0; k < contacts_; ++k)
      if (closed(k)) list_.push_back({.contact = k});
  begun_ = true;
  std::erase_if(list_, [&](const auto& one) { return !closed(one.contact); });
  for (auto& one : list_) {
    const auto at = [&](double t) { return force(one.contact, t); };
    const auto take = [&](double t, double value) {
      if (value < one.least) one.least = value, one.t = t;
      one.greatest = std::max(one.greatest, value);
    };
    std::array<double, parts + 1> f{};
    for (std::size_t i = 0; i <= parts; ++i) {
      const double t = t0 + static_cast<double>(i) / parts * h;
      take(t, f[i] = at(t));
    }
    // Around the least samples; at an end of the step, the minimum may be on either side of it.
    const double width = h / parts;
    for (std::size_t i = 0; i <= parts; ++i) {
      const std::size_t middle = std::clamp<std::size_t>(i, 1, parts - 1);
      if ((i > 0 && f[i - 1] < f[i]) || (i < parts && f[i + 1] < f[i])) continue;
      const double bend = std::abs(f[middle - 1] - 2 * f[middle] + f[middle + 1]);
      if (f[i] - bend > one.least) continue;
      const double t = t0 + static_cast<double>(i) * width;
      const auto [share, value] = boost::math::tools::brent_find_minima(
          [&](double s) { return at(t + s * width); }, i > 0 ? -1.0 : 0.0, i < parts ? 1.0 : 0.0, bits);
      take(t + share * width, value);
    }
  }
}

namespace {

/// Fills an EndState with the vector and the columns of a scheme at the end of a run.
template <class Scheme>
void take_end(const SensitivityRun& run, Scheme& scheme, EndState& end) {
  auto& variation = scheme.variation();
  const auto& d = scheme.mode();
  const auto& x = scheme.x();
  const auto& system = run.system;
  const auto n = system.n(), states = system.states();
  // q, v and z, and what contacts of a penalty run retain, which is at the end of the vector.
  const auto parts = [&](const std::vector<double>& all) {
    std::vector<double> list(all.begin(), all.begin() + 2 * n);
    const auto flows = all.begin() + d.state_offset();
    list.insert(list.end(), flows, flows + states);
    list.insert(list.end(), all.begin() + d.size(), all.end());
    return list;
  };
  const auto values = parts(x);
  const auto q = values.begin(), v = q + n, z = v + n;
  end.state = {scheme.t(), {q, v}, {v, z}, {z, z + states}};
  auto norm = motion_norm(system, make_scales(run.scene.mechanism, system, run.start), 1);
  add_states(norm, system, 2 * n);
  const auto motion = 2 * static_cast<std::size_t>(n) + static_cast<std::size_t>(states);
  for (std::size_t i = 0; i < motion; ++i)
    end.scales.push_back(norm.absolute[i] + norm.relative[i] * std::abs(values[i]));
  for (std::size_t c = 0; c < run.keys.size(); ++c)
    if (end.refused.empty()) end.refused = variation.reason(c);
  if (end.refused.empty())
    for (const auto& column : variation.end_columns(d, x, scheme.t())) end.columns.push_back(parts(column));
  for (auto* part : scheme.variations())
    end.onsets.insert(end.onsets.end(), part->onsets().begin(), part->onsets().end());
  std::ranges::stable_sort(end.onsets, {}, &VariedOnset::t);
}

/// What a scheme observes in each step beside the columns.
template <class Scheme>
struct StepObserver {
  StepObserver(const SensitivityRun&, Scheme&) {}
  void begin_step() {}
  void end_step() {}
  void finish(EndState&) {}
};

template <>
class StepObserver<EventScheme> {
 public:
  StepObserver(const SensitivityRun& run, EventScheme& scheme)
      : scheme_(scheme),
        probe_(scheme.mode().twin()),
        slope_(scheme.x().size()),
        least_(run.system.contacts()) {}
  void begin_step() {}
  void end_step() {
    probe_->take_mode(scheme_.mode());
    const auto& s = scheme_.stepper();
    least_.add_step(
        s.t_old(), s.t() - s.t_old(), [&](int k) { return probe_->contacts[k].closed; },
        [&](int k, double t) {
          (*probe_)(s.x_at(t), slope_, t);
          return probe_->contacts[k].lambda_n;
        });
  }
  void finish(EndState& end) { end.lasting = least_.lasting(); }

 private:
  EventScheme& scheme_;
  std::unique_ptr<EventDynamics> probe_;
  std::vector<double> slope_;
  LeastForces least_;
};

/// Also which contacts change, and what they retain.
template <>
class StepObserver<PenaltyScheme> {
 public:
  StepObserver(const SensitivityRun& run, PenaltyScheme& scheme)
      : scheme_(scheme),
        settling_(!std::isfinite(run.longest_step)),
        probe_(scheme.mode().twin()),
        x_(scheme.steps().x().size()),
        least_(run.system.contacts()),
        renewed_(static_cast<std::size_t>(run.system.contacts())) {}
  void begin_step() {
    for (std::size_t k = 0; k < renewed_.size(); ++k)
      probe_->contacts()[k].mode() = scheme_.mode().contacts()[k].mode();
  }
  void end_step() {
    const auto &was = probe_->contacts(), &now = scheme_.mode().contacts();
    for (std::size_t k = 0; k < renewed_.size(); ++k)
      if (was[k].closed != now[k].closed || was[k].in_impact != now[k].in_impact) renewed_[k] = true;
    if (settling_) return;
    const auto& steps = scheme_.steps();
    // A contact that closes or opens at the end of the step is open within or after it.
    least_.add_step(
        steps.t_old(), steps.t() - steps.t_old(), [&](int k) { return was[k].closed && now[k].closed; },
        [&](int k, double t) {
          double* v = x_.data() + probe_->system().n();
          steps.interpolate(t, x_.data(), v);
          const auto& row = probe_->contact_rows.at(k, x_, t);
          return was[k].normal_force(row.gap, row.normal.dot(v));
        });
  }
  void finish(EndState& end) {
    end.lasting = least_.lasting();
    end.renewed = renewed_;
    for (const auto& c : scheme_.mode().contacts()) {
      end.contacts.push_back(c.mode());
      end.retains.push_back(c.law.hysteretic());
      end.scales.insert(end.scales.end(), {scheme_.parts().speed_scale + c.v0, c.mass});
    }
  }

 private:
  PenaltyScheme& scheme_;
  bool settling_;
  std::unique_ptr<PenaltyDynamics> probe_;  // in the modes before the step
  std::vector<double> x_;
  LeastForces least_;
  std::vector<char> renewed_;
};

}  // namespace

EndState run_end_state(const SensitivityRun& run, Family family) {
  EndState end;
  with_variational_run<true>(run, family, {}, [&]<class Scheme>(VariationalRun<Scheme>& motion) {
    StepObserver<Scheme> observer(run, motion.scheme());
    for (observer.begin_step(); motion.step(); observer.begin_step()) observer.end_step();
    end.stopped = motion.stopped();
    end.fastest = motion.fastest();
    end.stepped = motion.scheme().steps_in_time();
    take_end(run, motion.scheme(), end);
    observer.finish(end);
  });
  return end;
}

}  // namespace freeplay
