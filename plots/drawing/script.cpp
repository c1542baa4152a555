#include "plots/drawing/script.hpp"

#include <cmath>
#include <iterator>

#include "io/files/output_file.hpp"
#include "io/files/visible.hpp"

namespace freeplay::plots {
namespace {

/// Whether a character has no special meaning to gnuplot within double quotes.
bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view(" ,.:_+-=()/").find(c) != std::string_view::npos;
}

constexpr std::size_t most_shown = 200;  ///< characters of a text

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  bool escaped = false;
  for (const char c : text) {
    // gnuplot reads a digit after \ooo as part of the number.
    const bool plain = is_plain(c) && !(escaped && c >= '0' && c <= '9');
    if (plain)
      out += c;
    else
      fmt::format_to(std::back_inserter(out), "\\{:03o}", static_cast<unsigned char>(c));
    escaped = !plain;
  }
  return out + "\"";
}

std::string doubled(std::string_view text) {
  std::string out;
  for (const char c : text) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

}  // namespace

std::string literal(std::string_view text) { return in_quotes(visible_brief(text, most_shown)); }

std::string marked_literal(std::string_view text) {
  std::string out;
  for (const char c : visible_brief(text, most_shown)) {
    if (std::string_view("_^{}@&~\\").find(c) != std::string_view::npos) out += '\\';
    out += c;
  }
  return in_quotes(out);
}

std::string tic_literal(std::string_view text) { return in_quotes(doubled(visible_brief(text, most_shown))); }

std::string in_tex(std::string_view text) {
  std::string out;
  for (const char c : visible_brief(text, most_shown)) {
    const auto at = std::string_view("\\{}$&#_%~^\"<>|").find(c);
    constexpr const char* spelt[] = {"\\textbackslash{}",
                                     "\\{",
                                     "\\}",
                                     "\\$",
                                     "\\&",
                                     "\\#",
                                     "\\_",
                                     "\\%",
                                     "\\textasciitilde{}",
                                     "\\textasciicircum{}",
                                     "\\char34{}",
                                     "\\textless{}",
                                     "\\textgreater{}",
                                     "\\textbar{}"};
    if (at == std::string_view::npos)
      out += c;
    else
      out += spelt[at];
  }
  return out;
}

std::string tex_literal(std::string_view text) { return in_quotes(in_tex(text)); }

double finite(double x) {
  if (!std::isfinite(x)) throw OutputError(fmt::format("a figure cannot hold {}", x));
  return x;
}

Script& Script::add_tic(std::string_view text, double at) {
  text_ += fmt::format("{} {:.12g}", tic_literal(text), finite(at));
  tex_ += fmt::format("{} {:.12g}", in_quotes(doubled(in_tex(text))), at);
  return *this;
}

}  // namespace freeplay::plots
