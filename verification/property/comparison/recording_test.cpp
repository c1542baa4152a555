// Recording between an impact and a file: the start of a run, impulses in fast filters, noise,
// converters, and the order of tables.
#include <tuple>

#include "facade/run_folder.hpp"
#include "io/scene/write_scene.hpp"
#include "simulation/instrument.hpp"
#include "verification/references/impulses.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct Sample {
  double t, value;
};

std::vector<Sample> samples(const Scene& scene, std::string_view formulation, std::size_t channel = 0,
                            const SimulationOptions& options = {}) {
  Simulation simulation(scene, formulation, options);
  std::vector<Sample> list;
  test::Listener listener;
  listener.on_sample = [&](std::size_t i, double t, double value) {
    if (i == channel) list.push_back({t, value});
  };
  REQUIRE(simulation.run({.observers = {&listener}}).ending.status == Ending::Status::finished);
  return list;
}

/// A block flies against a wall `gap` away.
Scene thrown(double gap, double bandwidth, std::vector<std::string> sets) {
  sets.push_back(fmt::format("bodies.block.position=[0.0, {}]", 0.1 + gap));
  sets.push_back(fmt::format("bodies.plate.position=[0.0, {}]", 0.2 + gap));
  for (const char* sensor : {"felt", "force"})
    sets.push_back(fmt::format("instruments.{}.bandwidth={}", sensor, bandwidth));
  return read_scene(test::scene_file("tests/thrown_block"), sets);
}

const std::vector<std::vector<std::string>> schemes = {
    {"nonsmooth.scheme=event-driven"},
    {"nonsmooth.scheme=automatic"},
    {"nonsmooth.scheme=moreau-jean"},
    {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-6"},
    {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1e-5"},
    {"nonsmooth.scheme=moreau-jean", "nonsmooth.step=1.7e-5"}};

}  // namespace

TEST_CASE("an impact before, in or after the first step is an impulse in the filter, in every scheme",
          "[instruments][recording]") {
  const auto scheme = GENERATE(from_range(schemes));
  // At the start, within any first step, and in mid-flight; the wall's own filter is as fast as the
  // longest step.
  const double flight = GENERATE(0.0, 4e-7, 1.23456789e-3);
  const double bandwidth = GENERATE(1000.0, 20000.0);
  CAPTURE(scheme, flight, bandwidth);
  const auto scene = thrown(0.5 * flight, bandwidth, scheme);
  const double dv = 0.5 * 1.6, peak = reference::low_pass2_response(
                                   bandwidth, dv, 1.110 / (2 * std::numbers::pi * bandwidth));
  double worst = 0, worst_force = 0, seen = 0;
  for (const auto& s : samples(scene, "nonsmooth")) {
    seen = std::max(seen, std::abs(s.value));
    if (std::abs(s.t - flight) > 1e-9)
      worst = std::max(worst, std::abs(s.value - reference::low_pass2_response(bandwidth, dv, s.t - flight)));
  }
  for (const auto& s : samples(scene, "nonsmooth", 1))
    if (std::abs(s.t - flight) > 1e-9)
      worst_force = std::max(
          worst_force, std::abs(s.value - reference::low_pass2_response(bandwidth, 0.5 * dv, s.t - flight)));
  // Free flight is exact in every scheme, so the contact is known up to rounding and, with adaptive
  // time stepping, up to the tolerance of 1e-6: a shift of the instant by 1e-6 of the flight, in a
  // signal that changes by ω_c a second.
  const double shift = 1e-6 * flight * 2 * std::numbers::pi * bandwidth;
  CHECK(worst < (1e-8 + 3 * shift) * peak);
  CHECK(worst_force < (1e-8 + 3 * shift) * 0.5 * peak);
  CHECK(seen >
        // the first sample after the contact is 20 µs away at most: 0.51 of the peak there
        0.4 * peak);
}

TEST_CASE("event-driven and fixed-step runs under a table over time record finite rows on the output grid",
          "[recording][files]") {
  const auto scheme = GENERATE(from_range(schemes));
  CAPTURE(scheme);
  auto sets = scheme;
  if (sets.size() > 1) sets[1] = "nonsmooth.step=1e-3";
  const auto scene = read_scene(test::scene_file("tests/pendulum_with_table"), sets);
  test::TemporaryFolder folder;
  REQUIRE(run_scene(scene, {.formulation = "nonsmooth", .folder = folder.path() / "o"}).ending.status ==
          Ending::Status::finished);
  for (const auto& [name, rows, column] :
       {std::tuple{"trajectory.csv", 20001u, 0u}, {"forces.csv", 20001u, 0u}, {"signals.csv", 1000u, 1u}}) {
    CAPTURE(name);
    const test::Columns file(folder.path() / "o" / name);
    const double spacing = rows > 10000 ? 5e-5 : 1e-3;
    int off = 0, unsound = 0;
    for (std::size_t n = 0; n < file.rows(); ++n) {
      // Row n is at n·spacing (signals begin at 1) up to the rounding of that product; the first
      // column of signals is a name.
      const auto& row = file.row(n);
      unsound += !std::all_of(row.begin() + column, row.end(), [](double x) { return std::isfinite(x); });
      off += std::abs(row[column] - static_cast<double>(n + column) * spacing) > 1e-12;
    }
    CHECK(file.rows() == rows);
    CHECK(off == 0);
    CHECK(unsound == 0);
  }
}

TEST_CASE("no recorded file holds a non-finite number", "[recording][files]") {
  test::TemporaryFolder folder;
  for (const double bad : {std::nan(""), double(INFINITY), -double(INFINITY)}) {
    const auto path = folder.path() / "rows.csv";
    {
      OutputFile file(path);
      file.write("t,x,y\n0.5,");
      file.number(1.25);
      file.write(",");
      REQUIRE_THROWS_WITH(file.number(bad), Contains("rows.csv: cannot store") && Contains("\"0.5\"") &&
                                                Contains("after 2 numbers"));
    }
    CHECK(std::filesystem::is_empty(folder.path()));
  }
}

namespace {

/// The standard normal numbers of a channel without a signal.
std::vector<double> noise(Instrument settings, std::uint64_t run, int n) {
  settings.kind = Instrument::Kind::lvdt;
  settings.noise = 1.0;
  Channel channel(settings, run);
  std::vector<double> list;
  for (int i = 0; i < n; ++i) list.push_back(channel.take(0));
  return list;
}

double correlation(const std::vector<double>& a, const std::vector<double>& b) {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) ab += a[i] * b[i], aa += a[i] * a[i], bb += b[i] * b[i];
  return ab / std::sqrt(aa * bb);
}

/// The normal numbers of these streams are uncorrelated, also a few samples apart.
void check_uncorrelated(const std::vector<std::vector<double>>& streams, const std::vector<int>& lags) {
  for (std::size_t i = 0; i < streams.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      for (const int lag : lags) {
        CAPTURE(i, j, lag);
        const std::vector<double> a(streams[i].begin() + lag, streams[i].end()),
            b(streams[j].begin(), streams[j].end() - lag);
        CHECK(std::abs(correlation(a, b)) < 5 / std::sqrt(double(streams[i].size())));
      }
}

}  // namespace

TEST_CASE("noise: each channel, seed and run has its own stream", "[instruments][recording]") {
  constexpr int n = 20000;
  Instrument one;
  one.name = "one";
  std::vector<std::vector<double>> streams{noise(one, 7, n)};
  CHECK(streams[0] == noise(one, 7, n));  // and reproducible
  auto other = one;
  other.name = "eno";
  streams.push_back(noise(other, 7, n));
  for (const std::uint64_t run : {8, 1 << 24, 0}) streams.push_back(noise(one, run, n));
  for (const unsigned seed : {2u, 1u + (1u << 24), 1u + (1u << 31), 0u}) {
    other = one;
    other.seed = seed;
    streams.push_back(noise(other, 7, n));
  }
  // Streams that share numbers a few samples apart would show a correlation at that lag.
  // Independent ones scatter by 1/√n: of the hundred or so pairs and lags one exceeds five of that
  // once in 20 000 test runs.
  check_uncorrelated(streams, {0, 1, 2});
  for (const auto& stream : streams) {
    double mean = 0, square = 0;
    for (const double x : stream) mean += x / n, square += x * x / n;
    CHECK(std::abs(mean) < 5 / std::sqrt(double(n)));
    CHECK(std::abs(square - 1) < 5 * std::sqrt(2.0 / n));
  }
}

TEST_CASE("noise of another channel, start, setting or formulation differs; a repeated run has the same",
          "[instruments][recording]") {
  const auto scene = [](std::vector<std::string> more) {
    more.insert(more.end(), {"instruments.felt.noise=1.0", "instruments.force.noise=1.0"});
    return thrown(1, 1000, more);  // far from the wall: nothing but noise
  };
  const auto values = [&](std::string_view formulation, const Scene& s, std::size_t channel,
                          const std::optional<State>& start = {}) {
    std::vector<double> list;
    for (const auto& x : samples(s, formulation, channel, {.matched = false, .start = start}))
      list.push_back(x.value);
    return list;
  };
  const auto plain = scene({});
  auto moved = Simulation(plain, "nonsmooth").state();
  for (std::size_t y = 1; y < moved.q.size(); y += 3) moved.q[y] += 1e-9;  // of (x, y, θ) of each body
  // The penalty formulation needs elastic constants, which the scene has not.
  const auto stiff = scene({"surfaces.steel.young=1e11", "surfaces.steel.poisson=0.3"});
  const std::vector<std::vector<double>> all{values("nonsmooth", plain, 0),
                                             values("nonsmooth", plain, 1),         // another channel
                                             values("nonsmooth", plain, 0, moved),  // another start
                                             values("nonsmooth", stiff, 0),         // other settings
                                             values("penalty", stiff, 0)};          // another formulation
  CHECK(values("nonsmooth", plain, 0) == all[0]);
  REQUIRE(all[0].size() == 100);  // 2 ms at 50 kHz
  check_uncorrelated(all, {0});   // each pair, no lag
}

TEST_CASE("codes of a converter are integer multiples of its resolution within its range",
          "[instruments][recording]") {
  Instrument settings;
  settings.kind = Instrument::Kind::lvdt;
  const auto shown = [&](double x) { return Channel(settings).take(x); };
  settings.range = 1.0;
  settings.resolution = 0.3;
  for (const auto& [x, code] :
       {std::pair{5.0, 3}, {-5.0, -3}, {0.95, 3}, {-0.95, -3}, {0.5, 1}, {-0.05, -1}, {0.0, 0}})
    CHECK(shown(x) == Approx(0.3 * code).margin(1e-15));
  settings.resolution = 0.1;  // 1.0 is its tenth code
  CHECK(shown(7) == Approx(1.0).epsilon(1e-15));
  CHECK(shown(-7) == Approx(-1.0).epsilon(1e-15));
  settings.range = 0.3;  // 0.3/0.1 is 3 up to rounding
  CHECK(shown(7) == Approx(0.3).epsilon(1e-15));
  settings.resolution.reset();
  CHECK(shown(7) == 0.3);
  CHECK(shown(-7) == -0.3);
  CHECK(shown(0.1234) == 0.1234);
  // Noise belongs to the sensor: it is converted with the signal, and saturated values stay within
  // the range.
  settings.resolution = 0.1;
  settings.noise = 10.0;
  Channel noisy(settings);
  std::set<int> codes;
  for (int i = 0; i < 1000; ++i) {
    const double code = noisy.take(0) / 0.1;
    CHECK(std::abs(code - std::round(code)) < 1e-9);
    codes.insert(static_cast<int>(std::round(code)));
  }
  CHECK(*codes.begin() == -3);
  CHECK(*codes.rbegin() == 3);
}

TEST_CASE("tables made by options follow those of the file, in the order of the options",
          "[scene][recording]") {
  const std::string text = test::body("wheel", 1.0, 0.1) + test::body("arm", 1.0, 0.1) +
                           test::pin("axle", "ground", "wheel") + test::pin("pin", "ground", "arm") +
                           test::motor("motor", "axle", 3.0) + R"([run]
revolutions = 2
[instruments.zero]
type = "encoder"
joint = "axle"
sampling = 10.0
counts = 100
)";
  const std::vector<std::string> second{"drives.a.joint=pin", "drives.a.speed=-7"};
  auto with = second;
  with.insert(with.end(),
              {"instruments.b.type=lvdt", "instruments.b.body=arm", "instruments.b.sampling=10",
               "instruments.a={type=\"lvdt\", body=\"arm\", sampling=10}", "drives.motor.speed=4"});
  const auto scene = parse_scene(text, "order.toml", with);
  REQUIRE(scene.mechanism.drives.size() == 2);
  CHECK(name_of(scene.mechanism.drives[0]) == "motor");
  CHECK(main_drive(scene.mechanism)->name == "motor");
  // two revolutions of the file's drive
  CHECK(scene.run.duration == Approx(2 * 2 * std::numbers::pi / 4));
  REQUIRE(scene.instruments.size() == 3);
  CHECK(scene.instruments[0].name == "zero");
  CHECK(scene.instruments[1].name == "b");
  CHECK(scene.instruments[2].name == "a");

  // Unless the other drive is named.
  auto named = second;
  named.emplace_back("drives.a.crank=true");
  const auto chosen = parse_scene(text, "order.toml", named);
  CHECK(main_drive(chosen.mechanism)->name == "a");
  CHECK(chosen.run.duration == Approx(2 * 2 * std::numbers::pi / 7));
  CHECK(Simulation(chosen, "nonsmooth").layout().crank_speed == -7);
  CHECK(to_toml(parse_scene(to_toml(chosen), "again")) == to_toml(chosen));
  named.emplace_back("drives.motor.crank=true");
  CHECK_THROWS_WITH(parse_scene(text, "order.toml", named),
                    Contains("drives.a.crank: drives.motor already counts the revolutions; only one drive "
                             "may"));
}
