#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace loopstone {

/// What SQLite says is wrong.
class SqliteError : public std::runtime_error {
 public:
  SqliteError(int code, const std::string& reason) : std::runtime_error(reason), code_(code) {}
  /// SQLITE_CORRUPT and so on, without its extension.
  [[nodiscard]] int code() const { return code_; }

 private:
  int code_;
};

enum class SqliteAccess {
  kUntouched,  ///< the file alone is read and nothing is made beside it; it must not change
  kRecover,    ///< of a private copy: what its log or its journal holds is put into it
  kCreate,     ///< a new file, without a journal
  kRead,       ///< of a file that somebody may be writing to, through its log
  kWrite,      ///< of such a file, which is made where there is none
};

struct SqliteOptions {
  SqliteAccess access = SqliteAccess::kUntouched;
  /// Read a schema or a file that is not whole as far as it goes.
  bool is_tolerant = false;
  std::uint64_t most_value_bytes = 1'000'000'000;  ///< of a text or a blob
  /// Asked now and then: true ends what is being done with ReadingStopped. May be empty.
  std::function<bool()> stop{};
};

/// A connection that trusts the file in nothing: no triggers, views or extensions of its schema.
class SqliteDatabase {
 public:
  /// Throws SqliteError.
  SqliteDatabase(const std::string& path, const SqliteOptions& options);
  /// Of a copy of these bytes.
  SqliteDatabase(std::string_view bytes, const SqliteOptions& options);
  SqliteDatabase(const SqliteDatabase&) = delete;
  SqliteDatabase& operator=(const SqliteDatabase&) = delete;
  ~SqliteDatabase();

  void run(const std::string& sql);
  [[nodiscard]] sqlite3* handle() const { return handle_; }
  [[nodiscard]] const std::function<bool()>& stop() const { return stop_; }

 private:
  void configure(const SqliteOptions& options);
  [[noreturn]] void fail(int code);

  sqlite3* handle_ = nullptr;
  std::function<bool()> stop_;
};

/// One statement. The database must outlive it.
class SqliteStatement {
 public:
  /// Throws SqliteError.
  SqliteStatement(SqliteDatabase& database, const std::string& sql);
  SqliteStatement(const SqliteStatement&) = delete;
  SqliteStatement& operator=(const SqliteStatement&) = delete;
  ~SqliteStatement();

  /// Parameters are counted from 1. Bytes must stay until the next reset().
  void bind(int parameter, std::int64_t value);
  void bind_real(int parameter, double value);
  void bind_text(int parameter, std::string_view text);
  void bind_blob(int parameter, std::span<const char> bytes);
  /// Whether there is a row. Throws SqliteError, ReadingStopped.
  [[nodiscard]] bool step();
  /// To its beginning; parameters stay.
  void reset() noexcept;

  // Columns of the row, counted from 0; bytes until the next step or reset.
  [[nodiscard]] std::int64_t integer(int column) const;
  [[nodiscard]] double real(int column) const;
  [[nodiscard]] std::string_view text(int column) const;
  [[nodiscard]] std::span<const char> blob(int column) const;
  [[nodiscard]] bool is_null(int column) const;

 private:
  [[noreturn]] void fail(int code);

  SqliteDatabase& database_;
  sqlite3_stmt* handle_ = nullptr;
};

/// As a name in a statement: in quotation marks.
[[nodiscard]] std::string sqlite_name(std::string_view name);

}  // namespace loopstone
