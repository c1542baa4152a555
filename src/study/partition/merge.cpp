#include "study/partition/merge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"
#include "mechanism/error.hpp"
#include "study/partition/division.hpp"
#include "study/partition/shard.hpp"
#include "study/store/database.hpp"

namespace freeplay {
namespace {

/// Copies the tables of shards. The first table is `runs`, with the key `run`; other tables refer
/// to it by that key, or by `id`, the integer of its row in `runs`. Rows are read from a shard and
/// written by this program's own statements: nothing in a shard is executed, and no database is
/// attached to another.
class Merging {
 public:
  explicit Merging(const std::filesystem::path& into) : db_(into, Database::Access::build) {}

  void add(const std::filesystem::path& file) {
    const Database shard(file, Database::Access::sealed);
    if (first_.empty())
      make_tables(shard);
    else if (sorted(shard.schema()) != sorted(schema_) || shard.kind() != kind_)
      throw SceneError(
          fmt::format("{}: its tables differ from those of {}: another version or another study made it",
                      file.string(), first_.string()));
    if (first_.empty()) first_ = file;
    Database::Transaction whole(db_);
    // Runs of a shard in the order of their digests, after the runs already present.
    if (numbered_) {
      shard.execute("CREATE TEMP TABLE map (old INTEGER PRIMARY KEY, new INTEGER)");
      shard.execute(fmt::format(
          "INSERT INTO temp.map SELECT \"run id\", {} + row_number() OVER (ORDER BY run) FROM runs",
          db_.number_of("SELECT coalesce(max(\"run id\"), 0) FROM runs")));
    }
    for (const auto& t : tables_)
      if (t.called == "runs" && numbered_)
        copy(shard, "runs (\"run id\", " + t.columns + ")", t.count + 1,
             fmt::format("SELECT map.new, {} FROM map JOIN runs ON \"run id\" = map.old ORDER BY map.new",
                         t.columns));
      else if (t.by_number)
        copy(shard, fmt::format("{} (id, {})", t.called, t.columns), t.count + 1,
             fmt::format("SELECT map.new, {} FROM {} AS many JOIN map ON map.old = many.id ORDER BY map.new, "
                         "many.rowid",
                         t.columns, t.called));
      else
        copy(shard, fmt::format("{} ({})", t.called, t.columns), t.count,
             fmt::format("SELECT {} FROM {} ORDER BY run, rowid", t.columns, t.called));
    whole.commit();
  }

  void finish() {
    for (const auto& text : later_) db_.execute(text);
  }

 private:
  using Statement = Database::Statement;

  struct CopiedTable {
    std::string called, columns;  // without the integer of the run
    int count = 0;                // number of columns
    bool by_number = false;
  };

  static std::vector<SchemaObject> sorted(std::vector<SchemaObject> schema) {
    std::ranges::sort(schema);
    return schema;
  }

  void make_tables(const Database& shard) {
    schema_ = shard.schema();
    kind_ = shard.kind();
    db_.execute(fmt::format("PRAGMA user_version = {}", kind_));
    // Each definition is in this program's text, since the shard was checked when it was opened.
    for (const auto& object : schema_) {
      if (object.type != "table") {
        later_.push_back(object.sql);
        continue;
      }
      db_.execute(object.sql);
      // A merged database has no active processes, and derived columns are computed from all runs.
      if (object.name == "sweeps" || object.name == "derived") continue;
      CopiedTable t{object.name, {}, 0, false};
      for (const auto& column : columns_of(shard, object.name)) {
        numbered_ = numbered_ || (t.called == "runs" && column == "\"run id\"");
        t.by_number = t.by_number || column == "id";
        if (column == "id" || column == "\"run id\"") continue;
        t.columns += (t.count++ > 0 ? ", " : "") + column;
      }
      tables_.insert(t.called == "runs" ? tables_.begin() : tables_.end(), t);
    }
  }

  void copy(const Database& shard, const std::string& into, int columns, const std::string& of) const {
    Statement rows(shard, of),
        row(db_, fmt::format("INSERT INTO {} VALUES ({})", into, fmt::join(std::vector(columns, '?'), ", ")));
    while (rows.step()) {
      for (int c = 0; c < columns; ++c) row.bind(rows, c);
      row.again();
    }
  }

  Database db_;
  std::filesystem::path first_;  // first shard
  std::vector<SchemaObject> schema_;
  long kind_ = 0;
  std::vector<CopiedTable> tables_;
  std::vector<std::string> later_;  // indexes and views; indexes are created faster after the rows
  bool numbered_ = false;
};

/// Removes files that no seal names: of killed processes, or of two processes that computed the
/// same shard.
void remove_orphans(const std::filesystem::path& place, const std::vector<std::filesystem::path>& sealed) {
  const std::set<std::filesystem::path> named(sealed.begin(), sealed.end());
  std::error_code none;
  for (const auto& entry : std::filesystem::directory_iterator(place, none)) {
    const auto called = entry.path().filename().string();
    const bool left =
        called.front() == '.' || called.ends_with(".part.db") || called.ends_with(".state.json");
    if (left || (called.ends_with(".db") && !named.contains(entry.path())))
      std::filesystem::remove(entry.path(), none);
  }
}

}  // namespace

std::string ranges(const std::vector<std::size_t>& numbers, const char* dash) {
  std::string text;
  for (std::size_t i = 0, j = 0; i < numbers.size(); i = j) {
    for (j = i + 1; j < numbers.size() && numbers[j] == numbers[j - 1] + 1;) ++j;
    text += (text.empty() ? "" : ",") + std::to_string(numbers[i]);
    if (j - i > 1) text += dash + std::to_string(numbers[j - 1]);
  }
  return text;
}

std::vector<std::pair<std::size_t, std::string>> not_whole(const Manifest& manifest,
                                                           const std::filesystem::path& folder, bool deep) {
  std::vector<std::pair<std::size_t, std::string>> list;
  for (std::size_t k = 1; k <= manifest.shards; ++k) {
    const auto seal = read_seal(folder, k);
    const auto why = seal ? fault_of(*seal, manifest, folder, deep) : "it is missing";
    if (!why.empty()) list.emplace_back(k, why);
  }
  return list;
}

void merge_files(const std::vector<std::filesystem::path>& shards, const std::filesystem::path& into) {
  std::filesystem::remove(into);
  Merging merging(into);
  for (const auto& shard : shards) merging.add(shard);
  merging.finish();
}

MergeSummary merge_shards(const Division& study, const std::filesystem::path& folder,
                          const std::filesystem::path& scratch) {
  const auto began = std::chrono::steady_clock::now();
  const auto manifest = read_manifest(folder);
  require_same(manifest, study, folder);
  const auto place = shards_folder(folder);
  const auto database = folder / (manifest.verb + ".db");
  const auto mark = place / "merged.json";
  if (const auto lacking = not_whole(manifest, folder, true); !lacking.empty()) {
    std::vector<std::size_t> numbers;
    for (const auto& [k, why] : lacking) numbers.push_back(k);
    throw SceneError(fmt::format(
        "{}: {} of {} shards cannot be merged: {} (the first: {}); run them: {}", place.string(),
        lacking.size(), manifest.shards, ranges(numbers), lacking.front().second,
        command_for(manifest, {"--shard", fmt::format("{}/{}", lacking.front().first, manifest.shards), "-o",
                               folder.string()})));
  }
  const FolderLock lock(folder, "merge");
  MergeSummary summary;
  std::vector<std::filesystem::path> files;
  for (std::size_t k = 1; k <= manifest.shards; ++k) {
    const auto seal = *read_seal(folder, k);
    files.push_back(place / seal.file);
    summary.units += seal.units;
    summary.failed += seal.failed;
  }
  summary.shards = files.size();
  if (summary.units != manifest.units)
    throw SceneError(
        fmt::format("{}: the shards contain {} units, but {} were planned; plan again into another folder",
                    place.string(), summary.units, manifest.units));
  const auto said = std::filesystem::is_regular_file(mark)
                        ? nlohmann::json::parse(read_file(mark, most_of_a_text), nullptr, false)
                        : nlohmann::json();
  if (said.is_object() && said.value("plan", "") == manifest.plan && std::filesystem::exists(database)) {
    summary.found = true;
  } else {
    const Scratch own(scratch, manifest.plan);
    const auto growing = own.folder() / database.filename();
    merge_files(files, growing);
    if (study.finish) study.finish(own.folder());
    for (const char* part : {"-wal", "-shm"}) std::filesystem::remove(database.string() + part);
    copy_whole(growing, database);
    write_file(mark, nlohmann::json{{"plan", manifest.plan}}.dump() + "\n", OutputFile::Shared());
    remove_orphans(place, files);
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return summary;
}

}  // namespace freeplay
