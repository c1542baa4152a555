#include "study/merge.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <chrono>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "io/input_file.hpp"
#include "io/output_file.hpp"
#include "model/error.hpp"
#include "study/scratch.hpp"
#include "study/shard_file.hpp"

namespace freeplay {
namespace {

/// A connection of a merge's own: it attaches shards without locks, which a shared folder may not have.
class Connection {
 public:
  Connection(const std::filesystem::path& file, int flags) : file_(file) {
    if (sqlite3_open_v2(file.c_str(), &db_, flags | SQLITE_OPEN_URI, nullptr) != SQLITE_OK) {
      const std::string why = sqlite3_errmsg(db_);
      sqlite3_close(db_);
      throw OutputError(fmt::format("{}: cannot be opened: {}", file.string(), why));
    }
  }
  ~Connection() { sqlite3_close(db_); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void execute(const std::string& sql) const {
    if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
      throw OutputError(fmt::format("{}: cannot be merged into: {}", file_.string(), sqlite3_errmsg(db_)));
  }
  /// Rows of texts; NULL is "".
  std::vector<std::vector<std::string>> ask(const std::string& sql) const {
    sqlite3_stmt* raw = nullptr;
    if (sqlite3_prepare_v2(db_, sql.c_str(), -1, &raw, nullptr) != SQLITE_OK)
      throw OutputError(fmt::format("{}: cannot be read: {}", file_.string(), sqlite3_errmsg(db_)));
    const std::unique_ptr<sqlite3_stmt, int (*)(sqlite3_stmt*)> s(raw, sqlite3_finalize);
    std::vector<std::vector<std::string>> rows;
    int code = SQLITE_ROW;
    while ((code = sqlite3_step(raw)) == SQLITE_ROW) {
      auto& row = rows.emplace_back();
      for (int c = 0; c < sqlite3_column_count(raw); ++c) {
        const auto* text = sqlite3_column_text(raw, c);
        row.emplace_back(text ? reinterpret_cast<const char*>(text) : "");
      }
    }
    if (code != SQLITE_DONE)
      throw OutputError(fmt::format("{}: cannot be read: {}", file_.string(), sqlite3_errmsg(db_)));
    return rows;
  }

 private:
  std::filesystem::path file_;
  sqlite3* db_ = nullptr;
};

/// As a URI; a name may have what means something in one.
std::string immutable(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : std::filesystem::absolute(file).string())
    uri += c == '%' || c == '?' || c == '#' ? fmt::format("%{:02x}", static_cast<unsigned char>(c))
                                            : std::string(1, c);
  return uri + "?immutable=1&mode=ro";
}

std::string quoted(const std::string& text, char mark) {
  std::string out(1, mark);
  for (const char c : text) out += c == mark ? std::string(2, mark) : std::string(1, c);
  return out + mark;
}
std::string name(const std::string& text) { return quoted(text, '"'); }

struct Table {
  std::string called, columns;
  bool by_number = false;  ///< of a run's rows, by the whole number of its row in `runs`
};

/// What a merge knows of the tables of studies: `runs` comes first and is named by `run`; others name it by that, or by `id`.
class Merging {
 public:
  explicit Merging(const std::filesystem::path& into)
      : db_(into, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE) {
    // The file is nobody's until it is renamed: a power failure leaves nothing that counts.
    for (const char* pragma : {"journal_mode = OFF", "synchronous = OFF", "cache_size = -262144",
                               "temp_store = FILE", "locking_mode = EXCLUSIVE"})
      db_.execute(fmt::format("PRAGMA {}", pragma));
    db_.execute("CREATE TEMP TABLE map (old INTEGER PRIMARY KEY, new INTEGER)");
  }

  void add(const std::filesystem::path& shard) {
    db_.execute(fmt::format("ATTACH {} AS shard", quoted(immutable(shard), '\'')));
    const auto schema =
        db_.ask("SELECT type, name, sql FROM shard.sqlite_master WHERE sql NOT NULL ORDER BY rowid");
    const auto kind = db_.ask("PRAGMA shard.user_version").at(0).at(0);
    if (schema_.empty())
      make_tables(schema, kind);
    else if (schema != schema_ || kind != kind_)
      throw SceneError(fmt::format(
          "{}: has other tables than the shards before it: it was made by another freeplay", shard.string()));
    db_.execute("BEGIN");
    if (numbered_) {  // a shard's runs in the order of their digests, behind those that are there
      db_.execute("DELETE FROM temp.map");
      db_.execute(
          "INSERT INTO temp.map SELECT \"run id\", (SELECT coalesce(max(\"run id\"), 0) FROM main.runs) + "
          "row_number() OVER (ORDER BY run) FROM shard.runs");
    }
    for (const auto& t : tables_) {
      if (t.called == "runs" && numbered_)
        db_.execute(fmt::format(
            "INSERT INTO main.runs ({0}, \"run id\") SELECT {0}, map.new FROM map JOIN shard.runs ON "
            "\"run id\" = map.old ORDER BY map.new",
            t.columns));
      else if (t.by_number)
        db_.execute(fmt::format(
            "INSERT INTO main.{0} (id, {1}) SELECT map.new, {1} FROM shard.{0} AS many JOIN map ON "
            "map.old = many.id ORDER BY map.new, many.rowid",
            name(t.called), t.columns));
      else
        db_.execute(fmt::format("INSERT INTO main.{0} ({1}) SELECT {1} FROM shard.{0} ORDER BY run, rowid",
                                name(t.called), t.columns));
    }
    db_.execute("COMMIT");
    db_.execute("DETACH shard");
  }

  void finish() {
    for (const auto& sql : later_) db_.execute(sql);
  }

 private:
  void make_tables(const std::vector<std::vector<std::string>>& schema, const std::string& kind) {
    schema_ = schema;
    kind_ = kind;
    db_.execute("PRAGMA main.user_version = " + kind);
    for (const auto& row : schema) {
      if (row[0] != "table") {
        later_.push_back(row[2]);
        continue;
      }
      db_.execute(row[2]);
      if (row[1] == "sweeps") continue;  // of processes at work, of which there is none
      Table t{row[1], {}};
      for (const auto& column : db_.ask(fmt::format("PRAGMA main.table_info({})", name(row[1])))) {
        const auto& c = column[1];
        numbered_ = numbered_ || (t.called == "runs" && c == "run id");
        t.by_number = t.by_number || c == "id";
        if (c != "id" && c != "run id") t.columns += (t.columns.empty() ? "" : ", ") + name(c);
      }
      tables_.insert(t.called == "runs" ? tables_.begin() : tables_.end(), t);
    }
  }

  Connection db_;
  std::vector<std::vector<std::string>> schema_;
  std::string kind_;
  std::vector<Table> tables_;
  std::vector<std::string> later_;  // indexes and views: indexes are made faster of what is there
  bool numbered_ = false;
};

/// Files that no seal names: of processes that were killed, or of two that made one shard.
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

bool is_sound(const std::filesystem::path& file) {
  try {
    const Connection db(file, SQLITE_OPEN_READWRITE);
    return db.ask("PRAGMA quick_check").at(0).at(0) == "ok";
  } catch (const OutputError&) {
    return false;
  }
}

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
        "{}: {} of {} shards cannot be merged: {} (the first: {}); make them: {}", place.string(),
        lacking.size(), manifest.shards, ranges(numbers), lacking.front().second,
        command_for(manifest, folder, fmt::format("--shard {}/{}", lacking.front().first, manifest.shards))));
  }
  const FolderLock lock(folder, "merge");
  MergeSummary summary;
  std::vector<std::filesystem::path> files;
  for (std::size_t k = 1; k <= manifest.shards; ++k) {
    const auto seal = *read_seal(folder, k);
    files.push_back(place / seal.file);
    summary.units += seal.units;
    summary.failed += seal.failed;
    summary.reasons.insert(summary.reasons.end(), seal.reasons.begin(), seal.reasons.end());
  }
  summary.shards = files.size();
  if (summary.units != manifest.units)
    throw SceneError(
        fmt::format("{}: shards hold {} units, and {} were planned; plan again into another folder",
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
    write_whole(mark, nlohmann::json{{"plan", manifest.plan}}.dump() + "\n");
    remove_orphans(place, files);
  }
  summary.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return summary;
}

}  // namespace freeplay
