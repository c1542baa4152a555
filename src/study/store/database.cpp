#include "study/store/database.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <chrono>
#include <cmath>
#include <cstring>
#include <string_view>
#include <thread>

#include "io/files/escaping.hpp"
#include "io/files/input_file.hpp"
#include "io/files/output_file.hpp"

namespace freeplay {
static_assert(std::endian::native == std::endian::little, "blobs have the lowest byte first");
namespace {

// A transaction takes milliseconds; eight processes wait for each other less than a second.
constexpr std::chrono::milliseconds between_tries(10), patience(60000);

// The slowest statement of a sweep of 10^6 runs creates the index of its impacts, and takes 5 s for
// 746 MB on a local disk.
constexpr double least_seconds = 120, bytes_a_second = 1e6;
constexpr std::size_t longest_path = 503;  // SQLite's limit of 512 includes the ending of the journal
// Reasons of failures and joined warnings are the longest texts.
constexpr int longest_text = 1 << 14;
constexpr long application_id = 0x46504c59;  // "FPLY"; files of earlier versions have 0
// Instructions of the virtual machine between two checks of the time.
constexpr int steps_between_looks = 100'000;  // of SQLite's machine, 5 ms

double seconds_now() {
  timespec now{};
  // Read twice for each row; the coarse clock takes 5 ns.
  clock_gettime(CLOCK_MONOTONIC_COARSE, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// s, time limit of a statement for the present size of the file.
double allowed_seconds(const std::filesystem::path& file) {
  std::error_code none;
  const auto bytes = std::filesystem::file_size(file, none);
  return least_seconds + (none ? 0 : static_cast<double>(bytes) / bytes_a_second);
}

/// Reason of a failure, and its remedy.
std::string reason(int code) {
  switch (code & 0xff) {
    case SQLITE_NOTADB:
      return "it is not a database of results; move it, or give another folder with -o";
    case SQLITE_CORRUPT:
    case SQLITE_ERROR:
    case SQLITE_MISMATCH:
    case SQLITE_SCHEMA:
      return "it is damaged or belongs to another program; restore it, or give another folder with -o";
    case SQLITE_CONSTRAINT:
      return "it is inconsistent (a run twice, or rows without a run); repeat its runs";
    case SQLITE_BUSY:
    case SQLITE_LOCKED:
      return "another program uses it; try again after that has ended";
    case SQLITE_FULL:
      return "the disk is full";
    case SQLITE_READONLY:
    case SQLITE_PERM:
      return "there is no permission to write it";
    case SQLITE_CANTOPEN:
      return "the file or its folder cannot be opened";
    case SQLITE_NOMEM:
      return "out of memory";
    default:
      return fmt::format("disk error (code {})", code);
  }
}

/// Whether the file is damaged, as opposed to an error of the disk or of another program.
bool is_damage(int code) {
  constexpr std::array codes{SQLITE_NOTADB,   SQLITE_CORRUPT, SQLITE_ERROR,
                             SQLITE_MISMATCH, SQLITE_SCHEMA,  SQLITE_CONSTRAINT};
  return std::ranges::find(codes, code & 0xff) != codes.end();
}

/// The path without links, except perhaps its last component: SQLite is opened with the option not
/// to follow links.
std::filesystem::path without_links(const std::filesystem::path& file) {
  std::error_code none;
  const auto folder = std::filesystem::canonical(
      file.has_parent_path() ? file.parent_path() : std::filesystem::path("."), none);
  return none ? std::filesystem::absolute(file) : folder / file.filename();
}

/// URI of a file that no process writes. It is read without locks, which a shared file system may
/// not support.
std::string immutable(const std::filesystem::path& file) {
  std::string uri = "file:";
  for (const char c : file.string())
    uri += c == '%' || c == '?' || c == '#' ? fmt::format("%{:02x}", static_cast<unsigned char>(c))
                                            : std::string(1, c);
  return uri + "?immutable=1&mode=ro";
}

/// Size of a regular file, bytes; nullopt if there is none. Opens nothing: closing any descriptor
/// of a file would release all locks of this process on it, including SQLite's.
std::optional<std::uint64_t> size_of(const std::filesystem::path& file, bool written) {
  if (written) require_own(file);
  struct stat about {};
  if (lstat(file.c_str(), &about) != 0) return std::nullopt;
  if (!S_ISREG(about.st_mode))
    throw SceneError(fmt::format("{}: is {}; results are read from a file", file.string(),
                                 S_ISLNK(about.st_mode) ? "a symbolic link" : "no file"));
  const auto bytes = static_cast<std::uint64_t>(about.st_size);
  if (bytes > most_of_a_database)
    throw SceneError(fmt::format("{}: exceeds {} GiB, the limit for a database of results", file.string(),
                                 most_of_a_database >> 30));
  return bytes;
}

/// Refuses a rollback journal that ends with this mark: it names another file, which SQLite would delete
/// after the rollback (sqlite.org/fileformat2.html, section 3). This program creates no such journal.
void require_no_other_name(const std::filesystem::path& journal) {
  constexpr std::string_view mark("\xd9\xd5\x05\xf9\x20\xa1\x63\xd7");
  const auto from = open_regular(journal, most_of_a_database, Links::refused);
  std::array<char, mark.size()> end{};
  if (from.bytes < end.size() ||
      pread(from.descriptor.number(), end.data(), end.size(), static_cast<off_t>(from.bytes - end.size())) !=
          static_cast<ssize_t>(end.size()) ||
      std::string_view(end.data(), end.size()) != mark)
    return;
  throw SceneError(fmt::format(
      "{}: is a journal with a reference to another file, which SQLite would delete; freeplay never writes "
      "one: remove it",
      journal.string()));
}

}  // namespace

void Database::fail(int code) const {
  if ((code & 0xff) == SQLITE_INTERRUPT)
    refuse(fmt::format(
        "a query takes more than {:.0f} s, the limit for its size; it is damaged, or the disk is too slow",
        allowed_seconds(file_)));
  if ((code & 0xff) == SQLITE_AUTH) refuse("it has parts that freeplay does not access");
  auto why = reason(code);
  if ((code & 0xff) == SQLITE_CANTOPEN && std::filesystem::absolute(file_).string().size() > longest_path)
    why =
        fmt::format("its path has more than {} bytes, the limit of SQLite; use a shorter one", longest_path);
  if (const int error = db_ ? sqlite3_system_errno(db_) : 0; (code & 0xff) == SQLITE_IOERR && error != 0)
    why = fmt::format("disk error: {}", std::strerror(error));
  const auto what = fmt::format("{}: cannot be read or written: {}", file_.string(), why);
  if (is_damage(code) && (access_ == Access::read || access_ == Access::sealed)) throw DamagedDatabase(what);
  throw OutputError(what);
}

void Database::fail() const { fail(sqlite3_errcode(db_)); }

void Database::refuse(const std::string& why) const {
  const auto what = fmt::format("{}: cannot be used: {}", file_.string(), why);
  if (access_ == Access::read || access_ == Access::sealed) throw SceneError(what);
  throw OutputError(what + ", or give another folder with -o");
}

int Database::wait(void* self, int tries) {
  if (static_cast<Database*>(self)->stop_() || tries * between_tries > patience) return 0;
  std::this_thread::sleep_for(between_tries);
  return 1;
}

int Database::is_late(void* self) {
  const auto& own = *static_cast<const Database*>(self);
  const double spent = seconds_now() - own.began_;
  return spent > least_seconds && spent > allowed_seconds(own.file_);
}

int Database::allowed(void* self, int what, const char* first, const char* second, const char* schema,
                      const char*) {
  const std::string_view in = schema ? schema : "", named = first ? first : "";
  switch (what) {
    case SQLITE_SELECT:
    case SQLITE_READ:
    case SQLITE_RECURSIVE:
    case SQLITE_TRANSACTION:
    case SQLITE_CREATE_TEMP_TABLE:
    case SQLITE_CREATE_TEMP_INDEX:
      return SQLITE_OK;
    case SQLITE_FUNCTION:
      return second && std::string_view(second) == "load_extension" ? SQLITE_DENY : SQLITE_OK;
    case SQLITE_PRAGMA:
      return named == "user_version" || named == "table_info" ? SQLITE_OK : SQLITE_DENY;
    case SQLITE_INSERT:
    case SQLITE_UPDATE:
    case SQLITE_DELETE:
      if (in == "temp") return SQLITE_OK;
      [[fallthrough]];
    case SQLITE_CREATE_TABLE:
    case SQLITE_CREATE_INDEX:
    case SQLITE_CREATE_VIEW:
    case SQLITE_DROP_TABLE:
    case SQLITE_DROP_INDEX:
    case SQLITE_DROP_VIEW:
    case SQLITE_REINDEX: {  // used by CREATE INDEX
      const auto access = static_cast<const Database*>(self)->access_;
      return access == Access::write || access == Access::build ? SQLITE_OK : SQLITE_DENY;
    }
    default:  // triggers, virtual tables, ATTACH, ALTER, …
      return SQLITE_DENY;
  }
}

Database::Database(const std::filesystem::path& file, Access access, StopToken stop)
    : file_(file), access_(access), stop_(stop) {
  const bool written = access == Access::write || access == Access::build;
  const auto own = size_of(file, written);
  if (!own && !written) throw SceneError(file.string() + ": no such file");
  std::uint64_t beside = 0;
  bool had_shm = false;
  if (access != Access::sealed)
    for (const char* part : {"-wal", "-journal", "-shm"}) {
      const auto bytes = size_of(file.string() + part, written);
      had_shm = bytes && std::string_view(part) == "-shm";
      if (!had_shm) beside += bytes.value_or(0);
    }
  if (beside > 0)
    if (const std::filesystem::path journal = file.string() + "-journal"; std::filesystem::exists(journal))
      require_no_other_name(journal);
  try {
    const auto place = without_links(file);
    if (written)
      open(place.string(), SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE);
    else if (access == Access::sealed || beside == 0)
      open(immutable(place), SQLITE_OPEN_READONLY | SQLITE_OPEN_URI);
    else
      open(place.string(), SQLITE_OPEN_READONLY);
    configure();
    if (own.value_or(0) + beside > 0) {
      // A refused file stays unchanged: no checkpoint of its write-ahead log.
      sqlite3_db_config(db_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, beside > 0 ? 1 : 0, nullptr);
      require_own();
      sqlite3_db_config(db_, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 0, nullptr);
    } else if (!written) {
      fail(SQLITE_NOTADB);  // an empty file
    }
    if (written) prepare_for_writing(own.value_or(0) + beside == 0);
    sqlite3_set_authorizer(db_, allowed, this);
  } catch (...) {
    sqlite3_close(db_);
    if (std::error_code none; access != Access::sealed && beside > 0 && !had_shm)
      std::filesystem::remove(file.string() + "-shm", none);
    throw;
  }
}

void Database::open(const std::string& name, int flags) {
  // The connections of a merge belong to one thread, so no mutex is needed for each value.
  if (access_ == Access::sealed || access_ == Access::build) flags |= SQLITE_OPEN_NOMUTEX;
  if (sqlite3_open_v2(name.c_str(), &db_, flags | SQLITE_OPEN_NOFOLLOW, nullptr) != SQLITE_OK) fail();
}

void Database::configure() {
  sqlite3_busy_handler(db_, wait, this);
  // Valid only after renaming, so a power failure cannot leave a valid incomplete file.
  if (access_ == Access::build)
    for (const char* pragma : {"journal_mode = OFF", "synchronous = OFF", "cache_size = -262144",
                               "temp_store = FILE", "locking_mode = EXCLUSIVE"})
      execute(fmt::format("PRAGMA {}", pragma));
  for (const auto& [what, on] : {std::pair{SQLITE_DBCONFIG_DEFENSIVE, 1},
                                 {SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0},
                                 {SQLITE_DBCONFIG_ENABLE_TRIGGER, 0},
                                 {SQLITE_DBCONFIG_ENABLE_LOAD_EXTENSION, 0},
                                 {SQLITE_DBCONFIG_DQS_DDL, 0},
                                 {SQLITE_DBCONFIG_DQS_DML, 0}})
    sqlite3_db_config(db_, what, on, nullptr);
  sqlite3_limit(db_, SQLITE_LIMIT_ATTACHED, 0);
  sqlite3_progress_handler(db_, steps_between_looks, is_late, this);
  execute("PRAGMA cell_size_check = ON");
}

std::vector<SchemaObject> Database::schema() const {
  // Indexes that SQLite makes for UNIQUE or PRIMARY KEY have no definition.
  using Text = std::string;
  return list<SchemaObject, Text, Text, Text, Text>(
      "SELECT type, name, tbl_name, sql FROM sqlite_master WHERE NOT (type = 'index' AND sql IS NULL "
      "AND name GLOB 'sqlite_autoindex_*') ORDER BY rowid");
}

long Database::kind() const { return number_of("PRAGMA user_version"); }

void Database::require_own() {
  using Texts = std::vector<std::string>;
  if (const long id = number_of("PRAGMA application_id"); id != 0 && id != application_id)
    refuse(fmt::format("it is a file of another program (application id {})", id));
  const auto objects = schema();
  for (const bool views : {false, true})  // a view is composed of the columns of tables
    for (const auto& object : objects)
      if ((object.type == "view") == views && !is_own(*this, object))
        refuse(fmt::format("it defines the {} {}, which freeplay never creates; remove it",
                           visible_brief(object.type, 12), visible_brief(object.name, 60)));
  if (texts("PRAGMA encoding") != Texts{"UTF-8"}) refuse("its texts are not UTF-8; repeat its runs");
  if (texts("PRAGMA quick_check(1)") != Texts{"ok"}) fail(SQLITE_CORRUPT);
  if (Statement row(*this, "PRAGMA foreign_key_check"); row.step())
    refuse(fmt::format("its table {} has rows of runs that it does not have; it is damaged", row.text(0)));
}

void Database::prepare_for_writing(bool is_new) {
  if (is_new) execute(fmt::format("PRAGMA application_id = {}", application_id));
  if (access_ != Access::write) return;
  // In WAL mode, long queries of a user do not block the runs, and a stop at any time loses
  // unstored runs only. SQLite does not wait by itself if another process switches to WAL at the
  // same time.
  for (int tries = 0; sqlite3_exec(db_, "PRAGMA journal_mode = WAL", nullptr, nullptr, nullptr) != SQLITE_OK;)
    if (sqlite3_errcode(db_) != SQLITE_BUSY || !wait(this, tries++)) fail();
  execute("PRAGMA foreign_keys = ON");
  // A commit is passed to the kernel at once and to the disk at checkpoints: a killed program loses
  // no commit, a power failure the last ones.
  execute("PRAGMA synchronous = NORMAL");
}

void Database::copy_to(const std::filesystem::path& file) const {
  std::filesystem::remove(file);
  const Database copy(file, Access::build, stop_);
  sqlite3_backup* const work = sqlite3_backup_init(copy.db_, "main", db_, "main");
  if (!work) copy.fail();
  int code = SQLITE_OK;
  for (int tries = 0; (code = sqlite3_backup_step(work, -1)) == SQLITE_BUSY || code == SQLITE_LOCKED;)
    if (!wait(const_cast<Database*>(this), tries++)) break;
  sqlite3_backup_finish(work);
  if (code != SQLITE_DONE) copy.fail(code);
  // The copied header requests WAL mode, as in the original; reset it.
  sqlite3_set_authorizer(copy.db_, nullptr, nullptr);
  copy.execute("PRAGMA journal_mode = DELETE");
}

Database::~Database() { sqlite3_close(db_); }

Database::Statement::Statement(const Database& owner, const std::string& sql) : owner_(owner) {
  const char* rest = nullptr;
  owner.began_ = seconds_now();
  if (sqlite3_prepare_v2(owner.db_, sql.c_str(), -1, &statement_, &rest) != SQLITE_OK) owner.fail();
  assert(!*rest);  // exactly one statement
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
Database::Statement& Database::Statement::bind_bytes(std::span<const std::byte> x) {
  if (x.empty())
    sqlite3_bind_null(statement_, ++bound_);
  else
    sqlite3_bind_blob64(statement_, ++bound_, x.data(), x.size(), SQLITE_TRANSIENT);
  return *this;
}
Database::Statement& Database::Statement::bind(const Statement& row, int column) {
  sqlite3_bind_value(statement_, ++bound_, sqlite3_column_value(row.statement_, column));
  return *this;
}
bool Database::Statement::step() {
  owner_.began_ = seconds_now() - spent_;
  const int status = sqlite3_step(statement_);
  spent_ = seconds_now() - owner_.began_;
  if (status != SQLITE_ROW && status != SQLITE_DONE) owner_.fail();
  return status == SQLITE_ROW;
}
void Database::Statement::again() {
  step();
  sqlite3_reset(statement_);
  bound_ = 0;
  spent_ = 0;
}
std::string Database::Statement::text(int column) const {
  if (sqlite3_column_bytes(statement_, column) > longest_text)
    owner_.refuse(
        fmt::format("a text of more than {} bytes is in {}; it is damaged", longest_text, name(column)));
  const auto* t = reinterpret_cast<const char*>(sqlite3_column_text(statement_, column));
  return t ? std::string(t, static_cast<std::size_t>(sqlite3_column_bytes(statement_, column))) : "";
}
double Database::Statement::number(int column) const {
  if (absent(column)) return std::nan("");
  require_number(column);
  return sqlite3_column_double(statement_, column);
}
long Database::Statement::whole(int column) const {
  require_number(column);
  return sqlite3_column_int64(statement_, column);
}
/// SQLite stores values of any type in any column.
void Database::Statement::require_number(int column) const {
  const int type = sqlite3_column_type(statement_, column);
  if (type == SQLITE_TEXT || type == SQLITE_BLOB)
    owner_.refuse(fmt::format("a number is wanted in {}; it is damaged", name(column)));
}
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
  if (!absent(column) &&
      (sqlite3_column_type(statement_, column) != SQLITE_BLOB ||
       static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)) % sizeof(T) != 0))
    owner_.refuse(fmt::format("a list of numbers is wanted in {}; it is damaged", name(column)));
  std::vector<T> list(static_cast<std::size_t>(sqlite3_column_bytes(statement_, column)) / sizeof(T));
  if (!list.empty()) std::memcpy(list.data(), blob, list.size() * sizeof(T));
  return list;
}
std::vector<float> Database::Statement::floats(int column) const { return numbers<float>(column); }
std::vector<double> Database::Statement::doubles(int column) const { return numbers<double>(column); }

Database::Transaction::Transaction(const Database& owner) : owner_(owner), alone_(owner.alone()) {
  owner.execute("BEGIN IMMEDIATE");
}
Database::Transaction::~Transaction() {
  insertions_.clear();
  if (open_) sqlite3_exec(owner_.db_, "ROLLBACK", nullptr, nullptr, nullptr);
}
Database::Statement& Database::Transaction::insertion(const std::string& table, std::size_t columns) {
  auto& statement = insertions_[{table, columns}];
  if (!statement)
    statement.emplace(owner_, fmt::format("INSERT OR REPLACE INTO {} VALUES ({})", table,
                                          fmt::join(std::vector(columns, '?'), ", ")));
  return *statement;
}
long Database::Transaction::last_id() const { return sqlite3_last_insert_rowid(owner_.db_); }
void Database::Transaction::commit() {
  owner_.execute("COMMIT");
  open_ = false;
}

}  // namespace freeplay
