// A periodic motion: phase portraits of the bodies with the jumps at impacts and the section, full lines if
// the motion is stable, else dashed ones; and its Floquet multipliers beside the unit circle.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstddef>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "io/files/input_file.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/axis.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/panels.hpp"
#include "plots/figures/phase_portrait.hpp"
#include "plots/tables/run_facts.hpp"

namespace freeplay::plots {
namespace {

constexpr std::size_t portrait_bodies = 9;
constexpr long portrait_rows = 20'000;
/// A change of the rate between two rows about an impact is drawn as a jump from this share of its range on,
/// and if it is this multiple of the changes before and after it: contact forces of several rows are part of
/// the curve.
constexpr double least_jump = 0.02, least_ratio = 3;
/// Multipliers within this distance of the unit circle do not count as inside (docs/theory/orbits.md).
constexpr double beside_circle = 1e-5;

/// Times of the contact onsets, s.
std::vector<double> onsets_of(const JsonFile& document) {
  std::vector<double> times;
  if (const auto* list = document.find("impacts"); list && list->is_array())
    for (const auto& impact : *list)
      if (impact.is_object() && impact.contains("time") && impact["time"].is_number())
        times.push_back(impact["time"].get<double>());
  std::ranges::sort(times);
  return times;
}

bool shows_stable(const JsonFile& document) {
  const auto* value = document.find("stable");
  return value && value->is_boolean() && value->get<bool>();
}

std::vector<std::filesystem::path> draw_portraits(const std::filesystem::path& folder,
                                                  const JsonFile& document) {
  const auto run = folder / "motion";
  if (!std::filesystem::exists(run / "trajectory.csv")) return {};
  const auto motion = motion_of(run, {-INFINITY, INFINITY, ""}, portrait_bodies, portrait_rows);
  if (motion.t.size() < 3) return {};
  const auto onsets = onsets_of(document);
  const bool is_stable = shows_stable(document);
  const double rounding = 1e-9 * (motion.t.back() - motion.t.front());
  const auto has_onset = [&](double from, double to) {
    const auto first = std::ranges::lower_bound(onsets, from - rounding);
    return first != onsets.end() && *first <= to + rounding;
  };
  Figure f{.name = "orbit", .source = "orbit.json"};
  f.caption = fmt::format("Phase portraits of a periodic motion, {:.6g} to {:.6g} s, {}.", motion.t.front(),
                          motion.t.back(), is_stable ? "stable" : "not stable");
  PanelStack stack{.abscissa = {AxisTitle::of("", ""), {}}, .panels = {}, .columns = 3};
  bool jumps = false;
  for (std::size_t b = 0; b < motion.bodies.size(); ++b) {
    const int coordinate = phase_coordinate(motion.coordinates[b]);
    if (coordinate < 0) continue;
    const auto k = static_cast<std::size_t>(coordinate);
    const auto &q = motion.coordinates[b][k], &v = motion.coordinates[b][3 + k];
    const auto plane = phase_plane(motion.coordinates[b], k);
    const auto at = [&](std::size_t i) -> std::vector<double> {
      return {q[i] / plane.place_unit.size, v[i] / plane.rate_unit.size};
    };
    const auto columns =
        fmt::format("{} ({}), {} ({})", motion.bodies[b], plane.place.unit, "rate", plane.rate.unit);
    Block curve("curve: " + columns), jump("jumps: " + columns), section("section: " + columns);
    const auto change = [&](std::size_t i) { return i + 1 < v.size() ? std::abs(v[i + 1] - v[i]) : 0; };
    const auto jumps_after = [&](std::size_t i) {
      const double beside = std::max(i > 0 ? change(i - 1) : 0, change(i + 1));
      return change(i) >= std::max(least_jump * range_of(v), least_ratio * beside) && change(i) > 0;
    };
    for (std::size_t i = 0; i < q.size(); ++i) {
      curve.row(at(i));
      if (i + 1 == q.size() || !jumps_after(i) || !has_onset(motion.t[i], motion.t[i + 1])) continue;
      curve.gap();
      jump.row(at(i)).row(at(i + 1)).gap();
    }
    section.row(at(0));
    Panel panel{
        .title = plane.rate,
        .axis = axis_of(Limits(v).least / plane.rate_unit.size, Limits(v).most / plane.rate_unit.size),
        .curves = {},
        .name = motion.bodies[b],
        .abscissa = Abscissa{plane.place, axis_of(Limits(q).least / plane.place_unit.size,
                                                  Limits(q).most / plane.place_unit.size)}};
    const auto add = [&](Block&& block, const Script& look) {
      add_curve(f, panel, std::move(block), Script().add("using 1:2 with {}", look));
    };
    jumps = jumps || !jump.empty();
    add(std::move(jump), Script().add("linespoints lw 1.4 dt (2,3) lc rgb 0x555555 pt 7 ps 0.6"));
    add(std::move(curve),
        is_stable ? Script().add("lines lw 2 lc rgb C1") : Script().add("lines lw 1.6 dt (6,4) lc rgb C2"));
    add(std::move(section), Script().add("points pt 6 ps 1.1 lw 1.5 lc rgb 0x000000"));
    stack.panels.push_back(std::move(panel));
  }
  if (stack.panels.empty()) return {};
  stack.each = stack.panels.size() == 1 ? 7.5 : 4.2;
  if (stack.panels.size() == 1) f.width_cm = 10;
  stack.key.push_back({is_stable ? Script().add("with lines lw 2 lc rgb C1")
                                 : Script().add("with lines lw 1.6 dt (6,4) lc rgb C2"),
                       is_stable ? "stable" : "not stable"});
  if (jumps)
    stack.key.push_back(
        {Script().add("with linespoints lw 1.4 dt (2,3) lc rgb 0x555555 pt 7 ps 0.6"), "impact"});
  stack.key.push_back({Script().add("with points pt 6 ps 1.1 lw 1.5 lc rgb 0x000000"), "section"});
  return {draw_panels(f, folder, std::move(stack))};
}

std::vector<std::complex<double>> multipliers_in(const JsonFile& document) {
  std::vector<std::complex<double>> values;
  if (const auto* list = document.find("multipliers"); list && list->is_array())
    for (const auto& m : *list)
      if (m.is_array() && m.size() == 2 && m[0].is_number() && m[1].is_number())
        values.emplace_back(m[0].get<double>(), m[1].get<double>());
  return values;
}

std::vector<std::filesystem::path> draw_multipliers(const std::filesystem::path& folder,
                                                    const JsonFile& document) {
  const auto values = multipliers_in(document);
  if (values.empty()) return {};
  Block circle("unit circle: real part, imaginary part"), inside("inside: real part, imaginary part"),
      outside("on or outside: real part, imaginary part");
  Limits across(std::vector<double>{-1, 1}), up = across;
  constexpr int corners = 180;
  for (int i = 0; i <= corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    circle.row({std::cos(angle), std::sin(angle)});
  }
  for (const auto& m : values) {
    (std::abs(m) < 1 - beside_circle ? inside : outside).row({m.real(), m.imag()});
    across.hold(m.real());
    up.hold(m.imag());
  }
  Figure f{.name = "multipliers", .width_cm = 8, .source = "orbit.json"};
  f.caption = fmt::format("Floquet multipliers of a periodic motion, {}.",
                          shows_stable(document) ? "stable" : "not stable");
  Panel panel{
      .title = AxisTitle::of({"Im μ", "Im $\\mu$"}, ""), .axis = axis_of(up.least, up.most), .curves = {}};
  const auto add = [&](Block&& block, const Script& look, const char* title) {
    add_curve(f, panel, std::move(block), Script().add("using 1:2 with {}", look), title);
  };
  add(std::move(circle), Script().add("lines lw 1 lc rgb 0x888888"), "unit circle");
  add(std::move(inside), Script().add("points pt 7 ps 1.0 lc rgb C1"), "inside");
  add(std::move(outside), Script().add("points pt 9 ps 1.1 lc rgb C2"), "on or outside");
  return {
      draw_panels(f, folder,
                  {.abscissa = {AxisTitle::of({"Re μ", "Re $\\mu$"}, ""), axis_of(across.least, across.most)},
                   .panels = {std::move(panel)},
                   .each = 6.0,
                   .equal_scales = true})};
}

std::vector<std::filesystem::path> draw_orbit(const std::filesystem::path& folder) {
  const JsonFile document(folder / "orbit.json");
  auto made = draw_portraits(folder, document);
  for (auto& path : draw_multipliers(folder, document)) made.push_back(std::move(path));
  return made;
}

}  // namespace

const Drawing orbit{{"orbit.json"}, draw_orbit};

}  // namespace freeplay::plots
