#include "plots/drawing/pdf_facts.hpp"

#include <fmt/format.h>

#include <cstdlib>
#include <iterator>
#include <string_view>

namespace freeplay::plots {
namespace {

/// A text string in UTF-16 with its byte order mark, written in hexadecimal digits: nothing in it
/// is syntax of PDF.
std::string text_string(std::string_view utf8) {
  std::string out = "<FEFF";
  for (std::size_t i = 0; i < utf8.size();) {
    const auto byte = [&](std::size_t k) {
      return k < utf8.size() ? static_cast<unsigned char>(utf8[k]) : 0u;
    };
    const unsigned first = byte(i);
    const int more = first < 0x80 ? 0 : first < 0xE0 ? 1 : first < 0xF0 ? 2 : 3;
    unsigned code = more == 0 ? first : first & (0x3Fu >> more);
    for (int k = 1; k <= more; ++k) code = code << 6 | (byte(i + static_cast<std::size_t>(k)) & 0x3Fu);
    i += static_cast<std::size_t>(more) + 1;
    if (code >= 0x10000)
      fmt::format_to(std::back_inserter(out), "{:04X}{:04X}", 0xD800 + ((code - 0x10000) >> 10 & 0x3FF),
                     0xDC00 + (code & 0x3FF));
    else
      fmt::format_to(std::back_inserter(out), "{:04X}", code);
  }
  return out + ">";
}

/// The text between two marks behind a position; empty if they are absent.
std::string text_between(const std::string& pdf, std::size_t from, std::string_view mark,
                         std::string_view end) {
  const auto at = pdf.find(mark, from);
  const auto to = at == pdf.npos ? at : pdf.find(end, at + mark.size());
  return to == pdf.npos ? "" : pdf.substr(at + mark.size(), to - at - mark.size());
}

}  // namespace

std::string with_facts(const std::string& pdf, const PdfFacts& facts) {
  const auto trailer = pdf.rfind("trailer");
  if (trailer == pdf.npos) return pdf;
  const long size = std::strtol(text_between(pdf, trailer, "/Size ", "\n").c_str(), nullptr, 10),
             table = std::strtol(text_between(pdf, trailer, "startxref\n", "\n").c_str(), nullptr, 10);
  const auto root = text_between(pdf, trailer, "/Root ", "R");
  if (size <= 0 || table <= 0 || root.empty()) return pdf;
  std::string out = pdf;
  if (!out.ends_with('\n')) out += '\n';
  const auto object = out.size();
  out += fmt::format("{} 0 obj\n<<", size);
  for (const auto& [key, text] : {std::pair<const char*, const std::string&>{"Title", facts.title},
                                  {"Subject", facts.subject},
                                  {"Keywords", facts.keywords},
                                  {"Creator", facts.creator}})
    if (!text.empty()) out += fmt::format(" /{} {}\n", key, text_string(text));
  out += ">>\nendobj\n";
  const auto xref = out.size();
  out += fmt::format(
      "xref\n{0} 1\n{1:010} 00000 n \ntrailer\n<< /Size {2} /Root {3}R /Info {0} 0 R /Prev {4} >>\nstartxref\n{5}\n%%EOF\n",
      size, object, size + 1, root, table, xref);
  return out;
}

}  // namespace freeplay::plots
