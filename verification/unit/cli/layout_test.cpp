// Text for a terminal: lines are broken only where necessary, and numbers are under their headings.
#include "cli/terminal.hpp"
#include "study/comparison/compare.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;
using test::lines_of, test::width;

TEST_CASE("progress in a pipe is at most one line a minute, the first after a minute", "[layout][progress]") {
  using namespace std::chrono_literals;
  const cli::LinePace::Clock::time_point begin{};
  cli::LinePace pace(begin);
  CHECK(!pace.due(begin));
  CHECK(!pace.due(begin + 59s));
  CHECK(pace.due(begin + 60s));
  CHECK(!pace.due(begin + 60s));
  CHECK(!pace.due(begin + 119s));
  // The pause counts from the last line, so that a slow command does not write two lines in a row.
  CHECK(pace.due(begin + 200s));
  CHECK(!pace.due(begin + 259s));
  CHECK(pace.due(begin + 260s));
  cli::LinePace hour(begin);
  int lines = 0;
  for (auto t = begin; t < begin + 1h; t += 1s) lines += hour.due(t);
  CHECK(lines == 59);
}

TEST_CASE("lines are broken at the last space before column 80 without loss", "[layout]") {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> length(1, 14), letter('a', 'z');
  for (int trial = 0; trial < 200; ++trial) {
    std::string text = "note:";
    while (width(text) < 300) {
      text += ' ';
      for (int i = length(random); i > 0; --i)
        text += trial % 2 ? std::string(1, static_cast<char>(letter(random))) : "é";
    }
    const std::size_t indent = trial % 11;
    const auto lines = lines_of(cli::wrapped(text, indent));
    REQUIRE(lines.size() > 3);
    std::string whole;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      CAPTURE(i, indent, lines[i]);
      CHECK(width(lines[i]) <= 80);
      const auto words = i == 0 ? lines[i] : lines[i].substr(indent);
      if (i > 0) {
        CHECK(lines[i].substr(0, indent) == std::string(indent, ' '));
        // The first word of a line did not fit on the one before.
        CHECK(width(lines[i - 1]) + 1 + width(words.substr(0, words.find(' '))) > 80);
        whole += ' ';
      }
      whole += words;
    }
    CHECK(whole == text);
  }
  CHECK(cli::wrapped("one\ntwo three\n") == "one\ntwo three\n");
  const std::string exact(80, 'x');
  CHECK(cli::wrapped("word " + exact.substr(5)) == "word " + exact.substr(5));
  CHECK(cli::wrapped("word " + exact.substr(4)) == "word\n  " + exact.substr(4));
}

TEST_CASE("the comparison table fits 80 columns, each number under its heading", "[layout]") {
  auto scene = test::read_short(test::flores(), 0.3);
  test::TemporaryFolder folder;
  const auto c = compare(scene, {}, folder.path());
  const auto lines = lines_of(comparison_table(scene, c, false));
  // A heading, then its rule: groups of dashes with a space between; the cells of every row below
  // end where the groups do.
  int tables = 0;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    if (!lines[i].starts_with("---")) continue;
    ++tables;
    std::vector<std::size_t> ends;
    for (std::size_t at = 0; at < lines[i].size(); ++at)
      if (lines[i][at] == '-' && (at + 1 == lines[i].size() || lines[i][at + 1] == ' ')) ends.push_back(at);
    const bool pairs = tables == 2;
    // Columns of each run; columns of pairs of contacts. 44 + 17 + 16 and 12 + 3·11 + 3·9 + 7, with
    // a space between.
    CHECK(ends.size() == (pairs ? 8 : 3));
    CHECK(ends.back() + 1 == (pairs ? 79 : 77));
    std::size_t columns = 0;
    for (std::size_t row = i - 1; row < lines.size() && !lines[row].empty(); row += row == i - 1 ? 2 : 1) {
      const auto& line = lines[row];
      if (line.starts_with("...") || line.starts_with("v: ") || line.starts_with("* ")) break;
      // Cells by their ends: a character there, and a space or the end after it. ± has two bytes.
      std::string plain;
      for (const char ch : line)
        if ((ch & 0xC0) != 0x80) plain += ch;
      CAPTURE(line);
      if (plain.size() > ends[0] &&
          // a name that fills the width: its cells follow on the next line
          plain.size() < ends[1]) {
        REQUIRE(lines.at(row + 1).starts_with(std::string(ends[0], ' ')));
        continue;
      }
      for (std::size_t k = 1; k < ends.size(); ++k) {
        REQUIRE(plain.size() > ends[k]);
        CHECK(plain[ends[k]] != ' ');
        if (plain.size() > ends[k] + 1) CHECK(plain[ends[k] + 1] == ' ');
      }
      CHECK(plain.size() == ends.back() + 1);
      ++columns;
    }
    CHECK(columns > 3);
  }
  CHECK(tables == 2);
}
