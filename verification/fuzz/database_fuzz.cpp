// A fuzz target for databases of results and shards: any bytes are opened, read whole, merged and opened for writing, or refused with
// one SceneError or OutputError. What is opened has no definition but this program's own.
#include <sqlite3.h>

#include "io/output_file.hpp"
#include "study/database.hpp"
#include "study/merge.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

namespace {

/// Each value of each table and view, as readers take them.
void read_all(const Database& database) {
  for (const auto& object : database.schema()) {
    if (!own_definition(object)) std::abort();
    if (object.type == "index") continue;
    Database::Statement s(database, "SELECT * FROM " + object.name);
    while (s.step())
      for (int c = 0; c < s.columns(); ++c) {
        s.text(c);
        s.number(c);
        s.whole(c);
        s.floats(c);
        s.doubles(c);
      }
  }
}

template <class F>
void judged(std::string_view input, F&& act) {
  try {
    act();
  } catch (const SceneError& e) {
    fuzz::judge(e, input);
  } catch (const OutputError& e) {
    fuzz::judge(e, input);
  }
}

}  // namespace

/// Seeds: a folder to write them to.
extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  sqlite3_hard_heap_limit64(std::int64_t{1} << 30);
  for (int i = 1; i + 1 < *argc; ++i)
    if (std::string((*argv)[i]) == "-seeds") {
      const std::filesystem::path folder = (*argv)[i + 1];
      std::filesystem::remove(folder / "sweep.db");
      const Database d(folder / "sweep.db", Database::Access::build);
      for (
          const char* text :
          {"CREATE TABLE runs (run TEXT UNIQUE, variant TEXT, formulation TEXT, start INTEGER, \"e\" REAL, "
           "status TEXT, reason TEXT, \"run id\" INTEGER PRIMARY KEY)",
           "CREATE TABLE turn_rows (id INTEGER REFERENCES runs(\"run id\") ON DELETE CASCADE, turn INTEGER, peak REAL)",
           "CREATE TABLE trace_blobs (id INTEGER PRIMARY KEY REFERENCES runs(\"run id\") ON DELETE CASCADE, angle "
           "BLOB, acceleration BLOB, position BLOB)",
           "CREATE TABLE work (run TEXT PRIMARY KEY, state TEXT, seat INTEGER)",
           "CREATE INDEX turn_rows_id ON turn_rows(id)", "CREATE INDEX work_state ON work(state)",
           "CREATE VIEW turns AS SELECT runs.run AS run, many.turn, many.peak FROM runs JOIN turn_rows AS many ON "
           "many.id = runs.\"run id\"",
           "INSERT INTO runs VALUES ('a', 'v', 'penalty', 0, 0.5, 'finished', '', 1)",
           "INSERT INTO runs VALUES ('b', 'v', 'nonsmooth', 1, 0.6, 'failed', 'why', 2)",
           "INSERT INTO turn_rows VALUES (1, 1, 2.5), (2, 1, 3.5)",
           "INSERT INTO work VALUES ('a', 'done', NULL)",
           "INSERT INTO trace_blobs VALUES (1, x'0000000000000040', x'0000803f0000803f', NULL)",
           "PRAGMA user_version = 3"})
        d.execute(text);
      std::exit(0);
    }
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = fuzz::text_of(data, size);
  const auto file = fuzz::file_of(data, size, "fuzz.db");
  judged(input, [&] { read_all(Database(file, Database::Access::sealed)); });
  judged(input, [&] { merge_files({file}, file.parent_path() / "merged.db"); });
  judged(input, [&] { read_all(Database(file, Database::Access::write)); });
  for (const char* part : {"-wal", "-shm", "-journal"}) std::filesystem::remove(file.string() + part);
  return 0;
}
