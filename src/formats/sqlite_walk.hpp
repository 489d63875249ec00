#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "formats/sqlite_database.hpp"

namespace loopstone {

/// The numbers of the rows of a database's messages, in the order in which these are given: by the
/// index of their times, and what that does not reach by number. Each row comes once. Nothing is
/// kept in memory whatever the number of rows.
class SqliteWalk {
 public:
  /// \param index  of find_time_index()
  /// \param told   called with what is wrong with rows or with the index
  SqliteWalk(SqliteDatabase& database, std::optional<std::string> index,
             std::function<void(const std::string&)> told);

  /// Nothing at the end. Throws ReadingStopped.
  [[nodiscard]] std::optional<std::int64_t> next();
  /// That row could not be read: told with its neighbours.
  void lose(std::int64_t row, const std::string& reason);
  void rewind();

 private:
  enum class Phase {
    kByTime,
    kByRow,    ///< what the index gave already is passed over
    kLeftOut,  ///< what the index lacks
    kEnd
  };

  [[nodiscard]] std::optional<std::int64_t> next_by_time();
  [[nodiscard]] std::optional<std::int64_t> next_by_row();
  void leave_index(const std::string& reason);
  void begin_rows(Phase phase);
  [[nodiscard]] bool index_is_complete();
  [[nodiscard]] bool was_given(std::int64_t time_ns, std::int64_t row);
  [[nodiscard]] bool seek(std::int64_t row);
  [[nodiscard]] bool pass_damage(const std::string& reason);
  void tell_passed(const std::string& reason);
  void tell_lost();

  SqliteDatabase& database_;
  std::optional<std::string> index_;
  std::function<void(const std::string&)> told_;
  Phase phase_ = Phase::kEnd;
  std::unique_ptr<SqliteStatement> by_time_;
  std::unique_ptr<SqliteStatement> by_row_;
  std::unique_ptr<SqliteStatement> in_index_;
  bool is_at_row_ = false;  // by_row_ stands on one that was not yet given
  // The last that the index gave.
  std::optional<std::int64_t> last_time_ns_;
  std::int64_t last_time_row_ = 0;
  std::int64_t walked_ = 0;
  std::int64_t least_row_ = 0;
  std::int64_t greatest_row_ = 0;
  std::optional<std::int64_t> last_row_;  // by row
  std::int64_t left_out_ = 0;
  // Rows that were lost one after the other.
  std::int64_t lost_ = 0;
  std::int64_t first_lost_ = 0;
  std::int64_t last_lost_ = 0;
  std::string lost_reason_;
};

}  // namespace loopstone
