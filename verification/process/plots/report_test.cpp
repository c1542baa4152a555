// The report page of a result folder: thinning loses no extreme, texts are data, sizes, and folders
// without results. scripts/report-test checks the page in a browser.
#include "plots/report/report.hpp"
#include "io/scene/pose_file.hpp"
#include "plots/report/page.hpp"
#include "plots/report/thinning.hpp"
#include "plots/tables/table.hpp"
#include "study/comparison/compare.hpp"
#include "verification/process/untrusted_files/inputs.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/run_files.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using Catch::Matchers::Contains;
using nlohmann::json;
using test::comparison;

namespace {

/// The data of a page as read by a browser.
json data_of(const std::string& page) {
  const std::string mark = "id=\"data\">";
  const auto from = page.find(mark) + mark.size();
  return json::parse(page.substr(from, page.find("</script>", from) - from));
}

}  // namespace

TEST_CASE("a thinned table keeps the extremes of every segment, a short table all rows", "[report]") {
  std::mt19937_64 random(GENERATE(1u, 2u, 3u));
  const long rows = std::uniform_int_distribution<long>(2000, 300'000)(random), most = 1000;
  std::normal_distribution<double> noise;
  report::Thinning table(rows, 2, most);
  std::vector<double> all;
  for (long i = 0; i < rows; ++i) {
    double y = noise(random);
    if (random() % 5000 == 0) y *= 1000;  // a peak of one row
    all.push_back(y);
    const std::array values{y, -y};
    table.take(1e-3 * static_cast<double>(i), values);
  }
  table.finish();
  const auto &t = table.t(), &kept = table.column(0);
  CHECK(static_cast<long>(kept.size()) <= most);
  CHECK(static_cast<long>(kept.size()) > most / 3);
  REQUIRE(t.size() == kept.size());
  CHECK(std::ranges::is_sorted(t));
  // Each bucket by hand: it contains its extremes, in their order, within its time.
  const auto each = static_cast<std::size_t>((rows + most / 2 - 1) / (most / 2));
  for (std::size_t b = 0; 2 * b < kept.size(); ++b) {
    const auto from = b * each, to = std::min(all.size(), from + each);
    const auto [least, greatest] =
        std::minmax_element(all.begin() + static_cast<long>(from), all.begin() + static_cast<long>(to));
    REQUIRE(std::min(kept[2 * b], kept[2 * b + 1]) == *least);
    REQUIRE(std::max(kept[2 * b], kept[2 * b + 1]) == *greatest);
    REQUIRE((kept[2 * b] == *least) == (least <= greatest));
    REQUIRE(t[2 * b] >= 1e-3 * static_cast<double>(from));
    REQUIRE(t[2 * b + 1] <= 1e-3 * static_cast<double>(to - 1));
    REQUIRE(table.column(1)[2 * b] == -kept[2 * b]);
  }
  report::Thinning whole(500, 1, most);
  for (std::size_t i = 0; i < 500; ++i) whole.take(static_cast<double>(i), {&all[i], 1});
  whole.finish();
  CHECK(whole.column(0) == std::vector<double>(all.begin(), all.begin() + 500));
}

TEST_CASE("non-finite numbers are skipped in thinning, and null where a segment has no others", "[report]") {
  report::Thinning table(8, 1, 4);
  for (const double y :
       {std::nan(""), 3.0, 1.0, std::nan(""), std::nan(""), std::nan(""), std::nan(""), std::nan("")})
    table.take(0, {&y, 1});
  table.finish();
  CHECK(table.column(0)[0] == 3);
  CHECK(table.column(0)[1] == 1);
  CHECK(report::numbers(table.column(0)).dump() == "[3,1,null,null]");
  CHECK(report::numbers({1.23456789, -0.0, 1e300, 20.0}).dump() == "[1.23457,0,1e+300,20]");
}

TEST_CASE("texts of a report page close no element and stay unchanged", "[report][untrusted-files]") {
  const test::TemporaryFolder folder;
  auto texts = test::hostile_texts(test::Bait(folder.path()));
  texts.insert(texts.end(),
               {"</script><script>document.title = 1</script>", "<!--<script>", "]]>", "{{script}}{{data}}",
                "\xe2\x80\xa8 \xe2\x80\xa9", "&lt;b&gt;", "\"><img src=x onerror=alert(1)>", "</title>"});
  const auto plain = report::page("", json(""));
  for (const auto& text : texts) {
    const json document = {{"title", text}, {text, 1}};
    const auto inside = report::embedded(document);
    CHECK(inside.find_first_of("<>&") == inside.npos);
    CHECK(inside.find("\xe2\x80\xa8") == inside.npos);
    // The same except for bytes that are not UTF-8.
    const auto replaced = document.dump(-1, ' ', false, json::error_handler_t::replace);
    CHECK(json::parse(inside) == json::parse(replaced));
    const auto page = report::page(text, document);
    CHECK(std::ranges::count(page, '<') == std::ranges::count(plain, '<'));
    CHECK_THAT(page, Contains("default-src 'none'"));
  }
}

TEST_CASE("report page of a comparison: both runs, rows at each event, tables", "[report]") {
  const auto page = report::report_page(comparison());
  CHECK(page.size() < 5'000'000u);  // bytes; tables are thinned
  for (const char* address : {"http:", "https:", "src=", "url(", "@import"})
    CHECK(page.find(address) == page.npos);
  const auto data = data_of(page);
  CHECK(data["kind"] == "comparison");
  REQUIRE(data["runs"].size() == 3);
  CHECK(data["comparison"].size() > 3);
  CHECK_THAT(data["commands"][0].get<std::string>(),
             Contains("freeplay compare") && Contains("--set run.forces=true"));
  for (const char* name : {"penalty", "nonsmooth"}) {
    const auto run = std::ranges::find_if(data["runs"], [&](const json& r) { return r["name"] == name; });
    REQUIRE(run != data["runs"].end());
    const plots::ReadTable rows(comparison() / name / "trajectory.csv", {}, {"t", "slider.x", "gudgeon.ex"});
    const plots::ReadTable events(comparison() / name / "events.csv", {"joint"}, {"t", "impulse_n"});
    REQUIRE(events.rows() > 3);
    CHECK((*run)["events"]["t"].size() == events.rows());
    const auto shown = (*run)["motion"]["t"].get<std::vector<double>>();
    const auto has = [&](double t) {
      return std::ranges::any_of(shown, [&](double s) { return std::abs(s - t) <= 1e-9 * t; });
    };
    CHECK(has(rows.column("t").back()));
    const auto& t = rows.column("t");
    for (const double instant : events.column("t")) {
      const auto after = std::ranges::upper_bound(t, instant);
      if (after == t.end() || after == t.begin()) continue;
      CHECK(has(*after));
    }
    CHECK_FALSE((*run)["motion"]["shapes"].empty());
    CHECK_FALSE((*run)["motion"]["arrows"].empty());
    CHECK((*run)["motion"]["loose"][0]["name"] == "gudgeon");
  }
}

TEST_CASE("shapes of bodies in body axes reproduce the pose", "[report]") {
  const auto data = report::document_of(comparison());
  const auto& motion = data["runs"][0]["motion"];
  // The rod's two joints are 0.3 m apart in its frame at any time; the crank pin is 0.05 m from the
  // crank's centre.
  std::vector<double> x;
  for (const auto& shape : motion["shapes"])
    if (shape[0] == "link" && shape[1] == "rod") x.push_back(shape[3]);
  REQUIRE(x.size() == 2);
  CHECK(std::abs(x[1] - x[0]) == Approx(0.3).epsilon(1e-6));
  for (const auto& shape : motion["shapes"])
    if (shape[0] == "pin" && shape[1] == "big_end")
      CHECK(std::hypot(shape[3].get<double>(), shape[4].get<double>()) == Approx(0.15).epsilon(1e-6));
}

TEST_CASE("a folder without results is refused in one line, and nothing is written", "[report][errors]") {
  const test::Sandbox box;
  make_folder(box.at("empty"));
  std::filesystem::copy(comparison() / "penalty", box.at("damaged"),
                        std::filesystem::copy_options::recursive);
  box.add("damaged/trajectory.csv", "t,crank.x\n0,zero\n");
  for (const auto& [arguments, why] : {std::pair("nowhere", "nowhere: is not a folder"),
                                       {"empty", "contains no results to show"},
                                       {"damaged", "trajectory.csv"},
                                       {"damaged -o empty", "is a folder"}}) {
    const auto outcome = box.run(fmt::format("report {}", arguments));
    CAPTURE(outcome.err);
    CHECK(outcome.status == 2);
    CHECK_THAT(outcome.err, Contains(why));
    CHECK(std::ranges::count(outcome.err, '\n') == 1);
  }
  CHECK(std::filesystem::is_empty(box.at("empty")));
  CHECK_FALSE(std::filesystem::exists(box.at("damaged/report.html")));
}

// The report page: titles, units and commands of a study, the start transient, bodies through their
// named points.

TEST_CASE("page of a sweep: title, units, verdict and commands with the study's file", "[report]") {
  const test::StudyDesk desk("bouncing-ball");
  const auto made = desk.sweep(
      "title = \"Rebound of a ball\"\nscene = \"scene.toml\"\nduration = 0.3\ndiscard_time = 0.33\n" +
      test::axis("radius", "contacts.table.radius", "0.050123456789012345, \"51 mm\"",
                 "unit = \"mm\"\nscale = 1e3\n") +
      "[variants.soft]\ntitle = \"A soft table\"\nset = [\"surfaces.hard.young=1e9\"]\n" +
      test::measure("highest", "ball.y", "max"));
  REQUIRE(made.status == 0);
  const auto page = report::document_of(desk.folder.path() / "out");
  CHECK(page["title"] == "Rebound of a ball");
  CHECK(page["scene_title"] == "Bouncing ball");
  const auto study = (desk.folder.path() / "study.toml").string(),
             scene = (desk.folder.path() / "scene.toml").string();
  CHECK(page["commands"] == json{"freeplay sweep " + study + " -o out"});
  CHECK(
      page["axis_facts"] ==
      json::array({{{"name", "radius"}, {"key", "contacts.table.radius"}, {"unit", "mm"}, {"scale", 1e3}}}));
  CHECK(page["variants"]["soft"] == json{{"scene", scene}, {"set", " --set surfaces.hard.young=1e9"}});
  CHECK(page["units"]["peak_max"] == "m/s²");
  CHECK(page["units"]["highest"] == "m");  // of the column ball.y
  CHECK(page["own"] == json{"highest"});
  CHECK(page["first"] == "highest");  // the study's own measure precedes the statistics of turns
  // The command of a cell repeats the run, so its key is the double of the study, not six digits of it.
  CHECK(page["runs"][0]["values"][0].get<double>() == 0.050123456789012345);
  // The page shows the words with which the command ends.
  const auto verdict = page["verdict"].get<std::string>();
  CHECK(verdict.starts_with("All 4 runs finished; highest ranges from"));
  CHECK(made.out.find(verdict.substr(0, 30)) != made.out.npos);
  // A folder of an older version has no sweep.json.
  std::filesystem::remove(desk.folder.path() / "out/sweep.json");
  CHECK(report::document_of(desk.folder.path() / "out")["commands"] == json{"freeplay sweep STUDY -o out"});
}

TEST_CASE("the start transient is the discarded time, else the beginning of the first turn", "[report]") {
  CHECK(report::start_transient(0.3, 0.1, 2) == 0.3);
  CHECK(report::start_transient(0, 0.2, 2) == Approx(0.05));    // a quarter of a turn
  CHECK(report::start_transient(0, 1.0, 0.5) == Approx(0.05));  // a tenth of a run of half a turn
  CHECK(report::start_transient(0, {}, 2) == 0);                // a fall, an oscillation: all of it counts
}

TEST_CASE("a body is drawn through all its named points", "[report][points]") {
  // The plate's points A (0, 0), B (3, 0), C (3, 2), D (0, 2) with its centre of mass at (1, 1);
  // only A carries a joint. The body stands at (5, 7), turned by a quarter: (x, y) → (5 − y, 7 + x).
  const auto scene = parse_scene(
      test::body("plate", 1, 1,
                 "points = { A = [0, 0], B = [3, 0], C = [3, 2], D = [0, 2], mass_centre = [1, 1] }\n") +
          "[joints.pin]\ntype = \"revolute\"\nbetween = [\"ground\", \"plate\"]\nat = [[6, 6], \"A\"]\n" +
          test::run_for(1),
      "plate.toml");
  std::vector<std::pair<double, double>> corners;
  for (const auto& s : pose_shapes(scene, {5, 7, std::numbers::pi / 2}))
    if (s.kind == "link") corners.emplace_back(s.at.x(), s.at.y());
  REQUIRE(corners.size() == 5);  // closed
  CHECK(corners.front() == corners.back());
  for (const auto& [x, y] : {std::pair{6.0, 6.0}, {6.0, 9.0}, {4.0, 9.0}, {4.0, 6.0}})
    CHECK(std::ranges::any_of(
        corners, [&](const auto& c) { return std::abs(c.first - x) + std::abs(c.second - y) < 1e-12; }));
  // In their order along the outline: no two sides cross, so opposite corners are not neighbours.
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const double side =
        std::hypot(corners[i + 1].first - corners[i].first, corners[i + 1].second - corners[i].second);
    CHECK((std::abs(side - 2) < 1e-9 || std::abs(side - 3) < 1e-9));
  }
}
