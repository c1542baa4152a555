#include "study/comparison/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "dynamics/system.hpp"
#include "facade/run_folder.hpp"
#include "io/files/output_file.hpp"
#include "io/files/run_json.hpp"
#include "mechanism/scene.hpp"
#include "simulation/statistics.hpp"
#include "simulation/touches.hpp"
#include "study/comparison/predicted_horizon.hpp"
#include "values/diagnostic.hpp"
#include "values/warning.hpp"

namespace freeplay {
namespace {

/// A contact onset with the flight before it and its duration.
struct ContactOnset {
  ContactEvent event;
  double flight = 0;  ///< s, since the last separation of the contact, or since the start
  double lasted = 0;  ///< s; infinite without a separation
};

/// Contact onsets of each contact. A contact that is closed at the start has none there.
std::vector<std::vector<ContactOnset>> touches(const std::vector<ContactEvent>& events, int joints) {
  std::vector<std::vector<ContactOnset>> of(joints);
  std::vector<double> left(joints);
  for (const auto& e : events) {
    auto& list = of[e.contact];
    if (e.kind == EventKind::separation) {
      left[e.contact] = e.t;
      if (!list.empty() && list.back().event.kind == EventKind::contact) list.back().lasted = e.duration;
      continue;
    }
    const bool impact = e.kind == EventKind::impact;
    if (is_onset(e)) list.push_back({e, e.t - left[e.contact], impact ? e.duration : INFINITY});
    left[e.contact] = e.t + (impact ? e.duration : 0);
  }
  return of;
}

/// Differences of the two motions up to the present pair.
struct Spread {
  double time = 0;     ///< s, greatest difference of times, including durations of the contacts
  double rate = 1e-3;  ///< greatest relative difference of speeds before and after

  void add(const ContactOnset& a, const ContactOnset& b) {
    const auto& p = a.event;
    const auto& n = b.event;
    const double longest =
        std::max(p.kind == EventKind::impact ? p.duration : 0, n.kind == EventKind::impact ? n.duration : 0);
    time = std::max(time, std::abs(p.t - n.t) + longest);
    const auto grow = [&](double x, double y) {
      if (x * y > 0) rate = std::max(rate, std::abs(x - y) / std::min(std::abs(x), std::abs(y)));
    };
    grow(p.v_n_minus, n.v_n_minus);
    if (p.kind == n.kind && p.kind == EventKind::impact) grow(p.v_n_plus, n.v_n_plus);
  }
};

/// Onsets from `first` on that follow flights of at most `longest`, as one contact.
struct Chain {
  std::size_t next;  ///< first onset that does not belong to it
  double end = 0;    ///< s
};
Chain chain(const std::vector<ContactOnset>& list, std::size_t first, double longest) {
  Chain c{first + 1, list[first].event.t + list[first].lasted};
  while (c.next < list.size() && list[c.next].flight <= longest && list[c.next].event.t <= c.end + longest) {
    c.end = std::max(c.end, list[c.next].event.t + list[c.next].lasted);
    ++c.next;
  }
  return c;
}

/// Reason why two onsets do not correspond; empty if they do. `ends`: of their chains; `longest`: T.
std::string parted(const ContactOnset& a, const ContactOnset& b, const std::array<double, 2>& ends,
                   double longest, const Spread& spread, double turn) {
  const double flight = std::min(a.flight, b.flight), apart = std::abs(a.event.t - b.event.t);
  if (!(apart <= 0.25 * flight)) return "the times differ by more than a quarter of the preceding flight";
  if (!(apart <= turn / 36)) return "the times differ by more than 10 degrees of a revolution";
  const double known = a.event.t_uncertainty + b.event.t_uncertainty;
  if (!(apart <= 10 * (spread.time + spread.rate * flight + known)))
    return "the times differ ten times more than the preceding events explain";
  const double ratio = a.event.v_n_minus / b.event.v_n_minus;
  if (!(ratio < 2 && ratio > 0.5)) return "the approach speeds differ by a factor of two";
  const double lasts_a = ends[0] - a.event.t, lasts_b = ends[1] - b.event.t;
  const bool alike = std::abs(lasts_a - lasts_b) <= longest ||
                     std::max(lasts_a, lasts_b) <= 2 * std::min(lasts_a, lasts_b);  // false for NaN
  if (a.event.kind != b.event.kind && !alike && !(std::max(a.lasted, b.lasted) <= 0.25 * flight))
    return a.event.kind == EventKind::impact ? "an impact (penalty), onset of sustained contact (nonsmooth)"
                                             : "an impact (nonsmooth), onset of sustained contact (penalty)";
  return "";
}

nlohmann::json to_json(const ContactEvent& e) {
  return {{"t_s", e.t},
          {"kind", name_of(e.kind)},
          {"crank_angle_rad", e.crank_angle},
          {"v_n_minus_m_per_s", e.v_n_minus},
          {"v_n_plus_m_per_s", e.v_n_plus},
          {"impulse_n_N_s", e.impulse_n},
          {"t_uncertainty_s", e.t_uncertainty}};
}

}  // namespace

Pairing pair_impacts(const std::vector<ContactEvent>& penalty, const std::vector<ContactEvent>& nonsmooth,
                     int joints, double until, double turn, const std::vector<std::string>& names) {
  Pairing p;
  const auto a = touches(penalty, joints), b = touches(nonsmooth, joints);
  std::vector<std::size_t> next_a(joints), next_b(joints);
  std::vector<double> longest(joints);  // s, impact of the penalty run
  for (const auto& e : penalty)
    if (e.kind == EventKind::impact) longest[e.contact] = std::max(longest[e.contact], e.duration);
  const auto alone = [&](const ContactEvent& e) {
    return std::ranges::equal_range(nonsmooth, e.t, {}, &ContactEvent::t).size() == 1;
  };
  const auto name_of_contact = [&](int k) {
    return names.empty() ? fmt::format("contact {}", k + 1) : names[static_cast<std::size_t>(k)];
  };
  Spread spread;
  double end = until, busy = -INFINITY;  // s, end of the latest impact of the penalty run
  int busy_contact = -1;
  p.complete = until == INFINITY, p.cut = !p.complete;
  p.ended_by = until < INFINITY ? "the recorded events of a run end there" : "all contact events are paired";
  for (;;) {  // in the order of time; each pass takes a contact event from the lists
    int first = -1;
    double t = until;
    const auto earliest = [&](int k, const std::vector<ContactOnset>& list, std::size_t next) {
      if (next < list.size() && list[next].event.t < t) t = list[next].event.t, first = k;
    };
    for (int k = 0; k < joints; ++k) earliest(k, a[k], next_a[k]), earliest(k, b[k], next_b[k]);
    if (first < 0) break;
    const auto &of_a = a[first], &of_b = b[first];
    const auto i = next_a[first], j = next_b[first];
    std::string why;
    std::array<Chain, 2> chains{};
    if (i >= of_a.size() || j >= of_b.size()) {
      why = fmt::format("it occurs in the {} run only", i < of_a.size() ? "penalty" : "nonsmooth");
    } else {
      chains = {chain(of_a, i, longest[first]), chain(of_b, j, longest[first])};
      why = parted(of_a[i], of_b[j], {chains[0].end, chains[1].end}, longest[first], spread, turn);
    }
    if (!why.empty()) {
      end = t;
      p.complete = p.cut = false;
      p.overlapping = t < busy && first != busy_contact;
      p.ended_by = fmt::format("contact event {}{} is unmatched: {}", i + 1,
                               joints > 1 ? " of " + name_of_contact(first) : "", why);
      if (p.overlapping)
        p.ended_by += fmt::format(
            "; it falls within an impact at {} of the penalty run, so that events are not comparable one by "
            "one",
            name_of_contact(busy_contact));
      break;
    }
    const auto &x = of_a[i], &y = of_b[j];
    spread.add(x, y);
    auto& pair = p.pairs.emplace_back(ImpactPair{x.event, y.event});
    next_a[first] = i + 1, next_b[first] = j + 1;
    // Onsets within the contact of the other run.
    while (next_a[first] < chains[0].next && of_a[next_a[first]].event.t < y.event.t + y.lasted)
      ++next_a[first], ++pair.merged_penalty;
    while (next_b[first] < chains[1].next && of_b[next_b[first]].event.t < x.event.t + x.lasted)
      ++next_b[first], ++pair.merged_nonsmooth;
    if (x.event.kind == EventKind::impact && x.event.t + x.event.duration > busy)
      busy = x.event.t + x.event.duration, busy_contact = first;
    const double change = y.event.v_n_plus - y.event.v_n_minus;
    if (x.event.kind == EventKind::impact && y.event.kind == EventKind::impact && change > 0 &&
        alone(y.event))
      pair.load = x.event.impulse_n - y.event.impulse_n / change * (x.event.v_n_plus - x.event.v_n_minus);
  }
  std::erase_if(p.pairs, [&](const ImpactPair& x) { return std::max(x.penalty.t, x.nonsmooth.t) >= end; });
  std::ranges::sort(p.pairs, {}, [](const ImpactPair& x) { return x.nonsmooth.t; });
  if (p.pairs.empty() && end == INFINITY) p.ended_by = "neither run has a contact event";
  if (!p.pairs.empty()) p.horizon = std::max(p.pairs.back().penalty.t, p.pairs.back().nonsmooth.t);
  return p;
}

namespace {

/// For each contact the properties in which the penalty law and the impact law differ although they
/// should agree.
void find_not_matched(const Scene& scene, Comparison& c) {
  const System system(scene.mechanism);
  for (int k = 0; k < system.contacts(); ++k) {
    auto& list = c.not_matched.emplace_back();
    const auto& surface = system.contact_facts(k).surface;
    c.frictional.push_back(surface.friction.value_or(0) > 0);
    if (!(std::abs(c.penalty.contacts[k].model.restitution_delivered -
                   c.nonsmooth.contacts[k].model.restitution_delivered) < 1e-9))
      list.emplace_back("restitution as given");
    if (surface.tangential_restitution > 0 && c.frictional.back())
      list.push_back(fmt::format("the contact law ignores the tangential restitution {:.3g}",
                                 surface.tangential_restitution));
    if (c.frictional.back() &&
        facts_of(scene.penalty.friction).compliant != (scene.nonsmooth.impact_law == ImpactLaw::compliant))
      list.emplace_back("tangential compliance in one formulation only");
  }
}

/// s, period of the drive; infinite without revolutions.
double turn_of(const Result& r) { return r.revolutions > 0 ? r.observed / r.revolutions : INFINITY; }

/// Impacts of a run below which their statistics are not compared.
constexpr long fewest_impacts = 10;

/// Energy turned over in the window: the greatest of the works, the dissipation and the change of
/// the stored energy.
double turned_over(const Window& w) {
  const auto& e = w.energy;
  return std::max({std::abs(e[Window::drives]), std::abs(e[Window::loads]), std::abs(e[Window::stored]),
                   e[Window::dampers] + e[Window::contacts] + e[Window::friction] + e[Window::films]});
}

/// The prediction may take this number of evaluations, about a second, even if the runs took fewer.
constexpr long least_evaluations = 1'000'000;

/// The predicted horizon. It needs the events of the whole nonsmooth run.
void predict(const Scene& scene, const CompareSetup& setup, Comparison& c) {
  if (c.joints.empty()) return;
  if (c.nonsmooth.events_cut()) {
    c.predicted.reason = "the list of the nonsmooth run's events is truncated";
    return;
  }
  PredictionBasis basis{
      .pairing = c.pairing,
      .nonsmooth = {c.nonsmooth.events.begin(), c.nonsmooth.events.end()},
      .restitution = {},
      .end = c.nonsmooth.t_end,
      .turn = turn_of(c.penalty),
      .most_evaluations = std::max(least_evaluations, c.penalty.work.rhs + c.nonsmooth.work.rhs)};
  if (std::ranges::any_of(scene.mechanism.surfaces, &Surface::restitution_by_speed)) {
    c.predicted.reason = "restitutions depend on the approach speed";
    return;
  }
  for (const auto& contact : c.nonsmooth.contacts)
    basis.restitution.push_back(contact.model.restitution_delivered);
  try {
    c.predicted = predict_horizon(scene, basis, setup.stop);
  } catch (const Interrupted&) {
    c.predicted.reason = "interrupted";
  }
}

}  // namespace

ComparisonValues comparison_values(const Scene& scene, const Comparison& c) {
  const auto &p = c.penalty, &n = c.nonsmooth;
  ComparisonValues v;
  v.scene = scene.file.string();
  for (const auto* run : {&p, &n})
    if (run->ending.status == Ending::Status::failed)
      v.stopped += fmt::format("{}{} stopped at t = {:.4g} s", v.stopped.empty() ? "" : " and ",
                               run->formulation, run->t_end);
  auto& e = v.events;
  e.contacts = !c.joints.empty();
  e.pairs = c.pairing.pairs.size();
  e.horizon = c.pairing.horizon;
  e.to_the_end = c.pairing.complete;
  e.cut = c.pairing.cut;
  e.overlapping = c.pairing.overlapping;
  for (const auto& pair : c.pairing.pairs) {
    const auto &a = pair.penalty, &b = pair.nonsmooth;
    e.merged += pair.merged_penalty + pair.merged_nonsmooth;
    e.loaded += pair.loaded();
    e.time = std::max(e.time, std::abs(a.t - b.t));
    e.speed = std::max(e.speed, relative_difference(a.v_n_minus, b.v_n_minus));
    if (a.kind == EventKind::impact && b.kind == EventKind::impact && !pair.loaded())
      e.impulse = std::fmax(e.impulse, relative_difference(pair.impulse(), b.impulse_n));
  }
  // The share of impacts is not compared: an impact law has none.
  for (std::size_t k = 0; k < c.joints.size(); ++k) {
    const auto &a = p.contacts[k], &b = n.contacts[k];
    const bool few = std::min(a.counted_impacts, b.counted_impacts) < fewest_impacts;
    v.statistics.push_back({.name = "share of free flight of " + c.joints[k],
                            .penalty = a.flight_fraction,
                            .nonsmooth = b.flight_fraction,
                            .error = std::hypot(a.flight_error, b.flight_error),
                            .few = few});
    v.statistics.push_back(
        {.name = (p.revolutions > 0 ? "impacts per revolution of " : "impacts per second of ") + c.joints[k],
         .penalty = a.impacts_per_revolution,
         .nonsmooth = b.impacts_per_revolution,
         .error = std::hypot(a.impacts_error, b.impacts_error),
         .few = few});
    // A formulation whose onsets all begin sustained contact has no impact to compare.
    const auto sustained = [](const ContactSummary& own, const ContactSummary& other) {
      return own.impacts == 0 && own.lasting_fraction > 0 && other.impacts > 0;
    };
    if (sustained(a, b) || sustained(b, a)) {
      v.one_sided.push_back(fmt::format("{} (sustained contact in {})", c.joints[k],
                                        sustained(a, b) ? "penalty" : "nonsmooth"));
      continue;
    }
    v.approaches.push_back({c.joints[k], a.fastest_approach, b.fastest_approach});
    v.impulses.push_back({c.joints[k], a.greatest_impulse, b.greatest_impulse});
  }
  if (p.window && n.window)
    for (const auto& [term, name] : {std::pair{Window::contacts, "energy dissipated in contacts, J"},
                                     {Window::friction, "energy dissipated by friction, J"}})
      if (p.window->energy[term] != 0 || n.window->energy[term] != 0)
        v.statistics.push_back({.name = name,
                                .penalty = p.window->energy[term],
                                .nonsmooth = n.window->energy[term],
                                .error = p.window->batches > 0 && n.window->batches > 0
                                             ? std::hypot(p.window->error[term], n.window->error[term])
                                             : NAN,
                                .turnover = std::max(turned_over(*p.window), turned_over(*n.window)),
                                .transient = !(p.revolutions > 0)});
  for (const auto* run : {&p, &n})
    for (const auto& note : run->notes)
      if (is_warning(note)) {
        const auto text = note.substr(std::min(warning_prefix.size(), note.size()));
        v.doubts.push_back(
            {run->formulation, text.substr(0, text.find_first_of(";:")), text.starts_with("penetration")});
      }
  if (c.joints.empty() && p.final_state.q.size() == n.final_state.q.size()) {
    v.final_length = v.final_angle = 0;
    for (std::size_t i = 0; i < p.final_state.q.size(); ++i) {
      auto& most = i % 3 == 2 ? v.final_angle : v.final_length;
      most = std::max(most, std::abs(p.final_state.q[i] - n.final_state.q[i]));
    }
  }
  if (p.revolutions > 0)
    v.revolutions_needed = WindowStatistics::fewest + scene.run.discard / (p.observed / p.revolutions);
  const auto cost = [](const Result& r) {
    const double error = r.first_touches ? r.first_touches->greatest() : NAN;
    return CostAndError{r.cpu_seconds, std::isfinite(error) ? error : NAN};
  };
  v.penalty = cost(p);
  v.nonsmooth = cost(n);
  return v;
}

Comparison compare(const Scene& scene, const CompareSetup& setup, const std::filesystem::path& folder) {
  Comparison c;
  c.matched = setup.matched;
  const auto progress = [&](const char* which) {
    return [&setup, which](double done) {
      if (setup.on_progress) setup.on_progress(which, done);
    };
  };
  int left = 3;
  const auto run = [&](const Scene& one, const char* formulation, const char* name) {
    return run_scene(one, {.formulation = formulation,
                           .matched = setup.matched,
                           .folder = folder / name,
                           .on_progress = progress(name),
                           .stop = setup.stop,
                           .companion = true,
                           .most_output = setup.most_output,
                           .runs_alike = left--});
  };
  c.penalty = run(scene, "penalty", "penalty");
  if (c.penalty.ending.status == Ending::Status::interrupted) return c;
  c.nonsmooth = run(scene, "nonsmooth", "nonsmooth");
  if (c.nonsmooth.ending.status == Ending::Status::interrupted) return c;
  for (const auto& contact : c.penalty.contacts) c.joints.push_back(contact.name);
  if (!c.joints.empty()) {
    Scene ideal = scene;
    ideal.mechanism = idealised(scene.mechanism);
    ideal.run.start = RunOptions::Start::ideal;
    try {
      c.ideal = run(ideal, "penalty", "ideal");
    } catch (const ModelError&) {
      // A mechanism that closes only because of its clearance has no ideal motion to show.
      c.nonsmooth.notes.push_back(diagnostic<Diagnostic::no_ideal_run>());
    }
  }
  const auto known = [](const Result& r) { return r.events_cut() ? r.events.back().t : INFINITY; };
  c.pairing =
      pair_impacts({c.penalty.events.begin(), c.penalty.events.end()},
                   {c.nonsmooth.events.begin(), c.nonsmooth.events.end()}, static_cast<int>(c.joints.size()),
                   std::min(known(c.penalty), known(c.nonsmooth)), turn_of(c.penalty), c.joints);
  predict(scene, setup, c);
  find_not_matched(scene, c);
  c.verdict = verdict(comparison_values(scene, c));

  auto document = to_json(c);
  document["provenance"] = provenance(scene);
  write_file(folder / "comparison.json",
             document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  write_file(folder / "comparison.md", comparison_table(scene, c, true));
  return c;
}

nlohmann::json to_json(const Comparison& c) {
  nlohmann::json pairs = nlohmann::json::array();
  for (const auto& p : c.pairing.pairs) {
    pairs.push_back({{"joint", c.joints[p.penalty.contact]},
                     {"penalty", to_json(p.penalty)},
                     {"nonsmooth", to_json(p.nonsmooth)}});
    auto& penalty = pairs.back()["penalty"];
    penalty["impact_impulse_n_N_s"] = p.impulse();
    penalty["load_impulse_n_N_s"] = std::isnan(p.load) ? nlohmann::json() : nlohmann::json(p.load);
    penalty["merged"] = p.merged_penalty;
    pairs.back()["nonsmooth"]["impact_impulse_n_N_s"] = p.nonsmooth.impulse_n;
    pairs.back()["nonsmooth"]["merged"] = p.merged_nonsmooth;
  }
  bool restitution = true;
  nlohmann::json open = nlohmann::json::object();
  for (std::size_t k = 0; k < c.not_matched.size(); ++k) {
    if (!c.not_matched[k].empty()) open[c.joints[k]] = c.not_matched[k];
    restitution = restitution && c.not_matched[k].empty();
  }
  nlohmann::json j = {{"verdict", c.verdict},
                      {"restitution_matched", restitution},
                      {"not_matched", open},
                      {"penalty", to_json(c.penalty)},
                      {"nonsmooth", to_json(c.nonsmooth)},
                      {"pairing",
                       {{"horizon_s", c.pairing.horizon},
                        {"ended_by", c.pairing.ended_by},
                        {"predicted_horizon_s", c.predicted.t},
                        {"predicted_to_the_end", c.predicted.to_the_end},
                        {"not_predicted", c.predicted.reason},
                        {"pairs", pairs}}}};
  if (c.ideal) j["ideal"] = to_json(*c.ideal);
  return j;
}

}  // namespace freeplay
