// Verdicts in words, on planted values: each sentence states what these values support, and calls
// unknown what they leave open.
#include <catch2/catch.hpp>

#include "study/verdicts/verdicts.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using Catch::Matchers::StartsWith;
using Outcome = SignalAgreement::Outcome;

namespace {

ComparisonValues two_runs() {
  ComparisonValues v;
  v.scene = "rig.toml";
  v.events = {.pairs = 3, .horizon = 5.716e-3, .time = 107e-6, .speed = 0.14, .impulse = 0.12};
  v.statistics = {{"share of free flight of pin", 0.10, 0.12, 0.01},
                  {"impacts per revolution of pin", 4, 4, 0.2}};
  v.penalty = {0.5, NAN};
  v.nonsmooth = {0.25, NAN};
  return v;
}

SignalAgreement of_penalty(Outcome outcome) {
  SignalAgreement a;
  a.formulation = "penalty";
  a.outcome = outcome;
  return a;
}

std::size_t sentences(const std::string& text) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    count += text[i] == '.' && (i + 1 == text.size() || text[i + 1] == ' ');
  return count;
}

}  // namespace

TEST_CASE("a statistic differs beyond 3 standard errors and 1 %", "[verdicts]") {
  // |0.10 − 0.12|/0.11 = 18 %: significant for σ < 0.02/3 = 0.0067.
  CHECK((StatisticPair{"", 0.10, 0.12, 0.006}.differs()));
  CHECK_FALSE((StatisticPair{"", 0.10, 0.12, 0.007}.differs()));
  CHECK((StatisticPair{"", 0.10, 0.12, 0.01}.relative()) == Approx(0.02 / 0.11));
  // Without scatter a difference of 0.9 % is no difference of the results, 1.1 % is one.
  CHECK_FALSE((StatisticPair{"", 1, 1.009, 0}.differs()));
  CHECK((StatisticPair{"", 1, 1.0111, 0}.differs()));
  CHECK_FALSE((StatisticPair{"", 0, 0, 0}.differs()));
  CHECK_FALSE((StatisticPair{"", 1, 2, NAN}.differs()));
}

TEST_CASE("compare: two sentences on events, statistics, cost and the next step", "[verdicts]") {
  auto v = two_runs();
  const auto text = verdict(v);
  CHECK(sentences(text) == 2);
  CHECK_THAT(text, Contains("Single contact events agree up to t = 5.716 ms (3 pairs: times within 107 us, "
                            "approach speeds within 14 %, impulses within 12 %)"));
  CHECK_THAT(text,
             Contains("; beyond, the statistics agree within 3 standard errors or 1 % (greatest difference "
                      "18 %, share of free flight of pin: 0.1 and 0.12)"));
  CHECK_THAT(
      text, Contains("CPU time: penalty 0.5 s, nonsmooth 0.25 s; the errors of both are unknown, so costs at "
                     "equal accuracy cannot be compared; see `freeplay advise rig.toml`."));

  v.statistics[0].error = 0.006;
  CHECK_THAT(verdict(v),
             Contains("the statistics differ by more than 3 standard errors, most in share of free "
                      "flight of pin: 0.1 and 0.12 (18 %)"));
  // Without standard errors nothing is said about agreement.
  v.statistics[0].error = NAN;
  v.revolutions_needed = 6;
  const auto open = verdict(v);
  CHECK_THAT(open, Contains("whether the statistics agree is unknown without standard errors"));
  CHECK_THAT(open, Contains("6 revolutions"));
  CHECK_THAT(open, !Contains("the statistics agree within") && !Contains("the statistics differ"));

  v.events.to_the_end = true;
  CHECK_THAT(verdict(v),
             Contains("Single contact events agree to the end of the run (3 pairs") && !Contains("beyond"));
  v.events = {.to_the_end = true};
  CHECK_THAT(verdict(v), Contains("Neither run has a contact event;"));
  v.events = {};
  CHECK_THAT(verdict(v), Contains("No single contact event of the two runs agrees;"));
  v.events = {.contacts = false};
  v.statistics.clear();
  CHECK_THAT(verdict(v), Contains("No contacts were compared, since the scene has none."));
  v.final_length = 2e-5, v.final_angle = 3e-4;
  CHECK_THAT(verdict(v), Contains("the final positions differ by at most 2e-05 m and 0.0003 rad."));
}

TEST_CASE("compare: statistics without power give no agreement", "[verdicts]") {
  auto v = two_runs();
  // Four impacts in one run: neither agreement nor difference is stated.
  for (auto& s : v.statistics) s.few = true;
  CHECK_THAT(verdict(v), Contains("; beyond, too few impacts to compare statistics. ") &&
                             !Contains("statistics agree") && !Contains("statistics differ"));
  // 3 ± 3 against 4 ± 4: the standard error 5 exceeds half of the mean 3.5.
  v.statistics = {{"impacts per second of pin", 3, 4, 5}};
  CHECK_THAT(verdict(v), Contains("the standard errors of 1 statistic (impacts per second of pin) exceed "
                                  "half of the values") &&
                             !Contains("agree within 3"));
  v.statistics.push_back({"share of free flight of pin", 0.1, 0.1, 0.01});
  CHECK_THAT(verdict(v), Contains("; the other statistics agree within 3 standard errors or 1 % "
                                  "(no difference beyond rounding)"));
  // Batches of a transient are no sample.
  v.statistics = {{.name = "energy, J", .penalty = 2, .nonsmooth = 2.2, .error = 1, .transient = true}};
  CHECK_THAT(verdict(v), Contains("energies of this single transient have no standard error (greatest "
                                  "difference 9.5 %, energy, J: 2 and 2.2)"));
}

TEST_CASE("compare: single extreme values are stated with their difference", "[verdicts]") {
  auto v = two_runs();
  CHECK_THAT(verdict(v), !Contains("fastest approach"));
  // 2 (0.0640 − 0.0572)/(0.0640 + 0.0572) = 11.2 %; 2 (0.0936 − 0.0721)/(0.0936 + 0.0721) = 25.95 %.
  v.approaches = {{"pin", 0.0572, 0.0640}};
  v.impulses = {{"pin", 0.0936, 0.0721}};
  CHECK_THAT(
      verdict(v),
      Contains(
          "; the fastest approach and the greatest impulse (in penalty with the load), single values without "
          "standard error, differ by 11 % and 26 %. CPU time"));
  // Of several contacts the one with the greatest difference: 2 (2 − 1)/(2 + 1) = 67 %.
  v.approaches.push_back({"guide", 1, 2});
  v.impulses.push_back({"guide", 1, 1});
  CHECK_THAT(verdict(v), Contains("differ by at most 67 % (guide) and 26 % (pin). CPU time"));
  v.impulses = {{"pin", 0, 0}, {"guide", 0, 0}};
  CHECK_THAT(verdict(v), Contains("; the fastest approach, a single value without standard error, differs by "
                                  "at most 67 % (guide). CPU time"));
}

TEST_CASE("compare: energies below a thousandth of the energy turned over do not decide", "[verdicts]") {
  auto v = two_runs();
  const auto energy = [](double turnover) {
    return StatisticPair{
        .name = "energy, J", .penalty = 1e-3, .nonsmooth = 0, .error = 1e-5, .turnover = turnover};
  };
  v.statistics.push_back(energy(0.9));
  CHECK_THAT(verdict(v), Contains("most in energy, J: 0.001 and 0 (200 %)"));
  v.statistics.back() = energy(1.1);
  CHECK_THAT(verdict(v), Contains("the statistics agree") && !Contains("energy"));
}

TEST_CASE("compare: warnings of the runs, and differences of rounding", "[verdicts]") {
  auto v = two_runs();
  v.doubts = {{"penalty", "contacts add 3 J"},
              {"penalty", "penetration at pin reached 45 % of the clearance", true}};
  CHECK_THAT(verdict(v), StartsWith("Penalty is not reliable here (penetration at pin reached 45 % of the "
                                    "clearance): see warnings. Single contact events"));
  v.doubts.pop_back();
  CHECK_THAT(verdict(v), StartsWith("Penalty may be wrong (contacts add 3 J): see warnings."));
  v.events = {.pairs = 1, .horizon = 1e-3, .time = 1e-16, .speed = 5e-15, .impulse = 0.037};
  CHECK_THAT(verdict(v),
             Contains("(1 pair: times to rounding, approach speeds to rounding, impulses within 3.7 %)"));
}

TEST_CASE("compare: which run is cheaper is said only for known errors", "[verdicts]") {
  auto v = two_runs();
  const auto said = [&](CostAndError p, CostAndError n) {
    v.penalty = p, v.nonsmooth = n;
    return verdict(v);
  };
  CHECK_THAT(said({2, 1e-3}, {1, 1e-3}),
             Contains("nonsmooth is cheaper for the same accuracy (errors 0.1 % and 0.1 %)"));
  CHECK_THAT(said({1, 1e-4}, {2, 1e-3}), Contains("penalty is cheaper for the same accuracy"));
  CHECK_THAT(said({1, 1e-2}, {2, 1e-3}), Contains("the faster run has the greater error") &&
                                             !Contains("is cheaper for the same accuracy ("));
  CHECK_THAT(said({1, 1e-3}, {1.1, 1e-3}), Contains("they cost about the same"));
  CHECK_THAT(said({1, NAN}, {2, 1e-3}), Contains("the error of penalty is unknown, so costs"));
  CHECK_THAT(said({1, 1e-3}, {2, 1e-3}), !Contains("freeplay advise"));
}

TEST_CASE("compare: a run that stopped gives no statement about statistics and cost", "[verdicts]") {
  auto v = two_runs();
  v.stopped = "penalty stopped at t = 0.12 s";
  const auto text = verdict(v);
  CHECK(sentences(text) == 2);
  CHECK_THAT(
      text,
      Contains("Penalty stopped at t = 0.12 s, so statistics and costs cannot be compared; before that, "
               "single contact events agree up to t = 5.716 ms"));
  CHECK_THAT(text, !Contains("CPU") && !Contains("the statistics"));
}

TEST_CASE("validate: each outcome of a measured signal in words", "[verdicts]") {
  const SignalAgreement agrees{
      "penalty", Outcome::agrees, {}, false, 0.2, 0.5, 12, "the same test finds 1.2 times the clearance"},
      differs{"nonsmooth", Outcome::differs, {"the peaks differ", "b", "c", "d"}, false, 3, 0.5, 12, ""};
  const auto text = verdict({agrees, differs});
  CHECK(text ==
        "Nonsmooth differs from the measurement: the peaks differ; b; "
        "c. Penalty agrees with the measurement in "
        "waveform, peaks, their angles and spectrum (mean revolutions: difference 0.2 m/s², "
        "0.5 is explained); the "
        "same test finds 1.2 times the clearance. Fit the unknown parameters with `freeplay calibrate`.");
  CHECK_THAT(verdict(std::vector{agrees}), !Contains("calibrate"));
  auto faulty = differs;
  faulty.faulty_signal = true;
  CHECK_THAT(verdict(std::vector{faulty}),
             Contains("Correct the measured signal first.") && !Contains("calibrate"));
  CHECK_THAT(verdict(std::vector{of_penalty(Outcome::undecided)}),
             Contains("Whether penalty agrees is unknown"));
  CHECK_THAT(verdict(std::vector{of_penalty(Outcome::stopped)}), Contains("Penalty stopped early"));
}

TEST_CASE("validate: no agreement without power", "[verdicts]") {
  const SignalAgreement blind{
      "penalty", Outcome::undecided, {}, false, 1, 2, 12, "the same test also accepts twice c"};
  CHECK_THAT(verdict(std::vector{blind}),
             Contains("No verdict on penalty, which does not differ from the measurement: the same test also "
                      "accepts twice c") &&
                 !Contains("agrees"));
  const SignalAgreement open{"penalty", Outcome::undecided, {}, false, 9, 16, 12, ""};
  CHECK_THAT(
      verdict(std::vector{open}),
      Contains("No verdict on penalty: the uncertainty and scatter explain differences of 16 m/s², more "
               "than the measured signal (rms 12 m/s²)") &&
          !Contains("agrees"));
}

TEST_CASE("validate: measured points and published findings in words", "[verdicts]") {
  const std::vector<PointsAgreement> models = {{"steel [penalty]", Outcome::differs, 0.08},
                                               {"steel [nonsmooth]", Outcome::agrees, 0.02}};
  CHECK(verdict(models) ==
        "With all measured points agree: steel [nonsmooth]; "
        "outside the measurement's uncertainty: steel [penalty]. "
        "The closest is steel [nonsmooth], with a relative rms error of 2 %.");
  CHECK_THAT(verdict(std::vector{PointsAgreement{"a", Outcome::undecided, 0.1}}),
             Contains("Unknown without"));
  CHECK(verdict(FindingCount{4, 4, {}}) ==
        "All 4 assessed findings hold; those marked - or fitted are no evidence.");
  CHECK(verdict(FindingCount{4, 3, {"F2 in chain, penalty"}}) ==
        "3 of 4 assessed findings hold. Not reproduced: F2 in chain, penalty.");
  CHECK_THAT(verdict(FindingCount{}), Contains("No published finding is assessed"));
}

TEST_CASE("advise: the cheaper formulation per simulated second", "[verdicts]") {
  // Costs of 2 s and 1 s a simulated second: the shorter run is not the cheaper one.
  const ChosenSetting penalty{"penalty", "dopri5 1e-8", 0.2, 0.1, false, 0.03, 1},
      nonsmooth{"nonsmooth", "automatic 1e-6", 0.5, 0.5, true};
  const auto text = verdict({penalty, nonsmooth}, 0.01, "rig.toml");
  CHECK(sentences(text) == 2);
  CHECK_THAT(
      text,
      Contains("Within 1 % nonsmooth is cheaper (CPU time per simulated second: nonsmooth automatic 1e-6, "
               "1 s; penalty dopri5 1e-8, 2 s; settings chosen by right-hand sides + 10 Jacobians)."));
  CHECK_THAT(text,
             Contains("Penalty: evaluated over the first 100 ms of 1 s, later statistics to 3 %; the error "
                      "excludes the difference of the formulations"));
  // All events lie in the first hundredth of the run.
  CHECK_THAT(
      verdict({ChosenSetting{"penalty", "a", 0.1, 9.4e-3, true, NAN, 1}, ChosenSetting{"nonsmooth", ""}},
              0.01, "s"),
      Contains("evaluated over the first 9.4 ms of 1 s, which contain all compared events"));
  CHECK_THAT(verdict({penalty, ChosenSetting{"nonsmooth", "a", 0.22, 0.1, true}}, 0.01, "s"),
             Contains("cost about the same"));
  CHECK_THAT(verdict({penalty, ChosenSetting{"nonsmooth", ""}}, 0.01, "s"),
             Contains("only penalty has a setting"));
  CHECK_THAT(verdict({ChosenSetting{"penalty", ""}, ChosenSetting{"nonsmooth", ""}}, 0.01, "s"),
             Contains("No setting of the formulations reaches 1 %"));
}

TEST_CASE("calibrate: values with intervals, open ranges, prediction, rejection", "[verdicts]") {
  CalibrationValues v;
  v.unknowns = {{"friction", "", 0.05, 0.04, 0.06}, {"clearance", "mm", 0.2, 0.1, 0.3, true}};
  v.predictions = 3, v.predicted = 2;
  const auto text = verdict(v);
  CHECK(sentences(text) == 2);
  CHECK_THAT(
      text,
      Contains("The targets are met by friction = 0.05 (0.04 to 0.06) and clearance = 0.2 (0.1 to 0.3) mm "
               "(95 %); the range of clearance is not closed"));
  CHECK_THAT(text, Contains("2 of 3 targets lie inside"));
  v.unpredicted = {"peak", "line"};
  v.ridge = "The targets determine friction / clearance^0.9 to 5 %, but not each unknown.";
  CHECK_THAT(verdict(v),
             Contains("2 of 3 targets lie inside their 95 % interval; without peak or line the fit "
                      "does not hold and predicts nothing.") &&
                 Contains(v.ridge));
  v.predictions = 0;
  CHECK_THAT(verdict(v), Contains("so the fit is not tested"));
  v.settled = false;
  CHECK_THAT(verdict(v), Contains("Calibration open") && !Contains("0.05") && !Contains("met"));
  // An open fit excludes nothing, so it states no contradiction.
  v.contradicted = {"peak"};
  CHECK_THAT(verdict(v), Contains("Calibration open"));
  v.settled = true;
  CHECK_THAT(verdict(v), Contains("Calibration rejected: runs at the optimum disagree") && !Contains("0.05"));
  v.rejected = true;
  CHECK_THAT(verdict(v), Contains("Calibration rejected: no values of the unknowns"));
}

TEST_CASE("sweep: range of the statistic, and difference of the formulations", "[verdicts]") {
  SweepValues v{4, 0, "peak_max", "m/s²", {}};
  v.cells = {{"c = 1 mm", "penalty", 10, 9, 11},
             {"c = 1 mm", "nonsmooth", 12, 11.5, 12.5},
             {"c = 2 mm", "penalty", 20, 18, 22},
             {"c = 2 mm", "nonsmooth", 21, 19, 23}};
  // 2 apart of a mean of 11: 18 %; the intervals at 2 mm overlap, those at 1 mm do not.
  CHECK(verdict(v) ==
        "All 4 runs finished; peak_max ranges from 10 m/s² (c = 1 mm, penalty) to 21 m/s² (c = 2 mm, "
        "nonsmooth). The "
        "formulations differ in peak_max by at most 2 m/s², 18 % (c = 1 mm); "
        "their 95 % intervals overlap in 1 of 2 cells.");
  // No relative difference from zero; cells where both are zero are no cells to compare.
  SweepValues zero{4, 0, "peak_max", "m/s²", {}};
  zero.cells = {{"c = 1 mm", "penalty", 0, 0, 0},
                {"c = 1 mm", "nonsmooth", 0, 0, 0},
                {"c = 2 mm", "penalty", 0, 0, 0},
                {"c = 2 mm", "nonsmooth", 0.5, 0.4, 0.6}};
  CHECK_THAT(verdict(zero),
             Contains("differ in peak_max by at most 0.5 m/s² (c = 2 mm); their 95 % intervals "
                      "overlap in 0 of 1 cells."));
  v.cells[1].low = v.cells[1].high = NAN;
  CHECK_THAT(verdict(v), Contains("is unknown, since some cells have one start") && !Contains("overlap"));
  v.failed = 1;
  v.cells.pop_back();
  CHECK_THAT(verdict(v), Contains("1 of 4 runs failed; peak_max ranges"));
  v.cells.clear();
  CHECK(verdict(v) == "1 of 4 runs failed; they have no statistic to compare.");
}
