#include "io/files/escaping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace freeplay {
namespace {

/// Bytes of the character that begins with `lead`; 0 if `lead` begins no character (RFC 3629).
std::size_t length_of(unsigned char lead) {
  if (lead < 0x80) return 1;
  if (lead >= 0xC2 && lead <= 0xDF) return 2;
  if (lead >= 0xE0 && lead <= 0xEF) return 3;
  if (lead >= 0xF0 && lead <= 0xF4) return 4;
  return 0;
}

/// Number of bytes at the beginning of `text` that belong to one character, and the length of that
/// character; {0, 1} if no character begins there. For a truncated character the first is smaller.
struct Extent {
  std::size_t there, whole;
};
Extent extent_of(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  const auto whole = length_of(byte(0));
  if (whole == 0) return {0, 1};
  std::size_t there = 1;
  for (; there < std::min(whole, text.size()); ++there) {
    unsigned char low = 0x80, high = 0xBF;
    if (there == 1) {  // excludes overlong encodings, surrogates and codes above U+10FFFF
      if (byte(0) == 0xE0) low = 0xA0;
      if (byte(0) == 0xED) high = 0x9F;
      if (byte(0) == 0xF0) low = 0x90;
      if (byte(0) == 0xF4) high = 0x8F;
    }
    if (byte(there) < low || byte(there) > high) return {0, 1};
  }
  return {there, whole};
}

std::uint32_t code_of(std::string_view character) {
  const auto lead = static_cast<unsigned char>(character[0]);
  if (character.size() == 1) return lead;
  std::uint32_t code = lead & (0xFFu >> (character.size() + 1));
  for (const char c : character.substr(1)) code = code << 6 | (static_cast<unsigned char>(c) & 0x3Fu);
  return code;
}

/// Whether a character is a control (C0, DEL, C1), a direction mark (Unicode's Bidi_Control), a
/// separator of lines or paragraphs, or has no width: zero-width characters, byte-order mark,
/// annotations, tags.
bool is_hidden(std::uint32_t code) {
  constexpr std::pair<std::uint32_t, std::uint32_t> ranges[] = {
      {0x00, 0x1F},     {0x7F, 0x9F},     {0xAD, 0xAD},      {0x61C, 0x61C},
      {0x180E, 0x180E}, {0x200B, 0x200F}, {0x2028, 0x202E},  {0x2060, 0x206F},
      {0xFEFF, 0xFEFF}, {0xFFF9, 0xFFFB}, {0xE0000, 0xE007F}};
  return std::ranges::any_of(ranges, [code](const auto& r) { return code >= r.first && code <= r.second; });
}

void spell(std::uint32_t code, std::string& out) {
  if (code == '\n')
    out += "\\n";
  else if (code == '\t')
    out += "\\t";
  else if (code == '\r')
    out += "\\r";
  else
    out += code < 0x80 ? fmt::format("\\x{:02x}", code) : fmt::format("\\u{{{:x}}}", code);
}

/// Appends the displayable part of `text`; returns the number of bytes of an incomplete last
/// character.
std::size_t show(std::string_view text, std::string_view kept, std::string& out) {
  while (!text.empty()) {
    const auto [there, whole] = extent_of(text);
    if (there > 0 && there < whole) return there;
    const auto character = text.substr(0, whole);
    if (there == 0)
      fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(text[0]));
    else if (const auto code = code_of(character);
             is_hidden(code) && (whole > 1 || kept.find(text[0]) == kept.npos))
      spell(code, out);
    else
      out += character;
    text.remove_prefix(whole);
  }
  return 0;
}

}  // namespace

std::size_t character_length(std::string_view text) {
  const auto [there, whole] = extent_of(text);
  return there == whole ? whole : 0;
}

std::string visible(std::string_view text, std::string_view kept) {
  std::string out;
  const auto left = show(text, kept, out);
  for (const char c : text.substr(text.size() - left))
    fmt::format_to(std::back_inserter(out), "\\x{:02x}", static_cast<unsigned char>(c));
  return out;
}

std::string VisibleStream::pass(std::string_view piece) {
  waiting_ += piece;
  std::string out;
  const auto left = show(waiting_, kept_, out);
  waiting_.erase(0, waiting_.size() - left);
  return out;
}

std::string visible_brief(std::string_view text, std::size_t most) {
  // A character has at most four bytes, so the rest of a very long text is not read.
  auto all = visible(text.substr(0, 4 * most + 4));
  std::size_t characters = 0;
  for (std::size_t i = 0; i < all.size(); ++i)
    if ((all[i] & 0xC0) != 0x80 && ++characters > most) return all.substr(0, i) + "…";
  return all;
}

namespace {

bool is_plain(char c) {
  constexpr std::string_view others = "%+,-./:=@_";
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
         others.find(c) != others.npos;
}

}  // namespace

std::string shell_words(const std::vector<std::string>& words) {
  std::string out;
  for (const auto& word : words) {
    if (!out.empty()) out += ' ';
    if (!word.empty() && std::ranges::all_of(word, is_plain)) {
      out += word;
      continue;
    }
    out += '\'';
    for (const char c : word) {
      if (c == '\'')
        out += "'\\''";
      else
        out += c;
    }
    out += '\'';
  }
  return out;
}

}  // namespace freeplay
