// gnuplot: its commands, and its process.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace freeplay::plots {

// Commands for gnuplot that contain only text which this program wrote. A command is a constant of
// the source with places for numbers and texts. A text becomes a literal that its content cannot
// terminate. A command made in another way does not compile.
//
// Every script exists in two versions: one for gnuplot's own terminals, and one for LaTeX
// (cairolatex), which interprets the texts of a figure as TeX. In the second version every special
// character of TeX is escaped, and a Word may have another form.

/// A piece of gnuplot's language, such as a colour. It is a compile-time constant, so it cannot
/// come from a file.
class Word {
 public:
  consteval Word(const char* text)  // NOLINT(google-explicit-constructor): it is a constant
      : text_(text), tex_(text) {}
  consteval Word(const char* text, const char* tex) : text_(text), tex_(tex) {}
  constexpr const char* text() const { return text_; }
  constexpr const char* tex() const { return tex_; }

 private:
  const char *text_, *tex_;
};

/// gnuplot format of the tics of a logarithmic axis.
inline constexpr Word powers_of_ten{"'10^{%T}'", "'$10^{%T}$'"};

/// A text in gnuplot's double quotes, shortened to 200 characters, with visible control characters.
/// Letters, digits and harmless characters are unchanged; every other byte is written as \ooo,
/// because gnuplot 5.4 ends a single-quoted literal in the middle of a''''b and executes backquotes
/// within double quotes. Commands that use the text switch off markup (noenhanced).
std::string literal(std::string_view text);

/// A text for LaTeX without special characters of TeX (in_tex), and the same in gnuplot's double
/// quotes (tex_literal).
std::string in_tex(std::string_view text);
std::string tex_literal(std::string_view text);

/// A text within markup: printed as it is, as a part of a text that has symbols such as F_x.
struct Marked {
  std::string text;
};
/// The text in gnuplot's double quotes, with a backslash before each character of its markup.
std::string marked_literal(std::string_view text);

/// Returns x. Throws OutputError if x is not finite, because gnuplot would read it as the name of a
/// variable.
double finite(double x);

class Script {
  template <class I>
  static constexpr bool counts =
      std::is_integral_v<I> && !std::is_same_v<I, char> && !std::is_same_v<I, bool>;

 public:
  /// The form of a value in a command.
  static double place(double x) { return finite(x); }
  template <class I>
  requires counts<I>
  static I place(I i) { return i; }
  static const char* place(const Word& word) { return word.text(); }
  static std::string_view place(const Script& script) { return script.text_; }
  static std::string place(const std::string& text) { return literal(text); }
  static std::string place(const Marked& text) { return marked_literal(text.text); }
  static std::string place(const char* text) { return literal(text); }
  template <class A>
  using Place = decltype(place(std::declval<const A&>()));

  /// The form of a value in a command for LaTeX.
  template <class A>
  static Place<A> tex_place(const A& value) {
    if constexpr (std::is_same_v<A, Word>)
      return value.tex();
    else if constexpr (std::is_same_v<A, Script>)
      return value.tex_;
    else if constexpr (std::is_same_v<A, Marked>)
      return tex_literal(value.text);
    else if constexpr (std::is_convertible_v<const A&, std::string>)
      return tex_literal(value);
    else
      return place(value);
  }

  /// Appends a command with its places {} filled: numbers, Words and Scripts as they are, texts as
  /// literals.
  template <class... A>
  Script& add(fmt::format_string<Place<A>...> command, const A&... values) {
    text_ += fmt::format(command, place(values)...);
    tex_ += fmt::format(command, tex_place(values)...);
    return *this;
  }
  /// Appends a tic of an axis. gnuplot reads its text as a number format, so each % is doubled.
  Script& add_tic(std::string_view text, double at);
  template <class I>
  requires counts<I> Script& add_tic(std::string_view text, I at) {
    return add_tic(text, static_cast<double>(at));
  }
  bool empty() const { return text_.empty(); }
  const std::string& text() const { return text_; }
  const std::string& tex() const { return tex_; }

 private:
  std::string text_, tex_;
};

/// Runs gnuplot on `script`, the name of a file in `folder`, with this folder as working directory.
/// gnuplot reads no start-up file, and its input contains no name of a folder. Returns an empty
/// string on success, otherwise the first line of gnuplot's message. Throws OutputError if gnuplot
/// cannot be started.
std::string run_gnuplot(const std::filesystem::path& folder, const std::string& script);

}  // namespace freeplay::plots
