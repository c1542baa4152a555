#include "analysis/play/play.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "analysis/play/held_drives.hpp"
#include "analysis/play/loose_mechanism.hpp"
#include "analysis/play/play_documents.hpp"
#include "analysis/play/play_extremes.hpp"
#include "analysis/play/play_loads.hpp"
#include "analysis/play/play_statistics.hpp"
#include "analysis/play/point_region.hpp"
#include "dynamics/assembly/assembly.hpp"
#include "io/scene/scene_text.hpp"
#include "mechanism/error.hpp"
#include "mechanism/scene.hpp"

namespace freeplay {
namespace {

/// Follows the ideal pose q from t to `end` on its branch: false where the mechanism does not close any
/// further, with t and q at the last position that closes.
bool follow(LooseMechanism& mechanism, bool slides, double end, double& t, Eigen::VectorXd& q) {
  // Smooth motion needs no step below `closest` times the length or a radian: there is a dead centre or a point at
  // which branches meet.
  constexpr double longest = 0.1, farthest = 0.2, closest = 1e-4;
  const Eigen::VectorXd middle = Eigen::VectorXd::Zero(mechanism.size());
  LooseMechanism::Equations f;
  DenseLu factors;
  if (!mechanism.close(middle, t, q, f, factors)) return false;
  Eigen::VectorXd rate(mechanism.n());
  double h = end - t;
  const double span = std::max(std::abs(h), 1e-3), unit = slides ? mechanism.length() : 1;
  while (t != end) {
    if (constexpr double same = 1e-9; std::abs(end - t) <= same * span)
      return mechanism.close(middle, t = end, q, f, factors);
    const int sign = factors.sign();
    factors.solve(f.by_t, rate);
    for (int c = 0; c < mechanism.n(); ++c)
      if (c % 3 == 2 && std::abs(rate[c] * h) > longest) h = std::copysign(longest / std::abs(rate[c]), h);
    h = std::abs(h) > std::abs(end - t) ? end - t : h;
    for (int halvings = 0;; h /= 2, ++halvings) {
      if (halvings > 0 && std::abs(h) < closest * unit) return false;
      Eigen::VectorXd trial = q - h * rate;
      const Eigen::VectorXd expected = trial;
      LooseMechanism::Equations g;
      DenseLu other;
      const double next = h == end - t ? end : t + h;
      if (mechanism.close(middle, next, trial, g, other) && other.sign() == sign &&
          (trial - expected).norm() <= farthest * (h * rate).norm() + 1e-9 * mechanism.length()) {
        t = next, q = trial, f = g, factors = other;
        break;
      }
    }
    h *= 2;
  }
  return true;
}

/// The numbers with tolerances, each at two deviations: at the limits, or at half of the other one where a limit is
/// the stated value.
std::vector<VariedNumber> varied_numbers(const Scene& scene, int over) {
  std::vector<VariedNumber> list;
  for (const auto& tolerance : scene.tolerances) {
    const Parameter number(scene, tolerance.key);
    const double low = tolerance.least(), high = tolerance.upper;
    auto& x = list.emplace_back();
    x.tolerance = tolerance;
    x.deviations = {low != 0 ? low : high / 2, high != 0 ? high : low / 2};
    for (std::size_t i = 0; i < x.deviations.size(); ++i)
      x.mechanisms[i] = held(number.at(number.value() + x.deviations[i]).mechanism, over, {});
  }
  return list;
}

/// The parts of the components in both deviations.
std::vector<double> parts_of(const LooseMechanism& mechanism, const Eigen::VectorXd& ideal,
                             const PlayExtreme& most, const PlayExtreme& least, double width) {
  std::vector<double> parts;
  double sum = 0;
  for (const auto& c : mechanism.components()) {
    const auto a = ideal.segment(c.first, c.size());
    const double part =
        0.5 * ((a + most.a.segment(c.first, c.size())).dot(most.u.segment(c.first, c.size())) +
               (least.a.segment(c.first, c.size()) - a).dot(least.u.segment(c.first, c.size())));
    parts.push_back(part), sum += part;
  }
  for (auto& part : parts) part *= sum != 0 ? width / sum : 0;
  return parts;
}

PlayRange range_of(LooseMechanism& mechanism, PlayExtremes& extremes, int k, Eigen::VectorXd& up,
                   Eigen::VectorXd& down, const PlaySampling& sampling) {
  PlayRange range;
  const auto output = linear_output(mechanism, extremes, k);
  range.ideal = output.value;
  for (const auto& c : mechanism.components()) range.linear += output.a.segment(c.first, c.size()).norm();
  range.variance = variance_shares(mechanism, sampling.place, output);
  const auto most = extremes.greatest(k, 1, up), least = extremes.greatest(k, -1, down);
  up = most.u, down = least.u;
  range.greatest = most.value, range.bound_greatest = most.bound;
  range.least = -least.value, range.bound_least = -least.bound;
  range.settled = most.settled && least.settled;
  range.at_greatest.assign(most.q.begin(), most.q.end());
  range.at_least.assign(least.q.begin(), least.q.end());
  range.parts = parts_of(mechanism, output.a, most, least, range.width());
  if (sampling.samples > 0) range.quantiles = play_quantiles(mechanism, extremes, k, sampling, output);
  return range;
}

std::string joint_unit(const Play& play) { return play.slides ? "m" : "rad"; }

std::string title_of(const PlayClearance& c) { return c.part.empty() ? c.joint : c.joint + "." + c.part; }

/// The position of the widest range of a quantity; null if all are refused.
const PlayPosition* widest(const Play& play, std::size_t k) {
  const PlayPosition* found = nullptr;
  for (const auto& p : play.positions)
    if (p.refusal.empty() && (!found || p.ranges[k].width() > found->ranges[k].width())) found = &p;
  return found;
}

void refuse_wrong(const PlayOptions& options) {
  constexpr int fewest = 100, most = 10'000'000;
  const int samples = options.sampling.samples;
  if (options.quantities.empty()) throw ModelError("quantities", "at least one output is needed");
  if (!std::isfinite(options.from) || !std::isfinite(options.to))
    throw ModelError("over", "the first and the last position must be finite");
  if (options.points < 1) throw ModelError("points", "must be 1 or greater");
  if (samples != 0 && (samples < fewest || samples > most))
    throw ModelError("samples", fmt::format("must be 0 or between {} and {}", fewest, most));
}

}  // namespace

std::vector<std::pair<std::string, double>> by_joint(const Play& play, const std::vector<double>& parts) {
  std::vector<std::pair<std::string, double>> list;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const auto joints = play.components.size();
    const auto& name = k < joints ? play.components[k].joint : play.tolerances[k - joints].key;
    if (!list.empty() && list.back().first == name)
      list.back().second += parts[k];
    else
      list.emplace_back(name, parts[k]);
  }
  return list;
}

Play find_play(const Scene& scene, const PlayOptions& options) {
  refuse_wrong(options);
  const auto& m = scene.mechanism;
  Play play;
  play.sampled = options.sampling.samples > 0;
  std::vector<OutputQuantity> quantities;
  for (const auto& name : options.quantities) quantities.push_back(output_quantity(m, name));
  play.quantities.assign(quantities.begin(), quantities.end());
  const auto driven = driven_joint(m, options.over);
  if (driven.joint >= 0) {
    const auto& joint = m.joints[static_cast<std::size_t>(driven.joint)];
    play.joint = name_of(joint);
    play.slides = std::holds_alternative<TranslationalJoint>(joint);
  }
  if (!m.contacts.empty() || !m.groups.empty())
    play.notes.emplace_back("contacts outside joints do not limit the positions");
  const auto fixed = held(m, driven.joint, {});
  // The branch of the assembly is that of a run.
  using Start = RunOptions::Start;
  const auto start =
      assemble(m, scene.run.start == Start::ideal ? Start::ideal : Start::assembled, nullptr, options.stop);
  double t = driven.start;
  std::vector<VariedNumber> varied;
  if (play.sampled)
    varied = varied_numbers(scene, driven.joint);
  else if (!scene.tolerances.empty())
    play.notes.emplace_back("tolerances have an effect on quantiles only; give --samples");
  LooseMechanism mechanism(fixed, quantities, start.q, t, varied);
  for (const auto& x : mechanism.tolerances())
    play.tolerances.push_back({x.key, x.least(), x.upper, std::string(text_of(x.distribution))});
  if (mechanism.size() == 0)
    throw ModelError("joints",
                     "no joint has clearance; give `clearance` to a revolute, translational, slot, "
                     "gear or rack joint");
  play.components.assign(mechanism.components().begin(), mechanism.components().end());
  for (std::size_t k = 0; k < play.quantities.size(); ++k)
    if (play.quantities[k].kind == PlayOutput::Kind::distance && !mechanism.differentiable(start.q, t))
      throw ModelError("--of", play.quantities[k].name +
                                   " is 0 at the start, where a distance has no derivative; "
                                   "give the coordinates of the points");
  PlayExtremes extremes(mechanism);
  Eigen::VectorXd q = Eigen::Map<const Eigen::VectorXd>(start.q.data(), mechanism.n());
  std::vector<Eigen::VectorXd> up(play.quantities.size()), down(play.quantities.size());
  const int points = options.over.empty() ? 1 : options.points;
  for (int i = 0; i < points; ++i) {
    if (options.stop()) throw Interrupted();
    const double place = options.over.empty() ? t
                         : points == 1        ? options.from
                                              : options.from + (options.to - options.from) * i / (points - 1);
    if (!follow(mechanism, play.slides, place, t, q))
      throw ModelError("--over",
                       fmt::format("{} cannot be moved from {:.6g} to {:.6g} {}: the mechanism is at a dead "
                                   "centre or does not close beyond {:.6g} {}",
                                   play.joint, driven.start, place, joint_unit(play), t, joint_unit(play)));
    PlayPosition at;
    at.coordinate = place;
    const auto& region = extremes.enclose(q, t);
    at.refusal = region.refusal;
    at.pose.assign(region.q.begin(), region.q.end());
    if (at.refusal.empty())
      for (std::size_t k = 0; k < play.quantities.size(); ++k)
        at.ranges.push_back(
            range_of(mechanism, extremes, static_cast<int>(k), up[k], down[k], options.sampling));
    // Near a dead centre the second derivatives may have no bound.
    if (std::ranges::any_of(at.ranges, [](const auto& r) { return !std::isfinite(r.gap()); })) {
      at.ranges.clear();
      at.refusal = no_bound;
    }
    play.positions.push_back(std::move(at));
  }
  if (std::ranges::none_of(play.positions, [](const auto& p) { return p.refusal.empty(); }))
    throw ModelError(play.joint.empty() ? "" : "joints." + play.joint, play.positions.front().refusal);
  add_regions(mechanism, extremes, play, options.stop);
  if (options.loads) add_loaded(m, driven.joint, quantities, play, options.stop);
  return play;
}

Table play_table(const Play& play) {
  Table table;
  table.column(play.joint.empty() ? "t" : play.joint);
  std::vector<std::string> parts{"ideal", "least", "greatest", "bound_least", "bound_greatest", "linear"};
  if (play.sampled)
    for (const double share : play_shares) parts.push_back(fmt::format("p{:g}", 100 * share));
  for (const auto& quantity : play.quantities) {
    for (const auto& part : parts) table.column(quantity.column() + "." + part);
    if (play.loaded)
      for (const char* part : {"loaded_up", "loaded_down"}) table.column(quantity.column() + "." + part);
  }
  for (const auto& p : play.positions) {
    std::vector<Table::Cell> row{p.coordinate};
    for (std::size_t k = 0; k < play.quantities.size(); ++k) {
      if (p.refusal.empty()) {
        const auto& r = p.ranges[k];
        row.insert(row.end(), {r.ideal, r.least, r.greatest, r.bound_least, r.bound_greatest, r.linear});
        if (play.sampled) row.insert(row.end(), r.quantiles->value.begin(), r.quantiles->value.end());
      } else {
        row.resize(row.size() + parts.size(), "");
      }
      if (play.loaded)
        for (const auto* pose : {&p.up, &p.down})
          row.emplace_back(pose->failure.empty() ? Table::Cell(pose->values[k]) : Table::Cell(""));
    }
    table.row(std::move(row));
  }
  return table;
}

Table play_parts_table(const Play& play) {
  Table table;
  table.column(play.joint.empty() ? "t" : play.joint);
  const std::vector<double> none(play.components.size(), 0.0);
  for (const auto& quantity : play.quantities)
    for (const auto& part : by_joint(play, none)) table.column(quantity.column() + "." + part.first);
  for (const auto& p : play.positions) {
    std::vector<Table::Cell> row{p.coordinate};
    for (const auto& r : p.ranges)
      for (const auto& part : by_joint(play, r.parts)) row.emplace_back(part.second);
    row.resize(table.columns().size(), "");
    table.row(std::move(row));
  }
  return table;
}

Table play_loads_table(const Play& play) {
  Table table;
  table.column(play.joint.empty() ? "t" : play.joint);
  for (const char* way : {"up", "down"})
    for (const auto& name : play.reactions)
      for (const char* part : {"fx", "fy", "m"}) table.column(fmt::format("{}.{}_{}", name, part, way));
  for (const auto& p : play.positions) {
    std::vector<Table::Cell> row{p.coordinate};
    for (const auto* pose : {&p.up, &p.down})
      for (std::size_t i = 0; i < 3 * play.reactions.size(); ++i)
        row.emplace_back(pose->failure.empty() ? Table::Cell(pose->reactions[i]) : Table::Cell(""));
    table.row(std::move(row));
  }
  return table;
}

nlohmann::json to_json(const Play& play) {
  nlohmann::json all{{"joint", play.joint}, {"unit", joint_unit(play)}, {"positions", play.positions.size()}};
  for (const auto& c : play.components)
    all["clearances"].push_back(
        {{"joint", title_of(c)}, {"kind", c.disc ? "disc" : "two-sided"}, {"m", c.clearance}});
  for (const auto& x : play.tolerances)
    all["tolerances"].push_back(
        {{"key", x.key}, {"lower", x.lower}, {"upper", x.upper}, {"distribution", x.distribution}});
  all["refused"] = nlohmann::json::array();
  all["notes"] = play.notes;
  for (const auto& p : play.positions)
    if (!p.refusal.empty()) all["refused"].push_back({{"at", p.coordinate}, {"reason", p.refusal}});
  const auto sentences = verdicts(play);
  for (std::size_t k = 0; k < play.quantities.size(); ++k) {
    double gap = 0;
    bool settled = true;
    for (const auto& p : play.positions)
      if (p.refusal.empty()) gap = std::max(gap, p.ranges[k].gap()), settled &= p.ranges[k].settled;
    nlohmann::json one{{"quantity", play.quantities[k].name},
                       {"column", play.quantities[k].column()},
                       {"unit", play.quantities[k].unit()},
                       {"verdict", sentences[k]},
                       {"greatest_gap", gap},
                       {"settled", settled}};
    if (const auto* at = widest(play, k)) {
      const auto& r = at->ranges[k];
      one["widest"] = {{"at", at->coordinate}, {"width", r.width()}, {"linear_width", 2 * r.linear}};
      for (const auto& [joint, part] : by_joint(play, r.parts)) one["widest"]["parts"][joint] = part;
      if (r.quantiles)
        for (std::size_t s = 0; s < play_shares.size(); ++s)
          one["widest"]["quantiles"].push_back({{"share", play_shares[s]},
                                                {"value", r.quantiles->value[s]},
                                                {"standard_error", r.quantiles->error[s]}});
      for (const auto& [joint, part] : by_joint(play, r.variance))
        one["widest"]["variance_shares"][joint] = part;
    }
    if (play.loaded) one["lost_motion"] = lost_motion(play, k);
    all["quantities"].push_back(std::move(one));
  }
  for (const auto& jump : play.jumps)
    all["jumps"].push_back({{"joint", jump.joint}, {"from", jump.from}, {"to", jump.to}, {"up", jump.up}});
  return all;
}

std::vector<std::string> verdicts(const Play& play) {
  std::vector<std::string> list;
  for (std::size_t k = 0; k < play.quantities.size(); ++k) {
    const auto& quantity = play.quantities[k];
    const auto* at = widest(play, k);
    if (!at) {
      list.push_back(quantity.name + " has no range");
      continue;
    }
    const auto& r = at->ranges[k];
    auto parts = by_joint(play, r.parts);
    std::ranges::stable_sort(parts, std::ranges::greater{}, &std::pair<std::string, double>::second);
    std::string shares;
    constexpr std::size_t shown = 4;
    for (std::size_t i = 0; i < std::min(parts.size(), shown); ++i)
      shares += fmt::format("{}{:.0f} % by {}", i == 0 ? "" : ", ",
                            r.width() > 0 ? 100 * parts[i].second / r.width() : 0, parts[i].first);
    if (parts.size() > shown) shares += fmt::format(", {} others", parts.size() - shown);
    const bool settled = std::ranges::all_of(
        play.positions, [&](const auto& p) { return !p.refusal.empty() || p.ranges[k].settled; });
    list.push_back(fmt::format("{} is between {:.4g} and +{:.4g} {} of its ideal value{}: {}", quantity.name,
                               r.least - r.ideal, r.greatest - r.ideal, quantity.unit(),
                               play.joint.empty() ? ""
                                                  : fmt::format(" (widest at {} = {:.4g} {})", play.joint,
                                                                at->coordinate, joint_unit(play)),
                               shares) +
                   (settled ? "" : "; the search did not converge at all positions, the bounds hold"));
  }
  return list;
}

}  // namespace freeplay
