#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "mechanism/lubricated.hpp"
#include "mechanism/scene.hpp"
#include "study/comparison/compare.hpp"
#include "values/table.hpp"

namespace freeplay {
namespace {

constexpr int joint_width = 12;          // of the table of pairs, columns
constexpr std::size_t shown_pairs = 20;  // on a terminal

std::string number(double x) { return fmt::format("{:.4g}", x); }

/// Two significant digits, without an exponent for integers: 100, 1200.
std::string two_digits(double x) {
  if (!(std::abs(x) >= 99.5 && std::abs(x) < 1e5)) return fmt::format("{:.2g}", x);
  const double unit = std::pow(10, std::floor(std::log10(std::abs(x))) - 1);
  return fmt::format("{:.0f}", std::round(x / unit) * unit);
}

/// A value below its standard error, with its own digits: 0.31 ± 4.1, (0.82 ± 1.2)e-10.
std::string below_error(double value, double error, const char* unit) {
  if (value != 0 && std::abs(value) < 0.01 * error)
    return fmt::format("{:.1g} ± {}{}", value, two_digits(error), unit);
  if (error >= 1e-3 && error < 1e5)
    return fmt::format("{} ± {}{}", two_digits(value), two_digits(error), unit);
  const int power = static_cast<int>(std::floor(std::log10(error)));
  const double scale = std::pow(10, power);
  return fmt::format("({} ± {:.1f})e{}{}", two_digits(value / scale), error / scale, power, unit);
}

/// A value with its standard error, both rounded to the first digit of the error (to the second if
/// the first is 1). Without an error: two digits, the precision of a single window.
std::string with_error(double value, double error, const char* unit = "") {
  if (!std::isfinite(error) || !std::isfinite(value)) return two_digits(value) + unit;
  if (error <= 1e-12 * std::abs(value)) return fmt::format("{:.4g} ± 0{}", value, unit);
  if (error > std::abs(value)) return below_error(value, error, unit);
  int place = static_cast<int>(std::floor(std::log10(error)));
  if (error / std::pow(10, place) < 1.95) --place;
  const double size = std::max(std::abs(value), error);
  // Small and large numbers with a power of ten.
  const int power =
      size < 1e-3 || size >= 1e5 || place > 0 ? static_cast<int>(std::floor(std::log10(size))) : 0;
  const double scale = std::pow(10, power);
  const int digits = std::max(0, power - place);
  const auto text = fmt::format("{:.{}f} ± {:.{}f}", value / scale, digits, error / scale, digits);
  return power == 0 ? text + unit : fmt::format("({})e{}{}", text, power, unit);
}
std::string percent(double value, double error) { return with_error(100 * value, 100 * error, " %"); }

/// Whether the two laws of a contact match, and their differences.
std::string matching(const Comparison& c, std::size_t k) {
  if (c.not_matched.at(k).empty()) return "matched";
  return fmt::format("NOT matched: {}", fmt::join(c.not_matched[k], "; "));
}

/// Statements about restitutions, each with the contacts to which it applies.
std::vector<std::pair<std::string, std::vector<std::string>>> restitutions(const Comparison& c) {
  std::vector<std::pair<std::string, std::vector<std::string>>> list;
  for (std::size_t k = 0; k < c.joints.size(); ++k) {
    const auto& p = c.penalty.contacts[k].model;
    const auto what = fmt::format("input {:.3g}, effective {:.4g} (contact law), {:.4g} (impact law); {}",
                                  p.restitution_asked, p.restitution_delivered,
                                  c.nonsmooth.contacts[k].model.restitution_delivered, matching(c, k));
    auto same = std::ranges::find(list, what, [](const auto& item) { return item.first; });
    if (same == list.end()) same = list.insert(list.end(), {what, {}});
    same->second.push_back(c.joints[k]);
  }
  return list;
}

/// A line with the horizon that growth of differences predicts; empty if that was not tried.
std::string predicted(const PredictedHorizon& p) {
  if (!p.reason.empty()) return "predicted horizon: none, " + p.reason + "\n";
  if (std::isnan(p.t)) return {};
  return fmt::format("predicted horizon: t = {:.4g} ms{}\n", 1e3 * p.t, p.to_the_end ? ", all events" : "");
}

/// The time over which statistics are taken, and the source of their errors.
std::string about_window(const Result& r) {
  std::string text = r.revolutions > 0 ? fmt::format("{:.4g} revolution{}", r.revolutions,
                                                     std::abs(r.revolutions - 1) < 5e-5 ? "" : "s")
                                       : fmt::format("{:.4g} s", r.observed);
  if (!r.window || r.window->batches == 0) return text + ": one window, no error bar";
  return text + fmt::format(";\n±: standard error, from {} batches of {:.3g} s{}", r.window->batches,
                            r.window->batch,
                            r.revolutions > 0 ? "" : "; none for energies of a single transient");
}

std::string tables(const Scene& scene, const Comparison& c, bool markdown) {
  std::string out = markdown ? "# " : "";
  out += (scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title) + "\n\n";
  const auto& p = c.penalty;
  const auto& n = c.nonsmooth;
  for (const auto* run : {&p, &n})
    if (run->ending.status == Ending::Status::failed)
      out +=
          fmt::format("{} STOPPED at t = {:.6g} s: {}\n\n", run->formulation, run->t_end, run->ending.reason);

  for (const auto& [what, names] : restitutions(c))
    out += fmt::format("Restitution of {}: {}\n", fmt::join(names, ", "), what);
  if (std::ranges::any_of(c.frictional, std::identity{}))
    out += fmt::format("Friction: {} (regularised) in penalty, Coulomb's set-valued law in nonsmooth\n",
                       text_of(scene.penalty.friction));
  if (!c.joints.empty()) out += "\n";

  Table t({"", "penalty", "nonsmooth"});
  const auto line = [&](const std::string& name, auto get) { t.row(name, get(p), get(n)); };
  for (std::size_t k = 0; k < c.joints.size(); ++k) {
    const auto of = [&](auto field) { return [&, field](const Result& r) { return field(r.contacts[k]); }; };
    const auto& name = c.joints[k];
    line(name + (lubricated(scene.mechanism, name) ? ": on the film" : ": free flight"),
         of([](const auto& x) { return percent(x.flight_fraction, x.flight_error); }));
    line(name + ": in impacts", of([](const auto& x) { return percent(x.impact_fraction, x.impact_error); }));
    line(name + ": sustained contact",
         of([](const auto& x) { return percent(x.lasting_fraction, x.lasting_error); }));
    line(name + (p.revolutions > 0 ? ": impacts per revolution *" : ": impacts per second *"),
         of([](const auto& x) { return with_error(x.impacts_per_revolution, x.impacts_error); }));
    line(name + ": fastest approach, m/s", of([](const auto& x) { return number(x.fastest_approach); }));
    line(name + ": greatest impulse of an impact, N s ***",
         of([](const auto& x) { return number(x.greatest_impulse); }));
    line(name + ": greatest penetration / " + p.contacts[k].measure + " **",
         of([](const auto& x) { return number(x.penetration_ratio); }));
  }
  line("greatest constraint violation, m **",
       [](const auto& r) { return number(r.extremes.constraint_length); });
  line("greatest constraint violation, rad **",
       [](const auto& r) { return number(r.extremes.constraint_angle); });
  const auto energy = [&](Window::Term term, const char* what, bool always) {
    const auto of = [&](const Result& r) { return r.window ? r.window->energy[term] : 0; };
    if (always || of(p) != 0 || of(n) != 0)
      line(fmt::format("energy: {}, J", what), [&](const Result& r) {
        const bool sampled = r.window && r.window->batches > 0 && r.revolutions > 0;
        return with_error(of(r), sampled ? r.window->error[term] : NAN);
      });
  };
  energy(Window::drives, "work of drives", true);
  energy(Window::loads, "work of loads", false);
  energy(Window::contacts, "dissipated in contacts", true);
  energy(Window::friction, "dissipated by friction", true);
  energy(Window::dampers, "dissipated in dampers", false);
  energy(Window::films, "dissipated in films", false);
  energy(Window::stored, "stored", true);
  energy(Window::stabilisation, "work of stabilisation", true);
  line("energy: closure of the balance, whole run, J",
       [](const auto& r) { return number(r.ledger.closure()); });
  line("steps", [](const auto& r) { return fmt::format("{}", r.work.steps); });
  line("right-hand sides", [](const auto& r) { return fmt::format("{}", r.work.rhs); });
  line("complementarity problems", [](const auto& r) { return fmt::format("{}", r.work.lcp_solves); });
  line("CPU time, s", [](const auto& r) { return number(r.cpu_seconds); });
  out += markdown ? t.markdown() : t.terminal({43, 17, 17}, true);
  out += fmt::format("{}{}statistics and energies after {:.4g} s, over {}\n", markdown ? "\n" : "",
                     c.joints.empty() ? "" : "* approach speed above 10 % of the maximum; ",
                     scene.run.discard, about_window(p));
  out += fmt::format("{} over the whole run (validity check)\n", markdown ? "\\*\\*" : "**");
  if (!c.joints.empty())
    out += fmt::format("{} in penalty with the load during the impact\n", markdown ? "\\*\\*\\*" : "***");
  for (const auto* run : {&p, &n})
    for (const auto& note : run->notes) out += fmt::format("{}: {}\n", run->formulation, note);
  if (c.joints.empty()) return out;
  if (c.pairing.pairs.empty()) return out + fmt::format("\nNo impacts are paired: {}\n", c.pairing.ended_by);

  out +=
      fmt::format("\n{}Impacts paired up to the horizon t = {:.6g} ms;\n{}\n{}{}", markdown ? "## " : "",
                  1e3 * c.pairing.horizon, c.pairing.ended_by, predicted(c.predicted), markdown ? "\n" : "");
  Table pairs({"joint", "t pen. ms", "nonsmooth", "diff us", "v pen.", "nonsm.", "P pen.", "nonsm."});
  const std::string* previous = nullptr;
  for (const auto& x : c.pairing.pairs) {
    if (!markdown && pairs.rows().size() == shown_pairs) break;
    const auto impulse = [](const ContactEvent& e, double value, bool loaded) {
      return e.kind != EventKind::impact ? "lasting" : loaded ? "loaded" : fmt::format("{:.5f}", value);
    };
    const auto& name = c.joints[x.penalty.contact];
    // On a terminal, a name that needs a line of its own is printed once for consecutive pairs.
    const bool repeated =
        !markdown && name.size() >= std::size_t{joint_width} && previous && *previous == name;
    previous = &name;
    pairs.row(repeated ? "" : name, fmt::format("{:.5f}", 1e3 * x.penalty.t),
              fmt::format("{:.5f}", 1e3 * x.nonsmooth.t),
              fmt::format("{:.2f}", 1e6 * (x.nonsmooth.t - x.penalty.t)),
              fmt::format("{:.5f}", -x.penalty.v_n_minus), fmt::format("{:.5f}", -x.nonsmooth.v_n_minus),
              impulse(x.penalty, x.impulse(), x.loaded()),
              impulse(x.nonsmooth, x.nonsmooth.impulse_n, false));
  }
  out += markdown ? pairs.markdown() + "\n" : pairs.terminal({joint_width - 1, 11, 11, 11, 9, 9, 9, 8}, true);
  if (const auto all = c.pairing.pairs.size(); pairs.rows().size() < all)
    out += fmt::format("... {} more in comparison.md\n", all - shown_pairs);
  return out +
         "v: approach speed, m/s; P: normal impulse, N s, without the "
         "load during the impact (loaded: the load exceeds it)\n";
}

}  // namespace

std::string comparison_table(const Scene& scene, const Comparison& c, bool markdown) {
  auto out = tables(scene, c, markdown);
  if (markdown && !c.verdict.empty()) out += "\n## Verdict\n\n" + c.verdict + "\n";
  return out;
}

}  // namespace freeplay
