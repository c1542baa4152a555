// Texts of figures on paper: pdftotext states the box of each word of a PDF. No word leaves the
// page, none overlaps another, and every number and word of the same figure as SVG is a word of the
// PDF: cairo omits texts outside the page, and pdftotext joins words that touch.
#include <fmt/ranges.h>
#include <cctype>
#include <regex>

#include "facade/run_folder.hpp"
#include "io/files/child.hpp"
#include "io/scene/read_scene.hpp"
#include "plots/drawing/figure.hpp"
#include "verification/support/ball_study.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_results.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;

namespace {

struct PlacedWord {
  double left, top, right, bottom;  ///< pt, from the upper left corner of the page
  std::string text;
};
struct PaperPage {
  double width = 0, height = 0;  ///< pt
  std::vector<PlacedWord> words;
};

/// The words of a PDF. pdftotext omits letters outside the page, so the page is enlarged first.
PaperPage page_of(const std::filesystem::path& pdf, const std::filesystem::path& scratch) {
  constexpr double more = 300;
  PaperPage page;
  const auto text = test::file_text(pdf);
  const std::regex box(R"(/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \])");
  std::smatch size;
  REQUIRE(std::regex_search(text, size, box));
  page.width = std::stod(size[1]);
  page.height = std::stod(size[2]);
  write_file(scratch, std::regex_replace(text, box,
                                         fmt::format("/MediaBox [{} {} {} {}]", -more, -more,
                                                     page.width + more, page.height + more)));
  const auto end = run_child({.command = {"pdftotext", "-bbox", scratch.string(), "-"}, .listen = true});
  INFO(end.errors);
  REQUIRE(end.status == 0);
  const std::regex word(
      R"re(<word xMin="([-\d.]+)" yMin="([-\d.]+)" xMax="([-\d.]+)" yMax="([-\d.]+)">(.*?)</word>)re");
  for (auto it = std::sregex_iterator(end.output.begin(), end.output.end(), word);
       it != std::sregex_iterator(); ++it)
    page.words.push_back({std::stod((*it)[1]) - more, std::stod((*it)[2]) - more, std::stod((*it)[3]) - more,
                          std::stod((*it)[4]) - more, (*it)[5]});
  return page;
}

/// Texts of the figure as SVG: numbers that are texts of their own, and words of three letters or
/// more. Powers of ten and symbols are omitted, because pdftotext may join their parts.
std::vector<std::string> texts_of(const std::filesystem::path& svg) {
  std::vector<std::string> list;
  const auto text = test::file_text(svg);
  const std::regex number(R"(<text><tspan[^>]*>\s*(-?\d+(?:\.\d+)?)\s*</tspan></text>)"),
      part(R"(<tspan[^>]*>([^<]*)</tspan>)"), word("[A-Za-z]{3,}");
  for (auto it = std::sregex_iterator(text.begin(), text.end(), number); it != std::sregex_iterator(); ++it)
    list.push_back((*it)[1]);
  for (auto it = std::sregex_iterator(text.begin(), text.end(), part); it != std::sregex_iterator(); ++it) {
    const std::string words = (*it)[1];
    for (auto w = std::sregex_iterator(words.begin(), words.end(), word); w != std::sregex_iterator(); ++w)
      list.push_back(w->str());
  }
  return list;
}

/// Words of the axis titles that are in effect at a plot command of a script: a later command of the
/// same panel may replace or unset a title. gnuplot omits a title that is wholly off the page.
std::vector<std::string> titles_of(const std::filesystem::path& script) {
  std::vector<std::string> list;
  std::map<std::string, std::vector<std::string>> current;  // of each axis, its pieces of text
  const std::regex command(R"(^\s*(set|unset)\s+([xy]2?label)\b(.*))"), plot(R"(^\s*plot\b)"),
      piece(R"re('([^']*)'|"((?:[^"\\]|\\.)*)")re"), escape(R"(\\(?:[0-7]{3}|.))"), word("[A-Za-z]{3,}"),
      look(R"(\s(font|offset|tc|rotate|textcolor)\s.*)");
  std::istringstream lines(test::file_text(script));
  for (std::string line; std::getline(lines, line);) {
    std::smatch found;
    if (std::regex_search(line, found, command)) {
      auto& pieces = current[found[2]];
      const std::string rest = std::regex_replace(found[3].str(), look, "");
      // A command with options alone changes the look of a title only.
      const std::sregex_iterator first(rest.begin(), rest.end(), piece);
      if (found[1] == "unset" || found[3].length() == 0 || first != std::sregex_iterator()) pieces.clear();
      for (auto it = first; it != std::sregex_iterator(); ++it)
        pieces.push_back(std::regex_replace((*it)[1].str() + (*it)[2].str(), escape, " "));
    } else if (std::regex_search(line, plot)) {
      for (const auto& [axis, pieces] : current)
        for (const auto& words : pieces)
          for (auto w = std::sregex_iterator(words.begin(), words.end(), word); w != std::sregex_iterator();
               ++w)
            list.push_back(w->str());
    }
  }
  return list;
}

/// The faults of a page: words outside, overlapping words, and absent texts. A word's box has the
/// height of the font's ascenders and descenders, which exceed its letters; an overlap of a fifth of
/// the lower box is none of letters. The parts of F_x and 10^3 share their edges.
std::vector<std::string> faults_of(const PaperPage& page, std::filesystem::path pdf) {
  auto texts = texts_of(pdf.replace_extension(".svg"));
  std::ranges::copy(titles_of(pdf.replace_extension(".gp")), std::back_inserter(texts));
  std::vector<std::string> faults;
  for (std::size_t i = 0; i < page.words.size(); ++i) {
    const auto& a = page.words[i];
    if (a.left < 0 || a.top < 0 || a.right > page.width || a.bottom > page.height)
      faults.push_back("outside: " + a.text);
    for (std::size_t k = 0; k < i; ++k) {
      const auto& b = page.words[k];
      const double across = std::min(a.right, b.right) - std::max(a.left, b.left),
                   down = std::min(a.bottom, b.bottom) - std::max(a.top, b.top);
      const auto least = [](double x, double y) { return 0.2 * std::min(x, y); };
      if (across > std::min(0.5, least(a.right - a.left, b.right - b.left)) &&
          down > least(a.bottom - a.top, b.bottom - b.top))
        faults.push_back(fmt::format("overlap: {} and {}", a.text, b.text));
    }
    if (const auto found = std::ranges::find(texts, a.text); found != texts.end()) texts.erase(found);
  }
  // Words have signs beside them; numbers do not.
  for (const auto& text : texts)
    if (std::ranges::none_of(page.words, [&](const PlacedWord& w) {
          return std::isalpha(static_cast<unsigned char>(text.front())) && w.text.find(text) != w.text.npos;
        }))
      faults.push_back("absent: " + text);
  return faults;
}

/// Faults of all figures of a folder, and that each page has the width of the style.
void check_figures(const std::filesystem::path& figures, double width, const std::filesystem::path& scratch) {
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(figures)) {
    if (entry.path().extension() != ".pdf") continue;
    ++count;
    const auto page = page_of(entry.path(), scratch);
    CAPTURE(entry.path().filename().string());
    CHECK(page.width == Approx(width / 25.4 * 72).margin(1));  // gnuplot rounds to points
    CHECK(page.words.size() > 4);
    CHECK(faults_of(page, entry.path()) == std::vector<std::string>{});
  }
  CHECK(count > 0);
}

void write_facts(const std::filesystem::path& folder) {
  make_folder(folder / "figures");
  write_file(folder / "run.json",
             R"({"provenance": {"version": "0.1", "commit": "abc", "scene_file": "s.toml"}})");
  write_file(folder / "figures/style.toml", "width = 84\nformat = [\"pdf\", \"svg\"]\n");
}

/// Width (mm) and size of letters (pt) of a journal's figures.
struct Paper {
  int width, size;
};
/// The narrowest column with the largest letters has the least room.
constexpr Paper narrowest{84, 9};
constexpr Paper others[] = {{84, 7}, {174, 7}, {174, 9}};

/// A result folder with the commands that draw its figures.
struct Drawn {
  std::filesystem::path folder;
  std::vector<std::string> commands;

  void check(const std::filesystem::path& place, const Paper& paper) const {
    CAPTURE(paper.width, paper.size);
    write_file(place / "style.toml", fmt::format("width = {}\nfont_size = {}\nformat = [\"pdf\", \"svg\"]\n",
                                                 paper.width, paper.size));
    std::filesystem::remove_all(folder / "figures");
    for (const auto& command : commands)
      test::succeeded(fmt::format("{} --style {}", command, (place / "style.toml").string()));
    check_figures(folder / "figures", paper.width, place / "large.pdf");
  }
};

Drawn run_in(const std::filesystem::path& folder) {
  const std::vector<std::string> set{"run.revolutions=1.1", "run.discard=0", "run.forces=true"};
  run_scene(*open_scene(test::flores(), set), {.formulation = "nonsmooth", .folder = folder});
  const auto plot = "plot " + folder.string();
  return {
      folder,
      {"figures " + folder.string(), plot + " --y gudgeon.gap",
       plot + " --y crank.omega --y main.fx,main.fy,gudgeon.fn",  // a constant signal
       plot + " --x gudgeon.ex --y gudgeon.ey --title 'Centre of the gudgeon within its bearing, from the "
              "start to the end of the run'",
       plot + " --y 'hypot(gudgeon.fx, gudgeon.fy)' --over crank_angle --fold"}};
}

/// A comparison, and a run beside it.
Drawn comparison_in(const std::filesystem::path& folder, const Drawn& single) {
  test::succeeded(fmt::format("compare {} --forces --set run.revolutions=1.1 --set run.discard=0 -o {}",
                              test::flores().string(), folder.string()));
  return {folder,
          {"figures " + folder.string(),
           fmt::format("plot {} {} --y slider.x,rod.x,crank.x --y gudgeon.gap --y slider.vx", folder.string(),
                       single.folder.string())}};
}

Drawn play_in(const std::filesystem::path& folder) {
  test::succeeded(
      fmt::format("play {} --of slider.x --of rod.theta --of 'distance(crank, slider)' --over main "
                  "--from 0 --to '360 deg' --points 37 -o {}",
                  test::flores().string(), folder.string()));
  return {folder, {"figures " + folder.string()}};
}

/// Results of a sweep, of a paper and of other studies.
struct Studies {
  test::BallStudy ball{
      "values = [0.05, 0.1, 0.2, 0.4]\n[axes.mass]\nkey = \"bodies.ball.mass\"\n"
      "values = [0.2, 0.3, 0.4]\nunit = \"kg\"",
      "[measure.hardest]\ncolumn = \"table.fastest_approach_m_per_s\"\nreduce = \"last\"\n"
      "[measure.highest]\ncolumn = \"ball.y\"\nreduce = \"max\"\n"};
  std::vector<Drawn> all;

  Studies() {
    test::succeeded(fmt::format("sweep {} -o {}", ball.study.string(), ball.out.string()));
    const auto& place = ball.folder.path();
    test::put_paper_result(place / "paper", 1e3);
    test::put_ensemble(place / "ensemble");
    test::put_bifurcation(place / "bifurcation");
    test::put_basin(place / "basin");
    const auto swept = "plot " + ball.out.string();
    all.push_back(
        {ball.out,
         {swept + " --y hardest,highest --x e --title 'Hardest impact and greatest height of the ball'",
          swept + " --y hardest --x mass", swept + " --y hardest,highest --x e,mass"}});
    all.push_back({place / "paper", {"figures " + (place / "paper").string()}});
    for (const auto& [name, column] :
         {std::pair("ensemble", "gudgeon.fastest_approach_m_per_s,gudgeon.impacts"),
          {"bifurcation", "approach"},
          {"basin", "axle.angle"}}) {
      const auto folder = (place / name).string();
      all.push_back({folder, {fmt::format("plot {} --y {}", folder, column), "figures " + folder}});
    }
  }
  void check(const Paper& paper) const {
    for (const auto& results : all) {
      results.check(ball.folder.path(), paper);
      // Keys and their symbols, which are no texts, stand above the panels that add_panels() measures.
      for (const auto& entry : std::filesystem::directory_iterator(results.folder / "figures"))
        if (entry.path().extension() == ".gp") {
          CAPTURE(entry.path().filename().string());
          CHECK_THAT(test::file_text(entry.path()), Contains("\nPANEL = "));
        }
    }
  }
};

}  // namespace

TEST_CASE("texts that overlap, touch or leave the page are found", "[figures][texts]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  write_facts(place);
  const auto faults = [&](plots::Script script) {
    plots::Figure f{.name = "planted", .height_cm = 6, .blocks = {}, .script = {}, .source = "run.json"};
    f.blocks.emplace_back("x, y").row({0, 0}).row({1, 1});
    f.script.add("unset key\nset xrange [0:1]\nset yrange [0:1]\n{}plot DATA index 0 using 1:2 with lines\n",
                 script);
    plots::draw(f, place);
    const auto page = page_of(place / "figures/planted.pdf", place / "large.pdf");
    return fmt::format("{}", fmt::join(faults_of(page, place / "figures/planted.pdf"), "\n"));
  };
  const auto label = [](const char* text, double x) {
    return plots::Script()
        .add("set label '{}' at graph {}, graph 0.5\n", plots::Word("gudgeon"), x)
        .add("set label {} at graph {}, graph 0.5\n", text, x + 0.03);
  };
  CHECK(faults({}).empty());
  CHECK_THAT(faults(label("bearing", 0.2)), Contains("overlap"));
  CHECK_THAT(faults(plots::Script().add("set label 'gudgeon' at graph 1.0, graph 0.5\n")),
             Contains("outside: gudgeon"));
  CHECK_THAT(faults(plots::Script().add("set ylabel 'approach speed' offset -9\n")),
             Contains("absent: approach"));
  // Titles that no plot shows: replaced, unset, or set after the plot of the panel before.
  CHECK(faults(plots::Script().add("set ylabel 'approach speed' offset -9\nset ylabel 'speed' offset 0\n"))
            .empty());
  CHECK(faults(plots::Script().add("set ylabel 'approach speed' offset -9\nunset ylabel\n")).empty());
  CHECK_THAT(faults(plots::Script().add("set ylabel {}.' '.'speed' offset -9\n", plots::Marked{"rod:"})),
             Contains("absent: rod") && Contains("absent: speed"));
  CHECK_THAT(faults(plots::Script().add("set xtics 0.02\n")), Contains("overlap") || Contains("absent"));
  CHECK_THAT(faults(plots::Script().add("set ytics 0.02\n")), Contains("overlap"));
  CHECK_THAT(faults(plots::Script().add("set xtics 0.1\nset format x '%.3f'\n")),
             Contains("overlap") || Contains("absent"));
}

TEST_CASE("texts of figures of a run stay apart and on the page in a narrow column", "[figures][texts]") {
  test::TemporaryFolder folder;
  run_in(folder.path() / "single").check(folder.path(), narrowest);
}

TEST_CASE("texts of figures of papers and studies stay apart and on the page in a narrow column",
          "[figures][texts]") {
  Studies().check(narrowest);
}

TEST_CASE("texts of figures of output play stay apart and on the page at all widths and sizes of journals",
          "[figures][texts][play]") {
  test::TemporaryFolder folder;
  const auto play = play_in(folder.path() / "play");
  play.check(folder.path(), narrowest);
  for (const auto& paper : others) play.check(folder.path(), paper);
}

TEST_CASE("texts of figures stay apart and on the page at all widths and sizes of journals",
          "[figures][texts][slow]") {
  test::TemporaryFolder folder;
  const auto single = run_in(folder.path() / "single"),
             compared = comparison_in(folder.path() / "compared", single);
  const Studies studies;
  compared.check(folder.path(), narrowest);
  for (const auto& paper : others) {
    for (const auto* results : {&single, &compared}) results->check(folder.path(), paper);
    studies.check(paper);
  }
}

TEST_CASE("figures state their origin in their script and their PDF alone", "[figures][texts]") {
  test::TemporaryFolder folder;
  const auto& place = folder.path();
  write_facts(place);
  plots::Figure f{.name = "facts", .height_cm = 6, .blocks = {}, .script = {}, .source = "run.json"};
  f.caption = "last turn, means over 180 µs.";
  f.blocks.emplace_back("x, y").row({0, 0}).row({1, 1});
  f.script.add("unset key\nplot DATA index 0 using 1:2 with lines\n");
  const auto pdf = plots::draw(f, place);
  for (const auto& word : page_of(pdf, place / "large.pdf").words)
    CHECK_THAT(word.text, !Contains("freeplay") && !Contains("s.toml"));
  CHECK_THAT(test::file_text(place / "figures/facts.gp"),
             Contains("ORIGIN = \"freeplay 0.1 (abc), s.toml\""));
  const auto facts = run_child({.command = {"pdfinfo", pdf.string()}, .listen = true});
  CHECK(facts.errors.empty());
  CHECK_THAT(facts.output,
             Contains("last turn, means over 180 µs.") && Contains("freeplay 0.1 (abc), s.toml"));
}
