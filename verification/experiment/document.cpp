// experiment.json, and docs/verification/experiment.md, all that a referee needs, from the results alone.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "verification/experiment/flores2011.hpp"

namespace freeplay::verification {

std::vector<VariantFindings> all_findings(const Study& study, const Results& results,
                                          const std::vector<RunRow>& runs, const Study* calibration) {
  std::vector<VariantFindings> all;
  for (const auto& v : study.variants)
    for (const auto& formulation : v.formulations)
      all.push_back({v.name, v.title, formulation,
                     flores2011(study, results, runs, v.name, formulation, TurnMetrics::ratio_95,
                                fitted_findings(v.name, calibration))});
  return all;
}

FindingCount count(const std::vector<VariantFindings>& all) {
  FindingCount count;
  for (const auto& of : all)
    for (const auto& f : of.findings) {
      count.assessed += f.assessed;
      count.holding += f.assessed && f.holds;
      if (f.assessed && !f.holds)
        count.failing.push_back(fmt::format("{} in {}, {}", f.id, of.variant, of.formulation));
    }
  return count;
}

nlohmann::json to_json(const std::vector<VariantFindings>& all) {
  nlohmann::json document = {{"verdict", verdict(count(all))}};
  for (const auto& of : all)
    for (const auto& f : of.findings)
      document["verdicts"][of.variant][of.formulation].push_back({{"id", f.id},
                                                                  {"claim", f.claim},
                                                                  {"measured", f.measured},
                                                                  {"bound", f.bound},
                                                                  {"judged", f.assessed},
                                                                  {"fitted", f.fitted},
                                                                  {"holds", f.holds}});
  return document;
}

std::string experiment_document(const Study& study, const Results& results, const Study* calibration_study,
                                const CalibrationResult* calibration, const std::string& version) {
  const auto runs = results.runs();
  const Evidence evidence{study, results, runs, calibration_study};
  std::string out =
      "# Validation against the experiment of Flores et al. (2011)\n\nThe page compares both formulations "
      "with the statements X1 to X13 of the paper's text about its slider-crank\nrig. Its figures are images "
      "without public data. A failed claim is a result, too.\n\n## Summary\n\nA statement holds if all its "
      "claims hold; the bounds are in the tables of claims below. \"Maximum\" is relative to the ideal\n"
      "joint, "
      "at 200 rpm. A fitted statement is no test, and no fitted value is called a prediction.\n\n" +
      summary_table(evidence) +
      "\n![maximum over clearance](figures/experiment_peaks_clearance.png)\n"
      "*\"Maximum\" over the clearance at "
      "200 rpm, calibrated scene: fitted to the measured points (the paper's figure 10).*\n\n## Failed "
      "statements and physical assumptions\n\nFor each quantity that fails with the paper's settings, the "
      "table names assumptions that can cause the failure, and the\nscene of this page that changes one of "
      "them. *Shown* is \"yes\" if the quantity then holds in each formulation in which it had\n"
      "failed. Most of "
      "these scenes have few starts, so that their intervals are wide; [the influences](#influence-of-each-"
      "assumption-on-the-claims)\nlist the peaks that change beyond their intervals. The table contains no "
      "fitted value.\n\n" +
      failures_table(evidence) +
      "\nNo run of this page tests these assumptions: compliance of crank and rod (all bodies are "
      "rigid), play "
      "of the guide,\nripple of the motor's speed (the motor of the scene drive turns at constant speed "
      "behind "
      "its coupling), and resonance of the\naccelerometer (the scenes change its bandwidth only). A row with "
      "\"no\" or \"no run\" leaves the cause open.\nA scene that corrects one quantity can worsen "
      "others (drive: X7 and X9; "
      "guide: X6 and X9 to X11); no scene satisfies all statements.\n\n";
  out += fmt::format(
      "## Source and version\n\nWritten by `freeplay validate {} "
      "--document docs/verification`, version {}.\nSource of the measurements: P. Flores, C. S. Koshy, "
      "H. M. Lankarani, "
      "J. Ambrósio, J. C. P. Claro,\n\"Numerical and experimental investigation on multibody systems with "
      "revolute clearance joints\",\nNonlinear Dynamics 65 (2011) 383–398.\n\n",
      study.file.string(), version);
  out += fmt::format(
      "## Assumptions\n\nThe paper does not state the accelerometer's bandwidth, the guide's friction, the "
      "datum of the crank angle, the\ncentres of mass, or the definition of \"maximum\". Assumed here: "
      "balanced crank, rod's centre at mid-span; angles are measured\nfrom the loss of contact (43° in the "
      "paper); **\"maximum\" is the acceleration that 95 % of revolutions do not\nexceed**, averaged over "
      "starts (other definitions are given below); \"300 % larger\" means four times.\n{} revolutions are "
      "evaluated after {} discarded ones, from {} starts: crank angle uniform over a revolution, journal "
      "uniform in {} of\nits clearance, seed {} (fewer for some scenes). Intervals are Student's 95 % of "
      "the mean over starts, also where\nfew skewed values push them below zero. The impact law uses the "
      "effective restitution of the contact law.\n\n",
      study.length.revolutions, study.length.discard, study.starts.count, study.starts.perturbation.play,
      study.starts.seed);
  Table scenes("scene,description,starts × revolutions");
  for (const auto& v : study.variants)
    scenes.row(v.name, v.title, fmt::format("{} × {:g}", v.starts, v.revolutions));
  out += scenes.markdown();
  if (calibration)
    out +=
        "\nCalibrated: the optimum of the fit to all targets (below); penalty uses the exact law, whose "
        "effective restitution\nis the fitted one.\n";
  for (const auto& v : study.variants) {
    if (v.formulations.size() < 2 || v.starts < study.starts.count) continue;
    out += fmt::format("\n## Claims: {}\n\n{}", v.title, claims_table(evidence, v));
    const auto cells = formulations_agree(study, runs, v.name);
    out += fmt::format(
        "\nMedian peaks of the formulations in {} cells: each mean is inside the other's 95 % interval in "
        "{}, at least one in {};\nthe intervals overlap in {}. With equal true means 80 %, 92 % and 99 % "
        "are expected (eight starts).\n",
        cells.all, cells.within, cells.all - static_cast<int>(cells.apart.size()), cells.overlapping);
    for (const auto& a : cells.apart) out += fmt::format("- Neither: {}.\n", a);
  }
  out +=
      "\nDifferences between cells: without filter, a bandwidth of 20 kHz resolves a contact of 0.2 ms but "
      "not an impact without duration, so the\nformulations differ there by construction, and X6 to X8 do "
      "not test them. With filter, the differing cells were\nexamined with more starts and shorter steps: "
      "[cases/flores2011-experiment](../cases/flores2011-experiment/README.md).\n\n## Definitions of "
      "\"maximum\"\n\n✗ marks a claim that fails.\n\n" +
      readings_table(evidence) +
      "\n## Influence of each assumption on the claims\n\nEach scene changes one assumption. Steps are "
      "those of the matrix along both axes. The scene bearings runs nonsmooth only, since\npenalty is slow "
      "at 5 µm; cylinder and stiff change parameters of penalty only. A run with a warning had a fast "
      "impact after a\nflight of fewer than thirty time steps.\n\n" +
      influences_table(evidence) +
      "\n## Explanation of failed claims\n\n- X3, X4: flights last half of the measured duration, and the "
      "impacts after them decay sooner. Friction in the guide\n  slows the slider in flight and lengthens "
      "the flights to the measured duration, but increases their number.\n- X6: the paper's settings with "
      "1 kHz give a larger value than measured. The fitted changes together (narrower bandwidth,\n  "
      "friction in the guide, higher restitution) reduce it; a single change, over three starts, seldom "
      "exceeds the intervals.\n- X10 with speed: impacts slower than 0.01 m/s are not counted, and a "
      "faster revolution has less time for rebounds.\n- X11 with speed: the accelerometer's bandwidth "
      "contains 2.5 times fewer harmonics at 250 than at 100 rpm, and the threshold\n  grows with the "
      "square of the speed. In Hz (not evaluated) the range of lines grows with speed where its row says "
      "so.\n- X12 without friction in the guide: no force slows a free slider. With friction the value is "
      "friction over the slider's mass by\n  Newton's law, so the claim holds because friction is "
      "included.\n";
  if (calibration)
    out += "\n## Fitted and predicted quantities\n\n" + calibration_tables(*calibration_study, *calibration);
  out +=
      "\n## Open questions of the paper's text\n\n- The definition of \"maximum\": see the table above. It "
      "was fixed after first runs with a 1 kHz measuring chain,\n  before the calibration.\n- The "
      "measuring chain and the guide's friction: three statements cannot determine four unknowns "
      "(intervals above).\n- The datum of the crank angle (X3 to X5): only lengths of flights and zones "
      "relative to the loss of contact are evaluated.\n  It is not calibrated, since no peak depends on "
      "it; the row of X3 without verdict gives the angle of the loss of contact in the\n  model.\n- The "
      "thresholds for an impact (X10; here 0.01 m/s) and a dominant line (X11; here 5 % of the greatest "
      "ideal\n  acceleration).\n- X2: the geometry bounds the slider's position by the clearance; this "
      "claim fails only if the joint separates.\n\n## Figures\n\nThe calibrated scene with penalty and "
      "nonsmooth, as in the paper's figures 5 to 13. Figure 10 is in the summary.\n\n"
      "![motion](figures/experiment_motion.png)\nPosition "
      "and acceleration against the crank angle (its figure "
      "5).\n\n![clearances](figures/experiment_clearances.png)\nAcceleration for four clearances at 200 "
      "rpm (6), [spectra](figures/experiment_clearance_spectra.png) "
      "(7).\n\n![speeds](figures/experiment_speeds.png)\nAcceleration for four speeds at 0.25 mm (8), "
      "[spectra](figures/experiment_speed_spectra.png) (9).\n\n"
      "![velocity](figures/experiment_velocity.png)\nSlider velocity "
      "(11).\n\n![peaks over speed](figures/experiment_peaks_speed.png)\n\"Maximum\" over the speed "
      "(12).\n\n![surface](figures/experiment_surface.png)\n\"Maximum\" over both (13).\n";
  for (const auto& v : study.variants) {
    if (v.formulations.size() < 2 || v.starts < study.starts.count) continue;
    out += fmt::format("\n## The matrix: {}\n\n{}", v.title, matrix_table(evidence, v));
  }
  return out + fmt::format(
                   "\nAll runs of these tables took {:.0f} min of CPU time, without those of the "
                   "calibration.\n",
                   results.cpu_seconds() / 60);
}

}  // namespace freeplay::verification
