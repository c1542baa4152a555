#include "plots/drawing/axis.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "io/scene/quantity.hpp"
#include "mechanism/error.hpp"

namespace freeplay::plots {
namespace {

/// SI units that take prefixes; m only those for small lengths.
constexpr std::pair<std::string_view, int> with_prefixes[] = {{"m", 0},   {"s", 0}, {"m/s", 0}, {"N", 9},
                                                              {"N m", 9}, {"W", 9}, {"N s", 9}};
constexpr std::pair<int, std::string_view> unit_prefixes[] = {{-12, "p"}, {-9, "n"}, {-6, "µ"}, {-3, "m"},
                                                              {3, "k"},   {6, "M"},  {9, "G"}};

std::string superscript(int n) {
  constexpr std::string_view digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text = n < 0 ? "⁻" : "";
  for (const char c : std::to_string(std::abs(n))) text += digits[c - '0'];
  return text;
}

/// Significant digits that tell neighbouring tics apart; at least six.
int digits_of(const Axis& axis) {
  const double size = std::max({std::abs(axis.low), std::abs(axis.high), axis.step});
  return std::clamp(
      1 + static_cast<int>(std::floor(std::log10(size)) - std::floor(std::log10(axis.step) + 1e-9)), 6, 15);
}

/// Place of a value between the ends of an axis, 0 to 1.
double share_of(const Axis& axis, double x) {
  return axis.logarithmic ? std::log(x / axis.low) / std::log(axis.high / axis.low)
                          : (x - axis.low) / (axis.high - axis.low);
}

double nearest_tic(double x, double step) { return std::round(x / step) * step; }

/// Steps 1, 2, 5 times powers of ten, or parts of a turn, in increasing order from `least`.
double next_step(double step, bool turn) {
  if (turn)
    for (const double part : {15.0, 30.0, 45.0, 60.0, 90.0, 120.0, 180.0, 360.0})
      if (part > step * (1 + 1e-9)) return part;
  const double power = std::pow(10, std::floor(std::log10(step) + 1e-9));
  const double first = step / power;
  return power * (first < 1.5 ? 2 : first < 3 ? 5 : 10);
}

}  // namespace

std::size_t letters(std::string_view text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string shortened(const std::string& text, std::size_t most) {
  const auto n = letters(text);
  if (n <= most || most < 3) return text;
  const std::size_t front = (most - 1) / 2, back = n - (most - 1 - front);
  std::string out;
  std::size_t i = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (at > 0 && (static_cast<unsigned char>(text[at]) & 0xC0) != 0x80) ++i;
    if (i < front || i >= back) out += text[at];
    if (i == front && (at + 1 == text.size() || (static_cast<unsigned char>(text[at + 1]) & 0xC0) != 0x80))
      out += "…";
  }
  return out;
}

ShownUnit fitting_unit(std::string_view si, double greatest) {
  if (!(greatest > 0) || !std::isfinite(greatest) || (greatest >= 0.1 && greatest < 1e4))
    return {printed(si), 1};
  const int power = 3 * static_cast<int>(std::floor(std::log10(greatest) / 3 + 1e-12));
  if (power == 0) return {printed(si), 1};
  const double size = std::pow(10.0, power);
  const auto unit = std::ranges::find(with_prefixes, si, &std::pair<std::string_view, int>::first);
  const auto prefix = std::ranges::find(unit_prefixes, power, &std::pair<int, std::string_view>::first);
  if (unit != std::end(with_prefixes) && prefix != std::end(unit_prefixes) && power <= unit->second)
    return {fmt::format("{}{}", prefix->second, si), size};
  return {fmt::format("10{}{}{}", superscript(power), si.empty() ? "" : " ", printed(si)), size};
}

ShownUnit unit_named(const std::string& name, std::string_view si) {
  const auto one = read_quantity("1 " + name, si);
  if (!one.wrong.empty()) throw SceneError(one.wrong);
  return {printed(name), one.value};
}

std::string printed(std::string_view unit) {
  if (unit == "deg" || unit == "degree" || unit == "degrees") return "°";
  std::string out;
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const char c = unit[i];
    if (c == '^') continue;
    if (c >= '2' && c <= '9')
      out += superscript(c - '0');
    else if (c == '-' && i + 1 < unit.size())
      out += superscript(-(unit[i + 1] - '0')), ++i;
    else if (c == 'u' && (i == 0 || unit[i - 1] == ' ' || unit[i - 1] == '/') && i + 1 < unit.size() &&
             std::string_view("msNgJW").find(unit[i + 1]) != std::string_view::npos)
      out += "µ";
    else
      out += c;
  }
  return out;
}

AxisTitle AxisTitle::of(Word quantity, std::string unit) {
  return {Script().add("'{}'", quantity), letters(quantity.text()), std::move(unit)};
}

AxisTitle AxisTitle::plain(const std::string& text, std::string unit) {
  return {Script().add("{}", Marked{text}), letters(text), std::move(unit)};
}

AxisTitle AxisTitle::of(const std::string& name, const Script& quantity, std::size_t length,
                        std::string unit) {
  return {Script().add("{}.' '.{}", Marked{name + ":"}, quantity), letters(name) + 2 + length,
          std::move(unit)};
}

bool AxisTitle::fits(std::size_t most) const {
  return length + (unit.empty() ? 0 : 3 + letters(unit)) <= most;
}

Script AxisTitle::label(std::size_t most) const {
  if (unit.empty()) return text;
  return Script().add("{}.{}.{}", text, fits(most) ? Word("' '") : Word("\"\\n\""),
                      Marked{fmt::format("({})", unit)});
}

double round_factor(double x) {
  if (!(x > 1)) return 1;
  const double power = std::pow(10, std::floor(std::log10(x))), first = x / power;
  return power * (first < std::sqrt(2.0)    ? 1
                  : first < std::sqrt(10.0) ? 2
                  : first < std::sqrt(50.0) ? 5
                                            : 10);
}

Axis axis_of(double least, double greatest) {
  if (!(least <= greatest)) return {0, 1};
  const double size = std::max(std::abs(least), std::abs(greatest)), range = greatest - least;
  if (range <= 1e-4 * size || size == 0) {
    const double half = size > 0 ? 0.05 * size : 1, middle = 0.5 * (least + greatest);
    return {middle - half, middle + half};
  }
  Axis axis{least - 0.05 * range, greatest + 0.05 * range};
  if (least >= 0 && least < 0.3 * range) axis.low = 0;
  return axis;
}

Axis decades_of(double least, double greatest) {
  if (!(least > 0 && least <= greatest)) return {1e-16, 1, 0, true};
  const double low = std::floor(std::log10(least) + 1e-9), high = std::ceil(std::log10(greatest) - 1e-9);
  return {std::pow(10, low), std::pow(10, std::max(high, low + 1)), 0, true};
}

std::size_t longest_label(const Axis& axis) {
  if (!axis.tics.empty()) {
    std::size_t most = 1;
    for (const auto& tic : axis.tics) most = std::max(most, letters(tic.label));
    return most;
  }
  if (axis.logarithmic) return 4;  // 10 with two smaller letters
  std::size_t most = 1;
  const double first = std::ceil(axis.low / axis.step - 1e-9),
               last = std::floor(axis.high / axis.step + 1e-9);
  for (double k = first; k <= last && k < first + 100; ++k)
    most =
        std::max(most, fmt::format("{:.{}g}", nearest_tic(k * axis.step, axis.step), digits_of(axis)).size());
  return most;
}

Axis with_tics(Axis axis, double most, double width) {
  if (axis.step > 0) return axis;
  most = std::max(most, 1.0);
  if (!axis.tics.empty()) {
    const Tic* last = nullptr;
    const auto touches = [&](const Tic& tic) {
      if (!last) return false;
      const double apart = share_of(axis, tic.at) - share_of(axis, last->at);
      const auto both = static_cast<double>(letters(tic.label) + letters(last->label));
      return width > 0 ? width * apart < 0.5 * both + 1.2 : most * apart < 1;
    };
    std::vector<Tic> kept;
    kept.reserve(axis.tics.size());
    for (const auto& tic : axis.tics)
      if (!touches(tic)) last = &kept.emplace_back(tic);
    axis.tics = std::move(kept);
    return axis;
  }
  if (axis.logarithmic) {
    const double decades = std::log10(axis.high / axis.low);
    axis.step = std::pow(10, std::max(1.0, std::ceil(decades / most)));
    return axis;
  }
  if (!(axis.high > axis.low)) axis.high = axis.low + 1;
  const double range = axis.high - axis.low;
  axis.step = axis.turn ? 15 : std::pow(10, std::floor(std::log10(range / 20)));
  if (axis.whole) axis.step = std::max(axis.step, 1.0);
  // Letters between the middles of two labels, less those of a label.
  const auto gap = [&] { return width * axis.step / range - static_cast<double>(longest_label(axis)); };
  const auto room = [&] { return range / axis.step <= most && (width <= 0 || gap() >= 1.7); };
  double before = axis.step;
  for (int i = 0; i < 12 && !room() && axis.step < range; ++i) {
    before = axis.step;
    axis.step = next_step(axis.step, axis.turn);
  }
  // One tic alone gives no scale: rather two that are close.
  if (std::floor(axis.high / axis.step + 1e-9) - std::ceil(axis.low / axis.step - 1e-9) < 1) {
    const double wide = std::exchange(axis.step, before);
    if (width > 0 && gap() < 0.7) axis.step = wide;
  }
  return axis;
}

Script commands(const Axis& axis, Word name) {
  Script script;
  if (!axis.tics.empty()) {
    script.add("{0} logscale {1}\nset format {1}\nset {1}range [{2:.12g}:{3:.12g}]\nset {1}tics (",
               axis.logarithmic ? Word("set") : Word("unset"), name, axis.low, axis.high);
    for (const auto& tic : axis.tics) {
      if (&tic != axis.tics.data()) script.add(", ");
      script.add_tic(tic.label, tic.at);
    }
    return script.add(")\n");
  }
  if (axis.logarithmic)
    return script.add(
        "set logscale {0}\nset format {0} {1}\nset {0}range [{2:.6g}:{3:.6g}]\nset {0}tics {4:.6g}\n", name,
        powers_of_ten, axis.low, axis.high, axis.step);
  return script.add(
      "unset logscale {0}\nset format {0} '%.{4}g'\nset {0}range [{1:.12g}:{2:.12g}]\nset {0}tics {3:.6g}\n",
      name, axis.low, axis.high, axis.step, digits_of(axis));
}

}  // namespace freeplay::plots
