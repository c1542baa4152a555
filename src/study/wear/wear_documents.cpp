#include "study/wear/wear_documents.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "io/files/output_file.hpp"
#include "study/wear/worn_profile.hpp"

namespace freeplay {
namespace {

constexpr double two_sided = 1.96;  // standard errors of a 95 % interval

/// m, half of the 95 % interval of a depth.
double error_of(const WornDepth& d) { return two_sided * d.statistical + d.extrapolation; }
double error_of(const WornJoint& j) { return error_of(j.in_bearing) + error_of(j.in_journal); }

std::string micrometres(double x) { return fmt::format("{:.4g}", 1e6 * x); }

/// The error of a depth in um, at least one unit of the last digit of micrometres().
std::string error_in_micrometres(const WornDepth& d) {
  const double unit = d.depth > 0 ? std::pow(10, std::floor(std::log10(d.depth)) - 3) : 0;
  return fmt::format("{:.2g}", 1e6 * std::max(error_of(d), unit));
}

/// A number of turns: 1234, 1.234e+06.
std::string in_turns(double n) {
  return n >= 100 && n < 1e5 ? fmt::format("{:.0f}", n) : fmt::format("{:.4g}", n);
}

const char* limit_of(WearEnd end) {
  switch (end) {
    case WearEnd::turns:
      return "turns";
    case WearEnd::depth:
      return "depth";
    case WearEnd::clearance:
      return "clearance";
    case WearEnd::no_load:
      return "no load";
    case WearEnd::failed:
      return "failure";
  }
  return "";
}

/// "X ± Y um (penalty) and X ± Y um (nonsmooth)"
std::string depths(const WearStudy& all, std::size_t j, WornDepth WornJoint::*which) {
  std::vector<std::string> parts;
  for (const auto& h : all.histories) {
    const auto& d = h.cycles.back().joints[j].*which;
    parts.push_back(
        fmt::format("{} ± {} um ({})", micrometres(d.depth), error_in_micrometres(d), h.formulation));
  }
  return fmt::format("{}", fmt::join(parts, " and "));
}

/// Growth of a clearance.
struct Growth {
  double turns, grown, error;  // m
};

/// The exponent β of a growth with N^β turns between two cycles; 1 if there was none, or none of it.
double exponent_of(const Growth& a, const Growth& b) {
  if (!(a.turns > 0 && b.turns > a.turns && a.grown > 0 && b.grown > a.grown)) return 1;
  return std::log(b.grown / a.grown) / std::log(b.turns / a.turns);
}

std::string life_in_words(const WearHistory& h, std::size_t j, double clearance) {
  const auto life = life_of(h, j, clearance);
  if (std::isinf(life.turns)) return fmt::format("is not reached ({})", h.formulation);
  const auto range = std::isinf(life.high) ? fmt::format("from {} on", in_turns(life.low))
                                           : fmt::format("{} to {}", in_turns(life.low), in_turns(life.high));
  return fmt::format("is reached after {} turns{} ({}; {}{})", in_turns(life.turns),
                     life.extrapolated ? ", extrapolated" : "", h.formulation,
                     life.extrapolated ? "by the last rate and by a power of the turns " : "95 % interval ",
                     range);
}

}  // namespace

WearLife life_of(const WearHistory& history, std::size_t j, double clearance) {
  enum class Shape { linear, power };
  std::vector<Growth> points;
  const double begin = history.cycles.front().joints[j].bearing.measured_clearance(),
               sought = clearance - begin;
  for (const auto& c : history.cycles)
    points.push_back({c.turns, c.joints[j].bearing.measured_clearance() - begin, error_of(c.joints[j])});
  const std::size_t last = points.size() - 1;
  // Turns at which the growth with `sign` errors is the sought one.
  const auto crossing = [&](double sign, Shape shape) {
    const auto grown = [&](std::size_t i) {
      return Growth{points[i].turns, points[i].grown + sign * points[i].error, 0};
    };
    if (grown(0).grown >= sought) return points[0].turns;
    for (std::size_t i = 1; i <= last; ++i) {
      const auto from = grown(i - 1), to = grown(i);
      if (to.grown < sought) continue;
      const double share = (sought - from.grown) / (to.grown - from.grown);
      // Of the first cycle, with the exponent of the second one.
      const double exponent = exponent_of(points[std::max<std::size_t>(i, 2) - 1],
                                          points[std::min(std::max<std::size_t>(i, 2), last)]);
      return shape == Shape::linear
                 ? std::lerp(from.turns, to.turns, share)
                 : std::clamp(to.turns * std::pow(sought / to.grown, 1 / exponent), from.turns, to.turns);
    }
    if (last == 0) return WearLimits::none;
    const auto& end = points[last];
    const double rate = (end.grown - points[last - 1].grown) / (end.turns - points[last - 1].turns);
    if (!(rate > 0 && end.grown > 0)) return WearLimits::none;
    const double share = grown(last).grown / end.grown;  // the relative error of all growth
    if (!(share > 0)) return WearLimits::none;
    if (shape == Shape::linear) return end.turns + (sought / share - end.grown) / rate;
    // The exponent of the second half of the turns.
    std::size_t half = last - 1;
    while (half > 1 && points[half].turns > 0.5 * end.turns) --half;
    return end.turns * std::pow(sought / (share * end.grown), 1 / exponent_of(points[half], end));
  };
  WearLife life{clearance, crossing(0, Shape::power), WearLimits::none, 0, false};
  for (const auto shape : {Shape::linear, Shape::power}) {
    life.low = std::min(life.low, crossing(1, shape));
    life.high = std::max(life.high, crossing(-1, shape));
  }
  life.extrapolated = life.turns > points[last].turns * (1 + 1e-9);
  if (life.extrapolated && last == 1) life.high = WearLimits::none;  // one rate tells no change of the rate
  return life;
}

Table wear_table(const WearStudy& all) {
  Table table(
      "formulation,joint,cycle,turns,cycle_turns,bearing_depth,bearing_depth_statistical,"
      "bearing_depth_extrapolation,journal_depth,journal_depth_statistical,journal_depth_extrapolation,"
      "bearing_area,journal_area,bearing_volume,journal_volume,clearance,clearance_greatest,work_per_turn,"
      "work_per_turn_error");
  for (const auto& h : all.histories)
    for (std::size_t j = 0; j < all.lengths.size(); ++j)
      for (const auto& c : h.cycles) {
        const auto& w = c.joints[j];
        const auto& b = w.bearing;
        const double bearing = b.bearing_area(), journal = b.journal_area(), length = all.lengths[j];
        table.row(h.formulation, b.joint().name, c.number, c.turns, c.length, w.in_bearing.depth,
                  w.in_bearing.statistical, w.in_bearing.extrapolation, w.in_journal.depth,
                  w.in_journal.statistical, w.in_journal.extrapolation, bearing, journal, bearing * length,
                  journal * length, b.measured_clearance(), b.greatest_clearance(), w.work, w.error);
      }
  return table;
}

Table profiles_table(const WearStudy& all) {
  Table table("formulation,joint,cycle,turns,angle,bearing_depth,journal_depth");
  for (const auto& h : all.histories)
    for (std::size_t j = 0; j < all.lengths.size(); ++j)
      for (const auto& c : h.cycles) {
        const auto& b = c.joints[j].bearing;
        const auto bearing = b.bearing_depth(), journal = b.journal_depth();
        for (std::size_t k = 0; k < bearing.size(); ++k)
          table.row(h.formulation, b.joint().name, c.number, c.turns,
                    2 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(bearing.size()),
                    bearing[k], journal.empty() ? 0.0 : journal[k]);
      }
  return table;
}

std::vector<ProfileFile> profile_files(const WearStudy& all) {
  std::vector<ProfileFile> files;
  for (const auto& h : all.histories)
    for (const auto& joint : h.cycles.back().joints) {
      const auto profiles = worn_profiles(joint.bearing);
      const auto& name = joint.bearing.joint().name;
      for (const auto& [surface, profile] :
           {std::pair("bearing", &profiles.bearing), std::pair("journal", &profiles.journal)}) {
        if (!*profile) continue;
        auto& file = files.emplace_back(
            ProfileFile{fmt::format("profile_{}_{}_{}.csv", surface, safe_name(name), h.formulation),
                        Table("angle,deviation")});
        for (const auto& [angle, deviation] : (*profile)->points) file.points.row(angle, deviation);
      }
    }
  return files;
}

nlohmann::json to_json(const WearPlan& plan, const WearStudy& all) {
  auto results = nlohmann::json::array();
  for (const auto& h : all.histories)
    for (std::size_t j = 0; j < all.lengths.size(); ++j) {
      const auto& last = h.cycles.back();
      const auto& w = last.joints[j];
      const auto depth = [](const WornDepth& d) {
        return nlohmann::json{
            {"depth_m", d.depth}, {"statistical_m", d.statistical}, {"extrapolation_m", d.extrapolation}};
      };
      nlohmann::json one = {{"formulation", h.formulation},
                            {"joint", w.bearing.joint().name},
                            {"bearing_radius_m", w.bearing.joint().foundation.bearing_radius},
                            {"nominal_clearance_m", w.bearing.joint().foundation.clearance},
                            {"length_m", all.lengths[j]},
                            {"turns", last.turns},
                            {"cycles", last.number},
                            {"ended_by", limit_of(h.end)},
                            {"bearing", depth(w.in_bearing)},
                            {"journal", depth(w.in_journal)},
                            {"bearing_area_m2", w.bearing.bearing_area()},
                            {"journal_area_m2", w.bearing.journal_area()},
                            {"clearance_m", w.bearing.measured_clearance()},
                            {"greatest_clearance_m", w.bearing.greatest_clearance()},
                            {"rounding_m", h.rounding}};
      if (plan.life_clearance) {
        const auto life = life_of(h, j, *plan.life_clearance);
        const auto finite = [](double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json(); };
        one["life"] = {{"clearance_m", life.clearance},
                       {"turns", finite(life.turns)},
                       {"low", finite(life.low)},
                       {"high", finite(life.high)},
                       {"extrapolated", life.extrapolated}};
      }
      results.push_back(std::move(one));
    }
  return {{"wear",
           {{"results", results},
            {"verdict", conclusion(plan, all)},
            {"turn_s", all.turn},
            {"turn_is_a_period", all.has_period},
            {"simulated_turns", all.simulated},
            {"starts", all.starts},
            {"share", plan.share},
            {"points", plan.points},
            {"failures", all.failures}}}};
}

std::string conclusion(const WearPlan& plan, const WearStudy& all) {
  std::string text;
  for (std::size_t j = 0; j < all.lengths.size(); ++j) {
    const auto& first = all.histories.front().cycles.back();
    const auto& facts = first.joints[j].bearing.joint();
    std::vector<std::string> after;
    for (const auto& h : all.histories) after.push_back(in_turns(h.cycles.back().turns));
    const bool alike = std::ranges::count(after, after.front()) == static_cast<long>(after.size());
    text += fmt::format("After {} {}", alike ? after.front() : fmt::format("{}", fmt::join(after, " and ")),
                        all.has_period ? "turns" : "runs of the evaluated time");
    if (facts.bearing > 0)
      text +=
          fmt::format(" the bearing of {} is worn by {}", facts.name, depths(all, j, &WornJoint::in_bearing));
    if (facts.journal > 0)
      text += fmt::format("{} the journal of {} is worn by {}", facts.bearing > 0 ? ", and" : "", facts.name,
                          depths(all, j, &WornJoint::in_journal));
    text += ".";
    if (plan.life_clearance) {
      text += fmt::format(" A clearance of {} um", micrometres(*plan.life_clearance));
      for (const char* link = " "; const auto& h : all.histories)
        text += std::exchange(link, ", and it ") + life_in_words(h, j, *plan.life_clearance);
      text += ".";
    }
    text += "\n";
  }
  for (const auto& h : all.histories)
    if (h.end == WearEnd::no_load)
      text += fmt::format("No joint that wears is loaded while it slides ({}): nothing wears{}.\n",
                          h.formulation, h.cycles.size() > 1 ? " any more" : "");
  return text;
}

std::string wear_page(const Study& study, const WearStudy& all) {
  Table table(
      "joint,formulation,turns,cycles,bearing um,± um,journal um,± um,volume mm³,clearance um,greatest um");
  for (std::size_t j = 0; j < all.lengths.size(); ++j)
    for (const auto& h : all.histories) {
      const auto& last = h.cycles.back();
      const auto& w = last.joints[j];
      table.row(
          w.bearing.joint().name, h.formulation, in_turns(last.turns), last.number,
          micrometres(w.in_bearing.depth), error_in_micrometres(w.in_bearing),
          micrometres(w.in_journal.depth), error_in_micrometres(w.in_journal),
          fmt::format("{:.4g}", 1e9 * all.lengths[j] * (w.bearing.bearing_area() + w.bearing.journal_area())),
          micrometres(w.bearing.measured_clearance()), micrometres(w.bearing.greatest_clearance()));
    }
  return fmt::format(
      "# Wear: {}\n\n{}\n{}\n"
      "Depths are the greatest ones, ± 1.96 standard errors and the extrapolation error, at least a unit of the "
      "last digit. The clearance is half of the greatest free movement of the journal; the greatest one adds both "
      "depths to the nominal clearance. Each set of runs has {} starts of {:.4g} turns; surfaces of the runs are "
      "rounded by at most {:.2g} um.\n",
      study.title.empty() ? study.file.stem().string() : study.title, conclusion(*study.wear, all),
      table.markdown(), all.starts, all.simulated,
      1e6 * std::ranges::max(all.histories, {}, &WearHistory::rounding).rounding);
}

}  // namespace freeplay
