#include "study/compare.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "io/output_file.hpp"
#include "io/run_folder.hpp"
#include "io/run_json.hpp"
#include "model/scene.hpp"

namespace freeplay {
namespace {

std::vector<std::vector<ContactEvent>> touches(const std::vector<ContactEvent>& events, int joints) {
  std::vector<std::vector<ContactEvent>> of(joints);
  for (const auto& e : events)
    if (e.kind != EventKind::separation) of[e.contact].push_back(e);
  return of;
}

/// First touch of a joint that has no partner: its time and the reason.
struct Break {
  double t = INFINITY;
  std::string why;
};

Break pair_joint(const std::vector<ContactEvent>& a, const std::vector<ContactEvent>& b,
                 std::vector<ImpactPair>& out) {
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    const double t = std::min(i < a.size() ? a[i].t : INFINITY, i < b.size() ? b[i].t : INFINITY);
    if (i >= a.size() || i >= b.size())
      return {t, fmt::format("only the {} run has touch {}", i < a.size() ? "penalty" : "nonsmooth", i + 1)};
    const double interval = i == 0 ? t : t - std::max(a[i - 1].t, b[i - 1].t);
    if (!(std::abs(a[i].t - b[i].t) <= 0.25 * interval))
      return {t, fmt::format("the times of touch {} differ by more than a quarter of the interval before it",
                             i + 1)};
    const double ratio = a[i].v_n_minus / b[i].v_n_minus;
    if (!(ratio < 2 && ratio > 0.5))
      return {t, fmt::format("the approach speeds of touch {} differ twofold", i + 1)};
    out.push_back({a[i], b[i]});
  }
  return {INFINITY, "all touches are paired"};
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
                     int joints, double until) {
  Pairing p;
  const auto a = touches(penalty, joints), b = touches(nonsmooth, joints);
  Break first{until, until < INFINITY ? "the list of a run's events that was kept ends there"
                                      : "all touches are paired"};
  for (int k = 0; k < joints; ++k) {
    const auto end = pair_joint(a[k], b[k], p.pairs);
    if (end.t < first.t) first = end;
  }
  std::erase_if(p.pairs,
                [&](const ImpactPair& x) { return std::max(x.penalty.t, x.nonsmooth.t) >= first.t; });
  std::ranges::sort(p.pairs, {}, [](const ImpactPair& x) { return x.nonsmooth.t; });
  p.ended_by = p.pairs.empty() && first.t == INFINITY ? "neither run touches" : first.why;
  if (!p.pairs.empty()) p.horizon = std::max(p.pairs.back().penalty.t, p.pairs.back().nonsmooth.t);
  return p;
}

Comparison compare(const Scene& scene, const CompareSetup& setup, const std::filesystem::path& folder) {
  Comparison c;
  c.matched = setup.matched;
  remove_figures_of_forces(folder);
  const auto progress = [&](const char* which) {
    return [&setup, which](double done) {
      if (setup.on_progress) setup.on_progress(which, done);
    };
  };
  const auto run = [&](const Scene& one, const char* formulation, const char* name) {
    return run_scene(one, {.formulation = formulation,
                           .matched = setup.matched,
                           .folder = folder / name,
                           .on_progress = progress(name),
                           .stop = setup.stop});
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
      // A mechanism that closes only thanks to its play has no ideal motion to show.
      c.nonsmooth.notes.push_back("with ideal joints the mechanism does not assemble; no ideal run");
    }
  }
  const auto known = [](const Result& r) { return r.events_cut() ? r.events.back().t : INFINITY; };
  c.pairing = pair_impacts({c.penalty.events.begin(), c.penalty.events.end()},
                           {c.nonsmooth.events.begin(), c.nonsmooth.events.end()},
                           static_cast<int>(c.joints.size()), std::min(known(c.penalty), known(c.nonsmooth)));

  auto document = to_json(c);
  document["provenance"] = provenance(scene);
  write_file(folder / "comparison.json",
             document.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  write_file(folder / "comparison.md", comparison_table(scene, c, true));
  return c;
}

nlohmann::json to_json(const Comparison& c) {
  nlohmann::json pairs = nlohmann::json::array();
  for (const auto& p : c.pairing.pairs)
    pairs.push_back({{"joint", c.joints[p.penalty.contact]},
                     {"penalty", to_json(p.penalty)},
                     {"nonsmooth", to_json(p.nonsmooth)}});
  nlohmann::json j = {
      {"restitution_matched", c.matched},
      {"penalty", to_json(c.penalty)},
      {"nonsmooth", to_json(c.nonsmooth)},
      {"pairing", {{"horizon_s", c.pairing.horizon}, {"ended_by", c.pairing.ended_by}, {"pairs", pairs}}}};
  if (c.ideal) j["ideal"] = to_json(*c.ideal);
  return j;
}

}  // namespace freeplay
