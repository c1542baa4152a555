// Helpers for tests of snapshots: the observable content of a run as bits, and a check at random
// steps.
#pragma once

#include <bitset>
#include <span>

#include "simulation/statistics.hpp"
#include "simulation/trajectory.hpp"
#include "values/snapshot.hpp"
#include "verification/support/piles.hpp"
#include "verification/support/rig.hpp"

namespace freeplay::snapshots {

using Bytes = std::vector<std::byte>;

/// The bits of values: NaNs are equal to themselves, and zeros have signs.
template <class... T>
inline Bytes bits(T&... values) {
  Bytes bytes;
  MemoryWriter m(bytes);
  m(values...);
  return bytes;
}

/// State of the motion at the end of a step.
enum Place { flight, contact, slide, stick, film, impact, before_knot, behind_knot, places };
inline const char* name_of(Place p) {
  return std::array{
      "flight", "contact", "slide", "stick", "film", "impact", "before a knot", "behind a knot"}[p];
}
using Places = std::bitset<places>;

/// All data that an observer receives, as bits.
class Record final : public Observer {
 public:
  struct Moment {
    Snapshot snapshot;
    Bytes statistics;
    std::size_t steps, events, samples;
    double t;
  };
  Record(Simulation& simulation, bool forces)
      : simulation_(simulation), forces_(forces), statistics(simulation.scene().run.discard) {
    const auto& surfaces = simulation.scene().mechanism.surfaces;
    if (!surfaces.empty()) mu_ = surfaces.front().friction.value_or(0);
  }
  Wants wants() const override { return {forces_, true}; }
  void begin(const Layout& layout, const State& state) override {
    statistics.begin(layout, state);
    contacts_.resize(layout.contacts.size());
    q_.resize(state.q.size());
    v_.resize(state.v.size());
    now_.elements.resize(layout.forces.size());
    now_.acceleration.resize(state.v.size());
    elements_.clear();
    for (std::size_t e = 0; e < layout.forces.size(); ++e)
      if (layout.forces[e].kind == ForceElement::Kind::contact && elements_.size() < contacts_.size())
        elements_.push_back(e);
  }
  void event(const Event& e) override {
    statistics.event(e);
    auto copy = e;
    events.push_back(bits(copy));
  }
  void sample(std::size_t channel, double t, double value) override {
    samples.push_back(bits(channel, t, value));
  }
  void step(const Step& step) override {
    double t0 = step.t0, t1 = step.t1;
    step.state(0.5 * (t0 + t1), q_, v_);
    auto seen = bits(t0, t1, q_, v_);
    std::vector<double> lambda(step.multipliers().begin(), step.multipliers().end());
    auto ledger = step.ledger();
    step.state(t1, q_, v_);
    step.contacts(t1, q_, contacts_);
    const auto more = [&](const Bytes& b) { seen.insert(seen.end(), b.begin(), b.end()); };
    more(bits(q_, v_, lambda, ledger));
    if (forces_) {
      step.forces(t1, now_);
      auto before = step.before(), within = step.within();
      more(bits(now_, before, within));
    }
    steps.push_back(seen);
    where.push_back(forces_ ? place(step) : Places());
    if (wanted.contains(steps.size())) {
      Moment m{simulation_.snapshot(), {}, steps.size(), events.size(), samples.size(), t1};
      MemoryWriter w(m.statistics);
      statistics.save(w);
      moments.push_back(m);
    }
  }
  void end(const RunEnd& end) override { statistics.end(end); }

  std::vector<Bytes> steps, events, samples;
  std::vector<Places> where;     // at the end of each step
  std::set<std::size_t> wanted;  // take a snapshot after these numbers of steps
  std::vector<Moment> moments;
  std::vector<double> knots;

 private:
  Places place(const Step& step) {
    Places p;
    bool touches = false;
    for (std::size_t k = 0; k < elements_.size(); ++k) {
      const auto &f = now_.elements[elements_[k]], &b = step.before().elements[elements_[k]],
                 &w = step.within().elements[elements_[k]];
      if (b.fn > 0 || w.fn > 0) p.set(impact);
      if (f.fn == 0) continue;
      touches = true;
      if (contacts_[k].gap > 1e-7) {
        p.set(film);
        continue;
      }
      if (!(f.fn > 0)) continue;
      p.set(contact);
      if (mu_ > 0 && std::abs(f.ft) >= 0.999 * mu_ * f.fn) p.set(slide);
      if (mu_ > 0 && std::abs(f.ft) < 0.9 * mu_ * f.fn) p.set(stick);
    }
    if (!touches && !elements_.empty() && !p[impact]) p.set(flight);
    for (const double knot : knots) p.set(step.t1 < knot ? before_knot : behind_knot);
    return p;
  }
  Simulation& simulation_;
  const bool forces_;
  double mu_ = 0;
  std::vector<std::size_t> elements_;  // of the contacts
  std::vector<ContactPlace> contacts_;
  std::vector<double> q_, v_;
  Forces now_;

 public:
  ContactStatistics statistics;
};

/// All of a result except its cost; its events are those of the record.
inline Bytes bits_of(Result r) {
  auto& s = r.final_state;
  auto all = bits(r.formulation, r.ending.status, r.ending.reason, r.t_end, r.observed, s.t, s.q, s.v, s.z,
                  r.revolutions, r.ledger, r.work, r.extremes, r.notes, r.undetermined);
  for (auto& c : r.contacts) {
    auto& m = c.model;
    const auto more = bits(c.name, m.restitution_asked, m.restitution_delivered, m.stiffness, m.exponent,
                           m.chi, c.flight_fraction, c.impact_fraction, c.lasting_fraction, c.impacts,
                           c.counted_impacts, c.impacts_per_revolution, c.fastest_approach, c.median_approach,
                           c.median_impulse, c.greatest_impulse, c.penetration, c.penetration_ratio);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

/// Whether `rest` is the end of `all`, from there on.
inline void require_rest(const char* what, const std::vector<Bytes>& rest, const std::vector<Bytes>& all,
                         std::size_t from) {
  INFO(what);
  REQUIRE(rest.size() == all.size() - from);
  const auto differs = std::ranges::mismatch(rest, std::span(all).subspan(from)).in1;
  INFO("the first " << differs - rest.begin() << " of " << rest.size() << " are equal");
  REQUIRE(differs == rest.end());
}

/// Options of a scene: a list, or words separated by spaces.
struct Options : std::vector<std::string> {
  using std::vector<std::string>::vector;
  Options(const std::string& words) {  // NOLINT(google-explicit-constructor)
    std::istringstream in(words);
    assign(std::istream_iterator<std::string>(in), {});
  }
  Options(const char* words) : Options(std::string(words)) {}  // NOLINT(google-explicit-constructor)
};

struct Case {
  std::string scene;  // text
  std::string formulation;
  Options set = {};
  std::vector<Place> in = {};  // states in which some snapshots must fall
  bool matched = false;
  bool forces = true;
  std::vector<double> knots = {};
};

inline std::string text(const std::string& name) { return test::file_text(test::scene_file(name)); }

inline void check(const Case& c) {
  CAPTURE(c.formulation, c.set);
  const auto scene = parse_scene(c.scene, "snapshot.toml", c.set);
  const auto simulation = [&] { return Simulation(scene, c.formulation, {.matched = c.matched}); };
  const auto run_on = [](Simulation& s, Record& record, Trajectory& path) {
    auto result = s.run({.observers = {&path, &record}});
    record.statistics.into(result);
    return result;
  };
  std::mt19937 engine(20240611);
  std::set<std::size_t> chosen;
  std::vector<Places> where;
  {  // Determine the steps.
    auto s = simulation();
    Record record(s, true);
    record.knots = c.knots;
    const auto result = s.run({.observers = {&record}});
    INFO(result.ending.reason);
    REQUIRE(result.ending.status == Ending::Status::finished);
    where = record.where;
    REQUIRE(where.size() > 5);
    for (const auto place : c.in) {
      std::vector<std::size_t> there;
      for (std::size_t i = 0; i + 1 < where.size(); ++i)
        if (where[i][place]) there.push_back(i + 1);
      INFO("in " << name_of(place) << ": " << there.size() << " of " << where.size() << " steps");
      REQUIRE(there.size() >= 2);
      for (int i = 0; i < 3; ++i) chosen.insert(there[engine() % there.size()]);
    }
    while (chosen.size() < std::min<std::size_t>(c.in.empty() ? 20 : 10, where.size() - 1))
      chosen.insert(1 + engine() % (where.size() - 1));
  }
  auto whole = simulation();
  Record all(whole, c.forces);
  all.wanted = chosen;
  Trajectory path;
  const auto result = run_on(whole, all, path);
  const auto result_bits = bits_of(result);
  REQUIRE(all.moments.size() == chosen.size());
  REQUIRE(all.steps.size() == where.size());  // observed in another way, the run is the same

  const auto go_on = [&](Simulation& s, const Record::Moment& m) {
    INFO("after " << m.steps << " of " << all.steps.size() << " steps, t = " << m.t << ": "
                  << where[m.steps - 1].to_string());
    s.restore(m.snapshot);
    REQUIRE(s.t() == m.t);
    REQUIRE((s.snapshot().memory == m.snapshot.memory));
    Record rest(s, c.forces);
    MemoryReader r(m.statistics);
    rest.statistics.load(r);
    Trajectory rest_path;
    const auto end = run_on(s, rest, rest_path);
    require_rest("steps", rest.steps, all.steps, m.steps);
    require_rest("events", rest.events, all.events, m.events);
    require_rest("samples", rest.samples, all.samples, m.samples);
    REQUIRE((bits_of(end) == result_bits));
    REQUIRE(end.events.size() == rest.events.size());
    std::size_t row = 0;
    while (row < path.size() && path.t(row) <= m.t) ++row;
    REQUIRE(rest_path.size() == path.size() - row + 1);  // its first row is at its beginning
    bool equal = true;
    for (std::size_t i = 1; i < rest_path.size(); ++i, ++row)
      equal = equal && rest_path.t(i) == path.t(row) && std::ranges::equal(rest_path.q(i), path.q(row)) &&
              std::ranges::equal(rest_path.v(i), path.v(row));
    REQUIRE(equal);
  };
  for (const auto& m : all.moments) {
    auto fresh = simulation();
    go_on(fresh, m);
  }
  // Restore in a simulation that has already run.
  go_on(whole, all.moments[engine() % all.moments.size()]);
}

/// A load cell on a pin of the long chain, whose forces come from sparse factors.
inline std::string chain() {
  return text("long_chain") +
         "[instruments.cell]\ntype = \"load-cell\"\njoint = \"pin1\"\naxis = [1.0, 0.0]\n"
         "bandwidth = 500.0\nsampling = 2000.0\n";
}

/// The same without further settings.
inline void check(std::string scene, std::string formulation, Options set = {}, std::vector<Place> in = {}) {
  check(Case{std::move(scene), std::move(formulation), std::move(set), std::move(in)});
}

}  // namespace freeplay::snapshots
