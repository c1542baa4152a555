// Batch means by hand: counts, shares and energies whose scatter has a closed form.
#include "simulation/statistics.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// A step of which only the ledger is used.
class LedgerStep final : public Step {
 public:
  LedgerStep(double from, double to, const EnergyLedger& ledger) : ledger_(ledger) { t0 = from, t1 = to; }
  void state(double, std::span<double>, std::span<double>) const override {}
  std::span<const double> z() const override { return {}; }
  std::span<const double> multipliers() const override { return {}; }
  void contacts(double, std::span<const double>, std::span<ContactPlace>) const override {}
  EnergyLedger ledger() const override { return ledger_; }
  bool stopped() const override { return false; }
  bool cut() const override { return false; }
  void forces(double, Forces&) const override {}
  void add_impulse(double, double, Forces&) const override {}
  const Forces& before() const override { return none_; }
  const Forces& within() const override { return none_; }

 private:
  EnergyLedger ledger_;
  Forces none_;
};

/// One contact; a revolution lasts 1 s.
Layout layout_of(double duration) {
  Layout layout;
  layout.contacts = {"a"};
  layout.crank_speed = 2 * std::numbers::pi;
  layout.duration = duration;
  return layout;
}

Event event_at(double t, EventKind kind = EventKind::impact) {
  Event e;
  e.kind = kind;
  e.t = t;
  e.v_n_minus = -1;
  return e;
}

/// Ends the observation at t; results of one contact.
Result end_of(std::initializer_list<Observer*> observers, double t, double discard = 0) {
  const std::vector<double> undecided{NAN};
  const Ending ending;
  Result r;
  r.t_end = t;
  r.observed = r.revolutions = t - discard;
  r.contacts.resize(1);
  for (auto* observer : observers) observer->end({ending, t, {}, undecided});
  return r;
}

/// A revolution lasts 1 s. Revolution i (from 0) has count(i) impacts of 1 m/s, and count(i) J of
/// the drive's work, at its end.
template <class Count>
Result watched(int turns, double discard, const Count& count, int resume_after = -1) {
  const auto layout = layout_of(turns);
  auto watcher = std::make_unique<WindowStatistics>(discard, turns);
  ContactStatistics plain(discard);
  watcher->begin(layout, {});
  plain.begin(layout, {});
  EnergyLedger ledger;
  ledger.initial = ledger.kinetic = 5;
  for (int i = 0; i < turns; ++i) {
    for (int k = 0; k < count(i); ++k) {
      const auto e = event_at(i + (k + 0.5) / 10);
      watcher->event(e);
      plain.event(e);
    }
    for (int k = 0; k < 4; ++k) {
      if (k == 3) ledger.drive += count(i), ledger.kinetic += count(i);
      watcher->step(LedgerStep(i + 0.25 * k, i + 0.25 * (k + 1), ledger));
    }
    if (i != resume_after) continue;
    std::vector<std::byte> bytes;
    MemoryWriter writer(bytes);
    watcher->save(writer);
    watcher = std::make_unique<WindowStatistics>(discard, turns);
    MemoryReader reader(bytes);
    watcher->load(reader);
    watcher->begin(layout, {});
  }
  auto r = end_of({watcher.get(), &plain}, turns, discard);
  r.ledger = ledger;
  plain.into(r);
  watcher->into(r);
  return r;
}

}  // namespace

TEST_CASE("batch means: the standard error of a known scatter", "[windows]") {
  // 1, 3, 1, 3: mean 2, every deviation 1, so √(4/(4·3)). Two revolutions are discarded before.
  const auto r = watched(6, 2, [](int i) { return i < 2 ? 7 : i % 2 ? 3 : 1; });
  const double error = std::sqrt(4.0 / 12);
  REQUIRE(r.window);
  CHECK(r.window->batches == 4);
  CHECK(r.window->batch == Approx(1));
  CHECK(r.contacts[0].impacts_per_revolution == Approx(2));
  CHECK(r.contacts[0].impacts_error == Approx(error));
  // Energies are those of the window alone: 8 J of the 22 J; the sum's error is the window's length
  // times the mean's.
  CHECK(r.window->energy[Window::drives] == Approx(8));
  CHECK(r.window->error[Window::drives] == Approx(4 * error));
  CHECK(r.window->energy[Window::stored] == Approx(8));
  CHECK(r.window->energy[Window::closure] == Approx(0).margin(1e-12));
}

TEST_CASE("batch means: fewer than four batches give no error", "[windows]") {
  const auto r = watched(3, 0, [](int i) { return 1 + i; });
  REQUIRE(r.window);
  CHECK(r.window->batches == 0);
  CHECK(std::isnan(r.contacts[0].impacts_error));
  CHECK(r.window->energy[Window::drives] == Approx(6));
}

TEST_CASE("batch means: revolutions beyond the stored number are merged in pairs", "[windows]") {
  // 1 and 3 alternately: each pair is 4, without scatter. 40 revolutions: merged twice, ten batches
  // of four.
  const auto r = watched(40, 0, [](int i) { return i % 2 ? 3 : 1; });
  CHECK(r.window->batches == 10);
  CHECK(r.window->batch == Approx(4));
  CHECK(r.contacts[0].impacts_per_revolution == Approx(2));
  CHECK(r.contacts[0].impacts_error == Approx(0).margin(1e-12));
  CHECK(r.window->energy[Window::drives] == Approx(80));
  CHECK(r.window->error[Window::drives] == Approx(0).margin(1e-9));
}

TEST_CASE("batch means: a lasting contact is divided among the batches it spans", "[windows]") {
  // From 0.5 to 2.5 of four revolutions: flights of 0.5, 0, 0.5 and 1 of them; mean 0.5,
  // √((0.25 + 0.25)/12).
  WindowStatistics windows(0, 4);
  windows.begin(layout_of(0), {});
  windows.event(event_at(0.5, EventKind::contact));
  windows.event(event_at(2.5, EventKind::separation));
  for (int i = 0; i < 4; ++i) windows.step(LedgerStep(i, i + 1, {}));
  auto r = end_of({&windows}, 4);
  windows.into(r);
  CHECK(r.contacts[0].flight_error == Approx(std::sqrt(0.5 / 12)));
  CHECK(r.contacts[0].lasting_error == Approx(std::sqrt(0.5 / 12)));
}

TEST_CASE("batch means: a resumed run gives the same error", "[windows]") {
  const auto count = [](int i) { return 1 + i * i % 5; };
  const auto whole = watched(23, 1, count), resumed = watched(23, 1, count, 9);
  CHECK(whole.window->error == resumed.window->error);
  CHECK(whole.window->energy == resumed.window->energy);
  CHECK(whole.contacts[0].impacts_error == resumed.contacts[0].impacts_error);
}

TEST_CASE("an impact under way at the start of the window counts with its part inside it", "[windows]") {
  ContactStatistics plain(1);
  plain.begin(layout_of(0), {});
  auto e = event_at(0.9);
  e.duration = 0.3;
  plain.event(e);
  auto r = end_of({&plain}, 3);
  plain.into(r);
  CHECK(r.contacts[0].impact_fraction == Approx(0.2 / 2));
  CHECK(r.contacts[0].impacts == 0);  // the impact was before
}

TEST_CASE("energies of a window whose ends lie within steps", "[windows]") {
  // 2 W in steps of 0.7 s: from 1 s to 4.2 s.
  Layout layout;
  WindowStatistics windows(1, 4.2);
  windows.begin(layout, {});
  EnergyLedger ledger;
  for (int i = 0; i < 6; ++i) {
    ledger.drive = ledger.kinetic = 2 * 0.7 * (i + 1);
    windows.step(LedgerStep(0.7 * i, 0.7 * (i + 1), ledger));
  }
  windows.end({{}, 4.2, {}, {}});
  Result r;
  r.t_end = 4.2;
  r.ledger = ledger;
  windows.into(r);
  CHECK(r.window->energy[Window::drives] == Approx(2 * 3.2));
  CHECK(r.window->energy[Window::stored] == Approx(2 * 3.2));
  CHECK(r.window->error[Window::drives] == Approx(0).margin(1e-12));
}
