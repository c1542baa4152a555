// A fuzz target for databases of results and shards: any bytes are opened, read completely, merged
// and opened for writing, or refused with one SceneError or OutputError. An accepted database
// contains only tables, indexes and views.
#include <sqlite3.h>

#include "io/files/output_file.hpp"
#include "study/partition/merge.hpp"
#include "study/store/database.hpp"
#include "verification/fuzz/judged.hpp"

using namespace freeplay;

namespace {

/// Each value of each table and view, as readers take them.
void read_all(const Database& database) {
  for (const auto& object : database.schema()) {
    if (object.type == "index") continue;
    if (object.type != "table" && object.type != "view") std::abort();
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
void assessed(std::string_view input, F&& act) {
  try {
    act();
  } catch (const SceneError& e) {
    fuzz::assess(e, input);
  } catch (const OutputError& e) {
    fuzz::assess(e, input);
  }
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  sqlite3_hard_heap_limit64(std::int64_t{1} << 30);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto input = fuzz::text_of(data, size);
  const auto file = fuzz::file_of(data, size, "fuzz.db");
  assessed(input, [&] { read_all(Database(file, Database::Access::sealed)); });
  assessed(input, [&] { merge_files({file}, file.parent_path() / "merged.db"); });
  assessed(input, [&] { read_all(Database(file, Database::Access::write)); });
  for (const char* part : {"-wal", "-shm", "-journal"}) std::filesystem::remove(file.string() + part);
  return 0;
}
