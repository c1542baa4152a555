// Measured signals: accepted and refused forms of a table, and the long format of signals.csv, of
// which the samples of one channel are read as those of a table with a column of accelerations.
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

/// A file of three revolutions with 100 samples each.
template <class Line>
std::filesystem::path table(const test::TemporaryFolder& folder, const std::string& head, const Line& line) {
  std::string text = head + "\n";
  for (int i = 0; i < 300; ++i) text += std::string(line(i)) + "\n";
  write_file(folder.path() / "data.csv", text);
  return folder.path() / "data.csv";
}

std::string two_numbers(double t, double a) { return fmt::format("{},{}", t, a); }
double wave(int i) { return 10 * std::cos(speed * 0.01 * i); }

}  // namespace

TEST_CASE("a measured table has times or crank angles, units in their usual spellings, an uncertainty",
          "[study]") {
  const test::TemporaryFolder folder;
  const auto good = read_measurement(table(folder, "t,acceleration,uncertainty",
                                           [](int i) { return two_numbers(0.01 * i, wave(i)) + ",0.5"; }),
                                     speed, 10);
  CHECK(good.sampling == Approx(100));
  CHECK(good.acceleration.size() == 300);
  CHECK(good.uncertainty == Approx(0.5));
  const auto angles =
      read_measurement(table(folder, "crank_angle,acceleration",
                             [](int i) { return two_numbers(std::fmod(40 + 3.6 * i, 360), wave(i)); }),
                       speed, 10);
  CHECK(angles.sampling == Approx(100));
  CHECK(angles.start_angle == Approx(40));
  for (const char* head : {"t (s),acceleration (m/s²)", "time [s],acceleration [m/s^2]", "t(s),acceleration"})
    CHECK(
        read_measurement(table(folder, head, [](int i) { return two_numbers(0.01 * i, wave(i)); }), speed, 10)
            .acceleration == good.acceleration);
}

TEST_CASE("a measured table with other units, gaps or values that are no acceleration is refused",
          "[study]") {
  const test::TemporaryFolder folder;
  struct Case {
    const char* head;
    std::function<std::string(int)> line;
    const char* message;
  };
  const auto plain = [](int i) { return two_numbers(0.01 * i, wave(i)); };
  for (const auto& [head, line, message] :
       {Case{"t (s),acceleration (g)", plain,
             "data.csv:1: column acceleration: the unit \"g\" is not accepted; it must be in m/s²"},
        {"t (ms),acceleration", plain, "column t: the unit \"ms\" is not accepted; it must be in s"},
        {"crank_angle (rad),acceleration", plain, "must be in degrees"},
        {"time,acceleration (m/s²)", plain, "the header must name"},
        {"t;acceleration", [](int i) { return fmt::format("0,{:02};1,5", i); },
         "data.csv:1: the columns are separated by semicolons; separate them by commas, and write numbers "
         "with a decimal point, not a decimal comma"},
        {"acceleration", [](int) { return "1"; }, "data.csv:1: the header must name"},
        {"t,acceleration", [](int i) { return std::to_string(i); }, ":2: has 1 field,"},
        {"t,acceleration", [&](int i) { return i == 7 ? "0.07,nan" : plain(i); },
         ":9: acceleration: \"nan\" is not a finite number"},
        {"t,acceleration", [](int i) { return two_numbers(0.01 * (i < 90 ? i : i + 20), wave(i)); },
         ":92: a gap of 0.21 s"},
        {"t,acceleration", [](int i) { return two_numbers(0.01 * (i == 50 ? 3 : i), wave(i)); },
         "must increase"},
        {"t,acceleration", [](int i) { return two_numbers(0.01 * i, 1000 * wave(i)); },
         "acceleration must be in m/s²"},
        {"t,acceleration", [](int i) { return two_numbers(1e-5 * i, wave(i)); },
         "less than a turn of the crank"}})
    CHECK_THAT(
        test::refusal_of([&, &h = head, &l = line] { read_measurement(table(folder, h, l), speed, 10); }),
        Contains(message));
  CHECK_THAT(test::refusal_of([&] { read_measurement(folder.path() / "none.csv", speed, 10); }),
             Contains("no such file"));
}

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
