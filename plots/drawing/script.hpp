// Commands for gnuplot that hold only what this program wrote. A command is a constant of the source with places for
// numbers and texts; a text becomes a literal that nothing in it can end. A command made in another way does not compile.
//
// Every script is kept twice: as gnuplot draws it, and as it writes it for LaTeX (cairolatex), which reads the texts of a
// figure as its own language. There a text has every sign of TeX spelt, and a Word may have a form of its own.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

namespace freeplay::plots {

/// A piece of gnuplot's language, such as a colour: known when the program is compiled, so that no file made it.
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

/// A text in gnuplot's double quotes, shortened to 200 characters, control characters spelt. Letters, digits and
/// harmless signs stand for themselves, every other byte as \ooo: gnuplot 5.4 ends a single-quoted literal in the middle
/// of a''''b, and runs what stands in backquotes within double quotes. Markup is switched off where it is used
/// (noenhanced).
std::string literal(std::string_view text);

/// The same for a tic of an axis, whose text gnuplot takes for a number's format: a % is doubled.
std::string tic_literal(std::string_view text);

/// A text for LaTeX, in which no sign means anything to TeX; and such a text in gnuplot's double quotes.
std::string in_tex(std::string_view text);
std::string tex_literal(std::string_view text);

/// The number itself; OutputError for what is not finite, which gnuplot would take for the name of a variable.
double finite(double x);

class Script {
  template <class I>
  static constexpr bool counts =
      std::is_integral_v<I> && !std::is_same_v<I, char> && !std::is_same_v<I, bool>;

 public:
  /// What stands in a command's place for a value.
  static double place(double x) { return finite(x); }
  template <class I>
  requires counts<I>
  static I place(I i) { return i; }
  static const char* place(const Word& word) { return word.text(); }
  static std::string_view place(const Script& script) { return script.text_; }
  static std::string place(const std::string& text) { return literal(text); }
  static std::string place(const char* text) { return literal(text); }
  template <class A>
  using Place = decltype(place(std::declval<const A&>()));

  /// The same for LaTeX.
  template <class A>
  static Place<A> tex_place(const A& value) {
    if constexpr (std::is_same_v<A, Word>)
      return value.tex();
    else if constexpr (std::is_same_v<A, Script>)
      return value.tex_;
    else if constexpr (std::is_convertible_v<const A&, std::string>)
      return tex_literal(value);
    else
      return place(value);
  }

  /// Appends a command with its places {} filled: numbers, Words and Scripts as they are, texts as literals.
  template <class... A>
  Script& add(fmt::format_string<Place<A>...> command, const A&... values) {
    text_ += fmt::format(command, place(values)...);
    tex_ += fmt::format(command, tex_place(values)...);
    return *this;
  }
  /// A tic of an axis.
  Script& add_tic(std::string_view text, std::size_t at);
  bool empty() const { return text_.empty(); }
  const std::string& text() const { return text_; }
  const std::string& tex() const { return tex_; }

 private:
  std::string text_, tex_;
};

}  // namespace freeplay::plots
