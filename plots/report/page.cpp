#include "plots/report/page.hpp"

#include <array>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace freeplay::report {
namespace {

// page_html, page_style, page_script: the files of plots/report/page; style_sha256, script_sha256:
// in hexadecimal digits.
#include "report_page.inc"

int digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

/// The bytes of hexadecimal digits.
std::string bytes_of(std::string_view hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes += static_cast<char>(16 * digit(hex[i]) + digit(hex[i + 1]));
  return bytes;
}

}  // namespace

std::string base64(std::string_view bytes) {
  constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(4 * bytes.size() / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t at = i; at < i + 3; ++at)
      group = group << 8 | (at < bytes.size() ? static_cast<unsigned char>(bytes[at]) : 0u);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? letters[group >> (18 - 6 * k) & 63] : '=';
  }
  return out;
}

std::string embedded(const nlohmann::json& document) {
  const auto text = document.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  std::string out;
  out.reserve(text.size() + text.size() / 64);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '<')
      out += "\\u003c";
    else if (c == '>')
      out += "\\u003e";
    else if (c == '&')
      out += "\\u0026";
    else if (text.compare(i, 2, "\xe2\x80") == 0 && i + 2 < text.size() && (text[i + 2] & 0xFE) == 0xA8) {
      out += text[i + 2] == '\xa8' ? "\\u2028" : "\\u2029";
      i += 2;
    } else
      out += c;
  }
  return out;
}

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  return out;
}

std::string page(const std::string& title, const nlohmann::json& document) {
  struct Filling {
    std::string_view mark;
    std::string text;
  };
  const std::array fillings{
      Filling{"{{policy}}",
              "default-src 'none'; img-src data:; base-uri 'none'; form-action 'none'; script-src 'sha256-" +
                  base64(bytes_of(script_sha256)) + "'; style-src 'sha256-" + base64(bytes_of(style_sha256)) +
                  "'"},
      Filling{"{{title}}", html_text(title)}, Filling{"{{style}}", std::string(page_style)},
      Filling{"{{data}}", embedded(document)}, Filling{"{{script}}", std::string(page_script)}};
  // Each mark occurs once, in this order. Inserted text is not searched for further marks.
  std::string out;
  std::string_view rest = page_html;
  for (const auto& [mark, text] : fillings) {
    const auto at = rest.find(mark);
    if (at == rest.npos) throw std::logic_error("page.html lacks " + std::string(mark));
    out += rest.substr(0, at);
    out += text;
    rest.remove_prefix(at + mark.size());
  }
  return out += rest;
}

}  // namespace freeplay::report
