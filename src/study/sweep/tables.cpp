#include "study/sweep/tables.hpp"

#include <fmt/format.h>

#include "io/files/output_file.hpp"
#include "mechanism/scene.hpp"
#include "study/runs/ideal_turn.hpp"
#include "study/sweep/intervals.hpp"

namespace freeplay {

void write_tables(const Study& study, const Results& results, const Conduct& conduct,
                  const std::filesystem::path& folder) {
  std::string axes;
  for (const auto& a : study.axes) axes += "," + a.name;
  OutputFile cells(folder / "cells.csv"), traces(folder / "traces.csv"), spectra(folder / "spectra.csv");
  cells.write(fmt::format("variant,formulation{},statistic,mean,low,high,least,greatest,starts\n", axes));
  traces.write(fmt::format("variant,formulation{},angle,acceleration,position\n", axes));
  spectra.write(fmt::format("variant,formulation{},harmonic,amplitude\n", axes));
  const auto rows = results.runs();
  const Cells every(rows);
  std::set<std::pair<std::string, std::vector<double>>> ideals;
  for (const auto& one : cases(study)) {
    if (one.start != 0) continue;
    std::string head;
    for (double x : one.values) head += fmt::format(",{}", x);
    const auto line = [&](const std::string& formulation) {
      return fmt::format("{},{}{}", one.variant, formulation, head);
    };
    std::vector<double> mean;
    int starts = 0;
    for (const auto* row : every.at(one.variant, one.formulation, one.values)) {
      if (row->start == 0)
        for (const auto& p : results.trace(row->key))
          traces.write(
              fmt::format("{},{},{},{}\n", line(one.formulation), p.angle, p.acceleration, p.position));
      const auto spectrum = results.spectrum(row->key);
      mean.resize(std::max(mean.size(), spectrum.size()));
      for (std::size_t h = 0; h < spectrum.size(); ++h) mean[h] += spectrum[h];
      ++starts;
    }
    for (std::size_t h = 0; h < mean.size(); ++h)
      spectra.write(fmt::format("{},{},{}\n", line(one.formulation), h + 1, mean[h] / starts));
    for (int m = 0; m < TurnMetrics::count; ++m) {
      const auto s = every.of(one.variant, one.formulation, one.values, static_cast<TurnMetrics::Name>(m));
      cells.write(fmt::format("{},{},{},{},{},{},{},{}\n", line(one.formulation), TurnMetrics::names()[m],
                              s.mean, s.low, s.high, s.least, s.greatest, s.count));
    }
    if (!ideals.emplace(one.variant, one.values).second) continue;
    const auto ideal = ideal_turn(study, scene_of(study, one, conduct), "penalty", conduct);
    for (const auto& p : ideal.last_turn)
      traces.write(fmt::format("{},{},{},{}\n", line("ideal"), p.angle, p.acceleration, p.position));
  }
  for (auto* file : {&cells, &traces, &spectra}) file->commit();
}

}  // namespace freeplay
