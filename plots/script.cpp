#include "plots/script.hpp"

#include <cmath>
#include <iterator>

#include "io/output_file.hpp"
#include "io/visible.hpp"

namespace freeplay::plots {
namespace {

/// Whether a character means nothing to gnuplot within double quotes.
bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         std::string_view(" ,.:_+-=()/").find(c) != std::string_view::npos;
}

std::string in_quotes(std::string_view text) {
  std::string out = "\"";
  bool escaped = false;
  for (const char c : text) {
    // gnuplot takes a digit behind \ooo for one more of its own.
    const bool plain = is_plain(c) && !(escaped && c >= '0' && c <= '9');
    if (plain)
      out += c;
    else
      fmt::format_to(std::back_inserter(out), "\\{:03o}", static_cast<unsigned char>(c));
    escaped = !plain;
  }
  return out + "\"";
}

}  // namespace

std::string literal(std::string_view text) { return in_quotes(visible_brief(text, 200)); }

std::string tic_literal(std::string_view text) {
  std::string doubled;
  for (const char c : visible_brief(text, 200)) doubled += c == '%' ? std::string("%%") : std::string(1, c);
  return in_quotes(doubled);
}

double finite(double x) {
  if (!std::isfinite(x)) throw OutputError(fmt::format("a figure cannot hold {}", x));
  return x;
}

Script& Script::add_tic(std::string_view text, std::size_t at) {
  text_ += fmt::format("{} {}", tic_literal(text), at);
  return *this;
}

}  // namespace freeplay::plots
