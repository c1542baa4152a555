// Studies without a drive of prescribed speed and without an accelerometer: measures of every
// column of the result files, and derived quantities, in the database and in exports.
#include <boost/math/special_functions/ellint_1.hpp>

#include "facade/run_folder.hpp"
#include "io/scene/read_scene.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

using test::StudyDesk, test::Rows, test::value_of, test::axis, test::measure;

const std::string nonsmooth = "scene = \"scene.toml\"\nformulations = [\"nonsmooth\"]\n",
                  each_period = "each = \"period\"\n", every_period = "at = \"every period\"\n";

/// The case of a pendulum whose bar has a given angle and no position: it is attached at the pin.
struct Pendulum : StudyDesk {
  explicit Pendulum(const std::string& angle) : StudyDesk("pendulum") {
    change("position = [\"0.3 m\", 0]\n", "angle = " + angle + "\n");
  }
};

}  // namespace

TEST_CASE("a pendulum's period over its amplitude is the elliptic integral", "[studies]") {
  const Pendulum desk("0.1");
  const auto runs =
      desk.table("scene = \"scene.toml\"\nduration = 3\n" +
                 axis("angle", "bodies.bar.angle", "\"-60 deg\", 0, \"60 deg\", \"80 deg\"") +
                 measure("quarter", "t", "first", "at = \"pivot.angle crosses -90 deg downwards\"\n") +
                 measure("crossings", "t", "count", "at = \"pivot.angle crosses -90 deg either\"\n") +
                 "[derived]\nperiod = \"4*quarter\"\namplitude = \"angle + pi/2\"\n");
  REQUIRE(runs.size() == 8);
  for (const auto& run : runs) {
    // k = sin(α/2) of the amplitude α from the vertical; ω₀² = m g a/(J + m
    // a²) = 9.81·0.3/(0.03 + 0.09).
    const double amplitude = value_of(run, "angle") + std::numbers::pi / 2;
    const double period = 4 * boost::math::ellint_1(std::sin(amplitude / 2)) / std::sqrt(24.525);
    CAPTURE(amplitude, run.at("formulation"));
    CHECK(value_of(run, "amplitude") == Approx(amplitude));
    CHECK(value_of(run, "period") == Approx(period).epsilon(1e-5));
    CHECK(value_of(run, "crossings") == std::floor(3 / (period / 2) + 0.5));
    CHECK_FALSE(run.contains("flight_share"));
  }
}

TEST_CASE("measures of all columns of trajectory.csv, forces.csv and signals.csv equal the written values",
          "[studies]") {
  const StudyDesk desk("motor-startup");
  const auto out = desk.at("run");
  run_scene(
      *open_scene(desk.at("scene.toml"), {"run.duration=0.08", "run.output_step=1e-4", "run.forces=true"}),
      {.formulation = "nonsmooth", .folder = out});
  // The rows between 0.02 s and 0.06 s, both included, of every table.
  const auto within = [](double t) { return t > 0.02 - 1e-9 && t < 0.06 + 1e-9; };
  std::map<std::string, std::vector<double>> written;
  for (const char* file : {"trajectory.csv", "forces.csv"}) {
    const test::Columns table(out / file);
    for (const auto& column : test::fields_of(table.header())) {
      auto& list = written[column];
      list.clear();
      for (std::size_t i = 0; i < table.rows(); ++i)
        if (within(table.at(i, "t"))) list.push_back(table.at(i, column));
      REQUIRE(list.size() == 401);
    }
  }
  std::vector<double> samples;
  for (const auto& row : test::read_csv(out / "signals.csv"))
    if (row[0] == "accelerometer" && within(std::stod(row[1]))) samples.push_back(std::stod(row[3]));
  REQUIRE(samples.size() >= 400);

  std::string text = nonsmooth +
                     "restitution = \"as-given\"\nplay = 0\ndiscard_time = 0.02\nduration = 0.04\n"
                     "[variants.given]\nset = [\"run.output_step=1e-4\"]\n";
  std::vector<std::string> columns;
  for (const auto& [column, list] : written) {
    for (const char* reduce : {"last", "mean", "max"})
      text += measure(fmt::format("m{}_{}", columns.size(), reduce), column, reduce);
    columns.push_back(column);
  }
  REQUIRE(columns.size() >= 60);
  text += measure("signal_mean", "accelerometer", "mean") + measure("signal_peak", "accelerometer", "peak") +
          measure("gap_median", "gudgeon.gap", "quantile", "q = 0.5\n") +
          measure("gap_rms", "gudgeon.gap", "rms") + measure("gap_std", "gudgeon.gap", "std") +
          measure("gap_count", "gudgeon.gap", "count") + measure("impacts", "gudgeon.impacts", "last");
  const auto runs = desk.table(text);
  REQUIRE(runs.size() == 1);
  const auto& run = runs[0];
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& list = written[columns[i]];
    const bool mean = columns[i].ends_with("_mean");
    double integral = 0, greatest = mean ? -INFINITY : list.front();
    for (std::size_t k = 1; k < list.size(); ++k) {
      integral += 1e-4 * (mean ? list[k] : 0.5 * (list[k - 1] + list[k]));
      greatest = std::max(greatest, list[k]);
    }
    double size = 0;
    for (const double x : list) size = std::max(size, std::abs(x));
    CAPTURE(columns[i]);
    CHECK(value_of(run, fmt::format("m{}_last", i)) == Approx(list.back()).margin(1e-12 * size));
    CHECK(value_of(run, fmt::format("m{}_mean", i)) == Approx(integral / 0.04).margin(1e-9 * size));
    // Ends of steps between the rows count too. The study's run ends a step at the start of its
    // window, which causes a small difference.
    CHECK(value_of(run, fmt::format("m{}_max", i)) >= greatest - 1e-7 * size);
  }
  double sum = 0, peak = 0;
  for (const double a : samples) {
    sum += a;
    peak = std::max(peak, std::abs(a));
  }
  CHECK(value_of(run, "signal_mean") == Approx(sum / static_cast<double>(samples.size())));
  CHECK(value_of(run, "signal_peak") == Approx(peak));
  auto gaps = written["gudgeon.gap"];
  double squares = 0, integral = 0;
  for (std::size_t k = 1; k < gaps.size(); ++k) {
    integral += 0.5e-4 * (gaps[k - 1] + gaps[k]) / 0.04;
    squares += 0.5e-4 * (gaps[k - 1] * gaps[k - 1] + gaps[k] * gaps[k]) / 0.04;
  }
  CHECK(value_of(run, "gap_rms") == Approx(std::sqrt(squares)));
  CHECK(value_of(run, "gap_std") == Approx(std::sqrt(squares - integral * integral)).epsilon(1e-6));
  std::ranges::sort(gaps);
  CHECK(value_of(run, "gap_median") == Approx(gaps[200]));
  CHECK(value_of(run, "gap_count") == 401);
  CHECK(value_of(run, "impacts") >= 1);
}

TEST_CASE("measures over each period and at each period", "[studies]") {
  // Oscillations of 60° about the bottom, of the period T: the greatest angle in each period is
  // that of the start, and so is the angle at the end of every period; the mean of a whole period
  // is the bottom.
  const Pendulum desk("\"-30 deg\"");
  const double period = 4 * boost::math::ellint_1(0.5) / std::sqrt(24.525), start = -std::numbers::pi / 6;
  const auto runs = desk.table(
      fmt::format(
          "scene = \"scene.toml\"\nformulations = [\"penalty\"]\nperiod = {}\nrevolutions = 4\ndiscard = 1\n",
          period) +
      measure("highest", "bar.theta", "max", each_period) +
      measure("middle", "bar.theta", "mean", each_period) +
      measure("begun", "bar.theta", "mean", every_period) +
      measure("spread", "bar.theta", "std", every_period));
  REQUIRE(runs.size() == 1);
  CHECK(value_of(runs[0], "highest") == Approx(start).margin(1e-5));
  CHECK(value_of(runs[0], "middle") == Approx(-std::numbers::pi / 2).margin(1e-5));
  CHECK(value_of(runs[0], "begun") == Approx(start).margin(1e-5));
  CHECK(value_of(runs[0], "spread") == Approx(0).margin(1e-5));
  const auto parts =
      desk.ask("select number, t, value from measures where measure = 'highest' order by number");
  REQUIRE(parts.size() == 4);
  for (std::size_t k = 0; k < 4; ++k) {
    CHECK(parts[k][0] == std::to_string(k + 1));
    CHECK(std::stod(parts[k][1]) == Approx(static_cast<double>(k + 1) * period));
    CHECK(std::stod(parts[k][2]) == Approx(start).margin(1e-5));
  }
  CHECK(desk.ask("select count(*) from measures where measure = 'begun'")[0][0] ==
        "5");  // from discard to end
}

TEST_CASE("a rotor under a periodic torque: the period is found, and means cover whole periods",
          "[studies]") {
  // J ω' = M sin(2πt/T) from rest: ω = (M/(Jw))(1 − cos wt), w = 2π/T. Over a period the mean is
  // M/(Jw), the standard deviation 1/√2 of it, the greatest value twice it, and the torque's mean
  // power zero.
  const StudyDesk desk;
  desk.put("scene.toml", "format = 2\n" + test::body("rotor", 1, 0.02) + test::pin("pin", "ground", "rotor") +
                             test::harmonic("pull", 0.1, 0.2) +
                             test::drive("motor", "pin", "torque_curve = \"pull\"\n") + test::run_for(1));
  const auto study = "scene = \"scene.toml\"\nrevolutions = 3\ndiscard = 1\n" +
                     axis("torque", "curves.pull.amplitude", "0.1, 0.3") +
                     measure("mean", "rotor.omega", "mean", each_period) +
                     measure("all", "rotor.omega", "mean") + measure("spread", "rotor.omega", "std") +
                     measure("fastest", "rotor.omega", "peak") + measure("power", "motor.power", "mean") +
                     measure("torque_mean", "motor.torque_mean", "mean");
  const auto runs = desk.table(study);
  REQUIRE(runs.size() == 4);
  for (const auto& run : runs) {
    const double rate = value_of(run, "torque") / (0.02 * 10 * std::numbers::pi);
    CAPTURE(run.at("formulation"), rate);
    CHECK(value_of(run, "mean") == Approx(rate).epsilon(1e-5));
    CHECK(value_of(run, "all") == Approx(rate).epsilon(1e-5));
    CHECK(value_of(run, "spread") == Approx(rate / std::sqrt(2)).epsilon(1e-5));
    CHECK(value_of(run, "fastest") == Approx(2 * rate).epsilon(1e-5));
    CHECK(std::abs(value_of(run, "power")) < 1e-5 * rate * value_of(run, "torque"));
    CHECK(std::abs(value_of(run, "torque_mean")) < 1e-5 * value_of(run, "torque"));
    CHECK_FALSE(run.contains("impacts_per_turn"));  // no contacts
    CHECK(value_of(run, "energy_per_turn") == 0);
  }
  CHECK(desk.ask("select count(*), min(t), max(t) from measures")[0] ==
        std::vector<std::string>{"12", "0.2", "0.6"});
  const auto page = desk.sweep(study);
  for (const auto& line : test::lines_of(page.out)) {
    CAPTURE(line);
    CHECK((line.size() <= 80 || line.starts_with("results in")));
  }
}

TEST_CASE("an accelerometer on a body without a drive: statistics of the whole window, none of turns",
          "[studies]") {
  const StudyDesk desk("bouncing-ball");
  desk.put("scene.toml", test::file_text(desk.at("scene.toml")) +
                             "[instruments.falling]\nbody = \"ball\"\naxis = [0.0, 1.0]\nbandwidth = 1000.0\n"
                             "sampling = 10000.0\n");
  const auto runs = desk.table(
      "scene = \"scene.toml\"\naccelerometer = \"falling\"\njoint = \"table\"\n"
      "discard_time = 0.05\nduration = 0.25\n");
  REQUIRE(runs.size() == 2);
  for (const auto& run : runs) {  // in free fall, after the filter's transient
    CHECK(value_of(run, "peak_max") == Approx(9.81).epsilon(1e-6));
    CHECK(value_of(run, "rms") == Approx(9.81).epsilon(1e-6));
    CHECK(value_of(run, "flight_share") == 1);
    for (const char* name :
         {"peak_median", "ratio_median", "ratio_max", "lines", "line_greatest", "impacts_per_turn"})
      CHECK_FALSE(run.contains(name));
  }
}

TEST_CASE("measures at each contact", "[studies]") {
  // A ball that falls h = 0.5 m has its first contact after t₁ = √(2h/g) with √(2gh), then contacts
  // after flights of 2e t₁, 2e² t₁ with e and e² of it: three up to t₁(1 + 2e + 2e²) = 0.798 s; the
  // fourth is beyond 0.85 s with e = 1/2 (0.878 s).
  const StudyDesk desk("bouncing-ball");
  const auto runs = desk.table(nonsmooth + "restitution = \"as-given\"\nduration = 0.85\n" +
                               measure("touches", "t", "count", "at = \"each touch of table\"\n") +
                               measure("first", "t", "first", "at = \"each touch of table\"\n") +
                               measure("second", "approach", "quantile", "at = \"each touch\"\nq = 0.5\n") +
                               "[derived]\nbounced = \"second/9.81^0.5\"  # √(2gh) = √g of half a metre\n");
  REQUIRE(runs.size() == 1);
  CHECK(value_of(runs[0], "touches") == 3);
  CHECK(value_of(runs[0], "first") == Approx(std::sqrt(1 / 9.81)).epsilon(1e-9));
  CHECK(value_of(runs[0], "bounced") == Approx(0.5).epsilon(1e-9));
  CHECK(desk.ask("select count(*) from measures where measure = 'second'")[0][0] == "3");
}

TEST_CASE("derived quantities change without a new run, and undefined values are NULL", "[studies]") {
  const StudyDesk desk("bouncing-ball");
  const auto study = nonsmooth + "duration = 0.1\n" + axis("e", "surfaces.hard.restitution", "0.5, 1") +
                     measure("low", "ball.y", "min");
  REQUIRE(desk.table(study + "[derived]\na = \"low/(1 - e)\"\n").size() == 2);
  CHECK(desk.ask("select e, a is null from named order by e") == Rows{{"0.5", "0"}, {"1.0", "1"}});
  const auto o = desk.sweep(study + "[derived]\nb = \"sqrt(e - 0.75)\"\nc = \"e > 0.75\"\n");
  CHECK_THAT(o.out, Contains("2 runs: 2 from the store, 0 new"));
  CHECK(desk.ask("select b is null, c from named order by e") == Rows{{"1", "0.0"}, {"0", "1.0"}});
  // Without measures, the view is that of the runs.
  CHECK(desk.sweep(study).status == 0);
  CHECK(desk.ask("select count(*) from pragma_table_info('named') where name in ('a', 'b', 'c')")[0][0] ==
        "0");
  // A study with another measure needs another file.
  const auto other = desk.sweep(study + measure("high", "ball.y", "max"));
  CHECK(other.status == 1);
  CHECK_THAT(other.err, Contains("contains another study"));
}

TEST_CASE("an invalid measure or window is refused before any file changes", "[studies]") {
  const StudyDesk desk("motor-startup");
  const auto said = [&](const std::string& text, const std::string& what) {
    const auto o = desk.sweep(nonsmooth + text);
    CAPTURE(text, o.out, o.err);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Contains("study.toml:") && Contains(what));
    CHECK_FALSE(std::filesystem::exists(desk.at("out")));
    return o.err;
  };
  const auto wrong = [&](const std::string& name, const std::string& column, const std::string& keys,
                         const std::string& what) {
    return said(
        fmt::format("duration = 0.1\n[measure.{}]\ncolumn = \"{}\"\nreduce = {}\n", name, column, keys),
        what);
  };
  const auto err = wrong("m", "gudgeon.gapp", "\"max\"",
                         "study.toml:5:10: measure.m.column: \"gudgeon.gapp\" is not a column, did you mean "
                         "gudgeon.gap? There are\n");
  CHECK(std::ranges::count(err, '\n') == 4);  // what is wrong, and three lines of what there is
  CHECK_THAT(err, Contains("\n  trajectory: ") && Contains("\n  forces: ") &&
                      Contains("\n  instruments and run.json: ") && Contains("gudgeon .ex .ey .gap"));
  for (const auto& [name, column, keys, what] :
       {std::tuple("m", "gap", "\"median\"", "\"median\" is unknown"),
        {"m", "gap", "\"quantile\"", "q: is missing"},
        {"m", "gap", "\"max\"\nq = 0.5", "applies only to reduce = \"quantile\""},
        {"m", "gap", "\"max\"\neach = \"period\"",
         "no drive of the scene defines a period; give study.period (s)"},
        {"m", "impacts", "\"max\"", "use reduce = \"last\""},
        {"peak_max", "gap", "\"max\"", "is a column of the results"},
        {"Peak_Max", "gap", "\"max\"", "is a column of the results"},
        {"a-b", "gap", "\"max\"", "expressions cannot use this name of the measure"},
        {"m", "gap", "\"max\"\nat = \"now and then\"", "is not a section"}})
    wrong(name, std::string("gudgeon.") + column, keys, what);
  for (const auto& [text, what] :
       {std::pair("duration = 0.1\n[derived]\nd = \"peek_max*2\"\n",
                  "study.toml:5:5: derived.d: column 1: \"peek_max\" is not a known name"),
        {"duration = 0.1\nrevolutions = 3\n", "revolutions: counts periods, but duration is in seconds"},
        {"discard_time = 0.1\n", "discard_time: needs duration, which is missing"},
        {"revolutions = 3\n", "has no drive with a period"},
        {"duration = 0.1\njoint = [\"gudgeon\", \"main\"]\n",
         "study.toml:4:9: joint: \"main\" has no clearance"},
        {"[study.axes.a]\n", "keys of a study are at the root: [axes.NAME], without study"}})
    said(text, what);
  CHECK_THAT(desk.run("calibrate").err, !Contains("nan"));
  for (const char* name : {"../x.csv", "/tmp/x.csv", "x.db", ".csv", "a/b.csv"}) {
    const auto o = desk.sweep("scene = \"scene.toml\"\nduration = 0.1\n", fmt::format("--export {}", name));
    CAPTURE(name, o.err);
    CHECK(o.status == 2);
    CHECK_THAT(o.err, Contains("must be the name of a file in the result folder"));
  }
  const auto alike = StudyDesk("bouncing-ball").sweep("scene = \"scene.toml\"\nduration = 0.1\nstarts = 3\n");
  CHECK(alike.status == 2);
  CHECK_THAT(alike.err, Contains("are identical: no drive has a prescribed speed"));
}
