// freeplay verify: evaluates all claims of the verification suite, on the terminal and in
// verification.json; with --document also as Markdown with figures, and as a table of the claims.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "cli/command_line.hpp"
#include "cli/ending.hpp"
#include "cli/folders.hpp"
#include "cli/terminal.hpp"
#include "facade/run_folder.hpp"
#include "io/files/folder_lock.hpp"
#include "io/files/output_file.hpp"
#include "io/files/result_set.hpp"
#include "io/files/run_json.hpp"
#include "io/scene/spelling.hpp"
#include "mechanism/error.hpp"
#include "plots/drawing/figure.hpp"
#include "verification/claims/claim.hpp"
#include "verification/support/support.hpp"

namespace freeplay::cli {
namespace {

using namespace verification;

/// Draws one figure for each name of a curve, with logarithmic axes.
void draw_curves(const std::vector<Verdict>& verdicts, const std::filesystem::path& folder) {
  std::vector<Curve> curves;
  for (const auto& v : verdicts)
    curves.insert(curves.end(), v.findings.curves.begin(), v.findings.curves.end());
  std::vector<std::string> names;
  for (const auto& c : curves)
    if (std::ranges::find(names, c.figure) == names.end()) names.push_back(c.figure);
  constexpr plots::Word colours[] = {"#0b3c8c", "#c8500a", "#000000", "#2a7a3a", "#8a2a8a", "#777777"};
  for (const auto& name : names) {
    plots::Figure figure{.name = name, .height_cm = 12, .source = "verification.json"};
    plots::Script plot;
    for (const auto& c : curves) {
      if (c.figure != name) continue;
      const auto index = figure.blocks.size();
      if (index == 0)
        figure.script.add("set logscale xy\nset format '10^{{%T}}'\nset xlabel {}\nset ylabel {}\n",
                          c.x_label, c.y_label);
      auto& block = figure.blocks.emplace_back(c.title);
      for (std::size_t i = 0; i < c.x.size(); ++i) block.row({c.x[i], c.y[i]});
      plot.add("{}DATA index {} using 1:2 with linespoints lw 1.4 dt {} pt {} lc rgb '{}' title {}",
               index ? plots::Word(", ") : plots::Word("plot "), index, 1 + index % 3, 4 + index,
               colours[index % std::size(colours)], c.title);
    }
    figure.script.add("set key outside top center horizontal\n{}\n", plot);
    plots::draw(figure, folder);
  }
}

struct VerifyRequest : Request {
  std::vector<std::string> names;  ///< sets of claims; empty: all
  std::string output;              ///< result folder
  std::string document;            ///< folder for verification.md and its figures
};

int verify(const VerifyRequest& request) {
  std::vector<const ClaimSet*> chosen;
  for (const auto& set : claim_sets())
    if (request.names.empty() || std::ranges::find(request.names, set.name) != request.names.end())
      chosen.push_back(&set);
  for (const auto& name : request.names)
    if (std::ranges::none_of(claim_sets(), [&](const ClaimSet& s) { return name == s.name; })) {
      std::vector<std::string> known;
      for (const auto& s : claim_sets()) known.emplace_back(s.name);
      throw SceneError(
          fmt::format("verify: unknown set of claims \"{}\"{}", name, meant(name, known, "there is:")));
    }

  test::source_folder();  // throws before any evaluation or output

  Progress progress;
  std::vector<Verdict> verdicts;
  std::size_t claims = 0, holding = 0;
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (request.stop()) return interrupted(Kept::nothing);
    progress.show(chosen[i]->name, static_cast<double>(i) / static_cast<double>(chosen.size()));
    verdicts.push_back(assess(*chosen[i]));
    progress.clear();
    fmt::print("{}", table(verdicts.back()));
    std::fflush(stdout);
    claims += verdicts.back().findings.claims.size();
    holding +=
        static_cast<std::size_t>(std::ranges::count_if(verdicts.back().findings.claims, &Claim::holds));
  }
  const bool all = std::ranges::all_of(verdicts, &Verdict::holds);
  fmt::print("\n{} of {} claims hold{}\n", holding, claims, all ? "" : "; the failures are listed above");

  const auto folder =
      result_folder(!request.document.empty() ? request.document : request.output, "out/verification");
  make_folder(folder);
  const FolderLock lock(folder, "verify");
  settle_result_sets(folder);
  const auto origin = provenance();
  write_json(folder / "verification.json", to_json(verdicts),
             {{"version", origin["version"]}, {"commit", origin["commit"]}, {"scene_file", "verification"}});
  if (!request.document.empty()) {
    draw_curves(verdicts, folder);
    write_file(folder / "verification.md", verification::document(verdicts));
    write_file(folder / "verification.csv", requested(verdicts));
  }
  fmt::print("results in {}\n", folder.string());
  return all ? 0 : 1;
}

}  // namespace

void verify_verb(Program& program) {
  auto [options, request] = program.verb("verify", verify_what, verify);
  options.add("names", request.names, "sets of claims; default all");
  options.output(request.output, "result folder");
  options
      .add("--document", request.document,
           "write verification.md, its figures and verification.csv into this folder")
      .takes("FOLDER");
}

}  // namespace freeplay::cli
