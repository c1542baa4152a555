#include "measure/measurement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/scene/points_file.hpp"
#include "measure/turns.hpp"
#include "mechanism/error.hpp"

namespace freeplay {
namespace {

/// A column of the header, "acceleration" or "acceleration (m/s²)", and the spellings of its unit.
struct KnownColumn {
  std::string_view name;
  std::vector<std::string_view> units;  ///< the first is named in messages
};
const KnownColumn known_columns[] = {{"t", {"s"}},
                                     {"crank_angle", {"degrees", "deg", "°", "degree"}},
                                     {"acceleration", {"m/s²", "m/s^2", "m/s2", "m/s**2", "m s^-2", "m·s⁻²"}},
                                     {"value", {"m/s²", "m/s^2", "m/s2", "m/s**2", "m s^-2", "m·s⁻²"}},
                                     {"uncertainty", {"m/s²", "m/s^2", "m/s2", "m/s**2", "m s^-2", "m·s⁻²"}}};

/// The names of a header without their units in brackets. `fail` throws an error for a unit that is
/// not the expected one.
template <class Fail>
std::vector<std::string> names_of(const std::vector<std::string>& header, bool long_format,
                                  const Fail& fail) {
  std::vector<std::string> names;
  for (const auto& field : header) {
    names.push_back(field);
    const auto open = field.find_first_of("([");
    if (open == field.npos || open == 0 || (field.back() != ')' && field.back() != ']')) continue;
    auto name = trimmed(field.substr(0, open));
    const auto unit = trimmed(field.substr(open + 1, field.size() - open - 2));
    if (name == "time" || name == "Time") name.assign(1, 't');
    const auto* known = std::ranges::find(known_columns, name, &KnownColumn::name);
    if (known == std::end(known_columns)) continue;
    const bool radians = long_format && name == "crank_angle";
    if (radians ? unit != "rad" : std::ranges::find(known->units, unit) == known->units.end())
      fail(fmt::format("column {}: the unit \"{}\" is not accepted; it must be in {}", name, visible(unit),
                       radians ? "rad" : known->units.front()));
    names.back() = name;
  }
  return names;
}

/// Unit of the last digit of a written number.
double last_digit(const std::string& text) {
  const auto e = text.find_first_of("eE"), point = text.find('.');
  const double decimals = point == text.npos ? 0 : static_cast<double>(std::min(e, text.size()) - point - 1);
  return std::pow(10.0, (e == text.npos ? 0 : std::atof(text.c_str() + e + 1)) - decimals);
}

/// Makes times uniform if they differ from uniform times only by rounding to the last digit.
void make_even(std::vector<double>& times, double digit) {
  const double step = times.back() / static_cast<double>(times.size() - 1);
  for (std::size_t i = 0; i < times.size(); ++i)
    if (std::abs(times[i] - static_cast<double>(i) * step) > 1.01 * digit + 1e-6 * step) return;
  for (std::size_t i = 0; i < times.size(); ++i) times[i] = static_cast<double>(i) * step;
}

/// The channels of a file in the long format, of which one is read.
class ChannelChoice {
 public:
  /// `column`: of the channels; −1: the file is not in the long format.
  ChannelChoice(int column, std::string wanted) : column_(column), wanted_(std::move(wanted)) {}
  bool takes(const std::vector<std::string>& fields) {
    if (column_ < 0 || fields[static_cast<std::size_t>(column_)] == wanted_) return true;
    others_.insert(fields[static_cast<std::size_t>(column_)]);
    return false;
  }
  /// Message for a file without samples of the channel; empty for any other file.
  std::string lacks(std::size_t samples) const {
    if (column_ < 0 || samples > 0) return "";
    return others_.empty()
               ? "has no samples"
               : fmt::format("has no channel \"{}\", the scene's accelerometer; it has {}", visible(wanted_),
                             visible(fmt::format("{}", fmt::join(others_, ", "))));
  }

 private:
  int column_;
  std::string wanted_;
  std::set<std::string> others_;
};

}  // namespace

Measurement read_measurement(const std::filesystem::path& file, double speed, double ideal_maximum,
                             const std::string& channel) {
  const auto fail = [&](long line, const std::string& what) {
    throw SceneError(line > 0 ? fmt::format("{}:{}: {}", file.string(), line, what)
                              : fmt::format("{}: {}", file.string(), what));
  };
  LineReader in(file);
  std::string line;
  if (!in.next(line)) fail(0, "is empty; expected a header with t or crank_angle, and acceleration");
  if (const auto what = wrong_separator(line); !what.empty()) fail(1, what);
  const auto header = fields(line);
  const bool has_channels = std::ranges::find(header, "channel") != header.end();
  const auto names = names_of(header, has_channels, [&](const std::string& what) { fail(1, what); });
  const auto place = [&](const char* name) {
    const auto it = std::ranges::find(names, name);
    return it == names.end() ? -1 : static_cast<int>(it - names.begin());
  };
  const bool in_rows = place("channel") >= 0 && place("value") >= 0 && place("acceleration") < 0;
  const int t = place("t"), angle = in_rows ? -1 : place("crank_angle"),
            a = place(in_rows ? "value" : "acceleration"), u = place("uncertainty");
  // An angle beside the time gives the crank angle of the first sample.
  const int beside = in_rows ? place("crank_angle") : -1;
  if (a < 0 || (t < 0) == (angle < 0))
    fail(1,
         fmt::format("the header must name acceleration (m/s²) and one of t (s) and crank_angle (degrees), "
                     "or channel, t and value as in signals.csv, is \"{}\"",
                     visible(trimmed(line))));
  ChannelChoice choice(in_rows ? place("channel") : -1, channel);

  Measurement m;
  std::vector<double> times;
  std::vector<long> lines;
  double squares = 0, wraps = 0, last = 0, digit = INFINITY;
  double first_beside = 0, last_beside = 0;  // rad
  int sense = 0;  // +1 if the angles increase from line to line, −1 if they decrease
  while (in.next(line)) {
    const long number = in.number();
    if (trimmed(line).empty() || line[0] == '#') continue;
    const auto list = fields(line);
    if (list.size() != names.size()) fail(number, wrong_count(list.size(), names.size()));
    if (!choice.takes(list)) continue;
    const auto value = [&](int column) {
      const auto& text = list[column];
      const auto x = number_in(text);
      if (!x || !std::isfinite(*x))
        fail(number, fmt::format("{}: \"{}\" is not a finite number", names[column], text));
      return *x;
    };
    double time = value(t >= 0 ? t : angle);
    if (angle >= 0) {
      if (!times.empty()) {
        if (sense == 0) sense = (time > last) == (std::abs(time - last) < 180) ? 1 : -1;
        if (sense * (time - last) < -180) wraps += sense * 360;
      }
      last = time;
      time += wraps;
      if (sense < 0) time = -time;
      if (times.size() == 1 && sense < 0) times[0] = -times[0];
    }
    if (!times.empty() && time <= times.back())
      fail(number, angle >= 0 ? "crank_angle must increase from line to line, or decrease"
                              : "t must increase from line to line");
    if (beside >= 0) {
      last_beside = value(beside);
      if (times.empty()) first_beside = last_beside;
    }
    digit = std::min(digit, last_digit(list[t >= 0 ? t : angle]));
    times.push_back(time);
    lines.push_back(number);
    m.acceleration.push_back(value(a));
    if (u >= 0) squares += value(u) * value(u);
  }
  if (const auto what = choice.lacks(times.size()); !what.empty()) fail(0, what);
  if (times.size() < 10)
    fail(0, fmt::format("has {} samples; at least one turn of the crank is needed", times.size()));
  const double turn = 2 * std::numbers::pi / std::abs(speed);
  const double first = times.front();
  if (angle >= 0) {
    m.datum = true;
    m.start_angle = sense < 0 ? -first : first;
    const double scale = std::numbers::pi / 180 / std::abs(speed);  // s per degree
    for (double& x : times) x = (x - first) * scale;
    digit *= scale;
    if (sense * speed < 0) {  // the lines run backwards in time
      m.start_angle += sense * 360 * times.back() / turn;
      const double end = times.back();
      std::ranges::reverse(times);
      for (double& x : times) x = end - x;
      std::ranges::reverse(m.acceleration);
      std::ranges::reverse(lines);
    }
    m.start_angle = std::fmod(m.start_angle, 360);
  } else {
    for (double& x : times) x -= first;
  }
  const double span = times.back();
  if (beside >= 0) {
    if (const double turned = (last_beside - first_beside) / (speed * span); std::abs(turned - 1) > 0.1)
      fail(0,
           fmt::format("crank_angle advances by {:.4g} between the first and the last sample, {:.3g} times "
                       "the scene's crank; beside t it must be in radians and continuous",
                       last_beside - first_beside, turned));
    m.datum = true;
    m.start_angle = std::fmod(first_beside * 180 / std::numbers::pi, 360);
  }
  if (whole_turns(times.size(), span, turn) < 1)
    fail(0,
         t >= 0
             ? fmt::format("spans {:.4g} s, less than a turn of the crank ({:.4g} s); t must be in seconds",
                           span, turn)
             : fmt::format(
                   "spans {:.4g} degrees, less than a turn of the crank; crank_angle must be in degrees",
                   360 * span / turn));
  if (span > 1e5 * turn)
    fail(0, fmt::format("spans {:.4g} turns of the crank; t must be in seconds", span / turn));

  std::vector<double> steps;
  for (std::size_t i = 1; i < times.size(); ++i) steps.push_back(times[i] - times[i - 1]);
  auto middle = steps.begin() + static_cast<long>(steps.size() / 2);
  std::ranges::nth_element(steps, middle);
  const double step = *middle;
  for (std::size_t i = 1; i < times.size(); ++i)
    if (times[i] - times[i - 1] > 3.5 * step)
      fail(lines[i], fmt::format("a gap of {:.4g} s before this line (sampling interval {:.4g} s); split "
                                 "the file or fill the gap",
                                 times[i] - times[i - 1], step));
  constexpr double least = 16;
  if (turn / step < least)
    fail(0, fmt::format("has {:.3g} samples a turn of the crank, fewer than {}; {}", turn / step, least,
                        t >= 0 ? "t must be in seconds" : "crank_angle must be in degrees"));
  make_even(times, digit);
  m.sampling = static_cast<double>(times.size() - 1) / span;
  m.uncertainty = u >= 0 ? std::sqrt(squares / static_cast<double>(times.size())) : 0;
  m.time = std::move(times);

  double greatest = 0;
  for (double x : m.acceleration) greatest = std::max(greatest, std::abs(x));
  if (ideal_maximum > 0 && (greatest > 300 * ideal_maximum || greatest < ideal_maximum / 300))
    fail(0,
         fmt::format("its greatest acceleration, {:.4g}, is {:.2g} times that of the ideal mechanism ({:.4g} "
                     "m/s²): acceleration must be in m/s²",
                     greatest, greatest / ideal_maximum, ideal_maximum));
  return m;
}

}  // namespace freeplay
