// Access to one SQLite file: statements, transactions, and error messages. Every database of the
// program is opened by this class. A result folder or a shard may be of unknown origin, so no
// database is trusted:
//
//     before opening   a regular file, no link, of at most most_of_a_database; so SQLite's files
//                      beside it; no rollback journal that names another file (SQLite would
//                      delete that)
//     in SQLite        defensive mode, untrusted schema, no triggers, nothing attached, and an
//                      authorizer that permits the actions of freeplay's own statements only; a
//                      file that is only read is opened read-only
//     after opening    the application id; UTF-8; each definition is one of this program
//                      (study/store/schema.hpp); consistent pages (quick_check to the first fault:
//                      3 s for a cached gigabyte); no row of a run that is not there
//     in use           a column has the type that is read, and its texts at most 16 kB; a statement
//                      ends after a time that grows with the file: 120 s, and a second for each
//                      megabyte
//
// The file is not changed before these checks have passed, except that SQLite rolls back an
// unfinished transaction whose journal is beside the file.
//
// A Database owns its connection. Several processes may write the same file. One thread uses it at a
// time: a Transaction excludes other threads, and threads that only read hold alone().
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "mechanism/error.hpp"
#include "study/store/schema.hpp"
#include "values/stop.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace freeplay {

/// A damaged database that was opened for reading.
struct DamagedDatabase : SceneError {
  using SceneError::SceneError;
};

/// One open SQLite file.
class Database {
 public:
  /// Purpose for which a file is opened.
  enum class Access {
    read,    ///< read-only
    sealed,  ///< read-only, and complete without SQLite's files beside it
    write,   ///< opened or created; several processes may write at the same time
    build    ///< a new file of this process, valid only when complete; without a journal
  };

  /// Opens the file. Waits while another program locks it, for at most a minute or until `stop`.
  /// For an unusable file, throws SceneError if it is only read, and OutputError otherwise.
  Database(const std::filesystem::path& file, Access access, StopToken stop = {});
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  const std::filesystem::path& file() const { return file_; }
  /// Excludes other threads that call it, and their transactions. A thread holds one of both.
  std::unique_lock<std::mutex> alone() const { return std::unique_lock(mutex_); }
  /// Executes one statement with these values.
  template <class... X>
  void execute(const std::string& sql, const X&... values) const {
    Statement(*this, sql, values...).step();
  }
  /// T{…} of the first columns, in these types, for each row of a query with these values.
  template <class T, class... Column, class... X>
  std::vector<T> list(const std::string& sql, const X&... values) const {
    Statement s(*this, sql, values...);
    std::vector<T> rows;
    while (s.step()) {
      int column = 0;
      rows.push_back(T{s.value<Column>(column++)...});
    }
    return rows;
  }
  /// The first column.
  std::vector<std::string> texts(const std::string& sql, const auto&... values) const {
    return list<std::string, std::string>(sql, values...);
  }
  /// The number that is the answer to a query.
  long number_of(const std::string& sql) const { return list<long, long>(sql).at(0); }
  /// Its tables, indexes and views, in the order of their creation. Each is_own().
  std::vector<SchemaObject> schema() const;
  /// SQLite's user_version, which states the kind of database.
  long kind() const;
  /// Copies the database, as of one instant, into one file. Copies pages and executes nothing.
  /// Throws OutputError.
  void copy_to(const std::filesystem::path& file) const;
  /// Throws SceneError or OutputError, as Database() does: the file cannot be used.
  [[noreturn]] void refuse(const std::string& why) const;

  /// A column of its own for each of these numbers.
  struct Columns {
    std::span<const double> numbers;
  };

  /// A prepared statement: bind values in order, then step through the rows.
  class Statement {
   public:
    Statement(const Database& owner, const std::string& sql);
    template <class... X>
    Statement(const Database& owner, const std::string& sql, const X&... values) : Statement(owner, sql) {
      (bind(values), ...);
    }
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;
    /// NaN is stored as NULL, for a statistic that a run does not have.
    Statement& bind(double x);
    Statement& bind(long x);
    Statement& bind(const std::string& x);
    /// Binds a blob of single-precision numbers, little-endian. An empty list is stored as NULL.
    Statement& bind(std::span<const float> x) { return bind_bytes(std::as_bytes(x)); }
    /// Likewise with double precision, bit for bit.
    Statement& bind(std::span<const double> x) { return bind_bytes(std::as_bytes(x)); }
    Statement& bind(Columns x) {
      for (const double number : x.numbers) bind(number);
      return *this;
    }
    /// Binds a value of another statement's current row unchanged.
    Statement& bind(const Statement& row, int column);
    bool step();
    void again();
    /// Binds all values of a row, executes, and resets.
    template <class... X>
    void put(const X&... x) {
      (bind(x), ...);
      again();
    }
    std::string text(int column) const;
    double number(int column) const;
    long whole(int column) const;
    /// One of these three, by type.
    template <class T>
    T value(int column) const {
      if constexpr (std::is_same_v<T, std::string>)
        return text(column);
      else if constexpr (std::is_integral_v<T>)
        return static_cast<T>(whole(column));
      else
        return number(column);
    }
    int columns() const;
    std::string name(int column) const;
    bool absent(int column) const;  ///< whether it is NULL
    bool is_text(int column) const;
    std::vector<float> floats(int column) const;  ///< numbers of a blob; empty for NULL
    std::vector<double> doubles(int column) const;

   private:
    void require_number(int column) const;
    Statement& bind_bytes(std::span<const std::byte> x);
    template <class T>
    std::vector<T> numbers(int column) const;

    const Database& owner_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
    double spent_ = 0;  // s, spent in step()
  };

  /// A transaction: without commit() everything is undone. It holds the write lock from its
  /// beginning, so what it reads cannot change before it writes.
  class Transaction {
   public:
    explicit Transaction(const Database& owner);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    /// Inserts a row into a table, in place of a row with the same key, and returns its integer. Each
    /// statement is prepared once.
    template <class... X>
    long insert(const std::string& table, const X&... values) {
      insertion(table, (... + width(values))).put(values...);
      return last_id();
    }
    void commit();

   private:
    static std::size_t width(const Columns& x) { return x.numbers.size(); }
    static std::size_t width(const auto&) { return 1; }
    Statement& insertion(const std::string& table, std::size_t columns);
    long last_id() const;

    const Database& owner_;
    std::unique_lock<std::mutex> alone_;
    bool open_ = true;
    std::map<std::pair<std::string, std::size_t>, std::optional<Statement>> insertions_;
  };

 private:
  [[noreturn]] void fail() const;
  [[noreturn]] void fail(int code) const;
  void open(const std::string& name, int flags);
  void configure();
  void require_own();
  /// Before the authorizer, which denies the table-valued pragmas of require_own() to readers, too.
  void prepare_for_writing(bool is_new);

  /// SQLite's busy handler: whether to try again after this many `tries`.
  static int wait(void* self, int tries);
  /// SQLite's progress handler: whether to interrupt the present statement.
  static int is_late(void* self);
  /// SQLite's authorizer: whether a statement may perform an action (sqlite3_set_authorizer).
  static int allowed(void* self, int what, const char* first, const char* second, const char* schema,
                     const char*);

  std::filesystem::path file_;
  Access access_;
  StopToken stop_;
  sqlite3* db_ = nullptr;
  mutable double began_ = 0;  // s, start of the present statement
  mutable std::mutex mutex_;
};

}  // namespace freeplay
