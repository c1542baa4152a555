// Texts passed to gnuplot and to a terminal: their interpretation by gnuplot itself.
#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "plots/drawing/figure.hpp"
#include "plots/drawing/gnuplot.hpp"
#include "verification/process/untrusted_files/inputs.hpp"
#include "verification/support/rig.hpp"

using namespace freeplay;

namespace {

/// Texts composed of fragments with a meaning for gnuplot, a shell or a terminal, and of the
/// hostile ones.
std::vector<std::string> random_texts(const test::Bait& bait, int count) {
  auto pieces = test::hostile_texts(bait);
  std::erase_if(pieces, [](const std::string& s) { return s.size() > 1000; });
  for (const char* piece :
       {"'", "''", "\"", "\"\"", "`", "\\", "\\\\", "\\'", "\\\"", "\\n", "\\1", "@",  "$",    "#",   ";",
        "{", "}",  "%",  "0",    "7", "19", " ",    "a",   "_",    "é",   "\n",  "\t", "\x01", "\xff"})
    for (int i = 0; i < 3; ++i) pieces.emplace_back(piece);
  std::mt19937_64 random(13);
  std::vector<std::string> list;
  for (int i = 0; i < count; ++i) {
    std::string text;
    for (auto n = random() % 8; n > 0; --n) text += pieces[random() % pieces.size()];
    list.push_back(text);
  }
  return list;
}

/// As gnuplot writes it into an SVG.
std::string as_xml(const std::string& text) {
  std::string out;
  for (const char c : text) out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : std::string(1, c);
  return out;
}

}  // namespace

TEST_CASE("gnuplot reads every text literally and executes none", "[security][figures]") {
  test::TemporaryFolder folder;
  const test::Bait bait(folder.path());
  const auto texts = random_texts(bait, 6000);
  // Two to a line: a literal without its proper end would include the next.
  plots::Script script;
  script.add("set encoding utf8\nset print 'printed'\n");
  for (std::size_t i = 0; i < texts.size(); ++i)
    script.add("print {}, '|', {}\n", texts[i], texts[(i + 1) % texts.size()]);
  write_file(bait.folder / "script.gp", script.text());
  REQUIRE(plots::run_gnuplot(bait.folder, "script.gp").empty());
  LineReader printed(bait.folder / "printed");
  std::string line;
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    REQUIRE(printed.next(line));
    const auto expected =
        visible_brief(texts[i], 200) + " | " + visible_brief(texts[(i + 1) % texts.size()], 200);
    if (line == expected) continue;
    ++wrong;
    CAPTURE(texts[i]);
    CHECK(line == expected);
  }
  CHECK(wrong == 0);
  CHECK(bait.untouched());
}

TEST_CASE("no text acts as markup or format in a figure", "[security][figures]") {
  test::TemporaryFolder folder;
  const test::Bait bait(folder.path());
  auto texts = random_texts(bait, 120);
  std::erase(texts, "");
  plots::Script script, tics;
  script.add(
      "set encoding utf8\nset terminal svg noenhanced\nset terminal svg enhanced\nset output 'drawn.svg'\n");
  for (std::size_t i = 0; i < texts.size(); ++i) {
    script.add("set label {} {} at 1,1 noenhanced\n", i + 1, texts[i]);
    tics.add("{}", i ? plots::Word(", ") : plots::Word("")).add_tic(texts[i], i);
  }
  script.add(
      "set xrange [0:200]\nset xtics ({}) noenhanced\nset title {} noenhanced\n"
      "plot 1 title {} noenhanced\nunset output\n",
      tics, texts[0], texts[1]);
  write_file(bait.folder / "script.gp", script.text());
  REQUIRE(plots::run_gnuplot(bait.folder, "script.gp").empty());
  const auto drawn = read_file(bait.folder / "drawn.svg", most_of_a_result);
  for (const auto& text : texts) {
    const auto shown = as_xml(visible_brief(text, 200));
    std::size_t count = 0;
    for (std::size_t at = 0; (at = drawn.find(">" + shown + "<", at)) != drawn.npos; ++at) ++count;
    CAPTURE(shown);
    // As a label and as a tic; a tic with a % in it is cut at 50 bytes.
    CHECK(count >= (text.find('%') == text.npos ? 2u : 1u));
  }
  CHECK(bait.untouched());
}

TEST_CASE("file names of figures are safe and distinct for distinct texts", "[security][figures]") {
  test::TemporaryFolder folder;
  const test::Bait bait(folder.path());
  std::set<std::string> names, texts;
  for (const auto& text : random_texts(bait, 2000)) {
    const auto name = plots::file_name("reaction", text);
    CHECK(name.size() < 100);
    CHECK(name.starts_with("reaction_"));
    CHECK(name.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.") ==
          name.npos);
    names.insert(name);
    texts.insert(text);
  }
  CHECK(names.size() == texts.size());
  CHECK(plots::file_name("reaction", "gudgeon") == "reaction_gudgeon");
}

TEST_CASE("a figure with hostile texts is drawn, and redrawn by its own script", "[security][figures]") {
  test::TemporaryFolder folder;
  const test::Bait bait(folder.path());
  for (const auto& text : test::hostile_texts(bait)) {
    CAPTURE(text.substr(0, 80));
    const nlohmann::json source{{"provenance", {{"version", text}, {"commit", text}, {"scene_file", text}}}};
    write_file(bait.folder / "source.json",
               source.dump(1, ' ', true, nlohmann::json::error_handler_t::replace));
    plots::Figure f{.name = plots::file_name("figure", text), .source = "source.json"};
    f.blocks.emplace_back(text).row({1, 2}).row({2, 3});
    f.script.add(
        "set title {} noenhanced\nset xlabel {} noenhanced\nplot DATA index 0 using 1:2 with lines ls 1 "
        "title {} "
        "noenhanced\n",
        text, text, text);
    const auto made = plots::draw(f, bait.folder);
    CHECK(std::filesystem::file_size(made) > 2000);
    CHECK(made.parent_path() == bait.folder / "figures");
  }
  CHECK(bait.untouched());
  CHECK_FALSE(std::filesystem::exists(bait.folder / "CANARY"));
}

TEST_CASE("control and reordering characters are shown as escapes", "[security]") {
  CHECK(visible("plain, Ω µ é 中 🙂") == "plain, Ω µ é 中 🙂");
  CHECK(visible("a\nb\tc\rd\x1b[2J\x07\x7f") == "a\\nb\\tc\\rd\\x1b[2J\\x07\\x7f");
  CHECK(visible("a\nb\tc", "\n\t") == "a\nb\tc");
  CHECK(visible("\xc2\x9b"
                "1A \xe2\x80\xae"
                "abc \xef\xbb\xbf") == "\\u{9b}1A \\u{202e}abc \\u{feff}");
  CHECK(visible("\xff \xc0\xaf \xed\xa0\x80 \xf5 \xe2\x80") ==
        "\\xff \\xc0\\xaf \\xed\\xa0\\x80 \\xf5 \\xe2\\x80");
  CHECK(visible(std::string("a\0b", 3)) == "a\\x00b");
  CHECK(visible_brief(std::string(500, 'x'), 5) == "xxxxx…");
  // The display does not depend on the division of a text into pieces.
  const std::string text = "Ω\x1b é\xff 中🙂\n\xe2\x80\xae.";
  for (std::size_t size = 1; size <= text.size(); ++size) {
    VisibleStream stream("\n");
    std::string out;
    for (std::size_t i = 0; i < text.size(); i += size)
      out += stream.pass(std::string_view(text).substr(i, size));
    CHECK(out == visible(text, "\n"));
  }
}
