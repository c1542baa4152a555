#include "study/database.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <bit>
#include <chrono>
#include <cmath>
#include <cstring>
#include <thread>

#include "io/output_file.hpp"

namespace freeplay {
static_assert(std::endian::native == std::endian::little, "blobs have the lowest byte first");
namespace {

// A transaction takes milliseconds; eight processes queue for less than a second.
constexpr std::chrono::milliseconds between_tries(10), patience(60000);

/// Why the database does not do what it is asked, and what would help.
std::string reason(int code) {
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      return "it is no database of results; move it away, or give another folder with -o";
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
    case SQLITE_MISMATCH:
    case SQLITE_SCHEMA:
      return "it is damaged, or another program's; restore it, or give another folder with -o";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program holds it; try again when that has ended";
    case SQLITE_FULL:
      return "the disk is full";
    case SQLITE_READONLY:
    case SQLITE_PERM:
    case SQLITE_AUTH:
      return "it may not be written here";
    case SQLITE_CANTOPEN:
      return "the file or its folder cannot be opened";
    case SQLITE_NOMEM:
      return "out of memory";
    default:
      return fmt::format("the disk refused (code {})", code);
  }
}

}  // namespace

void Database::fail() const {
  throw OutputError(
      fmt::format("{}: cannot be read or written: {}", file_.string(), reason(sqlite3_errcode(db_))));
}

void Database::execute(const std::string& sql) const {
  if (sqlite3_exec(db_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK) fail();
}

long Database::last_id() const { return sqlite3_last_insert_rowid(db_); }

int Database::wait(void* self, int tries) {
  if (static_cast<Database*>(self)->stop_() || tries * between_tries > patience) return 0;
  std::this_thread::sleep_for(between_tries);
  return 1;
}

Database::Database(const std::filesystem::path& file, StopToken stop) : file_(file), stop_(stop) {
  for (const char* part : {"", "-wal", "-shm", "-journal"}) require_own(file.string() + part);
  try {
    // By its absolute name: one that begins with file: would be taken for a URI.
    if (sqlite3_open(std::filesystem::absolute(file).c_str(), &db_) != SQLITE_OK) fail();
    sqlite3_busy_handler(db_, wait, this);
    // A user's query, however long, does not hold up the runs; a stop at any moment loses unstored runs only. SQLite does
    // not wait by itself for another process that is just doing the same.
    for (int tries = 0;
         sqlite3_exec(db_, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr) != SQLITE_OK;)
      if (sqlite3_errcode(db_) != SQLITE_BUSY || !wait(this, tries++)) fail();
    execute("PRAGMA foreign_keys = ON");
    // Of a commit the kernel is told, the disk at checkpoints: a killed program loses none, a power failure the last.
    execute("PRAGMA synchronous = NORMAL");
  } catch (...) {
    sqlite3_close(db_);
    throw;
  }
}

Database::~Database() { sqlite3_close(db_); }

Database::Statement::Statement(const Database& owner, const std::string& sql) : owner_(owner) {
  if (sqlite3_prepare_v2(owner.db_, sql.c_str(), -1, &statement_, nullptr) != SQLITE_OK) owner.fail();
}
Database::Statement::~Statement() { sqlite3_finalize(statement_); }

Database::Statement& Database::Statement::bind(double x) {
  sqlite3_bind_double(statement_, ++bound_, x);
  return *this;
}
Database::Statement& Database::Statement::bind(long x) {
  sqlite3_bind_int64(statement_, ++bound_, x);
  return *this;
}
Database::Statement& Database::Statement::bind(const std::string& x) {
  sqlite3_bind_text(statement_, ++bound_, x.c_str(), -1, SQLITE_TRANSIENT);
  return *this;
}
Database::Statement& Database::Statement::bind(std::span<const float> x) {
  return bind_bytes(std::as_bytes(x));
}
Database::Statement& Database::Statement::bind(std::span<const double> x) {
  return bind_bytes(std::as_bytes(x));
}
Database::Statement& Database::Statement::bind_bytes(std::span<const std::byte> x) {
  if (x.empty())
    sqlite3_bind_null(statement_, ++bound_);
  else
    sqlite3_bind_blob64(statement_, ++bound_, x.data(), x.size(), SQLITE_TRANSIENT);
  return *this;
}
bool Database::Statement::step() {
  const int status = sqlite3_step(statement_);
  if (status != SQLITE_ROW && status != SQLITE_DONE) owner_.fail();
  return status == SQLITE_ROW;
}
void Database::Statement::again() {
  step();
  sqlite3_reset(statement_);
  bound_ = 0;
}
std::string Database::Statement::text(int column) const {
  const auto* t = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return t ? t : "";
}
double Database::Statement::number(int column) const {
  if (sqlite3_column_type(statement_, column) == SQLITE_NULL) return std::nan("");
  return sqlite3_column_double(statement_, column);
}
long Database::Statement::whole(int column) const { return sqlite3_column_int64(statement_, column); }
int Database::Statement::columns() const { return sqlite3_column_count(statement_); }
std::string Database::Statement::name(int column) const { return sqlite3_column_name(statement_, column); }
bool Database::Statement::absent(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}
bool Database::Statement::is_text(int column) const {
  return sqlite3_column_type(statement_, column) == SQLITE_TEXT;
}
template <class T>
std::vector<T> Database::Statement::numbers(int column) const {
  const auto* blob = sqlite3_column_blob(statement_, column);
  std::vector<T> list(static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)) / sizeof(T));
  if (!list.empty()) std::memcpy(list.data(), blob, list.size() * sizeof(T));
  return list;
}
std::vector<float> Database::Statement::floats(int column) const { return numbers<float>(column); }
std::vector<double> Database::Statement::doubles(int column) const { return numbers<double>(column); }

Database::Transaction::Transaction(const Database& owner) : owner_(owner) {
  owner.execute("BEGIN IMMEDIATE");
}
Database::Transaction::~Transaction() {
  if (open_) sqlite3_exec(owner_.db_, "ROLLBACK", nullptr, nullptr, nullptr);
}
void Database::Transaction::commit() {
  owner_.execute("COMMIT");
  open_ = false;
}

}  // namespace freeplay
