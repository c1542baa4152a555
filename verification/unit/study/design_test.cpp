// Choice of a study's points: strata, the first Sobol points, ranges, keys that vary together, and
// filters.
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Desk : test::StudyDesk {
  Study study(const std::string& text) const { return read("scene = \"scene.toml\"\n" + text); }
  /// The text must be refused at a place of the study.
  void refuses(const std::string& text, const std::string& message) const {
    CAPTURE(text);
    CHECK_THAT(test::refusal_of<SceneError>([&] { cells(study(text)); }),
               Contains("study.toml:") && Contains(message));
  }
};

}  // namespace

TEST_CASE("the first Sobol points are those of Joe and Kuo", "[design]") {
  // As printed beside their generator (new-joe-kuo-6.21201), without the origin; the last three coordinates
  // by its recurrence of direction numbers, m_k = 2a₁m_{k−1} ⊕ … ⊕ 2^s m_{k−s} ⊕ m_{k−s}.
  const std::vector<std::vector<double>> printed{{0.5, 0.5, 0.5, 0.5, 0.5, 0.5},
                                                 {0.75, 0.25, 0.25, 0.25, 0.75, 0.75},
                                                 {0.25, 0.75, 0.75, 0.75, 0.25, 0.25},
                                                 {0.375, 0.375, 0.625, 0.875, 0.375, 0.125},
                                                 {0.875, 0.875, 0.125, 0.375, 0.875, 0.625},
                                                 {0.625, 0.125, 0.875, 0.625, 0.625, 0.875},
                                                 {0.125, 0.625, 0.375, 0.125, 0.125, 0.375}};
  CHECK(unit_points(DrawMethod::sobol, 6, 7, 1) == printed);
  CHECK(unit_points(DrawMethod::sobol, 6, 7, 2) == printed);  // no random numbers are used
}

TEST_CASE("a Latin hypercube has one point in each stratum of each coordinate", "[design]") {
  for (const int n : {1, 2, 7, 100}) {
    const auto points = unit_points(DrawMethod::latin_hypercube, 3, n, 5);
    for (std::size_t d = 0; d < 3; ++d) {
      std::set<int> strata;
      for (const auto& p : points) strata.insert(static_cast<int>(p[d] * n));
      CHECK(strata.size() == static_cast<std::size_t>(n));
      CHECK(*strata.begin() == 0);
      CHECK(*strata.rbegin() == n - 1);
    }
  }
  const auto points = unit_points(DrawMethod::latin_hypercube, 2, 100, 5);
  CHECK(points == unit_points(DrawMethod::latin_hypercube, 2, 100, 5));
  CHECK(points != unit_points(DrawMethod::latin_hypercube, 2, 100, 6));
  // Not along a diagonal: the strata of two coordinates are permuted relative to each other. For
  // two independent permutations of 100 the correlation has the standard deviation 1/√99.
  double sum = 0;
  for (const auto& p : points) sum += (p[0] - 0.5) * (p[1] - 0.5) * 12 / 100;
  CHECK(std::abs(sum) < 5 / std::sqrt(99.0));
}

TEST_CASE("random points are uniform and independent", "[design]") {
  const auto points = unit_points(DrawMethod::random, 2, 10000, 3);
  double mean = 0, square = 0, product = 0;
  for (const auto& p : points) {
    CHECK((p[0] >= 0 && p[0] < 1));
    mean += p[0] / 10000;
    square += p[0] * p[0] / 10000;
    product += p[0] * p[1] / 10000;
  }
  CHECK(std::abs(mean - 0.5) < 5 * std::sqrt(1 / 12.0 / 10000));
  CHECK(std::abs(square - 1 / 3.0) < 5 * std::sqrt(4 / 45.0 / 10000));
  CHECK(std::abs(product - 0.25) < 5 * std::sqrt(7 / 144.0 / 10000));
  CHECK(points == unit_points(DrawMethod::random, 2, 10000, 3));
  CHECK(points != unit_points(DrawMethod::random, 2, 10000, 4));
}

TEST_CASE("axes of a study: lists, ranges, units, several keys", "[design][study]") {
  const Desk desk;
  const auto values = [&](const std::string& axis) {
    return desk.study("[axes.a]\n" + axis).axes.at(0).values;
  };
  const std::string clearance = "key = \"joints.gudgeon.clearance\"\n";
  CHECK(values(clearance + "values = [\"0.1 mm\", 2e-4]") == std::vector{1e-4, 2e-4});
  CHECK(values(clearance + "range = [\"1 mm\", \"2 mm\", 3]") == std::vector{1e-3, 1.5e-3, 2e-3});
  const auto ratios = values("key = \"surfaces.a.restitution\"\nlog_range = [0.125, 1, 4]");
  REQUIRE(ratios.size() == 4);
  CHECK(ratios.front() == 0.125);
  CHECK(ratios[1] == Approx(0.25));
  CHECK(ratios[2] == Approx(0.5));
  CHECK(ratios.back() == 1);

  const auto one_value =
      cells(desk.study("[axes.a]\nkeys = [\"joints.a.clearance\", \"joints.b.clearance\"]\n"
                       "values = [\"0.1 mm\", \"0.2 mm\"]"));
  REQUIRE(one_value.size() == 2);
  CHECK(one_value[1].overrides ==
        std::vector<std::string>{"joints.a.clearance=0.0002", "joints.b.clearance=0.0002"});
  const auto within = cells(desk.study("[axes.a]\nkey = \"joints.a.at[1][0]\"\nvalues = [\"2 mm\"]"));
  CHECK(within.at(0).overrides == std::vector<std::string>{"joints.a.at[1][0]=0.002"});
  const auto own =
      cells(desk.study("[axes.a]\nkeys = [\"joints.a.clearance\", \"surfaces.s.restitution\"]\n"
                       "values = [[\"0.1 mm\", 0.5], [\"0.2 mm\", 0.25]]"));
  REQUIRE(own.size() == 2);
  CHECK(own[0].values == std::vector{1e-4});
  CHECK(own[1].overrides ==
        std::vector<std::string>{"joints.a.clearance=0.0002", "surfaces.s.restitution=0.25"});

  const auto says = [&](const std::string& axis, const std::string& message) {
    desk.refuses("[axes.a]\n" + axis, message);
  };
  says(clearance, "axes.a.values: is missing: give values, range, log_range, or low and high");
  says(clearance + "values = [1]\nrange = [1, 2, 3]",
       "needs exactly one of values, range, log_range, and low with high");
  says(clearance + "range = [1, 2]", "must be [low, high, n], has 2 numbers");
  says(clearance + "range = [2, 1, 3]", "high must be greater than low");
  says(clearance + "range = [1, 2, 2.5]", "n must be a whole number from 2, is 2.5");
  says(clearance + "log_range = [0, 1, 3]", "low must be greater than 0 for equal ratios");
  says(clearance + "values = [\"1 kg\"]", "is a mass, must be a length");
  says(clearance + "low = 1\nhigh = 2", "and sample, their design, is missing");
  says("keys = [\"joints.a.clearance\", \"surfaces.s.restitution\"]\nvalues = [1]",
       "so one value cannot serve both");
  says("keys = [\"joints.a.clearance\", \"joints.b.clearance\"]\nvalues = [[1, 2], [1, 3]]",
       "1 occurs twice");
  says("keys = [\"joints.a.clearance\", \"joints.b.clearance\"]\nvalues = [[1, 2], [1]]",
       "must be a list of 2 numbers");
  says("keys = [\"joints.a.clearance\"]\nkey = \"x\"\nvalues = [1]", "and key are given");
  says(clearance +
           "values = [1]\n[axes.b]\nkeys = [\"joints.x.clearance\", \"joints.gudgeon.clearance\"]\n"
           "values = [1]",
       "joints.gudgeon.clearance is already varied by axis a");
  says(clearance + "values = [1]\nspacing = \"log\"", "does not apply to an axis without random values");
}

TEST_CASE("axes of a study: random samples, combinations and filters", "[design][study]") {
  const Desk desk;
  const std::string axes = R"([axes.clearance]
key = "joints.gudgeon.clearance"
low = "0.1 mm"
high = "1.6 mm"
spacing = "log"
[axes.speed]
key = "drives.motor.speed_rpm"
low = 100
high = 300
)";
  const auto list = cells(desk.study("sample = \"sobol\"\nsamples = 3\n" + axes));
  REQUIRE(list.size() == 3);
  // (0.5, 0.5), (0.75, 0.25), (0.25, 0.75): 0.1·16^u mm and 100 + 200u.
  CHECK(list[0].values[0] == Approx(0.4e-3));
  CHECK(list[0].values[1] == 200);
  CHECK(list[1].values[0] == Approx(0.8e-3));
  CHECK(list[1].values[1] == 150);
  CHECK(list[2].values[0] == Approx(0.2e-3));
  CHECK(list[2].values[1] == 250);
  CHECK(cells(desk.study("sample = \"sobol\"\nsamples = 3\nwhere = \"clearance*speed > 0.1\"\n" + axes))
            .size() == 1);
  CHECK(cells(desk.study("sample = \"latin-hypercube\"\nsamples = 4\n" + axes +
                         "[axes.e]\nkey = \"surfaces.s.restitution\"\nvalues = [0.1, 0.2]"))
            .size() == 8);
  desk.refuses("sample = \"sobol\"\n" + axes, "samples: is missing");
  desk.refuses("samples = 4\n[axes.e]\nkey = \"surfaces.s.restitution\"\nvalues = [0.1, 0.2]",
               "samples: needs sample");
  desk.refuses("sample = \"sobol\"\nsamples = 4\n[axes.e]\nkey = \"surfaces.s.restitution\"\nvalues = [0.1]",
               "needs an axis with random values");
  desk.refuses("sample = \"halton\"\nsamples = 4\n" + axes, "\"halton\" is unknown");
  desk.refuses("sample = \"random\"\nsamples = 1000000\n" + axes, "above the limit of 1000000");
  desk.refuses("sample = \"sobol\"\nsamples = 4\nwhere = \"clearance + 1\"\n" + axes,
               "study.toml:4:9: where: column 1: is a number");
  desk.refuses("sample = \"sobol\"\nsamples = 4\nwhere = \"clearence > 1\"\n" + axes,
               "did you mean clearance?");
  desk.refuses("sample = \"sobol\"\nsamples = 4\nwhere = \"peak_max > 1\"\n" + axes,
               "\"peak_max\" is not a known name");
  desk.refuses("sample = \"sobol\"\nsamples = 4\nwhere = \"clearance > 1\"\n" + axes,
               "selects no cell of the axes");
}
