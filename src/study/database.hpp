// One SQLite file: statements, transactions, and failures in the program's own words.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "sim/stop.hpp"

struct sqlite3;
struct sqlite3_stmt;

namespace freeplay {

class Database {
 public:
  /// Opens or makes it; several processes may, at a time. Where another program holds the file it is waited for, a minute at
  /// most, or until `stop`. Throws OutputError.
  explicit Database(const std::filesystem::path& file, StopToken stop = {});
  ~Database();
  Database(const Database&) = delete;
  Database& operator=(const Database&) = delete;

  const std::filesystem::path& file() const { return file_; }
  void execute(const std::string& sql) const;
  long last_id() const;  ///< of the row that was inserted last

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
    bool step();
    void again();
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

  /// SQLite asks it whether to try again, after `tries` of them.
  static int wait(void* self, int tries);

  std::filesystem::path file_;
  StopToken stop_;
  sqlite3* db_ = nullptr;
};

}  // namespace freeplay
