// The documentation of studies and the studies of cases: the example runs as documented,
// docs/reference/study.md lists every table and column, and every study of a case can be planned.
#include "study/sweep/sweep.hpp"
#include "verification/support/rig.hpp"
#include "verification/support/study_desk.hpp"

using namespace freeplay;
using test::StudyDesk, test::value_of;

namespace {

/// The example of docs/reference/study.md.
std::string example() {
  const auto page = test::file_text(test::source_folder() / "docs/reference/study.md");
  const auto begin = page.find("```toml\n");
  REQUIRE(begin != page.npos);
  return page.substr(begin + 8, page.find("```", begin + 8) - begin - 8);
}

}  // namespace

TEST_CASE("the study of docs/reference/study.md: a ball rebounds to e²h", "[studies]") {
  // v₋ = √(2gh) at the first contact, e v₋ after it, and (e v₋)²/(2g) = e²h up: rows and ends of
  // steps are at most Δt = duration/20000 apart, so the highest point is missed by at most g
  // Δt²/8 = 3e-10 m; the error of locating the contact is smaller.
  const StudyDesk desk("bouncing-ball");
  const auto runs = desk.table(example());
  REQUIRE(runs.size() >= 5);
  std::set<double> restitutions;
  for (const auto& run : runs) {
    const double e = value_of(run, "e");
    restitutions.insert(e);
    CHECK(std::abs(value_of(run, "rise") - e * e * 0.5) < 1e-8);
    CHECK(std::abs(value_of(run, "share") - e * e) < 3e-8);
    // No instrument, no drive: quantities that need one are absent, not zero.
    for (const char* name :
         {"peak_max", "rms", "ratio_max", "lines", "impacts_per_turn", "energy_per_turn", "loss_angle"})
      CHECK_FALSE(run.contains(name));
    // It comes to rest after ever smaller rebounds, at t₁(1 + e)/(1 − e), t₁ = √(2h/g): for the
    // rest of the window it is not in flight.
    const double rest = std::sqrt(1 / 9.81) * (1 + e) / (1 - e);
    CHECK(value_of(run, "flight_share") == Approx(std::min(1.0, (rest - 0.33) / 0.3)).margin(1e-4));
  }
  CHECK(restitutions.size() == runs.size());
}

TEST_CASE("the studies of cases/ can be run", "[studies]") {
  for (const char* name : {"pendulum", "motor-startup", "flores2011"}) {
    CAPTURE(name);
    const auto study = read_study(test::source_folder() / "cases" / name / "study.toml", Reach::beside);
    CHECK(plan(study, {}).size() >= 6);
    CHECK_FALSE(study.derived.empty());
  }
}

TEST_CASE("docs/reference/study.md lists every table and column of the database", "[studies][docs]") {
  const StudyDesk desk("bouncing-ball");
  REQUIRE(desk.sweep(example()).status == 0);
  const auto study = read_study(desk.folder.path() / "study.toml");
  const auto names = [](const auto& all) {
    std::vector<std::string> list;
    for (const auto& one : all) list.push_back(one.name);
    return list;
  };
  const auto trimmed = [](std::string word) {
    word.erase(0, word.find_first_not_of(' '));
    return word.erase(word.find_last_not_of(' ') + 1);
  };
  std::map<std::string, std::vector<std::string>> stated, there,
      groups{{"*axes*", names(study.axes)},
             {"*statistics*", {TurnMetrics::names().begin(), TurnMetrics::names().end()}},
             {"*measures*", names(study.measures)},
             {"*derived*", names(study.derived)}};
  bool within = false;
  for (const auto& line :
       test::lines_of(test::file_text(test::source_folder() / "docs/reference/study.md"))) {
    if (line.starts_with("| table |")) within = true;
    if (within && !line.starts_with("|")) break;
    if (!within || line.starts_with("| table |") || line.starts_with("| ---")) continue;
    std::istringstream cells(line.substr(2));
    std::string table, columns;
    std::getline(cells, table, '|');
    std::getline(cells, columns, '|');
    auto& list = stated[trimmed(table)];
    for (const auto& field : test::fields_of(columns)) {
      const auto word = trimmed(field);
      if (word == "*those of runs*") groups[word] = stated["runs"];
      const auto group = groups.contains(word) ? groups[word] : std::vector<std::string>{word};
      list.insert(list.end(), group.begin(), group.end());
    }
  }
  // Internally runs have integer numbers, in tables that users need not query.
  for (const auto& table :
       desk.ask("select name from sqlite_master where type in ('table', 'view') and name not like "
                "'sqlite_%' and name not like '%\\_rows' escape '\\' and name not like '%\\_blobs' "
                "escape '\\'"))
    for (const auto& column :
         desk.ask(fmt::format("select name from pragma_table_info('{}') where name <> 'run id'", table[0])))
      there[table[0]].push_back(column[0]);
  REQUIRE(there.size() > 8);
  CHECK(stated == there);
}
