// One SQLite file: statements, transactions, and failures in the program's own words. Every database of the program is opened
// here, and none is trusted, for a result folder or a shard may come from anybody:
//
//     before SQLite    a regular file, no link, of at most most_of_a_database; so SQLite's files beside it; no rollback journal
//                      that names a file elsewhere (SQLite would remove that)
//     by SQLite        defensive, schema not trusted, no triggers, nothing attached, and an authorizer that allows what
//                      freeplay's own statements need; a file that is only read is opened for reading
//     then             UTF-8; each definition one of this program's own (study/store/schema.hpp); pages that hold together
//                      (quick_check, first fault: 3 s for a gigabyte that is in memory)
//     while in use     a statement ends after a time that grows with the file: 120 s, and a second for each megabyte
//
// Nothing is changed before all of this is known, but that SQLite takes back an unfinished transaction whose rollback journal
// lies beside the file.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "mechanism/error.hpp"
#include "study/store/schema.hpp"
#include "values/stop.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace freeplay {

/// A database that is only read, and is damaged.
struct DamagedDatabase : SceneError {
  using SceneError::SceneError;
};

class Database {
 public:
  enum class Access {
    read,    ///< nothing is changed
    sealed,  ///< likewise, of a file that is whole by itself: files beside it are not SQLite's
    write,   ///< opened, or made; several processes may, at a time
    build    ///< a new file of this process' own, which counts when it is whole: without a journal
  };

  /// Where another program holds the file it is waited for, a minute at most, or until `stop`. A file that is not used throws
  /// SceneError where it is only read, OutputError where it would be written.
  Database(const std::filesystem::path& file, Access access, StopToken stop = {});
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  const std::filesystem::path& file() const { return file_; }
  /// One statement.
  void execute(const std::string& sql) const;
  long last_id() const;  ///< of the row that was inserted last
  /// What it is made of, in the order of its making; each has an own_definition().
  std::vector<SchemaObject> schema() const;
  /// Its user_version.
  long kind() const;
  /// A copy of it as of one instant, in one file; pages are copied, nothing is executed. Throws OutputError.
  void copy_to(const std::filesystem::path& file) const;

  /// A prepared statement: bind in order, step through rows.
  class Statement {
   public:
    Statement(const Database& owner, const std::string& sql);
    ~Statement();
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;
    /// NaN becomes NULL: a statistic that a run does not have.
    Statement& bind(double x);
    Statement& bind(long x);
    Statement& bind(const std::string& x);
    /// As a blob: numbers of single precision, the lowest byte first; none is NULL.
    Statement& bind(std::span<const float> x);
    /// The same of double precision, bit for bit.
    Statement& bind(std::span<const double> x);
    /// A value of another statement's row, as it stands there.
    Statement& bind(const Statement& row, int column);
    bool step();
    void again();
    /// Binds all of a row, and again().
    template <class... X>
    void put(const X&... x) {
      (bind(x), ...);
      again();
    }
    std::string text(int column) const;
    double number(int column) const;
    long whole(int column) const;
    int columns() const;
    std::string name(int column) const;
    bool absent(int column) const;  ///< NULL
    bool is_text(int column) const;
    std::vector<float> floats(int column) const;  ///< of a blob; none of NULL
    std::vector<double> doubles(int column) const;

   private:
    Statement& bind_bytes(std::span<const std::byte> x);
    template <class T>
    std::vector<T> numbers(int column) const;

    const Database& owner_;
    sqlite3_stmt* statement_ = nullptr;
    int bound_ = 0;
    double spent_ = 0;  // s in step()
  };

  /// All of it or nothing; what is not committed is undone. It has the right to write from its beginning: what it reads
  /// stays so until it has written.
  class Transaction {
   public:
    explicit Transaction(const Database& owner);
    ~Transaction();
    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;
    void commit();

   private:
    const Database& owner_;
    bool open_ = true;
  };

 private:
  [[noreturn]] void fail() const;
  [[noreturn]] void fail(int code) const;
  [[noreturn]] void refuse(const std::string& why) const;
  void open(const std::string& name, int flags);
  void configure();
  void require_own();
  void prepare_for_writing();

  /// SQLite asks it whether to try again, after `tries` of them.
  static int wait(void* self, int tries);
  /// SQLite asks it now and then whether to end the statement.
  static int is_late(void* self);
  /// Whether a statement may do what it asks for (sqlite3_set_authorizer).
  static int allowed(void* self, int what, const char* first, const char* second, const char* schema,
                     const char*);

  std::filesystem::path file_;
  Access access_;
  StopToken stop_;
  sqlite3* db_ = nullptr;
  mutable double began_ = 0;  // s, of the statement at work
};

}  // namespace freeplay
