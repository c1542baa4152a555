// A measured signal in the long format of signals.csv: the samples of one channel are read as those
// of a table with a column of accelerations.
#include "measure/measurement.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

constexpr double speed = 2 * std::numbers::pi;  // one revolution a second

/// Three revolutions with 100 samples each in two channels, in alternating rows.
std::string two_channels(double radians_per_second) {
  std::string text = "channel,t,crank_angle,value\n";
  for (int i = 0; i < 300; ++i) {
    const double t = 0.5 + 0.01 * i, angle = 0.7 + radians_per_second * (t - 0.5);
    text += fmt::format("lvdt,{},{},{}\naccelerometer,{},{},{}\n", t, angle, 0.05, t, angle,
                        10 * std::cos(speed * t));
  }
  return text;
}

}  // namespace

TEST_CASE("a channel of the long format is read like a column", "[study]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "signals.csv";
  write_file(file, two_channels(speed));
  const auto m = read_measurement(file, speed, 10, "accelerometer");
  REQUIRE(m.acceleration.size() == 300);
  for (std::size_t i = 0; i < 300; ++i) {
    CHECK(m.time[i] == Approx(0.01 * static_cast<double>(i)).margin(1e-9));
    CHECK(m.acceleration[i] == Approx(10 * std::cos(speed * (0.5 + m.time[i]))).margin(1e-9));
  }
  CHECK(m.sampling == Approx(100));
  // The angle of the first sample is the datum: 0.7 rad.
  CHECK(m.datum);
  CHECK(m.start_angle == Approx(0.7 * 180 / std::numbers::pi));
}

TEST_CASE("the long format without the channel or with angles in degrees is refused", "[study][errors]") {
  const test::TemporaryFolder folder;
  const auto file = folder.path() / "signals.csv";
  const auto says = [&](const std::string& channel) {
    return test::refusal_of<SceneError>([&] { read_measurement(file, speed, 10, channel); });
  };
  write_file(file, two_channels(speed));
  CHECK_THAT(says("probe"),
             Contains("has no channel \"probe\", the scene's accelerometer; it has accelerometer, lvdt"));
  write_file(file, two_channels(360));
  CHECK_THAT(says("accelerometer"), Contains("must be in radians"));
  write_file(file, "channel,t,crank_angle,value\n");
  CHECK_THAT(says("accelerometer"), Contains("has no samples"));
  write_file(file, "channel,value\naccelerometer,1\n");
  CHECK_THAT(says("accelerometer"), Contains("or channel, t and value as in signals.csv"));
}
