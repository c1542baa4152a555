#include <fmt/format.h>

#include <cmath>

#include "model/scene.hpp"
#include "study/compare.hpp"

namespace freeplay {
namespace {

/// Rows of text cells, laid out for a terminal or as Markdown.
class Table {
 public:
  Table(bool markdown, std::vector<int> widths) : markdown_(markdown), widths_(std::move(widths)) {}
  void head(const std::vector<std::string>& cells) {
    row(cells);
    std::string rule = markdown_ ? "|" : "";
    for (int w : widths_)
      rule += markdown_ ? " --- |" : std::string(static_cast<std::size_t>(w - 1), '-') + " ";
    while (rule.back() == ' ') rule.pop_back();
    text += rule + "\n";
  }
  void row(const std::vector<std::string>& cells) {
    if (markdown_) text += "|";
    for (std::size_t i = 0; i < cells.size(); ++i) {
      if (markdown_)
        text += " " + cells[i] + " |";
      else
        text += i == 0 ? fmt::format("{:<{}}", cells[i], widths_[i])
                       : fmt::format("{:>{}} ", cells[i], widths_[i] - 1);
    }
    while (!text.empty() && text.back() == ' ') text.pop_back();
    text += "\n";
  }
  std::string text;

 private:
  bool markdown_;
  std::vector<int> widths_;
};

std::string number(double x) { return fmt::format("{:.4g}", x); }
std::string percent(double x) { return fmt::format("{:.2f} %", 100 * x); }

}  // namespace

std::string comparison_table(const Scene& scene, const Comparison& c, bool markdown) {
  std::string out = markdown ? "# " : "";
  out += (scene.mechanism.title.empty() ? scene.file.string() : scene.mechanism.title) + "\n\n";
  const auto& p = c.penalty;
  const auto& n = c.nonsmooth;
  for (const auto* run : {&p, &n})
    if (run->ending.status == Ending::Status::failed)
      out +=
          fmt::format("{} STOPPED at t = {:.6g} s: {}\n\n", run->formulation, run->t_end, run->ending.reason);

  for (std::size_t k = 0; k < c.joints.size(); ++k) {
    const double asked = p.contacts[k].model.restitution_asked,
                 ep = p.contacts[k].model.restitution_delivered,
                 en = n.contacts[k].model.restitution_delivered;
    out += fmt::format(
        "Restitution of {}: asked {:.3g}; delivered by the contact law {:.4g},\nby the impact law {:.4g} "
        "({})\n",
        c.joints[k], asked, ep, en, std::abs(ep - en) < 1e-9 ? "matched" : "NOT matched: as given");
  }
  if (!c.joints.empty()) out += "\n";

  Table t(markdown, {44, 17, 17});
  t.head({"", "penalty", "nonsmooth"});
  const auto line = [&](const std::string& name, auto get) { t.row({name, get(p), get(n)}); };
  for (std::size_t k = 0; k < c.joints.size(); ++k) {
    const auto of = [&](auto field) { return [&, field](const Result& r) { return field(r.contacts[k]); }; };
    const auto& name = c.joints[k];
    line(name + ": free flight", of([](const auto& x) { return percent(x.flight_fraction); }));
    line(name + ": in impacts", of([](const auto& x) { return percent(x.impact_fraction); }));
    line(name + ": lasting contact", of([](const auto& x) { return percent(x.lasting_fraction); }));
    line(name + (p.revolutions > 0 ? ": impacts per revolution *" : ": impacts per second *"),
         of([](const auto& x) { return number(x.impacts_per_revolution); }));
    line(name + ": fastest approach, m/s", of([](const auto& x) { return number(x.fastest_approach); }));
    line(name + ": greatest impulse of an impact, N s",
         of([](const auto& x) { return number(x.greatest_impulse); }));
    line(name + ": greatest penetration / " + p.contacts[k].measure,
         of([](const auto& x) { return number(x.penetration_ratio); }));
  }
  line("greatest constraint violation, m",
       [](const auto& r) { return number(r.extremes.constraint_length); });
  line("greatest constraint violation, rad",
       [](const auto& r) { return number(r.extremes.constraint_angle); });
  line("energy: work of drives, J", [](const auto& r) { return number(r.ledger.drive); });
  if (p.ledger.load != 0 || n.ledger.load != 0)
    line("energy: work of loads, J", [](const auto& r) { return number(r.ledger.load); });
  line("energy: dissipated in contacts, J", [](const auto& r) { return number(r.ledger.contact); });
  line("energy: dissipated by friction, J", [](const auto& r) { return number(r.ledger.friction); });
  if (p.ledger.damping != 0 || n.ledger.damping != 0)
    line("energy: dissipated in dampers, J", [](const auto& r) { return number(r.ledger.damping); });
  if (p.ledger.film != 0)
    line("energy: dissipated in films, J", [](const auto& r) { return number(r.ledger.film); });
  line("energy: stored (change since start), J", [](const auto& r) {
    return number(r.ledger.kinetic + r.ledger.potential + r.ledger.elastic - r.ledger.initial);
  });
  line("energy: work of stabilisation, J", [](const auto& r) { return number(r.ledger.stabilisation); });
  line("energy: closure of the balance, J", [](const auto& r) { return number(r.ledger.closure()); });
  line("steps", [](const auto& r) { return fmt::format("{}", r.work.steps); });
  line("right-hand sides", [](const auto& r) { return fmt::format("{}", r.work.rhs); });
  line("complementarity problems", [](const auto& r) { return fmt::format("{}", r.work.lcp_solves); });
  line("CPU time, s", [](const auto& r) { return number(r.cpu_seconds); });
  out += t.text;
  if (!c.joints.empty())
    out += fmt::format("{}* faster than a tenth of the fastest; statistics after {:.4g} s, over {}\n",
                       markdown ? "\n" : "", scene.run.discard,
                       p.revolutions > 0 ? fmt::format("{:.4g} revolutions", p.revolutions)
                                         : fmt::format("{:.4g} s", p.t_end - scene.run.discard));
  for (const auto* run : {&p, &n})
    for (const auto& note : run->notes) out += fmt::format("{}: {}\n", run->formulation, note);
  if (c.joints.empty()) return out;
  if (c.pairing.pairs.empty()) return out + fmt::format("\nNo impacts are paired: {}\n", c.pairing.ended_by);

  out +=
      fmt::format("\n{}Impacts paired up to the horizon t = {:.6g} ms, where\n{}\n{}", markdown ? "## " : "",
                  1e3 * c.pairing.horizon, c.pairing.ended_by, markdown ? "\n" : "");
  Table pairs(markdown, {12, 11, 11, 11, 9, 9, 9, 8});
  pairs.head({"joint", "t pen. ms", "nonsmooth", "diff us", "v pen.", "nonsm.", "P pen.", "nonsm."});
  std::size_t shown = 0;
  for (const auto& x : c.pairing.pairs) {
    if (!markdown && ++shown > 20) {
      pairs.text += fmt::format("... {} more in comparison.md\n", c.pairing.pairs.size() - 20);
      break;
    }
    const auto impulse = [](const ContactEvent& e) {
      return e.kind == EventKind::impact ? fmt::format("{:.5f}", e.impulse_n) : std::string("lasting");
    };
    pairs.row({c.joints[x.penalty.contact], fmt::format("{:.5f}", 1e3 * x.penalty.t),
               fmt::format("{:.5f}", 1e3 * x.nonsmooth.t),
               fmt::format("{:.2f}", 1e6 * (x.nonsmooth.t - x.penalty.t)),
               fmt::format("{:.5f}", -x.penalty.v_n_minus), fmt::format("{:.5f}", -x.nonsmooth.v_n_minus),
               impulse(x.penalty), impulse(x.nonsmooth)});
  }
  return out + pairs.text + (markdown ? "\n" : "") + "v: approach speed, m/s; P: normal impulse, N s\n";
}

}  // namespace freeplay
