// Tables of results: their writers, against texts written by hand.
#include "values/table.hpp"

#include <catch2/catch.hpp>

using namespace freeplay;

TEST_CASE("a table is written as CSV, as Markdown and for a terminal", "[table]") {
  Table t("setting,events,CPU ms");
  t.row("fast", "-", 1.5);
  t.row("a long name", 12, 0.1);
  t.row(std::vector<Table::Cell>{"ä", "x", std::int64_t{1}});
  CHECK(t.csv() == "setting,events,CPU ms\nfast,-,1.5\na long name,12,0.1\nä,x,1\n");
  CHECK(t.csv_rows(2) == "ä,x,1\n");
  CHECK(t.markdown() ==
        "| setting | events | CPU ms |\n| --- | --- | --- |\n| fast | - | 1.5 |\n"
        "| a long name | 12 | 0.1 |\n| ä | x | 1 |\n");
  CHECK(t.terminal({8, 8, 7}, true) ==
        "setting   events CPU ms\n-------- ------- ------\nfast           -    1.5\n"
        "a long name\n              12    0.1\nä              x      1\n");
  Table n({"n", "µs"});
  n.row(3, "4");
  CHECK(n.terminal({-4, 5}) == "   n   µs\n   3    4\n");
}
